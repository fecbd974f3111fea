"""Imperfect faces: the engine beside discrete elements on the same surfaces, what ideal numbers lose, coverage."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial

import numpy as np

from bench.baselines import penalty
from bench.scenes.random_pushes import columns, random_pushes
from bench.suite import Case, Row, Suite, table
from holdfast.assembly.assembly import Assembly, assemble
from holdfast.base.arrays import Float
from holdfast.elastic.system import PathOutcome
from holdfast.engines.answers import Answers
from holdfast.engines.compliant.engine import Compliant, RestingState, Rough
from holdfast.engines.groups import prepared
from holdfast.engines.imperfect import Imperfect, RandomFaces
from holdfast.engines.verdict import Status
from holdfast.queries.map import MapPoint, robustness_map
from holdfast.queries.push import Robustness, robustness
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene

SURFACES = 100
ROUGH = (1.0, 10.0, 100.0)  # standard deviation of the heights over the compression under the weight
DEVIATIONS = 4.0  # ratio of the peak-to-valley height to the standard deviation
SIDE, WEIGHT = 0.1, 9.81  # side [m] and weight [N] of the shipped cube
POINTS = {"centred": (-0.05, 0, 0.05), "off-centre": (-0.05, 0.045, 0.02), "slanted": (-0.05, 0.03, 0.08)}
WAYS = {"centred": (1.0, 0, 0), "off-centre": (1.0, 0, 0), "slanted": (1.0, 0.2, -0.5)}
SCENES = ("table", "wall2x2", "arch", "v_groove", "cantilever", "tabletop", "stack", "slope_two")
FLATNESS, BED, FACTORS = 5e-5, 2e9, (0.3, 3.0)  # wooden blocks: 0.05 mm; 20 MPa over a centimetre of touching fibres
SAMPLES, MORE = 32, 200
DRAWS = 63  # samples on each of SCENES: more than 500 in all
PUSHES = 6
SEED = 18
BEST = 3  # repetitions of what is timed


def surfaces(ratio: float) -> list[Row]:
    """Compare the engine's peaks with those of discrete elements on the same random surfaces under a cube.

    Both on the same nodes, so paths that are lost there are left out, though the engine would recover them on others.
    """
    assembly = assemble(shipped_scene("cube"))
    compression = 1e-6
    imperfect = Imperfect(DEVIATIONS * ratio * compression, WEIGHT / SIDE**2 / compression, seed=SEED)
    unit = {name: np.array(way) / np.linalg.norm(way) for name, way in WAYS.items()}
    W = push_columns(assembly, 0, np.array(list(POINTS.values())), np.array(list(unit.values())))
    ideal = prepared(Compliant(), assembly).load_factor(W).force
    own, other = np.zeros((SURFACES, len(POINTS))), np.zeros((SURFACES, len(POINTS)))
    for sample in range(SURFACES):
        group = prepared(Rough(Compliant(), RandomFaces(imperfect, sample)), assembly).group(0)
        assert isinstance(group.state, RestingState)  # a cube on a floor stands on any surface
        assert group.part is not None
        grid = group.state.grid
        paths = grid.paths(W[group.part.rows])
        own[sample] = np.where(paths.outcome == PathOutcome.PEAK, paths.peak, np.nan)
        for k, name in enumerate(POINTS):
            where = (group.part.assembly, "cube", np.array(POINTS[name]), unit[name], grid.nodes)
            seen = penalty.peak(*where, apart=grid.system.model.apart)
            other[sample, k] = (seen.held + seen.moves) / 2 if seen.held > 0 else np.nan
    rows: list[Row] = []
    for k, name in enumerate(POINTS):
        both = np.isfinite(own[:, k]) & np.isfinite(other[:, k])
        row: Row = {"case": f"cube, {name}, heights / compression {ratio:g}", "surfaces": int(both.sum())}
        row |= {"lost": int(np.isnan(own[:, k]).sum()), "lost by elements": int(np.isnan(other[:, k]).sum())}
        for word, share in (("median", 0.5), ("5 %", 0.05), ("least", 0.0)):
            row[word] = float(np.quantile(own[both, k], share) / ideal[k])
            row[f"{word} elements"] = float(np.quantile(other[both, k], share) / ideal[k])
        apart = np.abs(own[both, k] / other[both, k] - 1)
        rows.append(row | {"worst difference": float(apart.max()), "apart by 2 %": int((apart > 0.02).sum())})
    return rows


def imperfect_faces(samples: int, seed: int) -> Imperfect:
    """Faces of wooden blocks."""
    return Imperfect(FLATNESS, BED, stiffness_range=FACTORS, samples=samples, seed=seed)


def asked(assembly: Assembly, imperfect: Imperfect, W: Float, samples: int) -> tuple[Float, Float, int]:
    """Return forces and lower bounds (samples, n) of columns W (6J, n), and how many answers are undecided."""
    found: list[Answers] = [
        prepared(Rough(Compliant(), RandomFaces(imperfect, sample)), assembly).load_factor(W)
        for sample in range(samples)
    ]
    undecided = sum(int((answers.status == Status.UNDECIDED).sum()) for answers in found)
    return np.array([a.force for a in found]), np.array([a.lower for a in found]), undecided


def first_push(name: str, weakest: MapPoint, imperfect: Imperfect | None = None) -> tuple[float, Robustness]:
    """Return the processor time [s] of the first push on a scene and its answer, best of BEST.

    It holds all preparation that a push needs after the contacts are found.
    """
    best, found = np.inf, None
    for _ in range(BEST):
        assembly = assemble(shipped_scene(name))
        start = time.process_time()
        found = robustness(assembly, weakest.body, weakest.point, weakest.direction, imperfect=imperfect)
        best = min(best, time.process_time() - start)
    assert found is not None
    return best, found


def scene(name: str) -> list[Row]:
    """Ask for the weakest point of a scene: ideal, its lower bound, and what imperfect faces leave."""
    assembly, wooden = assemble(shipped_scene(name)), imperfect_faces(SAMPLES, SEED)
    weakest = robustness_map(assembly, spacing=0.04).weakest()
    number = assembly.index[weakest.body]
    W = push_columns(assembly, number, np.array([weakest.point]), np.array([weakest.direction]))
    once, ideal = first_push(name, weakest)
    covered, _ = first_push(name, weakest, wooden)
    force, lower, undecided = asked(assembly, wooden, W, SAMPLES)
    return [
        {
            "case": name,
            "body": weakest.body,
            "ideal [N]": float(ideal.force[0]),
            "lower": float(ideal.lower[0]),
            "imperfect, median": float(np.median(force)),
            "5 %": float(np.quantile(lower, 0.05)),
            "least": float(lower.min()),
            "undecided": undecided,
            "first push s": once,
            "samples s": covered - once,
            "first pushes a sample": (covered - once) / once / SAMPLES,
        }
    ]


def coverage(name: str) -> list[Row]:
    """Draw faces that the estimate has not seen, and count how many hold less than it says."""
    assembly = assemble(shipped_scene(name))
    rng = np.random.default_rng([SEED, SCENES.index(name)])
    W = columns(assembly, random_pushes(assembly, rng, PUSHES, slant=60))
    _, lower, undecided = asked(assembly, imperfect_faces(MORE, SEED), W, MORE)
    fresh, _, lost = asked(assembly, imperfect_faces(DRAWS, SEED + 1), W, DRAWS)
    which = rng.integers(PUSHES, size=DRAWS)
    drawn = fresh[np.arange(DRAWS), which]
    row: Row = {"case": f"coverage: {name}", "draws": DRAWS}
    for count in (SAMPLES, MORE):
        bound = lower[:count].min(0)[which]
        row[f"below, {count}"] = int((drawn < bound).sum())
        finite = np.isfinite(bound) & (bound > 0)
        row[f"least share, {count}"] = float((drawn[finite] / bound[finite]).min(initial=np.inf))
    return [row | {"undecided": undecided + lost}]


def cases() -> Mapping[str, Case]:
    found: dict[str, Case] = {f"surfaces: {ratio:g}": partial(surfaces, ratio) for ratio in ROUGH}
    found |= {f"scene: {name}": partial(scene, name) for name in SCENES}
    return found | {f"coverage: {name}": partial(coverage, name) for name in SCENES}


def written(rows: list[Row]) -> str:
    """Return one table for the surfaces, one for the scenes and one for the coverage."""
    kinds = ([row for row in rows if row["case"].startswith(start)] for start in ("cube,", "coverage"))
    under, covered = kinds
    return "\n\n".join(
        table(part) for part in (under, [row for row in rows if row not in under and row not in covered], covered)
    )


SUITE = Suite("imperfect", __doc__, cases, written=written)
