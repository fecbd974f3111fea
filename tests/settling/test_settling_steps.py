"""One small motion: closed forms of a block on a slope, of overlaps shared out, and of near points."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import manifold3d
import numpy as np
import pytest

import holdfast as hf
from holdfast.contacts.neighbours import joined
from holdfast.contacts.overlap import find_overlaps
from holdfast.contacts.tolerances import Tolerances
from holdfast.settling.motion import Motion, MotionLimits, come_to_rest
from holdfast.settling.moved_surfaces import Posed, rotation_of, turn_between
from holdfast.settling.near_points import FacePairs, near_points, shared_solids
from holdfast.settling.settling_program import StepContacts, small_motion


def one_contact(gap: float, mu: float, normal: tuple[float, float, float]) -> StepContacts:
    """A single body with one contact right at its centre of mass, over a fixed one: it moves as a particle."""
    return StepContacts(
        np.array([[1, 0]]), 1, np.zeros((1, 3)), np.array([normal]), np.array([gap]), np.array([mu]), np.array([True])
    )


def moved(gap: float, mu: float, slope: float) -> np.ndarray:
    normal = (np.sin(slope), 0.0, np.cos(slope))
    answer, solved = small_motion(
        one_contact(gap, mu, normal), np.zeros((1, 3)), np.ones(1), np.ones((1, 6)),
        np.array([0, 0, -1.0, 0, 0, 0]), unit=1e-3, friction=True,
    )  # fmt: skip
    assert answer is not None
    assert solved == 1
    return answer[0, :3]


@pytest.mark.parametrize(
    ("gap", "slope", "rises"),
    [
        (5e-3, 0.0, -1e-3),  # free, it sinks by the unit
        (4e-4, 0.0, -4e-4),  # over a gap, as far as the gap
        (-2e-4, 0.0, 2e-4),  # an overlap lifts it
        (0.0, 0.99 * np.arctan(0.5), 0.0),  # friction holds it up to its angle
    ],
)
def test_a_body_moves_straight_up_or_down_by_as_much_as_its_contact_allows(
    gap: float, slope: float, rises: float
) -> None:
    assert moved(gap, 0.5, slope) == pytest.approx([0, 0, rises], abs=1e-10)


@pytest.mark.parametrize("mu", [0.0, 0.2, 0.5])
def test_beyond_it_the_body_slides_along_the_edge_of_the_cone(mu: float) -> None:
    """Gravity projected onto the ray along which n.v = mu |t.v|: Anitescu's lift is mu times the slip."""
    slope = np.arctan(mu) + 0.2
    downhill, normal = np.array([np.cos(slope), 0, -np.sin(slope)]), np.array([np.sin(slope), 0, np.cos(slope)])
    along = (downhill + mu * normal) / np.hypot(1, mu)
    assert moved(0.0, mu, slope) == pytest.approx(1e-3 * (np.array([0, 0, -1.0]) @ along) * along, abs=1e-9)


def two_contacts(*gaps: float) -> StepContacts:
    """A single body over two fixed ones, like ``one_contact``; only the first contact is chosen."""
    up, chosen = np.array([[0.0, 0.0, 1.0]] * 2), np.array([True, False])
    return StepContacts(np.array([[1, 0]] * 2), 1, np.zeros((2, 3)), up, np.array(gaps), np.full(2, 0.5), chosen)


@pytest.mark.parametrize(("gaps", "before", "solved"), [
    ((5e-3, 4e-4), None, 3),  # the first contact alone, then both
    ((4e-4, 5e-4), None, 1),  # the second is not violated
    ((5e-3, 4e-4), 0.0, 1),  # both are far away, the second one joins
    ((5e-3, 4e-4), -1e-3, 1),  # going on like that would violate the second one
])  # fmt: skip
def test_contacts_join_when_they_would_be_violated(gaps: tuple[float, ...], before: float | None, solved: int) -> None:
    pull = np.array([0, 0, -1.0, 0, 0, 0])
    last = None if before is None else np.array([[0, 0, before, 0, 0, 0]])
    answer, count = small_motion(
        two_contacts(*gaps), np.zeros((1, 3)), np.ones(1), np.ones((1, 6)), pull, unit=1e-3, friction=True, before=last
    )
    assert answer is not None
    assert count == solved
    assert answer[0, :3] == pytest.approx([0, 0, -4e-4], abs=1e-8 if before is not None else 1e-10)


