"""The six pictures of docs/explanation/predicted_and_measured.md, from saved rows."""

from __future__ import annotations

from typing import Any, BinaryIO

import numpy as np

from bench.experiments.toppling_blocks import BETWEEN
from bench.suite import Row

BLUE, LIGHT, ORANGE, GREY = "#1f5f8b", "#7db8de", "#d9822b", "#555555"
STYLES = {"μ m g": (GREY, "x", 0.0), "limit": (ORANGE, "s", 0.6), "compliant": (BLUE, "o", -0.6)}  # colour, mark, aside
LABELS = {"μ m g": "μ m g, whatever the point"}
LEGENDS = ("upper left", "upper left", "upper right", "upper left", "upper right", "upper left")


def plot(rows: list[Row], file: BinaryIO) -> None:
    """Pushes on feet and on the face, arches, blocks, walls, stacks."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.5, 12.5), layout="constrained")
    places = figure.subplots(3, 2).ravel()
    arms = [row for row in rows if "arm mm" in row]
    _pushes(places[0], "pushes on three feet, four sets", [row for row in arms if row["set"] != "whole face"])
    _pushes(places[1], "pushes on the whole face", [row for row in arms if row["set"] == "whole face"])
    _arches(places[2], [row for row in rows if "friction" in row and row["case"].startswith("arch")])
    _blocks(places[3], {row["case"].split(", ")[-1]: row["kN/m"] for row in rows if "kN/m" in row})
    _walls(places[4], {row["case"]: row for row in rows if row["case"].startswith("wall")})
    _stacks(places[5], [row for row in rows if "blocks" in row])
    for axes, loc in zip(places, LEGENDS, strict=True):
        axes.grid(alpha=0.3)
        axes.set_axisbelow(True)
        axes.legend(frameon=False, fontsize=9, loc=loc)
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(file, dpi=110)


def _pushes(axes: Any, title: str, rows: list[Row]) -> None:  # noqa: ANN401 - matplotlib has no types here
    for name, (colour, mark, aside) in STYLES.items():
        middle = np.array([row[name] for row in rows])
        ends = np.array([[row[f"{name}, {share} %"] for row in rows] for share in (10, 90)])
        style = {"fmt": mark, "color": colour, "elinewidth": 0.8, "markersize": 5}
        arms = [row["arm mm"] + aside for row in rows]
        axes.errorbar(arms, middle, np.abs(ends - middle), label=LABELS.get(name, name), **style)
    axes.axhline(1, color="black", linewidth=0.8)
    axes.set_yscale("log")
    axes.set_ylim(0.45, 6.5)
    axes.set_yticks([0.5, 0.7, 1, 1.5, 2, 3, 5], ["0.5", "0.7", "1", "1.5", "2", "3", "5"], minor=False)
    axes.set_yticks([], minor=True)
    axes.set_xlabel("lever arm [mm] (medians of groups; bars: 10 to 90 %)")
    axes.set_ylabel("predicted / measured")
    axes.set_title(title, loc="left", fontsize=11)


def _arches(axes: Any, rows: list[Row]) -> None:  # noqa: ANN401
    curve = next(row for row in rows if isinstance(row["friction"], list))
    axes.plot(curve["friction"], curve["limit"], "-", color=BLUE, label="limit, 27 voussoirs")
    for kind, colour in (("13 voussoirs", LIGHT), ("27 voussoirs", BLUE), ("joints anywhere", "black")):
        some = [row for row in rows if kind in row["case"] and row is not curve]
        printed = [float(row["printed"]) for row in some]
        axes.plot(
            [row["friction"] for row in some], printed, "o", color=colour, label=f"by others, {kind}", fillstyle="none"
        )
    axes.set_xlabel("friction")
    axes.set_ylabel("least thickness / radius")
    axes.set_title("arches: how thin they may be", loc="left", fontsize=11)


def _blocks(axes: Any, forces: dict[str, list[float]]) -> None:  # noqa: ANN401
    bars = (("printed", "black"), ("35 nodes", BLUE), ("7 nodes", LIGHT), ("limit", ORANGE))
    where = np.arange(len(BETWEEN))
    for k, (name, colour) in enumerate(bars):
        label = f"compliant, {name} a side" if "nodes" in name else name
        axes.bar(where + 0.2 * (k - 1.5), forces[name], 0.2, color=colour, label=label)
    axes.set_xticks(where, [f"P{12 - k}" for k in where])
    axes.set_ylim(0, 11_000)
    axes.set_ylabel("force between neighbours [kN/m]")
    axes.set_title("Goodman and Bray's blocks at the printed limit", loc="left", fontsize=11)


def _walls(axes: Any, rows: dict[str, Row]) -> None:  # noqa: ANN401
    where = np.arange(3)
    for k, (kind, engine, colour) in enumerate(
        (("associated", "limit", ORANGE), ("non-associated", "compliant", BLUE))
    ):
        some = [rows[f"wall {number}, {kind}"] for number in (1, 2, 3)]
        at = where + 0.38 * (k - 0.5)
        axes.bar(at, [row[engine] for row in some], 0.36, color=colour, label=engine)
        axes.plot(
            at, [float(row["printed"]) for row in some], "_", color="black", markersize=30, label="printed" if k else ""
        )
    axes.set_xticks(where, ["wall 1", "wall 2", "wall 3"])
    axes.set_ylim(0, 0.8)
    axes.set_ylabel("acceleration at which it moves [g]")
    axes.set_title("Ferris and Tin-Loi's walls, with and without dilatancy", loc="left", fontsize=11)


def _stacks(axes: Any, rows: list[Row]) -> None:  # noqa: ANN401
    blocks, reach = np.array([[row["blocks"], row["reach"]] for row in rows]).T
    most = np.arange(1, 31)
    axes.plot(most, np.cumsum(0.5 / most), "-", color="black", linewidth=0.8, label="harmonic sum")
    for engine in ("limit", "compliant"):
        colour, mark, _ = STYLES[engine]
        axes.plot(blocks, reach * [row[engine] for row in rows], mark, color=colour, label=engine, fillstyle="none")
    axes.set_xlabel("blocks")
    axes.set_ylabel("overhang [block lengths]")
    axes.set_title("how far a stack reaches", loc="left", fontsize=11)
