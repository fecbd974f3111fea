"""What a release needs beside tests, site and packages, and what a person must still do by hand.

    python tools/release_check.py [FOLDER]

`make release-check` runs the tests, builds site and packages into FOLDER (`out`), and then this: one version
everywhere, a changelog that knows it, committed files only, pages with the figures of the saved benchmarks, and no dead
link on the site. Exit code 1 if anything is wrong.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

ROOT = Path(__file__).parents[1]
PLACES = {  # where a version stands
    "pyproject.toml": r'^version = "(.*)"',
    "CITATION.cff": r"^version: (.*)",
    "packaging/conda/meta.yaml": r'set version = "(.*)"',
    "src/holdfast/__init__.py": r'^__version__ = "(.*)"',
    "CHANGELOG.md": r"^## (\S+) \(\d{4}-\d\d-\d\d\)",
}
RELEASED = re.compile(r"\d+\.\d+\.\d+(rc\d+)?")
BY_HAND = """
By hand, in this order:
 1. Give the repository a public address; put it into [project.urls] of pyproject.toml, `repository-code` of
    CITATION.cff, and the links and pictures of README.md, which an index shows without the files beside it.
 2. make test-referees test-slow test-kernels, test-sanitized, test-wheels with PYTHONS, and make fuzz with
    new seeds (CONTRIBUTING.md); look at the pictures of the site, narrow and wide.
 3. git tag -s v{version}, and push the tag.
 4. Upload the two files of {folder}/dist as holdfast-robotics, first to an index for trials, and install it from there.
 5. Publish {folder}/site. Archive the tag where it gets a DOI, and put that into CITATION.cff.
 6. Open the next version: .dev0 in the four files, and a heading in CHANGELOG.md.
"""


class Page(HTMLParser):
    """The links of a page, and the names that links can lead to."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.names: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note what a tag leads to, and its name."""
        for name, value in attrs:
            if value and name in ("href", "src"):
                self.links.append(value)
            elif value and name in ("id", "name"):
                self.names.add(value)


def versions() -> Iterator[str]:
    """Tell where the version is missing, differs or is none of a release."""
    found = {}
    for place, pattern in PLACES.items():
        match = re.search(pattern, (ROOT / place).read_text(encoding="utf-8"), re.MULTILINE)
        if match is None:
            yield f"{place}: no version by the pattern {pattern}"
        else:
            found[place] = match[1]
    if len(set(found.values())) > 1:
        yield f"versions differ: {found}"
    yield from (
        f"{place}: {version} is no version of a release"
        for place, version in found.items()
        if not RELEASED.fullmatch(version)
    )


def uncommitted() -> Iterator[str]:
    """Tell which files differ from the last commit."""
    said = subprocess.run(["git", "status", "--porcelain"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    yield from (f"not committed: {line[3:]}" for line in said.splitlines())


def figures() -> Iterator[str]:
    """Tell which figures of the pages are not those of the saved benchmarks."""
    done = subprocess.run(
        [sys.executable, "-m", "bench", "figures", "--check"], cwd=ROOT, capture_output=True, text=True
    )
    if done.returncode:
        yield (done.stdout + done.stderr).strip()


def dead_links(site: Path) -> Iterator[str]:
    """Tell which links of a built site lead nowhere; those to other sites are not followed."""
    pages = {path: Page(path) for path in sorted(site.rglob("*.html"))}
    if not pages:
        yield f"{site} has no pages: make docs builds them"
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            named = (
                parts.fragment in ("", "top") or target not in pages or unquote(parts.fragment) in pages[target].names
            )
            if not target.exists() or not named:
                yield f"{path.relative_to(site)}: {link}"


def main() -> int:
    """Say of each check what is wrong, and at the end what is left to do by hand; return 1 if anything is wrong."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
    wrong = 0
    for name, faults in (
        ("one version", versions()),
        ("all is committed", uncommitted()),
        ("figures are the benchmarks'", figures()),
        ("no dead links on the site", dead_links((ROOT / folder / "site").resolve())),
    ):
        told = list(faults)
        wrong += len(told)
        print(f"{name}: {'ok' if not told else 'NO'}", *told, sep="\n  ")
    version = re.search(PLACES["pyproject.toml"], (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE)
    print(BY_HAND.format(version=version[1] if version else "?", folder=folder))
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
