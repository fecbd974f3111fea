"""PLY, binary and text, read with trimesh after the header was checked against the size of the file."""

from __future__ import annotations

import re
from codecs import BOM_UTF8

from holdfast.base.arrays import Float, Int
from holdfast.base.text import quoted
from holdfast.scene.meshes.by_trimesh import load

LONGEST_HEADER = 100_000  # bytes
END = re.compile(rb"^end_header[ \t]*\r?\n", re.MULTILINE)


def read(content: bytes) -> tuple[Float, Int]:
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
    counts = _counts(kept)
    body = content[end.end() :]
    text = forms[0][1:2] == ["ascii"]
    held = sum(1 for row in body.split(b"\n") if row.strip()) if text else len(body)
    if sum(counts.values()) > held:
        claimed = " and ".join(f"{count:,} of {quoted(name)}" for name, count in counts.items())
        raise ValueError(f"says {claimed}, and has {held:,} {'rows' if text else 'bytes'}")
    head = "\n".join(" ".join(words) for words in (["ply"], forms[0], *kept, ["end_header"]))
    return load(head.encode() + b"\n" + body, "ply")


def _counts(rows: list[list[str]]) -> dict[str, int]:
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
