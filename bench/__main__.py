"""``python -m bench``, from the root of a checkout: run benchmark suites, and put their numbers into the pages."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from bench import runner
from bench.checkout import RESULTS, ROOT, beside
from bench.figures import pages
from bench.registry import SUITES, suite
from holdfast.base.errors import HoldfastError
from holdfast.cli.output import err, make_writable, out, print_json, progress, write

app = typer.Typer(
    help="What was measured of holdfast, and how to measure it again.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
AsJson = Annotated[bool, typer.Option("--json", help="print JSON; infinity is the text inf")]
Results = Annotated[Path, typer.Option(metavar="DIR", help="folder of the saved results", show_default=False)]


@app.command("list")
def list_suites(as_json: AsJson = False) -> None:
    """List the suites and what they measure."""
    listed = {name: suite(name).about.splitlines()[0] for name in SUITES}
    if as_json:
        print_json(listed)
        return
    for name, about in listed.items():
        out.say(f"{name}: {about}")


@app.command()
def run(
    names: Annotated[list[str], typer.Argument(metavar="SUITE...", help="suites by name, or all")],
    save: Annotated[
        bool, typer.Option("--save", help="save JSON, Markdown and a picture; an interrupted run resumes")
    ] = False,
    compare: Annotated[bool, typer.Option("--compare", help="show each time as a ratio to the saved one")] = False,
    results: Results = RESULTS,
    fresh: Annotated[bool, typer.Option("--fresh", help="measure again what an interrupted run has measured")] = False,
    older: Annotated[
        Path | None, typer.Option("--beside", metavar="DIR", help="startup, scans: also measure this older checkout")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Measure suites, and print their rows."""
    chosen = [suite(name) for name in (SUITES if names == ["all"] else names)]
    measured = {}
    for one in chosen:
        with progress(), beside(older):
            rows = runner.run(one, results if save else None, fresh=fresh)
        measured[one.name] = rows
        if not as_json:
            write(f"\n## {one.name}\n\n{runner.written(one, rows)}\n")
            for line in runner.compared(one, rows, results) if compare else ():
                out.say(line)
        for path in runner.save(one, rows, results) if save else ():
            if not as_json:
                out.say(f"wrote {path}")
    if as_json:
        print_json(measured)


@app.command()
def figures(
    check: Annotated[bool, typer.Option("--check", help="write nothing; exit code 1 where a page differs")] = False,
    results: Results = RESULTS,
    root: Annotated[
        Path, typer.Option(metavar="DIR", help="checkout whose README.md and docs/ are meant", show_default=False)
    ] = ROOT,
) -> None:
    """Put the numbers and tables of the saved results into the pages."""
    for path in () if check else pages.refresh(root, results):
        out.say(f"wrote {path.relative_to(root)}")
    wrong = pages.all_faults(root, results)
    for fault in wrong:
        err.say(fault)
    if wrong:
        raise typer.Exit(1)


def main() -> None:
    """Run the command; an error of holdfast's own is one line, with exit code 2."""
    make_writable()
    try:
        app()
    except HoldfastError as error:
        err.say(str(error), label="error:", style="bold red")
        sys.exit(2)


if __name__ == "__main__":
    main()
