"""Convex sets in files: what is read is what was written, and what is no set is refused."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped import shipped_scene


@pytest.fixture(scope="module")
def found() -> hf.ConvexSet:
    return hf.sustainable_accelerations(hf.assemble(shipped_scene("cube")))


@pytest.mark.parametrize("suffix", ["json", "npz"])
def test_round_trip(suffix: str, found: hf.ConvexSet, tmp_path: Path) -> None:
    found.save(tmp_path / f"set.{suffix}")
    again = hf.ConvexSet.load(tmp_path / f"set.{suffix}")
    for field in fields(found):
        ours, theirs = getattr(found, field.name), getattr(again, field.name)
        assert type(ours) is type(theirs)
        if field.name in ("inner", "outer", "vertices", "bound"):
            arrays = zip(ours, theirs, strict=True) if isinstance(ours, tuple) else [(ours, theirs)]
            for a, b in arrays:
                assert a.tobytes() == b.tobytes()
                assert a.shape == b.shape
                assert not b.flags.writeable
        else:
            assert ours == theirs
    assert again.contains([5.0, 0, 0]) is True


def test_files_can_be_read_without_holdfast(found: hf.ConvexSet, tmp_path: Path) -> None:
    """Braking at 5 m/s² holds, at 6 it slips: A x <= b as any program reads it."""
    found.save(tmp_path / "set.json")
    found.save(tmp_path / "set.npz")
    inner = json.loads((tmp_path / "set.json").read_text())["inner"]
    with np.load(tmp_path / "set.npz", allow_pickle=False) as archive:
        A, b = archive["inner_A"], archive["inner_b"]
    for rows, ends in ((np.array(inner["A"]), np.array(inner["b"])), (A, b)):
        assert (rows @ [-5.0, 0, 0] <= ends).all()
        assert not (rows @ [-6.0, 0, 0] <= ends).all()


def test_usage_is_the_share_of_the_reach(found: hf.ConvexSet) -> None:
    x = np.array([[2.0, 0, 0], [0, -3.0, 0], [0, 0, 0]])
    used = found.usage(x)
    assert used == pytest.approx(np.array([2, 3, 0]) / (0.6 * 9.81), rel=0.021)
    assert (used[:2] >= np.array([2, 3]) / (0.6 * 9.81)).all()
    assert found.usage(x[0]) == used[0]
    assert found.usage(2 * x) == pytest.approx(2 * used)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"format": "other/1"}, "format: is 'other/1'; needs 'holdfast-set/1'"),
        ({"bound": [1, 2, "x"]}, "bound: got"),
        ({"inner": {"A": [[1, 0, 0]], "b": [1, 1]}}, "inner: A: has shape"),
        ({"outer": {"A": [[1, 0, 0]], "b": [-1]}}, "outer: b: has -1"),
        ({"claim": "sure"}, "is not one"),
        ({"vertices": None}, "vertices"),
        ({"inner": None}, "is not one"),
    ],
)
def test_what_is_no_set_is_refused(change: dict[str, object], match: str, found: hf.ConvexSet, tmp_path: Path) -> None:
    path = tmp_path / "set.json"
    found.save(path)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(hf.HoldfastError, match=match) as error:
        hf.ConvexSet.load(path)
    assert "set.json" in str(error.value)


def test_files_that_are_none(found: hf.ConvexSet, tmp_path: Path) -> None:
    for name, content in (("a.json", b"{"), ("a.npz", b"PK no zip"), ("b.json", b"[]")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(hf.HoldfastError, match="is not one"):
            hf.ConvexSet.load(tmp_path / name)
    with pytest.raises(hf.HoldfastError, match="cannot be read"):
        hf.ConvexSet.load(tmp_path / "none.json")
    for bad in ("set.txt", "set"):
        with pytest.raises(hf.HoldfastError, match=r"\.json or \.npz"):
            found.save(tmp_path / bad)
    with pytest.raises(hf.HoldfastError, match="cannot be written"):
        found.save(tmp_path / "no" / "set.json")
