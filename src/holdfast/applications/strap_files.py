"""Read straps from YAML and JSON files."""

from __future__ import annotations

import os
from typing import Any

from holdfast.base.errors import SceneError, located, message, nearest_of
from holdfast.base.files import checked_path, read_ordinary
from holdfast.base.text import quoted
from holdfast.scene.formats.source import from_json, from_yaml

FIELDS = ("route", "pretension", "mu", "closed", "spring")
NEEDED = ("route", "pretension")
MOST_BYTES = 10_000_000  # largest size of a file with straps
FORM = "needs a list of {route: [[BODY, X, Y, Z], ...], pretension: N}, optionally mu, closed, spring"


def strap_entries(path: str | os.PathLike[str]) -> tuple[dict[str, Any], ...]:
    """Return the arguments of ``Strap`` by name for each strap in a file, whose form ``Strap.from_file`` describes.

    Raises SceneError for any other content.
    """
    file = checked_path(path, "straps")
    content = read_ordinary(file, "straps", most=MOST_BYTES, too_large="take fewer straps")
    with located(str(file)):
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError:
            raise SceneError(message("straps", "the file is not a text", FORM)) from None
        data = (from_json if file.suffix.lower() == ".json" else from_yaml)(text, str(file))
        if not isinstance(data, list):
            raise SceneError(message("straps", f"the file holds a {type(data).__name__}", FORM))
        entries = []
        for number, entry in enumerate(data, 1):
            with located(f"strap {number}"):
                entries.append(_entry(entry))
        return tuple(entries)


def _entry(entry: Any) -> dict[str, Any]:  # noqa: ANN401 - plain data, checked here
    if not isinstance(entry, dict) or any(name not in entry for name in NEEDED):
        raise SceneError(message("strap", f"is {quoted(entry, 80)}", FORM))
    unknown = [name for name in entry if name not in FIELDS]
    if unknown:
        raise SceneError(message("strap", f"has a field {quoted(unknown[0])}", nearest_of(unknown[0], FIELDS)))
    points = entry["route"]
    if not isinstance(points, list) or any(not isinstance(p, list) or len(p) != 4 for p in points):
        raise SceneError(message("strap: route", f"is {quoted(points, 80)}", FORM))
    if not isinstance(entry.get("closed", False), bool):
        raise SceneError(message("strap: closed", f"is {quoted(entry['closed'])}", "needs true or false"))
    given = {name: value for name, value in entry.items() if name != "route" and value is not None}
    return {"route": [(str(body), place) for body, *place in points], **given}
