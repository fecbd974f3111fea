"""COLLADA (.dae): the triangles of its scene, in metres. Materials, lights, cameras and animations are not looked for.

Programs disagree on files whose up axis is not z: RViz, MoveIt and Gazebo ignore the axis, others rotate the mesh. So
such files are refused, unless the caller says which axis is up.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.errors import SceneError
from holdfast.base.rigid import transform
from holdfast.base.text import quoted
from holdfast.scene.xml import Element, parsed

MOST_TRIANGLES = 5_000_000  # repeated nodes within repeated nodes can multiply a small file
MOST_NODES = 100_000  # largest number of nodes, each counted as often as it is used
DEEPEST = 50  # levels of nodes

OVERLOOKED = ("lines", "linestrips", "extra", "source", "vertices")
REFUSED = ("instance_controller", "lookat", "skew")


def read(content: bytes, *, any_up: bool = False) -> tuple[Float, Int]:
    """Return the vertices [m] and triangles of a COLLADA file, at the places of its scene.

    Raises ValueError, with the line, if something is missing or not supported, or if the up axis is not z, unless
    ``any_up`` says that the caller knows it.
    """
    try:
        root = parsed(content.decode("utf-8-sig"), Path("line"))
        with np.errstate(
            over="ignore", invalid="ignore"
        ):  # infinite numbers raise an error when a mesh is made of them
            return _Document(root).triangles(any_up)
    except SceneError as cause:
        raise ValueError(str(cause)) from cause


class _Document:
    """A file with its elements by their ids; references outside the file are refused."""

    def __init__(self, root: Element) -> None:
        self.root = root
        self.known: dict[str, Element] = {}
        self.shapes: dict[int, tuple[Float, Int]] = {}
        self.nodes = 0
        waiting = [root]
        while waiting:
            element = waiting.pop()
            if "id" in element.attributes:
                self.known.setdefault(element.attributes["id"], element)
            waiting += element.children

    def triangles(self, any_up: bool) -> tuple[Float, Int]:
        if self.root.tag != "COLLADA":
            self.root.fail("is not <COLLADA>", "needs a COLLADA file")
        asset = self.root.needed("asset")
        if not any_up:
            given = asset.child("up_axis")
            if given is None or given.text.strip() != "Z_UP":
                said = "says no <up_axis>, which means Y_UP" if given is None else f"says {quoted(given.text.strip())}"
                remedy = 'programs disagree whether to turn it: say up_axis="y" to turn it, or "z" to take it as it is'
                (asset if given is None else given).fail(said, remedy)
        unit = asset.child("unit")
        metres = 1.0 if unit is None else unit.number("meter", 1.0)
        scene = self._referred(self.root.needed("scene").needed("instance_visual_scene"), "visual_scene")
        vertices, faces = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)]
        known = count = 0
        for matrix, geometry in self._placed(scene, np.eye(4), 0):
            if id(geometry) not in self.shapes:
                self.shapes[id(geometry)] = self._shape(geometry)
            corners, triangles = self.shapes[id(geometry)]
            if np.linalg.det(matrix[:3, :3]) < 0:
                triangles = triangles[:, ::-1]  # a mirror would turn the mesh inside out
            vertices.append(transform(matrix, corners))
            faces.append(known + triangles)
            known += len(corners)
            count += len(triangles)
            if count > MOST_TRIANGLES:
                geometry.fail(f"stands more than {MOST_TRIANGLES:,} triangles", "simplify the mesh")
        return metres * np.concatenate(vertices), np.concatenate(faces)

    def _referred(self, element: Element, tag: str) -> Element:
        """Return the element of this file to which another one refers."""
        url = element.attribute("url")
        if not url.startswith("#"):
            element.fail(f"names another file, {quoted(url)}", "put everything into one")
        found = self.known.get(url[1:])
        if found is None or found.tag != tag:
            element.fail(f"refers to {quoted(url)}", f"needs a <{tag}> of this file")
        return found

    def _placed(self, node: Element, above: Float, level: int) -> Iterator[tuple[Float, Element]]:
        """Yield the matrix (4, 4) and the geometry of everything below a node."""
        self.nodes += 1
        if level > DEEPEST or self.nodes > MOST_NODES:
            node.fail(f"is below {level} others, or one of many", f"the limits are {DEEPEST} and {MOST_NODES:,} nodes")
        matrix = above
        for child in node.children:
            match child.tag:
                case "node":
                    yield from self._placed(child, matrix, level + 1)
                case "instance_node":
                    yield from self._placed(self._referred(child, "node"), matrix, level + 1)
                case "instance_geometry":
                    yield matrix, self._referred(child, "geometry")
                case tag if tag in REFUSED:
                    child.fail("is not read", "apply it in the program that wrote the file")
                case _:
                    matrix = matrix @ _step(child)

    def _shape(self, geometry: Element) -> tuple[Float, Int]:
        """Return the vertices (V, 3) in the units of the file and the triangles (F, 3) of a geometry."""
        mesh = geometry.needed("mesh")
        vertices, faces, known = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], 0
        for primitive in mesh.children:
            if primitive.tag in OVERLOOKED:
                continue
            inputs = [each for each in primitive.all("input") if each.attribute("semantic") == "VERTEX"]
            if len(inputs) != 1:
                primitive.fail(f"has {len(inputs)} inputs VERTEX", "needs one")
            width = 1 + max(_whole(each, "offset") for each in primitive.all("input"))
            vertices.append(self._positions(inputs[0]))
            faces.append(known + _faces(primitive, width, _whole(inputs[0], "offset"), len(vertices[-1])))
            known += len(vertices[-1])
        return np.concatenate(vertices), np.concatenate(faces)

    def _positions(self, given: Element) -> Float:
        """Return the vertices (V, 3) that an input VERTEX refers to."""
        vertices = self._source(given, "vertices")
        named = [each for each in vertices.all("input") if each.attribute("semantic") == "POSITION"]
        if len(named) != 1:
            vertices.fail(f"has {len(named)} inputs POSITION", "needs one")
        source = self._source(named[0], "source")
        numbers, accessor = source.needed("float_array"), source.needed("technique_common").needed("accessor")
        values = _numbers(numbers)
        stride, offset, count = (_whole(accessor, name, d) for name, d in (("stride", 1), ("offset", 0), ("count", 0)))
        if stride < 3 or offset + count * stride > len(values):
            accessor.fail(f"reads {count} rows of {stride} from {len(values)} numbers", "check the file")
        return values[offset : offset + count * stride].reshape(count, stride)[:, :3]

    def _source(self, element: Element, tag: str) -> Element:
        found = self.known.get(element.attribute("source").removeprefix("#"))
        if found is None or found.tag != tag:
            element.fail(f"refers to {quoted(element.attribute('source'))}", f"needs a <{tag}> of this file")
        return found


def _step(child: Element) -> Float:
    """Return the matrix (4, 4) of one transformation of a node, or the identity for any other element."""
    step = np.eye(4)
    match child.tag:
        case "matrix":
            return np.array(child.values(16)).reshape(4, 4)
        case "translate":
            step[:3, 3] = child.values(3)
        case "scale":
            step[:3, :3] = np.diag(child.values(3))
        case "rotate":
            *axis, angle = child.values(4)
            length = float(np.linalg.norm(axis))
            if not length > 0:
                child.fail("turns about a zero axis", "needs a direction")
            from scipy.spatial.transform import Rotation  # only here, as it takes a tenth of a second

            step[:3, :3] = Rotation.from_rotvec(np.radians(angle) * np.array(axis) / length).as_matrix()
    return step


def _faces(primitive: Element, width: int, offset: int, known: int) -> Int:
    """Return the triangles (F, 3) of a primitive; faces of more corners are split into fans."""
    rows = [_indices(each) for each in primitive.all("p")]
    for row in rows:
        if len(row) % width:
            primitive.fail(f"has {len(row)} indices", f"needs a multiple of {width}")
    corners = [row.reshape(-1, width)[:, offset] for row in rows]
    match primitive.tag:
        case "triangles":
            faces = [_cut(primitive, row, np.full(len(row) // 3, 3)) for row in corners]
        case "polylist":
            faces = [_cut(primitive, row, _indices(primitive.needed("vcount"))) for row in corners]
        case "polygons" if not primitive.all("ph"):
            faces = [_cut(primitive, row, np.array([len(row)])) for row in corners]
        case _:
            primitive.fail("is not read", "reads triangles, polylist, and polygons without holes")
    found = np.concatenate([np.empty((0, 3), dtype=np.int64), *faces])
    if len(found) and (found.min() < 0 or found.max() >= known):
        primitive.fail(f"names vertex {found.max()} of {known}", "they count from 0")
    return found


def _cut(primitive: Element, corners: Int, counts: Int) -> Int:
    """Return the triangles (F, 3) of polygons with ``counts`` corners each, which are listed in ``corners``."""
    if counts.sum() != len(corners) or (len(counts) and counts.min() < 3):
        primitive.fail(f"has {len(corners)} corners", f"needs faces of at least 3, {counts.sum()} in all")
    starts = np.cumsum(counts) - counts
    first = np.repeat(starts, counts - 2)
    number = np.arange(len(first)) - np.repeat(np.cumsum(counts - 2) - (counts - 2), counts - 2)
    return np.asarray(corners[np.column_stack([first, first + number + 1, first + number + 2])])


def _numbers(element: Element) -> Float:
    try:
        return np.array(element.text.split(), dtype=np.float64)
    except ValueError:
        return element.fail("holds something that is no number", "check the file")


def _indices(element: Element) -> Int:
    numbers = _numbers(element)
    if len(numbers) and not (numbers == np.floor(numbers)).all():
        element.fail("holds something that is no whole number", "check the file")
    return numbers.clip(-1, 1e15).astype(np.int64)


def _whole(element: Element, name: str, default: int = 0) -> int:
    value = element.number(name, float(default))
    if value != int(value) or not 0 <= value < 1e9:
        element.fail(f"{name} = {value:g}", "needs a whole number from 0")
    return int(value)
