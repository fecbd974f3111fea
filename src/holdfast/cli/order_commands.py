"""The commands about taking bodies out and putting them in: remove, disassemble and build."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, NoReturn

import typer

from holdfast.applications.disassembly.build import PUSHES, BuildOrder, build_order
from holdfast.applications.disassembly.order import SOLVES, Disassembly, can_remove, disassembly_order
from holdfast.cli.output import AsJson, progress
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.shared_options import (
    EngineName,
    File,
    Files,
    Hands,
    Nodes,
    Proof,
    SaveAnswer,
    Several,
    Vector,
    check_suffix,
    engine_with,
    option,
    tell,
)
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.description import Report
from holdfast.report.order_report import build_report, disassembly_report, removal_report

Solves = Annotated[int, option("stop after this many checks by contact forces")]


@takes_scene
def remove(
    scene: AssemblyGiven,
    body: Annotated[str, typer.Argument(help="the body that is to be taken out")],
    lift: Annotated[Vector, option("direction in which it leaves: X Y Z")] = (0, 0, 1),
    engine: EngineName = DEFAULT_ENGINE,
    hands: Hands = 0,
    nodes: Nodes = None,
    certificate: Proof = None,
    as_json: AsJson = False,
) -> None:
    """Decide whether one body may be taken out of a scene now, and say who would move if not."""
    method = engine_with(engine, nodes=nodes)
    with progress():
        assembly = scene.assembled()
        result = can_remove(assembly, body, lift=lift, engine=method, hands=hands)
    tell(result, removal_report, as_json=as_json, notes=assembly.scene.notes, certificate=certificate)


@takes_scene
def disassemble(
    scene: AssemblyGiven,
    goal: Annotated[Several, option("take out this body (may be repeated); default: all")] = None,
    lift: Annotated[Vector, option("direction in which bodies leave: X Y Z")] = (0, 0, 1),
    engine: EngineName = DEFAULT_ENGINE,
    png: Annotated[File, option("write a PNG of the sequence to this file")] = None,
    solves: Solves = SOLVES,
    hands: Hands = 0,
    nodes: Nodes = None,
    certificate: Proof = None,
    as_json: AsJson = False,
) -> None:
    """Find an order in which the bodies of a scene can be taken out, one by one, while the others stand."""
    check_suffix(png, ".png")
    method = engine_with(engine, nodes=nodes)
    with progress():
        assembly = scene.assembled()
        result = disassembly_order(assembly, engine=method, lift=lift, goal=goal or None, solves=solves, hands=hands)
    _tell_order(result, disassembly_report, [(png, result.save_png)], as_json=as_json, certificate=certificate)


@takes_scene
def build(
    scene: AssemblyGiven,
    lift: Annotated[Vector, option("direction that bodies come from: X Y Z")] = (0, 0, 1),
    pushes: Annotated[int, option("approximate number of pushes on each state; 0: none")] = PUSHES,
    solves: Solves = SOLVES,
    engine: EngineName = DEFAULT_ENGINE,
    save: SaveAnswer = None,
    hands: Hands = 0,
    nodes: Nodes = None,
    certificate: Proof = None,
    as_json: AsJson = False,
) -> None:
    """Find an order in which a scene can be built, so that everything stands after each step."""
    method = engine_with(engine, nodes=nodes)
    with progress():
        assembly = scene.assembled()
        result = build_order(assembly, lift=lift, pushes=pushes, solves=solves, engine=method, hands=hands)
    _tell_order(result, build_report, [(save, result.save)], as_json=as_json, certificate=certificate)


def _tell_order(
    result: Disassembly | BuildOrder,
    report: Callable[[Any], Report],
    files: Files,
    *,
    as_json: bool,
    certificate: File,
) -> NoReturn:
    """Tell the answer of a search for an order, with the notes of its scene, and exit with its code."""
    notes = result.assembly.scene.notes
    tell(result, report, as_json=as_json, notes=notes, files=files, certificate=certificate)
