"""What Tables II and III have in common: placements of many seeds in one scene by one engine, checked three ways.

Every pose found is judged again from scratch (contacts detected again, engine compliant) and let go in MuJoCo with its
real shapes; the first RATED of a cell get a full map of 10 mm. Environment variable HOLDFAST_PLACEMENT_SEEDS: seeds a
cell (10; the paper has 100).
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType

import numpy as np

import holdfast as hf
from bench.baselines.drop import SECONDS, Drop, drop
from bench.scenes.placement_scenes import PlacementScene
from bench.suite import Case, Row
from holdfast.applications.placement.planner import Planner, planner
from holdfast.applications.placement.result import least_push
from holdfast.assembly.assembly import Assembly
from holdfast.base.errors import HoldfastError
from holdfast.engines.contract import Engine

SEEDS = 10
RATED = 12
SPACING = 0.01  # [m]
ENGINES: Mapping[str, Engine] = MappingProxyType(
    {"isolated": hf.Graph(isolated=True), "graph": hf.Graph(), "limit": hf.Limit(), "compliant": hf.Compliant()}
)


def cases_of(scenes: Mapping[str, Callable[[], PlacementScene]]) -> Mapping[str, Case]:
    """One case for each scene and engine."""
    count = int(os.environ.get("HOLDFAST_PLACEMENT_SEEDS", SEEDS))
    return {
        f"{name}, {engine}": partial(cell, name, make, engine, count)
        for name, make in scenes.items()
        for engine in ENGINES
    }


def cell(name: str, make: Callable[[], PlacementScene], engine: str, count: int) -> list[Row]:
    """Placements of seeds 0 to ``count`` - 1 in one scene by one engine."""
    prepared_planner(make(), engine)  # warm-up: reading does not count as the planner's time
    start = time.perf_counter()
    asked = prepared_planner(make(), engine)
    before = time.perf_counter() - start
    seconds, tried, least, own = list[float](), list[int](), list[float](), list[float]()
    undecided, again, drops = 0, 0, list[Drop]()
    for seed in range(count):
        search = asked.search(seed=seed)
        tried.append(search.tried)
        if not search.flat:
            continue
        assert search.first is not None
        seconds.append(search.first)
        _, after = search.flat[0]
        again += hf.stability(hf.assemble(after.scene)).status is hf.Status.STABLE
        fall = dropped(after, asked.checks.body.name)
        drops += [] if fall is None else [fall]
        if len(least) < RATED:
            full = hf.robustness_map(after, None, spacing=SPACING)
            decided = least_push(full)
            least += [] if decided is None else [decided]
            undecided += full.undecided.count
            decided = least_push(hf.robustness_map(after, None, spacing=SPACING, engine=asked.checks.engine))
            own += [] if decided is None else [decided]
    placed = len(seconds)
    row: Row = {
        "case": f"{name}, {engine}",
        "seeds": count,
        "placed %": 100 * placed / count,
        "map s": before,
        "search s": mean(seconds),
        "time s": before + mean(seconds),
        "search p95 s": float(np.percentile(seconds, 95)) if seconds else "",
        "attempts": mean(tried),
        "rob. N": mean(least),
        "own rob. N": mean(own),
        "rated": len(least),
        "undecided points": undecided,
        "confirmed %": 100 * again / placed if placed else "",
    }
    if drops:
        row |= {
            "stays dropped %": 100 * sum(fall.stands for fall in drops) / len(drops),
            "worst moved mm": 1e3 * max(fall.moved for fall in drops),
            "worst turned deg": max(fall.turned for fall in drops),
        }
    return [row]


def prepared_planner(scene: PlacementScene, engine: str) -> Planner:
    """A planner whose maps are made: that is done once, however many poses are tried."""
    asked = planner(
        hf.assemble(scene.scene),
        scene.body,
        approach=scene.approach,
        engine=ENGINES[engine],
        where=scene.where,
    )
    assert asked.verdict.status is hf.Status.STABLE
    assert len(asked.support.points)
    return asked


def dropped(after: Assembly, name: str, seconds: float = SECONDS) -> Drop | None:
    """The drop test of ``seconds``; None where MuJoCo is not installed."""
    try:
        return drop(after, name, seconds=seconds)
    except HoldfastError as error:
        if "not installed" in str(error):
            return None
        raise


def mean(values: list[float] | list[int]) -> float:
    """The mean, infinite where there is nothing."""
    return float(np.mean(values)) if values else np.inf


def printed(rows: list[Row], scenes: list[str], paper: Mapping[str, Mapping[str, list[float]]]) -> str:
    """The paper's form: time and robustness by scene, relative to ``isolated``, with the figures it prints."""
    value = {row["case"]: row for row in rows}
    lines = ["| | " + " | ".join([*scenes, "Avg."]) + " |", "|---|" + "---|" * (len(scenes) + 1)]

    def line(title: str, figures: list[float], form: str) -> None:
        lines.append(f"| {title} | " + " | ".join(format(f, form) for f in figures) + " |")

    def figures(engine: str, key: str) -> list[float]:
        found = [float(value[f"{scene}, {engine}"][key]) for scene in scenes]
        return [*found, float(np.mean(found))]

    for engine in ENGINES:
        times, forces = figures(engine, "time s"), figures(engine, "rob. N")
        line(f"**{engine}** time (s)", times, ".2f")
        line("rob. (N)", forces, ".2f")
        if engine != "isolated":
            for title, own, key in (("time", times, "time s"), ("rob.", forces, "rob. N")):
                change = [100 * (a / b - 1) for a, b in zip(own, figures("isolated", key), strict=True)]
                line(f"{title} relative (%)", change, "+.0f")
    for method, figure in paper.items():
        line(f"*paper, its scenes:* {method} time (s)", figure["time"], ".3g")
        line("rob. (N)", figure["rob"], ".3g")
    return "\n".join(lines)
