"""Entries of scene files that several formats share, and what is wrong with one, said in one line.

Numbers are taken without conversions, and no key may be unknown.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails

from holdfast.base.archive import to_dict
from holdfast.base.errors import SceneError, message
from holdfast.base.text import LONGEST_NAME, one_line, quoted
from holdfast.scene.friction import Combine, Friction
from holdfast.scene.hold import AnyHold, Grip, Hold

M = TypeVar("M", bound=BaseModel)

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


def validated(schema: type[M], data: Any, path: Path, kind: str = "") -> M:  # noqa: ANN401 - plain data
    """Return the model of the data in the file at ``path``; raise SceneError, with the first fault, if they do not fit.

    ``kind`` is the argument of ``holdfast schema`` that prints the schema.
    """
    try:
        return schema.model_validate(data)
    except ValidationError as cause:
        raise SceneError(_first_fault(cause, schema, data, path, kind)) from None


def _first_fault(error: ValidationError, schema: type[BaseModel], data: Any, path: Path, kind: str) -> str:  # noqa: ANN401
    """Describe the most helpful of the errors in one line, with the name of the body as well as its number.

    An unknown key comes first, because it is probably a misspelling of a missing one.
    """
    faults = error.errors(include_url=False, include_context=False)
    first = next((fault for fault in faults if fault["type"] == "extra_forbidden"), faults[0])
    models, dotted = _walk(schema, first["loc"], unknown=first["type"] == "extra_forbidden")
    where = f"{path}: {dotted or 'scene'}"
    match first["loc"]:
        case ("bodies", int(index), *_) if isinstance(data, dict):
            body = data["bodies"][index]
            where += f" (body {quoted(body['name'])})" if isinstance(body, dict) and "name" in body else ""
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


def _no_other_type(value: Any) -> Any:  # noqa: ANN401
    """Refuse texts and truth values, which pydantic would convert to numbers."""
    if isinstance(value, bool | str | bytes):
        raise ValueError("needs a number")
    return value


def _truth_value(value: Any) -> Any:  # noqa: ANN401
    """Refuse 0 and 1, "yes" and "no", which pydantic would convert to truth values."""
    if not isinstance(value, bool):
        raise ValueError("needs true or false")
    return value


Number = Annotated[float, BeforeValidator(_no_other_type)]
Whole = Annotated[int, BeforeValidator(_no_other_type)]
Truth = Annotated[bool, BeforeValidator(_truth_value)]
Triple = tuple[Number, Number, Number]
Quadruple = tuple[Number, Number, Number, Number]
Matrix3 = tuple[Triple, Triple, Triple]
Matrix4 = tuple[Quadruple, Quadruple, Quadruple, Quadruple]


MOST_KEYS = 100  # largest number of keys of one map, because pydantic collects the errors of all of them


class EntryModel(BaseModel):
    """Base class of the models of a scene file, without unknown keys and infinite numbers."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _few_keys(cls, data: Any) -> Any:  # noqa: ANN401
        if isinstance(data, dict) and len(data) > MOST_KEYS:
            unknown = next(key for key in data if key not in cls.model_fields)
            raise ValueError(f"has {len(data):,} keys; {quoted(unknown)} and others are unknown")
        return data


def _numbers(value: Any) -> Any:  # noqa: ANN401
    """Refuse a map of numbers with a value that is not a number, and name the first one."""
    wrong = [key for key, item in value.items() if isinstance(item, bool | str)] if isinstance(value, dict) else []
    if wrong:
        raise ValueError(f"needs a number for {quoted(wrong[0])}, got {quoted(value[wrong[0]])}")
    return value


class PairModel(EntryModel):
    """What holds between two bodies or materials: friction, and what joins their faces."""

    between: tuple[str, str]
    mu: Number | None = None
    tension: Number | None = Field(None, description="strength against being pulled apart [Pa]")
    cohesion: Number | None = Field(None, description="strength against sliding without pressure [Pa]")

    @model_validator(mode="after")
    def _says_something(self) -> PairModel:
        if (self.mu, self.tension, self.cohesion) == (None, None, None):
            raise ValueError("needs mu, tension or cohesion")
        return self


class FrictionModel(EntryModel):
    """Static Coulomb friction, and what joins faces."""

    default: Number | None = None
    pairs: list[PairModel] = Field([], fail_fast=True)
    values: Annotated[dict[str, Number], BeforeValidator(_numbers)] = Field(
        {}, description="one coefficient a body, for imported scenes; needs combine"
    )
    combine: Combine | None = Field(None, description="how two values make a pair's")


