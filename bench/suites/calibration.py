"""Friction from measured pushes: how often intervals hold the truth, and their width beside the best possible."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from scipy import stats

import holdfast as hf
from bench.suite import Case, Row, Suite
from holdfast.base.arrays import Float
from holdfast.scene.shipped.blocks import cube, stack

DRAWS = 1000
NOISE = 0.1  # standard deviation of ln(measured / true force)
SEED = 54
CONFIDENCE = 0.95
Pair = tuple[str, str]
PUSHED: Mapping[str, tuple[Callable[[], hf.Scene], list[tuple[str, tuple[float, float, float], Pair]]]] = {
    "cube": (cube, [("cube", (-0.05, 0, 0.001), ("cube", "floor"))]),
    "two cubes": (
        lambda: stack().without("cube3"),
        [("cube2", (-0.05, 0, 0.101), ("cube1", "cube2")), ("cube1", (-0.05, 0, 0.001), ("cube1", "floor"))],
    ),
}
WAY = (1.0, 0.0, 0.0)


def drawn(scene: str, count: int, scatter: float | None, most: float = np.inf) -> list[Row]:
    """Draw noise DRAWS times, ``count`` pushes for each place; a force ends at ``most`` times the true one.

    What has not moved until then is a push that moved nothing.
    """
    build, places = PUSHED[scene]
    assembly = hf.assemble(build())
    truth = np.array([float(hf.robustness(assembly, body, point, WAY, engine="limit")) for body, point, _ in places])
    rng, begun = np.random.default_rng([SEED, count]), time.process_time()
    covered = {kind: np.zeros(len(places)) for kind in ("mu", "further")}
    width, undecided = np.zeros(len(places)), 0
    for _ in range(DRAWS):
        noise = np.exp(NOISE * rng.standard_normal((len(places), count)))
        pushes = [
            (body, point, WAY, force * min(one, most), bool(one < most))
            for (body, point, _), force, row in zip(places, truth, noise, strict=True)
            for one in row.tolist()
        ]
        found = hf.friction_from(assembly, pushes, scatter=scatter, confidence=CONFIDENCE, engine="limit")
        again = np.exp(NOISE * rng.standard_normal(len(places)))
        if found.undecided:  # a draw that seems to contradict itself holds nothing
            undecided += 1
            continue
        for k, (_, _, pair) in enumerate(places):
            mu = assembly.scene.mu(*pair)
            covered["mu"][k] += _within(found.intervals[pair], mu)
            covered["further"][k] += _within(found.mu_range[pair], mu * again[k])
            width[k] += np.log(found.intervals[pair][1] / found.intervals[pair][0])
    least, largest = stats.binom.interval(0.999, DRAWS * len(places), CONFIDENCE)
    return [
        {
            "case": f"{scene}, scatter {'estimated' if scatter is None else 'given'}, {count} pushes a pair",
            "ended at": most,
            "draws": DRAWS,
            "mu covered": float(covered["mu"].mean() / DRAWS),
            "further push covered": float(covered["further"].mean() / DRAWS),
            "binomial bounds": f"{least / DRAWS / len(places):.3f} to {largest / DRAWS / len(places):.3f}",
            "width / best": float(np.mean(width) / (DRAWS - undecided) / best_width(count, most)),
            "undecided": undecided,
            "draw s": (time.process_time() - begun) / DRAWS,
        }
    ]


def best_width(count: int, most: float) -> float:
    """Cramér and Rao's bound: the width in ln mu of an interval from as much information as the pushes hold.

    A force that is known up to ``most`` times the true one is a normal observation that is censored there.
    """
    u = np.log(most) / NOISE
    tail = 0.0 if most == np.inf else stats.norm.pdf(u) * (u - stats.norm.pdf(u) / stats.norm.sf(u))
    information = count * (stats.norm.cdf(u) - tail) / NOISE**2
    return float(2 * stats.norm.ppf((1 + CONFIDENCE) / 2) / np.sqrt(information))


def _within(ends: tuple[float, float], value: float | Float) -> bool:
    return bool(ends[0] <= value <= ends[1])


def cases() -> Mapping[str, Case]:
    return {
        "one push": partial(drawn, "cube", 1, NOISE),
        "scatter given": partial(drawn, "cube", 10, NOISE),
        "scatter estimated": partial(drawn, "cube", 10, None),
        "held": partial(drawn, "cube", 20, None, 1.05),
        "two pairs": partial(drawn, "two cubes", 5, None),
    }


SUITE = Suite("calibration", __doc__, cases)
