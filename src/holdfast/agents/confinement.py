"""What an agent may read, write and ask: files of one folder, scenes of a size, names that are names.

Scenes come from an agent, or from files that anybody wrote, and name further files. Every file that a reader opens is
checked twice: by the note that all readers of holdfast give before they open one (``noting_files``), and by Python's
own audit, which also sees what a foreign library opens in Python. Names of bodies reach the agent as part of answers,
so sentences, which it might take for instructions, are no names.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.files import noting_files
from holdfast.base.text import many, quoted
from holdfast.scene.scene import Scene

MEGABYTE = 1_000_000  # bytes
LONGEST_NAME = 60  # characters of a name
LONGEST_PATH = 300  # characters of a path
MOST_WORDS = 4  # words of a name: a sentence has more
SHOWN = 24  # characters of a refused name that the error repeats
MOST_FILES = 1_000  # files of the folder among which the nearest name is looked for
PART = r"[\w.:/+#()\[\]@|=~*&,-]+"
NAME = re.compile(rf"{PART}(?: {PART}){{0,{MOST_WORDS - 1}}}")
NAME_HELP = (
    f"needs at most {LONGEST_NAME} characters and {MOST_WORDS} words of letters, digits and . : / _ - + # ( ) [ ] @"
)
PROGRAMS = ("subprocess.Popen", "os.exec", "os.posix_spawn", "os.spawn", "os.system", "socket.connect")  # audit events
HARMLESS = ("/dev/null", "/dev/urandom")


@dataclass(frozen=True)
class Confinement:
    """What an agent may do.

    ``folder`` is the only one whose files may be read, ``write`` the only one in which files may be written; without
    one, nothing is. A scene has at most ``bodies``, and with all its files ``megabytes``; an answer takes at most
    ``seconds``.
    """

    folder: Path | None = None
    write: Path | None = None
    bodies: int = 200
    megabytes: float = 20.0
    seconds: float = 60.0

    def readable(self, path: str) -> Path:
        """Return the path of a file in the folder, relative to it; raise SceneError for one outside, or none."""
        if self.folder is None:
            remedy = "give the scene itself as `scene`, or start the server with --folder"
            raise SceneError(message("path", f"is {quoted(path, SHOWN)}, and no folder may be read", remedy))
        found = _within(self.folder, path, "path")
        if not os.path.lexists(self.folder / found):
            raise SceneError(message("path", f"there is no file {quoted(path)}", nearest_of(path, self._files())))
        return found

    def writable(self, path: str) -> Path:
        """Return the absolute path of a new file in the folder for files that are written; raise SceneError."""
        if self.write is None:
            remedy = "leave `save` out, or start the server with --write FOLDER"
            raise SceneError(message("save", f"is {quoted(path, SHOWN)}, and nothing may be written", remedy))
        found = self.write / _within(self.write, path, "save")
        if os.path.lexists(found):
            raise SceneError(message("save", f"{quoted(path)} exists", "choose another name: no file is replaced"))
        if not found.parent.is_dir():
            raise SceneError(message("save", f"{quoted(path)} is in a folder that does not exist", "give a file name"))
        return found

    def check_count(self, bodies: int, where: str) -> None:
        """Raise SceneError if a scene has too many bodies."""
        if bodies > self.bodies:
            remedy = f"the limit is {self.bodies:,}: leave some out, or start the server with --bodies"
            raise SceneError(message(where, f"has {bodies:,} bodies", remedy))

    def check_size(self, size: int, where: str) -> None:
        """Raise SceneError if a scene has too many bytes."""
        if size > self.megabytes * MEGABYTE:
            remedy = f"the limit is {self.megabytes:g} MB: simplify it, or start the server with --megabytes"
            raise SceneError(message(where, f"has {size / MEGABYTE:,.1f} MB with its files", remedy))

    def check_scene(self, scene: Scene, where: str) -> None:
        """Raise SceneError for a scene with too many bodies, or with names that are none."""
        self.check_count(len(scene.bodies), where)
        for body in scene.bodies:
            check_names([body.name, *filter(None, [body.material, *body.materials])], f"{where}: name or material")
        table = scene.friction
        pairs = (name for pair in (*table.pairs, *table.tension, *table.cohesion) for name in pair)
        check_names([*filter(None, [scene.name]), *pairs, *table.values], f"{where}: name in it")

    def _files(self) -> Iterator[str]:
        """Yield the files in the folder whose names are fit to be shown."""
        assert self.folder is not None
        count = 0
        for home, folders, files in os.walk(self.folder):
            folders.sort()
            for file in sorted(files):
                name = Path(home, file).relative_to(self.folder).as_posix()
                count += 1
                if count > MOST_FILES:
                    return
                if NAME.fullmatch(name) and len(name) <= LONGEST_NAME:
                    yield name


def check_names(names: Iterable[Any], where: str) -> None:
    """Raise SceneError for a name that is too long, has characters that do not show, or is a sentence."""
    for name in names:
        if not isinstance(name, str) or not NAME.fullmatch(name) or len(name) > LONGEST_NAME:
            size = f" ({many(len(name), 'character')})" if isinstance(name, str) else ""
            raise SceneError(message(where, f"is no name: {quoted(name, SHOWN)}{size}", NAME_HELP))


def _within(folder: Path, path: str, where: str) -> Path:
    """Return a relative path that stays in the folder, also behind links; raise SceneError for any other."""
    if not path or len(path) > LONGEST_PATH or not path.isprintable():
        problem = f"is {quoted(path, SHOWN)} ({many(len(path), 'character')})"
        raise SceneError(message(where, problem, f"needs a path of 1 to {LONGEST_PATH} printable characters"))
    inside = not os.path.isabs(path) and ".." not in Path(path).parts and "://" not in path
    if not inside or not _is_in(folder / path, folder):
        remedy = "needs a path relative to the folder of the server, which leads to a file within it"
        raise SceneError(message(where, f"{quoted(path)} leads out of the folder", remedy))
    return Path(path)


def _is_in(path: str | Path, folder: str | Path) -> bool:
    """Tell whether a path leads into a folder, once all links are resolved."""
    try:
        return Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))
    except (OSError, ValueError):  # a circle of links, a zero byte
        return False


class ReadingGuard:
    """Guards the files of this process while it reads scenes, from its first ``reading`` to its end."""

    def __init__(self, limits: Confinement) -> None:
        self.limits = limits
        self._reading = False
        self._sizes: dict[str, int] = {}
        self._where = ""
        packages = {os.path.abspath(each) for each in (sys.prefix, sys.base_prefix, *filter(None, sys.path))}
        self._modules = tuple(os.path.realpath(each) for each in packages)  # which imports read
        sys.addaudithook(self._audit)

    @contextmanager
    def reading(self, where: str, size: int = 0) -> Iterator[None]:
        """Let the readers of this block open files of the folder alone, of the allowed size in all.

        ``size`` is that of what is given beside files, and ``where`` names the scene in errors.
        """
        self._where, self._sizes, self._reading = where, {"": size}, True
        try:
            self.limits.check_size(size, where)
            with noting_files(self._note):
                yield
        finally:
            self._reading = False

    def _note(self, path: Path) -> None:
        """Check a file that a reader is about to open, or to look for."""
        if self.limits.folder is None or not _is_in(path, self.limits.folder):
            remedy = "put it into the folder that the server may read (--folder), and name it relative to the scene"
            raise SceneError(message(self._where, f"the file {quoted(str(path))} is outside of the folder", remedy))
        real = os.path.realpath(path)
        if real not in self._sizes and os.path.isfile(real):
            self._sizes[real] = os.path.getsize(real)
            self.limits.check_size(sum(self._sizes.values()), self._where)

    def _audit(self, event: str, given: tuple[Any, ...]) -> None:
        """Refuse what Python itself is about to open or start while a scene is read."""
        if not self._reading:
            return
        if event in PROGRAMS:
            raise SceneError(message(self._where, f"its reader calls {event}", "give the scene in another format"))
        if event in ("open", "sqlite3.connect") and isinstance(given[0], str | bytes | os.PathLike):
            path = os.fsdecode(given[0])
            if event != "open" and path.startswith("file:"):  # an address, as recorded data are opened by
                path = unquote(path.removeprefix("file:").partition("?")[0])
            if path not in HARMLESS and not any(_is_in(path, each) for each in self._modules):
                self._note(Path(path))
