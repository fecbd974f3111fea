"""Watch a carrier that moves: each moment uses a share of what its load withstands.

The fixed bodies are the carrier. A motion, with gravity as it is now, differs from rest under the gravity of the scene
by loads d on the bodies (``transport.py``): the inertial ones, and those of the change of gravity. They are linear in
twelve numbers, of which six are products of angular velocities. For each group of bodies that touch each other the
default engine says up to which s everything stays at rest under s d, its ``lower``; 1/s is the share that is used. What
elastic contacts withstand is no convex set, so nothing is inferred from other directions: each is asked, once.
"""

from __future__ import annotations

import time
from collections import OrderedDict, deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holdfast.applications.transport import counted_bodies, motion_columns, motion_coordinates
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked, checked_number, checked_whole
from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.memory import Same
from holdfast.base.progress import reported
from holdfast.base.public import PublicValue, Summary, at_least, at_most
from holdfast.base.ranges import ACCELERATION, MANY, PLACE, SCALE, TURNING
from holdfast.base.text import listed
from holdfast.engines.answers import only_balanced
from holdfast.engines.groups import Groups, PreparedGroup, prepared
from holdfast.engines.mechanism import NAMED
from holdfast.engines.verdict import Status
from holdfast.queries import request
from holdfast.queries.request import CERTAIN_ENGINE, DEFAULT_ENGINE, Load
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene

STILL = 0.1  # share of the gap within which surfaces touch: a body that is displaced by less has not moved
LIKELY = (2.0, 2.0, 1.0)  # standard deviations of a [m/s²], α [rad/s²] and ω [rad/s], of motions asked in advance
ALIKE = 12  # digits to which directions agree that count as one: what scaling a motion leaves of them
REMEMBERED = 1000  # directions of which each group keeps the answers
RECENT = 9  # questions whose median time is what the next one is expected to take
AGAIN = 1.0  # [s] without a question, after which one is tried all the same: the machine may have been busy


class Monitored(PublicValue, ask=".holds or .margin"):
    """How much of what it withstands a moment of a motion leaves to a load.

    ``margin`` is the share that is left: 1 at rest under the gravity of the scene, 0 where it is not known that
    everything stays at rest. With the margin m, all that differs from rest may be 1 / (1 - m) times as large before it
    exceeds the ``lower`` of the default engine. ``upper`` is the share above which the margin is proved not to be; it
    is asked for where the margin is 0. ``status`` is STABLE where the margin is above 0, UNSTABLE where something is
    proved to move, and else UNDECIDED. ``moving`` holds the names of the bodies that move first if the motion becomes
    harder, as far as known.

    ``seconds`` [s] is the time that the answer took. ``late`` says that it took longer than it should, or that there
    was no time to ask about all bodies. Only in the second case the margin is 0, and ``reason`` says about which.
    """

    margin: float
    upper: float
    status: Status
    moving: tuple[str, ...]
    seconds: float
    late: bool
    reason: str

    def __float__(self) -> float:
        return self.margin

    @property
    def holds(self) -> bool:
        """Whether everything stays at rest, as far as the default engine knows: False also where that is undecided."""
        return self.status is Status.STABLE

    def summary(self) -> Summary:
        """Summarise the answer by its margin and what moves first."""
        when = f"{1e3 * self.seconds:.1f} ms{', late' if self.late else ''}"
        first = f"; then {listed(self.moving)} would move first" if self.moving else ""
        most = f" of at most {at_least(self.upper)}" if self.upper < 1 else ""
        text = f"margin {at_most(self.margin)}{most} ({when})"
        return Summary(f"{self.status}: {text}{first}", [("why", self.reason)] if self.reason else ())


class _Direction(NamedTuple):
    """What an engine says of one direction: bounds of the largest factor, and what moves first."""

    lower: float
    upper: float
    moving: tuple[str, ...]


