"""Tolerances that nobody chose: they follow from the two bodies of a pair alone."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.contacts.patches import line_patches
from holdfast.contacts.search_mesh import Features
from holdfast.contacts.tolerances import plain_gap, rough_gap
from holdfast.scene.shipped.blocks import at, box, floor

SIDE = (0.1, 0.1, 0.1)
DIAGONAL = 0.1 * np.sqrt(3)
STRANGERS = {
    "large": box("stranger", (4, 4, 4), 1000, (30, 0, 2)),
    "small": box("stranger", (0.004, 0.004, 0.004), 0.01, (0.4, 0.3, 0.002)),
}


def scanned(name: str, noise: float, place: tuple[float, float, float], seed: int = 1) -> hf.Body:
    mesh = trimesh.creation.box(SIDE)
    for _ in range(3):
        mesh = mesh.subdivide()
    rng = np.random.default_rng(seed)
    vertices = mesh.vertices + noise * rng.standard_normal(mesh.vertices.shape)
    return hf.Body(name, hf.Mesh(vertices, mesh.faces), mass=1.0, pose=at(*place))


def pairs(*bodies: hf.Body, **options: float) -> dict[tuple[str, str], hf.answers.Interface]:
    return {i.bodies: i for i in hf.assemble(hf.Scene([floor(), *bodies], 0.5), **options).interfaces}


@pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")
@pytest.mark.parametrize("stranger", STRANGERS)
@pytest.mark.parametrize("first", [True, False])
def test_a_stranger_changes_no_contact(stranger: str, first: bool) -> None:
    """Bit for bit, of boxes that are apart by a part of their tolerance, cans, balls and scans."""
    own = [
        box("low", SIDE, 1, (0, 0, 0.05 + 0.9e-4)),
        box("high", (0.05, 0.05, 0.02), 1, (0, 0, 0.11 + 1.4e-4)),
        hf.Body("can", hf.Cylinder(0.03, 0.1), mass=1.0, pose=at(0.2, 0, 0.05)),
        hf.Body("ball", hf.Sphere(0.03), mass=1.0, pose=at(-0.2, 0, 0.03)),
        scanned("scan", 3e-4, (0, 0.3, 0.05)),
    ]
    other = STRANGERS[stranger]
    alone, beside = pairs(*own), pairs(*((other, *own) if first else (*own, other)))
    left = {pair: interface for pair, interface in beside.items() if "stranger" not in pair}
    assert len(alone) >= 4
    assert left == alone


@pytest.mark.parametrize(
    ("upper", "gap"),
    [(SIDE, 1e-3 * DIAGONAL), ((0.05, 0.05, 0.05), 0.75e-3 * DIAGONAL), ((0.01, 0.01, 0.01), 0.5e-3 * DIAGONAL)],
)
def test_the_gap_of_a_pair_is_a_thousandth_of_its_mean_size(upper: tuple[float, float, float], gap: float) -> None:
    """Of those of the two that can move, but at most five times the smaller one's."""
    for share, touches in ((0.99, True), (1.01, False)):
        found = pairs(
            box("low", SIDE, 1, (0, 0, 0.05)), box("high", upper, 1, (0, 0, 0.1 + upper[2] / 2 + share * gap))
        )
        assert (("low", "high") in found) is touches
        assert ("floor", "low") in found
        on_floor = pairs(box("low", SIDE, 1, (0, 0, 0.05 + share * 1e-3 * DIAGONAL)))
        assert (("floor", "low") in on_floor) is touches


def test_a_turned_pair_has_the_same_gap() -> None:
    a, b = box("a", SIDE, 1, (0, 0, 0)), box("b", (0.2, 0.01, 0.3), 1, (0, 0, 1))
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec([0.3, 0.6, 0.15]).as_matrix()
    assert plain_gap(a.moved(pose), b.moved(pose @ b.pose)) == plain_gap(a, b)


def test_a_sheet_is_not_touched_through() -> None:
    a, b = box("a", SIDE, 1, (0, 0, 0)), box("b", (0.3, 0.2, 1e-4), 1, (0, 0, 1))
    assert plain_gap(a, b) == pytest.approx(0.5e-4)


@pytest.mark.filterwarnings("ignore:.*which side of its triangles:holdfast.errors.HoldfastWarning")
@pytest.mark.parametrize("uneven", [0.0, 1e-16, 1e-9, 1e-7])
def test_a_flat_sheet_carries_alike_however_its_file_was_rounded(uneven: float) -> None:
    """A ground of a scene in glTF: turned, and in single precision, it is flat but for the last digits."""
    corners = np.array([[-1, -1, 0], [1, -1, uneven], [1, 1, 0], [-1, 1, -uneven]])
    sheet = hf.Body("sheet", hf.Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]])), fixed=True)
    for above in (1e-6, 1e-5, 9e-5):
        cube = box("cube", SIDE, 1, (0.2, 0.3, 0.05 + above))
        assert plain_gap(sheet, cube) == pytest.approx(1e-3 * DIAGONAL)
        assert hf.stability(hf.Scene([sheet, cube], 0.5)).status == "stable"


