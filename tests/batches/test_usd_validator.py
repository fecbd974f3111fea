"""The rule for NVIDIA's USD validator: found by its command, good and broken stages told apart, mended on request."""

from __future__ import annotations

import csv
import importlib.util
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from broken_stages import STAGES, box, crates, text

import holdfast as hf
from holdfast.base.errors import SceneError
from holdfast.batches.scene_findings import SceneFinding
from holdfast.batches.usd_validator import PARAMETERS, stage_findings
from holdfast.scene.formats.usd.moved_prims import Placement, place

pxr = pytest.importorskip("pxr", reason="needs usd-core, of the extra usd")
from pxr import Usd  # noqa: E402

ROOT = Path(__file__).parents[2]
validator = pytest.mark.skipif(
    importlib.util.find_spec("usd_validation_nvidia") is None, reason="needs usd-validation-nvidia, of the extra usd"
)
Told = list[tuple[SceneFinding, Any, tuple[Placement, ...]]]


def asked(path: Path | Any, **given: Any) -> Told:
    """All findings of a stage; ``given`` are parameters without their prefix, in small letters."""
    whole = Usd.Stage.Open(str(path)) if isinstance(path, Path) else path
    values = {name: default for name, (_, default) in PARAMETERS.items()}
    return list(stage_findings(whole, values | {f"HOLDFAST_{name.upper()}": value for name, value in given.items()}))


def where(at: Any) -> str:
    return str(at.GetPath()) if hasattr(at, "GetPath") else "/"


def found(told: Told) -> set[tuple[str, str]]:
    return {(finding.severity, where(at)) for finding, at, _ in told if finding.severity != "info"}


@pytest.fixture(scope="module")
def stages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("asset") / "stages"
    folder.mkdir()
    for name, (write, _) in STAGES.items():
        write(folder / f"{name}.usda")
    return folder


@pytest.mark.parametrize("name", STAGES)
def test_good_and_broken_stages_are_told_apart(name: str, stages: Path) -> None:
    path = stages / f"{name}.usda"
    before = path.read_bytes()
    told = asked(path)
    assert found(told) == STAGES[name][1], [finding.text for finding, _, _ in told]
    assert path.read_bytes() == before
    assert not told or STAGES[name][1]  # a stage that passes is passed without a word


@pytest.mark.parametrize("name", [name for name, (_, expected) in STAGES.items() if expected])
def test_what_is_suggested_ends_what_was_found(name: str, stages: Path, tmp_path: Path) -> None:
    """Each suggestion alone brings its body to rest; where none is offered, the finding says why."""
    path, own = stages / f"{name}.usda", {"travel": 0.2} if name == "hovers_110_mm" else {}
    for number, (finding, at, wanted) in enumerate(asked(path, **own)):
        if not wanted:
            words = ("undecided whether everything", "looks like a mistake")
            refused = finding.severity == "info" or finding.text.startswith(words) or "no collider" in finding.text
            assert refused or "; no remedy" in finding.text
            continue
        whole = Usd.Stage.Open(str(path))
        whole.Reload()
        place(whole, wanted)
        whole.Export(str(tmp_path / f"{number}.usda"))
        assert (where(at)) not in {prim for _, prim in found(asked(whole, **own))}, finding.text
        whole.Reload()


MENDED = (
    "hovers_110_mm hovers_5_mm hovers_in_pile sunk_8_mm sunk_tabletop leaning_on_nothing instances referenced "
    "centimetres_y_up"
)


def test_a_remedy_is_offered_wherever_one_is_near(stages: Path) -> None:
    offered = {name for name in STAGES if any(wanted for _, _, wanted in asked(stages / f"{name}.usda", travel=0.2))}
    assert offered == set(MENDED.split())


def test_prims_in_instances_are_left_alone(stages: Path) -> None:
    texts = [finding.text for finding, _, _ in asked(stages / "within_an_instance.usda")]
    assert "no remedy: /World/pair/inner: is part of an instance; move the instance as a whole" in texts[0]


