"""Ellipsoids against round bodies: closed forms, all directions tried, invariances, and what rolls."""

from __future__ import annotations

import numpy as np
import pytest
from placed import at
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.base.arrays import Float
from holdfast.contacts.round_bodies import PlacedEllipsoid, PlacedRod, RoundLimits, meet, meeting, nearest

LIMITS = RoundLimits(gap=np.inf, depth=np.inf, cos_twist=0.0, cos_side=float(np.cos(np.radians(5))), seen=0.0)


def egg(rng: np.random.Generator, place: Float) -> PlacedEllipsoid:
    return PlacedEllipsoid.of(at(*place, Rotation.random(random_state=rng).as_matrix()), rng.uniform(0.5, 2.0, 3))


def apart(one: PlacedEllipsoid, two: PlacedEllipsoid, normals: Float) -> Float:
    """How far both are apart along normals (n, 3): what separates them most is the distance."""
    reaches = [np.sqrt(np.einsum("ni,ij,nj->n", normals, each.squares, normals)) for each in (one, two)]
    return np.asarray(normals @ (two.centre - one.centre) - reaches[0] - reaches[1])


@pytest.mark.parametrize("distance", [-0.05, 0.0, 1e-6, 0.3, 20.0])
def test_no_direction_separates_two_ellipsoids_more(distance: float) -> None:
    """Of 20,000 directions, and of more near the best one; the points found lie on both surfaces, ``apart`` apart."""
    rng = np.random.default_rng(0)
    everywhere = rng.normal(size=(20_000, 3))
    everywhere /= np.linalg.norm(everywhere, axis=1, keepdims=True)
    for _ in range(20):
        one, way = egg(rng, rng.normal(size=3)), everywhere[rng.integers(len(everywhere))]
        two = egg(rng, one.centre)
        touch = -apart(one, two, everywhere[[0]])  # any start: moved until they are as far apart as asked for
        for _ in range(60):
            found = nearest(one, two._replace(centre=one.centre + touch[0] * way))
            touch = touch + (distance - found.apart) / max(float(found.normal @ way), 0.05)
        two = two._replace(centre=one.centre + touch[0] * way)
        found = nearest(one, two)
        assert found.apart == pytest.approx(distance, abs=1e-9)
        near = found.normal + 0.05 * rng.normal(size=(2_000, 3))
        near /= np.linalg.norm(near, axis=1, keepdims=True)
        tried = near if distance < 0 else np.vstack([near, everywhere])
        assert apart(one, two, tried).max() <= found.apart + 1e-12
        np.testing.assert_allclose(found.of_two - found.of_one, found.apart * found.normal, atol=1e-9)
        for each, place in ((one, found.of_one), (two, found.of_two)):
            arm = place - each.centre
            assert arm @ np.linalg.solve(each.squares, arm) == pytest.approx(1, rel=1e-9)


def test_ellipsoids_with_equal_axes_are_balls() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        a, b = rng.uniform(0.5, 2.0, 2)
        one, two = rng.normal(size=3), 3 * rng.normal(size=3)
        half = rng.normal(size=3)
        found = meet(PlacedEllipsoid.of(at(*one), np.full(3, a)), PlacedRod(two, half, b, flat=False), LIMITS)
        exact = meeting(PlacedRod(one, np.zeros(3), a, flat=False), PlacedRod(two, half, b, flat=False), LIMITS)
        if found is None or exact is None:
            assert found is exact
            continue
        np.testing.assert_allclose(found.ends, exact.ends, atol=1e-8)
        np.testing.assert_allclose(found.normal, exact.normal, atol=1e-8)
        assert found.heights[0] == pytest.approx(exact.heights[0], abs=1e-12)
        assert found.bend == pytest.approx(exact.bend, rel=1e-6)


def test_the_order_of_both_makes_no_difference() -> None:
    rng = np.random.default_rng(2)
    for _ in range(20):
        one, two = egg(rng, np.zeros(3)), PlacedRod(4 * rng.normal(size=3), rng.normal(size=3), 0.4, flat=False)
        found, other = meet(one, two, LIMITS), meet(two, one, LIMITS)
        assert found is not None
        assert other is not None
        np.testing.assert_allclose(found.ends, other.ends[::-1], atol=1e-9)
        np.testing.assert_allclose(found.normal, -other.normal, atol=1e-9)


def test_no_point_of_an_axis_is_nearer() -> None:
    rng = np.random.default_rng(3)
    for _ in range(10):
        one, two = egg(rng, np.zeros(3)), PlacedRod(5 * rng.normal(size=3), 2 * rng.normal(size=3), 0.3, flat=False)
        found = meet(one, two, LIMITS)
        assert found is not None
        shares = np.linspace(-1, 1, 201)
        each = [nearest(one, PlacedEllipsoid(two.at(share), np.zeros((3, 3)))).apart - two.radius for share in shares]
        assert found.heights[0] <= min(each) + 1e-12
        assert found.heights[0] >= min(each) - 1e-2


