"""What falls by less than poses are known is undecided and told by what; what truly falls is told to fall."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from placed import at
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.scene.shipped.blocks import box, floor

ENGINES = ("compliant", "limit", "graph")
SIDE = (0.1, 0.1, 0.1)
LEFT, ALONG_X = (-0.05, 0, 0.05), (1.0, 0, 0)
SHELF = hf.Body("shelf", hf.Box((1.2, 0.4, 0.02)), pose=at(0, 0, -0.01), fixed=True)


def stability(*bodies: hf.Body, engine: str = "limit", mu: float = 0.5, **options: float) -> hf.answers.Stability:
    ground = () if any(body.fixed for body in bodies) else (floor(),)
    return hf.stability(hf.assemble(hf.Scene([*ground, *bodies], mu), **options), engine=engine)


def fixed(body: hf.Body) -> hf.Body:
    return dataclasses.replace(body, fixed=True)


def turned(axis: str, angle: float) -> NDArray[np.float64]:
    return np.asarray(Rotation.from_euler(axis, angle).as_matrix())


def posed(place: ArrayLike, turn: NDArray[np.float64]) -> NDArray[np.float64]:
    return at(*place, turn)


def cube(name: str, x: float, z: float, side: float = 0.1) -> hf.Body:
    return box(name, (side,) * 3, 1.0, (x, 0, z + side / 2))


@pytest.mark.parametrize("engine", ENGINES)
def test_a_hovering_body_is_undecided_alone_and_the_others_keep_their_answers(engine: str) -> None:
    alone = hf.assemble(hf.Scene([floor(), cube("low", 0, 0)], 0.5))
    both = hf.assemble(hf.Scene([floor(), cube("low", 0, 0), cube("high", 0, 0.10043)], 0.5))
    found = hf.stability(both, engine=engine)
    assert found.status is hf.Status.UNDECIDED
    assert found.equilibrium_exists is None
    assert [g.verdict.status.value for g in found.groups] == ["stable", "undecided"]
    assert (
        "high is 0.43 mm above 'low' (gap tolerance 0.17 mm) and would rest there: settle, or gap=0.001" in found.reason
    )
    assert found.moving == ("high",)
    one, other = (hf.robustness(a, "low", LEFT, ALONG_X, engine=engine) for a in (alone, both))
    assert one.force.tobytes() == other.force.tobytes()
    assert one.lower.tobytes() == other.lower.tobytes()
    above = hf.robustness(both, "high", (-0.05, 0, 0.15043), ALONG_X, engine=engine)
    assert above.status[0] is hf.Status.UNDECIDED
    assert above.lower[0] == 0
    assert any("high: undecided: no contact within tolerance" in note for note in above.notes)


def test_what_is_advised_helps() -> None:
    bodies = cube("low", 0, 0), cube("high", 0, 0.10043)
    assert stability(*bodies, gap=0.001).status is hf.Status.STABLE


@pytest.mark.parametrize(("side", "reach"), [(0.1, 0.01), (0.02, 0.1 * 0.02 * np.sqrt(3)), (0.5, 0.01)])
def test_the_reach_is_ten_millimetres_or_a_tenth_of_the_size(side: float, reach: float) -> None:
    assert stability(cube("it", 0, 0.99 * reach, side)).status is hf.Status.UNDECIDED
    assert stability(cube("it", 0, 1.01 * reach, side)).status is hf.Status.UNSTABLE


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("hover", [0.0, 0.001])
def test_a_tower_over_its_edge_falls(engine: str, hover: float) -> None:
    """Its centre is 5 mm beyond the edge below: no contact that it could have would hold it."""
    for height in (1, 3):
        tower = [cube(f"{k}", 0.055, 0.1 * (k + 1) + hover) for k in range(height)]
        found = stability(cube("base", 0, 0), *tower, engine=engine)
        assert found.status is hf.Status.UNSTABLE
        assert "0" in found.moving
        assert found.certificate is not None


@pytest.mark.parametrize("within", [True, False])
def test_a_body_that_tips_onto_a_ledge_one_millimetre_lower_is_undecided(within: bool) -> None:
    """The plank is 0.3 long and held over 0.1 of it; its other end lies 1 mm, or 30 mm, over a ledge."""
    lower = 0.099 if within else 0.07
    ledges = [
        fixed(box("high", (0.1, 0.1, 0.1), 1, (-0.1, 0, 0.05))),
        fixed(box("low", (0.05, 0.1, lower), 1, (0.12, 0, lower / 2))),
    ]
    found = stability(*ledges, box("plank", (0.3, 0.1, 0.02), 1, (0, 0, 0.11)))
    if within:
        assert found.status is hf.Status.UNDECIDED
        assert "plank is 1 mm above 'low'" in found.reason
    else:
        assert found.status is hf.Status.UNSTABLE


def test_a_wall_beside_a_falling_body_is_no_support() -> None:
    """Neither one wall 2 mm away nor a shaft of four, however deep the floor lies."""
    walls = [
        fixed(box(f"wall{k}", (0.1, 0.1, 0.4), 1, (0.102 * x, 0.102 * y, 0.3)))
        for k, (x, y) in enumerate(((1, 0), (-1, 0), (0, 1), (0, -1)))
    ]
    for count in (1, 4):
        found = stability(*walls[:count], cube("it", 0, 0.25))
        assert found.status is hf.Status.UNSTABLE
        assert found.moving == ("it",)


def test_what_hovers_over_a_falling_body_falls_with_it() -> None:
    found = stability(cube("one", 0, 0.3), cube("two", 0, 0.401))
    assert found.status is hf.Status.UNSTABLE
    assert found.moving == ("one", "two")


def test_bodies_that_hover_over_each_other_are_undecided_from_below() -> None:
    for order in itertools.permutations(range(3)):
        tower = [cube(f"{k}", 0, 0.1 * k + 0.002 * (k + 1)) for k in range(3)]
        found = stability(*[tower[k] for k in order])
        said = {g.bodies: g.verdict.reason for g in found.groups}
        assert {g.verdict.status for g in found.groups} == {hf.Status.UNDECIDED}
        assert "0 is 2 mm above 'floor'" in said["0",]
        assert "2 is 2 mm above '1'" in said["2",]


@pytest.mark.parametrize("seed", range(20))
def test_a_leaning_plank_below_its_friction_angle_slides(seed: int) -> None:
    """A uniform ladder with friction μ at both ends slides below tan θ = (1 - μ²) / (2 μ)."""
    rng = np.random.default_rng(seed)
    mu, length, thick = rng.uniform(0.1, 0.4), rng.uniform(0.2, 1.5), 0.02
    theta = rng.uniform(0.4, 0.9) * np.arctan((1 - mu**2) / (2 * mu))
    turn = turned("y", -theta)  # the end at +x rises
    corners = hf.Box((length, 0.1, thick)).surface.vertices @ turn.T
    place = [-corners[:, 0].max(), 0, -corners[:, 2].min()]
    plank = hf.Body("plank", hf.Box((length, 0.1, thick)), mass=1.0, pose=posed(place, turn))
    wall = fixed(box("wall", (0.2, 1.0, 2.0), 1.0, (0.1, 0, 1.0)))
    found = stability(floor(4, 2), wall, plank, mu=mu)
    assert found.status is hf.Status.UNSTABLE
    assert found.moving == ("plank",)


def test_steep_walls_are_met_too_late() -> None:
    """Walls 4 degrees from the vertical close in on a falling cube: 2 mm away from them it has 28 mm to go.

    Where they are 0.5 mm away, it has 7 mm, and is then held, as friction is steeper than they are.
    """
    for apart, status in ((2e-3, hf.Status.UNSTABLE), (0.5e-3, hf.Status.UNDECIDED)):
        walls = []
        for name, side in (("left", -1), ("right", 1)):
            turn = turned("y", side * np.radians(4))
            edge = np.array([side * 0.05, 0, 0.25])  # the lower one of the cube
            centre = edge + turn @ [side * (apart + 0.02), 0, 0]
            walls.append(fixed(hf.Body(name, hf.Box((0.04, 0.3, 0.4)), mass=1.0, pose=posed(centre, turn))))
        found = stability(*walls, cube("it", 0, 0.25))
        assert found.status is status, found.reason


@pytest.mark.parametrize("slope", [3.5, 8])
def test_a_cylinder_that_rolls_down_a_slope_falls(slope: float) -> None:
    """Its flank is always within reach of the slope, and never holds it."""
    turn = turned("y", np.radians(slope))
    ramp = hf.Body("ramp", hf.Box((1, 1, 0.1)), pose=posed(turn @ [0, 0, -0.05], turn), fixed=True)
    can = hf.Body(
        "can", hf.Cylinder(0.05, 0.2), mass=1.0, pose=posed(turn @ [0, 0, 0.05], turn @ turned("x", np.pi / 2))
    )
    found = stability(ramp, can)
    assert found.status is hf.Status.UNSTABLE


@pytest.mark.parametrize("angle", [0.8, 2.0, 4.0])
def test_a_box_that_stands_tilted_on_its_edge_would_fall_flat(angle: float) -> None:
    turn = turned("y", np.radians(angle))
    half = 0.05 * (np.sin(np.radians(angle)) + np.cos(np.radians(angle)))
    found = stability(hf.Body("it", hf.Box(SIDE), mass=1.0, pose=posed([0, 0, half], turn)))
    assert found.status is not hf.Status.UNSTABLE
    assert "it touches 'floor' tilted beyond tolerance" in found.reason
    assert ("angle_degrees=5" in found.reason) is (angle > 1)  # the name that hf.assemble takes
    steep = turned("y", np.radians(20))
    half = 0.05 * (np.sin(np.radians(20)) + np.cos(np.radians(20)))
    found = stability(hf.Body("it", hf.Box(SIDE), mass=1.0, pose=posed([0, 0, half], steep)))
    assert found.status is not hf.Status.STABLE  # on some processors the solver has trouble with a mere edge: undecided
    assert "would rest there" not in found.reason


def test_what_rests_keeps_its_answer_where_it_is_also_near_something() -> None:
    """A plank on two blocks, 1 mm over a third."""
    blocks = [box(f"{x}", SIDE, 1, (x, 0, 0.05)) for x in (-0.2, 0.2)] + [
        box("middle", (0.1, 0.1, 0.099), 1, (0, 0, 0.0495))
    ]
    plank = box("plank", (0.6, 0.1, 0.02), 1, (0, 0, 0.11))
    assert stability(*blocks, plank).status is hf.Status.STABLE


@pytest.mark.parametrize("engine", ENGINES)
def test_a_load_that_moves_what_rests_is_no_matter_of_poses(engine: str) -> None:
    """Pushed beyond its friction towards a neighbour 2 mm away, the cube does not stand, whatever stops it later."""
    assembly = hf.assemble(hf.Scene([floor(), cube("it", 0, 0), cube("next", 0.102, 0)], 0.5))
    push = hf.Load("it", (-0.05, 0, 0.02), force=(6, 0, 0))
    assert hf.stability(assembly, loads=[push], engine=engine).status is hf.Status.UNSTABLE
    assert hf.stability(assembly, engine=engine).status is hf.Status.STABLE


@pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("depth", [0.0005, 0.005, 0.02])
def test_an_overlap_beyond_the_tolerance_is_undecided_with_its_depth(engine: str, depth: float) -> None:
    found = stability(cube("sunk", 0, -depth), cube("other", 0.5, 0), engine=engine)
    assert {g.bodies: g.verdict.status.value for g in found.groups} == {("sunk",): "undecided", ("other",): "stable"}
    assert f"floor and sunk overlap by {depth * 1e3:.3g} mm" in found.reason
    assert "settle" in found.reason


def eight(hover: float) -> list[hf.Body]:
    """A shelf of eight unlike objects; the jar hovers."""
    return [
        SHELF,
        box("book", (0.15, 0.21, 0.03), 0.7, (-0.45, 0, 0.015)),
        hf.Body("cup", hf.Cylinder(0.035, 0.09), mass=0.25, pose=at(-0.45, 0.03, 0.075)),
        hf.Body("vase", hf.Cylinder(0.03, 0.2), mass=0.4, pose=at(-0.3, 0, 0.1)),
        hf.Body("orange", hf.Sphere(0.04), mass=0.2, pose=at(-0.2, 0, 0.04)),
        box("card", (0.09, 0.06, 0.002), 0.01, (-0.05, 0, 0.001)),
        hf.Body("jar", hf.Cylinder(0.04, 0.1), mass=0.5, pose=at(0.1, 0, 0.05 + hover)),
        box("radio", (0.2, 0.08, 0.12), 1.5, (0.3, 0, 0.06)),
        box("box", (0.1, 0.1, 0.06), 0.3, (0.5, 0, 0.03)),
    ]


@pytest.mark.parametrize("engine", ENGINES)
def test_on_a_shelf_of_eight_only_the_one_that_hovers_is_undecided(engine: str) -> None:
    flat, off = (hf.assemble(hf.Scene(eight(hover), 0.5)) for hover in (0.0, 0.0005))
    found = hf.stability(off, engine=engine)
    assert {g.bodies for g in found.groups if g.verdict.status is not hf.Status.STABLE} == {("jar",)}
    assert found.status is hf.Status.UNDECIDED
    assert "jar is 0.5 mm above 'shelf'" in found.reason
    point, along = (0.2, 0, 0.1), (1.0, 0, 0)
    one, other = (hf.robustness(a, "radio", point, along, engine=engine) for a in (flat, off))
    assert one.force.tobytes() == other.force.tobytes()


def cone(count: int, name: str, z: float, *, down: bool) -> hf.Body:
    """A flat cone of ``count`` needles and its base, apex up or down."""
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    ring = np.column_stack([0.15 * np.cos(angle), 0.15 * np.sin(angle), np.zeros(count)])
    i, j = np.arange(count), (np.arange(count) + 1) % count
    faces = np.vstack(
        [np.column_stack([i, j, np.full(count, count)]), np.column_stack([j, i, np.full(count, count + 1)])]
    )
    vertices = np.vstack([ring, [[0, 0, 0.003], [0, 0, 0]]])
    mesh = hf.Mesh(vertices * [1, 1, -1], faces[:, ::-1]) if down else hf.Mesh(vertices, faces)
    return hf.Body(name, mesh, mass=1, position=(0.003, 0, z) if down else (0, 0, z))


def test_where_too_many_faces_are_near_each_other_it_is_said_that_nothing_was_searched() -> None:
    """One cone hovers 1 mm over another: few needles are joined, and it is told what the many would cost."""
    for count, said in ((20, "would rest there"), (200, "was not searched: too many faces are near")):
        found = stability(cone(count, "low", 0, down=False), cone(count, "high", 0.007, down=True))
        assert found.status is hf.Status.UNDECIDED
        assert said in found.reason


def test_a_remedy_that_was_taken_is_not_proposed_again() -> None:
    """A bottle that leans by 2 degrees touches within the given gap: only the angle is too narrow."""
    floor = hf.Body("floor", hf.HalfSpace(), fixed=True)
    lean = np.radians(2.0)
    middle = 0.1 * np.cos(lean) + 0.03 * np.sin(lean)
    bottle = hf.Body("bottle", hf.Cylinder(0.03, 0.2), mass=0.5, position=(0, 0, middle), rpy_degrees=(2.0, 0, 0))
    scene = hf.Scene([floor, bottle], 0.5)
    wide, narrow = (hf.stability(hf.assemble(scene, gap=gap)).reason for gap in (0.003, 1e-5))
    assert "angle_degrees=5" in wide
    assert "gap=" not in wide
    assert "gap=" in narrow
