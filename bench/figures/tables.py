"""Whole tables of the pages, each made from the saved results of one benchmark suite."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from bench.figures import predicted
from bench.figures.saved_rows import Saved, rounded, significant, span, table, whole

NOTHING = "–"
SCENES = ("cube", "stack", "table")


def disassembly(saved: Saved) -> dict[str, str]:
    """Time to plan the disassembly of walls."""
    rows = [
        [
            whole(row["bodies"]),
            whole(row["interfaces"]),
            significant(row["plan s"]),
            significant(row["one verdict s"]),
        ]
        for row in saved.rows
        if row["case"].startswith("wall ")
    ]
    return {"walls": table(["bodies", "interfaces", "plan [s]", "one verdict of the whole [s]"], rows, 0)}


def transport(saved: Saved) -> dict[str, str]:
    """Seconds for 100 directions, and the largest difference to the simulation."""
    methods = [case.removeprefix("slope: ") for case in (r["case"] for r in saved.rows) if case.startswith("slope: ")]
    scenes = {"one cube": "slope", "two cubes": "slope_two"}
    lines = []
    for title, scene in scenes.items():
        rows = [saved.row(f"{scene}: {method}") for method in methods]
        lines.append([f"{title}, s", *(significant(row["100 directions s"]) for row in rows)])
        if any(row["paper s"] for row in rows):
            lines.append([f"{title}, paper, s", *(f"{row['paper s']:g}" if row["paper s"] else "" for row in rows)])
    for title, scene in scenes.items():
        rows = [saved.row(f"{scene}: {method}") for method in methods]
        lines.append([f"{title}, most off the simulation", *(_off_simulation(row) for row in rows)])
    return {"summary": table(["", *methods], lines)}


def _off_simulation(row: dict[str, Any]) -> str:
    off = max(row["most above simulation %"], row["most below simulation %"])
    return f"{significant(off)} %" if math.isfinite(off) and not row["case"].endswith("simulation") else ""


def firmer(saved: Saved) -> dict[str, str]:
    """The least push before and after, how much all bodies grew, and the same of random places."""
    heads = ["moved", "least before", "after", "random", "all grew by", "random", "time", "random", "as firm after"]
    cells = []
    for row in saved.rows:
        if "random s" not in row:
            continue
        newtons = [f"{row[key]:.3g} N" for key in ("least before N", "least after N", "least by random N")]
        grew = [f"{100 * (row[key] - 1):.0f} %" for key in ("all grew by", "all grew by random")]
        reached = row["as firm as random after s"]
        seconds = [f"{row[key]:.2g} s" for key in ("s", "random s")]
        cells.append([row["case"], *newtons, *grew, *seconds, "never" if reached == "inf" else f"{reached:.2g} s"])
    return {"table": table(heads, cells)}


def constraint(saved: Saved) -> dict[str, str]:
    """How close a planner's constraint is to single solves, its gradient, and calls a second, for every body."""
    heads = [
        "body",
        "bodies",
        "wrenches",
        "above",
        "median below",
        "90 % below",
        "gradient off",
        "solves",
        "calls/s",
        "solve",
    ]
    cells = [
        [
            row["case"],
            whole(row["bodies"]),
            whole(row["wrenches"]),
            whole(row["above"]),
            f"{row['median short %']:.2f} %",
            f"{row['90 % short %']:.1f} %",
            f"{row['gradient off']:.0e}",
            whole(row["solves"]),
            whole(round(row["calls a second"], -2)),
            f"{row['a solve ms']:.2g} ms",
        ]
        for row in saved.rows
    ]
    return {"table": table(heads, cells)}


def checked_constraint(saved: Saved) -> dict[str, str]:
    """How often a constraint with compliant is above its lower bound, what was told of it, and how close it is."""
    heads = ["body", "above", "told", "of these, nine in ten by less than", "by up to", "median below", "90 % below"]
    keys = ["above %", "told %", "nine in ten of these by less than %", "above by up to %"]
    keys += ["median short %", "90 % short %"]
    rows = [row for row in saved.rows if "refused" not in row]
    return {"table": table(heads, [[row["case"], *(f"{significant(row[key])} %" for key in keys)] for row in rows])}


def questions(saved: Saved) -> dict[str, str]:
    """What is called safe to take out, to put in and to push, and what MuJoCo sees of it, for every scene."""
    pushes = ["alone", "nothing", "others", "unknown", "simulated", "unsafe safe", "others, not seen"]
    removals = ["bodies", "safe", "unsafe safe", "unsafe, something falls", "unsafe, all rest", "undecided"]
    building = ["bodies", "steps", "states that rest", "unsafe safe", "least push N"]
    handled = [_kinds(saved, "removals", removals), _kinds(saved, "building", building)]
    return {"pushes": _kinds(saved, "pushes", pushes), "handled": "\n\n".join(handled)}


def _kinds(saved: Saved, kind: str, keys: list[str]) -> str:
    """The rows of one kind of question as a table."""
    rows = [row for row in saved.rows if row["case"].endswith(f": {kind}")]
    cells = [[row["case"].removesuffix(f": {kind}"), *(_count(row[key]) for key in keys)] for row in rows]
    return table([kind, *keys], cells)


def _count(value: Any) -> str:  # noqa: ANN401 - a number, or the text of one
    return NOTHING if value == "nan" else whole(value) if isinstance(value, int) else rounded(float(value), 3)


