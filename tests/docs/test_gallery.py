"""Examples that save no picture get one of their bodies, with those in colour that move in their last answer."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

import holdfast as hf

SITE = Path(__file__).parents[2] / "docs" / "_site"


@pytest.fixture
def gallery(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(SITE))
    import gallery_bodies

    yield gallery_bodies
    sys.modules.pop("gallery_bodies")


def test_what_moves_in_the_last_answer_is_in_colour(gallery: Any) -> None:
    stack = hf.assemble(hf.shipped_scene("stack"))
    top = hf.robustness(stack, "cube3", [(0.05, 0, 0.25), (0.05, 0, 0.21)], (-1, 0, 0), engine="limit")
    content, moving = gallery.bodies_and_movers({"scene": stack.scene, "a": stack, "n": 3, "r": top, "text": "moving"})
    assert content.startswith(b"\x89PNG")
    assert moving == set(top.moving[top.answers.ranking[0]])
    assert gallery.bodies_and_movers({"a": stack, "verdict": hf.stability(stack)})[1] == frozenset()
    other = hf.assemble(hf.shipped_scene("cube"))
    assert gallery.bodies_and_movers({"a": stack, "r": top, "b": other})[1] == frozenset(), "bodies of another scene"
    falls = hf.shipped_scene("stack").moved({"cube3": [(1, 0, 0, 0.06), (0, 1, 0, 0), (0, 0, 1, 0.25), (0, 0, 0, 1)]})
    found = hf.stability(hf.assemble(falls), engine="limit")
    assert found.mechanism is not None
    assert gallery.bodies_and_movers({"a": hf.assemble(falls), "v": found})[1] == set(found.mechanism.moving)
