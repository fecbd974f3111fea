"""Loaded pallets (finding S1): pressing straight down on a top box moves nothing where `limit` says so."""

from __future__ import annotations

import numpy as np
import pytest
from shared import needed

import holdfast as hf
from bench.scenes import real_pallets
from holdfast.engines.compliant.engine import Compliant
from holdfast.queries.request import push_columns

MU = 0.4  # the file gives no friction
FEW, MANY = (10, 18, 26), (8, 20, 30, 33)  # places in the list of units by number of boxes
DOWN = (0.0, 0.0, -1.0)
LATE = ((30, "box21"), (30, "box25"))  # rest under these pushes takes thousands of Newton steps to find; 200 are tried

pytestmark = needed


def pallet(place: int) -> hf.Scene:
    return real_pallets.pallet(real_pallets.pallets()[place], MU)


def tops(assembly: hf.answers.Assembly) -> list[hf.Body]:
    """The bodies on which nothing rests: no contact of theirs has a normal that leaves them upwards."""
    below = set()
    for interface in assembly.interfaces:
        for patch in interface.patches:
            if abs(patch.normal[2]) > 0.5:
                below.add(interface.bodies[0] if patch.normal[2] > 0 else interface.bodies[1])
    return [body for body in assembly.movable if body.name not in below]


def check(place: int, most: int) -> int:
    """Press the middle and one corner of some top boxes; return how many pushes were compared."""
    assembly = hf.assemble(pallet(place))
    if hf.stability(assembly).status is not hf.Status.STABLE:
        return 0
    compared = 0
    for body in tops(assembly)[:most]:
        low, high = body.box
        points = [(*(low[:2] + share * (high[:2] - low[:2])), high[2]) for share in (0.5, 0.8)]
        found = hf.robustness(assembly, body.name, points, DOWN)
        certain = hf.robustness(assembly, body.name, points, DOWN, engine="limit")
        endless = certain.status == hf.Status.INFINITE
        if (place, body.name) not in LATE:
            assert set(found.status[endless]) <= {hf.Status.INFINITE}, (place, body.name, found.force, found.status)
        assert (found.force <= certain.upper * (1 + 1e-6)).all()
        compared += len(points)
    return compared


@pytest.mark.parametrize("place", FEW)
def test_pressing_down_on_a_top_box(place: int) -> None:
    assert check(place, 3) > 0


@pytest.mark.slow
@pytest.mark.parametrize("place", MANY)
def test_pressing_down_on_all_top_boxes(place: int) -> None:
    check(place, 12)


@pytest.mark.parametrize(
    ("name", "point", "expected"), [("box39", (1.415, 2.32, 0.204), 2313.1), ("box37", (1.385, 2.32, 0.149), 2341.1)]
)
def test_long_steps_pass_over_no_maximum_of_a_pallet(
    name: str, point: tuple[float, float, float], expected: float
) -> None:
    """Pushed at its side the row gives way, and would be held again at 2,600 and 2,770 N: expected by short steps."""
    assembly = hf.assemble(hf.Scene(pallet(36).bodies, 0.5))
    W = push_columns(assembly, assembly.index[name], np.array([point]), np.array([[0.0, -1.0, 0.0]]))
    paths = Compliant().prepare(assembly).grid.paths(W)
    assert paths.first[0] == pytest.approx(expected, rel=5e-3)
