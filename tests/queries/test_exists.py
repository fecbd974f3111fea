"""Existence is not safety: what only engine ``limit`` stands for says *exists*, and what could be squeezed is told."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from rich.console import Console

import holdfast as hf
from bench.scenes.fitted import rails, row
from holdfast.report.contact_report import push_report

G = 9.81
PULL = ("book1", (0, -0.085, 0.12), (0, -1, 0))  # the middle one of three, towards the reader


@pytest.mark.parametrize("engine", ["compliant", "limit"])
@pytest.mark.parametrize(
    ("scene", "squeezed"),
    [
        (rails(), True),
        (rails(1e-5), True),
        (row(3), True),
        (rails(0.05), False),
        (hf.shipped_scene("table"), False),
        (hf.shipped_scene("tabletop"), False),
        (hf.shipped_scene("wedged_floor"), True),
    ],
)
def test_self_stress_is_told_wherever_contacts_can_press_each_other(
    scene: hf.Scene, squeezed: bool, engine: str
) -> None:
    found = hf.stability(scene, engine=engine)
    assert found.stable
    assert found.self_stress is squeezed
    assert found.to_dict()["self_stress"] is squeezed


def test_a_book_that_nothing_squeezes_is_pulled_out_at_mu_m_g() -> None:
    right = 0.4 * 0.8 * G
    held = hf.robustness(row(3), *PULL)
    assert 0.9 * right <= held.lower[0] <= right
    assert held.to_dict()["holds"]["lower"] == pytest.approx(held.lower[0])
    exists = hf.robustness(row(3), *PULL, engine="limit")
    assert exists.lower[0] == np.inf
    assert exists.to_dict()["claim"] == "exists"
    assert "holds" not in exists.to_dict()
    assert exists.to_dict()["exists"]["lower"] == "inf"
    assert "an equilibrium exists up to" in repr(exists)


def test_the_terminal_does_not_say_that_nothing_moves_where_an_equilibrium_exists() -> None:
    console = Console(width=200)
    with console.capture() as caught:
        console.print(push_report(hf.robustness(row(3), *PULL, engine="limit")))
    told = caught.get()
    assert "however hard: an equilibrium exists" in told
    assert "nothing moves" not in told


def test_the_terminal_promises_no_more_than_lower_where_no_limit_was_found() -> None:
    """A row of books that fits exactly between its ends: stiffness decides whether they squeeze each other."""

    def upright(name: str, x: float, **given: Any) -> hf.Body:
        return hf.Body(name, hf.Box((0.03, 0.2, 0.25)), position=(x, 0, 0.125), **given)

    books = [upright(f"book{k}", 0.03 * (k - 4), mass=1) for k in range(1, 8)]
    ends = [upright(name, x, fixed=True) for name, x in (("left", -0.12), ("right", 0.12))]
    shelf = hf.Body("shelf", hf.Box((0.8, 0.3, 0.02)), position=(0, 0, -0.01), fixed=True)
    push = hf.robustness(hf.Scene([shelf, *ends, *books], 0.35), "book3", (-0.045, 0, 0.25), (1, 0, 0))
    assert push.force[0] == np.inf
    assert push.lower[0] == 0
    console = Console(width=200)
    with console.capture() as caught:
        console.print(push_report(push))
    assert "no limit found, estimated to hold up to 0 N only" in caught.get()
    assert "nothing moves" not in caught.get()