def test_what_is_given_holds_for_all_pairs() -> None:
    bodies = box("low", SIDE, 1, (0, 0, 0.0508)), box("small", (0.01, 0.01, 0.01), 1, (0, 0, 0.1066))
    assert set(pairs(*bodies, gap=1e-3)) == {("floor", "low"), ("low", "small")}
    assert pairs(*bodies) == {}
    assembly = hf.assemble(hf.Scene([floor(), scanned("scan", 3e-4, (0, 0, 0.05))], 0.5), gap=1e-3)
    assert assembly.tolerances.between(*assembly.bodies).angle == 1.0
    assert assembly.tolerances.between(*assembly.bodies).gap == 1e-3
    assert assembly.notes == ()


def test_a_scan_that_touches_at_its_highest_vertex_is_not_certain() -> None:
    """What else touches within the tolerance of its roughness is a guess."""
    scan = scanned("scan", 4e-4, (0, 0, 0))
    lowest = scan.surface_world.vertices[:, 2].min()
    (interface,) = pairs(scan.moved(at(0, 0, -lowest))).values()
    assert abs(interface.separation or 0.0) < 1e-9
    assert not interface.certain


@pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")
def test_a_scan_touches_within_four_deviations_and_says_so() -> None:
    scan, exact = scanned("scan", 4e-4, (0, 0, 0.0515)), box("exact", SIDE, 1, (0.3, 0, 0.0515))
    assembly = hf.assemble(hf.Scene([floor(), scan, exact], 0.5))
    tolerances = assembly.tolerances.between(assembly.scene.body("floor"), scan)
    assert tolerances.gap == pytest.approx(1.6e-3, rel=0.15)
    assert rough_gap(floor(), exact) == 0.0
    (interface,) = assembly.interfaces
    assert interface.bodies == ("floor", "scan")
    assert not interface.certain
    assert any("floor-scan 1." in note and "rough" in note for note in hf.stability(assembly, engine="limit").notes)


@pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")
def test_a_contact_guessed_from_roughness_never_raises_lower() -> None:
    """R6 for scans: two cartons stand 1.5 mm apart; whether one helps to hold the other is not known."""
    one, two = scanned("one", 4e-4, (0, 0, 0.05)), scanned("two", 4e-4, (0.1015, 0, 0.05), seed=2)
    push = ((-0.05, 0, 0.03), (1.0, 0, 0))
    point = one.surface_world.vertices[np.argmin(np.linalg.norm(one.surface_world.vertices - push[0], axis=1))]
    both = hf.assemble(hf.Scene([floor(), one, two], 0.5))
    alone = hf.assemble(hf.Scene([floor(), one], 0.5))
    assert ("one", "two") in {i.bodies for i in both.interfaces}
    helped = hf.robustness(both, "one", point, push[1], engine="limit")
    single = hf.robustness(alone, "one", point, push[1], engine="limit")
    assert single.force[0] > 0
    assert helped.force[0] > 1.5 * single.force[0]
    assert helped.lower[0] <= single.lower[0] * (1 + 1e-6)


@pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")
def test_a_foil_without_thickness_has_a_gap() -> None:
    """Found by the fuzzer: half of no thickness was the gap."""
    corners = np.array([[0.0, 0, 0], [0.0501, 0.0003, 0], [0.0498, 0.0402, 0], [0.0002, 0.0399, 0]])
    foil = hf.Body("foil", hf.Mesh(corners, [[0, 1, 2], [0, 2, 3]]), mass=0.01, com=(0.025, 0.02, 0))
    assert plain_gap(floor(), foil) > 1e-5
    assert rough_gap(floor(), foil) == 0.0


def test_a_line_is_a_line_at_no_gap_at_all() -> None:
    """Rounding puts the ends of a line beside it by more than nothing."""
    rng = np.random.default_rng(4)
    for _ in range(20):
        ends = rng.normal(size=(1, 2, 3))
        lines = Features(ends, np.array([[0.0, 0, 1]]), np.zeros((1, 2)), np.ones(1), np.zeros(1, dtype=bool))
        (patch,) = line_patches(lines, (), 0.0, 1e-9, 1e-3)
        assert patch.length == pytest.approx(np.linalg.norm(ends[0, 1] - ends[0, 0]))
