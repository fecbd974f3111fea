"""The commands about taking bodies out and putting them in: remove, disassemble and build."""

from __future__ import annotations

from typing import Annotated

import typer

from holdfast.applications.disassembly.build import PUSHES, build_order
from holdfast.applications.disassembly.order import SOLVES, can_remove, disassembly_order
from holdfast.cli.assignments import option
from holdfast.cli.command import PROOF, SAVE, CommandAnswer, EngineGiven, Several, Vector, question
from holdfast.cli.scenes import AssemblyGiven
from holdfast.report.order_report import build_report, disassembly_report, removal_report

Solves = Annotated[int, option("stop after this many checks by contact forces")]
Hands = Annotated[int, option("hands that may hold other bodies where they are")]


@question(removal_report, certificate=PROOF)
def remove(
    scene: AssemblyGiven,
    body: Annotated[str, typer.Argument(help="the body that is to be taken out")],
    engine: EngineGiven,
    lift: Annotated[Vector, option("direction in which it leaves: X Y Z")] = (0, 0, 1),
    hands: Hands = 0,
) -> CommandAnswer:
    """Decide whether one body may be taken out of a scene now, and say who would move if not."""
    method, assembly = engine.chosen(), scene.assembled()
    return CommandAnswer(can_remove(assembly, body, lift=lift, engine=method, hands=hands), assembly.scene.notes)


@question(disassembly_report, png="write a PNG of the sequence to this file", certificate=PROOF)
def disassemble(
    scene: AssemblyGiven,
    engine: EngineGiven,
    goal: Annotated[Several, option("take out this body (may be repeated); default: all")] = None,
    lift: Annotated[Vector, option("direction in which bodies leave: X Y Z")] = (0, 0, 1),
    solves: Solves = SOLVES,
    hands: Hands = 0,
) -> CommandAnswer:
    """Find an order in which the bodies of a scene can be taken out, one by one, while the others stand."""
    method, assembly = engine.chosen(), scene.assembled()
    order = disassembly_order(assembly, engine=method, lift=lift, goal=goal or None, solves=solves, hands=hands)
    return CommandAnswer(order, assembly.scene.notes)


@question(build_report, save=SAVE, certificate=PROOF)
def build(
    scene: AssemblyGiven,
    engine: EngineGiven,
    lift: Annotated[Vector, option("direction that bodies come from: X Y Z")] = (0, 0, 1),
    pushes: Annotated[int, option("approximate number of pushes on each state; 0: none")] = PUSHES,
    solves: Solves = SOLVES,
    hands: Hands = 0,
) -> CommandAnswer:
    """Find an order in which a scene can be built, so that everything stands after each step."""
    method, assembly = engine.chosen(), scene.assembled()
    order = build_order(assembly, lift=lift, pushes=pushes, solves=solves, engine=method, hands=hands)
    return CommandAnswer(order, assembly.scene.notes)
