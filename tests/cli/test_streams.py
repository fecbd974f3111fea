"""Where the command line reads and writes: full disks, closed pipes, ASCII, stdin, Ctrl-C (D11, D19, D20, U6, U7)."""

from __future__ import annotations

import errno
import io
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from calling import Call

import holdfast as hf
from holdfast.cli.output import Output, OutputLost, make_writable, out, print_json
from holdfast.cli.stopping import STOPPED, stoppable
from holdfast.scene.shipped.blocks import box, cube, floor

FULL = Path("/dev/full")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    hf.save_scene(hf.Scene(cube().bodies, 0.5, name="σ"), "s.yaml")
    return tmp_path


def run(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "holdfast", *arguments]
    return subprocess.run(command, stderr=subprocess.PIPE, text=True, timeout=120, check=False, **options)


@pytest.mark.skipif(not FULL.exists(), reason="there is no /dev/full on this system")
@pytest.mark.parametrize("arguments", [("schema",), ("assess", "cube", "--engine", "limit")])
def test_d11_a_full_disk_is_told_on_one_line(arguments: tuple[str, ...]) -> None:
    with FULL.open("w") as full:
        done = run(*arguments, stdout=full)
    assert done.returncode == 2
    assert done.stderr == "error: output: cannot be written: No space left on device; check where it goes\n"


def test_d11_a_pipe_that_nobody_reads_ends_quietly() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    done = run("schema", stdout=writing)
    os.close(writing)
    assert (done.returncode, done.stderr) == (141, "")


class Failing(io.StringIO):
    """A stream on which everything fails as on a full disk, or as on a pipe that is closed."""

    def __init__(self, code: int) -> None:
        super().__init__()
        self.code = code

    def write(self, text: str) -> int:
        raise OSError(self.code, os.strerror(self.code))


