"""Real pallets of 5 to 108 boxes in 72 level directions: limits, who moves first, MuJoCo, and rules of packing."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

import holdfast as hf
from bench.baselines.carrier import Carrier
from bench.baselines.packing_rules import base_support_limits, support_polygon_limits
from bench.baselines.search import grid_nodes
from bench.scenes.real_pallets import pallet, pallets
from bench.suite import Case, Row, Suite, table

WAYS = 72  # level directions, evenly spaced
SIMULATED = (0, 2, 6, 8, 10, 11)  # small pallets that stand, which MuJoCo drives
RAMPS = (0, 18, 36, 54)  # directions in which it does, of the 72
SIDE = 3  # contact nodes along each side of a patch there
ABOVE, BELOW = 1.01, 0.9  # a rule is unsafe above this share of what is proved, too cautious below this of what holds
RULES = {"support polygon": support_polygon_limits, "base support": base_support_limits}


def cases() -> Mapping[str, Case]:
    """One case a pallet, and one for each that MuJoCo drives."""
    found = list(enumerate(pallets()))
    made: dict[str, Case] = {f"{k}: {len(boxes)} boxes": partial(_limits, k, boxes) for k, boxes in found}
    driven = [(k, boxes) for k, boxes in found if k in SIMULATED]
    return made | {f"{k}: {len(boxes)} boxes, MuJoCo": partial(_ramps, k, boxes) for k, boxes in driven}


def _limits(number: int, boxes: list[dict[str, Any]]) -> list[Row]:
    """One row: limits by both engines in all directions, how often a rule is above or below, and what moves first."""
    assembly = hf.assemble(pallet(boxes))
    ways = assembly.scene.horizontal_directions(WAYS)
    row: Row = {"case": f"{number}: {len(boxes)} boxes", "pallet": number, "boxes": len(boxes)}
    found = {}
    for engine in ("limit", "compliant"):
        start = time.process_time()
        found[engine] = hf.transport_limits(assembly, ways, engine=engine)
        row[f"{engine} s"] = time.process_time() - start
    certain, holds = found["limit"], found["compliant"]
    row["at rest"] = str(holds.verdict.status)
    ruled = {name: rule(assembly, ways) for name, rule in RULES.items()}
    row |= {f"{name} at rest": "stands" if (limits > 0).all() else "falls" for name, limits in ruled.items()}
    if holds.verdict.status is not hf.Status.STABLE:
        return [row]
    known = holds.answers.decided
    row |= {"directions": WAYS, "known": int(known.sum())}
    row |= {"least m/s²": float(holds.acceleration[known].min()), "median m/s²": float(np.median(holds.acceleration))}
    row["compliant / limit"] = float(np.median(holds.acceleration[known] / certain.acceleration[known]))
    row["above limit"] = int((holds.acceleration > certain.upper * (1 + 1e-6)).sum())
    first = Counter(holds.moving[known])
    names, often = first.most_common(1)[0]
    row |= {"first movers": len(first), "most often": ", ".join(names[:3]), "in": often, "of them": len(names)}
    row["one body"] = sum(times for moving, times in first.items() if len(moving) == 1)
    for name, limits in ruled.items():
        row[f"{name} unsafe"] = int((limits > ABOVE * certain.upper)[known].sum())
        row[f"{name} above what holds"] = int((limits > ABOVE * holds.acceleration)[known].sum())
        row[f"{name} too cautious"] = int((limits < BELOW * holds.lower)[known].sum())
        over = limits[known] / np.maximum(certain.upper[known], 1e-9)
        row[f"{name} / limit at most"] = float(over.max())
    return [row]


def _ramps(number: int, boxes: list[dict[str, Any]]) -> list[Row]:
    """One row a direction: the acceleration at which something moves in MuJoCo, beside both engines."""
    assembly = hf.assemble(pallet(boxes))
    label = f"{number}: {len(boxes)} boxes"
    if hf.stability(assembly).status is not hf.Status.STABLE:
        return [{"case": f"{label}, MuJoCo", "pallet": number, "boxes": len(boxes), "at rest": "does not stand"}]
    ways = assembly.scene.horizontal_directions(WAYS)[list(RAMPS)]
    found = {engine: hf.transport_limits(assembly, ways, engine=engine) for engine in ("limit", "compliant")}
    start = time.process_time()
    carrier = Carrier(assembly, grid_nodes(assembly, SIDE))
    rows: list[Row] = []
    for k, way in enumerate(ways):
        ramp = carrier.limit(way)
        row: Row = {"case": f"{label}, MuJoCo {360 * RAMPS[k] // WAYS}°", "pallet": number, "boxes": len(boxes)}
        row |= {"degrees": 360 * RAMPS[k] // WAYS, "MuJoCo m/s²": ramp.acceleration, "calm m/s²": ramp.calm}
        row |= {f"{engine} m/s²": float(each.acceleration[k]) for engine, each in found.items()}
        row |= {f"MuJoCo / {engine}": ramp.acceleration / float(each.acceleration[k]) for engine, each in found.items()}
        row["moves first"] = ", ".join(found["compliant"].moving[k][:3])
        rows.append(row | {"MuJoCo s": time.process_time() - start})
        start = time.process_time()
    return rows


def written(rows: list[Row]) -> str:
    """The pallets, how often the rules err, and MuJoCo beside the engines."""
    driven = [row for row in rows if "MuJoCo m/s²" in row]
    asked = [row for row in rows if "directions" in row]
    rest = [row for row in rows if "at rest" in row and "MuJoCo" not in row["case"]]
    sentences = []
    for name in RULES:
        count = sum(row["known"] for row in asked)
        share = {key: sum(row[f"{name} {key}"] for row in asked) / max(count, 1) for key in ("unsafe", "too cautious")}
        above = sum(row[f"{name} above what holds"] for row in asked) / max(count, 1)
        falls = sum(row[f"{name} at rest"] == "stands" and row["at rest"] == "unstable" for row in rest)
        stands = sum(row[f"{name} at rest"] == "falls" and row["at rest"] == "stable" for row in rest)
        sentences.append(
            f"Rule of the {name}: unsafe in {100 * share['unsafe']:.1f} % of {count:,} directions (above what `limit` "
            f"proves to move), above what `compliant` holds in {100 * above:.1f} %, too cautious in "
            f"{100 * share['too cautious']:.1f} %. At rest it lets {falls} pallets stand that fall, and condemns "
            f"{stands} of {sum(row['at rest'] == 'stable' for row in rest)} that stand."
        )
    keys = (
        *("pallet", "boxes", "at rest", "known", "least m/s²", "median m/s²", "compliant / limit", "first movers"),
        *("one body", "limit s", "compliant s"),
    )
    short = [{key: row[key] for key in keys if key in row} for row in rest]
    parts = [*sentences, table(short), table([{k: v for k, v in row.items() if k != "case"} for row in driven])]
    return "\n\n".join(parts)


SUITE = Suite("carriage", __doc__, cases, written=written)
