"""The commands about files: convert and schema."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from holdfast.base import envelope as answers
from holdfast.base.arrays import checked_word
from holdfast.base.errors import HoldfastError, message
from holdfast.base.plugins import plugin_notes
from holdfast.certificates import schema as certificate
from holdfast.cli.assignments import option
from holdfast.cli.command import takes_scene
from holdfast.cli.output import AsJson, out, print_json, write
from holdfast.cli.scenes import STREAM, SceneGiven
from holdfast.scene.formats.native import scene_text, schema
from holdfast.scene.formats.published import settled_schema
from holdfast.scene.formats.registry import save_scene, writable

WRITTEN_SUFFIXES = ", ".join(dict.fromkeys(suffix for each in writable() for suffix in each.suffixes))
TARGET = f"scene file to write: {WRITTEN_SUFFIXES}; - for standard output (YAML)"


@takes_scene
def convert(
    source: SceneGiven,
    target: Annotated[Path, typer.Argument(metavar="TARGET", help=TARGET)],
    verbose: Annotated[bool, option("say what the reader of SCENE guessed and left out", "--verbose", "-v")] = False,
    as_json: AsJson = False,
) -> None:
    """Read a scene in any known format and write it in the format that the suffix of TARGET selects."""
    scene = source.read()
    if str(target) == STREAM:
        if as_json:
            raise HoldfastError(message("--json", "the scene itself goes to standard output", "name a TARGET file"))
        write(scene_text(scene))
        return
    if source.scene != STREAM and _same(Path(source.scene), target):
        raise HoldfastError(message(str(target), "is the file that is read", "name another TARGET"))
    save_scene(scene, target)
    counts: dict[str, Any] = {"written": str(target), "bodies": len(scene.bodies), "movable": len(scene.movable)}
    if as_json:
        notes = [*plugin_notes(), *scene.notes]
        print_json(answers.envelope("convert", reason=f"wrote {target}", details=counts, notes=notes))
        return
    out.say(f"wrote {target}: {counts['bodies']} bodies, {counts['movable']} movable")
    for note in scene.notes if verbose else ():
        out.say(f"note: {note}")


def _same(source: Path, target: Path) -> bool:
    """Tell whether two paths lead to one file, through links or not."""
    try:
        return source.samefile(target)
    except (OSError, ValueError):
        return False


def print_schema(
    kind: Annotated[
        str, typer.Argument(metavar="[KIND]", help="scene, settled (settled-scene/1), certificate or answer (--json)")
    ] = "scene",
) -> None:
    """Print the JSON schema of the native scene file, of settled scenes, of certificates, or of answers."""
    schemas = {"scene": schema, "settled": settled_schema, "certificate": certificate.schema, "answer": answers.schema}
    checked_word(kind, tuple(schemas), "KIND")
    print_json(schemas[kind](), indent=2)
