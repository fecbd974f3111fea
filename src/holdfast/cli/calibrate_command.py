"""The command ``calibrate``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from holdfast.applications.calibration.friction_from import friction_from
from holdfast.applications.calibration.measured_friction import MeasuredFriction
from holdfast.base.errors import HoldfastError, message
from holdfast.base.files import read_ordinary
from holdfast.base.text import quoted
from holdfast.batches.inputs import csv_rows
from holdfast.batches.run import MOST_BYTES, PUSH_COLUMNS
from holdfast.cli.assignments import option
from holdfast.cli.command import SAVE, EngineGiven, question
from holdfast.cli.scenes import AssemblyGiven
from holdfast.report.pose_report import friction_report

MEASURED = (*PUSH_COLUMNS, "force")  # columns of a file of measured pushes
MOVED = {"": True, "1": True, "true": True, "yes": True, "0": False, "false": False, "no": False}


@question(friction_report, save=SAVE)
def calibrate(
    scene: AssemblyGiven,
    pushes: Annotated[
        Path,
        typer.Argument(metavar="PUSHES", help=f"CSV file: {', '.join(MEASURED)} and, if some did not move, moved"),
    ],
    engine: EngineGiven,
    scatter: Annotated[
        float | None, option("standard deviation of ln(measured / predicted); default: from the pushes")
    ] = None,
    confidence: Annotated[float, option("of the intervals, between 0 and 1")] = 0.95,
) -> MeasuredFriction:
    """Find the friction of pairs of bodies from measured pushes, with intervals."""
    method, measured = engine.chosen(), measured_pushes(pushes)
    return friction_from(scene.assembled(), measured, scatter=scatter, confidence=confidence, engine=method)


def measured_pushes(path: Path) -> list[tuple[Any, ...]]:
    """Read measured pushes from a CSV file: body, x, y, z [m], dx, dy, dz, force [N] and, optionally, moved.

    Raises HoldfastError if a column is missing, a value is no number, or ``moved`` is none of 1, 0, true, false, yes
    and no.
    """
    content = read_ordinary(path, "file of pushes", most=MOST_BYTES, error=HoldfastError, too_large="divide it")
    rows = csv_rows(content, str(path))
    _, columns = next(rows)
    remedy = f"needs {', '.join(MEASURED)} and, if some pushes moved nothing, moved"
    for problem, names in (
        ("has no column", [name for name in MEASURED if name not in columns]),
        ("has a column", [name for name in columns if name not in (*MEASURED, "moved")]),
    ):
        if names:
            raise HoldfastError(message(str(path), f"{problem} {quoted(names[0])}", remedy))
    pushes = []
    for line, row in rows:
        where = f"{path}, line {line}"
        try:
            x, y, z, dx, dy, dz, force = (float(row[name] or "") for name in MEASURED[1:])
        except ValueError:
            raise HoldfastError(message(where, "holds no seven numbers", f"needs {', '.join(MEASURED[1:])}")) from None
        moved = (row.get("moved") or "").strip().lower()
        if moved not in MOVED:
            raise HoldfastError(message(where, f"moved is {quoted(moved)}", "needs 1, 0, true, false, yes or no"))
        pushes.append((row["body"] or "", (x, y, z), (dx, dy, dz), force, MOVED[moved]))
    return pushes
