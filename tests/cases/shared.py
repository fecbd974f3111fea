"""The published and settled cases, which live beside the repository and are not part of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).parents[3] / "shared" / "cases"

needed = pytest.mark.skipif(not FOLDER.is_dir(), reason=f"needs the case files in {FOLDER}")


def paths(kind: str) -> list[Any]:
    """The files of ``published`` or ``settled`` as test parameters; one skipped parameter where they are absent."""
    found = sorted((FOLDER / kind).glob("*.json"))
    return [pytest.param(path, id=path.stem) for path in found] or [pytest.param(Path(), id="absent")]


def contents(path: Path) -> dict[str, Any]:
    """A case file as plain data."""
    data: dict[str, Any] = json.loads(path.read_text())
    return data
