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
from holdfast.scene.formats.mjcf.mobility import BALL, IN_PARENT, JOINT, SLIDE, acting, held_joints, joints_of
from holdfast.scene.hold import Hold, Range

AFFINE, PID = 1, 5  # mjGAIN_AFFINE and mjBIAS_AFFINE, mjGAIN_PID; 0 is a fixed gain, and no bias
INTEGRATOR, FILTERS = 1, (0, 2, 3)  # mjDYN_INTEGRATOR; mjDYN_NONE, mjDYN_FILTER, mjDYN_FILTEREXACT


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
        low, high = motors.of(known[j], _range(model, data, j, held=held))
        dof = int(model.jnt_dofadr[j])
        pushed = float(data.qfrc_spring[dof] + data.qfrc_applied[dof])  # which the motor has to bear
        own = low + pushed, high + pushed
        slides = bool(model.jnt_type[j] == SLIDE)
        on = names.get(int(owner[model.body_parentid[b]]))
        found.append(joint_hold(names[b], on, data.xanchor[j], np.array(data.xaxis[j]), own, slides=slides))
    return found


def _range(model: Any, data: Any, j: int, *, held: bool) -> Range | None:  # noqa: ANN401
    """Return what the actuators of a joint can give together; None if one has no limit, or another joint's hold it."""
    kinds, targets = np.asarray(model.actuator_trntype), np.asarray(model.actuator_trnid).reshape(-1, 2)[:, 0]
    own = np.flatnonzero(np.isin(kinds, (JOINT, IN_PARENT)) & (targets == j) & acting(model))
    if held and not len(own):
        return None
    ends = np.zeros(2)
    for k in own.tolist():
        force = _force(model, k, float(data.qpos[model.jnt_qposadr[j]]))
        if force is None:
            return None if not model.jnt_actfrclimited[j] else _pair(model.jnt_actfrcrange[j])
        ends += np.sort(float(model.actuator_gear[k, 0]) * np.array(force))
    if model.jnt_actfrclimited[j]:
        ends = np.clip(ends, *model.jnt_actfrcrange[j])
    return _pair(ends)


def _force(model: Any, k: int, position: float) -> Range | None:  # noqa: ANN401
    """Return the range of an actuator's force before its gear, or None; ``position`` is that of its joint.

    ``forcerange`` bounds it, and so does the range of its control: a motor gives gain * control, and a servo at this
    position no more than it does for the ends of that range.
    """
    gain, bias, dynamics = (
        int(kind[k]) for kind in (model.actuator_gaintype, model.actuator_biastype, model.actuator_dyntype)
    )
    limits = _pair(model.actuator_forcerange[k]) if model.actuator_forcelimited[k] else None
    if gain == PID:
        return limits
    if gain > AFFINE or bias > AFFINE:  # muscles and others
        return None
    given = None
    if dynamics in FILTERS and model.actuator_ctrllimited[k]:
        given = model.actuator_ctrlrange[k]
    if dynamics == INTEGRATOR and model.actuator_actlimited[k]:
        given = model.actuator_actrange[k]
    if given is None:
        return limits
    length = float(model.actuator_gear[k, 0]) * position
    factor, shift = (
        prm[k, 0] + (prm[k, 1] * length if kind == AFFINE else 0.0)
        for prm, kind in ((model.actuator_gainprm, gain), (model.actuator_biasprm, bias))
    )
    ends = np.sort(factor * np.asarray(given) + shift)
    return _pair(ends if limits is None else np.clip(ends, *limits))


def _pair(ends: Any) -> Range:  # noqa: ANN401
    low, high = (float(end) for end in ends)
    return low, high
