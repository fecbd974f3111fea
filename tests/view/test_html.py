"""HTML pages: self-contained, complete, and safe with any text."""

from __future__ import annotations

import base64
import builtins
import dataclasses
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from holdfast.base.errors import HoldfastError
from holdfast.view import colours
from holdfast.view.html import write_html
from holdfast.view.picture import Picture
from holdfast.view.soup import forces


def page(picture: Picture, folder: Path) -> str:
    path = folder / "page.html"
    write_html(picture, path)
    return path.read_text(encoding="utf-8")


def data_of(text: str) -> dict[str, Any]:
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', text, re.DOTALL)
    assert found
    return dict(json.loads(found.group(1)))


def unpack(packed: dict[str, str]) -> NDArray[Any]:
    return np.frombuffer(base64.b64decode(packed["bdata"]), dtype="<" + packed["dtype"])


def meshes(data: dict[str, Any]) -> list[dict[str, Any]]:
    return [trace for trace in data["traces"] if trace["type"] == "mesh3d"]


def test_nothing_is_loaded_over_the_network(table: Picture, tmp_path: Path) -> None:
    text = page(table, tmp_path)
    own = text.split("<script>")[0] + text[text.rindex('<script id="data"') :]
    assert "http" not in own.replace("http-equiv", "")
    assert 'src="http' not in text
    assert "default-src 'none'" in text
    assert not re.search(r"<(link|script|img|iframe)[^>]+(src|href)=", own)


def test_every_cell_has_its_hover_text_and_its_place_on_the_scale(table: Picture, tmp_path: Path) -> None:
    text = page(table, tmp_path)
    assert "R = 88.9 N" in text
    data = data_of(text)
    coloured = next(trace for trace in meshes(data) if "intensity" in trace)
    values, texts = forces(table), [t for surface in table.heat for t in surface.hover]
    finite = np.isfinite(values)
    assert coloured["cell_texts"] == [t for t, keep in zip(texts, finite, strict=True) if keep]
    scale = colours.scale_of(values)
    assert scale is not None
    expected = np.repeat(scale.position(values[finite]), coloured["cell_counts"])
    np.testing.assert_allclose(unpack(coloured["intensity"]), expected, atol=1e-6)
    assert len(unpack(coloured["x"])) == sum(coloured["cell_counts"])


def test_triangles_keep_their_corners(table: Picture, tmp_path: Path) -> None:
    data = data_of(page(table, tmp_path))
    coloured = next(trace for trace in meshes(data) if "intensity" in trace)
    points = np.stack([unpack(coloured[axis]) for axis in "xyz"], axis=1)
    faces = np.stack([unpack(coloured[corner]) for corner in "ijk"], axis=1)
    expected = [surface.vertices[surface.triangles[np.isfinite(surface.force)[surface.cell]]] for surface in table.heat]
    np.testing.assert_allclose(points[faces], np.concatenate(expected), atol=1e-6)


def test_there_are_few_traces_and_a_switch_for_each_part(blocks: Picture, tmp_path: Path) -> None:
    text = page(blocks, tmp_path)
    data = data_of(text)
    assert len(meshes(data)) == 4
    for name in ("fixed bodies", "contact patches", "contact forces at rest", "weakest pushes", "body edges"):
        assert f"</i>{name}</label>" in text
    numbers = [int(n) for found in re.findall(r'data-traces="([\d,]+)"', text) for n in found.split(",")]
    assert numbers == list(range(len(data["traces"])))


def test_infinite_and_zero_are_apart_from_the_scale(single: Callable[[float], Picture], tmp_path: Path) -> None:
    for value, colour in ((np.inf, colours.INFINITE), (0.0, colours.ZERO)):
        data = data_of(page(single(value), tmp_path))
        (mesh,) = meshes(data)
        assert mesh["color"] == colours.hex_of(colour)
        assert "coloraxis" not in data["layout"]


def test_a_single_cell_is_on_the_scale(single: Callable[[float], Picture], tmp_path: Path) -> None:
    data = data_of(page(single(4.0), tmp_path))
    np.testing.assert_allclose(unpack(meshes(data)[0]["intensity"]), 0.5)


def test_the_colour_bar_is_the_scale_of_the_png(table: Picture, tmp_path: Path) -> None:
    axis = data_of(page(table, tmp_path))["layout"]["coloraxis"]
    scale = colours.scale_of(forces(table))
    assert scale is not None
    assert [mark.label for mark in colours.ticks(scale)] == axis["colorbar"]["ticktext"]
    assert [colour for _, colour in axis["colorscale"]] == [colours.hex_of(rgb) for rgb in colours.TABLE]


def test_the_axis_box_frames_the_bodies_in_true_proportion(table: Picture, tmp_path: Path) -> None:
    scene = data_of(page(table, tmp_path))["layout"]["scene"]
    spans = np.array([np.ptp(scene[f"{axis}axis"]["range"]) for axis in "xyz"])
    np.testing.assert_allclose([scene["aspectratio"][axis] for axis in "xyz"], spans / spans.max())
    assert spans[0] < 2.5


def test_text_cannot_break_out_of_the_page(table: Picture, tmp_path: Path) -> None:
    nasty = "</script><script>alert(1)</script> $x & \u2028"
    heat = tuple(dataclasses.replace(surface, hover=(nasty,) * len(surface.hover)) for surface in table.heat)
    weakest = tuple(dataclasses.replace(arrow, label=nasty) for arrow in table.weakest)
    text = page(dataclasses.replace(table, title=nasty, subtitle=nasty, heat=heat, weakest=weakest), tmp_path)
    assert "<script>alert" not in text
    assert data_of(text)["traces"][0]["cell_texts"][0] == nasty


def test_nothing_to_show_is_still_a_page(tmp_path: Path) -> None:
    assert data_of(page(Picture("empty", "", (), ()), tmp_path))["traces"] == []


def test_a_failure_leaves_the_old_file(table: Picture, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text("old")
    broken = dataclasses.replace(table, up=np.array([0.0, np.nan, 1.0]))
    with pytest.raises(ValueError, match="JSON"):
        write_html(broken, path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_missing_plotly_is_explained(table: Picture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *more: object) -> object:
        if name.startswith("plotly"):
            raise ModuleNotFoundError(name)
        return real(name, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(HoldfastError, match=r"needs plotly.*pip install 'holdfast\[viewer\]'"):
        write_html(table, tmp_path / "page.html")