def friction_of(model: float | FrictionModel) -> Friction:
    """Return the friction table of a scene file."""
    if not isinstance(model, FrictionModel):
        return Friction(default=model)
    seen: set[tuple[str, str]] = set()
    for pair in model.pairs:
        if {pair.between, pair.between[::-1]} & seen:
            raise SceneError(message("friction", f"pair {quoted(pair.between)} stands twice", "give each pair once"))
        seen.add(pair.between)
    given = [(each.between, each) for each in model.pairs]
    return Friction(
        model.default,
        {between: each.mu for between, each in given if each.mu is not None},
        model.values,
        model.combine,
        {between: each.tension for between, each in given if each.tension is not None},
        {between: each.cohesion for between, each in given if each.cohesion is not None},
    )


def friction_data(friction: Friction) -> dict[str, Any]:
    """Return a friction table as a scene file holds it."""
    table: dict[str, Any] = {"default": friction.default}
    tables = {"mu": friction.pairs, "tension": friction.tension, "cohesion": friction.cohesion}
    table["pairs"] = [
        {"between": list(pair)} | {name: given[pair] for name, given in tables.items() if pair in given}
        for pair in dict.fromkeys(pair for given in tables.values() for pair in given)
    ]
    table["values"] = dict(friction.values)
    table["combine"] = friction.combine
    return {key: value for key, value in table.items() if value not in (None, [], {})}


# takes .inf of YAML as the text that JSON has for it
ENDLESS = BeforeValidator(lambda value: str(value) if isinstance(value, float) and math.isinf(value) else value)
End = Annotated[Number | Literal["inf", "-inf"], ENDLESS, Field(description="a number, or inf or -inf as a text")]
Endless = Annotated[Number | Literal["inf"], ENDLESS, Field(description="a number, or inf as a text")]
AxisModel = Endless | tuple[End, End]
BoundsModel = Endless | tuple[AxisModel, AxisModel, AxisModel]


class HoldModel(EntryModel):
    """A hand or gripper that exerts any force and moment within bounds; see holdfast.Hold."""

    type: Literal["hold"]
    body: str
    frame: Matrix4 = Field(description="4x4 frame to world, rows")
    forces: BoundsModel = Field(0.0, description="[N]: the radius of a ball, or an entry for each axis of the frame")
    moments: BoundsModel = Field(0.0, description="[N m], likewise")
    on: str | None = Field(None, description="the body that holds; a hand that is fixed in the world if left out")


class GripModel(EntryModel):
    """Fingers or pads that press on a body; see holdfast.Grip."""

    type: Literal["grip"]
    body: str
    points: list[Triple] = Field(fail_fast=True, description="[m], world frame")
    normals: list[Triple] = Field(fail_fast=True, description="into the body, world frame")
    mu: Number
    force: Endless | list[Endless] = Field("inf", description="largest normal force [N], one or one a point")
    pull: Number = Field(0.0, description="[N]: draws the body against all points together")


class SuctionModel(EntryModel):
    """A suction cup, which becomes a grip along its seal; see holdfast.Grip.suction."""

    type: Literal["suction"]
    body: str
    frame: Matrix4 = Field(description="4x4 frame to world, rows; z is the outward normal of the face")
    force: Number = Field(description="[N]: pressure times area, over the safety factor")
    radius: Number = Field(description="[m], of the seal")
    mu: Number


AnyHoldModel = Annotated[HoldModel | GripModel | SuctionModel, Field(discriminator="type")]


def hold_of(model: HoldModel | GripModel | SuctionModel) -> AnyHold:
    """Return the hold that an entry of a scene file describes."""
    if isinstance(model, HoldModel):
        bounds = _numbers_of(model.forces), _numbers_of(model.moments)
        return Hold(model.body, np.array(model.frame), *bounds, model.on)
    if isinstance(model, SuctionModel):
        return Grip.suction(model.body, np.array(model.frame), model.force, model.radius, model.mu)
    force = _numbers_of(model.force)
    return Grip(model.body, np.array(model.points), np.array(model.normals), model.mu, force, model.pull)


def _numbers_of(item: Any) -> Any:  # noqa: ANN401 - numbers, inf as a text, and lists of them
    return [_numbers_of(part) for part in item] if isinstance(item, list | tuple) else float(item)


def hold_data(hold: AnyHold) -> dict[str, Any]:
    """Return a hold as a scene file has it."""
    if isinstance(hold, Hold):
        bounds = {"forces": to_dict(hold.forces), "moments": to_dict(hold.moments)}
        on = {} if hold.on is None else {"on": hold.on}
        return {"type": "hold", "body": hold.body, "frame": hold.frame.tolist()} | bounds | on
    data: dict[str, Any] = {"type": "grip", "body": hold.body, "points": hold.points.tolist()}
    data |= {"normals": hold.normals.tolist(), "mu": hold.mu, "force": to_dict(hold.force)}
    return data | ({"pull": hold.pull} if hold.pull else {})
