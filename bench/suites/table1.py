"""Table I of Nadeau & Kelly: every method on cube, stack and table, beside two truths and the printed figures.

A run has a seed of its own for the paper's contact points (twenty an interface, each the farthest of ten random ones)
and for its pushes: inward, normal, spread over the surfaces. Times are of contacts, forces and 1,000 pushes; of
slow methods in proportion, from the pushes that were made. Points whose truth is infinite are left out of the error, as
printed, and counted apart.
"""

from __future__ import annotations

import importlib.util
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import BinaryIO

import numpy as np

import holdfast as hf
from bench.baselines import optimised, simulated
from bench.baselines.answers import Protocol, Simulator
from bench.scenes.pushes import Pushes, on_boxes
from bench.suite import Case, Row, Suite
from bench.truth import coupled, decoupled
from holdfast.assembly.contact_nodes import ContactNodes, contact_nodes
from holdfast.base.arrays import Float, Objects
from holdfast.engines.contract import State
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene

SCENES: Mapping[str, Sequence[str]] = {
    "cube": ("cube",),
    "stack": ("cube1", "cube2", "cube3"),
    "table": ("slab", "leg_left", "leg_right"),
}
RUNS = 10
NODES = 20
MANY = 200  # pushes a run of the quick methods
TIMED = 3  # runs of 1,000 pushes of theirs that are timed
BRACKET = 0.01  # relative: how close a simulated load search comes
PAPER, OWN = ("paper's points",), ("own points",)
BOTH = PAPER + OWN
OPTIMISTIC = 0.01  # relative: a smaller excess is no optimism

Answering = Callable[[hf.answers.Assembly, ContactNodes | None, int, Sequence[Pushes]], Float]


@dataclass(frozen=True)
class Method:
    """A row of the table: ``answer(assembly, nodes, seed, pushes)`` gives forces (n,) [N], NaN where undecided.

    ``pushes`` a run; ``points``: asked on which contact points; ``printed``: the paper's (time [s], error [%]) for
    cube, stack and table; ``needs``: a module of an extra.
    """

    answer: Answering
    pushes: int
    points: Sequence[str]
    printed: Sequence[tuple[float, float]] = ()
    needs: str = ""


def by_graph(
    isolated: bool, assembly: hf.answers.Assembly, nodes: ContactNodes | None, seed: int, asked: Sequence[Pushes]
) -> Float:
    """Engine ``graph``: all pushes at once."""
    engine = hf.Graph(isolated=isolated, sampling="hull" if nodes is None else "paper", seed=seed)
    return _factors(engine.prepare(assembly), assembly, asked)


def by_limit(
    cone: hf.Limit, assembly: hf.answers.Assembly, nodes: ContactNodes | None, seed: int, asked: Sequence[Pushes]
) -> Float:
    """Engine ``limit``: one program a push."""
    return _factors(cone.on(assembly, assembly.weight_wrench(), nodes), assembly, asked)


def by_compliant(
    assembly: hf.answers.Assembly, nodes: ContactNodes | None, seed: int, asked: Sequence[Pushes]
) -> Float:
    """Engine ``compliant``: one load path a push."""
    return _factors(hf.Compliant().on(assembly, assembly.weight_wrench(), nodes), assembly, asked)


def by_ipopt(
    sides: int, assembly: hf.answers.Assembly, nodes: ContactNodes | None, seed: int, asked: Sequence[Pushes]
) -> Float:
    """The printed linear program, solved by IPOPT as printed."""
    found = [
        optimised(assembly, p.body, p.points, -p.normals, sides=sides, nodes=nodes) for p in asked if len(p.points)
    ]
    return np.concatenate([_decided(answers.force, answers.status) for answers in found])


def by_simulation(
    engine: Simulator, protocol: Protocol,
    assembly: hf.answers.Assembly, nodes: ContactNodes | None, seed: int, asked: Sequence[Pushes],
) -> Float:  # fmt: skip
    """Loads tried in a simulator, which finds its own contact points."""
    found = [
        simulated(assembly, p.body, p.points, -p.normals, engine=engine, protocol=protocol, accuracy=BRACKET)
        for p in asked
        if len(p.points)
    ]
    return np.concatenate([_decided(answers.force, answers.status) for answers in found])


