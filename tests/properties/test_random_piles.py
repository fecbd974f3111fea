"""Properties of all engines on random piles of boxes: no nonsense, a convex gauge of loads, and who is above whom."""

from __future__ import annotations

from typing import Any

import numpy as np
from engine_scenes import Array, block, cube, floor
from hypothesis import example, given, settings
from hypothesis import strategies as st

from holdfast import Body, Compliant, Limit, Load, Scene, Status, assemble, load_factor, robustness
from holdfast.answers import Assembly
from holdfast.engines.answers import Answers

FEW = settings(max_examples=20, deadline=None, derandomize=True)

lengths = st.floats(0.05, 0.3)


def parts(share: float, most: int) -> st.SearchStrategy[Any]:
    """Up to ``most`` boxes: the size, the mass, and the shift of each, as a share of what ``pile`` says."""
    shares = st.floats(-share, share)
    one = st.tuples(st.tuples(lengths, lengths, lengths), st.floats(0.1, 10), st.tuples(shares, shares))
    return st.lists(one, min_size=1, max_size=most)


piles = st.tuples(parts(0.8, 3), st.floats(0.1, 1.2))
shares = st.floats(-0.95, 0.95)
vectors = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1)
wrenches = st.tuples(*[st.floats(-1, 1)] * 6).filter(lambda w: np.linalg.norm(w) > 0.1)


def pile(drawn: Any, overhang: float = 0.5) -> Assembly:
    """Boxes face to face; each is shifted by a share of ``overhang`` times the half-width of the one below."""
    bodies: list[Body] = [floor(4.0)]
    centre, top, half = np.zeros(2), 0.0, np.zeros(2)
    for k, (size, mass, shift) in enumerate(drawn[0]):
        centre = centre + overhang * np.array(shift) * half
        bodies.append(block(f"b{k}", size, (*centre, top + size[2] / 2), mass))
        half, top = np.array(size[:2]) / 2, top + size[2]
    return assemble(Scene(bodies, drawn[1]))


def on_top(assembly: Assembly, engine: Any, *loads: Any) -> Answers:
    """Factors of forces [N] and moments [0.1 N m] on the uppermost body."""
    W = np.zeros((6 * len(assembly.movable), len(loads)))
    W[-6:] = np.array(loads).T
    W[-3:] *= 0.1
    return engine.prepare(assembly).load_factor(W)


def sound(got: Answers) -> None:
    assert not np.isnan([got.force, got.lower, got.upper]).any()
    assert (got.lower >= 0).all()
    assert (got.lower <= got.force).all()
    assert (got.force <= got.upper).all()
    for force, status, mechanism in zip(got.force, got.status, got.mechanism, strict=True):
        assert (force == np.inf) == (status is Status.INFINITE)
        assert (mechanism is not None) == (status in (Status.FINITE, Status.UNSTABLE))


@FEW
@given(parts(0.95, 4), st.floats(0, 1.5), st.tuples(shares, shares), st.integers(0, 2), vectors, st.integers(0, 3))
def test_graph_is_never_negative_nor_nan(boxes: Any, mu: float, share: Any, axis: int, way: Any, which: int) -> None:
    assembly = pile((boxes, mu), overhang=1.0)
    body = assembly.movable[which % len(boxes)]
    half = body.shape.size / 2
    point = body.com_world + np.insert(np.array(share) * np.delete(half, axis), axis, half[axis])
    answer = robustness(assembly, body.name, point, way, engine="graph")
    assert answer.force[0] >= 0
    assert np.isfinite(answer.force[0]) == (answer.status[0] != "infinite")


@FEW
@given(st.floats(0.05, 1.5), st.floats(0, 50), st.floats(0, 2 * np.pi), st.tuples(shares, shares))
def test_weight_on_top_never_lowers_slip_resistance(mu: float, load: float, azimuth: float, at: Any) -> None:
    """Low centred pushes on a flat box slide; a load within its base adds mu times itself."""
    assembly = cube(mu, height=0.01)
    top = Load("cube", (0.016 * at[0], 0.016 * at[1], 0.01), (0, 0, -load))
    push = [Load("cube", (0, 0, 0), (np.cos(azimuth), np.sin(azimuth), 0))]
    before, after = (load_factor(assembly, push, standing=standing, engine="graph").factor for standing in ([], [top]))
    assert before <= after * (1 + 1e-6)
    np.testing.assert_allclose(before, mu * 9.81, rtol=1e-6)


@FEW
@given(piles, wrenches, wrenches)
def test_the_inverse_of_limit_is_a_convex_gauge_of_loads(drawn: Any, one: Any, other: Any) -> None:
    assembly = pile(drawn)
    state = Limit().prepare(assembly)
    assert state.verdict().residual < 1e-6 or state.verdict().status is not Status.STABLE
    found = on_top(assembly, Limit(), one, other, np.add(one, other))
    sound(found)
    with np.errstate(divide="ignore"):
        a, b, both = 1 / found.force
    assert both <= (a + b) * (1 + 1e-6) + 1e-9


@FEW
@given(piles, vectors, vectors, st.floats(0.05, 0.95))
def test_sustainable_accelerations_form_a_convex_set(drawn: Any, one: Any, other: Any, share: float) -> None:
    assembly = pile(drawn)
    state = Limit().prepare(assembly)

    def limit(acceleration: Array) -> float:
        forces = np.zeros((len(assembly.movable), 6))
        forces[:, :3] = -assembly.mass[:, None] * acceleration
        return float(state.load_factor(forces.reshape(-1, 1)).force[0])

    reached = [min(limit(np.array(d)), 100.0) * np.array(d) for d in (one, other)]
    between = share * reached[0] + (1 - share) * reached[1]
    if np.linalg.norm(between) > 1e-6:
        assert limit(between) >= 1 - 1e-6


BLOCK, UP = ((0.25, 0.25, 0.25), 1.0, (0.0, 0.0)), (0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
NARROW = ((0.078125, 0.125, 0.203125), 1.0, (0.0, 0.0))
AT_THE_EDGE = (0.2109375, 0.0, -0.86328125, 0.0, -0.515625, 0.08203125)  # a coarse grid finds an end, a finer one none


@settings(max_examples=40, deadline=None, derandomize=True)
@given(piles, st.lists(wrenches, min_size=10, max_size=10))
@example(([BLOCK, BLOCK, NARROW], 0.4375), [*[UP] * 9, AT_THE_EDGE])
def test_compliant_is_never_above_limit(drawn: Any, forces: Any) -> None:
    assembly = pile(drawn)
    verdict, certain = (engine.prepare(assembly).verdict() for engine in (Compliant(), Limit()))
    if verdict.status is not Status.STABLE:
        assert verdict.status is Status.UNSTABLE
        assert certain.status is not Status.STABLE
        return
    got, proved = (on_top(assembly, engine, *forces) for engine in (Compliant(), Limit()))
    sound(got)
    assert (got.force <= proved.upper * (1 + 1e-6)).all()
