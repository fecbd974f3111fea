"""The site has a place for every page, and links lead somewhere."""

from __future__ import annotations

import re
import sys
from importlib import import_module
from pathlib import Path

import file_list

import holdfast as hf
from bench.checkout import RESULTS
from bench.figures.pages import notes, pages

DOCS = Path(__file__).parents[2] / "docs"
sys.path.append(str(DOCS / "_site"))
contents = import_module("contents")


def listed(page: str) -> list[str]:
    """The entries of all tables of contents of a page."""
    text = contents.with_howto((DOCS / page).read_text(encoding="utf-8"))
    blocks = re.findall(r"```\{toctree\}\n(.*?)```", text, re.DOTALL)
    lines = [line.strip() for block in blocks for line in block.splitlines()]
    entries = [line for line in lines if line and not line.startswith(":")]
    globbed = [path for entry in entries if "*" in entry for path in sorted(DOCS.glob(f"{entry}.md"))]
    more = [path.relative_to(DOCS).with_suffix("").as_posix() for path in globbed]
    plain = [entry for entry in entries if "*" not in entry]
    return plain + [name for name in more if name not in plain]


def test_every_page_is_in_the_contents_once() -> None:
    found = [str(path.relative_to(DOCS).with_suffix("")) for path in pages(DOCS.parent)[1:]]
    made = ("gallery/", "benchmarks/", "files/")
    assert sorted(name for name in listed("index.md") if not name.startswith(made)) == sorted({*found} - {"index"})
    assert len({*listed("index.md")}) == len(listed("index.md"))


def anchors(path: Path) -> set[str]:
    """What a link to a heading of a page says behind #."""
    headings = re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


def test_links_between_pages_lead_somewhere() -> None:
    """In a checkout, too: nothing that `make docs` has still to make."""
    made = ("benchmarks/", "files/", "gallery/")
    for path in {*pages(DOCS.parent), *notes(DOCS.parent), *DOCS.parent.glob("*.md")}:
        for target, anchor in re.findall(r"\]\(([^)#\s]*)(?:#([\w-]+))?\)", path.read_text(encoding="utf-8")):
            if not target.startswith("http"):
                there = path.parent / target if target else path
                assert not (DOCS in path.parents and target.startswith(made)), f"{path.name}: {target}"
                assert there.exists(), f"{path.name}: {target}"
                assert not anchor or anchor in anchors(there), f"{path.name}: {target}#{anchor}"


def test_every_note_is_one_of_a_suite_and_begins_below_the_heading_of_its_page() -> None:
    for path in notes(DOCS.parent):
        assert (RESULTS / path.name).exists(), f"{path.name}: no suite has this name"
        text = path.read_text(encoding="utf-8")
        assert not re.search("^# ", re.sub(r"```.*?```", "", text, flags=re.DOTALL), re.MULTILINE), path.name


def test_every_file_of_the_package_is_in_the_list_of_files() -> None:
    page = file_list.page()
    for folder in (Path(hf.__file__).parent, *(path for path in Path(hf.__file__).parent.rglob("*") if path.is_dir())):
        names = {path.name for path in folder.glob("*.py")} - {"__init__.py"}
        if (folder / "__init__.py").exists():
            heading = f"## `{folder.relative_to(Path(hf.__file__).parents[1]).as_posix()}/`\n"
            section = page.split(heading)[1].split("\n## ")[0]
            assert set(re.findall(r"^- `(\w+\.py)`: \S", section, re.MULTILINE)) == names
        else:
            assert not names, f"{folder} has no __init__.py"


def test_every_picture_is_on_a_page_and_small() -> None:
    shown = "".join(path.read_text(encoding="utf-8") for path in {*pages(DOCS.parent), *notes(DOCS.parent)})
    for path in (DOCS / "images").iterdir():
        assert re.search(rf"images/{re.escape(path.name)}[)\"]", shown), f"{path.name} is on no page"
        most = {"shelf.png": 200, "rooms.svg": 120, "placement_maps.png": 100}.get(path.name, 80)
        assert path.stat().st_size < 1000 * most, f"{path.name}: save it with 256 colours"
