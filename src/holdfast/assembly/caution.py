"""Warnings about an assembly that is made all the same: sizes that suggest other units, and bodies that overlap."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence

from holdfast.base.errors import HoldfastWarning, message
from holdfast.contacts.overlap import Overlap
from holdfast.scene.body import Body

HUGE = 50.0  # [m] a movable body larger than this is suspected to be given in other units
WORST = 5  # the most overlaps that one warning names


def warn_of_units(bodies: Iterable[Body], gap: float, *, stacklevel: int) -> None:
    """Warn if the sizes of the bodies suggest that they are given in millimetres instead of metres.

    With wrong units the contact search finds contacts everywhere, or nowhere.
    """
    movable = [body for body in bodies if not body.fixed]
    across = {body.name: float((body.box[1] - body.box[0]).max()) for body in movable}
    widest = max(across, key=lambda name: across[name], default=None)
    if widest is not None and across[widest] > HUGE:
        problem = f"is {across[widest]:.3g} m across"
        text = message(f"body {widest!r}", problem, "if its mesh is in millimetres, use scale 0.001")
        warnings.warn(text, HoldfastWarning, stacklevel=stacklevel)
    sizes = {body.name: body.shape.surface.thickness for body in movable}
    thin = min(sizes, key=lambda name: sizes[name], default=None)
    if thin is not None and gap > 0.5 * sizes[thin]:
        problem = f"is {gap * 1e3:.3g} mm, but body {thin!r} is only {sizes[thin] * 1e3:.3g} mm thick"
        text = message("gap", problem, "bodies may touch through it: gap is in metres, use a smaller one")
        warnings.warn(text, HoldfastWarning, stacklevel=stacklevel)


def warn_of_overlaps(overlaps: Sequence[Overlap], *, stacklevel: int) -> None:
    """Issue one warning for all overlapping pairs, beginning with the deepest."""
    worst = sorted(overlaps, key=lambda overlap: -overlap.depth)[:WORST]
    pairs = ", ".join(
        f"{a!r} and {b!r} by {'about ' if o.estimated else ''}{o.depth * 1e3:.3g} mm"
        for o in worst
        for a, b in [o.bodies]
    )
    more = f" and {len(overlaps) - WORST} more pairs" if len(overlaps) > WORST else ""
    errors = sum(o.severity == "error" for o in overlaps)
    deep = f"; {errors} deeper than twice that" if errors else ""
    problem = f"{pairs}{more}; the gap tolerance is {worst[0].tolerance * 1e3:.3g} mm{deep}"
    text = message("bodies overlap", problem, "correct the poses, or raise gap; contacts there may be missing")
    warnings.warn(text, HoldfastWarning, stacklevel=stacklevel)
