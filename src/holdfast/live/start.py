"""Open a live view of a scene or an answer."""

from __future__ import annotations

import time
import webbrowser

from holdfast.applications.disassembly.order import Disassembly
from holdfast.applications.placement.result import Placement
from holdfast.applications.settled import Settled
from holdfast.applications.transport import TransportLimits
from holdfast.assembly.assembly import Assembly, assemble
from holdfast.base.arrays import checked_number, checked_truth
from holdfast.base.errors import HoldfastError, message
from holdfast.base.ranges import LENGTH
from holdfast.live.steps import ShownStep, places, settling, taking_apart
from holdfast.live.window import Window
from holdfast.live.window_model import ViewModel
from holdfast.queries.map import RobustnessMap
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice
from holdfast.report.painter_list import glimpse
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene

PORT = 8765  # default of the port that is tried first

Viewable = Scene | Assembly | RobustnessMap | Settled | TransportLimits | Disassembly | Placement


class LiveView:
    """A live view that is open at ``url`` until ``close`` or the end of the program.

    Only this machine can reach it, and only with the token in the address. It is a context manager. In a notebook, it
    is displayed in the cell.
    """

    def __init__(self, window: Window) -> None:
        self._window = window

    @property
    def url(self) -> str:
        """The address of the view on 127.0.0.1, with a port and a token that grants full access."""
        return self._window.url

    def wait(self) -> None:
        """Keep the view open until Ctrl-C."""
        while True:
            time.sleep(0.2)

    def close(self) -> None:
        """Close the view and stop its computations."""
        self._window.close()

    def __enter__(self) -> LiveView:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"LiveView({self.url})"

    def _repr_html_(self) -> str:
        return f'<iframe src="{self.url}" width="100%" height="600" style="border:0"></iframe>'


def view(
    what: Viewable,
    *,
    engine: EngineChoice = DEFAULT_ENGINE,
    spacing: float | None = None,
    port: int = PORT,
    browser: bool = True,
) -> LiveView:
    """Open a scene, an assembly or an answer in the browser, to turn it, push it and edit it.

    The page is served at 127.0.0.1 on the first free port from ``port`` on. Only this machine can reach it, and only
    with the token in its address; it makes no requests to other machines. ``browser`` opens it in the browser. The map
    of the bodies is computed by ``engine`` at points ``spacing`` [m] apart, by default a fiftieth of the size of the
    assembly, while the view is open; a RobustnessMap is shown as it is. The states of a Settled, a Disassembly or a
    Placement are selected by a slider, and TransportLimits are shown as a plot.

    Raises HoldfastError if viser, of the extra ``live``, is not installed, or if ``what`` is anything else.
    """
    _check(what)
    opened = checked_truth(browser, "view: browser")
    step = None if spacing is None else checked_number(spacing, "view: spacing", above=0, within=LENGTH)
    window = Window(_model(what, engine, step), port)
    if isinstance(what, TransportLimits):
        window.controls.show_limits(glimpse(what), what.summary().headline)
    if opened:
        webbrowser.open(window.url)
    return LiveView(window)


def _check(what: object) -> None:
    if not isinstance(what, Viewable):
        known = "a Scene, an Assembly, a RobustnessMap, a Settled, TransportLimits, a Disassembly or a Placement"
        raise HoldfastError(message("view", f"got a {type(what).__name__}", f"needs {known}"))


def _model(what: Viewable, engine: EngineChoice, spacing: float | None) -> ViewModel:
    """Return the model of what is viewed, with its map and its states."""
    known: RobustnessMap | None = None
    steps: tuple[ShownStep, ...] = ()
    match what:
        case Scene():
            assembly = assemble(what)
        case Assembly():
            assembly = what
        case RobustnessMap():
            assembly, known = what.assembly, what
        case TransportLimits():
            assembly = what.assembly
        case Settled():
            assembly, steps = assemble(what.scene), settling(what)
        case Disassembly():
            assembly, steps = what.assembly, taking_apart(what)
        case Placement():
            if what.map is None:
                raise HoldfastError(message("view of a placement", "there is no pose to show", what.reason))
            assembly, known, steps = what.map.assembly, what.map, places(what)
    refuse_holds(assembly.scene.holds, "view", "view the scene without them")
    model = ViewModel(assembly, engine=engine, spacing=spacing, known=known)
    model.show(steps)
    return model
