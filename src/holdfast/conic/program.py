"""A cone program as a value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from scipy import sparse

from holdfast.arrays import Float

ConeKind = Literal["zero", "nonnegative", "second_order"]


@dataclass(frozen=True, eq=False)
class ConeProgram:
    """minimise ½ xᵀP x + qᵀx  subject to  A x + s = b,  s in the product of ``cones`` (kind, dimension), in row order.

    P (n, n) symmetric, q (n,), A (m, n), b (m,).
    """

    P: sparse.csc_matrix
    q: Float
    A: sparse.csc_matrix
    b: Float
    cones: tuple[tuple[ConeKind, int], ...]
