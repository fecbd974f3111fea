"""``firmer`` beside random search with as many pushes asked: least push before and after, and what stays when dropped.

Things on a shelf, on a table, and on ten random trays: a plate on a narrower stand, with boxes and cans on it, two of
them on each other. On each tray the upper one is moved, beside random search, and then the heaviest without it.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial

import numpy as np

import holdfast as hf
from bench.baselines.drop import drop
from bench.scenes.random_assemblies import can, finished, resting
from bench.scenes.shelf import shelf
from bench.suite import Case, Row, Suite
from holdfast.applications.pushing.firmer import Climb, Firmness, Pushes, firmer_than
from holdfast.applications.pushing.freedom import Freedom, Moves
from holdfast.base.values import Table
from holdfast.contacts.overlap import distance
from holdfast.queries.request import engine_of
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import at

TRAYS = 10
MOST_RANDOM = 1_000  # poses, where nearly none is allowed
ON_SHELF = ("tin",)
ON_TABLE = ("upper_book",)


def tray(seed: int) -> hf.Scene:
    """A plate on a fixed stand that is narrower, two things on each other, and three beside them, not very even."""
    rng = np.random.default_rng(seed)
    stand = hf.Body("stand", hf.Box((0.26, 0.18, 0.1)), pose=at(0, 0, -0.05), fixed=True)
    bodies = [stand, resting(rng, "plate", (0.45, 0.32, 0.012), (0, 0, 0))]
    lower = resting(rng, "lower", rng.uniform((0.09, 0.09, 0.04), (0.12, 0.12, 0.08)), (*_place(rng), 0.012), 20)
    high, (x, y) = 0.012 + np.ptp(lower.surface_world.vertices[:, 2]), lower.com_world[:2]
    upper = can(rng, "upper", 0.03, rng.uniform(0.06, 0.12), (x + rng.uniform(-0.02, 0.02), y + 0.02, high))
    bodies += [lower, upper]
    while len(bodies) < 7:
        name, size = f"thing{len(bodies) - 3}", rng.uniform(0.04, 0.08, 3)
        foot = (*_place(rng), 0.012)
        one = resting(rng, name, size, foot, rng.uniform(-45, 45))
        if rng.random() < 0.5:
            one = can(rng, name, size[0] / 2, 1.5 * size[2], foot)
        if all(distance(one, other, 0.01) is None for other in bodies[2:]):
            bodies.append(one)
    return finished(rng, f"tray {seed}", bodies)


def _place(rng: np.random.Generator) -> tuple[float, float]:
    return float(rng.uniform(-0.15, 0.15)), float(rng.uniform(-0.09, 0.09))


def cases() -> Mapping[str, Case]:
    """One case a body, on a tray one for each of its things."""
    made: dict[str, Case] = {f"shelf: {name}": partial(_rows, shelf(), name) for name in ON_SHELF}
    made |= {f"tabletop: {name}": partial(_rows, shipped_scene("tabletop"), name) for name in ON_TABLE}
    return made | {f"tray {k}": partial(_on_tray, k) for k in range(TRAYS)}


def _on_tray(seed: int) -> list[Row]:
    scene = tray(seed)
    if not hf.stability(scene).stable:
        return [{"case": f"tray {seed}", "outcome": "does not stand"}]
    return [*_rows(scene, "upper"), *_rows(scene, loose_on(scene)[0], random=False)]


def loose_on(scene: hf.Scene) -> list[str]:
    """The things on a tray but for the upper one, the heaviest first."""
    loose = [body for body in scene.movable if body.name not in ("plate", "upper")]
    return [body.name for body in sorted(loose, key=lambda body: -(body.mass or 0))]


def _rows(scene: hf.Scene, name: str, *, random: bool = True) -> list[Row]:
    hf.firmer(scene, name, seconds=0.5)  # what is compiled on first use
    assembly = hf.assemble(scene)
    free, measure = Freedom(assembly, (name,), Moves()), _timed(assembly, name)
    climb = Climb(free, measure)
    climb.run(np.inf)
    taken = time.process_time() - measure.start
    last, firm = climb.path[-1]
    first = climb.path[0][1].least
    row: Row = {
        "case": f"{scene.name}: {name}",
        "least before N": min(first.values()),
        "least after N": min(firm.least.values()),
        "all grew by": _grown(firm.least, first),
        "steps": len(climb.path) - 1,
        "poses": climb.tried,
        "pushes": measure.asked,
        "s": taken,
        "dropped": "",
    }
    if random:
        other, by_random, tried = _random(assembly, name, measure.asked)
        row |= {
            "least by random N": min(other.least.values()),
            "all grew by random": _grown(other.least, first),
            "random poses": tried,
            "random s": by_random,
            "as firm as random after s": next(
                (at for at, then in measure.times if not firmer_than(other, then)), np.inf
            ),
            "random is firmer": int(firmer_than(other, firm)),
        }
    if len(climb.path) > 1 and scene.name.startswith("tray"):
        found = drop(last, name)
        row["dropped"] = "stays" if found.stands else f"{found.body} moved {1e3 * found.moved:.2g} mm"
    return [row]


def _grown(after: Table[str, float], before: Table[str, float]) -> float:
    """The geometric mean of the growth of all least pushes that were not 0."""
    ratios = [after[name] / value for name, value in before.items() if 0 < value < np.inf]
    return float(np.exp(np.mean(np.log(ratios)))) if ratios else 1.0


class _Timed(Pushes):
    """Pushes that note when each firmness was known."""

    start: float
    times: list[tuple[float, Firmness]]

    def firmness(self, assembly: hf.answers.Assembly) -> Firmness:
        found = super().firmness(assembly)
        self.times.append((time.process_time() - self.start, found))
        return found


def _timed(assembly: hf.answers.Assembly, name: str) -> _Timed:
    start = time.process_time()
    found = _Timed.map_of(assembly, Freedom(assembly, (name,), Moves()).watched, engine_of("compliant"))
    assert isinstance(found, _Timed)
    found.start, found.times = start, []
    return found


def _random(assembly: hf.answers.Assembly, name: str, most: int) -> tuple[Firmness, float, int]:
    """The best of random poses, until as many pushes were asked; the time that it took, and how many poses were."""
    rng, measure = np.random.default_rng(0), _timed(assembly, name)
    climb = Climb(Freedom(assembly, (name,), Moves()), measure)
    best, tried, free = climb.path[0][1], 0, climb.free
    while measure.asked < most and tried < MOST_RANDOM:
        tried += 1
        angle, far = rng.uniform(0, 2 * np.pi), free.moves.slide * np.sqrt(rng.random())
        slide = far * np.array([np.cos(angle), np.sin(angle), 0.0])
        moved = free.placed(assembly, name, slide, rng.uniform(-np.pi, np.pi))
        if moved is None or not climb.ahead(measure.at_most(moved), best):
            continue
        firm = measure.firmness(moved)
        best = firm if climb.ahead(firm, best) else best
    return best, time.process_time() - measure.start, tried


SUITE = Suite("firmer", __doc__, cases)
