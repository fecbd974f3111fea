"""Interfaces in canonical form, which does not depend on how they were found."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from holdfast.base.arrays import frozen
from holdfast.base.rigid import Frame, snapped
from holdfast.base.values import altered
from holdfast.contacts.interface import Interface, Patch
from holdfast.native import core


def canonical(interfaces: Sequence[Interface], flipped: Sequence[bool], frame: Frame) -> list[Interface]:
    """Return the same contacts in canonical form.

    Coordinates in ``frame`` are rounded, far below their accuracy. Every outline begins at its first corner in the
    order of these coordinates, and patches are in the order of these corners. Those that are ``flipped`` are seen from
    the other body: the order of the bodies and all normals are reversed. Each is kept with the contact.
    """
    about = frame.origin.tobytes(), frame.axes.tobytes()
    missing = [k for k, one in enumerate(interfaces) if (*about, flipped[k]) not in one.canonical]
    patches = [(patch, flipped[k]) for k in missing for patch in interfaces[k].patches]
    made = iter(_canonical_patches(patches, frame) if patches else [])
    for k in missing:
        one, own = interfaces[k], [next(made) for _ in interfaces[k].patches]
        if len(own) > 1:
            places = np.array([frame.seen(patch.polygon[0]) for patch in own])
            order = np.lexsort(snapped(places, float(np.abs(places).max()), core.FIRST).T[::-1])
            own = [own[number] for number in order.tolist()]
        bodies = one.bodies[::-1] if flipped[k] else one.bodies
        one.canonical.clear()  # bodies belong to one group at a time
        one.canonical[*about, flipped[k]] = altered(one, bodies=bodies, patches=tuple(own))
    return [one.canonical[*about, turned] for one, turned in zip(interfaces, flipped, strict=True)]


def _canonical_patches(patches: Sequence[tuple[Patch, bool]], frame: Frame) -> list[Patch]:
    """Return patches in canonical form, those flipped of which that is said."""
    rings = [(patch.polygon, *patch.holes) for patch, _ in patches]
    every = [ring for own in rings for ring in own]
    ring = np.cumsum([0, *map(len, rings)])
    corners, corner, normals, moments, centroids = (
        frozen(each)
        for each in core.canonical(
            (
                np.concatenate(every),
                np.cumsum([0, *map(len, every)]),
                ring,
                np.array([patch.normal for patch, _ in patches]),
                np.array([flipped for _, flipped in patches]),
            ),
            frame.origin,
            frame.axes,
        )
    )
    outlines = [frozen(corners[a:b]) for a, b in pairwise(corner.tolist())]
    found = []
    for k, ((patch, flipped), (first, last)) in enumerate(zip(patches, pairwise(ring.tolist()), strict=True)):
        spots = patch.spots
        if spots is not None:
            spots = (spots.flipped() if flipped else spots).canonical(frame, core.CANONICAL)
        outline, *holes = outlines[first:last]
        same = altered(patch, polygon=outline, normal=normals[k], holes=tuple(holes), spots=spots)
        if same.kind == "face" and spots is None:
            same.__dict__.update(moments=moments[k], centroid=centroids[k])
        found.append(same)
    return found
