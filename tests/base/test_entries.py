"""Sparse matrices made of their entries, beside SciPy's general ways."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from holdfast.base.arrays import Float
from holdfast.base.entries import Entries, diagonal, together
from holdfast.base.rigid import cross

SHAPE = (7, 5)


def matrix(seed: int) -> Float:
    rng = np.random.default_rng(seed)
    return np.where(rng.random(SHAPE) < 0.4, rng.normal(size=SHAPE), 0.0)


@pytest.mark.parametrize("made", [np.asarray, sparse.csc_matrix, sparse.csr_matrix])
def test_a_matrix_comes_back_from_its_entries_by_columns(made: type) -> None:
    for seed in range(5):
        given = matrix(seed)
        found = Entries.of(made(given)).matrix(SHAPE)
        assert found.format == "csc"
        assert found.has_canonical_format
        assert found.nnz == np.count_nonzero(given)
        np.testing.assert_array_equal(found.toarray(), given)


def test_stored_zeros_are_left_out() -> None:
    stored = sparse.csr_matrix(np.ones(SHAPE))
    stored.data[::2] = 0.0
    assert len(Entries.of(stored).values) == len(stored.data) // 2


def test_factors_rows_and_stacks_are_those_of_products() -> None:
    given, other, rng = matrix(1), matrix(2), np.random.default_rng(3)
    rows, columns, chosen = rng.normal(size=SHAPE[0]), rng.normal(size=SHAPE[1]), rng.random(SHAPE[0]) < 0.5
    scaled = Entries.of(given).scaled(rows, columns)
    np.testing.assert_array_equal(scaled.matrix(SHAPE).toarray(), rows[:, None] * given * columns)
    np.testing.assert_array_equal(
        scaled.within(chosen).matrix((chosen.sum(), SHAPE[1])).toarray(), (rows[:, None] * given * columns)[chosen]
    )
    both = together(Entries.of(given), Entries.of(other).below(SHAPE[0])).matrix((2 * SHAPE[0], SHAPE[1]))
    np.testing.assert_array_equal(both.toarray(), np.vstack([given, other]))
    np.testing.assert_array_equal(diagonal(rows).toarray(), np.diag(rows))


@pytest.mark.parametrize(
    ("a", "b"), [((3,), (3,)), ((4, 3), (4, 3)), ((2, 4, 3), (4, 3)), ((3,), (5, 3)), ((5, 1, 3), (5, 6, 3))]
)
def test_cross_products_are_those_of_numpy_to_the_last_digit(a: tuple[int, ...], b: tuple[int, ...]) -> None:
    rng = np.random.default_rng(0)
    one, other = rng.normal(size=a), rng.normal(size=b)
    np.testing.assert_array_equal(cross(one, other), np.cross(one, other))
    assert cross(one.astype(np.longdouble), other).dtype == np.longdouble
