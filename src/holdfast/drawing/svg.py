"""Small charts as SVG: shares, histograms, and limits around a circle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from holdfast.base.arrays import Bool, Float
from holdfast.base.text import escaped
from holdfast.drawing.colours import GREY, number

WIDTH: Final = 460  # of a chart [px]
HEIGHT: Final = 130  # of a histogram without its labels [px]
BINS: Final = 24  # of a histogram

SIZE: Final = 220  # width and height of the plot [px]
_RADIUS: Final = 80.0  # radius of the outer ring [px]
_CURVE: Final = "#d9622b"  # colour of the curve, with contrast on white and on black
_UNKNOWN: Final = "#8f7fc4"  # colour of undecided directions
_PLENTY: Final = 1.3  # limit at the outer ring, as a multiple of the largest finite one, if others are infinite


def bar(counts: Mapping[str, int], colours: Mapping[str, str]) -> str:
    """Return shares as one bar of coloured pieces with a legend; "" if all counts are zero."""
    total = sum(counts.values())
    if not total:
        return ""
    pieces, legend, left = [], [], 0.0
    for name, count in counts.items():
        width = WIDTH * count / total
        colour = colours.get(name, GREY)
        pieces.append(f'<rect x="{left:.2f}" y="0" width="{width:.2f}" height="26" fill="{colour}"/>')
        legend.append(
            f'<span><i style="background:{colour}"></i>{escaped(name)} {count:,} ({count / total:.1%})</span>'
        )
        left += width
    box = f'<svg width="{WIDTH}" height="26" viewBox="0 0 {WIDTH} 26" role="img">{"".join(pieces)}</svg>'
    return f'<figure>{box}<figcaption class="legend">{"".join(legend)}</figcaption></figure>'


def histogram(title: str, values: Sequence[float], unit: str, *, logarithmic: bool = False) -> str:
    """Return a histogram of the finite values; infinite values, and zeros on a logarithmic scale, are counted aside."""
    finite = np.array([v for v in values if math.isfinite(v) and (v > 0 or not logarithmic)], dtype=float)
    aside = [f"{sum(math.isinf(v) for v in values):,} infinite"] if any(map(math.isinf, values)) else []
    aside += [f"{sum(v <= 0 for v in values):,} at 0"] if logarithmic and any(v <= 0 for v in values) else []
    heading = f"<h3>{escaped(title)}{f' [{escaped(unit)}]' if unit else ''}</h3>"
    note = f"<p>{len(finite):,} scenes{''.join(f', {text}' for text in aside)}</p>"
    if not len(finite):
        return f"<figure>{heading}{note}</figure>" if values else ""
    scaled = np.log10(finite) if logarithmic else finite
    low, high = float(scaled.min()), float(scaled.max())
    if high - low < 1e-9 * max(abs(high), 1.0):
        low, high = low - 0.5, high + 0.5
    counts, _ = np.histogram(scaled, BINS, (low, high))
    step, most = WIDTH / BINS, int(counts.max())
    bars = [
        f'<rect x="{k * step + 1:.2f}" y="{HEIGHT * (1 - n / most):.2f}" width="{step - 2:.2f}" '
        f'height="{HEIGHT * n / most:.2f}" fill="#4a78b5"><title>{n:,}</title></rect>'
        for k, n in enumerate(counts.tolist())
    ]
    ends = [(0, "start"), (WIDTH / 2, "middle"), (WIDTH, "end")]
    places = [low, (low + high) / 2, high]
    labels = [
        f'<text x="{x:.0f}" y="{HEIGHT + 16}" text-anchor="{anchor}">{10**v if logarithmic else v:.3g}</text>'
        for (x, anchor), v in zip(ends, places, strict=True)
    ]
    box = f'<svg width="{WIDTH}" height="{HEIGHT + 20}" viewBox="0 0 {WIDTH} {HEIGHT + 20}" role="img">'
    rule = f'<line x1="0" x2="{WIDTH}" y1="{HEIGHT}" y2="{HEIGHT}" stroke="#b9bec7"/>'
    return f"<figure>{heading}{box}{''.join(bars)}{rule}{''.join(labels)}</svg>{note}</figure>"


def rose(angle: Float, limit: Float, known: Bool, unit: str, axes: Sequence[str]) -> str:
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
