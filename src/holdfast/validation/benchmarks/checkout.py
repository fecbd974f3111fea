"""Where saved results lie: in the checkout that the package runs from, whatever the current folder is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from holdfast.base.errors import HoldfastError, message

PACKAGE = Path(__file__).resolve().parents[2]  # the folder src/holdfast of a checkout, or of the installed package


def checkout(package: Path = PACKAGE) -> Path | None:
    """The root of the checkout whose ``src/`` holds the package; None where the package is installed without one."""
    root = package.parents[1]
    found = package.parent.name == "src" and (root / "pyproject.toml").is_file()
    return root if found and (root / "benchmarks" / "results").is_dir() else None


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


def results_folder(given: Path | None, package: Path = PACKAGE) -> Path:
    """The folder of saved results: the one ``given``, otherwise ``benchmarks/results`` of the checkout."""
    if given is not None:
        return given
    root = checkout(package)
    if root is None:
        problem = f"{package} is not part of a checkout of holdfast, which would hold them"
        raise HoldfastError(message("saved benchmark results", problem, "name their folder with --results DIR"))
    return root / "benchmarks" / "results"