def test_a_remedy_is_written_to_the_root_layer_alone(stages: Path) -> None:
    whole = Usd.Stage.Open(str(stages / "referenced.usda"))
    place(whole, asked(whole)[0][2])
    assert [layer for layer in whole.GetUsedLayers() if layer.dirty] == [whole.GetRootLayer()]
    whole.Reload()


def test_a_remedy_keeps_scale_and_order_of_other_operations(tmp_path: Path) -> None:
    """A box 0.2 m high by a matrix and a scale, in a turned and scaled group: it comes to rest at its own foot."""
    inner = box("a", "0, 0, 0.4").replace(
        'uniform token[] xformOpOrder = ["xformOp:translate"]',
        "double xformOp:rotateZ = 30\n double3 xformOp:scale = (1, 1, 4)\n"
        ' uniform token[] xformOpOrder = ["xformOp:rotateZ", "xformOp:translate", "xformOp:scale"]',
    )
    group = 'def Xform "g" {\n double3 xformOp:scale = (0.5, 0.5, 0.5)\n double xformOp:rotateZ = 20\n'
    group += ' uniform token[] xformOpOrder = ["xformOp:rotateZ", "xformOp:scale"]\n' + inner + "}\n"
    path = tmp_path / "scaled.usda"
    path.write_text(text(group), encoding="utf-8")
    whole = Usd.Stage.Open(str(path))
    told = asked(whole, travel=0.2)
    assert found(told) == {("failure", "/World/g/a")}
    before = hf.load_scene(path).body("a")
    for _ in range(2):  # the second time it is there already
        place(whole, told[0][2])
        whole.Export(str(tmp_path / "mended.usda"))
        after = hf.load_scene(tmp_path / "mended.usda").body("a")
        np.testing.assert_allclose(after.shape.size, before.shape.size, rtol=1e-12)
        np.testing.assert_allclose(after.pose[:3, :3], before.pose[:3, :3], atol=1e-6)
        np.testing.assert_allclose(before.pose[:3, 3] - after.pose[:3, 3], [0, 0, 0.1], atol=1e-6)
    assert found(asked(whole)) == set()


@pytest.mark.parametrize(("up", "at"), [("Z", "0, 0, {}"), ("Y", "0, {}, 0")])
def test_welded_bodies_move_as_one_and_bodies_below_their_prims_stay(up: str, at: str, tmp_path: Path) -> None:
    """In centimetres: two crates joined side by side hover by 1 cm; a post that is fixed is a child of one of them."""
    post = box("post", at.format(20), 10).replace(
        "float physics:mass", "bool physics:kinematicEnabled = 1\n float physics:mass"
    )
    hand = box("a", at.format(6), 10)[:-2] + post + "}\n"
    joined = 'def PhysicsFixedJoint "weld" {\n rel physics:body0 = </World/a>\n rel physics:body1 = </World/b>\n}\n'
    path = tmp_path / "welded.usda"
    path.write_text(text(hand + box("b", at.format(6).replace("0", "10", 1), 10) + joined, 0.01, up), encoding="utf-8")
    whole = Usd.Stage.Open(str(path))
    told = asked(whole)
    assert {prim for _, prim in found(told)} == {"/World/a"}
    heights = lambda: [  # noqa: E731
        round(whole.GetPrimAtPath(f"/World/{name}").GetAttribute("xformOp:translate").Get()["XYZ".index(up)], 5)
        for name in ("a", "b", "a/post")
    ]
    assert heights() == [6, 6, 20]
    place(whole, told[0][2])
    assert heights() == [5, 5, 21]  # of the post in its parent
    assert found(asked(whole)) == set()


def test_a_stage_in_memory_is_asked_as_it_is() -> None:
    whole = Usd.Stage.CreateInMemory()
    whole.GetRootLayer().ImportFromString(text(box("a", "0, 0, 0.06")))
    assert ("failure", "/World/a") in found(asked(whole))
    place(whole, asked(whole)[0][2])
    assert found(asked(whole)) == set()


