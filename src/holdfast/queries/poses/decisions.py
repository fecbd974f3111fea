"""The verdict on the whole scene at each pose: the moved bodies decided anew, and all other groups once."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastWarning
from holdfast.base.parallel import answers_in_parallel, free_threads
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.joint_answers import joint
from holdfast.engines.rest import undecided
from holdfast.engines.verdict import GroupVerdict, Status, Verdict
from holdfast.queries.poses.neighbourhoods import Neighbourhoods, Piece

STAGE = "poses"


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


@dataclass(frozen=True, eq=False)
class Locals:
    """The small assemblies in which pieces are decided by ``engine``, made once, and the groups of the rest."""

    around: Neighbourhoods
    engine: Engine
    _made: dict[Piece, Assembly] = field(default_factory=dict, init=False, repr=False)

    def of(self, piece: Piece) -> Assembly:
        """Return the assembly of a piece, with its moved bodies where they were."""
        if piece not in self._made:
            self._made[piece] = self.around.local(piece)
        return self._made[piece]

    def at(self, piece: Piece, poses: Mapping[str, Float]) -> Assembly:
        """Return the assembly of a piece with its moved bodies at ``poses`` (4, 4)."""
        return self.of(piece).moved({name: poses[name] for name in piece.moved})

    def decided(self, piece: Piece, poses: Mapping[str, Float]) -> Groups:
        """Return the verdicts on the groups of a piece at ``poses`` (4, 4)."""
        return tuple(Decided.of(group) for group in prepared(self.engine, self.at(piece, poses)).verdicts)

    @cached_property
    def rest(self) -> Groups:
        """The verdicts on the groups of the assembly without the moved bodies."""
        rest = self.around.rest
        return () if rest is None else tuple(Decided.of(group) for group in prepared(self.engine, rest).verdicts)

    def decided_all(self, asked: Sequence[tuple[int, Piece]], count: int) -> list[Groups]:
        """Decide pieces at the poses of some rows, ``asked`` as (row, piece), in threads.

        Progress is reported in shares of ``count``.
        """
        given = self.around.given
        for piece in dict.fromkeys(piece for _, piece in asked):
            self.of(piece)

        def ask(number: int) -> Groups:
            row, piece = asked[number]
            return self.decided(piece, given.row(row))

        with quiet():
            return answers_in_parallel(STAGE, ask, min(free_threads(), max(len(asked), 1)), len(asked), count)


def overlapping(name: str, texts: Mapping[tuple[str, str], str], rest: Groups) -> Groups:
    """Return the verdicts where a body overlaps others, with a text for each pair; ``rest`` are the groups beside."""
    found = [Decided((name,), Status.UNDECIDED, "; ".join(texts.values()))]
    for group in rest:
        said = [text for pair, text in texts.items() if not set(pair).isdisjoint(group.names)]
        found.append(Decided(group.names, Status.UNDECIDED, "; ".join(said)) if said else group)
    return tuple(found)


def quiet() -> warnings.catch_warnings[None]:
    """Return a context in which overlaps are not warned of: the answers name them."""
    return warnings.catch_warnings(action="ignore", category=HoldfastWarning)


class Whole:
    """Joins verdicts on groups to verdicts on the whole scene of an assembly, the same groups once."""

    def __init__(self, assembly: Assembly, rest: Groups) -> None:
        self._place = {body.name: number for number, body in enumerate(assembly.movable)}
        self._rest = rest
        self._known: dict[tuple[int, ...], tuple[Sequence[Groups], Decided]] = {}

    def joined(self, pieces: Sequence[Groups], others: frozenset[str]) -> Decided:
        """Return the verdict on the scene: that of the groups of all ``pieces``, and of the rest without ``others``."""
        key = tuple(map(id, pieces))
        if key not in self._known:  # what is kept with the verdict keeps its id
            groups = [group for piece in pieces for group in piece]
            groups += [group for group in self._rest if others.isdisjoint(group.names)]
            groups.sort(key=lambda group: min(map(self._place.__getitem__, group.names)))
            self._known[key] = pieces, _joined(tuple(groups))
        return self._known[key][1]


def _joined(groups: Groups) -> Decided:
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
