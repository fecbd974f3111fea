"""Say in one line what is wrong with a scene file, from the errors of its schema."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from holdfast.base.errors import message
from holdfast.base.text import LONGEST_NAME, one_line, quoted

ALIKE = 0.65  # least similarity (at most 1) of an unknown key to the one that is suggested
# Keys that users and other formats use for what has another key in a scene file
OTHER_NAMES = {
    "quaternion": "orientation",
    "rpy": "rpy_degrees",
    "euler": "rpy_degrees",
    "rotation": "orientation",
    "translation": "position",
    "origin": "position",
    "transform": "pose",
    "weight": "mass",
    "center_of_mass": "com",
    "centre_of_mass": "com",
    "static": "fixed",
    "dimensions": "size",
    "extents": "size",
    "length": "height",
    "height": "length",
    "path": "file",
    "filename": "file",
    "coefficient": "mu",
    "friction": "mu",
    "geometry": "shape",
    "objects": "bodies",
    "triangles": "faces",
    "points": "vertices",
}
# What to write for a missing key that new users do not know
EXAMPLES = {
    "friction": "write `friction: 0.5` for all pairs, or `friction: {pairs: [{between: [cup, table], mu: 0.4}]}`",
}


def first_fault(
    error: ValidationError,
    schema: type[BaseModel],
    data: Any,  # noqa: ANN401 - plain data
    path: Path,
    kind: str = "",
) -> str:
    """Describe the most helpful of the errors in one line, with the name of the body as well as its number.

    ``kind`` is the argument of ``holdfast schema`` that prints the schema.

    An unknown key comes first, because it is probably a misspelling of a missing one.
    """
    faults = error.errors(include_url=False, include_context=False)
    first = next((fault for fault in faults if fault["type"] == "extra_forbidden"), faults[0])
    models, dotted = _walk(schema, first["loc"], unknown=first["type"] == "extra_forbidden")
    where = f"{path}: {dotted or 'scene'}{_of_body(first['loc'], data)}"
    prints = f"`holdfast schema{' ' + kind if kind else ''}` prints"
    more = f" (and {len(faults) - 1:,} more)" if len(faults) > 1 else ""
    if first["type"] == "extra_forbidden":
        hint = _hint(str(first["loc"][-1]), [key for model in models for key in model.model_fields])
        return message(where, f"unknown key{more}", f"{hint}{prints} the keys there are")
    problem, hint = _problem(first, [tag for model in models for tag in _tags(model)])
    return message(where, f"{problem}{more}", f"{hint}{prints} the format")


def _problem(fault: ErrorDetails, tags: list[str]) -> tuple[str, str]:
    """Return what is wrong, with the value, and a hint, which may be empty; ``tags`` are the known types."""
    value = fault["input"]
    if fault["type"] in ("union_tag_invalid", "union_tag_not_found"):
        known = ", ".join(map(repr, tags))
        if not isinstance(value, dict) or "type" not in value:
            return f"has no type, needs one of {known}", ""
        return f"type is {quoted(value['type'])}, needs one of {known}", _hint(str(value["type"]), tags)
    if fault["type"] == "missing":
        key = str(fault["loc"][-1])
        return "is not given", f"{EXAMPLES[key]}; " if key in EXAMPLES else ""
    said = fault["msg"].removeprefix("Value error, ")
    if fault["type"] in ("model_type", "model_attributes_type"):
        said = "needs keys and values"
    return said if isinstance(value, dict | list) else f"{said}, got {quoted(value)}", ""


def _hint(name: str, known: list[str]) -> str:
    if name.lower() == "diameter" and "radius" in known:
        return "write half of it as 'radius'; "
    other = OTHER_NAMES.get(name.lower())
    near = [other] if other in known else difflib.get_close_matches(name.lower(), known, n=1, cutoff=ALIKE)
    return f"did you mean {near[0]!r}? " if near else ""


def _walk(schema: type[BaseModel], place: tuple[int | str, ...], *, unknown: bool) -> tuple[list[type[BaseModel]], str]:
    """Return the models that are possible at the place of an error, and the place as ``bodies[1].shape.size``.

    Pydantic includes in the place which of several types it tried; these are left out. An ``unknown`` last key stays.
    """
    models: list[type[BaseModel]] = [schema]
    parts, inside = [""], False  # whether inside a map with free keys
    for number, key in enumerate(place, 1):
        fields = {name: field.annotation for model in models for name, field in model.model_fields.items()}
        if isinstance(key, int):
            parts[-1] += f"[{key}]"
        elif key in fields and not inside:
            parts.append(key)
            inside = get_origin(fields[key]) is dict
            models = list(_models_in(fields[key])) or models
        elif any(key in _tags(model) for model in models):
            models = [model for model in models if key in _tags(model)]
        elif inside or (unknown and number == len(place)):
            parts.append(one_line(key, LONGEST_NAME))
    return models, ".".join(filter(None, parts))


def _tags(model: type[BaseModel]) -> tuple[str, ...]:
    """Return the values of ``type`` that select a model; the friction model is selected by being a table."""
    kind = model.model_fields.get("type")
    return get_args(kind.annotation) if kind is not None else ("table",)


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:  # noqa: ANN401 - any type
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models_in(part)


def _of_body(place: tuple[int | str, ...], data: Any) -> str:  # noqa: ANN401
    match place:
        case ("bodies", int(index), *_) if isinstance(data, dict):
            body = data["bodies"][index]
            if isinstance(body, dict) and "name" in body:
                return f" (body {quoted(body['name'])})"
    return ""
