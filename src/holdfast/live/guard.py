"""Guard the server of the live view: which requests it accepts, and which messages.

viser's server answers anyone who reaches its port, for example pages of other hosts in the same browser and other users
of this machine. The guard requires the token of the address, refuses pages of other hosts, and drops messages that
viser could not read.
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

TOKEN: Final = 24  # number of random bytes of the token
HOSTS: Final = ("127.0.0.1", "localhost")  # accepted host names; another name could be an attack by DNS rebinding
MOST_BYTES: Final = 32_000_000  # largest size of a message, which may hold a picture of a large page
MOST_SAID: Final = 64_000  # largest size of any other message
WAITING: Final = 4  # largest number of messages in the queue
PICTURE: Final = "GetRenderResponseMessage"
TURN: Final = "wxyz"  # the field of a quaternion, which must not be zero
# accepted messages: the type of each field, or the number of numbers in it, where 0 means a single number
SAID: Final[Mapping[str, Mapping[str, int | type]]] = {
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


class Guard:
    """The guard of one server. ``control(uuid)`` returns the control with that name, or None."""

    def __init__(self, control: Callable[[str], Any]) -> None:
        self.token = secrets.token_urlsafe(TOKEN)
        self._control = control
        self._active = False

    @contextmanager
    def active(self) -> Iterator[None]:
        """Guard the server that viser starts in this block; raise HoldfastError if that fails.

        viser has no arguments for checks and limits, so the function by which it starts a server is replaced in this
        block.
        """
        from websockets.asyncio import server

        serve = server.serve

        def behind(handler: Callable[..., Any], *where: Any, **options: Any) -> Any:  # noqa: ANN401
            if not handler.__module__.startswith("viser."):  # a server of another thread of the program
                return serve(handler, *where, **options)
            self._active = True
            return serve(handler, *where, **options | self._options(options["process_request"]))

        with _opening:
            server.serve = behind  # type: ignore[assignment, misc]
            try:
                yield
            finally:
                server.serve = serve  # type: ignore[misc]
        if not self._active:
            remedy = "install viser 1.1, or tell the authors of holdfast"
            raise HoldfastError(message("the live view", "this version of viser cannot be guarded", remedy))

    def refused(self, path: str, headers: Any) -> str:  # noqa: ANN401 - websockets' own type
        """Return the reason why a request is refused, or "" if it is accepted."""
        host = headers.get("Host", "")
        if urlsplit(f"//{host}").hostname not in HOSTS:
            return "this server has another host name"
        origin = headers.get("Origin")
        if origin is not None and origin != f"http://{host}":
            return "pages of other hosts have no access"
        token = path.partition("?")[0].strip("/").partition("/")[0]
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            return "open the whole address that holdfast gave, with its token"
        return ""

    def understood(self, raw: Any) -> bool:  # noqa: ANN401 - any message
        """Return whether a message is one that a page of viser may send."""
        import msgspec
        from viser.infra import Message

        try:
            sent = msgspec.msgpack.decode(raw)
            fields = SAID[sent["type"]]
            if len(raw) > MOST_SAID and sent["type"] != PICTURE:
                return False
            if not all(_fits(sent.get(name), kind) for name, kind in fields.items()):
                return False
            Message.deserialize(raw)
        except Exception:  # the bytes are from anyone; viser would print a traceback
            return False
        if TURN in fields and not 0.25 < sum(number * number for number in sent[TURN]) < 4.0:
            return False
        return sent["type"] != "GuiUpdateMessage" or self._settable(sent["uuid"], sent["updates"])

    def _settable(self, name: str, updates: Mapping[str, Any]) -> bool:
        """Return whether a control accepts a new value."""
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
        """Return the options of the websockets server that replace those of viser."""
        from viser import __version__
        from websockets.asyncio.server import ServerConnection

        guard = self

        class Connection(ServerConnection):
            """A connection that drops messages that are not understood."""

            async def recv(self, decode: bool | None = None) -> Any:  # noqa: ANN401
                while True:
                    raw = await super().recv(decode)
                    if guard.understood(raw):
                        return raw

        def answered(connection: Any, request: Any) -> Any:  # noqa: ANN401
            why = self.refused(request.path, request.headers)
            socket = "Upgrade" in request.headers
            if socket and request.headers.get("Sec-WebSocket-Protocol", "") != f"viser-v{__version__}":
                why = why or "this is another version of the page: load it again"
            if why:
                return connection.respond(http.HTTPStatus.FORBIDDEN, f"{why}\n")
            path = request.path.strip("/").removeprefix(self.token)
            response = answer(connection, replace(request, path=path or "/"))
            if response is not None:
                response.headers["Referrer-Policy"] = "no-referrer"
                response.headers["Cache-Control"] = "no-store"
            return response

        quiet = logging.getLogger("holdfast.live")
        quiet.addHandler(logging.NullHandler())
        quiet.propagate = False
        return {
            **{"process_request": answered, "create_connection": Connection, "logger": quiet},
            **{"max_size": MOST_BYTES, "max_queue": WAITING},
        }


def _fits(value: object, kind: int | type) -> bool:
    """Return whether a value is of a type, or has the right number of finite numbers (0: a single number)."""
    if isinstance(kind, type):
        return isinstance(value, kind)
    numbers = [value] if kind == 0 else value
    if not isinstance(numbers, list | tuple) or len(numbers) != max(kind, 1):
        return False
    return all(type(each) in (int, float) and math.isfinite(each) for each in numbers)
