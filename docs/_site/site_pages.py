"""Pages of the site that are made of other files (benchmarks, files, parameters), and links that mean files elsewhere.

The pages of docs/ are read on their own, too, where links lead to files beside the folder. On the site these lead to
the pages that were made of them.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import api_pages
import contents
import file_list
import vocabulary
from sphinx.application import Sphinx
from sphinx.util.inspect import TypeAliasForwardRef

DOCS = Path(__file__).parents[1]
ROOT = DOCS.parent
RESULTS = ROOT / "bench" / "results"
NOTES = ROOT / "bench" / "notes"  # what there is to say of a suite, by its name
MADE = DOCS / "benchmarks"
HEAD = """# Benchmarks

What was measured, each with one command: `python -m bench run NAME` measures it again, `--compare` shows both beside
each other. Times are those of two cores of a shared machine; ratios mean more than seconds.

"""
# Links of the pages, and where they lead on the site
LINKS = (
    (
        re.compile(r"\]\((?:\.\./)+(?:bench/)?(?:results|notes)/(\w+)\.(md|png)((?:#[\w-]+)?)\)"),
        r"](/benchmarks/\1.\2\3)",
    ),
    (re.compile(r"\]\((?:\.\./)+docs/"), "](/"),
    (re.compile(r"\]\((?:\.\./)*bench/results\)"), "](/benchmarks/index.md)"),
    (re.compile(r"\]\((?:\.\./)+examples\)"), "](/gallery/index.rst)"),
    (re.compile(r"\]\((?:\.\./)+tools/vocabulary\.csv\)"), "](/files/parameters.md)"),
    (re.compile(r"\]\((?:\.\./)*CONTRIBUTING\.md\)"), "](/contributing.md)"),
    (re.compile(r"\]\((?:\.\./)*SECURITY\.md\)"), "](/security.md)"),
    (re.compile(r"\]\((?:\.\./)*CHANGELOG\.md\)"), "](/changelog.md)"),
)
# In docstrings
ERRORS = {name.rpartition(".")[2]: name for name in api_pages.public_names() if re.search("(Error|Warning)$", name)}
NAMED_ERROR = re.compile(rf"(?<![`.\w])(?:{'|'.join(ERRORS)})(?![`\w])")
NAMED_PAGE = re.compile(r"(?<![`/\w])docs/([\w/]+)\.md")
BARS = re.compile(r"(``.*?``)|(?<!\\)\|(?=\S)([^|`]+?)(?<=\S)\|")  # code, or an absolute value


def make_benchmarks(app: Sphinx) -> None:
    """Write a page for every saved benchmark, and one that lists them."""
    shutil.rmtree(MADE, ignore_errors=True)
    MADE.mkdir()
    names, listed = sorted(path.stem for path in RESULTS.glob("*.md")), list[str]()
    for name in names:
        text = (RESULTS / f"{name}.md").read_text(encoding="utf-8")
        listed.append(f"- [{name}]({name}.md): {text.splitlines()[2].replace('``', '`')}")
        note = NOTES / f"{name}.md"
        if note.exists():
            about, rows = text.split("\n|", 1)
            text = f"{about}\n{note.read_text(encoding='utf-8')}\n## Results\n\n|{rows}"
        picture = RESULTS / f"{name}.png"
        if picture.exists():
            shutil.copy(picture, MADE / picture.name)
            text += f"\n![{name}]({picture.name})\n"
        (MADE / f"{name}.md").write_text(text, encoding="utf-8")
    hidden = "\n".join(["", "", "```{toctree}", ":hidden:", "", *names, "```", ""])
    (MADE / "index.md").write_text(HEAD + "\n".join(listed) + hidden, encoding="utf-8")


def make_lists(app: Sphinx) -> None:
    """Write the pages that list all files of the package and all parameters, and a page for each public name."""
    folder = DOCS / "files"
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "api").mkdir(parents=True)
    (folder / "index.md").write_text(file_list.page(), encoding="utf-8")
    (folder / "parameters.md").write_text(vocabulary.page(), encoding="utf-8")
    for name in api_pages.public_names():
        (folder / "api" / f"{name}.rst").write_text(api_pages.page_of(name), encoding="utf-8")


def lead_on_site(app: Sphinx, name: str, source: list[str]) -> None:
    """Turn links to files beside the folder of the pages into links to pages of the site; list what pages hold."""
    if name == "reference/api":
        source[0] = api_pages.with_lines(source[0])
    if name == "index":
        source[0] = contents.with_howto(source[0])
    for pattern, target in LINKS:
        source[0] = pattern.sub(target, source[0])


def lead_from_root(app: Sphinx, path: Path, parent: str, source: list[str]) -> None:
    """Do so in files that a page includes, whose links begin at the root of the repository."""
    lead_on_site(app, parent, source)
    source[0] = re.sub(r"\]\(docs/", "](", source[0])


def mark_up_docstrings(
    app: Sphinx, what: str, name: str, subject: object, options: object, lines: list[str]
) -> None:  # arguments as Sphinx gives them
    """Let docstrings lead to the pages and errors that they name, and show |x| as it stands."""
    for k, line in enumerate(lines):
        plain = BARS.sub(lambda found: found[1] or rf"\|{found[2]}\|", line)
        plain = NAMED_ERROR.sub(lambda found: f":py:exc:`{found[0]} <{ERRORS[found[0]]}>`", plain)
        lines[k] = NAMED_PAGE.sub(r":doc:`docs/\1.md </\1>`", plain)


def listed_anew(app: Sphinx, *changes: object) -> list[str]:
    """Read the list of names in every build: its lines are those of docstrings."""
    return ["reference/api"]


def setup(app: Sphinx) -> dict[str, Any]:
    """Join the making of the site."""
    app.connect("builder-inited", make_benchmarks)
    app.connect("builder-inited", make_lists)
    app.connect("source-read", lead_on_site)
    app.connect("include-read", lead_from_root)
    app.connect("autodoc-process-docstring", mark_up_docstrings)
    TypeAliasForwardRef.__repr__ = lambda self: self.name  # type: ignore[method-assign] # an alias within a union
    app.connect("env-get-outdated", listed_anew)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
