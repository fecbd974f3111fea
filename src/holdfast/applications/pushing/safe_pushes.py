"""Find pushes on a body that move nothing, and pushes that move the body but none of its neighbours.

The effect of a push must be the same for three cases of friction: as given, and with all other contacts weaker by a
share, while the body's own contacts are either stronger (so that it drags its neighbours most) or weaker (so that it
yields first). Limit analysis must prove for each case that the body moves; that nothing else moves follows from the
mechanism at the end of the load path. The assembly with the moved body must also stand, without new contacts.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum, auto

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.node_motion import displaced
from holdfast.base.archive import archived
from holdfast.base.arrays import Bool, Float, Objects, checked_directions, checked_number, frozen, objects
from holdfast.base.errors import HoldfastError, SceneError, message, no_truth
from holdfast.base.progress import reported
from holdfast.base.public import PublicValue, Summary, at_most, column, number
from holdfast.base.ranges import COORDINATES, FORCE, LENGTH
from holdfast.base.text import listed, quoted
from holdfast.base.values import Value
from holdfast.engines.answers import Answers, Claim, joined_notes
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.verdict import Status
from holdfast.geometry.distance import rod_clearance
from holdfast.queries import request
from holdfast.queries.map import exposed_cells, spacing_for
from holdfast.queries.push import load_factors
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice
from holdfast.queries.result import places_of, vector_text
from holdfast.scene.scene import Scene

SHOWN = 6  # largest number of rows of each effect in a summary
LONG = 2.0  # length of the tool, in sizes of the assembly
POINTS = 100  # approximate default number of surface points
OBLIQUE = 30.0  # [deg] largest angle between a push and the inward normal: at a larger one, the tool might slip
DOUBT = 0.2  # share by which friction may differ from the given coefficients
PARTS = (0.5, 1.0)  # shares of the travel at which the assembly is checked
SAME = 6  # decimals [m] to which equal poses agree


@archived
class Effect(StrEnum):
    """What a push certainly moves: NOTHING, the pushed body ALONE, or OTHERS too; UNKNOWN if that is not certain."""

    NOTHING = auto()
    ALONE = auto()
    OTHERS = auto()
    UNKNOWN = auto()

    def __bool__(self) -> bool:
        raise no_truth(self, f"compare it: effect == {self.value!r}")


class SafePushes(PublicValue):
    """What pushes of up to ``force`` [N] on ``body`` do, at n points that the tool can reach.

    ``points`` (n, 3) [m] and the unit ``directions`` (n, 3) are in the world frame. ``effect`` (n,) holds an Effect for
    each push, with the ``reason`` (n,) in words: NOTHING moves at any force up to this one; the body moves ALONE, by
    ``travel`` [m], when it is pushed slowly by a tool that yields at this force; OTHERS move too; or it is UNKNOWN.
    NOTHING and ALONE hold for the given friction and for friction that differs by the share ``doubt``, at the contacts
    of the body and at all others.

    For all these cases of friction, nothing moves at ``lower`` (n,) [N], by the engine's bound, and something certainly
    moves at ``upper`` (n,) [N], by limit analysis. ``unreached`` is the number of pushes that were skipped because the
    tool, of radius ``tool_radius`` [m], would touch another body.
    """

    body: str
    engine: str
    claim: Claim
    force: float
    points: Float = column("n 3")
    directions: Float = column("n 3")
    effect: Objects = column("n", of=Effect)
    reason: Objects = column("n", of=str)
    lower: Float = column("n")
    upper: Float = column("n")
    unreached: int
    tool_radius: float
    travel: float
    doubt: float
    notes: tuple[str, ...]

    @property
    def nothing(self) -> Bool:
        """Which pushes (n,) move nothing."""
        return self.are(Effect.NOTHING)

    @property
    def alone(self) -> Bool:
        """Which pushes (n,) move the body and no other one."""
        return self.are(Effect.ALONE)

    def are(self, effect: Effect) -> Bool:
        """Return which pushes (n,) have this effect."""
        return frozen(np.asarray(self.effect == effect))

    def checked_after_load(self) -> None:
        """Raise HoldfastError if the columns that were read from a file are not those of pushes."""
        if (self.lower[self.nothing] < self.force).any() or (self.upper[self.alone] > self.force).any():
            problem = "the bounds of a push contradict its effect"
            raise HoldfastError(message("pushes: effect", problem, "needs what was saved"))

    def summary(self) -> Summary:
        """Summarise the answer by the number of pushes with each effect, and some examples."""
        count = Counter(self.effect.tolist())
        counts = f"{count[Effect.ALONE]} move it alone, {count[Effect.NOTHING]} nothing"
        headline = f"{len(self.effect)} pushes of {number(self.force, 'N')} on {self.body}: {counts}"
        facts = [("engine", f"{self.engine} ({self.claim.words})")]
        facts += [(f"{effect}", f"{count[effect]}") for effect in Effect]
        facts += [("not reached by the tool", f"{self.unreached}")]
        places = places_of(self.points)
        rows = [
            [str(effect), places[k], vector_text(self.directions[k], ".2f"), self.reason[k]]
            for effect in Effect
            for k in self.are(effect).nonzero()[0][:SHOWN].tolist()
        ]
        return Summary(headline, facts, ("moves", "at", "along", "why"), rows, self.notes)


@dataclass(frozen=True, eq=False, repr=False)
class Tool(Value):
    """The tool that pushes a body: a straight rod with a round tip.

    - ``radius`` [m]: the radius of the rod, which must reach a point without touching another body.
    - ``travel`` [m]: how far it pushes the body. Nothing else may move or be in the way until then.

    Raises SceneError for a number out of range.
    """

    radius: float = 0.0
    travel: float = 0.005

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "radius", checked_number(self.radius, "Tool: radius", minimum=0, within=LENGTH))
        set_(self, "travel", checked_number(self.travel, "Tool: travel", above=0, within=LENGTH))


def reached(assembly: Assembly, body: str, points: Float, normals: Float, directions: Float, radius: float) -> Bool:
    """Return which of n pushes a rod with a round tip, both of ``radius`` [m], can make along its axis.

    Its tip touches the ``body`` at ``points`` (n, 3) [m] from outside, on the side of the outward unit ``normals``
    (n, 3), and the rod extends from there along minus ``directions`` (n, 3). It must not enter the pushed body, and
    must be further from every other body than the contact tolerance of the two.
    """
    pushed = assembly.scene.body(body)
    apart = assembly.tolerances.of(pushed) + pushed.shape.surface.sagitta
    tip = points + (radius + apart) * normals
    back = -LONG * assembly.size * directions
    slack = COORDINATES * assembly.size
    free = rod_clearance(tip, back, pushed.surface_world) >= max(radius - slack, slack)
    for other in assembly.bodies:
        if other.name != body:
            needed = radius + assembly.tolerances.base(pushed, other)
            free[free] = rod_clearance(tip[free], back[free], other.surface_world) >= needed - slack
    return np.asarray(free)


def safe_pushes(
    assembly: Assembly | Scene,
    body: str,
    force: float,
    *,
    directions: ArrayLike | None = None,
    spacing: float | None = None,
    tool: Tool | None = None,
    doubt: float = DOUBT,
    engine: EngineChoice = DEFAULT_ENGINE,
) -> SafePushes:
    """Find where ``body`` can be pushed with up to ``force`` [N] so that nothing moves, or so that it moves alone.

    The exposed surface is pushed at points about ``spacing`` [m] apart (by default about 100 points): inwards along the
    normal, or along those of ``directions`` (k, 3) that are within 30 degrees of it. ``tool`` describes what pushes and
    how far, see Tool. ``doubt`` is the share by which friction may differ from the given coefficients. Pushes are
    quasi-static, and the tool follows the body.

    Raises SceneError if the body is fixed or unknown. Raises HoldfastError if the engine does not claim that contacts
    hold (Claim.HOLDS).
    """
    assembly = request.checked_assembly(assembly)
    where = f"safe pushes on {quoted(body)}"
    most = checked_number(force, f"{where}: force", above=0, within=FORCE)
    rod = request.checked_options(tool, Tool, f"{where}: tool")
    share = checked_number(doubt, f"{where}: doubt", minimum=0, below=1)
    method = request.engine_of(engine)
    if method.claim is not Claim.HOLDS:
        raise HoldfastError(message(where, f"engine {method.name!r} does not claim that it holds", "use 'compliant'"))
    if request.body_number(assembly, body) == FIXED:
        raise SceneError(message(where, "the body is fixed: no push moves it", "name a movable body"))
    if spacing is None:
        step = spacing_for(assembly, [body], POINTS)
    else:
        step = checked_number(spacing, f"{where}: spacing", above=0, within=LENGTH)
    points, normals, along = _candidates(assembly, body, step, directions, where)
    free = reached(assembly, body, points, normals, along, rod.radius)
    points, along = points[free], along[free]
    trials = _Trials(assembly, body, method, most, rod.travel, share)
    effect, reason, lower, upper, notes = trials.judged(points, along)
    return SafePushes(
        body=body,
        engine=method.name,
        claim=method.claim,
        force=most,
        points=points,
        directions=along,
        effect=objects(effect),
        reason=objects(reason),
        lower=lower,
        upper=upper,
        unreached=int((~free).sum()),
        tool_radius=rod.radius,
        travel=rod.travel,
        doubt=share,
        notes=notes,
    )


def _candidates(
    assembly: Assembly, body: str, spacing: float, directions: ArrayLike | None, where: str
) -> tuple[Float, Float, Float]:
    """Return points (n, 3) [m] of the exposed surface, their outward normals and the directions of the pushes there."""
    cells = exposed_cells(assembly, body, spacing)[0]
    if directions is None:
        return cells.points, cells.normals, -cells.normals
    ways = checked_directions(directions, f"{where}: directions").reshape(-1, 3)
    point, way = np.nonzero(-cells.normals @ ways.T >= np.cos(np.radians(OBLIQUE)) - 1e-9)
    return cells.points[point], cells.normals[point], ways[way]


@dataclass(frozen=True)
class _Trials:
    """Pushes of up to ``force`` [N] on one ``body``, for several frictions."""

    assembly: Assembly
    body: str
    engine: Engine
    force: float
    travel: float
    doubt: float

    def judged(self, points: Float, along: Float) -> tuple[list[Effect], list[str], Float, Float, tuple[str, ...]]:
        """Return effects and reasons, the least lower and the largest upper bounds (n,), and the notes."""
        columns = request.push_columns(self.assembly, self.assembly.index[self.body], points, along)
        mine = np.array([self.body in interface.bodies for interface in self.assembly.interfaces], dtype=bool)
        cases = [(1.0, 1.0), (1 + self.doubt, 1 - self.doubt), (1 - self.doubt, 1 - self.doubt)]
        mu = np.array(self.assembly.mu)
        kinds = [self.assembly.with_mu((mu * np.where(mine, own, others)).tolist()) for own, others in cases]
        frictions = kinds if self.doubt > 0 else kinds[:1]
        still = self._still(frictions, columns)
        rest = np.flatnonzero(~still)
        found = [
            load_factors(self.engine, each, columns[:, rest], np.zeros(len(columns)), bounds=True)
            for each in reported("pushes with other friction", frictions)
        ]
        lower, upper = np.full(len(points), self.force), np.full(len(points), np.inf)
        lower[rest] = np.min([answers.lower for answers in found], axis=0, initial=np.inf)
        upper[rest] = np.max([answers.upper for answers in found], axis=0, initial=0.0)
        effect, reason = [], []
        states: dict[bytes, str] = {}
        row = np.cumsum(~still) - 1
        for k in reported("pushes", range(len(points))):
            if still[k]:
                one, why = Effect.NOTHING, _still(self.force)
            else:
                one, why = self._effect(found, int(row[k]), float(lower[k]), float(upper[k]))
            if one is Effect.ALONE:
                trouble = self._moved(found, int(row[k]), states)
                one, why = (Effect.UNKNOWN, trouble) if trouble else (one, why)
            effect.append(one)
            reason.append(why)
        return effect, reason, lower, upper, joined_notes(answers.notes for answers in found)

    def _still(self, frictions: Sequence[Assembly], columns: Float) -> Bool:
        """Return which pushes (n,) certainly move nothing up to the force, for all these cases of friction.

        This takes load paths up to the force only, which is cheaper than full answers.
        """
        still = np.ones(columns.shape[1], dtype=bool)
        for each in reported("pushes that move nothing", frictions[::-1]):  # the weakest friction first
            rows = np.flatnonzero(still)
            if len(rows):
                still[rows] = prepared(self.engine, each).held(self.force * columns[:, rows])
        return still

    def _effect(self, found: list[Answers], k: int, lower: float, upper: float) -> tuple[Effect, str]:
        """Judge one push by its bounds and by what gives way first, over all cases of friction."""
        for answers in found:
            if answers.verdict.status is not Status.STABLE:
                return Effect.UNKNOWN, f"whether it stands without a push: {answers.verdict.reason}"
            if answers.status[k] is Status.UNDECIDED:
                return Effect.UNKNOWN, answers.undecided.text
        if lower >= self.force:
            return Effect.NOTHING, _still(lower)
        if upper > self.force:
            return Effect.UNKNOWN, f"something may move above {lower:.3g} N, and certainly moves above {upper:.3g} N"
        others = [tuple(name for name in answers.moving[k] if name != self.body) for answers in found]
        if all(others):
            return Effect.OTHERS, f"it moves {listed(others[0])} as well"
        if any(others):
            return Effect.UNKNOWN, f"with other friction it moves {listed(next(filter(None, others)))} as well"
        if any(answers.force[k] == 0 for answers in found):
            return Effect.UNKNOWN, "it is only balanced: pushed, it may roll on by itself"
        if any(self.body not in answers.moving[k] or answers.mechanism[k] is None for answers in found):
            return Effect.UNKNOWN, "what moves was not found"
        return Effect.ALONE, f"it moves alone, from {lower:.3g} to {upper:.3g} N on"

    def _moved(self, found: list[Answers], k: int, states: dict[bytes, str]) -> str:
        """Say what is wrong with the assembly after the body has moved; empty if it stands in all cases."""
        body, index = self.assembly.scene.body(self.body), self.assembly.index[self.body]
        centre = self.assembly.com[index]
        arms = body.surface_world.vertices - centre
        for answers in found:
            twist = answers.mechanism[k].twists[index]
            speed = float(np.linalg.norm(twist[:3] + np.cross(twist[3:], arms), axis=1).max())
            for part in PARTS:
                pose = displaced(body.pose, part * self.travel / speed * twist, centre)
                key = np.round(pose, SAME).tobytes()
                if key not in states:
                    states[key] = self._trouble(pose)
                if states[key]:
                    return f"pushed on by {part * self.travel * 1e3:.3g} mm {states[key]}"
        return ""

    def _trouble(self, pose: Float) -> str:
        """Say why the assembly with the body at another pose may not stand; empty if it certainly stands."""
        if not self.assembly.detected:
            return "it may touch others: the contacts were given, so new ones cannot be detected"
        try:
            with request.quiet():
                moved = self.assembly.moved({self.body: pose})
        except HoldfastError as error:
            return f"is not known: {error}"
        known = {frozenset(interface.bodies) for interface in self.assembly.interfaces}
        new = {
            name
            for interface in moved.interfaces
            if frozenset(interface.bodies) not in known
            for name in interface.bodies
        }
        if new:
            return f"it would touch {listed(sorted(new - {self.body}))}"
        group = self.assembly.groups[int(self.assembly.group_of[self.assembly.index[self.body]])]
        verdict = prepared(self.engine, moved).verdict_on([moved.index[name] for name in group])
        if verdict.status is Status.STABLE:
            return ""
        falls = () if verdict.mechanism is None else verdict.mechanism.moving
        return f"{listed(falls)} would move on" if falls else f"is not known to stand: {verdict.reason}"


def _still(force: float) -> str:
    return f"nothing moves below {at_most(force, 'N')}"
