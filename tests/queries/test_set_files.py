"""Convex sets in files: other programs can read them, and what cannot be a set is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holdfast as hf


@pytest.fixture(scope="module")
def found() -> hf.answers.ConvexSet:
    return hf.sets.sustainable_accelerations(hf.shipped_scene("cube"))


def test_files_can_be_read_without_holdfast(found: hf.answers.ConvexSet, tmp_path: Path) -> None:
    """Braking at 5 m/s² holds, at 6 it slips: A x <= b as any program reads it."""
    found.save(tmp_path / "set.json")
    found.save(tmp_path / "set.npz")
    fields = json.loads((tmp_path / "set.json").read_text())["value"]["fields"]
    read = [np.reshape(part["$numbers"], part["shape"]) for part in fields["inner"]["$tuple"]]
    with np.load(tmp_path / "set.npz", allow_pickle=False) as archive:
        A, b = archive["inner.0"], archive["inner.1"]
    for rows, ends in (read, (A, b)):
        assert (rows @ [-5.0, 0, 0] <= ends).all()
        assert not (rows @ [-6.0, 0, 0] <= ends).all()


def numbers(values: Any) -> dict[str, Any]:
    array = np.array(values, dtype=float)
    return {"$numbers": array.ravel().tolist(), "dtype": "<f8", "shape": list(array.shape)}


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"box": numbers([[1, 2, 3]])}, "box has shape"),
        ({"inner": {"$tuple": [numbers([[1, 0, 0]]), numbers([1, 1])]}}, "inner: A: has shape"),
        ({"outer": {"$tuple": [numbers([[1, 0, 0]]), numbers([-1])]}}, "outer: b: has -1"),
        ({"claim": {"$enum": ["Claim", "sure"]}}, "is damaged"),
        ({"accuracy": -1}, "accuracy: is -1"),
    ],
)
def test_what_is_no_set_is_refused(
    change: dict[str, Any], match: str, found: hf.answers.ConvexSet, tmp_path: Path
) -> None:
    path = tmp_path / "set.json"
    found.save(path)
    data = json.loads(path.read_text())
    data["value"]["fields"] |= change
    path.write_text(json.dumps(data))
    with pytest.raises(hf.HoldfastError, match=match) as error:
        hf.load_answer(path)
    assert "set.json" in str(error.value)


def test_files_that_are_none(found: hf.answers.ConvexSet, tmp_path: Path) -> None:
    with pytest.raises(hf.HoldfastError, match="no such answer file; check the path"):
        hf.load_answer(tmp_path / "none.json")
    for bad in ("set.txt", "set"):
        with pytest.raises(hf.HoldfastError, match=r"\.json or \.npz"):
            found.save(tmp_path / bad)
    with pytest.raises(hf.HoldfastError, match="cannot be written"):
        found.save(tmp_path / "no" / "set.json")
