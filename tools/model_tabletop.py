"""Model the tabletop scene: write its five meshes and its scene file.

The scene follows the idea of Fig. 1 of Nadeau & Kelly: a wine bottle in a precarious position, books, a mug and a
tray on a table. Everything is modelled here from a few dimensions, with no randomness, so that running the script
again reproduces the files::

    python tools/model_tabletop.py [FOLDER]

Lengths are in metres, z points up, every mesh rests on the plane z = 0 of its own frame, and surfaces of revolution
have the z axis as their axis. The formats written differ on purpose (OBJ, STL, PLY, GLB and OFF). Three of them hold
single-precision numbers, so the heights at which bodies touch (`BOOK_THICKNESS`, `TRAY_FLOOR`) are dyadic fractions,
which single precision holds exactly.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import manifold3d
import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.exchange.obj import export_obj
from trimesh.exchange.off import export_off
from trimesh.exchange.ply import export_ply
from trimesh.exchange.stl import export_stl

Array = NDArray[np.float64]

SCENE_FOLDER = Path(__file__).resolve().parents[1] / "src" / "holdfast" / "scene" / "shipped" / "tabletop"
SEGMENTS = 48

BOTTLE_BASE_RADIUS = 0.030
BOTTLE_RADIUS = 0.0375
NECK_RADIUS = 0.0145

BOOK_WIDTH = 0.15  # spine (at -x) to fore-edge (at +x)
BOOK_HEIGHT = 0.21  # along y
BOOK_THICKNESS = 1.0 / 32.0
BOOK_BULGE = 0.008  # how far the rounded spine stands out from the flat covers
BOARD = 0.003  # thickness of the covers, and how far they stand out from the page block

MUG_RADIUS = 0.040
MUG_HEIGHT = 0.095
MUG_WALL = 0.0035
MUG_FOOT = (0.024, 0.030)  # inner and outer radius of the annulus on which the mug stands

TRAY_LENGTH, TRAY_WIDTH, TRAY_HEIGHT = 0.36, 0.26, 0.03
TRAY_FLOOR = 3.0 / 512.0
TRAY_FLARE = 0.01  # how far the rim leans outward from the base
TRAY_WALL = 0.006

COASTER_ACROSS_FLATS = 0.1
COASTER_THICKNESS = 0.005
COASTER_CHAMFER = 0.001


# Building blocks


def circle(radius: float, segments: int = SEGMENTS, start: float = 0.0) -> Array:
    """Return the corners of a regular polygon about the origin, counter-clockwise, shape (segments, 2)."""
    angle = start + 2.0 * math.pi * np.arange(segments) / segments
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def arc(centre: tuple[float, float], radii: tuple[float, float], degrees: tuple[float, float], steps: int) -> Array:
    """Return points along an axis-aligned elliptic arc, both ends included, shape (steps + 1, 2)."""
    angle = np.radians(np.linspace(degrees[0], degrees[1], steps + 1))
    return np.column_stack([centre[0] + radii[0] * np.cos(angle), centre[1] + radii[1] * np.sin(angle)])


def rounded_rectangle(length: float, width: float, radius: float, steps: int = 8) -> Array:
    """Return the outline of a rectangle with rounded corners about the origin, counter-clockwise."""
    x, y = 0.5 * length - radius, 0.5 * width - radius
    corners = [((x, y), 0.0), ((-x, y), 90.0), ((-x, -y), 180.0), ((x, -y), 270.0)]
    return np.vstack([arc(centre, (radius, radius), (turn, turn + 90.0), steps) for centre, turn in corners])


def at_height(outline: Array, height: float) -> Array:
    """Lift a planar outline to the given height."""
    return np.column_stack([outline, np.full(len(outline), height)])


def loft(rings: Sequence[Array]) -> trimesh.Trimesh:
    """Skin a sequence of rings of equally many points and close both ends by fans about the rings' centres.

    The rings run counter-clockwise seen from ahead, so the skin of rings which go up, or out along a bottom, faces
    outward; the first fan faces backward and the last one forward.
    """
    count, last = len(rings[0]), len(rings) - 1
    centres = np.array([rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    vertices = np.vstack([*rings, centres])
    here = np.arange(count)
    there = np.roll(here, -1)
    first_centre, last_centre = np.full(count, len(vertices) - 2), np.full(count, len(vertices) - 1)
    faces = [np.column_stack([first_centre, there, here])]
    for k in range(last):
        low, high = k * count, (k + 1) * count
        faces.append(np.column_stack([low + here, low + there, high + there]))
        faces.append(np.column_stack([low + here, high + there, high + here]))
    faces.append(np.column_stack([last_centre, last * count + here, last * count + there]))
    return trimesh.Trimesh(np.round(vertices, 12), np.vstack(faces), process=False)


def revolve(profile: Sequence[tuple[float, float]] | Array) -> trimesh.Trimesh:
    """Turn a profile of (radius, height) points, given from the bottom outward and up, about the z axis."""
    return loft([at_height(circle(float(radius)), float(height)) for radius, height in profile])


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> trimesh.Trimesh:
    """Return the axis-aligned box between two corners."""
    return trimesh.creation.box(bounds=np.array([low, high]))


def solid(mesh: trimesh.Trimesh) -> manifold3d.Manifold:
    """Hand a closed mesh over to manifold3d, in double precision."""
    vertices = np.ascontiguousarray(mesh.vertices, dtype=np.float64)
    faces = np.ascontiguousarray(mesh.faces, dtype=np.uint64)
    return manifold3d.Manifold(manifold3d.Mesh64(vertices, faces))


def mesh_of(body: manifold3d.Manifold) -> trimesh.Trimesh:
    """Take a mesh back from manifold3d, its coordinates rounded to the picometre so that planes stay exact."""
    raw = body.to_mesh64()
    vertices = np.round(np.asarray(raw.vert_properties, dtype=np.float64)[:, :3], 12)
    return trimesh.Trimesh(vertices, np.asarray(raw.tri_verts, dtype=np.int64), process=False)


# The five objects


def model_bottle() -> trimesh.Trimesh:
    """Model a wine bottle, closed and solid, which stands on a flat disc."""
    heel = BOTTLE_RADIUS - BOTTLE_BASE_RADIUS
    waist = 0.5 * (BOTTLE_RADIUS - NECK_RADIUS)
    body = arc((BOTTLE_BASE_RADIUS, heel), (heel, heel), (-90.0, 0.0), 6)
    shoulder = arc((BOTTLE_RADIUS - waist, 0.190), (waist, 0.024), (0.0, 90.0), 8)[:-1]
    throat = arc((NECK_RADIUS + waist, 0.238), (waist, 0.024), (270.0, 180.0), 8)
    lip = [(0.0140, 0.283), (0.0155, 0.284), (0.0155, 0.298), (0.0145, 0.300)]
    return revolve(np.vstack([body, shoulder, throat, lip]))


def model_book() -> trimesh.Trimesh:
    """Model a hardcover book lying on its back cover: flat covers around a smaller page block, and a rounded spine."""
    half, hinge, edge = 0.5 * BOOK_HEIGHT, BOOK_BULGE - 0.5 * BOOK_WIDTH, 0.5 * BOOK_WIDTH
    middle = 0.5 * BOOK_THICKNESS
    radius = (middle**2 + BOOK_BULGE**2) / (2.0 * BOOK_BULGE)
    opening = math.degrees(math.asin(middle / radius))
    spine = arc((middle, hinge - BOOK_BULGE + radius), (radius, radius), (270.0 - opening, 270.0 + opening), 12)
    spine[0], spine[-1] = (0.0, hinge), (BOOK_THICKNESS, hinge)
    outline = np.vstack([spine, [(BOOK_THICKNESS, edge), (0.0, edge)]])  # of (z, x)
    case = loft([at_height(outline, -half), at_height(outline, half)])
    case.vertices = case.vertices[:, [1, 2, 0]]
    top = BOOK_THICKNESS - BOARD
    hollow = box((hinge + BOARD, -half - 0.01, BOARD), (edge + 0.01, half + 0.01, top))
    sunk = 0.001  # the page block is let into the case, so that the two fuse
    pages = box((hinge + BOARD - sunk, BOARD - half, BOARD - sunk), (edge - BOARD, half - BOARD, top + sunk))
    return mesh_of((solid(case) - solid(hollow)) + solid(pages))


def model_handle() -> trimesh.Trimesh:
    """Model the mug's handle as a tube of elliptic section along half an ellipse, both ends inside the cavity."""
    rings = []
    for angle in np.linspace(0.0, math.pi, 25):
        across, along = math.sin(angle), math.cos(angle)
        centre = np.array([0.034 + 0.036 * across, 0.0, 0.051 + 0.028 * along])
        tangent = np.array([0.036 * along, 0.0, -0.028 * across])
        tangent /= np.linalg.norm(tangent)
        side = np.array([0.0, 1.0, 0.0])
        section = circle(1.0, 20)
        rings.append(centre + 0.0065 * section[:, :1] * side + 0.004 * section[:, 1:] * np.cross(tangent, side))
    return loft(rings)


