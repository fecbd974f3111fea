"""Placements as people would choose them: upright, inside the edges, on flat faces, with room for what holds them."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import holdfast as hf
from holdfast.applications.placement import planner as planning
from holdfast.applications.placement.faces import faces_of, rolls_on
from holdfast.applications.placement.faults import OVERLAPS
from holdfast.applications.placement.margins import clearance, contacts_of, edge_margin, rests_on
from holdfast.applications.placement.plan import planner
from holdfast.applications.placement.reach import Reach
from holdfast.base.rigid import pose_from
from holdfast.scene.shipped.blocks import about_y, at, box, floor

UP = np.array([0, 0, 1.0])


@cache
def shelf() -> hf.Assembly:
    """A shelf 0.6 m wide with a book and a vase that is easily toppled."""
    board = hf.Body("shelf", hf.Box((0.6, 0.3, 0.02)), pose=at(0, 0, -0.01), fixed=True)
    book = box("book", (0.15, 0.21, 0.03), 0.7, (-0.1, 0, 0.015))
    vase = hf.Body("vase", hf.Cylinder(0.03, 0.2), mass=0.4, pose=at(0.1, 0, 0.1))
    return hf.assemble(hf.Scene([board, book, vase], 0.5, name="shelf"))


def cup(radius: float = 0.035, height: float = 0.09) -> hf.Body:
    return hf.Body("cup", hf.Cylinder(radius, height), mass=0.25)


@cache
def placed(seed: int) -> hf.Placement:
    return hf.plan_placement(shelf(), cup(), engine="graph", supports=["shelf"], seed=seed, budget=None)


@pytest.mark.parametrize("seed", range(3))
def test_a_cup_stands_upright_well_inside_the_edges(seed: int) -> None:
    p = placed(seed)
    assert p.pose[2, 2] == pytest.approx(1, abs=1e-9)
    reach = np.abs(p.body.surface_world.vertices[:, :2]).max(0)
    assert (np.array([0.3, 0.15]) - reach >= 0.01).all()
    assert p.rating.edge == pytest.approx((np.array([0.3, 0.15]) - reach).min(), abs=1e-4)
    assert not p.rating.rolls


def test_the_score_is_not_that_of_a_weak_stranger() -> None:
    p = placed(0)
    assert p.weakest.body == "vase"
    assert p.robustness == p.weakest.force < p.rating.own
    assert p.rating.beneath == np.inf, "the shelf is fixed"
    assert p.beneath == ("shelf",)
    facts = dict(p.summary().facts)
    assert "vase" in facts["least push afterwards"]
    assert float(facts["least push on cup"].split()[0]) == pytest.approx(p.rating.own, rel=1e-3)


@pytest.mark.parametrize(
    ("shape", "flat", "round_"),
    [
        (hf.Cylinder(0.035, 0.09), 2, 64),
        (hf.Cylinder(0.008, 0.2), 2, 64),
        (hf.Cylinder(0.1, 0.01), 2, 64),
        (hf.Cylinder(0.03, 0.05, 6), 8, 0),
        (hf.Box((0.3, 0.02, 0.05)), 6, 0),
        (hf.Sphere(0.04, 2), 0, 320),
    ],
    ids=["cup", "pencil", "plate", "nut", "board", "ball"],
)
def test_facets_of_round_sides_are_told_from_flat_faces(shape, flat: int, round_: int) -> None:
    faces = [face for face in faces_of(hf.Body("b", shape, mass=1)) if face.tilt > 0]
    assert sum(face.rolls for face in faces) == round_
    assert sum(not face.rolls for face in faces) == flat


@pytest.mark.parametrize("radii", [(0.06, 0.05, 0.03), (0.02, 0.06, 0.06), (0.05, 0.02, 0.03)])
def test_an_ellipsoid_lies_on_its_flat_side(radii: tuple[float, float, float]) -> None:
    """No place was found for the first, and a lens was put on its rim: the true surface does not rest on facets."""
    body = hf.Body("pebble", hf.Ellipsoid(radii), mass=0.2)
    board = hf.Body("board", hf.Box((0.6, 0.4, 0.02)), pose=at(0, 0, -0.01), fixed=True)
    p = hf.plan_placement(hf.Scene([board], 0.5), body, engine="graph", seed=1, budget=None)
    assert p.pose is not None
    assert p.pose[2, 3] == pytest.approx(min(radii), abs=1e-6)
    assert abs(p.pose[2, int(np.argmin(radii))]) == pytest.approx(1, abs=1e-9)
    assert not p.rating.rolls


def test_up_to_which_slope_an_ellipsoid_rests_on_its_flat_side() -> None:
    """The line from its middle to where a plane touches it is vertical there: sought here around the ellipse."""
    b, c = 0.05, 0.03
    angle = np.linspace(0, np.pi / 2, 100_001)
    normal = np.stack([np.sin(angle), np.cos(angle)], 1)
    touching = normal * [b**2, c**2]
    touching /= np.linalg.norm(touching, axis=1)[:, None]
    steepest = np.arccos(np.einsum("ij,ij->i", normal, touching).min())
    faces = faces_of(hf.Body("pebble", hf.Ellipsoid((0.06, b, c)), mass=0.2))
    assert [face.tilt for face in faces] == pytest.approx([steepest, steepest], rel=1e-6)
    assert {tuple(face.foot) for face in faces} == {(0, 0, c), (0, 0, -c)}


@pytest.mark.parametrize("radii", [(0.04, 0.04, 0.04), (0.06, 0.03, 0.03), (0.06, 0.0305, 0.03)])
def test_an_ellipsoid_that_would_roll_has_no_flat_side(radii: tuple[float, float, float]) -> None:
    assert not any(face.tilt > 0 and not face.rolls for face in faces_of(hf.Body("egg", hf.Ellipsoid(radii), mass=0.2)))


def test_a_cylinder_rolls_on_a_floor_but_not_in_a_trough() -> None:
    faces = faces_of(cup())
    lying = pose_from(np.zeros(3), about_y(np.pi / 2))
    assert rolls_on(faces, lying, np.array([UP]))
    assert not rolls_on(faces, np.eye(4), np.array([UP]))
    assert not rolls_on(faces, lying, np.array([[0, 0.5, np.sqrt(0.75)], [0, -0.5, np.sqrt(0.75)]]))


def test_what_fits_lying_down_only_is_told_to_roll() -> None:
    """Under a board 8 cm above the floor a cup of 9 cm does not stand."""
    board = hf.Body("board", hf.Box((0.3, 0.3, 0.02)), pose=at(0, 0, 0.09), fixed=True)
    assembly = hf.assemble(
        hf.Scene([floor(0.3, 0.3), board, box("far", (0.02, 0.02, 0.02), 1, (0.13, 0.13, 0.01))], 0.5)
    )
    p = hf.plan_placement(assembly, cup(), engine="graph", supports=["floor"], seed=1, attempts=60, budget=None)
    assert p.rating.rolls
    assert "from which a round one would roll" in p.reason


def test_orientations_in_words() -> None:
    slab = hf.Body("slab", hf.Box((0.02, 0.08, 0.12)), mass=0.2)
    upright = hf.plan_placement(shelf(), slab, engine="graph", supports=["shelf"], orientations="upright", budget=None)
    assert upright.pose[2, 2] == pytest.approx(1, abs=1e-9)
    any_way = hf.plan_placement(shelf(), slab, engine="graph", supports=["shelf"], orientations="any", budget=None)
    assert any_way.pose[2, 2] == pytest.approx(0, abs=1e-9), "flat on its largest face it withstands more"
    assert any_way.rating.least > upright.rating.least


def test_the_room_about_an_object_against_its_closed_form() -> None:
    """A box 30 mm from one edge of a slab; a post beside it, 25 mm away."""
    slab, post = box("slab", (0.4, 0.3, 0.02), 2, (0, 0, 0.01)), box("post", (0.02, 0.02, 0.2), 0.3, (0.1, 0, 0.12))
    thing = box("thing", (0.06, 0.05, 0.08), 0.2, (0.035, 0.095, 0.06))
    assembly = hf.assemble(hf.Scene([floor(), slab, post, thing], 0.5))
    contacts = contacts_of("thing", assembly.interfaces)
    assert edge_margin(thing, assembly.bodies, contacts, UP) == pytest.approx(0.15 - 0.12, abs=1e-6)
    gap = np.hypot(0.09 - 0.065, 0.07 - 0.01)
    assert clearance(thing, [post], 0.2) == pytest.approx(gap, abs=1e-9)
    assert clearance(thing, [post], 0.02) == 0.02
    assert rests_on(assembly, "thing") == ("floor", "slab")
    over = hf.assemble(hf.Scene([floor(), slab, thing.moved(at(0.035, 0.14, 0.06))], 0.5))
    assert edge_margin(over.scene.body("thing"), over.bodies, contacts_of("thing", over.interfaces), UP) == 0


def test_tops_side_by_side_have_no_edge_between_them() -> None:
    left, right = (box(name, (0.1, 0.1, 0.1), 1, (x, 0, 0.05)) for name, x in (("left", -0.0502), ("right", 0.0502)))
    thing = box("thing", (0.06, 0.04, 0.04), 0.2, (0, 0, 0.12))
    assembly = hf.assemble(hf.Scene([floor(), left, right, thing], 0.5))
    margin = edge_margin(thing, assembly.bodies, contacts_of("thing", assembly.interfaces), UP)
    assert margin == pytest.approx(0.03, abs=1e-6)


def test_regions_to_keep_out_of() -> None:
    keep_out = [((-0.3, -0.15), (0.2, 0.15)), ((0.2, -0.15, -1), (0.3, 0.0, 1))]
    for seed in range(2):
        p = hf.plan_placement(
            *(shelf(), cup()), engine="graph", supports=["shelf"], keep_out=keep_out, seed=seed, budget=None
        )
        low = p.body.surface_world.vertices.min(0)
        assert low[0] >= 0.2 - 1e-6
        assert low[1] >= -1e-6


def test_next_to_a_body() -> None:
    for seed in range(2):
        p = hf.plan_placement(
            *(shelf(), cup()), engine="graph", supports=["shelf"], next_to="vase", seed=seed, budget=None
        )
        gap = np.linalg.norm(p.pose[:2, 3] - [0.1, 0]) - 0.035 - 0.03
        assert 0 < gap <= 0.5 * p.body.size + 1e-3


def pit(depth: float) -> tuple[hf.Body, ...]:
    """Walls about a square of 0.2 m, ``depth`` high."""
    walls = [(0.15, 0, 0.1, 0.4), (-0.15, 0, 0.1, 0.4), (0, 0.15, 0.2, 0.1), (0, -0.15, 0.2, 0.1)]
    return tuple(
        hf.Body(f"wall{k}", hf.Box((wide, deep, depth)), pose=at(x, y, depth / 2), fixed=True)
        for k, (x, y, wide, deep) in enumerate(walls)
    )


@pytest.mark.parametrize(("half", "fits"), [(0.095, True), (0.105, False)])
def test_a_gripper_needs_room_on_its_way_down(half: float, fits: bool) -> None:
    """In a pit 0.2 m wide and 0.3 m deep, a gripper of ``half`` its width reaches down beside the object."""
    thing = box("thing", (0.04, 0.04, 0.05), 0.1, (0, 0, 0.025))
    tolerances = hf.assemble(hf.Scene([*pit(0.3), floor(), thing], 0.5)).tolerances
    gripper = np.array([[-half, -0.01, -0.02], [half, 0.01, 0.1]])
    reach = Reach((*pit(0.3), floor()), tolerances, UP, None, 0.0, gripper)
    assert reach.gripper_fits(thing) is fits


def test_the_box_of_a_gripper_must_not_reach_into_the_ground() -> None:
    thing = box("thing", (0.04, 0.04, 0.05), 0.1, (0, 0, 0.025))
    tolerances = hf.assemble(hf.Scene([floor(), thing], 0.5)).tolerances
    for down, fits in ((0.045, True), (0.06, False)):
        gripper = np.array([[-0.05, -0.01, -down], [0.05, 0.01, 0.1]])
        assert Reach((floor(),), tolerances, UP, None, 0.0, gripper).gripper_fits(thing) is fits


def test_an_approach_cone_leads_past_what_is_above() -> None:
    """A bar above the object blocks the way straight down; 30° aside there is a way."""
    thing = box("thing", (0.04, 0.04, 0.05), 0.1, (0, 0, 0.025))
    bar = hf.Body("bar", hf.Box((0.02, 0.4, 0.02)), pose=at(0, 0, 0.3), fixed=True)
    tolerances = hf.assemble(hf.Scene([floor(), bar, thing], 0.5)).tolerances
    for cone, fits in ((0.0, False), (5.0, False), (30.0, True)):
        reach = Reach((floor(), bar), tolerances, UP, -UP, np.radians(cone), None)
        assert reach.object_fits(thing) is fits
        gripper = np.array([[-0.01, -0.01, 0.0], [0.01, 0.01, 0.1]])
        assert Reach((floor(), bar), tolerances, UP, -UP, np.radians(cone), gripper).gripper_fits(thing) is fits


def test_a_budget_that_ends_after_the_search_leaves_out_maps_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """A clock that has run out once poses are compared: the pose stands, and nothing is known of pushes."""
    clock = planning.Clock

    class Late(clock):
        def by(self, stage: str, share: float = 1.0) -> float:
            return 0.0 if stage in ("compare", "refine", "end") else np.inf

    monkeypatch.setattr(planning, "Clock", Late)
    p = hf.plan_placement(shelf(), cup(), engine="graph", supports=["shelf"], seed=1, budget=5)
    assert p.status is hf.Status.STABLE
    assert hf.stability(p.assembly).status is hf.Status.STABLE
    assert p.rating.own is None
    assert p.weakest.status is hf.Status.UNDECIDED
    assert "the time was spent before it was asked how hard anything can be pushed" in p.reason
    assert p.robustness == 0


def test_without_time_for_the_map_of_the_scene_all_points_count(monkeypatch: pytest.MonkeyPatch, tmp_path) -> None:
    def late(*_: object, **__: object) -> object:
        raise planning.OutOfTimeError

    monkeypatch.setattr(planning, "scene_map", late)
    p = hf.plan_placement(shelf(), cup(), engine="graph", supports=["shelf", "book"], seed=1, budget=60)
    assert p.status is hf.Status.STABLE
    assert np.isnan(p.support.force).all()
    assert set(p.support.body) == {"shelf", "book"}
    p.save_png(tmp_path / "p.png")


@pytest.mark.parametrize(("inside", "fault"), [(-1e-4, ""), (1e-6, ""), (1e-3, OVERLAPS), (5e-3, OVERLAPS)])
def test_sides_drawn_with_few_facets_excuse_no_overlap_of_what_is_placed(inside: float, fault: str) -> None:
    """A nut of six sides beside a box: seen there, it might be a round one, whose facets lie up to 6 mm too deep."""
    nut = hf.Body("nut", hf.Cylinder(0.045, 0.06, 6), mass=0.3, pose=at(0, 0, 0.03))
    assembly = hf.assemble(hf.Scene([floor(1, 1), nut], 0.5))
    brick = hf.Body("brick", hf.Box((0.1, 0.1, 0.06)), mass=0.3)
    far = float(nut.surface_world.vertices[:, 1].max())  # of a flat side, across the corners on the x axis
    assert far == pytest.approx(0.045 * np.cos(np.pi / 6))
    pose = at(0, far + 0.05 - inside, 0.03)
    assert planner(assembly, brick, engine="graph").checks.fits(pose)[0] == fault
