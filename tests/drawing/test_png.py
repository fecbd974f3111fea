"""PNG files: colours as in the legend, panels, odd pictures, failures."""

from __future__ import annotations

import builtins
import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from holdfast.base.errors import HoldfastError
from holdfast.drawing import colours
from holdfast.drawing.camera import back_view, front_view
from holdfast.drawing.canvas import room_of_axes
from holdfast.drawing.map_png import layout_of, write_png
from holdfast.drawing.marks import badge_places, nearest_badges, on_page, visible
from holdfast.drawing.picture import HeatSurface, Picture, forces, movable
from holdfast.drawing.render import render

SIZE = (1600, 1000)


def drawn(picture: Picture, folder: Path, size: tuple[int, int] = SIZE) -> NDArray[np.float64]:
    path = folder / "picture.png"
    write_png(picture, path, size=size)
    return np.asarray(Image.open(path).convert("RGB")) / 255.0


def pixel(
    image: NDArray[np.float64], picture: Picture, point: NDArray[np.float64], panel: int = 0
) -> NDArray[np.float64]:
    shot = layout_of(picture, (image.shape[1], image.shape[0])).shots[panel]
    column, row = on_page(shot, point[None])[0]
    return np.asarray(image[int(row), int(column)])


def assert_shaded(seen: NDArray[np.float64], legend: object) -> None:
    full = np.asarray(legend)
    assert np.all(seen <= full + 2 / 255)
    assert np.all(seen >= 0.88 * full - 2 / 255), "shading takes an eighth of the brightness at most"
    brightness = seen.sum() / full.sum()
    np.testing.assert_allclose(seen, brightness * full, atol=2 / 255)


def test_cells_have_the_colour_of_the_legend(table: Picture, tmp_path: Path) -> None:
    table = dataclasses.replace(table, weakest=())
    image = drawn(table, tmp_path)
    assert image.shape == (1000, 1600, 3)
    slab = table.heat[0]
    scale = colours.scale_of(forces(table))
    on_top = np.flatnonzero((slab.points[:, 2] > 0.7799) & (np.abs(slab.points[:, 0]) < 0.6))
    assert len(on_top) > 100
    for cell in on_top[::7]:
        legend = colours.colours(scale, slab.force[cell : cell + 1])[0]
        assert_shaded(pixel(image, table, slab.points[cell]), legend)


def test_the_colour_bar_runs_through_the_scale(table: Picture, tmp_path: Path) -> None:
    image = drawn(table, tmp_path)
    layout = layout_of(table, SIZE)
    foot, indent = layout.footer, round(20 * layout.unit)
    middle = foot.top + round(60 * layout.unit)
    row = np.rint(image[middle, foot.left + indent : foot.left + round(0.37 * foot.width)] * 255)
    expected = np.rint(colours.sample(np.linspace(0.0, 1.0, len(row))) * 255)
    np.testing.assert_allclose(row, expected, atol=1)


def test_a_picture_without_finite_values_is_drawn_without_a_bar(table: Picture, tmp_path: Path) -> None:
    heat = tuple(dataclasses.replace(surface, force=np.full_like(surface.force, np.inf)) for surface in table.heat)
    picture = dataclasses.replace(table, heat=heat, weakest=())
    image = drawn(picture, tmp_path)
    assert_shaded(pixel(image, picture, np.array([0.3, 0.1, 0.78])), colours.INFINITE)
    assert not np.any(np.all(np.abs(image - colours.TABLE[0]) < 2 / 255, axis=2))


def test_faces_hidden_in_front_are_seen_from_behind(table: Picture, tmp_path: Path) -> None:
    image = drawn(table, tmp_path)
    scale = colours.scale_of(forces(table))
    slab = table.heat[0]
    below = np.flatnonzero((slab.points[:, 2] < 0.701) & (np.abs(slab.points[:, 0]) > 0.6))
    toward = layout_of(table, SIZE).shots[1].camera.view.toward
    cell = max(below, key=lambda k: float(slab.points[k] @ toward))
    assert_shaded(pixel(image, table, slab.points[cell], panel=1), colours.colours(scale, slab.force[[cell]])[0])


def test_a_push_is_seen_only_where_its_point_is(table: Picture) -> None:
    shots = layout_of(table, SIZE).shots[:2]
    depth = [render(movable(table, None), None, s.camera, (s.box.height, s.box.width)).depth for s in shots]
    seen = [[visible(s, d, arrow) for arrow in table.weakest] for s, d in zip(shots, depth, strict=True)]
    assert seen[0][:4] == [True] * 4
    assert seen[0][5] is False
    assert seen[1][5] is True
    assert seen[1][:4] == [False] * 4


def test_a_large_floor_does_not_shrink_the_bodies(table: Picture) -> None:
    bare = dataclasses.replace(table, solids=())
    assert layout_of(table, SIZE).shots[0].camera.scale == layout_of(bare, SIZE).shots[0].camera.scale


