"""Groups of bodies of a MuJoCo model that move as one, and bodies that stand still."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.errors import SceneError, message
from holdfast.base.rigid import pose_from
from holdfast.base.text import listed, quoted
from holdfast.scene.compound import Inertial, together
from holdfast.scene.formats.mjcf.mjcf_names import entries
from holdfast.scene.formats.mjcf.mobility import FREE, free_by_joints, held_joints, joints_of
from holdfast.scene.formats.simulators.links import relative

STILL = 0  # the owner of bodies that do not move: the world
CONNECT, WELD = 0, 1  # mjEQ_CONNECT, mjEQ_WELD
BODY, SITE = 1, 6  # mjOBJ_BODY, mjOBJ_SITE
WRAP_SITES, WRAP_GEOMS = (3,), (4, 5)  # mjWRAP_SITE; mjWRAP_SPHERE, mjWRAP_CYLINDER
NO_EQUALITY = 1 << 1  # mjDSBL_EQUALITY


@dataclass(frozen=True)
class Groups:
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


def find_groups(model: Any, data: Any, *, rigid: bool, motors: bool = False) -> Groups:  # noqa: ANN401 - MuJoCo has no types
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
    notes += [f"{quoted(names[b])} moves freely by its joints: {_named(model, each)}" for b, each in freed.items()]
    notes += _held(model, fixed, names)
    return Groups(owner, names, frozenset(b for b, name in enumerate(given) if name), tuple(notes), tuple(joints))


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


def _held(model: Any, joints: list[int], names: Sequence[str]) -> list[str]:  # noqa: ANN401
    bodies = dict.fromkeys(names[model.jnt_bodyid[j]] for j in joints)
    return [f"held fixed at their joint positions: {listed(list(bodies))}"] if bodies else []


def _named(model: Any, joints: Sequence[int]) -> str:  # noqa: ANN401
    return listed([_joint(model, j).removeprefix("joint ") for j in joints])


def frame_of(data: Any, b: int) -> Float:  # noqa: ANN401
    """Return the pose (4, 4) of a body in the world."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = np.asarray(data.xmat[b]).reshape(3, 3), data.xpos[b]
    return pose


def inertia_of(model: Any, data: Any, bodies: Sequence[int]) -> Inertial:  # noqa: ANN401
    """Return the inertia of several bodies that move as one, in the frame of the first of them."""
    home = frame_of(data, bodies[0])
    each = []
    for b in bodies:
        own = pose_from(np.array(model.body_ipos[b]), np.array(model.body_iquat[b]))
        if b != bodies[0]:
            own = relative(frame_of(data, b), home) @ own
        each.append(Inertial(float(model.body_mass[b]), np.zeros(3), np.diag(model.body_inertia[b])).seen(own))
    return together(each)
