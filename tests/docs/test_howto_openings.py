"""Every how-to opens with its call, and shows at once what comes of it: a picture, or what is printed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

PAGES = sorted((Path(__file__).parents[2] / "docs" / "howto").glob("*.md"))
FIRST = 12  # the line by which the call begins
APART = 3  # lines at most between the call and its picture or output
SHOWN = ("![", "```text", "```console", "```json")


def fault(text: str) -> str:
    """What is wrong with how a page opens; nothing if it opens well."""
    lines = text.splitlines()
    begin = next((k for k, line in enumerate(lines[:FIRST]) if line.startswith("```")), None)
    if begin is None:
        return f"no call within {FIRST} lines"
    end = next(k for k, line in enumerate(lines) if k > begin and line.startswith("```"))
    block, after = lines[begin : end + 1], lines[end + 1 : end + 2 + APART]
    if block[0] == "```console" or any(re.search(r"\bprint\(.*\)\s+# \S", line) for line in block):
        return ""
    return "" if any(line.startswith(SHOWN) for line in after) else "neither picture nor output follows the call"


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_a_how_to_opens_with_its_call_and_what_comes_of_it(path: Path) -> None:
    assert fault(path.read_text(encoding="utf-8")) == ""


CALL = "```bash\nholdfast assess table\n```\n"


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("# A\n\nWhy.\n\n" + CALL + "\n```text\nstable\n```\n", ""),
        ("# A\n\nWhy.\n\n" + CALL + "\n![It](a.png)\n", ""),
        ("# A\n\nWhy.\n\n```python\nprint(1)  # 1\n```\n", ""),
        ("# A\n\nWhy.\n\n" + CALL + "\nMore.\n\n```bash\nls\n```\n", "neither picture nor output follows the call"),
        ("# A\n\nWhy.\n\n```python\nprint(1)\n```\n", "neither picture nor output follows the call"),
        ("# A\n\nWhy.\n" + "\nMore.\n" * 4 + "\n" + CALL + "\n![It](a.png)\n", "no call within 12 lines"),
        ("# A\n\nOnly words.\n", "no call within 12 lines"),
    ],
)
def test_other_openings_are_found_out(text: str, found: str) -> None:
    assert fault(text) == found
