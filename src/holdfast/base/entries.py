"""Sparse matrices as plain arrays of rows, columns and values, which are assembled in one step.

SciPy needs twenty to a hundred microseconds for each scaling, stacking or conversion, however small the matrix. That
would dominate queries on small scenes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse

from holdfast.base.arrays import Bool, Float, Int


class Entries(NamedTuple):
    """The entries of a sparse matrix: ``values`` (n,) at ``rows`` (n,) and ``columns`` (n,), no position twice."""

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
        """Return the entries of diag(rows) · matrix, or of diag(rows) · matrix · diag(columns) if that is given."""
        values = rows[self.rows] * self.values
        return Entries(self.rows, self.columns, values if columns is None else values * columns[self.columns])

    @property
    def stored(self) -> Entries:
        """The entries without explicit zeros, which would cost solvers time."""
        kept = np.flatnonzero(self.values)
        if len(kept) == len(self.values):
            return self
        return Entries(self.rows[kept], self.columns[kept], self.values[kept])

    def within(self, rows: Bool) -> Entries:
        """Return the entries in the rows for which the mask ``rows`` is true; the remaining rows are renumbered."""
        kept = rows[self.rows]
        return Entries((np.cumsum(rows) - 1)[self.rows[kept]], self.columns[kept], self.values[kept])

    def matrix(self, shape: tuple[int, int]) -> sparse.csc_matrix:
        """Return the matrix in compressed column form, with sorted row indices."""
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
