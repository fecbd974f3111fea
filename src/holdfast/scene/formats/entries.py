"""Entries of scene files that several formats share: the friction table, what holds bodies, and numbers as they are.

Numbers are taken without conversions, and no key may be unknown.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from holdfast.base.archive import to_dict
from holdfast.base.errors import SceneError, message
from holdfast.base.text import quoted
from holdfast.scene.friction import Combine, Friction
from holdfast.scene.hold import AnyHold, Grip, Hold


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


class Model(BaseModel):
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


class PairModel(Model):
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


class FrictionModel(Model):
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


def _as_text(value: Any) -> Any:  # noqa: ANN401
    """Return ``.inf`` of YAML as the text that JSON has for it."""
    return str(value) if isinstance(value, float) and math.isinf(value) else value


ENDLESS = BeforeValidator(_as_text)
End = Annotated[Number | Literal["inf", "-inf"], ENDLESS, Field(description="a number, or inf or -inf as a text")]
Endless = Annotated[Number | Literal["inf"], ENDLESS, Field(description="a number, or inf as a text")]
AxisModel = Endless | tuple[End, End]
BoundsModel = Endless | tuple[AxisModel, AxisModel, AxisModel]


class HoldModel(Model):
    """A hand or gripper that exerts any force and moment within bounds; see holdfast.Hold."""

    type: Literal["hold"]
    body: str
    frame: Matrix4 = Field(description="4x4 frame to world, rows")
    forces: BoundsModel = Field(0.0, description="[N]: the radius of a ball, or an entry for each axis of the frame")
    moments: BoundsModel = Field(0.0, description="[N m], likewise")
    on: str | None = Field(None, description="the body that holds; a hand that is fixed in the world if left out")


class GripModel(Model):
    """Fingers or pads that press on a body; see holdfast.Grip."""

    type: Literal["grip"]
    body: str
    points: list[Triple] = Field(fail_fast=True, description="[m], world frame")
    normals: list[Triple] = Field(fail_fast=True, description="into the body, world frame")
    mu: Number
    force: Endless | list[Endless] = Field("inf", description="largest normal force [N], one or one a point")
    pull: Number = Field(0.0, description="[N]: draws the body against all points together")


AnyHoldModel = Annotated[HoldModel | GripModel, Field(discriminator="type")]


def hold_of(model: HoldModel | GripModel) -> AnyHold:
    """Return the hold that an entry of a scene file describes."""
    if isinstance(model, HoldModel):
        bounds = _numbers_of(model.forces), _numbers_of(model.moments)
        return Hold(model.body, np.array(model.frame), *bounds, model.on)
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
