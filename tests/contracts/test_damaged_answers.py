"""Files of answers that are damaged, by accident or on purpose: one error that says so, and no memory taken before."""

from __future__ import annotations

import contextlib
import io
import json
import struct
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import at, cube

Data = dict[str, Any]


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with answers as a.json, a.npz, c.json, m.json and s.json."""
    folder = tmp_path_factory.mktemp("answers")
    assembly = hf.assemble(cube())
    found = hf.robustness(assembly, "cube", [(-0.05, 0, 0.05), (0, 0, 0.1)], [(1, 0, 0), (0, 0, -1)], engine="limit")
    found.save(folder / "a.json")
    found.save(folder / "a.npz")
    hf.robustness_map(assembly, spacing=0.05, engine="limit").save(folder / "m.json")
    hf.sets.sustainable_accelerations(assembly, accuracy=0.3).save(folder / "c.json")
    hf.stability(hf.Scene([cube().bodies[0], cube().bodies[1].moved(at(0, 0, 1))], 0.5)).save(folder / "s.json")
    return folder


def parts(data: Any, name: str) -> list[Data]:
    """Every object in nested data that has this key, with the last first."""
    here = [data] if isinstance(data, dict) and name in data else []
    inner = data.values() if isinstance(data, dict) else data if isinstance(data, list) else ()
    return [part for item in inner for part in parts(item, name)] + here


def put(name: str, value: Any) -> Callable[[Data], None]:
    def change(data: Data) -> None:
        parts(data, name)[0][name] = value

    return change


def of_class(cls: str, name: str, value: Any) -> Callable[[Data], None]:
    def change(data: Data) -> None:
        found = next(part for part in parts(data, "$value") if part["$value"] == cls)
        found["fields"][name] = value

    return change


NUMBERS = {"$numbers": [1.0, 2.0], "dtype": "<f8", "shape": [2]}
DAMAGES = {
    "a status that is a text": ("a", of_class("Answers", "status", {"$objects": ["finite"] * 2, "shape": [2]})),
    "a column that is too long": ("a", of_class("Answers", "upper", NUMBERS | {"$numbers": [99.0] * 3, "shape": [3]})),
    "a column without rows": ("a", of_class("Answers", "upper", NUMBERS | {"$numbers": [1.0], "shape": []})),
    "points of two coordinates": ("a", of_class("Robustness", "points", NUMBERS | {"shape": [1, 2]})),
    "a force above its bound": ("a", of_class("Answers", "force", NUMBERS | {"$numbers": [99.0, 99.0]})),
    "a number that is none": ("a", of_class("Answers", "lower", NUMBERS | {"$numbers": ["nan", 0.0]})),
    "a number beyond all": ("a", of_class("Answers", "lower", NUMBERS | {"$numbers": [1e300, 0.0]})),
    "an integer beyond floats": ("a", of_class("Answers", "lower", NUMBERS | {"$numbers": [10**400, 0]})),
    "a claim that is a text": ("a", of_class("Answers", "claim", "exists")),
    "a body that is a number": ("a", of_class("Robustness", "body", 7)),
    "an empty object": ("a", of_class("Robustness", "body", {})),
    "objects in an array of numbers": ("a", of_class("Answers", "lower", NUMBERS | {"dtype": "O"})),
    "a shape below nothing": ("a", of_class("Answers", "lower", NUMBERS | {"shape": [-1, -2]})),
    "a list of another length": ("a", put("shape", [10**9])),
    "a moving body that is not there": ("a", of_class("Mechanism", "moving", {"$tuple": ["x"]})),
    "twists of nobody": ("a", of_class("Mechanism", "own", NUMBERS | {"$numbers": [0.0] * 12, "shape": [2, 6]})),
    "a motion at rest": ("a", of_class("Mechanism", "own", NUMBERS | {"$numbers": [0.0] * 6, "shape": [1, 6]})),
    "a motion without end": ("a", of_class("Mechanism", "own", NUMBERS | {"$numbers": ["inf"] * 6, "shape": [1, 6]})),
    "a body nowhere": ("a", of_class("Kinematics", "com", NUMBERS | {"$numbers": ["inf"] * 3, "shape": [1, 3]})),
    "a crowd of bodies": ("a", of_class("Kinematics", "count", 10**12)),
    "a node on no body": ("a", of_class("ContactNodes", "b", {"$numbers": [9] * 4, "dtype": "<i8", "shape": [4]})),
    "a mechanism that is a number": ("s", of_class("Verdict", "mechanism", 1.5)),
    "units of fewer dimensions": ("c", of_class("ConvexSet", "units", {"$tuple": ["N"]})),
    "a point of another body": ("m", of_class("RobustnessMap", "cells", {"$table": []})),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_what_no_answer_holds_is_called_damaged(damage: str, saved: Path, tmp_path: Path) -> None:
    name, change = DAMAGES[damage]
    data = json.loads((saved / f"{name}.json").read_text())
    hf.load_answer(saved / f"{name}.json")
    change(data)
    (tmp_path / "x.json").write_text(json.dumps(data))
    with pytest.raises(hf.HoldfastError, match=r"x\.json: .*; needs "):
        hf.load_answer(tmp_path / "x.json")


def repacked(source: Path, change: Callable[[str, bytes], bytes]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            new.writestr(name, change(name, old.read(name)))
    return stream.getvalue()


def promising(name: str, content: bytes) -> bytes:
    """The same array with a header that promises four billion numbers, which would take 32 GB."""
    header = {"descr": "<f8", "fortran_order": False, "shape": (4_000_000_000,)}
    text = (repr(header).ljust(117) + "\n").encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text if name.startswith("points") else content


def torn(name: str, content: bytes) -> bytes:
    return content.replace(b"'shape'", b"'shape", 1)


def no_character(name: str, content: bytes) -> bytes:
    """A text with a number above that of the last character, in the middle of a word."""
    return content.replace(b"l\0\0\0i\0\0\0m", b"l\0\0\0i\0\0\1m", 1) if name == "value.npy" else content


@pytest.mark.parametrize(
    "change", [promising, torn, no_character, lambda name, content: content[:5], lambda name, content: b""]
)
def test_archives_of_arrays_are_not_believed(
    change: Callable[[str, bytes], bytes], saved: Path, tmp_path: Path
) -> None:
    (tmp_path / "x.npz").write_bytes(repacked(saved / "a.npz", change))
    tracemalloc.start()
    with pytest.raises(hf.HoldfastError, match="is damaged"):
        hf.load_answer(tmp_path / "x.npz")
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert taken < 20e6


@pytest.mark.parametrize("seed", range(30))
def test_flipped_bits_of_an_archive_are_an_error_or_the_same_answer(seed: int, saved: Path, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    content = bytearray((saved / "a.npz").read_bytes())
    content[int(rng.integers(len(content)))] ^= 1 << int(rng.integers(8))
    (tmp_path / "x.npz").write_bytes(content)
    with contextlib.suppress(hf.HoldfastError):
        assert hf.load_answer(tmp_path / "x.npz") == hf.load_answer(saved / "a.npz")


def test_columns_that_never_were_are_not_read(saved: Path, tmp_path: Path) -> None:
    data = json.loads((saved / "a.json").read_text())
    of_class("Answers", "guessed", NUMBERS)(data)
    (tmp_path / "a.json").write_text(json.dumps(data))
    with pytest.raises(hf.HoldfastError, match="other fields"):
        hf.load_answer(tmp_path / "a.json")
