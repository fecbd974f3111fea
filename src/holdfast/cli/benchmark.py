"""The command ``benchmark``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from holdfast.cli.common import (
    AsJson,
)
from holdfast.cli.output import out, print_json, write
from holdfast.cli.terminal import progress
from holdfast.validation.benchmarks import runner
from holdfast.validation.benchmarks.checkout import beside, results_folder
from holdfast.validation.benchmarks.registry import SUITES, suite


def benchmark(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[SUITE]...", help=f"{', '.join(SUITES)}, or all")
    ] = None,
    save: Annotated[
        bool, typer.Option("--save", help="save JSON, Markdown and a picture; an interrupted run resumes")
    ] = False,
    compare: Annotated[bool, typer.Option("--compare", help="show each time as a ratio to the saved one")] = False,
    results: Annotated[
        Path | None, typer.Option(metavar="DIR", help="folder of the saved results (default: that of the checkout)")
    ] = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="measure again what an interrupted run has measured")] = False,
    older: Annotated[
        Path | None, typer.Option("--beside", metavar="DIR", help="startup: also measure this older checkout")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Compare methods and their speed; without a name, list the benchmark suites."""
    if not names:
        listed = {name: suite(name).about for name in SUITES}
        if as_json:
            print_json(listed)
        else:
            for name, about in listed.items():
                out.say(f"{name}: {about}")
        return
    chosen = [suite(name) for name in (SUITES if names == ["all"] else names)]
    folder = results_folder(results) if save or compare else None
    measured = {}
    for one in chosen:
        with progress(), beside(older):
            rows = runner.run(one, folder if save else None, fresh=fresh)
        measured[one.name] = rows
        if not as_json:
            text = f"\n## {one.name}\n\n{runner.written(one, rows)}"
            write(f"{text}\n")
            for line in runner.compared(one, rows, folder) if folder and compare else ():
                out.say(line)
        if folder and save:
            for path in runner.save(one, rows, folder):
                if not as_json:
                    out.say(f"wrote {path}")
    if as_json:
        print_json(measured)
