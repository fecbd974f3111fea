"""HTML pages: self-contained, complete, small, and safe with any text."""

from __future__ import annotations

import base64
import dataclasses
import hashlib
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
from paged import data_of, faces, said, triples

import holdfast as hf
from holdfast.drawing import colours
from holdfast.drawing.html_page import page_of
from holdfast.drawing.picture import Picture, forces

LARGEST = 1.5e6  # of the page of a map as the command writes it [bytes]


def test_nothing_is_loaded_over_the_network(table: Picture) -> None:
    text = page_of(table)
    assert "http" not in text.replace("http-equiv", "")
    assert "default-src 'none'" in text
    assert not re.search(r"<(link|script|img|iframe)[^>]+(src|href)=", text)


def test_only_the_page_s_own_script_may_run(table: Picture) -> None:
    """The policy names its hash: what a name might smuggle in stays a text."""
    text = page_of(table)
    allowed = re.search(r"script-src 'sha256-([^']+)'", text)
    scripts = re.findall(r"<script>(.*?)</script>", text, re.DOTALL)
    assert allowed
    assert len(scripts) == 1
    assert base64.b64decode(allowed.group(1)) == hashlib.sha256(scripts[0].encode()).digest()
    assert "unsafe" not in text.replace("style-src 'unsafe-inline'", "")


def test_every_cell_has_its_hover_text_and_its_colour(table: Picture) -> None:
    coloured = faces(data_of(page_of(table)))[0]
    values = forces(table)
    texts = np.array([text for surface in table.heat for text in surface.hover])
    finite = np.isfinite(values)
    assert coloured["texts"] == texts[finite].tolist()
    assert any("R = 88.9 N" in text for text in coloured["texts"])
    expected = np.rint(255 * colours.colours(colours.scale_of(values), values[finite]))
    np.testing.assert_array_equal(coloured["paint"].reshape(-1, 4)[:, :3], expected)


def test_cells_keep_their_corners(table: Picture) -> None:
    """Each triangle of the page is a triangle of the surface, and belongs to the cell at whose point it lies."""
    data = data_of(page_of(table))
    coloured = faces(data)[0]
    drawn = triples(coloured["vertices"])[triples(coloured["triangles"])]
    expected = [surface.vertices[surface.triangles[np.isfinite(surface.force)[surface.cell]]] for surface in table.heat]
    np.testing.assert_allclose(drawn, np.concatenate(expected), atol=1e-6)
    points = np.concatenate([surface.points[np.isfinite(surface.force)] for surface in table.heat])
    owner = coloured["cell"][triples(coloured["triangles"])]
    assert (owner == owner[:, :1]).all()
    off = np.linalg.norm(drawn.mean(axis=1) - points[owner[:, 0]], axis=1)
    assert off.max() < 0.05, "cells are 0.05 m wide"


def test_there_is_a_switch_for_each_layer_and_one_surface_for_all_bodies(table: Picture) -> None:
    text = page_of(table)
    data = data_of(text)
    assert [len(layer["parts"]) for layer in data["layers"]] == [1, 1, 2, 1, 2, 1, 1]
    for name in ("fixed bodies", "contact patches", "contact forces at rest", "weakest pushes", "body edges"):
        assert f"</i>{name}</label>" in text
    assert re.findall(r'data-layer="(\d+)"', text) == [str(k) for k in range(len(data["layers"]))]


def test_infinite_and_zero_are_apart_from_the_scale(single: Callable[[float], Picture]) -> None:
    for value, colour in ((np.inf, colours.INFINITE), (0.0, colours.ZERO)):
        text = page_of(single(value))
        (part,) = faces(data_of(text))
        np.testing.assert_array_equal(part["paint"][:3], np.rint(255 * np.array(colour)))
        assert 'id="scale"' not in text


def test_undecided_cells_are_hatched_and_no_others(table: Picture) -> None:
    slab, *legs = table.heat
    unknown = np.full(len(slab.force), colours.Kind.UNDECIDED)
    parts = faces(data_of(page_of(dataclasses.replace(table, heat=(dataclasses.replace(slab, kinds=unknown), *legs)))))
    hatched = [set(part["paint"].reshape(-1, 4)[:, 3].tolist()) for part in parts]
    colour = np.rint(255 * np.array(colours.UNDECIDED)).tolist()
    assert [marks == {1} for marks in hatched] == [part["paint"][:3].tolist() == colour for part in parts]
    assert {1} in hatched


def test_the_colour_bar_is_the_scale_of_the_png(table: Picture) -> None:
    text = page_of(table)
    scale = colours.scale_of(forces(table))
    assert scale is not None
    marks = re.findall(r'<span style="left:([\d.]+)%">([^<]+)</span>', text)
    expected = colours.ticks(scale)
    assert [label for _, label in marks] == [mark.label for mark in expected]
    np.testing.assert_allclose([float(place) for place, _ in marks], [100 * m.position for m in expected], atol=0.01)
    bar = re.search(r'id="bar" style="background:linear-gradient\(90deg,([^)]+)\)', text)
    assert bar
    stops = bar.group(1).split(",")
    assert stops == [colours.hex_of(colours.sample(k / (len(stops) - 1))) for k in range(len(stops))]
    assert "largest push [N]" in text


def test_the_camera_sees_all_that_has_a_colour(table: Picture) -> None:
    """The few points that the page comes near to reach as far in every direction as all others."""
    data = data_of(page_of(table))
    shown = triples(data["shown"])
    points = np.concatenate([surface.vertices for surface in table.heat])
    np.testing.assert_allclose(data["bounds"], [points.min(axis=0), points.max(axis=0)])
    for way in np.random.default_rng(3).normal(size=(50, 3)):
        assert (shown @ way).max() > (points @ way).max() - 0.02 * np.linalg.norm(way)


def test_text_cannot_break_out_of_the_page(table: Picture) -> None:
    nasty = "</script><script>alert(1)</script> $x & \u2028"
    heat = tuple(dataclasses.replace(surface, hover=(nasty,) * len(surface.hover)) for surface in table.heat)
    weakest = tuple(dataclasses.replace(arrow, label=nasty) for arrow in table.weakest)
    text = page_of(dataclasses.replace(table, title=nasty, subtitle=nasty, heat=heat, weakest=weakest))
    assert "<script>alert" not in text
    assert said(data_of(text))[0] == nasty


def test_nothing_to_show_is_still_a_page() -> None:
    assert data_of(page_of(Picture("empty", "", (), ())))["layers"] == []


def test_the_page_of_a_map_is_small(tmp_path: Path) -> None:
    """As the command makes it, with 4,500 pushes; version 0.1 wrote 8.7 MB."""
    found = hf.robustness_map(hf.assemble(hf.shipped_scene("table")), engine="graph")
    found.save_html(tmp_path / "map.html")
    assert len(found.force) > 4000
    assert (tmp_path / "map.html").stat().st_size < LARGEST / 5


def test_a_corner_that_triangles_of_a_cell_share_is_in_the_page_once(table: Picture) -> None:
    coloured = faces(data_of(page_of(table)))[0]
    corners = np.column_stack([triples(coloured["vertices"]), coloured["cell"]])
    assert len(np.unique(corners, axis=0)) == len(corners)
    assert len(corners) < len(coloured["triangles"])
    of_triangle = coloured["cell"][triples(coloured["triangles"])]
    assert (of_triangle == of_triangle[:, :1]).all(), "no triangle lies in two cells"
