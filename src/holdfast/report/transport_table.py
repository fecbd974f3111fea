"""Show transport limits as a table for the terminal."""

from __future__ import annotations

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table

from holdfast.applications.transport import TransportLimits
from holdfast.base.arrays import Float
from holdfast.base.public import number
from holdfast.base.text import listed
from holdfast.engines.answers import Claim
from holdfast.engines.verdict import Status
from holdfast.queries.result import promised
from holdfast.report.level_directions import frame_names, level_angles
from holdfast.report.remarks import SHOWN, moving_words, remarks
from holdfast.report.texts import STYLES, WORDS, cell, headline, sentence

ARCS = 12  # largest number of rows of directions in a table


def transport_report(result: TransportLimits) -> RenderableType:
    """Return a table of horizontal directions, grouped into arcs by their angle.

    Neighbouring directions in which the same bodies give way form one arc. If there are more than ARCS arcs, the circle
    is divided into ARCS equal parts instead.
    """
    word, style = WORDS[result.verdict.status], STYLES[result.verdict.status]
    count = len(result.directions)
    head = headline(
        result.assembly.scene.name or "assembly",
        (word, style),
        f" on its carrier, {count} directions, {_round(result)}  (engine {result.engine}: {result.claim.words})",
    )
    table = Table(title="largest acceleration of the carrier", title_justify="left", box=SIMPLE_HEAD)
    promise = {Claim.HOLDS: "holds", Claim.EXISTS: "exists"}.get(result.claim, "lower")
    for heading in ("from", "to", "least [m/s²]", "at", promise, "at", "what moves"):
        name = heading == "what moves"
        table.add_column(cell(heading), justify="left" if name else "right", no_wrap=not name)
    angle = np.asarray(np.round(np.degrees(level_angles(result)), 1), dtype=np.float64)
    arcs = _arcs(result)
    if len(arcs) > ARCS:
        arcs = [part.tolist() for part in np.array_split(np.arange(count), ARCS)]
    rank = np.argsort(result.answers.ranking)
    for arc in arcs:
        least, low = arc[int(np.argmin(rank[arc]))], arc[int(np.argmin(result.lower[arc]))]
        first, last, at, there = (f"{angle[k]:g}°" for k in (arc[0], arc[-1], least, low))
        known = result.status[least] is not Status.UNDECIDED
        answer = number(float(result.acceleration[least])) if known else "?"
        promises = result.lower[low] > 0 or (known and result.lower.any())
        lower = [number(float(result.lower[low])), there] if promises else ["-", ""]
        unknown = int((~result.answers.decided[arc]).sum())
        partly = f"; {unknown} of {len(arc)} undecided" if 0 < unknown < len(arc) else ""
        table.add_row(*map(cell, (first, last, answer, at, *lower, _gives_way(result, least) + partly)))
    more = [*_held(result, angle), *_at_quarters(result, angle)]
    return Group(head, *remarks(result), sentence(_slowest(result, angle)), *map(sentence, more), table)


def _round(result: TransportLimits) -> str:
    """Describe the origin and the sense of the angles of horizontal directions."""
    first, second, *_ = frame_names(result.assembly)
    return f"{first} is 0°, {second} is 90°" if first != "0°" else "0° is the first of scene.horizontal_directions"


def _slowest(result: TransportLimits, angle: Float) -> str:
    """Return a sentence with the least acceleration in any decided direction that moves something."""
    if not result.answers.decided.any():
        return "the limit is undecided in every direction"
    least = int(result.answers.ranking[0])
    if result.status[least] is Status.INFINITE:
        what = "an equilibrium exists" if result.claim is Claim.EXISTS else "nothing moves on it"
        return f"{what}, however fast it accelerates"
    if result.status[least] is Status.UNSTABLE:
        return "even at rest " + ("something is crushed" if result.mode[least] == "crush" else "it does not stand")
    moving = f"{result.mode[least]} of {listed(result.moving[least], SHOWN)}"
    if not result.acceleration[least] > 0:
        return f"the slightest acceleration moves something: {moving}"
    among = "" if result.answers.decided.all() else ", of the directions with an answer"
    first = number(float(result.acceleration[least]), "m/s²")
    return f"the first to move{among}, towards {angle[least]:g}° beyond {first}: {moving}"


def _held(result: TransportLimits, angle: Float) -> list[str]:
    """Return a sentence with the bound that holds in all directions, and the direction where it is smallest."""
    row, held = result.answers.holding, promised(result.answers, "m/s²")
    if row is None or not held:
        return []
    return [f"{held} in every direction, the least towards {angle[row]:g}°"]


def _at_quarters(result: TransportLimits, angle: Float) -> list[str]:
    """Return a sentence with the limits at each quarter turn, if these directions have answers that differ."""
    places = [np.flatnonzero(angle == quarter) for quarter in (0.0, 90.0, 180.0, 270.0)]
    if not all(len(found) for found in places):
        return []
    chosen = [int(found[0]) for found in places]
    values = [number(float(result.acceleration[k]), "m/s²") if result.answers.decided[k] else "?" for k in chosen]
    if len(set(values)) == 1:
        return []
    return ["; ".join(f"towards {90 * k}°: {value}" for k, value in enumerate(values))]


def _arcs(result: TransportLimits) -> list[list[int]]:
    """Group neighbouring directions in which the same bodies give way in the same mode.

    The last direction is a neighbour of the first.
    """
    kinds = [(result.status[k], result.mode[k], result.moving[k]) for k in range(len(result.directions))]
    arcs: list[list[int]] = []
    for k, kind in enumerate(kinds):
        if arcs and kinds[k - 1] == kind:
            arcs[-1].append(k)
        else:
            arcs.append([k])
    if len(arcs) > 1 and kinds[0] == kinds[-1]:
        arcs[0] = arcs.pop() + arcs[0]
    return arcs


def _gives_way(result: TransportLimits, k: int) -> str:
    if result.status[k] is Status.INFINITE:
        return "nothing"
    if result.status[k] is Status.UNDECIDED:
        return "undecided"
    falls = ("" if result.mode[k] == "crush" else "falls ") + "at rest" if result.status[k] is Status.UNSTABLE else ""
    kind = falls or ("" if result.acceleration[k] > 0 else "only balanced")
    return moving_words(result.mode[k], result.moving[k], kind)
