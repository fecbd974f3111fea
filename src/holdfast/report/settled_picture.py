"""Show how a scene came to rest as a picture and as lines for the terminal."""

from __future__ import annotations

import os

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table

from holdfast.applications.settled import Settled
from holdfast.base.files import write_atomically
from holdfast.base.text import LONGEST_NAME, one_line
from holdfast.drawing.panels import PointsPanel, sheet_png
from holdfast.drawing.picture import Arrow
from holdfast.report.bodies import bare_picture
from holdfast.report.texts import STYLES, cell, headline, sentence

LONGEST = 0.12  # length of the longest arrow, as a share of the scene's size
SHORTEST = 0.02  # shorter arrows are not drawn, as a share of the scene's size
MOST = 100.0  # largest magnification of displacements


def save_settled_png(result: Settled, path: str | os.PathLike[str]) -> None:
    """Draw the bodies at rest, faintly also where they were, with arrows along which they moved or fall."""
    before, after = bare_picture(result.given), bare_picture(result.scene)
    corners = np.vstack([body.surface_world.vertices for body in result.given.movable] or [np.zeros((1, 3))])
    size = float(np.linalg.norm(np.ptp(corners, axis=0)))
    farthest = float(result.moved.max(initial=0.0))
    times = min(MOST, LONGEST * size / max(farthest, 1e-300))
    falls = {fall.body: fall for fall in result.fell}
    arrows = []
    for name in result.names:
        start, end = result.given.body(name).com_world, result.scene.body(name).com_world
        way = LONGEST * size * falls[name].direction if name in falls else times * (end - start)
        if np.linalg.norm(way) > SHORTEST * size:
            arrows.append(Arrow(start, start + way, name))
    caption = f"faint: as given; arrows: displacements, {times:.3g} times as long" + (", falls" if falls else "")
    panel = PointsPanel(caption, after, marks=tuple(arrows), accent=next(iter(falls), ""), ghost=before)
    title = f"{result.given.name or 'scene'}: {result.status}"
    write_atomically(path, sheet_png([[panel]], title, result.reason, panel=(1100, 760)))


def settled_report(result: Settled, scene: str) -> RenderableType:
    """Return the verdict and a table of all bodies with their displacements, the largest first."""
    rest = f" after {result.steps} steps within {1e3 * result.travel:.3g} mm"
    head = headline(one_line(scene, LONGEST_NAME), (str(result.status), STYLES[result.status]), rest)
    table = Table("body", "moved [mm]", "turned [deg]", "why", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    turns = result.turned_degrees
    for k in np.argsort(-result.moved, kind="stable"):
        row = (result.names[k], f"{1e3 * result.moved[k]:.3g}", f"{round(turns[k], 6):.3g}", result.reasons[k])
        table.add_row(*map(cell, row))
    return Group(head, sentence(result.reason), table, *(sentence(note, "dim") for note in result.notes))
