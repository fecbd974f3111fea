"""Placements on shelves, trays and pallets, how sensible they are, and where the strongest points of a map lead."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from functools import partial
from typing import BinaryIO

import numpy as np

import holdfast as hf
from bench.scenes.placement_scenes import TABLE_III, PlacementScene
from bench.suite import Case, Row, Suite, table
from bench.suites import placement_random, placement_several
from bench.suites.placements import ENGINES
from holdfast.applications.placement.checks import FALLEN, MARGINAL, REFUSED, UNSURE
from holdfast.applications.placement.planner import planner
from holdfast.drawing.panel_sheets import PointsPanel, sheet_png
from holdfast.report.map_picture import picture_of

TENTH = 0.9
SAMPLE = 200  # points tried at most
TRIES = 5  # poses on a point until one rests on the scene at all
DECIDING = ("", FALLEN, UNSURE, REFUSED, MARGINAL)  # it rested there, and everything else was judged


def tried(make: Callable[[], PlacementScene], name: str, engine: str) -> list[Row]:
    """Put the object onto points of the strongest tenth of the map of all movable bodies, ties drawn by lot.

    A placement counts as fallen where engine compliant does not find that everything stands with it.
    """
    scene = make()
    assembly = hf.assemble(scene.scene)
    asked = planner(
        assembly, scene.body, where=hf.Where(supports=[body.name for body in assembly.movable]), engine=ENGINES[engine]
    )
    found, support, rng = asked.maps[0], asked.support, np.random.default_rng(0)
    lot = np.lexsort((rng.random(len(found.force)), -found.force))
    strongest = lot[: max(1, round((1 - TENTH) * len(lot)))]
    chosen = strongest[rng.permutation(len(strongest))[:SAMPLE]]
    ends: Counter[str] = Counter()
    for k in chosen:
        distance = np.linalg.norm(support.points - found.points[k], axis=1)
        if distance.min() > 0:
            ends["faces down or aside"] += 1
            continue
        for _ in range(TRIES):
            fault = asked.attempt(rng, points=[int(np.argmin(distance))])[0].fault
            if fault in DECIDING:
                break
        ends[fault] += 1
    fallen = ends[FALLEN] + ends[UNSURE] + ends[REFUSED]
    return [
        {
            "case": f"{name}, {engine}",
            "points": len(found.force),
            "infinite %": 100 * float(np.isinf(found.force).mean()),
            "tried": len(chosen),
            "stand": ends[""] + ends[MARGINAL],
            "fall": fallen,
            "fall %": 100 * fallen / len(chosen),
            "face down or aside": ends["faces down or aside"],
            "no rest there": len(chosen) - ends[""] - ends[MARGINAL] - fallen - ends["faces down or aside"],
        }
    ]


def cases() -> Mapping[str, Case]:
    """Shelves and trays; several objects; scenes times engines."""
    strongest = {
        f"{name}, {engine}": partial(tried, make, name, engine)
        for name, make in TABLE_III.items()
        for engine in ENGINES
    }
    return dict(placement_random.cases()) | dict(placement_several.cases()) | strongest


def written(rows: list[Row]) -> str:
    """One table for each kind of rows."""
    kinds = (
        ("Single objects: README's shelf, random shelves and trays", "plans"),
        ("Several objects, in every state", "objects"),
        ("Where the strongest tenth of each map leads", "points"),
    )
    parts = [f"## {title}\n\n{table([row for row in rows if key in row])}" for title, key in kinds]
    return "\n\n".join(parts)


def plot(rows: list[Row], file: BinaryIO) -> None:
    """The maps side by side, as Fig. 13."""
    share = {row["case"]: row["fall %"] for row in rows if "fall %" in row}
    sheet = []
    for name, make in TABLE_III.items():
        assembly = hf.assemble(make().scene)
        panels = []
        for label, engine in ENGINES.items():
            caption = f"{name}, {label}: {share[f'{name}, {label}']:.0f} % of the strongest tenth fall"
            panels.append(PointsPanel(caption, picture_of(hf.robustness_map(assembly, engine=engine))))
        sheet.append(panels)
    title = "What the object is put on: strong by each engine's map"
    about = "isolated judges every body as if those it stands on were fixed; blue: no push moves anything"
    file.write(sheet_png(sheet, title, about, panel=(560, 400)))


SUITE = Suite("placement", __doc__ or "", cases, plot, written)
