"""Bring a perceived or authored scene to rest near its given poses, and report what moved, what fell and why."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from holdfast.assembly.assembly import assemble
from holdfast.assembly.caution import doubts_of_scene
from holdfast.base.archive import to_dict
from holdfast.base.arrays import Float, checked_number
from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.public import Pictured, PublicValue, Record, Summary, column, number
from holdfast.base.ranges import BETWEEN, LENGTH, TOLERANCE
from holdfast.base.text import listed, quoted
from holdfast.contacts.neighbours import alone, groups_within, joined, neighbours
from holdfast.contacts.overlap import Overlap, find_overlaps
from holdfast.contacts.tolerances import Tolerances
from holdfast.engines.verdict import Status
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice
from holdfast.queries.stability import Stability, stability
from holdfast.scene.friction import refuse_strengths
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene
from holdfast.settling.motion import CALM, NARROW, TOUCH, End, Motion, MotionLimits, come_to_rest
from holdfast.settling.moved_surfaces import turn_between, upright_pose

# The first three are shares of the travel.
SEEN = NARROW  # depth up to which overlaps are resolved by the motion itself
REMAINING = 10 * TOUCH  # depth above which remaining overlaps are an error, unless a gap is given that allows them
MEETING = CALM  # groups whose bodies end up closer to each other than this are settled again as one group
UNFINISHED = (End.GOING, End.EFFORT, End.TROUBLE)

Done = Mapping[tuple[str, ...], Motion]  # the motion of each group
LEAST = 1e-6  # [m] smaller motions count as none
STILL_GOING = 0.1  # share of the largest motion of the last step, below which a body counts as dragged along
UPWARD = 0.01  # cosine of the largest angle between up and the normal of a contact that carries weight


class Fall(Record):
    """A body that moved further than allowed, with its unit ``direction`` (3,), world frame, and ``distance`` [m]."""

    body: str
    direction: Float = column("3")
    distance: float


class Settled(Pictured, PublicValue, ask=".stable or .status"):
    """A scene brought to rest.

    ``scene`` has the new poses, ``given`` the old ones. ``status`` is STABLE if the whole new scene stands by
    ``stability``, UNSTABLE if a body fell beyond the travel or the new scene does not stand, and UNDECIDED otherwise,
    as where overlaps end only beyond the travel; ``reason`` says why. ``names`` are the J movable bodies in scene
    order. ``moved`` (J,) [m] is the distance between the old and the new centre of mass of each, ``turned_degrees``
    (J,) the angle of its rotation, and ``reasons`` say why it moved. ``fell`` holds the bodies that moved further than
    ``travel`` [m]; the motion of their groups was stopped there, so the poses of these have no further meaning.
    ``stability`` is the verdict on all other groups, None if there is none. ``steps`` is the number of steps of the
    motion. Its picture shows the bodies at rest, faintly also where they were, with arrows along which they moved or
    fall.
    """

    scene: Scene
    given: Scene
    status: Status
    reason: str
    names: tuple[str, ...]
    moved: Float = column("J")
    turned_degrees: Float = column("J")
    reasons: tuple[str, ...]
    fell: tuple[Fall, ...]
    stability: Stability | None
    travel: float
    steps: int
    notes: tuple[str, ...]

    plain = "fell travel steps notes"

    @property
    def stable(self) -> bool:
        """Whether the scene certainly stands at its new poses: False also where that is undecided."""
        return self.status is Status.STABLE

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON, with the new pose of each body."""
        bodies = [
            {
                "body": name,
                "moved": float(self.moved[k]),
                "turned_degrees": float(self.turned_degrees[k]),
                "reason": self.reasons[k],
                "pose": to_dict(self.scene.body(name).pose),
            }
            for k, name in enumerate(self.names)
        ]
        return {"status": self.status.value, "reason": self.reason, "bodies": bodies} | super().to_dict()

    def summary(self) -> Summary:
        """Summarise the verdict and the displacements, the largest first."""
        order = np.argsort(-self.moved, kind="stable")
        went, turns = 1e3 * self.moved, self.turned_degrees
        rows = [(self.names[k], f"{went[k]:.3g}", f"{turns[k]:.3g}", self.reasons[k]) for k in order]
        farthest = number(1e3 * float(self.moved.max(initial=0.0)), "mm")
        facts = [("travel", number(1e3 * self.travel, "mm")), ("moved at most", farthest), ("steps", str(self.steps))]
        if self.fell:
            facts.append(("fell", listed([fall.body for fall in self.fell])))
        heads = ("body", "moved [mm]", "turned [deg]", "why")
        return Summary(f"{self.status}: {self.reason}", facts, heads, rows, self.notes)