METHODS: Mapping[str, Method] = {
    "isolated": Method(partial(by_graph, True), MANY, BOTH, ((0.07, 0), (0.23, 30), (0.24, 44))),
    "simulation, PyBullet, as printed": Method(
        partial(by_simulation, "pybullet", "printed"), 20, OWN, ((0.80, 22), (10.1, 26), (41.7, 67)), "pybullet"
    ),
    "simulation, PyBullet, held": Method(partial(by_simulation, "pybullet", "hold"), 5, OWN, needs="pybullet"),
    "simulation, LMGC90, held": Method(partial(by_simulation, "lmgc90", "hold"), 4, OWN, needs="compas_lmgc90"),
    "simulation, MuJoCo, held": Method(partial(by_simulation, "mujoco", "hold"), 3, OWN, needs="mujoco"),
    "polygon 4, IPOPT": Method(partial(by_ipopt, 4), 3, PAPER, ((10.9, 16), (151, 17), (118, 23.6)), "casadi"),
    "polygon 8, IPOPT": Method(partial(by_ipopt, 8), 3, PAPER, ((23.6, 11), (205, 10), (118, 9)), "casadi"),
    "polygon 4": Method(partial(by_limit, hf.Limit("inscribed", 4)), MANY, BOTH),
    "polygon 8": Method(partial(by_limit, hf.Limit("inscribed", 8)), MANY, BOTH),
    "graph": Method(partial(by_graph, False), MANY, BOTH, ((0.13, 0.0), (0.20, 1.0), (0.23, 1.2))),
    "limit": Method(partial(by_limit, hf.Limit()), MANY, BOTH),
    "compliant": Method(by_compliant, MANY, BOTH),
}


def cases() -> Mapping[str, Case]:
    """One for each scene and method whose extra is installed."""
    there = [name for name, method in METHODS.items() if not method.needs or importlib.util.find_spec(method.needs)]
    return {f"{scene}: {name}": partial(measured, scene, name) for scene in SCENES for name in there}


def measured(scene: str, name: str) -> list[Row]:
    """One row: means over the runs."""
    method = METHODS[name]
    points, printed = method.points[-1], method.printed
    run_once(scene, method, points, 0, 1)  # compiles
    runs = {kind: [run_once(scene, method, kind, k, method.pushes) for k in range(RUNS)] for kind in method.points}
    if method.pushes == MANY:
        seconds = float(np.median([run_once(scene, method, points, k, 1000)[0] for k in range(TIMED)]))
    else:
        seconds = float(np.mean([spent for spent, _ in runs[points]])) * 1000 / method.pushes
    row: Row = {"case": f"{scene}: {name}", "scene": scene, "method": name, "runs": RUNS, "pushes a run": method.pushes}
    row["1,000 pushes s"] = seconds
    row["paper s"], row["paper error %"] = printed[list(SCENES).index(scene)] if printed else (None, None)
    for truth in ("decoupled", "coupled"):
        if truth == "coupled" and scene == "table":
            continue  # legs in a frame: no truth by hand couples slip, torsion and racking there
        true = np.concatenate([truths(truth, scene, method.pushes, k) for k in range(RUNS)])
        for kind, done in runs.items():
            answers = np.concatenate([force for _, force in done])
            row |= {f"{truth}, {kind}: {key}": value for key, value in compared(answers, true).items()}
    return [row]


def run_once(scene: str, method: Method, points: str, seed: int, count: int) -> tuple[float, Float]:
    """Seconds for contacts, forces and pushes, and the answers to ``count`` pushes, from a fresh scene."""
    built = shipped_scene(scene)
    asked = on_boxes(built, SCENES[scene], count, seed)
    start = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hf.errors.HoldfastWarning)
        assembly = hf.assemble(built)
        nodes = contact_nodes(assembly, NODES, "paper", seed) if points in PAPER else None
        force = method.answer(assembly, nodes, seed, asked)
    return time.perf_counter() - start, force


@cache
def truths(which: str, scene: str, count: int, seed: int) -> Float:
    """A truth (n,) [N] of a run's pushes (bench/truth/decoupled.py, coupled.py)."""
    built = shipped_scene(scene)
    assembly = hf.assemble(built)
    known = decoupled.robustness if which == "decoupled" else coupled.robustness
    asked = on_boxes(built, SCENES[scene], count, seed)
    return np.concatenate([known(assembly, p.body, p.points, -p.normals) for p in asked])


def compared(answers: Float, true: Float) -> Row:
    """Errors of ``answers`` (n,) where both are finite; how often the kind agrees; how optimistic they are."""
    decided = ~np.isnan(answers)
    a, t = answers[decided], true[decided]
    limited = np.isfinite(t)
    both = np.isfinite(a) & limited
    bold = limited & (a > (1 + OPTIMISTIC) * t)
    return {
        "error %": 100 * float(np.abs(a[both] / t[both] - 1).mean()) if both.any() else None,
        "kind agrees %": 100 * float((np.isfinite(a) == limited).mean()),
        "optimistic %": 100 * float(bold.sum() / max(limited.sum(), 1)),
        "worst optimistic %": 100 * float((a[bold] / t[bold] - 1).max(initial=0)),
        "undecided %": 100 * float(1 - decided.mean()),
    }


def _factors(state: State, assembly: hf.answers.Assembly, asked: Sequence[Pushes]) -> Float:
    columns = [push_columns(assembly, assembly.index[p.body], p.points, -p.normals) for p in asked]
    found = state.load_factor(np.hstack(columns))
    return _decided(found.force, found.status)


def _decided(force: Float, status: Objects) -> Float:
    return np.where(status == hf.Status.UNDECIDED, np.nan, force)


