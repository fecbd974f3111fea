"""The errors holdfast raises: every message says what is wrong, where, with which value, and what to do."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


class HoldfastError(Exception):
    """Base of every error that holdfast raises on purpose."""


class SceneError(HoldfastError):
    """A scene, a scene file or a query that cannot be taken as given."""


class UnstableError(SceneError):
    """An assembly that does not stand, where only one that stands can be asked about."""


class GeometryError(HoldfastError):
    """A mesh, a pose or a contact polygon that is not a usable solid or surface."""


class SolverError(HoldfastError):
    """A numerical method stopped without an answer, or the question is too large for it."""


class HoldfastWarning(UserWarning):
    """Something an answer was given in spite of, such as bodies that overlap."""


@contextmanager
def located(where: str) -> Iterator[None]:
    """Within this block errors say ``where`` first, unless they do already."""
    try:
        yield
    except HoldfastError as cause:
        if where in str(cause):
            raise
        raise type(cause)(f"{where}: {cause}") from cause


def message(where: str, problem: str, remedy: str) -> str:
    """One line: where, what with its value, remedy."""
    return f"{where}: {problem}; {remedy}"
