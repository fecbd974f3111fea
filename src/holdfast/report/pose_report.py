"""What is said about poses: where to put a body, how it rests, what settles, what is firmer; and measured friction."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np

from holdfast.applications.resting_poses import RestingPoses, words
from holdfast.base.errors import HoldfastError, message
from holdfast.base.files import write_atomically
from holdfast.base.public import number
from holdfast.base.text import LONGEST_NAME, listed, one_line
from holdfast.drawing.panel_sheets import PointsPanel, StateFrame, StateSequence, sheet_png, write_sequence
from holdfast.drawing.picture import Arrow
from holdfast.engines.verdict import Status
from holdfast.queries.result import vector_text
from holdfast.report.description import MOST_FRAMES, STYLES, Headline, Line, Report, ReportTable, by_engine, what_moves
from holdfast.report.map_picture import bare_picture, solids_of

if TYPE_CHECKING:
    from holdfast.applications.calibration.measured_friction import MeasuredFriction
    from holdfast.applications.placement.result import Placement
    from holdfast.applications.pushing.firmer import Firmer
    from holdfast.applications.settled import Settled

SAMPLED = 160  # number of support points that are sampled for the picture of a placement
MOST_ARROWS = 6  # largest number of arrows of supports, which are at the largest contact patches
ARROW = 0.1  # length of the arrows of supports, as a share of the assembly's size
LONGEST_ARROW = 0.12  # length of the longest arrow of a displacement, as a share of the scene's size
SHORTEST_ARROW = 0.02  # shorter arrows of displacements are not drawn, as a share of the scene's size
MOST_TIMES = 100.0  # largest magnification of displacements


def placement_report(result: Placement, scene: str, body: str) -> Report:
    """Return the verdict, the pose, the weakest point and the contacts, or the reason why no place was found."""
    if result.pose is None:
        rest = f" in {one_line(scene, LONGEST_NAME)}  (engine {result.engine})"
        style = "bold red" if result.status is Status.UNSTABLE else "bold yellow"
        lines = [Line(result.reason)]
        if result.best is not None:
            place = vector_text(result.best.pose[:3, 3], ".4g")
            lines.append(Line(f"nearest: at {place}, {result.best.fault}", "dim"))
        return Report(Headline(body, "no place found", style, rest), *lines)
    at = f" at {vector_text(result.pose[:3, 3], '.4g')}{by_engine(result.engine, result.claim)}"
    lines = [Line("pose, body to world [m]:")]
    lines += [Line("  " + " ".join(f"{value:9.5f}" for value in row)) for row in result.pose]
    lines.append(Line(f"touches {listed([other for i in result.contacts for other in i.bodies if other != body])}"))
    if result.rating is not None:
        lines.append(Line("; ".join(f"{what} {value}" for what, value in result.rating.facts(body, result.beneath))))
    weak = result.weakest
    if weak is not None:
        how = weak.status if weak.mode == "none" else what_moves(weak.body, weak.mode, weak.moving)
        what = f"{result.robustness:.3g} N on {one_line(weak.body, LONGEST_NAME)}, {how}"
        lines.append(Line(f"least push afterwards: {'undecided' if weak.status is Status.UNDECIDED else what}"))
    tried = f"{result.attempts} attempt{'s' if result.attempts != 1 else ''}"
    lines.append(Line(f"{result.reason}; {tried}, {result.elapsed:.2g} s", "dim"))
    return Report(Headline(body, "stands", "bold green", at), *lines)


def save_placement_png(result: Placement, path: str | os.PathLike[str], *, seed: int = 0) -> None:
    """Draw two pictures: sampled support points, coloured by the push that they withstand, and the pose (Fig. 12).

    Arrows show where the scene supports the object.
    """
    if result.assembly is None or result.body is None or result.support is None:
        raise HoldfastError(message("picture of a placement", "there is no pose to show", result.reason))
    support, name, scene = result.support, result.body.name, result.assembly.scene
    rng = np.random.default_rng(seed)
    chosen = np.unique(rng.choice(len(support.points), SAMPLED, p=support.chance))
    length = ARROW * result.assembly.size
    patches = sorted((patch for i in result.contacts for patch in i.patches), key=lambda patch: -patch.measure)
    places = np.array([patch.centroid for patch in patches[:MOST_ARROWS]])
    arrows = tuple(Arrow(place - length * scene.up, place, "") for place in places)
    computed = not np.isnan(support.force).all()
    how = "weighted by the push that they withstand" if computed else "without forces: there was no time"
    before = PointsPanel(
        f"sampled support points, {how}", bare_picture(scene, without=name),
        support.points[chosen], support.normals[chosen], support.force[chosen],
    )  # fmt: skip
    known = result.weakest is not None and result.weakest.status is not Status.UNDECIDED
    caption = f"the best pose: least push {result.robustness:.3g} N" if known else "the best pose: undecided"
    if known and result.rating is not None and result.rating.own is not None:
        caption += f", on {one_line(name, LONGEST_NAME)} {result.rating.own:.3g} N"
    marked = f"here {one_line(name, LONGEST_NAME)} is supported"
    after = PointsPanel(caption, bare_picture(scene), marks=arrows, accent=name, marked=marked)
    unknown = result.answers.undecided.text_on("points of the map")
    about = " · ".join(filter(None, [f"engine {result.engine} ({result.claim.words})", unknown]))
    write_atomically(path, sheet_png([[before, after]], f"{scene.name or 'scene'}: where to put {name}", about))


def settled_report(result: Settled, scene: str) -> Report:
    """Return the verdict and a table of all bodies with their displacements, the largest first."""
    rest = f" after {result.steps} steps within {1e3 * result.travel:.3g} mm"
    turns = result.turned_degrees
    rows = [
        (result.names[k], f"{1e3 * result.moved[k]:.3g}", f"{round(turns[k], 6):.3g}", result.reasons[k])
        for k in np.argsort(-result.moved, kind="stable")
    ]
    return Report(
        Headline(one_line(scene, LONGEST_NAME), str(result.status), STYLES[result.status], rest),
        Line(result.reason),
        ReportTable(("body", "moved [mm]", "turned [deg]", "why"), rows, most=len(rows)),
        *(Line(note, "dim") for note in result.notes),
    )


def save_settled_png(result: Settled, path: str | os.PathLike[str]) -> None:
    """Draw the bodies at rest, faintly also where they were, with arrows along which they moved or fall."""
    corners = np.vstack([body.surface_world.vertices for body in result.given.movable] or [np.zeros((1, 3))])
    size = float(np.linalg.norm(np.ptp(corners, axis=0)))
    times = min(MOST_TIMES, LONGEST_ARROW * size / max(float(result.moved.max(initial=0.0)), 1e-300))
    falls = {fall.body: fall for fall in result.fell}
    arrows = []
    for name in result.names:
        start, end = result.given.body(name).com_world, result.scene.body(name).com_world
        way = LONGEST_ARROW * size * falls[name].direction if name in falls else times * (end - start)
        if np.linalg.norm(way) > SHORTEST_ARROW * size:
            arrows.append(Arrow(start, start + way, name))
    panel = PointsPanel(
        f"faint: as given; arrows: displacements, {times:.3g} times as long" + (", falls" if falls else ""),
        bare_picture(result.scene), marks=tuple(arrows), accent=next(iter(falls), ""), ghost=bare_picture(result.given),
    )  # fmt: skip
    title = f"{result.given.name or 'scene'}: {result.status}"
    write_atomically(path, sheet_png([[panel]], title, result.reason, panel=(1100, 760)))


def resting_report(result: RestingPoses, name: str) -> Report:
    """Return a table of the poses, the most probable first."""
    summary = result.summary()
    right = [k for k, head in enumerate(summary.heads) if head]
    headline = Headline(name, _rests(result), "bold green", f"  (friction {result.mu:g})")
    return Report(headline, ReportTable(summary.heads, summary.rows, right=right, more_at=1))


def save_resting_png(result: RestingPoses, path: str | os.PathLike[str]) -> None:
    """Write the poses as a PNG, one panel for each, the most probable first."""
    frames = []
    for pose in list(result)[:MOST_FRAMES]:
        note = words(pose) if pose.rolls else f"{words(pose)}, tips at {pose.tipping_degrees:.3g}°"
        frames.append(StateFrame(solids_of([result.body.moved(pose.pose)]), "", f"{pose.probability:.1%}", note))
    shown = "" if len(frames) == len(result) else f", of which {len(frames)} are shown"
    up = np.array([0.0, 0.0, 1.0])
    note = "share of slow falls that end there, and the tilt of the plane at which it leaves"
    write_sequence(StateSequence(f"{_rests(result)}{shown}", note, tuple(frames), up, up), path)


def _rests(result: RestingPoses) -> str:
    return f"rests in {len(result)} poses" if len(result) > 1 else "rests in one pose"


def firmer_report(result: Firmer) -> Report:
    """Return what was moved, and the least push on each body before and after, or the least factor of a motion."""
    summary = result.summary()
    style = "bold green" if len(result) > 1 else "bold yellow"
    rest = f"  ({result.tried} poses tried, engine {result.engine}: {result.claim.words})"
    headline = Headline(result.assembly.scene.name or "scene", summary.headline, style, rest)
    return Report(headline, ReportTable(summary.heads, summary.rows))


def save_firmer_png(result: Firmer, path: str | os.PathLike[str]) -> None:
    """Write the scene before and after as a PNG; before, with an arrow the way in which the first body was moved."""
    from holdfast.applications.pushing.firmer import STILL  # only here, as it takes long to import

    scene, unit = result.assembly.scene, "times" if result.times else "N"
    name, last = next(iter(result.poses.items()))
    centre = np.append(scene.body(name).com_body, 1.0)
    way = ((last - result[0].poses[name]) @ centre)[:3]
    far = float(np.linalg.norm(way))
    frames = []
    for step, when, least in ((result[0], "before", result.before), (result[-1], "after", result.after)):
        bodies = [body.moved(step.poses.get(body.name, body.pose)) for body in scene.bodies]
        marked = name if far > STILL and step is result[0] else ""
        frames.append(StateFrame(solids_of(bodies), marked, when, f"least {number(least, unit)}"))
    along = way / far if far > STILL else scene.up
    title, note = scene.name or "firmer", result.summary().headline
    write_sequence(
        StateSequence(title, note, tuple(frames), along, scene.up, marked="what is moved, and which way"), path
    )


def friction_report(result: MeasuredFriction) -> Report:
    """Return a table of coefficients by pair, with what is not known and the pushes that fit worst."""
    summary = result.summary()
    lines = [
        summary.headline,
        *(f"{name}: {text}" for name, text in summary.facts),
        *(f"note: {note}" for note in summary.notes),
    ]
    pairs = ReportTable(summary.heads, summary.rows, "friction", airy=True, most=len(summary.rows))
    rows = []
    for k in result.worst:
        force, predicted = float(result.force[k]), float(result.predicted[k])
        measured = number(force, "N") + ("" if result.moved[k] else ", held")
        model = (number(predicted, "N"), number(force / predicted)) if predicted > 0 else ("?", "?")
        rows.append((str(k), result.bodies[k], measured, *model))
    heads = ("push", "body", "measured", "predicted", "ratio")
    worst = ReportTable(heads, rows, "the pushes that fit worst", right=(0, 2, 3, 4), airy=True, most=len(rows))
    return Report(*map(Line, lines), *([pairs] if summary.rows else []), worst)
