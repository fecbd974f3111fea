"""The published and settled cases, which live beside the repository and are not part of it."""

from __future__ import annotations

import json
from collections.abc import Collection
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).parents[3] / "shared" / "cases"

needed = pytest.mark.skipif(not FOLDER.is_dir(), reason=f"needs the case files in {FOLDER}")


def paths(kind: str, *, slow: Collection[str] = ()) -> list[Any]:
    """The files of ``published`` or ``settled`` as test parameters; one skipped parameter where they are absent.

    Those named in ``slow`` are marked so.
    """
    found = sorted((FOLDER / kind).glob("*.json"))
    marks = {name: [pytest.mark.slow] for name in slow}
    cases = [pytest.param(path, id=path.stem, marks=marks.get(path.stem, [])) for path in found]
    return cases or [pytest.param(Path(), id="absent")]


def contents(path: Path) -> dict[str, Any]:
    """A case file as plain data."""
    data: dict[str, Any] = json.loads(path.read_text())
    return data
