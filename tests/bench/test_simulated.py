"""Simulators as baselines: closed forms of one block, in whichever of them is installed."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from bench.baselines import pybullet, simulated
from bench.baselines.search import Peak, Trial, bracketed, largest_load
from holdfast import Body, Box, Friction, HoldfastError, Mesh, Scene, Status, assemble
from holdfast.answers import Assembly
from holdfast.errors import SceneError
from holdfast.scene.shipped import shipped_scene

G0 = 9.81  # [m/s²]
MU, MASS, SIDE = 0.6, 2.0, 0.1
W = MASS * G0
X, Y, Z = np.eye(3)
GAIN = np.sqrt(2e-4 * MASS) * 240  # [N] that a sliding block needs to gain 1e-4 J in a 1/240 s


def needs(module: str) -> None:
    pytest.importorskip(module, reason=f"{module} is not installed: see bench/notes/baselines.md")


def turned(angle: float, centre: tuple[float, float, float]) -> np.ndarray:
    """A pose, turned about z."""
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    pose[:3, 3] = centre
    return pose


def block(mu: float = MU, height: float = SIDE, angle: float = 0.0, tilt: float = 0.0, mesh: bool = False) -> Assembly:
    """A box on a floor, under gravity that is tilted by the slope ``tilt`` towards x."""
    shape: Box | Mesh = Box(np.array([SIDE, SIDE, height]))
    if mesh:
        shape = Mesh(shape.surface.vertices, shape.surface.faces)
    bodies = [
        Body("floor", Box(np.array([2, 2, 0.1])), pose=turned(0, (0, 0, -0.05)), fixed=True),
        Body("box", shape, mass=MASS, pose=turned(angle, (0, 0, height / 2))),
    ]
    return assemble(Scene(bodies, mu, G0 * np.array([tilt, 0, -1.0])))


# ---- loads that are held


@pytest.mark.parametrize(
    ("engine", "module"), [("pybullet", "pybullet"), ("mujoco", "mujoco"), ("lmgc90", "compas_lmgc90")]
)
def test_held_loads_on_a_block(engine: str, module: str) -> None:
    """Pushed low it slides, pushed at its top it topples, and it lifts off under its weight."""
    needs(module)
    box = block()
    points = [(-0.05, 0, 0.02), (-0.05, 0, 0.1), (0, 0, 0.1)]
    found = simulated(box, "box", points, [X, X, Z], engine=engine, accuracy=0.02)  # type: ignore[arg-type]
    assert found.force == pytest.approx([MU * W, W / 2, W], rel=0.03)
    assert (found.lower < found.force).all()
    assert (found.force < found.upper).all()
    assert list(found.status) == [Status.FINITE] * 3
    assert found.undecided == 0


def test_a_block_that_is_pressed_down_never_moves() -> None:
    needs("pybullet")
    pressed = simulated(block(), "box", (0.02, 0.01, 0.1), -Z, most=50.0)
    assert pressed.status[0] is Status.INFINITE
    assert pressed.force[0] == np.inf
    assert (pressed.lower[0], pressed.upper[0]) == (50.0, np.inf)


@pytest.mark.parametrize("mesh", [False, True])
def test_pybullet_on_an_incline(mesh: bool) -> None:
    """Turned about the vertical, as a box and as a mesh: principal axes and hulls are placed right."""
    needs("pybullet")
    for ratio, rests in ((0.97, True), (1.03, False)):
        assert pybullet.holds(block(MU, tilt=ratio * MU, angle=0.3, mesh=mesh)).holds is rests
    assert pybullet.holds(block(0.9, height=0.2, tilt=0.48, mesh=mesh)).holds is True
    assert pybullet.holds(block(0.9, height=0.2, tilt=0.52, mesh=mesh)).holds is False


def test_pybullet_loads_with_torques() -> None:
    """In the world's axes, on a block that is turned by 45 degrees: it tips over a corner, 0.707 sides away."""
    needs("pybullet")
    box = block(angle=np.pi / 4)
    for share, rests in ((0.67, True), (0.74, False)):
        assert pybullet.holds(box, np.r_[0, 0, 0, 0, share * W * SIDE, 0]).holds is rests
        assert (
            pybullet.holds(box, np.r_[0, 0, 0, 0, 0, share * MU * W * SIDE]).holds is rests
        )  # friction of the corners
    assert pybullet.peak(box, "box", np.array([0, 0, 0.1]), Z).force == pytest.approx(W, rel=0.01)


def test_pybullet_gives_each_pair_its_own_friction() -> None:
    needs("pybullet")
    scene = shipped_scene("stack")
    names = [body.name for body in scene.bodies]
    friction = {tuple(sorted(pair)): mu for pair, mu in zip(itertools.pairwise(names), (0.5, 0.2, 0.4), strict=True)}
    stack = assemble(Scene(scene.bodies, Friction(pairs=friction)))
    for number, mu in ((1, 0.5), (2, 0.2), (3, 0.4)):  # each slides with all that it carries
        found = simulated(stack, f"cube{number}", (-0.05, 0, 0.1 * number - 0.09), X, accuracy=0.01)
        assert found.force[0] == pytest.approx(mu * G0 * (4 - number), rel=0.05)


# ---- Algorithm 2 as printed


def test_as_printed_a_sliding_block_has_to_gain_energy() -> None:
    """One step, 1e-4 J: slipping and lifting come out too strong by a known force, the same in all directions."""
    needs("pybullet")
    aside = np.array([np.cos(0.7), np.sin(0.7), 0])
    found = simulated(
        block(), "box", [(0, 0, 0.1), (-0.05, 0, 0.05), (-0.05, 0, 0.05)], [Z, X, aside], protocol="printed"
    )
    assert found.force[0] == pytest.approx(W + GAIN, rel=1e-3)
    assert found.force[1] == pytest.approx(MU * W + GAIN, rel=1e-2)
    assert list(found.status) == [Status.FINITE] * 3


