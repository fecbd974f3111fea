"""The command ``verify``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from calling import Call, command

import holdfast as hf
from holdfast.scene.shipped import shipped_scene

verify = command("verify")
RESTS = "contact forces balance every body under weight and standing loads"


@pytest.fixture
def certificate(tmp_path: Path) -> Path:
    hf.stability(shipped_scene("cube")).save_certificate(tmp_path / "stands.json")
    return tmp_path / "stands.json"


def test_it_says_what_is_proved(verify: Any, certificate: Path) -> None:
    code, out, err = verify(certificate)
    assert (code, err) == (0, "")
    assert " ".join(out.split()).startswith(f"verified: {RESTS}: 'cube' not checked: ")


def test_a_file_that_was_altered_is_not_verified(verify: Any, certificate: Path) -> None:
    text = certificate.read_text()
    certificate.write_text(text.replace('"-9.81"', '"-9.80"'))
    code, out, _ = verify(certificate)
    assert (code, " ".join(out.split())) == (1, "NOT verified: the forces on 'cube' do not balance")


def test_it_is_compared_with_a_scene(verify: Any, certificate: Path) -> None:
    code, out, _ = verify(certificate, "--geometry", "cube")
    assert code == 0
    assert "agrees with cube: gravity, masses" in " ".join(out.split())
    code, out, _ = verify(certificate, "--geometry", "stack")
    assert code == 1
    assert "does NOT agree with stack: cube cannot move" in " ".join(out.split())


def test_a_scene_with_holds_is_refused(verify: Any, certificate: Path, tmp_path: Path) -> None:
    cube = shipped_scene("cube")
    hand = hf.Hold("cube", frame=hf.pose(z=0.05), forces=3.0)
    hf.save_scene(hf.Scene(cube.bodies, cube.friction, holds=[hand]), tmp_path / "held.json")
    code, _, err = verify(certificate, "--geometry", tmp_path / "held.json")
    assert code == 2
    assert "does not take holds" in " ".join(err.split())


@pytest.mark.parametrize("asked", [["assess"], ["remove", "cube3"], ["disassemble"], ["build"]])
def test_commands_write_certificates(verify: Any, call: Call, tmp_path: Path, asked: list[str]) -> None:
    path = tmp_path / "proof.json"
    code, out, err = call(asked[0], "stack", *asked[1:], "--certificate", path)
    assert (code, err) == (0, "")
    assert "wrote" in out
    assert verify(path)[0] == 0


@pytest.mark.parametrize(("content", "says"), [(b"\xff", "UTF-8"), (None, "no such certificate")])
def test_what_is_no_text_is_an_error(verify: Any, tmp_path: Path, content: bytes | None, says: str) -> None:
    if content is not None:
        (tmp_path / "x.json").write_bytes(content)
    code, _, err = verify(tmp_path / "x.json")
    assert code == 2
    assert says in err
