"""The table of the first page lists all how-to pages by task, and the sidebar of the site follows it."""

from __future__ import annotations

import re

ROW = re.compile(r"^\| (?P<task>[^|]+) \| (?P<pages>\[.*) \|$", re.MULTILINE)
NEXT = "```{toctree}\n:hidden:\n:caption: Coming from\n"  # what follows the how-to pages


def with_howto(text: str) -> str:
    """Return the first page with a table of contents for each task, named by the words in bold.

    A row without such words goes on with the task of the row above.
    """
    groups = dict[str, list[str]]()
    for row in ROW.finditer(text):
        bold = re.findall(r"\*\*(.+?)\*\*", row["task"])
        name = " and ".join(bold).capitalize() if bold else [*groups][-1]
        groups.setdefault(name, []).extend(re.findall(r"\((howto/\w+)\.md\)", row["pages"]))
    made = ("\n".join(["```{toctree}", ":hidden:", f":caption: {name}", *groups[name], "```\n"]) for name in groups)
    before, found, after = text.partition(NEXT)
    if not found:
        raise ValueError(f"docs/index.md: no place for the how-to pages; put them before\n{NEXT}")
    return before + "".join(made) + found + after
