"""What a picture of a robustness map shows, in metres and world coordinates, and its triangles with their colours."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Bool, Float, Int
from holdfast.drawing import colours
from holdfast.drawing.colours import Kind
from holdfast.geometry.triangles import normals_of


@dataclass(frozen=True)
class Solid:
    """A body, or a part of its surface, that is drawn without a value: fixed bodies and covered faces."""

    name: str
    vertices: Float  # (V, 3) world [m]
    triangles: Int  # (T, 3) indices into vertices, outward winding
    fixed: bool


@dataclass(frozen=True)
class HeatSurface:
    """The exposed surface of one body, cut into cells; each cell shows the answer at its query point."""

    name: str
    vertices: Float  # (V, 3) world [m]
    triangles: Int  # (T, 3) indices into vertices, outward winding
    cell: Int  # (T,) index of the triangle's cell, 0..C-1
    points: Float  # (C, 3) query point of each cell, world [m]
    force: Float  # (C,) robustness [N]; inf where no push moves anything
    hover: tuple[str, ...]  # (C,) text shown under the pointer, lines separated by "<br>"
    kinds: Int | None = None  # (C,) what each answer says; None where all forces are known

    @property
    def kind(self) -> Int:
        """The ``Kind`` of the answer of each cell (C,)."""
        return colours.kinds_of(self.force) if self.kinds is None else self.kinds


@dataclass(frozen=True)
class Arrow:
    """An arrow from tail to head (3,) [m], world frame; it acts at its head."""

    tail: Float  # (3,)
    head: Float  # (3,)
    label: str


@dataclass(frozen=True)
class Picture:
    """A robustness map that is ready to draw.

    ``heat`` holds the coloured surfaces and ``solids`` the neutral ones. ``outlines`` are the contact patches as closed
    polylines (k, 3) [m], and ``contact_points`` (m, 3) [m] the contact nodes. ``contact_forces`` are arrows of the
    contact forces at rest, already scaled to metres. ``weakest`` are arrows of the weakest pushes, with their heads at
    the pushed points. ``up`` (3,) is the unit vector opposite to gravity.
    """

    title: str
    subtitle: str
    heat: tuple[HeatSurface, ...]
    solids: tuple[Solid, ...]
    outlines: tuple[Float, ...] = ()
    contact_points: Float = field(default_factory=lambda: np.empty((0, 3)))
    contact_forces: tuple[Arrow, ...] = ()
    weakest: tuple[Arrow, ...] = ()
    up: Float = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    value_name: str = "largest push [N]"


def forces(picture: Picture) -> Float:
    """Return the force [N] of every cell of the picture, (C,) over all surfaces."""
    return np.concatenate([*(surface.force for surface in picture.heat), np.empty(0)])


def kinds(picture: Picture) -> Int:
    """Return the kinds (C,) of the answers of all cells of the picture."""
    return np.concatenate([*(surface.kind for surface in picture.heat), np.empty(0, dtype=np.int64)])


def legend(picture: Picture) -> dict[Kind, str]:
    """Return the names of the kinds of answers in the picture that are not on the scale, for its legend."""
    present = kinds(picture)
    unknown = int((present == Kind.UNDECIDED).sum())
    share = 100 * unknown / max(len(present), 1)
    names = {
        Kind.BALANCED: "moves at the smallest push (only balanced)",
        Kind.FALLS: "falls without a push",
        Kind.UNDECIDED: f"undecided: {unknown:,} of {len(present):,} ({share:.3g} %)",
        Kind.ENDLESS: "no push moves it (∞)",
        Kind.NONE: "no value",
    }
    return {kind: name for kind, name in names.items() if (present == kind).any()}


def heat_points(picture: Picture) -> Float:
    """Return the vertices (N, 3) [m] that must be in view: of the coloured surfaces or, without any, of all bodies."""
    meshes = [surface.vertices for surface in picture.heat] or [solid.vertices for solid in picture.solids]
    points = np.concatenate([*meshes, np.empty((0, 3))])
    return points if len(points) else np.array([[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]])


def size_of(picture: Picture) -> float:
    """Return the diagonal [m] of the box around what the picture shows."""
    return float(np.linalg.norm(np.ptp(heat_points(picture), axis=0))) or 1.0


def ends_of(arrows: Iterable[Arrow]) -> tuple[Float, Float]:
    """Return the tails and the heads (N, 3) [m] of arrows."""
    ends = np.array([(arrow.tail, arrow.head) for arrow in arrows], dtype=float).reshape(-1, 2, 3)
    return ends[:, 0], ends[:, 1]


class Corners(NamedTuple):
    """Corners (N,) of triangles (T, 3), each of one cell: the vertex of the surface and the cell of each corner."""

    vertex: Int
    cell: Int
    triangles: Int


def corners_of(surface: HeatSurface, shown: Bool | None = None) -> Corners:
    """Return the corners of the cells of a surface, or of its ``shown`` (C,) cells.

    Cells share no corners, so that each corner can have the colour and the value of its cell.
    """
    kept = np.ones(len(surface.cell), dtype=bool) if shown is None else shown[surface.cell]
    keys = surface.cell[kept][:, None] * len(surface.vertices) + surface.triangles[kept]
    unique, inverse = np.unique(keys.ravel(), return_inverse=True)
    return Corners(unique % len(surface.vertices), unique // len(surface.vertices), inverse.reshape(-1, 3))


@dataclass(frozen=True)
class Soup:
    """Triangles (T, 3) of vertices (V, 3) [m].

    Each triangle has a colour (T, 3) in 0..1, a unit normal (T, 3) and a body number (T,).
    """

    vertices: Float
    triangles: Int
    rgb: Float
    normals: Float
    body: Int


Part = TypeVar("Part", HeatSurface | Solid, Solid)


def soup_of(parts: Iterable[Part], paint: Callable[[Part], ArrayLike]) -> Soup:
    """Return the triangles of all parts; parts with the same name are one body.

    ``paint`` returns the colour of a part, either (3,) or one for each of its triangles (T, 3).
    """
    vertices, triangles, rgb, body = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], [np.empty((0, 3))], [[0][:0]]
    names: dict[str, int] = {}
    count = 0
    for part in parts:
        vertices.append(part.vertices)
        triangles.append(part.triangles + count)
        rgb.append(np.broadcast_to(np.asarray(paint(part), dtype=float), (len(part.triangles), 3)))
        body.append([names.setdefault(part.name, len(names))] * len(part.triangles))
        count += len(part.vertices)
    points, faces = np.concatenate(vertices), np.concatenate(triangles)
    numbers = np.concatenate([np.asarray(b, dtype=np.int64) for b in body])
    return Soup(points, faces, np.concatenate(rgb), normals_of(points, faces), numbers)


def movable(picture: Picture, scale: colours.Scale | None) -> Soup:
    """Return the coloured surfaces and the covered parts of the same bodies."""
    return soup_of(_movable_parts(picture), lambda part: _rgb(part, scale))


def movable_names(picture: Picture) -> list[str]:
    """Return the names of the bodies of ``movable``, in the order of their numbers."""
    return list(dict.fromkeys(part.name for part in _movable_parts(picture)))


def fixed(picture: Picture) -> Soup:
    """Return the bodies that never move."""
    return soup_of([solid for solid in picture.solids if solid.fixed], lambda part: _rgb(part, None))


def _movable_parts(picture: Picture) -> list[HeatSurface | Solid]:
    return [*picture.heat, *(solid for solid in picture.solids if not solid.fixed)]


def _rgb(part: HeatSurface | Solid, scale: colours.Scale | None) -> ArrayLike:
    if isinstance(part, HeatSurface):
        return colours.colours(scale, part.force, part.kind)[part.cell]
    return colours.FIXED if part.fixed else colours.COVERED
