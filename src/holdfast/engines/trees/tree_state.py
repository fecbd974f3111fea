"""Answers of bodies that hang on their support by plane contacts, one behind the other; an engine answers the rest.

The bodies that trees leave open, such as a ball on a shelf, are an assembly of their own on those that stand.

How the load at which a tree gives way changes with all that it depends on follows from the implicit function theorem. A
load gives way where F = 0: the friction asked for along the motion m less its power, or how far the centre of pressure
is beyond an edge of the hull. Both are functions of what the contact carries and of its faces, so the factor R of the
load changes by dR = -dF / (∂F/∂R). As a function of what acts on the bodies beyond, F changes like the power in a
``twist`` of them, which is not their motion alone: the pressure, too, follows what is carried, and friction it. The
faces lie halfway between the two bodies: the plane moves with half the motion of each, and each edge of a face, which
is one of either body, with half the motion of that body against the other (node_motion.py says when).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.node_motion import edges_of_second
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.rigid import cross
from holdfast.base.values import altered
from holdfast.engines.answers import Answers, Bound, Step, joined
from holdfast.engines.contract import EXACT, Accuracy, Engine, Loadable, Slope, State, fresh, held_by
from holdfast.engines.mechanism import Kinematics, Mechanism, Mode, describe_all
from holdfast.engines.rest import corner_nodes, find_rest
from holdfast.engines.trees.forest import Bridge, Exit, Forest, forest_of
from holdfast.engines.verdict import ContactForces, Look, Status, Verdict
from holdfast.native import core

GAUSS = np.polynomial.legendre.leggauss(12)  # along each edge
CORNER = 1e-6  # distance from an edge of the hull, in sizes of the contact, up to which a corner is on it


def slope_of(forest: Forest, load: Float) -> Slope | None:
    """Return the derivatives of the factor of ``load`` (6J,), which loads only bodies that are decided.

    None where they are not known: if nothing gives way, several contacts or edges do at once, or it lies between faces
    of several bodies or coefficients.
    """
    found = forest.exits(load[:, None])
    number, factor = int(found.bridge[0]), float(found.factor[0])
    if number < 0 or not 0 < factor < np.inf or found.tied[0]:
        return None
    bridge, assembly = forest.bridges[number], forest.assembly
    pairs = {assembly.interfaces[k].bodies for k in bridge.interfaces}
    if len(pairs) > 1 or not bridge.bed.size[1] > 0:
        return None
    # which edges (E,) of the bed are those of the second body, 1, the first, -1, or both, 0
    contacts = [assembly.interfaces[k] for k in bridge.interfaces]
    middles = bridge.origin + (bridge.bed.edges[:, :2] + bridge.bed.edges[:, 2:4]) / 2 @ bridge.frame[:2]
    into = 1.0 if assembly.ends[bridge.interfaces[0]][0] == bridge.root else -1.0
    normals = np.broadcast_to(into * bridge.frame[2], middles.shape)
    of_second = edges_of_second(assembly, contacts, middles, _outward(bridge), normals)
    owners = None if of_second is None else of_second.sum(axis=0) - 1
    if owners is None:
        return None
    wrenches = np.stack([forest.wrench + factor * load, load]).reshape(2, -1, 6)
    limit, alone = bridge.carried(assembly.com, wrenches)
    law = _slides(bridge, limit) if found.slides[0] else _tips(bridge, limit)
    if law is None:
        return None
    by_carried, by_mu, edges, places, by_edges = law
    scale = float(by_carried @ alone)
    frame, g = bridge.frame, by_carried
    spin = np.array([-g[2], g[1], -g[5]]) @ frame
    velocity = np.array([-g[3], -g[4], -g[0]]) @ frame - cross(spin, bridge.origin)
    own, at = wrenches[0, bridge.beyond], assembly.com[bridge.beyond]
    force, torque = own[:, :3].sum(0), (own[:, 3:] + cross(at, own[:, :3])).sum(0)
    plane = np.concatenate([cross(spin, force), cross(velocity, force) + cross(spin, torque)])
    return Slope(
        factor=factor,
        assembly=assembly,
        pair=next(iter(pairs)),
        beyond=bridge.beyond,
        twist=np.concatenate([velocity, spin]) / scale,
        by_friction=-by_mu / scale,
        by_plane=-plane / scale,
        by_edges=-by_edges / scale,
        places=bridge.origin + places @ bridge.frame[:2],
        outward=_outward(bridge)[edges],
        owners=owners[edges],
    )


# derivatives of F by what is carried (6,) and by μ; then numbers of edges (n,), places on them (n, 2), and the
# derivatives by how far these move outwards (n,)
Law = tuple[Float, float, Int, Float, Float]


def _slides(bridge: Bridge, limit: Float) -> Law | None:
    """Return the derivatives of the friction asked for less its power, where a contact slides under ``limit`` (6,)."""
    bed = bridge.bed
    found = core.sliding_under(bed, limit)
    if found is None:
        return None
    pressure_of, motion, by_carried, power = found
    mu, parts = float(bed.size[1]), core.pressed_parts(bed, pressure_of)
    share, heads, tails = (GAUSS[0][:, None, None] + 1) / 2, parts[:, :2], parts[:, 2:]
    x = heads + share * (tails - heads)  # (12, E, 2)
    length = np.linalg.norm(tails - heads, axis=1)
    pressure = np.maximum(pressure_of[0] + x @ pressure_of[1:], 0.0)
    speed = np.hypot(motion[0] - motion[2] * x[..., 1], motion[1] + motion[2] * x[..., 0])
    density = pressure * (by_carried[0] + x @ by_carried[1:] - mu * speed)
    weights = GAUSS[1][:, None] / 2 * density * length
    edges = np.tile(np.arange(len(heads)), len(x))
    return np.concatenate([-by_carried, motion]), -power / mu, edges, x.reshape(-1, 2), weights.ravel()


def _tips(bridge: Bridge, limit: Float) -> Law | None:
    """Return the derivatives of N times how far the centre of pressure is beyond the edge that it reaches."""
    bed = bridge.bed
    row = bed.hull[np.argmin(bed.hull @ limit[:3])]
    heads = bed.edges[:, :2]
    on = np.flatnonzero(row[0] + heads @ row[1:] <= CORNER * bed.size[0])
    along = heads[on] @ np.array([row[2], -row[1]])
    first, last = on[np.argmin(along)], on[np.argmax(along)]
    span = np.ptp(along)
    if not span > CORNER * bed.size[0]:
        return None
    place = (limit[1:3] / limit[0] @ np.array([row[2], -row[1]]) - along.min()) / span
    outward = _outward(bridge) @ bridge.frame[:2].T
    edges, weights = list[int](), list[float]()
    for corner, share in ((first, 1 - place), (last, place)):
        before = int(np.flatnonzero((bed.edges[:, 2:4] == heads[corner]).all(axis=1))[0])
        each = np.linalg.lstsq(outward[[before, corner]].T, -row[1:], rcond=1e-9)[0]
        edges += [before, int(corner)]
        weights += (-limit[0] * share * each).tolist()
    at = heads[[first, first, last, last]]
    return np.concatenate([-row, np.zeros(3)]), 0.0, np.array(edges), at, np.array(weights)


def _outward(bridge: Bridge) -> Float:
    """Return the normals (E, 3), in the plane, that point out of the faces at their edges."""
    along = bridge.bed.edges[:, 2:4] - bridge.bed.edges[:, :2]
    flat = np.column_stack([along[:, 1], -along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    return np.asarray(flat @ bridge.frame[:2])


def left_over(forest: Forest) -> tuple[Assembly, Int] | None:
    """Return the bodies that are not ``forest.decided``, on decided ones that are fixed, and their numbers (K,).

    None unless all their contacts are bridges. Then equilibrium alone says what each of them carries, so that whether
    they rest does not depend on how soft those are that stand beneath them.
    """
    whole, open_ = forest.assembly, np.flatnonzero(~forest.decided)
    of_open = set(open_.tolist())
    contacts = [k for k, ends in enumerate(whole.ends) if not of_open.isdisjoint(ends)]
    if whole.scene.holds or not set(forest.cuts.interfaces.tolist()).issuperset(contacts):
        return None
    names = {whole.movable[k].name for k in of_open}
    touched = {name for k in contacts for name in whole.interfaces[k].bodies}
    bodies = tuple(
        body if body.fixed or body.name in names else altered(body, fixed=True)
        for body in whole.bodies
        if body.name in touched
    )
    fixed = {k for k in range(FIXED, len(whole.movable)) if k not in of_open}
    interfaces = tuple(
        whole.interfaces[k].flipped() if whole.ends[k][1] in fixed else whole.interfaces[k] for k in contacts
    )
    scene = altered(whole.scene, bodies=bodies, excluded=())
    part = Assembly(scene, interfaces, whole.tolerances, detected=False, absent=whole.known_names)
    part.__dict__["axes"] = whole.axes
    return part, open_


RESTS = "every contact on the way to the support presses and has friction to spare"
NAME = "contacts on the way to the support"
FIRM = Verdict(
    status=Status.STABLE, reason=RESTS, equilibrium_exists=True, self_stress=False, steps=(Look(NAME, RESTS),)
)
MOST_TOLD = 30  # rows of one answer of which it is said what gives way; who asks for more reads none
WHY = "equilibrium alone says what each carries; an even bed says what it can"


def with_trees(engine: Engine, assembly: Assembly, standing: Float | None, acceleration: Float | None) -> State:
    """Prepare ``engine``, whose place trees take where they decide and it ``takes_trees``; see ``Engine.prepare``."""
    if getattr(engine, "takes_trees", False) and not assembly.hanging:
        wrench = assembly.weight_wrench(acceleration)
        forest = forest_of(assembly, wrench if standing is None else wrench + standing)
        if forest.decided.any():
            return TreeState(forest, engine, standing, acceleration)
    return engine.prepare(assembly, standing, acceleration)


@dataclass(frozen=True, eq=False)
class TreeState:
    """An assembly in which plane contacts that are bridges (forest.py) decide what some loads move.

    The ``engine`` answers for the other loads; ``standing`` and ``acceleration`` are as in ``Engine.prepare``.
    """

    forest: Forest
    engine: Engine
    standing: Float | None
    acceleration: Float | None

    @cached_property
    def behind(self) -> State:
        """The state of the engine that answers for loads that no tree decides, prepared when it is first asked."""
        return self.engine.prepare(self.forest.assembly, self.standing, self.acceleration)

    def fresh(self) -> TreeState:
        """Return the same state as it was before it was asked anything."""
        other = TreeState(self.forest, self.engine, self.standing, self.acceleration)
        if "behind" in self.__dict__:
            other.__dict__["behind"] = fresh(self.behind)
        return other

    @cached_property
    def _verdict_found(self) -> Verdict:
        """The verdict of trees where they tell that all stands, else that of the engine."""
        verdict = FIRM if self.forest.decided.all() else self.judge()
        if verdict is None or verdict.status is not Status.STABLE:
            return self.behind.verdict()
        return verdict.with_evidence(
            lambda: self._balanced.forces, lambda: self._balanced.residual, lambda: self._balanced.self_stress
        )

    def judge(self) -> Verdict | None:
        """Ask the engine whether the bodies stand that are not decided, on the others; None if it depends on these."""
        found = left_over(self.forest)
        if found is None:
            return None
        part, members = found
        own = None if self.standing is None else self.standing.reshape(-1, 6)[members].ravel()
        return self.engine.prepare(part, own, self.acceleration).verdict()

    @cached_property
    def _balanced(self) -> Verdict:
        """A verdict with forces: those on elastic contacts or, where these do not come to rest, any in balance."""
        found = self.behind.verdict()
        if found.status is Status.STABLE:
            return found
        return find_rest(self.forest.assembly, self.forest.wrench).verdict

    def verdict(self) -> Verdict:
        """Say whether the assembly stands under its weight and the standing loads."""
        return self._verdict_found

    @property
    def notes(self) -> tuple[str, ...]:
        """No notes but those of the engine, if it was asked."""
        return self.behind.notes if "behind" in self.__dict__ else ()

    def _by_trees(self, W: Float) -> Bool:
        """Tell which columns of W (6J, n) load only bodies that trees decide."""
        loaded = (W.reshape(-1, 6, W.shape[1]) != 0).any(axis=1)
        return np.asarray(~loaded[~self.forest.decided].any(axis=0))

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        """Find the largest factor of each column of W (6J, n) before something moves: exactly, where trees decide."""
        verdict = self.verdict()
        if verdict.status is not Status.STABLE:
            return Answers.not_standing(W.shape[1], engine=self.engine.name, claim=self.engine.claim, verdict=verdict)
        mine = np.flatnonzero(self._by_trees(W))
        found = self.forest.exits(W[:, mine])
        known = np.isfinite(found.lower) | np.isinf(found.factor)
        mine, found = mine[known], found.rows(known)
        others = np.setdiff1d(np.arange(W.shape[1]), mine)
        parts = [self._answers_by_trees(found, verdict, W[:, mine])] if len(mine) or not len(others) else []
        parts += [self.behind.load_factor(W[:, others], accuracy)] if len(others) else []
        whole = joined(parts) if len(parts) > 1 else parts[0]
        return whole if not len(mine) or not len(others) else whole.rows(np.argsort(np.concatenate([mine, others])))

    def _answers_by_trees(self, found: Exit, verdict: Verdict, W: Float) -> Answers:
        """Return the table of loads that trees decide."""
        finite = np.isfinite(found.factor)
        said = self.forest.how_each_ends(found, W) if len(finite) <= MOST_TOLD else ()
        return Answers.of(
            engine=self.engine.name,
            claim=self.engine.claim,
            verdict=verdict,
            force=found.factor,
            lower=found.lower,
            status=[Status.FINITE if one else Status.INFINITE for one in finite],
            mechanism=self._mechanisms(found),
            lower_bound=Bound.PROVED if found.proved.all() else Bound.ESTIMATED,
            steps=(Step(NAME, WHY, found.factor, found.lower, said),),
        )

    @cached_property
    def _kinematics(self) -> Kinematics:
        return Kinematics.of(self.forest.assembly, corner_nodes(self.forest.assembly))

    def _mechanisms(self, found: Exit) -> list[Mechanism | None]:
        """Return how what is behind the contact that gives way begins to move; None where none does."""
        com, result = self.forest.assembly.com, list[Mechanism | None]([None] * len(found.factor))
        for number in np.unique(found.bridge[found.bridge >= 0]).tolist():
            bridge, rows = self.forest.bridges[number], np.flatnonzero(found.bridge == number)
            twists = np.zeros((len(rows), len(com), 6))
            turn = found.twist[rows, None, 3:]
            twists[:, bridge.beyond, :3] = found.twist[rows, None, :3] + np.cross(turn, com[bridge.beyond])
            twists[:, bridge.beyond, 3:] = turn
            twists[np.ix_(np.flatnonzero(found.slides[rows]), self.forest.left_behind(bridge))] = 0
            modes: list[Mode] = ["slip" if found.slides[row] else "topple" for row in rows.tolist()]
            for row, one in zip(rows.tolist(), describe_all(self._kinematics, twists, modes, dual=False), strict=True):
                result[row] = one
        return result

    def held(self, W: Float) -> Bool:
        """Tell which loads, columns of W (6J, n), certainly move nothing; False where that is not known."""
        held, mine = np.zeros(W.shape[1], dtype=bool), self._by_trees(W)
        if self.verdict().status is not Status.STABLE:
            return held
        held[mine] = self.forest.exits(W[:, mine]).lower > 1
        held[~mine] = held_by(self.behind, W[:, ~mine])
        return held

    def slope(self, load: Float) -> Slope | None:
        """Return the derivatives of the largest factor of ``load`` (6J,), None where no tree decides it."""
        return slope_of(self.forest, load) if self._by_trees(load[:, None])[0] else None

    def forces_under(self, load: Float) -> ContactForces | None:
        """Return the contact forces under ``load`` (6J,), or None if the engine does not know them."""
        return self.behind.forces_under(load) if isinstance(self.behind, Loadable) else None
