"""The geoms of a MuJoCo model: their shapes, which of them may touch, and with which friction.

An explicit ``<pair>`` overrides everything. Otherwise two geoms may touch if the contype of one and the conaffinity of
the other have a bit in common and no ``<exclude>`` names their bodies; the friction is that of the geom of higher
priority, or the larger one if both priorities are equal, and likewise the dimension of the contact. One of dimension 1
has none.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.errors import GeometryError, message
from holdfast.base.rigid import pose_from
from holdfast.scene.compound import Solid
from holdfast.scene.formats.simulators.simulated import cached_shape, hull
from holdfast.scene.round_shapes import Capsule, Ellipsoid
from holdfast.scene.shapes import Box, Cylinder, Mesh, Sphere

OVERRIDE = 1 << 0  # mjENBL_OVERRIDE: one friction for all
NO_CONTACT = (1 << 0) | (1 << 4)  # mjDSBL_CONSTRAINT, mjDSBL_CONTACT
FRICTIONLESS = 1  # condim
PLANE, HFIELD, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH = range(8)  # mjtGeom
KINDS = ("plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh")


def entries(model: Any, kind: str, count: int) -> list[str]:  # noqa: ANN401 - MuJoCo has no types
    """Return the names of all objects of a kind, such as "body" or "geom"; "" for an object without a name."""
    text, starts = bytes(model.names), getattr(model, f"name_{kind}adr")
    return [text[k : text.index(b"\0", k)].decode(errors="replace") for k in starts[:count].tolist()]


class GeomRules:
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
        for (a, b), friction, dim in zip(self.of[ends].tolist(), model.pair_friction, model.pair_dim, strict=True):
            self.mu[[a, b], [b, a]] = 0.0 if dim == FRICTIONLESS else float(friction[:2].min())
            self.may[[a, b], [b, a]] = self.named[[a, b], [b, a]] = True
            self.sliding |= bool(dim != FRICTIONLESS and friction[0] != friction[1])
        if model.opt.disableflags & NO_CONTACT:
            self.may[:], self.named[:] = False, False
        self.names = entries(model, "geom", int(model.ngeom))
        self.materials = _materials(classes, model, self.names)
        self.body: Int = np.asarray(model.geom_bodyid, dtype=np.int64)

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


def pose_of(model: Any, g: int) -> Float:  # noqa: ANN401 - MuJoCo has no types
    """Return the pose (4, 4) of a geom in the frame of its body."""
    return pose_from(np.array(model.geom_pos[g]), np.array(model.geom_quat[g]))


def kind_of(model: Any, g: int) -> str:  # noqa: ANN401
    """Return the name of a geom's type in MJCF."""
    kind = int(model.geom_type[g])
    return KINDS[kind] if kind < len(KINDS) else f"type {kind}"


def solid_of(model: Any, g: int) -> Solid:  # noqa: ANN401
    """Return the shape of a geom other than a plane; raise GeometryError for a type without a shape."""
    kind, size = int(model.geom_type[g]), tuple(np.asarray(model.geom_size[g]).tolist())
    if kind == MESH:
        return hull(_mesh_vertices(model, int(model.geom_dataid[g])))
    if kind == HFIELD:
        field = int(model.geom_dataid[g])
        rows, columns, first = (int(getattr(model, f"hfield_{k}")[field]) for k in ("nrow", "ncol", "adr"))
        heights = np.array(model.hfield_data[first : first + rows * columns], dtype=np.float64)
        return _terrain(heights.tobytes(), rows, columns, tuple(np.asarray(model.hfield_size[field]).tolist()))
    match kind:
        case 2:
            return cached_shape(Sphere, size[0])
        case 3:
            return cached_shape(Capsule, size[0], 2 * size[1])
        case 4:
            return cached_shape(Ellipsoid, size)
        case 5:
            return cached_shape(Cylinder, size[0], 2 * size[1])
        case 6:
            return cached_shape(Box, (2 * size[0], 2 * size[1], 2 * size[2]))
    problem = "is a signed distance field" if kind == len(KINDS) else f"is of type {kind}"
    raise GeometryError(message("geom", problem, f"needs one of {', '.join(KINDS)}"))


def _mesh_vertices(model: Any, mesh: int) -> Float:  # noqa: ANN401
    """Return the vertices (n, 3) [m] of the convex hull of a mesh from MuJoCo; all vertices if there is no hull."""
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    vertices = np.array(model.mesh_vert[first : first + count], dtype=np.float64)
    graph = int(model.mesh_graphadr[mesh])
    if graph < 0:
        return vertices
    number = int(model.mesh_graph[graph])
    corners = graph + 2 + number  # skips the counts of vertices and faces, and the start of each vertex's edges
    return np.array(vertices[model.mesh_graph[corners : corners + number]])


@lru_cache(16)
def _terrain(heights: bytes, rows: int, columns: int, size: tuple[float, float, float, float]) -> Mesh:
    """Return the solid below a height field; ``size`` holds its half extents along x and y, its height and its base."""
    across, along, rise, base = size
    x, y = np.meshgrid(np.linspace(-across, across, columns), np.linspace(-along, along, rows))
    top = np.column_stack([x.ravel(), y.ravel(), rise * np.frombuffer(heights)])
    vertices = np.vstack([top, np.column_stack([top[:, :2], np.full(len(top), -base)])])
    grid = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1])
    above = np.vstack([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    rim = np.concatenate([grid[0], grid[1:, -1], grid[-1, -2::-1], grid[-2:0:-1, 0]])
    after, low = np.roll(rim, -1), grid.size
    sides = [np.column_stack([rim, rim + low, after + low]), np.column_stack([rim, after + low, after])]
    faces = np.asarray(np.vstack([above, above[:, ::-1] + low, *sides]), dtype=np.int64)
    return Mesh(vertices, faces, label="hfield")
