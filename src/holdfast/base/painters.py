"""Pictures of answers, drawn by painters that higher floors register here.

An answer knows that it can be drawn, not how: ``queries`` and ``applications`` lie below ``report`` and ``view`` and
import neither. So a painter is registered by the class of what it draws and the suffix of the file that it writes, and
``answer.save_png(path)`` looks it up here. Drawing is heavy to import, and ``import holdfast`` is light: the package's
own ``__init__``, which stands above all floors, tells ``painters_come_from`` a function that imports the painters, and
it is called when the first picture is wanted. Nothing is looked up by a module's name in a text: every import can be
seen by the test of the floors, and whoever uses the floors without ``holdfast/__init__`` may register painters.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from holdfast.base.errors import HoldfastError, message

Painter = Callable[..., None]  # (answer, path, **options)

_PAINTERS: dict[tuple[type, str], Painter] = {}
_SOURCES: list[Callable[[], object]] = []


def register_painter(kind: type, suffix: str, painter: Painter) -> None:
    """``painter(answer, path, **options)`` draws answers of class ``kind`` into files that end in ``suffix``."""
    _PAINTERS[kind, suffix] = painter


def painters_come_from(source: Callable[[], object]) -> None:
    """Call ``source``, which registers painters, when a picture is wanted for the first time."""
    _SOURCES.append(source)


def paint(answer: object, path: str | os.PathLike[str], suffix: str, **options: Any) -> None:  # noqa: ANN401
    """Draw an answer into the file at ``path``, which has to end in ``suffix``; ``options`` are the painter's."""
    while _SOURCES:
        _SOURCES[0]()
        _SOURCES.pop(0)
    if Path(path).suffix.lower() != suffix:
        raise HoldfastError(message(str(path), f"does not end in {suffix}", f"name a {suffix} file"))
    painter = _PAINTERS.get((type(answer), suffix))
    if painter is None:
        problem = f"nothing draws a {type(answer).__name__} as {suffix}"
        raise HoldfastError(message("picture", problem, "import holdfast, whose painters do, or register one"))
    painter(answer, path, **options)
