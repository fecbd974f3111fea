"""The command ``check``."""

from __future__ import annotations

from collections import Counter
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

from holdfast.base.errors import HoldfastError, message
from holdfast.batches.gate import FAILED, PASSED, UNDECIDED, Result, Rules, Scenes, findings
from holdfast.batches.resources import Resources
from holdfast.batches.result import read_batch
from holdfast.cli.batch_commands import Globs, Megabytes, Options, Running, Seconds, Workers
from holdfast.cli.common import AsJson
from holdfast.cli.output import out, print_json
from holdfast.report.batch_report import write_junit

CODES: dict[Result, int] = {FAILED: 1, UNDECIDED: 3}


def check(
    scenes: Globs,
    stands: Annotated[bool, typer.Option("--stands", help="every scene must stand")] = False,
    min_force: Annotated[
        float | None, typer.Option(help="no push of this many N, on a map or of --push, may move anything")
    ] = None,
    push: Annotated[Path | None, typer.Option(help="CSV of pushes for --min-force; default: a map")] = None,
    baseline: Annotated[Path | None, typer.Option(metavar="DIR", help="--out of an earlier check or batch")] = None,
    distance: Annotated[float, typer.Option(help="baseline: a body may have moved by this in m")] = 1e-6,
    turn_degrees: Annotated[float, typer.Option(help="baseline: a body may have turned by this in degrees")] = 1e-4,
    change: Annotated[float, typer.Option(help="baseline: share by which the weakest push may change")] = 0.01,
    folder: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="keep the tables here")] = None,
    junit: Annotated[Path | None, typer.Option(help="write the findings as JUnit XML to this file")] = None,
    options: Options = None,
    workers: Workers = None,
    seconds: Seconds = 60.0,
    megabytes: Megabytes = Resources.megabytes,
    as_json: AsJson = False,
) -> None:
    """Check that many scenes stand or withstand pushes, and what changed since a baseline.

    The exit code is 0 if all scenes pass; 1 if some fail, or changed by more than the tolerances; 2 for bad input; 3 if
    none fails and some are undecided.
    """
    if not stands and min_force is None and baseline is None:
        raise HoldfastError(message("check", "there is nothing to check", "give --stands, --min-force or --baseline"))
    pushes = [] if min_force is None else ["map" if push is None else f"push:{push}"]
    rules = Rules(stands, min_force, distance, turn_degrees, change)
    with ExitStack() as stack:
        before = None if baseline is None else Scenes.of(read_batch(baseline))
        place = Path(stack.enter_context(TemporaryDirectory())) / "batch" if folder is None else folder
        Running(workers, seconds, megabytes).ask(scenes, ["stability", *pushes], place, options)
        found = list(findings(Scenes.of(read_batch(place)), rules, before))
    if junit is not None:
        write_junit(found, junit)
    counts: Counter[str] = Counter(each.result for each in found)
    if as_json:
        print_json({"counts": dict(counts), "findings": [each._asdict() for each in found]})
    else:
        for each in found:
            if each.result != PASSED:
                out.say(f"{each.scene}: {each.reason}", label=f"{each.result}:")
        out.say(", ".join(f"{counts[name]:,} {name}" for name in (PASSED, FAILED, UNDECIDED)))
    raise typer.Exit(next((code for result, code in CODES.items() if counts[result]), 0))
