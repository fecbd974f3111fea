"""The command ``mcp``."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from holdfast.agents.confinement import Confinement
from holdfast.base.errors import HoldfastError, installing, message
from holdfast.base.text import quoted
from holdfast.cli.assignments import option


def mcp(
    folder: Annotated[Path | None, option("scenes and meshes in this folder may be read; default: none")] = None,
    write: Annotated[Path | None, option("new files may be written in this folder; default: none")] = None,
    bodies: Annotated[int, typer.Option(min=1, help="most bodies of a scene")] = Confinement.bodies,
    megabytes: Annotated[
        float, typer.Option(min=0.001, help="most megabytes of a scene with its files")
    ] = Confinement.megabytes,
    seconds: Annotated[float, typer.Option(min=0.1, help="longest time of an answer, in s")] = Confinement.seconds,
) -> None:
    """Serve the tools stands, push, settle, place and explain to agents, over standard input and output."""
    for name, given in (("--folder", folder), ("--write", write)):
        if given is not None and not given.is_dir():
            raise HoldfastError(message(name, f"{quoted(str(given), 120)} is no folder", "name one that exists"))
    if find_spec("mcp") is None or find_spec("mcp_types") is None:  # the first versions had no mcp_types
        raise HoldfastError(message("mcp", "needs mcp of version 2, which is not installed", installing("mcp")))
    from holdfast.agents.agent_server import serve  # only now, as it needs that package

    reading, writing = (None if given is None else given.resolve() for given in (folder, write))
    serve(Confinement(reading, writing, bodies, megabytes, seconds))
