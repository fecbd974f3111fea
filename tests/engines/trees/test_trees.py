"""Loads that only plane contacts carry, one behind the other: closed forms, and what other engines say."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import holdfast as hf
from bench.scenes.random_trees import random_tower
from holdfast.engines.compliant.engine import Compliant, state_on
from holdfast.engines.groups import prepared
from holdfast.engines.limit_engine import Limit
from holdfast.engines.trees.forest import Forest
from holdfast.engines.trees.tree_state import TreeState, with_trees
from holdfast.scene.shipped.blocks import box, floor

G = 9.81


def tower(*blocks: tuple[float, float, float], mu: float | hf.Friction = 0.5, lean: float = 0.0) -> hf.answers.Assembly:
    """Blocks (width, height, mass) one upon the other on the floor, under gravity that leans by an angle along x."""
    bodies, top = [floor()], 0.0
    for k, (width, height, mass) in enumerate(blocks):
        bodies.append(box(f"b{k}", (width, width, height), mass, (0, 0, top + height / 2)))
        top += height
    return hf.assemble(hf.Scene(bodies, mu, gravity=(G * np.sin(lean), 0, -G * np.cos(lean))))


def decided(assembly: hf.answers.Assembly) -> list[bool]:
    return Forest(assembly, assembly.weight_wrench()).decided.tolist()


def test_a_block_tips_or_slides_as_by_hand() -> None:
    """Pushed level at a height h, it slides at μ W and tips at W b / (2 h); both are proved."""
    assembly = tower((0.1, 0.2, 2.0), mu=0.3)
    for height, force, mode in ((0.02, 0.3 * 2 * G, "slip"), (0.19, 2 * G * 0.05 / 0.19, "topple")):
        found = hf.robustness(assembly, "b0", (-0.05, 0, height), (1, 0, 0))
        assert float(found) == pytest.approx(force, rel=1e-5)
        assert found.lower[0] == pytest.approx(force, rel=2e-4)
        assert found.lower[0] <= force
        assert found.answers.mechanism[0].mode == mode
        assert str(found.answers.lower_bound) == "proved"


@pytest.mark.parametrize(("height", "mode"), [(0.12, "slip"), (0.19, "topple")])
def test_where_friction_is_looked_at_in_places_alone_nothing_is_called_proved(height: float, mode: str) -> None:
    """Pushed off its middle a block also turns, and between two places on the way only experience bounds that."""
    found = hf.robustness(tower((0.1, 0.2, 2.0), mu=0.4), "b0", (-0.05, 0.01, height), (1, 0, 0))
    assert found.answers.mechanism[0].mode == mode
    assert str(found.lower_bound) == "estimated"
    assert 0.99 * found.force[0] < found.lower[0] <= found.force[0]


@pytest.mark.parametrize("foot", [0, 1, 2])
def test_the_contact_with_the_least_friction_slides_with_all_that_is_above(foot: int) -> None:
    """Three blocks of 1, 2 and 3 kg: a push on top slides the contact whose μ times the weight above is least."""
    above = np.array([6.0, 5.0, 3.0]) * G
    mu = 0.4 * above[2] / above  # all would slide at once
    mu[foot] *= 0.8
    pairs = {("floor", "b0"): mu[0], ("b0", "b1"): mu[1], ("b1", "b2"): mu[2]}
    assembly = tower((0.3, 0.02, 1.0), (0.3, 0.02, 2.0), (0.3, 0.02, 3.0), mu=hf.Friction(0.5, pairs=pairs))
    found = hf.robustness(assembly, "b2", (-0.15, 0, 0.05), (1, 0, 0))
    assert float(found) == pytest.approx(0.8 * 0.4 * above[2], rel=1e-5)
    assert found.answers.mechanism[0].moving == tuple(f"b{k}" for k in range(foot, 3))


def test_on_a_slope_a_push_down_it_meets_what_the_weight_leaves() -> None:
    """A block of weight W on a slope of φ: W (μ cos φ - sin φ) downwards, W (μ cos φ + sin φ) upwards."""
    assembly, lean = tower((0.2, 0.02, 2.0), lean=0.3), 0.3
    for way in (1, -1):
        found = hf.robustness(assembly, "b0", (-way * 0.1, 0, 0.01), (way, 0, 0))
        assert float(found) == pytest.approx(2 * G * (0.5 * np.cos(lean) - way * np.sin(lean)), rel=1e-5)


def test_a_twist_of_a_square_block() -> None:
    """The friction of an even square carries the torque μ N a (√2 + asinh 1) / 6."""
    assembly = tower((0.1, 0.1, 2.0))
    W = np.array([[0.0, 0, 0, 0, 0, 1]]).T
    found = prepared(Compliant(), assembly).load_factor(W)
    assert found.force[0] == pytest.approx(0.5 * 2 * G * 0.1 * (np.sqrt(2) + np.arcsinh(1)) / 6, rel=1e-6)


@pytest.mark.parametrize("seed", range(8))
def test_random_towers_beside_paths_and_limits(seed: int) -> None:
    """Contacts of any outline: paths on 15 nodes a side give way within 1.5 %, and nothing beyond what limit proves."""
    rng = np.random.default_rng(seed)
    while True:
        drawn = random_tower(rng)
        if len(drawn.weights) <= 4 and all(decided(drawn.assembly)):
            break
    W = rng.normal(size=(6 * len(drawn.weights), 6)) * np.tile([1, 1, 1, 0.05, 0.05, 0.05], len(drawn.weights))[:, None]
    W[:, :3] *= np.repeat(np.arange(len(drawn.weights)) == len(drawn.weights) - 1, 6)[:, None]  # three on top alone
    found = with_trees(Compliant(), drawn.assembly, None, None).load_factor(W)
    paths = state_on(drawn.assembly, drawn.assembly.weight_wrench(), Compliant(nodes=15).springs).load_factor(W)
    limit = Limit().prepare(drawn.assembly).load_factor(W)
    assert (np.isfinite(found.force) == np.isfinite(paths.force)).all()
    ends = np.isfinite(found.force)
    assert_allclose(found.force[ends], paths.force[ends], rtol=0.015)
    assert (found.lower <= found.force).all()
    assert (found.lower >= 0.998 * found.force)[ends].all()
    assert (found.force <= limit.upper * (1 + 1e-6)).all()


def test_the_order_of_bodies_does_not_matter() -> None:
    scene = tower((0.3, 0.05, 1.0), (0.2, 0.05, 2.0), (0.1, 0.05, 3.0)).scene
    turned = hf.Scene(scene.bodies[::-1], scene.friction, gravity=scene.gravity)
    asked = [(-0.05, 0.02, 0.12), (0.05, 0, 0.14)], [(1, 0.2, -0.3), (-1, 0, 0)]
    one, other = (hf.robustness(each, "b2", *asked) for each in (scene, turned))
    assert_allclose(one.force, other.force, rtol=1e-9)


def gate() -> hf.answers.Assembly:
    """A slab on the floor, and on it two posts with a lintel: forces run around a loop, but all hangs on the slab."""
    posts = [box(f"post{k}", (0.05, 0.1, 0.1), 1.0, (0.1 * k, 0, 0.1)) for k in (-1, 1)]
    slab, lintel = box("slab", (0.5, 0.3, 0.05), 2.0, (0, 0, 0.025)), box("lintel", (0.3, 0.1, 0.02), 1.0, (0, 0, 0.16))
    return hf.assemble(hf.Scene([floor(), slab, *posts, lintel], 0.5))


def test_a_slab_under_a_gate_is_a_tree_and_the_gate_is_not() -> None:
    """A push on the slab carries all 5 kg with it; one on the lintel is answered as if there were no tree."""
    assembly = gate()
    assert decided(assembly) == [True, False, False, False]
    found = hf.robustness(assembly, "slab", (-0.25, 0, 0.01), (1, 0, 0))
    assert float(found) == pytest.approx(0.5 * 5 * G, rel=1e-5)
    assert set(found.answers.mechanism[0].moving) == {"slab", "post-1", "post1", "lintel"}
    state = with_trees(Compliant(), assembly, None, None)
    assert isinstance(state, TreeState)
    W = np.zeros((24, 3))
    W[0, 0], W[18, 1], W[[0, 18], 2] = 1.0, 1.0, 1.0
    both, behind = state.load_factor(W), state.behind.load_factor(W[:, 1:])
    assert_allclose(both.force[1:], behind.force, rtol=1e-12)
    assert both.force[0] == pytest.approx(0.5 * 5 * G, rel=1e-5)
    assert str(both.lower_bound) == "estimated", "the table says what holds for all of its rows"


def test_a_cube_that_tips_rises_and_goes_ahead() -> None:
    """It turns about its lower edge at (0.05, 0, 0), from which its centre is as far up as it is back."""
    assembly = hf.assemble(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1.0, (0, 0, 0.05))], 0.8))
    (mechanism,) = hf.robustness(assembly, "cube", (-0.05, 0, 0.1), (1, 0, 0)).mechanism
    vx, vy, vz, wx, wy, wz = mechanism.twists[0]
    assert wy > 0
    assert_allclose([vx, vz, vy, wx, wz], [0.05 * wy, 0.05 * wy, 0, 0, 0], atol=1e-9)


def test_held_is_what_is_proved_to_hold() -> None:
    assembly = hf.assemble(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1.0, (0, 0, 0.05))], 0.5))
    state = with_trees(Compliant(), assembly, None, None)
    assert isinstance(state, TreeState)
    W = np.zeros((6, 4))
    W[0] = 0.5 * G * np.array([0.9, 0.999, 1.0, 1.05])
    assert state.held(W).tolist() == [True, True, False, False]


def test_what_leans_on_a_neighbour_is_no_tree() -> None:
    """A wide block and a light one that touches it, both on the floor: neither hangs on the floor alone."""
    pair = [
        floor(),
        box("wide", (0.4, 0.1, 0.1), 5.0, (0, 0, 0.05)),
        box("light", (0.1, 0.1, 0.1), 0.1, (0.25, 0, 0.05)),
    ]
    assert decided(hf.assemble(hf.Scene(pair, 0.5))) == [False, False]


def test_what_stands_beyond_the_edge_is_left_to_the_engine() -> None:
    stack = [floor(), box("a", (0.1, 0.1, 0.1), 1.0, (0, 0, 0.05)), box("b", (0.1, 0.1, 0.1), 1.0, (0.051, 0, 0.15))]
    assembly = hf.assemble(hf.Scene(stack, 0.5))
    assert decided(assembly) == [True, False]
    assert hf.stability(assembly).status == "unstable"


@pytest.mark.parametrize("engine", [Compliant(), Limit()])
def test_what_is_told_at_once_is_what_the_engine_says(engine: Compliant | Limit) -> None:
    """The verdict on groups that rest, and that of the same groups prepared one by one."""
    rng, told = np.random.default_rng(5), 0
    for _ in range(60):
        assembly = random_tower(rng).assembly
        rests, quick = engine.firm(assembly, assembly.weight_wrench())
        full = with_trees(engine, assembly, None, None).verdict()
        if rests.all():
            told += 1
            assert (full.status, full.reason) == (quick.status, quick.reason)
            assert (full.equilibrium_exists, full.self_stress) == (quick.equilibrium_exists, quick.self_stress)
        else:
            assert full.status != "stable" or isinstance(engine, Limit) or not rests.any()
    assert 20 < told < 60, "both kinds are asked about"


def test_forces_at_rest_are_those_of_the_engine() -> None:
    assembly = tower((0.2, 0.1, 2.0), (0.1, 0.1, 1.0))
    answer = hf.stability(assembly)
    np.testing.assert_array_equal(answer.forces.force, Compliant().prepare(assembly).verdict().forces.force)
    assert answer.residual < 1e-8


def test_what_is_doubtful_is_left_to_the_engine() -> None:
    cube = box("cube", (0.1, 0.1, 0.1), 1.0, (0, 0, 0.05))
    assert decided(hf.assemble(hf.Scene([floor(), cube], 0.5), pose_sigma=0.001)) == [False], "it may not touch"
    ball = hf.Body("ball", hf.Sphere(0.05), mass=1.0, pose=hf.pose(0.3, 0, 0.05))
    assert decided(hf.assemble(hf.Scene([floor(), ball, cube], 0.5))) == [False, True]
    glued = hf.Friction(0.5, tension={("floor", "cube"): 1e4})
    assert decided(hf.assemble(hf.Scene([floor(), cube], glued))) == [False]
    with pytest.warns(hf.errors.HoldfastWarning, match="overlap"):
        deep = hf.assemble(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1.0, (0, 0, 0.03))], 0.5))
    assert hf.stability(deep).status is hf.Status.UNDECIDED


def cluttered(rng: np.random.Generator) -> hf.answers.Assembly:
    """A board with balls, pens, tins and boxes on it, and some on others; a few boxes are exactly over an edge."""
    lying = hf.pose(pitch=90)
    bodies, x = [floor(), box("board", (1.2, 0.3, 0.03), 2.0, (0, 0, 0.015))], -0.5
    while x < 0.35:
        x, z = x + rng.uniform(0.08, 0.2), 0.03
        for _ in range(rng.choice([1, 1, 2])):
            shape, turn, high = (
                (hf.Sphere(0.03), np.eye(4), 0.06),
                (hf.Capsule(0.01, 0.04), lying, 0.02),
                (hf.Cylinder(0.03, 0.06), np.eye(4), 0.06),
                (hf.Box((0.06, 0.06, 0.02)), np.eye(4), 0.02),
            )[rng.integers(4)]
            place = np.array(turn)
            place[:3, 3] = x, 0, z + high / 2
            com = (rng.choice([0, 0.03]), 0, 0) if isinstance(shape, hf.Box) else None
            bodies.append(hf.Body(f"b{len(bodies)}", shape, mass=rng.uniform(0.02, 2), pose=place, com=com))
            z += high
    return hf.assemble(hf.Scene(bodies, 0.5))


def test_what_a_tree_leaves_over_is_judged_as_in_the_whole() -> None:
    """Balls and pens on a board rest, only balanced, on their own as the engine says of all bodies together."""
    rng, alone = np.random.default_rng(1), 0
    for _ in range(12):
        assembly = cluttered(rng)
        state = with_trees(Compliant(), assembly, None, None)
        assert isinstance(state, TreeState)
        left, whole = state.judge(), state.behind.verdict()
        assert left is not None
        if left.status == "stable":
            alone += 1
            assert (whole.status, whole.reason, whole.balanced) == (left.status, left.reason, left.balanced)
            told = state.verdict()
            assert told.forces is not None
            assert told.residual == whole.residual
    assert alone > 5


def test_what_closes_a_loop_is_not_judged_without_what_bears_it() -> None:
    state = with_trees(Compliant(), gate(), None, None)
    assert isinstance(state, TreeState)
    assert state.judge() is None
