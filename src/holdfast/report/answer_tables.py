"""Show answers as tables for the terminal."""

from __future__ import annotations

import shlex

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from holdfast.applications.transport import TransportLimits
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Bool, Float
from holdfast.base.public import number
from holdfast.base.text import LONGEST_NAME, listed, one_line
from holdfast.engines.answers import Claim
from holdfast.engines.verdict import Status
from holdfast.queries.map import MapPoint, RobustnessMap
from holdfast.queries.result import KNOWN_HOW, promised, vector_text
from holdfast.queries.stability import Stability
from holdfast.report.texts import STYLES, WORDS, cell, headline, sentence
from holdfast.report.transport_plot import frame_names, level_angles

SHOWN = 5  # largest number of names in a cell
ARCS = 12  # largest number of rows of directions in a table


def stability_report(assembly: Assembly, result: Stability) -> RenderableType:
    """Return a table with the verdict, its reason and the contacts."""
    word, style = WORDS[result.status], STYLES[result.status]
    name = assembly.scene.name or "scene"
    head = headline(name, (word, style), f"  (engine {result.engine}: {result.claim.words})")
    lines: list[RenderableType] = [head, sentence(result.reason, "dim")]
    lines += [sentence(f"note: {note}", "yellow") for note in result.notes]
    lines.append(_contacts(assembly, result))
    return Group(*lines)


def _contacts(assembly: Assembly, result: Stability) -> Table:
    movable, interfaces = len(assembly.movable), len(assembly.interfaces)
    table = Table(
        title=f"{movable} movable bodies, {interfaces} interfaces ({assembly.tolerances.text})",
        title_justify="left",
        box=SIMPLE_HEAD,
    )
    for heading in ("between", "area [cm²]", "μ", "normal force [N]", "friction used"):  # as a share of its limit
        table.add_column(cell(heading), justify="left" if heading == "between" else "right")
    shown = range(min(interfaces, 40))
    for k in shown:
        interface = assembly.interfaces[k]
        force, usage = "-", "-"
        if result.forces is not None:
            here = result.forces.interface == k
            pressing = (result.forces.force[here] * result.forces.normal[here]).sum()
            tangential = np.linalg.norm(result.forces.force[here].sum(0) - _along(result, here))
            force = f"{pressing:.3g}"
            limit = assembly.mu[k] * pressing
            usage = f"{tangential / limit:.0%}" if limit > 1e-9 * assembly.weight else "-"
        a, b = (one_line(name, LONGEST_NAME) for name in interface.bodies)
        said = interface.flags if interface.certain else (*interface.flags, "may not exist")
        flags = f" ({', '.join(said)})" if said else ""
        table.add_row(cell(f"{a} - {b}{flags}"), f"{interface.area * 1e4:.4g}", f"{assembly.mu[k]:g}", force, usage)
    if interfaces > len(shown):
        table.add_row(f"... and {interfaces - len(shown)} more", "", "", "", "")
    return table


def _along(result: Stability, here: Bool) -> Float:
    assert result.forces is not None
    force, normal = result.forces.force[here], result.forces.normal[here]
    return np.asarray(((force * normal).sum(1, keepdims=True) * normal).sum(0))


