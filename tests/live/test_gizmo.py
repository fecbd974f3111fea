"""Dragging a body in the picture, without a browser: the node is set as a page would set it, and the drag is told."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.live.window import Window
from holdfast.scene.shipped.blocks import box, floor

pytest.importorskip("viser", reason="needs viser: pip install 'holdfast-robotics[live]'")


class Event(NamedTuple):
    phase: str


def off_its_origin() -> hf.Body:
    """A cube of 0.1 m on the floor whose frame begins at (1, 0, 0), far from its middle at (0.3, 0, 0.05)."""
    mesh = trimesh.creation.box((0.1, 0.1, 0.1))
    mesh.apply_translation((-0.7, 0.0, 0.05))
    pose = np.eye(4)
    pose[0, 3] = 1.0
    return hf.Body("right", hf.Mesh(mesh.vertices, mesh.faces), mass=1.0, pose=pose)


@pytest.fixture
def scene() -> hf.Scene:
    return hf.Scene([floor(), box("left", (0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.05)), off_its_origin()], friction=0.5)


@pytest.fixture
def window(scene: hf.Scene) -> Iterator[Window]:
    with hf.view(scene, engine="limit", spacing=0.05, browser=False) as one:
        assert one._window.worker.rest()
        yield one._window


def choose(window: Window, name: str) -> None:
    window.controls._body.value = name
    window.controls._chosen()


def drag(window: Window, by: tuple[float, float, float], turn: tuple[float, float, float] = (0, 0, 0)) -> None:
    """Drag the gizmo by this much [m], and turn it [degrees], in two steps, and let go."""
    node = window.gizmo._node
    start = np.array(node.position)
    asyncio.run(window.gizmo._heard(Event("start")))
    for share in (0.5, 1.0):
        node.position = start + share * np.array(by)
        node.wxyz = np.roll(Rotation.from_euler("xyz", share * np.array(turn), degrees=True).as_quat(), 1)
        asyncio.run(window.gizmo._heard(Event("update")))


def let_go(window: Window) -> None:
    asyncio.run(window.gizmo._heard(Event("end")))
    assert window.worker.rest()


def pose(window: Window, name: str) -> np.ndarray:
    return window.model.assembly.scene.body(name).pose


def test_choosing_a_body_brings_the_arrows_to_its_middle(window: Window) -> None:
    assert window.gizmo._node is None, "nothing is in the way of clicks until it is asked for"
    choose(window, "right")
    assert window.gizmo._node.visible
    np.testing.assert_allclose(window.gizmo._node.position, [0.3, 0.0, 0.05], atol=1e-12)
    choose(window, "left")
    np.testing.assert_allclose(window.gizmo._node.position, [0.0, 0.0, 0.05], atol=1e-12)
    window.controls.drag.value = False
    window.grip()
    assert not window.gizmo._node.visible


def test_nothing_is_asked_until_the_body_is_let_go(window: Window) -> None:
    choose(window, "right")
    before = window.model.assembly
    drag(window, (0.05, 0.02, 0.0))
    assert window.worker.rest()
    assert window.model.assembly is before
    np.testing.assert_allclose(window._frames["right"].position, [0.05, 0.02, 0.0], atol=1e-12)
    let_go(window)
    np.testing.assert_allclose(pose(window, "right")[:3, 3], [1.05, 0.02, 0.0], atol=1e-12)
    np.testing.assert_array_equal(window._frames["right"].position, 0.0, err_msg="its surface is where it is now")
    np.testing.assert_allclose(window.gizmo._node.position, [0.35, 0.02, 0.05], atol=1e-12)
    assert window.controls._position.value == pytest.approx((1.05, 0.02, 0.0))
    assert "stands" in window.controls.verdict.content
    assert window.model.map is not None
    assert window.model.map.assembly is window.model.assembly


def test_a_body_turns_about_the_middle_of_the_arrows(window: Window) -> None:
    choose(window, "right")
    drag(window, (0.0, 0.0, 0.0), turn=(0.0, 0.0, 30.0))
    let_go(window)
    vertices = window.model.assembly.scene.body("right").surface_world.vertices
    np.testing.assert_allclose((vertices.min(axis=0) + vertices.max(axis=0)) / 2, [0.3, 0.0, 0.05], atol=1e-9)
    np.testing.assert_allclose(pose(window, "right")[:2, 0], [np.cos(np.pi / 6), np.sin(np.pi / 6)], atol=1e-12)
    assert window.controls._turned.value == pytest.approx((0.0, 0.0, 30.0))


def test_drags_follow_one_another_and_are_undone_one_by_one(window: Window) -> None:
    choose(window, "right")
    given = window.model.assembly
    drag(window, (0.05, 0.0, 0.0), turn=(0.0, 0.0, 90.0))
    let_go(window)
    once = pose(window, "right")
    drag(window, (0.0, 0.0, 0.2))
    let_go(window)
    np.testing.assert_allclose(pose(window, "right")[:3, 3], once[:3, 3] + [0, 0, 0.2], atol=1e-12)
    np.testing.assert_allclose(pose(window, "right")[:3, :3], once[:3, :3], atol=1e-12)
    assert "does not stand" in window.controls.verdict.content
    window.controls._undone()
    assert window.worker.rest()
    np.testing.assert_allclose(pose(window, "right"), once, atol=1e-12)
    assert "does not stand" not in window.controls.verdict.content
    window.controls._undone()
    window.controls._undone()
    assert window.worker.rest()
    assert window.model.assembly is given, "and there is nothing before it"
    np.testing.assert_allclose(window.gizmo._node.position, [0.3, 0.0, 0.05], atol=1e-12)


def test_a_body_dropped_into_another_is_undecided_and_says_why(window: Window) -> None:
    choose(window, "left")
    drag(window, (0.25, 0.0, 0.0))
    with pytest.warns(UserWarning, match="bodies overlap"):
        let_go(window)
    assert window.model.verdict is not None
    assert window.model.verdict.status is hf.Status.UNDECIDED
    assert "overlap" in window.controls.verdict.content


def test_a_drag_that_is_refused_leaves_the_body_where_it_was_and_says_why(scene: hf.Scene) -> None:
    """Where bodies touch is not known beside interfaces that were given."""
    given = hf.assemble(scene, interfaces=hf.assemble(scene).interfaces)
    with hf.view(given, engine="limit", spacing=0.05, browser=False) as live:
        window = live._window
        assert window.worker.rest()
        choose(window, "left")
        drag(window, (0.05, 0.0, 0.0))
        let_go(window)
        assert window.model.assembly is given
        assert "interfaces were given" in window.controls.refused.content
        assert window.gizmo.held == {}
        np.testing.assert_array_equal(window._frames["left"].position, 0.0)
        window.aimed(0.0, 0.0)
        assert window.controls.refused.content == ""


def test_a_click_on_a_body_chooses_it_and_a_press_without_a_drag_changes_nothing(window: Window) -> None:
    class Click(NamedTuple):
        ray_origin: tuple[float, float, float]
        ray_direction: tuple[float, float, float]

    before = window.model.assembly
    choose(window, "left")
    window._clicked(Click((1.0, 0.0, 0.02), (-1.0, 0.0, 0.0)))
    assert window.worker.rest()
    assert window.controls.body == "right"
    np.testing.assert_allclose(window.gizmo._node.position, [0.3, 0.0, 0.05], atol=1e-12)
    asyncio.run(window.gizmo._heard(Event("start")))
    let_go(window)
    assert window.model.assembly is before


def test_a_drag_that_goes_on_is_not_disturbed_by_answers_that_come(window: Window) -> None:
    choose(window, "left")
    drag(window, (0.05, 0.0, 0.0))
    window.draw()
    np.testing.assert_allclose(window.gizmo._node.position, [0.05, 0.0, 0.05], atol=1e-12)
    np.testing.assert_allclose(window._frames["left"].position, [0.05, 0.0, 0.0], atol=1e-12)
    window.controls._position.value = (-0.2, 0.0, 0.05)
    window.controls._moved()
    assert window.worker.rest()
    np.testing.assert_allclose(window.gizmo._node.position, [0.05, 0.0, 0.05], atol=1e-12, err_msg="another page typed")
    let_go(window)
    np.testing.assert_allclose(pose(window, "left")[:3, 3], [0.05, 0.0, 0.05], atol=1e-12)


def test_a_page_that_is_closed_lets_go_of_the_body_in_its_hand(window: Window) -> None:
    choose(window, "left")
    drag(window, (0.05, 0.0, 0.0))
    window._left(None)
    assert window.gizmo.held == {}
    np.testing.assert_array_equal(window._frames["left"].position, 0.0)


def test_a_body_that_is_not_shown_where_it_rests_has_no_arrows(window: Window) -> None:
    choose(window, "left")
    window.request("take apart", window.controls._take_apart)
    assert window.worker.rest()
    (leaving,) = window.model.steps[0].moved
    choose(window, leaving)
    assert not window.gizmo._node.visible
    choose(window, "left" if leaving == "right" else "right")
    assert window.gizmo._node.visible
