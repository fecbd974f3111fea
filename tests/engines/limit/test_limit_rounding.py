"""Bounds of rounding, against exact rational arithmetic."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from limit_scenes import Array, shipped

from holdfast import Assembly, Limit
from holdfast.assembly.nodes import ContactNodes
from holdfast.engines.limit.balance import Balance
from holdfast.engines.limit.rounding import EXTENDED, Equilibrium, inner

SCENES = ["cube", "slope_two", "v_groove"]


def exact(assembly: Assembly, nodes: ContactNodes) -> list[list[Fraction]]:
    """G (6J, 3I) of the points, axes and centres of mass as the numbers that they are."""
    G = [[Fraction(0)] * (3 * len(nodes)) for _ in range(6 * len(assembly.movable))]
    for i in range(len(nodes)):
        for body, sign in ((int(nodes.b[i]), 1), (int(nodes.a[i]), -1)):
            if body < 0:
                continue
            p = [Fraction(float(nodes.points[i, c])) - Fraction(float(assembly.com[body, c])) for c in range(3)]
            for k in range(3):
                f = [sign * Fraction(float(v)) for v in nodes.axes[i, k]]
                torque = [p[1] * f[2] - p[2] * f[1], p[2] * f[0] - p[0] * f[2], p[0] * f[1] - p[1] * f[0]]
                for row, value in enumerate([*f, *torque]):
                    G[6 * body + row][3 * i + k] = value
    return G


def product(rows: list[list[Fraction]], vector: Array) -> list[Fraction]:
    numbers = [Fraction(float(v)) for v in vector]
    return [sum((a * b for a, b in zip(row, numbers, strict=True)), Fraction(0)) for row in rows]


def spread(rng: np.random.Generator, count: int) -> Array:
    """Numbers of very different sizes."""
    return rng.standard_normal(count) * 10.0 ** rng.uniform(-8, 8, count)


@pytest.mark.parametrize("name", SCENES)
def test_errors_of_products_are_within_their_bounds(name: str) -> None:
    assembly = shipped(name)
    nodes = Limit().prepare(assembly).rest.nodes
    G, equilibrium = exact(assembly, nodes), Equilibrium.of(assembly, nodes)
    columns = [list(column) for column in zip(*G, strict=True)]
    rng = np.random.default_rng(0)
    seen = 0.0
    for _ in range(5):
        motion, forces = spread(rng, len(G)), spread(rng, len(columns))
        wrench, load, factor = spread(rng, len(G)), spread(rng, len(G)), spread(rng, 1)
        found, unknown = equilibrium.velocities(motion[:, None])
        for value, bound, truth in zip(found[:, 0], unknown[:, 0], product(columns, motion), strict=True):
            assert abs(Fraction(float(value)) - truth) <= Fraction(float(bound))
            seen = max(seen, float(abs(Fraction(float(value)) - truth)) / bound)
        found, unknown = equilibrium.imbalance(forces[:, None], wrench, load[:, None], factor)
        pushed = product(
            [[Fraction(float(w)), Fraction(float(e))] for w, e in zip(wrench, load, strict=True)], [1, factor[0]]
        )
        for value, bound, truth, more in zip(found[:, 0], unknown[:, 0], product(G, forces), pushed, strict=True):
            assert abs(Fraction(float(value)) - truth - more) <= Fraction(float(bound))
        value, bound = inner(motion[:, None], wrench[:, None])
        truth = product([[Fraction(float(v)) for v in motion]], wrench)[0]
        assert abs(Fraction(float(value[0])) - truth) <= Fraction(float(bound[0]))
    assert seen > 0.003, "the bounds are of the order of what they bound"


@pytest.mark.skipif(not EXTENDED, reason="numpy has no precision beyond double here")
@pytest.mark.parametrize("name", SCENES)
def test_errors_in_extended_precision_are_within_smaller_bounds(name: str) -> None:
    assembly = shipped(name)
    nodes = Limit().prepare(assembly).rest.nodes
    G, equilibrium = exact(assembly, nodes), Equilibrium.of(assembly, nodes)
    columns = [list(column) for column in zip(*G, strict=True)]
    motion = spread(np.random.default_rng(1), len(G))
    coarse = equilibrium.velocities(motion[:, None])[1]
    found, unknown = equilibrium.velocities(motion.astype(np.longdouble)[:, None])
    assert (unknown < 1e-2 * coarse).all()
    for value, bound, truth in zip(found[:, 0], unknown[:, 0], product(columns, motion), strict=True):
        high = float(value)
        number = Fraction(high) + Fraction(float(value - high))
        assert abs(number - truth) <= Fraction(float(bound)) * (1 + Fraction(1, 10**15))


@pytest.mark.parametrize("name", SCENES)
def test_a_right_inverse_is_as_good_as_it_says(name: str) -> None:
    """The rows of |I - A R| sum up to less than α, exactly; α / (1 - α) is ``spill``."""
    assembly = shipped(name)
    nodes = Limit().prepare(assembly).rest.nodes
    balance = Balance.of(Equilibrium.of(assembly, nodes), nodes.mu, np.ones(len(nodes)))
    assert balance is not None
    assert balance.rows.all()
    G = exact(assembly, nodes)
    most = Fraction(balance.spill) / (1 + Fraction(balance.spill))
    for i, row in enumerate(G):
        total = Fraction(0)
        for j in range(len(G)):
            value = sum((row[c] * Fraction(float(balance.inverse[c, j])) for c in range(len(row))), Fraction(0))
            scaled = value * Fraction(float(balance.share[i])) / Fraction(float(balance.share[j]))
            total += abs(int(i == j) - scaled)
        assert total <= most * (1 + Fraction(1, 100))
