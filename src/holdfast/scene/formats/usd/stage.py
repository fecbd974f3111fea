"""Opening of USD stages: all layers must be in the folder of the stage, and its size is limited.

USD allocates as much memory as a file claims to need before it reads the content, so all lengths in a binary file are
checked before: they must be within the file.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from struct import Struct
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from holdfast.base.arrays import Float, checked_number
from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import SceneError, message
from holdfast.base.files import check_ordinary
from holdfast.base.ranges import SCALE
from holdfast.base.rigid import Y_TO_Z
from holdfast.base.text import quoted
from holdfast.scene.formats.references import Packages, References

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
MOST_LAYERS = 1_000  # largest number of files of a stage
MOST_PRIMS = 200_000  # largest number of prims of a stage, with each instance
MOST_DEEP = 200  # largest number of prims within and referring to each other
LOOKS = ".mtlx"  # suffix of layers that only look: USD does without those that are not there


class FilePart(NamedTuple):
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


def _check_lengths(part: FilePart, depth: int) -> None:
    """Raise SceneError if a length in a crate or package exceeds the file, or if a package refers to other files."""
    head = part.read(0, min(8, part.length))
    if head == CRATE:
        contents = part.number(16)
        count = part.number(contents)
        table = part.read(contents + NUMBER.size, count * SECTION.size)
        fields = [begin for name, begin, _ in SECTION.iter_unpack(table) if name.rstrip(b"\0") == b"FIELDS"]
        for name, begin, length in SECTION.iter_unpack(table):
            part.read(begin, 0)
            part.read(begin + length, 0)
            if name.rstrip(b"\0") in COUNTED and part.number(begin) > DENSEST * max(length, 0):
                problem = f"its section {quoted(name.rstrip(bytes(1)).decode())} states {part.number(begin):,} values"
                raise SceneError(message(part.where, f"{problem} in {length:,} bytes", "check the file"))
        for begin in fields:
            _check_values(part, begin)
    elif head.startswith(ENTRY):
        if depth == MOST_NESTED:
            raise SceneError(message(part.where, f"is nested more than {MOST_NESTED} packages deep", "unpack it"))
        for entry in _entries(part):
            _check_lengths(entry, depth + 1)


def _check_values(crate: FilePart, begin: int) -> None:
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


def _unpacked(crate: FilePart, at: int, length: int, most: int) -> bytes:
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


def _entries(package: FilePart) -> Iterator[FilePart]:
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
        yield FilePart(package.stream, package.begin + begin, length, where)
        at = begin + length
    raise SceneError(message(package.where, "has too many files", f"the limit is {MOST_ENTRIES:,}"))


class Stage(NamedTuple):
    """An open stage: its prims, its units in metres and kilograms, and the rotation (4, 4) after which z is up.

    ``whole`` keeps the stage alive, because prims expire with it. The types of USD objects are not checked.
    """

    whole: Any
    prims: list[Any]
    metres: float
    kilograms: float
    turn: Float

    def placed(self, prim: Any) -> Float:  # noqa: ANN401
        """Return the matrix (4, 4) from the frame of a prim, in units of the stage, to the world [m]."""
        from pxr import Usd, UsdGeom

        rows = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
        matrix = np.array(rows, dtype=np.float64).T
        with np.errstate(over="ignore", invalid="ignore"):  # infinite numbers raise an error that names the prim
            matrix[:3] *= self.metres
            return np.asarray(self.turn @ matrix)


def opened(path: Path, packages: Packages | None, notes: list[str]) -> Stage:
    """Open a stage after checking all of its layers.

    Raises SceneError if it cannot be read, names a layer elsewhere, or has too many layers or prims.
    """
    from pxr import Usd

    _check_layers(path, packages)
    _check_composed(path)
    return stage_of(_opened(path, Usd.Stage.Open), str(path), notes)


def stage_of(whole: Any, where: str, notes: list[str]) -> Stage:  # noqa: ANN401 - a stage of USD, open in the program
    """Return the prims, units and axes of a stage; ``where`` names it. Raises SceneError if it has too many prims."""
    from pxr import Usd, UsdGeom, UsdPhysics

    metres = checked_number(UsdGeom.GetStageMetersPerUnit(whole), f"{where}: metersPerUnit", above=0, within=SCALE)
    kilograms = UsdPhysics.GetStageKilogramsPerUnit(whole)
    kilograms = checked_number(kilograms, f"{where}: kilogramsPerUnit", above=0, within=SCALE)
    if not UsdGeom.StageHasAuthoredMetersPerUnit(whole):
        notes.append(f"metersPerUnit is not given: {metres:g}, which USD says then")
    turn = np.eye(4)
    if str(UsdGeom.GetStageUpAxis(whole)) == "Y":
        turn = Y_TO_Z
        notes.append("y is up in the file: turned about x so that z is up")
    prims = []
    for prim in whole.Traverse(Usd.TraverseInstanceProxies()):
        prims.append(prim)
        if len(prims) > MOST_PRIMS:
            remedy = f"the limit is {MOST_PRIMS:,}, instances counted"
            raise SceneError(message(where, "has too many prims", remedy))
    return Stage(whole, prims, metres, kilograms, turn)


def _check_layers(path: Path, packages: Packages | None) -> None:
    """Open all layers one by one and refuse those outside the folder, before the stage is composed."""
    from pxr import Sdf

    references = References(path, packages)
    waiting, seen = [path], {path.resolve()}
    while waiting:
        here = waiting.pop()
        layer: Any = _opened(here, Sdf.Layer.FindOrOpen)
        _check_specs(layer)
        if here.suffix.lower() == ".usdz":
            _check_package(here, layer)
            continue
        for name in layer.GetCompositionAssetDependencies():
            if not name or (name.endswith(LOOKS) and not (here.parent / name).exists()):
                continue
            # absolute, as the folder of a stage with a relative path would otherwise be repeated
            found = references.file(os.path.abspath(here.parent / name) if "://" not in name else name, str(here))
            if found.resolve() not in seen:
                seen.add(found.resolve())
                waiting.append(found)
            if len(seen) > MOST_LAYERS:
                raise SceneError(message(str(path), "has too many layers", f"the limit is {MOST_LAYERS:,}"))


def _check_composed(path: Path) -> None:
    """Raise SceneError if the stage would have too many prims: references to references multiply.

    Each prim of a layer and of those below it is counted once, with all that it refers to; variants count as the
    largest one.
    """
    from pxr import Sdf

    known: dict[tuple[str, str], int] = {}

    def stack(layer: Any) -> list[Any]:  # noqa: ANN401
        found = [layer]
        for each in found:
            below = [Sdf.Layer.FindOrOpenRelativeToLayer(each, name) for name in each.subLayerPaths]
            found += [one for one in below if one and one not in found]
        return found

    def total(root: Any, at: Any, depth: int) -> int:  # noqa: ANN401
        key = root.identifier, str(at)
        if key not in known:
            if depth > MOST_DEEP:
                raise SceneError(message(str(path), "is nested too deeply", f"the limit is {MOST_DEEP} references"))
            known[key] = 0  # what refers to itself is an error of USD
            specs = [spec for spec in (layer.GetPrimAtPath(at) for layer in stack(root)) if spec]
            known[key] = sum(1 + of(spec, root, depth + 1) for spec in specs)
            if known[key] > MOST_PRIMS:
                raise SceneError(message(str(path), "has too many prims", f"the limit is {MOST_PRIMS:,}"))
        return known[key]

    def of(spec: Any, root: Any, depth: int) -> int:  # noqa: ANN401
        count = sum(total(root, child, depth) for child in {each.path for each in spec.nameChildren})
        for arc in (*spec.referenceList.GetAddedOrExplicitItems(), *spec.payloadList.GetAddedOrExplicitItems()):
            layer = Sdf.Layer.FindOrOpenRelativeToLayer(spec.layer, arc.assetPath) if arc.assetPath else root
            if layer:
                count += total(layer, arc.primPath or Sdf.Path(f"/{layer.defaultPrim}"), depth)
        for other in (*spec.inheritPathList.GetAddedOrExplicitItems(), *spec.specializesList.GetAddedOrExplicitItems()):
            count += total(root, other, depth)
        for variants in spec.variantSets.values():
            count += max((of(each.primSpec, root, depth) for each in variants.variants.values()), default=0)
        return count

    with foreign(str(path), "is no USD"):
        layer: Any = Sdf.Layer.FindOrOpen(str(path))
        for child in {each.path for one in stack(layer) for each in one.rootPrims}:
            total(layer, child, 0)


def _check_specs(layer: Any) -> None:  # noqa: ANN401
    """Raise SceneError if a binary layer names a child that it lacks; composing it would crash the process."""
    from pxr import Sdf

    if layer.GetFileFormat().formatId == "usda":  # the text parser creates all children that it names
        return

    def look(path: Any) -> None:  # noqa: ANN401
        if path.isEmpty or (not path.IsTargetPath() and layer.GetObjectAtPath(path) is None):
            lost.append(str(path))

    lost: list[str] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, look)
    if lost:
        problem = f"is damaged: it names {quoted(lost[0])}, and does not hold it"
        raise SceneError(message(layer.identifier, problem, "check the file"))


def _check_package(package: Path, root: Any) -> None:  # noqa: ANN401
    """Open all layers in a package one by one; raise SceneError if one names what is not in the package.

    USD would search it at its absolute path, or in the current folder.
    """
    from pxr import Ar, Sdf

    waiting, seen = [root], {root.identifier}
    while waiting:
        layer = waiting.pop()
        for name in filter(None, layer.GetCompositionAssetDependencies()):
            found = Sdf.ComputeAssetPathRelativeToLayer(layer, name)
            outer = Ar.SplitPackageRelativePathOuter(found)[0] if Ar.IsPackageRelativePath(found) else ""
            if not outer or Path(outer).resolve() != package.resolve():
                problem = f"names {quoted(name)}, which is not in the package"
                raise SceneError(message(layer.identifier, problem, "put it into the package"))
            if found not in seen:
                seen.add(found)
                with foreign(str(package), "is no USD"):
                    waiting.append(Sdf.Layer.FindOrOpen(found))
                if waiting[-1] is None:
                    raise SceneError(message(found, "is no USD", "check the package"))
                _check_specs(waiting[-1])
            if len(seen) > MOST_LAYERS:
                raise SceneError(message(str(package), "has too many layers", f"the limit is {MOST_LAYERS:,}"))


def _opened(path: Path, open_: Callable[[str], Any]) -> Any:  # noqa: ANN401
    """Return the result of ``open_`` for a file; raise SceneError if there is no such file, or if it is not USD.

    USD allocates as much memory as a file claims to need, so the lengths that it states are checked first.
    """
    check_ordinary(path, "layer", remedy="check the paths in the file")
    with path.open("rb") as stream:
        _check_lengths(FilePart(stream, 0, stream.seek(0, 2), str(path)), 0)
    with foreign(str(path), "is no USD"):
        found = open_(str(path))
    if not found:
        raise SceneError(message(str(path), "is no USD", "check the file"))
    return found
