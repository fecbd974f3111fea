"""The public names of modules, and things known by name, to which users can add: engines, formats of scene files.

The public names of a module are taken from its stub (``.pyi``), for type checkers and at run time alike. Each is
imported when it is first used, so that importing such a module costs next to nothing.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TypeVar

from holdfast.base.errors import HoldfastError, message, nearest_of
from holdfast.base.text import quoted

V = TypeVar("V")


@cache
def homes_in_stub(file: str) -> dict[str, str]:
    """Return the module from which the stub of ``file`` imports each public name, by name.

    The stub is in the same folder. A submodule that it imports from its own package has that package as its home.
    """
    tree = ast.parse(Path(file).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = [node for node in tree.body if isinstance(node, ast.ImportFrom)]
    return {alias.name: str(node.module) for node in imports for alias in node.names}


def names_of_stub(
    module: str, file: str, elsewhere: Callable[[str], str | None] = lambda _: None
) -> tuple[list[str], Callable[[str], object], Callable[[], list[str]]]:
    """Return ``__all__``, ``__getattr__`` and ``__dir__`` of a module whose names are those of its stub.

    Submodules that the stub imports are found as attributes, but are not in ``__all__``. For an unknown name,
    ``elsewhere(name)`` may say where it is, for the message of the AttributeError.
    """
    homes = homes_in_stub(file)
    public = sorted(name for name, home in homes.items() if home != module)

    def attribute(name: str) -> object:
        home = homes.get(name)
        if home is None:
            problem = f"module {module!r} has no attribute {name!r}"
            if not name.startswith("_"):
                place = elsewhere(name)
                problem += f"; {nearest_of(name, sorted(homes)) if place is None else f'it is {place}'}"
            raise AttributeError(problem, name=name, obj=sys.modules[module])
        value = import_module(f"{home}.{name}") if home == module else getattr(import_module(home), name)
        setattr(sys.modules[module], name, value)
        return value

    return public, attribute, lambda: sorted({*vars(sys.modules[module]), *homes})


class Registry(dict[str, V]):
    """A mapping from names to registered values; ``kind`` says in error messages what the values are."""

    def __init__(self, kind: str, known: Mapping[str, V] | None = None) -> None:
        super().__init__(known or {})
        self._kind = kind

    def add(self, name: str, value: V) -> Callable[[], None]:
        """Register ``value`` after all others and return a function that removes it again.

        Raises HoldfastError if the name is taken or is not a text.
        """
        if not isinstance(name, str) or name in self:
            problem = f"there is one named {quoted(name)}" if isinstance(name, str) else f"the name is {quoted(name)}"
            raise HoldfastError(message(self._kind, problem, "give it another name"))
        self[name] = value

        def take_back() -> None:
            if self.get(name) is value:
                del self[name]

        return take_back
