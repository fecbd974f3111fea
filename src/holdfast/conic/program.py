"""The data of a cone program."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from scipy import sparse

from holdfast.base.arrays import Float

ConeKind = Literal["zero", "nonnegative", "second_order"]


@dataclass(frozen=True, eq=False)
class ConeProgram:
    """The cone program: minimise ½ xᵀP x + qᵀx  subject to  A x + s = b,  s in the product of ``cones``.

    P (n, n) is symmetric, q is (n,), A is (m, n) and b is (m,). Each cone is a pair (kind, dimension), in the order of
    the rows of A.
    """

    P: sparse.csc_matrix
    q: Float
    A: sparse.csc_matrix
    b: Float
    cones: tuple[tuple[ConeKind, int], ...]
