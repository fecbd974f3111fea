"""glTF files of several parts as one binary file."""

from __future__ import annotations

import base64
from typing import Any

from holdfast.base.files import read_ordinary
from holdfast.base.text import quoted
from holdfast.geometry.gltf import container
from holdfast.scene.formats.references import References
from holdfast.scene.formats.source import MAX_BYTES, Source

PICTURES = ("images", "textures", "samplers", "materials")  # they do not matter for a scene at rest


def packed(source: Source) -> bytes:
    """Return a .gltf file and the files that it needs as one binary file, without images.

    Raises ValueError if it is malformed, and SceneError if a file to which it refers is missing or elsewhere.
    """
    version = str(source.data["asset"]["version"])
    if not version.startswith("2."):
        raise ValueError(f"is of version {quoted(version)}, not 2")
    data: dict[str, Any] = {key: value for key, value in source.data.items() if key not in PICTURES}
    buffers, views = data.get("buffers", []), data.get("bufferViews", [])
    parts, starts, end = [], [], 0
    for buffer in buffers:
        content = _buffer(str(buffer["uri"]), source) if "uri" in buffer else b""
        if len(content) < int(buffer["byteLength"]) or end > MAX_BYTES:
            raise ValueError(f"says a buffer of {buffer['byteLength']} bytes, and has {len(content):,}")
        content += b"\0" * (-len(content) % 4)
        parts.append(content)
        starts.append(end)
        end += len(content)
    data["bufferViews"] = [
        view | {"buffer": 0, "byteOffset": int(view.get("byteOffset", 0)) + starts[view["buffer"]]} for view in views
    ]
    data["buffers"] = [{"byteLength": end}] if parts else []
    data["meshes"] = [
        mesh | {"primitives": [{k: v for k, v in each.items() if k != "material"} for each in mesh["primitives"]]}
        for mesh in data.get("meshes", [])
    ]
    return container(data, b"".join(parts))


def _buffer(uri: str, source: Source) -> bytes:
    if uri.startswith("data:"):
        kind, comma, text = uri.partition(",")
        if not comma or not kind.endswith(";base64"):
            raise ValueError(f"has a buffer {quoted(uri)}, which is not base64")
        return base64.b64decode(text, validate=True)
    path = References(source.path, None, "a file of its folder, not package").file(uri, f"{source.path}: buffer")
    return read_ordinary(path, "buffer", most=MAX_BYTES)
