"""Faces that are not flat nor equally stiff: closed forms, invariances, an independent code on the same surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from engine_scenes import X, block, by_paths, cube, floor, shipped

import holdfast as hf
from bench.baselines import penalty
from bench.scenes.random_pushes import columns, random_pushes
from holdfast import Body, Compliant, Imperfect, Scene, Status, assemble
from holdfast.answers import Assembly
from holdfast.assembly.contact_nodes import contact_nodes
from holdfast.elastic.system import RestOutcome, System
from holdfast.engines.compliant.elastic_model import Places, elastic_model, own_rows
from holdfast.engines.compliant.engine import Rough
from holdfast.engines.groups import prepared
from holdfast.engines.imperfect import RandomFaces
from holdfast.queries.lower_bounds import covering
from holdfast.queries.request import push_columns

POINTS = np.array([[-0.05, 0, 0.05], [-0.05, 0.045, 0.02], [-0.05, 0.03, 0.08]])
WAYS = np.array([[1, 0, 0], [1, 0, 0], [1, 0.2, -0.5]])
UNIT = WAYS / np.linalg.norm(WAYS, axis=1)[:, None]
COMPRESSION = 1e-6  # [m] of the cube under its weight on the bed that the tests take
BED = 9.81 / 0.01 / COMPRESSION


def peaks(assembly: Assembly, imperfect: Imperfect, sample: int, nodes: int = 7) -> np.ndarray:
    engine = Rough(Compliant(nodes=nodes), RandomFaces(imperfect, sample))
    return hf.robustness(assembly, "cube", POINTS, WAYS, engine=engine).force


def factor(assembly: Assembly, load: np.ndarray, apart: np.ndarray) -> float:
    """The largest factor of one load (6,) on a cube whose nodes are ``apart`` [m]."""
    nodes = contact_nodes(assembly, len(apart), "quadrature")
    system = System.of(
        elastic_model(Places.at(assembly, nodes), assembly.weight_wrench(), stiffness=np.full(1, BED), apart=apart)
    )
    rest = system.come_to_rest()
    assert rest.outcome is RestOutcome.RESTS
    return float(system.paths(rest.q, own_rows(assembly, load[None] / assembly.weight)).peak[0])


def test_only_the_corners_touch() -> None:
    """A hollow face turns when μ times the weight at its corners gives way: μ m g √2 · 0.05 m; a flat one earlier."""
    assembly = cube()
    nodes = contact_nodes(assembly, 49, "quadrature")
    corner = (np.abs(np.abs(nodes.points[:, :2]) - 0.05) < 1e-9).all(1)
    assert corner.sum() == 4
    twist = np.array([0.0, 0, 0, 0, 0, 1])
    hollow = factor(assembly, twist, np.where(corner, 0.0, 1000 * COMPRESSION))
    assert hollow == pytest.approx(0.6 * 9.81 * 0.05 * np.sqrt(2), rel=1e-4)
    assert factor(assembly, twist, np.zeros(49)) < 0.6 * hollow


@pytest.mark.parametrize(
    ("material", "bed"),
    [("steel", 2.1e12), ("glass", 7.2e11), ("wood", 1.2e11), ("plastic", 3e10), ("cardboard", 3e7), ("rubber", 1e8)],
)
def test_the_bed_of_a_material_is_its_modulus_over_a_tenth_of_a_metre(material: str, bed: float) -> None:
    """A soft bed hides high spots, so that a mistake here is an optimistic answer."""
    assert Imperfect(1e-5, material=material).bed_stiffness == pytest.approx(bed, rel=1e-12)
    by_word, by_number = (
        hf.robustness_under(cube(), "cube", POINTS, WAYS, uncertain=hf.sets.Uncertain(samples=1, flatness=2e-6, **one))
        for one in ({"material": material}, {"bed": bed})
    )
    np.testing.assert_allclose(by_word.force, by_number.force, rtol=1e-9)


def test_only_a_strip_touches() -> None:
    """A face that bulges along its middle line tips over that line's end nodes' strip: no room against tipping."""
    assembly = cube()
    nodes = contact_nodes(assembly, 49, "quadrature")
    strip = np.abs(nodes.points[:, 0]) < 0.02  # three columns of nodes
    reach = np.abs(nodes.points[strip, 0]).max()
    tip = np.array([0.0, 0, 0, 0, 1, 0])
    assert factor(assembly, tip, np.where(strip, 0.0, 1e5 * COMPRESSION)) == pytest.approx(9.81 * reach, rel=1e-3)


@pytest.mark.parametrize("side", [7, 15, 29])
def test_the_least_twist_over_all_surfaces_is_none(side: int) -> None:
    """A cube on four spots h beside its middle turns at μ m g h, however small h is; so does one that is sheared.

    So no floor in closed form lies above 0: of pressures with a given resultant, that of a single spot has no moment.
    A force d beside the middle turns the cube at μ m g h / d at the latest.
    """
    assembly = cube()
    nodes = contact_nodes(assembly, side**2, "quadrature")
    h, d = 0.1 / (side - 1), 0.03
    spots = np.abs(np.abs(nodes.points[:, :2]).sum(1) - h) < 1e-9
    assert spots.sum() == 4
    apart = np.where(spots, 0.0, 1e5 * COMPRESSION)
    twist = factor(assembly, np.array([0.0, 0, 0, 0, 0, 1]), apart)
    assert twist == pytest.approx(0.6 * 9.81 * h, rel=1e-3)
    beside = factor(assembly, np.array([1.0, 0, 0, 0, -0.05, -d]), apart)  # in the plane of the floor
    assert 0 < beside <= 0.6 * 9.81 * h / d * (1 + 1e-3)


@pytest.mark.parametrize(
    ("far", "outcome"), [(3e3, RestOutcome.RESTS), (1e5, RestOutcome.RESTS), (1e9, RestOutcome.DRIFTS)]
)
def test_what_slides_rests_at_the_wall_that_it_comes_to(far: float, outcome: RestOutcome) -> None:
    """A cube that slides under half of its weight, to a wall ``far`` compressions away, which stops it."""
    wall = block("wall", (0.1, 0.2, 0.2), (0.1, 0, 0.1), fixed=True)
    scene = Scene([floor(), wall, block("cube", (0.1, 0.1, 0.1), (0, 0, 0.05))], 0.3, gravity=(4.905, 0, -9.81))
    assembly = assemble(scene)
    nodes = contact_nodes(assembly, 49, "quadrature")
    level = np.abs(nodes.normals[:, 2]) < 0.5
    assert 0 < level.sum() < len(nodes)
    apart = np.where(level, far * COMPRESSION, 0.0)
    places = Places.at(assembly, nodes)
    model = elastic_model(places, assembly.weight_wrench(), stiffness=np.full(2, BED), apart=apart)
    assert System.of(model).come_to_rest().outcome is outcome


@pytest.mark.parametrize("sample", [0, 1, 24, 90])
def test_a_push_through_the_middle_slides_on_any_surface(sample: int) -> None:
    """All nodes slip the same way, so μ m g is what any pressure withstands.

    On samples 24 and 90 the cube rocks over two spots on its way, at 0.19 and 0.56 of that, until it meets the next.
    """
    faces = RandomFaces(Imperfect(400 * COMPRESSION, BED, seed=18), sample)
    group = prepared(Rough(Compliant(), faces), cube()).group(0)
    found = group.state.grid.paths(push_columns(group.part.assembly, 0, POINTS[:1], UNIT[:1]))
    assert found.factor[0] == pytest.approx(0.6 * 9.81, rel=1e-3)


def test_a_wedge_between_two_planes_is_a_slight_turn() -> None:
    """Clearances that grow evenly change nothing: the body comes to rest turned, with the answers of flat faces."""
    assembly = cube()
    nodes = contact_nodes(assembly, 49, "quadrature")
    wedge = 300 * COMPRESSION * (nodes.points[:, 0] + 0.4 * nodes.points[:, 1]) / 0.1
    for load in np.random.default_rng(3).normal(size=(4, 6)) * (1, 1, 1, 0.03, 0.03, 0.03):
        assert factor(assembly, load, wedge) == pytest.approx(factor(assembly, load, np.zeros(49)), rel=2e-3)


@pytest.mark.parametrize("ratio", [1.0, 100.0])
def test_an_independent_code_on_the_same_surfaces(ratio: float) -> None:
    """Discrete elements, integrated in time, share the surfaces' heights alone."""
    assembly = cube()
    imperfect = Imperfect(4 * ratio * COMPRESSION, BED)
    for sample in range(2):
        group = prepared(Rough(Compliant(), RandomFaces(imperfect, sample)), assembly).group(0)
        grid, part = group.state.grid, group.part
        found = grid.paths(push_columns(part.assembly, 0, POINTS[1:], UNIT[1:])).peak
        for point, way, force in zip(POINTS[1:], UNIT[1:], found, strict=True):
            seen = penalty.peak(part.assembly, "cube", point, way, grid.nodes, apart=grid.system.model.apart)
            assert (seen.held + seen.moves) / 2 == pytest.approx(force, rel=0.02)


