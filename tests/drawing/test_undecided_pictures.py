"""Pictures, pages and plots of answers that are undecided, fall, are only balanced or finite, side by side."""

from __future__ import annotations

import re
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from paged import data_of, faces
from PIL import Image
from retold import REASON, orange, retold, shelf, unknown

import holdfast as hf
from holdfast.drawing import colours
from holdfast.drawing.colours import Kind
from holdfast.drawing.picture import forces, kinds, legend
from holdfast.drawing.plots import draw_curves
from holdfast.report.carrier_report import polar_picture
from holdfast.report.map_picture import picture_of

UNDECIDED, UNSTABLE, FINITE = hf.Status.UNDECIDED, hf.Status.UNSTABLE, hf.Status.FINITE


def image_of(path: Path) -> np.ndarray:
    return np.asarray(Image.open(BytesIO(path.read_bytes())).convert("RGB")) / 255.0


def share_of(image: np.ndarray, colour: Any, shade: float = 1.0) -> float:
    """The share of the pixels (of every third) with this colour, in the light that faces get."""
    lit = image[::3, ::3, None, :] / np.linspace(0.88, 1, 13)[:, None]
    return float((np.abs(lit - shade * np.asarray(colour)) < 0.012).all(-1).any(-1).mean())


@pytest.fixture(scope="module")
def plain() -> hf.answers.RobustnessMap:
    """A map of the shelf without the orange: everything on it is decided."""
    return hf.robustness_map(hf.assemble(shelf()), spacing=0.02, engine="limit")


@pytest.fixture(scope="module")
def mixed(plain: hf.answers.RobustnessMap) -> hf.answers.RobustnessMap:
    found = retold(plain, plain.body == "vase", UNDECIDED, notes=(REASON,))
    return retold(found, found.body == "cup", UNSTABLE)


def test_the_legend_lists_what_there_is_and_nothing_else(
    plain: hf.answers.RobustnessMap, mixed: hf.answers.RobustnessMap
) -> None:
    assert {Kind.UNDECIDED, Kind.FALLS, Kind.BALANCED}.isdisjoint(legend(picture_of(plain)))
    named = legend(picture_of(mixed))
    n, vase = len(mixed.force), int((mixed.body == "vase").sum())
    assert named[Kind.UNDECIDED] == f"undecided: {vase} of {n:,} ({100 * vase / n:.3g} %)"
    assert named[Kind.FALLS] == "falls without a push"
    assert Kind.BALANCED not in named
    balanced = retold(plain, plain.body == "book", FINITE)
    assert legend(picture_of(balanced))[Kind.BALANCED] == "moves at the smallest push (only balanced)"


def test_the_picture_shows_each_point_as_its_answer(mixed: hf.answers.RobustnessMap) -> None:
    picture = picture_of(mixed)
    shown = {surface.name: set(surface.kind.tolist()) for surface in picture.heat}
    assert shown["vase"] == {Kind.UNDECIDED}
    assert shown["cup"] == {Kind.FALLS}
    assert shown["book"] <= {Kind.FORCE, Kind.ENDLESS}
    scale = colours.scale_of(forces(picture))
    assert scale is not None
    assert scale.low > 0
    assert mixed.undecided.text in picture.subtitle
    assert REASON in picture.subtitle
    assert len(kinds(picture)) == len(mixed.force)


def test_arrows_point_at_decided_pushes_only(plain: hf.answers.RobustnessMap) -> None:
    """Bodies that fall come first in the ranking, but take no arrow from those that can be pushed."""
    fallen = retold(plain, plain.body != "book", UNSTABLE)
    assert [arrow.label.split(":")[0] for arrow in picture_of(fallen).weakest] == ["book"]
    assert picture_of(unknown(plain)).weakest == ()
    balanced = retold(plain, plain.body == "cup", FINITE)
    assert picture_of(balanced).weakest[0].label.startswith("cup: the smallest push")


def test_the_png_shows_each_kind_in_its_colour(
    plain: hf.answers.RobustnessMap, mixed: hf.answers.RobustnessMap, tmp_path: Path
) -> None:
    plain.save_png(tmp_path / "plain.png")
    mixed.save_png(tmp_path / "mixed.png")
    before, after = image_of(tmp_path / "plain.png"), image_of(tmp_path / "mixed.png")
    for colour in (colours.UNDECIDED, colours.FALLS):
        assert share_of(before, colour) < 1e-4
        assert share_of(after, colour) > 3e-3
    assert share_of(after, colours.UNDECIDED, 0.62) > 1e-3, "the lines of the hatching"
    assert share_of(after, colours.ZERO) < 1e-4, "nothing in the colour of force 0"


