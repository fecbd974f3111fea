"""Bodies that are balanced exactly over an edge: what `compliant` promises of them, against what `limit` proves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.base.rigid import pose_from
from holdfast.scene.shipped.blocks import at

EDGE = 0.3  # [m] where the block ends
SIDE = 0.03


def over_the_edge(turn: float, segments: int) -> hf.answers.Assembly:
    """An upright prism, turned about its axis, with its axis over the edge of a fixed block."""
    half = np.array([np.cos(turn / 2), 0, 0, np.sin(turn / 2)])
    prism = hf.Body(
        "prism", hf.Cylinder(SIDE / 2, SIDE, segments), mass=10, pose=pose_from(np.array([EDGE, 0, SIDE / 2]), half)
    )
    block = hf.Body("block", hf.Box((2 * EDGE, 2 * EDGE, 0.1)), pose=at(0, 0, -0.05), fixed=True)
    return hf.assemble(hf.Scene([block, prism], 2.0))


@pytest.mark.parametrize(("turn", "segments"), [(0.0, 8), (0.4, 11), (1.1, 7), (2.0, 32)])
def test_nothing_is_promised_that_limit_analysis_disproves(turn: float, segments: int) -> None:
    """A push that has any moment over the edge moves it; elastic nodes seemed to hold some of them."""
    assembly = over_the_edge(turn, segments)
    surface = assembly.scene.body("prism").surface_world
    points = surface.vertices[surface.faces].mean(1)
    inward, slanted = -surface.normals, np.random.default_rng(1).normal(size=points.shape)
    for along in (inward, slanted):
        limit, found = (
            hf.robustness(assembly, "prism", points, along, engine=engine) for engine in ("limit", "compliant")
        )
        known = found.status != hf.Status.UNDECIDED
        allowed = 1e-6 * assembly.weight
        assert (found.force <= 1.002 * limit.upper + allowed)[known].all()
        assert (found.lower <= limit.upper + allowed)[known].all()
        assert known.mean() > 0.5


FLOOR = hf.Body("floor", hf.Box((6, 6, 0.1)), pose=at(0, 0, -0.05), fixed=True)
BRICK, WEIGHT = hf.Box((0.2, 0.1, 0.06)), 2 * 9.81


def block(name: str, x: float, y: float, z: float, side: float = 0.1, **options: Any) -> hf.Body:
    return hf.Body(name, hf.Box((side, 0.1, 0.1)), pose=at(x, y, z), **{"mass": 1.0, **options})


def half_over() -> hf.answers.Assembly:
    """A brick whose centre of mass lies over the right edge, x = 0.05, of the fixed cube below it."""
    cube = block("cube", 0, 0, -0.05, fixed=True)
    return hf.assemble(hf.Scene([cube, hf.Body("top", BRICK, mass=2.0, pose=at(0.05, 0, 0.03))], 0.5))


def bond(courses: int, bricks: int, shift: float) -> hf.answers.Assembly:
    """A running bond, every other course of which is shifted."""
    laid = [
        hf.Body(f"c{i}_{j}", BRICK, mass=2.0, pose=at(0.2 * j + shift * (i % 2), 0, 0.03 + 0.06 * i))
        for i in range(courses)
        for j in range(bricks)
    ]
    return hf.assemble(hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), *laid], 0.5))


def named(assembly: hf.answers.Assembly, engine: str = "compliant") -> set[str]:
    """The bodies that the verdict calls only balanced."""
    verdict = hf.stability(assembly, engine=engine)
    assert verdict.status is hf.Status.STABLE
    told = verdict.reason.partition("only balanced")[2]
    return {body.name for body in assembly.movable if f" {body.name}" in told.replace(",", "")}


PUSHES = [  # point, direction and force [N] of the brick half over: over the edge any force has a moment or none
    ((-0.05, 0, 0.06), (0, 0, -1), np.inf),  # on the inner end
    ((0.05, 0, 0.06), (0, 0, -1), np.inf),  # right above the edge
    ((0.06, 0, 0.06), (0, 0, -1), 0.0),  # a centimetre outside it: all but the moment is carried
    ((0.0501, 0, 0.06), (0, 0, -1), 0.0),
    ((-0.05, 0, 0.03), (1, 0, 0), 0.0),
    ((0.15, 0, 0.03), (-1, 0, 0), 0.5 * WEIGHT),  # slides
    ((0.05, -0.05, 0.03), (0, 1, 0), 0.5 * WEIGHT),
    ((0.15, 0, 0), (0, 0, 1), WEIGHT * 0.1 / 0.2),  # lifted at its outer end it tips about the other edge of the cube
    ((0.1, 0.02, 0), (0, 0, 1), WEIGHT * 0.1 / 0.15),
]


@pytest.mark.parametrize("engine", ["graph", "limit", "compliant", hf.Compliant(nodes=2), hf.Compliant(nodes=14)])
def test_a_brick_half_over_an_edge_falls_at_any_moment_about_it(engine: Any) -> None:
    points, along, force = (np.array(column, dtype=float) for column in zip(*PUSHES, strict=True))
    found = hf.robustness(half_over(), "top", points, along, engine=engine)
    np.testing.assert_allclose(found.force, force, rtol=2e-3, atol=1e-12)
    assert (found.lower <= force).all()
    assert any("only balanced" in note and "top" in note for note in found.notes)


BASE = block("base", 0, 0, 0.05, fixed=True)
TOP = block("top", 0.05, 0, 0.15)


@pytest.mark.parametrize(
    ("bodies", "balanced"),
    [
        pytest.param([BASE, TOP], {"top"}, id="over an edge"),
        pytest.param([BASE, block("top", 0.05, 0.05, 0.15)], {"top"}, id="over a corner"),
        pytest.param([block("base", 0, 0, 0.05, mass=5), TOP], {"top"}, id="over an edge of a loose body"),
        pytest.param([BASE, TOP, block("on", 0.05, 0, 0.25)], {"top", "on"}, id="with a body on it"),
        pytest.param(
            [BASE, block("top", 0.025, 0, 0.15), block("on", 0.075, 0, 0.25)], {"top", "on"}, id="two at once"
        ),
        pytest.param(
            [BASE, block("top", 0.05, 0, 0.15, 0.2), block("on", 0, 0, 0.25)], set(), id="with a counterweight"
        ),
        pytest.param([BASE, TOP, block("wall", 0.15, 0, 0.15, fixed=True)], set(), id="in front of a wall"),
        pytest.param([BASE, TOP, block("wall", -0.05, 0, 0.15, fixed=True)], {"top"}, id="with a wall behind it"),
        pytest.param([BASE, TOP, block("pillar", 0.1, 0, 0.05, fixed=True)], set(), id="on two pillars"),
        pytest.param([BASE, block("top", 0, 0, 0.15, 0.6)], set(), id="a plank on a pillar"),
    ],
)
def test_what_some_least_push_moves_is_named(bodies: list[hf.Body], balanced: set[str]) -> None:
    """The wall that touches a body behind it cannot pull it back, and the one in front of it stops it at once."""
    assert named(hf.assemble(hf.Scene([FLOOR, *bodies], 0.5), gap=1e-6)) == balanced


def test_limit_and_compliant_say_so_in_the_same_words() -> None:
    reasons = [hf.stability(half_over(), engine=engine).reason for engine in ("limit", "compliant")]
    ends = [reason.partition("; only balanced")[2] for reason in reasons]
    assert ends[0] == ends[1] != ""


def test_a_bond_of_whole_bricks_is_answered_as_one_shifted_by_a_little_less() -> None:
    """The last brick of the upper course is balanced on the edge of the one below; all others are not."""
    whole, less = (hf.robustness_map(bond(2, 2, shift), spacing=0.05) for shift in (0.1, 0.0999))
    assert named(whole.assembly) == {"c1_1"}
    assert not named(less.assembly)
    assert not (whole.status == hf.Status.UNDECIDED).any()
    assert whole.body.tolist() == less.body.tolist()
    tips = (whole.body == "c1_1") & (less.force < 0.05 * WEIGHT)
    assert tips.any()
    assert (whole.force[tips] == 0).all()
    assert (whole.force[~tips] > 0.05 * WEIGHT).all()
    both = np.isfinite(whole.force) & np.isfinite(less.force) & ~tips
    np.testing.assert_allclose(whole.force[both], less.force[both], rtol=0.02)


def flush(rng: np.random.Generator) -> tuple[hf.answers.Assembly, np.ndarray, float]:
    """A ball on the floor that just touches one to three blocks, in a gap or a corner; its centre and radius."""
    radius, loose = rng.uniform(0.02, 0.06), bool(rng.integers(2))
    side = 1.6 * radius  # blocks at a right angle do not touch each other
    reach, options = radius + side / 2, {"fixed": not loose, "mass": rng.uniform(0.5, 3)}
    places = [(-reach, 0), (reach, 0), (0, reach)]
    chosen = [places[k] for k in rng.permutation(3)[: rng.integers(1, 4)]]
    shape = hf.Box((side, side, 0.1))
    blocks = [hf.Body(f"w{k}", shape, pose=at(x, y, 0.05), **options) for k, (x, y) in enumerate(chosen)]
    ball = hf.Body("ball", hf.Sphere(radius), mass=rng.uniform(0.1, 3), pose=at(0, 0, radius))
    return (
        hf.assemble(hf.Scene([FLOOR, *blocks, ball], rng.uniform(0.1, 0.9)), gap=1e-6),
        np.array([0, 0, radius]),
        radius,
    )


def test_balls_flush_between_blocks_roll_at_no_push_or_at_a_clear_one() -> None:
    """T6: six pushes of such balls got 0.0002 to 0.0007 of the weight, which only the regularisation spring carried."""
    for seed in range(12):
        rng = np.random.default_rng(seed)
        assembly, centre, radius = flush(rng)
        assert named(assembly) == {"ball"}
        ways = rng.normal(size=(8, 3))
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        points = centre - radius * ways
        along = rng.normal(size=(8, 3))
        along *= np.sign((along * ways).sum(1))[:, None]
        found, limit = (hf.robustness(assembly, "ball", points, along, engine=e) for e in ("compliant", "limit"))
        weight = 9.81 * assembly.scene.body("ball").mass
        known = found.status == hf.Status.FINITE
        assert ((found.force == 0) | (found.force > 3e-3 * weight))[known].all()
        assert (found.force[known & (limit.upper < 1e-9 * weight)] == 0).all()
        assert any("only balanced" in note and "ball" in note for note in found.notes)


def test_a_cylinder_between_two_walls_that_just_touch_it_is_held() -> None:
    """Rolling either way presses one of them: nothing resists at rest, but no push moves it at once."""
    rod = hf.Body("rod", hf.Cylinder(0.05, 0.2), mass=1.0, position=(0, 0, 0.05), rpy_degrees=(90, 0, 0))
    walls = [hf.Body(n, hf.Box((0.1, 0.3, 0.1)), pose=at(x, 0, 0.05), fixed=True) for n, x in (("l", -0.1), ("r", 0.1))]
    assembly = hf.assemble(hf.Scene([FLOOR, rod, *walls], 0.5))
    assert not named(assembly)
    points, along = [(-0.05, 0, 0.05), (0.05, 0, 0.05), (0, -0.1, 0.05)], [(1, 0, 0), (-1, 0, 0), (0, 1, 0)]
    found = hf.robustness(assembly, "rod", points, along)
    np.testing.assert_allclose(found.force, [np.inf, np.inf, 0.5 * 9.81], rtol=2e-3)


def leaning_neighbours(seed: int, *, beside: bool, behind: bool) -> hf.answers.Assembly:
    """A box half over the edge of a slab, which its weight tilts: towards a flush neighbour, or before one."""
    rng, deep = np.random.default_rng(seed), (0.2, 0.1, 0.1)
    bodies = [
        hf.Body("floor", hf.HalfSpace(), fixed=True),
        hf.Body("low", hf.Box((0.4, 0.4, 0.1)), mass=rng.uniform(0.5, 3), position=(-0.2, 0, 0.05)),
        hf.Body("top", hf.Box(deep), mass=rng.uniform(0.5, 4), position=(0, 0.15, 0.15)),
    ]
    if beside:
        loose = {"fixed": seed % 2 == 0, "mass": 5.0}
        bodies.append(hf.Body("block", hf.Box((0.4, 0.2, 0.1)), position=(-0.2, 0.3, 0.05), **loose))
        bodies.append(hf.Body("beside", hf.Box(deep), mass=rng.uniform(0.3, 3), position=(-0.15, 0.25, 0.15)))
    if behind:
        high = hf.Box((0.1, 0.1, 0.2))
        bodies.append(hf.Body("behind", high, mass=rng.uniform(0.3, 3), position=(-0.15, 0.15, 0.2)))
    pose = np.eye(4)
    pose[:3, :3] = turn = Rotation.random(random_state=seed).as_matrix() if seed else np.eye(3)
    scene = hf.Scene([body.moved(pose @ body.pose) for body in bodies], 0.5, gravity=turn @ (0, 0, -9.81))
    return hf.assemble(scene)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("beside", "behind"), [(True, False), (False, True), (True, True)])
def test_a_box_half_over_an_edge_is_balanced_whatever_leans_against_it(seed: int, beside: bool, behind: bool) -> None:
    """By hand: flush sides carry nothing, so any moment about the edge tips it, and none on the inside of the edge."""
    assembly = leaning_neighbours(seed, beside=beside, behind=behind)
    assert named(assembly) == {"top"}
    points, along = np.array([(0.09, 0.15, 0.2), (0.1, 0.15, 0.15), (-0.09, 0.15, 0.2)]), [[0, 0, -1], [0.3, 0, -1]]
    along = np.array([*along, along[0]], dtype=float)
    pose = assembly.scene.body("low").pose
    place = points - (-0.2, 0, 0.05)  # in the frame of the slab
    found = hf.robustness(assembly, "top", place @ pose[:3, :3].T + pose[:3, 3], along @ pose[:3, :3].T)
    np.testing.assert_array_equal(found.force[:2], 0)
    np.testing.assert_array_equal(found.lower[:2], 0)
    assert found.force[2] > assembly.weight


def wedged(seed: int, *, gap: float = 0.0) -> hf.answers.Assembly:
    """Two equal cylinders between two walls that they touch, and a third in their groove; one wall is ``gap`` away."""
    rng = np.random.default_rng(seed)
    radius, apart, length = rng.uniform(0.015, 0.04), rng.uniform(1.02, 1.3), rng.uniform(0.08, 0.2)
    lying = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])
    shape, half = hf.Cylinder(radius, length), apart * radius

    def rod(name: str, x: float, z: float) -> hf.Body:
        return hf.Body(name, shape, mass=0.1, pose=np.array(at(x, 0, z)) @ lying)

    wall = hf.Box((0.01, 2 * length, 0.1))
    walls = [
        hf.Body(f"wall{side}", wall, pose=at(side * (half + radius + 0.005) + max(side, 0) * gap, 0, 0.05), fixed=True)
        for side in (-1, 1)
    ]
    rods = [rod("c0", -half, radius), rod("c1", half, radius)]
    rods.append(rod("d0", 0, radius + np.sqrt(4 * radius**2 - half**2)))
    return hf.assemble(hf.Scene([FLOOR, *walls, *rods], 0.5))


@pytest.mark.parametrize("seed", range(4))
def test_cylinders_wedged_between_walls_are_held_by_them(seed: int) -> None:
    """All of them roll together, one way or the other, and close the gap to a wall; `limit` proves what they hold."""
    assembly = wedged(seed)
    assert not named(assembly)
    rng = np.random.default_rng(seed)
    for name in ("c0", "c1", "d0"):
        surface = assembly.scene.body(name).surface_world
        chosen = rng.integers(len(surface.faces), size=12)
        points, inward = surface.vertices[surface.faces[chosen]].mean(1), -surface.normals[chosen]
        along = inward + 0.4 * rng.normal(size=(12, 3))
        found, limit = (hf.robustness(assembly, name, points, along, engine=e) for e in ("compliant", "limit"))
        known = found.status != hf.Status.UNDECIDED
        assert (limit.lower > 0).all()
        assert (found.force > 0)[known].all()
        assert (found.force <= 1.002 * limit.upper)[known].all()
        assert known.mean() > 0.9


def test_cylinders_with_room_to_roll_are_balanced() -> None:
    """A wall that is far away stops nobody: all three roll off towards it."""
    assert named(wedged(0, gap=0.02)) == {"c0", "c1", "d0"}
