"""What placement planning answers."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from holdfast.applications.placement.support import SupportPoints
from holdfast.assembly.assembly import Assembly
from holdfast.base.archive import archived, to_dict
from holdfast.base.arrays import Float
from holdfast.base.painters import paint
from holdfast.base.public import Summary, number
from holdfast.base.values import Table, Value, seal
from holdfast.contacts.interface import Interface
from holdfast.engines.verdict import Status
from holdfast.queries.map import MapPoint, RobustnessMap
from holdfast.queries.result import Result, gives_way
from holdfast.scene.body import Body


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Candidate(Value):
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

    def __post_init__(self) -> None:
        seal(self)


@archived
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Placement(Result):
    """Where an object can be put down.

    ``status`` STABLE: ``pose`` (4, 4), body to world, is one in which everything stands; ``robustness`` [N] is the
    least inward push, over all exposed points of movable bodies, that then moves something, at ``weakest``;
    ``contacts`` are the interfaces of the placed ``body`` in ``assembly``, the assembly afterwards, and ``map`` all its
    pushes; ``points`` and ``normals`` (k, 3) those of the scene that the pose was built on, of all in ``support``.
    UNSTABLE: the scene does not stand before anything is put down. UNDECIDED: no place was found (``reason`` tells what
    was in the way), which is no proof that there is none; or the scene is undecided. Without a place ``pose``, ``map``
    and what comes from it are None, ``robustness`` 0, and ``best`` the attempt that came nearest.

    ``candidates`` are all stable poses found, the returned one first; ``attempts`` counts all tries, ``faults`` those
    that failed by what was wrong. ``time_to_stable`` and ``elapsed`` [s]: until the first stable pose, and in all.
    ``answers`` are those of ``map``, and none without it: ``verdict`` is then that of the scene.
    """

    name: str
    status: Status
    reason: str
    map: RobustnessMap | None = None
    candidates: tuple[Candidate, ...] = ()
    best: Candidate | None = None
    attempts: int
    faults: Table[str, int]
    support: SupportPoints | None = None
    time_to_stable: float | None = None
    elapsed: float

    @property
    def assembly(self) -> Assembly | None:
        """The assembly with the object in place."""
        return None if self.map is None else self.map.assembly

    @property
    def body(self) -> Body | None:
        """The object in place."""
        return None if self.assembly is None else self.assembly.scene.body(self.name)

    @property
    def pose(self) -> Float | None:
        """(4, 4) where it is, body to world."""
        return self.candidates[0].pose if self.candidates else None

    @property
    def points(self) -> Float:
        """(k, 3) points of the scene that the pose was built on [m]."""
        return self.candidates[0].points if self.candidates else _NONE

    @property
    def normals(self) -> Float:
        """(k, 3) outward normals there."""
        return self.candidates[0].normals if self.candidates else _NONE

    @cached_property
    def weakest(self) -> MapPoint | None:
        """The weakest point of the assembly with the object in place."""
        return None if self.map is None else self.map.weakest()

    @property
    def robustness(self) -> float:
        """The least push [N] that then moves something, 0 without a place."""
        return 0.0 if self.weakest is None else self.weakest.force

    @property
    def contacts(self) -> tuple[Interface, ...]:
        """The interfaces of the object in place."""
        return () if self.assembly is None else tuple(i for i in self.assembly.interfaces if self.name in i.bodies)

    def save_png(self, path: str | os.PathLike[str], *, seed: int = 0) -> None:
        """Draw the points it was built on and the pose; ``seed`` chooses which of the sampled points are shown."""
        paint(self, path, ".png", seed=seed)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON, without the meshes and pushes of the map."""
        names = (
            *("name", "status", "reason", "pose", "robustness", "weakest", "attempts", "faults", "candidates", "best"),
            *("points", "normals", "time_to_stable", "elapsed"),
        )
        return self.about() | {name: to_dict(getattr(self, name)) for name in names}

    def summary(self) -> Summary:
        """Where it goes, or why not."""
        facts = [("reason", self.reason), ("attempts", f"{self.attempts} in {self.elapsed:.2g} s"), *self.facts()]
        if self.pose is None:
            return Summary(f"no place found for {self.name}: {self.reason}", facts, notes=self.notes)
        place = "(" + ", ".join(f"{v + 0.0:.4g}" for v in self.pose[:3, 3]) + ") m"
        if self.weakest is not None:
            what = gives_way(self.weakest.mode, self.weakest.moving)
            facts.insert(0, ("least push afterwards", f"{number(self.robustness, 'N')} on {self.weakest.body}: {what}"))
        return Summary(f"{self.name} stands at {place}", facts, notes=self.notes)


_NONE = np.empty((0, 3))
_NONE.setflags(write=False)
