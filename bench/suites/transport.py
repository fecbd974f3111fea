"""Largest accelerations of a carrier in 100 level directions (paper, Fig. 15): engines, polygon cones, simulation."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial
from typing import BinaryIO

import numpy as np

import holdfast as hf
from bench.baselines.carrier import Carrier
from bench.baselines.search import grid_nodes
from bench.suite import Case, Row, Suite, table
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError
from holdfast.drawing.plots import Curve, PolarPicture, draw_curves
from holdfast.engines.contract import Engine
from holdfast.scene.shipped import shipped_scene

SCENES = ("slope", "slope_two")
RUNS = 5
AXES = {"+X": 0, "+Y": 25, "-X": 50, "-Y": 75}  # numbers among the 100 directions
METHODS: Mapping[str, Engine] = {
    "graph": hf.Graph(),
    "limit": hf.Limit(),
    "compliant": hf.Compliant(),
    "polygon 8": hf.Limit(cone="inscribed", sides=8),
    "polygon 4": hf.Limit(cone="inscribed", sides=4),
}
SIMULATION = "simulation"
STEP, SIDE = 1e-3, 2  # time step [s] and nodes along a side of the simulation; corners suffice without rotation
PAPER = {"graph": 0.63, "polygon 8": 3.6, SIMULATION: 38.0}  # [s] times of the paper for the second scene


def cases() -> Mapping[str, Case]:
    """Each scene with all methods in one run; the first answer of each, which compiles, is not timed."""
    return {scene: partial(_scene, scene) for scene in SCENES}


def _scene(name: str) -> list[Row]:
    assembly = hf.assemble(shipped_scene(name))
    ways = assembly.scene.horizontal_directions()
    seconds: dict[str, list[float]] = {method: [] for method in METHODS}
    found: dict[str, Float] = {}
    for k in range(RUNS + 1):
        for method, engine in METHODS.items():
            start = time.perf_counter()
            found[method] = hf.transport_limits(assembly, ways, engine=engine).acceleration
            if k:
                seconds[method].append(time.perf_counter() - start)
    taken: dict[str, float | str] = {method: float(np.median(values)) for method, values in seconds.items()}
    found[SIMULATION], taken[SIMULATION] = _simulated(assembly, ways)
    exact = found["limit"]
    return [_row(name, method, curve, taken[method], exact, found[SIMULATION]) for method, curve in found.items()]


def _simulated(assembly: hf.answers.Assembly, ways: Float) -> tuple[Float, float | str]:
    start = time.perf_counter()
    try:
        carrier = Carrier(assembly, grid_nodes(assembly, SIDE), step=STEP)
    except HoldfastError as error:
        return np.empty(0), f"not measured: {error}"
    found = np.array([carrier.limit(way).acceleration for way in ways])
    return found, time.perf_counter() - start


def _row(scene: str, method: str, curve: Float, seconds: float | str, exact: Float, simulated: Float) -> Row:
    row: Row = {"case": f"{scene}: {method}", "100 directions s": seconds}
    row["paper s"] = PAPER.get(method, "") if scene == "slope_two" else ""
    for axis, k in AXES.items():
        row[axis] = float(curve[k]) if len(curve) else ""
    if len(curve):
        row["most off limit %"] = float(100 * np.abs(curve / exact - 1).max())
    if len(curve) and len(simulated):
        off = curve / simulated - 1
        row["median off simulation %"] = float(100 * np.median(np.abs(off)))
        row["most above simulation %"] = float(100 * off.max())
        row["most below simulation %"] = float(-100 * off.min())
    row["curve"] = [float(value) for value in curve]
    return row


def written(rows: list[Row]) -> str:
    """Return the table without the curves, which are only in the JSON file."""
    return table([{key: value for key, value in row.items() if key != "curve"} for row in rows])


def plot(rows: list[Row], file: BinaryIO) -> None:
    """The two pictures of Fig. 15."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(14, 7.6), layout="constrained")
    for k, scene in enumerate(SCENES):
        axes = figure.add_subplot(1, 2, k + 1, projection="polar")
        curves = [_curve(row) for row in rows if row["case"].startswith(f"{scene}: ") and row["curve"]]
        curves.sort(key=lambda curve: ORDER.index(curve.name))
        draw_curves(axes, PolarPicture(scene, "", ("+x", "+y", "−x", "−y"), tuple(curves)))  # type: ignore[arg-type]
        axes.set_title(f"{('one cube', 'two cubes')[k]}: largest acceleration [m/s²]", fontweight="bold", pad=22)
    handles, labels = axes.get_legend_handles_labels()  # the first is drawn last
    figure.legend(handles[::-1], labels[::-1], loc="outside lower center", ncols=len(labels), frameon=False)
    figure.savefig(file, dpi=110, format="png", bbox_inches="tight", pad_inches=0.2)


ORDER = (SIMULATION, "limit", "graph", "polygon 8", "polygon 4", "compliant")  # the order of the styles of curves


def _curve(row: Row) -> Curve:
    radius = np.array(row["curve"])
    angle = 2 * np.pi * np.arange(len(radius)) / len(radius)
    return Curve(row["case"].split(": ")[1], angle, radius, np.zeros_like(radius), (), np.ones(len(radius), dtype=bool))


SUITE = Suite("transport", __doc__, cases, plot, written)
