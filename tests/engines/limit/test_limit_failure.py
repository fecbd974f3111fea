"""Scenes that a solver finds hard: the right answer or an honest status, bounds that hold the truth, never NaN."""

import numpy as np
import pytest
from engine_scenes import G0, X, Y, Z, block, cube, floor, pose
from limit_scenes import push

from holdfast import Body, Cylinder, Friction, Load, Scene, Status, assemble, load_factor, stability
from holdfast.answers import Assembly, Interface, Robustness
from holdfast.scene.shipped import shipped_scene

SIDE = (0.1, 0.1, 0.1)


def honest(got: Robustness, truth: float, *, decided: bool = False, near: float = 1e-9) -> None:
    """Bounds that hold the truth, which contacts place to ``near``, and a force near it unless it is not known."""
    force, lower, upper = float(got.force[0]), float(got.lower[0]), float(got.upper[0])
    assert not np.isnan([force, lower, upper]).any()
    assert lower <= force <= upper
    assert lower <= truth * (1 + near)
    assert upper >= truth * (1 - near)
    if got.status[0] is Status.UNDECIDED:
        assert not decided
        assert force == 0
    else:
        assert force == pytest.approx(truth, rel=1e-3)


def pair(low: float, high: float) -> Assembly:
    """One cube on another."""
    return assemble(Scene([floor(), block("lo", SIDE, (0, 0, 0.05), low), block("hi", SIDE, (0, 0, 0.15), high)], 0.6))


@pytest.mark.parametrize("ratio", [1e3, 1e6, 1e9])
def test_a_light_body_on_a_heavy_one(ratio: float) -> None:
    assembly = pair(ratio, 1.0)
    assert stability(assembly, engine="limit").status is not Status.UNSTABLE
    for height, truth in ((0.02, 0.6 * G0), (0.1, 0.5 * G0)):
        honest(push(assembly, "hi", (-0.05, 0, 0.1 + height), X), truth, decided=ratio <= 1e3)
    honest(push(assembly, "hi", (0, 0, 0.2), Z), G0, decided=ratio <= 1e3)
    honest(push(assembly, "hi", (-0.05, 0.045, 0.12), X), 4.6365969276, decided=ratio <= 1e3)


@pytest.mark.parametrize("ratio", [1e3, 1e6])
def test_a_heavy_body_on_a_light_one(ratio: float) -> None:
    assembly = pair(1.0, ratio)
    assert stability(assembly, engine="limit").status is Status.STABLE
    honest(push(assembly, "hi", (-0.05, 0, 0.12), X), (ratio + 1) * G0 * 0.05 / 0.12)
    honest(push(assembly, "hi", (0, 0, 0.2), Z), ratio * G0)
    honest(push(assembly, "lo", (-0.05, 0, 0.02), X), 0.6 * (ratio + 1) * G0)


@pytest.mark.parametrize("ratio", [1e3, 1e6, 1e8])
def test_a_light_body_that_falls_beside_a_heavy_one_is_not_called_stable(ratio: float) -> None:
    shelf = block("shelf", SIDE, (0.5, 0, 0.05), fixed=True)
    heavy, light = block("heavy", SIDE, (0, 0, 0.05), ratio), block("light", SIDE, (0.56, 0, 0.15))
    result = stability(assemble(Scene([floor(), shelf, heavy, light], 0.6)), engine="limit")
    assert result.status is not Status.STABLE
    assert result.equilibrium_exists is not True


@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e5, 1e7])
def test_self_stress_of_a_light_body_is_seen_beside_a_heavy_one(ratio: float) -> None:
    """The heavy one stands on a floor of its own, 3 m away."""
    ground = block("ground", (2, 2, 0.1), (0, 3, -0.05), fixed=True)
    bodies = [*shipped_scene("wedged").bodies, ground, block("heavy", SIDE, (0, 3, 0.05), ratio)]
    result = stability(assemble(Scene(bodies, 0.6)), engine="limit")
    assert result.status is not Status.STABLE
    assert result.self_stress is not False


def tiny(side: float, *, on_top: bool, mass: float = 1.0) -> tuple[Assembly, np.ndarray]:
    """A cube of ``side`` beside or on top of one of 10 m; where it stands."""
    foot = np.array([0.0, 0, 10]) if on_top else np.array([7.0, 0, 0])
    bodies = [
        block("floor", (40, 40, 1), (0, 0, -0.5), fixed=True),
        block("large", (10, 10, 10), (0, 0, 5), 1.0),
        block("tiny", (side,) * 3, foot + side / 2 * Z, mass),
    ]
    return assemble(Scene(bodies, 0.6), gap=side / 100), foot


