"""The one way of compiling a hot loop, and what such loops share."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

import numba
from numba.extending import register_jitable

from holdfast.base.arrays import Float

P = ParamSpec("P")
R = TypeVar("R")


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile ``function`` on its first call and keep the machine code on disk beside it; no lock is held."""
    try:
        return cast(Callable[P, R], numba.njit(cache=True, nogil=True)(function))
    except RuntimeError:  # no writable folder for the machine code: compile in every process
        return cast(Callable[P, R], numba.njit(nogil=True)(function))


def compilable(function: Callable[P, R]) -> Callable[P, R]:
    """Leave ``function`` to Python, but let compiled functions that call it compile it as a part of themselves."""
    return cast(Callable[P, R], register_jitable(function))


@compiled
def dot3(a: Float, b: Float) -> float:
    """The product a · b of two vectors (3,), without the overhead of a library call."""
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
