"""Who may come in to the live view, and what may be said there: real sockets, no browser."""

from __future__ import annotations

import http.client
import random
import time
from collections.abc import Iterator
from contextlib import suppress
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest

import holdfast as hf
from holdfast.base.borders.worker import taken
from holdfast.scene.shipped.blocks import box, floor

pytest.importorskip("viser", reason="needs viser: pip install 'holdfast-robotics[live]'")
import msgspec
import viser
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1, 0, 0, 0],
    "position": [1, 1, 1.5],
    "fov": 0.8,
    "near": 0.01,
    "far": 1000,
    "image_height": 600,
    "image_width": 800,
    "look_at": [0, 0, 0],
    "up_direction": [0, 0, 1],
}


@pytest.fixture
def live() -> Iterator[hf.answers.LiveView]:
    bodies = [box(n, (0.1, 0.1, 0.1), 1.0, (x, 0.0, 0.05)) for n, x in (("left", 0.0), ("right", 0.3))]
    with hf.view(hf.Scene([floor(), *bodies], friction=0.5), engine="graph", spacing=0.05, browser=False) as one:
        assert one._window.worker.rest()
        yield one


def socket_of(live: hf.answers.LiveView, path: str | None = None, **options: Any) -> ClientConnection:
    """A web socket as the page opens it, from the address without its query, or at another path."""
    here = urlsplit(live.url)
    address = f"ws://127.0.0.1:{here.port}{here.path if path is None else path}"
    given = {
        "origin": f"http://127.0.0.1:{here.port}",
        "subprotocols": [f"viser-v{viser.__version__}"],
        "max_size": None,
    }
    return connect(address, **given | options)


def say(page: ClientConnection, **said: Any) -> None:
    page.send(msgspec.msgpack.encode(said))


def mass_of(live: hf.answers.LiveView) -> float:
    return live._window.model.assembly.scene.body("left").mass or 0.0


def uuid_of(control: Any) -> str:
    return str(control._impl.uuid)


def set_mass(live: hf.answers.LiveView, page: ClientConnection, mass: object) -> None:
    say(page, **CAMERA)
    say(page, type="GuiUpdateMessage", uuid=uuid_of(live._window.controls._mass), updates={"value": mass})


def waited_for(done: Any) -> bool:
    until = time.monotonic() + 10
    while not done() and time.monotonic() < until:
        time.sleep(0.02)
    return bool(done())


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://127.0.0.1:{port}", "http://127.0.0.1:1"])
def test_a_page_of_another_origin_does_not_come_in_though_it_knows_the_token(
    live: hf.answers.LiveView, origin: str
) -> None:
    with pytest.raises(InvalidStatus, match="403"):
        socket_of(live, origin=origin.format(port=urlsplit(live.url).port))


@pytest.mark.parametrize("path", ["", "/", "/wrong", "/index.html", "/?websocket=ws://a"])
def test_nobody_comes_in_without_the_token(live: hf.answers.LiveView, path: str) -> None:
    for origin in (None, f"http://127.0.0.1:{urlsplit(live.url).port}"):
        with pytest.raises(InvalidStatus, match="403"):
            socket_of(live, path, origin=origin)
    assert asked(live, path or "/")[0] == 403


def test_a_token_that_is_nearly_right_is_wrong(live: hf.answers.LiveView) -> None:
    token = urlsplit(live.url).path.strip("/")
    for wrong in (token[:-1], token[1:], token + "a", token[:-1] + ("b" if token[-1] == "a" else "a"), token[::-1]):
        assert asked(live, f"/{wrong}")[0] == 403
    assert asked(live, f"/{token}")[0] == 200


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1.evil.example", ""])
def test_another_name_of_this_machine_is_not_taken(live: hf.answers.LiveView, host: str) -> None:
    """A name that leads to 127.0.0.1 makes its page one of the same origin: DNS rebinding."""
    assert asked(live, urlsplit(live.url).path, host)[0] == 403
    upgrade = {
        "Upgrade": "websocket",
        "Connection": "Upgrade",
        "Origin": f"http://{host}",
        "Sec-WebSocket-Version": "13",
    }
    upgrade |= {"Sec-WebSocket-Key": "x" * 22 + "==", "Sec-WebSocket-Protocol": f"viser-v{viser.__version__}"}
    assert asked(live, urlsplit(live.url).path, host, **upgrade)[0] == 403


def asked(live: hf.answers.LiveView, path: str, host: str | None = None, **headers: str) -> tuple[int, bytes, Any]:
    port = urlsplit(live.url).port
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    connection.putrequest("GET", path, skip_host=True)
    for name, value in ({"Host": f"127.0.0.1:{port}" if host is None else host} | headers).items():
        connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    return answer.status, answer.read(), answer.headers


def test_the_page_is_served_at_the_address_with_the_token_alone(live: hf.answers.LiveView) -> None:
    path = urlsplit(live.url).path
    for known in (path, f"{path}/", f"{path}?websocket=ws://127.0.0.1/{path}"):
        status, content, headers = asked(live, known)
        assert (status, b'<div id="root">' in content) == (200, True)
        assert headers["Referrer-Policy"] == "no-referrer"
    assert asked(live, f"{path}/../../../../etc/passwd")[0] == 404
    assert asked(live, path, f"localhost:{9999}")[0] == 200, "by a tunnel of one's own"


