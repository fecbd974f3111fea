"""The simulated carrier: closed forms that know nothing of the engines, then Fig. 15 against them."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from bench.baselines.search import grid_nodes
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import box, floor

pytestmark = pytest.mark.referee
pytest.importorskip("mujoco")

from bench.baselines.carrier import CALM, Carrier  # noqa: E402

G = 9.81
X, Y, Z = np.eye(3)
WAYS = [Y, -Y, X, -X, X + Y, X - Y]
WITHIN = 0.05


def carried(height: float, mu: float) -> hf.answers.Assembly:
    return hf.assemble(hf.Scene([floor(), box("box", (0.1, 0.1, height), 2.0, (0, 0, height / 2))], mu))


def test_the_carrier_drives_as_it_is_told() -> None:
    """From rest at a rate of 2 m/s³ for one second: 1 m/s, and a third of a metre, with all that stands on it."""
    carrier = Carrier(carried(0.05, 0.6))
    place = carrier.data.qpos[-3:].copy()
    for k in range(round(1 / carrier.step)):
        carrier._advance(2 * (k + 1) * carrier.step * X)
    assert carrier.data.qvel[-3:] == pytest.approx(X, abs=1e-3)
    assert carrier.data.qvel[:3] == pytest.approx(X, abs=1e-3)
    assert carrier.data.qpos[-3:] - place == pytest.approx(X / 3, abs=1e-3)
    assert carrier.speed() < CALM


@pytest.mark.parametrize("way", [X, -Y, X + Y])
def test_a_box_slips_at_mu_g(way: np.ndarray) -> None:
    found = Carrier(carried(0.05, 0.6)).limit(way)
    assert found.calm == pytest.approx(0.6 * G, rel=0.01)
    assert found.calm < found.acceleration < 1.02 * 0.6 * G


@pytest.mark.parametrize("way", [Y, -X])
def test_a_tall_box_topples(way: np.ndarray) -> None:
    found = Carrier(carried(0.3, 0.6)).limit(way)
    assert found.calm <= found.acceleration
    assert found.acceleration == pytest.approx(G / 3, rel=0.04)


def test_a_tilted_carrier() -> None:
    """Uphill less is left, and on a tray tilted too far everything moves at once."""
    flat = carried(0.05, 0.6)
    carrier = Carrier(flat.tilted((np.degrees(0.2), 0, 0)))
    for sense in (1, -1):
        expected = G * (0.6 * np.cos(0.2) - sense * np.sin(0.2))
        assert carrier.limit(sense * Y).acceleration == pytest.approx(expected, rel=0.03)
    assert Carrier(flat.tilted((40, 0, 0))).limit(X).acceleration == 0


@pytest.mark.parametrize("name", ["slope", "slope_two"])
def test_fig_15(name: str) -> None:
    """All directions within 5 % of ``limit``; of ``compliant`` too where no cube leans on the other."""
    assembly = hf.assemble(shipped_scene(name))
    exact, path = (hf.transport_limits(assembly, WAYS, engine=e).acceleration for e in ("limit", "compliant"))
    carrier = Carrier(assembly, grid_nodes(assembly, 3))
    found = np.array([carrier.limit(way).acceleration for way in WAYS])
    assert np.abs(found / exact - 1).max() < WITHIN
    leaning = np.array([name == "slope_two" and way[1] > 0 for way in WAYS])
    assert np.abs(found / path - 1)[~leaning].max() < WITHIN
    assert (path < 1.01 * found).all()
