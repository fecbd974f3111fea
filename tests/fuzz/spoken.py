"""Names in everything that is written: where they go, and which characters must not arrive there as they are."""

from __future__ import annotations

import json
import unicodedata
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

import holdfast as hf
from holdfast.cli.main import app
from holdfast.scene.shipped.blocks import box, floor

OUTPUTS = ("error", "terminal", "page", "picture", "repr", "file", "archive")
SLOW = ("picture",)
TURNING = {chr(code) for code in (*range(0x202A, 0x202F), *range(0x2066, 0x206A))}


def json_text(data: Any) -> str:
    return json.dumps(data)


def unfit(text: str, output: str = "error") -> str:
    """Say which kind of character an output holds that may not be in it; "" where there is none."""
    allowed = "" if output == "error" else "\n\t"
    for character in text:
        kind = unicodedata.category(character)
        if kind == "Cs":
            return "surrogate"
        if kind == "Cc" and character not in allowed:
            return "control character"
        if character in TURNING or character in "\u2028\u2029":
            return "turning character"
    return ""


def outputs(name: str, folder: Path, output: str) -> Iterator[tuple[str, str]]:
    """Write a scene whose body, material and title have this name to one kind of output; give back what it reads."""
    body = box("b", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))
    named = hf.Body(name, body.shape, mass=1, pose=body.pose, material=name)
    scene = hf.Scene([floor(), named], 0.5, name=name)
    if output == "error":
        yield "error", wrong(scene, name)
    elif output == "repr":
        yield "repr", repr(scene) + repr(hf.assemble(scene)) + repr(hf.stability(scene, engine="limit"))
    elif output == "file":
        for suffix in (".yaml", ".json", ".glb", ".gltf"):
            hf.save_scene(scene, folder / f"s{suffix}")
            again = hf.load_scene(folder / f"s{suffix}")
            assert again == scene, "a saved scene is another one"
    elif output == "archive":
        found = hf.robustness(scene, name, (-0.05, 0, 0.05), (1, 0, 0), engine="limit")
        for suffix in (".npz", ".json"):
            found.save(folder / f"a{suffix}")
            assert hf.load_answer(folder / f"a{suffix}") == found, "a saved answer is another one"
    elif output == "terminal":
        hf.save_scene(scene, folder / "s.json")
        for command in (["assess"], ["map", "--spacing", "0.05", "--engine", "limit"]):
            yield "terminal", shown([command[0], str(folder / "s.json"), *command[1:]])
    else:
        found = hf.robustness_map(scene, spacing=0.05, engine="limit")
        if output == "picture":
            found.save_png(folder / "m.png")
        else:
            found.save_html(folder / "m.html")
            page = (folder / "m.html").read_text(encoding="utf-8")
            yield "page", page[page.rindex('<script id="data"') :] if "<" not in name else raw(name, page)


def wrong(scene: hf.Scene, name: str) -> str:
    """The error for a name that is nearly that of a body."""
    try:
        scene.body(name + "x")
    except hf.HoldfastError as error:
        return str(error)
    raise AssertionError("a body that is not there was found")


def raw(name: str, page: str) -> str:
    """Text that is unfit where a name with markup stands in the page as it is."""
    return "\0" if name in page else ""


def shown(arguments: list[str]) -> str:
    """What a command prints; whatever it raises on purpose is part of that."""
    done = CliRunner().invoke(app, arguments)
    if isinstance(done.exception, hf.HoldfastError):
        return str(done.exception)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done.output
