"""Answers the calls of tools, in the worker process of the server: scene in, envelope, words and picture out."""

from __future__ import annotations

import io
import json
import os
import sys
import warnings
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.console import Console

from holdfast.agents.confinement import Confinement, ReadingGuard, check_names
from holdfast.agents.given_scenes import apart, saved, scene_of
from holdfast.agents.tools import (
    ExplainArguments,
    PlaceArguments,
    PushArguments,
    SceneArguments,
    SettleArguments,
    arguments_of,
)
from holdfast.applications.placement.conditions import Approach, Search, Where
from holdfast.applications.placement.planner import plan_placement
from holdfast.applications.settled import settle
from holdfast.assembly.assembly import assemble
from holdfast.base.envelope import enveloped
from holdfast.base.errors import HoldfastError, HoldfastWarning, message
from holdfast.base.text import one_line
from holdfast.drawing.map_png import map_png
from holdfast.drawing.render import thumbnail
from holdfast.queries.map import robustness_map, spacing_for
from holdfast.queries.push import robustness
from holdfast.queries.stability import stability
from holdfast.report.contact_report import map_report, push_report, stability_report
from holdfast.report.description import Report
from holdfast.report.map_picture import picture_of, solids_of
from holdfast.report.pose_report import placement_report, settled_report
from holdfast.scene.scene import Scene

PICTURE = (800, 600)  # width and height of the picture of a scene [px]
PAGE = (1200, 750)  # width and height of the page of a map [px]
MAP_POINTS = 300  # about how many points of a map are asked, if no spacing is given
MOST_ROWS = 20  # of a map, the weakest
LONG_BYTES = 12_000  # size of an envelope from which on details are left out that an agent seldom needs
MOST_BYTES = 200_000  # size of the largest envelope that is told
SEARCH = 0.5  # share of the time limit for the search of a place; maps and the picture have the rest
LONG = ("forces", "certificate", "mechanism", "overlaps")  # details that may be long, the least needed first
WIDTH = 120  # characters of a line of words


@dataclass
class Told:
    """What a tool answers: the envelope, words, and a picture that is drawn if it is wanted."""

    data: dict[str, Any]
    report: list[Report]
    picture: Callable[[], bytes] | None


_guards: list[ReadingGuard] = []  # one, once the worker is warm


def warm(limits: Confinement) -> None:
    """Prepare the worker; names of files in errors become relative to the folder."""
    sys.path[:] = [os.path.abspath(each) for each in sys.path if each]  # the folder's files are no modules
    for variable in ("GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH"):  # further folders of models
        os.environ.pop(variable, None)
    os.environ["MUJOCO_GL"] = "disable"  # to look for a display, the import of MuJoCo would start a program
    _guards[:] = [ReadingGuard(limits)]
    if limits.folder is not None:
        os.chdir(limits.folder)


def answered(call: tuple[str, dict[str, Any]], _: Callable[[Any], None]) -> dict[str, Any]:
    """Return what a call of a tool gives: ``data``, ``words`` and ``picture``, or an ``error``."""
    name, given = call
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", HoldfastWarning)
        try:
            arguments = arguments_of(name, given)
            told = ANSWERS[name](arguments)
            data = _fit(told.data | {"notes": _notes(told.data["notes"], caught)})
            picture = told.picture() if told.picture is not None and arguments.picture else None
            return {"data": data, "words": _words(told.report), "picture": picture}
        except HoldfastError as error:
            return {"error": one_line(error, 1000)}


def _notes(notes: list[str], caught: list[warnings.WarningMessage]) -> list[str]:
    told = [str(each.message) for each in caught if issubclass(each.category, HoldfastWarning)]
    return list(dict.fromkeys(one_line(note) for note in (*told, *notes)))


def _fit(data: dict[str, Any]) -> dict[str, Any]:
    """Return an envelope without the longest details if it is too long, with a note that says so."""
    details = dict(data["details"])
    left = []
    for name in LONG:
        if len(json.dumps(data | {"details": details})) <= LONG_BYTES:
            break
        if details.get(name):
            details[name] = [] if isinstance(details[name], list) else None
            left.append(name)
    note = [f"left out, as the answer is long: {', '.join(left)}"] if left else []
    whole = data | {"details": details, "notes": [*data["notes"], *note]}
    size = len(json.dumps(whole))
    if size > MOST_BYTES:
        remedy = f"the limit is {MOST_BYTES:,}: ask about fewer bodies"
        raise HoldfastError(message("answer", f"has {size:,} bytes", remedy))
    return whole


def _words(reports: list[Report]) -> str:
    """Return reports as plain text."""
    console = Console(file=io.StringIO(), width=WIDTH, color_system=None, markup=False, emoji=False, highlight=False)
    for report in reports:
        console.print(report)
    text: str = console.file.getvalue()  # type: ignore[attr-defined]
    return "\n".join(line.rstrip() for line in text.splitlines()).strip()


