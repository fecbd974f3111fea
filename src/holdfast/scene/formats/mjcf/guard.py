"""What an MJCF file may make MuJoCo do: which files it may read, and how much it may ask for."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as Xml

from holdfast.base.errors import SceneError, message
from holdfast.base.files import check_ordinary
from holdfast.base.text import quoted
from holdfast.scene.formats.source import Source

MOST_ELEMENTS = 100_000  # after replication
MOST_BYTES = 200_000_000  # of a file that a model names
LARGEST = {"width": 16_384, "height": 98_304, "nrow": 4_096, "ncol": 4_096, "size": 100_000, "nkey": 100_000}
UNUSED = ("njmax", "nconmax", "nstack", "memory")  # room for the solver, which the reader does not take
SIZED = ("texture", "hfield", "numeric", "size")  # elements whose numbers above say how much memory is filled
DECLARED = re.compile(r"<!\s*(DOCTYPE|ENTITY)", re.IGNORECASE)
BEFORE = re.compile(r"\s*(?:<\?.*?\?>|<!--.*?-->)", re.DOTALL)  # what may stand before the first element
FIRST = re.compile(r"\s*<(?:!DOCTYPE\s+)?([A-Za-z_][\w.:-]*)", re.IGNORECASE)
SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:")


def root_of(text: str) -> str:
    """Return the name of the first element of an XML text, or of its document type; empty if it is no XML."""
    at = 0
    while skipped := BEFORE.match(text, at):
        at = skipped.end()
    found = FIRST.match(text, at)
    return found.group(1) if found else ""


def parsed(text: str, where: str) -> Xml.Element:
    """Return the root of an XML text; raise SceneError for a text that declares entities or is not well formed."""
    declared = DECLARED.search(text)
    if declared:
        line = text.count("\n", 0, declared.start()) + 1
        problem = f"line {line} declares a {declared.group(1).upper()}"
        raise SceneError(message(where, problem, "document types and entities are not read: write the values out"))
    try:
        return Xml.fromstring(text)
    except Xml.ParseError as cause:
        raise SceneError(message(where, f"is not well-formed XML: {cause}", "needs an MJCF model")) from None


def files_of(text: str, path: Path, within: Path) -> list[Path]:
    """Return the files that a model names, included ones too.

    ``path`` is that of the model. Raises SceneError for a file that lies outside the folder ``within``, is missing or
    too large or no ordinary file, for a model that declares entities, and for one that asks for more than it may.
    """
    files: list[Path] = []
    trees = [parsed(text, str(path))]
    for tree in trees:  # grows while included files are found
        for element in tree.iter("include"):
            (place,) = _places(element.get("file", ""), ("",), element, path, within)
            if place not in files:
                files.append(place)
                trees.append(parsed(Source(place).text, str(place)))
    folders = tuple(dict.fromkeys(["", *(each for tree in trees for each in _folders(tree))]))
    count = 0
    for tree in trees:
        for element, copies in _expanded(tree):
            count += copies
            _check_size(element, count, path)
            for key, name in element.items():
                if key.startswith("file") and element.tag != "include" and name:
                    files += _places(name, folders, element, path, within)
    return list(dict.fromkeys(files))


def _folders(tree: Xml.Element) -> Iterator[str]:
    """Yield the folders to which a model says that files are relative."""
    for compiler in tree.iter("compiler"):
        yield from (compiler.get(key, "") for key in ("meshdir", "texturedir", "assetdir"))


def _places(name: str, folders: tuple[str, ...], element: Xml.Element, path: Path, within: Path) -> list[Path]:
    """Return where a file is: MuJoCo may look in each of the folders, for its path or its name alone."""
    where = f"{path}: {element.tag} file {quoted(name)}"
    if SCHEME.match(name) or "\0" in name:
        raise SceneError(message(where, "is no path", "name a file beside the model"))
    found = []
    for folder in folders:
        for key in dict.fromkeys([os.path.join(folder, name), os.path.join(folder, os.path.basename(name))]):
            place = path.parent / key
            if not Path(os.path.realpath(place)).is_relative_to(os.path.realpath(within)):
                problem = f"leads to {quoted(os.path.normpath(place), 120)}, outside {quoted(str(within), 120)}"
                raise SceneError(message(where, problem, "say within= a folder that holds all files, if you trust it"))
            if os.path.exists(place):  # a name that is too long is that of no file
                found.append(place)
                if check_ordinary(place, f"{element.tag} file") > MOST_BYTES:
                    raise SceneError(message(where, "is too large", f"the limit is {MOST_BYTES:,} bytes"))
    if not found:
        remedy = "give it beside the model, or correct its name"
        raise SceneError(message(where, f"is not in {quoted(str(path.parent), 120)}", remedy))
    return found[:1] if element.tag == "include" else found


def _expanded(tree: Xml.Element) -> Iterator[tuple[Xml.Element, int]]:
    """Yield every element with the number of its copies after replication."""
    waiting = [(tree, 1)]
    while waiting:
        element, copies = waiting.pop()
        yield element, copies
        for number in element.get("count", "").split():
            copies *= _whole(number)
        waiting.extend((child, min(copies, 2 * MOST_ELEMENTS)) for child in element)


def _whole(number: str) -> int:
    try:
        return max(1, int(float(number)))
    except (ValueError, OverflowError):
        return 1  # MuJoCo says what is wrong with it


def _check_size(element: Xml.Element, count: int, path: Path) -> None:
    if count > MOST_ELEMENTS:
        problem = f"has more than {MOST_ELEMENTS:,} elements with all copies of its <replicate>"
        raise SceneError(message(str(path), problem, "split the model"))
    for key, most in LARGEST.items():
        if element.tag in SIZED and _whole(element.get(key, "")) > most:
            problem = f"is {quoted(element.get(key))}"
            raise SceneError(message(f"{path}: {element.tag} {key}", problem, f"the limit is {most:,}"))
    for key, value in element.items():
        if element.tag == "size" and key.startswith("n") and key not in UNUSED and _whole(value) > LARGEST["nkey"]:
            problem = f"is {quoted(value)}"
            raise SceneError(message(f"{path}: size {key}", problem, f"the limit is {LARGEST['nkey']:,}"))
