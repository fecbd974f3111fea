"""Numbers within the sentences of the pages, each made from the saved results of one benchmark suite.

A name is "suite.figure" (or "one+other.figure" of two suites); the text is what stands on the page, without its unit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from bench.figures import predicted
from bench.figures.saved_rows import Saved, listed, mean, rounded, span, whole

SCENES = ("cube", "stack", "table")


def pipeline(saved: Saved) -> dict[str, str]:
    """From mesh files to a map of 1,000 points by ``graph``, on cube, stack and table."""
    ours = [whole(1000 * seconds) for seconds in saved.values(SCENES, "median s")]
    paper = [whole(1000 * seconds) for seconds in saved.values(SCENES, "paper s")]
    return {
        "milliseconds": listed(ours),
        "paper-milliseconds": listed(paper),
    }


def scaling(saved: Saved) -> dict[str, str]:
    """How the time of a push grows with the number of bricks in a wall."""
    ratio = {row["bodies"]: row["compliant / limit"] for row in saved.rows}
    return {
        "bricks": whole(max(ratio)),
        "limit-push-of-all-bricks": rounded(saved.rows[-1]["limit query s"], 1),
    }


def bounds(saved: Saved) -> dict[str, str]:
    """How close the bounds of ``limit`` are in ill-conditioned scenes."""
    rows = [row for row in saved.rows if "queries" in row]
    if any(row["truth outside"] for row in rows):
        raise ValueError("a truth lies outside its bounds: the page says that none does")
    count = sum(row["queries"] for row in rows)
    return {"queries": whole(count), "narrow": whole(100 * sum(row["narrow"] for row in rows) / count)}


def table1(saved: Saved) -> dict[str, str]:
    """Table I of the paper, done again."""

    def errors(methods: tuple[str, ...], column: str, scenes: tuple[str, ...]) -> list[float]:
        return [saved.value(f"{scene}: {method}", f"{column}: error %") for scene in scenes for method in methods]

    def ends(values: list[float]) -> str:
        return span([whole(min(values)), whole(max(values))])

    piles, coupled = SCENES[:2], "coupled, own points"
    slower = [
        saved.value(f"{scene}: polygon {sides}, IPOPT", "1,000 pushes s")
        / saved.value(f"{scene}: polygon {sides}", "1,000 pushes s")
        for scene in SCENES
        for sides in (4, 8)
    ]
    simulated = [row["runs"] * row["pushes a run"] for row in saved.rows if row["method"].startswith("simulation")]
    bold = saved.values([f"{scene}: compliant" for scene in piles], f"{coupled}: worst optimistic %")
    wrong = 100 - saved.value("table: isolated", "decoupled, own points: kind agrees %")
    return {
        "graph-papers-points": whole(mean(errors(("graph",), "decoupled, paper's points", SCENES))),
        "compliant-worst": whole(max(bold)),
        "compliant-papers-points": ends(errors(("compliant",), "coupled, paper's points", piles)),
        "ipopt-times-slower": span([rounded(min(slower)), rounded(max(slower))]),
        "printed-simulation": rounded(mean(errors(("simulation, PyBullet, as printed",), coupled, piles)), 1),
        "mujoco-held": str(math.ceil(max(errors(("simulation, MuJoCo, held",), coupled, piles)))),
        "corners-held": ends(errors(("simulation, PyBullet, held", "simulation, LMGC90, held"), coupled, piles)),
        "isolated-on-stack": whole(saved.value("stack: isolated", "decoupled, own points: error %")),
        "isolated-on-stack-paper": whole(saved.value("stack: isolated", "paper error %")),
        "isolated-on-table-paper": whole(saved.value("table: isolated", "paper error %")),
        "isolated-on-table-wrong-kind": whole(wrong),
        "simulated-pushes": span([whole(min(simulated)), whole(max(simulated))]),
    }


def reliability(saved: Saved) -> dict[str, str]:
    """How often ``compliant`` decides."""
    settled = sum(row["pushes"] for row in saved.rows if row["case"].startswith("settled "))
    return {
        "shipped-pushes": whole(sum(row["pushes"] for row in saved.rows) - settled),
        "settled-pushes": whole(settled),
    }


def messy(saved: Saved) -> dict[str, str]:
    """How often ``compliant`` decides in messy scenes."""
    rows = saved.rows
    total = {
        key: whole(sum(row[key] for row in rows)) for key in ("scenes", "answered by limit", "undecided", "above limit")
    }
    worst = max(row["worst of undecided s"] or 0.0 for row in rows)
    return {
        "scenes": total["scenes"],
        "answered": total["answered by limit"],
        "undecided": total["undecided"],
        "above": total["above limit"],
        "worst": f"{worst:.1f}",
    }


def graph_slanted(saved: Saved) -> dict[str, str]:
    """Answers of ``graph`` beside the certain bound of ``limit``, over families of random assemblies."""
    found: dict[str, str] = {}
    for kind in ("straight", "slanted"):
        rows = [row for row in saved.rows if row["case"].endswith(f", {kind}") and row["bounded"]]
        bounded = sum(row["bounded"] for row in rows)
        worst = max(rows, key=lambda row: row["worst"])
        found |= {
            f"{kind}-bounded": whole(bounded),
            f"{kind}-above": whole(100 * sum(row["above"] for row in rows) / bounded),
            f"{kind}-far-above": whole(100 * sum(row["above by a tenth"] for row in rows) / bounded),
            f"{kind}-below-half": whole(100 * sum(row["below half"] for row in rows) / bounded),
            f"{kind}-worst": rounded(worst["worst"]),
        }
    return found


def transport(saved: Saved) -> dict[str, str]:
    """Largest accelerations [m/s²] of a carrier."""
    strong, weak = (saved.value(f"slope_two: {engine}", "+Y") for engine in ("limit", "graph"))

    def acceleration(scene: str, axis: str) -> str:
        return f"{saved.value(f'{scene}: limit', axis):.3f}"

    return {
        "slope-x": acceleration("slope", "+X"),
        "slope-forwards": acceleration("slope", "+Y"),
        "slope-backwards": acceleration("slope", "-Y"),
        "slope_two-x": acceleration("slope_two", "+X"),
        "slope_two-forwards": acceleration("slope_two", "+Y"),
        "slope_two-gain": f"{100 * (strong / weak - 1):+.0f}",
        "slope_two-high": f"{strong:.2f}",
        "slope_two-low": f"{weak:.2f}",
        "graph-under-limit": whole(saved.value("slope: graph", "most off limit %")),
    }


def placements_of_a_table(saved: Saved) -> dict[str, str]:
    """How the engines' placements differ from those of ``isolated`` in the mean over the scenes of a table [%]."""
    scenes = list(dict.fromkeys(row["case"].split(", ")[0] for row in saved.rows))

    def change(engine: str, column: str) -> str:
        ours, theirs = (saved.values([f"{scene}, {one}" for scene in scenes], column) for one in (engine, "isolated"))
        return whole(abs(100 * (sum(ours) / sum(theirs) - 1)))

    return {
        "graph-time-less": change("graph", "time s"),
        "graph-force-more": change("graph", "rob. N"),
        "compliant-force-more": change("compliant", "rob. N"),
    }