def test_a_contact_joins_whose_friction_alone_would_be_violated() -> None:
    """The chosen contact is smooth, so that the body would slide; the other one, at the same place, holds it."""
    contacts = replace(two_contacts(0.0, 0.0), mu=np.array([0.0, 0.5]))
    pull = np.array([0.3, 0, -1.0, 0, 0, 0])
    answer, solved = small_motion(
        contacts, np.zeros((1, 3)), np.ones(1), np.ones((1, 6)), pull, unit=1e-3, friction=True
    )
    assert answer is not None
    assert solved == 3
    assert answer[0, :3] == pytest.approx([0, 0, 0], abs=1e-9)


def test_friction_does_not_hold_a_body_in_overlaps_that_it_can_only_leave_along_them() -> None:
    """Between walls that close at 10 degrees each, both 0.1 mm into the body: it rises by 0.1 mm / sin 10.

    The cones of friction admit no motion at all here, because the walls are steeper than the angle of friction.
    """
    lean = np.radians(10)
    normals = np.array([[side * np.cos(lean), 0, np.sin(lean)] for side in (-1, 1)])
    contacts = StepContacts(
        np.array([[1, 0]] * 2), 1, np.zeros((2, 3)), normals, np.full(2, -1e-4), np.full(2, 0.5), np.full(2, True)
    )
    pull = np.array([0, 0, -1.0, 0, 0, 0])
    answer, solved = small_motion(
        contacts, np.zeros((1, 3)), np.ones(1), np.ones((1, 6)), pull, unit=1e-3, friction=True
    )
    assert answer is not None
    assert solved == 2
    assert answer[0, :3] == pytest.approx([0, 0, 1e-4 / np.sin(lean)], abs=1e-9)


def boxes(apart: float, **more: float) -> hf.Scene:
    """Two equal boxes side by side on a floor, their near faces ``apart``."""
    floor = hf.Body("floor", hf.Box((2, 2, 0.1)), pose=at(0, 0, -0.05), fixed=True)
    a = hf.Body("a", hf.Box((0.1, 0.1, 0.1)), mass=1.0, pose=at(-0.05 - apart / 2, 0, 0.05))
    b = hf.Body("b", hf.Box((0.1, 0.1, 0.1)), mass=more.get("mass", 1.0), pose=at(0.05 + apart / 2, 0, 0.05))
    return hf.Scene([floor, a, b], 0.5)


def resting(scene: hf.Scene, *names: str, known: frozenset[str] = frozenset(), **sigma: float) -> Motion:
    overlaps = find_overlaps(scene, Tolerances(6.7e-5, 1.0))
    return come_to_rest(scene, names, MotionLimits(0.01, 15), known=known, sigma=sigma, overlaps=overlaps)


def at(x: float, y: float, z: float, turn: tuple[float, float, float] = (0, 0, 0)) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = rotation_of(np.array(turn, dtype=float))
    pose[:3, 3] = x, y, z
    return pose


@pytest.mark.parametrize(
    ("mass", "sigma", "share"), [(1.0, {}, 0.5), (3.0, {}, 0.75), (1.0, {"a": 1e-3, "b": 2e-3}, 0.2)]
)
def test_overlaps_are_shared_out_by_mass_and_confidence(mass: float, sigma: dict[str, float], share: float) -> None:
    """The share of a is (sigma_a² / m_a) over the sum of both."""
    motion = resting(boxes(-2e-3, mass=mass), "a", "b", **sigma)
    assert -motion.pushed[0, 0] == pytest.approx(share * 2e-3, abs=2e-6)
    assert motion.pushed[1, 0] == pytest.approx((1 - share) * 2e-3, abs=2e-6)


