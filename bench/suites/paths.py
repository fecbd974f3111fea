"""Load paths of ``compliant`` at its quick pace beside a close one: the peaks of random pushes, and linear systems."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial

import numpy as np

import holdfast as hf
from bench.scenes.random_assemblies import FAMILIES, standing
from bench.scenes.random_pushes import columns, random_pushes
from bench.scenes.real_pallets import pallet, pallets
from bench.suite import Case, Row, Suite, table
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError
from holdfast.elastic.system import CLOSE, PathOutcome
from holdfast.engines.compliant.elastic_model import Springs
from holdfast.engines.compliant.grid import Grid
from holdfast.scene.shipped import shipped_scene

SCENES = ("cube", "stack", "table", "tall_table", "slope_two", "wall2x2", "v_groove", "arch")
MEMBERS = 5  # assemblies of each random family
EVERY, MOST_BOXES = 4, 50  # each so-manieth pallet of no more boxes
PUSHES = {"scene": 600, "member": 120, "pallet": 60}  # number of pushes at each slant
SLANTS = (0.0, 35.0)  # [°] largest angles from the normal
NODES = 7  # a side
FAR = 30.0  # times the weight of all bodies, beyond which a path is not followed
SAME, CLEARLY = 0.002, 0.005  # relative difference of peaks that counts as none, and as a clear one
SEED = 2026


def cases() -> Mapping[str, Case]:
    """One case a scene, family or pallet."""
    some = [boxes for boxes in pallets() if len(boxes) <= MOST_BOXES][::EVERY]
    drawn: dict[str, Callable[[], Drawn]] = {f"scene {name}": partial(_scene, name) for name in SCENES}
    drawn |= {f"family {name}": partial(_family, name) for name in FAMILIES}
    drawn |= {f"pallet {k}: {len(boxes)} boxes": partial(_pallet, boxes) for k, boxes in enumerate(some)}
    return {name: partial(_case, name, source) for name, source in drawn.items()}


Drawn = Iterator[tuple[hf.answers.Assembly, int]]  # assemblies, and the pushes of each slant


def _scene(name: str) -> Drawn:
    yield hf.assemble(shipped_scene(name)), PUSHES["scene"]


def _family(name: str) -> Drawn:
    for member in range(MEMBERS):
        try:
            yield standing(FAMILIES[name], np.random.default_rng([SEED, member])), PUSHES["member"]
        except HoldfastError:  # none of many draws stands
            continue


def _pallet(boxes: list[dict[str, object]]) -> Drawn:
    yield hf.assemble(pallet(boxes)), PUSHES["pallet"]


def _case(name: str, drawn: Callable[[], Drawn]) -> list[Row]:
    """One row of all paths that end at a peak at both paces."""
    peaks, maxima, ends, systems = [], [], [], np.zeros(2, dtype=np.int64)
    for assembly, count in drawn():
        grid = Grid.of(assembly, assembly.weight_wrench(), Springs(NODES))
        most = FAR * float(np.linalg.norm(assembly.scene.gravity)) * float(assembly.mass.sum())
        for slant in SLANTS:
            pushes = random_pushes(assembly, np.random.default_rng([SEED, int(slant)]), count, slant=slant)
            loads = grid.loads(columns(assembly, pushes))
            farthest = np.full(len(loads), most)
            a = grid.system.paths(grid.settled.q, loads, most=farthest)
            b = grid.system.paths(grid.settled.q, loads, most=farthest, pace=CLOSE)
            systems += [a.systems.sum(), b.systems.sum()]
            ends.append(a.outcome != b.outcome)
            both = (a.outcome == PathOutcome.PEAK) & (b.outcome == PathOutcome.PEAK)
            peaks.append(_apart(a.peak[both], b.peak[both]))
            maxima.append(_apart(a.first[both], b.first[both]))
    off, first = np.concatenate(peaks), np.concatenate(maxima)
    row: Row = {"case": name, "pushes": sum(map(len, ends)), "peaks": len(off)}
    row |= {f"off by {100 * SAME} %": int((np.abs(off) > SAME).sum())}
    row |= {f"high by {100 * CLEARLY} %": int((off > CLEARLY).sum()), "highest %": 100 * float(off.max(initial=0.0))}
    row |= {f"low by {100 * CLEARLY} %": int((off < -CLEARLY).sum()), "lowest %": 100 * float(off.min(initial=0.0))}
    row |= {f"first maxima high by {100 * CLEARLY} %": int((first > CLEARLY).sum())}
    row |= {"end otherwise": int(np.concatenate(ends).sum())}
    return [row | {"systems": int(systems[0]), "systems, close": int(systems[1])}]


def _apart(quick: Float, close: Float) -> Float:
    """By which share the loads of the quick paths (k,) are higher."""
    return (quick - close) / np.maximum(np.abs(close), np.finfo(float).tiny)


def written(rows: list[Row]) -> str:
    """All rows, and what all scenes and families give together, and all pallets."""
    lines: list[Row] = []
    for kind in ("scene or family", "pallet"):
        mine = [row for row in rows if row["case"].split()[0] in kind]
        if not mine:
            continue
        line: Row = {"case": f"each {kind}"}
        for key in mine[0]:
            if key == "highest %":
                line[key] = max(row[key] for row in mine)
            elif key == "lowest %":
                line[key] = min(row[key] for row in mine)
            elif key != "case":
                line[key] = sum(row[key] for row in mine)
        lines.append(line)
    return f"{table(lines)}\n\n{table(rows)}"


SUITE = Suite("paths", __doc__, cases, written=written)
