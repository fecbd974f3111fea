"""A constraint with engine ``compliant`` beside single solves of it: how often above its ``lower``, and how close."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

import holdfast as hf
from bench.scenes.shelf import shelf
from bench.suite import Case, Row, Suite
from bench.suites.constraint import drawn
from holdfast.engines.groups import prepared
from holdfast.queries.request import engine_of
from holdfast.queries.sets import wrench_columns
from holdfast.scene.shipped import shipped_scene

SHIPPED = ("cube: cube", "table: slab", "arch: v3", "tabletop: mug")
ON_SHELF = ("board", "tin", "top tin", "book", "bowl", "pen")
FRESH = 2_000


def cases() -> Mapping[str, Case]:
    """One case a body."""
    scenes: dict[str, Callable[[], hf.Scene]] = {
        name: partial(shipped_scene, name.partition(":")[0]) for name in SHIPPED
    }
    scenes |= {f"shelf: {name}": shelf for name in ON_SHELF}
    return {name: partial(_rows, name, make) for name, make in scenes.items()}


def _rows(case: str, make: Callable[[], hf.Scene]) -> list[Row]:
    assembly, body = hf.assemble(make()), case.partition(": ")[2]
    start = time.process_time()
    try:
        found = hf.sets.constraint(assembly, body)
    except hf.HoldfastError as error:
        return [{"case": case, "refused": str(error)}]
    built = time.process_time() - start
    wrenches = drawn(assembly, body, found, FRESH)
    value = np.asarray(found.value(wrenches))
    lower = (
        prepared(engine_of("compliant"), assembly).load_factor(wrench_columns(assembly, body, case) @ wrenches.T).lower
    )
    within = (lower > 0) & (lower * np.abs(wrenches / found.box).max(1) <= 1)
    short = 1 - value[within] / lower[within]
    return [
        {
            "case": case,
            "wrenches": FRESH,
            "above %": 100 * float((value > lower).mean()),
            "nine in ten of these by less than %": 100 * float(np.quantile(-short[short < 0], 0.9)),
            "above by up to %": 100 * float(-short.min()),
            "lower is 0": int((lower == 0).sum()),
            "told %": 100 * found.above,
            "told by up to %": 100 * found.above_by,
            "median short %": 100 * float(np.median(short)),
            "90 % short %": 100 * float(np.quantile(short, 0.9)),
            "solves": found.solves,
            "built s": built,
        }
    ]


SUITE = Suite("checked_constraint", __doc__, cases)