def placement_tables(saved: Saved) -> dict[str, str]:
    """Plans on the shelf of the README; those on random shelves and trays by kind; several objects by method."""
    plans = []
    for kind in ("shelves", "trays"):
        rows = [row for row in saved.rows if row["case"].startswith(kind)]
        counted = ("plans", "placed", "stand", "rolling needlessly", "late", "dropped", "stay dropped")
        total = {key: sum(row[key] for row in rows) for key in counted}
        loads = span([f"{pick(row['load'] for row in rows):.0f}" for pick in (min, max)])
        counts = [whole(total[key]) for key in counted[:5]]
        plans.append([f"random {kind}", *counts, f"{total['stay dropped']} of {total['dropped']}", loads])
    heads = ["plans on", "plans", "placed", "stand", "needlessly on a facet", "late", "stay released", "load"]
    several = [
        [
            row["case"],
            f"{row['placed']} of {row['objects']}",
            whole(row["states that stand"]),
            f"{row['least push of all states N']:.3g}",
            f"{row['median over states N']:.3g}",
            f"{row['time s']:.3g}",
            f"{row['processor time s']:.3g}",
        ]
        for row in saved.rows
        if "objects" in row
    ]
    columns = ["several", "placed", "states that stand", "least push N", "median N", "time s", "processor time s"]
    shelf = saved.row("README's shelf")
    sentence = f"{shelf['upright']} of {shelf['plans']} plans stand the cup upright"
    sentence += f", {shelf['least edge mm']:.0f} mm inside the edges or more"
    more = (
        f"its median least push is {shelf['median N']:.2f} N, {shelf['median over 0.1']:.1f} times that of version 0.1"
    )
    return {"plans": table(heads, plans), "several": table(columns, several), "readme": f"{sentence}; {more}"}


def carriage(saved: Saved) -> dict[str, str]:
    """How often rules of packing err on real pallets, what questions cost, and MuJoCo beside the engines."""
    asked = [row for row in saved.rows if "directions" in row]
    rest = [row for row in saved.rows if "limit s" in row]
    count = sum(row["known"] for row in asked)

    def share(rule: str, key: str) -> str:
        return f"{100 * sum(row[f'{rule} {key}'] for row in asked) / count:.1f} %"

    keys = ("unsafe", "above what holds", "too cautious")
    stands = [row for row in rest if row["at rest"] == "stable"]
    rules = []
    for rule in ("support polygon", "base support"):
        wrong = sum(row[f"{rule} at rest"] == "falls" for row in stands)
        right = sum(row[f"{rule} at rest"] == "falls" for row in rest if row["at rest"] == "unstable")
        falls = sum(row["at rest"] == "unstable" for row in rest)
        cells = [share(rule, key) for key in keys]
        rules.append([rule, *cells, f"{wrong} of {len(stands)}", f"{right} of {falls}"])
    verdicts = {word: sum(row["at rest"] == word for row in rest) for word in ("stable", "unstable", "undecided")}
    answers = [
        ["pallets that stand, fall, are undecided", ", ".join(map(str, verdicts.values()))],
        ["directions asked, known", f"{72 * len(asked):,}, {count:,}"],
        ["above what `limit` proves", str(sum(row["above limit"] for row in asked))],
        ["least and median limit [m/s²]", _span([row["least m/s²"] for row in asked], min)
         + ", " + _span([row["median m/s²"] for row in asked], _middle)],
        ["sets of bodies that move first, a pallet", _span([row["first movers"] for row in asked], _middle)],
        ["72 directions by `limit`, median and most [s]", _median_and_most([row["limit s"] for row in asked])],
        ["72 directions by `compliant`, median and most [s]", _median_and_most([row["compliant s"] for row in asked])],
    ]  # fmt: skip
    driven = [row for row in saved.rows if "MuJoCo m/s²" in row]
    lines = [
        [
            f"{row['pallet']}: {row['boxes']} boxes, {row['degrees']}°",
            *(f"{row[key]:.2f}" for key in ("MuJoCo m/s²", "limit m/s²", "compliant m/s²")),
            *(f"{100 * (row[f'MuJoCo / {engine}'] - 1):+.1f} %" for engine in ("limit", "compliant")),
        ]
        for row in driven
    ]
    heads = ["", *keys, "condemns at rest what stands", "finds what falls at rest"]
    simulated = ["", "MuJoCo [m/s²]", "`limit`", "`compliant`", "over `limit`", "over `compliant`"]
    return {
        "rules": table(heads, rules),
        "answers": table(["", ""], answers),
        "simulated": table(simulated, lines),
    }


def calibration(saved: Saved) -> dict[str, str]:
    """How often intervals hold the truth, and how wide they are."""
    heads = ["pushes of", "ended at", "coefficient held", "further push held", "undecided", "width / best"]
    cells = [
        [
            row["case"],
            NOTHING if math.isinf(float(row["ended at"])) else f"{row['ended at']:g} of the force",
            f"{row['mu covered']:.1%}",
            f"{row['further push covered']:.1%}",
            str(row["undecided"]),
            f"{row['width / best']:.2f}",
        ]
        for row in saved.rows
    ]
    return {"coverage": table(heads, cells)}


def _middle(values: list[float]) -> float:
    return sorted(values)[len(values) // 2]


def _span(values: list[float], pick: Callable[[list[float]], float]) -> str:
    return f"{pick(values):.3g}"


def _median_and_most(values: list[float]) -> str:
    return f"{_middle(values):.2g}, {max(values):.2g}"


TABLES: Mapping[str, Callable[[Saved], dict[str, str]]] = {
    "disassembly": disassembly,
    "transport": transport,
    "calibration": calibration,
    "carriage": carriage,
    "checked_constraint": checked_constraint,
    "constraint": constraint,
    "firmer": firmer,
    "questions": questions,
    "placement": placement_tables,
    "experiments": predicted.tables,
}
