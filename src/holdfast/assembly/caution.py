"""Warnings about a scene: numbers that suggest wrong units or another origin, and bodies that overlap."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

import numpy as np

from holdfast.base.errors import HoldfastError, SceneError, message, warn
from holdfast.base.text import listed, quoted
from holdfast.contacts.interface import Interface
from holdfast.contacts.overlap import MISPLACED, Overlap
from holdfast.geometry.surface import IDENTITY
from holdfast.scene.body import Body
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.scene import Scene, like_radians

HUGE = 50.0  # [m] the units of a movable body larger than this are probably wrong
# [m] If no movable body is smaller than the first and half of them are larger than the second, as cups and boxes are in
# millimetres, the units of the whole scene are wrong
SMALL_AMONG_HUGE, USUAL_AMONG_HUGE = 2.0, 20.0
ASIDE = 1.0  # [sizes of the body] if a centre of mass is farther outside, its units are probably wrong
WORST = 5  # largest number of overlaps in one warning, and of bodies with a note of the same kind
# [kg/m³] Osmium has 22,600 and air 1.2, so densities beyond these limits have wrong units. The lower limit is below 1,
# because models in publications have a density of 1, less what their meshes lose
HEAVIEST, LIGHTEST = 25_000.0, 0.9
# [-] ratio to the largest other movable body above which a size is suspicious. A body in millimetres among others in
# metres is a thousand times too large, but may be smaller than the others in reality
OUTSIZE = 300.0
STRONGEST = 3.0  # [-] friction above this is a mistake: clean rubber, metal in a vacuum and the like have less


def check_units(bodies: Iterable[Body]) -> None:
    """Raise SceneError if the sizes of all movable bodies say that they are given in millimetres instead of metres."""
    across = {body.name: body.across for body in bodies if not body.fixed}
    if not across or min(across.values()) < SMALL_AMONG_HUGE or np.median([*across.values()]) < USUAL_AMONG_HUGE:
        return
    smallest = min(across, key=lambda name: across[name])
    problem = f"the smallest of {len(across):,} movable bodies, {quoted(smallest)}, is {across[smallest]:.3g} m across"
    remedy = "are the sizes in millimetres? Give metres (meshes: scale 0.001), or say allow_large=True"
    raise SceneError(message("scene", problem, remedy))


def check_copies(scene: Scene) -> None:
    """Raise SceneError if bodies with the same shape have the same pose, as happens if a scene is assembled twice.

    They would overlap completely. Fixed bodies may coincide, and so may bodies that never touch (``excluded``).
    """
    places: dict[bytes, list[Body]] = {}
    for body in scene.bodies:
        if not isinstance(body.shape, HalfSpace):
            low, high = body.box
            places.setdefault(body.pose.tobytes() + low.tobytes() + high.tobytes(), []).append(body)
    for first, *others in places.values():
        alike = [b for b in others if b.shape == first.shape and not (b.fixed and first.fixed)]
        alike = [b for b in alike if scene.touching(first, b)]
        if alike:
            names = listed([quoted(body.name) for body in (first, *alike)], WORST)
            problem = f"are {len(alike) + 1:,} bodies of one shape in one place"
            raise SceneError(message(names, problem, "move them apart, or leave all but one out"))


def doubts_of_scene(
    scene: Scene, interfaces: Sequence[Interface] = (), overlaps: Sequence[Overlap] = ()
) -> tuple[str, ...]:
    """Return notes on what looks like a mistake.

    Densities, sizes and angles that suggest other units; at ``interfaces``, more friction than there is; and at
    ``overlaps``, bodies with their middle where their foot should be.
    """
    mu = {i.bodies: scene.mu(*i.bodies) if i.mu is None else i.mu for i in interfaces}
    rough = [f"{a} and {b} ({mu[a, b]:g})" for a, b in mu if mu[a, b] > STRONGEST]
    notes = [f"friction is above {STRONGEST:g}, which hardly any pair has, of {listed(rough, WORST)}"] if rough else []
    sunk = [text for overlap in overlaps if (text := _sunk(scene, overlap))]
    return (*doubts(scene.movable), *_doubts_of_angles(scene.bodies), *notes, *sunk[:WORST])


def doubts(bodies: Sequence[Body]) -> tuple[str, ...]:
    """Return notes on movable bodies whose density or size suggests that they are given in other units."""
    across = {body.name: body.across for body in bodies}
    dense = [f"{body.name}: {doubt}" for body in bodies if (doubt := _dense(body))]
    notes = dense[:WORST] + ([f"and {len(dense) - WORST:,} more bodies like that"] if len(dense) > WORST else [])
    widest = sorted(across, key=lambda name: across[name])[-2:]
    if widest and across[widest[-1]] > HUGE:
        notes.append(f"{widest[-1]}: {across[widest[-1]]:.3g} m across: is its size in millimetres?")
    elif len(widest) > 1 and across[widest[1]] > OUTSIZE * across[widest[0]]:
        times = f"{across[widest[1]] / across[widest[0]]:,.0f} times as large as any other body that can move"
        notes.append(f"{widest[1]}: {across[widest[1]]:.3g} m across, {times}: is its size in millimetres?")
    return tuple(notes)


def _doubts_of_angles(bodies: Sequence[Body]) -> tuple[str, ...]:
    """Return a note if the roll, pitch and yaw of all bodies look like radians where degrees are meant."""
    turns = np.array([body.pose for body in bodies])[:, :3, :3]
    if (turns == IDENTITY).all():
        return ()
    x, y, z = turns[:, 2, 1], turns[:, 2, 0], turns[:, 2, 2]
    angles = np.degrees([np.arctan2(x, z), -np.arcsin(np.clip(y, -1, 1)), np.arctan2(turns[:, 1, 0], turns[:, 0, 0])])
    if not like_radians(angles.ravel()):
        return ()
    k = int(np.argmax(np.abs(angles).max(0)))
    largest = float(np.abs(angles[:, k]).max())
    said = f"{bodies[k].name} is turned by {largest:.5g} degrees: are these radians? {largest:.5g} rad are"
    return (f"{said} {np.degrees(largest):.3g} degrees",)


def _sunk(scene: Scene, overlap: Overlap) -> str:
    """Return what is odd if one of two bodies lies on the other with its middle, not its foot; else ""."""
    for name, below in (overlap.bodies, overlap.bodies[::-1]):
        own, under = (scene.body(each).surface_world.vertices @ scene.up for each in (name, below))
        half = float(np.ptp(own)) / 2
        if not scene.body(name).fixed and abs(own.min() + half - under.max()) <= overlap.tolerance:
            what = f"{name} sinks by half its height into {below}: the origin of a shape is its middle"
            return f"{what}: put it {half:.4g} m higher, or read the file with on_floor=True (--on-floor)"
    return ""


def _dense(body: Body) -> str:
    """Return what is odd about the density of a movable body; "" if nothing is, or if its shape has no volume."""
    try:
        volume = body.shape.mass_properties.volume
    except HoldfastError:
        return ""
    density = 0.0 if body.mass is None else body.mass / volume
    if LIGHTEST <= density <= HEAVIEST:
        return ""
    what = "heavier than any material" if density > HEAVIEST else "lighter than air"
    amount = f"{body.mass:,.6g} kg in {1e3 * volume:,.3g} litres, {density:,.3g} kg/m³"
    return f"{amount}, is {what}: are these kilograms and metres?"


def warn_of_bodies(bodies: Collection[Body], gap: float | None, *, allow_large: bool) -> None:
    """Warn of huge bodies, unless allowed, of odd centres of mass, and of bodies thinner than the ``gap`` [m]."""
    if not allow_large:
        warn_of_huge(bodies)
    warn_of_centres(bodies)
    if gap is not None:
        warn_of_gap(bodies, gap)


def warn_of_huge(bodies: Iterable[Body]) -> None:
    """Warn if the largest movable body suggests that its mesh is given in millimetres instead of metres."""
    across = {body.name: body.across for body in bodies if not body.fixed}
    widest = max(across, key=lambda name: across[name], default=None)
    if widest is not None and across[widest] > HUGE:
        problem = f"is {across[widest]:.3g} m across"
        warn(message(f"body {quoted(widest)}", problem, "if its mesh is in millimetres, use scale 0.001"))


def warn_of_centres(bodies: Iterable[Body]) -> None:
    """Warn if a centre of mass lies outside its body by more than ASIDE sizes; name the worst of the movable bodies.

    A centre of mass must be inside the convex hull of all mass, but a shape may be only a part of what has mass, such
    as the pad of a robot, so this is not an error.
    """
    aside = {body.name: _aside(body) for body in bodies if body.com is not None and not body.fixed}
    far = max(aside, key=lambda name: aside[name], default=None)
    if far is not None and aside[far] > ASIDE:
        problem = f"its centre of mass lies outside of it, {aside[far]:.3g} times its size away"
        warn(message(f"body {quoted(far)}", problem, "is com= in metres, in the frame of the body?"))


def _aside(body: Body) -> float:
    """Return the distance of the centre of mass from the box in the body frame, over the diagonal of the box."""
    surface = body.shape.surface
    low, high = surface.vertices.min(0), surface.vertices.max(0)
    outside = np.maximum(0.0, np.maximum(low - body.com_body, body.com_body - high))
    return float(np.linalg.norm(outside)) / surface.diagonal


def warn_of_gap(bodies: Iterable[Body], gap: float) -> None:
    """Warn if the gap is so large, perhaps given in millimetres, that contacts are found through a body."""
    sizes = {body.name: body.shape.surface.thickness for body in bodies if not body.fixed}
    thin = min(sizes, key=lambda name: sizes[name], default=None)
    if thin is not None and gap > 0.5 * sizes[thin]:
        problem = f"is {gap * 1e3:.3g} mm, but body {quoted(thin)} is only {sizes[thin] * 1e3:.3g} mm thick"
        warn(message("gap", problem, "bodies may touch through it: gap is in metres, use a smaller one"))


def warn_of_overlaps(overlaps: Sequence[Overlap]) -> None:
    """Issue one warning for all overlapping pairs, if any: each one if they are few, else how many and the deepest."""
    if not overlaps:
        return
    worst = sorted(overlaps, key=lambda overlap: -overlap.depth)[:WORST]
    named = [
        f"{quoted(a)} and {quoted(b)} by {'about ' if o.estimated else ''}{o.depth * 1e3:.3g} mm"
        for o in worst
        for a, b in [o.bodies]
    ]
    pairs = ", ".join(named) if len(overlaps) <= WORST else f"{len(overlaps):,} pairs, the deepest {named[0]}"
    errors = sum(o.severity == "error" for o in overlaps)
    deep = f"; {errors:,} deeper than twice that" if errors and len(overlaps) > 1 else ""
    problem = f"{pairs}; the gap tolerance is {worst[0].tolerance * 1e3:.3g} mm{deep}"
    remedy = MISPLACED if worst[0].misplaced else "correct the poses, or raise gap; contacts there may be missing"
    warn(message("bodies overlap", problem, remedy))
