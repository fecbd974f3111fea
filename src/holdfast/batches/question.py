"""The question of a batch: the verbs, their options and the pushes, checked before any scene is computed."""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from holdfast.applications.transport import transport_limits
from holdfast.assembly.assembly import assemble
from holdfast.base.arrays import checked_items, checked_mapping
from holdfast.base.errors import HoldfastError, message, nearest_of
from holdfast.base.files import read_ordinary
from holdfast.base.text import quoted
from holdfast.batches.inputs import csv_rows
from holdfast.batches.job import BatchQuestion, Push
from holdfast.queries.map import robustness_map
from holdfast.queries.push import robustness
from holdfast.queries.stability import stability

VERBS = ("stability", "map", "transport", "push")
ASKED: Mapping[str, Callable[..., Any]] = {
    "assemble": assemble,
    "stability": stability,
    "push": robustness,
    "map": robustness_map,
    "transport": transport_limits,
}
# Arguments that are not options: the batch supplies them, or they cannot be written to a file. The directions of
# transport are an option.
GIVEN = ("assembly", "scene", "body", "points", "directions", "standing", "loads", "imperfect", "interfaces")
ENGINE = "engine"
MOST_BYTES = 500_000_000  # largest size of a file of pushes
PUSH_COLUMNS = ("body", "x", "y", "z", "dx", "dy", "dz")


def question(ask: str | Iterable[str], options: Mapping[str, Any] | None) -> BatchQuestion:
    """Return the question for the arguments ``ask`` and ``options`` of a batch.

    ``ask`` is one of stability, map, transport and push:FILE, or several of them. ``options`` maps "load", "assemble"
    and verbs to keyword arguments, and "engine" to the engine of all verbs. Raises HoldfastError if a verb or an option
    is unknown.
    """
    words = [ask] if isinstance(ask, str) else checked_items(ask, "ask", "stability, map, transport or push:FILE")
    pushes: tuple[Push, ...] = ()
    verbs = []
    for word in words:
        verb, colon, file = word.partition(":") if isinstance(word, str) else ("", "", "")
        if verb not in VERBS or bool(colon) != (verb == "push"):
            remedy = "needs stability, map, transport or push:FILE"
            raise HoldfastError(message("ask", f"{quoted(word)} is unknown", remedy))
        if verb == "push":
            pushes += read_pushes(Path(file))
        verbs.append(verb)
    if not verbs:
        raise HoldfastError(message("ask", "is empty", "needs stability, map, transport or push:FILE"))
    given = {} if options is None else options
    return BatchQuestion(tuple(verb for verb in VERBS if verb in verbs), _options(given), pushes)


def _options(given: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return checked options, in which every verb has the common engine unless it has its own."""
    checked_mapping(given, "options", '{"engine": "limit"}')
    engine = {ENGINE: given[ENGINE]} if ENGINE in given else {}
    found: dict[str, dict[str, Any]] = {verb: dict(engine) for verb in VERBS if engine}
    for verb, own in given.items():
        if verb == ENGINE:
            continue
        if verb not in (*ASKED, "load") or not isinstance(own, Mapping):
            remedy = f"needs a dict of options for one of: load, {', '.join(ASKED)}; or an engine for all"
            raise HoldfastError(message("options", f"{quoted(verb)}: {quoted(own)}", remedy))
        for name in own:
            if verb != "load" and name not in _known(verb):
                remedy = nearest_of(name, _known(verb))
                raise HoldfastError(message(f"options of {verb}", f"{quoted(name)} is unknown", remedy))
        found.setdefault(verb, {}).update(own)
    try:
        return dict(json.loads(json.dumps(found, allow_nan=False)))
    except (TypeError, ValueError) as cause:
        remedy = "needs names, numbers, lists and dicts with texts as keys: engines by name"
        raise HoldfastError(message("options", f"cannot be written as JSON: {cause}", remedy)) from cause


def _known(verb: str) -> list[str]:
    given = [name for name in GIVEN if (verb, name) != ("transport", "directions")]
    names = inspect.signature(ASKED[verb]).parameters
    return [name for name in names if name not in given]


def read_pushes(path: Path) -> tuple[Push, ...]:
    """Read pushes from a CSV file with the columns body, x, y, z [m], dx, dy, dz and, if they differ, scene.

    Raises HoldfastError if a column is missing or a value is no number.
    """
    content = read_ordinary(path, "file of pushes", most=MOST_BYTES, error=HoldfastError, too_large="divide it")
    rows = csv_rows(content, str(path))
    _, columns = next(rows)
    missing = [name for name in PUSH_COLUMNS if name not in columns]
    if missing:
        remedy = f"needs {', '.join(PUSH_COLUMNS)} and, if pushes differ between scenes, scene"
        raise HoldfastError(message(str(path), f"has no column {missing[0]}", remedy))
    pushes = []
    for line, row in rows:
        try:
            x, y, z, dx, dy, dz = (float(row[name] or "") for name in PUSH_COLUMNS[1:])
        except ValueError:
            where = f"{path}, line {line}"
            raise HoldfastError(message(where, "holds no six numbers", "needs x, y, z, dx, dy, dz")) from None
        pushes.append(Push(row.get("scene") or "", row["body"] or "", (x, y, z), (dx, dy, dz)))
    return tuple(pushes)
