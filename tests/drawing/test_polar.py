"""The polar plot: a picture comes out of every kind of answer, and it shows what it is given."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import holdfast as hf
from holdfast.drawing.plots import draw_curves
from holdfast.report.carrier_report import level_angles, polar_picture, save_polar
from holdfast.scene.shipped import shipped_scene

matplotlib_image = pytest.importorskip("matplotlib.image")


def limits(name: str, count: int = 24, tilt: Any = (0, 0, 0), **options: Any) -> hf.answers.TransportLimits:
    assembly = hf.assemble(shipped_scene(name)).tilted(tilt)
    return hf.transport_limits(assembly, assembly.scene.horizontal_directions(count), engine="limit", **options)


def test_the_curve_is_the_answer() -> None:
    result = limits("slope")
    picture = polar_picture([result])
    (curve,) = picture.curves
    assert curve.angle == pytest.approx(np.arange(24) * np.pi / 12)
    assert curve.radius == pytest.approx(result.acceleration)
    assert picture.axes == ("+x", "+y", "−x", "−y")
    assert curve.lines[0].startswith("least 3.27 at 90°, topple: cube1")
    wedge = next(f for f in picture.footprints if not f.fixed)
    assert wedge.outline.min(0) == pytest.approx([-0.05, -0.15])
    assert wedge.outline.max(0) == pytest.approx([0.05, 0.15])


def test_the_names_of_directions_stand_at_their_angles() -> None:
    """Anticlockwise from +x on the right, so that +y is up the page."""
    axes = Figure().add_axes((0, 0, 1, 1), projection="polar")
    draw_curves(axes, polar_picture([limits("slope", 8)]))
    names = [label.get_text() for label in axes.get_xticklabels()]
    assert np.degrees(axes.get_xticks()) == pytest.approx(30 * np.arange(12))
    assert names[::3] == ["+x", "+y", "−x", "−y"]
    assert (names[1], names[11]) == ("30°", "330°")
    assert (axes.get_theta_direction(), axes.get_theta_offset()) == (1, 0)


def test_a_dot_lies_where_its_direction_points(tmp_path: Path) -> None:
    """Down (270 degrees) reaches far, up does not: crimson pixels lie low on the page."""
    save_polar(limits("slope"), tmp_path / "p.png")
    image = matplotlib_image.imread(BytesIO((tmp_path / "p.png").read_bytes()))
    assert image.shape[:2] == (900, 1340)
    crimson = np.abs(image[:, :790, :3] - np.array([0xB5, 0x17, 0x3F]) / 255).max(2) < 0.02
    rows, _ = np.nonzero(crimson)
    centre = 130 + 660 / 2
    assert centre - rows.min() < 0.5 * (rows.max() - centre)


@pytest.mark.parametrize("tilt", [(3, 6, 0), (70, 0, 0)])
def test_every_kind_of_answer_can_be_drawn(tilt: tuple[float, float, float], tmp_path: Path) -> None:
    result = limits("table", 8, tilt=tilt)
    picture = polar_picture([result, result], ["one", "two"])
    assert picture.axes == ("0°", "90°", "180°", "270°")
    assert [curve.name for curve in picture.curves] == ["one", "two"]
    save_polar(result, tmp_path / "p.png", others=[result])
    assert (tmp_path / "p.png").stat().st_size > 10_000


def test_endless_answers_reach_the_rim(tmp_path: Path) -> None:
    held = hf.Load("cube", (0, 0, 0.1), force=(0, 0, -1))
    result = limits("wedged_floor", 8, standing=[held])
    assert np.isinf(result.acceleration).all()
    save_polar(result, tmp_path / "p.png")
    assert polar_picture([result]).curves[0].lines == ("however fast: an equilibrium exists",)


def test_directions_off_the_level_have_no_angle() -> None:
    assembly = hf.assemble(shipped_scene("cube"))
    with pytest.raises(hf.HoldfastError, match="not level"):
        level_angles(hf.transport_limits(assembly, (1, 0, 0.1), engine="graph"))
    with pytest.raises(hf.HoldfastError, match="no answers"):
        polar_picture([])
