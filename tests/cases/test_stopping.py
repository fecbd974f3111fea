"""Ctrl-C ends a command at once, whatever its main thread is in, and leaves no half-written file (D19, item 7)."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import Timer
from typing import NamedTuple

import pytest
from shared import FOLDER, needed
from test_cargo import pallet
from test_messy_scenes import ORANGE, SHELF

import holdfast as hf
from holdfast.scene.shipped.blocks import wall

pytestmark = pytest.mark.skipif(not hasattr(os, "wait4"), reason="processor time of one process is not told here")
DONE = (0, 1, 3)  # exit codes of commands that have an answer
SOON = 0.5  # [s] of processor time after Ctrl-C, all threads together
DEEP_IN = 0.3  # [s] of processor time, in which a process is sure to come to what it is to be interrupted in
LONGEST = 60  # [s] that a process is waited for that does not end
PLACE = 39  # in the list of pallets: 108 boxes
HASH = "pbkdf2_hmac('sha256', b'a', b'b', 200_000_000)"  # a minute and more of machine code that hears no signal

DEEP = f"""
import sys
from hashlib import pbkdf2_hmac
from holdfast.cli.stopping import stoppable
with stoppable(process=True):
    print("ready", flush=True)
    {HASH}
"""
DEAF = """
from hashlib import pbkdf2_hmac
from holdfast.cli.stopping import stoppable
with stoppable(process=True):
    print("ready", flush=True)
    while True:
        try:
            while True:
                pbkdf2_hmac('sha256', b'a', b'b', 10_000)
        except BaseException:
            pass
"""
LOST = """
import ctypes
from holdfast.cli.stopping import stoppable
@ctypes.CFUNCTYPE(None)
def called():  # as the compiler calls Python: what it raises goes nowhere
    while True:
        pass
with stoppable(process=True):
    print("ready", flush=True)
    while True:
        called()
"""
FULL = """
import sys
from holdfast.cli.stopping import stoppable
with stoppable(process=True):
    print("ready", flush=True)
    for _ in range(40_000_000):
        pass
    while True:
        sys.stdout.write("x" * 1_000_000)
"""
WRITES = f"""
import os
from hashlib import pbkdf2_hmac
from holdfast.base.files import write_atomically
from holdfast.cli.stopping import stoppable
def slow(_):
    print("ready", flush=True)
    {HASH}
os.fsync = slow
with stoppable(process=True):
    write_atomically("file.txt", b"new")
"""


class End(NamedTuple):
    """How a command ended: its exit code, what it said on stderr, and the processor time after the interrupt [s]."""

    code: int
    said: str
    took: float


def processor_time(number: int) -> float:
    """Seconds that a running process has used so far."""
    try:
        fields = Path(f"/proc/{number}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def stopped(folder: Path, arguments: list[str], wait: float | None, **variables: str) -> End:
    """Interrupt Python with these arguments ``wait`` s of processor time after its start, or soon after it is ready."""
    said = folder / "said.txt"
    with said.open("w") as err:
        process = subprocess.Popen(
            [sys.executable, *arguments],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=err,
            env=os.environ | variables,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler) and None,
        )
        assert process.stdout is not None
        if wait is None:
            assert process.stdout.readline() == b"ready\n"
            wait = processor_time(process.pid) + DEEP_IN
        until = time.monotonic() + LONGEST
        while process.poll() is None and processor_time(process.pid) < wait and time.monotonic() < until:
            time.sleep(0.01)
        if process.returncode is not None:
            return End(process.returncode, said.read_text(encoding="utf-8"), 0.0)
        before = processor_time(process.pid)
        process.send_signal(signal.SIGINT)
        patience = Timer(LONGEST, process.kill)
        patience.start()
        _, status, used = os.wait4(process.pid, 0)
        patience.cancel()
        process.stdout.close()
        process.returncode = os.waitstatus_to_exitcode(status)
    took = used.ru_utime + used.ru_stime - before
    return End(process.returncode, said.read_text(encoding="utf-8"), took)


NEVER = {"machine code": DEEP, "a library catches it": DEAF, "a callback loses it": LOST, "full pipe": FULL}


@pytest.mark.parametrize("program", NEVER.values(), ids=NEVER)
def test_a_command_ends_that_hears_nothing(program: str, tmp_path: Path) -> None:
    """The machine code would take a minute of processor time and more; the bound is far from that."""
    end = stopped(tmp_path, ["-c", program], None)
    assert (end.code, end.said) == (130, "stopped: by the user\n")
    assert end.took < 5


def test_a_file_that_is_being_written_stays_as_it_was(tmp_path: Path) -> None:
    (tmp_path / "file.txt").write_bytes(b"old")
    assert stopped(tmp_path, ["-c", WRITES], None).code == 130
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir() if path.name != "said.txt"} == {
        "file.txt": b"old"
    }


@pytest.mark.parametrize("kind", ["ValueError", "OSError", "SceneError"])
def test_an_error_that_comes_of_an_interrupt_is_not_reported(kind: str) -> None:
    """The compiler fails with an error of its own where an interrupt is lost in it: that is no defect of holdfast."""
    program = f"""
