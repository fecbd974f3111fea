"""Names that are made to do harm, through every command, picture and page (findings D2, D6, D7, D15, D21)."""

from __future__ import annotations

import html
import io
import json
import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from calling import Call
from paged import data_of, said
from rich.console import Console

import holdfast as hf
from holdfast.report.carrier_report import carried_report, transport_report
from holdfast.report.contact_report import map_report, stability_report
from holdfast.scene.shipped.blocks import box, floor

NAMES = {
    "markup": "[/]",
    "style": "[red]x[/red]",
    "link": "[link=file:///etc/passwd]a[/link]",
    "emoji": ":smile:",
    "escape": "a\x1b[2J\x1b[31mb",
    "lines": "one\ntwo\r\nthree\tfour",
    "backwards": "pay\u202egnp.exe\u2066",
    "zero": "a\0b",
    "bell": "\x07\x08\x9b31m",
    "page": "<img src=x onerror=alert(1)><b>bold</b>",
    "script": "</script><script>alert(1)</script>",
    "entity": "&lt;i&gt;",
    "formula": "$\\frac{1}{$_{x}^2",
    "template": "%{x} {0} %s $title ${data}",
    "breaks": "a<br>b",
    "long": "x" * 500,
    "wide": "漢" * 100,
    "option": "--json",
    "separator": "a\u2028b\u0085c",
    "quotes": "'\"`",
    "private": "\ue000\ufeff\u200b",
}
DRAWN = ("lines", "zero", "formula", "long", "wide", "private")  # what a picture could stumble over


def scene(name: str) -> hf.Scene:
    """Two cubes on each other, both with such a name."""
    upper = f"{name}'s" if len(name) < 499 else "upper"
    cubes = [box(name, (0.1, 0.1, 0.1), 1, (0, 0, 0.05)), box(upper, (0.05, 0.05, 0.05), 0.5, (0, 0, 0.125))]
    return hf.Scene([floor(), *cubes], 0.5, name=name)


@pytest.fixture(params=NAMES)
def name(request: pytest.FixtureRequest) -> str:
    return NAMES[request.param]


@pytest.fixture
def file(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    hf.save_scene(scene(name), "s.json")
    return "s.json"


def assert_harmless(text: str) -> None:
    """Nothing but printable characters and the ends of lines."""
    assert "".join(text.split("\n")).isprintable()


def test_d2_d7_the_terminal_shows_names_as_they_are(name: str, file: str, call: Call) -> None:
    for command in ("assess", "transport", "disassemble", "build"):
        code, out, err = call(command, file, "--engine", "limit")
        assert code == 0, err
        assert_harmless(out)
        assert err == ""
        if command == "assess" and len(name) < 20 and name.isprintable():
            assert name in out


def test_d6_d21_pictures_and_pages(name: str, file: str, call: Call) -> None:
    drawn = ["--png", "m.png"] * (name in (NAMES[each] for each in DRAWN))
    code, out, err = call("map", file, "--engine", "graph", "--spacing", "0.05", *drawn, "--html", "m.html")
    assert code == 0, err
    assert_harmless(out)
    assert not drawn or Path("m.png").read_bytes().startswith(b"\x89PNG")
    text = Path("m.html").read_text(encoding="utf-8")
    hovers = said(data_of(text))
    assert hovers
    allowed = re.compile(r"</?b>|<br>")
    for hover in hovers:
        assert "<" not in allowed.sub("", hover)
        assert html.unescape(allowed.sub("", hover)).isprintable()
    head = text.split("<script")[0]
    assert head.count("<img") == head.count("<i>") == 0
    assert head.count("<b>") == 0


def test_d2_every_command_for_itself(name: str, file: str, call: Call) -> None:
    """Errors, JSON and files with such names, too."""
    code, out, _ = call("assess", file, "--engine", "limit", "--json")
    assert (code, json.loads(out)["details"]["scene"]) == (0, name)
    assert out.isascii()
    code, _, err = call("map", file, "--bodies", f"{name}?", "--engine", "limit")
    assert code == 2
    assert_harmless(err)
    assert err.count("\n") == 1
    assert call("convert", file, "t.yaml")[0] == 0
    assert hf.load_scene("t.yaml") == hf.load_scene(file)


def test_d2_reports_are_no_markup_on_any_console(name: str) -> None:
    """Whoever prints a report on a console of their own gets the same."""
    assembly = hf.assemble(scene(name))
    reports = [
        stability_report(assembly, hf.stability(assembly, engine="limit")),
        map_report(hf.robustness_map(assembly, spacing=0.05, engine="graph")),
        transport_report(hf.transport_limits(assembly, engine="limit")),
        carried_report(hf.carry(assembly, "road", engine="limit")),
    ]
    for report in reports:
        stream = io.StringIO()
        Console(file=stream, width=200).print(report)
        assert_harmless(stream.getvalue())
        if len(name) < 20 and name.isprintable():
            assert name in stream.getvalue()


def test_d7_summaries_reasons_and_notes_of_answers(name: str) -> None:
    falls = hf.Scene([floor(), *scene(name).movable, box("far", (0.1, 0.1, 0.1), 1, (5, 5, 5))], 0.5)
    answer = hf.stability(falls, engine="limit")
    assert_harmless(repr(answer))
    assert_harmless(answer.reason)
    page = answer._repr_html_()
    assert_harmless(page)
    assert "<img" not in page
    assert "<script" not in page
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sunk = [body.moved(np.diag([1.0, 1, 1, 1])) for body in scene(name).movable[:1]]
        hf.assemble(hf.Scene([floor(), *sunk], 0.5))
    assert caught
    for warning in caught:
        assert_harmless(str(warning.message))


def test_d6_the_widest_names_leave_room_for_the_answer(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    hf.save_scene(scene("x" * 500), "s.json")
    _, out, _ = call("assess", "s.json", "--engine", "limit")
    assert "14.7" in out


def test_d15_names_of_files_that_are_no_text(call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """File names are bytes, and Python gives those that are not UTF-8 as lone surrogates."""
    monkeypatch.chdir(tmp_path)
    odd = b"s\xff.yaml".decode("utf-8", "surrogateescape")
    hf.save_scene(scene("a"), odd)
    code, _, err = call("assess", odd, "--engine", "limit")
    assert (code, err) == (0, "")
    code, out, err = call("convert", odd, odd.replace("s", "t"))
    assert (code, out, err) == (0, "wrote t\\udcff.yaml: 3 bodies, 2 movable\n", "")
    code, _, err = call("assess", "no" + odd)
    assert (code, err) == (2, "error: nos\\udcff.yaml: no such scene file; check the path\n")
