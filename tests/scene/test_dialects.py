"""Inputs in the dialects of public scene sets load as they should, or are refused with what is to be done."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import holdfast as hf
from tests.scene.scene_dialects import TABLE, Input, inputs, table

INPUTS = inputs()
NEEDED = {".xml": "mujoco", ".usda": "pxr"}


@pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")
@pytest.mark.parametrize("given", INPUTS, ids=[f"{each.source}: {each.file}: {each.shows}" for each in INPUTS])
def test_an_input_does_what_its_data_say(given: Input, tmp_path: Path) -> None:
    path, expected = given.written(tmp_path), dict(given.expected)
    if path.suffix in NEEDED:
        pytest.importorskip(NEEDED[path.suffix])
    if "refused" in expected:
        with pytest.raises(hf.HoldfastError, match=re.escape(expected.pop("refused"))):
            given.loaded(path)
        assert not expected
        return
    scene = given.loaded(path)
    assert len(scene.movable) == expected.pop("movable")
    assert len(scene.bodies) - len(scene.movable) == expected.pop("fixed")
    for said in expected.pop("says", []):
        assert said in " ".join(scene.notes)
    for pair, mu in expected.pop("mu", {}).items():
        assert scene.mu(*pair.split()) == pytest.approx(mu, rel=1e-6)
    if "mass" in expected:
        assert scene.movable[0].mass == pytest.approx(expected.pop("mass"), rel=1e-6)
    if "stands" in expected:
        assert hf.stability(scene).stable is expected.pop("stands")
    assert not expected


def test_the_table_is_what_becomes_of_them() -> None:
    pytest.importorskip("mujoco")
    pytest.importorskip("pxr")
    assert TABLE.read_text() == table(), "write it anew: python -m tests.scene.scene_dialects"