def settle(
    scene: Scene,
    *,
    travel: float = 0.03,
    turn_degrees: float = 15.0,
    known: Iterable[str] = (),
    pose_sigma: float | Mapping[str, float] | None = None,
    upright: Iterable[str] = (),
    gap: float | None = None,
    engine: EngineChoice = DEFAULT_ENGINE,
) -> Settled:
    """Bring the movable bodies to rest under gravity and friction, near the given poses.

    First, overlaps are resolved by the smallest motions, weighted by the masses. Then the bodies sink, slide and tip
    without inertia until nothing moves (docs/howto/settle.md). A group that comes to rest but does not stand was held
    by self-stress: it is settled again, first without friction, and if the scene then stands, that is the answer. A
    body whose centre of mass moves further than ``travel`` [m], or that turns by more than ``turn_degrees``, is
    reported as falling. Overlaps deeper than ``travel`` are not resolved, and where only longer ways end overlaps, the
    answer is UNDECIDED.

    Bodies in ``known`` have exact poses: where they overlap others, the others yield; gravity moves them like any other
    body. ``pose_sigma`` [m] is the standard deviation of the positions, one for all or by body: overlapping bodies
    yield in proportion to its square over their mass. Bodies in ``upright`` are first turned, by at most
    ``turn_degrees``, so that the axis of their frame nearest to the vertical is vertical. ``gap`` and ``engine`` are
    those of ``assemble`` and ``stability`` for the verdict on the result.

    The result for a body does not depend on bodies that cannot touch it. Raises HoldfastError for an option out of
    range, and SceneError for an unknown name.
    """
    if not hasattr(scene, "movable"):
        problem = f"got a {type(scene).__name__}"
        raise HoldfastError(message("settle", problem, "needs a Scene: hf.load_scene(path) reads one from a file"))
    refuse_holds(scene.holds, "settle", "settle the scene without them, and hold it then")
    refuse_strengths(scene.friction, "settle", "leave out tension and cohesion, or give the poses of rest")
    parts = next((pair for pair in scene.excluded if not all(isinstance(end, str) for end in pair)), None)
    if parts is not None:
        problem = f"parts {quoted(parts)} do not touch, though others of the same bodies do"
        raise SceneError(
            message("settle", problem, "settle knows whole bodies only: make the parts bodies of their own")
        )
    limits = MotionLimits(
        checked_number(travel, "settle: travel", above=0, within=LENGTH),
        checked_number(turn_degrees, "settle: turn_degrees", above=0, within=BETWEEN),
    )
    exact = scene.checked_names([known] if isinstance(known, str) else known)
    sigma = _checked_sigma(scene, pose_sigma)
    start = _upright(scene, scene.checked_names([upright] if isinstance(upright, str) else upright), limits.turn)
    overlaps = find_overlaps(start, Tolerances(SEEN * limits.reach, 1.0))
    deep = tuple(o for o in overlaps if o.depth > limits.reach)

    def attempt(known: Done, smooth: frozenset[tuple[str, ...]]) -> tuple[Settled, Done]:
        result, done = _brought_to_rest(start, overlaps, deep, limits, exact, sigma, known, smooth)
        return _judged(scene, result, done, deep, limits, gap, engine), done

    found, done = attempt({}, frozenset())
    groups = () if found.stability is None else found.stability.groups
    loose = {name for g in groups if g.verdict.status is not Status.STABLE for name in g.bodies}
    # those that came to rest in the motion but do not stand, as self-stress held them
    stressed = frozenset(names for names, motion in done.items() if motion.end is End.REST and loose & set(names))
    if stressed:
        again, _ = attempt({group: motion for group, motion in done.items() if group not in stressed}, stressed)
        if again.status is Status.STABLE:
            return again
    return found


def _brought_to_rest(
    start: Scene,
    overlaps: tuple[Overlap, ...],
    deep: tuple[Overlap, ...],
    limits: MotionLimits,
    exact: frozenset[str],
    sigma: Mapping[str, float],
    known: Done,
    smooth: frozenset[tuple[str, ...]],
) -> tuple[Scene, Done]:
    """Return the scene at rest, and the motion of each group.

    ``known`` holds the motions of groups that need not be settled again. Groups in ``smooth`` first sink without
    friction.
    """
    near = groups_within(start, 2 * limits.reach)
    groups = joined([body.name for body in start.movable], _links((*near, *known, *smooth)))
    done = dict(known)
    while True:
        for group in groups:
            if group not in done and not _among(deep, group):
                here, inside, slides = alone(start, group), _among(overlaps, group), group in smooth
                done[group] = come_to_rest(
                    here, group, limits, known=exact, sigma=sigma, overlaps=inside, smooth=slides
                )
        done = {group: motion for group, motion in done.items() if group in groups}
        result = start.moved({p.start.name: p.body.pose for m in done.values() for p in m.bodies if not p.start.fixed})
        home = {name: k for k, group in enumerate(groups) for name in group}
        movable = [(a.name, b.name) for a, b in neighbours(result, MEETING * limits.reach) if not (a.fixed or b.fixed)]
        meeting = [(a, b) for a, b in movable if home[a] != home[b]]
        merged = joined([body.name for body in result.movable], [*_links(groups), *meeting])
        if merged == groups:
            return result, done
        groups = merged


