"""Scenes from the content of files: written to a folder, or not at hand, as the commands read standard input."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import holdfast as hf
from holdfast.base.errors import located
from holdfast.scene.formats.registry import format_of, read_as
from holdfast.scene.formats.source import Source


def read_scene(content: bytes, name: str | Path, **options: Any) -> hf.Scene:
    """The scene that the content of a file called ``name`` holds."""
    with located(str(name)):
        source = Source(Path(name), content)
        return read_as(format_of(source), source, options)


Load = Callable[..., hf.Scene]


def loading(name: str, made: Callable[[Any], str] = str, **usual: object) -> Callable[..., Load]:
    """A fixture that writes what ``made`` makes of a content to a file called ``name``, and loads it."""

    @pytest.fixture
    def load(tmp_path: Path) -> Load:
        def loaded(content: object, **options: object) -> hf.Scene:
            (tmp_path / name).write_text(made(content))
            return hf.load_scene(tmp_path / name, **{**usual, **options})

        return loaded

    return load
