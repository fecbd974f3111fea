"""The result of ``firmer``: from where to where bodies were moved, and how much firmer they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.public import Pictured, Record, Summary, number
from holdfast.base.text import listed
from holdfast.base.values import Table
from holdfast.engines.answers import Answers
from holdfast.queries.result import Result

STILL = 1e-9  # [m], rad: a body that moved less did not


class FirmerStep(Record):
    """One step: the ``poses`` (4, 4) of the moved bodies, by name, and how firm the assembly is with them there.

    ``least`` is the smallest push on each body [N], by its name, or the least factor of a motion, by "motion": the
    least of ``lower`` of the ``answers``, one for each push or each time. It is 0 for the names in ``undecided``, for
    which one of the answers is not known.
    """

    poses: Table[str, Float]
    least: Table[str, float]
    undecided: tuple[str, ...]
    answers: Answers

    plain = "poses least undecided"


class Firmer(Pictured, Result, Sequence[FirmerStep]):
    """Poses that are firmer and firmer, with answers: a sequence of ``steps``, from where the bodies were to the best.

    ``assembly`` is that with the bodies at the last step, and ``answers`` are those there. ``before`` and ``after`` are
    the least of all bodies, [N], or of the motion. Where the weakest cannot be made firmer, the next one was: ``least``
    of the first and the last step compares all. ``poses`` are the last ones, and ``shifts`` say how far each body was
    moved. ``solves`` counts the pushes that were asked, and ``tried`` the poses at which some were. Its
    picture shows the scene before and after.
    """

    assembly: Assembly
    steps: tuple[FirmerStep, ...]
    times: bool
    solves: int
    tried: int

    plain = "before after solves tried steps"

    def __getitem__(self, k: int) -> FirmerStep:  # type: ignore[override]
        return self.steps[k]

    def __len__(self) -> int:
        return len(self.steps)

    @property
    def before(self) -> float:
        """The least push [N], or factor of the motion, at the first step."""
        return min(self.steps[0].least.values())

    @property
    def after(self) -> float:
        """The least push [N], or factor of the motion, at the last step."""
        return min(self.steps[-1].least.values())

    @property
    def poses(self) -> Mapping[str, Float]:
        """The poses (4, 4) of the moved bodies at the last step, by name."""
        return self.steps[-1].poses

    @property
    def shifts(self) -> Mapping[str, tuple[float, float]]:
        """How far [m] the centre of mass of each body was moved, and by how many degrees it was turned, by name."""
        found = {}
        for name, new in self.poses.items():
            old, centre = self.steps[0].poses[name], np.append(self.assembly.scene.body(name).com_body, 1.0)
            turned = Rotation.from_matrix(new[:3, :3] @ old[:3, :3].T).magnitude()
            found[name] = float(np.linalg.norm((new - old) @ centre)), float(np.degrees(turned))
        return found

    def summary(self) -> Summary:
        """Summarise from what to what each body became firmer, and what was moved."""
        unit = "times" if self.times else "N"
        ways = {
            name: [*([number(1e3 * far, "mm")] if far > STILL else []), *([f"{number(turn)}°"] if turn > STILL else [])]
            for name, (far, turn) in self.shifts.items()
        }
        moved = [f"{name} by {' and '.join(way)}" for name, way in ways.items() if way]

        def shown(step: FirmerStep, name: str) -> str:
            return "undecided" if name in step.undecided else number(step.least[name], unit)

        first, last = self.steps[0], self.steps[-1]
        rows = [[name, shown(first, name), shown(last, name)] for name in first.least]
        headline = f"least {number(self.before, unit)} became {number(self.after, unit)}; moved {listed(moved)}"
        if first.undecided and not self.before:
            headline = f"undecided: {first.answers.undecided.text}; moved {listed(moved) or 'nothing'}"
        elif not moved:
            headline = f"nothing was moved: no step within the limits is firmer than {number(self.before, unit)}"
        facts = [("poses tried", f"{self.tried:,}"), ("pushes asked", f"{self.solves:,}"), *self.facts()]
        return Summary(headline, facts, ("least on", "before", "after"), rows, self.notes)
