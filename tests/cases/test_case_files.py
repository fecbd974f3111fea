"""Every file of the intake and hostile cases does what its README or the findings say, by the command line."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import shared

import holdfast as hf

INTAKE, HOSTILE = shared.FOLDER / "intake", shared.FOLDER / "hostile"
GIVEN = ("--friction", "0.5", "--density", "500")

# the file, more arguments of `holdfast assess`, the exit code, and a part of what is said
OUTCOMES = [
    ("slides_as_free.xml", (), 1, "'can' moves freely by its joints"),
    ("drake_mu.sdf", (), 1, "box slides along"),
    ("half_over.yaml", (), 0, "only balanced, as on an edge, a corner or a round side: top"),
    ("bond2.yaml", (), 0, "only balanced"),
    ("bond_n2_999.yaml", (), 0, ""),
    ("sdf_declared_and_sun.sdf", (), 3, "nothing here can move"),
    ("conveyor_pose.sdf", (), 0, ""),
    ("open_part.yaml", (), 0, ""),
    ("open_fixed.urdf", ("--fixed", "stand", "--friction", "0.5"), 3, "nothing here can move"),
    ("nstack.xml", (), 0, ""),
    ("two_meshes_compas.json", (*GIVEN, "--floor"), 0, ""),
    ("kitchen.scene", (*GIVEN, "--fixed", "table"), 0, ""),
    ("excluded_pair.xml", (), 1, "b is 0 mm from floor, but the scene keeps these two apart"),
    # grips and studs cannot be said yet: what is said is what friction alone holds
    ("pinch.yaml", (), 1, "nothing presses the contacts that it needs"),
    ("lego_cantilever.yaml", (), 1, "over turns about the axis"),
    ("drake_scene.dmd.yaml", (), 0, "tags of drake"),
    # what is missing is told, and nothing is guessed
    ("table.scene_instance.json", (), 2, "give --model-path the folder of the data set"),
    ("rim.obj", (), 2, "give --friction, --density or --mass, and --floor or --fixed"),
    ("rim.obj", (*GIVEN, "--floor", "--collision", "hull"), 3, "rim is 10 mm above 'floor'"),
]
ATTACKS = [
    ("m_model.xml", (), 2, "m_model.xml"),
    ("case_900308.usdz", (), 2, "case_900308.usdz"),
    ("hang.json", (), 1, "unsupported"),
    ("layers/main.usda", (), 2, "has no physics material, so no friction; give --friction"),
]
FILES = [(INTAKE, *case) for case in OUTCOMES] + [(HOSTILE, *case) for case in ATTACKS]


def assess(path: str, *arguments: str, folder: Path) -> tuple[int, str]:
    """The exit code of `holdfast assess` and what it says, asked in this folder with a relative path."""
    environment = {**os.environ, "COLUMNS": "400", "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "holdfast", "assess", path, *arguments]
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=240, check=False
    )
    return done.returncode, done.stdout + done.stderr


@shared.needed
@pytest.mark.parametrize(("folder", "file", "arguments", "code", "told"), FILES, ids=[case[1] for case in FILES])
def test_what_is_said_of_files_from_elsewhere(
    folder: Path, file: str, arguments: tuple[str, ...], code: int, told: str
) -> None:
    if file.endswith(".xml"):
        pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'holdfast-robotics[mujoco]'")
    if ".usd" in file:
        pytest.importorskip("pxr", reason="needs usd-core: pip install 'holdfast-robotics[usd]'")
    got, said = assess(file, *arguments, folder=folder)
    assert "Traceback" not in said
    assert (got, told in said) == (code, True), said


@shared.needed
@pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")
def test_faces_that_are_wound_against_each_other_settle() -> None:
    scene = hf.load_scene(HOSTILE / "zero.json")
    assert hf.settle(scene).status in (hf.Status.UNSTABLE, hf.Status.UNDECIDED)
