"""The arms of a MuJoCo model: bodies that are held by the motors of their joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from holdfast.base.arrays import Int
from holdfast.base.errors import SceneError, message
from holdfast.base.text import listed, quoted
from holdfast.scene.formats.joint_holds import Motors, joint_hold
from holdfast.scene.formats.mjcf.mjcf_names import entries
from holdfast.scene.formats.mjcf.mobility import BALL, IN_PARENT, JOINT, SLIDE, held_joints, joints_of
from holdfast.scene.hold import Hold, Range


def holds_of(
    model: Any,  # noqa: ANN401 - MuJoCo has no types
    data: Any,  # noqa: ANN401
    joints: Sequence[int],
    motors: Motors,
    names: Mapping[int, str],
    owner: Int,
) -> list[Hold]:
    """Return the holds of bodies by these joints; ``names`` are those of moving bodies, by the number of the owner."""
    known = [name or str(j) for j, name in enumerate(entries(model, "jnt", int(model.njnt)))]
    motors.check_names([known[j] for j in joints])
    found = []
    for j, held in zip(joints, held_joints(model, data, joints).tolist(), strict=True):
        b = int(model.jnt_bodyid[j])
        if len(joints_of(model, b)) > 1 or model.jnt_type[j] == BALL:
            several = listed([quoted(known[k]) for k in joints_of(model, b)])
            problem = f"body {quoted(names[b])} has the joints {several}"
            remedy = "hold_torques takes one hinge or slide a body: put a body with a mass between them"
            raise SceneError(message("joints", problem, remedy))
        own = motors.of(known[j], _range(model, j, held=held))
        slides = bool(model.jnt_type[j] == SLIDE)
        on = names.get(int(owner[model.body_parentid[b]]))
        found.append(joint_hold(names[b], on, data.xanchor[j], np.array(data.xaxis[j]), own, slides=slides))
    return found


def _range(model: Any, j: int, *, held: bool) -> Range | None:  # noqa: ANN401
    """Return what the actuators of a joint can give together; None if one has no limit, or another joint's hold it."""
    kinds, targets = np.asarray(model.actuator_trntype), np.asarray(model.actuator_trnid).reshape(-1, 2)[:, 0]
    own = np.flatnonzero(np.isin(kinds, (JOINT, IN_PARENT)) & (targets == j))
    if held and not len(own):
        return None
    ends = np.zeros(2)
    for k in own.tolist():
        force = _force(model, k)
        if force is None:
            return None if not model.jnt_actfrclimited[j] else _pair(model.jnt_actfrcrange[j])
        ends += np.sort(float(model.actuator_gear[k, 0]) * np.array(force))
    if model.jnt_actfrclimited[j]:
        ends = np.clip(ends, *model.jnt_actfrcrange[j])
    return _pair(ends)


def _force(model: Any, k: int) -> Range | None:  # noqa: ANN401
    """Return the range of an actuator's force before its gear, or None."""
    if model.actuator_forcelimited[k]:
        return _pair(model.actuator_forcerange[k])
    kinds = model.actuator_gaintype[k], model.actuator_biastype[k], model.actuator_dyntype[k]
    if any(kinds) or not model.actuator_ctrllimited[k]:  # 0 of each is a plain motor: force = gain * control
        return None
    return _pair(np.sort(float(model.actuator_gainprm[k, 0]) * np.asarray(model.actuator_ctrlrange[k])))


def _pair(ends: Any) -> Range:  # noqa: ANN401
    low, high = (float(end) for end in ends)
    return low, high
