"""The mobility of the bodies of a MuJoCo model: which move as one, which stand still, which motors hold."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.errors import SceneError, message
from holdfast.base.rigid import cross, pose_from
from holdfast.base.text import listed, quoted
from holdfast.scene.compound import Inertial, together
from holdfast.scene.formats.joints import Motors, joint_hold
from holdfast.scene.formats.mjcf.rules import entries
from holdfast.scene.formats.simulators.simulated import relative
from holdfast.scene.hold import Hold, Range

FREE, BALL, SLIDE = 0, 1, 2  # mjJNT_FREE, mjJNT_BALL, mjJNT_SLIDE
DOFS = {FREE: 6, BALL: 3}  # other joints have 1
JOINT, IN_PARENT, TENDON = 0, 1, 3  # mjTRN_JOINT, mjTRN_JOINTINPARENT, mjTRN_TENDON
WRAP_JOINT = 1  # mjWRAP_JOINT
NO_ACTUATION = 1 << 11  # mjDSBL_ACTUATION
AT_REST = 1e-6  # share of a motion up to which a joint counts as held
INDEPENDENT = 1e-6  # least singular value of six unit motions that count as independent
WEIGHTLESS = 1e-6  # largest mass of a body that only carries joints, relative to the body behind them
STILL = 0  # the owner of bodies that do not move: the world
CONNECT, WELD = 0, 1  # mjEQ_CONNECT, mjEQ_WELD
BODY, SITE = 1, 6  # mjOBJ_BODY, mjOBJ_SITE
WRAP_SITES, WRAP_GEOMS = (3,), (4, 5)  # mjWRAP_SITE; mjWRAP_SPHERE, mjWRAP_CYLINDER
NO_EQUALITY = 1 << 1  # mjDSBL_EQUALITY
AFFINE, PID = 1, 5  # mjGAIN_AFFINE and mjBIAS_AFFINE, mjGAIN_PID; 0 is a fixed gain, and no bias
INTEGRATOR, FILTERS = 1, (0, 2, 3)  # mjDYN_INTEGRATOR; mjDYN_NONE, mjDYN_FILTER, mjDYN_FILTEREXACT


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


@dataclass(frozen=True)
class BodyOwners:
    """The bodies of a model, grouped by the free body with which they move.

    ``owner`` (nbody,) is the number of that free body for each body, or STILL. ``names`` are those of all bodies;
    bodies without a name get their number, and ``named`` are the numbers of the others. ``notes`` say what was held
    fixed or joined. ``joints`` are those by which motors hold bodies.
    """

    owner: Int
    names: Sequence[str]
    named: frozenset[int]
    notes: tuple[str, ...]
    joints: tuple[int, ...]

    def of(self, owner: int) -> list[int]:
        """Return the numbers of the bodies that move with this one, itself first."""
        return [int(b) for b in np.flatnonzero(self.owner == owner)]


def find_groups(model: Any, data: Any, *, rigid: bool, motors: bool = False) -> BodyOwners:  # noqa: ANN401 - MuJoCo has no types
    """Find which bodies move as one.

    A body moves if it has a free joint, or other joints that nothing holds and that together allow the same motions. A
    joint or a weld between moving bodies raises SceneError with its name, and so does a movable joint between a body
    and the world that nothing drives, unless ``rigid`` is True: then they hold. With ``motors``, every body with a
    joint moves.
    """
    given = entries(model, "body", int(model.nbody))
    names = [name or f"body {b}" for b, name in enumerate(given)]
    owner, faulty, fixed, freed = _owners(model, data)
    joints = sorted({*faulty, *fixed}) if motors else []
    if motors:
        owner, faulty, fixed = _owned(model, {*owner.tolist(), *model.jnt_bodyid[joints].tolist()} - {STILL}), [], []
    faults = [f"{_joint(model, j)} of {quoted(names[model.jnt_bodyid[j]])}" for j in faulty]
    joined = []
    for a, b, what in _equalities(model, data):
        if owner[a] != owner[b]:
            faults.append(f"{what} of {quoted(names[a])} and {quoted(names[b])}")
            joined.append((a, b))
    _check_others(model, owner, names)
    if faults and not rigid:
        remedy = "say rigid=True to take what they join as one rigid body as it is now, or fix it in the model"
        raise SceneError(message("joints that can move", listed(faults), remedy))
    for a, b in joined:
        low, high = sorted((int(owner[a]), int(owner[b])))
        owner[owner == high] = low
    notes = [f"taken as rigid as it is now: {listed(faults)}"] if faults else []
    for b, each in freed.items():
        by = listed([_joint(model, j).removeprefix("joint ") for j in each])
        notes.append(f"{quoted(names[b])} moves freely by its joints: {by}")
    bodies = dict.fromkeys(names[model.jnt_bodyid[j]] for j in fixed)
    notes += [f"held fixed at their joint positions: {listed(list(bodies))}"] if bodies else []
    return BodyOwners(owner, names, frozenset(b for b, name in enumerate(given) if name), tuple(notes), tuple(joints))


def _owners(model: Any, data: Any) -> tuple[Int, list[int], list[int], dict[int, list[int]]]:  # noqa: ANN401
    """Return the owner of each body, and by number the joints that are errors, that hold, and that free a body.

    Joints below free bodies are errors, and so are those of chains on the world that nothing holds.
    """
    count = int(model.nbody)
    free = {b for b in range(1, count) if any(model.jnt_type[j] == FREE for j in joints_of(model, b))}
    owner = _owned(model, free)
    hung = [j for b in range(1, count) if owner[b] == STILL for j in joints_of(model, b)]
    loose = {j for j, held in zip(hung, held_joints(model, data, hung), strict=True) if not held}
    freed = {}
    for b in sorted({int(model.jnt_bodyid[j]) for j in loose}):
        by = free_by_joints(model, data, b, loose)
        if by and not loose.isdisjoint(by):
            freed[b] = by
            loose -= set(by)
    owner = _owned(model, free | set(freed))
    joints = [j for j in range(int(model.njnt)) if model.jnt_type[j] != FREE]
    gone = {j for each in freed.values() for j in each}
    faulty = [j for j in joints if j not in gone and (j in loose or owner[model.jnt_bodyid[j]] != STILL)]
    return owner, faulty, [j for j in joints if j not in gone and j not in faulty], freed


def _owned(model: Any, free: set[int]) -> Int:  # noqa: ANN401
    """Return the number of the free body with which each body moves, or STILL."""
    owner = np.zeros(int(model.nbody), dtype=np.int64)
    for b in range(1, len(owner)):
        owner[b] = b if b in free else owner[model.body_parentid[b]]
    return owner


def _joint(model: Any, j: int) -> str:  # noqa: ANN401
    return f"joint {quoted(entries(model, 'jnt', int(model.njnt))[j] or j)}"


def _equalities(model: Any, data: Any) -> list[tuple[int, int, str]]:  # noqa: ANN401
    """Return the pairs of bodies that active welds and connections join, with the name of each."""
    if model.opt.disableflags & NO_EQUALITY:
        return []
    names = entries(model, "eq", int(model.neq))
    found = []
    for k in np.flatnonzero(np.asarray(data.eq_active)):
        if model.eq_type[k] in (CONNECT, WELD):
            ends = [int(model.eq_obj1id[k]), int(model.eq_obj2id[k])]
            a, b = ends if model.eq_objtype[k] == BODY else [int(model.site_bodyid[s]) for s in ends]
            kind = "weld" if model.eq_type[k] == WELD else "connection"
            found.append((a, b, f"{kind} {quoted(names[k] or int(k))}"))
    return found


def _check_others(model: Any, owner: Any, names: Sequence[str]) -> None:  # noqa: ANN401
    """Raise SceneError for anything but weight and contact that acts on moving bodies."""
    if model.nflex:
        raise SceneError(message("flex", f"the model has {model.nflex} soft bodies", "needs rigid bodies alone"))
    lifted = [names[int(b)] for b in np.flatnonzero((np.asarray(model.body_gravcomp) != 0) & (owner != STILL))]
    if lifted:
        problem = f"gravcomp lifts {listed(lifted)}"
        raise SceneError(message("gravity", problem, "needs bodies with their whole weight: give gravcomp 0"))
    kinds = np.asarray(model.wrap_type)
    for t, name in enumerate(entries(model, "tendon", int(model.ntendon))):
        wraps = range(int(model.tendon_adr[t]), int(model.tendon_adr[t]) + int(model.tendon_num[t]))
        sites = [model.site_bodyid[model.wrap_objid[w]] for w in wraps if kinds[w] in WRAP_SITES]
        geoms = [model.geom_bodyid[model.wrap_objid[w]] for w in wraps if kinds[w] in WRAP_GEOMS]
        pulled = sorted({names[int(b)] for b in (*sites, *geoms) if owner[b] != STILL})
        if pulled:
            problem = f"pulls at {listed(pulled)}"
            raise SceneError(message(f"tendon {quoted(name or t)}", problem, "leave it out of the model"))


def frame_of(data: Any, b: int) -> Float:  # noqa: ANN401
    """Return the pose (4, 4) of a body in the world."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = np.asarray(data.xmat[b]).reshape(3, 3), data.xpos[b]
    return pose


