"""The entries of native scene files for what holds bodies: hands, grippers, suction cups."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field

from holdfast.base.archive import to_dict
from holdfast.scene.formats.models_shared import Matrix4, Model, Number, Triple
from holdfast.scene.hold import AnyHold, Grip, Hold


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
