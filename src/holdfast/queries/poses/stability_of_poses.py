"""Decide for many poses of some bodies whether the scene stands with them there."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, cached_property
from itertools import chain

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Bool, Float, Objects, frozen, objects
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import MOST_ROWS, PublicValue, Summary, column, number
from holdfast.base.text import listed
from holdfast.engines.answers import Claim
from holdfast.engines.bearing import limited
from holdfast.engines.verdict import Status
from holdfast.queries.poses.neighbourhoods import Decided, Groups, Neighbourhood, Neighbourhoods, given_poses, joined
from holdfast.queries.poses.plain_cases import PlainCases
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, checked_assembly, engine_of, quiet
from holdfast.queries.stability import Stability, stability
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene

NAME = "stability_of_poses"


class StabilityOfPoses(PublicValue):
    """Whether a scene stands with some of its bodies at each of n poses.

    ``poses`` (n, k, 4, 4) are those of the k moved ``bodies``. Each column has a row for each pose: ``status`` (n,) is
    STABLE, UNSTABLE or UNDECIDED; ``reason`` (n,) explains it in words; ``moving`` (n,) holds the names of the bodies
    that move, and is empty unless the status is UNSTABLE. All of them are on the whole scene, as in ``hf.stability``.

    ``answer[k]`` and iteration give the single answers, a ``Stability`` each with contact forces and evidence. They are
    worked out when they are asked for, and so is ``margin``. Answers that were saved, pickled or copied have lost them.
    """

    engine: str
    claim: Claim
    bodies: tuple[str, ...]
    poses: Float = column("n k 4 4")
    status: Objects = column("n")
    reason: Objects = column("n")
    moving: Objects = column("n")
    notes: tuple[str, ...]

    plain = "engine claim bodies status reason moving poses notes"

    def __len__(self) -> int:
        return len(self.poses)

    def __getitem__(self, row: int) -> Stability:
        """Return the answer for one pose, as ``hf.stability`` gives it."""
        asked: Callable[[int], Stability] | None = getattr(self, "_asked", None)
        if asked is None:
            remedy = "ask hf.stability(assembly.moved(...))"
            raise HoldfastError(message(f"{NAME}[{row}]", "was lost when the answer was saved or copied", remedy))
        return asked(range(len(self))[row])  # raises IndexError beyond the last row, which also ends an iteration

    def __iter__(self) -> Iterator[Stability]:
        return (self[row] for row in range(len(self)))

    @cached_property
    def stable(self) -> Bool:
        """Whether the scene certainly stands with the bodies at each pose (n,): False also where that is undecided."""
        return frozen(np.asarray(self.status == Status.STABLE, dtype=bool))

    @cached_property
    def margin(self) -> Float:
        """The margin (n,) of each pose, from 0 to 1, as ``Stability.margin``; it takes far longer than all the rest."""
        margins = np.zeros(len(self))
        for row in np.flatnonzero(self.stable).tolist():
            margins[row] = self[row].margin
        return frozen(margins)

    def summary(self) -> Summary:
        """Summarise the answer by how many poses stand, and by the reasons of those that do not."""
        counts = {status: int((self.status == status).sum()) for status in STATES}
        headline = f"{len(self):,} poses of {listed(self.bodies)}: {counts[Status.STABLE]:,} stand"
        facts = [("engine", f"{self.engine} ({self.claim.words})")]
        facts += [(str(status), f"{count:,} ({number(100 * count / len(self))} %)") for status, count in counts.items()]
        rows = [
            [str(row), str(self.status[row]), str(self.reason[row])] for row in np.flatnonzero(~self.stable)[:MOST_ROWS]
        ]
        return Summary(headline, facts, ("pose", "status", "reason"), rows, self.notes)


STATES = (Status.STABLE, Status.UNSTABLE, Status.UNDECIDED)


def stability_of_poses(
    assembly: Assembly | Scene,
    bodies: str | Sequence[str],
    poses: ArrayLike | Mapping[str, ArrayLike],
    *,
    engine: EngineChoice = DEFAULT_ENGINE,
) -> StabilityOfPoses:
    """Decide for each of n poses of one or several bodies whether the scene stands with them there.

    ``bodies`` is a name, or a list of k names; ``poses`` are (n, 4, 4), body frame to world, for a list (n, k, 4, 4) or
    a mapping from each name to (n, 4, 4). Each row has the status that ``hf.stability(assembly.moved(...))`` gives, but
    takes far less time: contacts are searched only where the bodies are, and all else is decided once. Bodies that
    overlap are not warned of; the reason names them. Where a body bears more than its ``top_load`` or ``pressure``, the
    row is UNSTABLE and ``moving`` names who is crushed; such scenes take as long as single calls.

    ``engine`` is the name of an engine, or an engine itself. Raises SceneError for an unknown name or no poses,
    GeometryError if a pose is not rigid, and HoldfastError if the interfaces of the assembly were given.
    """
    assembly = checked_assembly(assembly)
    refuse_holds(
        assembly.scene.holds, NAME, "ask one pose at a time: hf.stability(assembly.moved(...), engine=hf.Limit())"
    )
    method = engine_of(engine)
    given = given_poses(assembly, bodies, poses, NAME)

    def asked(row: int) -> Stability:
        with quiet():
            return stability(assembly.moved(given.row(row)), engine=method)

    if limited(assembly.bodies):  # who is crushed is asked of the whole scene
        found = [_with_bearing(asked(row), limited(assembly.bodies)) for row in range(len(given))]
    else:
        found = decided(Neighbourhoods(assembly, given, method))
    answer = StabilityOfPoses(
        engine=method.name,
        claim=method.claim,
        bodies=given.names,
        poses=given.poses,
        status=objects([one.status for one in found]),
        reason=objects([one.reason for one in found]),
        moving=objects([one.moving for one in found]),
        notes=assembly.scene.notes,
    )
    vars(answer)["_asked"] = asked
    return answer


def _with_bearing(found: Stability, limits: Sequence[str]) -> Decided:
    """Return a single answer in short: UNSTABLE where a body is crushed, UNDECIDED where what one bears is not known.

    ``limits`` are the names of the bodies with a limit.
    """
    unknown = sorted({*limits} - {one.body for one in found.bearing})
    if found.status is not Status.STABLE:
        return Decided((), found.status, found.reason, found.moving if found.status is Status.UNSTABLE else ())
    if found.crushed:
        return Decided((), Status.UNSTABLE, found.bearing[0].text, found.crushed)
    if unknown:
        return Decided((), Status.UNDECIDED, f"what {listed(unknown)} may bear was not compared: forces are not known")
    return Decided((), Status.STABLE, found.reason)


def decided(around: Neighbourhoods) -> list[Decided]:
    """Return the verdict on the whole scene at each pose: plain cases at once, all others one by one."""
    plain = {name: PlainCases(around, name) for name in around.given.names}
    known: list[dict[Neighbourhood, Groups]] = [{} for _ in range(len(around.given))]
    unknown: list[tuple[int, Neighbourhood]] = []
    for pieces, rows in around.patterns:
        for piece in pieces:
            for at, groups in plain[piece.moved[0]].at_once(piece, rows):
                for row in at.tolist():
                    known[row][piece] = groups
            unknown += [(row, piece) for row in rows.tolist() if piece not in known[row]]
    unknown.sort(key=lambda entry: entry[0])
    each = around.in_threads(unknown, lambda there, _: around.verdicts_on(there))
    for (row, piece), groups in zip(unknown, each, strict=True):
        known[row][piece] = groups
    place = {body.name: number for number, body in enumerate(around.assembly.movable)}

    @cache  # many poses have the same groups
    def whole(groups: Groups, others: frozenset[str]) -> Decided:
        every = [*groups, *(group for group in around.rest_groups if others.isdisjoint(group.names))]
        return joined(tuple(sorted(every, key=lambda group: min(map(place.__getitem__, group.names)))))

    return [
        whole(tuple(chain.from_iterable(pieces.values())), frozenset().union(*(piece.others for piece in pieces)))
        for pieces in known
    ]
