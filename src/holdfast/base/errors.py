"""The errors that holdfast raises. Every message says what is wrong, where, with which value, and what to do."""

from __future__ import annotations

import difflib
import os
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from holdfast.base.text import listed, one_line, quoted

P = ParamSpec("P")
R = TypeVar("R")

MOST_NAMES = 20  # largest number of known names that a remedy lists
PACKAGE = f"{Path(__file__).parents[1]}{os.sep}"  # where all of holdfast's modules lie
LONGEST_PLACE = 200  # largest number of characters of the place in a message: the path of a file, the name of a body
DISTRIBUTION = "holdfast-robotics"  # the name on package indexes; the module and the command are called holdfast


class HoldfastError(Exception):
    """Base class of every error that holdfast raises on purpose.

    For example:

    >>> try:
    ...     hf.shipped_scene("cube").body("cup")
    ... except hf.HoldfastError as error:
    ...     print(error)
    scene: has no body named 'cup'; known: floor, cube
    """


class SceneError(HoldfastError):
    """A scene, a scene file or the arguments of a query are invalid."""


class UnstableError(SceneError):
    """The assembly does not stand, but the query is defined only for an assembly that stands."""


class GeometryError(HoldfastError):
    """A mesh, a pose or a contact polygon is not usable as a solid, a rigid transform or a surface."""


class SolverError(HoldfastError):
    """A numerical method stopped without an answer, or the problem is too large for it."""


class HoldfastWarning(UserWarning):
    """An answer is given in spite of a problem, such as bodies that overlap."""


@contextmanager
def located(where: str) -> Iterator[None]:
    """Put ``where`` in front of the message of every HoldfastError raised in this block, unless it is already there."""
    place = one_line(where, LONGEST_PLACE)
    try:
        yield
    except HoldfastError as cause:
        if place in str(cause):
            raise
        raise type(cause)(f"{place}: {cause}") from cause


def message(where: str, problem: str, remedy: str) -> str:
    """Join the place, the problem (with its value) and the remedy into an error message of one line.

    Line breaks in them are escaped, and each is shortened to a readable length.
    """
    return f"{one_line(where, LONGEST_PLACE)}: {one_line(problem)}; {one_line(remedy)}"


def warn(text: str) -> None:
    """Issue a HoldfastWarning that points at the line outside of holdfast from which all this was called."""
    import inspect  # `import holdfast` costs next to nothing without it

    frame = inspect.currentframe()
    level = outside = 1
    while frame is not None:  # to the end: cached properties and thread pools come between functions of holdfast
        level += 1
        if frame.f_code.co_filename.startswith(PACKAGE):
            outside = level
        frame = frame.f_back
    warnings.warn(text, HoldfastWarning, stacklevel=outside)


def no_truth(value: object, remedy: str) -> HoldfastError:
    """Return the error for ``bool()`` of an answer that may also be undecided, so that no ``if`` misreads it."""
    problem = "it may also be undecided, so it is neither true nor false"
    return HoldfastError(message(f"bool() of {type(value).__name__}", problem, remedy))


def nearest_of(name: object, known: Iterable[str]) -> str:
    """Return the remedy for an unknown name: the most similar of the ``known`` ones or, if none is similar, a list."""
    names = list(known)
    near = difflib.get_close_matches(str(name), names, n=1)
    return f"did you mean {quoted(near[0])}?" if near else f"known: {listed(names, MOST_NAMES)}"


def hinting(**values: type[Any]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Let the TypeError for a keyword that is a field of a value say so (decorator): ``hinting(where=Where)``.

    ``values`` are the classes of the arguments with these names, dataclasses all.
    """
    from dataclasses import fields  # `import holdfast` costs next to nothing without it

    homes = {each.name: (argument, kind) for argument, kind in values.items() for each in fields(kind)}

    def decorated(function: Callable[P, R]) -> Callable[P, R]:
        known = function.__annotations__

        @wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> R:
            for name in kwargs:
                if name in homes and name not in known:
                    argument, kind = homes[name]
                    hint = f"it is a field of {kind.__name__}: {argument}={kind.__name__}({name}=...)"
                    raise TypeError(f"{function.__name__}() got an unexpected keyword argument {name!r}; {hint}")
            return function(*args, **kwargs)

        return called

    return decorated


def installing(extra: str) -> str:
    """Return the command that installs holdfast with an extra, for error messages."""
    return f"pip install '{DISTRIBUTION}[{extra}]'"


PNG_NEEDS = "writing a PNG needs matplotlib, which is not installed"
PNG_INSTALL = installing("viewer")
