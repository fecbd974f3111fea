"""A scene and the question about it, as they are sent to a worker, and its key: a hash of all the data in both."""

from __future__ import annotations

import hashlib
import json
import os
import stat
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from holdfast import __version__
from holdfast.base.archive import text_of
from holdfast.base.errors import HoldfastError, message
from holdfast.batches.tables import VERSION

if TYPE_CHECKING:
    from holdfast.scene.scene import Scene


MISSING = "missing"  # digest of a file that does not exist or cannot be read
BLOCK = 1 << 20  # number of bytes of a file that are hashed at a time

Signature = tuple[int, int, int, int] | None  # identifies the state of a file: device, inode, size, time of change


@dataclass(frozen=True)
class Push:
    """A push at ``point`` [m] of ``body`` along ``direction``, world frame; ``scene`` is "" if it is for all scenes."""

    scene: str
    body: str
    point: tuple[float, float, float]
    direction: tuple[float, float, float]


@dataclass(frozen=True)
class BatchQuestion:
    """The question of a batch.

    ``verbs`` are some of "stability", "map", "transport" and "push". ``options`` maps "load", "assemble" and verbs to
    keyword arguments of the functions that they call. ``pushes`` are the pushes for the verb "push". ``plugins`` are
    those that workers load: what ``load_plugin`` returns, by name.
    """

    verbs: tuple[str, ...]
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    pushes: tuple[Push, ...] = ()
    plugins: Mapping[str, str] = field(default_factory=dict)

    def of(self, verb: str) -> dict[str, Any]:
        """Return the keyword arguments of a verb, of "load" or of "assemble"."""
        return dict(self.options.get(verb, {}))

    @cached_property
    def text(self) -> str:
        """The question as text, without the pushes; it is the same for equal questions."""
        told = {"ask": self.verbs, "options": self.options} | ({"plugins": self.plugins} if self.plugins else {})
        return json.dumps(told, sort_keys=True, allow_nan=False)

    @property
    def bare(self) -> BatchQuestion:
        """The question without the pushes."""
        return replace(self, pushes=())

    @cached_property
    def _pushes_by_scene(self) -> dict[str, tuple[Push, ...]]:
        found: dict[str, list[Push]] = {}
        for push in self.pushes:
            found.setdefault(push.scene, []).append(push)
        return {name: tuple(pushes) for name, pushes in found.items()}

    def pushes_on(self, name: str) -> tuple[Push, ...]:
        """Return the pushes for the scene with this name: those for all scenes, and its own."""
        return tuple(push for key in dict.fromkeys(("", name)) for push in self._pushes_by_scene.get(key, ()))


@dataclass(frozen=True)
class Job:
    """One scene of a batch: its ``number`` and ``name``, the question, and the scene as a file or a value.

    ``path`` is the path as it was given, ``place`` the absolute path, ``state`` as in Input. ``key`` is a digest of all
    that decides the answer, by which an earlier one is found again. That of a value is known at once, that of a file
    once it was read.
    """

    number: int
    name: str
    question: BatchQuestion
    pushes: tuple[Push, ...] = ()
    path: str | None = None
    place: str = ""
    scene: Scene | None = None
    key: str = ""
    state: tuple[float, ...] | None = None


class Digests:
    """The SHA-256 digests of files, with a cache of files that have not changed."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[Signature, str]] = {}

    def of(self, path: Path) -> str:
        """Return the digest of a file, or MISSING."""
        place, now = os.path.abspath(path), signature(path)
        if now is None:
            return MISSING
        known = self._known.get(place)
        if known is None or known[0] != now:
            known = self._known[place] = (now, _digest(path))
        return known[1]


class Touched:
    """The files that were read for a scene, in order, with their signatures before they were read."""

    def __init__(self) -> None:
        self.before: dict[Path, Signature] = {}

    def note(self, path: Path) -> None:
        """Note a file that is about to be read; to be passed to ``noting_files``."""
        self.before.setdefault(Path(os.path.abspath(path)), signature(path))

    def check(self) -> None:
        """Raise HoldfastError if a file changed since it was noted: it may have been read half old, half new."""
        for path, before in self.before.items():
            if signature(path) != before:
                raise HoldfastError(message(str(path), "changed while it was read", "ask again"))

    def relative_to(self, place: str) -> tuple[str, ...]:
        """Return the paths relative to the folder of a scene file."""
        folder = os.path.dirname(place)
        return tuple(os.path.relpath(path, folder) for path in self.before)


def key_of_files(job: Job, files: Iterable[str], digests: Digests) -> str:
    """Return the key of a scene that consists of ``files``, given relative to its own folder."""
    folder = Path(job.place).parent
    return _key_of(job, [[name, digests.of(folder / name)] for name in files])


def key_of_value(job: Job) -> str:
    """Return the key of a scene that was given as a value."""
    assert job.scene is not None
    return _key_of(job, [["", hashlib.sha256(text_of(job.scene).encode()).hexdigest()]])


def signature(path: Path) -> Signature:
    """Return the signature of a file, None if it does not exist."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns


def _key_of(job: Job, parts: Sequence[Sequence[str]]) -> str:
    pushes = [[push.body, *push.point, *push.direction] for push in job.pushes]
    whole: list[Any] = [VERSION, __version__, job.question.text, pushes, parts]
    whole += [] if job.state is None else [job.state]
    return hashlib.sha256(json.dumps(whole).encode()).hexdigest()


def _digest(path: Path) -> str:
    found = hashlib.sha256()
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):  # a device or a pipe may never end
            return MISSING
        with open(path, "rb") as stream:
            while block := stream.read(BLOCK):
                found.update(block)
    except OSError:
        return MISSING
    return found.hexdigest()
