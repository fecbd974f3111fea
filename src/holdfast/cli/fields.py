"""Command-line options for the fields of classes such as ``Where``, with help texts from their docstrings."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator
from dataclasses import MISSING, Field, fields
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from holdfast.base.errors import HoldfastError, message
from holdfast.base.text import quoted
from holdfast.cli.assignments import numbers

if TYPE_CHECKING:
    from holdfast.applications.placement.conditions import Weights

FLAT = "X0,Y0,X1,Y1 or X0,Y0,Z0,X1,Y1,Z1"
SOLID = "X0,Y0,Z0,X1,Y1,Z1"
NONE = "none"
UNITS = {"s": "seconds", "deg": "degrees"}
ITEM = re.compile(r"^- ``(\w+)``(?: \[(.+?)\])?: (.+?)(?=^- ``|^\S|\Z)", re.MULTILINE | re.DOTALL)


class Orientation(StrEnum):
    """The values of ``Approach.orientations`` that a command line can give."""

    UPRIGHT = "upright"
    ANY = "any"


class Form(NamedTuple):
    """The form of a field on the command line: the type and the metavar of its option, and a function to read it."""

    kind: Any
    metavar: str | None = None
    read: Callable[[str, Any], Any] = lambda option, given: given


def _corners(option: str, text: str) -> list[list[float]]:
    lengths, form = ((6,), SOLID) if option == "--gripper" else ((4, 6), FLAT)
    found = numbers(option, text, form)
    if len(found) not in lengths:
        raise HoldfastError(message(option, f"is {quoted(text)}", f"needs {form}"))
    half = len(found) // 2
    return [found[:half], found[half:]]


def _weights(option: str, text: str) -> Weights:
    from holdfast.applications.placement.conditions import Weights  # here, for commands that place nothing

    form = "ROBUSTNESS,LEVEL,STEADINESS"
    found = numbers(option, text, form)
    if len(found) != len(fields(Weights)):
        raise HoldfastError(message(option, f"is {quoted(text)}", f"needs {form}"))
    return Weights(*found)


FORMS: dict[str, Form] = {
    "box": Form(str, FLAT, _corners),
    "keep_out": Form(list[str], FLAT, lambda option, texts: [_corners(option, text) for text in texts]),
    "gripper": Form(str, SOLID, _corners),
    "supports": Form(list[str], "BODY"),
    "avoid": Form(list[str], "BODY"),
    "next_to": Form(str, "BODY"),
    "orientations": Form(Orientation, None, lambda _, given: given.value),
    "direction": Form(tuple[float, float, float], "X Y Z"),
    "weights": Form(str, "ROBUSTNESS,LEVEL,STEADINESS", _weights),
    "confirm": Form(str, "ENGINE", lambda _, given: None if given == NONE else given),
    "apart": Form(float),
    "seconds": Form(float),
    "solves": Form(int),
}


def help_texts(kind: type) -> dict[str, str]:
    """Return the help text of each field: the first sentence on it in the docstring of its class, with its unit."""
    found = {}
    for name, unit, text in ITEM.findall(inspect.getdoc(kind) or ""):
        first = re.split(r"(?<=[^.])\.(?=\s|$)", " ".join(text.split()).replace("``", ""))[0]
        found[name] = f"{first}; in {UNITS.get(unit, unit)}" if unit else first
    return found


def options_of(kind: type) -> Iterator[inspect.Parameter]:
    """Yield the options of a command, one for each field of a class."""
    said = help_texts(kind)
    for field in fields(kind):
        form, default = FORMS.get(field.name), _default(field)
        several = form is not None and form.kind == list[str]
        text = f"{said[field.name]} (may be repeated)" if several else said[field.name]
        option = typer.Option(help=text, metavar=None if form is None else form.metavar, rich_help_panel=kind.__name__)
        shown = type(default) if form is None else form.kind | None
        yield inspect.Parameter(
            field.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=default if form is None else None,
            annotation=Annotated[shown, option],
        )


def value_of(kind: type, given: dict[str, Any]) -> Any:  # noqa: ANN401 - a value of this kind
    """Remove the options of a class from the arguments of a command, and return the value that they make."""
    found = {}
    for field in fields(kind):
        value, form = given.pop(field.name), FORMS.get(field.name)
        if value is None or (form is not None and value == []):
            continue
        found[field.name] = value if form is None else form.read("--" + field.name.replace("_", "-"), value)
    return kind(**found)


def _default(field: Field[Any]) -> Any:  # noqa: ANN401
    return None if field.default is MISSING else field.default
