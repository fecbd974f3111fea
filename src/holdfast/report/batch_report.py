"""The report of a batch as one page that opens offline."""

from __future__ import annotations

import base64
import os
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from heapq import nsmallest
from typing import Any

from holdfast.base.borders.worker import ANSWERED, OUTCOMES
from holdfast.base.errors import HoldfastError
from holdfast.base.files import write_atomically
from holdfast.base.public import at_most, number
from holdfast.base.text import escaped, listed, many
from holdfast.batches.folder import about, reading
from holdfast.batches.result import BatchTables
from holdfast.batches.tables import Row
from holdfast.drawing.html_page import template
from holdfast.drawing.render import thumbnail
from holdfast.drawing.svg import bar, histogram
from holdfast.queries.result import gives_way
from holdfast.report.description import ReportTable
from holdfast.report.map_picture import solids_of
from holdfast.scene.formats.registry import load_scene

SHOWN, PICTURED, UNANSWERED, REASONS = 12, 12, 60, 12  # largest numbers of rows of the tables and of pictures
ALIKE = 48  # reasons that agree in this number of characters are of one kind
VERDICTS = {"stable": "#3c9a5f", "unstable": "#cf4f3c", "undecided": "#d9a13b", "not asked": "#b9bec7"}
ENDINGS = {"answered": "#4a78b5", "error": "#d9a13b", "time": "#8a5fb0", "memory": "#cf7a3c", "crash": "#cf4f3c"}
COLUMNS = (  # of the table of scenes; those that tables of older versions do not have are None
    *("scene", "path", "outcome", "problem", "status", "reason", "moving", "bodies", "weakest", "weakest_body"),
    *("weakest_mode", "weakest_moving", "weakest_lower", "acceleration", "acceleration_lower", "seconds", "peak_mb"),
)


def write_report(folder: str | os.PathLike[str], path: str | os.PathLike[str]) -> None:
    """Write the report of the batch in ``folder`` as one HTML page; raise HoldfastError if there is no batch."""
    tables = BatchTables(reading(folder))
    facts = about(tables.folder.path)
    rows: list[Row] = [{name: row.get(name) for name in COLUMNS} for row in tables.rows("scenes")]
    folders = {os.path.dirname(row["scene"]) for row in rows}
    comparable = len({os.path.isabs(folder) for folder in folders}) == 1
    common = os.path.commonpath(folders) if comparable else ""
    for row in rows:
        row["scene"] = os.path.relpath(row["scene"], common) if common else row["scene"]
    outcomes = Counter(row["outcome"] for row in rows)
    verdicts = Counter(row["status"] or "not asked" for row in rows if row["status"] or row["outcome"] == ANSWERED)
    seconds = sum(row["seconds"] or 0.0 for row in rows)
    ask = f"asked: {listed(facts['ask'])}; options: {facts['options'] or 'none'}; holdfast {facts['version']}"

    def values(name: str) -> list[float]:
        return [float(row[name]) for row in rows if row[name] is not None]

    cells = [
        (r["scene"], r["outcome"], str(r["bodies"] or ""), _amount(r["seconds"]), _amount(r["peak_mb"]))
        for r in nsmallest(SHOWN, rows, key=lambda row: -(row["seconds"] or 0.0))
    ]
    failed = [row for row in rows if row["outcome"] != ANSWERED]
    lost = [(row["scene"], row["outcome"], row["problem"] or "") for row in failed[:UNANSWERED]]
    more = f"<p>and {len(failed) - UNANSWERED:,} more</p>" if len(failed) > UNANSWERED else ""
    page = template("batch.html").substitute(
        title=escaped(f"{many(len(rows), 'scene')} in {tables.folder.path}"),
        subtitle=escaped(f"{ask}; {number(seconds, 's')} of work"),
        outcomes=bar({name: outcomes[name] for name in OUTCOMES if outcomes[name]}, ENDINGS),
        verdicts=bar({name: verdicts[name] for name in VERDICTS if verdicts[name]}, VERDICTS),
        distributions="".join(
            [
                histogram("weakest push", values("weakest"), "N", logarithmic=True),
                histogram("least acceleration of the carrier", values("acceleration"), "m/s²", logarithmic=True),
                histogram("movable bodies", values("bodies"), ""),
                histogram("time", values("seconds"), "s", logarithmic=True),
            ]
        ),
        pictures="".join(_pictures(rows, facts["options"].get("load", {}))),
        reasons=_reasons(rows),
        weakest=_weakest(rows),
        slowest=ReportTable(("scene", "outcome", "bodies", "time [s]", "memory [MB]"), cells).html(),
        failures=ReportTable(("scene", "outcome", "problem"), lost).html() + more,
    )
    write_atomically(path, page.encode("utf-8"))