def test_a_known_body_stays_where_others_give_way() -> None:
    motion = resting(boxes(-2e-3), "a", "b", known=frozenset({"a"}))
    assert motion.pushed[:, 0] == pytest.approx([0, 2e-3], abs=2e-6)


def test_near_points_of_boxes_are_the_corners_of_their_overlap() -> None:
    scene = boxes(0.0)
    floor, a = Posed(scene.body("floor")), Posed(scene.body("a").moved(at(0, 0, 0.053, (0, 0, 0.3))))
    near = near_points(floor, a, FacePairs(), margin=0.01)
    assert near.gaps == pytest.approx(np.full(len(near.gaps), 3e-3), abs=1e-12)
    assert near.normals == pytest.approx(np.tile([0, 0, 1.0], (len(near.gaps), 1)))
    corners = a.body.placed(np.array([[x, y, -0.05] for x in (-0.05, 0.05) for y in (-0.05, 0.05)]))[:, :2]
    chosen = near.points[near.chosen][:, :2]
    assert np.linalg.norm(chosen[:, None] - corners, axis=2).min(0).max() < 1e-9


def test_a_ball_has_its_exact_foot() -> None:
    floor = Posed(hf.Body("floor", hf.Box((2, 2, 0.1)), pose=at(0, 0, -0.05), fixed=True))
    ball = Posed(hf.Body("ball", hf.Sphere(0.04), mass=1, pose=at(0.013, 0.002, 0.042, (1, 2, 3))))
    near = near_points(floor, ball, FacePairs(), margin=0.005)
    assert near.gaps == pytest.approx([2e-3], abs=1e-12)
    assert near.points[0, :2] == pytest.approx([0.013, 0.002], abs=1e-12)


def test_turns_are_measured_and_made_alike() -> None:
    assert turn_between(at(0, 0, 0), at(0, 0, 0, (0.1, -0.2, 0.3))) == pytest.approx(np.degrees(np.sqrt(0.14)))


def test_groups_are_joined_by_chains() -> None:
    assert joined("abcde", [("d", "b"), ("e", "d")]) == (("a",), ("b", "d", "e"), ("c",))


def pair(size_a: tuple[float, ...], size_b: tuple[float, ...], place: tuple[float, float, float]) -> list[Posed]:
    a = Posed(hf.Body("a", hf.Box(size_a), mass=1.0))
    return [a, Posed(hf.Body("b", hf.Box(size_b), mass=1.0, pose=at(*place)))]


def test_a_corner_is_pushed_out_the_nearest_way_only() -> None:
    """b reaches 3 mm over the edge of a and 1 mm into it: it goes up, not aside."""
    a, b = pair((0.1, 0.1, 0.1), (0.1, 0.1, 0.1), (0.097, 0, 0.099))
    near = near_points(a, b, FacePairs(), margin=0.01)
    deep = near.gaps < -1e-6
    assert deep.any()
    assert near.gaps[deep] == pytest.approx(np.full(deep.sum(), -1e-3), abs=1e-9)
    assert near.normals[deep] == pytest.approx(np.tile([0, 0, 1.0], (deep.sum(), 1)))


def test_the_far_side_of_a_thin_plate_is_no_overlap() -> None:
    a, b = pair((0.1, 0.1, 0.004), (0.1, 0.1, 0.002), (0.001, 0, 0.0035))  # 0.5 mm above
    near = near_points(a, b, FacePairs(), margin=0.01)
    assert near.gaps == pytest.approx(np.full(len(near.gaps), 5e-4), abs=1e-9)