def test_tall_pictures_stand_side_by_side_and_flat_ones_in_two_rows(heat_box: Callable[..., HeatSurface]) -> None:
    for name, high, rows in (("tower", (0.1, 0.1, 1.0), 1), ("plank", (1.0, 0.1, 0.1), 2)):
        body = heat_box(name, (-high[0], -high[1], 0.0), high, lambda points: 1 + points[:, 2])
        picture = Picture(name, "", (body,), (), contact_points=body.points[:1])  # three panels
        assert len({shot.box.top for shot in layout_of(picture, SIZE).shots}) == rows


@pytest.mark.parametrize("size", [(480, 300), (1000, 1400)])
def test_other_sizes_are_kept(single: Callable[[float], Picture], tmp_path: Path, size: tuple[int, int]) -> None:
    assert drawn(single(1.0), tmp_path, size).shape == (size[1], size[0], 3)


def test_views_are_upright_and_not_mirrored(table: Picture) -> None:
    """Right, up and towards the viewer are a right-handed frame; up is up, seen from above and from below."""
    for up in ([0.0, 0.0, 1.0], [0.6, 0.0, 0.8]):
        picture = dataclasses.replace(table, up=np.array(up))
        front = front_view(picture)
        for view, above in ((front, 1), (back_view(picture, front), -1)):
            np.testing.assert_allclose(np.cross(view.right, view.up), view.toward, atol=1e-12)
            assert view.right @ up == pytest.approx(0, abs=1e-12)
            assert view.up @ up > 0.8
            assert above * (view.toward @ up) > 0.3


def test_the_vertical_may_be_any_axis(table: Picture, tmp_path: Path) -> None:
    image = drawn(dataclasses.replace(table, up=np.array([0.0, -1.0, 0.0]), weakest=()), tmp_path)
    assert 0.02 < np.mean(np.ptp(image, axis=2) > 0.2) < 0.9


def test_nothing_to_show_is_still_a_picture(tmp_path: Path) -> None:
    assert drawn(Picture("empty", "", (), ()), tmp_path).shape == (1000, 1600, 3)


def test_odd_labels_are_plain_text_and_arrows_without_length_are_passed_over(table: Picture, tmp_path: Path) -> None:
    odd = tuple(dataclasses.replace(arrow, label="a $x_1$<br>b $") for arrow in table.weakest)
    points = tuple(dataclasses.replace(arrow, tail=arrow.head) for arrow in table.weakest)
    texts = {"title": "$ \\frac{", "subtitle": "word " * 200}
    drawn(dataclasses.replace(table, weakest=odd * 3 + points, contact_forces=points, **texts), tmp_path)


def test_too_small_a_size_is_refused(table: Picture, tmp_path: Path) -> None:
    with pytest.raises(HoldfastError, match="too small"):
        write_png(table, tmp_path / "a.png", size=(100, 100))
    assert list(tmp_path.iterdir()) == []


def test_a_missing_directory_is_named(single: Callable[[float], Picture], tmp_path: Path) -> None:
    with pytest.raises(HoldfastError, match="nowhere"):
        write_png(single(1.0), tmp_path / "nowhere" / "a.png")


def test_missing_matplotlib_is_explained(table: Picture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *more: object) -> object:
        if name.startswith("matplotlib"):
            raise ModuleNotFoundError(name)
        return real(name, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(HoldfastError, match=r"needs matplotlib.*pip install 'holdfast-robotics\[viewer\]'"):
        write_png(table, tmp_path / "a.png")


@pytest.mark.parametrize("count", [1, 3])
def test_numbers_of_pushes_keep_clear_of_the_axes(table: Picture, count: int) -> None:
    shot = layout_of(table, SIZE).shots[0]
    middle, radius = room_of_axes(shot.box, 1.0)
    for offset in (0.0, 20.0, radius):
        places = np.tile(middle + offset, (count, 1))
        apart = badge_places(shot, places, 1.0)
        assert (np.linalg.norm(apart - middle, axis=1) >= radius + 12.0).all(), "the radius of a badge is 12"
        assert (apart >= [shot.box.left, shot.box.top]).all()
        assert (apart <= [shot.box.left + shot.box.width, shot.box.top + shot.box.height]).all()
    elsewhere = np.array([[shot.box.left + shot.box.width / 2, shot.box.top + shot.box.height / 2]])
    np.testing.assert_allclose(badge_places(shot, elsewhere, 1.0), elsewhere, atol=0.02)


def test_a_number_stands_at_the_end_of_its_own_arrow() -> None:
    ends = np.array([[100.0, 100.0], [110.0, 100.0], [300.0, 50.0]])
    passed = np.array([[121.0, 103.0], [94.0, 98.0], [310.0, 50.0]])  # the first two passed each other
    assert nearest_badges(ends, passed).tolist() == [1, 0, 2]
