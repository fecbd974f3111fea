"""Show a placement as a picture and as lines for the terminal."""

from __future__ import annotations

import os

import numpy as np
from rich.console import Group, RenderableType
from rich.text import Text

from holdfast.applications.placement.result import Placement
from holdfast.base.errors import HoldfastError, message
from holdfast.base.files import write_atomically
from holdfast.base.text import LONGEST_NAME, listed, one_line
from holdfast.drawing.panels import PointsPanel, sheet_png
from holdfast.drawing.picture import Arrow
from holdfast.engines.verdict import Status
from holdfast.queries.result import vector_text
from holdfast.report.bodies import bare_picture
from holdfast.report.texts import headline, sentence, what_moves

SHOWN = 160  # number of support points that are sampled for the picture
MOST_ARROWS = 6  # largest number of arrows, which are at the largest contact patches
ARROW = 0.1  # length of the arrows, as a share of the assembly's size


def save_placement_png(result: Placement, path: str | os.PathLike[str], *, seed: int = 0) -> None:
    """Draw two pictures: sampled support points, coloured by the push that they withstand, and the pose (Fig. 12).

    Arrows show where the scene supports the object.
    """
    if result.assembly is None or result.body is None or result.support is None:
        raise HoldfastError(message("picture of a placement", "there is no pose to show", result.reason))
    support, name = result.support, result.body.name
    rng = np.random.default_rng(seed)
    chosen = np.unique(rng.choice(len(support.points), SHOWN, p=support.chance))
    length = ARROW * result.assembly.size
    patches = sorted((patch for i in result.contacts for patch in i.patches), key=lambda patch: -patch.measure)
    places = np.array([patch.centroid for patch in patches[:MOST_ARROWS]])
    arrows = tuple(Arrow(p - length * result.assembly.scene.up, p, "") for p in places)
    computed = not np.isnan(support.force).all()
    how = "weighted by the push that they withstand" if computed else "without forces: there was no time"
    before = PointsPanel(
        f"sampled support points, {how}", bare_picture(result.assembly.scene, without=name),
        support.points[chosen], support.normals[chosen], support.force[chosen],
    )  # fmt: skip
    known = result.weakest is not None and result.weakest.status is not Status.UNDECIDED
    caption = f"the best pose: least push {result.robustness:.3g} N" if known else "the best pose: undecided"
    if known and result.rating is not None and result.rating.own is not None:
        caption += f", on {one_line(name, LONGEST_NAME)} {result.rating.own:.3g} N"
    after = PointsPanel(
        caption, bare_picture(result.assembly.scene), marks=arrows, accent=name,
        marked=f"here {one_line(name, LONGEST_NAME)} is supported",
    )  # fmt: skip
    title = f"{result.assembly.scene.name or 'scene'}: where to put {name}"
    unknown = result.answers.undecided.text_on("points of the map")
    about = " · ".join(filter(None, [f"engine {result.engine} ({result.claim.words})", unknown]))
    write_atomically(path, sheet_png([[before, after]], title, about))


def placement_report(result: Placement, scene: str, body: str) -> RenderableType:
    """Return the verdict, the pose, the weakest point and the contacts, or the reason why no place was found."""
    if result.pose is None:
        style = "bold red" if result.status is Status.UNSTABLE else "bold yellow"
        where = one_line(scene, LONGEST_NAME)
        head = headline(body, ("no place found", style), f" in {where}  (engine {result.engine})")
        lines: list[RenderableType] = [head, sentence(result.reason)]
        if result.best is not None:
            lines.append(
                sentence(f"nearest: at {vector_text(result.best.pose[:3, 3], '.4g')}, {result.best.fault}", "dim")
            )
        return Group(*lines)
    at = f" at {vector_text(result.pose[:3, 3], '.4g')}  (engine {result.engine}: {result.claim.words})"
    head = headline(body, ("stands", "bold green"), at)
    rows = "\n".join("  " + " ".join(f"{value:9.5f}" for value in row) for row in result.pose)
    others = [other for i in result.contacts for other in i.bodies if other != body]
    weak = result.weakest
    lines = [head, Text(f"pose, body to world [m]:\n{rows}"), sentence(f"touches {listed(others)}")]
    if weak is not None:
        how = weak.status if weak.mode == "none" else what_moves(weak.body, weak.mode, weak.moving)
        what = f"{result.robustness:.3g} N on {one_line(weak.body, LONGEST_NAME)}, {how}"
        lines.append(Text(f"least push afterwards: {'undecided' if weak.status is Status.UNDECIDED else what}"))
    if result.rating is not None:
        facts = [f"{what} {value}" for what, value in result.rating.facts(body, result.beneath)]
        lines.insert(3, sentence("; ".join(facts)))
    tried = f"{result.attempts} attempt{'s' if result.attempts != 1 else ''}"
    lines.append(sentence(f"{result.reason}; {tried}, {result.elapsed:.2g} s", "dim"))
    return Group(*lines)
