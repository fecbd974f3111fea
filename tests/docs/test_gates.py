"""The hook for commits and the GitHub action do what their page says, whatever files and inputs are called.

The steps of the action run here as a runner would run them: inputs in the environment, bash with GitHub's options, and
in place of what the first step installs the holdfast of these tests.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree as Xml

import pytest
import yaml

import holdfast as hf

ROOT = Path(__file__).parents[2]
PACKAGE = Path(hf.__file__).parents[1]
ACTION = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))
(HOOK,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text(encoding="utf-8"))
PAGE = (ROOT / "docs" / "howto" / "gate.md").read_text(encoding="utf-8")
INPUT = re.compile(r"\$\{\{ (inputs|github)\.(\w+) \}\}")
ODD = (
    *("a b.yaml", "it's 'so'.yaml", "größe μ.yaml", "-dash.yaml", "--out=x.yaml", "a[1].yaml", "a*.yaml"),
    *(
        "$(touch pwned).yaml",
        "`touch pwned`.yaml",
        "; touch pwned;.yaml",
        "a\\b.yaml",
        "::error::##[error]x.yaml",
        " .yaml",
    ),
)


class Step(NamedTuple):
    """How a step of the action ended: its exit code, its log, the summary of the job and its outputs."""

    code: int
    log: str
    summary: str
    outputs: str


def stepped(name: str, folder: Path, **inputs: str) -> Step:
    """Run a step of the action in ``folder`` with these inputs, as a runner does."""
    known = {key: each.get("default", "") for key, each in ACTION["inputs"].items()}
    assert inputs.keys() <= known.keys()
    values = {f"inputs.{key}": value for key, value in (known | inputs).items()} | {"github.action_path": str(ROOT)}
    (step,) = (step for step in ACTION["runs"]["steps"] if step["name"] == name)
    runner = folder.parent / "the runner's"
    (runner / "temp").mkdir(parents=True, exist_ok=True)
    (runner / "script.sh").write_text(step["run"], encoding="utf-8")
    files = {"GITHUB_STEP_SUMMARY": runner / "summary", "GITHUB_OUTPUT": runner / "output"}
    for path in files.values():
        path.write_text("", encoding="utf-8")
    given = {key: INPUT.sub(lambda found: values[f"{found[1]}.{found[2]}"], text) for key, text in step["env"].items()}
    ended = subprocess.run(
        ["bash", "--noprofile", "--norc", "-eo", "pipefail", str(runner / "script.sh")],
        cwd=folder,
        env=os.environ | {"RUNNER_TEMP": str(runner / "temp"), "PYTHONPATH": str(PACKAGE)} | files | given,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return Step(ended.returncode, ended.stdout, *(path.read_text(encoding="utf-8") for path in files.values()))


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """An empty folder, and beside it the environment that the first step of the action makes."""
    (tmp_path / "checkout").mkdir()
    programs = tmp_path / "the runner's" / "temp" / "holdfast" / "bin"
    programs.mkdir(parents=True)
    for name, means in (("python", ""), ("holdfast", " -m holdfast")):
        (programs / name).write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)}{means} "$@"\n')
        (programs / name).chmod(0o755)
    return tmp_path / "checkout"


def cases(folder: Path) -> dict[str, list[str]]:
    """What the report of the action says of each scene."""
    found = Xml.parse(folder / "holdfast-check.xml").getroot().iter("testcase")
    return {str(case.get("name")): [child.tag for child in case] for case in found}


def save(path: Path, height: float = 0.0) -> None:
    """Write the shipped cube, so much above its floor [m]."""
    cube = hf.shipped_scene("cube")
    pose = cube.body("cube").pose.copy()
    pose[2, 3] += height
    hf.save_scene(cube.moved({"cube": pose}), path)


def test_no_input_is_text_of_a_script() -> None:
    for step in ACTION["runs"]["steps"]:
        assert "${{" not in step["run"]
        assert step["shell"] == "bash"
        for text in step["env"].values():
            assert INPUT.fullmatch(text)
    used = {
        found[2] for step in ACTION["runs"]["steps"] for text in step["env"].values() for found in INPUT.finditer(text)
    }
    assert used - {"action_path"} == ACTION["inputs"].keys()


def test_the_action_checks_reports_and_sums_up(checkout: Path) -> None:
    save(checkout / "good.yaml")
    save(checkout / "falls.yaml", 1.0)
    step = stepped("check scenes", checkout, paths="good.yaml\n\nfalls.yaml\n")
    assert step.code == 1, step.log
    assert cases(checkout) == {"good.yaml": [], "falls.yaml": ["failure"]}
    assert step.summary.startswith("### holdfast check: 1 passed, 1 failed, 0 undecided\n\n<table>")
    assert "<td>failed</td><td>falls.yaml</td>" in step.summary
    assert "holdfast settle falls.yaml" in step.summary
    assert step.outputs == "junit=holdfast-check.xml\n"


def test_push_and_tolerance_reach_the_check(checkout: Path) -> None:
    """The cube slips at 5.886 N; 1 mm above its floor nothing holds it but a wider tolerance."""
    save(checkout / "cube.yaml", 1e-3)
    assert stepped("check scenes", checkout, paths="*.yaml").code == 3
    assert cases(checkout) == {"cube.yaml": ["error"]}
    assert stepped("check scenes", checkout, paths="*.yaml", tolerance="0.002").code == 0
    assert stepped("check scenes", checkout, paths="*.yaml", tolerance="0.002", push="20").code == 1


def test_names_are_names_in_the_action(checkout: Path) -> None:
    for name in ODD:
        save(checkout / name)
    step = stepped("check scenes", checkout, paths="\n".join(ODD))
    assert step.code == 0, step.log
    assert cases(checkout) == {name: [] for name in ODD}
    assert sorted(path.name for path in checkout.iterdir()) == sorted([*ODD, "holdfast-check.xml"])


def test_nothing_that_a_scene_says_is_a_command_of_a_workflow(checkout: Path) -> None:
    (checkout / "::error::##[error]<b>x.yaml").write_text("format: '::error::'", encoding="utf-8")
    step = stepped("check scenes", checkout, paths="*.yaml")
    first, *_, last = step.log.splitlines()
    word = re.fullmatch(r"::stop-commands::([0-9a-f]{32})", first)
    assert word is not None
    assert last == f"::{word[1]}::"
    assert "<b>" not in step.summary


@pytest.mark.parametrize(
    ("name", "inputs"),
    [
        ("check scenes", {"paths": "\n"}),
        ("check scenes", {"paths": "none.yaml"}),
        ("check scenes", {"push": "$(touch pwned)"}),
        ("check scenes", {"push": "-1"}),
        ("check scenes", {"push": "nan"}),
        ("check scenes", {"tolerance": '0.1" --out "pwned'}),
        ("check scenes", {"tolerance": "nan"}),
        ("install holdfast-robotics", {"extras": "usd]; touch pwned #"}),
        ("install holdfast-robotics", {"extras": "usd] @ https://x.example/y #"}),
        ("install holdfast-robotics", {"version": "1.0 --pre"}),
        ("install holdfast-robotics", {"python": "no such python"}),
        ("install holdfast-robotics", {"python": "--version"}),
    ],
)
def test_bad_inputs_are_told(checkout: Path, name: str, inputs: dict[str, str]) -> None:
    save(checkout / "a.yaml")
    step = stepped(name, checkout, **({"paths": "a.yaml"} | inputs))
    assert step.code == 2, step.log
    assert re.search(r"holdfast action: \w+: |error: |Invalid value", step.log)
    assert [path.name for path in checkout.iterdir()] == ["a.yaml"]
    assert name != "check scenes" or step.outputs == ""


@pytest.mark.parametrize(
    ("inputs", "wanted"),
    [
        ({}, str(ROOT)),
        ({"extras": "usd,mujoco"}, f"{ROOT}[usd,mujoco]"),
        ({"from": "index", "extras": "usd"}, f"holdfast-robotics[usd]=={hf.__version__}"),
        ({"from": "index", "version": "1.0.0"}, "holdfast-robotics==1.0.0"),
    ],
)
def test_the_action_installs_what_is_asked_for(tmp_path: Path, inputs: dict[str, str], wanted: str) -> None:
    """The interpreter here makes an environment whose python notes what it is asked."""
    (tmp_path / "checkout").mkdir()
    python, noted = tmp_path / "a python", tmp_path / "noted"
    note = f'#!/bin/sh\nprintf "%s\\n" "$@" > {shlex.quote(str(noted))}\n'
    program = f"""#!{sys.executable}