import os, signal
from holdfast.base.errors import SceneError
from holdfast.cli import main
from holdfast.cli.stopping import stoppable
def app(standalone_mode):
    try:
        os.kill(os.getpid(), signal.SIGINT)
    except KeyboardInterrupt:
        raise {kind}("of the compiler") from None
signal.signal(signal.SIGINT, signal.default_int_handler)
main.app = app
with stoppable(process=True):
    main.run()
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (130, "stopped: by the user\n")


@pytest.mark.parametrize(("ending", "code"), [("pass", 0), ("sys.exit(1)", 1)])
def test_a_command_that_is_done_is_not_stopped_any_more(ending: str, code: int) -> None:
    """Python takes a tenth of a second to clear up; an interrupt then ended it by a traceback or by the signal."""
    program = f"""
import atexit, os, signal, sys
from holdfast.cli.stopping import stoppable
signal.signal(signal.SIGINT, signal.default_int_handler)
atexit.register(lambda: os.kill(os.getpid(), signal.SIGINT))
with stoppable(process=True):
    {ending}
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (code, "")


def test_outside_a_process_of_its_own_nothing_is_ended(tmp_path: Path) -> None:
    """Called from Python, a command raises; no thread waits to end the process."""
    program = "from holdfast.cli.stopping import stoppable\nwith stoppable():\n    import threading, signal\n"
    program += "    assert threading.active_count() == 1\n    assert signal.set_wakeup_fd(-1) == -1\n"
    assert subprocess.run([sys.executable, "-c", program], cwd=tmp_path, check=False).returncode == 0


COMMANDS = {
    "map": ["map", "pallet.yaml", "--spacing", "0.05"],
    "map by limit": ["map", "pallet.yaml", "--spacing", "0.05", "--engine", "limit"],
    "assess a scan": ["assess", str(FOLDER / "settled" / "masonry_crossvault.json")],
    "push": ["push", "pallet.yaml", "box3", "--at", "{corner}", "--along", "1", "0", "0"],
    "transport": ["transport", "pallet.yaml"],
    "carry": ["carry", "pallet.yaml", "--profile", "road"],
    "disassemble": ["disassemble", "wall.yaml"],
    "build": ["build", "wall.yaml"],
    "safe": ["safe", "pallet.yaml", "box3", "--force", "50"],
    "place": ["place", "shelf.yaml", "orange"],
}
MOMENTS = {"cold": (0.3, 1.0, 2.5, 6.0, 12.0), "warm": (0.3, 0.8, 1.3, 1.8, 2.5, 4.0, 7.0, 12.0)}  # [s] after its start


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A pallet of 108 boxes, a wall and a shelf of eight unlike bodies with an orange."""
    folder = tmp_path_factory.mktemp("scenes")
    hf.save_scene(pallet(PLACE), folder / "pallet.yaml")
    hf.save_scene(wall(8, 6, 0.5, "wall"), folder / "wall.yaml")
    hf.save_scene(hf.Scene([*SHELF, ORANGE], 0.5), folder / "shelf.yaml")
    return folder


@needed
@pytest.mark.slow
@pytest.mark.parametrize("kind", MOMENTS)
@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_ends_within_half_a_second(command: str, kind: str, scenes: Path, tmp_path: Path) -> None:
    """Of processor time, whatever it is at: imports, compiling, load paths, solves, pictures."""
    corner = [str(x) for x in hf.load_scene(scenes / "pallet.yaml").body("box3").box[1]]
    arguments = ["-m", "holdfast"]
    for word in COMMANDS[command]:
        arguments += corner if word == "{corner}" else [word]
    own = {"HOLDFAST_CACHE_DIR": str(tmp_path)} if kind == "cold" else {}
    ends = []
    for wait in MOMENTS[kind]:
        ends.append(stopped(scenes, arguments, wait, **own))
        if ends[-1].took == 0:  # it was done before
            break
    late = [end for end in ends if end.took > 0]
    assert late
    if late[-1].code in DONE and not late[-1].said:  # it was done and cleared up
        late.pop()
    assert [(end.code, end.said.count("stopped: by the user")) for end in late] == [(130, 1)] * len(late)
    assert [end.said for end in late if "Traceback" in end.said] == []
    assert max(end.took for end in late) <= SOON, [round(end.took, 2) for end in late]
