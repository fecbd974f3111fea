"""What placement planning answers."""

from __future__ import annotations

from dataclasses import dataclass

from holdfast.applications.placement.support import SupportPoints
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.contacts.interface import Interface
from holdfast.engines.contract import Claim, Status
from holdfast.queries.map import MapPoint
from holdfast.scene.body import Body


@dataclass(frozen=True, eq=False)
class Candidate:
    """A pose that was tried.

    ``fault`` says in words why it was refused, empty for a stable one, whose ``robustness`` [N] is then that of a
    coarse map (None where it was not needed). ``points`` (k, 3) [m] are those of the scene that it was built on, with
    outward ``normals`` (k, 3).
    """

    pose: Float
    points: Float
    normals: Float
    fault: str
    robustness: float | None = None


@dataclass(frozen=True, eq=False)
class Placement:
    """Where an object can be put down.

    ``status`` STABLE: ``pose`` (4, 4), body to world, is one in which everything stands; ``robustness`` [N] is the
    least inward push, over all exposed points of movable bodies, that then moves something, at ``weakest``;
    ``contacts`` are the interfaces of the placed body in ``assembly``, the assembly afterwards; ``points`` and
    ``normals`` (k, 3) those of the scene that the pose was built on, of all in ``support``. UNSTABLE: the scene does
    not stand before anything is put down. UNDECIDED: no place was found (``reason`` tells what was in the way), which
    is no proof that there is none; or the scene is undecided. Without a place ``pose`` is None, ``robustness`` 0, and
    ``best`` the attempt that came nearest.

    ``candidates`` are all stable poses found, the returned one first; ``attempts`` counts all tries, ``faults`` those
    that failed by what was wrong. ``time_to_stable`` and ``elapsed`` [s]: until the first stable pose, and in all.
    """

    engine: str
    claim: Claim
    status: Status
    reason: str
    pose: Float | None
    robustness: float
    weakest: MapPoint | None
    contacts: tuple[Interface, ...]
    attempts: int
    faults: dict[str, int]
    candidates: tuple[Candidate, ...]
    best: Candidate | None
    points: Float
    normals: Float
    support: SupportPoints | None
    body: Body | None
    assembly: Assembly | None
    time_to_stable: float | None
    elapsed: float
    notes: tuple[str, ...]
