"""Numbers and tables of the pages are those of the saved benchmark results; the tool that writes them is tried too."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from bench.__main__ import app
from bench.checkout import RESULTS, ROOT
from bench.figures import pages as figures
from bench.figures.saved_rows import Saved, UnknownResultError, listed, rounded, significant, span, table

FILES = [*figures.pages(ROOT), *figures.notes(ROOT)]
KNOWN = {"try.seconds": "21, 40 and 41", "try.rows": "| a | b |\n|---|--:|\n| x | 1 |"}
PAGE = "Here <!-- figure: try.seconds -->20<!-- end --> ms.\n\n<!-- figure: try.rows -->\n<!-- end -->\n"


@pytest.fixture(scope="module")
def known() -> dict[str, str]:
    return figures.figures(RESULTS)


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_a_page_says_what_the_saved_results_say(path: Path, known: dict[str, str]) -> None:
    assert figures.faults(path.read_text(encoding="utf-8"), known) == []


def test_every_figure_stands_on_a_page(known: dict[str, str]) -> None:
    used = set().union(*(figures.used(path.read_text(encoding="utf-8")) for path in FILES))
    assert known.keys() - used == set()


def test_writing_twice_changes_nothing_more() -> None:
    once = figures.refreshed(PAGE, KNOWN)
    assert "<!-- figure: try.seconds -->21, 40 and 41<!-- end --> ms" in once
    assert "<!-- figure: try.rows -->\n\n| a | b |\n|---|--:|\n| x | 1 |\n\n<!-- end -->" in once
    assert figures.refreshed(once, KNOWN) == once
    assert figures.faults(once, KNOWN) == []


def test_lines_of_a_sentence_may_break_within_a_figure() -> None:
    page = "Here <!-- figure: try.seconds -->21, 40\nand 41<!-- end --> ms."
    assert figures.refreshed(page, KNOWN) == page
    assert figures.faults(page, KNOWN) == []


@pytest.mark.parametrize(
    ("page", "fault"),
    [
        (PAGE, "the page says '20', the saved results '21, 40 and 41'"),
        ("x <!-- figure: try.second -->1<!-- end -->", "'try.second' is unknown; did you mean 'try.seconds'?"),
        ("x <!-- figure: try.seconds -->21, 40 and 41", "needs one '<!-- end -->' of its own"),
        ("x 21, 40 and 41<!-- end -->", "needs one '<!-- end -->' of its own"),
        ("takes\n<!-- figure: try.seconds -->21, 40 and 41<!-- end --> ms", "must not begin with its comment"),
        ("takes <!-- figure: try.seconds -->21, 40 and 41\n<!-- end --> ms", "must not begin with its comment"),
        (
            "<!-- figure: try.rows -->\n\n| a | b |\n|---|--:|\n| x | 2 |\n<!-- end -->",
            "line 3 of the table is '| x | 2 |'",
        ),
    ],
)
def test_a_fault_is_named(page: str, fault: str) -> None:
    assert any(fault in found for found in figures.faults(page, KNOWN))


def test_a_result_that_was_not_saved_is_named(tmp_path: Path) -> None:
    (tmp_path / "try.json").write_text(json.dumps({"rows": [{"case": "cube", "map s": 1.5, "force": "inf"}]}))
    saved = Saved(tmp_path, "try")
    assert saved.value("cube", "map s") == 1.5
    assert saved.value("cube", "force") == math.inf
    with pytest.raises(UnknownResultError, match=r"no case 'cub'; did you mean 'cube'"):
        saved.value("cub", "map s")
    with pytest.raises(UnknownResultError, match=r"no column 'maps s'; did you mean 'map s'"):
        saved.value("cube", "maps s")
    with pytest.raises(UnknownResultError, match=r"python -m bench run other --save"):
        Saved(tmp_path, "other")


def called(*options: object) -> object:
    """The exit code of ``python -m bench figures``."""
    with pytest.raises(SystemExit) as ended:
        app(["figures", *map(str, options)])
    return ended.value.code


def test_the_command_checks_and_writes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for page in FILES:
        copy = tmp_path / page.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_text(page.read_text(encoding="utf-8"), encoding="utf-8")
    page = tmp_path / "docs" / "explanation" / "limit.md"
    right = page.read_text(encoding="utf-8")
    page.write_text(right.replace("-->500<!--", "-->400<!--"), encoding="utf-8")
    assert called("--check", "--root", tmp_path) == 1
    assert "limit.md: figure 'scaling.bricks'" in capsys.readouterr().err
    assert called("--root", tmp_path) == 0
    assert page.read_text(encoding="utf-8") == right
    assert called("--check", "--root", tmp_path) == 0


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0065764, "0.0066"),
        (0.102, "0.1"),
        (0.0999, "0.1"),
        (9.4999, "9.5"),
        (287.4, "290"),
        (3066.7, "3,100"),
        (0.0, "0"),
        (math.inf, "inf"),
    ],
)
def test_numbers_are_rounded_to_significant_digits(value: float, text: str) -> None:
    assert rounded(value) == text


def test_numbers_as_they_stand_in_tables_and_sentences() -> None:
    assert [significant(x) for x in (0.0147, 9.5, 287.4, 3066.7)] == ["0.015", "9.5", "287", "3,067"]
    assert listed(["1", "2", "3"]) == "1, 2 and 3"
    assert (span(["4", "9"]), span(["4", "4"])) == ("4 to 9", "4")
    assert table(["a", "b"], [["x", "1"]]) == KNOWN["try.rows"]
