"""The report of a batch, and its tables for other programs."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from importlib import import_module
from typing import Any

from holdfast.base.archive import to_dict
from holdfast.base.borders.worker import ANSWERED, OUTCOMES
from holdfast.base.envelope import UNDECIDED, UNSTABLE, envelope
from holdfast.base.errors import HoldfastError, installing, message, nearest_of
from holdfast.base.public import PublicValue, Summary
from holdfast.base.text import many
from holdfast.base.values import Table
from holdfast.batches.folder import Folder, reading
from holdfast.batches.tables import TABLES, Row, arrow_schema
from holdfast.engines.verdict import Status
from holdfast.queries.request import ENGINES, engine_of

SHOWN = 8  # largest number of scenes without answers in a report
VERDICTS = (Status.STABLE.value, Status.UNSTABLE.value, Status.UNDECIDED.value)


class BatchReport(PublicValue):
    """The numbers of scenes in the folder of a batch, by outcome and verdict.

    ``folder`` is its path. ``outcomes`` counts its scenes by outcome: answered, error, time, memory and crash.
    ``verdicts`` counts those with a verdict: stable, unstable and undecided. ``failures`` are the first scenes that
    were not answered, each with its outcome and the problem. In the run that made the report, ``asked`` scenes were
    computed and ``kept`` scenes had answers from earlier runs; ``seconds`` [s] is the time that it took.
    """

    folder: str
    outcomes: Table[str, int]
    verdicts: Table[str, int]
    failures: tuple[tuple[str, str, str], ...] = ()
    asked: int = 0
    kept: int = 0
    seconds: float = 0.0

    @property
    def scenes(self) -> int:
        """The number of scenes in the folder."""
        return sum(self.outcomes.values())

    def summary(self) -> Summary:
        """Summarise the batch by its outcomes and verdicts."""
        parts = [f"{count:,} {name}" for counts in (self.outcomes, self.verdicts) for name, count in counts.items()]
        facts = [("folder", self.folder), ("this run", f"{self.asked:,} computed, {self.kept:,} from earlier runs")]
        rows = [list(failure) for failure in self.failures]
        return Summary(
            f"{many(self.scenes, 'scene')}: {', '.join(parts)}", facts, ("scene", "outcome", "problem"), rows
        )


def counted(folder: Folder) -> BatchReport:
    """Count the scenes in a folder."""
    outcomes: Counter[str] = Counter()
    verdicts: Counter[str] = Counter()
    failures: list[tuple[str, str, str]] = []
    for shard in folder.shards():
        for row in folder.rows("scenes", shard, ["scene", "outcome", "status", "problem"]):
            outcomes[row["outcome"]] += 1
            if row["status"] is not None:
                verdicts[row["status"]] += 1
            if row["outcome"] != ANSWERED and len(failures) < SHOWN:
                failures.append((row["scene"], row["outcome"], row["problem"] or ""))
    return BatchReport(
        folder=str(folder.path),
        outcomes=_ordered(outcomes, OUTCOMES),
        verdicts=_ordered(verdicts, VERDICTS),
        failures=tuple(failures),
    )


def _ordered(counts: Counter[str], names: Sequence[str]) -> Table[str, int]:
    return Table({name: counts[name] for name in names if counts[name]})


class BatchTables:
    """The tables of a folder: "scenes", "bodies", "interfaces", "pushes" and "transports", see docs/howto/batch.md.

    Only finished shards are read. Every table is available as rows, and with the package of that name installed, as an
    Arrow table, a pandas data frame or a polars data frame.
    """

    def __init__(self, folder: Folder) -> None:
        self.folder = folder

    def __repr__(self) -> str:
        return f"BatchTables({str(self.folder.path)!r}, {len(self.folder.shards())} shards)"

    def rows(self, table: str = "scenes") -> Iterator[Row]:
        """Yield the rows of a table as dicts, in the order of the scenes.

        Raises HoldfastError for an unknown table or a damaged file. Running the same batch again replaces such a file.
        """
        if table not in TABLES:
            raise HoldfastError(message("read_batch", f"table {table!r} is unknown", nearest_of(table, TABLES)))
        for shard in self.folder.shards():
            yield from self.folder.rows(table, shard)

    def data(self) -> Iterator[dict[str, Any]]:
        """Yield the answer about each scene in the layout ``holdfast-answer/1``, in the order of the scenes.

        Its rows are the weakest push and the least acceleration, as far as these were asked.
        """
        for shard in self.folder.shards():
            bodies: dict[str, list[Row]] = {}
            for row in self.folder.rows("bodies", shard):
                bodies.setdefault(row["scene"], []).append(row)
            for row in self.folder.rows("scenes", shard):
                yield scene_data(row, bodies.get(row["scene"], ()))

    def arrow(self, table: str = "scenes") -> Any:  # noqa: ANN401 - a pyarrow.Table, which has no types
        """Return a table as a pyarrow.Table, with units and meanings in the metadata of its fields."""
        pa = _imported("pyarrow")
        parts = list(self.rows(table))
        return pa.Table.from_pylist(parts, schema=arrow_schema(table))

    def pandas(self, table: str = "scenes") -> Any:  # noqa: ANN401 - a pandas.DataFrame
        """Return a table as a pandas.DataFrame; raises HoldfastError if pandas is not installed."""
        pd = _imported("pandas")
        return pd.DataFrame(list(self.rows(table)), columns=[column.name for column in TABLES[table]])

    def polars(self, table: str = "scenes") -> Any:  # noqa: ANN401 - a polars.DataFrame
        """Return a table as a polars.DataFrame; raises HoldfastError if polars or pyarrow is not installed."""
        return _imported("polars").from_arrow(self.arrow(table))


def scene_data(row: Row, bodies: Sequence[Row] = ()) -> dict[str, Any]:
    """Return a row of the table of scenes, with those of its ``bodies``, in the layout ``holdfast-answer/1``."""
    answered, engine = row["outcome"] == ANSWERED, row["engine"]
    rows = []
    if row["weakest_lower"] is not None:
        names = {"force": "weakest", "lower": "weakest_lower", "body": "weakest_body", "mode": "weakest_mode"}
        known = {shown: row[name] for shown, name in names.items() if shown == "force" or row[name] is not None}
        rows.append(known | {"moving": row["weakest_moving"] or []})
    if row["acceleration"] is not None:
        rows.append({"acceleration": row["acceleration"], "lower": row["acceleration_lower"]})
    return envelope(
        "scene",
        verdict=UNDECIDED if not answered else UNSTABLE if row["crushed"] else row["status"],
        reason=(row["reason"] or "") if answered else f"{row['outcome']}: {row['problem']}",
        claim=engine_of(engine).claim.value if engine in ENGINES else None,
        rows=to_dict(rows),
        details={name: row[name] for name in ("scene", "path", "outcome", "engine", "seconds")}
        | {name: row[name] or [] for name in ("moving", "crushed")}
        | to_dict(_faults(row, bodies)),
        notes=[*(row["notes"] or ()), *(row["warnings"] or ())],
    )


def _faults(row: Row, bodies: Sequence[Row]) -> dict[str, Any]:
    """Return what hovers and sinks in a scene, and where it settles, as far as that was asked; old tables lack it."""
    hovers = [
        {"body": body["body"], "height": body["hovers"], "above": body["above"]}
        for body in bodies
        if body.get("hovers") is not None
    ]
    sinks = [
        {"body": body["body"], "depth": body["sinks"], "into": body["into"]}
        for body in bodies
        if body.get("sinks") is not None
    ]
    found: dict[str, Any] = {"hovers": hovers, "sinks": sinks}
    if row.get("settled_reason") is not None:
        names = ("body", "moved", "turned_degrees")
        went = [
            {name: body[name] for name in names} | {"reason": body["settled_reason"]}
            for body in bodies
            if body["moved"] is not None
        ]
        found["settled"] = {"verdict": row["settled"], "reason": row["settled_reason"], "moved": row["moved"]}
        found["settled"] |= {"bodies": went}
    return found


def read_batch(folder: str | os.PathLike[str]) -> BatchTables:
    """Open the tables that ``batch`` wrote to a folder; raise HoldfastError if that is not the folder of a batch."""
    return BatchTables(reading(folder))


def _imported(package: str) -> Any:  # noqa: ANN401 - a module, which has no types
    try:
        return import_module(package)
    except ImportError as cause:
        remedy = installing("tables") if package == "pyarrow" else f"pip install {package}"
        raise HoldfastError(message("read_batch", f"needs {package}, which is not installed", remedy)) from cause
