"""Derivatives of pushes beside central differences of moved scenes, on 2,000 random parameters of random pushes.

The steps are 2 and 20 hundredths of the usual gap: the better of both counts, as the small one is lost in the accuracy
of solvers in some scenes, and kinks are closer than the large one in others. For ``limit``, programs of moved scenes
are solved to 1e-13; for ``compliant``, answers are the public ones. Errors are in shares of the push for a usual change
of the parameter: the size of a body, a turn by it up to one radian, the coefficient or the mass itself. A difference is
smooth where its two sides agree to 0.1 %, or to 1 % for ``compliant``. Elsewhere there is a kink within the steps,
which has to be told. Times are those of rows without kinks, in units of the first answer of an assembly.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from numpy.random import Generator

import holdfast as hf
from bench.scenes.random_assemblies import FAMILIES, standing
from bench.scenes.random_pushes import random_pushes
from bench.scenes.shelf import shelf
from bench.suite import Case, Row, Suite
from holdfast.applications.gradients.parameters import Parameters
from holdfast.base.arrays import Float
from holdfast.engines.limit.limit_state import factors_on
from holdfast.queries.push import load_factors
from holdfast.queries.request import engine_of
from holdfast.scene.shipped import shipped_scene
from holdfast.sets import gradients

SHIPPED = ("cube", "stack", "table", "tall_table", "wall2x2", "slope", "slope_two", "cantilever", "arch", "tabletop")
LIMIT = {"shipped": 600, "shelf of 8": 300, "random": 1_100}  # parameters of each kind of scene: 2,000 in all
COMPLIANT = {"shipped": 40, "shelf of 8": 10, "random": 40}
EACH = 5  # parameters of one push
STEPS = (2e-5, 2e-4)  # in usual changes
ERROR = {"limit": 1e-5, "compliant": 1e-3}
SIDES = {"limit": 1e-3, "compliant": 1e-2}  # by which the two one-sided differences of a smooth one may differ
SOME = 1e-6  # share of the push that a parameter changes, below which it counts as one that does not matter

Make = Callable[[Generator], hf.answers.Assembly]


def cases() -> Mapping[str, Case]:
    """One case for each engine and kind of scene."""
    kinds: dict[str, Make] = {
        "shipped": lambda rng: hf.assemble(shipped_scene(str(rng.choice(SHIPPED)))),
        "shelf of 8": lambda rng: hf.assemble(shelf()),
        "random": lambda rng: standing(FAMILIES[str(rng.choice(list(FAMILIES)))], rng),
    }
    counts = {"limit": LIMIT, "compliant": COMPLIANT}
    return {
        f"{engine}, {kind}": partial(_rows, f"{engine}, {kind}", engine, make, counts[engine][kind])
        for engine in counts
        for kind, make in kinds.items()
    }


def _rows(case: str, engine: str, make: Make, count: int) -> list[Row]:
    rng = np.random.default_rng(57)
    found: list[tuple[float, bool, bool]] = []  # error, smooth, told
    ratios = []
    with warnings.catch_warnings(action="ignore"):
        while len(found) < count:
            assembly = make(rng)
            body, point, way = random_pushes(assembly, rng, 1, slant=40)[0]
            hf.robustness(assembly, body, point, way, engine=engine)
            fresh = hf.assemble(assembly.scene)
            start = time.process_time()
            answer = hf.robustness(fresh, body, point, way, engine=engine)
            solved = time.process_time() - start
            if not (np.isfinite(answer.force[0]) and answer.force[0] > 0):
                continue
            start = time.process_time()
            slopes = gradients(fresh, answer)
            if not slopes.kinks:
                ratios.append((time.process_time() - start) / solved)
            found += _beside(answer, slopes, engine, rng, min(EACH, count - len(found)))
    errors, smooth, told = (np.array(each) for each in zip(*found, strict=True))
    wrong = smooth & ~told & (errors > ERROR[engine])
    row: Row = {"case": case, "parameters": len(errors), "kinks told": int(told.sum())}
    row |= {"kinks of differences": int((~smooth).sum()), "of these not told": int((~smooth & ~told).sum())}
    row |= {
        f"error, {name}": float(np.quantile(errors[smooth & ~told], q)) for name, q in (("median", 0.5), ("99 %", 0.99))
    }
    row |= {"largest error": float(errors[smooth & ~told].max()), f"above {ERROR[engine]:g}": int(wrong.sum())}
    row |= {"told but smooth": int((told & smooth).sum())}
    if ratios:  # on some scenes no row is without kinks
        row |= {
            f"time in solves, {name}": float(np.quantile(ratios, q)) for name, q in (("median", 0.5), ("90 %", 0.9))
        }
    return [row]


def _beside(
    answer: hf.answers.Robustness, slopes: hf.answers.Derivatives, engine: str, rng: Generator, count: int
) -> list[tuple[float, bool, bool]]:
    """Return for some parameters the error of the derivative, whether differences are smooth, and if kinks are told."""
    (question,) = answer.questions
    assert question.loads is not None
    parameters = Parameters(answer, question, question.loads, {body.name for body in question.assembly.bodies})
    value, before, after = (_flat(each) for each in (slopes.slopes, slopes.before, slopes.after))
    unit = parameters.units / answer.force[0]
    matter = np.flatnonzero((np.abs(np.array([before, after])) * unit > SOME).any(axis=0))
    drawn = rng.choice(matter if len(matter) else len(unit), min(count, max(len(matter), 1)), replace=False)
    method, there = engine_of(engine), np.ones(1, dtype=bool)

    def force(assembly: hf.answers.Assembly, W: Float, held: Float) -> float:
        if engine == "limit":
            return float(factors_on(assembly, assembly.weight_wrench() + held, W)[0])
        return float(load_factors(method, assembly, W, held, bounds=False).force[0])

    here = force(question.assembly, question.loads, question.standing)
    found = []
    for place in drawn.tolist():
        own, each = value[place] * unit[place], []
        for step in STEPS:
            low, high = (force(*parameters.changed(place, s * step * parameters.units[place], there)) for s in (-1, 1))
            error = abs((high - low) / (2 * step) / here - own) / max(1.0, abs(own))
            sides = abs(high + low - 2 * here) / step / here
            each.append((error, bool(sides < SIDES[engine] * max(1.0, abs(own)))))
        told = bool(before[place] != after[place])
        found.append((min(error for error, _ in each), any(smooth for _, smooth in each), told))
    return found


def _flat(slopes: hf.answers.Slopes) -> Float:
    """Return the derivatives (P,) of the first row in the order of the parameters."""
    found = [
        *slopes.pose.values(),
        *(each[:, None] for table in (slopes.friction, slopes.mass) for each in table.values()),
    ]
    return np.asarray(np.hstack([*found, slopes.point, slopes.direction])[0])


SUITE = Suite("gradients", __doc__, cases)
