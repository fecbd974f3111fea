"""Workers that do what scene files say, which takes no time."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest


@pytest.fixture(scope="module")
def drill() -> Iterator[None]:
    """Let workers, here and in processes of their own, do what the files say."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("holdfast.batches.workers.ANSWERED_BY", "batch_drill:answered")
        known = filter(None, [os.environ.get("PYTHONPATH")])
        patch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parent), *known]))
        yield
