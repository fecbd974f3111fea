"""Is anything called safe that does not hold? Monitors and sets of accelerations beside ``transport_limits``.

Thirty scenes in which nothing squeezes what could be squeezed. In each, ten random accelerations are asked of a monitor
at random sizes and just above ``lower``; and of the set of accelerations 100 random directions, which it was not asked,
at its border and at random places inside.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

import holdfast as hf
from bench.scenes.fitted import fitted
from bench.suite import Case, Row, Suite

ACCELERATIONS = 10  # a scene, of which the last coordinate is mostly small
WAYS = 100
LONG = 1e3  # [s] an update may take: how much a busy machine leaves is not looked at here
ROUNDING = 1e-6


def cases() -> Mapping[str, Case]:
    """One case a scene."""
    return {name: partial(_rows, name, scene) for name, scene in fitted()}


def _rows(name: str, scene: hf.Scene) -> list[Row]:
    assembly, rng = hf.assemble(scene), np.random.default_rng(5)
    return [{"case": name} | _watched(assembly, rng) | _set(assembly, rng)]


def _watched(assembly: hf.answers.Assembly, rng: np.random.Generator) -> Row:
    limits = hf.transport_limits(assembly, rng.normal(size=(ACCELERATIONS, 3)) * (1, 1, 0.4))
    monitor = hf.Monitor(assembly, seconds=LONG, solves=0)
    above, ratios, asked = 0, [], 0
    for way, lower in zip(limits.directions, limits.lower, strict=True):
        if lower == np.inf:
            continue
        asked += 1
        for size in (*(lower * rng.uniform(0.3, 1.7, 3)), lower * (1 + ROUNDING), max(9.0, 1.01 * lower)):
            above += monitor.update(size * way).holds and size > lower
        if lower > 0:
            ratios.append(0.5 / (1 - monitor.update(0.5 * lower * way).margin))
    row: Row = {"asked": asked, "monitor above": above}
    return row | {"of lower, least": min(ratios, default=1.0), "of lower, most": max(ratios, default=1.0)}


def _set(assembly: hf.answers.Assembly, rng: np.random.Generator) -> Row:
    try:
        found = hf.sets.sustainable_accelerations(assembly)
    except hf.HoldfastError as error:
        return {"refused": str(error)}
    unit = found.box / found.usage(np.diag(found.box))  # reaches along the axes
    ways = rng.normal(size=(WAYS, 3)) * unit
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    limits = hf.transport_limits(assembly, ways)
    reach, ends = 1 / np.asarray(found.usage(ways)), (found.box / np.abs(ways)).min(1)  # the box ends there
    lower, force = np.minimum(limits.lower, ends), np.minimum(limits.acceleration, ends)
    known = limits.answers.decided & (lower > 0)
    inside = rng.uniform(0, 1, WAYS) * reach
    lost = 1 - reach[known] / lower[known]
    excess = np.maximum(-lost, 0.0)
    return {
        "checks failed": next(note for note in found.notes if note.startswith("checked")),
        "lower unknown": int((~known).sum()),
        "inside above lower": int((inside > lower)[known].sum()),
        "border above lower": int((excess > ROUNDING).sum()),
        "by up to %": 100 * float(excess.max(initial=0.0)),
        "border above force": int((reach > force * (1 + ROUNDING))[known].sum()),
        "lost, median %": 100 * float(np.median(lost)),
        "lost, worst %": 100 * float(lost.max()),
    }


SUITE = Suite("holding", __doc__, cases)
