"""The page itself: who can reach it, what it draws, and that controls reach the model. Without a browser."""

from __future__ import annotations

import builtins
import json
import socket
import threading
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest

import holdfast as hf
from holdfast.base.errors import HoldfastError
from holdfast.scene.shipped.blocks import box, floor

MASS, MU, G = 1.0, 0.5, 9.81


def cubes() -> hf.Scene:
    bodies = [box(n, (0.1, 0.1, 0.1), MASS, (x, 0.0, 0.05)) for n, x in (("left", 0.0), ("right", 0.3))]
    return hf.Scene([floor(), *bodies], friction=MU)


def test_missing_viser_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *more: object) -> object:
        if name.startswith("viser"):
            raise ModuleNotFoundError(name)
        return real(name, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(HoldfastError, match=r"needs viser.*pip install 'holdfast-robotics\[live\]'"):
        hf.view(cubes(), browser=False)


def test_only_what_can_be_shown_is_taken() -> None:
    with pytest.raises(HoldfastError, match="got a int; needs a Scene"):
        hf.view(3, browser=False)  # type: ignore[arg-type]
    with pytest.raises(HoldfastError, match="spacing"):
        hf.view(cubes(), spacing=-1.0, browser=False)


@pytest.fixture
def live() -> Iterator[hf.answers.LiveView]:
    pytest.importorskip("viser", reason="needs viser: pip install 'holdfast-robotics[live]'")
    with hf.view(cubes(), engine="limit", spacing=0.05, browser=False) as one:
        assert one._window.worker.rest()
        yield one


def drawn(live: hf.answers.LiveView, name: str) -> Any:
    return live._window.server.scene.get_handle_by_name(name)


class Event:
    """A click as viser tells it."""

    def __init__(self, origin: tuple[float, float, float], ray: tuple[float, float, float]) -> None:
        self.ray_origin, self.ray_direction = origin, ray


def click_left(live: hf.answers.LiveView) -> None:
    live._window._clicked(Event((-1.0, 0.0, 0.02), (1.0, 0.0, 0.0)))
    assert live._window.worker.rest()


def test_it_is_served_to_this_machine_alone(live: hf.answers.LiveView) -> None:
    assert live.url.startswith("http://127.0.0.1:")
    port = urlsplit(live.url).port
    with urllib.request.urlopen(live.url) as page:
        assert page.status == 200
    assert listeners(port) == {"0100007F"}


def listeners(port: int) -> set[str]:
    """The addresses, as Linux writes them, on which this port is listened to: of 127.0.0.1 it is 0100007F."""
    tables = [Path("/proc/net/tcp"), Path("/proc/net/tcp6")]
    if not tables[0].exists():
        pytest.skip("needs the socket table of Linux")
    rows = [line.split() for table in tables if table.exists() for line in table.read_text().splitlines()[1:]]
    return {row[1].split(":")[0] for row in rows if row[3] == "0A" and int(row[1].split(":")[1], 16) == port}


def test_no_page_can_have_it_shared(live: hf.answers.LiveView) -> None:
    """What viser calls when a page sends its message for a public tunnel."""
    assert live._window.server.request_share_url() is None
    assert live._window.server._share_tunnel is None


def test_the_view_begins_above_the_bodies_and_turned_to_their_middle(live: hf.answers.LiveView) -> None:
    """Both cubes are within its 45 degrees; the floor, which is far larger, does not count."""
    camera = live._window.server.initial_camera
    middle = np.array([0.15, 0.0, 0.05])
    np.testing.assert_allclose(camera.look_at, middle, atol=1e-9)
    np.testing.assert_array_equal(camera.up, [0.0, 0.0, 1.0])
    away = np.array(camera.position) - middle
    assert away[2] > 0.3 * np.linalg.norm(away)
    radius = np.linalg.norm([0.2, 0.05, 0.05])
    assert radius < np.sin(np.deg2rad(22.5)) * np.linalg.norm(away) < 3.0 * radius


def test_verdict_and_map_come_by_themselves(live: hf.answers.LiveView) -> None:
    model, controls = live._window.model, live._window.controls
    assert model.verdict is not None
    assert model.map is not None
    assert "stands" in controls.verdict.content
    assert "largest push [N]" in controls.legend.content
    assert drawn(live, "/bodies/0/surface") is not None


def test_a_click_pushes_and_the_sliders_turn_the_push(live: hf.answers.LiveView) -> None:
    controls = live._window.controls
    click_left(live)
    assert f"R = <b>{MU * MASS * G:.4g} N</b>" in controls.push.content
    assert drawn(live, "/push") is not None
    assert drawn(live, "/parting/sliding") is not None
    live._window.aimed(0.0, 30.0)
    assert live._window.worker.rest()
    assert controls._tilt.value == 30.0
    assert f"R = <b>{MU * MASS * G:.4g} N</b>" not in controls.push.content


def test_a_slider_stays_where_it_was_dragged_while_older_angles_are_answered(live: hf.answers.LiveView) -> None:
    click_left(live)
    window = live._window
    began, go_on = threading.Event(), threading.Event()
    ask = window.model.ask_push

    def slow() -> None:
        began.set()
        go_on.wait(10)
        ask()

    window.model.ask_push = slow  # type: ignore[method-assign]
    window.aimed(0.0, 10.0)
    assert began.wait(10)
    window.aimed(0.0, 40.0)
    window.controls._tilt.value = 40.0
    window.draw_push()
    assert window.controls._tilt.value == 40.0
    go_on.set()
    assert window.worker.rest()
    assert window.model.tilt == window.controls._tilt.value == 40.0


def test_a_click_while_the_map_comes_goes_first_and_the_map_goes_on(live: hf.answers.LiveView) -> None:
    window = live._window
    window.model.edit(window.model.given)
    asked: list[str] = []
    ask_map = window.model.ask_map

    def ask() -> None:
        ask_map()
        asked.append(",".join(window.model.map.cells))  # type: ignore[union-attr]
        if len(asked) == 1:
            window._clicked(Event((-1.0, 0.0, 0.02), (1.0, 0.0, 0.0)))

    window.model.ask_map = ask  # type: ignore[method-assign]
    window.ask()
    assert window.worker.rest()
    assert asked == ["left", "left,right"]
    assert window.model.push is not None


def test_the_mechanism_moves_the_body_that_it_moves(live: hf.answers.LiveView) -> None:
    from holdfast.live.steps import moved_by

    click_left(live)
    window = live._window
    assert window.model.mechanism is not None
    window.place(moved_by(window.model.mechanism, 0.05))
    frames = window._frames
    along = 0.05 / np.hypot(1.0, MU)
    assert frames["left"].position == pytest.approx((along, 0.0, MU * along)), "limit: slides and rises by mu"
    assert tuple(frames["right"].position) == (0.0, 0.0, 0.0)
    window.play(on=False)
    assert tuple(frames["left"].position) == (0.0, 0.0, 0.0)


def test_edits_reach_the_model_and_the_verdict_follows(live: hf.answers.LiveView) -> None:
    window = live._window
    controls = window.controls
    controls._body.value, controls._position.value = "left", (0.0, 0.0, 0.2)
    controls._moved()
    assert window.worker.rest()
    assert "does not stand" in controls.verdict.content
    assert "falls" in controls.legend.content
    controls._changed("as given", lambda: window.model.given)
    assert window.worker.rest()
    assert "<b>scene stands</b>" in controls.verdict.content
    assert controls._position.value == pytest.approx((0.0, 0.0, 0.05))


def test_a_body_keeps_its_node_whatever_its_colours_say(live: hf.answers.LiveView) -> None:
    """The map and the groups list bodies in another order."""
    window = live._window
    names = [body.name for body in window.model.assembly.bodies]
    for colours in ("groups", "largest push"):
        window.controls._colour.value = colours
        window.draw()
        for number, name in enumerate(names):
            surface = window.model.assembly.scene.body(name).surface_world.vertices
            content = drawn(live, f"/bodies/{number}/surface").glb_data
            assert low_and_high(content) == pytest.approx(
                np.array([surface.min(axis=0), surface.max(axis=0)]), abs=1e-6
            )


def low_and_high(glb: bytes) -> np.ndarray:
    """The ends of the places in a binary glTF file, before its node turns them."""
    header = json.loads(glb[20 : 20 + int.from_bytes(glb[12:16], "little")])
    ends = next(one for one in header["accessors"] if "min" in one)
    return np.array([ends["min"], ends["max"]])


def test_steps_move_and_hide_bodies_until_an_edit(live: hf.answers.LiveView) -> None:
    window = live._window
    window.worker.ask("take apart", window.controls._take_apart)
    assert window.worker.rest()
    first = window.model.steps[0]
    (leaving,) = first.moved
    assert window._frames[leaving].position[2] > 0.01
    window.controls._step.value = 2
    window.controls._stepped()
    assert not window._frames["left"].visible
    assert "nothing is left" in window.controls._said.content
    window.edited("as given", lambda: window.model.edit(window.model.given))
    assert window.worker.rest()
    assert window._frames["left"].visible
    assert np.allclose(window._frames[leaving].position, 0.0)


def test_answers_open_with_their_states(live: hf.answers.LiveView) -> None:
    scene = cubes()
    answers = [
        hf.assemble(scene),
        hf.robustness_map(scene, spacing=0.05, engine="graph"),
        hf.settle(scene, engine="limit"),
        hf.disassembly_order(scene, engine="limit"),
        hf.plan_placement(
            hf.Scene([floor()], friction=MU), box("cube", (0.1, 0.1, 0.1), 1.0, (0, 0, 0.3)), search=hf.Search(seed=1)
        ),
        hf.transport_limits(scene, engine="graph"),
    ]
    for answer in answers:
        with hf.view(answer, engine="graph", spacing=0.05, browser=False) as one:
            assert one.url != live.url
            assert one._window.worker.rest()
            model = one._window.model
            assert bool(model.steps) == isinstance(
                answer, hf.answers.Settled | hf.answers.Disassembly | hf.answers.Placement
            )
            assert ("<svg" in one._window.controls.limits.content) == isinstance(answer, hf.answers.TransportLimits)
            if isinstance(answer, hf.answers.RobustnessMap):
                assert model.map is answer


def test_a_notebook_shows_it_in_the_cell(live: hf.answers.LiveView) -> None:
    assert f'src="{live.url}"' in live._repr_html_()
    assert live.url in repr(live)


def test_closing_frees_the_port(live: hf.answers.LiveView) -> None:
    port = urlsplit(live.url).port
    live.close()
    with pytest.raises(OSError, match=r".*"), socket.create_connection(("127.0.0.1", port), timeout=2):
        pass