@dataclass(eq=False)
class _GroupAnswers:
    """The answers of one prepared engine about one group, along directions x (12,), and what they take.

    ``columns`` (6J, 12) are the loads of the group alone. ``times`` [s] are those of the last questions.
    """

    groups: Groups
    columns: Float
    times: deque[float] = field(default_factory=lambda: deque(maxlen=RECENT))
    known: OrderedDict[bytes, _Direction] = field(default_factory=OrderedDict)

    @property
    def cost(self) -> float:
        """The time [s] that the next question is expected to take; 0 if none was asked."""
        return float(np.median(self.times)) if self.times else 0.0

    def ask(self, way: Float) -> _Direction:
        """Return the answer along ``way`` (12,), and remember it."""
        start = time.perf_counter()
        found = self.groups.load_factor((self.columns @ way)[:, None])
        along = _Direction(float(found.lower[0]), float(found.upper[0]), found.moving[0])
        self.times.append(time.perf_counter() - start)
        self.known[_key(way)] = along
        while len(self.known) > REMEMBERED:
            self.known.popitem(last=False)
        return along


@dataclass(eq=False)
class _WatchedGroup:
    """A group that stands, with the ``names`` of its bodies, of which some may be only ``balanced``.

    ``holds`` asks the default engine, and ``moves`` the one that proves motions. ``last`` is the share that a unit of
    motion used when ``holds`` was asked last.
    """

    names: tuple[str, ...]
    balanced: tuple[str, ...]
    holds: _GroupAnswers
    moves: _GroupAnswers
    last: float = np.inf


