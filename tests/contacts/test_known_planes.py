"""Scans on plane faces: they touch along the normal of the plane, so that friction on it bounds what they bear."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import holdfast as hf
from holdfast.base.arrays import Float

G, MU, MASS = 9.81, 0.5, 2.0
WAYS = np.array([(np.cos(t), np.sin(t), 0.0) for t in np.arange(8) * np.pi / 4])
SUPPORTS = {
    "half space": (hf.HalfSpace(), 0.0),
    "box": (hf.Box((1.0, 1.0, 0.04)), -0.02),
    "mesh": (trimesh.creation.box((1.0, 0.8, 0.1)).subdivide(), -0.05),
}


def scan(seed: int, form: str, scatter: float, noise: float = 0.0) -> tuple[hf.Mesh, float]:
    """A box or a tin whose vertices scatter, and how high its centre is when it stands."""
    rng = np.random.default_rng(seed)
    if form == "box":
        solid = trimesh.creation.box(rng.uniform((0.15, 0.12, 0.08), (0.3, 0.2, 0.12))).subdivide()
    else:
        solid = trimesh.creation.cylinder(rng.uniform(0.05, 0.08), rng.uniform(0.06, 0.1), sections=48)
    for _ in range(3):
        solid = solid.subdivide()
    high = -float(solid.vertices[:, 2].min())
    vertices = solid.vertices + rng.normal(0, scatter, solid.vertices.shape)
    return hf.Mesh(vertices, solid.faces, noise=noise), high


def on_plane(shape: hf.Mesh, high: float, support: str, degrees: float, turn: float) -> tuple[hf.Scene, Float]:
    """A scan at rest on a fixed plane that slopes along a direction ``turn``, and the normal of the plane."""
    tilt = np.array(hf.pose(0, 0, 0, yaw=turn)) @ np.array(hf.pose(0, 0, 0, pitch=degrees))
    kind, below = SUPPORTS[support]
    fixed = hf.Body("plane", kind, pose=tilt @ np.array(hf.pose(0, 0, below)), fixed=True)
    body = hf.Body("scan", shape, mass=MASS, pose=tilt @ np.array(hf.pose(0, 0, high)))
    return hf.Scene([fixed, body], MU), tilt[:3, 2]


def slips_at(normal: Float, way: Float) -> float:
    """The acceleration a of the plane along ``way`` at which f = g - a way leaves the friction cone about ``normal``.

    From |f|² = (1 + μ²) (f · n)², a quadratic in a.
    """
    g = np.array([0, 0, -G])
    k = 1 + MU**2
    coefficients = (
        way @ way - k * (way @ normal) ** 2,
        -2 * (g @ way) + 2 * k * (g @ normal) * (way @ normal),
        g @ g - k * (g @ normal) ** 2,
    )
    roots = np.roots(coefficients)
    return float(min((a.real for a in roots if abs(a.imag) < 1e-12 and a.real > 0), default=np.inf))


def tilts(assembly: hf.answers.Assembly, normal: Float) -> Float:
    """The angles [rad] between all contact normals and that of the plane."""
    normals = np.array([patch.normal for i in assembly.interfaces for patch in i.patches])
    return np.asarray(np.linalg.norm(np.cross(normals, normal), axis=1))


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("form", "scatter", "noise"), [("box", 1e-3, 0), ("box", 1e-3, 1e-3), ("tin", 1e-4, 0)])
@pytest.mark.parametrize(
    ("support", "degrees"), [("half space", 0.0), ("box", 0.0), ("mesh", 7.0), ("half space", 12.0)]
)
def test_a_scan_on_a_fixed_plane_slides_as_its_friction_says(
    seed: int, form: str, scatter: float, noise: float, support: str, degrees: float
) -> None:
    scene, normal = on_plane(*scan(seed, form, scatter, noise), support, degrees, 40.0 * seed)
    assembly = hf.assemble(scene)
    assert tilts(assembly, normal).max() < 1e-9
    found = hf.transport_limits(assembly, WAYS, engine=hf.Limit())
    right = np.array([slips_at(normal, way) for way in WAYS])
    assert (found.lower <= right * (1 + 1e-6)).all()
    slides = found.mode == "slip"
    assert found.acceleration[slides] == pytest.approx(right[slides], rel=1e-6)
    if not noise:
        assert slides.all()


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_a_low_level_push_on_a_scan_ends_at_its_friction(seed: int, engine: str) -> None:
    shape, high = scan(seed, "box", 1e-3)
    scene, _ = on_plane(shape, high, "box", 0.0, 0.0)
    body = scene.body("scan")
    corners = body.surface_world.vertices
    low = corners[(corners[:, 2] > 0.02) & (corners[:, 2] < 0.03)]
    points = low[np.argsort(np.linalg.norm(low[:, :2] @ [[1, 0], [0, 0]], axis=1))[-4:]]
    found = hf.robustness(hf.assemble(scene), "scan", points, -np.sign(points[:, :1]) * [1.0, 0, 0], engine=engine)
    assert (found.lower <= MU * MASS * G * (1 + 1e-6)).all()
    assert (found.lower > 0).all()


def test_a_scan_on_a_box_that_can_move_touches_along_the_normal_of_the_box() -> None:
    shape, high = scan(5, "box", 1e-3)
    scene, normal = on_plane(shape, high + 0.1, "half space", 9.0, 30.0)
    crate = hf.Body(
        "crate", hf.Box((0.5, 0.4, 0.1)), mass=5, pose=scene.body("scan").pose @ np.array(hf.pose(0, 0, -high - 0.05))
    )
    assembly = hf.assemble(hf.Scene([*scene.bodies, crate], MU))
    assert {i.bodies for i in assembly.interfaces} == {("plane", "crate"), ("scan", "crate")}
    assert tilts(assembly, normal).max() < 1e-9


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("scatter", [3e-4, 1e-3])
def test_a_scan_that_juts_out_over_the_edge_of_a_table_does_not_catch_on_it(seed: int, scatter: float) -> None:
    """Edges and corners of the scan cross that of the table there, with normals that scatter more than the faces."""
    shape, high = scan(seed, "box", scatter)
    table = hf.Body("plane", hf.Box((1.0, 1.0, 0.5)), position=(0.48, 0, -0.25), fixed=True)
    assembly = hf.assemble(hf.Scene([table, hf.Body("scan", shape, mass=MASS, position=(0, 0, high))], MU))
    assert tilts(assembly, np.array([0, 0, 1.0])).max() < 1e-9
    assert (hf.transport_limits(assembly, WAYS, engine=hf.Limit()).lower <= MU * G * (1 + 1e-6)).all()


def test_the_sides_and_the_edge_of_a_plane_face_keep_their_own_normals() -> None:
    """A scan that leans with 30 degrees on the edge of a table touches along its own normal there."""
    shape, high = scan(1, "box", 3e-4)
    lean = np.array(hf.pose(0, 0, 0, pitch=-30)) @ np.array(hf.pose(0, 0, high))
    table = hf.Body("table", hf.Box((1.0, 1.0, 0.5)), position=(0.5, 0, -0.25), fixed=True)
    found = hf.assemble(hf.Scene([table, hf.Body("scan", shape, mass=MASS, pose=lean)], MU))
    normals = np.array([patch.normal for i in found.interfaces for patch in i.patches])
    assert len(normals)
    assert (normals @ lean[:3, 2] > np.cos(np.radians(10))).all()
