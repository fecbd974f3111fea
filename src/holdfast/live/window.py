"""The window: a page of viser that shows a model and handles clicks, drags and inputs.

The model computes, the scenery prepares what is drawn, and this module connects both with the controls.
"""

from __future__ import annotations

import contextlib
import io
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, Final

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.colour import rgb_of
from holdfast.base.errors import HoldfastError, installing, message
from holdfast.base.rigid import quaternion_of
from holdfast.base.text import escaped
from holdfast.drawing.camera import front_view
from holdfast.drawing.colours import CONTACT, FORCE_COLOUR, INK, before_film
from holdfast.drawing.edges import feature_edges
from holdfast.drawing.html_page import sides_of
from holdfast.drawing.map_files import lit_glb
from holdfast.drawing.picture import Arrow, Picture, Solid, soup_of
from holdfast.drawing.render import png_bytes
from holdfast.live import scenery
from holdfast.live.controls import Controls
from holdfast.live.edits import Gizmo
from holdfast.live.guard import Guard
from holdfast.live.steps import SWING, moved_by, parting
from holdfast.live.window_model import ViewModel
from holdfast.live.window_thread import Worker
from holdfast.report.map_picture import outlines_of, solids_of

HERE: Final = "127.0.0.1"  # the only address that the server listens on
FRAMES: Final = 30  # frames per second of the animation
PERIOD: Final = 2.0  # [s] period of the animation
HANDLES: Final = 0.6  # length of the drag handles, as a share of the body's diagonal
SHORTEST_HANDLES: Final = 0.08  # smallest length of the drag handles, as a share of the assembly's size
UNMOVED: Final = np.eye(4)  # the pose of a handle that nobody has dragged
Z_UP: Final = (0.5**0.5, 0.5**0.5, 0.0, 0.0)  # glTF has y up; this quaternion turns it to z


