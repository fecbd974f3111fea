"""No test works out what it expects with a number of the code that it checks.

A constant that a test imports moves together with the code: halve a margin, and such a test still passes. So no module
of tests imports a number in capitals from a module of holdfast; it says the number, or follows from what it means.
Tables, names and arrays (COMMANDS, FORMATS, colours, the axes of the world) tell things apart, and may be imported.
"""

from __future__ import annotations

import ast
import importlib
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from numbers import Number
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
CAPITALS = re.compile(r"[A-Z][A-Z0-9_]*")
# Numbers that are names: codes of colours, of kinds of lines, of chunks of a file and of an exit; a unit; and settings
# that are handed over
NAMES = re.compile(
    r"holdfast\.(drawing\.(colours|render)\.[A-Z]+|geometry\.gltf\.[A-Z]+_CHUNK|cli\.stopping\.STOPPED"
    r"|base\.borders\.worker\.MEGABYTE|elastic\.system\.(QUICK|BRIEF|CLOSE))"
)


def is_numeric(value: object) -> bool:
    """A number, or a row of them."""
    if isinstance(value, tuple | list | frozenset | set):
        return bool(value) and all(is_numeric(part) for part in value)
    return isinstance(value, Number) and not isinstance(value, bool)


@cache
def value_of(module: str, name: str) -> object:
    """What a name in a module is; None for one that a missing extra hides."""
    try:
        return getattr(importlib.import_module(module), name, None)
    except ImportError:
        return None


def numbers_imported(source: str) -> Iterator[str]:
    """The numbers of holdfast that a module takes, as ``module.NAME``: imported, or reached through the module."""
    tree = ast.parse(source)
    modules: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            modules |= {a.asname or a.name: a.name for a in node.names if a.name.split(".")[0] == "holdfast"}
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "holdfast" and not node.level:
            for alias in node.names:
                modules[alias.asname or alias.name] = f"{node.module}.{alias.name}"
                if CAPITALS.fullmatch(alias.name) and is_numeric(value_of(str(node.module), alias.name)):
                    yield f"{node.module}.{alias.name}"
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and CAPITALS.fullmatch(node.attr) and isinstance(node.ctx, ast.Load):
            module = modules.get(ast.unparse(node.value), "")
            if module and is_numeric(value_of(module, node.attr)):
                yield f"{module}.{node.attr}"


def offenders() -> dict[str, set[str]]:
    found = {
        path.relative_to(TESTS).as_posix(): set(numbers_imported(path.read_text(encoding="utf-8")))
        for path in sorted(TESTS.rglob("*.py"))
    }
    own = {module: {name for name in names if not NAMES.fullmatch(name)} for module, names in found.items()}
    return {module: names for module, names in own.items() if names}


def test_no_test_imports_a_number_of_what_it_checks() -> None:
    assert offenders() == {}


@pytest.mark.parametrize("source", [
    "from holdfast.base.archive import LARGEST as MOST",
    "def f():\n    from holdfast.base.archive import LARGEST",
    "from holdfast.base import archive\nx = archive.LARGEST",
    "import holdfast.base.archive as k\nx = 2 * k.LARGEST",
    "import holdfast.base.archive\nx = holdfast.base.archive.LARGEST",
])  # fmt: skip
def test_a_planted_import_is_found(source: str) -> None:
    assert len(list(numbers_imported(source))) == 1


@pytest.mark.parametrize("source", [
    "from holdfast.engines.verdict import Status\nx = Status.STABLE",
    "from holdfast.base.archive import fits",
    "from holdfast.base.text import listed, quoted",
    "import holdfast as hf\nx = hf.Status.STABLE",
    "import numpy as np\nx = np.NAN",
])  # fmt: skip
def test_what_is_no_number_may_be_imported(source: str) -> None:
    assert list(numbers_imported(source)) == []


def test_files_of_tests_have_names_of_their_own() -> None:
    """Without packages, pytest imports them by name: of two with one name, the second cannot be collected."""
    names = Counter(path.name for path in TESTS.rglob("test_*.py"))
    assert [name for name, count in names.items() if count > 1] == []
