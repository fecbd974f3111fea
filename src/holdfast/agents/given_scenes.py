"""Scenes and objects as a call gives them, read within what is allowed; scenes as a call has them written."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from holdfast.agents.confinement import Confinement, ReadingGuard, check_names
from holdfast.agents.tools import SceneArguments
from holdfast.base.errors import SceneError, located, message
from holdfast.base.text import quoted
from holdfast.scene.body import Body
from holdfast.scene.formats.entries import validated
from holdfast.scene.formats.links import on_the_floor
from holdfast.scene.formats.native import FORMAT, NATIVE, BodyModel, body_of
from holdfast.scene.formats.native import sniff as is_native
from holdfast.scene.formats.registry import format_of, read_as, save_scene
from holdfast.scene.formats.source import Source
from holdfast.scene.scene import Scene

GIVEN = Path("scene")  # the name of a scene that is given inline, beside whose files it lies


def scene_of(arguments: SceneArguments, guard: ReadingGuard) -> Scene:
    """Return the scene of a call; raise HoldfastError if it is refused."""
    if (arguments.scene is None) == (arguments.path is None):
        given = "neither is" if arguments.scene is None else "both are"
        raise SceneError(message("scene and path", f"{given} given", "give one: the scene itself, or its file"))
    limits = guard.limits
    if arguments.path is not None:
        path = limits.readable(arguments.path)
        reading = arguments.reading
        options = {} if reading is None else reading.model_dump(exclude_none=True, exclude={"on_floor"})
        with guard.reading(str(path)), located(str(path)):
            scene = _read(Source(path), limits, options)
            scene = on_the_floor(scene) if reading is not None and reading.on_floor else scene
        where = str(path)
    else:
        if arguments.reading is not None:
            raise SceneError(message("reading", "is given with a scene", "it is for files: write it into the scene"))
        text = arguments.scene if isinstance(arguments.scene, str) else json.dumps(arguments.scene)
        where, content = str(GIVEN), text.encode("utf-8", "surrogatepass")
        with guard.reading(where, len(content)):
            source = Source(GIVEN, content)
            if not is_native(source):
                told = source.data.get("format") if isinstance(source.data, dict) else None
                problem = "is not given" if told is None else f"is {quoted(told)}"
                raise SceneError(message(f"{where}: format", problem, f"needs `format: {FORMAT}`"))
            scene = _read(source, limits, {})
    limits.check_scene(scene, where)
    return scene


def _read(source: Source, limits: Confinement, options: dict[str, Any]) -> Scene:
    """Read a scene; of the native format, counts and names are checked before anything is built."""
    chosen = format_of(source)
    if chosen is NATIVE:
        _check_plain(source.data, limits, str(source.path))
    whole_folder: dict[str, Any] = {"within": ".", "model_path": ["."]}  # what a file names may lie anywhere in it
    return read_as(
        chosen, source, {name: whole_folder[name] for name in whole_folder.keys() & chosen.options} | options
    )


def _check_plain(data: Any, limits: Confinement, where: str) -> None:  # noqa: ANN401 - plain data
    """Raise SceneError for too many bodies and for hostile names in the data of a native scene."""
    bodies = data.get("bodies")
    if data.get("name"):
        check_names([data["name"]], f"{where}: name")
    if isinstance(bodies, list):
        limits.check_count(len(bodies), where)
        for number, body in enumerate(bodies):
            for key in ("name", "material"):
                if isinstance(body, dict) and isinstance(body.get(key), str):
                    check_names([body[key]], f"{where}: bodies[{number}].{key}")


def apart(scene: Scene, thing: str | dict[str, Any], guard: ReadingGuard) -> tuple[Scene, Body]:
    """Return the scene without the object that is to be placed, and the object."""
    if isinstance(thing, str):
        check_names([thing], "place: object")
        return scene.without([thing]), scene.body(thing)
    check_names([thing.get("name")], "place: object.name")
    with guard.reading("object", len(json.dumps(thing))), located("place: object"):
        body = body_of(validated(BodyModel, thing, Path("object")), GIVEN)
    check_names(filter(None, body.materials), "place: object.material")
    return scene, body


def saved(scene: Scene, target: Path | None) -> list[str]:
    """Write a scene to the file that was asked for, if any; return the note that says so."""
    if target is None:
        return []
    save_scene(scene, target)
    return [f"written: {target.name}"]
