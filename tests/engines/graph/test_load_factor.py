"""Factors of several loads, accelerations, moments and standing loads (Algorithm 3)."""

import numpy as np
import pytest
from engine_scenes import X, Y, Z, block, cube_scene, floor

from holdfast import Graph, HoldfastError, Load, Scene, Status, assemble, load_factor, robustness
from holdfast.answers import Assembly
from holdfast.scene.shipped import shipped_scene


def transport(assembly: Assembly, direction: np.ndarray, **options: object) -> float:
    """Largest acceleration of the support along ``direction`` [m/s2]."""
    loads = [Load(body.name, body.com_world, -body.mass * direction) for body in assembly.movable]
    return load_factor(assembly, loads, engine=Graph(**options)).factor  # type: ignore[arg-type]


def test_transport_of_a_stack_is_limited_by_the_whole_pile() -> None:
    assert transport(assemble(shipped_scene("stack")), X) == pytest.approx(9.81 * 0.1 / 0.3)
    cube = [block(f"c{k}", (0.1, 0.1, 0.02), (0, 0, 0.01 + 0.02 * k)) for k in range(3)]
    assert transport(assemble(Scene([floor(), *cube], 0.6)), Y) == pytest.approx(0.6 * 9.81)


def test_pure_moments_on_a_cube() -> None:
    assembly = assemble(cube_scene())
    lever = 0.1 / 6 * (np.sqrt(2) + np.log(1 + np.sqrt(2)))
    for moment, expected in ((X, 0.4905), (-X, 0.4905), (Y, 0.4905), (Z, 0.6 * 9.81 * lever), (-Z, 0.6 * 9.81 * lever)):
        answer = load_factor(assembly, [Load("cube", moment=moment)], engine="graph")
        assert answer.factor == pytest.approx(expected)
        assert answer.status is Status.FINITE


@pytest.mark.parametrize(
    ("loads", "lever"),
    [
        ([Load("cube", (-0.05, 0, 0.05), 2 * Z), Load("cube", (0.05, 0, 0.05), -2 * Z)], 0.2),  # a couple
        ([Load("cube", (0, 0, 0.05), X), Load("cube", moment=0.05 * Y)], 0.1),  # as 2 N at half height
        ([Load("cube", (0, 0, 0.05), X), Load("cube", moment=-0.02 * Y)], 0.03),
    ],
)
def test_forces_and_moments_act_together(loads: list[Load], lever: float) -> None:
    """All of them tip the cube, of 4.905 N on half its width, over its edge."""
    assert load_factor(assemble(cube_scene(mu=3)), loads, engine="graph").factor == pytest.approx(0.4905 / lever)


def test_loads_on_several_bodies_share_the_interfaces_below() -> None:
    """1 N on each tile of a pile: tile k has the k-1 above it to carry through mu times their weight."""
    tiles = [block(f"t{k}", (0.4, 0.4, 0.01), (0, 0, 0.005 + 0.01 * k), m) for k, m in enumerate((1, 2, 3))]
    assembly = assemble(Scene([floor(), *tiles], 0.5))
    for shares, expected in (((1, 1, 1), 0.5 * 6 / 3), ((0, 1, 4), 0.5 * min(6 / 5, 5 / 5, 3 / 4)), ((5, 1, 0), 0.5)):
        loads = [Load(f"t{k}", (0, 0, 0.005 + 0.01 * k), share * X) for k, share in enumerate(shares) if share]
        assert load_factor(assembly, loads, engine="graph").factor == pytest.approx(9.81 * expected)


def test_factor_and_size_of_a_load_are_inverse() -> None:
    assembly = assemble(shipped_scene("table"))
    one, five = (load_factor(assembly, [Load("slab", (-0.25, 0, 0.225), s * X)], engine="graph").factor for s in (1, 5))
    assert one == pytest.approx(5 * five)
    assert one == pytest.approx(robustness(assembly, "slab", (-0.25, 0, 0.225), X, engine="graph").force[0])


def test_standing_loads_act_unscaled() -> None:
    assembly = assemble(cube_scene())
    down = Load("cube", (0, 0, 0.1), -10 * Z)
    along = [Load("cube", (-0.05, 0, 0.01), X)]
    assert load_factor(assembly, along, standing=[down], engine="graph").factor == pytest.approx(0.6 * 19.81)
    side = Load("cube", (-0.05, 0, 0.01), 2 * X)
    assert load_factor(assembly, along, standing=[side], engine="graph").factor == pytest.approx(
        0.6 * 9.81 - 2, rel=1e-4
    )
    assert robustness(assembly, "cube", (0.05, 0, 0.01), -X, standing=[side], engine="graph").force[0] == pytest.approx(
        0.6 * 9.81 + 2, rel=1e-4
    )


def test_a_standing_load_that_topples_it_leaves_nothing() -> None:
    assembly = assemble(cube_scene())
    answer = load_factor(
        assembly, [Load("cube", (0, 0, 0.1), -Z)], standing=[Load("cube", (-0.05, 0, 0.1), 5 * X)], engine="graph"
    )
    assert (answer.factor, answer.status, answer.moving) == (0, Status.UNSTABLE, ("cube",))


def test_forces_of_different_directions_are_refused_with_a_remedy() -> None:
    assembly = assemble(shipped_scene("stack"))
    loads = [Load("cube1", (0, 0, 0.05), X), Load("cube2", (0, 0, 0.15), Y)]
    with pytest.raises(HoldfastError, match=r"different directions.*'limit' or 'compliant'"):
        load_factor(assembly, loads, engine="graph")
    with pytest.raises(HoldfastError, match="different directions"):
        load_factor(assembly, [loads[0], Load("cube2", (0, 0, 0.15), -X)], engine="graph")


def test_loads_on_the_floor_move_nothing() -> None:
    answer = load_factor(assemble(cube_scene()), [Load("floor", (0, 0, 0), X)], engine="graph")
    assert (answer.factor, answer.status) == (np.inf, Status.INFINITE)