def test_flat_and_equally_stiff_faces_give_the_ideal() -> None:
    """Its force, and a lower bound that is the ideal's on nodes: samples of faces are answered by paths."""
    found = hf.robustness(cube(), "cube", POINTS, WAYS, imperfect=Imperfect(0.0, samples=2))
    np.testing.assert_array_equal(found.force, hf.robustness(cube(), "cube", POINTS, WAYS).force)
    ideal = hf.robustness(cube(), "cube", POINTS, WAYS, engine=by_paths(cube()))
    np.testing.assert_allclose(found.lower, ideal.lower, rtol=1e-9)
    slight = peaks(cube(), Imperfect(1e-3 * COMPRESSION, BED), 0)
    np.testing.assert_allclose(slight, ideal.force, rtol=1e-3)


def test_flatness_counts_by_its_product_with_the_bed_over_the_weight() -> None:
    given = Imperfect(1e-5, BED)
    known = peaks(cube(), given, 1)
    np.testing.assert_allclose(peaks(cube(), Imperfect(5e-6, 2 * BED), 1), known, rtol=1e-6)
    np.testing.assert_allclose(peaks(cube(mass=3.0), Imperfect(1e-5, 3 * BED), 1), 3 * known, rtol=1e-6)
    assert np.abs(peaks(cube(), Imperfect(5e-6, BED), 1) / known - 1).max() > 0.01


