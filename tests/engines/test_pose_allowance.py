"""What uncertain poses take from ``lower``: against the closed forms of a leaning box, and on random table tops."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.engines.contract import EXACT
from holdfast.engines.doubts.doubtful_contacts import prepared
from holdfast.engines.doubts.pose_allowance import PoseAllowance, narrowed
from holdfast.engines.limit_engine import Limit
from holdfast.queries.request import body_number, push_columns
from holdfast.scene.shipped.blocks import at, box, floor

G = 9.81
SIGMA = (0.0015, 0.5)
TILT = np.radians(4 * SIGMA[1])
SCENES, PUSHES = 200, 6
X = (1, 0, 0)


def alone(mu: float, sigma: tuple[float, float] = SIGMA) -> Assembly:
    """A box of 1 kg, 0.1 m wide and 0.16 m high, on a floor."""
    return hf.assemble(hf.Scene([floor(4, 4), box("box", (0.1, 0.1, 0.16), 1, (0, 0, 0.08))], mu), pose_sigma=sigma)


def test_narrowed_cones_lie_within_the_tilted_ones() -> None:
    assembly = narrowed(alone(0.4), 0.03)
    assert assembly.mu == pytest.approx([np.tan(np.arctan(0.4) - 0.03)])
    assert narrowed(alone(0.4), -0.03).mu == pytest.approx([np.tan(np.arctan(0.4) + 0.03)])
    assert narrowed(alone(0.02), 0.03).mu == (0.0,)


def test_a_box_that_tips_leans_and_is_pushed_higher() -> None:
    """R = m g a / h: a falls by the tilt times the height of the centre, h rises by half the gap."""
    assembly = alone(2.0)
    gap = assembly.tolerances.between(*assembly.bodies).gap
    found = hf.robustness(assembly, "box", (-0.05, 0, 0.16), X, engine="limit")
    assert found.force[0] == pytest.approx(G * 0.05 / 0.16, rel=1e-6)
    assert found.lower[0] == pytest.approx(G * (0.05 - TILT * 0.08) / (0.16 + gap / 2), rel=1e-4)
    assert found.upper[0] == pytest.approx(G * 0.05 / (1 - TILT * 0.08 / 0.05) / (0.16 - gap / 2), rel=1e-4)


def test_a_box_that_slides_has_a_narrower_cone() -> None:
    found = hf.robustness(alone(0.3), "box", (-0.05, 0, 0.01), X, engine="limit")
    narrow = np.tan(np.arctan(0.3) - TILT) * G
    lean = PoseAllowance.of(alone(0.3), None, None).share
    assert lean == pytest.approx(1 - TILT * 0.08 / 0.05, rel=1e-6)
    assert found.lower[0] == pytest.approx(narrow * lean, rel=1e-4)


def test_positions_alone_tilt_nothing() -> None:
    found = hf.robustness(alone(0.3, (SIGMA[0], 0.0)), "box", (-0.05, 0, 0.01), X, engine="limit")
    assert found.lower[0] == pytest.approx(0.3 * G, rel=1e-5)


def test_a_push_into_the_support_stays_endless() -> None:
    found = hf.robustness(alone(0.3), "box", (0, 0, 0.16), (0.05, 0, -1), engine="limit")
    assert np.isinf(found.lower[0])


def table_top(rng: np.random.Generator) -> hf.Scene:
    """A row of boxes and upright cylinders; a third of the neighbours touch, the others are 1 to 12 mm apart."""
    bodies, edge = [floor(4, 4)], 0.0
    for k in range(int(rng.integers(2, 6))):
        mass, height = float(rng.uniform(0.2, 2)), float(rng.uniform(0.06, 0.25))
        edge += 0.0 if k == 0 or rng.random() < 0.35 else float(rng.uniform(0.001, 0.012))
        if rng.random() < 0.65:
            width, depth = rng.uniform(0.06, 0.2, 2)
            shape: hf.Box | hf.Cylinder = hf.Box((width, depth, height))
        else:
            radius = float(rng.uniform(0.03, 0.06))
            shape, width = hf.Cylinder(radius, height), 2 * radius
        pose = at(edge + width / 2, float(rng.uniform(-0.02, 0.02)), height / 2)
        bodies.append(hf.Body(f"body{k}", shape, mass=mass, pose=pose))
        edge += width
    return hf.Scene(bodies, float(rng.uniform(0.2, 0.7)))


def pushed(rng: np.random.Generator, scene: hf.Scene) -> list[tuple[str, Float, Float]]:
    """Pushes on sides and tops, inward to within about 20 degrees."""
    found = []
    for _ in range(PUSHES):
        body = scene.movable[int(rng.integers(len(scene.movable)))]
        low, high = body.box
        middle, half = (low + high) / 2, (high - low) / 2
        side, normal = int(rng.integers(5)), np.zeros(3)
        if side == 4:
            normal[2] = 1
            point = middle + np.array([*(0.55 * rng.uniform(-1, 1, 2) * half[:2]), half[2]])
        else:
            axis = side // 2
            normal[axis] = 1 - 2 * (side % 2)
            point = middle + normal * half
            point[2] += 0.9 * rng.uniform(-1, 1) * half[2]
            if isinstance(body.shape, hf.Box):
                point[1 - axis] += 0.8 * rng.uniform(-1, 1) * half[1 - axis]
        aslant = rng.normal(size=3) * 0.25
        direction = -normal + aslant - (aslant @ normal) * normal
        found.append((body.name, point, direction / np.linalg.norm(direction)))
    return found


def seen(rng: np.random.Generator, scene: hf.Scene) -> dict[str, Float]:
    """How far each body is seen from its true pose, as transforms of the world."""
    moves = {}
    for body in scene.movable:
        move = np.eye(4)
        move[:3, :3] = Rotation.from_rotvec(np.radians(SIGMA[1]) * rng.normal(size=3)).as_matrix()
        move[:3, 3] = body.com_world + SIGMA[0] * rng.normal(size=3) - move[:3, :3] @ body.com_world
        moves[body.name] = move
    return moves


def lowers(assembly: Assembly, pushes: list[tuple[str, Float, Float]]) -> Float:
    columns = [push_columns(assembly, body_number(assembly, name), p[None], e[None]) for name, p, e in pushes]
    return prepared(Limit(), assembly).load_factor(np.hstack(columns), EXACT).lower


def compared(seeds: range) -> tuple[Float, Float, Float]:
    """``lower`` of the true poses, the same without neighbours that no body needs, and ``lower`` of those seen."""
    rows = []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        scene = table_top(rng)
        pushes, moves = pushed(rng, scene), seen(rng, scene)
        true = hf.assemble(scene)
        between = [k for k, i in enumerate(true.interfaces) if "floor" not in i.bodies]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", hf.errors.HoldfastWarning)  # bodies are seen within each other
            poses = {body.name: moves[body.name] @ body.pose for body in scene.movable}
            noisy = hf.assemble(scene.moved(poses), pose_sigma=SIGMA)
        carried = [
            (name, moves[name][:3, :3] @ p + moves[name][:3, 3], moves[name][:3, :3] @ e) for name, p, e in pushes
        ]
        full = lowers(true, pushes)
        least = np.minimum(full, lowers(true.without_interfaces(between), pushes))
        rows.append((full, least, lowers(noisy, carried)))
    full, least, low = (np.concatenate(column) for column in zip(*rows, strict=True))
    return full, least, low


@pytest.mark.parametrize(
    "seeds", [range(8), pytest.param(range(8, SCENES), marks=pytest.mark.slow)], ids=["few", "many"]
)
def test_lower_of_noisy_poses_holds_for_the_true_ones(seeds: range) -> None:
    """Never above; and at most a tenth of it below half of what holds without the help of neighbours."""
    full, least, low = compared(seeds)
    assert (low <= 1.01 * full).all()
    assert (low < 0.5 * least).mean() <= 0.1
    assert np.median(np.divide(low, least, out=np.ones(len(low)), where=np.isfinite(least))) > 0.7
