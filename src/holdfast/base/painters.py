"""Pictures of answers, drawn by painters that higher floors register here.

An answer does not know how it is drawn: ``queries`` and ``applications`` lie below ``report`` and ``drawing`` and
import neither. A painter is therefore registered for a class of answers and a file suffix, and
``answer.save_png(path)`` looks it up here. Drawing libraries are slow to import, but ``import holdfast`` has to be
fast. ``holdfast/__init__``, which stands above all floors, therefore gives ``painters_come_from`` a function that
imports the painters, and this function is called when the first picture is drawn. No module is looked up by its name in
a string: the test of the floors can see every import, and code that uses the floors without ``holdfast/__init__`` can
register painters of its own.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from holdfast.base.errors import HoldfastError, message
from holdfast.base.files import checked_path

Painter = Callable[..., None]  # (answer, path, **options)

Glimpse = Callable[[object], str]  # returns a value as a small picture in HTML; "" if it has no picture

_GLIMPSES: list[Glimpse] = []
_PAINTERS: dict[tuple[type, str], Painter] = {}
_SOURCES: list[Callable[[], object]] = []


def register_painter(kind: type, suffix: str, painter: Painter) -> None:
    """Register ``painter(answer, path, **options)`` to draw answers of class ``kind`` into files with this suffix."""
    _PAINTERS[kind, suffix] = painter


def painters_come_from(source: Callable[[], object]) -> None:
    """Have ``source``, a function that registers painters, called when the next picture is drawn."""
    _SOURCES.append(source)


def paint(answer: object, path: str | os.PathLike[str], suffix: str, **options: Any) -> None:  # noqa: ANN401
    """Draw an answer into the file at ``path``, which has to end in ``suffix``.

    ``options`` are passed to the painter. Raises HoldfastError for another suffix or if no painter is registered.
    """
    _load_painters()
    if checked_path(path, "picture").suffix.lower() != suffix:
        raise HoldfastError(message(str(path), f"does not end in {suffix}", f"name a {suffix} file"))
    painter = _PAINTERS.get((type(answer), suffix))
    if painter is None:
        problem = f"nothing draws a {type(answer).__name__} as {suffix}"
        raise HoldfastError(message("picture", problem, "import holdfast, whose painters do, or register one"))
    painter(answer, path, **options)


def register_glimpse(function: Glimpse) -> None:
    """Register the function that draws small pictures of scenes and answers for notebooks; the last one counts."""
    _GLIMPSES.append(function)


def glimpse(value: object) -> str:
    """Return a scene or an answer as a small picture in HTML, or "" if nothing shows it."""
    _load_painters()
    return _GLIMPSES[-1](value) if _GLIMPSES else ""


def _load_painters() -> None:
    while _SOURCES:
        _SOURCES[0]()
        _SOURCES.pop(0)
