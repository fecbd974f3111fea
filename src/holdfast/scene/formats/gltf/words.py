"""The words of a glTF file that its reader does not know."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from holdfast.scene.formats.gltf.extras import KEY
from holdfast.scene.formats.rigid_parts import unknown_keys
from holdfast.scene.meshes.glb import LOOKING

# What glTF has for each kind of its objects; what only looks or moves is ignored
KEYS = {
    "asset": ("version", "generator", "copyright", "minVersion", "extras"),
    "scenes": ("nodes", "name"),
    "nodes": ("mesh", "name", "children", "matrix", "translation", "rotation", "scale", "camera", "weights"),
    "meshes": ("primitives", "weights", "name", "extras"),
    "primitives": ("attributes", "indices", "material", "mode", "targets", "extras"),
    "the file": (
        "asset", "scene", "scenes", "nodes", "meshes", "accessors", "bufferViews", "buffers", "materials", "textures",
        "images", "samplers", "cameras", "skins", "animations", "extensionsUsed", "extensionsRequired", "extras",
    ),
}  # fmt: skip


def unknown_words(header: dict[str, Any]) -> Iterator[str]:
    """Yield the keys, extensions and custom properties of a checked header that are not known."""
    yield from _of(header, "the file")
    yield from _of(header.get("asset", {}), "asset")
    for kind in ("scenes", "nodes", "meshes"):
        for each in header.get(kind, []):
            yield from _of(each, kind)
    for mesh in header.get("meshes", []):
        for each in mesh.get("primitives", []):
            yield from _of(each, "primitives")


def _of(data: dict[str, Any], kind: str) -> Iterator[str]:
    yield from unknown_keys(data, (*KEYS[kind], "extras", "extensions"), kind)
    extras, extensions, weights = data.get("extras"), data.get("extensions"), data.get("weights")
    if kind in ("nodes", "meshes") and isinstance(weights, list) and any(weights):
        yield f"weights of {kind}"  # morph targets change the shape
    if kind in ("scenes", "nodes") and isinstance(extras, dict):
        yield from unknown_keys(extras, (KEY,), f"extras of {kind}")
    for name in extensions if isinstance(extensions, dict) else ():
        if not name.startswith(LOOKING):
            yield f"{name} of {kind}"
