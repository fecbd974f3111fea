"""Binary glTF and PLY, read with trimesh after all counts and lengths in the header were checked against the file."""

from __future__ import annotations

import io
import json
import logging
import math
import re
from codecs import BOM_UTF8
from typing import Any, NamedTuple

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.text import quoted
from holdfast.geometry.gltf import BINARY_CHUNK, JSON_CHUNK, MAGIC, container

_QUIET = logging.NullHandler()  # without a handler, Python would print trimesh's tracebacks
LONGEST_HEADER = 100_000  # bytes of a PLY file
END = re.compile(rb"^end_header[ \t]*\r?\n", re.MULTILINE)
BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}  # size of each type of number
PARTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}  # numbers in an item
MOST_JSON = 64_000_000  # bytes
MOST_SHARED = 20  # the views of a file may use each byte this many times on average
MOST_CORNERS = 20_000_000  # largest number of vertices and indices of all instances of all meshes
OF_NODE = 100  # corners that take as much memory as the node of a further primitive
MOST_STEPS = 1_000_000  # largest sum of the depths of all nodes
COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression")
# Beginnings of the names of extensions that look, or that all readers of meshes need
LOOKING = ("KHR_materials_", "KHR_technique", "KHR_texture_", "KHR_lights_", "EXT_texture_", "EXT_lights_",
           "KHR_mesh_quantization", "KHR_xmp", "KHR_animation_", "KHR_draco", "EXT_meshopt")  # fmt: skip
TRIANGLES, STRIP, FAN = 4, 5, 6  # modes of primitives that are surfaces; trimesh leaves out the last


class _Nothing:
    """A resolver that refuses all names: a mesh is a single file, and other files are never opened."""

    file_name = None

    def get(self, name: str) -> bytes:
        raise ValueError(f"names another file, {name!r:.80}: put everything into one")

    __getitem__ = get


class Node(NamedTuple):
    """A named mesh of a scene: its vertices (V, 3) and triangles (F, 3), and the matrix (4, 4) that puts it there.

    ``extras`` is further plain data from the file.
    """

    name: str
    vertices: Float
    faces: Int
    matrix: Float
    extras: Any = None


def nodes_of(scene: Any) -> list[Node]:  # noqa: ANN401 - a trimesh.Scene, whose types are not followed
    """Return the nodes of a trimesh.Scene that hold triangles; lines and points are left out."""
    found = []
    for name in scene.graph.nodes_geometry:
        matrix, geometry = scene.graph[name]
        mesh = scene.geometry[geometry]
        if len(getattr(mesh, "faces", ())):
            vertices, faces = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)
            found.append(Node(str(name), vertices, faces, np.array(matrix, dtype=np.float64)))
    return found


def _scene_of(content: bytes, kind: str) -> Any:  # noqa: ANN401 - a trimesh.Scene, whose types are not followed
    """Return the scene that trimesh reads from the content of a file; raises whatever the parser of the format does."""
    import trimesh

    logging.getLogger("trimesh").addHandler(_QUIET)
    resolver: Any = _Nothing()
    stream = io.BytesIO(content)
    try:
        return trimesh.load_scene(stream, file_type=kind, resolver=resolver, process=False, skip_materials=True)
    except ImportError as cause:  # for text that is not UTF-8, trimesh needs an optional package
        raise ValueError("neither text nor a complete binary file") from cause


def _as_one(scene: Any) -> tuple[Float, Int]:  # noqa: ANN401
    mesh = scene.to_mesh()
    return np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)


