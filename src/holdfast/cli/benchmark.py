"""The command ``benchmark``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from holdfast.cli.common import AsJson, out, print_json, progress
from holdfast.validation.benchmarks import runner
from holdfast.validation.benchmarks.checkout import results_folder
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
    as_json: AsJson = False,
) -> None:
    """Compare methods and their speed; without a name, list the benchmark suites."""
    if not names:
        listed = {name: suite(name).about for name in SUITES}
        if as_json:
            print_json(listed)
        else:
            for name, about in listed.items():
                out.print(f"{name}: {about}", highlight=False, soft_wrap=True)
        return
    chosen = [suite(name) for name in (SUITES if names == ["all"] else names)]
    folder = results_folder(results) if save or compare else None
    measured = {}
    for one in chosen:
        with progress():
            rows = runner.run(one, folder if save else None, fresh=fresh)
        measured[one.name] = rows
        if not as_json:
            text = f"\n## {one.name}\n\n{runner.written(one, rows)}"
            out.print(text, markup=False, highlight=False, soft_wrap=True)
            for line in runner.compared(one, rows, folder) if folder and compare else ():
                out.print(line, markup=False, highlight=False, soft_wrap=True)
        if folder and save:
            for path in runner.save(one, rows, folder):
                if not as_json:
                    out.print(f"wrote {path}", highlight=False, soft_wrap=True)
    if as_json:
        print_json(measured)
