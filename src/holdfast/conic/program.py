"""The data of a cone program."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Literal

import numpy as np
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

    def to_json(self) -> str:
        """Return the program as JSON text that keeps every digit, so that it can be solved again elsewhere."""
        matrices = {
            name: {
                "shape": list(m.shape),
                "data": m.data.tolist(),
                "indices": m.indices.tolist(),
                "indptr": m.indptr.tolist(),
            }
            for name, m in (("P", sparse.csc_matrix(self.P)), ("A", sparse.csc_matrix(self.A)))
        }
        vectors = {"q": self.q.tolist(), "b": self.b.tolist()}
        return json.dumps({**matrices, **vectors, "cones": [list(cone) for cone in self.cones]}, allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> ConeProgram:
        """Return the program that ``to_json`` wrote."""
        data = json.loads(text)
        P, A = (
            sparse.csc_matrix((np.array(m["data"], dtype=float), m["indices"], m["indptr"]), shape=m["shape"])
            for m in (data["P"], data["A"])
        )
        cones = tuple((kind, size) for kind, size in data["cones"])
        return cls(P, np.array(data["q"], dtype=float), A, np.array(data["b"], dtype=float), cones)
