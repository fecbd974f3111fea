"""The one border to foreign parsers and libraries: what they raise becomes an error of holdfast, within limits.

A scene may consist of many files, so bytes and elements are counted over all that is read for it.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.progress import OutOfTimeError

CHECK = "check the file, or export it again"
SECONDS = 300.0  # [s] in which a scene must be read
MAX_DEPTH = 40  # the deepest nesting of data that is accepted
BYTES, JSON, YAML, ELEMENTS = "bytes of files", "bytes of JSON", "bytes of YAML", "elements of XML"
# of all files of a scene; 1 MB of YAML takes 3 s, and parsed JSON twenty times its memory
MOST = {BYTES: 2_000_000_000, JSON: 100_000_000, YAML: 4_000_000, ELEMENTS: 2_000_000}

_spent: ContextVar[dict[str, float] | None] = ContextVar("holdfast_spent", default=None)


@contextmanager
def foreign(
    where: str, problem: str = "cannot be read", remedy: str = CHECK, error: type[HoldfastError] = SceneError
) -> Iterator[None]:
    """Turn whatever a foreign parser or library raises in this block into ``error``, with the place and a remedy.

    Errors of holdfast pass as they are, and so does that of a package that is not installed.
    """
    try:
        yield
    except (HoldfastError, ModuleNotFoundError, OutOfTimeError):
        raise
    except RecursionError as cause:
        raise error(message(where, "is nested too deeply", f"the limit is {MAX_DEPTH} levels")) from cause
    except MemoryError as cause:
        raise error(message(where, f"{problem}: needs more memory than there is", remedy)) from cause
    except Exception as cause:
        mark = getattr(cause, "problem_mark", None)  # of YAML; JSON and XML have a number, all from 1
        line = getattr(cause, "lineno", None) if mark is None else mark.line + 1
        said = getattr(cause, "problem", None) or getattr(cause, "msg", None) or " ".join(str(cause).split())
        if type(cause).__module__.startswith("pxr"):  # USD names its own source files first
            said = said.rpartition(" : ")[2].strip(" '")
        said = said.partition(": line ")[0] if line is not None else said
        named = isinstance(cause, ValueError | SyntaxError) or line is not None
        said = said if named and said else f"{type(cause).__name__}: {said}"
        raise error(message(where if line is None else f"{where}:{line}", f"{problem}: {said}", remedy)) from cause


@contextmanager
def counted() -> Iterator[None]:
    """Count what is read in this block by ``spend``, unless it is within another such block."""
    token = None if _spent.get() is not None else _spent.set({"until": time.monotonic() + SECONDS})
    try:
        yield
    finally:
        if token is not None:
            _spent.reset(token)


def spend(what: str, amount: int, where: str) -> None:
    """Count an ``amount`` that is about to be read for a scene; raise SceneError beyond MOST or after SECONDS."""
    spent = _spent.get()
    if spent is None:
        return
    spent[what] = spent.get(what, 0) + amount
    if spent[what] > MOST[what]:
        raise SceneError(message(where, "is too much for one scene", f"the limit is {MOST[what]:,} {what} in all"))
    if time.monotonic() > spent["until"]:
        raise SceneError(message(where, f"is not read after {SECONDS:g} s", "divide the scene"))
