"""The commands batch, report and check."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from calling import Call

import holdfast as hf

HOSTILE = "<script>alert(1)<!--&\"'"  # as a file name may be


def raised(height: float) -> hf.Scene:
    """The cube, so much above its floor [m]."""
    cube = hf.shipped_scene("cube")
    shift = np.eye(4)
    shift[2, 3] = height
    return cube.moved({"cube": shift @ cube.body("cube").pose})


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with two scenes that stand, one of them named like markup, and one that is no scene."""
    (tmp_path / "in").mkdir()
    hf.save_scene(raised(0.0), tmp_path / "in" / f"{HOSTILE}.yaml")
    hf.save_scene(hf.shipped_scene("stack"), tmp_path / "in" / "stack.yaml")
    (tmp_path / "in" / "broken.yaml").write_text(f"bodies: [\n# {HOSTILE}")
    return tmp_path


def test_a_batch_is_told_and_reported_on_one_page(folder: Path, call: Call) -> None:
    options = folder / "options.json"
    options.write_text(json.dumps({"engine": "limit", "transport": {"directions": [[1, 0, 0]]}}))
    arguments = (
        "--out",
        folder / "out",
        "--ask",
        "stability",
        "--ask",
        "transport",
        "--options",
        options,
        "--workers",
        1,
    )
    code, out, _ = call("batch", folder / "in", *arguments)
    assert code == 3
    assert "3 scenes: 2 answered, 1 error, 2 stable" in out.replace("\n", " ")
    assert "error: " in out
    code, out, _ = call("batch", folder / "in" / "*.yaml", *arguments, "--json")
    told = json.loads(out)
    assert (code, told["verdict"], told["details"]["asked"], told["details"]["kept"]) == (3, "undecided", 0, 3)
    assert sorted(str(row["verdict"]) for row in told["rows"]) == ["stable", "stable", "undecided"]
    assert [len(row["rows"]) for row in told["rows"] if row["verdict"] == "stable"] == [1, 1]  # accelerations along x
    assert call("report", folder / "out")[0] == 0
    page = (folder / "out" / "report.html").read_text(encoding="utf-8")
    assert "<script" not in page
    assert "&lt;script&gt;" in page
    assert "default-src 'none'" in page
    assert re.findall(r"https?://", page) == []
    assert page.count("data:image/png;base64,") == 2
    assert "3 scenes in" in page
    assert page.count("<svg") >= 4


def test_the_page_says_what_gives_way_first(tmp_path: Path, call: Call) -> None:
    hf.save_scene(raised(0.0), tmp_path / "cube.yaml")
    pushes = tmp_path / "pushes.csv"
    pushes.write_text("body, x, y, z, dx, dy, dz\ncube, -0.05, 0, 0.001, 1, 0, 0\n")
    call("batch", tmp_path / "cube.yaml", "--out", tmp_path / "out", "--ask", f"push:{pushes}", "--workers", 1)
    assert call("report", tmp_path / "out")[0] == 0
    assert "<td>slip: cube</td>" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("height", "options", "code", "result"),
    [
        (1.0, ("--stands",), 1, "failure"),
        (0.0, ("--min-force", 5.88598), 3, "error"),
        (0.0, ("--min-force", 6.5), 1, "failure"),
    ],
)
def test_a_check_says_what_fails(
    tmp_path: Path, call: Call, height: float, options: tuple[Any, ...], code: int, result: str | None
) -> None:
    """A cube of 1 kg, friction 0.6: pushed at half its height it slips at 5.886 N; ``lower`` is a little less."""
    hf.save_scene(raised(height), tmp_path / "cube.yaml")
    pushes = tmp_path / "pushes.csv"
    pushes.write_text("body,x,y,z,dx,dy,dz\ncube,-0.05,0,0.05,1,0,0\n")
    given = (*options, *(("--push", pushes) if "--min-force" in options else ()))
    junit = tmp_path / "junit.xml"
    found, out, _ = call("check", tmp_path / "cube.yaml", *given, "--junit", junit, "--workers", 1)
    assert found == code, out
    assert re.search(r"^next: `holdfast (assess|map) .*cube.yaml` shows", out, re.MULTILINE)
    (case,) = Xml.parse(junit).getroot().iter("testcase")
    assert [child.tag for child in case] == ([] if result is None else [result])


