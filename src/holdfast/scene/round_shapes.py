"""Capsules and ellipsoids, and what they have in common with balls and cylinders.

All of them are ellipsoids swept along a segment of the z axis; the ellipsoid of a cylinder is a disc.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Bool, Float, checked_number, checked_sizes, checked_whole
from holdfast.base.errors import GeometryError
from holdfast.base.public import Record
from holdfast.base.ranges import LENGTH
from holdfast.geometry.surface import Surface
from holdfast.geometry.triangles import SMOOTH
from holdfast.scene.shapes import Cylinder, MassProperties, Sphere, tessellated

LEAST_LEAN = 1e-3  # least sine of the angle between an end of a cylinder and a face at which its rim touches


class Capsule(Record):
    """A cylinder about the z axis with a half ball of the same ``radius`` [m] on either end, centred on its frame.

    ``length`` [m] is the distance between the centres of the half balls, that is, the height of the cylinder alone.
    Contacts with flat faces, sharp edges, balls, ellipsoids, other capsules and the sides of cylinders are exact;
    others are those of an inscribed surface with ``segments`` sides. The mass properties are exact. Raises
    GeometryError if a length is not positive, or if ``segments`` is not a multiple of four up to 1,000.

    For example:

    >>> pill = hf.Capsule(radius=0.01, length=0.03)
    >>> round(hf.Body("pill", pill, density=1000).mass, 4)  # π r² (length + 4/3 r) · 1000 kg
    0.0136
    """

    radius: float
    length: float
    segments: int = 48

    def __post_init__(self) -> None:
        for name in ("radius", "length"):
            value = checked_number(getattr(self, name), f"Capsule: {name}", within=LENGTH, above=0, error=GeometryError)
            object.__setattr__(self, name, value)
        quarter = checked_whole(self.segments, "Capsule: segments", 8, 1_000, error=GeometryError) // 4
        object.__setattr__(self, "segments", 4 * quarter)

    @cached_property
    def surface(self) -> Surface:
        """The inscribed surface: rings of vertices along the meridians, and a pole on either end."""
        n = self.segments
        surface = _inscribed(self.radius, self.length, n)
        return tessellated(surface, ("capsule", n), lambda: _inscribed(1, 1, n), min(surface.sagitta / 2, self.length))

    @cached_property
    def mass_properties(self) -> MassProperties:
        """The exact mass properties of the capsule."""
        r, h = self.radius, self.length
        tube, ball = np.pi * r**2 * h, 4 / 3 * np.pi * r**3
        across = tube * (r**2 / 4 + h**2 / 12) + ball * (0.4 * r**2 + h**2 / 4 + 3 / 8 * h * r)
        return MassProperties(tube + ball, np.zeros(3), np.diag([across, across, tube * r**2 / 2 + ball * 0.4 * r**2]))


def _inscribed(radius: float, length: float, n: int) -> Surface:
    """Return rings of ``n`` vertices along the meridians of a capsule, and a pole on either end."""
    quarter = n // 4
    turn = 2 * np.pi * np.arange(n) / n
    circle = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(n)])
    rise = np.linspace(0, np.pi / 2, quarter + 1)[:-1]
    up = [radius * (np.cos(a) * circle + [0, 0, np.sin(a)]) + [0, 0, length / 2] for a in rise]
    rings = [ring * [1, 1, -1] for ring in up[::-1]] + up
    poles = np.array([[0, 0, -1.0], [0, 0, 1.0]]) * (length / 2 + radius)
    i = np.arange(n)
    j = (i + 1) % n
    low = n * np.arange(len(rings) - 1)[:, None]
    sides = [np.stack([low + i, low + j, low + n + j], -1), np.stack([low + i, low + n + j, low + n + i], -1)]
    last, south = n * (len(rings) - 1), n * len(rings)
    caps = [
        np.column_stack([j, i, np.full(n, south)]),
        np.column_stack([last + i, last + j, np.full(n, south + 1)]),
    ]
    faces = np.vstack([*(side.reshape(-1, 3) for side in sides), *caps]).astype(np.int64)
    sagitta = radius * (1 - float(np.cos(np.pi / n)) ** 2)
    return Surface(np.vstack([*rings, poles]), faces, sagitta)


class Ellipsoid(Record):
    """An ellipsoid along the axes of its frame and centred on it; ``radii`` (3,) [m] are its half axes.

    Contacts with flat faces, sharp edges and other round bodies are exact; others are those of an inscribed surface, an
    icosahedron that is subdivided ``subdivisions`` times. The mass properties are exact. Raises GeometryError if a
    radius is not positive, or if ``subdivisions`` is not between 0 and 6.

    For example:

    >>> egg = hf.Ellipsoid((0.02, 0.02, 0.03))
    >>> round(hf.Body("egg", egg, density=1000).mass, 4)  # 4/3 π a b c · 1000 kg
    0.0503
    """

    radii: Float
    subdivisions: int

    def __init__(self, radii: ArrayLike, subdivisions: int = 3) -> None:
        object.__setattr__(self, "radii", checked_sizes(radii, (3,), "Ellipsoid: radii", LENGTH, GeometryError))
        number = checked_whole(subdivisions, "Ellipsoid: subdivisions", 0, 6, error=GeometryError)
        object.__setattr__(self, "subdivisions", number)

    @cached_property
    def surface(self) -> Surface:
        """The surface of a subdivided icosahedron, stretched."""
        ball = Sphere(1.0, self.subdivisions).surface
        return Surface(ball.vertices * self.radii, ball.faces, ball.sagitta * float(self.radii.max()))

    @cached_property
    def mass_properties(self) -> MassProperties:
        """The exact mass properties of the ellipsoid."""
        volume = 4 / 3 * np.pi * float(self.radii.prod())
        squares = self.radii**2
        return MassProperties(volume, np.zeros(3), np.diag(squares.sum() - squares) * volume / 5)


class Round(NamedTuple):
    """A convex shape without edges on its sides: an ellipsoid with ``radii`` (3,) [m], swept along z.

    It is swept from -``half`` to ``half`` [m]. If the third radius is zero, the ends are flat discs.
    """

    radii: Float
    half: float

    @property
    def has_flat_ends(self) -> bool:
        """Whether the shape is a cylinder."""
        return float(self.radii[2]) == 0

    @property
    def is_swept(self) -> bool:
        """Whether the shape is a ball or a disc swept along its axis."""
        return self.has_flat_ends or bool((self.radii == self.radii[0]).all())

    def spread(self, gap: float, normal: Float) -> float:
        """Return twice the largest distance [m] from a contact with a plane at which the surface is within ``gap`` [m].

        The ``normal`` (3,) of the plane is in the frame of the shape. The rim of a disc that leans by an angle a rises
        from the plane like a circle with the radius of the disc over sin a.
        """
        least, most = float(self.radii.min()), float(self.radii.max())
        flattest = most / max(float(np.hypot(*normal[:2])), LEAST_LEAN) if self.has_flat_ends else most**2 / least
        return 2 * float(np.sqrt(2 * flattest * gap))

    def is_end(self, normals: Float, cos_angle: float) -> Bool:
        """Tell which of ``normals`` (..., 3), in the frame of the shape, are parallel to the axis of flat ends.

        ``cos_angle`` is the cosine of the angle tolerance.
        """
        return np.asarray(self.has_flat_ends & (np.abs(normals[..., 2]) >= cos_angle))


def round_of(shape: object) -> Round | None:
    """Return a ball, cylinder, capsule or ellipsoid as a swept ellipsoid, and None for other shapes.

    A cylinder of so few segments that its sides meet at sharp edges is a prism.
    """
    if isinstance(shape, Sphere):
        return Round(np.full(3, shape.radius), 0.0)
    if isinstance(shape, Capsule):
        return Round(np.full(3, shape.radius), shape.length / 2)
    if isinstance(shape, Ellipsoid):
        return Round(shape.radii, 0.0)
    if isinstance(shape, Cylinder) and 2 * np.pi / shape.segments < SMOOTH:
        return Round(np.array([shape.radius, shape.radius, 0.0]), shape.height / 2)
    return None
