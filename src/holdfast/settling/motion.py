"""The quasi-static motion of one group of bodies to rest: overlaps are removed, then gravity and friction act."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.progress import report
from holdfast.contacts.overlap import Overlap
from holdfast.scene.body import Body
from holdfast.scene.excluded import body_of
from holdfast.scene.scene import Scene
from holdfast.settling.moved_surfaces import Posed, pairs_near
from holdfast.settling.near_points import FacePairs, NearPoints, near_points
from holdfast.settling.settling_program import LEFT, StepContacts, slips, small_motion

# Lengths are relative to ``MotionLimits.reach``, so that the motion does not depend on the unit of length.
STRIDE = 0.033  # largest motion of a point in one step
FIRST = 0.027  # motion of a free body in the first step
WIDE = 2.5  # [strides] distance up to which surfaces take part in a step
NARROW = STRIDE / 5  # least stride for which contacts are searched
EAGER = 4.0  # factor by which gravity is increased if bodies move slowly, and largest growth of a stride over a motion
STRONGEST = EAGER**5  # largest total factor of gravity; a group is at rest only if nothing moves under it
NOTHING = 1e-6  # a body whose motion, relative to the largest one allowed in the step, is smaller stays where it is
STILL = STRIDE / 1000  # bodies are at rest if no point moves more in a step under the strongest gravity
TOUCH = STRIDE / 200  # distance or depth up to which surfaces may support a body at rest; larger overlaps are removed
CALM = STRIDE / 10  # after a step in which no point moves more, it is tested whether the bodies are at rest
POLISH = 4  # largest number of further steps at rest, in which a balancing body comes nearer to its equilibrium
SHRINKING = 0.6  # these steps end if a motion is larger than TOUCH and than this share of the one before
RESTING = WIDE * NARROW  # distance up to which surfaces are considered in the test for rest

FLUNG = 2.0  # [depths of the deepest overlap] if removing overlaps needs larger motions, they are allowed to yield
YIELDING = 3.0  # force at which overlaps then yield, in weights of the heaviest body at that depth
UNDOING = 12  # largest number of steps that remove overlaps
STEPS = 150  # largest number of steps under gravity
EFFORT = 1_000_000  # largest number of contacts in all cone programs of a group, about two minutes
BALL = 0.4  # moment of inertia of a ball over its mass and squared radius
BACK = 0.5  # a motion reverses if its cosine to the one before is below -BACK; then only half of it is made
RECOVERY = 1.2  # factor by which that share grows again in a step that does not reverse
SPREAD = 1e-3  # [m] standard deviation of a position at which the weight of a body is its mass


class End(Enum):
    """How the motion of a group ended."""

    REST = "nothing moves"
    LEFT = "a body leaves the reach"
    APART = "a body that it may overlap leaves the reach"
    GOING = "the bodies still move after 150 steps"
    EFFORT = "the bodies still move after programs with a million contacts together"
    TROUBLE = "a step has no solution"


@dataclass(frozen=True)
class MotionLimits:
    """How far a body may move: its centre of mass by ``reach`` [m], and its orientation by ``turn`` [deg]."""

    reach: float
    turn: float


@dataclass(frozen=True, eq=False)
class Motion:
    """The result for a group: its ``bodies``, movable ones first, how the motion ``end``-ed, and the number of steps.

    ``pushed`` (J, 3) [m] is the part of the displacements that removed overlaps. ``left`` holds the numbers of the
    bodies that moved beyond the limits, ``going`` (J, 3) [m] the motions of the centres of mass in the last step, and
    ``contacts`` the near points at the end.
    """

    bodies: tuple[Posed, ...]
    end: End
    steps: int
    pushed: Float
    left: tuple[int, ...]
    going: Float
    contacts: StepContacts


def come_to_rest(
    scene: Scene,
    names: Sequence[str],
    limits: MotionLimits,
    *,
    known: frozenset[str],
    sigma: Mapping[str, float],
    overlaps: Sequence[Overlap],
    smooth: bool = False,
) -> Motion:
    """Bring the movable bodies with these ``names`` to rest among each other and the fixed bodies of the scene.

    Bodies in ``known`` do not move while overlaps are removed. ``sigma`` [m] are the standard deviations of the
    positions of bodies; while overlaps are removed, bodies move in proportion to their squares. ``overlaps`` are those
    that are deeper than RESTING times the reach. If ``smooth``, the bodies first sink without friction, so that none of
    them gets stuck.
    """
    group = Group(scene, names, TOUCH * limits.reach)
    if not overlaps and not smooth and group.at_rest(limits.reach):
        return group.report(End.REST, 0, np.zeros((group.count, 3)), np.zeros((group.count, 3)), limits)
    weight = np.array([np.inf if n in known else (SPREAD / sigma.get(n, SPREAD)) ** 2 for n in names])
    steps = _undo_overlaps(group, weight, overlaps, limits)
    pushed = np.array([posed.moved for posed in group.bodies[: group.count]])
    if group.beyond(limits):
        return group.report(End.APART, steps, pushed, np.zeros((group.count, 3)), limits)
    if smooth:
        group.rough = False
        _, sunk, _ = _sink(group, limits)
        steps, group.rough = steps + sunk, True
    if steps and not group.beyond(limits) and group.at_rest(limits.reach):
        return group.report(End.REST, steps, pushed, np.zeros((group.count, 3)), limits)
    end, sunk, going = _sink(group, limits)
    return group.report(end, steps + sunk, pushed, going, limits)


def _undo_overlaps(group: Group, weight: Float, overlaps: Sequence[Overlap], limits: MotionLimits) -> int:
    """Try to remove ``overlaps`` and shallower ones by least motions; return the steps taken, also if some remain.

    ``weight`` (J,) is the cost of moving each body; bodies with an infinite weight do not move. The common volume of
    overlapping bodies is computed in every step until they are apart.
    """
    margin = max(WIDE * FIRST * limits.reach, 1.5 * max((o.depth for o in overlaps), default=0.0))
    group.overlapping = {frozenset(o.bodies) for o in overlaps}
    for step in range(UNDOING):
        contacts = group.contacts(margin)
        deep = contacts.gaps < -TOUCH * limits.reach
        if not deep.any():
            group.overlapping.clear()
            return step
        group.overlapping |= {frozenset(group.bodies[k].start.name for k in pair) for pair in contacts.ends[deep]}
        motion = group.undoing(contacts, weight)
        if motion is None or group.apply(motion, limits.reach / 2) < STILL * limits.reach:
            return step
        margin = max(min(-2 * float(contacts.gaps.min()), margin), NARROW * limits.reach)
    return UNDOING


def _sink(group: Group, limits: MotionLimits) -> tuple[End, int, Float]:
    """Let the bodies sink, slide and tip; return how it ended, the number of steps, and the last motions (J, 3) [m]."""
    stride, eager, damped = FIRST * limits.reach, 1.0, 1.0
    last = made = np.zeros((group.count, 6))
    going = np.zeros((group.count, 3))
    calm, travelled = 0, np.inf
    rest: list[Body] = []
    for step in range(STEPS):
        report("settling", step, STEPS)
        contacts = group.sliding(group.contacts(_margin(stride, limits)), made, TOUCH * limits.reach, stride)
        motion = group.sinking(contacts, stride, eager, made)
        if motion is None:
            return End.TROUBLE, step, going
        back = float((motion * last).sum()) < -BACK * float(np.linalg.norm(motion) * np.linalg.norm(last))
        damped, last = (damped / 2 if back else min(1.0, RECOVERY * damped)), motion
        before = group.centres()
        travelled, before_that = group.apply(damped * motion, stride), travelled
        made = motion * (travelled / max(group.farthest(motion), 1e-300))
        going = group.centres() - before
        if group.beyond(limits):
            return End.LEFT, step + 1, going
        if calm and not group.at_rest(limits.reach):  # the last step left the state of rest
            group.place(rest)
            return End.REST, step + 1, going
        calm = calm + 1 if travelled < CALM * limits.reach and (calm or group.at_rest(limits.reach)) else 0
        if calm > POLISH or (calm > 1 and travelled > max(SHRINKING * before_that, TOUCH * limits.reach)):
            return End.REST, step + 1, going
        rest = [posed.body for posed in group.bodies]
        if back:
            eager = max(eager / EAGER, 1.0)
        elif travelled < stride / 2:
            eager = min(EAGER * eager, STRONGEST)
        if group.effort > EFFORT:
            return End.EFFORT, step + 1, going
        stride = float(np.clip(EAGER * travelled, NARROW * limits.reach, STRIDE * limits.reach))
    return End.GOING, STEPS, going


def _margin(stride: float, limits: MotionLimits) -> float:
    """Return the distance [m] up to which surfaces take part in a step of ``stride`` [m].

    It is one of a few values, so that near points can be reused.
    """
    widest = WIDE * STRIDE * limits.reach
    return float(widest * 0.5 ** np.floor(np.log2(widest / (WIDE * stride))))


class Group:
    """A group of bodies that may touch, and their current poses.

    The first ``count`` of ``bodies`` are movable. Friction acts if ``rough``. ``effort`` is the number of contacts in
    all cone programs so far.
    """

    def __init__(self, scene: Scene, names: Sequence[str], least: float) -> None:
        self.scene, self.count = scene, len(names)
        fixed = [body for body in scene.bodies if body.fixed]
        self.bodies = [Posed(body) for body in [*(scene.body(name) for name in names), *fixed]]
        self.excluded = frozenset(frozenset(map(body_of, pair)) for pair in scene.excluded)
        movable = [posed.start for posed in self.bodies[: self.count]]
        mass = np.array([body.mass for body in movable], dtype=float)
        self.levers = np.array([posed.radius for posed in self.bodies[: self.count]])
        self.share = mass / mass.max()
        self.rough, self.effort = True, 0
        self.overlapping: set[frozenset[str]] = set()
        self.least = least
        self._faces: defaultdict[tuple[int, int], FacePairs] = defaultdict(FacePairs)
        self._near: dict[tuple[int, int], tuple[Body, Body, float, NearPoints]] = {}

    def contacts(self, margin: float) -> StepContacts:
        """Find all near points up to ``margin`` apart or into each other [m].

        The two limits are equal, so that a thin wall is always found from its nearer side, too.
        """
        found: list[tuple[int, int, float, NearPoints]] = []
        for i, j in pairs_near(self.bodies, margin, self.excluded):
            near = self._near_points(i, j, margin)
            rough = min(self.scene.mu(self.bodies[i].start.name, self.bodies[j].start.name), 1e3)
            found.append((i, j, rough, near))
        sizes = [len(near.gaps) for *_, near in found]
        ends = np.repeat(np.array([f[:2] for f in found], dtype=int).reshape(-1, 2), sizes, axis=0)
        points, normals = (np.concatenate([np.empty((0, 3)), *(f[3][k] for f in found)]) for k in (0, 1))
        gaps = np.concatenate([np.empty(0), *(f[3].gaps for f in found)])
        mu = np.repeat([f[2] for f in found], sizes)
        chosen = np.concatenate([np.empty(0, dtype=bool), *(f[3].chosen for f in found)])
        return StepContacts(ends, self.count, points, normals, gaps, mu, chosen)

    def _near_points(self, i: int, j: int, margin: float) -> NearPoints:
        """Return the near points of two bodies, from the cache if neither has moved since."""
        a, b = self.bodies[i], self.bodies[j]
        known = self._near.get((i, j))
        if known is None or known[0] is not a.body or known[1] is not b.body or known[2] != margin:
            pair = frozenset((a.start.name, b.start.name))
            overlapping = pair in self.overlapping
            near = near_points(a, b, self._faces[i, j], margin=margin, least=self.least, overlapping=overlapping)
            self._near[i, j] = known = (a.body, b.body, margin, near)
        return known[3]

    def centres(self) -> Float:
        """Return the centres of mass (J, 3) [m]."""
        return np.array([posed.body.com_world for posed in self.bodies[: self.count]])

    def _metric(self, weight: Float) -> Float:
        """Return the masses and inertias (J, 6) of the bodies, treated as balls, times ``weight`` (J,)."""
        return np.outer(weight * self.share, [1, 1, 1, BALL, BALL, BALL])

    def undoing(self, contacts: StepContacts, weight: Float) -> Float | None:
        """Return the least motions (J, 6) that remove all overlaps, or None; infinite ``weight`` (J,) fixes a body."""
        unit, pull = float(-contacts.gaps.min()), np.zeros(6 * self.count)
        metric = self._metric(np.minimum(weight, 1e9 * weight.min()))
        motion = self._solved(contacts, metric, pull, unit, friction=False)
        if motion is None or self.farthest(motion) > FLUNG * unit:
            motion = self._solved(contacts, metric, pull, unit, friction=False, giving=YIELDING)
        return motion

    def at_rest(self, reach: float) -> bool:
        """Tell whether nothing moves under gravity and friction if surfaces within TOUCH times ``reach`` [m] touch."""
        contacts = self.contacts(RESTING * reach)
        if len(contacts) and contacts.gaps.min() < -TOUCH * reach:
            return False
        touching = contacts.only(contacts.gaps < TOUCH * reach)
        motion = self.sinking(replace(touching, gaps=np.zeros(len(touching))), RESTING * reach, STRONGEST)
        return motion is not None and self.farthest(motion) < STILL * reach

    def sinking(self, contacts: StepContacts, stride: float, eager: float, before: Float | None = None) -> Float | None:
        """Return motions (J, 6) under gravity and friction, in which a free body sinks by ``eager * stride`` [m].

        If the motions ``before`` (J, 6) of the last step are given, they are found less exactly (``small_motion``).
        """
        pull = np.zeros((self.count, 6))
        pull[:, :3] = -eager * self.share[:, None] * self.scene.up
        weight = self._metric(np.ones(self.count))
        return self._solved(contacts, weight, pull.ravel(), stride, friction=self.rough, before=before)

    def _solved(
        self,
        contacts: StepContacts,
        metric: Float,
        pull: Float,
        unit: float,
        *,
        friction: bool,
        before: Float | None = None,
        giving: float | None = None,
    ) -> Float | None:
        """Return the motions (J, 6) of ``small_motion``, and add its contacts to ``effort``."""
        bodies = self.centres(), self.levers, metric, pull
        motion, solved = small_motion(contacts, *bodies, unit=unit, friction=friction, before=before, giving=giving)
        self.effort += solved
        return motion

    def sliding(self, contacts: StepContacts, before: Float, touch: float, stride: float) -> StepContacts:
        """Return the contacts of a step of ``stride`` [m], adjusted for bodies that keep falling or sliding.

        The cone g + n·v >= μ |t·v| drives sliding surfaces apart. A body between two walls could then fall in one step
        only by their distance over μ. But no force acts on surfaces that are more than ``touch`` [m] apart. These may
        slide as far as in the motions ``before`` (J, 6) with g + n·v >= 0 alone; the cone begins beyond that.
        """
        _, across = slips(contacts, self.centres(), before)
        room = contacts.mu * across
        loose = (contacts.gaps > touch) & (room > LEFT * stride)
        smooth = replace(contacts.only(loose), mu=np.zeros(int(loose.sum())))
        return replace(contacts, gaps=contacts.gaps + np.where(loose, room, 0.0)).with_(smooth)

    def apply(self, motion: Float, most: float) -> float:
        """Move the bodies by ``motion`` (J, 6), scaled down so that no point moves farther than ``most`` [m].

        Returns the largest distance [m] by which a point moved.
        """
        farthest = self.farthest(motion)
        share = min(1.0, most / max(farthest, 1e-300))
        for posed, twist, way in zip(self.bodies, share * motion, share * self._ways(motion), strict=False):
            if way > NOTHING * most:
                posed.move(twist[:3], twist[3:])
        return share * farthest

    def place(self, bodies: Sequence[Body]) -> None:
        """Put all bodies into the poses of ``bodies``."""
        for posed, body in zip(self.bodies, bodies, strict=True):
            if posed.body is not body:
                posed.place(body)

    def report(self, end: End, steps: int, pushed: Float, going: Float, limits: MotionLimits) -> Motion:
        """Return the result for the group."""
        contacts = self.contacts(RESTING * limits.reach)
        return Motion(tuple(self.bodies), end, steps, pushed, self.beyond(limits), going, contacts)

    def farthest(self, motion: Float) -> float:
        """Return the largest distance [m] by which a point moves."""
        return float(self._ways(motion).max())

    def _ways(self, motion: Float) -> Float:
        """Return for each body (J,) the largest distance [m] by which a point moves."""
        return np.asarray(np.linalg.norm(motion[:, :3], axis=1) + self.levers * np.linalg.norm(motion[:, 3:], axis=1))

    def beyond(self, limits: MotionLimits) -> tuple[int, ...]:
        """Return the numbers of the bodies that have moved beyond the limits."""
        movable = enumerate(self.bodies[: self.count])
        return tuple(k for k, p in movable if np.linalg.norm(p.moved) > limits.reach or p.turned > limits.turn)