def test_the_correlation_is_a_length_of_the_face() -> None:
    """Twice as large a cube, eight times as heavy, on a bed that it presses as far by as much of the flatness."""
    small = peaks(cube(), Imperfect(1e-5, BED), 2)
    body = block("cube", (0.2, 0.2, 0.2), (0, 0, 0.1), 8.0)
    large = assemble(Scene([floor(), body], 0.6))
    engine = Rough(Compliant(), RandomFaces(Imperfect(2e-5, BED), 2))
    found = hf.robustness(large, "cube", 2 * POINTS, WAYS, engine=engine).force
    np.testing.assert_allclose(found, 8 * small, rtol=1e-6)
    third = peaks(cube(), Imperfect(1e-5, BED, correlation=0.1 / 3), 2)
    np.testing.assert_allclose(third, small, rtol=1e-9)


def test_neither_axes_nor_names_nor_strangers_change_anything() -> None:
    """Of a table without symmetries, whose legs cannot be taken for each other."""
    legs = [
        block("left", (0.05, 0.2, 0.2), (-0.2, 0, 0.1), 1.0),
        block("right", (0.06, 0.18, 0.2), (0.19, 0.013, 0.1), 1.3),
    ]
    scene = Scene([floor(), *legs, block("slab", (0.5, 0.2, 0.05), (0, 0, 0.225), 2.0)], 0.5)
    imperfect = Imperfect(5e-5, 1e9, stiffness_range=(0.3, 3.0), samples=3)
    push = (-0.25, 0, 0.225)
    known = hf.robustness(scene, "slab", push, X, imperfect=imperfect)
    stranger = block("stranger", (0.1, 0.1, 0.1), (0.8, 0.0, 0.05))
    again = hf.robustness(Scene([*scene.bodies, stranger], scene.friction), "slab", push, X, imperfect=imperfect)
    assert (again.lower == known.lower).all()
    turn = np.eye(4)
    turn[:3, :3] = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0], [0.48, 0.64, 0.6]]
    bodies = [
        Body(f"the {b.name}", b.shape, mass=b.mass, com=b.com, pose=turn @ b.pose, fixed=b.fixed)
        for b in reversed(scene.bodies)
    ]
    turned = Scene(bodies, scene.friction.default, turn[:3, :3] @ scene.gravity)
    found = hf.robustness(turned, "the slab", turn[:3, :3] @ push, turn[:3, :3] @ X, imperfect=imperfect)
    np.testing.assert_allclose(found.lower, known.lower, rtol=5e-5)


