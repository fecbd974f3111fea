"""The option ``--straps`` of the commands about carriers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from holdfast.applications.strap import Strap
from holdfast.assembly.assembly import Assembly
from holdfast.queries.request import Load

Straps = Annotated[Path | None, typer.Option(help="YAML or JSON file with straps, see docs/howto/straps.md")]


def strap_loads(path: Path | None, assembly: Assembly) -> tuple[Load, ...]:
    """Return the standing loads of all straps in the file on the bodies of an assembly; none without a file."""
    return () if path is None else tuple(load for strap in Strap.from_file(path) for load in strap.loads(assembly))
