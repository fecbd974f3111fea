"""The commands for scene files: ``convert`` and ``schema``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from holdfast.cli.common import WRITTEN_SUFFIXES, AsJson, SceneArgument, out, print_json, scene_of
from holdfast.scene.formats.native import schema
from holdfast.scene.formats.registry import save_scene


def convert(
    source: SceneArgument,
    target: Annotated[Path, typer.Argument(metavar="TARGET", help=f"scene file to write: {WRITTEN_SUFFIXES}")],
    as_json: AsJson = False,
) -> None:
    """Read a scene in any known format and write it in the format that the suffix of TARGET selects."""
    scene = scene_of(source)
    save_scene(scene, target)
    counts = {"written": str(target), "bodies": len(scene.bodies), "movable": len(scene.movable)}
    if as_json:
        print_json(counts)
    else:
        text = f"wrote {target}: {counts['bodies']} bodies, {counts['movable']} movable"
        out.print(text, highlight=False, soft_wrap=True)


def print_schema() -> None:
    """Print the JSON schema of the native scene file."""
    print_json(schema(), indent=2)
