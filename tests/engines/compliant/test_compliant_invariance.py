"""What must not change an answer, and that it never exceeds that of engine ``limit`` on the same nodes."""

import numpy as np
import pytest
from compliant_scenes import SMALL, columns, even_grid, random_pushes, strength
from engine_scenes import X, block, floor, shipped
from hypothesis import example, given, settings
from hypothesis import strategies as st

import holdfast as hf
from holdfast import Body, Compliant, Scene, Status, assemble

OFF = ("cube", (-0.05, 0.045, 0.02), X)


@pytest.mark.parametrize("stiffness", [1e3, 1e6, 1e9])
def test_stiffness_drops_out(stiffness: float) -> None:
    assert strength(shipped("cube"), *OFF, stiffness=stiffness) == pytest.approx(
        strength(shipped("cube"), *OFF), rel=1e-6
    )
    named = {i.bodies: stiffness for i in shipped("table").interfaces}
    point, direction = (0.2, -0.1, 0.225), (0.2, 1, 0)
    one, other = (strength(shipped("table"), "slab", point, direction, stiffness=s) for s in (named, None))
    assert one == pytest.approx(other, rel=1e-4)


def test_unequal_stiffness_sends_the_load_to_the_stiffer_support() -> None:
    """A slab on three legs: how much the middle one carries depends on its stiffness."""
    legs = [block(f"leg{k}", (0.05, 0.2, 0.2), (x, 0, 0.1)) for k, x in enumerate((-0.2, 0, 0.2))]
    assembly = assemble(Scene([floor(), *legs, block("slab", (0.5, 0.2, 0.05), (0, 0, 0.225), 3.0)], 0.5))

    def carried(ratio: float) -> float:
        named = dict.fromkeys((("floor", "leg1"), ("leg1", "slab")), ratio)
        forces = hf.stability(assembly, engine=Compliant(stiffness=named)).forces
        joint = [{"leg1", "slab"} == set(i.bodies) for i in assembly.interfaces].index(True)
        return float(np.abs(forces.force[forces.interface == joint, 2]).sum())

    total = 3 * 9.81
    assert carried(1.0) == pytest.approx(total / 3, rel=1e-6)  # equal weights on the floor's contacts sink alike
    assert carried(1.0) < carried(3.0) < carried(1e3) <= total * (1 + 1e-9)


@pytest.mark.parametrize("ratio", [0.5, 0.75])
def test_tangential_stiffness_matters_little(ratio: float) -> None:
    assert strength(shipped("cube"), *OFF, stiffness_ratio=ratio) == pytest.approx(
        strength(shipped("cube"), *OFF), rel=0.01
    )


def moved(scene: Scene, motion: np.ndarray, order: list[int], prefix: str) -> Scene:
    bodies = []
    for k in order:
        b = scene.bodies[k]
        bodies.append(Body(prefix + b.name, b.shape, mass=b.mass, com=b.com, pose=motion @ b.pose, fixed=b.fixed))
    return Scene(bodies, scene.friction, motion[:3, :3] @ scene.gravity)


@pytest.mark.parametrize("name", ["cube", "stack", "table"])
def test_rigid_motion_and_new_names(name: str) -> None:
    assembly = shipped(name)
    rng = np.random.default_rng(8)
    axis, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    motion = np.eye(4)
    motion[:3, :3] = axis * np.sign(np.linalg.det(axis))
    motion[:3, 3] = rng.normal(size=3)
    order = list(rng.permutation(len(assembly.bodies)))
    other = assemble(moved(assembly.scene, motion, order, "new "))
    for body, point, direction in random_pushes(assembly, 6, 9):
        here = strength(assembly, body, point, direction)
        there = strength(other, "new " + body, motion[:3, :3] @ point + motion[:3, 3], motion[:3, :3] @ direction)
        assert there == (pytest.approx(here, rel=2e-2) if np.isfinite(here) else here)


def test_splitting_a_patch_with_its_nodes_changes_nothing() -> None:
    """Two halves that keep the nodes and weights of the whole, under one interface each."""
    assembly = shipped("cube")
    (whole,) = assembly.interfaces
    (patch,) = whole.patches
    low, high = patch.polygon.min(0), patch.polygon.max(0)
    middle = (low[0] + high[0]) / 2
    halves = []
    for a, b in ((low[0], middle), (middle, high[0])):
        outline = [(a, low[1], 0), (b, low[1], 0), (b, high[1], 0), (a, high[1], 0)]
        halves.append(hf.answers.Interface(whole.bodies, outline, patch.normal))
    split = assemble(assembly.scene, interfaces=halves)
    answers = []
    for given_ in (assembly, split):
        nodes = even_grid(given_, 21)
        load = columns(given_, [("cube", np.array(OFF[1]), X)])
        answers.append(Compliant().on(given_, given_.weight_wrench(), nodes).grid.paths(load).peak[0])
    assert answers[0] == pytest.approx(answers[1], rel=3e-3)


@pytest.mark.parametrize("name", SMALL)
def test_never_above_limit_on_shipped_scenes(name: str) -> None:
    assembly = shipped(name)
    W = columns(assembly, random_pushes(assembly, 25, 31))
    check(Compliant().prepare(assembly).load_factor(W), hf.Limit().prepare(assembly).load_factor(W))


