"""The command line for all tests of this folder."""

from __future__ import annotations

import pytest
from calling import Call, called


@pytest.fixture
def call(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Call:
    """``holdfast`` with these arguments."""
    return lambda *arguments: called(monkeypatch, capsys, *arguments)
