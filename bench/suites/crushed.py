"""Forty real pallets of cartons with crush limits: who is crushed first, and how near its limit it is.

The limit of every carton is McKee's box compression strength of a single-wall board, with a factor of safety. What lies
on a carton is worked out once more from what holds it up, less its weight. How much another distribution would press:
the least and the largest load on the carton nearest to its limit in any equilibrium of vertical forces, by a linear
program, and what engine limit finds, whose forces may also lean on neighbours by friction.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import linprog

import holdfast as hf
from bench.scenes.real_pallets import pallet, pallets
from bench.suite import Case, Row, Suite
from holdfast.sets import box_compression_strength

PALLETS = 40
EDGE, CALIPER, SAFETY = 5600.0, 4e-3, 4.0  # [N/m] edge crush strength, [m] thickness of the board, factor of safety


def limited(scene: hf.Scene) -> hf.Scene:
    """The scene with the limits of all cartons."""
    bodies = []
    for body in scene.bodies:
        if body.fixed:
            bodies.append(body)
            continue
        x, y, _ = np.ptp(body.surface_world.vertices, axis=0)
        bodies.append(replace(body, top_load=box_compression_strength(EDGE, CALIPER, 2 * (x + y)) / SAFETY))
    return hf.Scene(bodies, scene.friction, scene.gravity, scene.name)


def by_balance(assembly: hf.answers.Assembly, verdict: hf.answers.Stability) -> dict[str, float]:
    """The load [N] on top of every carton: all that acts on it from below and from its sides, less its weight."""
    forces, found = verdict.forces, {}
    assert forces is not None
    for body in assembly.movable:
        found[body.name] = -9.81 * float(body.mass or 0.0)
        for k, interface in enumerate(assembly.interfaces):
            if body.name in interface.bodies:
                sign, here = 1 if interface.bodies[1] == body.name else -1, forces.interface == k
                from_above = sign * forces.normal[here, 2] < -0.5
                found[body.name] += float(sign * forces.force[here, 2][~from_above].sum())
    return found


def range_of(assembly: hf.answers.Assembly, name: str) -> tuple[float, float]:
    """The least and the largest load [N] on top of a carton in any equilibrium of vertical forces at corners."""
    movable, columns, on_top = assembly.movable, [], []
    for interface in assembly.interfaces:
        for patch in interface.patches:
            if abs(patch.normal[2]) < 0.9:
                continue
            upper = interface.bodies[int(patch.normal[2] > 0)]
            lower = next(each for each in interface.bodies if each != upper)
            for point in patch.polygon:
                column = np.zeros((len(movable), 3))
                for body, sign in ((upper, 1.0), (lower, -1.0)):
                    if assembly.index[body] >= 0:
                        arm = point - assembly.com[assembly.index[body]]
                        column[assembly.index[body]] = sign * np.array([1.0, arm[1], -arm[0]])
                columns.append(column.ravel())
                on_top.append(1.0 if lower == name else 0.0)
    weight = np.zeros((len(movable), 3))
    weight[:, 0] = 9.81 * assembly.mass
    ends = []
    for sign in (1.0, -1.0):
        found = linprog(sign * np.array(on_top), A_eq=np.array(columns).T, b_eq=weight.ravel(), method="highs")
        ends.append(sign * float(found.fun or 0.0) if found.status == 0 else np.nan)
    return ends[0], ends[1]


def cases() -> Mapping[str, Case]:
    return {f"pallet {k + 1}": partial(_measured, k) for k in range(min(PALLETS, len(pallets())))}


def _measured(number: int) -> list[Row]:
    boxes: list[dict[str, Any]] = pallets()[number]
    assembly = hf.assemble(limited(pallet(boxes)))
    start = time.perf_counter()
    verdict = hf.stability(assembly)
    seconds = time.perf_counter() - start
    if not verdict.bearing:
        return [{"case": f"pallet {number + 1}", "boxes": len(boxes), "status": verdict.status.value}]
    first = verdict.bearing[0]
    balance = by_balance(assembly, verdict)
    least, most = range_of(assembly, first.body)
    other = hf.stability(assembly, engine="limit").bearing
    return [
        {
            "case": f"pallet {number + 1}",
            "boxes": len(boxes),
            "status": verdict.status.value,
            "first": first.body,
            "load N": first.load,
            "over its limit": first.share,
            "crushed": len(verdict.crushed),
            "largest difference from the balance N": max(abs(one.load - balance[one.body]) for one in verdict.bearing),
            "vertical forces, least N": least,
            "vertical forces, most N": most,
            "by limit": other[0].body if other else "",
            "by limit, over its limit": other[0].share if other else 0.0,
            "verdict s": seconds,
        }
    ]


def _written(rows: list[Row]) -> str:
    known = [row for row in rows if "first" in row]
    spread = [row["vertical forces, most N"] / max(row["load N"], 1e-9) for row in known]
    lines = [
        ("pallets", len(rows)),
        ("with a verdict that they stand", len(known)),
        ("pallets with a crushed carton", sum(row["crushed"] > 0 for row in known)),
        ("load over limit of the first carton, median", f"{np.median([r['over its limit'] for r in known]):.2f}"),
        ("load over limit of the first carton, largest", f"{max(r['over its limit'] for r in known):.2f}"),
        (
            "largest difference from what holds it up, less its weight, N",
            f"{max(row['largest difference from the balance N'] for row in known):.1e}",
        ),
        ("same first carton by engine limit", sum(row["first"] == row["by limit"] for row in known)),
        ("largest load of any vertical forces over that of elastic contacts, median", f"{np.median(spread):.2f}"),
        ("the same, largest", f"{max(spread):.2f}"),
    ]
    return "\n".join(["| what | |", "|---|---|", *(f"| {name} | {value} |" for name, value in lines)])


SUITE = Suite("crushed", __doc__ or "", cases, written=_written)
