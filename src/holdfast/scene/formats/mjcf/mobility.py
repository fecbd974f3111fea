"""The mobility of bodies that are connected to the world of a MuJoCo model by joints: fixed, free or in between."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from importlib import import_module
from typing import Any

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.rigid import cross

FREE, BALL, SLIDE = 0, 1, 2  # mjJNT_FREE, mjJNT_BALL, mjJNT_SLIDE
DOFS = {FREE: 6, BALL: 3}  # other joints have 1
JOINT, IN_PARENT, TENDON = 0, 1, 3  # mjTRN_JOINT, mjTRN_JOINTINPARENT, mjTRN_TENDON
WRAP_JOINT = 1  # mjWRAP_JOINT
NO_ACTUATION = 1 << 11  # mjDSBL_ACTUATION
AT_REST = 1e-6  # share of a motion up to which a joint counts as held
INDEPENDENT = 1e-6  # least singular value of six unit motions that count as independent
WEIGHTLESS = 1e-6  # largest mass of a body that only carries joints, relative to the body behind them


def dofs_of(model: Any, j: int) -> Int:  # noqa: ANN401 - MuJoCo has no types
    """Return the numbers of the degrees of freedom of a joint."""
    first = int(model.jnt_dofadr[j])
    return np.arange(first, first + DOFS.get(int(model.jnt_type[j]), 1))


def held_joints(model: Any, data: Any, joints: Sequence[int]) -> Bool:  # noqa: ANN401
    """Tell which of these joints (k,) cannot move, because of actuators that hold positions or equality constraints.

    Each actuator on a joint or on a tendon of joints is a row of a linear system, and so is each active equality
    constraint among these joints; a joint is held if no motion that all rows allow moves it. So the joints of a closed
    chain with one drive are held, and those of a finger that follows another one.
    """
    if not len(joints):
        return np.zeros(0, dtype=bool)
    columns = np.concatenate([dofs_of(model, j) for j in joints])
    rows = np.vstack([_driven(model), _equal(model, data)])
    others = np.ones(rows.shape[1], dtype=bool)
    others[columns] = False
    rows = rows[~rows[:, others].any(axis=1)][:, columns]
    _, sizes, turned = np.linalg.svd(rows) if len(rows) else (None, np.zeros(0), np.eye(len(columns)))
    rank = int((sizes > AT_REST * sizes.max(initial=0.0)).sum())
    moves = np.abs(turned[rank:]).max(axis=0, initial=0.0) > AT_REST
    ends = np.cumsum([len(dofs_of(model, j)) for j in joints])
    return np.array([not part.any() for part in np.split(moves, ends[:-1])])


def acting(model: Any) -> Bool:  # noqa: ANN401
    """Tell which actuators (nu,) the model does not switch off, all of them or by their group."""
    groups = np.asarray(model.actuator_group).ravel()
    off = np.isin(groups, [group for group in range(31) if int(model.opt.disableactuator) >> group & 1])
    return ~off & (not model.opt.disableflags & NO_ACTUATION)


def _driven(model: Any) -> Float:  # noqa: ANN401
    """Return a row (n, nv) for every motion of joints that an actuator drives."""
    rows = []
    for k in np.flatnonzero(acting(model)).tolist():
        kind, target = model.actuator_trntype[k], int(np.asarray(model.actuator_trnid).reshape(-1, 2)[k, 0])
        if kind in (JOINT, IN_PARENT):
            rows += list(np.eye(model.nv)[dofs_of(model, int(target))])
        elif kind == TENDON:
            row = np.zeros(model.nv)
            for w in range(int(model.tendon_adr[target]), int(model.tendon_adr[target] + model.tendon_num[target])):
                if model.wrap_type[w] == WRAP_JOINT:
                    row[dofs_of(model, int(model.wrap_objid[w]))] = model.wrap_prm[w]
            rows.append(row)
    return np.array(rows).reshape(-1, int(model.nv))


def _equal(model: Any, data: Any) -> Float:  # noqa: ANN401
    """Return the Jacobian (n, nv) of the active equality constraints, as ``mj_forward`` left it."""
    count, wide = int(data.ne), int(model.nv)
    values = np.asarray(data.efc_J).ravel()
    if not import_module("mujoco").mj_isSparse(model):  # the arrays of a sparse one then hold anything
        return values.reshape(-1, wide)[:count]
    rows = np.zeros((count, wide))
    for k in range(count):
        first, number = int(data.efc_J_rowadr[k]), int(data.efc_J_rownnz[k])
        rows[k, np.asarray(data.efc_J_colind)[first : first + number]] = values[first : first + number]
    return rows


def joints_of(model: Any, b: int) -> range:  # noqa: ANN401
    """Return the numbers of the joints of a body."""
    first = int(model.body_jntadr[b])
    return range(first, first + int(model.body_jntnum[b]))


def free_by_joints(model: Any, data: Any, b: int, loose: Collection[int]) -> list[int]:  # noqa: ANN401
    """Return the ``loose`` joints that together let a body move as a free joint would; none if they do not.

    They are its own and those of the bodies between it and the world, which may have neither a weight nor a geom. The
    six unit motions of the body that they allow are independent of each other: three slides and a ball, say. In a
    position in which two axes coincide they are not.
    """
    joints = list(joints_of(model, b))
    above = int(model.body_parentid[b])
    while above and joints:
        own = joints_of(model, above)
        if len(own) and (model.body_geomnum[above] or model.body_mass[above] > WEIGHTLESS * model.body_subtreemass[b]):
            return []
        joints += own
        above = int(model.body_parentid[above])
    if not joints or not set(joints) <= set(loose):
        return []
    motions = []
    for j in joints:
        kind, axis = int(model.jnt_type[j]), np.array(data.xaxis[j])
        arm = np.array(data.xpos[b] - data.xanchor[j])
        if kind == SLIDE:
            motions.append(np.concatenate([axis, np.zeros(3)]))
        else:
            motions += [np.concatenate([cross(turn, arm), turn]) for turn in (np.eye(3) if kind == BALL else [axis])]
    unit = np.array(motions)
    unit[:, :3] /= max(1.0, float(np.abs(unit[:, :3]).max()))
    return joints if len(unit) >= 6 and np.linalg.svd(unit, compute_uv=False)[5] > INDEPENDENT else []
