"""Loads on a support that accelerates, and on what bears other loads already: closed forms of a cube."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import cube

G, MU, SIDE = 9.81, 0.6, 0.1


@pytest.mark.parametrize("engine", ["compliant", "limit", "graph"])
@pytest.mark.parametrize(
    ("push", "acceleration", "held"),
    [
        ((1, 0, 0), (2, 0, 0), MU * G + 2),  # the support runs after the push
        ((-1, 0, 0), (2, 0, 0), MU * G - 2),
        ((1, 0, 0), (-2, 0, 0), MU * G - 2),
        ((0, 1, 0), (0, 0, 3), MU * (G + 3)),  # it is lifted
        ((0, 1, 0), (0, 0, -3), MU * (G - 3)),
        ((1, 0, 0), None, MU * G),
    ],
)
def test_a_cube_on_a_support_that_accelerates(
    push: tuple[float, ...], acceleration: tuple[float, ...] | None, held: float, engine: str
) -> None:
    """Pushed through its middle plane, low, the cube of 1 kg slides when it and its inertia outweigh friction."""
    load = hf.Load("cube", (0, 0, 0.001), force=push)
    found = hf.load_factor(hf.assemble(cube()), [load], acceleration=acceleration, engine=engine)
    assert float(found) == pytest.approx(held, rel=5e-3)


@pytest.mark.parametrize("engine", ["compliant", "limit", "graph"])
@pytest.mark.parametrize("sign", [-1, 1])
def test_a_moment_that_acts_already_adds_to_the_next_one(sign: int, engine: str) -> None:
    """Over its edge the cube tips at m g / 2 times its side; a fifth of that is there, one way or the other."""
    most = G * SIDE / 2
    standing = [hf.Load("cube", moment=(0, 0.2 * most * sign, 0))]
    found = hf.load_factor(hf.assemble(cube()), [hf.Load("cube", moment=(0, 1, 0))], standing=standing, engine=engine)
    assert float(found) == pytest.approx(most * (1 - 0.2 * sign), rel=0.01)
    pushed = hf.Load("cube", (-SIDE / 2, 0, SIDE), force=(1, 0, 0))
    assert float(hf.load_factor(hf.assemble(cube()), [pushed], standing=standing, engine=engine)) == pytest.approx(
        G / 2 * (1 - 0.2 * sign), rel=0.01
    )


def test_several_loads_on_one_body_add() -> None:
    loads = [hf.Load("cube", (0, 0, 0.001), force=(x, 0, 0)) for x in (2.0, -0.5)]
    assert float(hf.load_factor(hf.assemble(cube()), loads, engine="limit")) == pytest.approx(MU * G / 1.5, rel=1e-3)
    assert np.isinf(float(hf.load_factor(hf.assemble(cube()), [hf.Load("cube", (0, 0, 0.1), force=(0, 0, -1))])))
