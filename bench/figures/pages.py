"""Write the numbers and tables of README.md, docs/ and bench/notes/ that come from saved benchmark results.

A page holds each of them between two comments, which no Markdown viewer shows::

    a map of 1,000 points takes <!-- figure: pipeline.seconds -->21, 40 and 41<!-- end --> ms

The name says which suite's saved results the figure is made from (``bench/results/pipeline.json``) and which
figure of ``numbers.py`` or ``tables.py`` it is. A table stands on lines of its own between the two.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from itertools import zip_longest
from pathlib import Path

from bench.figures.numbers import NUMBERS
from bench.figures.saved_rows import Saved
from bench.figures.tables import TABLES

START = re.compile(r"<!-- figure: (?P<name>\S+) -->")
END = "<!-- end -->"
PARTS = ("", "howto", "from", "explanation", "reference")  # folders of docs/
FIGURE = re.compile(START.pattern + r"(?P<text>.*?)" + END, re.DOTALL)


def figures(results: Path) -> dict[str, str]:
    """The text of every figure by its name, "suite.figure", from the saved results in a folder."""
    found: dict[str, str] = {}
    for makers in (NUMBERS, TABLES):
        for suite, make in makers.items():
            found |= {f"{suite}.{name}": text for name, text in make(Saved(results, suite)).items()}
    return found


def pages(root: Path) -> list[Path]:
    """README and the pages of docs/, without what ``make docs`` makes there."""
    return [root / "README.md", *(page for part in PARTS for page in sorted((root / "docs" / part).glob("*.md")))]


def notes(root: Path) -> list[Path]:
    """What is to be said of single suites, ``bench/notes/SUITE.md``: the site shows it above the table of the suite."""
    return sorted((root / "bench" / "notes").glob("*.md"))


def same(one: str, other: str) -> bool:
    """Whether two texts of a figure say the same; a sentence may break its lines elsewhere, a table may not."""
    if "\n" in one:
        return one.strip().splitlines() == other.strip().splitlines()
    return one.split() == other.split()


def refreshed(page: str, known: Mapping[str, str]) -> str:
    """The page with every figure as it is known; one that differs only in where its lines break is left alone."""

    def renewed(match: re.Match[str]) -> str:
        text = known.get(match["name"])
        if text is None or same(text, match["text"]):
            return match[0]
        inserted = f"\n\n{text}\n\n" if "\n" in text else text
        return f"<!-- figure: {match['name']} -->{inserted}{END}"

    return FIGURE.sub(renewed, page)


def faults(page: str, known: Mapping[str, str]) -> list[str]:
    """What is wrong with the figures of a page, one sentence each."""
    found = []
    if len(START.findall(page)) != len(FIGURE.findall(page)) or page.count(END) != len(FIGURE.findall(page)):
        found.append(f"every '<!-- figure: NAME -->' needs one '{END}' of its own")
    for match in FIGURE.finditer(page):
        name, text = match["name"], known.get(match["name"])
        if text is None:
            near = difflib.get_close_matches(name, list(known), n=1)
            found.append(f"figure {name!r} is unknown" + (f"; did you mean {near[0]!r}?" if near else ""))
            continue
        if not same(text, match["text"]):
            found.append(f"figure {name!r}: {_difference(match['text'], text)}")
        # Markdown takes a line that begins with a comment for raw HTML: the paragraph would end there
        if "\n" not in text and (page[: match.start()].endswith("\n") or match["text"].endswith("\n")):
            found.append(f"figure {name!r}: a line of text must not begin with its comment; put a word before it")
    return found


def _difference(written: str, saved: str) -> str:
    if "\n" not in saved:
        return f"the page says {written!r}, the saved results {saved!r}"
    lines = (text.strip().splitlines() for text in (written, saved))
    for number, (ours, theirs) in enumerate(zip_longest(*lines, fillvalue="nothing"), 1):
        if ours != theirs:
            return f"line {number} of the table is {ours!r}; by the saved results it is {theirs!r}"
    return "the table differs in its blank lines"


def used(page: str) -> set[str]:
    """The names of the figures that a page holds."""
    return {match["name"] for match in FIGURE.finditer(page)}


def refresh(root: Path, results: Path) -> list[Path]:
    """Put the saved results in a folder into all pages below ``root``; the pages that changed."""
    known = figures(results)
    changed = []
    for path in [*pages(root), *notes(root)]:
        before = path.read_text(encoding="utf-8")
        text = refreshed(before, known)
        if text != before:
            path.write_text(text, encoding="utf-8")
            changed.append(path)
    return changed


def all_faults(root: Path, results: Path) -> list[str]:
    """What is wrong with the figures of all pages, one sentence each; a figure must stand on a page."""
    known = figures(results)
    found, names = [], set[str]()
    for path in [*pages(root), *notes(root)]:
        text = path.read_text(encoding="utf-8")
        names |= used(text)
        found += [f"{path.relative_to(root)}: {fault}" for fault in faults(text, known)]
    return found + [f"figure {name!r} stands on no page: remove it" for name in sorted(known.keys() - names)]