@pytest.mark.parametrize(("code", "exit_code"), [(errno.ENOSPC, 2), (errno.EIO, 2), (errno.EPIPE, 141)])
@pytest.mark.parametrize(
    "arguments", [("assess", "s.yaml", "--engine", "limit"), ("assess", "s.yaml", "--json"), ("--version",)]
)
def test_d11_lost_output_of_every_kind_has_its_exit_code(
    code: int, exit_code: int, arguments: tuple[str, ...], folder: Path, call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdout", Failing(code))
    found, _, err = call(*arguments)
    assert found == exit_code
    assert err == (
        "" if exit_code == 141 else f"error: output: cannot be written: {os.strerror(code)}; check where it goes\n"
    )


def test_d11_no_output_at_all_is_told(folder: Path, call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", None)
    assert call("assess", "s.yaml", "--engine", "limit")[0] == 2
    with pytest.raises(OutputLost):
        print_json(1)


def test_errors_that_cannot_be_told_keep_their_exit_code(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", Failing(errno.ENOSPC))
    assert call("assess", "nope.yaml")[0] == 2


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp437"])
def test_u6_terminals_of_few_letters_get_what_they_can_show(
    encoding: str, folder: Path, call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding=encoding, write_through=True)
    monkeypatch.setattr(sys, "stdout", stream)
    code, _, err = call("assess", "s.yaml", "--engine", "limit")
    assert (code, err) == (0, "")
    said = raw.getvalue().decode(encoding)
    assert "stands" in said
    assert "?" not in said
    assert ("area [cm2]" if encoding == "ascii" else "area [cm²]") in said
    assert ("sigma: stands" if encoding != "cp437" else "σ: stands") in said


def test_u6_letters_without_a_likeness_are_written_out() -> None:
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding="ascii", write_through=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "stdout", stream)
        make_writable()
        out.say("日 μ")
    assert raw.getvalue() == b"\\u65e5 u\n"


def test_u6_ascii_alone_is_enough_for_a_whole_run() -> None:
    done = run(
        "assess", "cube", "--engine", "limit", stdout=subprocess.PIPE, env=os.environ | {"PYTHONIOENCODING": "ascii"}
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.isascii()


@pytest.fixture
def heard() -> Iterator[None]:
    """Ctrl-C is heard although these tests may run in the background, where shells let it be ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heard")
def test_d19_ctrl_c_says_stopped() -> None:
    """At any moment, the second of imports included."""
    for wait in (0.3, 1.2):
        command = [sys.executable, "-m", "holdfast", "disassemble", "bonded_wall"]
        started = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        time.sleep(wait)
        started.send_signal(signal.SIGINT)
        _, err = started.communicate(timeout=120)
        if started.returncode == -signal.SIGINT:
            continue  # before the first line of holdfast ran
        assert (started.returncode, err.splitlines()[-1:]) == (130, ["stopped: by the user"])
        assert "Traceback" not in err


@pytest.mark.usefixtures("heard")
def test_d19_an_interrupt_that_a_library_swallows_still_stops(capsys: pytest.CaptureFixture[str]) -> None:
    def swallowed() -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        except BaseException:
            raise TypeError("half imported") from None

    with pytest.raises(SystemExit) as stopped, stoppable():
        swallowed()
    assert stopped.value.code == STOPPED == 130
    assert capsys.readouterr().err == "stopped: by the user\n"
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_d19_other_errors_stay_what_they_are() -> None:
    with pytest.raises(TypeError), stoppable():
        raise TypeError


@pytest.mark.usefixtures("heard")
def test_d19_within_a_command(call: Call, monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    monkeypatch.setattr("holdfast.cli.scenes.assemble", lambda *_, **__: signal.raise_signal(signal.SIGINT))
    assert call("assess", "s.yaml") == (130, "", "stopped: by the user\n")


class Stream:
    def __init__(self, content: bytes) -> None:
        self.buffer = io.BytesIO(content)


def test_u6_a_minus_is_standard_input(folder: Path, call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    content = (folder / "s.yaml").read_bytes()
    monkeypatch.setattr(sys, "stdin", Stream(content))
    code, text, _ = call("assess", "-", "--json", "--engine", "limit")
    assert (code, json.loads(text)["verdict"]) == (0, "stable")
    monkeypatch.setattr(sys, "stdin", Stream(b"friction: 1\n"))
    code, _, err = call("assess", "-")
    assert code == 2
    assert err.startswith("error: -: is in no known format")


@pytest.mark.parametrize("stdin", [None, Stream(b"")])
def test_u6_an_empty_standard_input_is_told(stdin: object, call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", stdin)
    code, _, err = call("assess", "-")
    assert code == 2
    assert err.startswith("error: -: standard input is ")


def test_u6_a_minus_is_standard_output_of_convert(folder: Path, call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    code, text, err = call("convert", "s.yaml", "-")
    assert (code, err) == (0, "")
    assert text == (folder / "s.yaml").read_text()
    monkeypatch.setattr(sys, "stdin", Stream(text.encode()))
    assert call("convert", "-", "t.json")[0] == 0
    assert hf.load_scene("t.json") == hf.load_scene("s.yaml")
    assert call("convert", "s.yaml", "-", "--json")[0] == 2


@pytest.mark.parametrize("option", ["--png", "--html"])
def test_u6_a_minus_is_no_picture(option: str, folder: Path, call: Call) -> None:
    code, _, err = call("map", "s.yaml", option, "-")
    assert (code, err) == (2, f"error: {option}: - does not end in .{option[2:]}; name a .{option[2:]} file\n")


@pytest.mark.parametrize("target", ["s.yaml", "./s.yaml", "link.yaml", "hard.yaml"])
def test_u6_a_scene_is_not_converted_onto_itself(target: str, folder: Path, call: Call) -> None:
    (folder / "link.yaml").symlink_to("s.yaml")
    os.link("s.yaml", "hard.yaml")
    before = (folder / "s.yaml").read_bytes()
    code, _, err = call("convert", "s.yaml", target)
    assert (code, err.count("is the file that is read; name another TARGET")) == (2, 1)
    assert (folder / "s.yaml").read_bytes() == before


def test_d20_an_output_that_is_a_link_is_written_through(folder: Path, call: Call) -> None:
    (folder / "link.json").symlink_to("target.json")
    assert call("convert", "s.yaml", "link.json")[0] == 0
    assert (folder / "link.json").is_symlink()
    assert hf.load_scene(folder / "target.json") == hf.load_scene(folder / "s.yaml")


def test_the_console_takes_no_markup() -> None:
    stream = io.StringIO()
    console = Output()
    console.file = stream
    console.say("[red]x[/red] :smile: [/]")
    assert stream.getvalue() == "[red]x[/red] :smile: [/]\n"


def test_u7_allow_large_is_the_remedy_that_the_error_names(folder: Path, call: Call) -> None:
    hf.save_scene(hf.Scene([floor(1000, 1000), box("cup", (70, 70, 100), 1, (0, 0, 50))], 0.5), "mm.yaml")
    code, _, err = call("assess", "mm.yaml", "--engine", "limit")
    assert code == 2
    assert "are the sizes in millimetres?" in err
    assert "--allow-large" in err
    assert call("assess", "mm.yaml", "--engine", "limit", "--allow-large")[0] == 0
