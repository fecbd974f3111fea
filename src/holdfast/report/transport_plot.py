"""Show transport limits as a polar plot of one or several answers."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np

from holdfast.applications.transport import TransportLimits
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked_items, checked_name
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import number
from holdfast.base.rigid import tangents
from holdfast.base.text import listed
from holdfast.drawing.polar import Curve, Footprint, PolarPicture, write_polar
from holdfast.engines.verdict import Status
from holdfast.geometry.hull import outline_numbers
from holdfast.queries.result import Columns, promised
from holdfast.report.level_directions import frame_names, level_angles
from holdfast.report.texts import WORDS

SHOWN = 3  # largest number of names of moving bodies in a line


def save_polar(
    results: Sequence[TransportLimits], path: str | os.PathLike[str], names: Sequence[str] | None = None
) -> None:
    """Write answers of one assembly along horizontal directions as a polar plot (PNG); the first is drawn on top."""
    write_polar(polar_picture(results, names), path)


def polar_picture(results: Sequence[TransportLimits], names: Sequence[str] | None = None) -> PolarPicture:
    """Return the content of the polar plot; by default, ``names`` are the names of the engines."""
    if not results:
        raise HoldfastError(message("polar plot", "has no answers", "give at least one"))
    where = "polar plot: names"
    given = [result.engine for result in results] if names is None else checked_items(names, where, "names")
    named = [checked_name(name, where) for name in given]
    if len(named) != len(results):
        raise HoldfastError(message(where, f"{len(named)} names of {len(results)} answers", "give one for each"))
    first = results[0]
    return PolarPicture(
        f"{first.assembly.scene.name or 'assembly'}: largest acceleration of the carrier [m/s²]",
        f"{WORDS[first.verdict.status]} · {len(first.directions)} level directions, "
        "the distance from the centre is the largest acceleration that way",
        frame_names(first.assembly),
        tuple(_curve(result, name) for result, name in zip(results, named, strict=True)),
        _footprints(first.assembly, np.array(tangents(first.assembly.scene.up))),
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


def movers(result: Columns) -> list[str]:
    """Return for each row in words what gives way first; "" if nothing does."""
    pairs = zip(result.mode, result.moving, strict=True)
    return [f"{mode}: {listed(names, SHOWN)}" if names else "" for mode, names in pairs]


def _lines(result: TransportLimits, angle: Float) -> tuple[str, ...]:
    """Describe the smallest and the largest decided answer, what gives way first, and the undecided answers."""
    unknown = [result.undecided.brief] if result.undecided.count else []
    known = result.acceleration[result.answers.decided]
    if len(known) and (result.status[result.answers.decided] == Status.UNSTABLE).all():
        return ("does not stand on the carrier", *unknown)
    if not len(known):
        return tuple(unknown)
    if np.isinf(known).all():
        return ("nothing moves, however fast", *unknown)
    least = int(result.answers.ranking[0])
    names = result.moving[least]
    moving = listed(names, SHOWN)
    gives = f"{result.mode[least]}: {moving}" if moving else str(result.status[least])
    only = " (only balanced)" if result.status[least] is Status.FINITE and not result.acceleration[least] > 0 else ""
    degrees = np.round(np.degrees(angle), 1)
    lines = [f"least {number(float(result.acceleration[least]))}{only} at {degrees[least]:g}°, {gives}"]
    row, held = result.answers.holding, promised(result.answers)
    if held:
        lines.append(f"{held} in every direction, the least at {degrees[row]:g}°")
    lines.append(f"largest {number(float(known.max()))}")
    return (*lines, *unknown)


def _footprints(assembly: Assembly, frame: Float) -> tuple[Footprint, ...]:
    found = []
    for body in assembly.bodies:
        vertices = body.surface_world.vertices
        flat = vertices @ frame.T
        outline = flat[outline_numbers(flat)]
        found.append(Footprint(body.name, outline, body.fixed, float((vertices @ assembly.scene.up).max())))
    return tuple(found)
