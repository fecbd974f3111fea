"""The command ``holdfast``. Its help lists the exit codes."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import sys
import traceback
import warnings
from collections.abc import Sequence
from functools import partial
from importlib import import_module
from itertools import takewhile
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from holdfast import __version__
from holdfast.base.errors import HoldfastError, HoldfastWarning, SolverError, UnstableError, message, nearest_of
from holdfast.base.plugins import load_plugin
from holdfast.base.text import quoted
from holdfast.cli.output import OutputLost, abandon, err, make_writable, out, write
from holdfast.cli.stopping import STOPPED, interrupted, stoppable

HELP = """How hard can you push here before something moves?

Exit codes: 0 it stands; 1 it does not stand; 2 bad input; 3 undecided: the verdict or, although it stands, every single
answer; 4 a defect of holdfast; 130 stopped by the user; 141 the output pipe was closed. For place, disassemble and
build, 0 means that a place or an order was found, for remove that the body may be taken out, for safe that the effect
of some push is known."""

TASKS = (  # what most people come for, on a scene that is shipped
    ("does it stand?", "holdfast assess table"),
    ("how hard can I push here?", "holdfast push table slab --at -0.25 0 0.24 --along 1 0 0"),
    ("where is it weak?", "holdfast map table --html map.html"),
    ("how fast may I carry it?", "holdfast transport table"),
    ("are these scenes sound?", "holdfast check 'scenes/*.yaml' --stands"),
)

BAD_INPUT, INTERNAL, NOT_STABLE, NO_ANSWER = 2, 4, 1, 3  # exit codes
PIPE_CLOSED = 141  # exit code of a command that was stopped by a closed pipe, as in a shell
COMMANDS = {  # the module and the function of each command, which is imported when it is called, and its help text
    "assess": ("push_commands:assess", "Decide whether a scene stands, and explain why."),
    "push": ("push_commands:push", "Compute how hard a body can be pushed at a point before anything moves."),
    "map": ("push_commands:map_surfaces", "Compute the largest push at points of all exposed surfaces."),
    "calibrate": ("calibrate_command:calibrate", "Find the friction of pairs of bodies from measured pushes."),
    "view": ("view_command:view", "Open a live view of a scene: push, play and edit it in the browser."),
    "place": ("pose_commands:place", "Find places for objects where everything stands."),
    "firmer": (
        "pose_commands:firmer",
        "Move bodies a little, to where the least push that moves something is larger.",
    ),
    "rest": ("pose_commands:rest", "List all poses in which one body rests on a level plane."),
    "settle": ("pose_commands:settle", "Bring a perceived or authored scene to rest near its poses."),
    "transport": ("carrier_commands:transport", "Compute how fast the carrier of a scene may accelerate."),
    "carry": ("carrier_commands:carry", "Decide whether a scene holds while its carrier moves."),
    "batch": ("batch_commands:batch", "Answer the same question about many scenes, as tables in a folder."),
    "report": ("batch_commands:report", "Write the report of a batch as one page."),
    "check": ("batch_commands:check", "Check that many scenes stand, and what changed since a baseline."),
    "remove": ("order_commands:remove", "Decide whether one body may be taken out now, and who moves if not."),
    "build": ("order_commands:build", "Find an order in which bodies can be put in, each state standing."),
    "safe": ("pose_commands:safe", "Find where a body can be pushed without moving any other."),
    "disassemble": ("order_commands:disassemble", "Find an order in which bodies can be taken out."),
    "convert": ("file_commands:convert", "Read a scene in any known format and write it in another."),
    "verify": ("light_commands:verify", "Check that a certificate proves what it claims."),
    "schema": ("file_commands:print_schema", "Print the JSON schema of scene files, certificates or answers."),
    "mcp": ("mcp_command:mcp", "Serve the tools stands, push, settle, place and explain to agents."),
    "doctor": ("light_commands:doctor", "Report what is installed and what is missing."),
}


# An option as Python takes it, such as floor=True, and not within a call, a name or a path
IN_PYTHON = re.compile(
    r"""(?<![\w./(=-])(?<!["'])([a-z_]+)=(\{[^}]*\}|\[[^]]*\]|\([^)]*\)|"[^"]*"|'[^']*'|[\w.]*\w)?"""
)
BRACKETS = re.compile("""[][{}()"']""")


def in_flags(text: str, options: dict[str, Any]) -> str:
    """Return an error or a warning with the options of Python in it as flags, those of a command by their names."""

    def flag(option_in_python: re.Match[str]) -> str:
        name, value = option_in_python.groups("")
        option = options.get({"poses": "pose", "bodies": "objects"}.get(name, name))
        if option is None or value.startswith("hf."):
            return option_in_python[0]
        if option.is_flag:
            value = ""
        elif value == "True":
            value = option.metavar
        return f"{option.opts[0]} {BRACKETS.sub('', value).replace(': ', '=')}".strip()

    return IN_PYTHON.sub(flag, text)


class Command(TyperCommand):
    """One command. The numbers of a vector option may be separated by spaces or by commas."""

    def invoke(self, ctx: Any) -> Any:  # noqa: ANN401 - typer's own types
        """Call the command; its errors and warnings name flags where those of Python name options."""
        options = {str(each.name): each for each in self.params if each.opts[0].startswith("--")}
        warnings.showwarning = partial(_show_warning, options)
        try:
            return super().invoke(ctx)
        except HoldfastError as error:
            error.args = (in_flags(str(error), options),)
            raise

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:  # noqa: ANN401 - typer's own types
        """Treat ``--at 0.1,0,0.2`` and ``--at=0.1,0,0.2`` like ``--at 0.1 0 0.2``.

        If words are left over after an option that may be repeated, the error says to repeat it before each of them. If
        a vector has too few numbers, it says what was given and how many it needs.
        """
        if any(each.nargs == -1 for each in self.params):
            _refuse_files_as_options(args)
        several = {flag: each.nargs for each in self.params for flag in each.opts if each.nargs > 1}
        spread: list[str] = []
        for arg in args:
            flag, joined, value = arg.partition("=")
            if joined and flag in several:
                spread.append(flag)
            else:
                value = arg
            count = several.get(spread[-1], 0) if spread else 0
            parts = value.split(",")
            spread += parts if len(parts) == count else [value]
        repeated = {flag for each in self.params if getattr(each, "multiple", False) for flag in each.opts}
        given = next((flag for flag in spread if flag in repeated), None)
        try:
            return super().parse_args(ctx, list(spread))
        except Exception as error:  # typer's own
            if given is not None and "unexpected extra argument" in getattr(error, "message", ""):
                error.message += f"; say {given} before each: {given} A {given} B"  # type: ignore[attr-defined]
            short = getattr(error, "option_name", None)  # of a vector that ends the line with too few numbers
            if short == "--plugin":
                error.message = "--plugin goes before the command: holdfast --plugin NAME assess SCENE"  # type: ignore[attr-defined]
                error.possibilities = None  # type: ignore[attr-defined]
            vector = getattr(error, "param", None) or next((each for each in self.params if short in each.opts), None)
            if vector is not None and vector.nargs > 1 and hasattr(error, "message"):
                error.message = ("" if short is None else f"Invalid value for '{short}': ") + _needs(vector, spread)
            raise


def _needs(vector: Any, words: Sequence[str]) -> str:  # noqa: ANN401 - typer's own types
    """Return what the words of a command say for an option of several numbers, if anything, and what it needs."""
    form = vector.metavar or " ".join(["NUMBER"] * vector.nargs)
    numbers = f"{vector.nargs} numbers: {vector.opts[0]} {form}"
    behind = next((words[k + 1 :] for k, word in enumerate(words) if word in vector.opts), ())
    given = tuple(takewhile(lambda word: not word.startswith("--"), behind))[: vector.nargs]
    return f"is {quoted(' '.join(given))}; needs {numbers}" if given else f"Give {numbers}"


def _refuse_files_as_options(args: Sequence[str]) -> None:
    """Raise HoldfastError for a file whose name would be taken for an option: a wildcard or a hook may name it."""
    for arg in takewhile(lambda arg: arg != "--", args):
        if arg.startswith("-") and os.path.lexists(arg):
            problem = "is a file here, and reads like an option"
            raise HoldfastError(
                message(quoted(arg), problem, "put -- before the names of files, or ./ before this one")
            )


class Commands(TyperGroup):
    """The commands. Only the module of the one that is called is imported."""

    _called = ""

    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ANN401 - typer's own types
        """Return the names, in the order of the help."""
        return list(COMMANDS)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:  # noqa: ANN401
        """Return the command that the arguments call."""
        self._called = args[0]
        if self._called not in COMMANDS:
            raise HoldfastError(
                message("command", f"{quoted(self._called)} is unknown", nearest_of(self._called, COMMANDS))
            )
        return super().resolve_command(ctx, args)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ANN401
        """Return the command that is called; for any other, a command with its help text only."""
        if cmd_name not in COMMANDS:
            return None
        place, text = COMMANDS[cmd_name]
        if cmd_name != self._called:
            return TyperCommand(cmd_name, help=text)
        module, _, function = place.partition(":")
        alone = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
        alone.command(cmd_name, cls=Command)(getattr(import_module(f"holdfast.cli.{module}"), function))
        return typer.main.get_command(alone)


app = typer.Typer(
    name="holdfast",
    cls=Commands,
    help=HELP,
    invoke_without_command=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def _version(value: bool) -> None:
    if value:
        out.say(f"holdfast {__version__}")
        raise typer.Exit


@app.callback()
def _main(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="print the version")
    ] = False,
    plugin: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="load this plug-in (holdfast doctor lists them)")
    ] = None,
) -> None:
    for name in plugin or ():
        err.say(f"{name}: {load_plugin(name)}", label="loaded plug-in", style="yellow")
    if context.invoked_subcommand is None:
        out.say("How hard can you push an assembly before something moves? Try:")
        for task, command in TASKS:
            out.say(f"  {task:<26} {command}")
        out.say("`table` is shipped; name a file of your own instead: YAML, URDF, SDF, MJCF, USD, meshes and more.")
        out.say("`holdfast --help` lists all commands, `holdfast assess --help` the options of one.")


