"""The Python on the pages runs as it stands there, and prints what it says. Some pages have tests that know more."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from typing import Any

import pytest

from bench.figures.pages import pages

DOCS = Path(__file__).parents[2] / "docs"
OWN = {"tutorial", "batch", "carry", "near_hardware", "bring_a_scene", "in_a_loop"}  # beside the pages in from/
NEEDS = {"view": ("viser",), "rerun": ("rerun",)}  # beside the library
PAGES = {
    path.stem: found
    for path in pages(DOCS.parent)[1:]
    if path.stem not in OWN
    and path.parent.name != "from"
    and (found := re.findall(r"```python\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL))
}


@pytest.mark.parametrize("page", PAGES)
def test_snippets_run_in_order_and_print_what_they_say(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = [name for name in NEEDS.get(page, ()) if importlib.util.find_spec(name) is None]
    if missing:
        pytest.skip(f"needs {', '.join(missing)}")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for text in PAGES[page]:
        exec(compile(text, f"{page}.md", "exec"), names)
        printed = capsys.readouterr().out.splitlines()
        for said in re.findall(r"print\(.*\)\s+# (.*)", text):
            assert any(line and said.startswith(line) for line in printed), f"{said}: {printed}"


def test_there_are_pages_with_snippets() -> None:
    assert {"sets", "transport", "uncertainty"} <= PAGES.keys()
