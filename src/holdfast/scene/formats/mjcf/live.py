"""Scenes from a compiled MuJoCo model and its state."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from holdfast.base.arrays import checked_truth
from holdfast.base.errors import SceneError, located, message
from holdfast.base.text import listed, quoted
from holdfast.scene.body import Body
from holdfast.scene.formats.joints import Motors, Torques, never_touching
from holdfast.scene.formats.links import BodyParts, BodyPiece, kept_apart, unique
from holdfast.scene.formats.mjcf import mobility
from holdfast.scene.formats.mjcf.mobility import FREE, IN_PARENT, JOINT, STILL, WRAP_JOINT, BodyOwners
from holdfast.scene.formats.mjcf.rules import MESH, PLANE, GeomRules, kind_of, pose_of, solid_of
from holdfast.scene.formats.simulators.simulated import body_of
from holdfast.scene.friction import Friction
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.scene import Scene

NO_GRAVITY = 1 << 7  # mjDSBL_GRAVITY
SEEN = 1e-3  # relative to the smaller movable body: soft contacts overlap by less, and such overlaps are not reported
SITE, BODY = 4, 5  # mjTRN_SITE, mjTRN_BODY
MOST_CONDIM = 3  # contacts with a larger condim also resist twisting and rolling at points


class GeomGroup(NamedTuple):
    """One body of the scene: ``bodies`` of the model, and the colliding ``geoms`` of all of them."""

    name: str
    bodies: list[int]
    geoms: list[int]
    fixed: bool


@np.errstate(over="ignore", invalid="ignore")  # infinite numbers raise an error that names the body
def from_mujoco(
    model: Any,  # noqa: ANN401
    data: Any,  # noqa: ANN401
    *,
    rigid: bool = False,
    hold_torques: Torques = False,
    name: str = "",
) -> Scene:
    """Return the scene of a MuJoCo model ``mujoco.MjModel`` in the state ``data``, ``mujoco.MjData``.

    Poses are those of ``data.xpos`` and ``data.xmat``, which ``mujoco.mj_forward`` (or ``mj_kinematics``) brings up to
    date with ``data.qpos``; ``mj_step`` alone leaves them one step behind. Frames of bodies are MuJoCo's, and so are
    masses, centres of mass and inertias. Bodies with a free joint move, with all that is welded to them; all others are
    fixed where they are: each geom of the world and each plane by itself. A body has its own name, that of its only
    geom, or its number. docs/from/mujoco.md says what is ignored in general, and the scene's ``notes`` in this case.
    Shapes are cached between calls, so scenes of many states of a simulation are cheap.

    With ``rigid=True``, moving bodies that are connected by joints or welds are one rigid body; otherwise such a
    connection raises SceneError. So do soft bodies, and everything that Scene and Body refuse. With ``hold_torques``
    every body with a hinge or a slide moves, held by the body that carries it: the joint bears any force and moment but
    along its axis, where its actuators give at most what ``forcerange``, ``actuatorfrcrange`` or, of a motor,
    ``ctrlrange`` say, or ``hold_torques`` by the joint's name [N m, or N if it slides]; a joint that nothing drives
    gives none. Bodies of one kinematic tree never touch each other then.
    """
    if not hasattr(model, "body_weldid") or not hasattr(data, "xpos"):
        problem = f"got a {type(model).__name__} and a {type(data).__name__}"
        raise SceneError(message("from_mujoco", problem, "needs mujoco.MjModel and mujoco.MjData"))
    if not np.any(data.xmat):
        raise SceneError(message("from_mujoco", "the state has no poses yet", "call mujoco.mj_forward(model, data)"))
    rules = GeomRules(model)
    motors = Motors(hold_torques, welded=checked_truth(rigid, "rigid"))
    owners = mobility.find_groups(model, data, rigid=rigid, motors=motors.used)
    groups, empty = _groups(model, owners, rules)
    bodies = []
    for group in groups:
        with located(f"body {quoted(group.name)}"):
            bodies.append(_body(model, data, group, rules, motors))
    table = rules.table([g for group in groups for g in group.geoms]) if groups else {}
    gravity = np.zeros(3) if model.opt.disableflags & NO_GRAVITY else np.array(model.opt.gravity)
    notes = [*owners.notes, *_left_out(model, rules, empty), *_unread(model, data, owners, motors.used)]
    notes += _overlaps(data, groups, bodies)
    parts = [BodyParts(body, group.geoms) for group, body in zip(groups, bodies, strict=True)]
    apart = [] if rules.all_may else kept_apart(combinations(parts, 2), rules.touching)
    if not motors.used:
        return Scene(bodies, Friction(pairs=table), gravity, name, apart, notes)
    moving = {group.bodies[0]: group.name for group in groups if not group.fixed}
    holds = mobility.holds_of(model, data, owners.joints, motors, moving, owners.owner)
    roots = sorted({int(model.body_rootid[model.jnt_bodyid[j]]) for j in owners.joints})
    arms = [[group.name for group in groups if model.body_rootid[group.bodies[0]] == root] for root in roots]
    never = never_touching(arms, motors.balls, [body.name for body in bodies])
    pairs = dict.fromkeys((*apart, *never))
    return Scene(bodies, Friction(pairs=table), gravity, name, pairs, notes, holds)


def _groups(model: Any, owners: BodyOwners, rules: GeomRules) -> tuple[list[GeomGroup], list[str]]:  # noqa: ANN401
    """Return the groups that become bodies, in the model's order, and the names of moving bodies without contacts."""
    labels = [name or f"{kind_of(model, g)} {g}" for g, name in enumerate(rules.names)]
    of_body: dict[int, list[int]] = {}
    for g in np.flatnonzero(rules.colliding).tolist():
        of_body.setdefault(int(model.geom_bodyid[g]), []).append(g)
    moving = [g for b, geoms in of_body.items() for g in geoms if owners.owner[b] != STILL]
    joined = {int(model.jnt_bodyid[j]) for j in owners.joints}
    jointed = joined | {int(owners.owner[model.body_parentid[b]]) for b in joined}  # each end of a joint
    found, empty = [], []
    for b in range(int(model.nbody)):
        if owners.owner[b] == b and b != STILL:
            bodies = owners.of(b)
            geoms = [g for each in bodies for g in of_body.get(each, [])]
            if geoms or b in jointed:
                found.append(GeomGroup(_called(owners, rules, b, geoms), bodies, geoms, False))
            else:
                empty.append(owners.names[b])
        elif owners.owner[b] == STILL:
            for geoms in _fixed_groups(model, rules, b, of_body.get(b, []), moving):
                single = b == 0 or len(geoms) != len(of_body[b])
                found.append(
                    GeomGroup(labels[geoms[0]] if single else _called(owners, rules, b, geoms), [b], geoms, True)
                )
    names = unique(group.name for group in found)
    return [group._replace(name=name) for group, name in zip(found, names, strict=True)], empty


