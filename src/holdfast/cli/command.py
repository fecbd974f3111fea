"""A command is a function: its signature and docstring say what it takes, ``question`` does what all of them do.

That is the options of the scene, of engines and of files, the notes, the report or the envelope, and the exit code.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, cast, get_type_hints

import typer

from holdfast.base.envelope import EXIT, enveloped, verdict_of
from holdfast.base.errors import PNG_INSTALL, PNG_NEEDS, HoldfastError, message
from holdfast.base.plugins import plugin_notes
from holdfast.base.public import PublicValue
from holdfast.cli.assignments import option, options_of, value_of
from holdfast.cli.output import AsJson, out, print_json, progress
from holdfast.engines.contract import Engine
from holdfast.engines.graph.engine import Graph
from holdfast.queries.request import DEFAULT_ENGINE, ENGINES, engine_of

if TYPE_CHECKING:
    from holdfast.report.description import Report

Vector = tuple[float, float, float]
File = Path | None
Several = list[str] | None
EngineName = Annotated[str, option(f"one of: {', '.join(ENGINES)}", "--engine")]
Nodes = Annotated[int | None, option("contact nodes: graph per interface, compliant per patch side")]
PNG = "write a PNG picture to this file"
SAVE = "write the answer to this file (.json or .npz)"
PROOF = "also write a proof for others"
PICTURES = ("png", "html", "glb", "ply")  # options of files with that suffix


@dataclass(frozen=True, kw_only=True)
class OptionSet:
    """Options that several commands take: each field is one, annotated as typer wants it."""


@dataclass(frozen=True, kw_only=True)
class EngineGiven(OptionSet):
    """The engine of a command."""

    engine: EngineName = DEFAULT_ENGINE
    nodes: Nodes = None

    def chosen(self, **options: Any) -> Engine:  # noqa: ANN401 - options of the engine
        """Return the engine, with further options; raise HoldfastError if it lacks one that is not at its default."""
        choice: Any = engine_of(self.engine)
        usual = {each.name: each.default for each in fields(Graph)} | {"nodes": None}
        given = {"nodes": self.nodes} | options
        changed = {key: value for key, value in given.items() if value != usual[key]}

        def known(engine: Any) -> set[str]:  # noqa: ANN401 - a dataclass
            return {each.name for each in fields(engine)}

        for key in [key for key in changed if key not in known(choice)]:
            having = [name for name, make in ENGINES.items() if key in known(make())]
            remedy = f"leave it out, or use --engine {' or '.join(having)}"
            problem = f"engine {self.engine!r} has no such option"
            raise HoldfastError(message("--" + key.replace("_", "-"), problem, remedy))
        return cast(Engine, dataclasses.replace(choice, **changed))


@dataclass(frozen=True)
class CommandAnswer:
    """An answer with what a command tells besides.

    ``notes``, such as those of the scene, are printed below the report and come before those of the answer in JSON, as
    ``details`` come after its own. ``files`` are pairs of a path, or None, and a function that writes there. ``report``
    replaces that of the command.
    """

    answer: Any
    notes: Sequence[str] = ()
    details: dict[str, Any] = field(default_factory=dict)
    files: Sequence[tuple[File, Callable[[Path], object]]] = ()
    report: Callable[[Any], Report] | None = None


def question(report: Callable[[Any], Report] | None = None, **files: str) -> Callable[[Any], Callable[..., None]]:
    """Make a command of a function that takes a scene and returns an answer, or one that is a ``CommandAnswer``.

    ``report`` returns what is printed. ``files`` are the files that the answer can write itself, each with the help of
    its option: ``png`` by its ``save_png``, ``certificate`` by ``save_certificate``, ``save`` by ``save``.
    """

    def command_of(function: Callable[..., Any]) -> Callable[..., None]:
        @functools.wraps(function)
        def command(*scene: Any, as_json: bool, **given: Any) -> None:  # noqa: ANN401
            paths: dict[str, File] = {name: given.pop(name) for name in files}
            for name in paths.keys() & set(PICTURES):
                check_suffix(paths[name], f".{name}")
            with progress():
                answer = function(*scene, **given)
            tell(answer if isinstance(answer, CommandAnswer) else CommandAnswer(answer), report, paths, as_json=as_json)

        own = inspect.signature(function)
        kinds = {name: Annotated[File, option(text, f"--{name}")] for name, text in files.items()}
        common = [_keyword(name, None, kind) for name, kind in kinds.items()] + [_keyword("as_json", False, AsJson)]
        command.__signature__ = own.replace(parameters=[*own.parameters.values(), *common])  # type: ignore[attr-defined]
        command.__annotations__ = get_type_hints(function, include_extras=True) | kinds | {"as_json": AsJson}
        return takes_scene(command)

    return command_of


def tell(
    told: CommandAnswer, report: Callable[[Any], Report] | None, paths: Mapping[str, File], *, as_json: bool
) -> NoReturn:
    """Write the files that are named, print the envelope or the report, and exit with the code of the verdict."""
    answer: PublicValue = told.answer
    proof = paths.get("certificate")
    pictures = [(path, _writer(answer, name)) for name, path in paths.items() if name in PICTURES]
    saved = [(path, _writer(answer, name)) for name, path in paths.items() if name == "save"]
    written = [(path, write) for path, write in (*pictures, *told.files, *saved) if path is not None]
    for path, write in written:
        write(path)
    if as_json:
        print_json(enveloped(answer, details=told.details, notes=[*plugin_notes(), *told.notes]))
    else:
        shown = told.report or report
        assert shown is not None
        out.print(shown(answer))
        for note in told.notes:
            out.say(note, label="note:", style="yellow")
        for path, _ in written:
            out.say(f"wrote {path}")
    if proof is not None:
        _writer(answer, "certificate")(proof)
        if not as_json:
            out.say(f"wrote {proof}")
    raise typer.Exit(EXIT[verdict_of(answer)])


def _writer(answer: PublicValue, name: str) -> Callable[[Path], object]:
    """Return the method of an answer that writes the file of the option with this name."""
    return cast("Callable[[Path], object]", getattr(answer, "save" if name == "save" else f"save_{name}"))


def check_suffix(path: File, suffix: str) -> None:
    """Raise HoldfastError if a file has the wrong suffix, or cannot be written because matplotlib is missing.

    To be called before anything is computed.
    """
    if path is None:
        return
    if path.suffix.lower() != suffix:
        raise HoldfastError(message(f"--{suffix[1:]}", f"{path} does not end in {suffix}", f"name a {suffix} file"))
    if suffix == ".png" and find_spec("matplotlib") is None:
        raise HoldfastError(message("--png", PNG_NEEDS, f"{PNG_INSTALL}, or leave it out"))


def takes_scene(command: Callable[..., None]) -> Callable[..., None]:
    """Expand the first parameter of a command, a set of options that says which scene, into options for its fields.

    Its first field becomes the first argument, and its other fields become options after those of the command, except
    those whose name it gives to an option of its own. Other parameters whose type is a dataclass, such as
    ``EngineGiven`` or ``Where``, are expanded too.
    """
    hints = get_type_hints(command, include_extras=True)
    first, *others = inspect.signature(command).parameters.values()
    sets: dict[str, type] = {first.name: hints[first.name]}
    own: list[inspect.Parameter] = []
    values: dict[str, type] = {}
    for each in others:
        kind = hints[each.name]
        if isinstance(kind, type) and issubclass(kind, OptionSet):
            sets[each.name] = kind
            own += _options(kind)
        elif is_dataclass(kind):
            values[each.name] = cast(type, kind)
            own += options_of(values[each.name])
        else:
            own.append(_keyword(each.name, each.default, kind))
    names = {each.name for each in own}
    whole = [each for each in _options(sets[first.name]) if each.name not in names]
    parameters = [whole[0], *own, *whole[1:]]

    @functools.wraps(command)
    def called(**given: Any) -> None:  # noqa: ANN401
        made = {name: value_of(kind, given) for name, kind in values.items()}
        for name, kind in sets.items():
            taken = [each.name for each in (whole if name == first.name else _options(kind))]
            made[name] = kind(**{each: given.pop(each) for each in taken})
        command(made.pop(first.name), **given, **made)

    called.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    called.__annotations__ = {each.name: each.annotation for each in parameters}
    return called


def _options(kind: type) -> list[inspect.Parameter]:
    """Return a parameter for each field of a set of options."""
    hints, absent = get_type_hints(kind, include_extras=True), dataclasses.MISSING
    return [
        _keyword(each.name, inspect.Parameter.empty if each.default is absent else each.default, hints[each.name])
        for each in fields(kind)
    ]


def _keyword(name: str, default: Any, kind: Any) -> inspect.Parameter:  # noqa: ANN401 - of any type
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)
