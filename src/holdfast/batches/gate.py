"""Check data sets: which scenes pass, fail or are undecided, and what changed since a baseline."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final, Literal, NamedTuple

import numpy as np

from holdfast.base.arrays import checked_number
from holdfast.base.borders.worker import ANSWERED
from holdfast.base.public import at_most, number
from holdfast.base.text import listed
from holdfast.batches.result import BatchTables
from holdfast.batches.tables import Row
from holdfast.queries.result import NAMED

Result = Literal["passed", "failed", "undecided"]
PASSED: Final = "passed"
FAILED: Final = "failed"
UNDECIDED: Final = "undecided"
RENEW = "if this is meant, make a new baseline: `holdfast check ... --out DIR`"
READERS = """what a reader asks for is given by --options FILE, as {"load": {"friction": 0.5}}"""
MORE = {"time": "give it longer, --seconds", "memory": "give it more, --megabytes"}  # by the outcome of a scene


@dataclass(frozen=True)
class GateRules:
    """The requirements: a scene must stand if ``stands``, and withstand pushes of ``min_force`` [N] unless it is None.

    Compared with a baseline, a body may have moved by ``distance`` [m] and turned by ``angle`` [deg], and the weakest
    push may have changed by the share ``force``. Raises SceneError for a number that is negative or not finite.
    """

    stands: bool = False
    min_force: float | None = None
    distance: float = 1e-6
    angle: float = 1e-4
    force: float = 0.01

    def __post_init__(self) -> None:
        given = {"--min-force": self.min_force, "--distance": self.distance}
        for flag, value in (given | {"--turn-degrees": self.angle, "--change": self.force}).items():
            if value is not None:  # NaN would pass everything
                checked_number(value, flag, minimum=0)


class Finding(NamedTuple):
    """The result of a scene, the reason, the time that its answers took [s], and what helps unless it passes."""

    scene: str
    result: Result
    reason: str
    seconds: float = 0.0
    remedy: str = ""


@dataclass(frozen=True)
class Scenes:
    """The rows of a batch by the names of its scenes, and the rows of their bodies by name."""

    rows: Mapping[str, Row]
    bodies: Mapping[str, Mapping[str, Row]] = field(default_factory=dict)

    @staticmethod
    def of(tables: BatchTables) -> Scenes:
        """Read the rows of a batch."""
        bodies: dict[str, dict[str, Row]] = {}
        for row in tables.rows("bodies"):
            bodies.setdefault(row["scene"], {})[row["body"]] = row
        return Scenes({row["scene"]: row for row in tables.rows("scenes")}, bodies)


def findings(scenes: Scenes, rules: GateRules, baseline: Scenes | None = None) -> Iterator[Finding]:
    """Yield the finding of every scene, and of every scene that only the baseline has."""
    for name, row in scenes.rows.items():
        result, reason = judged(row, rules)
        if result != PASSED and row.get("settled_reason"):
            reason = "; ".join([reason, *faults(row, scenes.bodies.get(name, {}))])
        if baseline is not None and name in baseline.rows:
            changed = list(changes(row, baseline.rows[name], rules))
            changed += moves(scenes.bodies.get(name, {}), baseline.bodies.get(name, {}), rules)
            if changed:
                result, reason = FAILED, "; ".join(filter(None, [reason, f"changed: {', '.join(changed)}"]))
        yield Finding(name, result, reason, row["seconds"] or 0.0, "" if result == PASSED else remedy(row, rules))
    if baseline is not None:
        for name in baseline.rows:
            if name not in scenes.rows:
                yield Finding(name, FAILED, "is missing: only the baseline has it", remedy=RENEW)


def judged(row: Row, rules: GateRules) -> tuple[Result, str]:
    """Return the result of a scene without a baseline, and the reason unless it passes.

    A scene withstands ``min_force`` if no lower bound is below it, and fails if a decided force is. It is undecided in
    between, and if answers are missing.
    """
    if row["outcome"] != ANSWERED:
        return FAILED, f"{row['outcome']}: {row['problem']}"
    if rules.stands and row["status"] != "stable":
        reason = f"{row['status']}: {row['reason']}"
        return (FAILED if row["status"] == "unstable" else UNDECIDED), reason
    if rules.stands and row.get("crushed"):
        return FAILED, f"crushed: {listed(row['crushed'], NAMED)}"
    if rules.min_force is None:
        return PASSED, ""
    wanted, weakest, lower = rules.min_force, row["weakest"], row["weakest_lower"]
    if weakest is not None and weakest < wanted:
        what = listed(row.get("weakest_moving") or ["something"], NAMED)
        return (
            FAILED,
            f"{number(weakest, 'N')} on {row['weakest_body']} moves {what}, {number(wanted, 'N')} is wanted",
        )
    if row["undecided"]:
        return UNDECIDED, f"{row['undecided']:,} answers are undecided"
    if lower is None:
        return UNDECIDED, "no push was computed"
    if lower < wanted:
        return UNDECIDED, f"only {at_most(lower, 'N')} is certain, {number(wanted, 'N')} is wanted"
    return PASSED, ""


def remedy(row: Row, rules: GateRules) -> str:
    """Return what helps a scene that does not pass: the command that shows why, or one that mends it."""
    if judged(row, rules)[0] == PASSED:
        return RENEW  # all that is wrong is a change
    if row["outcome"] != ANSWERED:
        asks = re.search(r"\bgive \w+=", row["problem"] or "")  # an error says itself what helps, but for Python
        return READERS if asks else MORE.get(row["outcome"], "")
    path = row.get("path") or row["scene"]
    file = shlex.quote(f"./{path}" if path.startswith("-") else path)
    if row.get("settled_reason"):  # a state of --states: the model alone has another pose
        file += " --qpos Q,Q,..."
    if row["status"] != "stable":
        return f"`holdfast assess {file}` shows why, `holdfast settle {file}` where it would come to rest"
    if row.get("crushed"):
        return f"`holdfast assess {file}` shows what lies on them"
    return f"`holdfast map {file}` shows where it is weak, `holdfast firmer` moves bodies to where it bears more"


def faults(row: Row, bodies: Mapping[str, Row]) -> Iterator[str]:
    """Yield what hovers and sinks in a scene, and where it settles."""
    for name, body in bodies.items():
        if body["hovers"] is not None:
            yield f"{name} hovers {_length(body['hovers'])} above {body['above'] or 'nothing'}"
        if body["sinks"] is not None:
            yield f"{name} sinks {_length(body['sinks'])} into {body['into']}"
    if row["settled"] == "stable":
        yield f"settles by {_length(row['moved'])}"
    else:
        yield f"does not settle: {row['settled_reason']}"


def _length(metres: float) -> str:
    return f"{1e3 * metres:.3g} mm"


def changes(row: Row, before: Row, rules: GateRules) -> Iterator[str]:
    """Yield the changes of the outcome, the verdict and the weakest push of a scene."""
    for name in ("outcome", "status"):
        if row[name] != before[name]:
            yield f"{name} from {before[name]} to {row[name]}"
    old, new = before["weakest"], row["weakest"]
    both = old is not None and new is not None
    if old != new and not (both and math.isfinite(old) and abs(new - old) <= rules.force * abs(old)):
        said = ["none" if force is None else number(force, "N") for force in (old, new)]
        yield f"weakest push from {said[0]} to {said[1]}"


def moves(bodies: Mapping[str, Row], before: Mapping[str, Row], rules: GateRules) -> Iterator[str]:
    """Yield which bodies are new, gone or at another pose."""
    for what, names in (("new", bodies.keys() - before.keys()), ("gone", before.keys() - bodies.keys())):
        if names:
            yield f"{what}: {listed(sorted(names))}"
    for name in sorted(bodies.keys() & before.keys()):
        a, b = bodies[name], before[name]
        shift, turn = float(np.linalg.norm([a[axis] - b[axis] for axis in "xyz"])), _turn(a, b)
        if shift > rules.distance:
            yield f"{name} moved by {shift * 1e3:.3g} mm"
        if turn > rules.angle:
            yield f"{name} turned by {turn:.3g} degrees"


def _turn(a: Row, b: Row) -> float:
    """Return the angle [deg] between two rotations: 4 arcsin(|p - q| / 2) of their quaternions, of either sign."""
    p, q = (np.array([row[f"q{axis}"] for axis in "xyzw"]) for row in (a, b))
    apart = min(float(np.linalg.norm(p - q)), float(np.linalg.norm(p + q)))
    return float(np.degrees(4 * np.arcsin(min(apart / 2, 1.0))))