def _stands(arguments: SceneArguments) -> Told:
    assembly = assemble(scene_of(arguments, _guards[0]))
    answer = stability(assembly, engine=arguments.engine)
    return Told(
        enveloped(answer),
        [stability_report(assembly, answer)],
        lambda: _drawn(assembly.scene, () if answer.mechanism is None else answer.mechanism.moving),
    )


def _push(arguments: Any) -> Told:  # noqa: ANN401 - checked by its model, as below
    assert isinstance(arguments, PushArguments)
    check_names([arguments.body], "push: body")
    assembly = assemble(scene_of(arguments, _guards[0]))
    bounds = arguments.engine != "graph"  # whose numbers are no bounds
    answer = robustness(
        assembly, arguments.body, arguments.point, arguments.direction, engine=arguments.engine, bounds=bounds
    )
    return Told(enveloped(answer), [push_report(answer)], lambda: _drawn(assembly.scene, answer.moving[0]))


def _settle(arguments: Any) -> Told:  # noqa: ANN401
    assert isinstance(arguments, SettleArguments)
    check_names([*arguments.known, *arguments.upright], "settle: names")
    guard = _guards[0]
    target = None if arguments.save is None else guard.limits.writable(arguments.save)
    answer = settle(
        scene_of(arguments, guard),
        travel=arguments.travel,
        turn_degrees=arguments.turn_degrees,
        known=arguments.known,
        upright=arguments.upright,
        engine=arguments.engine,
    )
    notes = saved(answer.scene, target)
    return Told(
        enveloped(answer, notes=notes),
        [settled_report(answer, answer.given.name or "scene")],
        lambda: _drawn(answer.scene, [name for name, far in zip(answer.names, answer.moved, strict=True) if far > 0]),
    )


def _place(arguments: Any) -> Told:  # noqa: ANN401
    assert isinstance(arguments, PlaceArguments)
    check_names([*(arguments.supports or ()), *arguments.avoid, *filter(None, [arguments.next_to])], "place: names")
    guard = _guards[0]
    target = None if arguments.save is None else guard.limits.writable(arguments.save)
    scene, body = apart(scene_of(arguments, guard), arguments.object, guard)
    answer = plan_placement(
        assemble(scene),
        body,
        Where(arguments.box, arguments.supports, avoid=arguments.avoid, next_to=arguments.next_to),
        Approach("upright" if arguments.upright else None, direction=scene.gravity if arguments.from_above else None),
        Search(seconds=min(arguments.seconds, SEARCH * guard.limits.seconds), seed=arguments.seed),
        engine=arguments.engine,
        friction=arguments.friction,
    )
    placed = None if answer.assembly is None else answer.assembly.scene
    notes = [*scene.notes, *([] if placed is None else saved(placed, target))]
    return Told(
        enveloped(answer, notes=notes),
        [placement_report(answer, scene.name or "scene", answer.name)],
        None if placed is None else lambda: _drawn(placed, [answer.name]),
    )


def _explain(arguments: Any) -> Told:  # noqa: ANN401
    assert isinstance(arguments, ExplainArguments)
    check_names(arguments.bodies or (), "explain: bodies")
    assembly = assemble(scene_of(arguments, _guards[0]))
    names = arguments.bodies
    asked = [body.name for body in assembly.movable] if names is None else names
    known = [name for name in asked if name in assembly.scene.names]
    spacing = arguments.spacing
    if spacing is None and known:
        spacing = spacing_for(assembly, known, MAP_POINTS)
    answer = robustness_map(assembly, names, spacing=spacing or 1.0, engine=arguments.engine)
    state = stability(assembly, engine=arguments.engine)
    order = np.where(answer.answers.decided, answer.force, np.inf).argsort(kind="stable")[:MOST_ROWS]
    rows = enveloped(answer)["rows"]
    notes = [f"rows: the weakest {len(order)} of {len(rows):,} points"] if len(rows) > len(order) else []
    return Told(
        enveloped(answer, rows=[rows[k] for k in order], notes=notes),
        [stability_report(assembly, state), map_report(answer)],
        lambda: map_png(picture_of(answer), size=PAGE),
    )


ANSWERS: dict[str, Callable[[Any], Told]] = {
    "stands": _stands,
    "push": _push,
    "settle": _settle,
    "place": _place,
    "explain": _explain,
}


def _drawn(scene: Scene, coloured: Collection[str]) -> bytes:
    """Return the picture of a scene as PNG, in which some bodies are coloured."""
    return thumbnail(solids_of(scene.bodies), scene.up, coloured, PICTURE)
