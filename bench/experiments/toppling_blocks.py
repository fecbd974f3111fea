"""Blocks in a row on the steps of a slope, which topple on each other: Goodman and Bray 1976."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

import holdfast as hf
from bench.experiments.source import G0, Source, block, least, row, threshold
from bench.suite import Case, Row
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.engines.verdict import Verdict
from holdfast.queries.request import total_wrench

DIP = np.radians(30)
HEIGHTS = (4, 8, 12, 16, 20, 24, 28, 32, 36, 40, 34, 28, 22, 16, 10, 4)  # [m], from the toe up
LEAST, ANCHOR, HELD_AT = "0.7855", "2013", 0.65  # tan φ; kN a metre, at this tan φ
BETWEEN = (292.5, 825.7, 1556, 2827, 3922, 4595, 4837, 4638, 3978, 2826, 1414, 472)  # kN a metre, from P12 to P1
NODES = (7, 15, 25, 35)  # a side
SIZE = 0.1  # of the blocks that are asked: it changes no verdict
SCALE = 25e3 / (1000 * G0) / SIZE**2 / 1000  # kN a metre there, for every newton between blocks of 1,000 kg/m³ here
WHY_LEAST = (
    "`limit` lets friction hold what nothing presses together, and says that its verdict is undecided; by hand the"
    " blocks press each other at an edge, which the nodes of `compliant` reach as they get more"
)
WHY_ANCHOR = (
    "as above; `compliant` is UNSTABLE below its number and undecided about the printed one, for nodes lie inside the"
    " edges that press by hand"
)


class Slope(NamedTuple):
    """Blocks of these ``heights`` [m] from the lowest place up, ``width`` [m] wide, on steps of ``step`` [m]."""

    heights: Sequence[float]
    width: float
    step: float

    def scene(self, mu: float) -> hf.Scene:
        """The blocks, which do not touch the risers behind them, with gravity turned by the dip of the slope."""
        bodies, excluded, width = [], [], self.width
        for k, height in enumerate(self.heights):
            x, z = (k + 0.5) * width, k * self.step
            bodies.append(block(f"step{k}", (width, 1, width), (x, 0, z - width / 2), fixed=True))
            bodies.append(block(f"block{k}", (width, 1, height), (x, 0, z + height / 2), density=1000.0))
            if k:
                excluded.append((f"step{k}", f"block{k - 1}"))
        return hf.Scene(bodies, mu, G0 * np.array([-np.sin(DIP), 0, -np.cos(DIP)]), excluded=excluded)

    def stand(self, mu: float) -> bool:
        """Whether they stand, by Goodman and Bray's recursion from the uppermost down.

        Each presses the next one at the top of their contact, with all its friction, by as much as it would topple
        about its lower edge or slide without.
        """
        heights, width, step = self
        pressed, tops = 0.0, step * np.arange(len(heights)) + heights
        for k in range(len(heights) - 1, -1, -1):
            weight = width * heights[k]
            above, below = (min(tops[k], tops[m]) - k * step if 0 <= m < len(heights) else 1.0 for m in (k + 1, k - 1))
            turning = weight / 2 * (heights[k] * np.sin(DIP) - width * np.cos(DIP))
            topples = (pressed * (above - mu * width) + turning) / below
            slides = pressed - weight * (mu * np.cos(DIP) - np.sin(DIP)) / (1 - mu**2)
            pressed = max(topples, slides, 0.0)
        return pressed == 0.0


SIXTEEN = Slope([SIZE * height for height in HEIGHTS], 10 * SIZE, SIZE)
FIVE = Slope((0.18, 0.36, 0.54, 0.72, 0.9), 0.3, 0.03)


def by_hand(slope: Slope) -> float:
    """The least tan φ by the recursion."""
    return least(slope.stand, 0.6, 0.86, 1e-6)


def on_nodes(assembly: Assembly, nodes: int, load: Float | float = 0.0) -> Verdict:
    """The verdict of ``compliant`` on so many nodes a side, whatever its reserve, under one more ``load`` (6J,)."""
    return hf.Compliant(nodes=nodes).on(assembly, assembly.weight_wrench() + load).verdict()


def rests(assembly: Assembly, nodes: int, load: Float | float = 0.0) -> bool:
    """Whether it comes to rest on so many nodes a side."""
    return on_nodes(assembly, nodes, load).status is hf.Status.STABLE


def pressed_between(assembly: Assembly, verdict: Verdict) -> list[float]:
    """The normal forces [kN a metre] between neighbours, P12 to P1, as BETWEEN has them."""
    forces, pairs = verdict.forces, [set(interface.bodies) for interface in assembly.interfaces]
    assert forces is not None
    places = [pairs.index({f"block{k}", f"block{k + 1}"}) for k in range(len(BETWEEN) - 1, -1, -1)]
    return [round(SCALE * abs(float(forces.force[forces.interface == place, 0].sum())), 1) for place in places]


def _least(name: str, slope: Slope, printed: str) -> list[Row]:
    case = f"{name}: least tan φ"
    found = threshold(case, printed, slope.scene, (0.6, 0.86), meant="compliant", why=WHY_LEAST)
    fine = {f"{nodes} nodes": least(partial(_rests_at, slope, nodes), 0.7, 0.86, 1e-4) for nodes in NODES}
    graph = least(lambda mu: hf.stability(slope.scene(mu), engine="graph").stable, 0.6, 0.86, 1e-4)
    return [found | {"graph": graph, "recursion": by_hand(slope)} | fine]


def _rests_at(slope: Slope, nodes: int, mu: float) -> bool:
    return rests(hf.assemble(slope.scene(mu)), nodes)


def _anchor() -> list[Row]:
    assembly = hf.assemble(SIXTEEN.scene(HELD_AT))
    level = np.array([np.cos(DIP), 0, -np.sin(DIP)])

    def load(force: float) -> hf.Load:
        return hf.Load("block0", (SIXTEEN.width / 2, 0, SIXTEEN.heights[0] / 2), force=level * force / SCALE)

    def asked(engine: str, force: float) -> bool:
        verdict = hf.stability(assembly, loads=[load(force)], engine=engine)
        return bool(verdict.equilibrium_exists) if engine == "limit" else verdict.status is not hf.Status.UNSTABLE

    def held(nodes: int, force: float) -> bool:
        return rests(assembly, nodes, total_wrench(assembly, [load(force)]))

    found = {engine: least(partial(asked, engine), 1.0, 4000.0, 0.5) for engine in ("limit", "compliant", "graph")}
    found |= {f"{nodes} nodes": least(partial(held, nodes), 1.0, 4000.0, 0.5) for nodes in NODES}
    return [row("16 blocks: anchor at tan φ = 0.65 [kN/m]", ANCHOR, "compliant", WHY_ANCHOR, **found)]


def _between() -> list[Row]:
    assembly = hf.assemble(SIXTEEN.scene(float(LEAST)))
    found: dict[str, list[float]] = {"printed": [*BETWEEN]}
    for nodes in NODES:
        found[f"{nodes} nodes"] = pressed_between(assembly, on_nodes(assembly, nodes))
    for engine in ("limit", "graph"):
        found[engine] = pressed_between(assembly, hf.stability(assembly, engine=engine).verdict)
    return [{"case": f"16 blocks: forces between them, P12 to P1, {name}", "kN/m": f} for name, f in found.items()]


def cases() -> Mapping[str, Case]:
    """The least friction of two slopes, the anchor that holds the first, and the forces in it."""
    return {
        "16 blocks": partial(_least, "16 blocks", SIXTEEN, LEAST),
        "five blocks": partial(_least, "five blocks", FIVE, f"{by_hand(FIVE):.4f}"),
        "anchor": _anchor,
        "between": _between,
    }


SOURCE = Source(
    "toppling blocks",
    "R. E. Goodman, J. W. Bray, Toppling of rock slopes, Proc. ASCE Specialty Conference on Rock Engineering for"
    " Foundations and Slopes, Boulder (1976) 201-234",
    "the least tan φ at which 16 blocks on steps stand, by a recursion; the anchor that holds them at 0.65; the forces"
    " between them",
    "blocks 10 m wide and 4 to 40 m high on steps of 1 m, a slope of 30 degrees, 25 kN/m³; the risers do not touch",
    cases,
)
