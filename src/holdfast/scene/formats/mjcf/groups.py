"""Which bodies of a MuJoCo model move as one, and which stand still."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.errors import SceneError, message
from holdfast.base.rigid import pose_from
from holdfast.base.text import listed, quoted
from holdfast.scene.formats.mjcf.names import entries
from holdfast.scene.inertial import Inertial, together

STILL = 0  # the owner of bodies that do not move: the world
FREE = 0  # mjJNT_FREE
CONNECT, WELD = 0, 1  # mjEQ_CONNECT, mjEQ_WELD
BODY, SITE = 1, 6  # mjOBJ_BODY, mjOBJ_SITE
WRAP_SITES, WRAP_GEOMS = (3,), (4, 5)  # mjWRAP_SITE; mjWRAP_SPHERE, mjWRAP_CYLINDER
NO_EQUALITY = 1 << 1  # mjDSBL_EQUALITY


@dataclass(frozen=True)
class Groups:
    """The bodies of a model by what carries them; ``notes`` say what was held fixed or joined.

    ``owner`` (nbody,) is the number of the body with the free joint that carries each body, or STILL. ``names`` are
    those of all bodies, with the numbers of those without one; ``named`` are the numbers of those that have one.
    """

    owner: np.ndarray[Any, np.dtype[np.int64]]
    names: Sequence[str]
    named: frozenset[int]
    notes: tuple[str, ...]

    def of(self, owner: int) -> list[int]:
        """The numbers of the bodies that move with this one, itself first."""
        return [int(b) for b in np.flatnonzero(self.owner == owner)]


def find_groups(model: Any, data: Any, *, rigid: bool) -> Groups:  # noqa: ANN401 - MuJoCo has no types
    """Find which bodies move as one.

    A joint or a weld between bodies that move raises SceneError, with its name, unless ``rigid`` says that it is held.
    """
    given = entries(model, "body", int(model.nbody))
    names = [name or f"body {b}" for b, name in enumerate(given)]
    owner, below, fixed = _owners(model)
    faults = [f"{_joint(model, j)} of {quoted(names[model.jnt_bodyid[j]])}" for j in below]
    joined = []
    for a, b, what in _equalities(model, data):
        if owner[a] != owner[b]:
            faults.append(f"{what} of {quoted(names[a])} and {quoted(names[b])}")
            joined.append((a, b))
    _check_others(model, owner, names)
    if faults and not rigid:
        remedy = "say rigid=True to take what they join as one rigid body as it is now, or fix it in the model"
        raise SceneError(message("joints between bodies that move", listed(faults), remedy))
    for a, b in joined:
        low, high = sorted((int(owner[a]), int(owner[b])))
        owner[owner == high] = low
    notes = [f"taken as rigid as it is now: {text}" for text in faults]
    notes += _held(model, fixed, names)
    return Groups(owner, names, frozenset(b for b, name in enumerate(given) if name), tuple(notes))


def _owners(model: Any) -> tuple[np.ndarray[Any, np.dtype[np.int64]], list[int], list[int]]:  # noqa: ANN401
    """Return the owner of each body, the joints below free bodies, and those of chains that hang on the world."""
    owner = np.zeros(int(model.nbody), dtype=np.int64)
    below: list[int] = []
    fixed: list[int] = []
    for b in range(1, len(owner)):
        joints = range(int(model.body_jntadr[b]), int(model.body_jntadr[b]) + int(model.body_jntnum[b]))
        if any(model.jnt_type[j] == FREE for j in joints):
            owner[b] = b
            continue
        owner[b] = owner[model.body_parentid[b]]
        (below if owner[b] != STILL else fixed).extend(joints)
    return owner, below, fixed


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
    """Raise SceneError for what acts on bodies that move and is neither weight nor contact."""
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
    if not joints:
        return []
    bodies = dict.fromkeys(names[model.jnt_bodyid[j]] for j in joints)
    note = f"held fixed at their joint positions: {listed(list(bodies))}"
    driven = set(np.asarray(model.actuator_trnid)[:, 0].tolist()) if model.nu else set()
    loose = [_joint(model, j) for j in joints if j not in driven]
    return [note + (f"; no actuator drives {listed(loose)}, held all the same" if loose else "")]


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
            own = _inverse(home) @ frame_of(data, b) @ own
        each.append(Inertial(float(model.body_mass[b]), np.zeros(3), np.diag(model.body_inertia[b])).seen(own))
    whole = together(each)
    return whole._replace(inertia=(whole.inertia + whole.inertia.T) / 2)


def _inverse(pose: Float) -> Float:
    back = np.eye(4)
    back[:3, :3], back[:3, 3] = pose[:3, :3].T, -pose[:3, :3].T @ pose[:3, 3]
    return back


def relative(pose: Float, home: Float) -> Float:
    """Return a pose (4, 4) of the world as seen from the frame ``home`` (4, 4)."""
    return _inverse(home) @ pose
