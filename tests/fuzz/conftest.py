"""One worker for all tests of a process: it takes seconds to start."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from fuzz.keeper import Keeper


@pytest.fixture(scope="session")
def trier() -> Iterator[Keeper]:
    """A keeper with the limits of a campaign."""
    with Keeper() as made:
        yield made