def test_a_map_without_any_answer_is_drawn_as_undecided(plain: hf.answers.RobustnessMap, tmp_path: Path) -> None:
    unknown(plain).save_png(tmp_path / "p.png")
    image = image_of(tmp_path / "p.png")
    assert share_of(image, colours.UNDECIDED) > 1e-2
    assert share_of(image, colours.ZERO) == 0


def test_the_page_lists_counts_and_tells_under_the_pointer(mixed: hf.answers.RobustnessMap, tmp_path: Path) -> None:
    mixed.save_html(tmp_path / "p.html")
    text = (tmp_path / "p.html").read_text()
    vase = int((mixed.body == "vase").sum())
    assert f"</i>undecided: {vase} of {len(mixed.force):,} (" in text
    assert "</i>falls without a push</label>" in text
    assert f'style="background:{colours.hex_of(colours.UNDECIDED)}"' in text
    header = re.search(r"<header>.*</header>", text, re.DOTALL)
    assert header is not None
    assert REASON in header.group()
    by_colour = {tuple(part["paint"][:3]): part["texts"] for part in faces(data_of(text))}
    undecided, falls = (tuple(np.rint(255 * np.array(c)).astype(int)) for c in (colours.UNDECIDED, colours.FALLS))
    hover = by_colour[undecided]
    assert len(hover) == vase
    assert all("undecided" in line and " 0 N" not in line for line in hover)
    assert all("falls" in line for line in by_colour[falls])


@pytest.fixture(scope="module")
def carried() -> hf.answers.TransportLimits:
    return hf.transport_limits(
        hf.assemble(shelf()), hf.assemble(shelf()).scene.horizontal_directions(24), engine="limit"
    )


def test_the_plot_hatches_undecided_sectors_and_never_draws_them_as_zero(
    carried: hf.answers.TransportLimits, tmp_path: Path
) -> None:
    found = retold(carried, slice(2, 8), UNDECIDED, notes=(REASON,))
    picture = polar_picture([found, carried], ["this", "other"])
    curve = picture.curves[0]
    assert (~curve.decided).sum() == 6
    assert picture.curves[1].decided.all()
    assert picture.undecided == f"6 of 24 undecided (25 %): {REASON}"
    least = carried.acceleration[np.r_[0:2, 8:24]].min()
    assert curve.lines[0].startswith(f"least {least:.3g} at ")
    assert curve.lines[-1] == "6 of 24 undecided (25 %)"
    axes = Figure().add_axes((0, 0, 1, 1), projection="polar")
    draw_curves(axes, picture)
    radii = np.concatenate([line.get_ydata() for line in axes.lines])
    assert np.isnan(radii).any()
    assert np.nanmin(radii) > 0
    found.save_png(tmp_path / "some.png")
    carried.save_png(tmp_path / "all.png")
    hatch = 0.8 * np.asarray(colours.UNDECIDED) + 0.2
    near = [
        float((np.abs(image_of(tmp_path / name) - hatch) < 0.06).all(-1).mean()) for name in ("some.png", "all.png")
    ]
    assert near[0] > 10 * near[1] + 1e-3


def test_plots_of_nothing_decided_and_of_something_only_balanced(
    carried: hf.answers.TransportLimits, tmp_path: Path
) -> None:
    nothing = unknown(carried)
    assert polar_picture([nothing]).curves[0].lines == ("24 of 24 undecided (100 %)",)
    nothing.save_png(tmp_path / "p.png")
    balanced = retold(carried, [5], FINITE)
    assert polar_picture([balanced]).curves[0].lines[0].startswith("least 0 (only balanced) at 75°")
    falling = retold(retold(carried, slice(None), UNSTABLE), [0], UNDECIDED)
    assert polar_picture([falling]).curves[0].lines == ("does not stand on the carrier", "1 of 24 undecided (4.17 %)")


def test_an_orange_on_the_shelf_is_never_painted_as_zero_because_it_is_unknown(tmp_path: Path) -> None:
    """The scene of finding U1: what the engine decides of it is its matter; what it does not is told."""
    found = hf.robustness_map(hf.assemble(shelf(orange())), ["orange", "cup"], spacing=0.03)
    picture = picture_of(found)
    unsure = int((kinds(picture) == Kind.UNDECIDED).sum())
    assert unsure == found.undecided.count == sum(status is UNDECIDED for status in found.status)
    assert bool(found.undecided.count) == ("undecided" in picture.subtitle.split("·", 1)[1])
    if found.undecided.count:
        assert found.undecided.reasons
    found.save_png(tmp_path / "p.png")
    assert (share_of(image_of(tmp_path / "p.png"), colours.UNDECIDED) > 1e-3) == (unsure > 0)