COLUMNS = (
    ("s", "1,000 pushes s"),
    ("paper s", "paper s"),
    ("decoupled truth: paper's points, error %", "decoupled, paper's points: error %"),
    ("own points, error %", "decoupled, own points: error %"),
    ("paper error %", "paper error %"),
    ("coupled truth: paper's points, error %", "coupled, paper's points: error %"),
    ("own points, error %", "coupled, own points: error %"),
    ("finite/infinite right %", "kind agrees %"),
    ("optimistic %", "optimistic %"),
    ("worst optimistic %", "worst optimistic %"),
    ("undecided %", "undecided %"),
)
DETAILS = 7  # columns from here on: against the last truth that the scene has, on own points if asked there


def written(rows: list[Row]) -> str:
    """A table for each scene: the paper's figures beside ours."""
    parts = []
    for scene in SCENES:
        truth = "decoupled" if scene == "table" else "coupled"
        lines = [
            f"## {scene}\n",
            f"| method | {' | '.join(head for head, _ in COLUMNS)} |",
            "|---|" + "--:|" * len(COLUMNS),
        ]
        for row in (row for row in rows if row["scene"] == scene):
            points = METHODS[row["method"]].points[-1]
            keys = [f"{truth}, {points}: {key}" if k >= DETAILS else key for k, (_, key) in enumerate(COLUMNS)]
            cells = [_cell(row.get(key)) for key in keys]
            lines.append(f"| {row['method']} ({row['pushes a run']}) | {' | '.join(cells)} |")
        parts.append("\n".join(lines))
    parts.append(
        "In brackets: pushes a run, of ten runs. Times are of contacts, forces and 1,000 pushes (in proportion, where "
        "fewer were made). Times and the last four columns: own points, where there are any; the columns against the "
        "coupled truth (table: the decoupled one); optimistic: more than 1 % above a finite truth, infinite answers "
        "included."
    )
    return "\n\n".join(parts)


def _cell(value: float | str | None) -> str:
    if value is None:
        return "–"
    if isinstance(value, str):
        return {"inf": "∞"}.get(value, value)
    return "∞" if np.isinf(value) else f"{value:.0e}" if 0 < abs(value) < 1e-3 else f"{value:.3g}"


def plot(rows: list[Row], file: BinaryIO) -> None:
    """Errors of every method, a panel for each scene, with its time; the paper's own figures as crosses."""
    from matplotlib.figure import Figure

    names = [name for name in METHODS if any(row["method"] == name for row in rows)]
    figure = Figure(figsize=(13, 0.36 * len(names) + 1.6), layout="constrained")
    panels = figure.subplots(1, 3, sharey=True)
    for axes, scene in zip(panels, SCENES, strict=True):
        for row in (row for row in rows if row["scene"] == scene):
            height, method = names.index(row["method"]), METHODS[row["method"]]
            points = method.points[-1]
            found = {truth: row.get(f"{truth}, {points}: error %") for truth in FILLED}
            for truth, error in found.items():
                if error is not None:
                    face = FILLED[truth] or "white"
                    axes.plot(max(error, LEAST), height, "o", markeredgecolor=INK, markerfacecolor=face, markersize=8)
            if row["paper error %"] is not None:
                axes.plot(max(row["paper error %"], LEAST), height, "x", color="#b5173f", markersize=7)
            axes.text(190, height, _span(row["1,000 pushes s"]), fontsize=8, va="center", ha="left", color="#555555")
        axes.set(xscale="log", xlim=(0.8 * LEAST, 160), yticks=range(len(names)))
        axes.set_yticklabels(names)
        axes.set_xlabel("mean error of finite answers [%]")
        axes.set_title(scene, loc="left", fontsize=11)
        axes.text(190, -0.7, "1,000 pushes", fontsize=8, va="center", color="#555555")
        axes.grid(alpha=0.3, axis="x")
        axes.tick_params(axis="y", length=0)
        axes.spines[["top", "right", "left"]].set_visible(False)
    panels[0].invert_yaxis()
    legend = [
        panels[2].plot(
            [], [], "o", markeredgecolor=INK, markerfacecolor=FILLED["coupled"], label="against the coupled truth"
        ),
        panels[2].plot([], [], "o", markeredgecolor=INK, markerfacecolor="white", label="against the decoupled truth"),
        panels[2].plot([], [], "x", color="#b5173f", label="as the paper prints it"),
    ]
    figure.legend(handles=[line for (line,) in legend], loc="outside lower center", ncols=3, frameon=False)
    figure.savefig(file, dpi=130)


def _span(seconds: float) -> str:
    return (
        f"{seconds:.2g} s"
        if seconds < 100
        else f"{seconds / 60:.0f} min"
        if seconds < 5400
        else f"{seconds / 3600:.1f} h"
    )


INK = "#1f3a4d"
FILLED = {"decoupled": "", "coupled": "#2a8a57"}
LEAST = 0.1  # [%] smaller errors are drawn here
SUITE = Suite(
    "table1", "Table I of the paper: every method on cube, stack and table, beside two truths.", cases, plot, written
)
