"""Of the rooms of engines, limit analysis knows nothing of elastic contacts; engine ``limit`` stands above both."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import holdfast

ENGINES = Path(holdfast.__file__).parent / "engines"
KNOWS = {"graph": set[str](), "trees": set[str](), "limit": {"trees"}, "compliant": {"trees", "limit"}}


def rooms_imported(source: str) -> Iterator[str]:
    """Yield the rooms of engines that a source imports from."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom):
            place = (node.module or "").split(".")[1:]
            yield from place[1:2] if place[:1] == ["engines"] else []


@pytest.mark.parametrize("room", KNOWS)
def test_a_room_imports_from_itself_and_those_below(room: str) -> None:
    sources = [path.read_text(encoding="utf-8") for path in (ENGINES / room).glob("*.py")]
    assert len(sources) > 2
    above = {*KNOWS, "doubts"} - KNOWS[room] - {room}
    assert {other for source in sources for other in rooms_imported(source)} & above == set()


def test_a_planted_import_is_found() -> None:
    source = "def f():\n    from holdfast.engines.compliant.grid import Grid"
    assert list(rooms_imported(source)) == ["compliant"]
