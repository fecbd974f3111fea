"""The package has one name on indexes; whatever says how to install it uses that name, never another project's."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path

import pytest

from holdfast.base.errors import DISTRIBUTION, installing

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
# `install` or `add`, options, then holdfast without the rest of the name; or holdfast with extras, wherever it stands
STRANGER = re.compile(
    r"""\b(?:install|add|inject)\s+(?:--?\S+\s+)*['"]?holdfast(?![\w.-])|(?<![\w.-])holdfast\\?\[[a-z, ]+\\?\]"""
)


def texts() -> dict[str, str]:
    """The text of every committed file that is text, by its path."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True)
    found = {}
    for name in filter(None, listed.stdout.split("\0")):
        path = ROOT / name
        if path.is_file() and path != Path(__file__):
            content = path.read_bytes()
            if b"\0" not in content:
                found[name] = content.decode("utf-8", errors="ignore")
    return found


def test_nothing_installs_the_project_that_is_called_holdfast() -> None:
    found = texts()
    assert {"README.md", "Makefile", "packaging/Containerfile", "src/holdfast/cli/light_commands.py"} <= found.keys()
    assert {name: match[0] for name, text in found.items() if (match := STRANGER.search(text))} == {}


@pytest.mark.parametrize(
    "text",
    [
        "pip install holdfast",
        "pip install -U 'holdfast[viewer]'",
        'uv add "holdfast"',
        "pipx install holdfast==0.2",
        "the extra `holdfast[live]`",
        r"match=r'holdfast\[live\]'",
    ],
)
def test_a_planted_command_is_found(text: str) -> None:
    assert STRANGER.search(text)


@pytest.mark.parametrize(
    "text",
    [
        installing("viewer"),
        "pip install '.[viewer]', then use the command `holdfast`",
        "pip install holdfast-robotics",
        "install holdfast_robotics-1.0.0-py3-none-any.whl",
        "how to install holdfast-robotics and what holdfast is",
    ],
)
def test_what_is_meant_is_let_through(text: str) -> None:
    assert not STRANGER.search(text)


def test_one_constant_holds_the_name() -> None:
    homes = [name for name, text in texts().items() if name.startswith("src/") and DISTRIBUTION in text]
    assert homes == ["src/holdfast/base/errors.py"]
    assert PROJECT["name"] == DISTRIBUTION
    assert f"name: {DISTRIBUTION}\n" in (ROOT / "packaging" / "conda" / "meta.yaml").read_text(encoding="utf-8")


def test_the_extras_that_remedies_name_exist() -> None:
    named = {
        extra
        for name, text in texts().items()
        if name.startswith("src/")
        for extra in re.findall(r"""\binstalling\(["'](\w+)["']\)""", text)
    }
    assert {"viewer", "tables", "live"} <= named <= PROJECT["optional-dependencies"].keys()
