"""Runs suites case by case, writes their results, and compares them with saved ones."""

from __future__ import annotations

import io
import json
import math
import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from bench.suite import Row, Suite, table
from holdfast import __version__
from holdfast.base.errors import HoldfastError, message
from holdfast.base.files import write_atomically
from holdfast.base.progress import report

PACKAGES = ("numpy", "scipy", "clarabel", "mujoco", "pybullet", "compas_lmgc90", "casadi")


def machine() -> dict[str, Any]:
    """Processor and versions of packages, on which the results depend."""
    found: dict[str, Any] = {
        "processor": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "holdfast": __version__,
    }
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


def run(suite: Suite, folder: Path | None = None, *, fresh: bool = False) -> list[Row]:
    """Measure all cases of a suite and return their rows.

    With a ``folder``, each case is written there as soon as it is measured, and cases that an interrupted run of the
    same version on the same machine has left there are not measured again, unless ``fresh``. Raises HoldfastError if
    there is no case, as where the scenes that a suite measures are missing.
    """
    cases, here = suite.cases(), machine()
    if not cases:
        remedy = "put the published scenes into shared/cases beside a checkout of holdfast, and run it from there"
        raise HoldfastError(message(f"benchmark {suite.name}", "finds nothing to measure here", remedy))
    partial = None if folder is None else folder / f"{suite.name}.partial.json"
    done: dict[str, list[Row]] = {}
    if partial is not None and partial.exists() and not fresh:
        before = _read(partial)
        if before["machine"] == here:
            done = {label: rows for label, rows in before["cases"].items() if label in cases}
    for number, (label, measure) in enumerate(cases.items()):
        report(suite.name, number, len(cases))
        if label not in done:
            done[label] = [{key: _plain(value) for key, value in row.items()} for row in measure()]
            if partial is not None:
                _write(partial, {"suite": suite.name, "machine": here, "cases": done})
    report(suite.name, len(cases), len(cases))
    return [row for label in cases for row in done[label]]


def written(suite: Suite, rows: list[Row]) -> str:
    """The Markdown text of a suite's rows."""
    return table(rows) if suite.written is None else suite.written(rows)


def save(suite: Suite, rows: list[Row], folder: Path) -> list[Path]:
    """Write rows as JSON and Markdown, and a picture where the suite has one; remove what an interrupted run left."""
    paths = [folder / f"{suite.name}.json", folder / f"{suite.name}.md"]
    _write(paths[0], {"suite": suite.name, "machine": machine(), "rows": rows})
    text = f"# {suite.name}\n\n{suite.about}\n\n{written(suite, rows)}\n"
    write_atomically(paths[1], text.encode())
    if suite.plot is not None:
        paths.append(folder / f"{suite.name}.png")
        picture = io.BytesIO()
        suite.plot(rows, picture)
        write_atomically(paths[2], picture.getvalue())
    (folder / f"{suite.name}.partial.json").unlink(missing_ok=True)
    return paths


def compared(suite: Suite, rows: list[Row], folder: Path) -> list[str]:
    """For every time [s] in ``rows``, one line that gives its ratio to the saved time."""
    path = folder / f"{suite.name}.json"
    if not path.exists():
        return [f"nothing saved in {path}"]
    saved = {row["case"]: row for row in _read(path)["rows"]}
    lines = []
    for row in rows:
        for key, value in row.items():
            before = saved.get(row["case"], {}).get(key)
            if (
                key.endswith(" s")
                and isinstance(value, float)
                and isinstance(before, float)
                and before not in (0, value)
            ):
                lines.append(f"{row['case']}, {key}: {value / before:.2f} x the saved {before:.3g}")
    return lines


def _plain(value: Any) -> Any:  # noqa: ANN401 - JSON has no infinity, numpy numbers are no numbers to it
    value = value.item() if hasattr(value, "item") else value
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def _read(path: Path) -> dict[str, Any]:
    try:
        data: dict[str, Any] = json.loads(path.read_text())
    except ValueError as error:
        raise HoldfastError(message(str(path), f"is not JSON ({error})", "remove it and run again")) from error
    return data


def _write(path: Path, data: dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(data, indent=1, allow_nan=False) + "\n"
    write_atomically(path, text.encode())