def model_mug() -> trimesh.Trimesh:
    """Model a hollow mug with one handle, which stands on an annular foot around a shallow recess."""
    inner_foot, outer_foot = MUG_FOOT
    heel = arc((outer_foot, 0.012), (MUG_RADIUS - outer_foot, 0.012), (-90.0, 0.0), 8)
    recess = [(inner_foot - 0.0015, 0.0015), (inner_foot, 0.0)]
    rim = [(MUG_RADIUS, MUG_HEIGHT - 0.0008), (MUG_RADIUS - 0.0008, MUG_HEIGHT)]
    outside = revolve(np.vstack([recess, heel, rim]))
    bore = MUG_RADIUS - MUG_WALL
    bowl = arc((bore - 0.012, 0.018), (0.012, 0.012), (-90.0, 0.0), 8)
    mouth = [(bore, MUG_HEIGHT - 0.0008), (bore + 0.0008, MUG_HEIGHT), (bore + 0.0008, MUG_HEIGHT + 0.005)]
    cavity = revolve(np.vstack([bowl, mouth]))
    return mesh_of((solid(outside) + solid(model_handle())) - solid(cavity))


def model_tray() -> trimesh.Trimesh:
    """Model a rectangular serving tray with rounded corners: a flat floor inside a rim which leans outward."""
    base = rounded_rectangle(TRAY_LENGTH - 2.0 * TRAY_FLARE, TRAY_WIDTH - 2.0 * TRAY_FLARE, 0.020)
    brim = rounded_rectangle(TRAY_LENGTH, TRAY_WIDTH, 0.030)
    mouth = rounded_rectangle(TRAY_LENGTH - 2.0 * TRAY_WALL, TRAY_WIDTH - 2.0 * TRAY_WALL, 0.030 - TRAY_WALL)
    inset = 2.0 * (TRAY_FLARE + TRAY_WALL)
    floor = rounded_rectangle(TRAY_LENGTH - inset, TRAY_WIDTH - inset, 0.020 - TRAY_WALL)
    heights = [0.0, TRAY_HEIGHT, TRAY_HEIGHT, TRAY_FLOOR]
    return loft([at_height(ring, z) for ring, z in zip([base, brim, mouth, floor], heights, strict=True)])


