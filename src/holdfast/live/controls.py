"""The controls beside the picture, in four tabs: the push, what is shown, edits, and answers with several states."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from holdfast.applications.disassembly.order import disassembly_order
from holdfast.applications.settled import settle
from holdfast.applications.transport import transport_limits
from holdfast.assembly.assembly import Assembly, assemble
from holdfast.base.text import LONGEST_NAME, escaped, one_line
from holdfast.live import scenery
from holdfast.live.edits import BodyPlace, place_of, pose_of, weighing
from holdfast.live.scenery import GROUPS, MAP, OPENING, SLIDING
from holdfast.live.steps import settling, taking_apart
from holdfast.live.window_model import STEEPEST, ViewModel
from holdfast.report.painter_list import glimpse

DIRECTIONS = 36  # level directions of the limits of transport
MARKED = (
    '<div style="padding:2px 22px;font-size:12px">contacts that '
    f'<span style="color:{OPENING}">●</span> open, <span style="color:{SLIDING}">●</span> slide</div>'
)
NO_STEPS = "no answer with several states"


class Controls:
    """The controls of a window. They call its methods when a user changes something."""

    def __init__(self, window: Any) -> None:  # noqa: ANN401 - a Window, whose module imports this one
        self._window = window
        self._model: ViewModel = window.model
        self._gui = window.server.gui
        self._undos = 0
        self.verdict = self._gui.add_html("")
        self.legend = self._gui.add_html("")
        self.busy = self._gui.add_html("")
        self.refused = self._gui.add_html("")
        tabs = self._gui.add_tab_group()
        for name, build in (
            ("Push", self._push),
            ("Show", self._show),
            ("Edit", self._edit),
            ("Answers", self._answers),
        ):
            with tabs.add_tab(name):
                build()

    @property
    def colour_by(self) -> str:
        """What the colours of the bodies show: MAP or GROUPS."""
        return str(self._colour.value)

    @property
    def body(self) -> str:
        """The name of the body that is selected for edits."""
        return str(self._body.value)

    def choose(self, name: str) -> None:
        """Select a body for edits."""
        self._set(self._body, name)

    def refresh(self) -> None:
        """Update all controls from the model."""
        self.verdict.content = scenery.verdict_html(self._model)
        self.legend.content = scenery.legend_html(self._model, self.colour_by)
        self._refresh_steps()
        self._refresh_body()
        self.refresh_push()

    def refresh_push(self) -> None:
        """Show the answer for the push, and set its sliders to the angles that were requested last."""
        self.push.content = scenery.push_html(self._model)
        turn, tilt = self._window.aim
        self._set(self._turn, turn)
        self._set(self._tilt, tilt)

    def _push(self) -> None:
        window = self._window
        self.push = self._gui.add_html("")
        self._tilt = self._gui.add_slider("lean [deg]", 0.0, STEEPEST, 1.0, 0.0)
        self._turn = self._gui.add_slider("towards [deg]", 0.0, 360.0, 1.0, 0.0)
        for slider in (self._tilt, self._turn):
            slider.on_update(self._heard(lambda: window.aimed(self._turn.value, self._tilt.value)))
        self.play = self._gui.add_checkbox("play the motion", False)
        self.play.on_update(lambda _: window.play(self.play.value))
        self._gui.add_html(MARKED)
        self.marks = self._gui.add_checkbox("mark contacts", True)
        self.marks.on_update(lambda _: window.worker.ask("draw push", window.draw_push))

    def _show(self) -> None:
        window = self._window
        self._colour = self._gui.add_dropdown("colours", (MAP, GROUPS), initial_value=MAP)
        self.surfaces = self._gui.add_checkbox("surfaces", True)
        self.contacts = self._gui.add_checkbox("contact patches", True)
        self.forces = self._gui.add_checkbox("contact forces", False)
        for control in (self._colour, self.surfaces, self.contacts, self.forces):
            control.on_update(lambda _: window.worker.ask("draw", window.draw))  # only the worker may read the model
        self._gui.add_button("save picture").on_click(lambda event: window.picture(event.client))

    def _edit(self) -> None:
        assembly = self._model.assembly
        self._body = self._gui.add_dropdown("body", tuple(body.name for body in assembly.movable) or ("",))
        self.drag = self._gui.add_checkbox("drag it in the picture", False)
        self._position = self._gui.add_vector3("position [m]", (0.0, 0.0, 0.0), step=0.001)
        self._turned = self._gui.add_vector3("turned [deg]", (0.0, 0.0, 0.0), step=0.1)
        self._mass = self._gui.add_number("mass [kg]", 1.0, min=1e-6, step=0.001)
        self._pair = self._gui.add_dropdown("between", self._pairs())
        self._mu = self._gui.add_number("friction", 0.5, min=0.0, step=0.01)
        self._body.on_update(self._heard(self._chosen))
        self.drag.on_update(self._heard(self._window.grip))
        self._pair.on_update(self._heard(self._refresh_body))
        for control in (self._position, self._turned):
            control.on_update(self._heard(self._moved))
        self._mass.on_update(self._heard(self._set_mass))
        self._mu.on_update(self._heard(self._set_friction))
        self._gui.add_button("undo").on_click(lambda _: self._undone())
        self._gui.add_button("as given").on_click(lambda _: self._changed("as given", lambda: self._model.given))

    def _answers(self) -> None:
        window = self._window
        self._step = self._gui.add_slider("state", 0, 100, 1, 0)
        self._said = self._gui.add_html("")
        self._step.on_update(self._heard(self._stepped))
        self._gui.add_button("settle").on_click(lambda _: window.request("settle", self._settle))
        self._gui.add_button("take apart").on_click(lambda _: window.request("take apart", self._take_apart))
        self._gui.add_button("limits of transport").on_click(lambda _: window.request("transport", self._transport))
        self.limits = self._gui.add_html("")

    def _heard(self, act: Callable[[], object]) -> Any:  # noqa: ANN401 - a function of viser's events
        """Return a listener to what a page says; changes that the program itself makes have no client.

        It is a coroutine, because viser runs these one after the other in the order of the messages, before the
        worker shows other values. Functions would run in several threads, and read what came after or before.
        """

        async def listener(event: Any) -> None:  # noqa: ANN401 - viser's own type
            if event.client is not None:
                act()

        return listener

    def _set(self, control: Any, value: Any) -> None:  # noqa: ANN401 - viser's controls and their values
        if not np.array_equal(control.value, value):
            control.value = value

    def _pairs(self) -> tuple[str, ...]:
        pairs = dict.fromkeys(one.bodies for one in self._model.assembly.interfaces)
        self._named = {f"{one_line(a, LONGEST_NAME)} - {one_line(b, LONGEST_NAME)}": (a, b) for a, b in pairs}
        return tuple(self._named) or ("",)

    def _refresh_body(self) -> None:
        assembly = self._model.assembly
        name = self._body.value
        if name in assembly.index:
            place = place_of(assembly, name)
            self._set(self._position, tuple(np.round(place.position, 9).tolist()))
            self._set(self._turned, tuple(np.round(place.turn, 9).tolist()))
            self._set(self._mass, assembly.scene.body(name).mass)
        pairs = self._pairs()
        if tuple(self._pair.options) != pairs:
            self._pair.options = pairs
        if self._pair.value in self._named:
            pair = self._named[self._pair.value]
            number = next(k for k, one in enumerate(assembly.interfaces) if one.bodies == pair)
            self._set(self._mu, float(assembly.mu[number]))

    def _chosen(self) -> None:
        """Show the values of the selected body and its drag handles."""
        self._refresh_body()
        self._set(self.drag, True)
        self._window.grip()

    def _changed(self, name: str, change: Callable[[], Assembly]) -> None:
        window = self._window
        window.edited(name, lambda: self._model.edit(change()))

    def _moved(self) -> None:
        name, place = self._body.value, BodyPlace(np.array(self._position.value), np.array(self._turned.value))
        self._changed(f"move {name}", lambda: self._model.assembly.moved({name: pose_of(place)}))

    def _set_mass(self) -> None:
        name, mass = self._body.value, float(self._mass.value)
        self._changed(f"weigh {name}", lambda: weighing(self._model.assembly, name, mass))

    def _set_friction(self) -> None:
        pair, mu = self._named.get(self._pair.value), float(self._mu.value)
        if pair is None:  # no two bodies touch, or no longer these
            return
        self._changed(f"friction of {pair}", lambda: self._model.assembly.with_friction({pair: mu}))

    def _undone(self) -> None:
        self._undos += 1  # jobs with equal names replace each other, so every undo has its own name
        self._window.edited(f"undo {self._undos}", self._model.undo)

    def _stepped(self) -> None:
        model = self._model
        model.step = min(int(self._step.value), max(len(model.steps) - 1, 0))
        self._refresh_steps()
        self._window.place()

    def _refresh_steps(self) -> None:
        model = self._model
        self._step.disabled = not model.steps
        self._step.max = max(len(model.steps) - 1, 1)
        self._set(self._step, model.step)
        text = escaped(model.state.text) if model.steps else NO_STEPS
        self._said.content = f'<div style="padding:2px 22px;font-size:13px">{text}</div>'

    def _settle(self) -> None:
        window = self._window
        result = settle(self._model.assembly.scene, engine=self._model.engine)
        self._model.edit(assemble(result.scene))
        self._model.show(settling(result))
        window.draw()
        window.ask()

    def _take_apart(self) -> None:
        window = self._window
        self._model.show(taking_apart(disassembly_order(self._model.assembly, engine=self._model.engine)))
        window.draw()

    def _transport(self) -> None:
        model = self._model
        ways = model.assembly.scene.horizontal_directions(DIRECTIONS)
        limits = transport_limits(model.assembly, ways, engine=model.engine)
        self.show_limits(glimpse(limits), limits.summary().headline)

    def show_limits(self, drawing: str, headline: str) -> None:
        """Show limits by direction as SVG, with a headline."""
        self.limits.content = f'<div style="padding:2px 22px;font-size:13px">{drawing}<br>{escaped(headline)}</div>'
