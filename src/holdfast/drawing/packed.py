"""Pack a JSON header and arrays into one compressed text for a page."""

from __future__ import annotations

import base64
import json
import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

Place = dict[str, int | str]


class Packer:
    """Collects arrays, and packs them with a header that refers to them."""

    def __init__(self) -> None:
        self._chunks: list[bytes] = []
        self._length = 0

    def put(self, values: NDArray[Any], kind: str) -> Place:
        """Add an array as little-endian ``kind`` ("f4", "u4" or "u1"), and return its entry for the header.

        Arrays of "u4" are stored byte plane by byte plane, the lowest bytes first, which halves their compressed size.
        """
        raw = np.ascontiguousarray(values, dtype=np.dtype(kind).newbyteorder("<"))
        content = raw.view(np.uint8).reshape(-1, 4).T.tobytes() if kind == "u4" else raw.tobytes()
        place: Place = {"at": self._length, "count": int(np.size(values)), "kind": kind}
        padded = content + bytes(-len(content) % 4)
        self._chunks.append(padded)
        self._length += len(padded)
        return place

    def text(self, header: dict[str, Any]) -> str:
        """Return the header and all arrays, deflated (zlib), in base 64.

        Before that: the length of the header in bytes as a little-endian unsigned 32-bit number, the header as JSON
        padded with spaces to a multiple of four bytes, the arrays one after the other, each at its ``at`` from the
        first. Raises ValueError if a number of the header is not finite, which JSON does not have.
        """
        written = json.dumps(header, ensure_ascii=False, allow_nan=False).encode("utf-8")
        written += b" " * (-len(written) % 4)
        whole = struct.pack("<I", len(written)) + written + b"".join(self._chunks)
        return base64.b64encode(zlib.compress(whole, 9)).decode("ascii")
