"""A round body a nanometre off its balance: rounding decides nothing, on a support that is fixed or can move."""

from __future__ import annotations

import numpy as np
import pytest
from placed import at

import holdfast as hf

LONG, ROUND = 0.035, 0.025  # [m] half-axes


def _egg(offset: float, fixed: bool) -> hf.answers.Assembly:
    """An egg on a box; its point of contact is ``offset`` [m] from below its centre."""
    tilt = offset * ROUND / (LONG**2 - ROUND**2)
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    pose = at(-0.1, 0.002, 0.2 + ROUND, turn)
    bodies = [
        hf.Body("floor", hf.Box((2, 2, 0.1)), position=(0, 0, -0.05), fixed=True),
        hf.Body("box", hf.Box((0.3, 0.3, 0.2)), mass=None if fixed else 2.0, position=(0, 0, 0.1), fixed=fixed),
        hf.Body("egg", hf.Ellipsoid((LONG, ROUND, ROUND)), mass=0.1, pose=pose),
    ]
    return hf.assemble(hf.Scene(bodies, 0.5))


@pytest.mark.parametrize("engine", ["limit", "compliant"])
@pytest.mark.parametrize("fixed", [True, False])
def test_a_picometre_off_balance_is_no_fall(fixed: bool, engine: str) -> None:
    for offset in (0.0, 2.4e-12, 2.4e-11):
        assert hf.stability(_egg(offset, fixed), engine=engine).status is hf.Status.STABLE, offset


@pytest.mark.parametrize("engine", ["limit", "compliant"])
@pytest.mark.parametrize("fixed", [True, False])
def test_nanometres_are_never_called_a_fall(fixed: bool, engine: str) -> None:
    for offset in (2.4e-10, 2.4e-9):
        assert hf.stability(_egg(offset, fixed), engine=engine).status is not hf.Status.UNSTABLE, offset


@pytest.mark.parametrize("fixed", [True, False])
def test_a_tenth_of_a_millimetre_is_a_fall(fixed: bool) -> None:
    verdict = hf.stability(_egg(1e-4, fixed), engine="limit")
    assert verdict.status is hf.Status.UNSTABLE
    assert verdict.mechanism is not None
    assert verdict.mechanism.moving == ("egg",)
