"""Sparse matrices made of their entries at once.

SciPy's products with diagonals, stacks and conversions take some twenty to a hundred microseconds each, whatever the
size, and small scenes are asked about often. Here rows, columns and values are worked on as plain arrays.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse

from holdfast.base.arrays import Bool, Float, Int


class Entries(NamedTuple):
    """The ``values`` (n,) of a matrix at its ``rows`` and ``columns`` (n,), no place twice; others are zero."""

    rows: Int
    columns: Int
    values: Float

    @classmethod
    def of(cls, matrix: Float | sparse.csc_matrix | sparse.csr_matrix) -> Entries:
        """Return the entries of a matrix that are not zero."""
        if isinstance(matrix, np.ndarray):
            columns, rows = np.nonzero(matrix.T)
            return cls(rows, columns, matrix[rows, columns])
        major = np.repeat(np.arange(len(matrix.indptr) - 1), np.diff(matrix.indptr))
        minor = matrix.indices.astype(np.int64)
        rows, columns = (minor, major) if matrix.format == "csc" else (major, minor)
        return cls(rows, columns, matrix.data).stored

    def below(self, count: int) -> Entries:
        """Return the same entries ``count`` rows further down."""
        return Entries(self.rows + count, self.columns, self.values)

    def scaled(self, rows: Float, columns: Float | None = None) -> Entries:
        """Return the entries times factors of their ``rows`` and, if given, of their ``columns``."""
        values = rows[self.rows] * self.values
        return Entries(self.rows, self.columns, values if columns is None else values * columns[self.columns])

    @property
    def stored(self) -> Entries:
        """The entries that are not zero: solvers take time for the others, too."""
        kept = np.flatnonzero(self.values)
        if len(kept) == len(self.values):
            return self
        return Entries(self.rows[kept], self.columns[kept], self.values[kept])

    def within(self, rows: Bool) -> Entries:
        """Return the entries in these ``rows``, which are numbered anew."""
        kept = rows[self.rows]
        return Entries((np.cumsum(rows) - 1)[self.rows[kept]], self.columns[kept], self.values[kept])

    def matrix(self, shape: tuple[int, int]) -> sparse.csc_matrix:
        """Return the matrix by columns, each with its rows in order."""
        order = np.lexsort((self.rows, self.columns))
        starts = np.concatenate([[0], np.cumsum(np.bincount(self.columns, minlength=shape[1]))])
        return sparse.csc_matrix((self.values[order], self.rows[order], starts), shape=shape)


def together(*parts: Entries) -> Entries:
    """Return the entries of all parts."""
    return Entries(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def diagonal(values: Float) -> sparse.csc_matrix:
    """Return the square matrix with these ``values`` (n,) on its diagonal."""
    count = len(values)
    return sparse.csc_matrix((values, np.arange(count), np.arange(count + 1)), shape=(count, count))
