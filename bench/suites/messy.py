"""How often engine ``compliant`` decides in messy scenes: balls, frictionless pairs, floating and falling bodies."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial

import numpy as np
from numpy.random import Generator

from bench.scenes.random_assemblies import (
    FAMILIES,
    with_ball,
    with_ball_against,
    with_falling,
    with_floating,
    with_frictionless_pair,
)
from bench.scenes.random_pushes import columns, random_pushes
from bench.suite import Case, Row, Suite, table
from holdfast.assembly.assembly import Assembly, assemble
from holdfast.engines.compliant.engine import Compliant
from holdfast.engines.groups import prepared
from holdfast.engines.limit_engine import Limit
from holdfast.engines.verdict import Status
from holdfast.scene.scene import Scene

SCENES = 36  # scenes of each family: 504 in all
PUSHES = 4  # pushes on each scene, half of them normal and half up to 60 degrees from the inward normal
SEED = 13
TROUBLES = (with_ball, with_ball_against, with_frictionless_pair, with_floating, with_falling)
ANSWERED = (Status.FINITE, Status.INFINITE)


def messy(family: str, rng: Generator) -> Scene:
    """Draw a scene of a family with at least one ball or frictionless pair, and other troubles by chance."""
    scene = FAMILIES[family](rng)
    chosen = rng.random(len(TROUBLES)) < 0.4
    chosen[int(rng.integers(3))] = True
    for trouble, wanted in zip(TROUBLES, chosen, strict=True):
        scene = trouble(scene, rng) if wanted else scene
    return scene


def asked(assembly: Assembly, rng: Generator) -> Row:
    """Ask both engines about random pushes on one scene: counts, and the time of every undecided answer."""
    pushes = [p for slant in (0.0, 60.0) for p in random_pushes(assembly, rng, PUSHES // 2, slant=slant)]
    W = columns(assembly, pushes)
    certain = prepared(Limit(), assembly).load_factor(W)
    answered = np.isin(certain.status, ANSWERED)
    state = prepared(Compliant(), assembly)
    undecided, above, times = 0, 0, []
    for k in range(W.shape[1]):
        start = time.perf_counter()
        found = state.load_factor(W[:, k : k + 1])
        spent = time.perf_counter() - start
        if found.status[0] is Status.UNDECIDED:
            undecided += bool(answered[k])
            times.append(spent)
        above += bool(answered[k] and found.force[0] > certain.upper[k] * (1 + 1e-4) + 1e-4)
    zero = answered & (certain.upper < 1e-6 * assembly.weight)
    return {
        "pushes": len(pushes),
        "answered by limit": int(answered.sum()),
        "undecided": undecided,
        "of no force": int(zero.sum()),
        "above limit": above,
        "times": times,
    }


def family_rows(name: str) -> list[Row]:
    rng = np.random.default_rng([SEED, list(FAMILIES).index(name)])
    rows = [asked(assemble(messy(name, rng)), rng) for _ in range(SCENES)]
    times = [t for row in rows for t in row["times"]]
    counts = {key: sum(row[key] for row in rows) for key in rows[0] if key != "times"}
    return [
        {
            "case": name,
            "scenes": len(rows),
            **counts,
            "median of undecided s": float(np.median(times)) if times else None,
            "worst of undecided s": float(max(times)) if times else None,
        }
    ]


def cases() -> Mapping[str, Case]:
    return {name: partial(family_rows, name) for name in FAMILIES}


def written(rows: list[Row]) -> str:
    asked_, undecided = (sum(row[key] for row in rows) for key in ("answered by limit", "undecided"))
    shown = [{key: "" if value is None else value for key, value in row.items()} for row in rows]
    return f"{table(shown)}\n\n{undecided} of {asked_} pushes that `limit` answers are undecided."


SUITE = Suite("messy", __doc__, cases, written=written)