def model_coaster() -> trimesh.Trimesh:
    """Model an octagonal coaster with chamfered edges."""
    corner = 1.0 / math.cos(math.pi / 8.0)
    wide, narrow = (
        circle(corner * (0.5 * COASTER_ACROSS_FLATS - inset), 8, math.pi / 8.0) for inset in (0.0, COASTER_CHAMFER)
    )
    top = COASTER_THICKNESS
    levels = [(narrow, 0.0), (wide, COASTER_CHAMFER), (wide, top - COASTER_CHAMFER), (narrow, top)]
    return loft([at_height(ring, z) for ring, z in levels])


# Files


def encode_obj(mesh: trimesh.Trimesh) -> bytes:
    """Encode a mesh as Wavefront OBJ."""
    text = export_obj(mesh, include_normals=False, include_color=False, include_texture=False, header="holdfast")
    return (str(text) + "\n").encode("ascii")


def encode_stl(mesh: trimesh.Trimesh) -> bytes:
    """Encode a mesh as binary STL."""
    return bytes(export_stl(mesh))


def encode_ply(mesh: trimesh.Trimesh) -> bytes:
    """Encode a mesh as binary PLY."""
    return bytes(export_ply(mesh, encoding="binary", vertex_normal=False))


def encode_glb(mesh: trimesh.Trimesh) -> bytes:
    """Encode a mesh as binary glTF; the coordinates are stored as they are, with z up and no node transform."""
    return bytes(trimesh.Scene({"tray": mesh}).export(file_type="glb", include_normals=False))


