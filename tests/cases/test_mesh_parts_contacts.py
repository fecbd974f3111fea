"""A U of abutting boxes touches and carries like the same U as one closed surface."""

from __future__ import annotations

import numpy as np
import pytest
from mesh_parts import US, WAYS, B, D, H, T, W, clean_u, spanning
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.scene.shipped.blocks import at, box, floor

KINDS = [(shape, way) for shape in US for way in ("apart", "welded")]
PUSHES = [
    ("u", (0.0, D / 2, 0.15), (1, 0, 0)),
    ("u", (0.2, 0.0, 0.02), (0, 1, 0)),
    ("cube", (0.11, 0.05, 0.07), (1, 0.2, 0)),
]
PUSHES += [
    ("cube", (0.11, 0.05, 0.07), (-1, 0.1, 0)),
    ("lid", (0.15, 0.05, H), (0.3, 1, 0)),
    ("u", (0.02, 0.01, H), (0, -1, 0.3)),
]


def standing(mesh: hf.Mesh) -> hf.answers.Assembly:
    """A U on the floor, a cube on its base that touches the left arm and a lid on both arms."""
    bodies = [
        floor(),
        hf.Body("u", mesh, mass=2.0),
        box("cube", (0.06, 0.06, 0.06), 0.5, (T + 0.03, D / 2, B + 0.03)),
        box("lid", (0.32, 0.08, 0.02), 0.4, (W / 2, D / 2, H + 0.01)),
    ]
    return hf.assemble(hf.Scene(bodies, 0.5))


@pytest.fixture(scope="module")
def clean() -> hf.answers.Assembly:
    return standing(clean_u())


@pytest.fixture(scope="module", params=KINDS, ids=lambda kind: f"{kind[0]}, {kind[1]}")
def in_parts(request: pytest.FixtureRequest) -> hf.answers.Assembly:
    shape, way = request.param
    return standing(WAYS[way]([spanning(*span) for span in US[shape]]))


def test_the_interfaces_are_those_of_one_surface(clean: hf.answers.Assembly, in_parts: hf.answers.Assembly) -> None:
    assert [i.bodies for i in in_parts.interfaces] == [i.bodies for i in clean.interfaces]
    for found, truth in zip(in_parts.interfaces, clean.interfaces, strict=True):
        assert found.flags == truth.flags
        assert found.area == pytest.approx(truth.area, rel=1e-9)
        assert [p.kind for p in found.patches] == [p.kind for p in truth.patches]
        for one, other in zip(found.patches, truth.patches, strict=True):
            np.testing.assert_allclose(one.centroid, other.centroid, atol=1e-9)
            np.testing.assert_allclose(one.normal, other.normal, atol=1e-9)
    assert in_parts.overlaps == clean.overlaps == ()
    assert in_parts.unmodelled == clean.unmodelled
    areas = {i.bodies: i.area for i in in_parts.interfaces}
    assert areas["floor", "u"] == pytest.approx(W * D)
    assert areas["u", "cube"] == pytest.approx(2 * 0.06**2)  # the base and one arm
    assert areas["u", "lid"] == pytest.approx(2 * T * 0.08)


@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_the_robustness_is_that_of_one_surface(
    clean: hf.answers.Assembly, in_parts: hf.answers.Assembly, engine: str
) -> None:
    assert hf.stability(in_parts, engine=engine).status is hf.Status.STABLE
    for body, point, direction in PUSHES:
        found, truth = (
            hf.robustness(assembly, body, [point], [direction], engine=engine) for assembly in (in_parts, clean)
        )
        np.testing.assert_allclose(found.force, truth.force, rtol=1e-3)
        np.testing.assert_allclose(found.lower, truth.lower, rtol=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_a_support_across_the_seams_is_whole_however_the_parts_are_turned(seed: int) -> None:
    """Rounding leaves hairlines between the parts of a turned mesh."""
    turn = np.eye(4)
    turn[:3, :3] = Rotation.random(random_state=seed).as_matrix()
    back = np.linalg.inv(turn)
    for way in ("apart", "soup"):
        mesh = WAYS[way]([spanning(*span).apply_transform(turn) for span in US["beside"]])
        scene = hf.Scene([floor(), hf.Body("u", mesh, mass=2.0, pose=back)], 0.5)
        (interface,) = hf.assemble(scene).interfaces
        assert interface.area == pytest.approx(W * D, rel=1e-6)
        assert "not_manifold" not in interface.flags
        assert len(interface.patches) == 1


def test_nothing_is_made_up_at_a_seam() -> None:
    """A ball of 1 cm rolls over the seam between base and arm: it touches at one point each, as on one surface."""
    for x in (T + 0.01, T + 0.0101, T + 0.05):
        ball = hf.Body("ball", hf.Sphere(0.01), mass=0.1, pose=at(x, D / 2, B + 0.01))
        scenes = [
            hf.Scene([floor(), hf.Body("u", mesh, mass=2.0), ball], 0.5)
            for mesh in (clean_u(), WAYS["apart"]([spanning(*span) for span in US["on top"]]))
        ]
        truth, found = (hf.assemble(scene, gap=5e-5) for scene in scenes)
        assert [(i.bodies, i.flags, len(i.patches)) for i in found.interfaces] == [
            (i.bodies, i.flags, len(i.patches)) for i in truth.interfaces
        ]