def test_finer_grids_see_the_same_surfaces() -> None:
    imperfect = Imperfect(5e-6, BED)
    coarse, fine = (peaks(cube(), imperfect, 0, nodes) for nodes in (11, 21))
    np.testing.assert_allclose(coarse, fine, rtol=0.05)
    assembly = cube()
    heights = [
        dict(
            zip(
                map(tuple, np.round(nodes.points, 9)),
                RandomFaces(imperfect, 0).clearances(assembly, count),
                strict=True,
            )
        )
        for count in (49, 169)
        for nodes in [contact_nodes(assembly, count, "quadrature")]
    ]
    shared = heights[0].keys() & heights[1].keys()
    assert len(shared) >= 9
    assert all(heights[0][place] == pytest.approx(heights[1][place], abs=1e-15) for place in shared)
    assert np.ptp(list(heights[1].values())) == pytest.approx(5e-6, rel=0.1)


def test_lower_is_the_least_of_the_samples_or_the_quantile() -> None:
    given = {"flatness": 5e-5, "bed": BED, "samples": 5}
    each = np.array(
        [
            hf.robustness(
                cube(), "cube", POINTS, WAYS, engine=Rough(Compliant(), RandomFaces(Imperfect(**given), k))
            ).lower
            for k in range(5)
        ]
    )
    ideal = hf.robustness(cube(), "cube", POINTS, WAYS)
    for quantile, rank in ((0.0, 0), (0.2, 1), (0.55, 2)):
        found = hf.robustness(cube(), "cube", POINTS, WAYS, imperfect=Imperfect(**given, quantile=quantile))
        np.testing.assert_allclose(found.lower, np.minimum(np.sort(each, 0)[rank], ideal.lower), rtol=1e-12)
    assert any("5 samples of faces with 0.05 mm" in note for note in found.notes)
    fewer = hf.robustness(cube(), "cube", POINTS, WAYS, imperfect=Imperfect(**given | {"samples": 3}))
    np.testing.assert_allclose(fewer.lower, np.minimum(each[:3].min(0), ideal.lower), rtol=1e-12)


def test_all_samples_are_given_where_they_are_asked_for() -> None:
    under = hf.robustness_under(
        cube(),
        "cube",
        POINTS,
        WAYS,
        uncertain=hf.sets.Uncertain(samples=4, flatness=5e-5, bed=BED, stiffness_range=(0.5, 2)),
    )
    covered = hf.robustness(
        cube(), "cube", POINTS, WAYS, imperfect=Imperfect(5e-5, BED, stiffness_range=(0.5, 2), samples=4)
    )
    np.testing.assert_allclose(np.minimum(under.lower.min(0), covered.lower), covered.lower, rtol=1e-12)
    assert (under.force.std(0)[1:] > 0).all()
    with pytest.raises(hf.HoldfastError, match="no flatness"):
        hf.robustness_under(cube(), "cube", POINTS, WAYS, uncertain=hf.sets.Uncertain(samples=2, bed=BED))


def test_stiffness_of_pairs_moves_wedged_bodies_and_not_a_lone_one() -> None:
    imperfect = Imperfect(0.0, stiffness_range=(0.1, 10.0), samples=6)
    lone = hf.robustness(cube(), "cube", POINTS, WAYS, imperfect=imperfect)
    ideal = hf.robustness(cube(), "cube", POINTS, WAYS, engine=by_paths(cube()))
    np.testing.assert_allclose(lone.lower, ideal.lower, rtol=1e-6)
    arch = shipped("arch")
    m = hf.robustness_map(arch, ["v3"], spacing=0.05)
    weakest = m.weakest()
    push = (weakest.point, weakest.direction)
    ideal, found = (hf.robustness(arch, "v3", *push, imperfect=one) for one in (None, imperfect))
    assert found.lower[0] < 0.98 * ideal.lower[0]
    assert found.force[0] == ideal.force[0]


