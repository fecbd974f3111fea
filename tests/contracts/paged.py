"""What the page of a map holds, read back for tests."""

from __future__ import annotations

import re
from typing import Any

from holdfast.drawing.packed import unpacked


def data_of(text: str) -> dict[str, Any]:
    """The data of a page: its layers with their arrays."""
    found = re.search(r'<script id="data" type="text/plain">(.*?)</script>', text, re.DOTALL)
    assert found
    return unpacked(found.group(1))


def faces(data: dict[str, Any]) -> list[dict[str, Any]]:
    """All coloured surfaces of a page, arrows among them."""
    return [part for layer in data["layers"] for part in layer["parts"] if part["shape"] == "faces"]


def triples(values: Any) -> Any:
    """Numbers (3N,) as places or corners (N, 3)."""
    return values.reshape(-1, 3)


def said(data: dict[str, Any]) -> list[str]:
    """All texts that a page shows under the pointer."""
    return [text for part in faces(data) for text in part["texts"] if text]
