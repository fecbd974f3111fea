"""The command ``doctor``."""

from __future__ import annotations

import platform
import re
import sys
from importlib import metadata
from typing import Any

from rich.table import Table as RichTable

from holdfast import __version__
from holdfast.base.envelope import envelope
from holdfast.base.errors import DISTRIBUTION, installing
from holdfast.base.progress import cores
from holdfast.base.text import many
from holdfast.cli.output import AsJson, out, print_json

NOT_FOR_USE = ("test", "dev", "docs")  # extras for development, which users do not need
_NAME = re.compile(r"[\w.-]+")
_EXTRA = re.compile(r"extra == ['\"]([\w-]+)['\"]")


def doctor(as_json: AsJson = False) -> None:
    """Report what is installed and which extras are missing.

    Include the output in reports of defects.
    """
    facts = examined()
    if as_json:
        print_json(envelope("doctor", reason="what is installed", details=facts))
        return
    out.say(
        f"holdfast {facts['holdfast']}, Python {facts['python']}, {facts['system']}, {many(facts['cores'], 'core')}"
    )
    table = RichTable("needed for", "package", "version", box=None, pad_edge=False)
    for extra, packages in facts["packages"].items():
        for name, version in packages.items():
            table.add_row(extra, name, version or f"missing: {installing(extra)}")
    out.print(table)


def examined() -> dict[str, Any]:
    """Return the versions of packages by extra (None if missing), and the system."""
    return {
        "holdfast": __version__,
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "executable": sys.executable,
        "cores": cores(),
        "packages": {extra: {name: _version(name) for name in names} for extra, names in _needed().items()},
    }


def _needed() -> dict[str, list[str]]:
    """Return the required packages by extra; those that holdfast always needs are under "core"."""
    try:
        lines = metadata.requires(DISTRIBUTION) or []
    except metadata.PackageNotFoundError:  # run from its sources
        lines = []
    packages: dict[str, list[str]] = {"core": []}
    for line in lines:
        name, extra = _NAME.match(line), _EXTRA.search(line)
        group = extra[1] if extra else "core"
        if name and name[0] != DISTRIBUTION and group not in NOT_FOR_USE:
            packages.setdefault(group, []).append(name[0])
    return packages


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
