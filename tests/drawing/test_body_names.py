"""Names in pictures: on their bodies, apart from each other, and axes that point as the world does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from holdfast.base.arrays import unit
from holdfast.drawing import canvas, map_png, panel_sheets
from holdfast.drawing.camera import View, front_view
from holdfast.drawing.canvas import PageBox, block, draw_axes, name_places
from holdfast.drawing.map_png import layout_of
from holdfast.drawing.panel_sheets import PointsPanel, sheet_png
from holdfast.drawing.picture import Picture, movable
from holdfast.drawing.render import render


def test_a_name_is_written_on_its_body_and_clear_of_what_is_there() -> None:
    seen = np.full((100, 200), -1)
    seen[20:80, 10:90], seen[20:80, 110:190] = 0, 1
    taken = np.zeros(seen.shape, dtype=bool)
    block(taken, 50, 150, 60, 20)
    found = {place.name: place for place in name_places(seen, [("left", 40, 12), ("right", 40, 12)], taken)}
    assert (found["left"].row, found["left"].column) == pytest.approx((50, 50), abs=2)
    right = found["right"]
    assert 110 < right.column < 190
    assert abs(right.row - 50) >= 10 + 6 - 1


def test_what_has_no_room_stays_without_a_name_and_names_do_not_overlap() -> None:
    seen = np.full((60, 120), -1)
    seen[10:50, 10:110], seen[28:32, 50:60] = 0, 1
    assert [
        place.name for place in name_places(seen, [("wide", 60, 12), ("tiny", 60, 12)], np.zeros(seen.shape, bool))
    ] == ["wide"]
    crowd = np.repeat(np.repeat(np.arange(12).reshape(3, 4), 20, axis=0), 30, axis=1)
    found = name_places(crowd, [(str(k), 26, 12) for k in range(12)], np.zeros(crowd.shape, bool))
    places = np.array([(place.row, place.column) for place in found])
    assert len(found) == 12
    for k, place in enumerate(places):
        off = np.abs(np.delete(places, k, axis=0) - place)
        assert ((off[:, 0] >= 12) | (off[:, 1] >= 26)).all()


def test_the_panel_knows_which_body_is_at_each_pixel(table: Picture) -> None:
    shot = layout_of(table, (1600, 1000)).shots[0]
    panel = render(movable(table, None), None, shot.camera, (shot.box.height, shot.box.width))
    rows, columns = np.nonzero(panel.body >= 0)
    world = shot.camera.world(np.column_stack([columns + 0.25, rows + 0.25, panel.depth[rows, columns]]))
    for number, surface in enumerate(table.heat):
        own = world[panel.body[rows, columns] == number]
        low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
        assert len(own) > 1000
        assert ((own > low - 0.01) & (own < high + 0.01)).all()
    assert ((panel.body >= 0) == np.isfinite(panel.depth)).all()


def test_every_body_of_a_picture_has_its_name(table: Picture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written: dict[str, int] = {}
    real = canvas.name_places

    def listening(*given: object) -> object:
        found = real(*given)  # type: ignore[arg-type]
        for place in found:
            written[place.name] = written.get(place.name, 0) + 1
        return found

    monkeypatch.setattr(canvas, "name_places", listening)
    map_png.write_png(table, tmp_path / "p.png")
    assert written.keys() == {"slab", "leg left", "leg right"}


def test_axes_point_as_the_view_sees_them(table: Picture) -> None:
    """Seen from above with x to the right, y points up the page and z at the viewer."""
    axes = Figure().add_axes((0, 0, 1, 1))
    draw_axes(axes, PageBox(0, 0, 400, 300), View(*np.eye(3)), 1.0)
    ends = {line.get_gid(): np.diff(line.get_xydata(), axis=0)[0] for line in axes.lines}
    assert ends["axis x"] == pytest.approx([30, 0])
    assert ends["axis y"] == pytest.approx([0, -30]), "rows count downwards"
    assert ends["axis z"] == pytest.approx([0, 0])
    view = front_view(table)
    other = Figure().add_axes((0, 0, 1, 1))
    draw_axes(other, PageBox(0, 0, 400, 300), view, 1.0)
    up = next(line for line in other.lines if line.get_gid() == "axis z").get_xydata()
    assert unit(np.diff(up, axis=0)[0]) == pytest.approx([0, -1])


def test_points_of_a_sheet_stay_in_their_panel(table: Picture, monkeypatch: pytest.MonkeyPatch) -> None:
    """Points on a fixed shelf far beside the bodies are shown in their own panel, not in its neighbour."""
    drawn = []
    real = panel_sheets.Writer

    class Listening(real):  # type: ignore[misc, valid-type]
        def __init__(self, *size: int) -> None:
            super().__init__(*size)
            drawn.append(self.axes)

    monkeypatch.setattr(panel_sheets, "Writer", Listening)
    far = np.array([[3.0, y, 0.0] for y in np.linspace(-2, 2, 9)])
    left = PointsPanel("points", table, far, np.tile([0.0, 0.0, 1.0], (9, 1)), np.ones(9))
    sheet_png([[left, PointsPanel("pose", table)]], "sheet", "", panel=(400, 300))
    (scatter,) = drawn[0].collections
    columns = scatter.get_offsets()[:, 0]
    assert len(columns)
    assert columns.min() > 26
    assert columns.max() < 26 + 400


def test_a_sheet_without_any_movable_body_is_drawn(table: Picture) -> None:
    """As before the first thing is put onto an empty shelf."""
    top = np.array([[0.5, 0.0, 0.0], [0.0, 0.5, 0.0]])
    bare = Picture("", "", (), table.solids)
    points = PointsPanel("points", bare, top, np.tile([0.0, 0.0, 1.0], (2, 1)), np.ones(2))
    assert sheet_png([[points]], "sheet", "").startswith(b"\x89PNG")
