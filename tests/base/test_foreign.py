"""The border to foreign parsers: whatever they raise is one clear error, and what a scene reads is counted in all."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

import holdfast as hf
from holdfast.base.borders import foreign
from holdfast.base.files import read_ordinary, write_atomically


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (KeyError("visual"), "a.bin: cannot be read: KeyError: 'visual'; check the file"),
        (RecursionError("maximum recursion depth"), "a.bin: is nested too deeply; the limit is 40 levels"),
        (MemoryError(), "a.bin: cannot be read: needs more memory than there is; check"),
        (struct.error("needs 2 bytes"), "a.bin: cannot be read: error: needs 2 bytes; check"),
        (ValueError("no number"), "a.bin: cannot be read: no number; check"),
        (
            RuntimeError("Caught an\nunknown exception!"),
            "a.bin: cannot be read: RuntimeError: Caught an unknown exception",
        ),
        (AssertionError(), "a.bin: cannot be read: AssertionError"),
    ],
)
def test_whatever_is_raised_is_one_error_with_the_name_of_the_file(error: Exception, said: str) -> None:
    with pytest.raises(hf.errors.SceneError) as caught, foreign.foreign("a.bin"):
        raise error
    assert str(caught.value).startswith(said)
    assert "\n" not in str(caught.value)
    assert caught.value.__cause__ is error


@pytest.mark.parametrize("error", [hf.errors.GeometryError("its own"), ModuleNotFoundError("no such package")])
def test_errors_of_holdfast_and_missing_packages_pass(error: Exception) -> None:
    with pytest.raises(type(error)) as caught, foreign.foreign("a.bin"):
        raise error
    assert caught.value is error


def test_parsers_of_text_say_the_line() -> None:
    for parse, text in ((json.loads, "[1,\n2,,"), (yaml.safe_load, "a: 1\nb: [1, }")):
        with (
            pytest.raises(hf.errors.SceneError, match=r"^a\.txt:2: is no data: \w"),
            foreign.foreign("a.txt", "is no data"),
        ):
            parse(text)
    with pytest.raises(hf.errors.SceneError, match="line 2"), foreign.foreign("a.txt", "is no data"):
        ElementTree.fromstring("<a>\n<b></a>")


def test_bytes_of_all_files_of_a_scene_are_counted_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(foreign.MOST, foreign.BYTES, 2500)
    path = tmp_path / "m.bin"
    path.write_bytes(bytes(1000))
    with foreign.counted():
        for _ in range(2):
            read_ordinary(path, "mesh file", most=10_000)
        with (
            foreign.counted(),
            pytest.raises(hf.errors.SceneError, match=r"m\.bin: is too much for one scene; .* 2,500"),
        ):
            read_ordinary(path, "mesh file", most=10_000)
    for _ in range(4):  # each of them is a file of its own now
        with foreign.counted():
            read_ordinary(path, "mesh file", most=10_000)


def test_seconds_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(foreign, "SECONDS", -1.0)
    with foreign.counted(), pytest.raises(hf.errors.SceneError, match="is not read after"):
        foreign.spend(foreign.BYTES, 1, "a.bin")


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o755])
def test_a_file_that_is_replaced_keeps_its_mode(mode: int, tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text("before")
    path.chmod(mode)
    write_atomically(path, b"after")
    assert path.read_bytes() == b"after"
    assert path.stat().st_mode & 0o777 == mode


def test_texts_of_numpy_are_names_as_any_other(tmp_path: Path) -> None:
    a, b, oak = np.array(["a", "b", "oak"])
    floor = hf.Body("f", hf.HalfSpace(), fixed=True)
    box = hf.Box((1, 1, 1))
    bodies = [
        floor,
        hf.Body(a, box, mass=1, position=(0, 0, 0.5), material=oak),
        hf.Body(b, box, mass=1, position=(0, 0, 1.5)),
    ]
    grip = hf.Grip(b, [(0.5, 0, 1.5)], [(-1, 0, 0)], 0.5)
    scene = hf.Scene(bodies, hf.Friction(0.5, {(a, b): 0.3}), name=a, excluded=[(a, b)], holds=[grip])
    for suffix in (".yaml", ".json"):
        hf.save_scene(scene, tmp_path / f"s{suffix}")
        assert hf.load_scene(tmp_path / f"s{suffix}") == scene
