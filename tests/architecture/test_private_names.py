"""A name with a leading underscore belongs to its module: no other module imports it or reaches for it.

The rule, by syntax alone, over every module of holdfast and bench:

- nothing is imported whose name, or whose module's name, begins with one underscore;
- ``x._name`` is allowed where x is ``self`` or ``cls``, or where this module itself defines ``_name``: a function, a
  class, a method, a field, or an attribute of ``self`` or ``cls``;
- ``getattr`` and its kin with a private name in quotes count as the access that they are;
- the methods that every NamedTuple has begin with an underscore only so that fields cannot clash with them.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

import holdfast

ROOTS = (Path(holdfast.__file__).parent, Path(__file__).parents[2] / "bench")
NAMED_TUPLE = {"_replace", "_asdict", "_fields", "_make", "_field_defaults"}
ALLOWED = {
    # viser has no public way to tell which control a message is about: its values are checked before viser takes them
    ("holdfast.live.window", "_gui_input_handle_from_uuid"),
    ("holdfast.__main__", "_exit"),  # likewise, before any thread was begun
    ("holdfast.cli.stopping", "_exit"),  # public in spite of its name: the end of a process that waits for no thread
}
OWN = {"self", "cls"}
BY_NAME = {"getattr", "setattr", "hasattr", "delattr", "attrgetter", "methodcaller"}


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__") and name != "_"


def is_own(node: ast.expr) -> bool:
    return isinstance(node, ast.Name) and node.id in OWN


def defined(tree: ast.AST) -> set[str]:
    """Private names that a module defines: at its top, in its classes, or on its own objects."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and is_own(node.value):
            found.add(node.attr)
        body = node.body if isinstance(node, ast.ClassDef | ast.Module) else []
        for statement in body:
            if isinstance(statement, ast.Assign | ast.AnnAssign):
                targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
                found |= {n.id for target in targets for n in ast.walk(target) if isinstance(n, ast.Name)}
    return {name for name in found if is_private(name)}


def imported(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """Private names that are imported, each with how."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield from ((part, f"import {alias.name}") for part in alias.name.split(".") if is_private(part))
        elif isinstance(node, ast.ImportFrom):
            names = [*(node.module or "").split("."), *(alias.name for alias in node.names)]
            yield from ((name, f"import of {name}") for name in names if is_private(name))


def reached(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """Private attributes of other objects than a module's own ``self`` and ``cls``, each with how."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and is_private(node.attr) and not is_own(node.value):
            yield node.attr, ast.unparse(node)
        elif isinstance(node, ast.Call):
            called = node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
            if called in BY_NAME and not (node.args and is_own(node.args[0])):
                quoted = [a.value for a in node.args if isinstance(a, ast.Constant) and isinstance(a.value, str)]
                yield from ((part, ast.unparse(node)) for q in quoted for part in q.split(".") if is_private(part))


def violations(module: str, source: str) -> list[str]:
    tree = ast.parse(source)
    own = defined(tree) | NAMED_TUPLE | {name for place, name in ALLOWED if place == module}
    found = [how for _, how in imported(tree)]
    return found + [how for name, how in reached(tree) if name not in own]


def modules() -> Mapping[str, str]:
    paths = {path: path.relative_to(root.parent).with_suffix("") for root in ROOTS for path in root.rglob("*.py")}
    names = {path: ".".join(relative.parts) for path, relative in paths.items()}
    return {name: path.read_text(encoding="utf-8") for path, name in names.items()}


def test_no_module_uses_a_private_name_of_another() -> None:
    found = {module: told for module, source in modules().items() if (told := violations(module, source))}
    assert found == {}


def test_every_exception_is_needed() -> None:
    sources = modules()
    for module, name in ALLOWED:
        assert name in {used for used, _ in reached(ast.parse(sources[module]))}, (module, name)


@pytest.mark.parametrize(
    "source",
    [
        "from holdfast.base.arrays import _checked",
        "from holdfast.base._arrays import checked",
        "import holdfast.base._arrays",
        "import scipy._lib as d",
        "from . import _hidden",
        "def f():\n    from holdfast.base.arrays import _checked as checked",
        "def f(state):\n    return state._prepared",
        "def f(state):\n    state._prepared = 1",
        "def f(state):\n    state.rest._nodes.append(1)",
        "def f(state):\n    return getattr(state, '_prepared')",
        "from operator import attrgetter\nkey = attrgetter('rest._nodes')",
        "import numpy as np\nx = np._core",
        "class A:\n    def f(self):\n        return self.other._x",
        "class A:\n    def f(self):\n        return super().f()._x",
        "class A:\n    def f(self):\n        return self._mine._theirs",
        "def f(states):\n    return [state._x for state in states]",
        "def f(a):\n    _local = a\n    return a._local",
    ],
)
def test_a_planted_violation_is_found(source: str) -> None:
    assert len(violations("holdfast.queries.push", source)) == 1


@pytest.mark.parametrize(
    "source",
    [
        "from __future__ import annotations",
        "import numpy as np\nx = np.__version__",
        "class A:\n    def f(self):\n        return self._x + self._g()",
        "class A:\n    _x = 1\n    def f(self, other):\n        return other._x",
        "class A:\n    _x: int\ndef f(a):\n    return a._x",
        "class A:\n    def __init__(self):\n        self._x = 1\ndef f(a):\n    return a._x",
        "class A:\n    def _g(self): ...\ndef f(a):\n    return a._g()",
        "class A:\n    def f(self):\n        return getattr(self, '_x')",
        "def f(point):\n    return point._replace(x=1)",
        "for _ in range(3):\n    pass",
        "def _help(): ...\nx = _help()",
    ],
)
def test_what_belongs_to_a_module_is_its_own(source: str) -> None:
    assert violations("holdfast.queries.push", source) == []


def test_an_exception_holds_for_its_module_alone() -> None:
    source = "import os\ndef f():\n    os._exit(1)"
    assert violations("holdfast.cli.stopping", source) == []
    assert len(violations("holdfast.queries.push", source)) == 1
