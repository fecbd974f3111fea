"""The arms of a URDF file: links that are held by the motors of their joints."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from holdfast.base.arrays import Float
from holdfast.scene.formats.joint_holds import Motors, joint_hold, never_touching
from holdfast.scene.formats.urdf.tree import SLIDING, Group, Joint, axis_of
from holdfast.scene.hold import Range
from holdfast.scene.scene import Scene


def with_arms(
    scene: Scene, groups: Sequence[Group], tops: Sequence[str], copies: Iterable[tuple[str, Float]], motors: Motors
) -> Scene:
    """Return the scene with the holds of all joints, for each copy of the file at its pose (4, 4) in the world.

    ``tops`` are the first links of the groups that are bodies; what holds on any other is fixed in the world.
    """
    fixed, holds, arms, balls = {body.name: body.fixed for body in scene.bodies}, [], [], []
    for copy, place in copies:
        names = {top: f"{copy}/{top}" if len(tops) > 1 else copy for top in tops}
        arms.append([*names.values()])
        balls += [names[top] for top in motors.balls]
        for group in groups:
            joint, body = group.joint, names.get(group.top)
            if joint is None or body is None or fixed[body]:
                continue
            at, on = place @ group.pose, names.get(group.above)
            axis, own = at[:3, :3] @ axis_of(joint.element), motors.of(joint.name, _effort(joint))
            slides = joint.kind in SLIDING
            holds.append(joint_hold(body, on, at[:3, 3], axis, own, slides=slides))
    return replace(scene, holds=tuple(holds), excluded=never_touching(arms, balls, [*fixed]))


def _effort(joint: Joint) -> Range | None:
    """Return the range of a joint by its <limit>; None without one, for 0, and for a joint that another one drives.

    Files write 0 for none.
    """
    limit = joint.element.child("limit")
    effort = 0.0 if limit is None or joint.element.child("mimic") is not None else limit.number("effort", 0.0)
    return (-effort, effort) if effort > 0 else None
