"""Numbers and tables of what was predicted and measured, made from the saved results of the suite ``experiments``."""

from __future__ import annotations

import math
from typing import Any

from bench.figures.saved_rows import Saved, listed, rounded, span, table, whole

SETS = ("feet at the corners", "feet askew", "feet half way in", "feet near the middle", "whole face")
METHODS = ("compliant", "limit", "graph", "μ m g")
MARGINS = {
    "compliant": "`force`",
    "0.9 compliant": "0.9 `force`",
    "0.8 compliant": "0.8 `force`",
    "lower": "`lower`",
    "lower, wooden faces": '`lower` with `Imperfect(2e-4, material="wood")`',
    "5 % quantile, friction within 10%": "5 % quantile, `mu_range=0.1`",
    "5 % quantile, friction within 20%": "5 % quantile, `mu_range=0.2`",
    "5 % quantile, friction within 30%": "5 % quantile, `mu_range=0.3`",
    "limit": "`force` of `limit`",
    "graph": "`force` of `graph`",
    "μ m g": "μ m g, whatever the point",
}
KINDS = {
    "toppling blocks": ("16 blocks", "five blocks"),
    "arches": ("arch",),
    "arch on a shaken base": ("shaken",),
    "brick walls": ("wall",),
    "overhangs": ("harmonic", "diamond", "inverted"),
    "three cylinders": ("three",),
    "block on a slope": ("block turned",),
}


def numbers(saved: Saved) -> dict[str, str]:
    """What sentences of several pages say of the pushes, the blocks and the arches."""
    sets = [saved.row(f"pushes, {name}") for name in SETS]
    blocks, anchor = saved.row("16 blocks: least tan φ"), saved.row("16 blocks: anchor at tan φ = 0.65 [kN/m]")
    arches = {count: saved.row(f"shaken arch, {count} voussoirs") for count in (7, 13)}
    band, fit = saved.row("whole face: band"), saved.row("pushes, R²")
    near = [saved.value(f"feet near the middle, moved out by {out} mm", "median") for out in (-2, 0, 2)]
    found = {
        "pushes": whole(sum(row["pushes"] for row in sets)),
        "turns": f"{sum(row['turn as predicted'] for row in sets)} of {sum(row['turn'] for row in sets)}",
        "band": f"{band['inside']} of {band['pushes']}",
        "below": span([whole(100 * (1 - pick(row["compliant"] for row in sets))) for pick in (max, min)]),
        "twice": whole(sum(row["measured twice"] for row in sets)),
        "tilts": listed(
            [
                f"{saved.value(_tilt(turn), 'compliant') - saved.value(_tilt(0), 'compliant'):.1f}"
                for turn in (10, 20, 30)
            ]
        ),
        "feet-moved": f"{near[0]:.2f} to {near[2]:.2f}, around {near[1]:.2f}",
        "friction-seen": _range([row["friction seen"] for row in sets[:-1]], 3),
        "friction-seen-face": f"{sets[-1]['friction seen']:.3f}",
        "fit-compliant": f"{fit['compliant']:.2f}",
        "fit-graph": f"{fit['graph']:.2f}",
        "fit-null": f"{fit['μ m g']:.2f}",
        "margin-08": _share("0.8 compliant", saved),
        "margin-lower": _share("lower", saved),
        "margin-mu": _share("5 % quantile, friction within 20%", saved),
        "blocks-exist": f"{blocks['limit']:.3f}",
        "blocks-rest": f"{blocks['compliant']:.3f}",
        "blocks-fine": f"{blocks['35 nodes']:.3f}",
        "anchor-limit": whole(anchor["limit"]),
        "anchor-compliant": whole(anchor["compliant"]),
        "anchor-fine": whole(anchor["35 nodes"]),
    }
    for count, row in arches.items():
        found |= {f"arch-{count}-{engine}": f"{row[engine]:.3f}" for engine in ("limit", "graph")}
        found[f"arch-{count}-over"] = whole(100 * (row["graph"] / row["limit"] - 1))
    peaks = {name: saved.row(f"16 blocks: forces between them, P12 to P1, {name}")["kN/m"] for name in _FORCES}
    off = {name: max(a / b - 1 for a, b in zip(force, peaks["printed"], strict=True)) for name, force in peaks.items()}
    return found | {
        "forces-coarse": whole(100 * off["7 nodes"]),
        "forces-fine": whole(100 * off["35 nodes"]),
        "forces-limit": rounded(1 + off["limit"], 1),
    }


