"""What the window draws and says, as plain arrays and texts."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.drawing import colours
from holdfast.live import scenery
from holdfast.live.scenery import GROUPS, MAP
from holdfast.live.window_model import ViewModel
from holdfast.scene.shipped.blocks import box, floor

DOWN = np.array([0.0, 0.0, -1.0])


@pytest.fixture(scope="module")
def standing() -> ViewModel:
    model = ViewModel(hf.assemble(hf.shipped_scene("stack")), engine="limit", spacing=0.03)
    model.ask_verdict()
    while not model.mapped:
        model.ask_map()
    return model


def falling() -> ViewModel:
    bodies = [box("steady", (0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.05)), box("over", (0.1, 0.1, 0.1), 1.0, (0.06, 0, 0.15))]
    apart = box("apart", (0.1, 0.1, 0.1), 1.0, (0.3, 0.0, 0.05))
    model = ViewModel(hf.assemble(hf.Scene([floor(), *bodies, apart], friction=0.5)), engine="limit")
    model.ask_verdict()
    return model


def test_the_map_is_on_the_bodies_in_the_colours_of_the_legend(standing: ViewModel) -> None:
    assert standing.map is not None
    scale = colours.scale_of(standing.map.force)
    expected = colours.colours(scale, standing.map.force)
    for body in scenery.bodies(standing, MAP):
        own = expected[standing.map.body == body.name]
        if len(own):
            shown = np.unique(np.round(body.rgb, 6), axis=0)
            allowed = np.unique(np.round([*own, colours.COVERED], 6), axis=0)
            assert {tuple(rgb) for rgb in shown} <= {tuple(rgb) for rgb in allowed}


def test_without_a_map_groups_have_colours_and_what_falls_that_of_falling() -> None:
    model = falling()
    rgb = {body.name: tuple(body.rgb[0]) for body in scenery.bodies(model, MAP)}
    assert rgb["steady"] == rgb["over"] == pytest.approx(colours.FALLS)
    assert rgb["apart"] != rgb["over"]
    assert rgb["floor"] == pytest.approx(colours.FIXED)
    assert "falls" in scenery.legend_html(model, MAP)
    fresh = ViewModel(model.assembly, engine="limit")
    assert len({tuple(body.rgb[0]) for body in scenery.bodies(fresh, GROUPS)}) == 3


def test_the_legend_has_the_marks_of_the_scale_in_newtons(standing: ViewModel) -> None:
    text = scenery.legend_html(standing, MAP)
    assert standing.map is not None
    scale = colours.scale_of(standing.map.force)
    assert scale is not None
    for mark in colours.ticks(scale):
        assert f"left:{100 * mark.position:.2f}%" in text
        assert mark.label in text
    assert "largest push [N]" in text


def test_the_arrow_ends_at_the_chosen_point_and_comes_from_outside(standing: ViewModel) -> None:
    assert scenery.push_arrow(ViewModel(standing.assembly, engine="limit")) == ()
    model = ViewModel(standing.assembly, engine="limit")
    assert model.choose(np.array([0.0, 0.0, 5.0]), DOWN)
    (arrow,) = scenery.push_arrow(model)
    assert arrow.head == pytest.approx([0, 0, 0.3])
    assert arrow.tail[2] > 0.3
    vertices, _, rgb = scenery.arrows_mesh((arrow,), model.assembly.size, "#14171c")
    assert rgb.shape == vertices.shape


def test_what_is_said_of_a_push(standing: ViewModel) -> None:
    model = ViewModel(standing.assembly, engine="limit")
    assert "Click a body" in scenery.push_html(model)
    assert model.choose(np.array([0.0, 0.0, 5.0]), DOWN)
    assert "computing" in scenery.push_html(model)
    model.ask_push()
    assert "an equilibrium exists" in scenery.push_html(model)
    assert model.choose(np.array([-1.0, 0.0, 0.05]), np.array([1.0, 0.0, 0.0]))
    model.ask_push()
    assert model.push is not None
    told = scenery.push_html(model)
    assert f"R = <b>{model.push.force[0]:.4g} N</b>" in told
    assert "proved to move above" in told
    assert "cube1" in told


def test_names_are_no_markup() -> None:
    scene = hf.Scene([floor(), box("<img src=x>", (0.1, 0.1, 0.1), 1.0, (0, 0, 0.05))], friction=0.5, name="<b>n</b>")
    model = ViewModel(hf.assemble(scene), engine="limit")
    model.ask_verdict()
    assert model.choose(np.array([-1.0, 0.0, 0.05]), np.array([1.0, 0.0, 0.0]))
    model.ask_push()
    for text in (scenery.push_html(model), scenery.verdict_html(model), scenery.legend_html(model, GROUPS)):
        assert "<img" not in text
        assert "<b>n</b>" not in text
