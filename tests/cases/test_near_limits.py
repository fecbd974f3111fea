"""Verdicts on published structures near their limits, where few nodes or forces that nothing causes would hold them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import holdfast as hf
from bench.experiments.arches import arch
from bench.experiments.brick_walls import wall
from bench.experiments.overhangs import diamond, harmonic, triangle
from bench.experiments.source import G0
from bench.experiments.three_cylinders import cylinders
from bench.experiments.toppling_blocks import FIVE, LEAST, SIXTEEN, rests
from holdfast import Scene, Status, assemble, stability

FINE = 25  # nodes a side
STEP = 0.002


@pytest.mark.parametrize("mu", [0.75, pytest.param(0.756, marks=pytest.mark.slow), 0.76])
def test_blocks_that_topple_though_few_nodes_hold_them_are_not_stable(mu: float) -> None:
    assembly = assemble(FIVE.scene(mu))
    assert not FIVE.stand(mu)
    assert rests(assembly, 7)
    result = stability(assembly)
    assert result.status is not Status.STABLE
    assert result.equilibrium_exists
    assert "nodes a side" in result.reason


@pytest.mark.parametrize("mu", [0.72, 0.75, 0.76])
def test_limit_does_not_hold_blocks_by_forces_that_nothing_causes(mu: float) -> None:
    """An equilibrium exists, and pushes get the answer that it gives them."""
    assembly = assemble(FIVE.scene(mu))
    assert not FIVE.stand(mu)
    result = stability(assembly, engine="limit")
    assert (result.status, result.equilibrium_exists) == (Status.UNDECIDED, True)
    pushed = hf.robustness(assembly, "block0", (0, 0, 0.09), (1, 0, 0), engine="limit")
    assert pushed.force[0] > 0


@pytest.mark.parametrize("engine", ["limit", "compliant"])
@pytest.mark.parametrize("mu", [0.79, 0.85])
def test_blocks_that_stand_by_hand_with_some_friction_to_spare_are_stable(mu: float, engine: str) -> None:
    assert FIVE.stand(mu)
    assert stability(assemble(FIVE.scene(mu)), engine=engine).status is Status.STABLE


def test_toppling_slope() -> None:
    """Goodman and Bray's 16 blocks: 7 nodes a side hold them from tan φ = 0.769 on, 25 from 0.781 on."""
    row, least = SIXTEEN, float(LEAST)
    assert not row.stand(least - 1e-4)
    assert row.stand(least + 1e-4)
    assembly = assemble(row.scene(0.774))
    assert rests(assembly, 7)
    assert stability(assembly).status is not Status.STABLE
    result = stability(assembly, engine="limit")
    assert (result.status, result.equilibrium_exists) == (Status.UNDECIDED, True)
    for mu in (0.82, 0.825, 0.84):  # at exactly 0.83 the search for rest on the finer nodes ends without an answer
        assert stability(assemble(row.scene(mu))).status is Status.STABLE


def leaning(scene: Scene, share: float) -> Scene:
    """The scene under a level acceleration of ``share`` times g."""
    return replace(scene, gravity=(G0 * share, 0, -G0))


def cases() -> dict[str, tuple[Callable[[float], Scene], float, float]]:
    """Scenes, and the parameters between which they are looked at, around what holds by the file."""
    found: dict[str, tuple[Callable[[float], Scene], float, float]] = {
        "sixteen_blocks": (SIXTEEN.scene, 0.656, 0.81),
        "five_blocks": (FIVE.scene, 0.736, 0.8),
        "shaken_arch": (lambda share: leaning(arch(7, 0.15, 3.0, half_angle=1.3744, radius=10.0), share), 0.36, 0.384),
        "cylinders": (lambda mu: cylinders(0.5409, mu, 1.0), 0.267, 0.287),
        "cylinders_ground": (lambda mu: cylinders(0.5409, 1.0, mu), 0.082, 0.102),
    }
    for count, mu, least in (
        (13, 0.7, 0.103), (13, 0.38, 0.116), (13, 0.33, 0.171), (13, 0.31, 0.195),
        (27, 0.7, 0.107), (27, 0.38, 0.121), (27, 0.33, 0.173), (27, 0.31, 0.196),
    ):  # fmt: skip
        thin = least - 0.009
        found[f"arch{count}_{mu}"] = (lambda t, count=count, mu=mu: arch(count, t, mu), thin, thin + 0.018)
    for count in (13, 27):
        found[f"thick_arch{count}"] = (lambda mu, count=count: arch(count, 0.3, mu), 0.299, 0.319)
    for count in (2, 5, 10, 20, 30):  # not at 1, where all hangs on edges and rounding decides
        found[f"harmonic{count}"] = (lambda scale, count=count: harmonic(count, scale), 0.995, 1.005)
    for most in (2, 3, 4, 5):
        found[f"diamond{most}"] = (lambda _, most=most: diamond(most), 0.0, 0.0)
        found[f"triangle{most}"] = (lambda _, most=most: triangle(most), 0.0, 0.0)
    for name, low, high in (("1", 0.62, 0.65), ("2", 0.545, 0.585), ("3", 0.34, 0.41)):
        found[f"wall{name}"] = (lambda share, name=name: leaning(wall(name), share), low, high)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", cases())
def test_nothing_is_stable_that_fine_nodes_let_go(name: str) -> None:
    wrong, (scene, low, high) = [], cases()[name]
    for parameter in np.arange(low, high + 1e-9, STEP):
        assembly = assemble(scene(float(parameter)))
        verdicts = {engine: stability(assembly, engine=engine).status for engine in ("limit", "compliant")}
        said = [engine for engine, status in verdicts.items() if status is Status.STABLE]
        if said and not rests(assembly, FINE):
            wrong.append((parameter, said))
    assert not wrong
