"""The registry of scene file formats: it finds the format that reads or writes a file."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from holdfast.base.arrays import checked_truth
from holdfast.base.borders.foreign import counted
from holdfast.base.errors import HoldfastError, SceneError, installing, located, message
from holdfast.base.files import checked_path, write_atomically
from holdfast.base.names import Registry
from holdfast.scene.formats import FORMATS
from holdfast.scene.formats.links import on_the_floor
from holdfast.scene.formats.source import SUFFIXES, Source
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene

T = TypeVar("T")

# What to do instead of an option, for a format that has none because its files say all
STANDS = {
    "friction": "it has none: write `friction: 0.3` into the file, or say --friction A:B=0.3 for a pair "
    "(in Python hf.Scene(scene.bodies, 0.3))",
    "density": "it has none: write `density: 700` or `mass: 0.3` at the body in the file",
    "floor": "it has none: add `{name: floor, shape: {type: halfspace}, fixed: true}` to the bodies in the file",
}
SHARED = (*SUFFIXES, ".xml")  # suffixes of scenes that most files with them have for another reason
MARKS = (b"holdfast-scene/", b"<mujoco>", b"<mujoco ", b"<sdf ", b"<robot ")  # in the head of a scene, even if damaged


@dataclass(frozen=True)
class Format:
    """A format of scene files: its name, its suffixes, and the functions that read and write it.

    - ``sniff(source) -> bool`` tells from the content whether a file is in the format. It must be fast and exact and
      must not need optional packages. A SceneError (the content is not text, JSON or XML) counts as no.
    - ``read(source, *, ...) -> Scene`` reads the file. Its keyword-only parameters are the options that ``load_scene``
      accepts for this format.
    - ``write(scene, path, *, ...) -> bytes`` returns the content of the file that will be at ``path``, likewise with
      options. It writes nothing itself, so that an error never leaves an incomplete file.

    ``mark`` says in a few words how its files are recognised. ``extra`` is the optional dependency group that the
    functions import, and ``holds`` says that it can write what holds bodies. Raises HoldfastError if a suffix is
    malformed, if there is neither a reader nor a writer, or if there is neither a suffix nor ``sniff``.
    """

    name: str
    suffixes: tuple[str, ...]
    sniff: Callable[[Source], bool] | None = None
    read: Callable[..., Scene] | None = None
    write: Callable[..., bytes] | None = None
    mark: str = ""
    extra: str = ""
    holds: bool = False

    def __post_init__(self) -> None:
        where = f"format {self.name!r}"
        object.__setattr__(self, "suffixes", tuple(self.suffixes))
        for suffix in self.suffixes:
            if not suffix.startswith(".") or suffix != suffix.lower():
                raise HoldfastError(message(where, f"suffix {suffix!r}", "needs a dot and small letters, as '.yaml'"))
        if self.read is None and self.write is None:
            raise HoldfastError(message(where, "neither reads nor writes", "give read=, write= or both"))
        if self.sniff is None and not self.suffixes:
            raise HoldfastError(message(where, "no file would be in it", "give suffixes, sniff= or both"))

    @cached_property
    def options(self) -> tuple[str, ...]:
        """The names of the options of its reader."""
        return () if self.read is None else _keywords(self.read)

    def check_options(self, options: Iterable[str]) -> None:
        """Raise SceneError if its reader lacks one of these options."""
        _check_options(self, self.options, options, readable())

    def __str__(self) -> str:
        return f"{self.name} ({', '.join(self.suffixes)}{': ' if self.mark and self.suffixes else ''}{self.mark})"


@cache
def _formats() -> Registry[Format]:
    """All formats; those that come with holdfast are imported now."""
    home = "holdfast.scene.formats"
    own: list[Format] = [getattr(import_module(f"{home}.{module}"), name) for module, name in FORMATS]
    return Registry("format", {each.name: each for each in own})


def register_format(new: Format) -> Callable[[], None]:
    """Make a format known to ``load_scene``, ``save_scene`` and the command line.

    Returns a function that removes the registration. Raises HoldfastError if a format with its name is registered.
    """
    return _formats().add(new.name, new)


def readable() -> tuple[Format, ...]:
    """The formats that can be read."""
    return tuple(each for each in _formats().values() if each.read is not None)


def writable() -> tuple[Format, ...]:
    """The formats that can be written."""
    return tuple(each for each in _formats().values() if each.write is not None)


def load_scene(path: str | Path, *, on_floor: bool = False, **options: Any) -> Scene:  # noqa: ANN401 - of each format
    """Read a scene file in any known format.

    The suffix and the content of the file decide its format. ``options`` are passed on to the reader of that format.
    ``on_floor`` moves what was read vertically, as one, so that its lowest point is on the floor: on the level half
    space of the scene or, without one, on its only fixed body. Raises SceneError if no format recognises the file, if
    the file is invalid, if the format does not have an option, or if there is no such floor.
    """
    path = checked_path(path, "scene file")
    with located(str(path)):
        source = Source(path)
        scene = read_as(format_of(source), source, options)
        return on_the_floor(scene) if checked_truth(on_floor, "on_floor") else scene


def read_as(chosen: Format, source: Source, options: Mapping[str, Any]) -> Scene:
    """Read a file as the format that ``format_of`` found, with the options of its reader."""
    assert chosen.read is not None
    chosen.check_options(options)
    with counted():
        return _called(chosen, partial(chosen.read, source, **options))


def save_scene(scene: Scene, path: str | Path, **options: Any) -> None:  # noqa: ANN401 - each format has its own
    """Write a scene in the format that the suffix of ``path`` selects.

    The file is written completely or not at all. After saving in a native format (.yaml, .json), ``load_scene`` returns
    an equal scene, bit for bit. ``options`` are passed on to the writer of the format. Raises SceneError if no format
    with this suffix can be written, or if the format does not have an option.
    """
    path = checked_path(path, "scene file")
    if not isinstance(scene, Scene):
        raise SceneError(
            message(str(path), f"got {type(scene).__name__}", "needs a Scene, as an Assembly has in scene")
        )
    with located(str(path)):
        chosen = next((each for each in writable() if path.suffix.lower() in each.suffixes), None)
        if chosen is None:
            problem = f"suffix {path.suffix!r}"
            only = [each.name for each in readable() if path.suffix.lower() in each.suffixes]
            if only:
                problem += f" ({' and '.join(only)} can be read, not written)"
            known = ", ".join(f"{each.name} ({', '.join(each.suffixes)})" for each in writable())
            raise SceneError(message(str(path), problem, f"can be written: {known}"))
        assert chosen.write is not None
        _check_options(chosen, _keywords(chosen.write), options, ())
        if not chosen.holds:
            refuse_holds(scene.holds, f"format {chosen.name!r}", "save it as .yaml or .json")
        content = _called(chosen, partial(chosen.write, scene, path, **options))
    write_atomically(path, content)


def format_of(source: Source) -> Format:
    """Return the format that recognises the content; formats with the file's suffix are tried first.

    Raises SceneError if there is none.
    """
    own = [each for each in readable() if source.suffix in each.suffixes]
    others = [each for each in readable() if source.suffix not in each.suffixes]
    troubles = []
    for each in own + others:
        try:
            if each.sniff is not None and each.sniff(source):
                return each
        except SceneError as trouble:
            if each in own:
                troubles.append(trouble)
    for each in own:
        if each.sniff is None:  # if no content says otherwise, the suffix alone decides
            return each
    if troubles:
        raise troubles[0]
    problem = f"is in no known format ({source.described()})"
    only = [each.name for each in writable() if source.suffix in each.suffixes and each.read is None]
    if only:
        problem += f"; {' and '.join(only)} can be written, not read"
    known = ", ".join([*map(str, own), *(f"{each.name} ({', '.join(each.suffixes)})" for each in others)])
    raise SceneError(message(str(source.path), problem, f"can be read: {known}"))


def is_scene(path: str | Path) -> bool:
    """Return whether a file is to be read as a scene: False for YAML, JSON and XML of other programs.

    True, too, for what cannot be read and for damaged files that name a format, so that their errors are seen.
    """
    try:
        source = Source(Path(path))
        if source.suffix not in SHARED or any(mark in source.head for mark in MARKS):
            return True
    except SceneError:
        return True
    try:
        format_of(source)
    except SceneError:
        return False
    return True


def _keywords(function: Callable[..., Any]) -> tuple[str, ...]:
    parameters = inspect.signature(function).parameters.values()
    return tuple(each.name for each in parameters if each.kind is inspect.Parameter.KEYWORD_ONLY)


def _check_options(chosen: Format, known: Sequence[str], options: Iterable[str], others: Iterable[Format]) -> None:
    """Raise SceneError for an option that a format lacks, with the names of ``others`` that have it."""
    for option in options:
        if option not in known:
            near = difflib.get_close_matches(option, known, n=1)
            hint = f"did you mean {near[0]}=? " if near else ""
            having = (
                f"its options: {', '.join(f'{each}=' for each in known)}"
                if known
                else STANDS.get(option, "it has none")
            )
            with_it = ", ".join(each.name for each in others if option in each.options)
            formats = f"; formats with {option}=: {with_it}" if with_it else ""
            problem = f"is unknown to the format {chosen.name!r}"
            raise SceneError(message(f"option {option}=", problem, f"{hint}{having}{formats}"))


def _called(chosen: Format, function: Callable[[], T]) -> T:
    """Call a function of a format; if an optional package is missing, say how to install it, as HoldfastError."""
    try:
        return function()
    except ModuleNotFoundError as cause:
        if not chosen.extra:
            raise
        problem = f"needs {cause.name}, which is not installed"
        raise HoldfastError(message(f"format {chosen.name!r}", problem, installing(chosen.extra))) from cause