_FORCES = ("printed", "7 nodes", "35 nodes", "limit")


def _tilt(turn: int) -> str:
    return f"block turned by {turn}°: dip at which it topples [°]"


def _range(values: list[float], decimals: int = 2) -> str:
    return span([f"{pick(values):.{decimals}f}" for pick in (min, max)])


def _share(margin: str, saved: Saved) -> str:
    return rounded(saved.value(f"margin: {margin}", "all, above %"), 3)


def tables(saved: Saved) -> dict[str, str]:
    """The pushes by set and by lever arm, what margins covered, and printed numbers by source and where they differ."""
    sets = []
    for name in SETS:
        row = saved.row(f"pushes, {name}")
        scatter = whole(100 * row["compliant, scatter"])
        turns = f"{row['turn as predicted']} of {row['turn']}"
        sets.append([name, f"{row['friction seen']:.3f}", *(f"{row[m]:.2f}" for m in METHODS), f"{scatter} %", turns])
    arms = [row for row in saved.rows if "arm mm" in row]
    ways = list(dict.fromkeys(row["case"].rsplit(", ", 1)[1] for row in arms))
    by_arm = []
    for kind in ("feet", "whole face"):
        for method in METHODS:
            groups = [[r[method] for r in arms if kind in r["set"] and r["case"].endswith(way)] for way in ways]
            by_arm.append([f"{kind}, {method}", *(_range(group) for group in groups)])
    margins = [
        [
            text,
            *(rounded(saved.value(f"margin: {name}", f"{kind}, above %"), 3) for kind in ("all", "feet", "whole face")),
            *(f"{saved.value(f'margin: {name}', f'all, {what}'):.2f}" for what in ("median", "most")),
        ]
        for name, text in MARGINS.items()
    ]
    heads = ["number", "all, %", "feet, %", "whole face, %", "median of it / measured", "most"]
    methods = ["`compliant`", "`limit`", "`graph`", "μ m g"]
    return {
        "sets": table(
            ["50 pushes each", "μ of central pushes", *methods, "scatter of `compliant`", "turns as predicted"], sets
        ),
        "arms": table(["predicted / measured", *ways], by_arm),
        "margins": table(heads, margins),
        "sources": _sources(saved),
        "differences": _differences(saved),
    }


def _sources(saved: Saved) -> str:
    lines = []
    for kind, starts in KINDS.items():
        rows = [row for row in saved.rows if "printed" in row and row["case"].startswith(starts)]
        ladder = [row for row in rows if "falls to %" in row]
        falls = [row["falls to %"] for row in ladder]
        stands = [float(row["stands from %"]) for row in ladder]
        doubt = f"{min(falls):g} to +{max(stands):g} %" if ladder and math.isfinite(max(stands)) else "–"
        if ladder and not math.isfinite(max(stands)):
            doubt = f"{min(falls):g} % to beyond +20 %"
        lines.append([kind, str(len(rows)), str(sum(row["agrees"] for row in rows)), doubt])
    return table(
        ["source", "numbers printed", "agree to the last digit", "verdict of `compliant` may be in doubt"], lines
    )


def _differences(saved: Saved) -> str:
    rows = [row for row in saved.rows if row.get("why")]
    engines = ("limit", "compliant", "graph")
    heads = ["", "printed", *(f"`{engine}`" for engine in engines), "why"]
    cells = [[row["case"], row["printed"], *(_like(row, e) for e in engines), row["why"]] for row in rows]
    return table(heads, cells, numbers_from=len(heads))


def _like(row: dict[str, Any], engine: str) -> str:
    """A prediction with as many decimals as what is printed."""
    value = row.get(engine, "–")
    return value if isinstance(value, str) else f"{value:,.{len(row['printed'].partition('.')[2])}f}"
