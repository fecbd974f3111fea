"""Keys of scenes: whatever changes an answer changes the key, and nothing else does."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from holdfast.batches.job import MISSING, BatchQuestion, Digests, Job, Push, key_of_files

PUSH = Push("", "cup", (0.1, 0, 0.2), (1, 0, 0))


@pytest.fixture
def job(tmp_path: Path) -> Job:
    """A scene of two files."""
    (tmp_path / "scene.yaml").write_text("bodies: []")
    (tmp_path / "mesh.obj").write_text("v 0 0 0")
    question = BatchQuestion(("map",), {"map": {"spacing": 0.02}})
    return Job(0, "scene", question, (PUSH,), "scene.yaml", str(tmp_path / "scene.yaml"))


def key(job: Job, files: tuple[str, ...] = ("scene.yaml", "mesh.obj")) -> str:
    return key_of_files(job, files, Digests())


def asked(verbs: tuple[str, ...] = ("map",), **options: object) -> Callable[[Job], Job]:
    return lambda job: replace(job, question=BatchQuestion(verbs, {"map": options}))


def pushed(**changes: object) -> Callable[[Job], Job]:
    return lambda job: replace(job, pushes=(replace(PUSH, **changes),))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("other", "same"),
    [
        (asked(spacing=0.02), True),
        (lambda job: replace(job, number=7, name="other", path="elsewhere/scene.yaml"), True),
        (pushed(scene="scene"), True),
        (asked(spacing=0.01), False),
        (asked(spacing=0.02, engine="limit"), False),
        (asked(("map", "stability"), spacing=0.02), False),
        (pushed(body="mug"), False),
        (pushed(point=(0.1, 0, 0.3)), False),
        (pushed(direction=(-1, 0, 0)), False),
        (lambda job: replace(job, pushes=(PUSH, PUSH)), False),
        (lambda job: replace(job, pushes=()), False),
    ],
)
def test_the_question_and_the_pushes_are_in_the_key(job: Job, other: Callable[[Job], Job], same: bool) -> None:
    assert (key(other(job)) == key(job)) is same


def test_a_digest_is_kept_until_the_file_changes(tmp_path: Path) -> None:
    path, digests = tmp_path / "a", Digests()
    assert digests.of(path) == MISSING
    path.write_bytes(b"abc")
    assert digests.of(path) == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad", "FIPS 180-2"
    path.write_bytes(b"abd")
    os.utime(path, ns=(1, 1))
    assert digests.of(path) != "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    os.mkfifo(tmp_path / "pipe")
    assert digests.of(tmp_path / "pipe") == MISSING, "it may never end"
