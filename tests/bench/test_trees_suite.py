"""The even beds that the suite on trees compares with, beside closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from bench.scenes.random_trees import Contact
from bench.suites.trees import Bed

SQUARE = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]) * 0.1
MU, N = 0.4, 7.0


def bed(ring: np.ndarray, *holes: np.ndarray) -> Bed:
    return Bed(Contact([ring], list(holes), 0.0, MU))


def test_an_even_square_turns_at_its_closed_form() -> None:
    torque = MU * N * 0.1 * (np.sqrt(2) + np.arcsinh(1)) / 6
    assert bed(SQUARE).share(np.array([N, 0, 0, 0, 0, torque])) == pytest.approx(1, rel=1e-5)


@pytest.mark.parametrize("left", [0.3, 0.02, 1e-4])
def test_a_strip_turns_about_its_middle(left: float) -> None:
    """Next to tipping a strip three times as wide as what is left presses: a line that turns at μ N a / 4."""
    place = 0.05 - 0.1 * left / 3
    carried = np.array([N, N * place, 0, 0, 0, MU * N * 0.1 / 4])
    assert bed(SQUARE).share(carried) == pytest.approx(1, rel=1e-4 + 4 * left * left)  # it is as wide as 0.1 left


def test_all_friction_along_a_line_and_none_beyond_the_border() -> None:
    ring, hole = SQUARE - 0.05, (SQUARE - 0.05) * 0.8
    level = bed(ring, hole)
    assert level.share(np.array([N, 0.02 * N, 0, 0.5 * MU * N, 0, 0])) < 1
    assert level.share(np.array([N, 0.02 * N, 0, 0, 0.5 * MU * N, 0.5 * MU * N * 0.02])) == pytest.approx(0.5, rel=1e-6)
    assert level.share(np.array([N, 0.0501 * N, 0, 0, 0, 0.1])) == np.inf


def test_triangles_fill_a_ring() -> None:
    triangles = Contact([SQUARE], [0.03 + 0.4 * SQUARE], 0.0, MU).triangles()
    twice = np.abs(np.linalg.det(triangles[:, 1:] - triangles[:, :1])).sum()
    assert twice == pytest.approx(2 * (0.01 - 0.0016), rel=1e-12)
