"""Plug-ins of installed packages: off unless named, loaded by name, and said to be loaded."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import holdfast as hf
from holdfast.base import plugins
from holdfast.batches.job import BatchQuestion, Job
from holdfast.batches.rows import warm

FORMAT = """
import holdfast as hf
from holdfast.plugins import Format, Source, register_format

def read(source: Source) -> hf.Scene:
    bodies = [hf.Body("floor", hf.HalfSpace(), fixed=True)]
    for name, *at in map(str.split, source.text.splitlines()):
        bodies.append(hf.Body(name, hf.Box((0.2, 0.2, 0.2)), mass=1, position=[float(word) for word in at]))
    return hf.Scene(bodies, 0.5)

register_format(Format("boxes", (".boxes",), read=read))
"""
ENGINE = """
from holdfast import Limit
from holdfast.plugins import register_engine

def register() -> None:
    register_engine("mine", Limit)
"""
Run = Callable[..., subprocess.CompletedProcess[str]]


def install(folder: Path, package: str, version: str, modules: dict[str, str], points: str) -> None:
    """Write a package as an installer would: its modules, and its metadata with the entry points."""
    for name, text in modules.items():
        (folder / f"{name}.py").write_text(text)
    about = folder / f"{package.replace('-', '_')}-{version}.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: {version}\n")
    (about / "entry_points.txt").write_text(f"[holdfast.plugins]\n{points}\n")


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """A folder of installed packages."""
    found = tmp_path / "site"
    found.mkdir()
    install(
        found,
        "boxes-and-more",
        "1.2",
        {"of_boxes": FORMAT, "my_engine": ENGINE, "broken": "1 / 0"},
        "boxes = of_boxes\nmine = my_engine:register\nbroken = broken\nlacking = my_engine:nothing",
    )
    return found


@pytest.fixture
def holdfast(tmp_path: Path, site: Path) -> Run:
    """The command, as a process that finds these packages, in a folder with a file in their format."""
    home = tmp_path / "home"
    home.mkdir()
    (home / "pair.boxes").write_text("low 0 0 0.1\nhigh 0 0 0.3\n")
    path = os.pathsep.join([str(site), str(Path(hf.__file__).parents[1])])

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "holdfast", *arguments]
        environment = {**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"}
        return subprocess.run(command, cwd=home, env=environment, capture_output=True, text=True, check=False)

    return run


def test_nothing_is_loaded_unless_it_is_named(holdfast: Run) -> None:
    done = holdfast("assess", "pair.boxes")
    assert done.returncode == 2
    assert done.stderr.startswith("error: pair.boxes: is in no known format")
    done = holdfast("assess", "cube", "--engine", "mine")
    assert done.returncode == 2
    assert "'mine' is unknown" in done.stderr


def test_what_is_named_is_loaded_and_told(holdfast: Run) -> None:
    done = holdfast("--plugin", "boxes", "--plugin", "mine", "assess", "pair.boxes", "--engine", "mine", "--json")
    assert done.returncode == 0, done.stderr
    assert done.stderr.splitlines() == [
        "loaded plug-in boxes: of_boxes of package boxes-and-more 1.2",
        "loaded plug-in mine: my_engine:register of package boxes-and-more 1.2",
    ]
    told = json.loads(done.stdout)
    assert told["verdict"] == "stable"
    assert told["rows"][0]["bodies"] == ["low", "high"]
    assert told["notes"][:2] == [
        "plug-in boxes is loaded: of_boxes of package boxes-and-more 1.2",
        "plug-in mine is loaded: my_engine:register of package boxes-and-more 1.2",
    ]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("box", "plug-in: 'box' is not installed; installed: boxes, broken, lacking, mine; install the package that "),
        ("broken", "plug-in 'broken': broken of package boxes-and-more 1.2: ZeroDivisionError: division by zero; "),
        ("lacking", "plug-in 'lacking': my_engine:nothing of package boxes-and-more 1.2: AttributeError: module "),
    ],
)
def test_what_is_wrong_is_one_clear_error(holdfast: Run, name: str, said: str) -> None:
    done = holdfast("--plugin", name, "assess", "cube")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"error: {said}")
    assert len(done.stderr.splitlines()) == 1


def test_a_name_that_two_packages_have_is_refused(holdfast: Run, site: Path) -> None:
    install(site, "others", "3", {}, "boxes = of_others")
    done = holdfast("--plugin", "boxes", "assess", "pair.boxes")
    assert done.returncode == 2
    assert "'boxes': several packages have it: " in done.stderr
    assert "of_others of package others 3" in done.stderr
    assert "; uninstall all but one" in done.stderr


def test_the_option_goes_before_the_command(holdfast: Run) -> None:
    done = holdfast("assess", "pair.boxes", "--plugin", "boxes")
    assert done.returncode == 2
    assert "--plugin goes before the command: holdfast --plugin NAME assess SCENE" in done.stderr


def test_workers_of_a_batch_load_the_same(holdfast: Run) -> None:
    ask = ("batch", "*.boxes", "--out", "out", "--workers", "1")
    named = holdfast("--plugin", "boxes", *ask, "--json")
    assert named.returncode == 0, named.stderr
    told = json.loads(named.stdout)
    assert [row["verdict"] for row in told["rows"]] == ["stable"]
    assert told["notes"][0].startswith("plug-in boxes is loaded")
    again = holdfast("--plugin", "boxes", *ask)
    assert "0 computed, 1 from earlier runs" in again.stdout
    other = holdfast(*ask)
    assert other.returncode == 2
    assert "holds answers for plugins" in other.stderr


def test_doctor_lists_what_is_installed_without_loading_it(holdfast: Run) -> None:
    done = holdfast("doctor")
    assert done.returncode == 0
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("plug-in") and "of_boxes" in line]
    assert " ".join(line.split()) == (
        "plug-in boxes of_boxes of package boxes-and-more 1.2; off unless named: --plugin boxes"
    )
    assert json.loads(holdfast("doctor", "--json").stdout)["details"]["plugins"]["mine"] == (
        "my_engine:register of package boxes-and-more 1.2"
    )


def test_in_python_it_is_loaded_once_and_workers_have_the_same_version(
    site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (site / "counted.py").write_text("times = 0\ndef count():\n    global times\n    times += 1\n")
    install(site, "counted", "0.1", {}, "counted = counted:count")
    monkeypatch.syspath_prepend(site)
    monkeypatch.setattr(plugins, "LOADED", {})  # as it is afterwards
    text = "counted:count of package counted 0.1"
    assert [hf.plugins.load_plugin("counted") for _ in range(2)] == [text, text]
    assert sys.modules["counted"].times == 1
    with pytest.raises(hf.HoldfastError, match=r"a worker has counted:count of package counted .*, and not counted 9"):
        warm(Job(0, "", BatchQuestion(("stability",), plugins={"counted": "counted 9"})))


def test_a_scene_file_cannot_name_one(holdfast: Run, tmp_path: Path) -> None:
    hf.save_scene(hf.shipped_scene("cube"), tmp_path / "home" / "cube.yaml")
    with (tmp_path / "home" / "cube.yaml").open("a") as file:
        file.write("plugins: [boxes]\n")
    done = holdfast("assess", "cube.yaml")
    assert done.returncode == 2
    assert "plugins" in done.stderr
    assert "loaded" not in done.stderr