def free_joints(model: Any, data: Any, *, rigid: bool) -> dict[str, list[int]]:  # noqa: ANN401
    """Return the numbers of the free joints that move with each movable body of ``from_mujoco``, by its name."""
    groups, _ = _groups(model, mobility.find_groups(model, data, rigid=rigid), GeomRules(model))
    joints = {int(model.jnt_bodyid[j]): j for j in range(int(model.njnt)) if model.jnt_type[j] == FREE}
    return {g.name: [joints[b] for b in g.bodies if b in joints] for g in groups if not g.fixed}


def _fixed_groups(model: Any, rules: GeomRules, b: int, geoms: list[int], moving: list[int]) -> list[list[int]]:  # noqa: ANN401
    """Divide the geoms of a fixed body among bodies of the scene.

    Planes and geoms of the world are separate; others are together if they may touch the same moving geoms.
    """
    alone = [[g] for g in geoms if b == 0 or model.geom_type[g] == PLANE]
    others = [g for g in geoms if [g] not in alone]
    alike: dict[bytes, list[int]] = {}
    for g, row in zip(others, rules.touching(others, moving), strict=True):
        alike.setdefault(row.tobytes(), []).append(g)
    return sorted(alone + list(alike.values()))


def _called(owners: BodyOwners, rules: GeomRules, b: int, geoms: list[int]) -> str:
    """Return the name of a body: its own, that of its only geom if it has none, or else its number."""
    only = rules.names[geoms[0]] if len(geoms) == 1 else ""
    return only if only and b not in owners.named else owners.names[b]


