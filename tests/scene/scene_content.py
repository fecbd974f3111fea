"""Scenes from the content of files that are not at hand, as the commands read them from standard input."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import holdfast as hf
from holdfast.base.errors import located
from holdfast.scene.formats.registry import format_of, read_as
from holdfast.scene.formats.source import Source


def read_scene(content: bytes, name: str | Path, **options: Any) -> hf.Scene:
    """The scene that the content of a file called ``name`` holds."""
    with located(str(name)):
        source = Source(Path(name), content)
        return read_as(format_of(source), source, options)