def test_two_views_have_two_tokens(live: hf.answers.LiveView) -> None:
    with hf.view(hf.shipped_scene("cube"), engine="graph", browser=False) as other:
        assert urlsplit(other.url).path != urlsplit(live.url).path
        assert asked(live, urlsplit(other.url).path)[0] == 403


MALFORMED: list[Any] = [
    *("a text", b"", b"\xff" * 50, b"\x81" * 5000, msgspec.msgpack.encode([1, 2]), msgspec.msgpack.encode({"a": 1})),
    *({"type": None}, {"type": 3}, {"type": "NoMessage"}, {"type": []}, {"type": "GuiUpdateMessage"}),
    *({"type": "GuiUpdateMessage", "uuid": 3, "updates": {}}, {"type": "RemoveSceneNodeMessage", "name": "/bodies"}),
    *({**CAMERA, "wxyz": [0, 0, 0, 0]}, {**CAMERA, "position": [1, 2]}, {**CAMERA, "fov": float("nan")}),
    *({**CAMERA, "position": ["a", "b", "c"]}, {**CAMERA, "look_at": None}, {**CAMERA, "more": 1}),
    {"type": "FileTransferStartUpload", "source_component_uuid": "?", "transfer_uuid": "a", "filename": "a"},
    {"type": "ScenePointerMessage", "event_type": "click", "ray_origin": None, "ray_direction": None},
    {"type": "ScenePointerMessage", "event_type": "click", "ray_origin": [0, 0, 0], "ray_direction": [0, 0, 0]},
    {"type": "TransformControlsUpdateMessage", "name": "/drag", "wxyz": [0, 0, 0, 0], "position": [0, 0, 0]},
    {"type": "TransformControlsUpdateMessage", "name": "/drag", "wxyz": [1, 0, 0, 0], "position": [1e999, 0, 0]},
    {"type": "ShareUrlRequest"},
]
VALUES = ("", "no such", None, True, -1, 1e300, float("nan"), [1], [1, 2, 3], ["a", "b", "c"], {"a": 1}, b"a", 1 << 63)


def test_malformed_messages_change_nothing_and_print_nothing(
    live: hf.answers.LiveView, capfd: pytest.CaptureFixture[str], recwarn: pytest.WarningsRecorder
) -> None:
    """All that is not understood, and every control with values of every kind: no traceback, and it goes on."""
    controls, rng = live._window.controls, random.Random(7)
    inputs = [each for each in vars(controls).values() if hasattr(each, "on_update") and hasattr(each, "value")]
    assert len(inputs) >= 12
    with socket_of(live) as page:
        page.recv()
        say(page, **CAMERA)
        for said in MALFORMED:
            page.send(said if isinstance(said, str | bytes) else msgspec.msgpack.encode(said))
        updates = [(uuid_of(control), value) for control in inputs for value in VALUES]
        for uuid, value in rng.sample(updates, len(updates)):
            say(page, type="GuiUpdateMessage", uuid=uuid, updates={"value": value})
        say(page, type="GuiUpdateMessage", uuid=uuid_of(controls._mass), updates={"props": 1, "_impl": 2})
        for _ in range(50):
            page.send(rng.randbytes(rng.randrange(200)))
        set_mass(live, page, 3.0)
        assert waited_for(lambda: mass_of(live) == 3.0)
    assert live._window.worker.rest()
    said = capfd.readouterr()
    assert (said.out, said.err) == ("", "")
    assert [str(each.message) for each in recwarn if "viser" in str(each.message)] == []


def test_the_last_word_of_a_page_stands_while_earlier_ones_are_worked_on(live: hf.answers.LiveView) -> None:
    """An edit that ends shows the values of its own time; what was typed since then is not lost by it."""
    with socket_of(live) as page:
        page.recv()
        say(page, **CAMERA)
        for last in (20.0, 40.0, 60.0):
            for mass in np.arange(last - 19.0, last + 1.0):
                say(
                    page,
                    type="GuiUpdateMessage",
                    uuid=uuid_of(live._window.controls._mass),
                    updates={"value": float(mass)},
                )
                time.sleep(0.003)
            assert waited_for(lambda wanted=last: mass_of(live) == wanted and live._window.worker.rest())


def test_a_pair_that_is_not_there_any_more_rubs_nothing(live: hf.answers.LiveView) -> None:
    controls = live._window.controls
    controls._named = {}
    controls._set_friction()
    assert live._window.worker.rest()


def test_another_version_of_the_page_is_turned_away_in_silence(
    live: hf.answers.LiveView, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(InvalidStatus, match="403"):
        socket_of(live, subprotocols=["viser-v0.0.1"])
    assert capfd.readouterr() == ("", "")


def test_large_messages_take_no_memory(live: hf.answers.LiveView) -> None:
    """What is too large to be understood is dropped, and what is larger than any picture ends the connection."""
    name = uuid_of(live._window.controls._colour)
    with socket_of(live) as page:
        page.recv()
        before = taken("VmRSS")
        for _ in range(10):
            say(page, type="GuiUpdateMessage", uuid=name, updates={"value": "a" * 64_001})
        for k in range(10):
            with suppress(ConnectionClosed), socket_of(live) as other:
                say(other, type="GuiUpdateMessage", uuid=name, updates={"value": str(k) + "a" * 32_000_001})
                other.recv()
        set_mass(live, page, 5.0)
        assert waited_for(lambda: mass_of(live) == 5.0)
        if before:
            assert taken("VmRSS") - before < 128_000_000, "ours included, which made the messages"
