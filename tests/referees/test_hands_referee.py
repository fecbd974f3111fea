"""Every state of a building that hands hold stands in MuJoCo with hands of little more than that strength.

A hand there is a spring with damping that keeps a body in place, and whose force and moment end at a bound.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

import holdfast as hf
from bench.baselines.native import Native
from bench.scenes.voussoirs import arch_of
from holdfast.answers import Assembly, BuildOrder
from holdfast.base.arrays import Float
from holdfast.scene.shipped.blocks import arch

pytestmark = pytest.mark.referee

STEP, TIME = 5e-4, 1.0  # [s]
SOFT = 5e-4  # [m] by which a hand gives way under the weight of its body
FAR = 5e-3  # [m] beyond which something has moved


def hands_of(order: BuildOrder, number: int) -> tuple[Assembly, dict[str, tuple[float, float]]]:
    """The state before a step, and the least force and moment of each hand in it."""
    gone = set(order.order[number:])
    holds = order.steps[number].holds
    lengths = {h.body: (float(np.linalg.norm(h.force)), float(np.linalg.norm(h.moment))) for h in holds}
    return order.assembly.without(gone), lengths


def stands_in_mujoco(state: Assembly, bounds: Mapping[str, tuple[float, float]]) -> bool:
    """Whether all bodies stay where they are, with hands of at most these forces and moments."""
    native = Native(state.scene, STEP, settle=0.0)
    data, model = native.data, native.model
    home = {name: (data.xipos[native.number[name]].copy(), data.xmat[native.number[name]].copy()) for name in bounds}
    begin = np.array([data.xipos[k] for k in native.movable])
    for _ in range(round(TIME / STEP)):
        data.xfrc_applied[:] = 0
        for name, (force, moment) in bounds.items():
            k = native.number[name]
            mass, size = float(model.body_mass[k]), state.scene.body(name).size
            stiff = 9.81 * mass / SOFT
            speed = np.zeros(6)
            native.mujoco.mj_objectVelocity(model, data, native.mujoco.mjtObj.mjOBJ_BODY, k, speed, 0)
            turned = _turn(home[name][1].reshape(3, 3) @ data.xmat[k].reshape(3, 3).T)
            damped = 0.5 * np.sqrt(stiff * mass)
            push = stiff * (home[name][0] - data.xipos[k]) - damped * speed[3:]
            twist = stiff * size**2 / 6 * turned - damped * size**2 / 6 * speed[:3]
            data.xfrc_applied[k] = [*_within(push, force), *_within(twist, moment)]
        native.mujoco.mj_step(model, data)
    return bool(np.abs(np.array([data.xipos[k] for k in native.movable]) - begin).max() < FAR)


def _within(vector: Float, most: float) -> Float:
    length = float(np.linalg.norm(vector))
    return vector if length <= most else vector * (most / length)


def _turn(rotation: Float) -> Float:
    """The rotation vector of a small rotation."""
    return (
        np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
        / 2
    )


@pytest.mark.parametrize("scene", [arch(), arch_of(13)], ids=["shipped", "13 voussoirs"])
def test_every_state_of_an_arch_stands_with_hands_of_that_strength(scene: hf.Scene) -> None:
    pytest.importorskip("mujoco")
    order = hf.build_order(scene, hands=2, pushes=0)
    assert order.reached
    held = [number for number, step in enumerate(order.steps) if step.holds]
    assert held
    for number in held:
        state, least = hands_of(order, number)
        assert stands_in_mujoco(state, {name: (1.25 * f + 1e-3, 1.25 * m + 1e-3) for name, (f, m) in least.items()})
        assert not stands_in_mujoco(state, {name: (0.6 * f, 0.6 * m) for name, (f, m) in least.items()})
