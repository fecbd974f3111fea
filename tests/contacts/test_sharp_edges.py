"""Balls, capsules and cylinders on sharp edges and corners: where they touch, and that they roll there."""

from __future__ import annotations

import numpy as np
import pytest
from placed import at
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.base.arrays import Float

G = 9.81
ACROSS = Rotation.from_euler("y", 90, degrees=True).as_matrix()  # lays the z axis along x


def spun(seed: int) -> Float:
    return np.asarray(Rotation.random(random_state=seed).as_matrix())


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("seed", range(20))
def test_a_capsule_touches_a_box_where_a_search_finds_its_axis_nearest(seed: int, order: int) -> None:
    """At faces, edges and corners; the search is one for the nearest points of a segment and a box, which is convex."""
    rng = np.random.default_rng(seed)
    half, size, radius = rng.uniform(0.02, 0.1), rng.uniform(0.05, 0.2, 3), 0.03
    along, centre = spun(seed)[:, 2], rng.normal(size=3)
    centre *= 0.3 / np.linalg.norm(centre)

    def apart(x: Float) -> Float:
        return np.asarray(centre + x[0] * half * along - x[1:] * size / 2)

    best = minimize(
        lambda x: 1e4 * float(apart(x) @ apart(x)), np.zeros(4), bounds=[(-1, 1)] * 4, method="L-BFGS-B", tol=1e-18
    ).x
    way = apart(best) / np.linalg.norm(apart(best))
    shift = way * (radius - np.linalg.norm(apart(best)))  # now they touch exactly
    turn = spun(seed + 100)  # the whole scene
    box = hf.Body("box", hf.Box(size), pose=at(turn=turn), fixed=True)
    rod = hf.Body("rod", hf.Capsule(radius, 2 * half), mass=1, pose=at(*turn @ (centre + shift), turn @ spun(seed)))
    (interface,) = hf.assemble(hf.Scene([box, rod][::order], 0.5), gap=1e-5).interfaces
    (patch,) = interface.patches
    assert patch.kind == "point"
    assert patch.polygon[0] == pytest.approx(turn @ (best[1:] * size / 2), abs=1e-5)
    assert patch.normal == pytest.approx(order * turn @ way, abs=1e-3)


@pytest.mark.parametrize("engine", ["limit", "compliant"])
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("gap", [0.02, 0.05, 0.06])
def test_a_ball_on_the_edges_of_a_slot_rolls_along_it_and_tips_over_one(gap: float, seed: int, engine: str) -> None:
    """On its facets it withstood 0.9 N, and half of the ways to turn it were undecided.

    Pushed across at its middle it turns about an edge: R = m g (gap / 2) / height over it.
    """
    r, rise = 0.04, float(np.sqrt(0.04**2 - gap**2 / 4))
    sides = [
        hf.Body(f"side {s:+d}", hf.Box((0.5, 0.2, 0.1)), fixed=True, pose=at(0, s * (0.1 + gap / 2), -0.05))
        for s in (1, -1)
    ]
    ball = hf.Body("ball", hf.Sphere(r), mass=1, pose=at(0, 0, rise, spun(seed)))
    assembly = hf.assemble(hf.Scene([*sides, ball], 0.5))
    places = np.array([patch.polygon[0] for each in assembly.interfaces for patch in each.patches])
    assert places[np.argsort(places[:, 1])] == pytest.approx(np.array([(0, -gap / 2, 0), (0, gap / 2, 0)]), abs=1e-9)
    assert hf.stability(assembly, engine=engine).status == "stable"
    top = (0, 0, rise + r)
    push = hf.robustness(assembly, "ball", [top, (0, -r, rise)], [(1, 0, 0), (0, 1, 0)], engine=engine)
    assert push.force == pytest.approx([0, G * gap / 2 / rise], rel=2e-3, abs=1e-6)


