"""Commands that run in a folder full of modules that somebody else put there, beside the scenes: none is imported."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import holdfast as hf

CODE = (
    "import os\nos.open(os.path.join({folder!r}, 'ran-' + __name__), os.O_CREAT | os.O_WRONLY)\nraise SystemExit(99)\n"
)
OTHERS = ("numpy", "scipy", "yaml", "trimesh", "shapely", "manifold3d", "clarabel", "pydantic")
OTHERS += ("typer", "rich", "pyarrow", "pxr", "mujoco", "matplotlib", "distributed", "sitecustomize", "usercustomize")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Modules of all names that anything here may import, each of which would leave a file and stop the process."""
    here = tmp_path / "data"
    here.mkdir()
    for name in {*sys.stdlib_module_names, *OTHERS, "holdfast"}:
        (here / f"{name}.py").write_text(CODE.format(folder=str(here)))
    hf.save_scene(hf.shipped_scene("cube"), here / "scene.yaml")
    return here


def run(folder: Path, *command: str) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert not [each.name for each in folder.glob("ran-*")]
    return done.stdout


SCRIPT = shutil.which("holdfast", path=os.path.dirname(sys.executable)) or "holdfast"
ASKED = (["check", "scene.yaml", "--stands"], ["batch", "scene.yaml", "--out", "out"], ["assess", "scene.yaml"])


@pytest.mark.parametrize("asked", ASKED, ids=lambda each: each[0])
@pytest.mark.parametrize("command", [[SCRIPT], [sys.executable, "-P", "-m", "holdfast"]], ids=["script", "-P -m"])
def test_nothing_of_the_current_folder_is_imported(folder: Path, command: list[str], asked: list[str]) -> None:
    if not os.path.exists(command[0]):
        pytest.skip("needs the command holdfast, which is not installed beside Python")
    run(folder, *command, *asked)


def test_python_m_leaves_the_current_folder_as_soon_as_it_can(folder: Path) -> None:
    """What Python imports to find holdfast is out of reach, all others are not."""
    for name in (*python_imports_at_once(folder), "holdfast"):
        (folder / f"{name}.py").unlink(missing_ok=True)
    assert {"json.py", "numpy.py", "yaml.py"} <= {each.name for each in folder.glob("*.py")}
    run(folder, sys.executable, "-m", "holdfast", "check", "scene.yaml", "--stands")


def python_imports_at_once(folder: Path) -> set[str]:
    """What ``python -m`` has imported when a module begins, in a folder without any other."""
    (folder.parent / "bare.py").write_text("import sys\nprint(*sys.modules)\n")
    command = [sys.executable, "-m", "bare"]
    done = subprocess.run(command, cwd=folder.parent, capture_output=True, text=True, check=True)
    return {name.split(".")[0] for name in done.stdout.split()}


def test_an_empty_entry_of_the_search_path_is_not_the_current_folder_of_workers(folder: Path) -> None:
    """``export PYTHONPATH=$PYTHONPATH:/somewhere`` makes one; the driver starts elsewhere, its worker works here."""
    code = f"import os, sys; sys.path[:] = [each for each in sys.path if each]; os.chdir({str(folder)!r}); "
    code += "import holdfast as hf; print(dict(hf.batch('scene.yaml', out='out').outcomes))"
    home = str(Path(hf.__file__).parents[1])
    environment = {**os.environ, "PYTHONPATH": f"{home}{os.pathsep}{os.pathsep}"}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=folder.parent, capture_output=True, text=True, check=False, env=environment)
    assert "'answered': 1" in done.stdout, done.stderr
    assert not list(folder.glob("ran-*"))
