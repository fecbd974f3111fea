"""Checks of MJCF files before MuJoCo reads them: the files they refer to, and the memory they ask for.

What asks for more than a file shows is read in a process of its own, with limits of memory and time. Workers of batches
have such limits already, and read everything themselves.
"""

from __future__ import annotations

import math
import os
import re
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, cast
from xml.etree import ElementTree as Xml

from holdfast.base.borders.foreign import foreign
from holdfast.base.borders.supervisor import Limits, Supervisor
from holdfast.base.borders.worker import DONE
from holdfast.base.errors import HoldfastError, HoldfastWarning, SceneError, message, warn
from holdfast.base.files import check_ordinary
from holdfast.base.text import quoted
from holdfast.scene.formats.source import Source
from holdfast.scene.xml import root_name

T = TypeVar("T")
LIMITS = Limits(seconds=30.0, megabytes=2_000.0)
ROOT = "mujoco"
ELEMENTS, MADE = "elements", "made"
MOST_ELEMENTS = 100_000  # largest number of elements of a file with all that it includes
MOST_DEEP = 200  # largest depth of elements
MOST_NESTED = 20  # largest depth of models attached to models
MOST = {  # limits of a model with all its attachments; a height field cell needs up to 3 kB
    ELEMENTS: (MOST_ELEMENTS, "elements with all copies of its <replicate> and <attach>"),
    "hfield": (300_000, "cells of heightfields"),
    MADE: (20_000, "corners of meshes and grids that MuJoCo makes"),
}
PNG = b"\x89PNG\r\n\x1a\n"
MOST_BYTES = 200_000_000  # size of the largest file that a model may refer to
LARGEST = {"nrow": 4_096, "ncol": 4_096, "size": 100_000, "nkey": 100_000}
UNUSED = ("njmax", "nconmax", "nstack")  # memory for the solver, which the reader does not need
# elements whose attributes in MOST determine the memory that is filled
SIZED = ("hfield", "numeric", "size")
UNSEEN = ("texture", "material", "skin")  # what only looks: the reader takes it out before MuJoCo opens its files
DECLARED = re.compile(r"<!\s*(DOCTYPE|ENTITY)", re.IGNORECASE)
SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:")


def read_apart(read: Callable[..., T], source: Source, options: Mapping[str, Any]) -> T:
    """Return ``read(source, **options)``, called in a process of its own; ``read`` is a function of a module.

    Raises what it raises, and SceneError if it needs more memory or time than LIMITS, or ends its process. A worker
    (``worker.is_limited``) must not call this.
    """
    with Supervisor("holdfast.scene.formats.mjcf.mjcf_guard:read_in_worker", limits=LIMITS) as reader:
        reply = reader.ask((read.__module__, read.__name__, source.path, source.given, dict(options)))
    if reply.outcome != DONE:
        problem = f"cannot be read with {LIMITS.megabytes:,.0f} MB and {LIMITS.seconds:g} s: {reply.problem}"
        raise SceneError(message(str(source.path), problem, "simplify the file"))
    found, told = reply.value
    for text in told:
        warn(text)
    if isinstance(found, HoldfastError):
        raise found
    return cast(T, found)


def read_in_worker(
    item: tuple[str, str, Path, bytes | None, dict[str, Any]], _: Callable[[Any], None]
) -> tuple[Any, list[str]]:
    """Read a file in the worker; return what was read, or the error, and the texts of warnings."""
    module, name, path, given, options = item
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            found = getattr(import_module(module), name)(Source(path, given), **options)
        except HoldfastError as error:
            found = type(error)(str(error))
    return found, [str(each.message) for each in caught if isinstance(each.message, HoldfastWarning)]


def parsed(text: str, where: str) -> Xml.Element:
    """Return the root of an XML text; raise SceneError for a text that declares entities or is not well formed."""
    declared = DECLARED.search(text)
    if declared:
        line = text.count("\n", 0, declared.start()) + 1
        problem = f"line {line} declares a {declared.group(1).upper()}"
        raise SceneError(message(where, problem, "document types and entities are not read: write the values out"))
    with foreign(where, "is not well-formed XML", "needs an MJCF model"):
        tree = Xml.fromstring(text)
    level, depth = [tree], 0  # MuJoCo recurses
    while level:
        level, depth = [child for element in level for child in element], depth + 1
        if depth > MOST_DEEP:
            raise SceneError(message(where, "is nested too deeply", f"the limit is {MOST_DEEP} levels"))
    return tree


def files_of(text: str, path: Path, within: Path) -> list[Path]:
    """Return the files to which a model refers, also through included and attached files.

    ``path`` is that of the model. Raises SceneError for a file that is outside the folder ``within``, missing, too
    large or not a regular file, for a model that declares entities or attaches itself, and for one that exceeds MOST.
    """
    files: list[Path] = []
    _demands_of(text, path, _Demands(within, files, {}), (path.resolve(),))
    return list(dict.fromkeys(files))


class _Demands(NamedTuple):
    """The state of the check: the allowed folder ``within``, the files, and the demands of attached models."""

    within: Path
    files: list[Path]
    models: dict[Path, Counter[str]]


