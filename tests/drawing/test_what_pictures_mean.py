"""What a picture says: which way its arrows point, how long they are, which body and which number they name.

Told from the artists and traces that are drawn, never from the bytes of a file.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray
from paged import data_of, faces, triples

import holdfast as hf
from holdfast.drawing.edges import arrow_mesh
from holdfast.drawing.map_png import layout_of
from holdfast.drawing.marks import PUSH, Shot, arrow_shapes, draw_contacts, draw_pushes, on_page
from holdfast.drawing.picture import Arrow, Picture
from holdfast.report.map_picture import picture_of
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import box, floor

G = 9.81
TIP = 3  # number of the corner of an arrow's outline that is its point


@pytest.fixture(scope="module")
def stack() -> hf.answers.RobustnessMap:
    return hf.robustness_map(hf.assemble(shipped_scene("stack")), spacing=0.025, engine="limit")


@pytest.fixture(scope="module")
def picture(stack: hf.answers.RobustnessMap) -> Picture:
    return picture_of(stack)


def test_contact_forces_push_the_body_that_they_act_on(picture: Picture) -> None:
    """A stack of three cubes of 9.81 N: what lies above is borne by what lies below, with 3, 2 and 1 weights."""
    height = {"floor": 0, "cube1": 1, "cube2": 2, "cube3": 3}
    told = {}
    for arrow in picture.contact_forces:
        a, b, newton = re.fullmatch(r"(\w+) on (\w+): ([\d.]+) N", arrow.label).groups()  # type: ignore[union-attr]
        along = arrow.head - arrow.tail
        assert along[:2] == pytest.approx([0, 0], abs=1e-3 * np.linalg.norm(along))
        assert (along[2] > 0) == (height[b] > height[a]), arrow.label
        assert arrow.head == pytest.approx([0, 0, 0.1 * min(height[a], height[b])], abs=1e-3)
        told[frozenset({a, b})] = (float(newton), float(np.linalg.norm(along)))
    weights = {frozenset({"floor", "cube1"}): 3, frozenset({"cube1", "cube2"}): 2, frozenset({"cube2", "cube3"}): 1}
    assert {pair: round(newton / G, 2) for pair, (newton, _) in told.items()} == weights
    scale = told[frozenset({"floor", "cube1"})][1] / 3
    assert {pair: round(length / scale, 2) for pair, (_, length) in told.items()} == weights


def test_pushes_come_from_outside_along_the_push(stack: hf.answers.RobustnessMap, picture: Picture) -> None:
    weakest = {weak.body: weak for weak in stack.weakest_of_each_body()}
    assert len(picture.weakest) == 3
    for arrow in picture.weakest:
        name, newton = re.match(r"(\w+): ([\d.]+) N", arrow.label).groups()  # type: ignore[union-attr]
        weak = weakest[name]
        along = (arrow.head - arrow.tail) / np.linalg.norm(arrow.head - arrow.tail)
        assert along == pytest.approx(weak.direction)
        assert arrow.head == pytest.approx(weak.point)
        assert float(newton) == pytest.approx(weak.force, rel=5e-3)
        centre = stack.assembly.scene.body(name).com_world
        half = np.abs(arrow.tail - centre)
        assert half.max() > 0.05, "the tail is in the body"
        assert half.max() > np.abs(arrow.head - centre).max()


def test_every_cell_tells_its_own_body_and_number(stack: hf.answers.RobustnessMap, picture: Picture) -> None:
    for surface in picture.heat:
        low, high = stack.assembly.scene.body(surface.name).box
        assert ((surface.vertices >= low - 1e-9) & (surface.vertices <= high + 1e-9)).all()
        for point, force, text in zip(surface.points, surface.force, surface.hover, strict=True):
            index = int(np.flatnonzero((stack.points == point).all(1))[0])
            assert force == stack.force[index]
            assert text.startswith(f"<b>{surface.name}</b> at ({point[0]:.3f}, {point[1]:.3f}, {point[2]:.3f}) m")
            assert ("∞" in text) == np.isinf(force)
            assert np.isinf(force) or f"<b>{force:.3g} N</b>" in text


def collections(draw: Any, *more: Any) -> list[PolyCollection]:
    axes = Figure(figsize=(16, 10), dpi=100).add_axes((0, 0, 1, 1))
    draw(axes, *more)
    return [artist for artist in axes.collections if isinstance(artist, PolyCollection)]


def shots_of(picture: Picture) -> tuple[Shot, Shot]:
    """The first panel of the map, and that of the contacts."""
    shots = layout_of(picture, (1600, 1000)).shots
    return shots[0], next(shot for shot in shots if shot.contacts)


def assert_drawn(outline: NDArray[np.float64], shot: Shot, arrow: Arrow) -> None:
    """The outline ends in a point at the arrow's head, and its shaft lies on the side of the tail."""
    tail, head = on_page(shot, np.array([arrow.tail, arrow.head]))
    assert outline[TIP] == pytest.approx(head, abs=1e-6)
    shaft = (outline[0] + outline[6]) / 2 - outline[TIP]
    across = np.array([head[1] - tail[1], tail[0] - head[0]])
    assert shaft @ across == pytest.approx(0, abs=1e-6 * np.linalg.norm(across))
    assert shaft @ (tail - head) > 0
    assert np.ptp(outline[[2, 4]], axis=0).max() > np.ptp(outline[[1, 5]], axis=0).max(), "the head is wider"


