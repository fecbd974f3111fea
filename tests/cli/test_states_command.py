"""The options of check and batch for states of a MuJoCo model."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from calling import Call

from holdfast.base.envelope import schema

pytest.importorskip("mujoco")

MODEL = """<mujoco><worldbody><geom name="floor" type="plane" size="1 1 1"/>
<body name="bowl" pos="0 0 .05"><freejoint/><geom type="box" size=".05 .05 .05"/></body></worldbody></mujoco>"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A model, and three states: at rest, in the air, and sunk."""
    (tmp_path / "model.xml").write_text(MODEL)
    np.save(tmp_path / "s.npy", [[0, 0, z, 1, 0, 0, 0] for z in (0.05, 0.16, 0.048)])
    return tmp_path


def test_a_check_names_what_hovers_and_writes_settled_states(folder: Path, call: Call) -> None:
    given = ("check", folder / "model.xml", "--states", folder / "s.npy", "--stands", "--workers", 1)
    code, out, _ = call(*given, "--travel", 0.2, "--fix", folder / "f.npy", "--junit", folder / "j.xml")
    assert code == 1
    assert "bowl hovers 110 mm above floor; settles by 110 mm" in out
    assert "bowl sinks 2 mm into floor; settles by 2 mm" in out
    assert "1 passed, 1 failed, 1 undecided" in out
    assert "2 settled, 0 left" in out
    assert "model.xml --qpos Q,Q,...` shows why" in " ".join(out.split())  # the model alone stands
    assert "hovers 110 mm" in (folder / "j.xml").read_text()
    code, out, _ = call(
        "check", folder / "model.xml", "--states", folder / "f.npy", "--stands", "--workers", 1, "--json"
    )
    told = json.loads(out)
    jsonschema.validate(told, schema())
    assert code == 0
    assert [row["verdict"] for row in told["rows"]] == ["stable"] * 3


def test_json_has_one_row_a_state(folder: Path, call: Call) -> None:
    fixed = folder / "f.npy"
    given = ("check", folder / "model.xml", "--states", folder / "s.npy", "--stands", "--workers", 1, "--fix", fixed)
    code, out, _ = call(*given, "--json")
    told = json.loads(out)
    jsonschema.validate(told, schema())
    assert code == 1
    assert [row["verdict"] for row in told["rows"]] == ["stable", "unstable", "undecided"]
    assert told["rows"][1]["details"]["hovers"] == [{"body": "bowl", "height": pytest.approx(0.11), "above": "floor"}]
    assert told["rows"][2]["details"]["settled"]["moved"] == pytest.approx(0.002, abs=1e-5)
    assert (told["details"]["fixed"], told["details"]["left"]) == (["2"], ["1"])


def test_a_batch_takes_states(folder: Path, call: Call) -> None:
    given = ("batch", folder / "model.xml", "--states", folder / "s.npy", "--out", folder / "out", "--workers", 1)
    code, out, _ = call(*given)
    assert code == 0
    assert "1 stable, 1 unstable, 1 undecided" in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--fix", "f.npy"), "--fix: is about states; give --states FILE"),
        (("--travel", 0.1), "--travel: is about states"),
        (("--states", "s.npy", "--fix", "f.csv"), "cannot hold settled states; needs a .npy file"),
        (("--states", "none.npy"), "no such file of states"),
    ],
)
def test_bad_input_is_told(folder: Path, call: Call, arguments: tuple[str, ...], words: str) -> None:
    named = [folder / each if str(each).endswith(("npy", "csv")) else each for each in arguments]
    code, _, err = call("check", folder / "model.xml", "--stands", "--workers", 1, *named)
    assert code == 2
    assert words in err


def test_a_pickle_is_refused_with_a_line_of_python_that_can_be_copied(folder: Path, call: Call) -> None:
    np.save(folder / "p.npy", np.array([{}], dtype=object))
    code, _, err = call("check", folder / "model.xml", "--stands", "--states", folder / "p.npy")
    assert code == 2
    assert "numpy.savez('states.npz', array)" in " ".join(err.split())
