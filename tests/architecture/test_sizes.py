"""Functions and modules stay short enough to be read in one go."""

from __future__ import annotations

import ast
import io
import tokenize
from functools import cache
from pathlib import Path

import pytest

import holdfast

ROOTS = (Path(holdfast.__file__).parent, Path(__file__).parents[2] / "bench")
LONGEST_FUNCTION = 60  # code lines: no blank ones, comments or docstrings
LONGEST_MODULE = 330
LONGEST_HEADER = 480  # of the compiled core, comments included: an idea, with its formulas
MANY_MODULES = 250  # nine modules in ten are shorter: an idea has 100 to 400 lines, docstrings and blank ones included

LAYOUT = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@cache
def code_lines(source: str) -> frozenset[int]:
    """Numbers of the lines that hold code."""
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in LAYOUT:
            lines.update(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            docstring = node.body[0]
            lines.difference_update(range(docstring.lineno, (docstring.end_lineno or 0) + 1))
    return frozenset(lines)


def functions(source: str) -> list[tuple[str, int]]:
    """Name and code lines of every function, nested ones and methods too."""
    lines = code_lines(source)
    return [
        (node.name, sum(node.lineno <= line <= (node.end_lineno or 0) for line in lines))
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    ]


def too_long(name: str, source: str) -> list[str]:
    found = [f"{name}:{function}" for function, count in functions(source) if count > LONGEST_FUNCTION]
    return found + ([name] if len(code_lines(source)) > LONGEST_MODULE else [])


def sources() -> dict[str, str]:
    paths = {path: path.relative_to(root.parent) for root in ROOTS for path in sorted(root.rglob("*.py"))}
    return {relative.as_posix(): path.read_text() for path, relative in paths.items()}


def test_no_function_and_no_module_is_too_long() -> None:
    found = {place for name, source in sources().items() for place in too_long(name, source)}
    assert found == set()


def test_most_modules_are_short() -> None:
    lengths = sorted(len(code_lines(source)) for name, source in sources().items() if not name.endswith("__init__.py"))
    assert lengths[int(0.9 * len(lengths))] <= MANY_MODULES


def test_no_header_of_the_compiled_core_is_too_long() -> None:
    files = {path.name: path.read_text().count("\n") for path in (ROOTS[0] / "native").glob("*.?pp")}
    assert len(files) > 40
    assert {name for name, count in files.items() if count > LONGEST_HEADER} == set()


@pytest.mark.parametrize(("lines", "long"), [(61, True), (60, False)])
def test_a_planted_function_is_measured(lines: int, long: bool) -> None:
    body = '    """Not a line of code,\n\n    nor this."""\n\n    # nor this\n' + "    x = 1\n" * (lines - 1)
    assert too_long("planted.py", f"def f():\n{body}") == (["planted.py:f"] if long else [])


def test_a_planted_module_is_measured() -> None:
    assert too_long("planted.py", "x = 1\n" * (LONGEST_MODULE + 1)) == ["planted.py"]
    assert too_long("planted.py", "x = 1\n# and why\n\n" * LONGEST_MODULE) == []
