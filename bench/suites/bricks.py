"""Random models of bricks that hold by their studs, beside an independent linear program.

For each model the linear program finds the least tension of the studs with which the model stands, between a polygon
inside the friction cone and one around it. Engine limit is asked at 99 % of the lower and at 101 % of the upper of the
two, where the linear program knows the answer.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

import holdfast as hf
from bench.scenes.bricks import Brick, least_tension, random_bricks, scene_of
from bench.suite import Case, Row, Suite

SIDES, SEED = 32, 55
CLASSES = {"5 to 20 bricks": (5, 21, 14), "21 to 40 bricks": (21, 41, 13), "41 to 60 bricks": (41, 61, 13)}
BELOW, ABOVE = 0.99, 1.01
NONE = 1.0  # [Pa] tension up to which a model counts as standing without studs


def cases() -> Mapping[str, Case]:
    return {name: partial(_measured, name, *sizes) for name, sizes in CLASSES.items()}


def compared(bricks: list[Brick]) -> dict[str, Any]:
    """What the linear program and engine limit say of one model; ``alike`` if nothing differs."""
    start = time.perf_counter()
    low, high = (least_tension(bricks, SIDES, inside=inside) for inside in (False, True))
    found: dict[str, Any] = {"width": 1 - low / high if high > NONE else 0.0, "program": time.perf_counter() - start}
    start, alike = time.perf_counter(), True
    for what, tension, stands in (("below", BELOW * low, False), ("above", max(ABOVE * high, 0.0), True)):
        if what == "below" and low <= NONE:
            found[what] = "stands without studs"
            continue
        assembly = hf.assemble(scene_of(bricks, tension))
        alike &= hf.Limit().prepare(assembly).verdict().equilibrium_exists is stands
        found[what] = hf.stability(assembly, engine="limit").status.value
    return found | {"alike": alike, "limit": time.perf_counter() - start}


def _measured(name: str, fewest: int, most: int, models: int) -> list[Row]:
    rng = np.random.default_rng([SEED, fewest])
    found = [compared(random_bricks(rng, int(rng.integers(fewest, most)))) for _ in range(models)]
    statuses = {
        what: ", ".join(f"{count} {status}" for status, count in Counter(one[what] for one in found).most_common())
        for what in ("below", "above")
    }
    return [
        {
            "case": name,
            "models": models,
            "equilibrium as in the linear program": sum(one["alike"] for one in found),
            "verdicts at 99 % of the least tension": statuses["below"],
            "verdicts at 101 %": statuses["above"],
            "widest bracket of the linear program": max(one["width"] for one in found),
            "linear program, median s": float(np.median([one["program"] for one in found])),
            "limit, median s": float(np.median([one["limit"] for one in found])),
        }
    ]


SUITE = Suite("bricks", __doc__ or "", cases)
