"""Pictures of the gallery: the examples save them to the folder that they are given, and from there they are taken."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

from sphinx_gallery.scrapers import figure_rst

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
    folder = _folders.get(variables["src_file"])
    fresh = [] if folder is None else sorted(path for path in folder.glob("*.png") if path not in _taken)
    shown = []
    for path in fresh:
        _taken.add(path)
        shown.append(next(variables["image_path_iterator"]))
        shutil.copy(path, shown[-1])
    return figure_rst(shown, gallery["src_dir"])
