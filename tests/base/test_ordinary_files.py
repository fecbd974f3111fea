"""Files as they come: pipes, devices and folders are refused at once, links are kept (findings D4, D14, D20)."""

from __future__ import annotations

import os
import socket
import stat
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

import holdfast as hf
from holdfast.base import archive
from holdfast.base.errors import HoldfastError, SceneError
from holdfast.base.files import read_ordinary, write_atomically


@pytest.fixture
def odd(tmp_path: Path, request: pytest.FixtureRequest) -> tuple[Path, str]:
    """A path that is no ordinary file, and what it is."""
    path = tmp_path / "odd"
    match request.param:
        case "pipe":
            os.mkfifo(path)
            return path, "is a named pipe"
        case "folder":
            path.mkdir()
            return path, "is a folder"
        case "device":
            return Path("/dev/zero"), "is a device"
        case "socket":
            server = socket.socket(socket.AF_UNIX)
            server.bind(os.path.relpath(path))  # paths of sockets are short
            server.close()
            return path, "is a socket"
        case "loop":
            path.symlink_to(path)
            return path, "Too many levels of symbolic links"
        case "long":
            return tmp_path / ("x" * 5000), "File name too long"
        case "long path":
            return tmp_path.joinpath(*["x" * 200] * 40), "File name too long"
        case "zero byte":
            return tmp_path / "a\0b", "no such"
        case "surrogate":
            return tmp_path / "a\ud800b", "no such"
    raise AssertionError


ODD = pytest.mark.parametrize(
    "odd",
    ["pipe", "folder", "device", "socket", "loop", "long", "long path", "zero byte", "surrogate"],
    indirect=True,
)


@ODD
def test_d4_d14_what_is_no_ordinary_file_is_refused_at_once(odd: tuple[Path, str]) -> None:
    path, problem = odd
    for call in (hf.load_scene, lambda p: read_ordinary(p, "test file", most=10)):
        with pytest.raises(SceneError, match=problem) as caught:
            call(path)
        assert str(caught.value).isprintable()
        assert len(str(caught.value)) < 700


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply", ".glb", ".off"])
def test_d4_a_pipe_for_a_mesh_is_refused_at_once(suffix: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / f"m{suffix}")
    with pytest.raises(hf.errors.GeometryError, match="is a named pipe, not a mesh file"):
        hf.Mesh.from_file(tmp_path / f"m{suffix}")


@pytest.mark.parametrize("suffix", [".json", ".npz"])
def test_a_pipe_for_an_answer_is_refused_at_once(suffix: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / f"a{suffix}")
    with pytest.raises(HoldfastError, match="is a named pipe, not a answer file"):
        hf.load_answer(tmp_path / f"a{suffix}")


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "f").write_bytes(b"x" * 11)
    with pytest.raises(SceneError, match="is 11 bytes; the limit is 10"):
        read_ordinary(tmp_path / "f", "test file", most=10)
    assert read_ordinary(tmp_path / "f", "test file", most=11) == b"x" * 11


def test_d20_a_link_is_written_through(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    target, link = tmp_path / "real" / "scene.yaml", tmp_path / "scene.yaml"
    target.write_text("old")
    link.symlink_to("real/scene.yaml")
    before = target.stat().st_ino
    write_atomically(link, b"new")
    assert link.is_symlink()
    assert os.readlink(link) == "real/scene.yaml"
    assert target.read_bytes() == b"new"
    assert target.stat().st_ino != before  # replaced in one step, not overwritten
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["real", "scene.yaml", "scene.yaml"]


def test_d20_a_link_to_nothing_yet_makes_its_target(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("later")
    write_atomically(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "later").read_bytes() == b"new"


@pytest.mark.parametrize("odd", ["pipe", "folder", "loop"], indirect=True)
def test_what_is_no_file_is_not_replaced(odd: tuple[Path, str]) -> None:
    path, _ = odd
    kind = stat.S_IFMT(path.lstat().st_mode)
    with pytest.raises(HoldfastError, match=r"cannot be written: .*; name a file"):
        write_atomically(path, b"new")
    assert stat.S_IFMT(path.lstat().st_mode) == kind
    assert [p.name for p in path.parent.iterdir()] == ["odd"]


def test_d14_the_longest_name_that_a_file_may_have_can_be_written(tmp_path: Path) -> None:
    name = "x" * 250 + ".json"
    write_atomically(tmp_path / name, b"new")
    assert (tmp_path / name).read_bytes() == b"new"
    with pytest.raises(HoldfastError, match="cannot be written: File name too long"):
        write_atomically(tmp_path / ("x" * 5000), b"new")


def test_d23_a_saved_answer_may_begin_with_a_byte_order_mark(tmp_path: Path) -> None:
    box = hf.Body("b", hf.Box((1, 1, 1)), fixed=True)
    cube = hf.Body("c", hf.Box((1, 1, 1)), mass=1, pose=[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1], [0, 0, 0, 1]])
    answer = hf.stability(hf.Scene([box, cube], 0.5), engine="limit")
    answer.save(tmp_path / "a.json")
    (tmp_path / "b.json").write_bytes(b"\xef\xbb\xbf" + (tmp_path / "a.json").read_bytes())
    assert hf.load_answer(tmp_path / "b.json") == answer


def test_an_answer_that_unpacks_to_more_than_the_memory_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    np.savez_compressed(tmp_path / "a.npz", value=np.array("{}"), zeros=np.zeros(10))
    monkeypatch.setattr(archive, "MAX_BYTES", 100)
    with pytest.raises(HoldfastError, match=r"unpacks to .* bytes; the limit"):
        hf.load_answer(tmp_path / "a.npz")


def test_reading_takes_the_memory_of_the_file_and_not_of_the_limit(tmp_path: Path) -> None:
    """Python takes the memory for as many bytes as are asked for: 4 GB for an answer of a kilobyte."""
    path = tmp_path / "small"
    path.write_bytes(b"x" * 1000)
    tracemalloc.start()
    assert read_ordinary(path, "file", most=4_000_000_000) == b"x" * 1000
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert taken < 1e6