def test_a_check_says_what_changed_since_the_baseline(tmp_path: Path, call: Call) -> None:
    scene, old, new = tmp_path / "cube.yaml", tmp_path / "old", tmp_path / "new"
    hf.save_scene(raised(0.0), scene)
    assert call("check", scene, "--stands", "--out", old, "--workers", 1)[0] == 0
    hf.save_scene(raised(1e-5), scene)
    code, out, _ = call("check", scene, "--baseline", old, "--out", new, "--workers", 1)
    assert (code, "cube moved by 0.01 mm" in out) == (1, True)
    assert call("check", scene, "--baseline", old, "--out", new, "--distance", 2e-5)[0] == 0


def test_a_file_that_two_globs_name_is_asked_once(folder: Path, call: Call) -> None:
    code, out, _ = call("check", folder / "in" / "stack.yaml", folder / "in" / "s*.yaml", "--stands", "--workers", 1)
    assert (code, out) == (0, "1 passed, 0 failed, 0 undecided\n")


def test_junit_is_what_schemas_ask_for_and_says_what_helps(folder: Path, call: Call) -> None:
    """Windy Road's schema of Ant's reports wants all of this in this order; Jenkins' junit-10 takes it, too."""
    hf.save_scene(raised(1.0), folder / "in" / "it's.yaml")
    junit, summary = folder / "junit.xml", folder / "summary.md"
    files = ("--junit", junit, "--summary", summary)
    assert call("check", folder / "in", "--stands", *files, "--seconds", 20, "--workers", 1)[0] == 1
    root = Xml.parse(junit).getroot()
    (suite,) = root
    assert (root.tag, suite.tag, root.attrib) == ("testsuites", "testsuite", {})
    assert suite.attrib.keys() == {
        *("name", "package", "id", "timestamp", "hostname", "tests", "failures", "errors", "skipped", "time")
    }
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d", suite.attrib["timestamp"])
    assert [suite.attrib[name] for name in ("tests", "failures", "errors", "skipped")] == ["4", "2", "0", "0"]
    assert [child.tag for child in suite] == ["properties", *["testcase"] * 4, "system-out", "system-err"]
    found = {case.attrib["name"].rpartition("/")[2]: case for case in suite.iter("testcase")}
    assert found.keys() == {f"{HOSTILE}.yaml", "stack.yaml", "broken.yaml", "it's.yaml"}
    assert all(case.attrib.keys() == {"classname", "name", "time"} for case in found.values())
    assert sum(float(case.attrib["time"]) for case in found.values()) == pytest.approx(
        float(suite.attrib["time"]), abs=3e-3
    )
    (failure,) = found["it's.yaml"]
    assert failure.tag == "failure"
    reason, helps = str(failure.text).splitlines()
    assert failure.attrib == {"type": "failed", "message": reason}
    assert "unstable" in reason
    assert "in/it'\"'\"'s.yaml'` shows why" in helps
    told = summary.read_text(encoding="utf-8")
    assert told.startswith("### holdfast check: 2 passed, 2 failed, 0 undecided\n\n<table>")
    assert told.count("<tr>") == 3
    assert "<script" not in told


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("check", "cube.yaml", "--min-force", "nan"), "--min-force: is nan"),
        (("check", "cube.yaml", "--min-force", -1), "--min-force: is -1"),
        (("check", "cube.yaml", "--stands", "--change", "nan"), "--change: is nan"),
        (("check", "cube.yaml"), "there is nothing to check"),
        (("check", "cube.yaml", "--stands"), "names no scene file"),
        (("check", "cube.yaml", "--baseline", "nowhere"), "folder of a batch"),
        (("report", "nowhere"), "folder of a batch"),
        (("batch", "*.none", "--out", "x"), "names no scene file"),
    ],
)
def test_bad_input_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: Call, arguments: tuple[str, ...], words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    code, _, err = call(*arguments)
    assert code == 2
    assert words in err


def test_a_check_prints_what_readers_guessed_with_the_number_of_scenes(tmp_path: Path, call: Call) -> None:
    link = '<link name="l"><collision name="c"><geometry><box><size>1 1 0.1</size></box></geometry></collision></link>'
    for name, height in (("near", 0.1), ("far", 2.0)):
        above = f'<model name="up"><pose>0 0 {height} 0 0 0</pose>{link}</model>'
        world = f'<world name="w"><model name="floor"><static>true</static>{link}</model>{above}</world>'
        (tmp_path / f"{name}.sdf").write_text(f'<sdf version="1.9">{world}</sdf>')
    code, out, _ = call("check", tmp_path / "*.sdf", "--stands", "--workers", 1)
    said = " ".join(out.split())
    assert code == 1
    assert "note: link up::l: mass 1 kg, which SDF says where a file says none (2 scenes)" in said
