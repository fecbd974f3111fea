"""Bounds that hold in exact arithmetic: against 50 digits, for ill-conditioned scenes and for spoilt solver results."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal
from functools import cache

import numpy as np
import pytest
from engine_scenes import G0, X, Z, block, cube, floor, push_wrench, shipped
from limit_scenes import BEYOND_DOUBLE, columns, push

from bench.scenes.ill_conditioned import FAMILIES, Query, queries
from holdfast import Friction, Limit, Scene, Status, assemble
from holdfast.answers import Bound
from holdfast.conic.solve import Outcome
from holdfast.engines.answers import Answers
from holdfast.engines.limit.limit_state import LimitState
from holdfast.engines.limit.proof import LoadProgram, SolvedLoad

SIDE = (0.1, 0.1, 0.1)
NARROW = 1e-6  # width of the bounds, relative to the truth


@cache
def asked(family: str, count: int) -> list[tuple[Query, Answers]]:
    """Queries of a family and their answers; those on one assembly come one after the other."""
    rng = np.random.default_rng([5, list(FAMILIES).index(family)])
    found: list[tuple[Query, Answers]] = []
    state: LimitState | None = None
    for query in queries(family, rng, count):
        if state is None or state.assembly is not query.assembly:
            state = Limit().prepare(query.assembly)
        found.append((query, state.load_factor(query.load[:, None])))
    return found


def check(family: str, count: int) -> list[float]:
    """See that the truth is inside the bounds, to the last of 50 digits; return the widths of the bounds."""
    widths = []
    for query, found in asked(family, count):
        lower, upper = Decimal(float(found.lower[0])), Decimal(float(found.upper[0]))
        assert lower <= query.truth <= upper
        assert found.lower[0] <= found.force[0] <= found.upper[0]
        assert (found.lower_bound, found.upper_bound) == (Bound.PROVED, Bound.PROVED)
        widths.append(float((upper - lower) / query.truth))
    return widths


@pytest.mark.parametrize("family", FAMILIES)
def test_the_truth_is_inside(family: str) -> None:
    assert np.median(check(family, 40)) <= NARROW


@pytest.mark.slow
def test_the_truth_is_inside_for_a_thousand_ill_conditioned_queries() -> None:
    widths = np.array([width for family in FAMILIES for width in check(family, 250)])
    assert len(widths) == 1000
    assert (widths <= NARROW).mean() >= (0.95 if BEYOND_DOUBLE else 0.9)


def noisy(share: float) -> Callable[[SolvedLoad, np.random.Generator], SolvedLoad]:
    """Noise in proportion to the largest entry of forces and motion, and to the factor."""

    def spoil(good: SolvedLoad, rng: np.random.Generator) -> SolvedLoad:
        forces, motion = (v + share * np.abs(v).max() * rng.standard_normal(len(v)) for v in (good.forces, good.motion))
        return replace(good, forces=forces, motion=motion, factor=good.factor * (1 + share * rng.standard_normal()))

    return spoil


def exchanged(good: SolvedLoad, rng: np.random.Generator) -> SolvedLoad:
    """The numbers of some nodes and of some bodies change places."""
    forces = good.forces.reshape(-1, 3)[rng.permutation(len(good.forces) // 3)].ravel()
    return replace(good, forces=forces, motion=good.motion.reshape(-1, 3)[::-1].ravel())


SPOILT: dict[str, Callable[[SolvedLoad, np.random.Generator], SolvedLoad]] = {
    "as it is": lambda good, _: good,
    **{f"noise {share:g}": noisy(share) for share in (1e-12, 1e-9, 1e-6, 1e-3)},
    "exchanged": exchanged,
    "no forces": lambda good, _: replace(good, forces=0 * good.forces),
    "no motion": lambda good, _: replace(good, motion=0 * good.motion),
    "other way": lambda good, _: replace(good, motion=-good.motion, forces=-good.forces),
    "twice the factor": lambda good, _: replace(good, factor=2 * good.factor),
    "not a number": lambda good, _: replace(good, forces=np.nan * good.forces),
    "motion not a number": lambda good, _: replace(good, motion=np.nan * good.motion),
    "factor not a number": lambda good, _: replace(good, factor=np.nan),
    "huge": lambda good, _: replace(good, forces=1e300 * good.forces, motion=1e300 * good.motion, factor=1e300),
    "endless": lambda good, _: replace(good, outcome=Outcome.UNBOUNDED),
    "given up": lambda good, _: replace(good, outcome=Outcome.TROUBLE),
}


def spoiling(monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    """From now on, what the solver finds is spoilt."""
    rng, original = np.random.default_rng(7), LoadProgram.maximise

    def spoilt(program: LoadProgram, load: np.ndarray, around: float | None = None) -> SolvedLoad:
        return SPOILT[kind](original(program, load, around), rng)

    monkeypatch.setattr(LoadProgram, "maximise", spoilt)


@pytest.mark.parametrize("kind", SPOILT)
def test_spoilt_results_of_the_solver_spoil_no_bound(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    spoiling(monkeypatch, kind)
    for family in FAMILIES:
        for query in queries(family, np.random.default_rng(3), 12):
            found = Limit().prepare(query.assembly).load_factor(query.load[:, None])
            assert not np.isnan([found.lower[0], found.force[0], found.upper[0]]).any()
            assert Decimal(float(found.lower[0])) <= query.truth <= Decimal(float(found.upper[0]))
            assert found.lower[0] <= found.force[0] <= found.upper[0]


@pytest.mark.parametrize("kind", SPOILT)
@pytest.mark.parametrize("name", ["table", "arch", "wall2x2", "v_groove", "wedged_floor"])
def test_spoilt_bounds_agree_with_sound_ones(name: str, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """No lower bound is above an upper bound that another solve of the same load proved."""
    state = Limit().prepare(shipped(name))
    W = columns(shipped(name), 12, 1)
    sound = state.load_factor(W)
    spoiling(monkeypatch, kind)
    found = Limit().prepare(shipped(name)).load_factor(W)
    assert (found.lower <= sound.upper).all()
    assert (sound.lower <= found.upper).all()


def test_a_little_noise_costs_little(monkeypatch: pytest.MonkeyPatch) -> None:
    W = columns(shipped("table"), 12, 1)
    spoiling(monkeypatch, "noise 1e-09")
    found = Limit().prepare(shipped("table")).load_factor(W)
    finite = np.isfinite(found.force)
    assert finite.sum() >= 6
    assert ((found.upper - found.lower)[finite] <= 1e-5 * found.upper[finite]).all()


def test_what_only_pushing_presses_together_is_proved_with_forces_of_its_own() -> None:
    """On a smooth floor the sides of two boxes bear nothing at rest; pushed against a wall, they carry their weight."""
    wall = block("wall", (0.1, 1, 1), (0.25, 0, 0.5), fixed=True)
    bodies = [floor(), wall, block("a", SIDE, (0.15, 0, 0.05)), block("b", SIDE, (0.05, 0, 0.05))]
    smooth = {("floor", "a"): 0.0, ("floor", "b"): 0.0}
    assembly = assemble(Scene(bodies, Friction(0.5, pairs=smooth)))
    found = push(assembly, "b", (0, 0, 0.02), X + Z)
    assert found.lower[0] == pytest.approx(found.upper[0], rel=1e-6)
    assert found.lower_bound is Bound.PROVED
    assert found.lower[0] > 9


def test_endless_answers_are_proved_where_the_forces_are_inside_their_cones() -> None:
    pressed = push(cube(), "cube", (0.02, 0.02, 0.1), -Z)
    assert (pressed.lower[0], pressed.lower_bound) == (np.inf, Bound.PROVED)
    edge = push(cube(), "cube", (0, 0, 0), (0.6, 0, -1))  # along the border of the cone, but for the last digit
    assert edge.lower[0] > 1e6
    assert edge.upper[0] == np.inf


def test_a_fall_is_proved_and_a_knife_edge_is_not() -> None:
    slope = G0 * np.array([0.7, 0, -1])
    state = Limit().prepare(cube(0.6, gravity=slope))
    fallen = state.load_factor(push_wrench(state.assembly, "cube", (0, 0, 0.05), X)[:, None])
    assert fallen.status[0] is Status.UNSTABLE
    assert (fallen.upper[0], fallen.upper_bound) == (0, Bound.PROVED)


def test_without_room_in_the_cones_lower_is_an_estimate_and_says_so() -> None:
    """A cube on a slope as steep as its friction stands on the border of every cone."""
    assembly = cube(0.5, gravity=G0 * np.array([0.5, 0, -1]))
    found = Limit().prepare(assembly).load_factor(push_wrench(assembly, "cube", (-0.05, 0, 0.05), -X)[:, None])
    assert found.lower_bound is not Bound.PROVED or found.lower[0] == 0
    assert any("estimate" in note for note in found.notes) or found.lower_bound is Bound.PROVED
