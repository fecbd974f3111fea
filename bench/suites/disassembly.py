"""How long it takes to plan the disassembly of walls in quarter bond to the end, and of the shipped scenes."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial
from typing import BinaryIO

import holdfast as hf
from bench.suite import Case, Row, Suite
from holdfast.scene.shipped import shipped_scene, shipped_scenes
from holdfast.scene.shipped.blocks import wall

SHAPES = ((4, 2), (8, 3), (9, 5), (19, 5), (29, 7))
REFUSED = ("wedged",)  # does not stand


def cases() -> Mapping[str, Case]:
    hf.disassembly_order(hf.assemble(wall(2, 2, 0.25, "warm-up")))
    walls: dict[str, Case] = {
        f"wall {c} x {b}": partial(_planned, wall(c, b, 0.25, f"wall {c} x {b}")) for c, b in SHAPES
    }
    return {name: partial(_planned, shipped_scene(name)) for name in shipped_scenes() if name not in REFUSED} | walls


def _planned(scene: hf.Scene) -> list[Row]:
    start = time.perf_counter()
    assembly = hf.assemble(scene)
    ready = time.perf_counter()
    hf.stability(assembly)
    stood = time.perf_counter()
    d = hf.disassembly_order(assembly)
    planned = time.perf_counter() - stood
    return [
        {
            "case": scene.name,
            "bodies": len(assembly.movable),
            "interfaces": len(assembly.interfaces),
            "taken out": len(d.order),
            "answers": d.removals.checks,
            "detection s": ready - start,
            "one verdict s": stood - ready,
            "plan s": planned,
            "a removal s": planned / max(len(d.order), 1),
        }
    ]


def plot(rows: list[Row], file: BinaryIO) -> None:
    """Times of walls over the number of bodies, both axes logarithmic."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.5, 4.6), layout="constrained")
    axes = figure.add_subplot()
    walls = sorted((row for row in rows if row["case"].startswith("wall ")), key=lambda row: row["bodies"])
    lines = (("plan s", "the whole order", "#1f5f8b", "s-"), ("a removal s", "one removal", "#5fa3cf", "^--"))
    for key, label, colour, style in lines:
        axes.loglog([row["bodies"] for row in walls], [row[key] for row in walls], style, color=colour, label=label)
    axes.set_xlabel("movable bodies of a wall in quarter bond")
    axes.set_ylabel("seconds")
    axes.set_title("taking a wall apart: every removal proven safe before it is made", loc="left", fontsize=11)
    axes.grid(alpha=0.3, which="both")
    axes.legend(frameon=False)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    figure.savefig(file, dpi=130)


SUITE = Suite("disassembly", __doc__, cases, plot)
