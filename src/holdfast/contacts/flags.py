"""What an interface has to say about itself: which of its contacts depend on a tolerance, a pose or a mesh."""

from __future__ import annotations

from collections.abc import Sequence

from holdfast.contacts.interface import Patch
from holdfast.scene.body import Body

SHAKY = 0.5  # share of the gap tolerance: surfaces further apart, or deeper, touch by the tolerance alone
FRAGILE = 0.5  # share of its area that a patch may lose when a body is moved sideways within the gap


def flags_of(a: Body, b: Body, patches: Sequence[Patch], gap: float, *, hidden: bool) -> tuple[str, ...]:
    """Of the interface of two bodies, ``patches`` after what ``hidden`` ones lost.

    sliver: every patch is narrower than the gap, or lies within it of a sharp edge: moved sideways within the gap, the
    bodies part. fragile: so moved, they may lose half of the area. ambiguous_gap: surfaces somewhere lie further apart,
    or deeper in each other, than half the gap, so that another gap gives another interface. occluded: a third body in
    between hides a part. not_manifold: a surface does not close, so that overlap is estimated. orientation_unknown: it
    cannot be told which side of a surface is the inside.
    """
    flags = []
    if all(patch.room < gap for patch in patches):
        flags.append("sliver")
    faces = sum(patch.area for patch in patches)
    kept = sum(patch.area * max(0.0, 1 - gap / patch.room) for patch in patches if patch.kind == "face")
    if kept < FRAGILE * faces or (not faces and all(patch.room < gap / FRAGILE for patch in patches)):
        flags.append("fragile")
    if any(max(map(abs, patch.separation)) > SHAKY * gap for patch in patches if patch.separation is not None):
        flags.append("ambiguous_gap")
    if hidden:
        flags.append("occluded")
    if not all(body.shape.surface.reduced.topology.closed for body in (a, b)):
        flags.append("not_manifold")
    if not all(body.shape.surface.oriented for body in (a, b)):
        flags.append("orientation_unknown")
    return tuple(flags)
