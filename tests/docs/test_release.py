"""What `make release-check` looks at beside the tests: versions, and the links of the built site."""

from __future__ import annotations

from pathlib import Path

import pytest
import release_check


def test_one_version_of_a_release_stands_in_every_place() -> None:
    assert list(release_check.versions()) == []


def test_versions_that_differ_are_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for place in release_check.PLACES:
        text = (release_check.ROOT / place).read_text(encoding="utf-8")
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / place).write_text(text.replace("version: ", "version: 7.") if place.endswith("cff") else text)
    monkeypatch.setattr(release_check, "ROOT", tmp_path)
    assert any("versions differ" in fault for fault in release_check.versions())
    (tmp_path / "pyproject.toml").write_text("nothing")
    assert any("pyproject.toml: no version" in fault for fault in release_check.versions())


def test_dead_links_are_found(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "index.html").write_text('<h1 id="top"><a href="sub/a.html#here">a</a><img src="no.png"></h1>')
    (tmp_path / "sub" / "a.html").write_text(
        '<p id="here"><a href="../index.html">up</a> <a href="https://example.org/x">out</a> <a href="#gone">x</a></p>'
    )
    assert list(release_check.dead_links(tmp_path)) == ["index.html: no.png", "sub/a.html: #gone"]
    assert list(release_check.dead_links(tmp_path / "none"))