def check(got: object, certain: object) -> None:
    assert not np.isnan([got.force, got.lower, got.upper]).any()
    assert (got.lower <= got.force).all()
    assert (got.force <= got.upper).all()
    for k, status in enumerate(got.status):
        assert status in (Status.FINITE, Status.INFINITE)
        assert (status is Status.INFINITE) == np.isinf(got.force[k])
        assert (got.mechanism[k] is None) == (status is Status.INFINITE)
        assert got.force[k] <= certain.upper[k] * (1 + 1e-6)


lengths = st.floats(0.05, 0.3)
shares = st.floats(-0.8, 0.8)
parts = st.tuples(st.tuples(lengths, lengths, lengths), st.floats(0.1, 10), st.tuples(shares, shares))
piles = st.tuples(st.lists(parts, min_size=1, max_size=3), st.floats(0.1, 1.2))
loads = st.lists(st.tuples(*[st.floats(-1, 1)] * 6).filter(lambda w: np.linalg.norm(w) > 0.1), min_size=10, max_size=10)


def pile(drawn: tuple) -> hf.answers.Assembly:
    """Boxes face to face; each centre is shifted by a share of half the half-width of its support."""

    def placed(name: str, size: tuple, centre: tuple, mass: float | None) -> Body:
        pose = np.eye(4)
        pose[:3, 3] = centre
        return Body(name, hf.Box(np.array(size)), mass=mass, pose=pose, fixed=mass is None)

    bodies = [placed("floor", (4, 4, 0.1), (0, 0, -0.05), None)]
    centre, top, half = np.zeros(2), 0.0, np.zeros(2)
    for k, (size, mass, shift) in enumerate(drawn[0]):
        centre = centre + 0.5 * np.array(shift) * half
        bodies.append(placed(f"b{k}", size, (*centre, top + size[2] / 2), mass))
        half, top = np.array(size[:2]) / 2, top + size[2]
    return assemble(Scene(bodies, drawn[1]))


BLOCK, UP = ((0.25, 0.25, 0.25), 1.0, (0.0, 0.0)), (0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
NARROW = ((0.078125, 0.125, 0.203125), 1.0, (0.0, 0.0))
AT_THE_EDGE = (0.2109375, 0.0, -0.86328125, 0.0, -0.515625, 0.08203125)  # a coarse grid finds an end, a finer one none


@settings(max_examples=50, deadline=None, derandomize=True)
@given(piles, loads)
@example(([BLOCK, BLOCK, NARROW], 0.4375), [*[UP] * 9, AT_THE_EDGE])
def test_never_above_limit_on_random_piles(drawn: tuple, forces: list) -> None:
    assembly = pile(drawn)
    state = Compliant().prepare(assembly)
    certain = hf.Limit().prepare(assembly)
    if state.verdict().status is not Status.STABLE:
        assert state.verdict().status is Status.UNSTABLE
        assert certain.verdict().status is not Status.STABLE
        return
    W = np.zeros((6 * len(assembly.movable), len(forces)))
    W[-6:] = np.array(forces).T
    W[-3:] *= 0.1
    check(state.load_factor(W), certain.load_factor(W))


@pytest.mark.parametrize("factor", [1e-3, 1.0, 1e4])
def test_a_larger_load_has_a_smaller_factor(factor: float) -> None:
    assembly = shipped("table")
    W = columns(assembly, random_pushes(assembly, 6, 3))
    state = Compliant().prepare(assembly)
    one, other = state.load_factor(W), state.load_factor(factor * W)
    np.testing.assert_allclose(factor * other.force, one.force, rtol=1e-4)


def test_bound_is_that_of_limit() -> None:
    assembly = shipped("table")
    point, direction = [(0.2, -0.1, 0.225), (0, 0, 0.25)], [(0, 1, 0), (0, 0, -1)]
    asked = hf.robustness(assembly, "slab", point, direction, engine="compliant", bounds=True)
    limit = hf.robustness(assembly, "slab", point, direction, engine="limit")
    np.testing.assert_array_equal(asked.upper, limit.upper)
    assert asked.lower[0] < asked.force[0] < asked.upper[0]
    plain = hf.robustness(assembly, "slab", point, direction, engine="compliant")
    assert np.isinf(plain.upper).all()
    load = [hf.Load("slab", point[0], force=direction[0])]
    factor = hf.load_factor(assembly, load, engine="compliant", bounds=True)
    assert factor.upper == pytest.approx(6.2267738, rel=1e-6)
    with pytest.raises(hf.HoldfastError, match="not ordered"):
        hf.load_factor(assembly, load, engine="graph", bounds=True)


def test_no_load_is_carried_for_ever() -> None:
    found = Compliant().prepare(shipped("cube")).load_factor(np.zeros((6, 2)))
    assert np.isinf(found.force).all()
    assert set(found.status) == {Status.INFINITE}


@pytest.mark.parametrize(
    "options",
    [{"nodes": 1}, {"nodes": 2.5}, {"stiffness_ratio": 0}, {"stiffness": -1.0}, {"stiffness": {("a", "b"): 0}}],
)
def test_wrong_options_raise(options: dict) -> None:
    with pytest.raises(hf.HoldfastError):
        Compliant(**options)