def test_the_drawn_arrows_of_pushes_point_at_the_pushed_points(picture: Picture) -> None:
    shot, _ = shots_of(picture)
    drawn = collections(draw_pushes, shot, picture, dict.fromkeys(range(len(picture.weakest)), True), 1.0)
    assert len(drawn) == len(picture.weakest)
    for collection, arrow in zip(drawn, picture.weakest, strict=True):
        (path,) = collection.get_paths()
        assert_drawn(path.vertices[:7], shot, arrow)


def test_the_drawn_arrows_of_contact_forces_end_at_their_centres(picture: Picture) -> None:
    _, shot = shots_of(picture)
    patches, arrows = collections(draw_contacts, shot, picture, 1.0)
    assert len(patches.get_paths()) == len(picture.outlines)
    for path, outline in zip(patches.get_paths(), picture.outlines, strict=True):
        assert path.vertices[: len(outline)] == pytest.approx(on_page(shot, outline))
    assert len(arrows.get_paths()) == 3
    for path, arrow in zip(arrows.get_paths(), picture.contact_forces, strict=True):
        assert_drawn(path.vertices[:7], shot, arrow)


def test_a_short_arrow_is_drawn_longer_backwards() -> None:
    """It keeps its point, which is where the push acts, and its direction."""
    (outline,) = arrow_shapes(np.array([[10.0, 0.0]]), np.array([[12.0, 0.0]]), PUSH)
    assert outline[TIP] == pytest.approx([12, 0])
    assert outline[:, 0].min() == pytest.approx(12 - 34)


def test_arrows_in_space_are_rods_with_their_cone_at_the_head() -> None:
    arrow = Arrow(np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 5.0]), "")
    vertices, triangles = arrow_mesh((arrow,), 0.05)
    height, off = vertices[:, 2], np.linalg.norm(vertices[:, :2] - [1, 2], axis=1)
    assert height.max() == pytest.approx(5)
    assert off[height > 5 - 1e-9] == pytest.approx(0)
    assert off[height < 3 + 1e-9].max() == pytest.approx(0.05)
    assert height[np.argmax(off)] == pytest.approx(5 - 0.25)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() > 0, "the surface faces outwards"


def test_the_arrows_of_the_page_stay_outside_of_what_they_push(
    stack: hf.answers.RobustnessMap, picture: Picture, tmp_path: Path
) -> None:
    stack.save_html(tmp_path / "p.html")
    labels = [arrow.label for arrow in picture.weakest]
    (drawn,) = [part for part in faces(data_of((tmp_path / "p.html").read_text())) if part["texts"] == labels]
    for number, arrow in enumerate(picture.weakest):
        own = triples(drawn["vertices"])[drawn["cell"] == number]
        low, high = stack.assembly.scene.body(arrow.label.split(":")[0]).box
        assert np.linalg.norm(own - arrow.head, axis=1).min() < 1e-6
        inside = ((own > low + 1e-5) & (own < high - 1e-5)).all(1)
        assert not inside.any()


def test_the_list_of_weakest_pushes_names_who_moves_besides_the_pushed_body() -> None:
    """A box under a lighter one is pushed: both slide, or the upper one falls off, and the list says so."""
    bodies = [box("lower", (0.1, 0.1, 0.1), 1.0, (0, 0, 0.05)), box("upper", (0.1, 0.1, 0.02), 0.1, (0, 0, 0.11))]
    scene = hf.Scene([floor(), *bodies], friction=0.5)
    found = hf.robustness_map(scene, spacing=0.03, engine="limit")
    weak = {one.body: one for one in found.weakest_of_each_body()}
    labels = {arrow.label.partition(":")[0]: arrow.label for arrow in picture_of(found).weakest}
    assert weak["lower"].moving == ("lower", "upper")
    assert labels["lower"].endswith(f"{weak['lower'].mode} of lower, upper")
    assert weak["upper"].moving == ("upper",)
    assert labels["upper"].endswith(f", {weak['upper'].mode}")
