"""Forces inside their cones and motions that open every node, found without a program where that is easy."""

from __future__ import annotations

import numpy as np
import pytest
from engine_scenes import G0, X, block, cube, floor
from limit_scenes import push

from holdfast import Limit, Scene, Status, assemble
from holdfast.answers import Assembly
from holdfast.engines.limit import interior, repair
from holdfast.engines.limit.interior import pressed_forces
from holdfast.engines.limit.limit_state import LimitState


def dense(across: int = 3, deep: int = 2, high: int = 2) -> Assembly:
    """Boxes side by side, the upper ones across the joints of the lower ones."""
    size = (0.3, 0.2, 0.15)
    places = [(x, y, z) for z in range(high) for y in range(deep) for x in range(across)]
    boxes = [block(f"box{x}{y}{z}", size, (0.3 * x + 0.1 * z, 0.2 * y, 0.075 + 0.15 * z), 5.0) for x, y, z in places]
    return assemble(Scene([floor(6.0), *boxes], 0.5))


def between_walls() -> Assembly:
    """A block that fills the room between two walls: no motion leaves both."""
    walls = [block(f"wall{side}", (0.1, 0.2, 0.2), (0.1 * side, 0, 0.1), fixed=True) for side in (-1, 1)]
    return assemble(Scene([floor(), *walls, block("cube", (0.1, 0.1, 0.1), (0, 0, 0.05))], 0.5))


def state_of(assembly: Assembly) -> LimitState:
    state = Limit().prepare(assembly)
    assert state.verdict().equilibrium_exists
    return state


def pressed(state: LimitState) -> np.ndarray | None:
    known = state.proofs._carried
    assert known.balance is not None
    return pressed_forces(known.balance, known.wrench, known.mu, known.tau)


def test_forces_between_dense_boxes_balance_and_have_room() -> None:
    state = state_of(dense())
    found = pressed(state)
    assert found is not None
    nodes, assembly = state.rest.nodes, state.assembly
    forces = nodes.world(found.reshape(-1, 3))
    for number, body in enumerate(assembly.movable):
        into, out = nodes.b == number, nodes.a == number
        points = np.vstack([nodes.points[into], nodes.points[out]])
        acting = np.vstack([forces[into], -forces[out]])
        assert acting.sum(0) == pytest.approx([0, 0, body.mass * G0], abs=1e-9)
        assert np.cross(points - body.com_world, acting).sum(0) == pytest.approx([0, 0, 0], abs=1e-9)
    normal, along = found[::3], np.hypot(found[1::3], found[2::3])
    assert (normal - along / nodes.mu >= 0.0999 * state.proofs._carried.tau).all()


def test_none_are_found_where_friction_is_all_but_used_up() -> None:
    assert pressed(state_of(cube(0.6, gravity=(0.5 * 0.6 * G0, 0, -G0)))) is not None
    assert pressed(state_of(cube(0.6, gravity=(0.95 * 0.6 * G0, 0, -G0)))) is None


def test_the_motion_opens_every_node_between_dense_boxes() -> None:
    state = state_of(dense())
    opening = state.proofs._repair._usual_opening
    assert opening is not None
    nodes, com = state.rest.nodes, np.vstack([state.assembly.com, np.zeros((1, 3))])
    twists = np.vstack([opening.motion.reshape(-1, 6), np.zeros((1, 6))])  # the last one is FIXED
    velocity = [twists[side, :3] + np.cross(twists[side, 3:], nodes.points - com[side]) for side in (nodes.b, nodes.a)]
    u = np.einsum("ikx,ix->ik", nodes.axes, velocity[0] - velocity[1])
    opened = u[:, 0] - nodes.mu * np.hypot(u[:, 1], u[:, 2])
    assert (opened >= 0.999 * opening.room).all()
    assert (opening.room * state.proofs._carried.tau >= 0.5 * (1 - 1e-9)).all()


def test_no_motion_opens_what_is_clamped() -> None:
    assert state_of(between_walls()).proofs._repair._usual_opening is None


def test_dense_boxes_are_proved_without_a_program_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    assembly = dense()

    def refused(*_: object, **__: object) -> None:
        raise AssertionError("solved a program")

    for module in (interior, repair):
        monkeypatch.setattr(module, "solve", refused)
    found = push(assembly, "box001", assembly.com[assembly.index["box001"]] - 0.15 * X, X)
    assert found.status[0] is Status.FINITE
    assert found.upper[0] - found.lower[0] <= 1e-6 * found.upper[0]


def test_of_what_falls_no_proof_of_being_carried_is_sought() -> None:
    leaning = block("cube", (0.1, 0.1, 0.1), (0.06, 0, 0.15), 1.0)
    assembly = assemble(Scene([floor(), block("below", (0.1, 0.1, 0.1), (0, 0, 0.05), 1.0), leaning], 0.5))
    state = Limit().prepare(assembly)
    assert state.verdict().status is Status.UNSTABLE
    found = state.load_factor(np.eye(6 * len(assembly.movable)))
    assert not found.notes
    assert "reference" not in state.proofs._carried.__dict__
