"""Reading regular files up to a size limit, and atomic writing: a file appears complete or not at all."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from holdfast.base.borders.foreign import BYTES, spend
from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.text import quoted

_unfinished: set[Path] = set()  # temporary files that are being written
_note: ContextVar[Callable[[Path], None] | None] = ContextVar("holdfast_reading", default=None)

_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a named pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def checked_path(value: object, what: str) -> Path:
    """Return ``value`` as a Path; raise HoldfastError if it is not a path. ``what`` says what the path is for."""
    try:
        return Path(value)  # type: ignore[arg-type]
    except TypeError:
        raise HoldfastError(message(what, f"got {quoted(value)}", "needs a path: a text or a pathlib.Path")) from None


@contextmanager
def noting_files(note: Callable[[Path], None]) -> Iterator[None]:
    """Call ``note(path)`` for every file that is read in this block, before it is opened, and for every missing one."""
    token = _note.set(note)
    try:
        yield
    finally:
        _note.reset(token)


def check_ordinary(
    path: Path, what: str, *, error: type[HoldfastError] = SceneError, remedy: str = "check the path"
) -> int:
    """Return the size of a file in bytes; raise ``error`` unless it is an ordinary file.

    A pipe or a device is refused without opening it, because reading it might block for ever or never end. ``what``
    says what the file should be. Every file of a scene is checked here before it is read.
    """
    note = _note.get()
    if note is not None:
        note(path)
    try:
        found = os.stat(path)
    except (FileNotFoundError, NotADirectoryError, ValueError) as cause:
        raise error(message(str(path), f"no such {what}", remedy)) from cause
    except OSError as cause:
        raise error(message(str(path), f"is no {what}: {cause.strerror or cause}", remedy)) from cause
    if not stat.S_ISREG(found.st_mode):
        kind = _KINDS.get(stat.S_IFMT(found.st_mode), "no ordinary file")
        raise error(message(str(path), f"is {kind}, not a {what}", remedy))
    return found.st_size


def read_ordinary(
    path: Path,
    what: str,
    *,
    most: int,
    error: type[HoldfastError] = SceneError,
    remedy: str = "check the path",
    too_large: str = "keep meshes in files of their own",
) -> bytes:
    """Return the content of an ordinary file of at most ``most`` bytes; raise ``error`` for any other."""
    size = check_ordinary(path, what, error=error, remedy=remedy)
    spend(BYTES, size, str(path))
    if size <= most:
        try:
            with open(path, "rb") as stream:
                content = stream.read(size + 1)  # ``read`` allocates as many bytes as it is asked for
        except OSError as cause:
            problem = f"cannot be read: {cause.strerror or cause}"
            raise error(message(str(path), problem, "needs a file that may be read")) from cause
        if len(content) > size:
            raise error(message(str(path), "grew while it was read", "read it when it is complete"))
        size = len(content)
    if size > most:
        raise error(message(str(path), f"is {size:,} bytes", f"the limit is {most:,}: {too_large}"))
    return content


def write_atomically(path: str | os.PathLike[str], content: bytes) -> None:
    """Replace the file at ``path`` by ``content`` in one step.

    If ``path`` is a symbolic link, the link stays, and the file to which it leads is replaced. The mode of the file
    stays. A failure leaves the old file as it was, and raises HoldfastError. Whatever is not a file, such as a pipe or
    a device, is not replaced.
    """
    try:
        target = _target(Path(path))
        temporary = target.with_name(f".{os.urandom(8).hex()}.tmp")
        _unfinished.add(temporary)
        try:
            with temporary.open("xb") as stream:
                stream.write(content)
                stream.flush()
                with suppress(FileNotFoundError):
                    os.fchmod(stream.fileno(), stat.S_IMODE(os.stat(target).st_mode))
                os.fsync(stream.fileno())
            os.replace(temporary, target)
        finally:
            temporary.unlink(missing_ok=True)
            _unfinished.discard(temporary)
    except (OSError, ValueError) as cause:
        reason = getattr(cause, "strerror", None) or str(cause)
        raise HoldfastError(
            message(str(path), f"cannot be written: {reason}", "name a file in a writable folder")
        ) from cause


def remove_unfinished() -> None:
    """Remove the temporary files of unfinished writes; for a process that is about to be ended."""
    for path in list(_unfinished):
        with suppress(OSError):
            path.unlink(missing_ok=True)


def _target(path: Path) -> Path:
    """Return the path of the file to replace, behind all symbolic links; raise OSError if that is not a file."""
    target = Path(os.path.realpath(path))
    try:
        mode = os.stat(path).st_mode
    except FileNotFoundError:
        return target
    if not stat.S_ISREG(mode):
        kind = _KINDS.get(stat.S_IFMT(mode), "no ordinary file")
        raise OSError(errno.EINVAL, f"it is {kind}, not a file")
    return target