def test_lines_are_at_least_so_far_away() -> None:
    rng, close = np.random.default_rng(4), 0
    for _ in range(200):
        one, ends = egg(rng, np.zeros(3)), 2 * rng.normal(size=(1, 2, 3))
        line = PlacedRod(ends[0].mean(0), (ends[0, 1] - ends[0, 0]) / 2, 0.0, flat=False)
        found = meet(one, line, LIMITS)
        assert found is not None
        least = one.least_apart(ends)[0]
        if found.heights[0] > -0.3:  # deeper ones may be nearer to another side
            assert abs(least) <= abs(found.heights[0]) + 1e-9
            assert least * found.heights[0] >= 0
            close += 1
    assert close > 50


def test_the_gap_over_an_edge_bends_as_the_egg_does_along_it() -> None:
    """A bend is what tells how far from a contact its drawing may touch: an edge, which has no radius, adds to it."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        one, way = egg(rng, np.zeros(3)), rng.normal(size=3)
        edge = PlacedRod(3 * rng.normal(size=3), 10 * way, 0.0, flat=False)
        found = meet(one, edge, LIMITS)
        assert found is not None
        along = edge.along  # across the normal, unless the edge ends there
        if abs(along @ found.normal) < 1e-6:
            assert found.bend == pytest.approx(along @ one.curvature(found.normal, 0.0) @ along, rel=1e-3)
        assert found.bend >= one.flattest(found.normal) * (1 - 1e-3)


def test_the_side_of_a_cylinder_ends_at_its_rims() -> None:
    """Beside the middle an egg touches it; beyond an end, where it would meet the rim, that is left to others."""
    tin = PlacedRod(np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.5, flat=True)
    for height, touches in ((0.0, True), (0.9, True), (1.6, False)):
        found = meet(PlacedEllipsoid.of(at(1.0, 0.0, height), np.array([0.5, 0.4, 0.7])), tin, LIMITS)
        assert (found is not None) == touches
        if found is not None:
            assert found.heights[0] == pytest.approx(0.0, abs=1e-12)
            assert found.ends[0, 0] == pytest.approx([0.5, 0.0, height], abs=1e-9)


def on_rails(turn: float, roll: float) -> hf.answers.Assembly:
    """An egg with round cross sections across the rails lies on two cylinders, turned about its axis by ``roll``."""
    lying = Rotation.from_euler("y", 90, degrees=True)
    across, radius, wide, long = 0.05, 0.03, 0.04, 0.09
    height = float(np.sqrt((across + radius) ** 2 - wide**2))
    own = Rotation.from_euler("x", roll, degrees=True) * lying
    bodies = [
        hf.Body("left", hf.Cylinder(radius, 0.4), pose=at(0, -wide, 0, lying.as_matrix()), fixed=True),
        hf.Body("right", hf.Cylinder(radius, 0.4), pose=at(0, wide, 0, lying.as_matrix()), fixed=True),
        hf.Body("egg", hf.Ellipsoid((across, across, long)), mass=1.0, pose=at(0, 0, height, own.as_matrix())),
    ]
    whole = at(0.1, 0.2, 0.3, Rotation.from_euler("z", turn, degrees=True).as_matrix())
    return hf.assemble(
        hf.Scene([hf.Body(b.name, b.shape, mass=b.mass, pose=whole @ b.pose, fixed=b.fixed) for b in bodies], 0.5)
    )


@pytest.mark.parametrize("turn", [0.0, 33.0])
@pytest.mark.parametrize("roll", [0.0, 0.5, 2.0, 11.0, 40.0])
def test_an_egg_on_rails_touches_each_at_one_point_however_it_is_rolled(turn: float, roll: float) -> None:
    found = on_rails(turn, roll)
    whole = at(0.1, 0.2, 0.3, Rotation.from_euler("z", turn, degrees=True).as_matrix())
    assert len(found.interfaces) == 2
    for interface in found.interfaces:
        (patch,) = interface.patches
        assert patch.kind == "point"
        here = np.linalg.inv(whole) @ np.append(patch.polygon[0], 1.0)
        side = -1 if "left" in interface.bodies else 1
        height = np.sqrt(0.08**2 - 0.04**2)
        np.testing.assert_allclose(here[:3], [0, side * 0.04 * 0.05 / 0.08, height * 0.03 / 0.08], atol=1e-9)


@pytest.mark.parametrize("roll", [0.0, 0.5, 11.0])
def test_a_push_across_the_rails_lifts_an_egg_off_one_of_them(roll: float) -> None:
    """Through its axis, where friction turns nothing: at m g tan(angle) of what leads from the other one."""
    assembly = on_rails(0.0, roll)
    side = assembly.movable[0].com_world - (0.0, 0.05, 0.0)
    found = hf.robustness(assembly, "egg", side, (0.0, 1.0, 0.0), engine="limit")
    assert found.force[0] == pytest.approx(9.81 * np.tan(np.arcsin(0.04 / 0.08)), rel=1e-3)


@pytest.mark.parametrize("roll", [0.0, 0.5, 2.0, 40.0, 90.0])
def test_a_cylinder_that_lies_on_an_egg_touches_it_at_its_top(roll: float) -> None:
    """Rolled by 0.5 to 40 degrees it was said to fall; it is balanced, as it is however it is rolled."""
    turn = (Rotation.from_euler("x", roll, degrees=True) * Rotation.from_euler("y", 90, degrees=True)).as_matrix()
    bodies = [
        hf.Body("egg", hf.Ellipsoid((0.06, 0.06, 0.03)), pose=at(0, 0, 0.03), fixed=True),
        hf.Body("cylinder", hf.Cylinder(0.04, 0.2), mass=0.5, pose=at(0, 0, 0.1, turn)),
    ]
    found = hf.assemble(hf.Scene(bodies, 0.6))
    (interface,) = found.interfaces
    (patch,) = interface.patches
    np.testing.assert_allclose(patch.polygon, [[0, 0, 0.06]], atol=1e-9)
    assert hf.stability(found).status is not hf.Status.UNSTABLE


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("seed", range(12))
def test_an_egg_touches_a_box_where_a_search_finds_it_nearest(seed: int, order: int) -> None:
    """At faces, edges and corners; the search is that for the point of the box least far out in the egg's own measure.

    An egg scaled so that this point is on it touches the box there and nowhere else.
    """
    rng = np.random.default_rng(seed)
    size, radii = rng.uniform(0.05, 0.2, 3), rng.uniform(0.03, 0.09, 3)
    turn, centre = Rotation.random(random_state=seed).as_matrix(), rng.normal(size=3)
    centre *= 0.3 / np.linalg.norm(centre)

    def out(x: Float) -> float:
        return float((((x * size / 2 - centre) @ turn / radii) ** 2).sum())

    best = minimize(out, np.zeros(3), bounds=[(-1, 1)] * 3, method="L-BFGS-B", tol=1e-18).x
    place, scale = best * size / 2, np.sqrt(out(best))
    normal = turn @ (((place - centre) @ turn) / radii**2)
    whole = Rotation.random(random_state=seed + 100).as_matrix()
    box = hf.Body("box", hf.Box(size), pose=at(0, 0, 0, whole), fixed=True)
    it = hf.Body("it", hf.Ellipsoid(scale * radii), mass=1, pose=at(*(whole @ centre), whole @ turn))
    (interface,) = hf.assemble(hf.Scene([box, it][::order], 0.5), gap=1e-5).interfaces
    (patch,) = interface.patches
    assert patch.kind == "point"
    assert patch.polygon[0] == pytest.approx(whole @ place, abs=1e-4)
    away = patch.normal if interface.bodies[0] == "it" else -patch.normal
    assert away == pytest.approx(whole @ normal / np.linalg.norm(normal), abs=2e-2)


@pytest.mark.parametrize("roll", [0.0, 0.5, 7.0, 90.0])
def test_an_egg_on_the_edges_of_a_slot_rolls_along_it(roll: float) -> None:
    """Nothing but its drawing's facets would resist that; it lies on one point of each edge."""
    across, gap = 0.05, 0.06
    own = (Rotation.from_euler("y", roll, degrees=True)).as_matrix()
    bodies = [
        hf.Body(f"side {s:+d}", hf.Box((0.5, 0.2, 0.1)), fixed=True, pose=at(0, s * (0.1 + gap / 2), -0.05))
        for s in (1, -1)
    ]
    height = 0.08 * np.sqrt(1 - (gap / 2 / across) ** 2)
    shape = hf.Ellipsoid((0.08, across, 0.08))
    found = hf.assemble(hf.Scene([*bodies, hf.Body("egg", shape, mass=1.0, pose=at(0, 0, height, own))], 0.5))
    assert len(found.interfaces) == 2
    for interface in found.interfaces:
        (patch,) = interface.patches
        assert np.abs(patch.polygon[0]) == pytest.approx([0, gap / 2, 0], abs=1e-9)
    push = hf.robustness(found, "egg", (-0.08, 0, height), (1.0, 0.0, 0.0), engine="limit")
    assert push.force[0] < 1e-6