def read_ply(content: bytes) -> tuple[Float, Int]:
    """Return the vertices and triangles of a PLY file.

    Raises ValueError if the file is shorter than its header says, or is not a PLY file.
    """
    content = content.removeprefix(BOM_UTF8)
    end = END.search(content, 0, LONGEST_HEADER)
    if not content.startswith(b"ply") or end is None:
        raise ValueError("has no header of a PLY file")
    rows = [line.split() for line in content[: end.start()].decode("latin-1").splitlines()[1:]]
    forms = [words for words in rows if words[:1] == ["format"]]
    # comments may name an image, so they are dropped
    kept = [words for words in rows if words[:1] in (["element"], ["property"])]
    if len(forms) != 1:
        raise ValueError(f"has {len(forms)} rows that say its format")
    counts = _ply_counts(kept)
    body = content[end.end() :]
    text = forms[0][1:2] == ["ascii"]
    held = sum(1 for row in body.split(b"\n") if row.strip()) if text else len(body)
    if sum(counts.values()) > held:
        claimed = " and ".join(f"{count:,} of {quoted(name)}" for name, count in counts.items())
        raise ValueError(f"says {claimed}, and has {held:,} {'rows' if text else 'bytes'}")
    head = "\n".join(" ".join(words) for words in (["ply"], forms[0], *kept, ["end_header"]))
    return _as_one(_scene_of(head.encode() + b"\n" + body, "ply"))


def _ply_counts(rows: list[list[str]]) -> dict[str, int]:
    """Return how many items of each element the header says; every element that has items has properties."""
    counts: dict[str, int] = {}
    described: set[str] = set()
    for words in rows:
        if words[:1] == ["element"]:
            if len(words) != 3 or not (words[2].isascii() and words[2].isdigit()):
                raise ValueError(f"has the header row {quoted(' '.join(words))}")
            counts[words[1]] = int(words[2][:18])
        else:
            described |= set(list(counts)[-1:])
    bare = [name for name, count in counts.items() if count and name not in described]
    if bare:
        raise ValueError(f"does not say what its {quoted(bare[0])} holds")
    return counts


def read_glb(content: bytes) -> tuple[Float, Int]:
    """Return the vertices and triangles of all instances of all meshes of a GLB file.

    Raises ValueError if the file holds less than its header says, needs another file, or is compressed.
    """
    _check(content)
    return _as_one(_scene_of(content, "glb"))


def read_nodes(content: bytes) -> tuple[list[Node], Any, dict[str, Any]]:
    """Return the meshes of the nodes of a GLB file, in its order, the extras of its scene, and its header.

    If several nodes have the same name, a number is appended to all but the first. Raises ValueError like ``read_glb``.
    """
    _check(content)
    whole, binary = _chunks(content)
    header = dict(whole)
    nodes = _maps(header, "nodes")
    names = _distinct([str(node.get("name", number)) for number, node in enumerate(nodes)])
    said = [node.get("extras") for node in nodes]
    owner = _divide(header)
    parts: dict[int, list[Node]] = {}
    for node in sorted(nodes_of(_scene_of(container(header, binary), "glb")), key=lambda node: int(node.name)):
        parts.setdefault(owner[int(node.name)], []).append(node)
    scenes, chosen = _maps(header, "scenes"), header.get("scene", 0)
    about = scenes[chosen].get("extras") if isinstance(chosen, int) and 0 <= chosen < len(scenes) else None
    return [joined(parts[k])._replace(name=names[k], extras=said[k]) for k in sorted(parts)], about, whole


def _divide(header: dict[str, Any]) -> list[int]:
    """Give each surface of a header a mesh of its own, and return the number of the node to which each node belongs.

    trimesh cannot join primitives whose materials it does not read, so all but the first of a mesh go to new children
    of its node. It reserves one name and changes others, so it is given nodes without names, which it numbers.
    """
    divided: list[dict[str, Any]] = []
    of_mesh: list[list[int]] = []
    for mesh in _maps(header, "meshes"):
        primitives = [each for each in _maps(mesh, "primitives") if each.get("mode", TRIANGLES) in (TRIANGLES, STRIP)]
        of_mesh.append(list(range(len(divided), len(divided) + len(primitives))))
        divided += [{"primitives": [each]} for each in primitives]
    nodes = [{key: v for key, v in node.items() if key not in ("name", "extras")} for node in _maps(header, "nodes")]
    owner = list(range(len(nodes)))
    for number, node in enumerate(nodes[:]):
        own = of_mesh[_whole(node, "mesh")] if "mesh" in node else []
        node.pop("mesh", None)
        if own:
            node["mesh"] = own[0]
            node["children"] = [*_list(node, "children"), *range(len(nodes), len(nodes) + len(own) - 1)]
            nodes += [{"mesh": each} for each in own[1:]]
            owner += [number] * (len(own) - 1)
    header["meshes"], header["nodes"] = divided, nodes
    return owner


