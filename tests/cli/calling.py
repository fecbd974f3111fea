"""The command line as a user calls it, within this process."""

from __future__ import annotations

import sys

import pytest

from holdfast.cli.main import run


def called(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *arguments: object
) -> tuple[int, str, str]:
    """The exit code of `holdfast` with these arguments, and what it printed to stdout and stderr."""
    monkeypatch.setattr(sys, "argv", ["holdfast", *map(str, arguments)])
    with pytest.raises(SystemExit) as stopped:
        run()
    out, err = capsys.readouterr()
    code = stopped.value.code
    return code if isinstance(code, int) else 0 if code is None else 1, out, err
