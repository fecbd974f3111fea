"""Log scenes and answers to Rerun: bodies, contacts, forces and pushes, and how bodies move along a timeline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holdfast.applications.carrying.carry import Carried
from holdfast.applications.disassembly.order import Disassembly
from holdfast.applications.placement.result import Placement, Placements
from holdfast.applications.resting_poses import RestingPoses
from holdfast.applications.settled import Settled
from holdfast.applications.transport import TransportLimits
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import checked_name
from holdfast.base.colour import rgb_of
from holdfast.base.errors import HoldfastError, installing, message
from holdfast.base.public import number
from holdfast.base.text import listed, one_line
from holdfast.drawing import colours
from holdfast.drawing.colours import CONTACT, FORCE_COLOUR, INK, Kind
from holdfast.drawing.edges import FORCE_RADIUS, PUSH_RADIUS
from holdfast.drawing.map_files import Painted, painted
from holdfast.drawing.picture import Arrow, Picture, ends_of, forces, kinds, legend, size_of
from holdfast.engines.mechanism import Mechanism
from holdfast.engines.verdict import ContactForces
from holdfast.live.steps import BETWEEN, SWING, ShownStep, moved_by, places, placing, resting, settling, taking_apart
from holdfast.queries.map import RobustnessMap
from holdfast.queries.push import Robustness
from holdfast.queries.result import gives_way
from holdfast.queries.stability import Stability
from holdfast.report.map_picture import WEAK_ARROW, bare_picture, force_arrows, outlines_of, picture_of, solids_of
from holdfast.scene.scene import Scene

STEP, TIME = "step", "time"  # the timelines: of states that are counted, and of a motion of the carrier in seconds

Loggable = (
    Scene | Assembly | Stability | Robustness | RobustnessMap | TransportLimits | Carried | Settled | Disassembly
    | Placement | Placements | RestingPoses
)  # fmt: skip


class Moment(NamedTuple):
    """One place on the timeline: a number of a step or a time [s], the state there, and values to plot by name."""

    when: float
    step: ShownStep
    values: dict[str, float]


class LoggedContent(NamedTuple):
    """What is logged: the ``picture``, and the ``moments`` of the ``timeline``, if there are any."""

    picture: Picture
    moments: Sequence[Moment] = ()
    timeline: str = STEP


def log_to_rerun(answer: Loggable, *, entity: str = "holdfast", recording: Any = None) -> None:  # noqa: ANN401 - rerun's
    """Log a scene, an assembly or an answer to Rerun, below the path ``entity``.

    It goes to the current recording of Rerun, or to ``recording``, a ``rerun.RecordingStream``. The bodies are meshes
    in the colours of the map, beside contact patches and nodes, contact forces at rest, the weakest pushes and the
    points of the map with their forces. What moves is a transform of the body along the timeline "step": the mechanism,
    enlarged to 8 % of the scene, the directions of transport limits, or the states of an answer with several. What is
    carried moves along the timeline "time" [s], with its factor as a plot. All coordinates are in the world frame [m].

    Raises HoldfastError if rerun-sdk, of the extra ``rerun``, is not installed, if there is no recording, for a push or
    a verdict that was saved or copied and does not know its assembly any more, and for anything else.
    """
    path = checked_name(entity, "log_to_rerun: entity")
    _check(answer)
    sink = RerunSink(_rerun(recording), path, recording)
    content = _content(answer)
    sink.still(content.picture, repr(answer))
    sink.moving(content)


def _check(answer: object) -> None:
    if not isinstance(answer, Loggable):
        problem = f"answer is a {type(answer).__name__}"
        raise HoldfastError(message("log_to_rerun", problem, "needs a scene, an assembly or an answer"))


def _rerun(recording: Any) -> ModuleType:  # noqa: ANN401 - rerun's
    try:
        import rerun
    except ImportError:
        problem = "it needs rerun-sdk, which is not installed"
        raise HoldfastError(message("log_to_rerun", problem, installing("rerun"))) from None
    if rerun.get_data_recording(recording) is None:
        remedy = 'call rerun.init("holdfast", spawn=True) before, or give recording='
        raise HoldfastError(message("log_to_rerun", "there is no recording", remedy))
    module: ModuleType = rerun
    return module


def _content(what: Loggable) -> LoggedContent:
    """Return the picture of an answer and its moments."""
    match what:
        case Scene():
            return LoggedContent(bare_picture(what))
        case Assembly():
            return LoggedContent(_standing(what, None))
        case Stability() | Robustness():
            return _asked(what)
        case RobustnessMap():
            return LoggedContent(picture_of(what), _swing(what.mechanism[what.answers.ranking[0]], what.assembly.size))
        case TransportLimits() | Carried():
            moments = [_accelerated(what, k) for k in range(len(what.answers))]
            timeline = TIME if isinstance(what, Carried) else STEP
            return LoggedContent(_standing(what.assembly, what.verdict.forces), moments, timeline)
        case Settled():
            return LoggedContent(bare_picture(what.scene), _counted(settling(what)))
        case Disassembly():
            return LoggedContent(bare_picture(what.assembly.scene), _counted(taking_apart(what)))
        case Placements():
            return LoggedContent(bare_picture(what.assembly.scene), _counted(placing(what)))
        case RestingPoses():
            return LoggedContent(Picture("", "", (), solids_of([what.body])), _counted(resting(what)))
        case Placement():
            if what.assembly is None:
                raise HoldfastError(message("log_to_rerun", "no place was found", f"its reason: {what.reason}"))
            picture = bare_picture(what.assembly.scene) if what.map is None else picture_of(what.map)
            return LoggedContent(picture, _counted(places(what)))


def _asked(what: Stability | Robustness) -> LoggedContent:
    """Return the content of a verdict or of pushes, which know their assembly by what was asked."""
    assembly = what.questions[0].assembly
    picture = _standing(assembly, what.verdict.forces)
    if isinstance(what, Stability):
        return LoggedContent(picture, _swing(what.mechanism, assembly.size))
    length = WEAK_ARROW * assembly.size
    pushes = tuple(
        Arrow(point - length * way, point, f"{number(force, 'N')}, {gives_way(mode, moving)}")
        for point, way, force, mode, moving in zip(
            what.points, what.directions, what.force, what.mode, what.moving, strict=True
        )
    )
    weakest = what.mechanism[what.answers.ranking[0]]
    return LoggedContent(replace(picture, weakest=pushes), _swing(weakest, assembly.size))


def _standing(assembly: Assembly, at_rest: ContactForces | None) -> Picture:
    """Return a picture of an assembly with its contacts and the contact forces at rest, if they are known."""
    picture = replace(bare_picture(assembly.scene), outlines=outlines_of(assembly))
    if at_rest is None:
        return picture
    return replace(picture, contact_points=at_rest.points, contact_forces=force_arrows(assembly, at_rest))


def _counted(steps: Sequence[ShownStep]) -> list[Moment]:
    return [Moment(k, step, {}) for k, step in enumerate(steps)]


def _swing(mechanism: Mechanism | None, size: float) -> list[Moment]:
    """Return states from rest to a motion of SWING, in equal steps; none if nothing gives way."""
    if mechanism is None:
        return []
    shares = np.linspace(0, SWING, BETWEEN + 1)
    return _counted([ShownStep(mechanism.text, moved=moved_by(mechanism, share * size)) for share in shares])


def _accelerated(result: TransportLimits | Carried, k: int) -> Moment:
    """Return the state in which bodies begin to move: in direction ``k``, or at time ``k`` if its factor is below 1."""
    mechanism, known = result.mechanism[k], result.answers.decided[k]
    gives = gives_way(result.mode[k], result.moving[k]) if known else "undecided"
    begins, lower = mechanism is not None, float(result.lower[k])
    if isinstance(result, TransportLimits):
        when, values = float(k), {"acceleration": float(result.acceleration[k]), "lower": lower}
        along = listed([f"{value:.3g}" for value in result.directions[k]])
        text = f"along ({along}): {number(values['acceleration'], 'm/s²')}, {gives}"
    else:
        when, values = float(result.profile.time[k]), {"factor": float(result.factor[k]), "lower": lower}
        text, begins = f"factor {number(values['factor'])}, {gives}", begins and result.factor[k] < 1
    moved = moved_by(mechanism, SWING * result.assembly.size) if begins else {}
    shown = {name: value for name, value in values.items() if known and np.isfinite(value)}  # what a plot can show
    return Moment(when, ShownStep(text, moved=moved), shown)


class RerunSink:
    """Logs below one path of a recording."""

    def __init__(self, rr: ModuleType, path: str, recording: Any) -> None:  # noqa: ANN401 - rerun's
        self.rr, self.path, self.recording = rr, path, recording

    def put(self, parts: Sequence[str], *content: Any, static: bool = True) -> None:  # noqa: ANN401 - of rerun
        """Log content below this path."""
        self.rr.log([self.path, *map(one_line, parts)], *content, static=static, recording=self.recording)

    def still(self, picture: Picture, text: str) -> None:
        """Log what does not change: the answer in words, contacts, forces, pushes and the points of the map."""
        rr, size = self.rr, size_of(picture)
        words = [one_line(text), picture.title, picture.subtitle]
        scale = colours.scale_of(forces(picture))
        if scale is not None:
            low, *_, high = colours.ticks(scale)
            words.append(f"{picture.value_name}: dark red {low.label} (weak) to pale green {high.label} (strong)")
        self.put(["answer"], rr.TextDocument("\n\n".join(filter(None, words))))
        if picture.outlines:
            rings = [np.concatenate([ring, ring[:1]]) for ring in picture.outlines]
            self.put(["contacts", "patches"], rr.LineStrips3D(rings, colors=_bytes(rgb_of(CONTACT))))
        if len(picture.contact_points):
            nodes = rr.Points3D(picture.contact_points, colors=_bytes(rgb_of(CONTACT)), radii=0.5 * FORCE_RADIUS * size)
            self.put(["contacts", "nodes"], nodes)
        self._arrows("forces", picture.contact_forces, FORCE_COLOUR, FORCE_RADIUS * size)
        self._arrows("pushes", picture.weakest, INK, PUSH_RADIUS * size)
        if picture.heat:
            self.put(["points"], self._points(picture))

    def _arrows(self, name: str, arrows: Sequence[Arrow], colour: str, radius: float) -> None:
        if arrows:
            tails, heads = ends_of(arrows)
            drawn = self.rr.Arrows3D(
                origins=tails, vectors=heads - tails, colors=_bytes(rgb_of(colour)), radii=radius,
                labels=[one_line(arrow.label) for arrow in arrows], show_labels=False,
            )  # fmt: skip
            self.put([name], drawn)

    def _points(self, picture: Picture) -> Any:  # noqa: ANN401 - rerun's
        """Return the points of a map, with the force of each as its label."""
        force, kind = forces(picture), kinds(picture)
        names = legend(picture)
        labels = [
            number(f, "N") if k == Kind.FORCE else names[Kind(k)]
            for f, k in zip(force.tolist(), kind.tolist(), strict=True)
        ]
        return self.rr.Points3D(
            np.concatenate([surface.points for surface in picture.heat]),
            colors=_bytes(colours.colours(colours.scale_of(force), force, kind)),
            radii=0.5 * PUSH_RADIUS * size_of(picture), labels=labels, show_labels=False,
        )  # fmt: skip

    def moving(self, content: LoggedContent) -> None:
        """Log the bodies, and along the timeline where they are, which are there, the values and a text."""
        rr, bodies = self.rr, {body.name: body for body in painted(content.picture)}
        ever_hidden = {name for moment in content.moments for name in moment.step.hidden}
        ever_moved = {name for moment in content.moments for name in moment.step.moved}
        for name in bodies.keys() - ever_hidden:
            self.put(["bodies", name], self._mesh(bodies[name]))
        shown: set[str] = set()
        for when, step, values in content.moments:
            exact = {"sequence": int(when)} if content.timeline == STEP else {"duration": when}
            rr.set_time(content.timeline, recording=self.recording, **exact)
            self.put([content.timeline], rr.TextDocument(one_line(step.text)), static=False)
            for name, value in values.items():
                self.put([name], rr.Scalars(value), static=False)
            for name in sorted(ever_hidden & bodies.keys()):
                if name in step.hidden and name in shown:
                    self.put(["bodies", name], rr.Clear(recursive=False), static=False)
                elif name not in step.hidden and name not in shown:
                    self.put(["bodies", name], self._mesh(bodies[name]), static=False)
            shown = ever_hidden - step.hidden
            for name in sorted(ever_moved & (bodies.keys() - step.hidden)):
                place = step.moved.get(name, np.eye(4))
                self.put(["bodies", name], rr.Transform3D(translation=place[:3, 3], mat3x3=place[:3, :3]), static=False)
        if content.moments:
            rr.disable_timeline(content.timeline, recording=self.recording)

    def _mesh(self, body: Painted) -> Any:  # noqa: ANN401 - rerun's
        rgb = _bytes(body.rgb)
        return self.rr.Mesh3D(vertex_positions=body.vertices, triangle_indices=body.triangles, vertex_colors=rgb)


def _bytes(rgb: ArrayLike) -> NDArray[np.uint8]:
    """Return colours (..., 3) in 0..1 as bytes (n, 3)."""
    return np.asarray(np.rint(255 * np.reshape(rgb, (-1, 3))), dtype=np.uint8)