def joined(parts: list[Node]) -> Node:
    """Return the parts of one node as one mesh."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, starts, strict=False)]
    return parts[0]._replace(vertices=np.concatenate([part.vertices for part in parts]), faces=np.concatenate(faces))


def _distinct(names: list[str]) -> list[str]:
    """Return the names with numbers appended to repeated ones."""
    taken, again, found = set(names), dict.fromkeys(names, 0), []
    for name in names:
        again[name] += 1
        own = name
        while again[name] > 1 and own in taken:
            own = f"{name}_{again[name] - 1}"
            again[name] += own in taken
        taken.add(own)
        found.append(own)
    return found


def _check(content: bytes) -> None:
    header, binary = _chunks(content)
    for name in ("extensionsRequired", "extensionsUsed"):
        for extension in _list(header, name):
            if extension in COMPRESSED:
                raise ValueError(f"is compressed with {extension}: export it without")
    for extension in _list(header, "extensionsRequired"):
        if not str(extension).startswith(LOOKING):
            raise ValueError(f"requires the extension {quoted(extension)}, which is not read: export it without")
    views = _views(header, len(binary))
    accessors = _maps(header, "accessors")
    for part in (part for mesh in _maps(header, "meshes") for part in _maps(mesh, "primitives")):
        if part.get("mode") == FAN:
            raise ValueError("has a fan of triangles: export lists of triangles")
        if "POSITION" in part["attributes"] and accessors[_whole(part["attributes"], "POSITION")].get("normalized"):
            raise ValueError("has positions as fractions of whole numbers: export them as floating-point numbers")
    counts = _counts(header, views, len(content))
    _check_instances(header, counts)


def _chunks(content: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the header and the binary chunk."""
    words = [int.from_bytes(content[k : k + 4], "little") for k in range(0, 20, 4)]
    if content[:4] != MAGIC or len(content) < 20 or words[4] != JSON_CHUNK:
        raise ValueError("has no header of a GLB file")
    if words[1] != 2:
        raise ValueError(f"is of version {words[1]}, not 2")
    end = 20 + words[3]
    if end > len(content) or words[3] > MOST_JSON:
        raise ValueError(f"says a header of {words[3]:,} bytes, and has {len(content):,} in all")
    header = json.loads(content[20:end].decode("utf-8"))
    if not isinstance(header, dict):
        raise ValueError("has a header that is no map")
    binary = b""
    while end + 8 <= len(content):
        length, kind = (int.from_bytes(content[end + k : end + k + 4], "little") for k in (0, 4))
        if end + 8 + length > len(content):
            raise ValueError(f"says a part of {length:,} bytes, and has {len(content) - end - 8:,} left")
        if kind == BINARY_CHUNK:
            binary = content[end + 8 : end + 8 + length]
        end += 8 + length
    return header, binary


def _views(header: dict[str, Any], binary: int) -> list[int]:
    """Return the lengths [bytes] of the views, which together use the file at most MOST_SHARED times."""
    for number, buffer in enumerate(_maps(header, "buffers")):
        if "uri" in buffer or number:
            raise ValueError("keeps its numbers in another file: export it as one")
    lengths = []
    for number, view in enumerate(_maps(header, "bufferViews")):
        start, length = _whole(view, "byteOffset", 0), _whole(view, "byteLength")
        if _whole(view, "buffer") != 0 or start + length > binary:
            raise ValueError(f"view {number} ends at byte {start + length:,} of {binary:,}")
        lengths.append(length)
    if sum(lengths) > MOST_SHARED * binary:
        raise ValueError(f"has views of {sum(lengths):,} bytes, and holds {binary:,}")
    return lengths