def _body(model: Any, data: Any, group: GeomGroup, rules: GeomRules, motors: Motors) -> Body:  # noqa: ANN401
    home = mobility.frame_of(data, group.bodies[0])
    if not group.geoms:
        return motors.ball(group.name, home, mobility.inertia_of(model, data, group.bodies))
    if group.fixed and len(group.geoms) == 1 and group.bodies[0] == 0:
        geom = _collider(model, data, group.geoms[0], 0, rules)
        return body_of(group.name, home @ geom.pose, [geom._replace(pose=np.eye(4))])
    geoms = [_collider(model, data, g, group.bodies[0], rules) for g in group.geoms]
    return body_of(group.name, home, geoms, None if group.fixed else mobility.inertia_of(model, data, group.bodies))


def _collider(model: Any, data: Any, g: int, home: int, rules: GeomRules) -> BodyPiece:  # noqa: ANN401
    """Return a geom in the frame of the body of the model, ``home``, whose frame its body of the scene has."""
    pose, b = pose_of(model, g), int(model.geom_bodyid[g])
    if b != home:
        pose = mobility.carried(model, data, b, home) @ pose
    plane = model.geom_type[g] == PLANE
    shape = HalfSpace() if plane else solid_of(model, g)
    return BodyPiece(shape, pose, rules.materials[rules.of[g]], g)


def _left_out(model: Any, rules: GeomRules, empty: list[str]) -> list[str]:  # noqa: ANN401
    """Return notes on what the model has and the scene lacks."""
    notes = []
    seen = int((~rules.colliding).sum())
    if seen:
        notes.append(f"left out: {seen} geoms that collide with nothing")
    if empty:
        notes.append(f"left out, as no geom of theirs collides: {listed(empty)}")
    used = rules.colliding
    if (np.asarray(model.geom_type)[used] == MESH).any():
        notes.append("meshes are their convex hulls, as MuJoCo collides them")
    if (np.asarray(model.geom_margin)[used] > 0).any():
        notes.append("ignored: margins, at which MuJoCo's contacts begin before surfaces touch")
    if max([0, *np.asarray(model.geom_condim)[used].tolist(), *np.asarray(model.pair_dim).tolist()]) > MOST_CONDIM:
        notes.append("ignored: torsional and rolling friction (condim 4 and 6), so bodies hold less than in MuJoCo")
    if rules.sliding:
        notes.append("pairs with two coefficients of sliding friction: the smaller one is taken")
    return notes


