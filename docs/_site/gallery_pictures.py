"""Pictures of the gallery: those that an example saves, or else the bodies that it asked about and what moves there."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any, Final

from gallery_bodies import bodies_and_movers
from sphinx_gallery.scrapers import figure_rst

COLOURED: Final = "\nThe bodies of the example, those in red as they move in its last answer.\n\n"
BARE: Final = "\nThe bodies of the example.\n\n"
_folders: dict[str, Path] = {}  # by example
_taken: set[Path] = set()


def arguments(gallery: dict[str, Any], script: dict[str, Any]) -> list[str]:
    """Return the arguments that an example is run with: a folder of its own for what it writes."""
    name = script["src_file"]
    if name not in _folders:
        _folders[name] = Path(tempfile.mkdtemp(prefix="holdfast-gallery-")) / "out"
        _folders[name].mkdir()
    return [str(_folders[name])]


def pictures(block: Any, variables: dict[str, Any], gallery: dict[str, Any]) -> str:  # noqa: ANN401 - Sphinx-Gallery's
    """Take the pictures that the example saved since the last block, and return the text that shows them."""
    if "notebooks" in Path(variables["src_file"]).parts:  # answers show themselves there
        return ""
    folder = _folders.get(variables["src_file"])
    saved = [] if folder is None else sorted(folder.glob("*.png"))
    shown = []
    for path in saved:
        if path not in _taken:
            _taken.add(path)
            shown.append(next(variables["image_path_iterator"]))
            shutil.copy(path, shown[-1])
    said = ""
    drawn = None if saved else bodies_and_movers(variables["example_globals"])
    if drawn is not None:
        content, moving = drawn
        shown.append(next(variables["image_path_iterator"]))
        Path(shown[-1]).write_bytes(content)
        said = COLOURED if moving else BARE
    return figure_rst(shown, gallery["src_dir"]) + said