def placements(saved: Saved) -> dict[str, str]:
    """All searches for a placement."""
    engines = list(dict.fromkeys(row["case"].split(", ")[1] for row in saved.rows))
    tries = {row["case"].split(", ")[0]: row["attempts"] for row in saved.rows if row["case"].endswith(", isolated")}
    others = [row["attempts"] for row in saved.rows if not row["case"].startswith("S4, ")]
    seconds = {e: [row["time s"] for row in saved.rows if row["case"].endswith(f", {e}")] for e in engines}
    return {
        "searches": whole(sum(row["seeds"] for row in saved.rows)),
        "seeds": whole(saved.rows[0]["seeds"]),
        "scenes": whole(len(tries)),
        "cells": whole(len(saved.rows)),
        "cells-where-all-stay": whole(sum(row["stays dropped %"] == 100 for row in saved.rows)),
        "slant-stays": listed([whole(saved.value(f"slant, {e}", "stays dropped %")) for e in ("isolated", "graph")]),
        "tries": span([rounded(min(others)), rounded(max(others))]),
        "tries-S4": rounded(tries["S4"]),
        "rated": whole(saved.rows[0]["rated"]),
        **{f"{e}-seconds": span([f"{min(found):.2f}", f"{max(found):.2f}"]) for e, found in seconds.items()},
    }


def placement(saved: Saved) -> dict[str, str]:
    """Placements on the strongest tenth of each engine's map that let the scene fall [%]."""

    def falls(engine: str) -> str:
        cases = [f"{scene}, {engine}" for scene in ("slant", "balance", "cantilever")]
        return listed([whole(share) for share in saved.values(cases, "fall %")])

    return {f"{engine}-falls": falls(engine) for engine in ("isolated", "graph", "compliant")}


NUMBERS: Mapping[str, Callable[[Saved], dict[str, str]]] = {
    "pipeline": pipeline,
    "scaling": scaling,
    "bounds": bounds,
    "table1": table1,
    "reliability": reliability,
    "graph_slanted": graph_slanted,
    "messy": messy,
    "transport": transport,
    "table2": placements_of_a_table,
    "table3": placements_of_a_table,
    "table2+table3": placements,
    "placement": placement,
    "experiments": predicted.numbers,
}