def carried(model: Any, data: Any, b: int, home: int) -> Float:  # noqa: ANN401
    """Return the pose (4, 4) of a body in the frame of the body ``home`` that carries it.

    Where no joint is between the two it is that of the model, to the last digit the same in every state, so that the
    shapes of all states are one.
    """
    pose, at = np.eye(4), b
    while at not in (home, STILL) and not model.body_jntnum[at]:
        pose = pose_from(np.array(model.body_pos[at]), np.array(model.body_quat[at])) @ pose
        at = int(model.body_parentid[at])
    return pose if at == home else relative(frame_of(data, b), frame_of(data, home))


def inertia_of(model: Any, data: Any, bodies: Sequence[int]) -> Inertial:  # noqa: ANN401
    """Return the inertia of several bodies that move as one, in the frame of the first of them."""
    each = []
    for b in bodies:
        to_first = pose_from(np.array(model.body_ipos[b]), np.array(model.body_iquat[b]))
        if b != bodies[0]:
            to_first = carried(model, data, b, bodies[0]) @ to_first
        each.append(Inertial(float(model.body_mass[b]), np.zeros(3), np.diag(model.body_inertia[b])).seen(to_first))
    return together(each)


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
    holds = []
    for j, immobile in zip(joints, held_joints(model, data, joints).tolist(), strict=True):
        b = int(model.jnt_bodyid[j])
        if len(joints_of(model, b)) > 1 or model.jnt_type[j] == BALL:
            several = listed([quoted(known[k]) for k in joints_of(model, b)])
            problem = f"body {quoted(names[b])} has the joints {several}"
            remedy = "hold_torques takes one hinge or slide a body: put a body with a mass between them"
            raise SceneError(message("joints", problem, remedy))
        low, high = motors.of(known[j], _motor_range(model, data, j, immobile=immobile))
        dof = int(model.jnt_dofadr[j])
        pushed = float(data.qfrc_spring[dof] + data.qfrc_applied[dof])  # which the motor has to bear
        bounds = low + pushed, high + pushed
        slides = bool(model.jnt_type[j] == SLIDE)
        on = names.get(int(owner[model.body_parentid[b]]))
        holds.append(joint_hold(names[b], on, data.xanchor[j], np.array(data.xaxis[j]), bounds, slides=slides))
    return holds


def _motor_range(model: Any, data: Any, j: int, *, immobile: bool) -> Range | None:  # noqa: ANN401
    """Return what the actuators of joint ``j`` can give together [N m, or N if it slides]; None if that is not known.

    It is not if one of them has no limit, or if the joint has none but is ``immobile`` (``held_joints``): what tendons,
    couplings and the actuators of other joints hold it with has no limit of its own.
    """
    kinds, targets = np.asarray(model.actuator_trntype), np.asarray(model.actuator_trnid).reshape(-1, 2)[:, 0]
    actuators = np.flatnonzero(np.isin(kinds, (JOINT, IN_PARENT)) & (targets == j) & acting(model))
    if immobile and not len(actuators):
        return None
    ends = np.zeros(2)
    for k in actuators.tolist():
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
