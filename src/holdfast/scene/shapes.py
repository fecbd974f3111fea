"""Shapes of bodies, each with a triangle surface in the body frame and with mass properties at unit density."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple, Never
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, Int, checked, checked_number, checked_sizes, checked_whole, frozen
from holdfast.base.errors import GeometryError, message, warn
from holdfast.base.files import checked_path
from holdfast.base.memory import Memory
from holdfast.base.public import Record, column
from holdfast.base.ranges import LENGTH, PLACE, SCALE, TOLERANCE
from holdfast.base.text import quoted
from holdfast.geometry.hull import search_tree
from holdfast.geometry.hygiene import MeshReport, PlaneFit, cleaned
from holdfast.geometry.planes import flattened
from holdfast.geometry.surface import Surface
from holdfast.geometry.triangles import SMOOTH
from holdfast.scene.meshes.read import triangles_of

if TYPE_CHECKING:
    import trimesh


MOST_TRIANGLES = 200_000  # of all models that are kept
SHARED = ("topology", "facets", "curved", "sharp_edges")  # properties of surfaces that do not depend on sizes
FINEST = 1e-6  # least detail, relative to the size, of a surface that is surely reduced like its model: 100 STRAIGHT
LEAST_VOLUME = 1e-9  # least volume of a solid, relative to its bounding box


class _UnitModel(NamedTuple):
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


def _modelled(surface: Surface) -> _UnitModel:
    few = surface.reduced
    if few is surface:
        return _UnitModel(surface, None)
    return _UnitModel(surface, np.asarray(search_tree(surface.vertices).query(few.vertices)[1]))


class MassProperties(Record):
    """The mass properties of a shape at unit density, in the body frame.

    These are the volume [m³], the centre of mass (3,) [m] and the inertia (3, 3) [m⁵] about the centre of mass.
    """

    volume: float
    com: Float = column("3")
    inertia: Float = column("3 3")


class Box(Record):
    """A cuboid centred on the origin of its frame; ``size`` (3,) [m] holds its edge lengths along x, y and z.

    Raises GeometryError if a length is not positive, or if the lengths are not given together: Box((0.3, 0.2, 0.1)).
    """

    size: Float = column("3")

    def __init__(self, size: ArrayLike, *lengths: Never) -> None:
        if lengths or isinstance(size, int | float):
            together = ", ".join(map(str, (size, *lengths))) if len(lengths) == 2 else "x, y, z"
            problem = f"got {quoted((size, *lengths) if lengths else size, 60)}"
            raise GeometryError(message("Box", problem, f"give the three edge lengths together: Box(({together}))"))
        object.__setattr__(self, "size", checked_sizes(size, (3,), "Box: size", LENGTH, GeometryError))

    @cached_property
    def surface(self) -> Surface:
        """The surface of the cuboid, with eight vertices and twelve triangles."""
        return Surface.of_box(self.size, np.zeros(3)).shared()

    @cached_property
    def mass_properties(self) -> MassProperties:
        """The exact mass properties of the cuboid."""
        volume = float(self.size.prod())
        squares = self.size**2
        return MassProperties(volume, np.zeros(3), np.diag(squares.sum() - squares) * volume / 12)


class Cylinder(Record):
    """A cylinder about the z axis, centred on the origin of its frame; ``radius`` and ``height`` are in metres.

    Its side touches flat faces, sharp edges and corners, balls, capsules and other cylinders where the true cylinder
    does. All its other contacts are those of an inscribed prism with ``segments`` sides, whose end faces are smaller by
    a share of 2π²/(3 segments²); with ten segments or fewer, it is that prism in all contacts. The mass properties are
    those of the true cylinder. Raises GeometryError if a length is not positive, or if ``segments`` is not between 3
    and 10,000.
    """

    radius: float
    height: float
    segments: int = 64

    def __post_init__(self) -> None:
        for name in ("radius", "height"):
            value = checked_number(
                getattr(self, name), f"Cylinder: {name}", above=0, within=LENGTH, error=GeometryError
            )
            object.__setattr__(self, name, value)
        object.__setattr__(
            self, "segments", checked_whole(self.segments, "Cylinder: segments", 3, 10_000, GeometryError)
        )

    @cached_property
    def surface(self) -> Surface:
        """The surface of the inscribed prism."""
        n = self.segments
        surface = _prism(self.radius, self.height, n).shared()
        if 2 * np.pi / n >= SMOOTH:
            return surface
        return tessellated(surface, ("cylinder", n), lambda: _prism(1, 2, n), min(surface.sagitta, self.height))

    @cached_property
    def mass_properties(self) -> MassProperties:
        """The exact mass properties of the true cylinder."""
        r2, h2 = self.radius**2, self.height**2
        volume = np.pi * r2 * self.height
        return MassProperties(volume, np.zeros(3), volume * np.diag([r2 / 4 + h2 / 12, r2 / 4 + h2 / 12, r2 / 2]))


class Sphere(Record):
    """A ball centred on the origin of its frame; ``radius`` is in metres.

    It touches flat faces, sharp edges and corners, capsules, the sides of cylinders and other balls where the true ball
    does. All its other contacts are those of an inscribed icosahedron that is subdivided ``subdivisions`` times. The
    mass properties are those of the true ball. Raises GeometryError if the radius is not positive, or if
    ``subdivisions`` is not between 0 and 6.

    For example:

    >>> ball = hf.Sphere(0.02)
    >>> round(hf.Body("ball", ball, density=1000).mass, 4)  # 4/3 π r³ · 1000 kg
    0.0335
    """

    radius: float
    subdivisions: int = 3

    def __post_init__(self) -> None:
        radius = checked_number(self.radius, "Sphere: radius", above=0, within=LENGTH, error=GeometryError)
        object.__setattr__(self, "radius", radius)
        object.__setattr__(
            self, "subdivisions", checked_whole(self.subdivisions, "Sphere: subdivisions", 0, 6, GeometryError)
        )

    @cached_property
    def surface(self) -> Surface:
        """The surface of the subdivided icosahedron, with 20 · 4^subdivisions triangles."""
        ball = _unit_ball(self.subdivisions)
        surface = Surface(self.radius * ball.vertices, ball.faces, self.radius * ball.sagitta).shared()
        return tessellated(surface, ("ball", self.subdivisions), lambda: ball, surface.sagitta)

    @cached_property
    def mass_properties(self) -> MassProperties:
        """The exact mass properties of the true ball."""
        volume = 4 / 3 * np.pi * self.radius**3
        return MassProperties(volume, np.zeros(3), np.eye(3) * 0.4 * volume * self.radius**2)


def _prism(radius: float, height: float, n: int) -> Surface:
    """Return the surface of a prism with ``n`` sides about the z axis; its ends are fans of triangles."""
    angle = 2 * np.pi * np.arange(n) / n
    ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(n)])
    half = np.array([0, 0, height / 2])
    vertices = np.vstack([ring - half, ring + half, [-half], [half]])
    i = np.arange(n)
    j = (i + 1) % n
    sides = np.vstack([np.column_stack([i, j, j + n]), np.column_stack([i, j + n, i + n])])
    caps = np.vstack(
        [np.column_stack([np.full(n, 2 * n), j, i]), np.column_stack([np.full(n, 2 * n + 1), i + n, j + n])]
    )
    return Surface(vertices, np.vstack([sides, caps]).astype(np.int64), radius * (1 - float(np.cos(np.pi / n))))


@cache
def _unit_ball(subdivisions: int) -> Surface:
    """Return an icosahedron with corners at distance 1, and with points halfway subdivided this often."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=1.0)
    sagitta = 1 - float(np.linalg.norm(ball.triangles_center, axis=1).min())
    return Surface(np.array(ball.vertices), np.array(ball.faces, dtype=np.int64), sagitta)