def test_a_stronger_layer_is_an_error_and_not_overlooked(stages: Path) -> None:
    whole = Usd.Stage.Open(str(stages / "hovers_5_mm.usda"))
    wanted = asked(whole)[0][2]
    whole.SetEditTarget(Usd.EditTarget(whole.GetSessionLayer()))
    whole.GetPrimAtPath("/World/crate0").GetAttribute("xformOp:translate").Set((0.0, 0.0, 1.0))
    with pytest.raises(SceneError, match="stays where it is"):
        place(whole, wanted)
    whole.Reload()


def test_edits_that_were_not_saved_count(stages: Path) -> None:
    whole = Usd.Stage.Open(str(stages / "good_crates.usda"))
    whole.SetEditTarget(Usd.EditTarget(whole.GetSessionLayer()))
    whole.GetPrimAtPath("/World/crate2").GetAttribute("xformOp:translate").Set((0.5, 0.0, 0.07))
    assert {prim for _, prim in found(asked(whole))} == {"/World/crate2"}


def test_pushes_are_asked_when_a_force_is_stated(stages: Path) -> None:
    """A crate of 1 kg on a floor with mu 0.5 yields at 0.5 x 9.81 / (1 + ...) N; each at its own prim."""
    path = stages / "good_crates.usda"
    assert found(asked(path, min_force=0.1)) == set()
    told = asked(path, min_force=50.0)
    assert found(told) == {("failure", f"/World/crate{k}") for k in range(3)}
    assert all(" N on crate" in finding.text and "50 N is wanted" in finding.text for finding, _, _ in told[:3])


def test_parameters_reach_the_reader_and_the_question(stages: Path) -> None:
    assert found(asked(stages / "hovers_5_mm.usda", tolerance=0.006)) == set()
    assert found(asked(stages / "friction_missing.usda", friction=0.5)) == set()
    assert found(asked(stages / "joint.usda", rigid=True)) == set()
    assert found(asked(stages / "no_floor.usda", floor=True)) == set()
    assert "needs one of" in asked(stages / "good_table.usda", combine="most")[0][0].text
    assert asked(stages / "good_table.usda", tolerance=-1.0)[0][0].text.startswith(
        "undecided whether everything stands"
    )
    notes = asked(stages / "good_table.usda", notes=True)
    assert {finding.severity for finding, _, _ in notes} == {"info"}
    assert any("friction of a pair" in finding.text for finding, _, _ in notes)


