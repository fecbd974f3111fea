"""Every documented idiom runs; ``mypy`` checks the same lines."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from types import FunctionType

import idioms
import pytest

IDIOMS = {name: f for name, f in vars(idioms).items() if isinstance(f, FunctionType) and f.__module__ == "idioms"}


@pytest.mark.parametrize("name", IDIOMS)
def test_an_idiom_runs(name: str, tmp_path: Path) -> None:
    idiom: Callable[..., object] = IDIOMS[name]
    assert (idiom(tmp_path) if inspect.signature(idiom).parameters else idiom()) is not None
