"""MuJoCo's rules on which geoms may touch, and with which friction.

An explicit ``<pair>`` overrides everything. Otherwise two geoms may touch if the contype of one and the conaffinity of
the other have a bit in common and no ``<exclude>`` names their bodies; the friction is that of the geom of higher
priority, or the larger one if both priorities are equal, and likewise the dimension of the contact. One of dimension 1
has none.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.scene.formats.mjcf.mjcf_names import entries
from holdfast.scene.formats.mjcf.mjcf_shapes import kind_of

OVERRIDE = 1 << 0  # mjENBL_OVERRIDE: one friction for all
NO_CONTACT = (1 << 0) | (1 << 4)  # mjDSBL_CONSTRAINT, mjDSBL_CONTACT
FRICTIONLESS = 1  # condim


class Rules:
    """The geoms of a model, in classes with the same rules.

    ``of`` (ngeom,) is the class of each geom. ``mu`` (C, C) is the friction between two classes, ``may`` (C, C) whether
    they may touch, and ``named`` (C, C) whether a ``<pair>`` says so. ``materials`` are the names of the classes; two
    that differ in what they may touch alone have one. ``sliding`` says that a pair has two coefficients, of which the
    smaller one is taken.
    """

    def __init__(self, model: Any) -> None:  # noqa: ANN401 - MuJoCo has no types
        ends = np.column_stack([model.pair_geom1, model.pair_geom2]).astype(np.int64).reshape(-1, 2)
        own = np.zeros(int(model.ngeom), dtype=np.int64)
        own[ends.ravel()] = ends.ravel() + 1  # a geom of an explicit pair is a class by itself
        rows = np.column_stack(
            [
                np.asarray(model.geom_priority, dtype=np.float64),
                model.geom_condim,
                np.asarray(model.geom_friction).reshape(-1, 3)[:, 0],
                model.geom_contype,
                model.geom_conaffinity,
                own,
            ]
        )
        classes, of = np.unique(rows, axis=0, return_inverse=True)
        self.of: Int = np.asarray(of).ravel()
        self.mu, self.may = _mixed(classes, model)
        self.named: Bool = np.zeros(self.may.shape, dtype=bool)
        self.sliding = False
        signs = np.asarray(model.exclude_signature, dtype=np.int64)  # two body numbers in one integer
        low, high = np.minimum(signs >> 16, signs & 0xFFFF), np.maximum(signs >> 16, signs & 0xFFFF)
        self._excluded: Int = (low << 16) + high
        for (g, h), friction, dim in zip(ends.tolist(), model.pair_friction, model.pair_dim, strict=True):
            self._name(int(self.of[g]), int(self.of[h]), np.asarray(friction), int(dim))
        if model.opt.disableflags & NO_CONTACT:
            self.may[:], self.named[:] = False, False
        self.names = entries(model, "geom", int(model.ngeom))
        self.materials = _materials(classes, model, self.names)
        self.body: Int = np.asarray(model.geom_bodyid, dtype=np.int64)

    def _name(self, a: int, b: int, friction: Float, dim: int) -> None:
        """Set what an explicit pair gives."""
        self.mu[[a, b], [b, a]] = 0.0 if dim == FRICTIONLESS else float(friction[:2].min())
        self.may[[a, b], [b, a]] = self.named[[a, b], [b, a]] = True
        self.sliding |= dim != FRICTIONLESS and bool(friction[0] != friction[1])

    @property
    def colliding(self) -> Bool:
        """Which geoms (ngeom,) may touch at least one other geom."""
        return np.asarray(np.any(self.may, axis=1), dtype=bool)[self.of]

    @property
    def all_may(self) -> bool:
        """Whether all geoms that collide may touch each other."""
        used = np.unique(self.of[self.colliding])
        return not len(self._excluded) and bool(self.may[np.ix_(used, used)].all())

    def touching(self, a: Sequence[int], b: Sequence[int]) -> Bool:
        """Whether each of the geoms ``a`` may touch each of the geoms ``b``, as (len(a), len(b))."""
        g, h = np.asarray(a, dtype=np.int64)[:, None], np.asarray(b, dtype=np.int64)[None]
        first, second = self.of[g], self.of[h]
        low, high = np.minimum(self.body[g], self.body[h]), np.maximum(self.body[g], self.body[h])
        apart = np.isin((low << 16) + high, self._excluded)
        return np.asarray(self.named[first, second] | (self.may[first, second] & ~apart))

    def table(self, geoms: Sequence[int]) -> dict[tuple[str, str], float]:
        """Return the friction between the materials of some geoms, pair by pair."""
        used = np.unique(self.of[list(geoms)]).tolist()
        entries_ = ((self.materials[a], self.materials[b], float(self.mu[a, b])) for a in used for b in used)
        return {(min(a, b), max(a, b)): mu for a, b, mu in entries_}


def _mixed(classes: Float, model: Any) -> tuple[Float, Bool]:  # noqa: ANN401
    """Return the friction between classes of geoms and whether they may touch, without explicit pairs."""
    priority, dim, friction = (classes[:, k] for k in range(3))
    first, second = priority[:, None] > priority[None], priority[:, None] < priority[None]

    def chosen(values: Float) -> Float:
        larger = np.maximum(values[:, None], values[None])
        return np.where(first, values[:, None], np.where(second, values[None], larger))

    mu = chosen(friction)
    if model.opt.enableflags & OVERRIDE:
        mu = np.full_like(mu, float(model.opt.o_friction[0]))
    kind, affine = classes[:, 3].astype(np.int64), classes[:, 4].astype(np.int64)
    may = ((kind[:, None] & affine[None]) | (kind[None] & affine[:, None])) != 0
    return np.where(chosen(dim) == FRICTIONLESS, 0.0, mu), may


def _materials(classes: Float, model: Any, geoms: Sequence[str]) -> list[str]:  # noqa: ANN401
    """Return the name of each class as a material: what distinguishes its friction from that of others."""
    taken = {*entries(model, "body", int(model.nbody)), *geoms}
    result = []
    for priority, dim, friction, _, _, own in classes.tolist():
        name = f"friction {friction!r}" + (f", priority {int(priority)}" if priority else "")
        name += ", condim 1" if dim == FRICTIONLESS else ""
        if own:
            g = int(own) - 1
            name = f"geom {geoms[g] or f'{kind_of(model, g)} {g}'} of a pair"
        while name in taken:
            name += "'"
        result.append(name)
    return result