@pytest.mark.parametrize("on_top", [False, True])
@pytest.mark.parametrize("mass", [1.0, 1e-6])
def test_a_tenth_of_a_millimetre_beside_ten_metres(on_top: bool, mass: float) -> None:
    side = 1e-4
    assembly, foot = tiny(side, on_top=on_top, mass=mass)
    west = foot - side / 2 * X
    near = 2.0**-40 * 10 / side  # contacts are written with so many digits, here of coordinates of 10 m
    honest(push(assembly, "tiny", west + 0.2 * side * Z, X), 0.6 * G0 * mass, near=near)
    honest(push(assembly, "tiny", west + side * Z, X), 0.5 * G0 * mass, near=near)
    honest(push(assembly, "tiny", west + side * (0.45 * Y + 0.2 * Z), X), 4.6365969276 * mass, near=near)
    honest(push(assembly, "large", (-5, 0, 1), X), 0.6 * G0 * (1 + mass * on_top), decided=mass == 1)


@pytest.mark.parametrize("corners", [200, 1000])
def test_many_redundant_nodes(corners: int) -> None:
    angle = 2 * np.pi * np.arange(corners) / corners
    ring = 0.05 * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(corners)])
    body = Body("drum", Cylinder(0.05, 0.1), mass=1.0, pose=pose((0, 0, 0.05)))
    assembly = assemble(Scene([floor(), body], 0.6), interfaces=[Interface(("floor", "drum"), ring, Z)])
    assert stability(assembly, engine="limit").status is Status.STABLE
    honest(push(assembly, "drum", (-0.05, 0, 0.02), X), 0.6 * G0, decided=True)
    honest(push(assembly, "drum", (-0.05, 0, 0.09), X), G0 * 0.05 / 0.09, decided=True)
    assert push(assembly, "drum", (0.02, 0.02, 0.1), -Z).force[0] == np.inf
    twist = load_factor(assembly, [Load("drum", moment=Z)], engine="limit")
    assert twist.factor == pytest.approx(0.6 * G0 * 0.05, rel=1e-6)


def test_no_friction() -> None:
    got = push(cube(0), "cube", (-0.05, 0.01, 0.02), X)
    assert got.force[0] == pytest.approx(0, abs=1e-9)
    assert got.lower[0] == 0
    assert got.upper[0] < 1e-8
    assert got.status[0] is Status.FINITE
    assert push(cube(0), "cube", (0, 0, 0.1), Z).force[0] == pytest.approx(G0, rel=1e-6)
    assert push(cube(0), "cube", (0.02, 0, 0.1), -Z).force[0] == np.inf
    groove = assemble(Scene(shipped_scene("v_groove").bodies, 0.0))
    along = push(groove, "cube", (0, -0.05, 0.07), Y)
    assert along.force[0] == pytest.approx(0, abs=1e-9)
    middle = groove.movable[0].com_world
    across = load_factor(groove, [Load("cube", middle, X)], engine="limit")  # sides of 45 degrees: push against weight
    assert across.factor == pytest.approx(G0, rel=1e-6)


@pytest.mark.parametrize("mu", [1e-3, 1e3, 1e6])
def test_little_and_much_friction(mu: float) -> None:
    assembly = cube(mu)
    honest(push(assembly, "cube", (-0.05, 0, 0.02), X), min(mu, 2.5) * G0, decided=True)
    honest(push(assembly, "cube", (0, 0, 0.1), Z), G0, decided=True)
    assert push(assembly, "cube", (0, 0, 0.1), -Z).force[0] == np.inf
    table = assemble(Scene(shipped_scene("table").bodies, mu))
    # sways as before while friction allows it; with little, the slab or all slides
    truth = 7.3575 if mu > 1 else 2 * G0 * mu
    honest(push(table, "slab", (-0.25, 0, 0.225), X), truth, decided=mu <= 1e3)


def walled(mu: float, *more: Body, friction: float = 0.6) -> Assembly:
    """A column of three cubes, the lower two of them between walls that touch them, with friction ``mu``."""
    walls = [block(name, (0.05, 0.2, 0.2), (x, 0, 0.1), fixed=True) for name, x in (("l", -0.075), ("r", 0.075))]
    cubes = [block(f"c{k}", SIDE, (0, 0, 0.05 + 0.1 * k)) for k in range(3)]
    pairs = {(wall, cube): mu for wall in "lr" for cube in ("c0", "c1")}
    return assemble(Scene([floor(), *walls, *cubes, *more], Friction(friction, pairs=pairs)))