def map_report(result: RobustnessMap) -> RenderableType:
    """Return a table with the weakest point of every body."""
    word, style = WORDS[result.verdict.status], STYLES[result.verdict.status]
    name = result.assembly.scene.name or "scene"
    head = headline(
        name, (word, style), f"  {len(result.force):,} inward pushes  (engine {result.engine}: {result.claim.words})"
    )
    table = Table(title="weakest push on each body", title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading in ("body", "force [N]", "at [mm]", "along", "what moves"):
        table.add_column(
            cell(heading), justify="right" if heading == "force [N]" else "left", no_wrap=heading != "what moves"
        )
    weakest = result.weakest_of_each_body()
    for weak in weakest[:30]:
        here = result.body == weak.body
        unknown = int((here & ~result.answers.decided).sum())
        *cells, what = _row(weak)
        partly = f"; {unknown} of {here.sum()} undecided" if 0 < unknown < here.sum() else ""
        table.add_row(*map(cell, (*cells, what + partly)))
    if len(weakest) > 30:
        table.add_row(f"... and {len(weakest) - 30} more", *[""] * 4)
    return Group(head, *_remarks(result), *map(sentence, _held_everywhere(result)), table)


def _held_everywhere(result: RobustnessMap) -> list[str]:
    """Return a sentence with the bound that holds at all points, and the point where it is smallest."""
    row, held = result.answers.holding, promised(result.answers, "N")
    if row is None or not held:
        return []
    place = f"{vector_text(1e3 * result.points[row], '.0f')} mm"
    body, known = one_line(result.body[row], LONGEST_NAME), KNOWN_HOW[result.lower_bound]
    return [f"{held} at every point, the least on {body} at {place} ({known})"]


def _remarks(result: RobustnessMap | TransportLimits) -> list[Text]:
    """Return the reason of a verdict that is not STABLE, the number of undecided answers, and the notes, none twice."""
    stands = result.verdict.status is Status.STABLE
    remarks = [] if stands else [sentence(result.verdict.reason, "dim")]
    notes = [note for note in result.notes if stands or result.verdict.reason not in note]
    if result.undecided.count:
        known = {result.verdict.reason, *result.notes}.issuperset(result.undecided.reasons)
        remarks.append(sentence(result.undecided.brief if known else result.undecided.text, "bold yellow"))
    return remarks + [sentence(f"note: {note}", "yellow") for note in (*notes, *_way_out(result))]


def _way_out(result: RobustnessMap | TransportLimits) -> list[str]:
    """Return how to leave out bodies that are only balanced, if the least answer is 0 because of them."""
    names = [name for name in result.verdict.balanced if name in _moving_at_least(result)]
    options = " ".join(f"--without {shlex.quote(name)}" for name in names)
    one = f"{listed(names, SHOWN)} {'are' if len(names) > 1 else 'is'} only balanced"
    return [f"the least is 0 because {one}: {options} asks about the rest"] if names else []


def _moving_at_least(result: RobustnessMap | TransportLimits) -> tuple[str, ...]:
    """Return which bodies move at the least answer if that is 0."""
    if not result.answers.decided.any():
        return ()
    least = int(result.answers.ranking[0])
    zero = result.status[least] is Status.FINITE and result.answers.force[least] == 0
    return tuple(result.moving[least]) if zero else ()


def _row(weak: MapPoint) -> tuple[str, ...]:
    if weak.status is Status.INFINITE:
        return weak.body, "∞", "", "", "nothing"
    if weak.status is Status.UNDECIDED:
        return weak.body, "?", "", "", "undecided"
    if weak.status is Status.UNSTABLE:
        return weak.body, "0", "", "", _moving(weak.mode, weak.moving, "falls without a push")
    place = vector_text((1e3 * v for v in weak.point), ".0f")
    what = _moving(weak.mode, weak.moving, "" if weak.force > 0 else "only balanced")
    return weak.body, f"{weak.force:.4g}", place, _direction(weak.direction), what


def _moving(mode: str, moving: tuple[str, ...], kind: str) -> str:
    """Describe what moves and how, after the ``kind`` of the answer, which may be ""."""
    what = f"{mode}: {listed(moving, SHOWN)}" if moving else ""
    return ", ".join(filter(None, [kind, what]))


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
    promise = "holds" if result.claim is Claim.HOLDS else "lower"
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
    return Group(head, *_remarks(result), sentence(_slowest(result, angle)), *map(sentence, more), table)


def _round(result: TransportLimits) -> str:
    """Describe the origin and the sense of the angles of horizontal directions."""
    first, second, *_ = frame_names(result.assembly)
    return f"{first} is 0°, {second} is 90°" if first != "0°" else "0° is the first of scene.horizontal_directions"


def _slowest(result: TransportLimits, angle: Float) -> str:
    """Return a sentence with the acceleration that the carrier may have in any decided direction."""
    if not result.answers.decided.any():
        return "the limit is undecided in every direction"
    least = int(result.answers.ranking[0])
    if result.status[least] is Status.INFINITE:
        return "nothing moves on it, however fast it accelerates"
    if result.status[least] is Status.UNSTABLE:
        return "it does not stand even at rest"
    where = "in every direction" if result.answers.decided.all() else "in every direction with an answer"
    fastest = number(float(result.acceleration[least]), "m/s²")
    moving = f"{result.mode[least]} of {listed(result.moving[least], SHOWN)}"
    return f"{where} up to {fastest}; beyond that, when it accelerates towards {angle[least]:g}°, {moving}"


def _held(result: TransportLimits, angle: Float) -> list[str]:
    """Return a sentence with the bound that holds in all directions, and the direction where it is smallest."""
    row, held = result.answers.holding, promised(result.answers, "m/s²")
    if row is None or not held:
        return []
    return [f"{held} in every direction, the least towards {angle[row]:g}° ({KNOWN_HOW[result.lower_bound]})"]


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
    falls = "falls at rest" if result.status[k] is Status.UNSTABLE else ""
    kind = falls or ("" if result.acceleration[k] > 0 else "only balanced")
    return _moving(result.mode[k], result.moving[k], kind)


def _direction(values: tuple[float, float, float]) -> str:
    """Return the name of an axis, or the components of any other direction."""
    for axis, value in zip("xyz", values, strict=True):
        if abs(value) > 1 - 1e-9:
            return f"{'+' if value > 0 else '-'}{axis}"
    return vector_text(np.round(values, 2), ".2f")