def test_strong_points_are_asked_on_the_worst_samples_for_the_weak_ones() -> None:
    """The rule of a map, from the answers on all samples: the 24 weakest on each, the others on four."""
    assembly, imperfect = cube(), Imperfect(5e-5, BED, samples=6)
    rng = np.random.default_rng(7)
    W = columns(assembly, random_pushes(assembly, rng, 40, slant=30))
    ideal = prepared(Compliant(), assembly).load_factor(W)
    covers = covering(imperfect, Compliant(), assembly)
    assert covers is not None
    found = covers.over_surface(ideal, W)
    each = np.array([prepared(covers.sample(k), assembly).load_factor(W).lower for k in range(6)])
    weak = np.argsort(ideal.force, kind="stable")[:24]
    worst = np.argsort(each[:, weak].sum(1), kind="stable")[:4]
    expected = each[worst].min(0)
    expected[weak] = each[:, weak].min(0)
    np.testing.assert_allclose(found.lower, np.minimum(expected, ideal.lower), rtol=1e-12)
    assert (expected > each.min(0) * (1 + 1e-9)).any(), "some strong point is weaker on a sample that was not asked"
    assert any("16 of 40 points were asked only on the 4 samples worst for the rest" in note for note in found.notes)


def test_loads_and_transport_take_it_too() -> None:
    imperfect = Imperfect(5e-5, BED, samples=3)
    load = hf.Load("cube", (0.05, 0, 0.05), force=(1, 0, 0), moment=(0, 0, 0.02))
    ideal, found = (hf.load_factor(cube(), [load], imperfect=one) for one in (None, imperfect))
    assert (found.factor, found.lower < ideal.lower) == (ideal.factor, True)
    ways = [(1, 0, 0), (0.6, 0.8, 0)]
    steady, carried = (hf.transport_limits(shipped("slope_two"), ways, imperfect=one) for one in (None, imperfect))
    assert (carried.lower <= steady.lower).all()
    assert carried.lower[1] < 0.95 * steady.lower[1]
    assert (carried.answers.status == Status.FINITE).all()
    assert any("3 samples of faces" in note for note in carried.notes)
    assert not any("asked only" in note for note in carried.notes), "every direction is asked on every sample"
    straight = [hf.transport_limits(shipped("stack"), ways, imperfect=one).lower for one in (None, imperfect)]
    np.testing.assert_allclose(*straight, rtol=3e-3, err_msg="it tips or slides without a turn: on any surface alike")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"flatness": -1e-5, "bed": 1e9}, "flatness"),
        ({"flatness": 1e-5}, "how stiff the faces are"),
        ({"flatness": 1e-5, "bed": 1e9, "material": "wood"}, "give one"),
        ({"flatness": 1e-5, "material": "cheese"}, "steel"),
        ({"flatness": 1e-5, "bed": 1e9, "stiffness_range": (3, 0.3)}, "low, high"),
        ({"flatness": 1e-5, "bed": 1e9, "stiffness_range": 2.0}, "range"),
        ({"flatness": 1e-5, "bed": 1e9, "quantile": 1.0}, "quantile: is .* and < 1"),
        ({"flatness": 1e-5, "bed": 1e9, "samples": 0}, "samples"),
    ],
)
def test_what_makes_no_sense_is_told(given: dict, words: str) -> None:
    with pytest.raises(hf.HoldfastError, match=words):
        Imperfect(**given)


@pytest.mark.parametrize("engine", ["limit", "graph"])
def test_engines_without_elastic_contacts_are_refused(engine: str) -> None:
    with pytest.raises(hf.HoldfastError, match="compliant"):
        hf.robustness(cube(), "cube", POINTS, WAYS, engine=engine, imperfect=Imperfect(1e-5, 1e9))