def test_as_printed_a_long_block_tips_with_its_inertia() -> None:
    """Lifted at one end it turns about the other: the energy is that of all its mass about that edge."""
    needs("pybullet")
    long, wide, high = 0.3, 0.04, 0.12
    plank = Body("box", Box(np.array([long, wide, high])), mass=MASS, pose=turned(0.5, (0, 0, high / 2)))
    floor = Body("floor", Box(np.array([2, 2, 0.1])), pose=turned(0, (0, 0, -0.05)), fixed=True)
    end = plank.pose[:3, :3] @ [long / 2, 0, high / 2] + plank.pose[:3, 3]
    found = simulated(assemble(Scene([floor, plank], MU)), "box", end, Z, protocol="printed")
    inertia = MASS * (long**2 + high**2) / 3
    assert found.force[0] == pytest.approx(W / 2 + np.sqrt(2e-4 * inertia) * 240 / long, rel=1e-3)


def test_as_printed_friction_is_a_cone() -> None:
    """Along an edge, along a diagonal and between; a pyramid would differ by up to 1.4."""
    needs("pybullet")
    along = [np.array([np.cos(a), np.sin(a), 0]) for a in (0, np.pi / 8, np.pi / 4)]
    found = simulated(block(), "box", (0, 0, 0), along, protocol="printed").force
    assert found == pytest.approx(found[0], rel=5e-3)


def test_as_printed_endless_is_what_the_range_does_not_move() -> None:
    needs("pybullet")
    down = simulated(block(), "box", (0, 0, 0.1), -Z, protocol="printed")
    assert down.status[0] is Status.INFINITE
    slides = simulated(block(tilt=1.0), "box", (0, 0, 0.1), X, protocol="printed")
    assert slides.status[0] is Status.UNSTABLE
    assert slides.force[0] == 0.0


def test_answers_do_not_depend_on_what_was_asked_before() -> None:
    needs("pybullet")
    box = block()
    points, along = [(-0.05, 0.03, 0.05), (0, 0, 0.1), (-0.05, 0, 0.1)], [X, Z, X]
    for protocol in ("printed", "hold"):
        forward = simulated(box, "box", points, along, protocol=protocol, accuracy=0.02)  # type: ignore[arg-type]
        back = simulated(box, "box", points[::-1], along[::-1], protocol=protocol, accuracy=0.02)  # type: ignore[arg-type]
        assert forward.force.tolist() == back.force[::-1].tolist()


# ---- search and errors


class Made:
    """A simulator whose answers are made up."""

    def __init__(self, weighed: bool | None, strength: float, sure: float = np.inf) -> None:
        self.weighed = Trial(weighed, 0.0, 0.0, 1)
        self.strength, self.sure = strength, sure

    def trial(self, load: np.ndarray) -> Trial:
        holds = bool(load[0] < self.strength)
        return Trial(holds if load[0] < self.sure else None, 0.0, 0.0, 1)


@pytest.mark.parametrize(
    ("world", "status", "force"),
    [
        (Made(True, 7.0), Status.FINITE, 7.0),
        (Made(True, np.inf), Status.INFINITE, np.inf),
        (Made(True, 0.0), Status.FINITE, 0.0),
        (Made(True, np.inf, sure=3.0), Status.UNDECIDED, 0.0),
        (Made(False, 7.0), Status.UNSTABLE, 0.0),
        (Made(None, 7.0), Status.UNDECIDED, 0.0),
    ],
)
def test_what_a_search_comes_to(world: Made, status: Status, force: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pybullet, "World", lambda assembly: world)
    found = simulated(block(), "box", (0, 0, 0.1), X)
    assert found.status[0] is status
    assert found.force[0] == pytest.approx(force, rel=5e-3, abs=1e-2)
    assert found.lower[0] <= found.force[0] or status is Status.UNDECIDED
    assert found.undecided == (status is Status.UNDECIDED)


def test_searches_end() -> None:
    never = bracketed(lambda s: Trial(False, 0.0, 0.0, 1), 1.0, 100.0, 1e-3)
    assert never == Peak(0.0, never.moves, 0.0, 0.0, 0, never.steps)
    assert 0 < never.moves <= 1e-3
    assert largest_load(Made(True, np.inf), 1.0, np.ones(6), 1e-3, most=2.0).held == 2.0


def test_questions_that_make_no_sense() -> None:
    box = block()
    with pytest.raises(HoldfastError, match="known: pybullet"):
        simulated(box, "box", (0, 0, 0.1), X, engine="gazebo")  # type: ignore[arg-type]
    with pytest.raises(HoldfastError, match="ask for 'hold'"):
        simulated(box, "box", (0, 0, 0.1), X, engine="mujoco", protocol="printed")
    with pytest.raises(SceneError, match="from the surface"):
        simulated(box, "box", (0, 0, 0.2), X)


def test_pybullet_refuses_what_it_cannot_hold() -> None:
    needs("pybullet")
    bricks = assemble(shipped_scene("wall2x2"))
    pairs = {tuple(sorted(i.bodies)): 0.3 + 0.05 * k for k, i in enumerate(bricks.interfaces)}
    with pytest.raises(HoldfastError, match="product over both bodies"):
        pybullet.holds(assemble(Scene(bricks.bodies, Friction(0.5, pairs=pairs))))
