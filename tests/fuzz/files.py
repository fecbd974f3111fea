"""Mutated files: bytes, text, numbers, keys, nesting, counts, and the parts that lie within archives and GLB files."""

from __future__ import annotations

import io
import json
import re
import struct
import zipfile
from collections.abc import Callable
from typing import Any

import numpy as np

from fuzz.draw import Rng, chance, one_of
from fuzz.originals import originals, packed

Mutation = Callable[[Rng, bytes], bytes]
NUMBER = re.compile(rb"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
NUMBERS = (
    *b"nan NaN inf -Infinity 1e999 -1e308 1e-320 0 -0.0 -1 1e100 3e8 0x10".split(),
    *b'99999999999999999999 4294967295 2147483648 -2147483649 1_000 1,5 true null "1"'.split(),
    *(b"[]", b"{}", b"", b" ", b"1 2", b"0.1", b"7", b".", b"-", b"9" * 400, b"9" * 5000),
)
WORDS = (
    *b"[ ] { } \" ' : , - # &a *a !!python/object:os.system".split(),
    *(b"<<: *a", b"---", b"\n", b"\r\n", b"\t", b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\xed\xa0\x80", b"\xe2\x80\xa8"),
    *(b"f 1 2 3\n", b"v 1 2\n", b"f -1 -2 -3\n", b"f 1/2/3 4//5 6\n", b"mtllib /etc/passwd\n", b"endsolid\n"),
    *(b"facet normal 0 0 0\n", b"end_header\n", b"element vertex 300000000\n", b"property list uchar int x\n"),
    *(b"format ascii 1.0\n", b"../../../etc/passwd", b"$value"),
)
MARKUP = (
    b'<!DOCTYPE a [<!ENTITY b "bbbbbbbb"><!ENTITY c "&b;&b;&b;&b;">]>',
    *b"&c; &#0; &lt; <!-- <![CDATA[ <a> </a> />".split(),
    *(b"<?xml version='1.1' encoding='utf-7'?>", b'<include file="s.xml"/>'),
    *(b"<include><uri>model://x</uri></include>", b'size="-1 0 nan"', b'file="../../../etc/passwd"'),
    *(b"<body><freejoint/></body>", b'class="none"', b"<static>1</static>"),
)
COUNTS = (0, 1, 2, 255, 65535, 1 << 20, 300_000_000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1, 2, 1e-300, 1e300, -1e300, 10**30, 0.5, "", "x", "1", "nan", "inf"),
    *([], {}, [[]], [0], [1, 2, 3]),
    *([0.0] * 16, {"type": "box"}, {"$same": 0}, {"$value": "Scene", "fields": {}}, {"$tuple": []}, {"$float": "nan"}),
    *({"$numbers": [1], "dtype": "O", "shape": [1]}, {"$numbers": [1], "dtype": "<f8", "shape": [10**9]}),
    *({"$path": "/"}, {"$enum": ["Status", "stable"]}, {"$array": "points"}),
    {"$bytes": "AAAA", "dtype": "<f8", "shape": [-1]},
)


def file(rng: Rng) -> dict[str, Any]:
    """Draw an original and mutate it once to three times; rarely it gets the suffix or place of another one."""
    kept = originals()
    original = one_of(rng, kept)
    content = original["content"]
    for _ in range(int(one_of(rng, (1, 1, 2, 3)))):
        content = mutated(rng, content, original["suffix"])
    suffix = original["suffix"]
    if chance(rng, 0.03):
        suffix = one_of(rng, (".obj", ".stl", ".ply", ".glb", ".off", ".json", ".yaml", ".npz", "", ".txt"))
    if original["beside"] and chance(rng, 0.1):
        beside = {name: mutated(rng, inner, "") for name, inner in original["beside"].items()}
        return packed(original | {"beside": beside, "suffix": suffix})
    return packed(original | {"content": content, "suffix": suffix})


def mutated(rng: Rng, content: bytes, suffix: str) -> bytes:
    """Change a file in one way; what fits its kind is likelier than what fits any."""
    fitting: tuple[Mutation, ...] = ()
    if suffix in (".json", ".yaml", ".obj", ".off") or content[:5] in (b"solid", b"ply\nf"):
        fitting = (nudged, nudged, nudged, number, number, word, line, lines_swapped)
    if suffix == ".json":
        fitting = (*fitting, node, node, node, doubled_key, nested)
    if suffix in (".xml", ".urdf", ".sdf"):
        fitting = (nudged, nudged, nudged, number, number, line, lines_swapped, doubled_line, markup, markup, attribute)
    if suffix == ".yaml":
        fitting = (*fitting, doubled_line, nested, indented)
    if suffix in (".stl", ".ply") and not fitting:
        fitting = (packed_number, packed_number, count, cut, flip)
    if suffix == ".npz":
        fitting = (member, member, member, member_gone)
    if suffix == ".glb":
        fitting = (chunk, chunk, chunk, count, packed_number, packed_number)
    change = one_of(rng, fitting) if fitting and chance(rng, 0.75) else one_of(rng, ANY)
    return change(rng, content)


def place(rng: Rng, content: bytes) -> int:
    return int(rng.integers(len(content) + 1))


def flip(rng: Rng, content: bytes) -> bytes:
    data = bytearray(content)
    for _ in range(int(rng.integers(1, 9))):
        if data:
            data[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
    return bytes(data)


def cut(rng: Rng, content: bytes) -> bytes:
    return content[: place(rng, content)]


def gone(rng: Rng, content: bytes) -> bytes:
    a, b = sorted((place(rng, content), place(rng, content)))
    return content[:a] + content[min(b, a + int(rng.integers(1, 200))) :]


def twice(rng: Rng, content: bytes) -> bytes:
    a = place(rng, content)
    piece = content[a : a + int(rng.integers(1, 300))]
    return content[:a] + piece * int(one_of(rng, (2, 2, 3, 50))) + content[a:]


def noise(rng: Rng, content: bytes) -> bytes:
    a = place(rng, content)
    return content[:a] + rng.bytes(int(rng.integers(1, 40))) + content[a:]


def word(rng: Rng, content: bytes) -> bytes:
    a = place(rng, content)
    return content[:a] + one_of(rng, WORDS) + content[a:]


def markup(rng: Rng, content: bytes) -> bytes:
    a = place(rng, content)
    return content[:a] + one_of(rng, MARKUP) + content[a:]


def attribute(rng: Rng, content: bytes) -> bytes:
    """Replace what stands between two quotation marks by what stands between others, or by a number or nothing."""
    found = [*re.finditer(rb'"[^"<>]*"', content)]
    if not found:
        return markup(rng, content)
    hit, other = (found[int(k)] for k in rng.integers(len(found), size=2))
    text = other.group() if chance(rng, 0.6) else b'"' + one_of(rng, NUMBERS) + b'"'
    return content[: hit.start()] + text + content[hit.end() :]


def count(rng: Rng, content: bytes) -> bytes:
    """Write a large number over four bytes, mostly near the beginning, where counts are."""
    a = int(rng.integers(min(len(content), 400 if chance(rng, 0.7) else len(content)) + 1))
    return content[:a] + struct.pack(one_of(rng, ("<I", ">I")), one_of(rng, COUNTS)) + content[a + 4 :]


def recoded(rng: Rng, content: bytes) -> bytes:
    """The same text in another encoding, mostly with a byte-order mark."""
    return content.decode("latin-1").encode(one_of(rng, ("utf-16", "utf-32", "utf-8-sig", "utf-16-be")))


def number(rng: Rng, content: bytes) -> bytes:
    """Replace one number, or all that are the same."""
    found = [*NUMBER.finditer(content)]
    if not found:
        return noise(rng, content)
    hit = found[int(rng.integers(len(found)))]
    other = one_of(rng, NUMBERS)
    if chance(rng, 0.1):
        return content.replace(hit.group(), other)
    return content[: hit.start()] + other + content[hit.end() :]


def nudged(rng: Rng, content: bytes) -> bytes:
    """Change one number a little: what is read then is another thing, and no error."""
    found = [*NUMBER.finditer(content)]
    if not found:
        return flip(rng, content)
    hit = found[int(rng.integers(len(found)))]
    factor = one_of(rng, (-1.0, 0.5, 2.0, 1.0 + 1e-9, 1.01, 10.0, 1e-3))
    value = float(hit.group()) * factor + one_of(rng, (0.0, 0.0, 1.0))
    whole = b"." not in hit.group() and abs(value) < 1e15 and value == int(value)
    return content[: hit.start()] + (str(int(value)) if whole else repr(value)).encode() + content[hit.end() :]


def packed_number(rng: Rng, content: bytes) -> bytes:
    """Write a sane or odd float over four aligned bytes."""
    a = 4 * int(rng.integers(len(content) // 4 + 1))
    value = one_of(rng, (0.0, -1.0, 0.1, 1e-30, 1e30, float("nan"), float("inf"), float(rng.normal())))
    return content[:a] + struct.pack("<f", value) + content[a + 4 :]


def line(rng: Rng, content: bytes) -> bytes:
    lines = content.split(b"\n")
    del lines[int(rng.integers(len(lines)))]
    return b"\n".join(lines)


def lines_swapped(rng: Rng, content: bytes) -> bytes:
    lines = content.split(b"\n")
    a, b = (int(k) for k in rng.integers(len(lines), size=2))
    lines[a], lines[b] = lines[b], lines[a]
    return b"\n".join(lines)


def doubled_line(rng: Rng, content: bytes) -> bytes:
    lines = content.split(b"\n")
    a = int(rng.integers(len(lines)))
    return b"\n".join([*lines[:a], *[lines[a]] * int(one_of(rng, (2, 2, 1000))), *lines[a:]])


def indented(rng: Rng, content: bytes) -> bytes:
    lines = content.split(b"\n")
    a = int(rng.integers(len(lines)))
    lines[a] = b" " * int(rng.integers(1, 9)) + lines[a] if chance(rng, 0.5) else lines[a].lstrip()
    return b"\n".join(lines)


def doubled_key(rng: Rng, content: bytes) -> bytes:
    """Repeat a key of a JSON object with another value."""
    found = [*re.finditer(rb'"[^"]*":', content)]
    if not found:
        return word(rng, content)
    hit = found[int(rng.integers(len(found)))]
    return content[: hit.start()] + hit.group() + one_of(rng, NUMBERS) + b"," + content[hit.start() :]


def nested(rng: Rng, content: bytes) -> bytes:
    a, deep = place(rng, content), int(one_of(rng, (30, 100, 1000, 100_000)))
    return content[:a] + one_of(rng, (b"[", b"{", b'{"a":', b"- ", b"[[")) * deep + content[a:]


def node(rng: Rng, content: bytes) -> bytes:
    """Replace, remove or move one value of JSON data."""
    try:
        return json.dumps(elsewhere(rng, json.loads(content))).encode()
    except (ValueError, RecursionError):  # it is no JSON any more, or too deep
        return number(rng, content)


def elsewhere(rng: Rng, data: Any) -> Any:
    places = [*walked(data)]
    if not places:
        return one_of(rng, VALUES)
    holder, key = places[int(rng.integers(len(places)))]
    if chance(rng, 0.15):
        del holder[key]
    elif chance(rng, 0.2):
        other, source = places[int(rng.integers(len(places)))]
        holder[key] = json.loads(json.dumps(other[source])) if source in keys(other) else None
    elif chance(rng, 0.1) and isinstance(holder, list):
        holder.extend([holder[key]] * int(one_of(rng, (1, 2, 1000))))
    else:
        holder[key] = one_of(rng, VALUES)
    return data


def keys(holder: Any) -> list[Any]:
    return [*holder] if isinstance(holder, dict) else [*range(len(holder))]


def walked(data: Any, deep: int = 0) -> Any:
    """Give every place in nested data: its holder and key. Places deep down are many, so branches are alike."""
    if isinstance(data, dict | list) and deep < 30:
        for key in keys(data):
            yield data, key
            yield from walked(data[key], deep + 1)


def member(rng: Rng, content: bytes) -> bytes:
    """Change one member of a .npz file: its text, its array's header or its numbers."""
    parts = unpacked(content)
    if not parts:
        return flip(rng, content)
    name = one_of(rng, [*parts])
    inner = parts[name]
    if name == "value.npy" and chance(rng, 0.6):
        return zipped(parts | {name: retold(rng, inner)})
    change = one_of(rng, (flip, cut, number, count, gone, word))
    return zipped(parts | {name: change(rng, inner)})


def retold(rng: Rng, inner: bytes) -> bytes:
    """Change the JSON text that stands as one UTF-32 string in value.npy."""
    try:
        text = str(np.load(io.BytesIO(inner), allow_pickle=False))
    except Exception:
        return flip(rng, inner)
    stream = io.BytesIO()
    np.save(stream, np.array(node(rng, text.encode()).decode(errors="replace")), allow_pickle=False)
    return stream.getvalue()


def member_gone(rng: Rng, content: bytes) -> bytes:
    parts = unpacked(content)
    if not parts:
        return cut(rng, content)
    name = one_of(rng, [*parts])
    inner = parts.pop(name)
    return zipped(parts | ({one_of(rng, ("x.npy", "../x", "value", name + name)): inner} if chance(rng, 0.5) else {}))


def unpacked(content: bytes) -> dict[str, bytes]:
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            return {name: archive.read(name) for name in archive.namelist()}
    except Exception:
        return {}


def zipped(parts: dict[str, bytes]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, inner in parts.items():
            archive.writestr(zipfile.ZipInfo(name, (2020, 1, 1, 0, 0, 0)), inner)
    return stream.getvalue()


def chunk(rng: Rng, content: bytes) -> bytes:
    """Change the JSON part of a GLB file and keep its lengths right."""
    try:
        length = struct.unpack("<I", content[12:16])[0]
        text, rest = content[20 : 20 + length], content[20 + length :]
        if content[:4] != b"glTF" or not rest:
            return count(rng, content)
    except struct.error:
        return flip(rng, content)
    changed = one_of(rng, (node, node, number))(rng, text)
    changed += b" " * (-len(changed) % 4)
    body = struct.pack("<I4s", len(changed), b"JSON") + changed + rest
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


ANY: tuple[Mutation, ...] = (flip, flip, cut, gone, twice, noise, word, count, recoded, number)
