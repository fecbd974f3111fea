"""Limits by direction as a small polar plot in SVG, for notebooks: lines and letters take the colour of the page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from holdfast.drawing.colours import number

SIZE: Final = 220  # width and height of the plot [px]
_RADIUS: Final = 80.0  # radius of the outer ring [px]
_CURVE: Final = "#d9622b"  # colour of the curve, with contrast on white and on black
_UNKNOWN: Final = "#8f7fc4"  # colour of undecided directions
_PLENTY: Final = 1.3  # limit at the outer ring, as a multiple of the largest finite one, if others are infinite


def rose(
    angle: NDArray[np.float64], limit: NDArray[np.float64], known: NDArray[np.bool_], unit: str, axes: Sequence[str]
) -> str:
    """Return limits (n,) at angles (n,) [rad] as an SVG; those that are not ``known`` (n,) are dots on the ring.

    The distance of the curve from the middle is the limit; infinite ones lie on the ring. ``axes`` are the names of the
    directions at 0, 90, 180 and 270 degrees, counted anticlockwise from the right.
    """
    order = np.argsort(angle, kind="stable")
    angle, limit, known = angle[order], limit[order], known[order]
    finite = limit[known & np.isfinite(limit)]
    most = float(finite.max(initial=0.0)) or 1.0
    end = most * (_PLENTY if np.isinf(limit[known]).any() else 1.0)
    reach = np.where(known, np.minimum(limit, end) / end, 1.0)
    x, y = _RADIUS * reach * np.cos(angle), -_RADIUS * reach * np.sin(angle)
    path = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x[known], y[known], strict=True))
    parts = [f'<polygon points="{path}" fill="{_CURVE}" fill-opacity="0.3" stroke="{_CURVE}" stroke-width="1.6"/>']
    parts += [
        f'<circle cx="{a:.1f}" cy="{b:.1f}" r="2.5" fill="{_UNKNOWN}"/>'
        for a, b in zip(x[~known], y[~known], strict=True)
    ]
    rings = "".join(f'<circle r="{_RADIUS * share:g}"/>' for share in (0.5, 1.0))
    cross = f'<path d="M-{_RADIUS:g} 0H{_RADIUS:g}M0 -{_RADIUS:g}V{_RADIUS:g}"/>'
    ends = ((_RADIUS + 12, 4), (0, -_RADIUS - 8), (-_RADIUS - 12, 4), (0, _RADIUS + 18))
    letters = [f'<text x="{a:g}" y="{b:g}">{name}</text>' for (a, b), name in zip(ends, axes, strict=True)]
    letters.append(f'<text x="{_RADIUS * 0.72:.0f}" y="{_RADIUS * 0.85:.0f}">{number(end)} {unit}</text>')
    half = SIZE / 2
    return (
        f'<svg width="{SIZE}" height="{SIZE}" viewBox="{-half:g} {-half:g} {SIZE} {SIZE}" role="img">'
        f'<g fill="none" stroke="currentColor" stroke-opacity="0.35">{rings}{cross}</g>{"".join(parts)}'
        f'<g fill="currentColor" font-size="12" text-anchor="middle">{"".join(letters)}</g></svg>'
    )