def run(program: str, *arguments: object, **environment: str) -> subprocess.CompletedProcess[str]:
    """A program in a fresh process, which has this package and its entry points as after an installation."""
    return subprocess.run(
        [sys.executable, "-c", program, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        env={**os.environ, **environment},
    )


COMMAND = "import sys, usd_validation_nvidia as v; v.cli_main(sys.argv[1:])"  # all that nvidia_usd_validate is


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A PYTHONPATH with the entry points of pyproject.toml, as pip writes them beside the package."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lines = []
    for group, entries in project["entry-points"].items():
        lines += [f"[{group}]", *(f"{name} = {value}" for name, value in entries.items())]
    info = tmp_path_factory.mktemp("site") / "holdfast_robotics-0.dist-info"
    info.mkdir()
    (info / "entry_points.txt").write_text("\n".join(lines), encoding="utf-8")
    needed = [f"Requires-Dist: {one}" for several in project["optional-dependencies"].values() for one in several]
    head = ["Metadata-Version: 2.1", f"Name: {project['name']}", "Version: 0", *needed, ""]
    (info / "METADATA").write_text("\n".join(head), encoding="utf-8")
    return os.pathsep.join([str(info.parent), str(Path(hf.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])


@validator
def test_the_validators_own_command_finds_the_rule_and_tells_stages_apart(
    stages: Path, tmp_path: Path, installed: str
) -> None:
    report = tmp_path / "report.csv"
    only = ("--no-init-rules", "--rule", "HoldfastChecker", "--csv-output", report)
    before = {path: path.read_bytes() for path in stages.glob("*.usda")}
    done = run(COMMAND, stages, *only, PYTHONPATH=installed)
    assert done.returncode == 1, done.stderr
    said: dict[str, set[tuple[str, str]]] = {name: set() for name in STAGES}
    for row in csv.DictReader(report.open(encoding="utf-8")):
        severity = row["Severity"].lower()
        if severity in ("failure", "warning", "error"):
            prim = re.search(r"Prim <(.*)>", row["Location"])
            said[Path(row["Asset"]).stem].add((severity, prim[1] if prim else "/"))
    assert said == {name: expected for name, (_, expected) in STAGES.items()}
    assert {path: path.read_bytes() for path in before} == before


@validator
def test_a_good_stage_passes_and_fix_mends_another(stages: Path, tmp_path: Path, installed: str) -> None:
    only = ("--no-init-rules", "--rule", "HoldfastChecker")
    good = run(COMMAND, stages / "good_table.usda", *only, PYTHONPATH=installed)
    assert (good.returncode, good.stdout.strip(), good.stderr) == (0, "No issues found.", "")
    broken = tmp_path / "broken.usda"
    hf.save_scene(crates((0, 0.005), (0, 0.105), (1, -0.004)), broken)
    mended = run(COMMAND, broken, *only, "--fix", PYTHONPATH=installed)
    assert (mended.stdout + mended.stderr).count("FixStatus.SUCCESS") == 5
    assert run(COMMAND, broken, *only, PYTHONPATH=installed).returncode == 0
    wanted = ("--parameter", "HOLDFAST_MIN_FORCE=50")
    pushed = run(COMMAND, broken, *only, *wanted, PYTHONPATH=installed)
    assert (pushed.returncode, (pushed.stdout + pushed.stderr).count("50 N is wanted")) == (1, 3)


@validator
def test_fix_writes_to_the_stage_and_not_to_what_it_refers_to(tmp_path: Path, installed: str) -> None:
    path = tmp_path / "asset" / "stage.usda"
    path.parent.mkdir()
    STAGES["referenced"][0](path)
    part = tmp_path / "parts" / "part.usda"
    before = part.read_bytes()
    only = ("--no-init-rules", "--rule", "HoldfastChecker")
    assert run(COMMAND, path, *only, "--fix", PYTHONPATH=installed).returncode == 1
    assert part.read_bytes() == before
    assert run(COMMAND, path, *only, PYTHONPATH=installed).returncode == 0


@validator
def test_the_plugin_comes_and_goes(installed: str) -> None:
    program = (
        "import usd_validation_nvidia as v\n"
        "from usd_validation_nvidia import PluginManager, CategoryRuleRegistry as R\n"
        "names = lambda: {rule.__name__ for rule in R().rules}\n"
        "manager = PluginManager(); manager.initialize(); assert 'HoldfastChecker' in names(), names()\n"
        "manager.shutdown(); assert 'HoldfastChecker' not in names()\n"
        "manager.initialize(); assert 'HoldfastChecker' in names()\n"
    )
    done = run(program, PYTHONPATH=installed)
    assert done.returncode == 0, done.stderr


def test_nothing_of_usd_is_imported_before_a_stage_is_asked() -> None:
    """Neither by holdfast, nor by the module that the entry point names."""
    program = (
        "import sys, holdfast\n"
        "assert not any(name.startswith('holdfast.batches') for name in sys.modules)\n"
        "import holdfast.batches.usd_validator\n"
        "heavy = {'pxr', 'usd_validation_nvidia', 'omni'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    done = run(
        program, PYTHONPATH=os.pathsep.join([str(Path(hf.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    )
    assert done.returncode == 0, done.stderr
