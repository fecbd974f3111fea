"""Friction from measured pushes: closed forms of intervals, their coverage, pairs without influence, real pushes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats

import holdfast as hf
from holdfast.applications.calibration.friction_fit import Fit
from holdfast.scene.shipped.blocks import at, box, cube, floor, stack

G = 9.81
X = (1.0, 0, 0)
LOW = (-0.05, 0, 0.001)
PAIR = ("cube", "floor")


def low(force: float, moved: bool = True) -> Any:
    """The cube of 1 kg, pushed where it slides at mu g."""
    return ("cube", LOW, X, force, moved)


def test_one_push_and_its_scatter_give_an_interval() -> None:
    """Force mu m g times exp(s e): mu = force / (m g) times or divided by exp(1.96 s)."""
    found = hf.friction_from(cube(), [low(0.5 * G)], scatter=0.1)
    assert found.mu[PAIR] == pytest.approx(0.5, rel=1e-4)
    assert found.intervals[PAIR] == pytest.approx(0.5 * np.exp([-0.196, 0.196]), rel=1e-4)
    further = np.sqrt(2) * stats.norm.ppf(0.975) * 0.1
    assert found.mu_range[PAIR] == pytest.approx(0.5 * np.exp([-further, further]), rel=1e-4)
    assert (found.undetermined, found.undecided, found.scatter, found.scatter_estimated) == ((), "", 0.1, False)
    assert found.predicted == pytest.approx([0.5 * G], rel=1e-4)


def test_without_a_scatter_the_interval_is_students() -> None:
    logs = np.random.default_rng(0).normal(np.log(0.45), 0.08, 6)
    found = hf.friction_from(cube(), [low(G * mu) for mu in np.exp(logs)], confidence=0.9, engine="limit")
    middle, s, t = logs.mean(), logs.std(ddof=1), stats.t.ppf(0.95, 5)
    assert found.mu[PAIR] == pytest.approx(np.exp(middle), rel=1e-4)
    assert found.intervals[PAIR] == pytest.approx(np.exp(middle + t * s * np.array([-1, 1]) / np.sqrt(6)), rel=1e-4)
    assert found.mu_range[PAIR] == pytest.approx(np.exp(middle + t * s * np.array([-1, 1]) * np.sqrt(7 / 6)), rel=1e-4)
    assert found.scatter == pytest.approx(logs.std(), rel=1e-3)
    assert found.scatter_estimated


def test_a_push_that_moved_nothing_sets_a_lower_end() -> None:
    """Twice ln Φ(z) is -3.84 at z = -1.05: mu is at least force / (m g) exp(-1.05 s), and nothing more is known."""
    found = hf.friction_from(cube(), [low(0.5 * G, False)], scatter=0.1)
    z = stats.norm.ppf(np.exp(-stats.chi2.ppf(0.95, 1) / 2))
    assert found.intervals[PAIR] == pytest.approx((0.5 * np.exp(0.1 * z), np.inf), rel=1e-3)
    assert found.mu_range[PAIR][1] == 0.6, "the scene's own"
    assert any("the interval alone says something" in note for note in found.notes)
    above = hf.friction_from(cube(), [low(1.5 * G, False)], scatter=0.1)
    assert above.mu_range[PAIR][0] == above.mu_range[PAIR][1] > 0.6


@pytest.mark.parametrize("arm", [0.1, 0.05, 0.02])
def test_pushes_that_topple_tell_a_lower_end_whatever_the_file_says(arm: float) -> None:
    """At m g a / h it slides or topples: mu is at least that a / h, times exp(-1.96 s / 2) for four pushes."""
    found = []
    for guess in (0.05, 0.3, 0.6, 0.9, 1.2, 4.0):
        block = box("block", (2 * arm, 0.2, 0.2), 1.0, (0, 0, 0.1))
        push = ("block", (-arm, 0, 0.19), X, G * arm / 0.19)
        found.append(hf.friction_from(hf.Scene([floor(), block], guess), [push] * 4, scatter=0.1, engine="limit"))
    least = arm / 0.19 * np.exp(stats.norm.ppf(0.025) * 0.1 / 2)
    for each in found:
        assert each.intervals["block", "floor"] == pytest.approx((least, np.inf), rel=3e-3)
        assert each.mu == found[0].mu
        assert each.intervals == found[0].intervals


def test_held_and_moved_enclose_the_coefficient() -> None:
    found = hf.friction_from(cube(), [low(0.4 * G, False), low(0.5 * G), low(0.55 * G)], scatter=0.05)
    alone = hf.friction_from(cube(), [low(0.5 * G), low(0.55 * G)], scatter=0.05)
    assert not any("the interval alone" in note for note in found.notes)
    assert alone.intervals[PAIR][0] <= found.intervals[PAIR][0] < found.mu[PAIR] < found.intervals[PAIR][1] < 0.6


def test_a_pair_that_no_push_depends_on_is_undetermined() -> None:
    other = box("other", (0.1, 0.1, 0.1), 1, (0.5, 0, 0.05))
    scene = hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)), other], 0.6)
    found = hf.friction_from(scene, [low(0.5 * G)], scatter=0.1)
    assert found.undetermined == (("floor", "other"),)
    assert set(found.mu) == set(found.intervals) == set(found.mu_range) == {PAIR}
    up = hf.friction_from(scene, [("cube", (0, 0, 0.1), (0, 0, 1), G)], scatter=0.1)
    assert up.undetermined == (PAIR, ("floor", "other"))
    assert up.undecided == "no push depends on a coefficient of friction"
    assert not up.mu


def test_each_push_tells_of_the_pair_that_slips() -> None:
    """Pushed low, block k of three slides on what is below it, with all above it: 1, 2 and 3 kg."""
    pushes = [
        (f"cube{k}", (-0.05, 0, 0.1 * k - 0.099), X, mu * (4 - k) * G) for k, mu in ((3, 0.3), (2, 0.4), (1, 0.45))
    ]
    found = hf.friction_from(stack(), pushes, scatter=0.1)
    wanted = {("cube2", "cube3"): 0.3, ("cube1", "cube2"): 0.4, ("cube1", "floor"): 0.45}
    assert dict(found.mu) == pytest.approx(wanted, rel=5e-3)
    for pair, mu in wanted.items():
        assert found.intervals[pair] == pytest.approx(mu * np.exp([-0.196, 0.196]), rel=2e-2)
    alone = hf.friction_from(stack(), pushes[:1], scatter=0.1)
    assert alone.intervals["cube2", "cube3"][0] == pytest.approx(0.3 * np.exp(-0.196), rel=2e-2)
    assert alone.intervals["cube2", "cube3"][1] == np.inf, "with 0.15 below, the two upper cubes slip at the same force"
    assert "1 pushes depend on several coefficients, whose effects are added up" in alone.notes


def test_pairs_of_the_same_materials_share_a_coefficient() -> None:
    bodies = [box(name, (0.1, 0.1, 0.1), 1, (x, 0, 0.05)) for name, x in (("cube", 0.0), ("other", 0.5))]
    bodies = [hf.Body(b.name, b.shape, mass=1, pose=b.pose, material="oak") for b in bodies]
    found = hf.friction_from(hf.Scene([floor(), *bodies], 0.6), [low(0.5 * G)], scatter=0.1)
    assert found.intervals[PAIR] != found.intervals.get(("floor", "other")), "pushes reach one group only"
    table = hf.Body("table", hf.Box((2, 2, 0.1)), mass=50, position=(0, 0, 0.05))
    raised = [body.moved(at(body.com_world[0], 0, 0.15)) for body in bodies]
    scene = hf.Scene([floor(), table, *raised], 0.6)
    found = hf.friction_from(scene, [("cube", (-0.05, 0, 0.101), X, 0.5 * G)], scatter=0.1, engine="limit")
    assert found.intervals["cube", "table"] == found.intervals["other", "table"]
    assert found.intervals["cube", "table"] == pytest.approx(0.5 * np.exp([-0.196, 0.196]), rel=1e-3)


def test_two_that_act_together_are_known_together_only() -> None:
    """A cube half on one board and half on the next, in line with the push, slides at the mean of both coefficients."""
    ends = (("a", -0.25), ("b", 0.25))
    boards = [hf.Body(name, hf.Box((0.5, 1, 0.1)), position=(x, 0, -0.05), fixed=True) for name, x in ends]
    scene = hf.Scene([*boards, box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.6)
    found = hf.friction_from(scene, [low(0.5 * G)] * 4, scatter=0.1)
    for pair in (("a", "cube"), ("b", "cube")):
        assert found.intervals[pair][0] == 0
        assert 0.85 < found.intervals[pair][1] < 1.1  # twice the mean, less what the other has at least
    assert found.mu["a", "cube"] + found.mu["b", "cube"] == pytest.approx(1.0, abs=0.02)


def test_pushes_that_contradict_each_other_are_undecided() -> None:
    found = hf.friction_from(cube(), [low(1.0), low(10.0)], scatter=0.1)
    assert found.undecided.startswith("no coefficients explain the pushes within a scatter of 0.1: push ")
    assert not found.mu
    assert found.undetermined == (PAIR,)
    held = hf.friction_from(cube(), [low(1.0), low(1.05), low(10.0, False)], scatter=0.1)
    assert "held at 10 N" in held.undecided or "moved at" in held.undecided
    spread = hf.friction_from(cube(), [low(f) for f in (1.0, 2.0, 4.0, 1.5, 3.0, 2.5)])
    assert spread.undecided == ""
    assert any("scatter by" in note for note in spread.notes)
    assert "within a scatter of 3" in hf.friction_from(cube(), [low(1.0), low(1e4)]).undecided


@pytest.mark.parametrize(("forces", "contradict"), [((5.0, 7.5), False), ((4.9, 8.2), True), ((2.45, 4.1), True)])
def test_pushes_contradict_each_other_where_a_thousandth_of_all_would_be_as_far_apart(
    forces: tuple[float, float], contradict: bool
) -> None:
    """ln² of their ratio / (2 0.1²) is of chi² with one degree of freedom: 8.2 is of 0.4 %, 13.3 is of 0.03 %."""
    found = hf.friction_from(cube(), [low(force) for force in forces], scatter=0.1)
    assert bool(found.undecided) is contradict
    assert bool(found.mu) is not contradict


def test_other_questions_take_the_answer() -> None:
    found = hf.friction_from(cube(), [low(f * G) for f in (0.45, 0.5, 0.55)])
    worst = hf.sets.worst_case(cube(), "cube", LOW, X, mu_range=found.mu_range)
    assert float(worst) == pytest.approx(found.mu_range[PAIR][0] * G, rel=1e-3)
    sampled = hf.robustness_under(cube(), "cube", LOW, X, hf.sets.Uncertain(mu_range=found.mu_range, samples=20))
    assert (
        float(worst) * 0.999 <= sampled.quantile(0)[0] <= sampled.quantile(1)[0] <= found.mu_range[PAIR][1] * G * 1.001
    )


@pytest.mark.parametrize(
    ("given", "count", "limit", "draws"),
    [(0.1, 10, None, 200), (None, 10, None, 200), (0.1, 20, 0.05, 150), (None, 20, 0.05, 150)],
)
def test_intervals_cover_the_truth_as_often_as_stated(
    given: float | None, count: int, limit: float | None, draws: int
) -> None:
    """Draws of noise of 10 %: coverage within its 99.9 % binomial bounds, width beside Cramér and Rao's bound.

    With a ``limit``, pushes end where ln(force / predicted) reaches it: those that held until then are one-sided.
    """
    rng, s, steps = np.random.default_rng(7), 0.1, np.linspace(-1.6, 1.6, 33)
    covered, widths = 0, []
    for logs in s * rng.standard_normal((draws, count)):
        moved = np.ones(count, dtype=bool) if limit is None else logs < limit
        fit = Fit(
            np.zeros(count),
            (steps,),
            (np.tile(steps[:, None], (1, count)),),
            np.where(moved, logs, limit or 0),
            moved,
            given,
        )
        ends = fit.interval(0, fit.best(), 0.95)
        covered += ends[0] <= 0 <= ends[1]
        widths.append(ends[1] - ends[0])
    u = np.inf if limit is None else limit / s
    tail = 0.0 if limit is None else stats.norm.pdf(u) * (u - stats.norm.pdf(u) / stats.norm.sf(u))
    information = count * (stats.norm.cdf(u) - tail) / s**2
    best = 2 * stats.norm.ppf(0.975) / np.sqrt(information)
    least, most = stats.binom.interval(0.999, draws, 0.95)
    assert least <= covered <= most
    assert 0.97 < np.mean(widths) / best < (1.03 if given else 1.2)


@pytest.mark.parametrize(
    ("measured", "match"),
    [
        ([], r"measured: is empty; needs at least one push"),
        ("cube", r"measured: is 'cube'; needs a list of pushes as \(body, point, direction, force\)"),
        ([("cube", LOW, X)], r"push 0: is .*; needs pushes as"),
        ([low(1.0), low(-1.0)], r"push 1: force: is -1; needs a finite number > 0"),
        ([("cub", LOW, X, 1.0)], r"'cub'; did you mean 'cube'"),
        ([("floor", (0, 0, 0), X, 1.0)], r"push 0: 'floor' is fixed; name movable bodies"),
        ([("cube", (0, 0, 0.5), X, 1.0)], r"push 0: point 0 at .* from the surface"),
        ([low(1.0)], r"scatter: cannot be estimated from 1 pushes that moved something and 1 coefficients; give more"),
        ([low(1.0, False)] * 3, r"scatter: cannot be estimated from 0 pushes"),
    ],
)
def test_what_makes_no_sense_is_refused(measured: Any, match: str) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        hf.friction_from(cube(), measured)


def test_what_falls_on_its_own_tells_nothing_of_friction() -> None:
    air = hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.3))], 0.6)
    found = hf.friction_from(air, [("cube", (-0.05, 0, 0.3), X, 1.0)], scatter=0.1)
    assert found.undecided == "it does not stand even without a push, or is only balanced"


@pytest.mark.parametrize("mu", [0.02, 5.0])
def test_the_scene_need_not_be_near(mu: float) -> None:
    scene = hf.Scene([floor(), box("cube", (0.3, 0.3, 0.01), 1, (0, 0, 0.005))], 0.6)
    found = hf.friction_from(scene, [("cube", (-0.15, 0, 0.001), X, mu * G)], scatter=0.1, engine="limit")
    assert found.intervals[PAIR] == pytest.approx(mu * np.exp([-0.196, 0.196]), rel=1e-2)
