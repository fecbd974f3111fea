"""No removal that is called safe makes anything move in MuJoCo, in any state along the order."""

from __future__ import annotations

import pytest
from disassembly_confirmed import LARGE, compared

from holdfast import assemble, disassembly_order
from holdfast.applications.disassembly.removal import Answer
from holdfast.scene.shipped import shipped_scene, shipped_scenes

pytestmark = pytest.mark.referee


@pytest.mark.parametrize("name", [name for name in shipped_scenes() if name not in (*LARGE, "wedged")])
def test_what_is_safe_rests_in_mujoco(name: str) -> None:
    pytest.importorskip("mujoco")
    rows = compared(disassembly_order(assemble(shipped_scene(name))))
    safe = [(step, answer.body, rests) for step, answer, rests in rows if answer.answer is Answer.SAFE]
    assert [row for row in safe if row[2] is False] == []
    told = [rests for _, _, rests in safe if rests is not None]
    assert len(told) >= 0.9 * len(safe)
    falls = [answer for _, answer, rests in rows if rests is False]
    assert all(answer.answer is not Answer.SAFE for answer in falls)
