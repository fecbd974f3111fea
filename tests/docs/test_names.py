"""Names of modules, functions and files that the pages mention exist."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

from bench.figures.pages import notes, pages

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "CONTRIBUTING.md", *pages(ROOT), *notes(ROOT)]
FOLDERS = ("src", "bench", "tests", "examples", "tools")
DOTTED = re.compile(r"(?<![\w./-])(?:holdfast|hf|bench)(?:\.[A-Za-z_]\w*)+(?![\w/])")
IMPORTED = re.compile(r"^\s*from ((?:holdfast|bench)[\w.]*) import ([\w, ]+)", re.MULTILINE)
SOURCE = re.compile(r"`([\w/]+\.py)`")


def names(page: str) -> set[str]:
    """Dotted names of a page, ``hf`` written out."""
    found = {re.sub(r"^hf\b", "holdfast", name) for name in DOTTED.findall(page)}
    return found | {
        f"{module}.{name.strip()}" for module, several in IMPORTED.findall(page) for name in several.split(",")
    }


def resolved(name: str) -> object:
    """What a dotted name stands for: a module, or an attribute of one."""
    parts = name.split(".")
    for k in range(len(parts), 0, -1):
        try:
            found: object = importlib.import_module(".".join(parts[:k]))
        except ModuleNotFoundError:
            continue
        for part in parts[k:]:
            found = getattr(found, part)
        return found
    raise ModuleNotFoundError(name)


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_names_on_a_page_can_be_imported(path: Path) -> None:
    for name in sorted(names(path.read_text(encoding="utf-8"))):
        resolved(name)


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_source_files_on_a_page_exist(path: Path) -> None:
    there = [str(file) for folder in FOLDERS for file in (ROOT / folder).rglob("*.py")]
    mentioned = SOURCE.findall(path.read_text(encoding="utf-8"))
    assert [name for name in mentioned if not any(file.endswith(f"/{name}") for file in there)] == []


def test_a_name_that_does_not_exist_is_found_out() -> None:
    assert names("`holdfast.queries.mapp` and `hf.Boxx((1, 1, 1))`") == {"holdfast.queries.mapp", "holdfast.Boxx"}
    assert names("from bench import baselines, truths") >= {"bench.truths"}
    for name in ("holdfast.queries.mapp", "holdfast.Boxx", "bench.truths"):
        with pytest.raises((AttributeError, ModuleNotFoundError)):
            resolved(name)