def _weakest_first(rows: Iterable[Row], most: int) -> list[Row]:
    """Return the first of the answered scenes: those that fall, then the undecided ones, then by strength."""

    def weakness(row: Row) -> tuple[float, float, float]:
        rank = {"unstable": 0.0, "undecided": 1.0}.get(row["status"] or "", 2.0)
        push, acceleration = (float("inf") if row[name] is None else row[name] for name in ("weakest", "acceleration"))
        return rank, push, acceleration

    return nsmallest(most, (row for row in rows if row["outcome"] == ANSWERED), key=weakness)


def _pictures(rows: Sequence[Row], options: Mapping[str, Any]) -> Iterable[str]:
    """Yield small pictures of the weakest scenes, except those that were values or whose files are gone."""
    drawn = 0
    for row in _weakest_first(rows, 4 * PICTURED):
        if row["path"] is None or drawn >= PICTURED:
            continue
        try:
            scene = load_scene(row["path"], **options)
        except HoldfastError:
            continue
        drawn += 1
        content = thumbnail(solids_of(scene.bodies), scene.up, row["moving"] or ())
        image = f'<img alt="" src="data:image/png;base64,{base64.b64encode(content).decode()}">'
        yield f"<figure>{image}<figcaption>{escaped(row['scene'], 80)}<br>{_strength(row)}</figcaption></figure>"


def _strength(row: Row) -> str:
    parts = [escaped(row["status"] or "no verdict")]
    for name, unit in (("weakest", "N"), ("acceleration", "m/s²")):
        value, lower = row[name], row[f"{name}_lower"]
        if value is not None:
            parts.append(number(value, unit) + (f" (all at least {at_most(lower, unit)})" if lower else ""))
    return ", ".join(parts)


def _weakest(rows: Sequence[Row]) -> str:
    cells = [
        (
            row["scene"],
            row["status"] or "",
            _amount(row["weakest"]),
            row["weakest_body"] or "",
            gives_way(row["weakest_mode"], tuple(row["weakest_moving"])) if row["weakest_moving"] else "",
            _amount(row["weakest_lower"], at_most),
            _amount(row["acceleration"]),
            _amount(row["acceleration_lower"], at_most),
        )
        for row in _weakest_first(rows, SHOWN)
    ]
    force, rate = "least lower bound [N]", "least lower bound [m/s²]"
    heads = ("scene", "verdict", "weakest push [N]", "on", "what gives way", force, "acceleration [m/s²]", rate)
    return ReportTable(heads, cells).html()


def _amount(value: float | None, form: Callable[[float], str] = number) -> str:
    return "" if value is None else form(value)


def _reasons(rows: Sequence[Row]) -> str:
    """Return a table of the kinds of reasons of verdicts other than stable, with their counts and an example."""
    alike: dict[tuple[str, str], list[Row]] = defaultdict(list)
    for row in rows:
        if row["status"] not in (None, "stable"):
            alike[row["status"], kind_of(row["reason"] or "")].append(row)
    cells = [
        (f"{len(some):,}", some[0]["status"], some[0]["scene"], some[0]["reason"] or "")
        for some in nsmallest(REASONS, alike.values(), key=lambda some: -len(some))
    ]
    return ReportTable(("scenes", "verdict", "for example", "whose reason is"), cells).html()


def kind_of(reason: str) -> str:
    """Return the kind of a reason: its beginning, without numbers and lists."""
    bare = re.sub(r"-?\d+(\.\d+)?(e-?\d+)?", "#", reason)
    return re.sub(r"([\w#]+)(, [\w#]+)+", r"\1", bare)[:ALIKE]
