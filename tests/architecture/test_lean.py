"""Lean functions count no arrays: one that made or returned an array would leak it, or free it twice."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import holdfast

ROOT = Path(holdfast.__file__).parent
NUMBERS = {"None", "float", "int", "bool", "Event", "Iteration"}
MAKERS = {"empty", "zeros", "ones", "full", "array", "arange", "copy", "empty_like", "zeros_like"}


def faults(source: str) -> list[str]:
    """What the lean functions of a module return or make, where that is no number."""
    found = []
    for function in ast.walk(ast.parse(source)):
        if not isinstance(function, ast.FunctionDef):
            continue
        if "lean" not in {each.id for each in function.decorator_list if isinstance(each, ast.Name)}:
            continue
        returned = ast.unparse(function.returns) if function.returns is not None else "nothing that is stated"
        if set(returned.removeprefix("tuple[").removesuffix("]").split(", ")) - NUMBERS:
            found.append(f"{function.name} returns {returned}")
        found += [
            f"{function.name} calls {node.func.attr}"
            for node in ast.walk(function)
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in MAKERS
        ]
    return found


def test_lean_functions_neither_make_nor_return_arrays() -> None:
    sources = {path.relative_to(ROOT).as_posix(): path.read_text() for path in sorted(ROOT.rglob("*.py"))}
    assert sum("@lean" in source for source in sources.values()) > 5
    assert {name: found for name, source in sources.items() if (found := faults(source))} == {}


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("-> Float:\n    return x", ["f returns Float"]),
        ("-> float:\n    return x.copy()[0]", ["f calls copy"]),
        ("-> float:\n    return np.zeros(3)[0]", ["f calls zeros"]),
        ("-> float:\n    return x[0]", []),
    ],
)
def test_planted_faults_are_found(body: str, expected: list[str]) -> None:
    assert faults(f"@compiled\n@lean\ndef f(x: Float) {body}") == expected
