"""Intervals of friction from a robot's pushes: each push left out once, and looked for where the others say."""

from __future__ import annotations

import numpy as np
import pytest
from test_experiments import needed

import holdfast as hf
from bench.experiments.pushed_triangle import sets
from holdfast.applications.calibration.friction_fit import STEPS, Fit

PAIR = ("board", "triangle")


@needed
@pytest.mark.parametrize("confidence", [0.8, 0.9, 0.95])
def test_a_push_left_out_is_where_the_others_say(confidence: float) -> None:
    """Of 250 pushes, the stated share within 3 %. Scans are as ``friction_from`` makes them, once for each set."""
    inside, count = 0, 0
    for pushes in sets():
        assembly, points, along, force = pushes.assembly, pushes.points, pushes.along, pushes.measured
        mus = assembly.mu[0] * np.exp(STEPS)
        scan = [hf.robustness(assembly.with_friction({PAIR: mu}), "triangle", points, along).force for mu in mus]
        scans, logs = np.log(np.array(scan)), np.log(force)
        for k in range(len(force)):
            others = np.arange(len(force)) != k
            scan = scans[:, others]
            fit = Fit(scan[len(STEPS) // 2], (STEPS,), (scan,), logs[others], others[others], None)
            best = fit.best()
            low, high = fit.interval(0, best, confidence)
            s = fit.further(best, confidence)
            ends = best[0] - np.hypot(best[0] - low, s), best[0] + np.hypot(high - best[0], s)
            least, most = np.interp(ends, STEPS, scans[:, k])
            inside += least <= logs[k] <= most
            count += 1
    assert count == 250
    assert inside / count == pytest.approx(confidence, abs=0.03)


@needed
def test_the_question_says_the_same() -> None:
    """One push left out of each set, by ``friction_from`` and ``robustness`` at the ends of its range."""
    inside = 0
    for one in sets():
        assembly, points, along, force = one.assembly, one.points, one.along, one.measured
        pushes = [("triangle", *each) for each in zip(points[1:], along[1:], force[1:].tolist(), strict=True)]
        found = hf.friction_from(assembly, pushes)
        assert 0.05 < found.scatter < 0.21
        low, high = found.intervals[PAIR]
        assert 0.28 < low < found.mu[PAIR] < high < 0.38
        ends = [
            float(hf.robustness(assembly.with_friction({PAIR: mu}), "triangle", points[0], along[0]))
            for mu in found.mu_range[PAIR]
        ]
        inside += ends[0] <= force[0] <= ends[1]
    assert inside >= 4
