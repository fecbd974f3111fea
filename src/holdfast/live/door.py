"""The door of the page: who may come in, and what may be said there.

viser's server answers whoever reaches its port: pages of other hosts in the same browser, whose requests the browser
sends along, other users of this machine, and whatever they say. Here only who knows the address with its token comes
in, a page of another host never does, and what viser could not read is dropped.
"""

from __future__ import annotations

import hmac
import http
import logging
import math
import secrets
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, Final
from urllib.parse import urlsplit

from holdfast.base.errors import HoldfastError, message

TOKEN: Final = 24  # bytes of the token: nobody guesses them
HOSTS: Final = ("127.0.0.1", "localhost")  # by which this machine is asked: of another name, its owner says where it is
MOST_BYTES: Final = 32_000_000  # of a message: a picture of a large page
MOST_SAID: Final = 64_000  # bytes of any other: values of controls, places, directions
WAITING: Final = 4  # messages that wait to be read
PICTURE: Final = "GetRenderResponseMessage"
TURN: Final = "wxyz"  # quaternions, which no turn is without a length
SAID: Final[Mapping[str, Mapping[str, int | type]]] = {  # what a page says: kinds, and how many numbers; 0: one alone
    "GuiUpdateMessage": {"uuid": str, "updates": dict},
    "ScenePointerMessage": {"event_type": str, "ray_origin": 3, "ray_direction": 3, "screen_pos": list},
    "TransformControlsUpdateMessage": {"name": str, TURN: 4, "position": 3},
    "TransformControlsDragStartMessage": {"name": str},
    "TransformControlsDragEndMessage": {"name": str},
    "ViewerCameraMessage": {
        **{TURN: 4, "position": 3, "look_at": 3, "up_direction": 3},
        **dict.fromkeys(("fov", "near", "far", "image_height", "image_width"), 0),
    },
    PICTURE: {"payload": bytes, "render_uuid": str},
}

_opening = threading.Lock()


class Door:
    """Keeps the door of one server. ``control(uuid)`` returns the control of that name, None if there is none."""

    def __init__(self, control: Callable[[str], Any]) -> None:
        self.token = secrets.token_urlsafe(TOKEN)
        self._control = control
        self._kept = False

    @contextmanager
    def kept(self) -> Iterator[None]:
        """Have the server that viser starts in this block serve behind this door; raise HoldfastError if it does not.

        viser names neither its checks nor its limits as arguments, so what it calls to serve is replaced meanwhile.
        """
        from websockets.asyncio import server

        serve = server.serve

        def behind(handler: Callable[..., Any], *where: Any, **options: Any) -> Any:  # noqa: ANN401
            if not handler.__module__.startswith("viser."):  # of another thread of the program
                return serve(handler, *where, **options)
            self._kept = True
            return serve(handler, *where, **options | self._options(options["process_request"]))

        with _opening:
            server.serve = behind  # type: ignore[assignment, misc]
            try:
                yield
            finally:
                server.serve = serve  # type: ignore[misc]
        if not self._kept:
            remedy = "install viser 1.1, or tell the authors of holdfast"
            raise HoldfastError(message("the live view", "this version of viser cannot be guarded", remedy))

    def refused(self, path: str, headers: Any) -> str:  # noqa: ANN401 - of websockets
        """Return why a request is refused, "" if it is not."""
        host = headers.get("Host", "")
        if urlsplit(f"//{host}").hostname not in HOSTS:
            return "this is not the host that was asked for"
        origin = headers.get("Origin")
        if origin is not None and origin != f"http://{host}":
            return "pages of other hosts may not ask here"
        token = path.partition("?")[0].strip("/").partition("/")[0]
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            return "open the whole address that holdfast gave, with its token"
        return ""

    def understood(self, raw: Any) -> bool:  # noqa: ANN401 - whatever comes
        """Say whether a message is one that a page sends."""
        import msgspec
        from viser.infra import Message

        try:
            found = msgspec.msgpack.decode(raw)
            fields = SAID[found["type"]]
            if len(raw) > MOST_SAID and found["type"] != PICTURE:
                return False
            if not all(_fits(found.get(name), kind) for name, kind in fields.items()):
                return False
            Message.deserialize(raw)
        except Exception:  # of bytes from anybody; what viser cannot read it would tell by a traceback
            return False
        if TURN in fields and not 0.25 < sum(number * number for number in found[TURN]) < 4.0:
            return False
        return found["type"] != "GuiUpdateMessage" or self._settable(found["uuid"], found["updates"])

    def _settable(self, name: str, updates: Mapping[str, Any]) -> bool:
        """Say whether a control can take a new value."""
        control, value = self._control(name), updates.get("value")
        if control is None or updates.keys() != {"value"}:
            return False
        now = control.value
        if isinstance(now, bool):
            return isinstance(value, bool)
        if isinstance(now, str):
            return value in getattr(control, "options", ())
        if isinstance(now, tuple):
            return _fits(value, len(now))
        low, high = getattr(control, "min", None), getattr(control, "max", None)
        return _fits(value, 0) and (low is None or high is None or low <= value <= high)

    def _options(self, answer: Callable[..., Any]) -> dict[str, Any]:
        """Return what websockets is asked for instead of what viser asks."""
        from viser import __version__
        from websockets.asyncio.server import ServerConnection

        door = self

        class Connection(ServerConnection):
            """Drops what is not understood."""

            async def recv(self, decode: bool | None = None) -> Any:  # noqa: ANN401
                while True:
                    raw = await super().recv(decode)
                    if door.understood(raw):
                        return raw

        def asked(connection: Any, request: Any) -> Any:  # noqa: ANN401
            why = self.refused(request.path, request.headers)
            socket = "Upgrade" in request.headers
            if socket and request.headers.get("Sec-WebSocket-Protocol", "") != f"viser-v{__version__}":
                why = why or "this is another version of the page: load it again"
            if why:
                return connection.respond(http.HTTPStatus.FORBIDDEN, f"{why}\n")
            path = request.path.strip("/").removeprefix(self.token)
            found = answer(connection, replace(request, path=path or "/"))
            if found is not None:
                found.headers["Referrer-Policy"] = "no-referrer"
                found.headers["Cache-Control"] = "no-store"
            return found

        quiet = logging.getLogger("holdfast.live")
        quiet.addHandler(logging.NullHandler())
        quiet.propagate = False
        return {
            **{"process_request": asked, "create_connection": Connection, "logger": quiet},
            **{"max_size": MOST_BYTES, "max_queue": WAITING},
        }


def _fits(value: object, kind: int | type) -> bool:
    """Say whether a value is of a kind: of a type, one finite number (0), or a list of so many."""
    if isinstance(kind, type):
        return isinstance(value, kind)
    numbers = [value] if kind == 0 else value
    if not isinstance(numbers, list | tuple) or len(numbers) != max(kind, 1):
        return False
    return all(type(each) in (int, float) and math.isfinite(each) for each in numbers)