import pathlib, sys
if sys.argv[1:3] == ["-m", "venv"]:
    made = pathlib.Path(sys.argv[3], "bin", "python")
    made.parent.mkdir(parents=True)
    made.write_text({note!r})
    made.chmod(0o755)
"""
    python.write_text(program, encoding="utf-8")
    python.chmod(0o755)
    step = stepped("install holdfast-robotics", tmp_path / "checkout", python=str(python), **inputs)
    assert step.code == 0, step.log
    assert noted.read_text(encoding="utf-8").splitlines()[-2:] == ["--", wanted]


def test_the_hook_checks_scenes_and_nothing_else(checkout: Path) -> None:
    for name in ODD:
        save(checkout / name)
    (checkout / "workflow.yml").write_text("on: &x push\njobs: {}\n", encoding="utf-8")
    (checkout / "package.json").write_text("{}", encoding="utf-8")
    (checkout / "package.xml").write_text("<package/>", encoding="utf-8")
    (checkout / "notes.txt").write_text("no scene", encoding="utf-8")
    call = [sys.executable, "-m", *shlex.split(HOOK["entry"])]

    def hooked(*args: str) -> tuple[int, str]:
        names = [path.name for path in checkout.iterdir() if re.search(HOOK["files"], path.name)]
        asked = [*call, *(args or HOOK["args"]), *names]
        environment = os.environ | {"PYTHONPATH": str(PACKAGE)}
        ended = subprocess.run(asked, cwd=checkout, env=environment, capture_output=True, text=True, check=False)
        return ended.returncode, ended.stdout + ended.stderr

    code, told = hooked()
    assert (code, told) == (0, f"{len(ODD)} passed, 0 failed, 0 undecided; passed over 3 files without a scene\n")
    code, told = hooked("--seconds", "30")
    assert code == 2
    assert "reads like an option" in told, "own args without -- stop at such a file, and write nothing"
    for name in ODD:
        (checkout / name).unlink()
    save(checkout / "falls.yaml", 1.0)
    (checkout / "damaged.yaml").write_text("format: holdfast-scene/1\nbodies: [", encoding="utf-8")
    code, told = hooked()
    assert code == 1
    assert "failed: falls.yaml: " in told
    assert "failed: damaged.yaml: " in told


def blocks(kind: str) -> list[Any]:
    """The YAML blocks of the page in whose text this word stands."""
    found = [yaml.safe_load(text) for text in re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)]
    return [each for each in found if kind in yaml.safe_dump(each)]


def test_the_page_configures_the_hook_that_there_is() -> None:
    hooks = [hook for each in blocks("repos:") for repo in each["repos"] for hook in repo["hooks"]]
    assert hooks
    for hook in hooks:
        assert hook["id"] == HOOK["id"]
        assert hook.get("args", HOOK["args"])[-1] == "--"


def test_the_page_uses_the_action_as_it_is(checkout: Path) -> None:
    (checkout / "scenes").mkdir()
    save(checkout / "scenes" / "cube.yaml")
    used = [step for each in blocks("/holdfast@") for step in each["jobs"]["scenes"]["steps"]]
    (ours,) = (step for step in used if "/holdfast@" in step["uses"])
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    assert set(ours["with"].pop("extras").split(",")) <= extras.keys()
    step = stepped("check scenes", checkout, **{key: str(value) for key, value in ours["with"].items()})
    assert step.code == 0, step.log
    upload = next(step for step in used if "upload-artifact" in step["uses"])
    assert (checkout / upload["with"]["path"]).exists()