def server_at(port: int) -> tuple[Any, str]:
    """Return a server of viser's type, and the token that requests must have (guard.py).

    It listens on the loopback address only, and never opens a public tunnel. Raises HoldfastError if viser is not
    installed.
    """
    try:
        from viser import ViserServer
    except ImportError as error:
        problem = "needs viser, which is not installed"
        raise HoldfastError(message("the live view", problem, installing("live"))) from error

    class Local(ViserServer):  # type: ignore[misc, unused-ignore]
        def request_share_url(self, verbose: bool = True) -> None:
            """Do nothing: a page could otherwise request a public tunnel by a message."""

    servers: list[Any] = []
    guard = Guard(lambda name: servers[0].gui._gui_input_handle_from_uuid.get(name) if servers else None)
    with _silent(), guard.active():
        servers.append(Local(host=HERE, port=port, label="holdfast", verbose=False))
    return servers[0], guard.token


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """Suppress what viser prints, which it does even with ``verbose=False``."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


class Window:
    """Shows a model until it is closed.

    ``aim`` are the angles [degrees] that were requested last; the model may not have them yet.
    """

    def __init__(self, model: ViewModel, port: int) -> None:
        self.model = model
        self.server, self._token = server_at(port)
        self.worker = Worker(self._tell, self._refuse)
        self._lock = threading.RLock()
        self._frames: dict[str, Any] = {}
        self._playing = threading.Event()
        self._closed = threading.Event()
        self.aim = (0.0, 0.0)
        self._look()
        self.gizmo = Gizmo(self.server.scene, self._put, self._dropped)
        self.controls = Controls(self)
        self.server.scene.on_click()(self._clicked)
        self.server.on_client_disconnect(self._left)
        self.draw()
        threading.Thread(target=self._play, name="holdfast play", daemon=True).start()
        self.ask()

    @property
    def url(self) -> str:
        """The address of the page, with its token."""
        return f"http://{HERE}:{self.server.get_port()}/{self._token}"

    def close(self) -> None:
        """Stop the server and all computations."""
        self._closed.set()
        self._playing.set()
        self.worker.close()
        with _silent():
            self.server.stop()

    def ask(self) -> None:
        """Request the verdict and the map of the assembly on show, unless they are known."""
        if self.model.verdict is None:
            self.worker.ask("verdict", self._verdict)
        if not self.model.mapped:
            self.worker.ask("map", self._map, patient=True)

    def request(self, name: str, job: Callable[[], None]) -> None:
        """Run a job that a user requested, and clear the message of an earlier failure."""
        self._refuse("")
        self.worker.ask(name, job)

    def edited(self, name: str, change: Callable[[], None]) -> None:
        """Run a job that changes the model, and then request its answers again. A failed change has no effect.

        Of several waiting changes with the same name, only the newest is made.
        """

        def job() -> None:
            try:
                change()
            except HoldfastError:
                self.gizmo.back()
                self.place()
                raise
            self.draw()
            self.ask()

        self.request(name, job)

    def grip(self) -> None:
        """Show the drag handles at the selected body, if they are enabled and the body is drawn at its own pose."""
        name, state, assembly = self.controls.body, self.model.state, self.model.assembly
        with self._lock, self.server.atomic():
            if self.controls.drag.value and name in assembly.index and name not in state.hidden | state.moved.keys():
                body = assembly.scene.body(name)
                low, high = (end(body.surface_world.vertices, axis=0) for end in (np.min, np.max))
                length = max(HANDLES * float(np.linalg.norm(high - low)), SHORTEST_HANDLES * assembly.size)
                self.gizmo.show(name, body.pose, (low + high) / 2, length)
            else:
                self.gizmo.hide()

    def aimed(self, turn: float, tilt: float) -> None:
        """Aim the push and request its answer."""
        self.aim = (turn, tilt)

        def job() -> None:
            self.model.aim(turn, tilt)
            self.draw_push()
            self.model.ask_push()
            self.draw_push()

        self.request("push", job)

    def picture(self, client: Any) -> None:  # noqa: ANN401 - viser's own type
        """Send the current picture to the page that requested it, as a PNG file."""
        size = client.camera.image_height, client.camera.image_width
        image = np.asarray(client.get_render(*size, transport_format="png"), dtype=float)
        share = image[..., 3:] / 255.0
        flat = np.rint(image[..., :3] * share + 255.0 * (1.0 - share)).astype(np.uint8)
        client.send_file_download("holdfast.png", png_bytes(flat), save_immediately=True)

    def play(self, on: bool) -> None:
        """Start the animation of the mechanism, or stop it and draw the bodies at rest."""
        if on:
            self._playing.set()
        else:
            self._playing.clear()
            self.place()

    def draw(self) -> None:
        """Redraw everything."""
        with self._lock, self.server.atomic():
            self._draw_bodies()
            sides = sides_of(outlines_of(self.model.assembly)) if self.controls.contacts.value else np.empty((0, 2, 3))
            self._replace("/contacts", len(sides), partial(self._lines, points=sides, colour=CONTACT, width=3.0))
            forces = scenery.resting_forces(self.model) if self.controls.forces.value else ()
            self._arrows("/forces", forces, FORCE_COLOUR)
            self.draw_push()
            self.controls.refresh()
            self.grip()
            self.place()

    def draw_push(self) -> None:
        """Redraw the arrow of the push and the contacts that open or slide, and show its answer."""
        with self._lock, self.server.atomic():
            self._arrows("/push", scenery.push_arrow(self.model), INK)
            mechanism = self.model.mechanism
            opening, sliding = (np.empty((0, 3)),) * 2 if mechanism is None else parting(mechanism)
            shown = self.controls.marks.value and self.model.step == 0
            for name, points, colour in (("opening", opening, scenery.OPENING), ("sliding", sliding, scenery.SLIDING)):
                add = partial(
                    self.server.scene.add_point_cloud, points=points, colors=_bytes(colour),
                    point_size=0.012 * self.model.assembly.size, point_shape="circle", precision="float32",
                    point_shading="flat",
                )  # fmt: skip
                self._replace(f"/parting/{name}", len(points) if shown else 0, add)
            self.controls.refresh_push()

    def place(self, moved: dict[str, Float] | None = None) -> None:
        """Draw bodies at these transforms (4, 4), by default those of the state on show; a drag takes precedence."""
        with self._lock, self.server.atomic():
            state = self.model.state
            places = {**(state.moved if moved is None else moved), **self.gizmo.held}
            for name, frame in self._frames.items():
                frame.visible = name not in state.hidden
                self._put(name, places.get(name, UNMOVED))

    def _put(self, name: str, place: Float) -> None:
        """Draw a body at this transform (4, 4), world frame."""
        frame = self._frames[name]
        frame.wxyz = quaternion_of(place[:3, :3])
        frame.position = place[:3, 3]

    def _dropped(self, name: str, pose: Float) -> None:
        """Move a body to where it was dragged."""
        self.edited(f"move {name}", lambda: self.model.edit(self.model.assembly.moved({name: pose})))

    def _left(self, _: object) -> None:
        """Cancel the drag of a page that was closed."""
        self.gizmo.back()
        self.place()

    def _look(self) -> None:
        up, solids = self.model.assembly.scene.up, solids_of(self.model.assembly.movable or self.model.assembly.bodies)
        view = front_view(Picture("", "", (), solids, up=up))
        points = np.concatenate([solid.vertices for solid in solids])
        middle, size = (points.min(axis=0) + points.max(axis=0)) / 2, self.model.assembly.size
        self.server.scene.set_up_direction(tuple(up))
        camera = self.server.initial_camera
        camera.look_at = tuple(middle)
        camera.position = tuple(middle + 1.7 * size * view.toward)
        camera.up = tuple(up)
        camera.fov = np.deg2rad(45.0)
        camera.near = 0.01 * size
        self.server.gui.configure_theme(control_width="medium", show_logo=False, show_share_button=False)
        self.server.gui.main_panel.dock_right()  # beside the bodies: a floating panel covers them in a narrow window

    def _draw_bodies(self) -> None:
        numbers = {body.name: number for number, body in enumerate(self.model.assembly.bodies)}
        for body in scenery.bodies(self.model, self.controls.colour_by):
            number = numbers[body.name]
            # frames are never removed, because a page keeps the pose of a node that is added again
            if body.name not in self._frames:
                self._frames[body.name] = self.server.scene.add_frame(f"/bodies/{number}", show_axes=False)
            solid = Solid(body.name, body.vertices, body.triangles, fixed=False)
            edges = feature_edges(soup_of([solid], lambda _: (0.0, 0.0, 0.0)))
            content = lit_glb(body.vertices, body.triangles, before_film(body.rgb))
            shown = self.controls.surfaces.value
            self.server.scene.add_glb(f"/bodies/{number}/surface", content, wxyz=Z_UP, visible=shown)
            if len(edges):
                self._lines(f"/bodies/{number}/edges", edges, INK, 1.5)

    def _arrows(self, name: str, arrows: tuple[Arrow, ...], colour: str) -> None:
        vertices, triangles, rgb = scenery.arrows_mesh(arrows, self.model.assembly.size, colour)
        content = lit_glb(vertices, triangles, before_film(rgb)) if len(triangles) else b""
        self._replace(name, len(triangles), partial(self.server.scene.add_glb, glb_data=content, wxyz=Z_UP))

    def _lines(self, name: str, points: Float, colour: str, width: float) -> None:
        self.server.scene.add_line_segments(name, points, _bytes(colour), thickness=width, thickness_units="screen")

    def _replace(self, name: str, count: int, add: Callable[[str], Any]) -> None:
        """Add a node in place of the one of this name, or remove that one if there is nothing to add."""
        if count:
            add(name)
        elif self.server.scene.get_handle_by_name(name) is not None:
            self.server.scene.remove_by_name(name)

    def _clicked(self, event: Any) -> None:  # noqa: ANN401 - viser's own type
        self.aim = (0.0, 0.0)
        origin, ray = np.array(event.ray_origin), np.array(event.ray_direction)
        if not ray.any():  # no click gives this, but a message may hold it
            return

        def job() -> None:
            self.model.choose(origin, ray)
            if self.model.pick is not None:
                self.controls.choose(self.model.pick.body)
            self.controls.refresh()
            self.grip()
            self.draw_push()
            self.model.ask_push()
            self.draw_push()

        self.request("push", job)

    def _map(self) -> None:
        while not self.model.mapped:
            self.model.ask_map()
            with self._lock, self.server.atomic():  # a portion changes the colours and their legend alone
                self._draw_bodies()
                self.controls.refresh()

    def _verdict(self) -> None:
        self.model.ask_verdict()
        self.draw()

    def _tell(self, text: str) -> None:
        self.controls.busy.content = f'<div style="padding:2px 22px;font-size:12px">{escaped(text)}&nbsp;</div>'

    def _refuse(self, text: str) -> None:
        """Show what failed and why, until the next request."""
        said = f'<div style="padding:2px 22px;font-size:13px">&#9888; {escaped(text)}</div>'
        self.controls.refused.content = said if text else ""

    def _play(self) -> None:
        while True:
            self._playing.wait()
            if self._closed.is_set():
                return
            mechanism = self.model.mechanism
            if mechanism is not None:
                share = (1.0 - np.cos(2.0 * np.pi * time.monotonic() / PERIOD)) / 2.0
                self.place(moved_by(mechanism, share * SWING * self.model.assembly.size))
            time.sleep(1.0 / FRAMES)


def _bytes(colour: str) -> tuple[int, int, int]:
    """Return the red, green and blue components, in 0..255, of a colour "#rrggbb"."""
    red, green, blue = (round(255 * c) for c in rgb_of(colour))
    return red, green, blue
