"""Random numbers that reach over many magnitudes, and the seed of every input."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

Rng = np.random.Generator
T = TypeVar("T")

KINDS = ("scene", "file", "name")


def rng_of(seed: int, kind: str, number: int) -> Rng:
    """Return the random numbers of one input; they depend on nothing else."""
    return np.random.default_rng([seed, KINDS.index(kind), number])


def spread(rng: Rng, low: float, high: float) -> float:
    """Draw a number whose logarithm is uniform, with six digits, so that a reproduction can be read."""
    return float(f"{np.exp(rng.uniform(np.log(low), np.log(high))):.6g}")


def one_of(rng: Rng, things: Sequence[T]) -> T:
    return things[int(rng.integers(len(things)))]


def chance(rng: Rng, share: float) -> bool:
    return bool(rng.random() < share)