def test_a_box_that_leans_by_a_twentieth_of_a_millimetre_comes_down() -> None:
    scene = hf.Scene([boxes(0.0).body("floor"), hf.Body("a", hf.Box((0.1, 0.1, 0.1)), mass=1.0)], 0.5)
    scene = scene.moved({"a": at(0, 0, 0.050025, (5e-4, 0, 0))})
    motion = resting(scene, "a")
    corners = motion.bodies[0].body.surface_world.vertices
    assert abs(np.sort(corners[:, 2])[:4]).max() < 1.1e-5


LEAST = 5e-6  # [m] the least overlap that is compared with what the bodies share


@pytest.mark.parametrize(("sunk", "up"), [(0.001, 1.0), (0.0032, 1.0), (0.0058, -1.0), (0.0068, -1.0)])
def test_a_plate_leaves_another_on_the_nearer_side_though_that_is_more_than_half_its_thickness(
    sunk: float, up: float
) -> None:
    """A plate of 5 mm that sinks into one of 3 mm: from 4 mm on it is nearer to the other side."""
    a, b = pair((0.2, 0.2, 0.003), (0.1, 0.1, 0.005), (0, 0, 0.004 - sunk))
    near = near_points(a, b, FacePairs(), margin=0.01, least=LEAST, overlapping=True)
    deep = near.gaps < -LEAST
    assert deep.any()
    depth = sunk if up > 0 else 0.008 - sunk
    assert near.gaps[deep] == pytest.approx(np.full(deep.sum(), -depth), abs=1e-9)
    assert near.normals[deep] == pytest.approx(np.tile([0, 0, up], (deep.sum(), 1)))


def covered(name: str, z: float) -> hf.Body:
    """Two covers, 3 mm thick, that reach over a thicker block between them on all sides, as those of a book do."""
    parts = [Box((0.2, 0.2, 0.003), 0.0135), Box((0.16, 0.16, 0.024), 0.0), Box((0.2, 0.2, 0.003), -0.0135)]
    solid = manifold3d.Manifold.batch_boolean([part.solid() for part in parts], manifold3d.OpType.Add)
    mesh = solid.to_mesh64()
    return hf.Body(
        name, hf.Mesh(np.array(mesh.vert_properties)[:, :3], np.array(mesh.tri_verts)), 1.0, pose=at(0, 0, z)
    )


class Box(NamedTuple):
    size: tuple[float, float, float]
    z: float

    def solid(self) -> manifold3d.Manifold:
        return manifold3d.Manifold.cube(self.size, True).translate((0, 0, self.z))


def test_covers_that_overlap_by_almost_their_thickness_leave_as_the_whole_book_does() -> None:
    """Where covers overhang, the nearer way out of 3.5 mm is 2.5 mm downwards; what the books share says upwards."""
    a, b = Posed(covered("a", 0.015)), Posed(covered("b", 0.0415).moved(at(0.01, 0.005, 0.0415)))
    near = near_points(a, b, FacePairs(), margin=0.01, least=LEAST, overlapping=True)
    deep = near.gaps < -LEAST
    assert near.gaps[deep].min() == pytest.approx(-3.5e-3, abs=1e-6)
    assert (near.normals[deep][:, 2] > -0.5).all()


def tray(name: str, width: float, floor: float, wall: float, rim: float) -> hf.Body:
    """A tray, square and hollow from above: the floor, whose middle is at the origin, and walls to ``rim`` above it."""
    full = manifold3d.Manifold.cube((width, width, rim + floor / 2)).translate((-width / 2, -width / 2, -floor / 2))
    inner = width - 2 * wall
    hollow = manifold3d.Manifold.cube((inner, inner, rim)).translate((-inner / 2, -inner / 2, floor / 2))
    mesh = (full - hollow).to_mesh64()
    return hf.Body(name, hf.Mesh(np.array(mesh.vert_properties)[:, :3], np.array(mesh.tri_verts)), 1.0)


ANY = rotation_of(np.array([0.4, -0.7, 1.1]))


