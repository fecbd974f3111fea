"""Where things lie in the checkout, and which older checkout is measured beside it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

import holdfast
from holdfast.base.errors import HoldfastError, message

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "bench" / "results"
CASES = ROOT.parent / "shared" / "cases"  # published scenes that are not part of the repository
SOURCE = Path(holdfast.__file__).resolve().parents[1]  # the source folder of the holdfast that is measured

older: ContextVar[Path | None] = ContextVar("holdfast_older_checkout", default=None)


@contextmanager
def beside(root: Path | None) -> Iterator[None]:
    """Let benchmarks that can measure an older checkout in the same run do so within this block.

    Raises HoldfastError if there is no package in it.
    """
    if root is not None and not (root / "src" / "holdfast").is_dir():
        raise HoldfastError(
            message(f"--beside {root}", "is no checkout of holdfast", "name the folder that holds src/")
        )
    token = older.set(root)
    try:
        yield
    finally:
        older.reset(token)
