"""Values of options: of the form NAME=VALUE, which may be repeated, and those that are the fields of a class."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import MISSING, fields
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np
import typer

from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.base.text import quoted
from holdfast.scene.formats.links import pose_of

if TYPE_CHECKING:
    from holdfast.applications.placement.conditions import Weights

POSE = "BODY=X,Y,Z or BODY=X,Y,Z,ROLL,PITCH,YAW"
FLAT = "X0,Y0,X1,Y1 or X0,Y0,Z0,X1,Y1,Z1"
SOLID = "X0,Y0,Z0,X1,Y1,Z1"
NONE = "none"
UNITS = {"s": "seconds", "deg": "degrees"}
ITEM = re.compile(r"^- ``(\w+)``(?: \[(.+?)\])?: (.+?)(?=^- ``|^\S|\Z)", re.MULTILINE | re.DOTALL)


def option(text: str, *flags: str, metavar: str | None = None, panel: str | None = None) -> Any:  # noqa: ANN401
    """Return an option with this help; its flag is the name of the parameter, unless ``flags`` are given."""
    return typer.Option(*flags, help=text, metavar=metavar, rich_help_panel=panel)


def wrong(option: str, text: str, form: str) -> HoldfastError:
    """Return the error for an option whose text does not have the ``form``."""
    return HoldfastError(message(option, f"is {quoted(text)}", f"needs {form}"))


def assigned(option: str, texts: Sequence[str], form: str, *, last: bool = True) -> dict[str, str]:
    """Return the values of texts NAME=VALUE by name, split at the last ``=``, as names may hold any character.

    With ``last=False`` they are split at the first ``=``, as values may hold any character. Raises HoldfastError for a
    text of another form, and for a name that occurs twice.
    """
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.rpartition("=") if last else text.partition("=")
        if not equals or not name or not value:
            raise wrong(option, text, form)
        if name in values:
            raise HoldfastError(message(option, f"is given twice for {quoted(name)}", "give it once"))
        values[name] = value
    return values


def numbers(option: str, text: str, form: str) -> list[float]:
    """Return numbers that are separated by commas; raise HoldfastError, with the ``form``, for anything else."""
    try:
        return [float(word) for word in text.split(",")]
    except ValueError:
        raise wrong(option, text, form) from None


def number(option: str, text: str, form: str) -> float:
    """Return one number; raise HoldfastError, with the ``form``, for anything else."""
    given = numbers(option, text, form)
    if len(given) != 1:
        raise wrong(option, text, form)
    return given[0]


def poses(texts: Sequence[str]) -> dict[str, Float]:
    """Return the poses (4, 4) of bodies by name, from positions [m] and optionally angles in degrees.

    The angles are about the fixed axes x, y and z, in this order, as in URDF.
    """
    by_name = {}
    for name, value in assigned("--pose", texts, POSE).items():
        given = numbers("--pose", value, POSE)
        if len(given) not in (3, 6) or not np.isfinite(given).all():
            raise wrong("--pose", f"{name}={value}", POSE)
        by_name[name] = pose_of(given[:3], np.deg2rad([*given[3:], 0.0, 0.0, 0.0][:3]).tolist())
    return by_name


def turns(texts: Sequence[str]) -> list[str]:
    """Return a remark with the angles in degrees for each pose that has angles."""
    remarks = []
    for name, value in assigned("--pose", texts, POSE).items():
        angles = numbers("--pose", value, POSE)[3:]
        if any(angles):
            remarks.append(f"{name} by {', '.join(f'{angle:g}°' for angle in angles)} about x, y and z")
    return remarks


def of_all_and_each(option: str, texts: Sequence[str], form: str) -> tuple[float | None, dict[str, float]]:
    """Split texts into a number for all (None if there is none) and numbers by name."""
    alone = [text for text in texts if "=" not in text]
    if len(alone) > 1:
        raise HoldfastError(message(option, f"is given {len(alone)} times for all", "give it once"))
    each = assigned(option, [text for text in texts if "=" in text], form)
    of_all = number(option, alone[0], form) if alone else None
    return of_all, {name: number(option, value, form) for name, value in each.items()}


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
    corners = numbers(option, text, form)
    if len(corners) not in lengths:
        raise wrong(option, text, form)
    half = len(corners) // 2
    return [corners[:half], corners[half:]]


def _weights(option: str, text: str) -> Weights:
    from holdfast.applications.placement.conditions import Weights

    form = "ROBUSTNESS,LEVEL,STEADINESS"
    weights = numbers(option, text, form)
    if len(weights) != len(fields(Weights)):
        raise wrong(option, text, form)
    return Weights(*weights)


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
    texts = {}
    for name, unit, text in ITEM.findall(inspect.getdoc(kind) or ""):
        first = re.split(r"(?<=[^.])\.(?=\s|$)", " ".join(text.split()).replace("``", ""))[0]
        texts[name] = f"{first}; in {UNITS.get(unit, unit)}" if unit else first
    return texts


def options_of(kind: type) -> Iterator[inspect.Parameter]:
    """Yield the options of a command, one for each field of a class."""
    said = help_texts(kind)
    for field in fields(kind):
        form, default = FORMS.get(field.name), None if field.default is MISSING else field.default
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
    values = {}
    for field in fields(kind):
        value, form = given.pop(field.name), FORMS.get(field.name)
        if value is None or (form is not None and value == []):
            continue
        values[field.name] = value if form is None else form.read("--" + field.name.replace("_", "-"), value)
    return kind(**values)