def _demands_of(text: str, path: Path, so_far: _Demands, above: tuple[Path, ...]) -> Counter[str]:
    """Add the files to which a model refers, and return its demands by the keys of MOST.

    ``above`` are the models to which it is attached, and itself.
    """
    within, files = so_far.within, so_far.files
    trees = [parsed(text, str(path))]
    included: list[Path] = []
    for tree in trees:  # the list grows when included files are found
        for element in tree.iter("include"):
            (place,) = _places(element.get("file", ""), ("",), element, path, within)
            if place not in included:
                included.append(place)
                trees.append(parsed(Source(place).text, str(place)))
    files += included
    attached = _attached(trees, path, so_far, above)
    compilers = [each for tree in trees for each in tree.iter("compiler")]
    named = [each.get(key, "") for each in compilers for key in ("meshdir", "texturedir", "assetdir")]
    folders = tuple(dict.fromkeys(["", *named]))  # to which file names are relative
    count: Counter[str] = Counter()
    for tree in trees:
        for element, copies in _expanded(tree):
            _check_size(element, path)
            count[ELEMENTS] += copies
            places: list[Path] = []
            if element.tag not in ("include", "model", *UNSEEN):
                named = [name for key, name in element.items() if key.startswith("file") and name]
                places = [place for name in named for place in _places(name, folders, element, path, within)]
            files += places
            count[element.tag] += _filled(element, places)
            count[MADE] += copies * _made(element)
            for key, amount in attached.get(element.get("model", ""), {}).items() if element.tag == "attach" else ():
                count[key] += copies * amount
            for key, (most, what) in MOST.items():
                if count[key] > most:
                    raise SceneError(message(str(path), f"has more than {most:,} {what}", "split the model"))
    return count


def _attached(
    trees: list[Xml.Element], path: Path, so_far: _Demands, above: tuple[Path, ...]
) -> dict[str, Counter[str]]:
    """Return the demands of each model that may be attached, by the name under which it is attached.

    If a model attaches itself, directly or through others, MuJoCo recurses until the process dies.
    """
    found: dict[str, Counter[str]] = {}
    for element in (each for tree in trees for each in tree.iter("model")):
        (place,) = _places(element.get("file", ""), ("",), element, path, so_far.within)
        so_far.files.append(place)
        here, where = place.resolve(), f"{path}: model file {quoted(element.get('file'))}"
        if here in above:
            raise SceneError(message(where, "attaches a model to itself", "name another file"))
        if len(above) > MOST_NESTED:
            raise SceneError(message(where, f"is attached more than {MOST_NESTED} levels deep", "flatten the model"))
        if here not in so_far.models:
            source = Source(place)
            known = root_name(source.text) == ROOT  # MuJoCo reads URDF here, too, which attaches nothing
            so_far.models[here] = _demands_of(source.text, place, so_far, (*above, here)) if known else Counter()
        found[element.get("name", "")] = so_far.models[here]
    return found


def _places(name: str, folders: tuple[str, ...], element: Xml.Element, path: Path, within: Path) -> list[Path]:
    """Return the places where MuJoCo may find a file: in each folder it looks for the path, then for its name alone.

    Of a model that is included or attached, the first is the one. Raises SceneError if there is none, or if one lies
    outside ``within``.
    """
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
            if os.path.exists(place):  # False for a name that is too long
                found.append(place)
                if check_ordinary(place, f"{element.tag} file") > MOST_BYTES:
                    raise SceneError(message(where, "is too large", f"the limit is {MOST_BYTES:,} bytes"))
    if not found:
        remedy = "give it beside the model, or correct its name"
        raise SceneError(message(where, f"is not in {quoted(str(path.parent), 120)}", remedy))
    return found[:1] if element.tag in ("include", "model") else found


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
        return 1  # MuJoCo will report the error


def _filled(element: Xml.Element, places: list[Path]) -> int:
    """Return the number of cells of a height field, from its attributes or the headers of its files."""
    if element.tag != "hfield":
        return 0
    sizes = []
    for head in (Source(place).head for place in places):
        if head.startswith(PNG):
            sizes.append(int.from_bytes(head[16:20], "big") * int.from_bytes(head[20:24], "big"))
        else:  # MuJoCo's own format
            sizes.append(int.from_bytes(head[:4], "little") * int.from_bytes(head[4:8], "little"))
    return max(sizes) if sizes else _whole(element.get("nrow", "")) * _whole(element.get("ncol", ""))


def _made(element: Xml.Element) -> int:
    """Return about how many vertices MuJoCo makes for a builtin mesh, a flexible body or a composite one."""
    if element.tag in ("flexcomp", "composite"):
        return math.prod(_whole(number) for number in element.get("count", "").split())
    if element.tag != "mesh" or element.get("builtin") is None:
        return 0
    first, second = ([_whole(number) for number in element.get("params", "").split()] + [1, 1])[:2]
    match element.get("builtin"):
        case "cone":
            return first
        case "plate" | "wedge":
            return first * second
        case "sphere":
            return 1 << 2 * min(first, 20)
    return first * first


def _check_size(element: Xml.Element, path: Path) -> None:
    for key, most in LARGEST.items():
        if element.tag in SIZED and _whole(element.get(key, "")) > most:
            problem = f"is {quoted(element.get(key))}"
            raise SceneError(message(f"{path}: {element.tag} {key}", problem, f"the limit is {most:,}"))
    for key, value in element.items():
        if element.tag == "size" and key.startswith("n") and key not in UNUSED and _whole(value) > LARGEST["nkey"]:
            problem = f"is {quoted(value)}"
            raise SceneError(message(f"{path}: size {key}", problem, f"the limit is {LARGEST['nkey']:,}"))
