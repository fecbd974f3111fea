"""The site has a place for every page and every public name."""

from __future__ import annotations

import re
from pathlib import Path

import holdfast as hf

DOCS = Path(__file__).parents[2] / "docs"
MADE = {"api/", "benchmarks/", "gallery/"}  # by `make docs`


def listed(page: str) -> list[str]:
    """The entries of all tables of contents, or lists of names, of a page."""
    text = (DOCS / page).read_text(encoding="utf-8")
    blocks = re.findall(r"```\{(?:toctree|eval-rst)\}\n(.*?)```", text, re.DOTALL)
    lines = [line.strip() for block in blocks for line in block.splitlines()]
    return [line for line in lines if line and not line.startswith((":", ".."))]


def test_every_public_name_is_on_the_page_of_names_once() -> None:
    assert sorted(listed("api.md")) == sorted(hf.__all__)


def test_every_page_is_in_the_contents_once() -> None:
    pages = sorted(path.stem for path in DOCS.glob("*.md") if path.stem != "index")
    assert sorted(name for name in listed("index.md") if "/" not in name) == pages


def test_links_between_pages_lead_somewhere() -> None:
    for path in [*DOCS.glob("*.md"), DOCS.parent / "README.md"]:
        for target in re.findall(r"\]\(([^)#\s]+)(?:#[\w-]+)?\)", path.read_text(encoding="utf-8")):
            if not target.startswith(("http", *MADE)):
                assert (path.parent / target).exists(), f"{path.name}: {target}"
