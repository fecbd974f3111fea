"""The command ``mcp`` before it serves; tests/agents have what it serves."""

from __future__ import annotations

import pytest
from calling import called


def test_without_the_package_the_command_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("holdfast.cli.mcp_command.find_spec", lambda name: None)
    answer = called(monkeypatch, capsys, "mcp")
    assert answer.code == 2
    assert "pip install 'holdfast-robotics[mcp]'" in answer.err


def test_a_folder_that_is_none_is_told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    for option in ("--folder", "--write"):
        answer = called(monkeypatch, capsys, "mcp", option, "nowhere")
        assert (answer.code, answer.out) == (2, "")
        assert f"{option}: 'nowhere' is no folder" in answer.err
