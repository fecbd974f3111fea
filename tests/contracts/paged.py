"""What the page of a map holds, read back for tests."""

from __future__ import annotations

import base64
import json
import re
import struct
import zlib
from typing import Any

import numpy as np


def data_of(text: str) -> dict[str, Any]:
    """The data of a page: its layers with their arrays."""
    found = re.search(r'<script id="data" type="text/plain">(.*?)</script>', text, re.DOTALL)
    assert found
    return unpacked(found.group(1))


def unpacked(text: str) -> dict[str, Any]:
    """Return the header of ``Packer.text`` with every array (N,) in the place of what refers to it."""
    whole = zlib.decompress(base64.b64decode(text))
    (length,) = struct.unpack_from("<I", whole)
    arrays = whole[4 + length :]

    def filled(value: Any) -> Any:
        if isinstance(value, dict):
            if value.keys() == {"at", "count", "kind"} and value["kind"] == "u4":  # all lowest bytes first
                planes = np.frombuffer(arrays, "u1", 4 * value["count"], value["at"])
                return np.ascontiguousarray(planes.reshape(4, -1).T).view("<u4").ravel()
            if value.keys() == {"at", "count", "kind"}:
                return np.frombuffer(arrays, "<" + value["kind"], value["count"], value["at"])
            return {name: filled(item) for name, item in value.items()}
        return [filled(item) for item in value] if isinstance(value, list) else value

    return dict(filled(json.loads(whole[4 : 4 + length])))


def faces(data: dict[str, Any]) -> list[dict[str, Any]]:
    """All coloured surfaces of a page, arrows among them."""
    return [part for layer in data["layers"] for part in layer["parts"] if part["shape"] == "faces"]


def triples(values: Any) -> Any:
    """Numbers (3N,) as places or corners (N, 3)."""
    return values.reshape(-1, 3)


def said(data: dict[str, Any]) -> list[str]:
    """All texts that a page shows under the pointer."""
    return [text for part in faces(data) for text in part["texts"] if text]