def turned(body: hf.Body, z: float) -> Posed:
    """The body ``z`` higher, then the whole turned."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = ANY, ANY @ [0, 0, z]
    return Posed(body.moved(pose))


@pytest.mark.parametrize("z", [-8e-4, 0.0, 8e-4])
@pytest.mark.parametrize("order", [1, -1])
def test_a_floor_inside_another_leaves_it_on_the_side_where_the_bodies_come_apart(z: float, order: int) -> None:
    """Both sides of a floor of 1 mm are inside one of 3 mm; below it, the walls of the tray would be in that one."""
    a, b = turned(tray("a", 0.2, 3e-3, 4e-3, 0.03), 0.0), turned(tray("b", 0.1, 1e-3, 4e-3, 0.04), z)
    (found,) = shared_solids(*(a, b)[::order]) or ()
    assert found.way == pytest.approx(order * ANY[:, 2], abs=1e-9)
    near = near_points(*(a, b)[::order], FacePairs(), margin=0.005, least=LEAST, overlapping=True)
    deep = near.gaps < -LEAST
    assert near.normals[deep] == pytest.approx(np.tile(order * ANY[:, 2], (deep.sum(), 1)), abs=1e-9)
    assert near.gaps[deep].min() == pytest.approx(-(1.5e-3 + 0.5e-3 - z), abs=1e-9)


def crossing(size: tuple[float, float, float]) -> Posed:
    return turned(hf.Body("b", hf.Box(size), mass=1.0), 0.0)


@pytest.mark.parametrize("size", [(0.1, 0.1, 1e-3), (0.01, 0.01, 0.2)])
def test_a_plate_in_the_middle_of_another_and_a_rod_through_it_have_no_side(size: tuple[float, float, float]) -> None:
    """The plate comes apart as soon to one side as to the other, the rod to none."""
    plate = turned(hf.Body("a", hf.Box((0.2, 0.2, 3e-3)), mass=1.0), 0.0)
    (found,) = shared_solids(plate, crossing(size)) or ()
    assert found.way is None


def test_overlaps_of_folded_triangles_outside_of_a_body_are_none() -> None:
    """A triangle that faces inwards, above the top of a box: what hovers over it does not overlap with anything."""
    box = hf.Box((0.1, 0.1, 0.1)).surface
    fold = np.array([[-0.002, -0.002, 0.05], [0.002, -0.002, 0.05], [0, 0.002, 0.0502]])
    vertices = np.concatenate([box.vertices, fold])
    faces = np.concatenate([box.faces, [[8, 10, 9]]])
    folded = Posed(hf.Body("a", hf.Mesh(vertices, faces), mass=1.0, com=(0, 0, 0), inertia=np.eye(3)))
    above = Posed(hf.Body("b", hf.Box((0.1, 0.1, 0.1)), mass=1.0, pose=at(0, 0, 0.1004)))
    assert folded.solid is None
    inside = folded.encloses(np.array([[0, 0, 0.049], [0, 0, 0.0501], [0.03, 0.03, 0.0501]]))
    assert inside.tolist() == [True, False, False]
    near = near_points(folded, above, FacePairs(), margin=0.002, least=LEAST)
    assert near.gaps.min() > 0


def test_motions_that_contradictory_overlaps_ask_for_are_not_made() -> None:
    """A tilted box is too wide for the slot between two walls; only far up, where these end, it would be free."""
    walls = [
        hf.Body(n, hf.Box((0.05, 0.2, 0.2)), pose=at(x, 0, 0.15), fixed=True) for n, x in (("l", -0.075), ("r", 0.075))
    ]
    box = hf.Body("a", hf.Box((0.1002, 0.1, 0.1)), mass=1.0, pose=at(0, 0, 0.0512, (0, 0.002, 0.05)))
    motion = resting(hf.Scene([boxes(0.0).body("floor"), *walls, box], 0.5), "a")
    assert np.linalg.norm(motion.pushed[0]) < 0.01
