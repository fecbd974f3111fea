"""``holdfast mcp`` as agents meet it: the official client starts it, lists its tools and calls all of them."""

from __future__ import annotations

import base64
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Awaitable, Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import exchange
import jsonschema
import pytest
from envelopes import problems

import holdfast as hf

needs_mcp = pytest.mark.skipif(find_spec("mcp_types") is None, reason="needs the extra mcp")
CRATE = exchange.CRATE
PUSH = {"body": "crate", "point": [-0.05, 0, 0.3], "direction": [1, 0, 0]}
TIPS = 4 * 9.81 * 0.05 / 0.3  # N


def talk(asked: Callable[[Any], Awaitable[Any]], *arguments: object) -> Any:
    """What ``asked(client)`` returns, of a client of the server with these arguments."""
    import anyio
    from mcp import Client, StdioServerParameters, stdio_client

    command, env = exchange.server(*arguments)

    async def talking() -> Any:
        parameters = StdioServerParameters(command=command[0], args=command[1:], env=env)
        async with Client(stdio_client(parameters)) as client:
            return await asked(client)

    return anyio.run(talking)


def picture(result: Any) -> bytes:
    """The picture of an answer."""
    (found,) = [block for block in result.content if block.type == "image"]
    assert found.mime_type == "image/png"
    return base64.b64decode(found.data)


@needs_mcp
def test_a_client_lists_and_calls_all_tools(tmp_path: Path) -> None:
    hf.save_scene(hf.shipped_scene("cube"), tmp_path / "cube.yaml")
    cup = {"name": "cup", "shape": {"type": "box", "size": [0.03, 0.03, 0.05]}, "mass": 0.1}
    calls: dict[str, dict[str, Any]] = {
        "stands": {"path": "cube.yaml"},
        "push": {"scene": CRATE, **PUSH},
        "settle": {"scene": json.dumps(CRATE)},
        "place": {"scene": CRATE, "object": cup, "supports": ["crate"], "engine": "graph", "seconds": 3},
        "explain": {"scene": CRATE, "spacing": 0.05, "engine": "limit"},
    }

    async def asked(client: Any) -> Any:
        tools = (await client.list_tools()).tools
        return tools, {name: await client.call_tool(name, given) for name, given in calls.items()}

    tools, results = talk(asked, "--folder", tmp_path)
    assert [tool.name for tool in tools] == list(calls)
    for tool in tools:
        jsonschema.validate(calls[tool.name], tool.input_schema)
        result = results[tool.name]
        assert not result.is_error, result.content
        data = result.structured_content
        assert problems(data) == []
        jsonschema.Draft202012Validator(tool.output_schema).validate(data)
        assert (data["version"], data["verdict"]) == ("holdfast-answer/1", "stable")
        assert json.loads(result.content[1].text) == data
        assert picture(result)[:8] == b"\x89PNG\r\n\x1a\n"
        assert tool.annotations.read_only_hint
    assert results["push"].structured_content["rows"][0]["force"] == pytest.approx(TIPS, rel=1e-3)
    assert "6.54 N before something moves" in results["push"].content[0].text
    forces = [row["force"] for row in results["explain"].structured_content["rows"]]
    assert len(forces) == 20
    assert forces == sorted(forces)
    assert "weakest push on each body" in results["explain"].content[0].text


@needs_mcp
def test_errors_reach_the_agent_and_the_server_goes_on(tmp_path: Path) -> None:
    """Also after a call that took too long, whose process is ended."""
    floor, crate = CRATE["bodies"]
    pile = [crate | {"name": f"c{k}", "position": [0, 0, 0.15 + 0.3 * k]} for k in range(40)]

    async def asked(client: Any) -> Any:
        wrong = [
            await client.call_tool("stands", {"path": "../x.yaml"}),
            await client.call_tool("stand", {"scene": CRATE}),
            await client.call_tool("explain", {"scene": CRATE | {"bodies": [floor, *pile]}, "spacing": 0.002}),
            await client.call_tool("stands", {"scene": CRATE | {"bodies": [floor, *pile, *pile]}}),
            await client.call_tool("stands", {"scene": CRATE | {"bodies": [floor, crate | {"name": "a\x1b[31mb"}]}}),
        ]
        return wrong, await client.call_tool("stands", {"scene": CRATE, "picture": False})

    wrong, right = talk(asked, "--folder", tmp_path, "--seconds", 1, "--bodies", 50)
    said = [result.content[0].text for result in wrong]
    assert all(result.is_error for result in wrong)
    assert "leads out of the folder" in said[0]
    assert "did you mean 'stands'?" in said[1]
    assert said[2].startswith("explain: no answer within 1 s; ")
    assert "scene: has 81 bodies; the limit is 50" in said[3]
    assert "bodies[1].name: is no name: 'a\\x1b[31mb'" in said[4]
    assert right.structured_content["verdict"] == "stable"
    assert [block.type for block in right.content] == ["text", "text"]


@needs_mcp
def test_a_call_that_is_cancelled_ends_at_once() -> None:
    import anyio

    floor, crate = CRATE["bodies"]
    pile = [crate | {"name": f"c{k}", "position": [0, 0, 0.15 + 0.3 * k]} for k in range(40)]

    async def asked(client: Any) -> Any:
        with anyio.move_on_after(2) as scope:
            await client.call_tool("explain", {"scene": CRATE | {"bodies": [floor, *pile]}, "spacing": 0.002})
        return scope.cancelled_caught, await client.call_tool("stands", {"scene": CRATE, "picture": False})

    cancelled, right = talk(asked)
    assert cancelled
    assert right.structured_content["verdict"] == "stable"  # it would wait for a minute behind the other


@needs_mcp
def test_the_line_that_tries_the_server_runs_as_it_stands() -> None:
    (line,) = re.findall(r"```sh\n(.*?)```", exchange.PAGE.read_text(encoding="utf-8"), re.DOTALL)
    ready = f'holdfast() {{ "{sys.executable}" -m holdfast "$@"; }}\n'
    done = subprocess.run(["bash", "-c", ready + line], capture_output=True, text=True, check=True)
    assert '"serverInfo":{"name":"holdfast"' in done.stdout
    assert len(done.stdout.splitlines()) == 1


@needs_mcp
def test_the_page_shows_a_real_exchange() -> None:
    """``python tests/agents/exchange.py`` writes it anew."""

    def near(data: Any) -> Any:
        if isinstance(data, dict):
            return {key: near(value) for key, value in data.items()}
        if isinstance(data, list):
            return [near(value) for value in data]
        return pytest.approx(data, rel=1e-6, abs=1e-9) if isinstance(data, float) else data

    shown = exchange.on_page()
    assert len(shown) == 2
    assert exchange.recorded() == near(shown)


@needs_mcp
def test_the_server_ends_with_its_input_and_with_ctrl_c() -> None:
    command, env = exchange.server()
    for stop in (None, signal.SIGINT):
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**os.environ, **env}
        )
        if stop is None:
            out, err = process.communicate(timeout=60)
            assert (process.returncode, out, err) == (0, b"", b"")
        else:
            assert process.stdin is not None
            hello = {"jsonrpc": "2.0", "id": 1, "method": "ping"}
            process.stdin.write(json.dumps(hello).encode() + b"\n")
            process.stdin.flush()
            assert process.stdout is not None
            assert process.stdout.readline()  # it runs
            begun = time.monotonic()
            process.send_signal(stop)
            process.communicate(timeout=60)
            assert process.returncode == 130
            assert time.monotonic() - begun < 10
