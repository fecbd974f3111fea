"""What the fuzzer found, in its smallest form: every input that once showed a defect, tried again."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fuzz.keeper import Keeper

FOUND = sorted((Path(__file__).parent / "found").glob("*.json"))


@pytest.mark.parametrize("path", FOUND, ids=lambda path: path.stem)
def test_no_defect_is_back(trier: Keeper, path: Path) -> None:
    """The file says what was wrong (``ending``, ``sign``, ``detail``) and where it was found."""
    kept = json.loads(path.read_text())
    found = trier.tried(kept["item"])
    assert found.good, f"{found.ending}: {found.sign}: {found.detail}"
