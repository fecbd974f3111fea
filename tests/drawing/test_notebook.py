"""What notebooks show: small pictures in the right colours, on light and on dark, without scripts."""

from __future__ import annotations

import base64
import re
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

import holdfast as hf
from holdfast.drawing import colours
from holdfast.drawing.picture import forces
from holdfast.drawing.render import png_bytes
from holdfast.drawing.svg import rose
from holdfast.report.map_picture import picture_of
from holdfast.scene.shipped.blocks import box, floor

LARGEST = 40_000  # of what a cell shows [characters]


@pytest.fixture(scope="module")
def table() -> hf.answers.Assembly:
    return hf.assemble(hf.shipped_scene("table"))


@pytest.fixture(scope="module")
def table_map(table: hf.answers.Assembly) -> hf.answers.RobustnessMap:
    return hf.robustness_map(table, spacing=0.03, engine="graph")


def image_in(page: str) -> np.ndarray:
    (content,) = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    return np.asarray(Image.open(BytesIO(base64.b64decode(content))).convert("RGB")) / 255.0


def test_a_scene_and_an_assembly_show_their_bodies(table: hf.answers.Assembly) -> None:
    for value, words in ((table.scene, ("3 movable, 1 fixed", "slab", "Box")), (table, ("4 interfaces", "cm²"))):
        page = value._repr_html_()
        assert len(page) < LARGEST
        assert "<script" not in page
        for word in words:
            assert word in page
        drawn = image_in(page)
        assert 0.1 < (drawn.min(axis=2) < 0.97).mean() < 0.95, "bodies on white"


def test_a_map_shows_its_weakest_colour_and_its_scale(table_map: hf.answers.RobustnessMap) -> None:
    page = table_map._repr_html_()
    assert len(page) < LARGEST
    picture = picture_of(table_map)
    scale = colours.scale_of(forces(picture))
    assert scale is not None
    low, *_, high = colours.ticks(scale)
    assert f"{low.label} N" in page
    assert f"{high.label} N" in page
    assert colours.hex_of(colours.TABLE[0]) in page
    drawn = image_in(page).reshape(-1, 3)
    shades = np.linspace(0.88, 1.0, 13)[:, None]
    for colour in (colours.TABLE[0], colours.INFINITE):
        off = np.abs(drawn[:, None] - shades * np.asarray(colour)).max(axis=2).min(axis=1)
        assert (off < 0.03).mean() > 0.003


def test_limits_are_drawn_to_the_side_that_they_are_for() -> None:
    """A block that is four times as long as wide tips across far sooner than along; b / h g either way."""
    scene = hf.Scene([floor(), box("block", (0.4, 0.1, 0.4), 1.0, (0.0, 0.0, 0.2))], friction=2.0)
    ways = hf.assemble(scene).scene.horizontal_directions(4)
    page = hf.transport_limits(scene, ways, engine="limit")._repr_html_()
    (points,) = re.findall(r'<polygon points="([^"]+)"', page)
    places = np.array([[float(v) for v in pair.split(",")] for pair in points.split()])
    along, across, back, other = places
    assert along == pytest.approx([80, 0], abs=0.2)
    assert back == pytest.approx([-80, 0], abs=0.2)
    assert across == pytest.approx([0, -20], abs=0.2), "+y is up the page, and a quarter as far"
    assert other == pytest.approx([0, 20], abs=0.2)
    assert "9.81 m/s²" in page


def test_what_is_not_known_and_what_never_moves_lie_on_the_ring() -> None:
    drawn = rose(
        np.deg2rad([0.0, 90.0, 180.0, 270.0]), np.array([2.0, np.inf, 0.0, 1.0]), np.array([True, True, False, True]),
        "m/s²", ("a", "b", "c", "d"),
    )  # fmt: skip
    (points,) = re.findall(r'<polygon points="([^"]+)"', drawn)
    reach = [np.hypot(*(float(v) for v in pair.split(","))) for pair in points.split()]
    assert reach == pytest.approx([80 / 1.3, 80, 40 / 1.3], abs=0.1)
    assert '<circle cx="-80.0"' in drawn


def test_letters_take_the_colour_of_the_page_and_pictures_bring_their_own_ground(
    table_map: hf.answers.RobustnessMap,
) -> None:
    """Readable in light and in dark: no letter has a colour of its own, no picture is transparent."""
    limits = hf.transport_limits(table_map.assembly, engine="graph")
    for value in (table_map, limits, table_map.assembly, table_map.assembly.scene):
        page = value._repr_html_()
        assert not re.search(r"[;\"\s]color:", page)
        assert page.count("<img") == page.count('style="background:white')
    assert 'fill="currentColor"' in limits._repr_html_()


def test_png_files_hold_the_image_that_they_were_given() -> None:
    image = np.random.default_rng(1).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    np.testing.assert_array_equal(np.asarray(Image.open(BytesIO(png_bytes(image)))), image)


def test_odd_scenes_have_a_picture_or_none() -> None:
    lonely = hf.Scene([floor()], friction=0.5)
    assert "0 movable, 1 fixed" in lonely._repr_html_()
    steep = hf.transport_limits(hf.shipped_scene("cube"), [[0.0, 0.0, 1.0]], engine="graph")
    assert "<svg" not in steep._repr_html_()
