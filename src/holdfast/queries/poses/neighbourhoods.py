"""Poses of some bodies, what is within reach of these at each, and the small assemblies in which they are decided.

A verdict on a group of bodies depends on these bodies, on those that they touch, and on those within reach of them. So
at each pose only the moved bodies and what they may touch have to be looked at; the rest stands or falls as before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.arrays import Bool, Float, Int, checked, checked_items, frozen
from holdfast.base.errors import GeometryError, HoldfastError, SceneError, message
from holdfast.base.progress import answers_in_parallel, free_threads
from holdfast.base.ranges import PLACE
from holdfast.base.rigid import RIGID_TOLERANCE, checked_pose
from holdfast.base.text import quoted
from holdfast.contacts.neighbours import box_distance, components, neighbours
from holdfast.contacts.tolerances import DOUBTFUL_GAP, doubtful_gap
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.joint_answers import joint
from holdfast.engines.rest import undecided
from holdfast.engines.verdict import GroupVerdict, Status, Verdict
from holdfast.queries.poses.outlines import PartHull, outlines_of, separation
from holdfast.queries.request import quiet
from holdfast.scene.body import Body

STAGE = "poses"
T = TypeVar("T")

SLACK = 1.001  # factor on a reach, so that no rounding takes a body for out of reach


@dataclass(frozen=True)
class Decided:
    """The verdict on a group in short; ``moving`` are those that move if it is UNSTABLE, ``balanced`` are as there."""

    names: tuple[str, ...]
    status: Status
    reason: str
    moving: tuple[str, ...] = ()
    balanced: tuple[str, ...] = ()

    @classmethod
    def of(cls, group: GroupVerdict) -> Decided:
        """Return a verdict in short."""
        verdict, mechanism = group.verdict, group.verdict.mechanism
        falls = verdict.status is Status.UNSTABLE and mechanism is not None
        moving = mechanism.moving if falls and mechanism else ()
        return cls(group.bodies, verdict.status, verdict.reason, moving, verdict.balanced)


Groups = tuple[Decided, ...]


def joined(groups: Groups) -> Decided:
    """Return one verdict for all groups: the worst, with the reasons and the moving bodies of those that have it."""
    if groups:
        short = [
            GroupVerdict(
                bodies=group.names, verdict=Verdict(status=group.status, reason=group.reason, balanced=group.balanced)
            )
            for group in groups
        ]
        verdict = joint(short)
    else:
        verdict = undecided("nothing here can move: every body is fixed")
    names = tuple(name for group in groups for name in group.names)
    moving = tuple(name for group in groups if group.status is verdict.status for name in group.moving)
    return Decided(names, verdict.status, verdict.reason, moving)


@dataclass(frozen=True, eq=False)
class GivenPoses:
    """``poses`` (n, k, 4, 4), body frame to world, of the k bodies with these ``names``."""

    names: tuple[str, ...]
    poses: Float

    def __len__(self) -> int:
        return len(self.poses)

    def of(self, name: str) -> Float:
        """Return the poses (n, 4, 4) of one of the bodies."""
        return self.poses[:, self.names.index(name)]

    def row(self, number: int) -> dict[str, Float]:
        """Return the poses of one row by name, as ``Assembly.moved`` takes them."""
        return dict(zip(self.names, self.poses[number], strict=True))


def given_poses(
    assembly: Assembly, bodies: str | Sequence[str], poses: ArrayLike | Mapping[str, ArrayLike], where: str
) -> GivenPoses:
    """Check the names of the moved ``bodies`` and their ``poses``.

    ``poses`` is (n, 4, 4) for one body; for k bodies it is (n, k, 4, 4), in the order of ``bodies``, or a mapping from
    each name to (n, 4, 4). Raises SceneError for an unknown or repeated name or if the names of a mapping are others,
    GeometryError if a pose is not rigid, and HoldfastError if the interfaces of the assembly were given.
    """
    if not assembly.detected:
        problem = "its interfaces were given, and where bodies touch elsewhere cannot be told from them"
        raise HoldfastError(message(where, problem, "assemble the scene without interfaces="))
    names = [bodies] if isinstance(bodies, str) else checked_items(bodies, f"{where}: bodies", "names")
    for name in names:
        assembly.scene.body(name)
    if not names or len(set(names)) < len(names):
        problem = f"bodies is {quoted(names, 80)}"
        raise SceneError(message(where, problem, "name at least one body, and each once"))
    each = _by_body(names, poses, isinstance(bodies, str), where)
    return GivenPoses(tuple(names), frozen(np.stack(each, axis=1)))


def _by_body(names: Sequence[str], poses: ArrayLike | Mapping[str, ArrayLike], single: bool, where: str) -> list[Float]:
    """Return the checked poses (n, 4, 4) of each body."""
    if isinstance(poses, Mapping):
        if set(poses) != set(names):
            problem = f"poses are those of {quoted(sorted(map(str, poses)), 80)}"
            raise SceneError(message(where, problem, f"needs those of {quoted(sorted(names), 80)}"))
        each = [_rigid(poses[name], f"{where}: poses of {quoted(name)}") for name in names]
    elif single:
        each = [_rigid(poses, f"{where}: poses")]
    else:
        together = checked(poses, (None, len(names), 4, 4), f"{where}: poses", error=GeometryError)
        each = [_rigid(together[:, k], f"{where}: poses of {quoted(name)}") for k, name in enumerate(names)]
    counts = {len(own) for own in each}
    if len(counts) > 1:
        counted = ", ".join(f"{quoted(name)} {len(own)}" for name, own in zip(names, each, strict=True))
        raise SceneError(message(where, f"poses differ in number: {counted}", "needs as many of each body"))
    if counts == {0}:
        raise SceneError(message(where, "got no poses", "needs at least one"))
    return each


def _rigid(value: Any, where: str) -> Float:  # noqa: ANN401 - anything a caller may pass
    """Return poses (n, 4, 4) after checking all of them at once; the first that is not rigid raises GeometryError."""
    poses = checked(value, (None, 4, 4), where, error=GeometryError)
    turned = poses[:, :3, :3]
    with np.errstate(over="ignore", invalid="ignore"):
        defect = np.abs(np.swapaxes(turned, 1, 2) @ turned - np.eye(3)).max((1, 2))
        fits = (defect <= RIGID_TOLERANCE) & (np.linalg.det(turned) > 0) & (poses[:, 3] == (0, 0, 0, 1)).all(1)
        fits &= (np.abs(poses[:, :3, 3]) <= PLACE.largest).all(1)
    for number in np.flatnonzero(~fits):
        checked_pose(poses[number], f"{where}[{number}]")
    return poses


@dataclass(frozen=True)
class Neighbourhood:
    """Some ``moved`` bodies, the bodies ``beside`` them at some pose, and all ``others`` that are decided with them.

    The others are ``beside`` with all movable bodies that touch these or come within reach of them, and so on.
    """

    moved: tuple[str, ...]
    beside: frozenset[str]
    others: frozenset[str]


@dataclass(frozen=True, eq=False)
class Neighbourhoods:
    """What is near the moved bodies of ``given`` at each of their n poses in ``assembly``."""

    assembly: Assembly
    given: GivenPoses
    engine: Engine
    _local: dict[Neighbourhood, Assembly] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def rest(self) -> Assembly | None:
        """The assembly without the moved bodies; None if one of these is fixed, and everything may depend on it."""
        if any(self.assembly.scene.body(name).fixed for name in self.given.names):
            return None
        return self.assembly.without(*self.given.names)

    @cached_property
    def rest_groups(self) -> Groups:
        """The verdicts on the groups of ``rest``."""
        return () if self.rest is None else self.verdicts_on(self.rest)

    def verdicts_on(self, assembly: Assembly) -> Groups:
        """Return the verdicts on the groups of an assembly, in short."""
        return tuple(map(Decided.of, prepared(self.engine, assembly).verdicts))

    @cached_property
    def outlines(self) -> dict[str, tuple[PartHull, ...]]:
        """The outlines of the parts of every body."""
        return {body.name: outlines_of(body) for body in self.assembly.bodies}

    @cached_property
    def parts(self) -> list[tuple[str, PartHull]]:
        """All parts of all bodies, with the names of the bodies, in the order of the scene."""
        return [(body.name, part) for body in self.assembly.bodies for part in self.outlines[body.name]]

    @cached_property
    def patterns(self) -> list[tuple[tuple[Neighbourhood, ...], Int]]:
        """The pieces of each pattern of neighbours that occurs, with the rows (m,) of the poses that have it.

        Each moved body is in one of the pieces.
        """
        if self.rest is None:
            others = frozenset(body.name for body in self.assembly.bodies) - set(self.given.names)
            return [((Neighbourhood(self.given.names, others, others),), np.arange(len(self.given)))]
        near = np.packbits(self._near.reshape(len(self.given), -1), axis=1)
        _, first, pattern = np.unique(near, axis=0, return_index=True, return_inverse=True)
        return [
            (self._pieces(self._near[row]), np.flatnonzero(pattern.ravel() == number))
            for number, row in enumerate(first)
        ]

    @cached_property
    def apart(self) -> Float:
        """Lower bounds (n, k, P) [m] of the distance of each moved body from all P ``parts``; inf where none can touch.

        Bounds beyond the ``reach`` of two bodies may be anything beyond it.
        """
        scene, names = self.assembly.scene, self.given.names
        apart = np.full((len(self.given), len(names), len(self.parts)), np.inf)
        for k, name in enumerate(names):
            body, poses = scene.body(name), self.given.of(name)
            for number, (its, part) in enumerate(self.parts):
                other = scene.body(its)
                if its == name or not scene.touching(body, other):
                    continue
                at = self.given.of(its) if its in names else np.broadcast_to(other.pose, poses.shape)
                reach = self.reach(body, other)
                bounds = [separation(own, poses, part, at, reach) for own in self.outlines[name]]
                apart[:, k, number] = np.minimum.reduce(bounds)
        return apart

    @cached_property
    def meets(self) -> Bool:
        """Which parts may touch each of the moved bodies (n, k, P)."""
        return np.asarray(self.apart <= SLACK * self._of_pairs(self.gap))

    @cached_property
    def _near(self) -> Bool:
        """Which bodies come within reach of each of the moved ones (n, k, B)."""
        near = np.zeros((len(self.given), len(self.given.names), len(self.assembly.bodies)), dtype=bool)
        body = self.assembly.scene.body
        within = self.apart <= self._of_pairs(lambda one, two: self.reach(body(one), body(two)))
        for number, (its, _) in enumerate(self.parts):
            near[:, :, self.order[its]] |= within[:, :, number]
        return near

    def _of_pairs(self, value: Callable[[str, str], float]) -> Float:
        """Return a value (k, P) of each moved body and the body of each part; -1 for a body with itself."""
        return np.array(
            [[-1.0 if its == name else value(name, its) for its, _ in self.parts] for name in self.given.names]
        )

    def gap(self, a: str, b: str) -> float:
        """Return the gap [m] up to which two bodies touch."""
        return self.assembly.tolerances.between(*(self.assembly.scene.body(name) for name in (a, b))).gap

    def reach(self, a: Body, b: Body) -> float:
        """Return the distance [m] beyond which two bodies neither touch nor are held by each other in doubt."""
        return SLACK * max(self.assembly.tolerances.between(a, b).gap, doubtful_gap(a, b))

    def _pieces(self, near: Bool) -> tuple[Neighbourhood, ...]:
        """Return the pieces of one pose, at which the moved bodies are ``near`` (k, B) others."""
        names, bodies = self.given.names, self.assembly.bodies
        beside = {
            name: {body.name for body, one in zip(bodies, row, strict=True) if one}
            for name, row in zip(names, near, strict=True)
        }
        joined = {name: {name} | self.with_all_near(beside[name] - set(names)) for name in names}
        links = [
            (a, b)
            for a, one in enumerate(names)
            for b, two in enumerate(names[:a])
            if two in beside[one] or any(not self._is_fixed(name) for name in joined[one] & joined[two])
        ]
        pieces = []
        for group in components(len(names), links):
            moved = tuple(names[k] for k in group)
            together = set[str]().union(*(beside[name] for name in moved))
            others = set[str]().union(*(joined[name] for name in moved)) - set(moved)
            pieces.append(Neighbourhood(moved, frozenset(together - set(moved)), frozenset(others)))
        return tuple(pieces)

    @cached_property
    def order(self) -> dict[str, int]:
        """The place of each body in the scene."""
        return {body.name: number for number, body in enumerate(self.assembly.bodies)}

    def _is_fixed(self, name: str) -> bool:
        return self.assembly.scene.body(name).fixed

    def with_all_near(self, names: Iterable[str]) -> set[str]:
        """Return bodies with all that their movable ones are decided with."""
        found = set(names)
        return found.union(*(self._clusters[name] for name in found if not self._is_fixed(name)))

    @cached_property
    def _clusters(self) -> dict[str, frozenset[str]]:
        """The bodies with which each unmoved movable body is decided: all that is within reach, and so on."""
        assert self.rest is not None
        movable, index = self.rest.movable, self.rest.index
        widest = SLACK * max(self.assembly.tolerances.widest(self.assembly.scene), DOUBTFUL_GAP)
        close = [(a, b) for a, b in neighbours(self.rest.scene, widest) if box_distance(a, b) <= self.reach(a, b)]
        ends = [(index[a.name], index[b.name]) for a, b in close]
        found: dict[str, frozenset[str]] = {}
        for group in components(len(movable), [pair for pair in ends if FIXED not in pair]):
            members = {movable[k].name for k in group}
            holders = {b.name for pair in close for a, b in (pair, pair[::-1]) if b.fixed and a.name in members}
            found |= dict.fromkeys(members, frozenset(members | holders))
        return found

    def local(self, piece: Neighbourhood) -> Assembly:
        """Return the assembly in which a piece is decided, made once, with its moved bodies where they were."""
        if piece not in self._local:
            kept = {*piece.moved, *piece.others}
            if not any(self._is_fixed(name) for name in kept):
                kept |= {body.name for body in self.assembly.fixed}
            gone = [body.name for body in self.assembly.bodies if body.name not in kept]
            self._local[piece] = self.assembly.without(gone) if gone else self.assembly
        return self._local[piece]

    def at(self, piece: Neighbourhood, poses: Mapping[str, Float]) -> Assembly:
        """Return the assembly of a piece with its moved bodies at ``poses`` (4, 4)."""
        return self.local(piece).moved({name: poses[name] for name in piece.moved})

    def in_threads(self, pieces: Sequence[tuple[int, Neighbourhood]], answer: Callable[[Assembly, int], T]) -> list[T]:
        """Return an ``answer(assembly, row)`` for each (row, piece) of ``pieces``, computed in threads."""
        for piece in dict.fromkeys(piece for _, piece in pieces):
            self.local(piece)

        def ask(number: int) -> T:
            row, piece = pieces[number]
            return answer(self.at(piece, self.given.row(row)), row)

        with quiet():
            return answers_in_parallel(
                STAGE, ask, min(free_threads(), max(len(pieces), 1)), len(pieces), len(self.given)
            )
