"""What must not change an answer, and that it never exceeds that of engine ``limit`` on the same nodes."""

import numpy as np
import pytest
from compliant_scenes import SMALL, columns, random_pushes, strength
from engine_scenes import X, shipped

import holdfast as hf
from holdfast import Compliant, Status

OFF = ("cube", (-0.05, 0.045, 0.02), X)


@pytest.mark.parametrize("stiffness", [1e3, 1e6, 1e9])
def test_stiffness_drops_out(stiffness: float) -> None:
    assert strength(shipped("cube"), *OFF, stiffness=stiffness) == pytest.approx(
        strength(shipped("cube"), *OFF), rel=1e-6
    )
    named = {i.bodies: stiffness for i in shipped("table").interfaces}
    point, direction = (0.2, -0.1, 0.225), (0.2, 1, 0)
    one, other = (strength(shipped("table"), "slab", point, direction, stiffness=s) for s in (named, None))
    assert one == pytest.approx(other, rel=1e-4)


@pytest.mark.parametrize("ratio", [0.5, 0.75])
def test_tangential_stiffness_matters_little(ratio: float) -> None:
    assert strength(shipped("cube"), *OFF, stiffness_ratio=ratio) == pytest.approx(
        strength(shipped("cube"), *OFF), rel=0.01
    )


@pytest.mark.parametrize("name", SMALL)
def test_never_above_limit_on_shipped_scenes(name: str) -> None:
    assembly = shipped(name)
    W = columns(assembly, random_pushes(assembly, 25, 31))
    check(Compliant().prepare(assembly).load_factor(W), hf.Limit().prepare(assembly).load_factor(W))


def check(got: object, certain: object) -> None:
    assert not np.isnan([got.force, got.lower, got.upper]).any()
    assert (got.lower <= got.force).all()
    assert (got.force <= got.upper).all()
    for k, status in enumerate(got.status):
        assert status in (Status.FINITE, Status.INFINITE)
        assert (status is Status.INFINITE) == np.isinf(got.force[k])
        assert (got.mechanism[k] is None) == (status is Status.INFINITE)
        assert got.force[k] <= certain.upper[k] * (1 + 1e-6)


def test_bound_is_that_of_limit() -> None:
    assembly = shipped("table")
    point, direction = [(0.2, -0.1, 0.225), (0, 0, 0.25)], [(0, 1, 0), (0, 0, -1)]
    asked = hf.robustness(assembly, "slab", point, direction, engine="compliant", bounds=True)
    limit = hf.robustness(assembly, "slab", point, direction, engine="limit")
    np.testing.assert_array_equal(asked.upper, limit.upper)
    assert asked.lower[0] < asked.force[0] < asked.upper[0]
    plain = hf.robustness(assembly, "slab", point, direction, engine="compliant")
    assert np.isinf(plain.upper).all()
    load = [hf.Load("slab", point[0], force=direction[0])]
    factor = hf.load_factor(assembly, load, engine="compliant", bounds=True)
    assert factor.upper == pytest.approx(6.2267738, rel=1e-6)
    with pytest.raises(hf.HoldfastError, match="not ordered"):
        hf.load_factor(assembly, load, engine="graph", bounds=True)


def test_no_load_is_carried_for_ever() -> None:
    found = Compliant().prepare(shipped("cube")).load_factor(np.zeros((6, 2)))
    assert np.isinf(found.force).all()
    assert set(found.status) == {Status.INFINITE}