@pytest.mark.parametrize("roll", [0.0, 1.0, 2.8, 40.0])
def test_a_cylinder_across_two_knife_edges_rolls_and_slides(roll: float) -> None:
    knives = [
        hf.Body(f"knife {x:+.2f}", hf.Box((0.05, 0.4, 0.05)), fixed=True, pose=at(x, 0, -0.05 / np.sqrt(2), turn))
        for x, turn in ((x, Rotation.from_euler("y", 45, degrees=True).as_matrix()) for x in (-0.06, 0.06))
    ]
    turn = ACROSS @ Rotation.from_euler("z", roll, degrees=True).as_matrix()
    rod = hf.Body("rod", hf.Cylinder(0.04, 0.2), mass=1, pose=at(0, 0, 0.04, turn))
    assembly = hf.assemble(hf.Scene([*knives, rod], 0.5))
    assert hf.stability(assembly).status == "stable"
    push = hf.robustness(assembly, "rod", [(0, -0.04, 0.04), (-0.1, 0, 0.04)], [(0, 1, 0), (1, 0, 0)], engine="limit")
    assert push.force == pytest.approx([0, 0.5 * G], rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("roll", [0.0, 1.7])
def test_a_cylinder_along_an_edge_touches_along_it(roll: float) -> None:
    """It leans on the edge of a step and lies on the floor beside it: a line on each, as long as the step."""
    floor = hf.Body("floor", hf.HalfSpace(), fixed=True)
    step = hf.Body("step", hf.Box((0.15, 0.2, 0.02)), fixed=True, pose=at(0, 0.1, 0.01))
    y = -float(np.sqrt(0.04**2 - 0.02**2))
    turn = ACROSS @ Rotation.from_euler("z", roll, degrees=True).as_matrix()
    rod = hf.Body("rod", hf.Cylinder(0.04, 0.2), mass=1, pose=at(0, y, 0.04, turn))
    found = {i.bodies: i.patches for i in hf.assemble(hf.Scene([floor, step, rod], 0.5)).interfaces}
    (line,) = found["step", "rod"]
    assert line.polygon[np.argsort(line.polygon[:, 0])] == pytest.approx(
        np.array([(-0.075, 0, 0.02), (0.075, 0, 0.02)]), abs=1e-9
    )
    assert line.normal == pytest.approx((0, y / 0.04, 0.5), abs=1e-9)
    assert [patch.kind for patch in found["floor", "rod"]] == ["line"]


@pytest.mark.parametrize(
    "nearest", [(0.0985, 0, 0), (0.0999, 0, 0), (0.1, 0, 0), (0.1, 0.0985, 0), (0.1, 0.1, 0), (0.0985, 0.0985, 0)]
)
def test_a_ball_touches_what_is_nearest_and_not_the_edges_and_corners_beside_it(
    nearest: tuple[float, float, float],
) -> None:
    """All of them are within the gap; it leans outwards over an edge or a corner, and stands upright over the face."""
    box = hf.Body("box", hf.Box((0.2, 0.2, 0.1)), pose=at(0, 0, -0.05), fixed=True)
    way = np.array([float(nearest[0] == 0.1), float(nearest[1] == 0.1), 1.0])
    way /= np.linalg.norm(way)
    ball = hf.Body("ball", hf.Sphere(0.04), mass=1, pose=at(*np.array(nearest) + 0.04 * way, spun(1)))
    (interface,) = hf.assemble(hf.Scene([box, ball], 0.5), gap=1e-4).interfaces
    (patch,) = interface.patches
    assert patch.polygon[0] == pytest.approx(nearest, abs=1e-9)
    assert patch.normal == pytest.approx(way, abs=1e-9)


def test_a_peg_that_stands_near_an_edge_does_not_overlap_it_by_its_side() -> None:
    """Its axis ends 3 mm from the edge, less than its radius; settled, it stays where it is."""
    shelf = hf.Body("shelf", hf.Box((0.2, 0.2, 0.02)), pose=at(0, 0, -0.01), fixed=True)
    peg = hf.Body("peg", hf.Cylinder(0.005, 0.02), mass=0.1, pose=at(0.097, 0, 0.01))
    (interface,) = hf.assemble(hf.Scene([shelf, peg], 0.5)).interfaces
    assert {patch.kind for patch in interface.patches} == {"face"}
    settled = hf.settle(hf.Scene([shelf, peg], 0.5))
    assert settled.status == "stable"
    assert settled.moved == pytest.approx([0], abs=1e-6)
