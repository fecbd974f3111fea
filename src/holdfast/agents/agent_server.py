"""The server of ``holdfast mcp``: it lists the tools, and has each call answered in a worker that it can end.

The official package ``mcp`` speaks the protocol, on standard input and output. Scenes are read and computed in a
process of its own, with limits of time and memory (``base/borders/supervisor.py``); one call at a time.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from typing import Any

import anyio
import mcp_types as protocol
from mcp.server.lowlevel.server import Server
from mcp.server.stdio import stdio_server

from holdfast import __version__
from holdfast.agents.confinement import Confinement
from holdfast.agents.tools import INSTRUCTIONS, TOOLS, input_schema, output_schema, tool_of
from holdfast.base.borders.supervisor import Limits, Reply, Supervisor
from holdfast.base.borders.worker import DONE, MEMORY, TIME
from holdfast.base.errors import HoldfastError, message

ANSWERED_BY = "holdfast.agents.answering:answered"
MEMORY_LIMIT = 2_000.0  # [MB] of a call, above that of the ready worker


class Desk:
    """Has calls answered, one after the other, by a worker that is replaced when it is ended."""

    def __init__(self, limits: Confinement) -> None:
        self._limits = limits
        self._one = anyio.Lock()
        self._worker = self._new()

    def _new(self) -> Supervisor:
        limits = Limits(self._limits.seconds, MEMORY_LIMIT)
        return Supervisor(ANSWERED_BY, self._limits, limits)

    def close(self) -> None:
        """End the worker."""
        self._worker.close()

    async def ask(self, name: str, arguments: dict[str, Any]) -> dict[str, Any]:
        """Return what ``answering.answered`` gives for a call; a call that is cancelled ends the worker."""
        async with self._one:
            try:
                self._worker.give((name, arguments))
                reply = None
                while reply is None:
                    with anyio.move_on_after(self._worker.left):
                        await anyio.wait_readable(self._worker.answers.fileno())
                    reply = self._worker.take()
            except anyio.get_cancelled_exc_class():
                self._worker.close()
                self._worker = self._new()
                raise
        return reply.value if reply.outcome == DONE else {"error": self._problem(name, reply)}

    def _problem(self, name: str, reply: Reply) -> str:
        if reply.outcome == TIME:
            remedy = "ask about fewer bodies or a larger spacing, or start the server with more --seconds"
            return message(name, f"no answer within {self._limits.seconds:g} s", remedy)
        if reply.outcome == MEMORY:
            return message(name, f"needs more than {MEMORY_LIMIT:,.0f} MB of memory", "ask about fewer bodies")
        last = reply.problem.strip().splitlines()[-1:]
        return message(name, f"a defect of holdfast: {''.join(last)}", "please report it with the scene")


def listed_tools(limits: Confinement) -> list[protocol.Tool]:
    """Return the tools as the protocol lists them."""
    return [
        protocol.Tool(
            name=name,
            description=tool.arguments.__doc__,
            input_schema=input_schema(name),
            output_schema=output_schema(name),
            annotations=protocol.ToolAnnotations(
                read_only_hint=limits.write is None or "save" not in tool.arguments.model_fields,
                destructive_hint=False,
                idempotent_hint=True,
                open_world_hint=False,
            ),
        )
        for name, tool in TOOLS.items()
    ]


def result_of(told: dict[str, Any]) -> protocol.CallToolResult:
    """Return an answer, or an error, as the protocol has it: words, the envelope, and the picture if there is one."""
    if "error" in told:
        return protocol.CallToolResult(content=[protocol.TextContent(text=told["error"])], is_error=True)
    # clients that know no structured answers find the envelope in the second text
    content: list[Any] = [protocol.TextContent(text=told["words"]), protocol.TextContent(text=json.dumps(told["data"]))]
    if told["picture"] is not None:
        picture = base64.b64encode(told["picture"]).decode("ascii")
        content.append(protocol.ImageContent(data=picture, mime_type="image/png"))
    return protocol.CallToolResult(content=content, structured_content=told["data"])


def server_of(limits: Confinement, ask: Callable[[str, dict[str, Any]], Any]) -> Server[Any]:
    """Return a server of the tools whose calls ``ask`` answers."""
    tools = listed_tools(limits)

    async def list_tools(_: Any, __: protocol.PaginatedRequestParams | None) -> protocol.ListToolsResult:  # noqa: ANN401
        return protocol.ListToolsResult(tools=tools)

    async def call_tool(_: Any, call: protocol.CallToolRequestParams) -> protocol.CallToolResult:  # noqa: ANN401
        try:
            tool_of(call.name)
            return result_of(await ask(call.name, call.arguments or {}))
        except HoldfastError as error:
            return result_of({"error": str(error)})

    return Server(
        "holdfast", version=__version__, instructions=INSTRUCTIONS, on_list_tools=list_tools, on_call_tool=call_tool
    )


def serve(limits: Confinement) -> None:
    """Serve on standard input and output until the input ends."""

    async def serving() -> None:
        desk = Desk(limits)
        try:
            server = server_of(limits, desk.ask)
            async with stdio_server() as (read, write):
                await server.run(read, write, server.create_initialization_options())
        finally:
            desk.close()

    anyio.run(serving)