class Monitor:
    """Watch what stands on a carrier that moves, many times a second.

    It is prepared once for an assembly; ``update`` then says how much of what the assembly withstands the present
    motion leaves. It holds where ``transport_limits`` says so of the same motion: answers are the ``lower`` of the
    default engine. That something moves is proved by engine ``limit``. Every moment is judged on its own, from rest:
    nothing bounces or rocks, or has slipped before.

    ``bodies`` (names) restricts it to their groups, as in ``transport_limits``. The ``standing`` loads act throughout.
    The carrier's acceleration is that at ``pivot`` (3,) [m], about which it turns. ``seconds`` [s] is the longest time
    of an update: groups of bodies for which there is no time are not asked, and the margin is 0; once a second one is
    tried all the same. ``solves`` motions are asked in advance for each group, to know how long one takes. Directions
    that were asked before take no time.

    One thread may use it at a time. A copy, or one that was pickled, prepares itself anew. Raises SceneError if one of
    ``bodies`` is unknown or fixed, or if all are fixed, and HoldfastError if the poses of the assembly are uncertain
    (``pose_sigma``) or if something is held.
    """

    def __init__(
        self,
        assembly: Assembly | Scene,
        *,
        bodies: Sequence[str] | None = None,
        standing: Iterable[Load] = (),
        pivot: ArrayLike = (0.0, 0.0, 0.0),
        seconds: float = 0.02,
        solves: int = 5,
    ) -> None:
        given = request.checked_assembly(assembly)
        if given.tolerances.capped:
            remedy = "needs contacts that are known: assemble the scene without pose_sigma"
            raise HoldfastError(message("monitor", "the poses of the assembly are uncertain", remedy))
        refuse_holds(given.scene.holds, "monitor", "leave them out, or ask load_factor with engine='limit'")
        self._pivot = checked(pivot, (3,), "monitor: pivot", within=PLACE)
        self._seconds = checked_number(seconds, "monitor: seconds", minimum=0, within=SCALE)
        self._solves = checked_whole(solves, "monitor: solves", 0, MANY)
        self._standing = request.checked_loads(standing)
        counted, self._notes = counted_bodies(given, bodies, "monitor")
        self._names = {body.name for body, taken in zip(given.movable, counted, strict=True) if taken}
        if not self._names:
            raise SceneError(message("monitor", "nothing that it watches can move", "needs movable bodies"))
        self._assembly = given
        self._watched: dict[tuple[Same, bytes], _WatchedGroup] = {}
        self._tried = -np.inf  # when a question was last asked
        self._prepare(self._solves)

    @property
    def assembly(self) -> Assembly:
        """The assembly that is watched, with the bodies where they were last given."""
        return self._assembly

    @property
    def notes(self) -> tuple[str, ...]:
        """What the scene's reader guessed or left out, which bodies are not watched, and which are only balanced."""
        loose = tuple(name for each in self._watched.values() for name in each.balanced)
        return (*self._assembly.scene.notes, *self._notes, *((only_balanced(loose),) if loose else ()))

    def __repr__(self) -> str:
        groups = len(self._watched) + len(self._unsure)
        return f"Monitor({len(self._names)} bodies in {groups} groups, {1e3 * self._seconds:g} ms)"

    def __getstate__(self) -> dict[str, Any]:
        # without what is prepared, which ``__setstate__`` prepares again
        return self.__dict__ | {"_watched": {}, "_unsure": []}

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        self.__dict__.update(state)
        self._prepare(self._solves)

    def update(
        self,
        acceleration: ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
        gravity: ArrayLike | None = None,
        poses: Mapping[str, ArrayLike] | None = None,
        *,
        angular_acceleration: ArrayLike = (0.0, 0.0, 0.0),
    ) -> Monitored:
        """Say how much of what everything withstands the present motion of the carrier leaves.

        All vectors (3,) are along the axes of the scene, which move with the carrier: its ``acceleration`` [m/s²]
        without gravity, its ``angular_velocity`` [rad/s] and ``angular_acceleration`` [rad/s²], and ``gravity``
        [m/s²], by default that of the scene. A sensor of acceleration reads the acceleration less gravity.

        ``poses`` maps names of bodies to poses (4, 4), body frame to the scene's, and holds until others are given.
        Where a body is displaced by more than a tenth of the gap within which its surfaces touch, its group is prepared
        anew: that takes longer, and nothing stops it. Raises SceneError for arguments that are no such numbers.
        """
        start = time.perf_counter()
        a, omega, alpha = (
            checked(value, (3,), f"monitor: {name}", within=within)
            for name, value, within in (
                ("acceleration", acceleration, ACCELERATION),
                ("angular velocity", angular_velocity, TURNING),
                ("angular acceleration", angular_acceleration, TURNING),
            )
        )
        usual = self._assembly.scene.gravity
        pull = usual if gravity is None else checked(gravity, (3,), "monitor: gravity", within=ACCELERATION)
        if poses is not None:
            scene, tolerances = self._assembly.scene, self._assembly.tolerances
            after, moved = scene.moved(poses), []
            for n in poses:  # how far points of a body are displaced that are no farther from its origin than its size
                now, before = after.body(n), scene.body(n)
                turned = np.linalg.norm(now.pose[:3, :3] - before.pose[:3, :3])
                displaced = np.linalg.norm(now.pose[:3, 3] - before.pose[:3, 3]) + now.size * turned
                if displaced > STILL * tolerances.base(now, now):
                    moved.append(n)
            if moved:
                self._assembly = self._assembly.moved({n: poses[n] for n in moved})
                self._prepare(0)
        x = motion_coordinates((a - (pull - usual))[None], alpha[None], omega[None])[0]
        found = self._judged(x, start + self._seconds)
        taken = time.perf_counter() - start
        return replace(found, seconds=taken, late=found.late or taken > self._seconds)

    def _judged(self, x: Float, until: float) -> Monitored:
        """Return the answer at x (12,), without the time that it took; groups are asked ``until`` the time is over."""
        size = float(np.linalg.norm(x))
        if self._unsure:  # a motion may hold what falls at rest
            verdict, names = self._unsure[0].verdict, self._unsure[0].names
            falls = verdict.status is Status.UNSTABLE and size == 0
            moving = names if verdict.mechanism is None else verdict.mechanism.moving
            return _answer(np.inf, np.inf if falls else 0.0, moving, f"at rest: {verdict.reason}")
        way = x / size if size else x
        used, first, left = self._used(way, size, until) if size else (0.0, None, [])
        if left:
            names = tuple(name for each in left for name in each.names)
            cost = 1e3 * sum(each.holds.cost for each in left)
            reason = f"there was no time to ask about {listed(names, NAMED)} (some {cost:.2g} ms)"
            return _answer(np.inf, 0.0, (), reason, late=True)
        if first is None:
            return _answer(0.0, 0.0, (), "")
        known, proof = first.holds.known[_key(way)], first.moves.known.get(_key(way))
        if used >= 1 and proof is None and time.perf_counter() + first.moves.cost <= until:
            proof = first.moves.ask(way)
        least = max(_share(size, one.upper) for one in (known, proof) if one is not None)
        return _answer(used, least, known.moving or (() if proof is None else proof.moving), "")

    def _used(self, way: Float, size: float, until: float) -> tuple[float, _WatchedGroup | None, list[_WatchedGroup]]:
        """Return the largest share that a group uses of what it withstands at ``size`` times the direction ``way``.

        Also returns that group, and those that are left as the time is over. Those that used most the last time are
        asked first, until one is found not to hold.
        """
        used, first, left = 0.0, None, []
        for each in self._watched.values():
            known = each.holds.known.get(_key(way))
            if known is None:
                left.append(each)
            elif _share(size, known.lower) > used:
                used, first = _share(size, known.lower), each
        left.sort(key=lambda each: -each.last)
        while left and used < 1:
            now = time.perf_counter()
            short = now + max(each.holds.cost for each in left) > until
            if short and (now >= until or now < self._tried + AGAIN):
                return used, first, left
            each, self._tried = left.pop(0), now
            each.last = _share(1.0, each.holds.ask(way).lower)
            if size * each.last > used:
                used, first = size * each.last, each
        return used, first, []

    def _prepare(self, solves: int) -> None:
        """Prepare all groups that have changed, and ask each of them about so many likely motions."""
        assembly = self._assembly
        standing = request.total_wrench(assembly, self._standing)
        columns, times = motion_columns(assembly, self._pivot), {w.names: w.holds.times for w in self._watched.values()}
        holding, moving = (
            prepared(request.engine_of(name), assembly, standing) for name in (DEFAULT_ENGINE, CERTAIN_ENGINE)
        )
        numbers = [k for k, names in enumerate(assembly.groups) if not self._names.isdisjoint(names)]
        rng = np.random.default_rng(0)
        x = motion_coordinates(*(deviation * rng.normal(size=(solves, 3)) for deviation in LIKELY))
        likely = x / np.linalg.norm(x, axis=1, keepdims=True)
        watched: dict[tuple[Same, bytes], _WatchedGroup] = {}
        self._unsure: list[PreparedGroup] = []
        for k in reported("monitor", numbers):
            group = holding.group(k)
            if group.verdict.status is not Status.STABLE or group.part is None:
                self._unsure.append(group)
                continue
            rows = group.part.rows
            key = (group.part.content, standing[rows].tobytes())
            known = self._watched.get(key)
            if known is None:
                own = np.zeros_like(columns)
                own[rows] = columns[rows]
                holds, moves = (
                    _GroupAnswers(holding, own, times.get(group.names, deque(maxlen=RECENT))),
                    _GroupAnswers(moving, own),
                )
                known = _WatchedGroup(group.names, group.verdict.balanced, holds, moves)
                for way in likely:
                    holds.ask(way)
                    moves.ask(way)
            watched[key] = known
        self._watched = watched
        self._tried = time.perf_counter()
        self._unsure.sort(key=lambda group: group.verdict.status is not Status.UNSTABLE)


def _key(way: Float) -> bytes:
    """Return what directions (12,) that count as one have in common."""
    return np.asarray(np.round(way, ALIKE) + 0.0).tobytes()  # 0.0: -0 is 0


def _share(size: float, factor: float) -> float:
    """Return which share of a ``factor`` this ``size`` is: of 0 it is more than all."""
    return size / factor if factor > 0 else np.inf


def _answer(most: float, least: float, moving: tuple[str, ...], reason: str, *, late: bool = False) -> Monitored:
    """Return the answer for a usage between two bounds, without the time that it took."""
    margin = max(1 - most, 0.0)
    upper = max(1 - least, margin)
    status = Status.STABLE if margin > 0 else Status.UNSTABLE if least > 1 else Status.UNDECIDED
    if not reason and status is Status.UNDECIDED:
        reason = "it is not known to hold, nor proved to move"
    return Monitored(margin=margin, upper=upper, status=status, moving=moving, seconds=0.0, late=late, reason=reason)
