"""Errors that tell where an option is: in one of the values that a function takes, such as ``Where`` or ``Search``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from functools import wraps
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def hinting(**values: type[Any]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Let the TypeError for a keyword that is a field of a value say so (decorator): ``hinting(where=Where)``.

    ``values`` are the classes of the arguments with these names, dataclasses all.
    """
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
