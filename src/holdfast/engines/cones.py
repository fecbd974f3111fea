"""Friction cones as rows of a cone program: exact, or polygons inside or around it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from scipy import sparse

from holdfast.assembly.nodes import ContactNodes
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.conic.program import ConeKind

ConeChoice = Literal["exact", "inscribed", "circumscribed"]


@dataclass(frozen=True)
class FrictionCone:
    """How |f_t| <= μ f_n is stated: the exact cone, or a polygon of ``sides`` inside it (cautious) or around it."""

    kind: ConeChoice = "exact"
    sides: int = 8

    def __post_init__(self) -> None:
        if self.kind not in get_args(ConeChoice):
            raise HoldfastError(message("cone", f"got {self.kind!r}", f"known: {', '.join(get_args(ConeChoice))}"))
        if not isinstance(self.sides, int | np.integer) or self.sides < 3:
            raise HoldfastError(message("cone", f"sides = {self.sides!r}", "needs a whole number of at least 3"))

    def rows(self, nodes: ContactNodes) -> tuple[sparse.csr_matrix, tuple[tuple[ConeKind, int], ...]]:
        """Rows C (m, 3I) and cones such that -C f in the cones states friction at every node.

        In order: f_t = 0 of nodes without friction, f_n >= 0 of those, then the cones (μ f_n, f_t) of the others.
        """
        count = len(nodes)
        smooth, rough = np.flatnonzero(nodes.mu == 0), np.flatnonzero(nodes.mu > 0)
        unit = -sparse.eye(3 * count, format="csr")
        tangential = unit[np.sort(np.r_[3 * smooth + 1, 3 * smooth + 2])]
        free: list[tuple[ConeKind, int]] = [("zero", 2 * len(smooth)), ("nonnegative", len(smooth))]
        if self.kind == "exact":
            scale = np.ones((count, 3))
            scale[:, 0] = nodes.mu
            friction = sparse.csr_matrix(-sparse.diags(scale.ravel()))[(3 * rough[:, None] + np.arange(3)).ravel()]
            held: list[tuple[ConeKind, int]] = [("second_order", 3)] * len(rough)
        else:
            friction = self._polygon(nodes, rough)
            held = [("nonnegative", friction.shape[0])]
        rows = sparse.csr_matrix(sparse.vstack([tangential, unit[3 * smooth], friction]))
        return rows, tuple((kind, size) for kind, size in (*free, *held) if size)

    @property
    def corner(self) -> float:
        """The largest |f_t| / (μ f_n) that it allows."""
        return 1 / np.cos(np.pi / self.sides) if self.kind == "circumscribed" else 1.0

    def resistance(self, mu: Float, sliding: Float) -> Float:
        """(I,) the most that friction at f_n = 1 can do against a sliding velocity (I, 2): μ |u_t|, or at a corner."""
        if self.kind == "exact":
            return np.asarray(mu * np.linalg.norm(sliding, axis=1))
        angle = 2 * np.pi * (np.arange(self.sides) + 0.5) / self.sides
        corners = self.corner * np.column_stack([np.cos(angle), np.sin(angle)])
        return np.asarray(mu * (sliding @ corners.T).max(axis=1, initial=0))

    def _polygon(self, nodes: ContactNodes, rough: np.ndarray[tuple[int], np.dtype[np.intp]]) -> sparse.csr_matrix:
        """Rows cos θ f_t1 + sin θ f_t2 - μ' f_n <= 0; μ' = μ cos(π/N) puts the polygon's corners on the circle."""
        angle = 2 * np.pi * np.arange(self.sides) / self.sides
        shrink = np.cos(np.pi / self.sides) if self.kind == "inscribed" else 1.0
        block = np.empty((len(rough), self.sides, 3))
        block[:, :, 0] = -shrink * nodes.mu[rough][:, None]
        block[:, :, 1], block[:, :, 2] = np.cos(angle), np.sin(angle)
        rows = np.broadcast_to(np.arange(len(rough) * self.sides)[:, None], (len(rough) * self.sides, 3))
        columns = np.broadcast_to(3 * rough[:, None, None] + np.arange(3), block.shape)
        shape = (len(rough) * self.sides, 3 * len(nodes))
        return sparse.csr_matrix((block.ravel(), (rows.ravel(), columns.ravel())), shape=shape)


EXACT = FrictionCone()
