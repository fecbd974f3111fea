"""The command ``holdfast``.

The help of the command lists the exit codes.
"""

from __future__ import annotations

import sys
import traceback
import warnings
from collections.abc import Callable
from typing import Annotated

import typer

from holdfast import __version__
from holdfast.base.errors import HoldfastError, HoldfastWarning, SolverError, UnstableError
from holdfast.cli.assess import assess, map_surfaces
from holdfast.cli.benchmark import benchmark
from holdfast.cli.common import EXIT, err, out
from holdfast.cli.disassemble import disassemble
from holdfast.cli.files import convert, print_schema
from holdfast.cli.place import place
from holdfast.cli.transport import transport
from holdfast.engines.verdict import Status

HELP = """How hard can you push here before something moves?

Exit codes: 0 it stands; 1 it does not stand; 2 bad input; 3 undecided: the verdict or, although it stands, every single
answer; 4 a defect of holdfast; 130 stopped by the user. For place and disassemble, 0 means that a place or an order
was found."""

app = typer.Typer(
    name="holdfast",
    help=HELP,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
BAD_INPUT, INTERNAL, STOPPED = 2, 4, 130
COMMANDS: dict[str, Callable[..., None]] = {
    "assess": assess,
    "map": map_surfaces,
    "place": place,
    "transport": transport,
    "disassemble": disassemble,
    "benchmark": benchmark,
    "convert": convert,
    "schema": print_schema,
}
for name, command in COMMANDS.items():
    app.command(name)(command)


def _version(value: bool) -> None:
    if value:
        out.print(f"holdfast {__version__}", highlight=False)
        raise typer.Exit


@app.callback()
def _main(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="print the version")
    ] = False,
) -> None:
    pass


def run() -> None:
    """Run the command line; an error is reported on one line and sets the exit code."""
    warnings.showwarning = _show_warning  # type: ignore[assignment]
    warnings.simplefilter("always", HoldfastWarning)
    try:
        sys.exit(app(standalone_mode=False) or 0)
    except SolverError as error:
        _complain("no answer", str(error))
        sys.exit(EXIT[Status.UNDECIDED])
    except UnstableError as error:
        _complain("unstable", str(error))
        sys.exit(EXIT[Status.UNSTABLE])
    except HoldfastError as error:
        _complain("error", str(error))
        sys.exit(BAD_INPUT)
    except (typer.Abort, KeyboardInterrupt):
        _complain("stopped", "by the user")
        sys.exit(STOPPED)
    except Exception as error:
        if isinstance(getattr(error, "exit_code", None), int):  # typer's own message about wrong usage
            error.show()  # type: ignore[attr-defined]
            sys.exit(BAD_INPUT)
        traceback.print_exc()
        _complain("internal error", "this is a defect in holdfast: please report it with the lines above")
        sys.exit(INTERNAL)


def _complain(kind: str, text: str) -> None:
    err.print(f"[bold red]{kind}:[/] ", end="")
    err.print(text, markup=False, highlight=False, soft_wrap=True)


def _show_warning(text: Warning | str, category: type[Warning], *_: object, **__: object) -> None:
    if issubclass(category, HoldfastWarning):
        err.print("[yellow]warning:[/] ", end="")
        err.print(str(text), markup=False, highlight=False, soft_wrap=True)


if __name__ == "__main__":
    run()
