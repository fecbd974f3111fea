"""What is said about carriers: limits of their acceleration, and a motion with what gives way first."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from holdfast.applications.transport import TransportLimits
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked_items, checked_name
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import at_most, number
from holdfast.base.rigid import tangents
from holdfast.base.text import listed, quoted
from holdfast.drawing.plots import Curve, Footprint, PolarPicture, Timeline, write_polar
from holdfast.engines.answers import Claim
from holdfast.engines.verdict import Status
from holdfast.geometry.hull import outline_numbers
from holdfast.queries.result import Columns, amount, endless, kind_of, promised
from holdfast.report import description as wording
from holdfast.report.description import STYLES, WORDS, Headline, Line, Report, ReportTable

if TYPE_CHECKING:
    from holdfast.applications.carrying.carry import Carried

ARCS = 12  # largest number of rows of directions in a table
TIMES = 12  # largest number of times in the table of a motion
DRAWN = 3  # largest number of names of moving bodies in a line of a picture
LEVEL = 1e-6  # largest vertical component of a unit direction that counts as horizontal
ENDS = {Status.STABLE: "holds", Status.UNSTABLE: "gives way", Status.UNDECIDED: "is undecided"}  # of a motion


def frame_names(assembly: Assembly) -> tuple[str, str, str, str]:
    """Return the names of the horizontal directions at 0, 90, 180 and 270 degrees."""
    plain = np.allclose(np.array(tangents(assembly.scene.up)), np.eye(3)[:2])
    return ("+x", "+y", "−x", "−y") if plain else ("0°", "90°", "180°", "270°")


def level_angles(result: TransportLimits) -> Float:
    """Return the angles (n,) [rad], in [0, 2π), of horizontal directions.

    They are measured from the first of ``Scene.horizontal_directions``.
    """
    up = result.assembly.scene.up
    if np.abs(result.directions @ up).max() > LEVEL:
        remedy = "ask along assembly.scene.horizontal_directions(...)"
        raise HoldfastError(message("transport limits by angle", "a direction is not level", remedy))
    ahead, left = tangents(up)
    angle = np.arctan2(result.directions @ left, result.directions @ ahead) % (2 * np.pi)
    return np.where(angle > 2 * np.pi - 1e-9, 0.0, angle)


def movers(result: Columns) -> list[str]:
    """Return for each row in words what gives way first; "" if nothing does."""
    pairs = zip(result.mode, result.moving, strict=True)
    return [f"{kind_of(mode)}: {listed(names, DRAWN)}" if names else "" for mode, names in pairs]


def transport_report(result: TransportLimits) -> Report:
    """Return what moves first, and a table of horizontal directions, grouped into arcs by their angle.

    Neighbouring directions in which the same bodies give way form one arc. If there are more than ARCS arcs, the circle
    is divided into ARCS equal parts instead.
    """
    count, (first, second, *_) = len(result.directions), frame_names(result.assembly)
    zero = f"{first} is 0°, {second} is 90°" if first != "0°" else "0° is the first of scene.horizontal_directions"
    rest = f" on its carrier, {count} directions, {zero}{wording.by_engine(result.engine, result.claim)}"
    verdict = result.verdict.status
    angle = np.asarray(np.round(np.degrees(level_angles(result)), 1), dtype=np.float64)
    row, least = result.answers.holding, promised(result.answers, "m/s²")
    of_all = (
        [f"{least} in each of these directions, the least towards {angle[row]:g}°"] if row is not None and least else []
    )
    quarters = [np.flatnonzero(angle == quarter) for quarter in (0.0, 90.0, 180.0, 270.0)]
    if all(len(rows) for rows in quarters):
        at = [amount(result.status[k], result.acceleration[k], "m/s²") for k in (rows[0] for rows in quarters)]
        if len(set(at)) > 1:
            of_all.append("; ".join(f"towards {90 * k}°: {limit}" for k, limit in enumerate(at)))
    arcs = _arcs(result)
    if len(arcs) > ARCS:
        arcs = [part.tolist() for part in np.array_split(np.arange(count), ARCS)]
    promise = {Claim.HOLDS: "holds", Claim.EXISTS: "exists"}.get(result.claim, "lower")
    heads = ("from", "to", "least [m/s²]", "at", promise, "at", "what moves")
    rank = np.argsort(result.answers.ranking)
    return Report(
        Headline(result.assembly.scene.name or "assembly", WORDS[verdict], STYLES[verdict], rest),
        *wording.remarks(result),
        Line(_slowest(result, angle)),
        *map(Line, of_all),
        ReportTable(
            heads, [_arc_row(result, angle, arc, rank) for arc in arcs], "largest acceleration of the carrier",
            right=range(6), whole=True, airy=True,
        ),
    )  # fmt: skip


def _arc_row(result: TransportLimits, angle: Float, arc: list[int], rank: NDArray[np.intp]) -> list[str]:
    """Return the row of an arc: its ends, its least answer and its least lower bound, and what moves."""
    least, low = arc[int(np.argmin(rank[arc]))], arc[int(np.argmin(result.lower[arc]))]
    first, last, at, there = (f"{angle[k]:g}°" for k in (arc[0], arc[-1], least, low))
    known, answer = result.answers.decided[least], amount(result.status[least], result.acceleration[least])
    promises = result.lower[low] > 0 or (known and result.lower.any())
    lower = [at_most(result.lower[low]), there] if promises else ["-", ""]
    partly = wording.partly_undecided(int((~result.answers.decided[arc]).sum()), len(arc))
    return [first, last, answer, at, *lower, _gives_way(result, least) + partly]


def _slowest(result: TransportLimits, angle: Float) -> str:
    """Return a sentence with the least acceleration in any decided direction that moves something."""
    if not result.answers.decided.any():
        return "the limit is undecided in each of these directions"
    least = int(result.answers.ranking[0])
    if result.status[least] is Status.INFINITE:
        return f"however fast it accelerates: {_endless(result)}"
    if result.status[least] is Status.UNSTABLE:
        return "even at rest " + ("something is crushed" if result.mode[least] == "crush" else "it does not stand")
    moving = f"{kind_of(result.mode[least])} of {listed(result.moving[least], wording.SHOWN)}"
    if not result.acceleration[least] > 0:
        return f"the slightest acceleration moves something: {moving}"
    among = "" if result.answers.decided.all() else ", of the directions with an answer"
    first = number(float(result.acceleration[least]), "m/s²")
    return f"the first to move{among}, towards {angle[least]:g}° beyond {first}: {moving}"


def _endless(result: TransportLimits) -> str:
    """Describe limits that are infinite in all decided directions, by that with the least lower bound."""
    decided = np.flatnonzero(result.answers.decided)
    return endless(result.answers, int(decided[np.argmin(result.lower[decided])]), "m/s²")


def _arcs(result: TransportLimits) -> list[list[int]]:
    """Group neighbouring directions, the last and the first too, in which the same bodies give way in the same mode."""
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
    return wording.moving_words(result.mode[k], result.moving[k], kind)


def save_polar(
    result: TransportLimits,
    path: str | os.PathLike[str],
    *,
    others: Sequence[TransportLimits] = (),
    names: Sequence[str] | None = None,
) -> None:
    """Write answers of one assembly along horizontal directions as a polar plot; the first is drawn on top."""
    write_polar(polar_picture([result, *checked_items(others, "polar plot: others", "TransportLimits")], names), path)


def polar_picture(results: Sequence[TransportLimits], names: Sequence[str] | None = None) -> PolarPicture:
    """Return the content of the polar plot; by default, ``names`` are the names of the engines."""
    if not results:
        raise HoldfastError(message("polar plot", "has no answers", "give at least one"))
    for other in results[1:]:
        if not isinstance(other, TransportLimits):
            raise HoldfastError(message("polar plot: others", f"hold {quoted(other)}", "needs TransportLimits"))
    where = "polar plot: names"
    given = [result.engine for result in results] if names is None else checked_items(names, where, "names")
    named = [checked_name(name, where) for name in given]
    if len(named) != len(results):
        raise HoldfastError(message(where, f"{len(named)} names of {len(results)} answers", "give one for each"))
    first, up, footprints = results[0], results[0].assembly.scene.up, []
    for body in first.assembly.bodies:
        vertices = body.surface_world.vertices
        flat = vertices @ np.array(tangents(up)).T
        footprints.append(Footprint(body.name, flat[outline_numbers(flat)], body.fixed, float((vertices @ up).max())))
    return PolarPicture(
        f"{first.assembly.scene.name or 'assembly'}: largest acceleration of the carrier [m/s²]",
        f"{WORDS[first.verdict.status]} · {len(first.directions)} level directions, "
        "the distance from the centre is the largest acceleration that way",
        frame_names(first.assembly),
        tuple(_curve(result, name) for result, name in zip(results, named, strict=True)),
        tuple(footprints),
        first.undecided.text,
    )


def _curve(result: TransportLimits, name: str) -> Curve:
    angle = level_angles(result)
    order = np.argsort(angle, kind="stable")
    title = f"{name} ({result.claim.words})" if name == result.engine else name
    return Curve(
        title, angle[order], result.acceleration[order], result.lower[order], _lines(result, angle),
        result.answers.decided[order], tuple(np.array(movers(result), dtype=object)[order]),
    )  # fmt: skip


def _lines(result: TransportLimits, angle: Float) -> tuple[str, ...]:
    """Describe the smallest and the largest decided answer, what gives way first, and the undecided answers."""
    unknown = [result.undecided.brief] if result.undecided.count else []
    known = result.acceleration[result.answers.decided]
    if len(known) and (result.status[result.answers.decided] == Status.UNSTABLE).all():
        return ("does not stand on the carrier", *unknown)
    if not len(known):
        return tuple(unknown)
    if np.isinf(known).all():
        return (f"however fast: {_endless(result)}", *unknown)
    least = int(result.answers.ranking[0])
    gives = movers(result)[least] or str(result.status[least])
    only = " (only balanced)" if result.status[least] is Status.FINITE and not result.acceleration[least] > 0 else ""
    degrees = np.round(np.degrees(angle), 1)
    lines = [f"least {number(float(result.acceleration[least]))}{only} at {degrees[least]:g}°, {gives}"]
    promise = promised(result.answers)
    if promise:
        lines.append(f"{promise} in all of these, the least at {degrees[result.answers.holding]:g}°")
    lines.append(f"largest {number(float(known.max()))}")
    return (*lines, *unknown)


def carried_report(result: Carried) -> Report:
    """Return whether a load holds while it is carried, and the times with the smallest factors, in their order."""
    motion, first, low = result.profile, movers(result), result.answers.holding
    rest = f" while it is carried: {motion.name or 'a motion'}{wording.by_engine(result.engine, result.claim)}"
    chosen = result.answers.ranking[:TIMES].tolist()
    rows = []
    for k in sorted(chosen if low is None or low in chosen else [*chosen[: TIMES - 1], low]):
        held = at_most(result.lower[k]) if result.answers.decided[k] else "?"
        figures = [amount(result.status[k], result.factor[k]), held]
        acceleration = [f"{v + 0.0:.4g}" for v in motion.acceleration[k]]
        gives = first[k] if result.answers.decided[k] else "not known"
        rows.append([number(float(motion.time[k])), *acceleration, *figures, gives])
    heads = ("at [s]", "ax", "ay", "az [m/s²]", "factor", "lower", "what moves first")
    return Report(
        Headline(result.assembly.scene.name or "assembly", ENDS[result.outcome], STYLES[result.outcome], rest),
        Line(result.reason),
        *map(Line, _safe_speed(result)),
        *([Line(f"motion from {motion.source}", "dim")] if motion.source else []),
        *wording.noted(result.notes),
        ReportTable(heads, rows, "times with the smallest factors", right=range(6), whole=True, airy=True),
    )


def _safe_speed(result: Carried) -> list[str]:
    """Return in words up to which speed the load is known to hold, or to have an equilibrium."""
    if result.claim is Claim.ESTIMATED:
        return []
    scale, what = result.time_scale(), "to hold" if result.claim is Claim.HOLDS else "to have an equilibrium"
    return [f"known {what} at {at_most(scale)} times this speed" if scale > 0 else f"not known {what} at any speed"]


def timeline(result: Carried) -> Timeline:
    """Return the accelerations and the used share of the load's capacity over time, for their picture."""
    motion, word = result.profile, ENDS[result.outcome]
    lines = [f"{word}: {result.reason}", *_safe_speed(result), f"engine {result.engine} ({result.claim.words})"]
    if result.undecided.count:
        lines.append(result.undecided.text)
    with np.errstate(divide="ignore"):
        certain = 1 / result.upper
    return Timeline(
        title=f"{result.assembly.scene.name or 'load'} carried: {motion.name or 'a motion'}",
        subtitle=f"{word} · {len(motion.time):,} times · each judged from rest, quasi-static",
        time=motion.time,
        acceleration=motion.acceleration,
        turning=motion.angular_acceleration,
        used=result.used,
        proved=np.where(result.answers.decided, certain, 0.0),
        movers=tuple(movers(result)),
        moved=result.time,
        lines=tuple(lines),
    )
