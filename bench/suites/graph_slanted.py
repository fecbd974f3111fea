"""How often engine ``graph`` exceeds the certain bound of ``limit``: straight and slanted pushes, random assemblies."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, BinaryIO

import numpy as np

from bench.scenes.random_assemblies import FAMILIES, standing
from bench.scenes.random_pushes import columns, random_pushes
from bench.suite import Case, Row, Suite, table
from holdfast.base.arrays import Float
from holdfast.engines.graph.engine import Graph
from holdfast.engines.limit_engine import Limit
from holdfast.engines.verdict import Status

ASSEMBLIES = 10  # assemblies of each family
PUSHES = 20  # pushes of each kind on each assembly
SLANTS = {"straight": 0.0, "slanted": 60.0}  # degrees: the cone about the inward normal that directions come from
SEED = 14
ABOVE = 1e-6  # relative: a smaller excess over the bound is rounding
FAR = 0.1  # relative: an excess that matters
QUANTILES = (5, 25, 50, 75, 95)
COUNTS = ("above", "above by a tenth", "infinite", "below half")  # columns that count bounded pushes
SHOWN = (0.06, 60)  # ratios in the picture; smaller ones end at its border
ANSWERED = (Status.FINITE, Status.INFINITE)


def counted(case: str, force: Float, lower: Float, upper: Float) -> Row:
    """Count how the answers of ``graph`` (n,) lie to the bounds (n,) that ``limit`` proves, all in newtons.

    Only pushes with a finite upper bound are compared ("bounded"). An infinite answer to one of them counts as above
    the bound, too. "below half" compares with the lower bound. Quantiles are those of the ratio force / upper, and
    "worst" is the largest finite one.
    """
    bounded = np.isfinite(upper) & (upper > 0)
    row: Row = {
        "case": case,
        "pushes": len(force),
        "bounded": int(bounded.sum()),
        "finite where limit is infinite": int((np.isfinite(force) & np.isinf(lower)).sum()),
        **dict.fromkeys(COUNTS, 0),
    }
    if not bounded.any():
        return row
    ratio = force[bounded] / upper[bounded]
    marks = (ratio > 1 + ABOVE, ratio > 1 + FAR, np.isinf(ratio), force[bounded] < lower[bounded] / 2)
    row |= {name: int(mark.sum()) for name, mark in zip(COUNTS, marks, strict=True)}
    row["worst"] = float(ratio[np.isfinite(ratio)].max(initial=0))
    # a value that occurs: nothing lies between a finite ratio and an infinite one
    found = np.percentile(ratio, QUANTILES, method="inverted_cdf")
    return row | {f"{q} %": float(value) for q, value in zip(QUANTILES, found, strict=True)}


def family_rows(name: str) -> list[Row]:
    """Ask both engines about random pushes on random assemblies of a family: one row for each kind of push."""
    rng = np.random.default_rng([SEED, list(FAMILIES).index(name)])
    asked: dict[str, list[tuple[Float, Float, Float]]] = {kind: [] for kind in SLANTS}
    undecided = dict.fromkeys(SLANTS, 0)
    for _ in range(ASSEMBLIES):
        assembly = standing(FAMILIES[name], rng)
        graph, limit = Graph().prepare(assembly), Limit().prepare(assembly)
        for kind, slant in SLANTS.items():
            W = columns(assembly, random_pushes(assembly, rng, PUSHES, slant=slant))
            found, certain = graph.load_factor(W), limit.load_factor(W)
            answered = np.isin(found.status, ANSWERED) & np.isin(certain.status, ANSWERED)
            asked[kind].append((found.force[answered], certain.lower[answered], certain.upper[answered]))
            undecided[kind] += int((~answered).sum())
    return [
        {**counted(f"{name}, {kind}", *map(np.concatenate, zip(*parts, strict=True))), "undecided": undecided[kind]}
        for kind, parts in asked.items()
    ]


def cases() -> Mapping[str, Case]:
    return {name: partial(family_rows, name) for name in FAMILIES}


def total(rows: list[Row], kind: str) -> Row:
    """Sum up all families for one kind of push."""
    some = [row for row in rows if row["case"].endswith(f", {kind}")]
    sums = {name: sum(row[name] for row in some) for name in ("pushes", "bounded", *COUNTS)}
    return {"case": f"all, {kind}", **sums, "worst": max(row.get("worst", 0.0) for row in some)}


def share(row: Row, name: str) -> float:
    """Return a count as percent of the bounded pushes."""
    return float(100 * row[name] / max(row["bounded"], 1))


def written(rows: list[Row]) -> str:
    """Return a table of all families and their sum, with shares of the bounded pushes instead of counts."""
    shown = [
        {f"{key} %" if key in COUNTS else key: share(row, key) if key in COUNTS else row[key] for key in row}
        for row in [*rows, *(total(rows, kind) for kind in SLANTS)]
    ]
    return f"{table(shown)}\n\nShares are of the pushes that `limit` bounds; quantiles are of graph / upper bound."


def plot(rows: list[Row], file: BinaryIO) -> None:
    """Draw the share above the certain bound, and the ratio to it, for every family."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 6.4), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=(1, 1.35))
    families = list(dict.fromkeys(row["case"].split(", ")[0] for row in rows))
    by_case = {row["case"]: row for row in rows}
    for kind, colour, shift in (("straight", "#4a90bf", -0.19), ("slanted", "#b5173f", 0.19)):
        found = [by_case[f"{name}, {kind}"] for name in families]
        at = np.arange(len(families), dtype=np.float64) + shift
        above, far = ([share(row, name) for row in found] for name in ("above", "above by a tenth"))
        left.barh(at, above, 0.36, color=colour, alpha=0.3, label=f"{kind}: above the bound")
        left.barh(at, far, 0.36, color=colour, label=f"{kind}: by more than a tenth")
        for y, wide in zip(at, above, strict=True):
            left.text(wide + 1, y, f"{wide:.0f}", va="center", fontsize=8, color="#444444")
        _boxes(right, at, found, colour)
    left.set_yticks(np.arange(len(families)), families)
    left.invert_yaxis()
    left.set_xlim(0, 100)
    left.set_xlabel("answers above the certain bound [%]")
    left.legend(frameon=False, fontsize=8, loc="lower left", bbox_to_anchor=(0, 1), ncols=2, columnspacing=1)
    right.set_xscale("log")
    right.set_xlim(*SHOWN)
    ticks = (0.1, 0.3, 1, 3, 10, 30)
    right.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    right.minorticks_off()
    right.axvline(1, color="#222222", linewidth=1)
    right.set_title("right of the line something moves for certain", fontsize=9, loc="right")
    right.set_xlabel("graph / upper bound of limit   (box: middle half; line: 5 to 95 %; dot: worst)")
    figure.suptitle("Engine graph against the certain bound of engine limit", fontsize=13)
    for axes in (left, right):
        axes.grid(axis="x", alpha=0.3)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(file, dpi=130)


def _boxes(axes: Any, at: Float, rows: list[Row], colour: str) -> None:  # noqa: ANN401 - of matplotlib
    """Draw quantiles and the worst ratio of each row; an infinite quantile is drawn at the worst ratio."""
    for y, row in zip(at, rows, strict=True):
        if not row["bounded"]:
            continue
        found = [np.clip(float(row[f"{q} %"]), SHOWN[0], row["worst"]) for q in QUANTILES]
        low, first, middle, third, high = found
        axes.plot([low, high], [y, y], color=colour, linewidth=1.2)
        axes.barh(y, third - first, 0.3, left=first, color=colour)
        axes.plot([middle, middle], [y - 0.17, y + 0.17], color="#222222", linewidth=1.5)
        axes.plot(row["worst"], y, "o", color=colour, markersize=4)


SUITE = Suite("graph_slanted", __doc__, cases, plot, written)