@dataclass(frozen=True, eq=False)
class _Cleaned:
    """A repaired mesh, with a report on the repair."""

    solid: trimesh.Trimesh
    report: MeshReport


_IN_USE: WeakValueDictionary[tuple[bytes, bytes], _Cleaned] = WeakValueDictionary()


class Mesh(Record):
    """A triangle mesh with ``vertices`` (V, 3) [m] and ``faces`` (F, 3), in the body frame.

    Each face holds three indices into ``vertices``, counter-clockwise when seen from outside. ``file`` and ``scale``
    record the file from which the mesh was read, so that a saved scene can refer to it; ``vertices`` are already
    scaled. Closed parts that touch or overlap are one solid, in which common volume counts once.

    ``noise`` [m] is the standard deviation of the vertices of a scanned mesh. Regions that are flat to within the noise
    are made flat before contacts are detected; ``report`` lists them with their residuals. ``label`` is the name of the
    mesh in error messages. Two meshes with the same vertices, faces and noise are equal, whatever their files.

    Raises GeometryError if there are no triangles or a face has an invalid index. ``Body`` and ``Part`` take a
    trimesh.Trimesh as it is.

    For example:

    >>> corners = [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)]
    >>> wedge = hf.Mesh(corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
    >>> round(hf.Body("wedge", wedge, density=1000).mass, 4)  # 0.1³ / 6 · 1000 kg
    0.1667
    """

    vertices: Float = column("V 3")
    faces: Int = column("F 3")
    file: Path | None = field(compare=False)
    scale: tuple[float, float, float] = field(compare=False)
    noise: float
    label: str = field(compare=False, repr=False)

    def __init__(
        self,
        vertices: ArrayLike,
        faces: ArrayLike = (),
        file: Path | None = None,
        scale: tuple[float, float, float] = (1.0, 1.0, 1.0),
        noise: float = 0.0,
        label: str = "Mesh",
    ) -> None:
        if hasattr(vertices, "vertices") and hasattr(vertices, "faces"):
            remedy = "give it to Body or Part as it is, or write Mesh(mesh.vertices, mesh.faces)"
            raise GeometryError(message(label, f"got a {type(vertices).__name__}", remedy))
        set_ = object.__setattr__
        set_(self, "noise", checked_number(noise, f"{label}: noise", minimum=0, within=TOLERANCE, error=GeometryError))
        corners = checked(vertices, (None, 3), f"{label}: vertices", within=PLACE, error=GeometryError)
        numbers = checked(faces, (None, 3), f"{label}: faces", error=GeometryError)
        if len(numbers) == 0 or len(corners) == 0:
            raise GeometryError(message(label, "has no triangles", "needs a surface with at least four"))
        extent = float(np.ptp(corners, axis=0).max())
        if extent < LENGTH.least:
            problem = f"is {extent:g} m across"
            raise GeometryError(message(label, problem, f"needs a size {LENGTH}: are its units metres?"))
        wrong = numbers[(numbers < 0) | (numbers >= len(corners)) | (numbers != np.floor(numbers))]
        if len(wrong):
            problem = f"a face names vertex {wrong[0]:g} of {len(corners)}"
            raise GeometryError(message(label, problem, "needs indices into vertices, whole numbers from 0"))
        set_(self, "vertices", corners)
        set_(self, "faces", frozen(numbers.astype(np.int64)))
        sx, sy, sz = checked_sizes(scale, (3,), f"{label}: scale", SCALE, GeometryError).tolist()
        set_(self, "file", None if file is None else checked_path(file, f"{label}: file"))
        set_(self, "scale", (sx, sy, sz))
        set_(self, "label", label)

    @classmethod
    def from_file(
        cls,
        path: str | Path,
        *,
        scale: float | tuple[float, float, float] = 1.0,
        noise: float = 0.0,
        up_axis: Literal["y", "z"] | None = None,
    ) -> Mesh:
        """Read a mesh from an OBJ, STL, PLY, GLB, OFF or DAE file; all pieces of the file become one mesh.

        ``scale`` is one factor or three, applied to the coordinates in the file; those of a DAE file are in metres
        already, by its own unit. ``up_axis`` is the axis of the file that points up: with "y" everything is turned
        about x before it is scaled, so that y is z; "z" says so of a DAE file that says otherwise. Then the mesh refers
        to no file. Raises GeometryError if the file cannot be read.
        """
        path = checked_path(path, "mesh file")
        given = [scale] * 3 if isinstance(scale, int | float) else scale
        factors = checked_sizes(given, (3,), f"{path}: scale", SCALE, GeometryError)
        corners, triangles = triangles_of(path, up_axis)
        if up_axis is not None:
            return cls(corners * factors, triangles, noise=noise, label=str(path))
        sx, sy, sz = (float(f) for f in factors)
        return cls(corners * factors, triangles, path, (sx, sy, sz), noise, label=str(path))

    @cached_property
    def _cleaned(self) -> _Cleaned:
        key = self.vertices.tobytes(), self.faces.tobytes()
        known = _IN_USE.get(key)  # fifty tins with the same mesh are cleaned once, whatever files they come from
        if known is None:
            known = _IN_USE[key] = _Cleaned(*cleaned(self.vertices, self.faces, self.label))
        if not known.report.oriented:
            problem = "which side of its triangles is the inside cannot be told"
            text = message(self.label, problem, "close it, or wind its faces alike: contacts may be missed")
            warn(text)
        return known

    @property
    def _solid(self) -> trimesh.Trimesh:
        return self._cleaned.solid

    @cached_property
    def report(self) -> MeshReport:
        """A report on the mesh as it was given and on how it was repaired."""
        return replace(self._cleaned.report, planes=self._flattened[1])

    @property
    def is_closed(self) -> bool:
        """Whether the surface bounds a volume."""
        report = self._cleaned.report
        return report.closed and report.oriented

    @cached_property
    def _flattened(self) -> tuple[Surface, tuple[PlaneFit, ...]]:
        vertices = np.array(self._solid.vertices, dtype=np.float64)
        faces = np.array(self._solid.faces, dtype=np.int64)
        surface = Surface(vertices, faces, oriented=self._cleaned.report.oriented)
        return flattened(surface, self.noise) if self.noise else (surface, ())

    @cached_property
    def surface(self) -> Surface:
        """The mesh with duplicate vertices merged and closed parts that touch or overlap joined to one solid.

        If ``noise`` is given, its flat regions are made flat.
        """
        return self._flattened[0].shared()

    @cached_property
    @np.errstate(all="ignore")  # trimesh warns of what is flat before it is refused
    def mass_properties(self) -> MassProperties:
        """The mass properties of the enclosed volume; raises GeometryError if the mesh does not enclose one."""
        if not self.is_closed:
            remedy = 'give mass=, com= (and inertia=), a closed mesh or, where a file is read, collision="hull"'
            problem = f"is not watertight, so its volume is unknown ({self._cleaned.report})"
            raise GeometryError(message(self.label, problem, remedy))
        solid = self._solid
        if not float(solid.volume) > LEAST_VOLUME * float(np.prod(solid.extents.clip(1e-300))):
            problem = f"encloses a volume of {float(solid.volume):.3g} m³"
            raise GeometryError(message(self.label, problem, "needs a solid: check for flat or inside-out pieces"))
        return enclosed(solid)


def enclosed(solid: trimesh.Trimesh) -> MassProperties:
    """Return the mass properties of the volume that a closed surface encloses, by integrals over its triangles."""
    with np.errstate(all="ignore"):  # trimesh warns of triangles without area and of extreme sizes
        return MassProperties(
            float(solid.volume), np.array(solid.center_mass), np.array(solid.moment_inertia) / solid.density
        )