def encode_off(mesh: trimesh.Trimesh) -> bytes:
    """Encode a mesh as ASCII OFF."""
    return (str(export_off(mesh)).strip() + "\n").encode("ascii")


MESHES: dict[str, tuple[Callable[[], trimesh.Trimesh], Callable[[trimesh.Trimesh], bytes]]] = {
    "bottle.obj": (model_bottle, encode_obj),
    "book.stl": (model_book, encode_stl),
    "mug.ply": (model_mug, encode_ply),
    "tray.glb": (model_tray, encode_glb),
    "coaster.off": (model_coaster, encode_off),
}


def write_mesh(path: Path) -> int:
    """Model, write and read back one mesh; return its number of triangles.

    Raises:
        ValueError: If what is read back is not closed, not consistently wound, or does not rest on z = 0.
    """
    model, encode = MESHES[path.name]
    path.write_bytes(encode(model()))
    mesh = trimesh.load_mesh(path)
    if not (mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0.0 and mesh.bounds[0, 2] == 0.0):
        raise ValueError(f"{path.name} is not a closed, outward-wound mesh resting on z = 0")
    return len(mesh.faces)


# The scene


@dataclass(frozen=True)
class Placed:
    """One movable body: its mesh, mass (kg), material, position (m) and turn about the vertical (degrees)."""

    name: str
    file: str
    mass: float
    material: str
    position: tuple[float, float, float]
    turn: float = 0.0

    def lines(self) -> list[str]:
        """Return the body's entry of the scene file."""
        half = math.radians(0.5 * self.turn)
        quaternion = [round(math.cos(half), 15), 0, 0, round(math.sin(half), 15)]
        entry = [
            f"  - name: {self.name}",
            f"    shape: {{type: mesh, file: {self.file}}}",
            f"    mass: {self.mass}",
            f"    material: {self.material}",
            f"    position: {[round(x, 12) for x in self.position]}",
        ]
        return [*entry, f"    orientation: {quaternion}"] if self.turn else entry


BODIES = [
    Placed("lower_book", "book.stl", 0.7, "cloth", (-0.25, 0.0, 0.0)),
    Placed("upper_book", "book.stl", 0.7, "cloth", (-0.217, 0.01, BOOK_THICKNESS), 90.0),
    Placed("bottle", "bottle.obj", 0.5, "glass", (-0.144, 0.02, 2.0 * BOOK_THICKNESS)),
    Placed("tray", "tray.glb", 0.6, "wood", (0.2, 0.0, 0.0), 8.0),
    Placed("coaster", "coaster.off", 0.03, "cork", (0.12, -0.04, TRAY_FLOOR), 20.0),
    Placed("mug", "mug.ply", 0.35, "ceramic", (0.12, -0.04, TRAY_FLOOR + COASTER_THICKNESS), 40.0),
    Placed("full_bottle", "bottle.obj", 1.2, "glass", (0.28, 0.04, TRAY_FLOOR)),
]

HEADER = """\
# A tabletop after the idea of Fig. 1 of Nadeau & Kelly. Written by tools/model_tabletop.py: change that, not this.
# The bottle stands on the part of the upper book which overhangs the lower one.
format: holdfast-scene/1
name: tabletop
gravity: [0, 0, -9.81]
friction:
  default: 0.4
  pairs:
    - {between: [glass, cloth], mu: 0.3}
    - {between: [lower_book, upper_book], mu: 0.35}
    - {between: [cork, ceramic], mu: 0.5}
    - {between: [cork, wood], mu: 0.5}
bodies:
  - name: table
    shape: {type: box, size: [1.0, 0.7, 0.04]}
    material: wood
    position: [0, 0, -0.02]
    fixed: true
"""


def scene_text() -> str:
    """Return the scene file."""
    return HEADER + "".join(line + "\n" for body in BODIES for line in body.lines())


def main() -> None:
    """Write the meshes and the scene file."""
    parser = argparse.ArgumentParser(description="Model the tabletop scene.")
    parser.add_argument("folder", nargs="?", type=Path, default=SCENE_FOLDER, help="where to write (default: shipped)")
    folder: Path = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    triangles = sum(write_mesh(folder / name) for name in MESHES)
    (folder / "tabletop.yaml").write_text(scene_text(), encoding="utf-8")
    print(f"{len(MESHES)} meshes ({triangles} triangles) and tabletop.yaml written to {folder}")


if __name__ == "__main__":
    main()
