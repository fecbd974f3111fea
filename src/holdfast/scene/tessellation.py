"""Tessellations of round shapes: how their triangles join does not depend on sizes, and is found out once for all."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Int
from holdfast.base.memory import Memory
from holdfast.geometry.spatial import search_tree
from holdfast.geometry.surface import Surface

MOST_TRIANGLES = 200_000  # of all models that are kept
SHARED = ("topology", "facets", "curved", "sharp_edges")  # properties of surfaces that do not depend on sizes
FINEST = 1e-6  # least detail, relative to the size, of a surface that is surely reduced like its model: 100 STRAIGHT


class _Model(NamedTuple):
    """A tessellation of unit size, and the vertices (V,) that its reduction keeps, if that is another surface."""

    surface: Surface
    kept: Int | None


_MODELS = Memory(MOST_TRIANGLES)


def tessellated(surface: Surface, kind: Hashable, model: Callable[[], Surface], detail: float) -> Surface:
    """Return ``surface`` with what a ``model`` of the same ``kind`` says of its edges and flat faces (SHARED).

    The model has the same faces, with the same normals up to rounding. ``detail`` [m] is the least length in the
    surface, by which a vertex stands out or two are apart: a surface too fine for its size is reduced by itself.
    """
    known = surface.__dict__
    if "reduced" in known or detail < FINEST * surface.diagonal:
        return surface
    same = _MODELS.recalled(kind, len(surface.faces), lambda: _modelled(model()))
    known.update({name: getattr(same.surface, name) for name in SHARED})
    if same.kept is None:
        known["reduced"] = surface
        return surface
    few = same.surface.reduced
    known["reduced"] = reduced = Surface(surface.vertices[same.kept], few.faces, surface.sagitta)
    reduced.__dict__.update({name: getattr(few, name) for name in SHARED})
    return surface


def _modelled(surface: Surface) -> _Model:
    few = surface.reduced
    if few is surface:
        return _Model(surface, None)
    return _Model(surface, np.asarray(search_tree(surface.vertices).query(few.vertices)[1]))
