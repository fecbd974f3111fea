"""Compilation of hot loops with Numba: the one switch. Machine code is kept on disk (code_store.py)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

import numba

from holdfast.base.arrays import Float

P = ParamSpec("P")
R = TypeVar("R")

KNOWN = ("0.68.",)  # versions of Numba whose inner workings linking.py was written for and is tested with
_DISPATCHERS: dict[Callable[..., Any], Callable[..., Any]] = {}  # of ``compilable`` functions


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile ``function`` on its first call and keep the machine code on disk; calls release Python's global lock.

    With a version of Numba that is not KNOWN, Numba itself compiles it, anew in every process.
    """
    if numba.config.DISABLE_JIT:
        return function
    if not numba.__version__.startswith(KNOWN):
        return cast(Callable[P, R], numba.njit(nogil=True)(function))
    from holdfast.base.code_store import CodeStore
    from holdfast.base.linking import Kernel

    return cast(Callable[P, R], Kernel(function, CodeStore(function)))


def lean(function: Callable[P, R]) -> Callable[P, R]:
    """Mark a function, below ``compiled`` or ``compilable``, that neither makes nor returns arrays: it counts none.

    Numba counts in how many places an array is in use. Threads that work on the same arrays write to these counts all
    the time and wait for each other.
    """
    function.lean = True  # type: ignore[attr-defined]  # linking.py asks for it
    return function


def fused(function: Callable[P, R]) -> Callable[P, R]:
    """Mark a function, below ``compiled``, where a product and a sum may be rounded once instead of twice.

    Processors that can do that in one step take about four fifths of the time. The last digits differ on others.
    """
    function.fused = True  # type: ignore[attr-defined]  # linking.py asks for it
    return function


def compilable(function: Callable[P, R]) -> Callable[P, R]:
    """Run ``function`` in Python if Python code calls it, and compiled if a compiled function calls it.

    All compiled functions that call it share the same machine code; it is not compiled again within each of them.
    """
    dispatcher = compiled(function)
    if dispatcher is not function:
        function._numba_type_ = dispatcher._numba_type_  # type: ignore[attr-defined]  # what Numba takes it for
        _DISPATCHERS[function] = dispatcher  # Numba's type refers to it weakly
    return function


def machine_code(function: Callable[P, R]) -> Callable[P, R]:
    """Return the compiled version of a ``compilable`` function."""
    return cast(Callable[P, R], _DISPATCHERS.get(function, function))


@compiled
@lean
def dot3(a: Float, b: Float) -> float:
    """Return the scalar product a · b of two vectors (3,), without the overhead of a library call."""
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
