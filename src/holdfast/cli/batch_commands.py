"""The commands about many scenes: batch, report and check."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any, NoReturn

import typer

from holdfast.base.arrays import checked_number
from holdfast.base.envelope import EXIT, envelope, enveloped, verdict_of
from holdfast.base.errors import HoldfastError, message
from holdfast.base.files import read_ordinary
from holdfast.base.plugins import plugin_notes
from holdfast.base.text import listed, many
from holdfast.batches.gate import FAILED, UNDECIDED, Finding, GateRules, Result, Scenes, findings
from holdfast.batches.inputs import inputs_of
from holdfast.batches.result import read_batch
from holdfast.batches.run import Resources
from holdfast.batches.run import batch as run_batch
from holdfast.batches.states import ModelStates, states_of
from holdfast.cli.output import AsJson, out, print_json, progress
from holdfast.report.batch_report import write_report
from holdfast.report.gate_report import counted, write_junit, write_summary
from holdfast.scene.formats.registry import is_scene

MOST_BYTES = 1_000_000  # of a file of options
PAGE = "report.html"
WORDS: dict[Result, str] = {FAILED: "unstable", UNDECIDED: "undecided"}  # verdicts of check

Globs = Annotated[
    list[str], typer.Argument(metavar="GLOB...", help="scene files, folders, quoted globs (** too), .csv, .parquet")
]
Options = Annotated[Path | None, typer.Option(help='JSON: {"engine": ..., "load": {"friction": 0.5}, "map": {...}}')]
Workers = Annotated[int | None, typer.Option(help="processes; default: one for each core")]
Seconds = Annotated[float, typer.Option(help="longest time of a scene in s")]
Megabytes = Annotated[float, typer.Option(help="most memory of a scene in MB")]
Scheduler = Annotated[str | None, typer.Option(help="address of a Dask scheduler, such as tls://host:8786")]
States = Annotated[
    Path | None,
    typer.Option(help="states of the only scene, a MuJoCo model: .npy, .npz, .csv, .hdf5; each is a scene"),
]
MOST_NOTES = 8  # of readers, that a check prints
Every = Annotated[bool, typer.Option("--every-state", help="HDF5: all states of each demonstration, not its first")]
Certificate = Annotated[Path | None, typer.Option(help="PEM file for tls://")]


def batch(
    scenes: Globs,
    folder: Annotated[Path, typer.Option("--out", metavar="DIR", help="folder of the tables; resumes what is there")],
    ask: Annotated[
        list[str] | None, typer.Option(help="stability (default), settle, map, transport, push:FILE; commas between")
    ] = None,
    options: Options = None,
    workers: Workers = None,
    seconds: Seconds = 60.0,
    megabytes: Megabytes = Resources.megabytes,
    shard_size: Annotated[int, typer.Option(help="scenes in a file of each table")] = Resources.shard_size,
    shard: Annotated[str | None, typer.Option(metavar="I/N", help="only each N-th shard from I on: arrays")] = None,
    states: States = None,
    every: Every = False,
    retry: Annotated[str, typer.Option(help="outcomes to ask again: error, time, memory, crash")] = "",
    scheduler: Scheduler = None,
    tls_ca: Certificate = None,
    tls_cert: Certificate = None,
    tls_key: Certificate = None,
    as_json: AsJson = False,
) -> None:
    """Answer the same question about many scenes in processes with limits, and write the answers as tables.

    The same command resumes a batch that was stopped. The exit code is 0 if every scene was answered, whatever the
    answers, and 3 if some were not: their rows say why.
    """
    again, own = tuple(filter(None, retry.split(","))), _read(options)
    named = _scenes(scenes)
    given = None if states is None else states_of(named, states, own.get("load", {}), every=every)
    files = {"tls_ca_file": tls_ca, "tls_client_cert": tls_cert, "tls_client_key": tls_key}
    with progress(), _client(scheduler, files) as where:
        result = run_batch(
            named if given is None else given,
            ",".join(ask or ["stability"]).split(","),
            out=folder,
            workers=workers,
            options=own,
            seconds=seconds,
            retry=again,
            resources=Resources(megabytes, where, shard, shard_size),
        )
    if as_json:
        print_json(enveloped(result, rows=list(read_batch(folder).data()), notes=plugin_notes()))
    else:
        summary = result.summary()
        out.say(summary.headline)
        for fact in summary.facts:
            out.say(": ".join(fact))
        for row in summary.rows:
            out.say(f"{row[1]}: {row[0]}: {row[2]}")
    raise typer.Exit(EXIT[verdict_of(result)])


def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="the folder of a batch")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help=f"default: {PAGE} in the folder")] = None,
) -> None:
    """Write the report of a batch as one page: shares, distributions, pictures of the weakest, and failures."""
    path = folder / PAGE if output is None else output
    write_report(folder, path)
    out.say(f"wrote {path}")


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
    summary: Annotated[Path | None, typer.Option(help="write them as a table for the page of a CI run")] = None,
    scenes_only: Annotated[
        bool, typer.Option("--scenes-only", help="pass over YAML, JSON and XML files that are no scenes")
    ] = False,
    gap: Annotated[float | None, typer.Option(help="surfaces touch if they are this near, in m; as of assess")] = None,
    states: States = None,
    every: Every = False,
    fix: Annotated[
        Path | None, typer.Option(help="write the file of --states with settled states for those that do not stand")
    ] = None,
    travel: Annotated[float | None, typer.Option(help="a state settles by at most this in m; default: 0.03")] = None,
    options: Options = None,
    workers: Workers = None,
    seconds: Seconds = 60.0,
    megabytes: Megabytes = Resources.megabytes,
    as_json: AsJson = False,
) -> None:
    """Check that many scenes stand or withstand pushes, and what changed since a baseline.

    With --states every state of a model is a scene, and for those that do not stand it is said what hovers, sinks and
    falls, and how far they would settle. The exit code is 0 if all scenes pass; 1 if some fail, or changed by more than
    the tolerances; 2 for bad input; 3 if none fails and some are undecided.
    """
    if not stands and min_force is None and baseline is None:
        raise HoldfastError(message("check", "there is nothing to check", "give --stands, --min-force or --baseline"))
    pushes = [] if min_force is None else ["map" if push is None else f"push:{push}"]
    rules = GateRules(stands, min_force, distance, turn_degrees, change)
    with ExitStack() as stack:
        before = None if baseline is None else Scenes.of(read_batch(baseline))
        named, others = _sorted_out(_scenes(scenes), scenes_only)
        own = _with_gap(_read(options), gap)
        given = None if states is None else states_of(named, states, own.get("load", {}), every=every)
        place = Path(stack.enter_context(TemporaryDirectory())) / "batch" if folder is None else folder
        limits, ask = Resources(megabytes), ["stability", *_settling(given, fix, travel, own), *pushes]
        about = named if given is None else given
        with progress():
            run_batch(about, ask, out=place, workers=workers, options=own, seconds=seconds, resources=limits)
        tables = read_batch(place)
        verdicts = list(findings(Scenes.of(tables), rules, before))
        answers = {row["details"]["scene"]: row for row in tables.data()}
        fixed, left = given.fix(tables, fix) if given is not None and fix is not None else ([], [])
    for path, write in ((junit, write_junit), (summary, write_summary)):
        if path is not None:
            write(verdicts, path)
    said = counted(verdicts) + (f"; passed over {many(others, 'file')} without a scene" if others else "")
    written = {} if fix is None else {"written": str(fix), "fixed": fixed, "left": left}
    notes = [*(plugin_notes() if as_json else ()), *_notes(given, fix, fixed, left)]
    if not as_json:  # where each scene has its own
        told = Counter(note for answer in answers.values() for note in answer["notes"])
        notes += [f"{note} ({many(count, 'scene')})" for note, count in told.most_common(MOST_NOTES)]
        notes += [f"{many(len(told) - MOST_NOTES, 'further note')}: --json"] if len(told) > MOST_NOTES else []
    _tell_checks(verdicts, said, notes, written, answers if as_json else None)


def _tell_checks(
    verdicts: Sequence[Finding],
    said: str,
    notes: Sequence[str],
    details: dict[str, Any],
    answers: Mapping[str, dict[str, Any]] | None,
) -> NoReturn:
    """Print what was found in words or, with the ``answers`` by the names of scenes, in JSON; exit by the verdict."""
    counts: Counter[str] = Counter(each.result for each in verdicts)
    verdict = next((word for result, word in WORDS.items() if counts[result]), "stable")
    if answers is not None:
        rows = [_checked(each, answers) for each in verdicts]
        details = {"counts": dict(counts)} | details
        print_json(envelope("check", verdict=verdict, reason=said, rows=rows, details=details, notes=notes))
    else:
        for each in verdicts:
            if each.result in WORDS:
                out.say(f"{each.scene}: {each.reason}", label=f"{each.result}:")
        for remedy in [each.remedy for each in verdicts if each.remedy][:1]:
            out.say(remedy, label="next:")
        out.say(said)
        for note in notes:
            out.say(note, label="note:", style="yellow")
    raise typer.Exit(EXIT[verdict])


def _settling(given: ModelStates | None, fix: Path | None, travel: float | None, options: dict[str, Any]) -> list[str]:
    """Return the further question about states, with its options; raise HoldfastError for options that need states."""
    if given is None:
        for name, value in (("--fix", fix), ("--travel", travel)):
            if value is not None:
                raise HoldfastError(message(name, "is about states", "give --states FILE"))
        return []
    if fix is not None:
        given.check_target(fix)
    if travel is not None:
        options["settle"] = dict(options.get("settle", {})) | {"travel": travel}
    return ["settle"]


def _notes(given: ModelStates | None, fix: Path | None, fixed: list[str], left: list[str]) -> list[str]:
    """Return notes on states: the later ones of demonstrations, which were not looked at, and the file written."""
    later = 0 if given is None else given.rows.later
    notes = [f"the first state of each demonstration; {later:,} later ones: --every-state"] if later else []
    if fix is not None:
        names = f": {listed(left)}" if left else ""
        notes.append(f"wrote {fix}: {len(fixed):,} settled, {len(left):,} left though they do not stand{names}")
    return notes


def _checked(finding: Finding, answers: Mapping[str, dict[str, Any]]) -> dict[str, Any]:
    """Return the answer about a scene with the result of its check; of one that is missing, that alone."""
    missing = envelope("scene", details={"scene": finding.scene, "outcome": None})
    answer = answers.get(finding.scene, missing)
    result = {"result": finding.result, "seconds": finding.seconds}
    return answer | {"reason": finding.reason or answer["reason"], "details": answer["details"] | result}


def _sorted_out(named: Sequence[tuple[str, str]], scenes_only: bool) -> tuple[list[tuple[str, str]], int]:
    """Return those of the named files that are checked, and the number of the others."""
    kept = [(name, path) for name, path in named if not scenes_only or is_scene(path)]
    return kept, len(named) - len(kept)


def _with_gap(options: dict[str, Any], gap: float | None) -> dict[str, Any]:
    """Return options of a batch with this gap [m] for ``assemble``."""
    own = options.get("assemble", {})
    if gap is None or not isinstance(own, Mapping):  # the latter is refused with all other options
        return options
    return options | {"assemble": {**own, "gap": checked_number(gap, "--gap", minimum=0)}}


def _scenes(globs: Iterable[str]) -> list[tuple[Any, Any]]:
    """Return the names and the paths of the scenes that the arguments name, each once although globs may overlap."""
    return list(dict.fromkeys((item.name, item.path) for text in globs for item in inputs_of(text).items))


def _client(scheduler: str | None, files: Mapping[str, Path | None]) -> AbstractContextManager[Any]:
    """Return the client of the Dask scheduler at this address, with its files for TLS; None without an address."""
    if scheduler is None:
        return nullcontext()
    from holdfast.batches.workers import connected

    client: AbstractContextManager[Any] = connected(scheduler, {k: str(v) for k, v in files.items() if v is not None})
    return client


def _read(options: Path | None) -> dict[str, Any]:
    if options is None:
        return {}
    content = read_ordinary(options, "file of options", most=MOST_BYTES, error=HoldfastError)
    try:
        return dict(json.loads(content))
    except (ValueError, TypeError) as cause:
        raise HoldfastError(
            message(str(options), f"is no JSON object: {cause}", 'needs {"engine": "limit"}')
        ) from cause
