"""No circle of imports between modules, and every module can be imported first, by its own name."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import holdfast

ROOTS = (Path(holdfast.__file__).parent, Path(__file__).parents[2] / "bench")


def sources() -> dict[str, str]:
    """Text of every module by dotted name; a package goes by its own name."""
    found = {}
    for base, path in ((root.parent, path) for root in ROOTS for path in root.rglob("*.py")):
        parts = path.relative_to(base).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path.read_text()
    return found


def imported(module: str, source: str, known: set[str]) -> Iterator[str]:
    """Modules among ``known`` that a source imports, wherever it does: a late import hides a circle, no more."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = module.split(".")[: -node.level] if node.level else []
            stem = ".".join([*base, *(node.module or "").split(".")]).strip(".")
            names = [f"{stem}.{alias.name}" for alias in node.names]
        else:
            continue
        for name in names:
            while name and name not in known:
                name = name.rpartition(".")[0]
            if name and name != module:
                yield name


def circle(texts: Mapping[str, str]) -> list[str]:
    """The modules of one circle, none if there is none. The root package and mere parents of a module do not count."""
    known = set(texts) - {"holdfast", "bench"}
    graph = {name: set(imported(name, text, known)) for name, text in texts.items() if name in known}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as found:
        return list(found.args[1])
    return []


def test_there_is_no_circle() -> None:
    assert circle(sources()) == []


def test_a_planted_circle_is_found() -> None:
    texts = {
        "holdfast.a": "from holdfast.b import x",
        "holdfast.b": "def f():\n    from holdfast import c",
        "holdfast.c": "from .a import y",
    }
    assert set(circle(texts)) == set(texts)
    assert circle(texts | {"holdfast.c": "import numpy"}) == []


@pytest.mark.parametrize("module", ["holdfast.queries.map", "holdfast.queries.push", "holdfast.drawing.map_png"])
def test_a_module_is_imported_by_its_full_name(module: str) -> None:
    """Findings, H5: a function of the same name shadowed the package."""
    code = f"import holdfast, {module} as found; assert found.__name__ == {module!r}; import {module}; {module}"
    subprocess.run([sys.executable, "-c", code], check=True)
