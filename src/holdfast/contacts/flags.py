"""Flags of an interface, which warn that its contacts depend on a tolerance, a pose or a mesh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from holdfast.contacts.interface import Patch
from holdfast.geometry.distance import distance_to_surface
from holdfast.scene.body import Body

SHAKY = 0.5  # separation or depth, relative to the gap, above which another gap may give another contact
DOUBTFUL = frozenset({"ambiguous_gap", "fragile", "sliver", "occluded"})  # flags of contacts that may not exist
EXACT = 1e-3  # separation, relative to the gap, up to which surfaces touch exactly, up to rounding
ALIKE = float(np.cos(np.radians(20)))  # cosine of the largest angle between a patch and the triangle on which it lies
FRAGILE = 0.5  # least share of the face area that remains when a body is moved sideways by the gap


def flags_of(a: Body, b: Body, patches: Sequence[Patch], gap: float, *, hidden: bool) -> tuple[str, ...]:
    """Return the flags of the interface of two bodies.

    ``patches`` are what remains after occlusion, and ``hidden`` says whether a third body hides a part.

    - sliver: every patch is narrower than the gap or lies within the gap of a sharp edge, so the bodies may separate if
      one is moved sideways by the gap.
    - fragile: the bodies may lose half of the contact area if one is moved sideways by the gap.
    - ambiguous_gap: surfaces are somewhere further apart, or overlap by more, than half the gap, so another gap gives
      another interface.
    - facet: a face lies on a facet that represents a curved surface, or a line lies on such a facet of a mesh. If the
      real surface is smooth, it touches elsewhere, along a line or at a point, and the body may roll.
    - occluded: a third body between the two hides a part.
    - not_manifold: a surface is not closed, so the overlap is estimated.
    - orientation_unknown: it is not known which side of a surface is the inside.
    """
    flags = []
    faces = kept = widest = farthest = 0.0
    for patch in patches:
        room = patch.room
        widest = max(widest, room)
        if patch.kind == "face":
            area = patch.area
            faces += area
            kept += area * max(0.0, 1 - gap / room)
        if patch.separation is not None:
            low, high = patch.separation
            farthest = max(farthest, abs(low), abs(high))
    if widest < gap:
        flags.append("sliver")
    if kept < FRAGILE * faces or (not faces and widest < gap / FRAGILE):
        flags.append("fragile")
    if farthest > SHAKY * gap:
        flags.append("ambiguous_gap")
    if _on_facet(a, patches, 1.0) or _on_facet(b, patches, -1.0):
        flags.append("facet")
    if hidden:
        flags.append("occluded")
    one, two = a.shape.surface, b.shape.surface
    if not (one.closed and two.closed):
        flags.append("not_manifold")
    if not (one.oriented and two.oriented):
        flags.append("orientation_unknown")
    return tuple(flags)


def _on_facet(body: Body, patches: Sequence[Patch], outward: float) -> bool:
    """Tell whether the middle of a face, or of a line on a mesh, lies on a triangle that represents a curved surface.

    Lines on shapes with a known sagitta are exact and do not count. ``outward`` is 1 if the normals of the patches
    point out of the body, and -1 if they point into it.
    """
    surface = body.shape.surface
    if not surface.bends:
        return False
    for patch in patches:
        if patch.kind != "face" and (patch.kind != "line" or surface.sagitta > 0):
            continue
        alike = outward * (surface.normals @ (patch.normal @ body.pose[:3, :3])) >= ALIKE
        if (alike & surface.curved).any():
            middle = ((patch.polygon.mean(0) - body.pose[:3, 3]) @ body.pose[:3, :3])[None]
            curved, flat = (
                distance_to_surface(middle, replace(surface, faces=surface.faces[alike & which]))
                for which in (surface.curved, ~surface.curved)
            )
            if curved[0] < flat[0]:
                return True
    return False


def is_certain(patches: Sequence[Patch], flags: Sequence[str], *, gap: float, usual: float, sagitta: float) -> bool:
    """Tell whether two bodies certainly touch, if their poses are as given.

    ``gap`` is the gap of the search and ``usual`` the default gap of the scene; ``sagitta`` is how far the meshes of
    the two bodies may lie inside their true surfaces, all [m]. The bodies may not touch if they are further apart than
    the default gap accepts, or if one of the flags DOUBTFUL is set. Flags do not count if the surfaces touch exactly
    and the gap is not wider than the default, because such a gap only allows for rounding.
    """
    apart = min((patch.separation[0] for patch in patches if patch.separation is not None), default=0.0) - sagitta
    if apart > usual:
        return False
    return DOUBTFUL.isdisjoint(flags) or (gap <= usual and apart <= EXACT * gap)