def run() -> None:
    """Run the command line; an error is reported on one line and sets the exit code."""
    make_writable()
    warnings.showwarning = partial(_show_warning, {})
    warnings.simplefilter("always", HoldfastWarning)
    with stoppable():
        try:
            code = _called()
        except OutputLost as lost:
            code = _lost(lost)
        sys.exit(code)


def _called() -> int:
    """Run the command and return its exit code."""
    try:
        code = app(standalone_mode=False) or 0
        write("")
    except Exception as error:
        if interrupted() or isinstance(error, typer.Abort):  # libraries may turn an interrupt into their own errors
            raise KeyboardInterrupt from None
        return _explained(error)
    if code == STOPPED:  # typer catches the interrupt
        raise KeyboardInterrupt
    return int(code)


def _explained(error: Exception) -> int:
    """Print an error and return the exit code; raise OutputLost if the output could not be written."""
    match error:
        case OutputLost():
            raise error
        case OSError():  # errors on files are HoldfastErrors, so this one is about the output stream
            raise OutputLost(error) from error
        case SolverError():
            return _complain("no answer", error, NO_ANSWER)
        case UnstableError():
            return _complain("unstable", error, NOT_STABLE)
        case HoldfastError():
            return _complain("error", error, BAD_INPUT)
    if isinstance(getattr(error, "exit_code", None), int):  # typer's own message about wrong usage
        error.show()  # type: ignore[attr-defined]
        return BAD_INPUT
    traceback.print_exception(error)
    return _complain("internal error", "this is a defect in holdfast: please report it with the lines above", INTERNAL)


def _lost(lost: OutputLost) -> int:
    """Print why the output was lost, unless its reader closed the pipe, and return the exit code."""
    abandon()
    if lost.reason == errno.EPIPE:
        return PIPE_CLOSED
    return _complain("error", message("output", f"cannot be written: {lost}", "check where it goes"), BAD_INPUT)


def _complain(kind: str, text: object, code: int) -> int:
    """Print an error to stderr, if it has one, and return the exit code."""
    with contextlib.suppress(OutputLost):
        err.say(str(text), label=f"{kind}:", style="bold red")
    return code


def _show_warning(
    options: dict[str, Any], text: Warning | str, category: type[Warning], *_: object, **__: object
) -> None:
    if issubclass(category, HoldfastWarning):
        err.say(in_flags(str(text), options), label="warning:", style="yellow")


if __name__ == "__main__":
    run()
