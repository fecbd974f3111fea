"""The recipes for conda and containers ask for what pyproject.toml asks for."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import holdfast

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CONDA = (ROOT / "packaging" / "conda" / "meta.yaml").read_text(encoding="utf-8")


def test_conda_asks_for_the_same_packages() -> None:
    (listed,) = re.findall(r"  run:\n((?:    - .*\n)+)", CONDA)
    asked = {line.strip("- ").replace(" ", "").lower() for line in listed.splitlines()}
    assert asked == {need.lower() for need in PROJECT["dependencies"]} | {f"python{PROJECT['requires-python']}"}
    assert f'version = "{holdfast.__version__}"' in CONDA
    assert holdfast.__version__ == PROJECT["version"]


def test_the_container_copies_what_there_is() -> None:
    recipe = (ROOT / "packaging" / "Containerfile").read_text(encoding="utf-8")
    for line in re.findall(r"^COPY (.*)$", recipe, re.MULTILINE):
        for name in line.split()[:-1]:
            assert (ROOT / name).exists(), name
    (extras,) = re.findall(r"/source\[([\w,]+)\]", recipe)
    assert set(extras.split(",")) <= PROJECT["optional-dependencies"].keys()
