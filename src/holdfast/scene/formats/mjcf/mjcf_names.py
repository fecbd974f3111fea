"""Names of the objects of a compiled MuJoCo model, in the model and in a scene."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any


def entries(model: Any, kind: str, count: int) -> list[str]:  # noqa: ANN401 - MuJoCo has no types
    """Return the names of all objects of a kind, such as "body" or "geom"; "" for an object without a name."""
    text, starts = bytes(model.names), getattr(model, f"name_{kind}adr")
    return [text[k : text.index(b"\0", k)].decode(errors="replace") for k in starts[:count].tolist()]


def unique(wanted: Iterable[str]) -> list[str]:
    """Return the names with numbers appended to repeated ones."""
    taken: set[str] = set()
    result = []
    for name in wanted:
        chosen, number = name, 2
        while chosen in taken:
            chosen, number = f"{name} ({number})", number + 1
        taken.add(chosen)
        result.append(chosen)
    return result
