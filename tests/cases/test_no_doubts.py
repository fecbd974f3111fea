"""Real scenes raise no doubt about densities and sizes: settled ones of simulators, and loaded pallets."""

from __future__ import annotations

from pathlib import Path

import pytest
from shared import needed, paths
from test_cargo import FEW, MANY, pallet

import holdfast as hf
from holdfast.assembly.caution import doubts

pytestmark = needed


@pytest.mark.parametrize("path", paths("settled"))
def test_settled_scenes_raise_no_doubt(path: Path) -> None:
    assert doubts(hf.load_scene(path).movable) == ()


@pytest.mark.parametrize("place", [*FEW, *MANY])
def test_loaded_pallets_raise_no_doubt(place: int) -> None:
    assert doubts(pallet(place).movable) == ()