def _judged(
    given: Scene,
    result: Scene,
    done: Done,
    deep: tuple[Overlap, ...],
    limits: MotionLimits,
    gap: float | None,
    engine: EngineChoice,
) -> Settled:
    """Decide whether the scene at rest stands, and describe the result in words."""
    names = tuple(body.name for body in given.movable)
    fell, words = list[Fall](), dict[str, str]()
    for group, motion in done.items():
        falls, reasons = fate_of(group, motion, limits, given.up)
        fell += falls
        words |= reasons
    resting = {name for g, m in done.items() if m.end not in (End.LEFT, End.APART) for name in g}
    verdict, faults = None, []
    if resting:
        assembly = assemble(alone(result, resting), gap=gap)
        verdict = stability(assembly, engine=engine)
        remaining = {o.bodies: 1e3 * o.depth for o in assembly.overlaps}
        if gap is None and verdict.status is Status.STABLE:
            allowed = Tolerances(REMAINING * limits.reach, 1.0)
            remaining |= {o.bodies: 1e3 * o.depth for o in find_overlaps(assembly.scene, allowed)}
        faults = [f"{quoted(a)} and {quoted(b)} by {depth:.2g} mm" for (a, b), depth in remaining.items()]
    unfinished = [f"{listed(moving(g, m))}: {m.end.value}" for g, m in done.items() if m.end in UNFINISHED]
    far = [group[k] for group, m in done.items() if m.end is not End.LEFT for k in m.left]
    status, reason = status_and_reason(verdict, [f.body for f in fell], deep, far, faults, unfinished, limits)
    for o in deep:
        words |= {n: f"overlaps {quoted(m)} by {1e3 * o.depth:.3g} mm" for n, m in (o.bodies, o.bodies[::-1])}
    before, after = given.movable, result.movable
    return Settled(
        scene=result,
        given=given,
        status=status,
        reason=reason,
        names=names,
        moved=np.array([np.linalg.norm(b.com_world - a.com_world) for a, b in zip(before, after, strict=True)]),
        turned_degrees=np.array([turn_between(a.pose, b.pose) for a, b in zip(before, after, strict=True)]),
        reasons=tuple(words.get(name, "not moved: bodies of its group overlap too deeply") for name in names),
        fell=tuple(fell),
        stability=verdict,
        travel=limits.reach,
        steps=sum(motion.steps for motion in done.values()),
        notes=(*given.notes, *doubts_of_scene(given), *unfinished),
    )


def _among(overlaps: Iterable[Overlap], group: Iterable[str]) -> list[Overlap]:
    inside = set(group)
    return [o for o in overlaps if inside & set(o.bodies)]


def _links(groups: Iterable[tuple[str, ...]]) -> list[tuple[str, str]]:
    """Return pairs of names that connect the bodies of each group."""
    return [(group[0], name) for group in groups for name in group[1:]]


def _checked_sigma(scene: Scene, value: float | Mapping[str, float] | None) -> dict[str, float]:
    """Return the standard deviations [m] of the positions by name, for the bodies that have one."""
    if value is None:
        return {}
    given = value if isinstance(value, Mapping) else {body.name: value for body in scene.movable}
    scene.checked_names(list(given))
    where = "settle: pose_sigma"
    return {
        name: checked_number(s, f"{where} of {quoted(name)}", above=0, within=TOLERANCE) for name, s in given.items()
    }


def _upright(scene: Scene, names: Iterable[str], turn: float) -> Scene:
    """Return the scene with the named bodies upright; raise HoldfastError if one must turn by more than ``turn``."""
    poses = {}
    for name in sorted(names):
        body = scene.body(name)
        poses[name] = upright_pose(body, scene.up)
        angle = turn_between(body.pose, poses[name])
        if body.fixed or angle > turn:
            problem = "is fixed" if body.fixed else f"is {angle:.3g} degrees from upright"
            raise HoldfastError(
                message(f"settle: upright: {quoted(name)}", problem, f"needs a movable body within {turn:g}")
            )
    return scene.moved(poses) if poses else scene


