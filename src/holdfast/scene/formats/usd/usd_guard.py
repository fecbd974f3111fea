"""Checks of binary USD files before USD opens them: all lengths in the file must be within the file.

USD allocates as much memory as a file claims to need before it reads the content.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from struct import Struct
from typing import BinaryIO, NamedTuple

from holdfast.base.errors import SceneError, message
from holdfast.base.text import quoted

CRATE = b"PXR-USDC"
ENTRY = b"PK\x03\x04"
MOST_ENTRIES = 10_000  # largest number of files in a package
MOST_NESTED = 4  # largest depth of packages in packages
DENSEST = 1024  # largest number of values for each byte: four, times 255 by compression of repetitions
# header of a file in a package: mark, version, flags, method, times, sums, sizes, lengths
LOCAL = Struct("<4sHHHHHIIIHH")
SECTION = Struct("<16sqq")  # row in the table of contents of a crate: name, start and length of a section
NUMBER = Struct("<Q")
PLACE = (1 << 48) - 1  # mask for the position in the description of a value
MOST_VALUES = 20_000_000  # of one list; no file that is read has more
LISTED = frozenset((31, 40, 41, 48, 49, 50))  # types of values that begin with a count: dictionaries, vectors
OPERATED = frozenset((*range(32, 40), 54, 55))  # types with one byte before the count: list edits
COUNTED = (b"TOKENS", b"STRINGS", b"FIELDS", b"FIELDSETS", b"PATHS", b"SPECS")  # sections that begin with a count


class Part(NamedTuple):
    """A part of an open file: its start and length in bytes, and its name for messages."""

    stream: BinaryIO
    begin: int
    length: int
    where: str

    def read(self, at: int, count: int) -> bytes:
        """Return bytes of the part; raise SceneError if it has fewer."""
        if at < 0 or count < 0 or at + count > self.length:
            problem = f"states a length beyond its end: {count:,} bytes at {at:,} of {self.length:,}"
            raise SceneError(message(self.where, problem, "check the file"))
        self.stream.seek(self.begin + at)
        return self.stream.read(count)

    def number(self, at: int) -> int:
        """Return an integer of eight bytes."""
        return int(NUMBER.unpack(self.read(at, NUMBER.size))[0])


def check_lengths(path: Path) -> None:
    """Raise SceneError if a length in a crate or package exceeds the file, or if a package refers to other files."""
    with path.open("rb") as stream:
        size = stream.seek(0, 2)
        _check(Part(stream, 0, size, str(path)), 0)


def _check(part: Part, depth: int) -> None:
    head = part.read(0, min(8, part.length))
    if head == CRATE:
        _check_crate(part)
    elif head.startswith(ENTRY):
        if depth == MOST_NESTED:
            raise SceneError(message(part.where, f"is nested more than {MOST_NESTED} packages deep", "unpack it"))
        for entry in _entries(part):
            _check(entry, depth + 1)


def _check_crate(crate: Part) -> None:
    """Check that the sections of a crate are inside the file, and that none claims more values than fit into it."""
    contents = crate.number(16)
    count = crate.number(contents)
    table = crate.read(contents + NUMBER.size, count * SECTION.size)
    fields = [begin for name, begin, _ in SECTION.iter_unpack(table) if name.rstrip(b"\0") == b"FIELDS"]
    for name, begin, length in SECTION.iter_unpack(table):
        crate.read(begin, 0)
        crate.read(begin + length, 0)
        if name.rstrip(b"\0") in COUNTED and crate.number(begin) > DENSEST * max(length, 0):
            problem = f"its section {quoted(name.rstrip(bytes(1)).decode())} states {crate.number(begin):,} values"
            raise SceneError(message(crate.where, f"{problem} in {length:,} bytes", "check the file"))
    for begin in fields:
        _check_values(crate, begin)


def _check_values(crate: Part, begin: int) -> None:
    """Check that no list of values is longer than the rest of the file; ``begin`` is the start of the section FIELDS.

    The fields are compressed integers of eight bytes, with the type of each value and the position of its content.
    """
    version = tuple(crate.read(8, 3))
    if version < (0, 4, 0):  # not compressed, and older than UsdPhysics
        raise SceneError(message(crate.where, f"is of version {version}", "write it anew with USD's own tools"))
    count, packed = crate.number(begin), crate.number(begin + 8)
    at = begin + 16 + packed
    for (value,) in NUMBER.iter_unpack(_unpacked(crate, at + 8, crate.number(at), count * NUMBER.size)):
        kind, place = value >> 48 & 0xFF, value & PLACE
        array, inlined, dense = value >> 63 & 1, value >> 62 & 1, value >> 61 & 1
        if inlined or not place or not (array or kind in LISTED or kind in OPERATED):
            continue
        place += kind in OPERATED and not array
        short = array and version < (0, 7, 0)
        held = int.from_bytes(crate.read(place, 4), "little") if short else crate.number(place)
        if held > min(MOST_VALUES, (DENSEST if dense else 1) * (crate.length - place)):
            problem = f"states {held:,} values in {crate.length - place:,} bytes"
            raise SceneError(message(crate.where, problem, "check the file"))


def _unpacked(crate: Part, at: int, length: int, most: int) -> bytes:
    """Decompress LZ4 data: runs of literal bytes, each followed by a repetition of earlier bytes."""
    content = crate.read(at, length)
    found, at = bytearray(), 1  # the first byte is the number of chunks, 0 for a single one
    try:
        while at < len(content) and not content[0]:
            token, at = content[at], at + 1
            run, at = _extended(content, at, token >> 4)
            found += content[at : at + run]
            at += run
            if at >= len(content):
                break
            back = content[at] | content[at + 1] << 8
            copied, at = _extended(content, at + 2, token & 15)
            copied += 4
            begin = len(found) - back
            if back == 0 or begin < 0 or len(found) + copied > most:
                break
            found += (found[begin:] * (copied // back + 1))[:copied]
    except IndexError:
        pass
    if len(found) != most:
        raise SceneError(message(crate.where, "has damaged fields", "check the file"))
    return bytes(found)


def _extended(content: bytes, at: int, count: int) -> tuple[int, int]:
    """Return a length, which continues in further bytes if it begins with 15, and the position after it."""
    more = 255 if count == 15 else 0
    while more == 255:
        more, at = content[at], at + 1
        count += more
    return count, at


def _entries(package: Part) -> Iterator[Part]:
    """Yield the files in a package, which are stored in it one after the other without compression."""
    at = 0
    for _ in range(MOST_ENTRIES):
        if package.length - at < LOCAL.size or package.read(at, 4) != ENTRY:
            return
        header = LOCAL.unpack(package.read(at, LOCAL.size))
        flags, method, length, name_length, more = header[2], header[3], header[7], header[9], header[10]
        name = package.read(at + LOCAL.size, name_length).decode("utf-8", "replace")
        where = f"{package.where}[{name}]"
        if method or flags & 0b1001 or header[8] != length:
            problem = "is packed, encrypted or without its length"
            raise SceneError(message(where, problem, "a .usdz holds files as they are: write it with USD's own tools"))
        begin = at + LOCAL.size + name_length + more
        package.read(begin, 0)
        package.read(begin + length, 0)
        yield Part(package.stream, package.begin + begin, length, where)
        at = begin + length
    raise SceneError(message(package.where, "has too many files", f"the limit is {MOST_ENTRIES:,}"))
