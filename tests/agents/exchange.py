"""A real exchange of protocol messages between a client of the official package and ``holdfast mcp``.

``recorded()`` starts the server behind a process that copies every line that passes, and returns the messages; those
that are long are shortened as on the page. ``python tests/agents/exchange.py`` writes the page.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from typing import Any

PAGE = Path(__file__).parents[2] / "docs" / "howto" / "agents.md"
BEGIN, END = "<!-- exchange -->\n", "<!-- end of exchange -->"
DOTS = "..."
WIDTH = 116  # characters of a line of the page
CRATE: dict[str, Any] = {
    "format": "holdfast-scene/1",
    "name": "crate",
    "friction": 0.6,
    "bodies": [
        {"name": "floor", "shape": {"type": "halfspace"}, "fixed": True},
        {"name": "crate", "shape": {"type": "box", "size": [0.1, 0.1, 0.3]}, "mass": 4, "position": [0, 0, 0.15]},
    ],
}


def server(*arguments: object) -> tuple[list[str], dict[str, str]]:
    """The command of the server with these arguments, and its environment."""
    kept = {name: os.environ[name] for name in ("PYTHONPATH", "OPENBLAS_NUM_THREADS") if name in os.environ}
    return [sys.executable, "-m", "holdfast", "mcp", *map(str, arguments)], kept


def copied(log: str, *command: str) -> None:
    """Run a command; copy each line that it reads and writes to a file, after ``>`` or ``<``."""
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdin is not None
    assert process.stdout is not None
    with open(log, "ab", buffering=0) as file:

        def pump(mark: bytes, source: Any, sink: Any) -> None:
            for line in source:
                file.write(mark + line)
                sink.write(line)
                sink.flush()
            sink.close()

        said = threading.Thread(target=pump, args=(b"<", process.stdout, sys.stdout.buffer))
        said.start()
        pump(b">", sys.stdin.buffer, process.stdin)
        said.join()
    process.wait()


def recorded() -> list[tuple[str, dict[str, Any]]]:
    """The messages of the exchange on the page, each with who sent it: ``>`` the client, ``<`` the server."""
    import anyio
    from mcp import Client, StdioServerParameters, stdio_client

    async def talk(parameters: StdioServerParameters) -> None:
        async with Client(stdio_client(parameters), mode="legacy") as client:  # the handshake that most agents speak
            await client.list_tools()
            asked = {"body": "crate", "point": [-0.05, 0, 0.3], "direction": [1, 0, 0]}
            await client.call_tool("push", {"scene": CRATE, **asked})

    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder, "log")
        command, env = server("--folder", folder)
        parameters = [__file__, "copy", str(log), *command]
        anyio.run(talk, StdioServerParameters(command=sys.executable, args=parameters, env=env))
        lines = log.read_text(encoding="utf-8").splitlines()
    messages = [(line[0], json.loads(line[1:])) for line in lines]
    calls = {message["id"] for _, message in messages if message.get("method") == "tools/call"}
    return [(mark, shortened(message)) for mark, message in messages if message.get("id") in calls]


def shortened(message: dict[str, Any]) -> dict[str, Any]:
    """A message without what is long or changes with versions."""
    result = message.get("result", {})
    for part in (message.get("params", {}), result):
        part.pop("_meta", None)
    answer = result.get("structuredContent", {})
    if "details" in answer:
        answer["details"] = DOTS
    for row in answer.get("rows", []):
        row |= {key: round(row[key], 4) for key in ("force", "lower", "upper")} | {"mechanism": DOTS}
    if "content" in result:
        result["content"] = result["content"][:1] + [DOTS for _ in result["content"][1:]]
    return message


def written(data: Any, indent: int = 0) -> str:
    """JSON with as many short parts on a line as fit."""
    line = json.dumps(data, ensure_ascii=False)
    if len(line) + indent <= WIDTH or not data or not isinstance(data, dict | list):
        return line
    keyed = isinstance(data, dict)
    lines, whole = [""], False  # whole: what was written last is on one line, so that more may follow there
    for part in data.items() if keyed else data:
        key, value = (f"{json.dumps(part[0])}: ", part[1]) if keyed else ("", part)
        text = key + written(value, indent + 1 + len(key))
        fits = whole and indent + len(lines[-1]) + len(text) + 4 <= WIDTH
        if "\n" not in text and fits:
            lines[-1] += f", {text}"
        else:
            lines.append(text)
        whole = "\n" not in text
    first, last = ("{", "}") if keyed else ("[", "]")
    return first + (",\n" + " " * (indent + 1)).join(lines[1:]) + last


def as_page(messages: list[tuple[str, dict[str, Any]]]) -> str:
    """The exchange as the page has it."""
    who = {">": "The agent:", "<": "holdfast:"}
    return "".join(f"{who[mark]}\n```json\n{written(message)}\n```\n\n" for mark, message in messages)


def on_page() -> list[tuple[str, dict[str, Any]]]:
    """The messages that the page shows."""
    shown = PAGE.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0]
    blocks = shown.split("```json\n")
    heads = [">" if "The agent:" in block else "<" for block in blocks[:-1]]
    bodies = [json.loads(block.partition("```")[0]) for block in blocks[1:]]
    return list(zip(heads, bodies, strict=True))


if __name__ == "__main__":
    if sys.argv[1:2] == ["copy"]:
        copied(*sys.argv[2:])
    else:
        before, begin, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
        after = rest.partition(END)[2]
        PAGE.write_text(before + begin + as_page(recorded()) + END + after, encoding="utf-8")
