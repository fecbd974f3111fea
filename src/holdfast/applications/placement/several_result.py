"""The result of placing several objects."""

from __future__ import annotations

from typing import Any

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.public import Pictured, PublicValue, Record, Summary, column, number
from holdfast.base.text import listed
from holdfast.engines.answers import Claim
from holdfast.engines.verdict import Status
from holdfast.queries.result import vector_text


class PlacedObject(Record):
    """One step: the ``body`` that is placed and its ``pose`` (4, 4), body frame to world.

    ``own`` [N] is the smallest push on it that moves something right after this step. ``rests_on`` names the bodies
    that it touches or rests on, down to the ground, and ``beneath`` [N] is the smallest push on the movable ones, but
    for those that were only balanced before; inf if there are none. Both forces are from the decided points of a coarse
    map, and None if no point is decided. ``balanced`` tells that the object is only balanced, as a ball is: ``own`` is
    then 0.
    """

    body: str
    pose: Float = column("4 4")
    own: float | None
    beneath: float | None
    rests_on: tuple[str, ...]

    @property
    def least(self) -> float | None:
        """The smaller of ``own`` and ``beneath`` [N], or None if neither is known.

        An object that is only balanced rolls wherever it lies: what counts is ``beneath``, None if all that is fixed.
        """
        if self.balanced:
            return None if self.beneath is None or np.isinf(self.beneath) else self.beneath
        return min((force for force in (self.own, self.beneath) if force is not None), default=None)

    @property
    def balanced(self) -> bool:
        """Whether the object is only balanced: the slightest push moves it."""
        return self.own == 0

    @property
    def least_text(self) -> str:
        """The smallest push in words."""
        if self.balanced:
            return "only balanced"
        return "undecided" if self.least is None else number(self.least, "N")


class Placements(Pictured, PublicValue, ask=".stable, which says whether every object has a place, or .status"):
    """Where several objects can be put down, one after the other, so that everything stands after each step.

    ``status`` is one of three. STABLE: every object has a place. UNSTABLE: the scene does not stand before anything is
    put down. UNDECIDED: some objects, which ``left`` names, have found no place, which does not prove that there is
    none; or it is not known whether the scene stands. ``reason`` explains the status.

    ``steps`` are those of the best of ``tries`` attempts, ``assembly`` is the assembly after them, and ``apart`` [m] is
    the smallest distance between the objects. ``engine`` and ``claim`` hold for all forces. ``elapsed`` [s] is the
    total time. Its picture shows the states after the steps, with the object that was placed last in colour.
    """

    assembly: Assembly
    status: Status
    reason: str
    steps: tuple[PlacedObject, ...]
    left: tuple[str, ...]
    apart: float
    tries: int
    engine: str
    claim: Claim
    elapsed: float

    plain = "status reason engine claim order left apart least steps tries elapsed"

    @property
    def stable(self) -> bool:
        """Whether every object has a place where everything certainly stands."""
        return self.status is Status.STABLE

    @property
    def order(self) -> tuple[str, ...]:
        """The names of the objects in the order in which they are placed."""
        return tuple(step.body for step in self.steps)

    @property
    def poses(self) -> dict[str, Float]:
        """The poses (4, 4) of the objects by their names, body frame to world."""
        return {step.body: step.pose for step in self.steps}

    @property
    def weakest(self) -> PlacedObject | None:
        """The step with the smallest ``least``, or None if no force is known."""
        known = [(step.least, k) for k, step in enumerate(self.steps) if step.least is not None]
        return self.steps[min(known)[1]] if known else None

    @property
    def least(self) -> float:
        """The smallest push [N] of all steps, leaving out objects that are only balanced; 0 if none is known."""
        return 0.0 if self.weakest is None or self.weakest.least is None else self.weakest.least

    def about(self) -> dict[str, Any]:
        """Return the name of the scene as plain data."""
        return {"scene": self.assembly.scene.name}

    def summary(self) -> Summary:
        """Summarise where every object goes, in order."""
        whole = len(self.steps) + len(self.left)
        headline = f"{len(self.steps)} of {whole} objects placed: {self.reason}"
        facts = [("engine", f"{self.engine} ({self.claim.words})"), ("tried", f"{self.tries} in {self.elapsed:.2g} s")]
        balanced = [step.body for step in self.steps if step.balanced]
        if balanced:
            facts.insert(0, ("only balanced", f"{listed(balanced)}: the slightest push moves it"))
        if self.weakest is not None:
            facts.insert(0, ("least push of all steps", f"{number(self.least, 'N')}, after {self.weakest.body}"))
        rows = [
            [
                str(k + 1),
                step.body,
                f"{vector_text(step.pose[:3, 3], '.4g')} m",
                listed(step.rests_on),
                step.least_text,
            ]
            for k, step in enumerate(self.steps)
        ]
        return Summary(headline, facts, ("step", "put down", "at", "on", "least push"), rows)