def _counts(header: dict[str, Any], views: list[int], size: int) -> list[int]:
    """Return the number of items of every accessor; all their bytes are in the views."""
    counts, total = [], 0
    strides = [_whole(view, "byteStride", 0) for view in _maps(header, "bufferViews")]
    for number, accessor in enumerate(_maps(header, "accessors")):
        count = _whole(accessor, "count")
        item = BYTES[_whole(accessor, "componentType")] * PARTS[str(accessor.get("type"))]
        if "sparse" in accessor or "bufferView" not in accessor:
            raise ValueError(f"accessor {number} says {count:,} items, and no bytes for them: export them in full")
        view = _whole(accessor, "bufferView")
        stride = strides[view] or item
        needed = _whole(accessor, "byteOffset", 0) + (stride * (count - 1) + item if count else 0)
        if stride < item or needed > views[view]:
            raise ValueError(f"accessor {number} says {count:,} items, {needed:,} bytes, of {views[view]:,}")
        total += count * item
        counts.append(count)
    if total > MOST_SHARED * size:
        raise ValueError(f"has items of {total:,} bytes, and holds {size:,}")
    return counts


def _check_instances(header: dict[str, Any], counts: list[int]) -> None:
    """Raise ValueError if a small file would become a huge mesh because its parts are used many times."""
    corners = []
    for mesh in _maps(header, "meshes"):
        parts = _maps(mesh, "primitives")
        of_parts = [
            counts[_whole(part["attributes"], "POSITION")] for part in parts if "POSITION" in part["attributes"]
        ]
        of_indices = sum(counts[_whole(part, "indices")] for part in parts if "indices" in part)
        corners.append(max(OF_NODE * (len(parts) - 1), sum(of_parts) + of_indices))
    nodes = _maps(header, "nodes")
    total = sum(corners) + sum(corners[_whole(node, "mesh")] for node in nodes if "mesh" in node)
    if total > MOST_CORNERS:
        raise ValueError(f"has {total:,} corners with all instances, of {MOST_CORNERS:,} that are read")
    for node in nodes:
        for name in ("matrix", "translation", "rotation", "scale"):
            if not all(isinstance(v, int | float) and math.isfinite(v) for v in _list(node, name)):
                raise ValueError(f"a node has the {name} {quoted(node[name])}")
    _check_depth(nodes)


def _check_depth(nodes: list[dict[str, Any]]) -> None:
    """Raise ValueError if a node has two parents or is its own ancestor, or if the tree is very deep."""
    parent: dict[int, int] = {}
    for number, node in enumerate(nodes):
        for child in _list(node, "children"):
            if not isinstance(child, int) or not 0 <= child < len(nodes) or child in parent:
                raise ValueError(f"node {quoted(child)} is not there, or has two parents")
            parent[child] = number
    depth = dict.fromkeys(set(range(len(nodes))) - set(parent), 1)
    level = list(depth)
    while level:
        level = [child for number in level for child in _list(nodes[number], "children")]
        depth |= dict.fromkeys(level, 0)
        for child in level:
            depth[child] = depth[parent[child]] + 1
    if len(depth) < len(nodes):
        raise ValueError("has nodes that are their own ancestors")
    if sum(depth.values()) > MOST_STEPS:
        raise ValueError(f"has {len(nodes):,} nodes, up to {max(depth.values()):,} below each other")


def _list(data: dict[str, Any], name: str) -> list[Any]:
    value = data.get(name, [])
    if not isinstance(value, list):
        raise ValueError(f"{name} is no list")
    return value


def _maps(data: dict[str, Any], name: str) -> list[dict[str, Any]]:
    value = _list(data, name)
    if not all(isinstance(item, dict) for item in value):
        raise ValueError(f"{name} holds what is no map")
    return value


def _whole(data: dict[str, Any], name: str, default: int | None = None) -> int:
    value = data.get(name, default)
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise ValueError(f"{name} is {quoted(value)}, not a whole number from 0")
    return value
