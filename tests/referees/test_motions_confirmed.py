"""The motion that begins, beside a simulation at 1.1 times the force.

The whole table is ``python tests/referees/motions_table.py 500``; here are as many pushes as a test may take time for.
"""

from __future__ import annotations

import pytest
from motions_table import cases

pytestmark = pytest.mark.referee

COUNT, SHARE = 20, 0.8  # measured over 100 pushes: see bench/notes/reliability.md


def test_the_motion_is_the_one_that_a_simulation_begins() -> None:
    pytest.importorskip("mujoco", reason="needs the simulator MuJoCo")
    known = [case for case in cases(COUNT, 0) if case.simulated is not None]
    alike = [case.compliant.like(case.simulated, case.size) for case in known]
    assert len(known) >= 0.9 * COUNT
    assert sum(alike) >= SHARE * len(known)
