"""The entries of native scene files for what holds bodies: hands, grippers, suction cups."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from holdfast.base.archive import to_dict
from holdfast.scene.formats.models_shared import Matrix4, Model, Number, Triple
from holdfast.scene.hold import AnyHold, Grip, Hold

End = Annotated[Number | Literal["inf", "-inf"], Field(description="a number, or inf or -inf as a text")]
Endless = Annotated[Number | Literal["inf"], Field(description="a number, or inf as a text")]
AxisModel = Endless | tuple[End, End]
BoundsModel = Endless | tuple[AxisModel, AxisModel, AxisModel]


class HoldModel(Model):
    """A hand or gripper that exerts any force and moment within bounds; see holdfast.Hold."""

    type: Literal["hold"]
    body: str
    frame: Matrix4 = Field(description="4x4 frame to world, rows")
    forces: BoundsModel = Field(0.0, description="[N]: the radius of a ball, or an entry for each axis of the frame")
    moments: BoundsModel = Field(0.0, description="[N m], likewise")


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
        return Hold(model.body, np.array(model.frame), _numbers_of(model.forces), _numbers_of(model.moments))
    force = _numbers_of(model.force)
    return Grip(model.body, np.array(model.points), np.array(model.normals), model.mu, force, model.pull)


def _numbers_of(item: Any) -> Any:  # noqa: ANN401 - numbers, inf as a text, and lists of them
    return [_numbers_of(part) for part in item] if isinstance(item, list | tuple) else float(item)


def hold_data(hold: AnyHold) -> dict[str, Any]:
    """Return a hold as a scene file has it."""
    if isinstance(hold, Hold):
        bounds = {"forces": to_dict(hold.forces), "moments": to_dict(hold.moments)}
        return {"type": "hold", "body": hold.body, "frame": hold.frame.tolist()} | bounds
    data: dict[str, Any] = {"type": "grip", "body": hold.body, "points": hold.points.tolist()}
    data |= {"normals": hold.normals.tolist(), "mu": hold.mu, "force": to_dict(hold.force)}
    return data | ({"pull": hold.pull} if hold.pull else {})
