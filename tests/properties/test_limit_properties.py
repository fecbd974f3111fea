"""Properties of engine ``limit`` on random piles of boxes: a convex gauge of loads."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from holdfast import Body, Box, Limit, Scene, Status, assemble
from holdfast.answers import Assembly
from holdfast.engines.answers import Answers

FEW = settings(max_examples=20, deadline=None, derandomize=True)

lengths = st.floats(0.05, 0.3)
shares = st.floats(-0.8, 0.8)
parts = st.tuples(st.tuples(lengths, lengths, lengths), st.floats(0.1, 10), st.tuples(shares, shares))
piles = st.tuples(st.lists(parts, min_size=1, max_size=3), st.floats(0.1, 1.2))
components = st.floats(-1, 1)
wrenches = st.tuples(*[components] * 6).filter(lambda w: np.linalg.norm(w) > 0.1)
directions = st.tuples(*[components] * 3).filter(lambda d: np.linalg.norm(d) > 0.1)


def pile(drawn: tuple) -> Assembly:
    """Boxes face to face; each centre is shifted by a share of half the half-width of its support."""
    bodies = [placed("floor", (4, 4, 0.1), (0, 0, -0.05), None)]
    centre, top, half = np.zeros(2), 0.0, np.zeros(2)
    for k, (size, mass, shift) in enumerate(drawn[0]):
        centre = centre + 0.5 * np.array(shift) * half
        bodies.append(placed(f"b{k}", size, (*centre, top + size[2] / 2), mass))
        half, top = np.array(size[:2]) / 2, top + size[2]
    return assemble(Scene(bodies, drawn[1]))


def placed(name: str, size: tuple, centre: tuple, mass: float | None) -> Body:
    pose = np.eye(4)
    pose[:3, 3] = centre
    return Body(name, Box(np.array(size)), mass=mass, pose=pose, fixed=mass is None)


def on_top(assembly: Assembly, *loads: tuple) -> Answers:
    """Factors of forces [N] and moments [0.1 N m] on the uppermost body."""
    W = np.zeros((6 * len(assembly.movable), len(loads)))
    W[-6:] = np.array(loads).T
    W[-3:] *= 0.1
    return Limit().prepare(assembly).load_factor(W)


def inverse(answers: Answers) -> np.ndarray:
    with np.errstate(divide="ignore"):
        return np.asarray(1 / answers.force)


@FEW
@given(piles, wrenches)
def test_answers_are_never_negative_nor_nan(drawn: tuple, load: tuple) -> None:
    state = Limit().prepare(pile(drawn))
    assert state.verdict().residual < 1e-6 or state.verdict().status is not Status.STABLE
    got = on_top(pile(drawn), load)
    assert not np.isnan([got.force, got.lower, got.upper]).any()
    assert 0 <= got.lower[0] <= got.force[0] <= got.upper[0]
    assert (got.force[0] == np.inf) == (got.status[0] is Status.INFINITE)
    assert (got.mechanism[0] is not None) == (got.status[0] in (Status.FINITE, Status.UNSTABLE))


@FEW
@given(piles, wrenches, st.floats(-6, 6))
def test_a_larger_load_has_a_smaller_factor(drawn: tuple, load: tuple, exponent: float) -> None:
    t = 10.0**exponent
    got = on_top(pile(drawn), load, tuple(t * np.array(load)))
    np.testing.assert_allclose(t * got.force[1], got.force[0], rtol=1e-6)


@FEW
@given(piles, wrenches, wrenches)
def test_the_inverse_is_a_convex_gauge_of_loads(drawn: tuple, one: tuple, other: tuple) -> None:
    a, b, both = inverse(on_top(pile(drawn), one, other, tuple(np.add(one, other))))
    assert both <= (a + b) * (1 + 1e-6) + 1e-9


@FEW
@given(piles, directions, directions, st.floats(0.05, 0.95))
def test_sustainable_accelerations_form_a_convex_set(drawn: tuple, one: tuple, other: tuple, share: float) -> None:
    assembly = pile(drawn)
    state = Limit().prepare(assembly)

    def limit(acceleration: np.ndarray) -> float:
        forces = np.zeros((len(assembly.movable), 6))
        forces[:, :3] = -assembly.mass[:, None] * acceleration
        return float(state.load_factor(forces.reshape(-1, 1)).force[0])

    reached = [min(limit(np.array(d)), 100.0) * np.array(d) for d in (one, other)]
    between = share * reached[0] + (1 - share) * reached[1]
    if np.linalg.norm(between) > 1e-6:
        assert limit(between) >= 1 - 1e-6