def fate_of(group: Sequence[str], motion: Motion, limits: MotionLimits, up: Float) -> tuple[list[Fall], dict[str, str]]:
    """Return the falls in a group, and what happened to each of its bodies in words; ``up`` (3,) points upwards."""
    falls, words = [], {}
    for k, name in enumerate(group):
        posed = motion.bodies[k]
        way = float(np.linalg.norm(posed.moved))
        if k in motion.left and motion.end is End.LEFT:
            going = motion.going[k] if np.linalg.norm(motion.going[k]) > 0 else posed.moved
            direction = going / max(float(np.linalg.norm(going)), 1e-300)
            falls.append(Fall(name, direction, way))
            x, y, z = direction + 0.0
            how = f"after {1e3 * way:.3g} mm and {posed.turned:.3g} degrees"
            words[name] = f"falls: goes beyond the travel {how}, moving along ({x:.2f}, {y:.2f}, {z:.2f})"
        elif motion.end is End.LEFT:
            words[name] = "not brought to rest: a body that it may touch falls"
        elif k in motion.left:
            words[name] = f"moved {1e3 * way:.3g} mm, beyond the travel, to end overlaps"
        elif motion.end is not End.REST:
            words[name] = f"moved {1e3 * way:.3g} mm: {motion.end.value}"
        else:
            words[name] = _why(motion, k, way, limits, up)
    return falls, words


def moving(group: Sequence[str], motion: Motion) -> list[str]:
    """Return the names of the bodies of a group that still moved in the last step, or of all if none did."""
    ways = np.linalg.norm(motion.going, axis=1)
    return [name for name, way in zip(group, ways, strict=True) if way >= STILL_GOING * float(ways.max())]


def _why(motion: Motion, k: int, way: float, limits: MotionLimits, up: Float) -> str:
    """Say why a body that came to rest has moved."""
    touched = np.abs(motion.contacts.gaps) <= TOUCH * limits.reach
    ends, normals = motion.contacts.ends[touched], motion.contacts.normals[touched]
    mine = np.flatnonzero((ends == k).any(1))
    others = np.where(ends[mine, 0] == k, ends[mine, 1], ends[mine, 0])
    upward = np.where(ends[mine, 1] == k, 1.0, -1.0) * (normals[mine] @ up)
    below = others[upward > UPWARD]
    leant = np.unique(below if len(below) else others).tolist()  # on those that press it upwards, or on all it touches
    where = listed([motion.bodies[other].start.name for other in leant]) or "nothing"
    if way < LEAST and motion.bodies[k].turned < 1e-3:
        return f"was at rest on {where}"
    pushed = float(np.linalg.norm(motion.pushed[k]))
    sunk = float(np.linalg.norm(motion.bodies[k].moved - motion.pushed[k]))
    parts = [f"pushed {1e3 * pushed:.2g} mm out of an overlap"] if pushed > LEAST else []
    parts += [f"sank {1e3 * sunk:.2g} mm"] if sunk > LEAST else []
    return " and ".join(parts or ["turned"]) + f"; rests on {where}"


def status_and_reason(
    verdict: Stability | None,
    fell: Sequence[str],
    deep: Sequence[Overlap],
    far: Sequence[str],
    faults: Sequence[str],
    unfinished: Sequence[str],
    limits: MotionLimits,
) -> tuple[Status, str]:
    """Return the status of a scene brought to rest and the reason for it."""
    travel = f"the travel of {1e3 * limits.reach:.3g} mm"
    if fell:
        return (
            Status.UNSTABLE,
            f"{listed(fell)}: went beyond {travel} or turned by more than {limits.turn:.3g} degrees",
        )
    if deep:
        worst = max(deep, key=lambda o: o.depth)
        a, b = map(quoted, worst.bodies)
        return (
            Status.UNDECIDED,
            f"{a} and {b} overlap by {1e3 * worst.depth:.3g} mm, deeper than {travel}: correct the poses",
        )
    if far:
        return Status.UNDECIDED, f"{listed(far)}: overlaps end only beyond {travel}: correct the poses"
    if verdict is None:
        return Status.STABLE, "nothing can move"
    if faults and verdict.status is Status.STABLE:
        return Status.UNDECIDED, f"overlaps are left: {'; '.join(faults[:3])}"
    if verdict.status is Status.STABLE:
        return Status.STABLE, f"at rest within {travel}; {verdict.reason}"
    if unfinished:
        return (
            Status.UNDECIDED,
            f"{'; '.join(unfinished)}: settle the resulting scene once more, or correct the poses",
        )
    return verdict.status, verdict.reason
