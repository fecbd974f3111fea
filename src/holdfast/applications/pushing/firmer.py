"""Move bodies to where the least push, or the least factor of a motion, is larger."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from holdfast.applications.carrying.carry import ProfileChoice, carry, checked_profile
from holdfast.applications.carrying.profile import Profile
from holdfast.applications.placement.comparing import pattern_search
from holdfast.applications.pushing.freedom import WAYS, Freedom, Moves
from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.on_surface import check_on_surface
from holdfast.base.arrays import Float, Int, Objects, checked_number, objects
from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.progress import OutOfTimeError, keep_to_time, until
from holdfast.base.public import Pictured, Record, Summary, number
from holdfast.base.text import listed, quoted
from holdfast.base.values import Table
from holdfast.engines.answers import Answers, Claim
from holdfast.engines.contract import Engine
from holdfast.queries import request
from holdfast.queries.map import exposed_cells
from holdfast.queries.push import load_factors
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, Load
from holdfast.queries.result import Result
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene

STILL = 1e-9  # [m], rad: a body that moved less did not
MOST_PUSHES = 150  # approximate number of pushes of a default map, on all bodies together
GAIN = 0.01  # relative growth that counts, and loss of force that does not: so much varies with the nodes of faces
SAME = 1e-6  # relative loss of what is promised that does not count
LEAST = 1e-9  # [N], or times: growth from 0 that counts
FIRST, LAST = 0.5, 0.01  # first and last step, as shares of the limit of the moves and of the size of a body


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


@dataclass(frozen=True, eq=False)
class Firmness:
    """How firm an assembly is: the ``least`` load that moves something, by the name of the pushed body, or "motion".

    It is the least that ``answers`` promise, 0 for the names in ``undecided``. The truth is at most about ``most``, the
    least force that is known.
    """

    least: Table[str, float]
    most: Table[str, float]
    undecided: tuple[str, ...]
    answers: Answers

    @classmethod
    def of(cls, answers: Answers, names: Objects) -> Firmness:
        """Return how firm the names (n,) of the rows are."""
        low, high = promised(answers), np.where(answers.decided, answers.force, np.inf)
        rows = {name: np.flatnonzero(names == name) for name in dict.fromkeys(names)}
        return cls(
            Table({name: float(low[own].min()) for name, own in rows.items()}),
            Table({name: float(high[own].min()) for name, own in rows.items()}),
            tuple(name for name, own in rows.items() if not answers.decided[own].all()),
            answers,
        )


def promised(answers: Answers) -> Float:
    """Return the bounds (n,) that answers promise from below; the forces of an engine that only estimates."""
    return answers.force if answers.claim is Claim.ESTIMATED else answers.lower


@dataclass(eq=False)
class Pushes:
    """Pushes that travel with their bodies: ``points`` and ``directions`` (n, 3) in the frame of each ``body`` (n,).

    The ``weakest`` in any answer so far are asked first: where these are no firmer, the others need not be asked.
    """

    engine: Engine
    body: Objects
    points: Float
    directions: Float
    asked: int = 0
    weakest: set[int] = field(default_factory=set)

    @classmethod
    def map_of(cls, assembly: Assembly, names: Sequence[str], engine: Engine) -> Pushes:
        """Return inward pushes all over the exposed surfaces of the bodies ``names``."""
        areas = np.array([assembly.scene.body(name).surface_world.area for name in names])
        bodies, points, normals = [], [np.zeros((0, 3))], [np.zeros((0, 3))]
        for name, most in zip(names, np.ceil(MOST_PUSHES * areas / areas.sum()).astype(int).tolist(), strict=True):
            cells = exposed_cells(assembly, name, float(np.sqrt(areas.sum() / MOST_PUSHES)))[0]
            every = max(len(cells.points) // most, 1)  # a round side has many facets, each with cells of its own
            points.append(cells.points[::every])
            normals.append(cells.normals[::every])
            bodies += [name] * len(points[-1])
        return cls._in_frames(assembly, engine, bodies, np.vstack(points), -np.vstack(normals))

    @classmethod
    def given(cls, assembly: Assembly, loads: Iterable[Load], engine: Engine) -> Pushes:
        """Return the pushes of ``loads``, each of which is asked on its own."""
        found = request.checked_loads(loads)
        for load in found:
            where = f"firmer: push on {quoted(load.body)}"
            if assembly.index.get(load.body, FIXED) == FIXED or np.any(load.moment) or not np.any(load.force):
                raise SceneError(message(where, "is no force on a movable body", "needs hf.Load(body, point, force)"))
            check_on_surface(assembly, load.body, np.array([load.point]), where)
        if not found:
            raise SceneError(message("firmer: pushes", "is empty", "give pushes, or None for all over the bodies"))
        forces = np.array([load.force for load in found])
        forces /= np.linalg.norm(forces, axis=1, keepdims=True)
        return cls._in_frames(
            assembly, engine, [load.body for load in found], np.array([load.point for load in found]), forces
        )

    @classmethod
    def _in_frames(
        cls, assembly: Assembly, engine: Engine, bodies: Sequence[str], points: Float, directions: Float
    ) -> Pushes:
        poses = np.array([assembly.scene.body(name).pose for name in bodies])
        points = np.einsum("nji,nj->ni", poses[:, :3, :3], points - poses[:, :3, 3])
        return cls(engine, objects(bodies), points, np.einsum("nji,nj->ni", poses[:, :3, :3], directions))

    def firmness(self, assembly: Assembly) -> Firmness:
        """Return the least push on each body [N]."""
        answers = self._answers(assembly, np.arange(len(self.body)))
        values = promised(answers)
        for name in self.names:
            own = np.flatnonzero(self.body == name)
            self.weakest.add(int(own[np.argmin(values[own])]))
        return Firmness.of(answers, self.body)

    def at_most(self, assembly: Assembly) -> Firmness:
        """Return what the assembly is at most as firm as, by the pushes that were the weakest anywhere."""
        rows = np.array(sorted(self.weakest))
        return Firmness.of(self._answers(assembly, rows), self.body[rows])

    @property
    def names(self) -> list[str]:
        """The names of the bodies that are pushed."""
        return list(dict.fromkeys(self.body))

    def _answers(self, assembly: Assembly, rows: Int) -> Answers:
        self.asked += len(rows)
        W, ways = np.zeros((6 * len(assembly.movable), len(rows))), np.zeros((len(rows), 3))
        for name in self.names:
            mine = np.flatnonzero(self.body[rows] == name)
            pose = assembly.scene.body(name).pose
            points = self.points[rows[mine]] @ pose[:3, :3].T + pose[:3, 3]
            ways[mine] = self.directions[rows[mine]] @ pose[:3, :3].T
            W[:, mine] = request.push_columns(assembly, assembly.index[name], points, ways[mine])
        pressed = np.zeros(len(assembly.bodies)), request.pressed_by_pushes(assembly, self.body[rows].tolist(), ways)
        return load_factors(self.engine, assembly, W, np.zeros(len(W)), bounds=False, pressed=pressed)


@dataclass(eq=False)
class CarrierMotion:
    """A motion of the carrier: how many times faster its accelerations may be."""

    engine: Engine
    profile: Profile
    asked: int = 0

    def firmness(self, assembly: Assembly) -> Firmness:
        """Return the least factor of the inertial loads over all times."""
        found = carry(assembly, self.profile, engine=self.engine).answers
        self.asked += len(found.force)
        return Firmness.of(found, objects(["motion"] * len(found)))

    def at_most(self, assembly: Assembly) -> None:
        """Return no bound: one answer covers many times."""


def firmer(
    assembly: Assembly | Scene,
    bodies: str | Sequence[str],
    *,
    moves: Moves | None = None,
    pushes: Iterable[Load] | None = None,
    motion: ProfileChoice | None = None,
    engine: EngineChoice = DEFAULT_ENGINE,
    seconds: float | None = None,
) -> Firmer:
    """Move one body, or several, to where the least push that moves something is larger; see Firmer.

    ``bodies`` slide on what they stand on and turn about its normal, within ``moves`` (see ``holdfast.sets.Moves``):
    they stay on the same supports, touch nothing new, leave no movable body that they touch, which may lean on them,
    keep their distance from others, and come no nearer to an edge. What rests on them moves along.

    The pushes are about 150 inward ones all over the moved bodies and the movable ones that they touch or on which they
    rest, or ``pushes``, each asked on its own. They travel with their bodies. Of a ``motion`` of the carrier (see
    ``carry``) it is the least factor of its inertial loads that is to grow. ``lower`` of the ``engine`` has to grow,
    and ``force``, too. Nothing is moved unless ``lower`` there is above ``force`` here, so that no gain is one of
    errors alone. First the weakest body that can be made firmer is; no body ends weaker than it began.

    The search ends where no step in ten directions is better, however short, or after about ``seconds``.

    Raises SceneError for a body that is unknown, is fixed or stands on nothing, and HoldfastError for interfaces that
    were given, or both ``pushes`` and a ``motion``.
    """
    assembly = request.checked_assembly(assembly)
    refuse_holds(assembly.scene.holds, "firmer", "move bodies in the scene without them")
    names = tuple(dict.fromkeys([bodies] if isinstance(bodies, str) else bodies))
    for name, index in request.body_numbers(assembly, names, "firmer").items():
        if index == FIXED:
            raise SceneError(message(f"firmer: {quoted(name)}", "is fixed", "needs bodies that can be moved"))
    free_moves = request.checked_options(moves, Moves, "firmer: moves")
    if pushes is not None and motion is not None:
        raise HoldfastError(message("firmer", "got pushes and a motion", "ask one after the other"))
    limit = np.inf if seconds is None else checked_number(seconds, "firmer: seconds", above=0)
    method = request.engine_of(engine)
    free = Freedom(assembly, names, free_moves)
    measure: Pushes | CarrierMotion
    if motion is not None:
        measure = CarrierMotion(method, checked_profile(motion, assembly))
    elif pushes is not None:
        measure = Pushes.given(assembly, pushes, method)
    else:
        measure = Pushes.map_of(assembly, free.watched, method)
    found = Climb(free, measure)
    found.run(limit)
    steps = tuple(
        FirmerStep(
            Table({name: here.scene.body(name).pose for name in free.movers}), firm.least, firm.undecided, firm.answers
        )
        for here, firm in found.path
    )
    return Firmer(
        answers=steps[-1].answers,
        assembly=found.path[-1][0],
        steps=steps,
        times=motion is not None,
        solves=measure.asked,
        tried=found.tried,
    )


State = tuple[Assembly, Firmness]


class Climb:
    """A search from one firm state to the next: the ``path`` of states so far, and how many were ``tried``."""

    def __init__(self, free: Freedom, measure: Pushes | CarrierMotion) -> None:
        self.free, self.measure, self.tried = free, measure, 0
        self.path: list[State] = [(free.assembly, measure.firmness(free.assembly))]

    def run(self, seconds: float) -> None:
        """Search until no step is better, or for so many seconds."""
        size = min(self.free.assembly.scene.body(name).size for name in self.free.bodies)
        ways = WAYS * len(self.free.bodies)
        first = FIRST * self.free.longest
        try:
            with until(time.perf_counter() + seconds):
                pattern_search(self.path[0], self._better, ways, first=first, last=LAST * size)
        except OutOfTimeError:
            pass
        if not firmer_than(self.path[-1][1], self.path[0][1], certainly=True):
            del self.path[1:]

    def _better(self, state: State, way: int, step: float) -> State | None:
        keep_to_time()
        moved = self.free.stepped(state[0], way, step)
        if moved is None:
            return None
        self.tried += 1
        at_most = self.measure.at_most(moved)
        if at_most is not None and not self.ahead(at_most, state[1]):
            return None
        new = moved, self.measure.firmness(moved)
        if not self.ahead(new[1], state[1]):
            return None
        self.path.append(new)
        return new

    def ahead(self, now: Firmness, before: Firmness) -> bool:
        """Tell whether the weakest that differs is firmer, and nothing weaker than at first."""
        first = self.path[0][1]
        kept = all(now.least[name] >= least * (1 - SAME) for name, least in first.least.items())
        kept = kept and all(now.most[name] >= most * (1 - GAIN) for name, most in first.most.items())
        return kept and firmer_than(now, before)


def firmer_than(now: Firmness, before: Firmness, *, certainly: bool = False) -> bool:
    """Tell whether the smallest value that differs is larger than before, when all are compared in their order.

    What is promised has to grow, and the force, too: else it is the error of the nodes that has become smaller. It is
    ``certainly`` larger if what is promised now is above the force of before.
    """
    values = (sorted(table.values()) for table in (now.least, now.most, before.least, before.most))
    for least, most, least_before, most_before in zip(*values, strict=True):
        base = most_before if certainly else least_before
        if least > base * (1 + GAIN) + LEAST and most > most_before * (1 + GAIN):
            return True
        if least < least_before * (1 - GAIN) or most < most_before * (1 - GAIN):
            return False
    return False