def test_clamped_contacts_prove_no_upper_bound_but_what_rests_on_them_has_one() -> None:
    """Forces between walls and cubes have no bound: whatever rounding leaves there might hold any push."""
    assembly = walled(0.6, block("aside", SIDE, (0.4, 0, 0.05)))
    for body, point in (("c2", (0, -0.05, 0.21)), ("aside", (0.4, -0.05, 0.01))):
        got = push(assembly, body, point, Y)
        honest(got, 0.6 * G0, decided=True)
        assert got.upper[0] <= 0.6 * G0 * (1 + 1e-5)
    slide = push(walled(0.0), "c0", (0, -0.05, 0.01), Y)  # the walls are smooth, the floor holds the whole column
    honest(slide, 0.6 * 3 * G0, decided=True)
    assert slide.upper[0] == np.inf


@pytest.mark.parametrize("held", [1e-9, 1e3, 1e6, 1e9, 1e12])
def test_standing_loads_of_any_size(held: float) -> None:
    answer = load_factor(
        cube(), [Load("cube", (-0.05, 0, 0), X)], standing=[Load("cube", (0, 0, 0.1), -held * Z)], engine="limit"
    )
    truth = 0.6 * (G0 + held)
    assert answer.lower <= truth * (1 + 1e-9)
    assert answer.upper >= truth * (1 - 1e-9)
    if answer.status is Status.UNDECIDED:
        assert held > 1e6
        assert answer.factor == 0
    else:
        assert answer.factor == pytest.approx(truth, rel=1e-5)


@pytest.mark.parametrize("step", [1e-3, 1e-5, 1e-7, 1e-9])
def test_pushes_that_are_almost_endless(step: float) -> None:
    """Bounds must hold the truth up to 1e9 N; "infinite" only where the weight is lost in rounding."""
    slab, base = block("slab", (0.2, 0.1, 0.02), (0, 0, 0.11)), block("base", SIDE, (0, 0, 0.05))
    overhang = push(assemble(Scene([floor(), base, slab], 0.6)), "slab", (0.05 + step, 0, 0.12), -Z)
    cone = push(cube(), "cube", (0, 0, 0), (0.6 * (1 + step), 0, -1))
    edge = push(cube(), "cube", (0.05, 0, 0.1), (step, 0, -1))
    truths = (G0 * 0.05 / step, G0 / step * np.hypot(0.6 * (1 + step), 1), G0 * 0.5 / step * np.hypot(step, 1))
    for got, truth in zip((overhang, cone, edge), truths, strict=True):
        if got.status[0] is Status.INFINITE:
            assert step < 1e-8
        elif got.status[0] is Status.UNDECIDED:
            assert step < 1e-6
            assert (got.force[0], got.lower[0], got.upper[0]) == (0, 0, np.inf)
        else:
            # detection places corners to about 1e-11 m, and the lever is a tenth of the step
            assert got.lower[0] <= truth * (1 + 1e-7 + 3e-10 / step)
            assert got.upper[0] >= truth * (1 - 1e-7 - 3e-10 / step)


def test_a_scene_on_the_knife_edge_is_not_nan() -> None:
    for mu in (0.5, np.nextafter(0.5, 0), np.nextafter(0.5, 1)):
        assembly = cube(mu, gravity=G0 * np.array([0.5, 0, -1]))
        got = push(assembly, "cube", (-0.05, 0, 0.05), X)
        assert got.force[0] == pytest.approx(0, abs=1e-6)
        assert got.lower[0] <= got.upper[0]
        up = push(assembly, "cube", (0.05, 0, 0.05), -X)
        assert up.force[0] == pytest.approx(0.5 * G0 + 0.5 * G0, rel=1e-5) or up.status[0] is not Status.FINITE


def test_undecided_and_unstable_answers_have_no_force() -> None:
    shelf = block("shelf", SIDE, (0, 0, 0.05), fixed=True)
    falling = assemble(Scene([shelf, block("cube", SIDE, (0.06, 0, 0.15))], 0.6))
    got = push(falling, "cube", (0.01, 0, 0.2), X)
    assert (got.force[0], got.lower[0], got.status[0]) == (0, 0, Status.UNSTABLE)
    ridge = Body("ridge", block("r", SIDE, (0, 0, 0)).shape, pose=pose((0, 0, 0.05 * np.sqrt(2)), turn()), fixed=True)
    edge = Body("cube", ridge.shape, mass=1.0, pose=pose((0, 0, 0.15 * np.sqrt(2)), turn()))
    unmodelled = assemble(Scene([ridge, edge], 0.6))  # a sharp edge along a sharp edge: no direction of contact
    got = push(unmodelled, "cube", (0, 0, 0.2 * np.sqrt(2)), -Z)
    assert got.status[0] is Status.UNDECIDED
    assert (got.force[0], got.lower[0], got.upper[0]) == (0, 0, np.inf)


def turn() -> np.ndarray:
    c = np.sqrt(0.5)
    return np.array([[c, 0, c], [0, 1, 0], [-c, 0, c]])
