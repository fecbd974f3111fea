"""The map over all exposed surfaces."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.base.rigid import pose_from
from holdfast.geometry.distance import distance_to_surface
from holdfast.scene.shipped import shipped_scene, shipped_scenes
from holdfast.scene.shipped.blocks import at, box, cube, floor, table

TOO_MANY_CUTS = {"bonded_wall"}  # refused with a remedy: tests/engines/graph/test_cuts.py


@pytest.mark.parametrize("name", sorted(set(shipped_scenes()) - TOO_MANY_CUTS))
def test_maps_of_shipped_scenes_are_numbers_on_the_bodies(name: str) -> None:
    assembly = hf.assemble(shipped_scene(name))
    found = hf.robustness_map(assembly, spacing=0.04, engine="graph")
    n = len(found.force)
    fields = (found.points, found.normals, found.body, found.status, found.lower, found.upper, found.moving, found.mode)
    assert [len(f) for f in fields] == [n] * 8
    assert not any(np.isnan(f).any() for f in (found.points, found.normals, found.force, found.lower, found.upper))
    assert (found.force >= 0).all()
    assert (found.lower <= found.force).all()
    assert (found.force <= found.upper).all()
    assert set(found.body) == {b.name for b in assembly.movable}
    for status, force, moving, mode in zip(found.status, found.force, found.moving, found.mode, strict=True):
        assert (status == hf.Status.FINITE) == np.isfinite(force)
        assert (status == hf.Status.INFINITE) == (moving == () and mode == "none")
    for name_ in set(found.body):
        here = np.array(found.body) == name_
        some = found.points[here][:: max(1, here.sum() // 50)]
        assert distance_to_surface(some, assembly.scene.body(name_).surface_world).max() < 2e-8


def test_the_map_says_what_a_query_says() -> None:
    assembly = hf.assemble(table())
    found = hf.robustness_map(assembly, ["leg_left", "slab"], spacing=0.03, engine="graph")
    for name in ("leg_left", "slab"):
        own = found.body == name
        asked = hf.robustness(assembly, name, found.points[own], -found.normals[own], engine="graph")
        np.testing.assert_allclose(found.force[own], asked.force, rtol=1e-12)
        assert list(found.moving[own]) == list(asked.moving)
        assert list(found.mode[own]) == list(asked.mode)


def test_the_weakest_point_is_the_smallest_force() -> None:
    found = hf.robustness_map(hf.assemble(table()), spacing=0.02, engine="graph")
    weakest = found.weakest()
    assert weakest.force == pytest.approx(found.force.min(), rel=1e-9)
    (k,) = np.flatnonzero((found.points == weakest.point).all(1) & (-found.normals == weakest.direction).all(1))
    assert weakest.force == found.force[k]
    assert weakest.body == found.body[k]
    assert weakest.moving
    assert weakest.mechanism
    each = found.weakest_of_each_body()
    assert each[0] == weakest
    assert {p.body for p in each} == {"slab", "leg_left", "leg_right"}
    for point in each:
        assert point.force == pytest.approx(found.force[np.array(found.body) == point.body].min(), rel=1e-9)


@pytest.mark.parametrize(("sunk", "spacing", "hidden"), [(0, 0.02, 2), (1e-4, 0.02, 2), (0, 0.0125, 1)])
def test_points_on_contacts_and_right_behind_other_bodies_are_hidden(sunk: float, spacing: float, hidden: int) -> None:
    """A cube on a floor, beside a wall 8 mm away: less than half of 20 mm, but not of 12.5 mm."""
    wall = hf.Body("wall", hf.Box((0.02, 0.1, 0.1)), pose=at(0.068, 0, 0.05), fixed=True)
    scene = hf.Scene([floor(), wall, box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05 - sunk))], 0.5)
    found = hf.robustness_map(hf.assemble(scene), spacing=spacing, engine="graph")
    on_a_side = round(0.1 / spacing) ** 2
    assert len(found.points) == (6 - hidden) * on_a_side
    assert {tuple(n) for n in found.hidden["cube"].normals.round().tolist()} == {(0, 0, -1), (1, 0, 0)} - {
        (1, 0, 0) if hidden == 1 else None
    }


def test_a_fixed_body_never_moves() -> None:
    found = hf.robustness_map(hf.assemble(cube()), ["floor"], spacing=0.2, engine="graph")
    assert np.isinf(found.force).all()
    assert set(found.status) == {hf.Status.INFINITE}


def test_a_scene_that_does_not_stand_has_no_robustness() -> None:
    floating = hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.09))], 0.5)
    found = hf.robustness_map(hf.assemble(floating), spacing=0.05, engine="graph")
    assert set(found.status) == {hf.Status.UNSTABLE}
    assert not found.force.any()
    assert found.verdict.status == hf.Status.UNSTABLE


def test_a_coarse_spacing_still_gives_a_point_for_every_face() -> None:
    found = hf.robustness_map(hf.assemble(cube()), spacing=10, engine="graph")
    exposed = {tuple(np.round(n)) for n in found.normals}
    assert exposed == {(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)}


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"spacing": 1e-6}, r"spacing 1e-06 m gives about [\d,]+ points on .*; use .* m or more"),
        ({"bodies": ["slb"]}, r"'slb'; did you mean 'slab'"),
        ({"bodies": "slab"}, r"'slab'.*; "),
        ({"bodies": []}, r"bodies.*; "),
        ({"engine": "grap"}, r"engine: 'grap' is unknown; known: graph"),
        ({"engine": hf.Graph}, r"engine: .*Graph.*; needs a name"),
    ],
)
def test_what_is_refused(options: dict[str, Any], match: str) -> None:
    with pytest.raises(hf.HoldfastError, match=match) as caught:
        hf.robustness_map(hf.assemble(table()), **{"engine": "graph", **options})
    assert "there is no movable body" not in str(caught.value)


def test_a_line_contact_along_a_face_covers_nothing() -> None:
    """A rod lying on the edge of a block: its underside touches along a line, which no cell lies under."""
    turned = np.array([np.cos(np.pi / 8), np.sin(np.pi / 8), 0, 0])
    bar = hf.Body("bar", hf.Box((0.5, 0.1, 0.1)), pose=pose_from(np.zeros(3), turned), fixed=True)
    plate = hf.Body(
        "plate", hf.Box((0.2, 0.2, 0.02)), mass=1, pose=pose_from(np.array([0, 0, 0.05 * 2**0.5 + 0.01]), np.eye(4)[0])
    )
    assembly = hf.assemble(hf.Scene([bar, plate], 0.5))
    assert [patch.kind for i in assembly.interfaces for patch in i.patches] == ["line"]
    m = hf.robustness_map(assembly, spacing=0.02, engine="graph")
    assert (m.normals[:, 2] < -0.9).sum() > 90  # all of its underside that the bar is not right in front of


def test_points_on_the_rim_of_a_contact_are_beside_it_wherever_the_scene_is() -> None:
    """At this spacing some cells of the cantilever have their points on the outline of a contact, but for rounding."""
    given = shipped_scene("cantilever")
    counts = []
    for shift in np.linspace(0, 1, 12):
        pose = pose_from(np.array([shift / 3, shift / 7, 0]), np.array([1.0, 0, 0, 0]))
        moved = hf.Scene([body.moved(pose @ body.pose) for body in given.bodies], given.friction)
        found = hf.robustness_map(moved, ["B"], spacing=0.065, engine="graph")
        counts.append((len(found.points), len(found.hidden["B"].points)))
    assert set(counts) == {counts[0]}