def _unread(model: Any, data: Any, owners: BodyOwners, motors: bool) -> list[str]:  # noqa: ANN401
    """Return notes on what acts on bodies in MuJoCo, but not in the scene.

    Equality constraints, tendons, gravity compensation and soft bodies are not among it: if they act on a moving body,
    the model is refused or the body is held (mobility.py). Sensors, keyframes, custom data and visual elements have
    no effect.
    """
    moves, names = owners.owner != STILL, owners.names

    jointed = {int(model.jnt_bodyid[j]) for j in owners.joints}  # what acts along their joints is read with the motors

    def moving(bodies: Any, *, along: bool = False) -> list[int]:  # noqa: ANN401 - numbers of bodies
        return [int(b) for b in bodies if moves[b] and not (along and b in jointed)]

    def set_of_geoms(field: str) -> list[int]:  # some versions of MuJoCo lack it
        return [int(model.geom_bodyid[g]) for g in np.unique(np.nonzero(getattr(model, field, ()))[0])]

    kind, target = np.asarray(model.actuator_trntype), np.asarray(model.actuator_trnid).reshape(-1, 2)[:, 0]
    sticky = np.nonzero(getattr(model, "pair_adhesion", ()))[0]  # some versions lack it
    pairs = np.asarray(model.geom_bodyid)[np.asarray(model.pair_geom1)[sticky]].tolist() if len(sticky) else []
    springs = [np.nonzero(getattr(model, field, ()))[0] for field in ("jnt_stiffness", "jnt_stiffnesspoly")]
    drawn: list[int] = []  # bodies whose joints a tendon with a spring connects
    for t in np.flatnonzero(model.tendon_stiffness).tolist():
        wraps = range(int(model.tendon_adr[t]), int(model.tendon_adr[t] + model.tendon_num[t]))
        drawn += [int(model.jnt_bodyid[model.wrap_objid[w]]) for w in wraps if model.wrap_type[w] == WRAP_JOINT]
    found = [
        ("moving surfaces (surfacevel)", set_of_geoms("geom_surfacevel")),
        ("adhesion", [*set_of_geoms("geom_adhesion"), *pairs, *target[kind == BODY].tolist()]),
        ("actuators that push", moving(np.asarray(model.site_bodyid)[target[kind == SITE]])),
        (
            "actuators of joints",
            [] if motors else moving(np.asarray(model.jnt_bodyid)[target[np.isin(kind, (JOINT, IN_PARENT))]]),
        ),
        ("plugins", moving(np.flatnonzero(np.asarray(model.body_plugin) >= 0))),
        ("applied forces (xfrc_applied)", moving(np.unique(np.nonzero(data.xfrc_applied)[0]))),
        (
            "applied forces (qfrc_applied)",
            moving(np.asarray(model.dof_bodyid)[np.flatnonzero(data.qfrc_applied)], along=True),
        ),
        ("springs of tendons", moving(drawn, along=True)),
        ("springs of joints", moving(np.asarray(model.jnt_bodyid)[np.unique(np.concatenate(springs))], along=True)),
    ]
    each = [(what, listed([quoted(names[b]) for b in dict.fromkeys(bodies)])) for what, bodies in found if bodies]
    notes = [f"ignored, though it acts: {what} of {who}" for what, who in each]
    windy = bool(np.asarray(model.opt.wind).any()) and model.opt.density > 0
    return [*notes, *(["ignored, though it acts: wind"] if windy else [])]


def _overlaps(data: Any, groups: Sequence[GeomGroup], bodies: Sequence[Body]) -> list[str]:  # noqa: ANN401
    """Return a note on the contacts in which bodies overlap much according to MuJoCo, if there are any."""
    of = {g: body for group, body in zip(groups, bodies, strict=True) for g in group.geoms}
    deepest: dict[tuple[str, str], float] = {}
    geoms, depths = np.asarray(data.contact.geom).reshape(-1, 2), -np.asarray(data.contact.dist).ravel()
    for (g, h), depth in zip(geoms[depths > 0].tolist(), depths[depths > 0].tolist(), strict=True):
        size = min((of[k].size for k in (g, h) if k in of and not of[k].fixed), default=np.inf)
        if g in of and h in of and depth > SEEN * size:
            pair = (of[g].name, of[h].name)
            deepest[pair] = max(depth, deepest.get(pair, 0.0))
    if not deepest:
        return []
    pairs = sorted(deepest, key=lambda pair: -deepest[pair])
    pairs_text = listed([f"{quoted(a)} and {quoted(b)} by {deepest[a, b] * 1e3:.3g} mm" for a, b in pairs], 4)
    gap = f"{1.1 * deepest[pairs[0]]:.2g}"
    remedy = f"step the model to rest and take hf.from_mujoco(model, data), or assemble with gap={gap}"
    return [f"bodies overlap: {pairs_text}; {remedy}"]
