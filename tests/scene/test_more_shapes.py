"""Capsules, ellipsoids, half spaces and compounds: mass properties against closed forms and boolean unions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from placed import at
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.base.arrays import Float

L = [((0.4, 0.1, 0.1), (0, 0, 0.05)), ((0.1, 0.1, 0.3), (-0.15, 0, 0.25))]
T = [((0.1, 0.1, 0.3), (0, 0, 0.15)), ((0.4, 0.1, 0.1), (0, 0, 0.35))]
U = [((0.4, 0.1, 0.1), (0, 0, 0.05)), ((0.1, 0.1, 0.3), (-0.15, 0, 0.25)), ((0.1, 0.1, 0.3), (0.15, 0, 0.25))]
LEGS = [((0.05, 0.05, 0.4), (x, y, 0.2)) for x in (-0.3, 0.3) for y in (-0.2, 0.2)]
TABLE = [((0.7, 0.5, 0.04), (0, 0, 0.42)), *LEGS]
OVERLAPPING = [((0.4, 0.1, 0.1), (0, 0, 0.05)), ((0.1, 0.3, 0.2), (0.05, 0.02, 0.1))]
CROSS = [((0.5, 0.1, 0.1), (0, 0, 0.05)), ((0.1, 0.5, 0.1), (0, 0, 0.05))]
APART = [((0.1, 0.1, 0.1), (-0.2, 0, 0.05)), ((0.1, 0.1, 0.1), (0.2, 0, 0.05))]
BUILT = {"L": L, "T": T, "U": U, "table": TABLE, "overlapping": OVERLAPPING, "cross": CROSS, "apart": APART}


def compound(boxes: list) -> hf.Compound:
    return hf.Compound([hf.Part(hf.Box(size), at(*place)) for size, place in boxes])


def union(boxes: list) -> tuple[float, Float, Float]:
    """Volume, centre and inertia of the union of boxes, cell by cell of the grid that all of their faces make."""
    low, high = (np.array([np.array(place) + s * np.array(size) / 2 for size, place in boxes]) for s in (-1, 1))
    edges = [np.unique(np.round(np.concatenate([low[:, k], high[:, k]]), 12)) for k in range(3)]
    sizes = np.stack(np.meshgrid(*(np.diff(e) for e in edges), indexing="ij"), -1).reshape(-1, 3)
    middles = np.stack(np.meshgrid(*((e[1:] + e[:-1]) / 2 for e in edges), indexing="ij"), -1).reshape(-1, 3)
    inside = ((middles[:, None] > low) & (middles[:, None] < high)).all(2).any(1)
    sizes, middles = sizes[inside], middles[inside]
    volumes = sizes.prod(1)
    com = volumes @ middles / volumes.sum()
    inertia = np.zeros((3, 3))
    for volume, size, arm in zip(volumes, sizes, middles - com, strict=True):
        inertia += volume * ((size @ size * np.eye(3) - np.diag(size**2)) / 12)
        inertia += volume * (np.eye(3) * (arm @ arm) - np.outer(arm, arm))
    return float(volumes.sum()), com, inertia


@pytest.mark.parametrize("name", BUILT)
def test_a_compound_has_the_mass_properties_of_the_union(name: str) -> None:
    volume, com, inertia = union(BUILT[name])
    found = compound(BUILT[name]).mass_properties
    assert found.volume == pytest.approx(volume, rel=1e-9)
    assert np.allclose(found.com, com, atol=1e-9)
    assert np.allclose(found.inertia, inertia, rtol=1e-9, atol=1e-9 * inertia.max())


FOOTPRINTS = {"L": 0.04, "T": 0.01, "U": 0.04, "table": 4 * 0.0025, "overlapping": 0.06, "cross": 0.09, "apart": 0.02}


@pytest.mark.parametrize("name", BUILT)
def test_a_compound_touches_the_floor_with_its_footprint_alone(name: str) -> None:
    floor = hf.Body("floor", hf.HalfSpace(), fixed=True)
    assembly = hf.assemble(hf.Scene([floor, hf.Body("it", compound(BUILT[name]), mass=1.0)], 0.5))
    (interface,) = assembly.interfaces
    assert interface.area == pytest.approx(FOOTPRINTS[name], rel=1e-9)
    assert all(np.allclose(patch.normal, (0, 0, 1)) for patch in interface.patches)
    assert hf.stability(assembly).status is hf.Status.STABLE


def test_parts_inside_each_other_touch_others_where_the_union_does() -> None:
    """A cube stands in the corner of an L: it touches both arms, and the inner face between them is no contact."""
    cube = hf.Body("cube", hf.Box((0.1, 0.1, 0.1)), mass=0.5, pose=at(-0.05, 0, 0.15))
    bodies = [hf.Body("floor", hf.HalfSpace(), fixed=True), hf.Body("L", compound(L), mass=1.0), cube]
    found = {i.bodies: i for i in hf.assemble(hf.Scene(bodies, 0.5)).interfaces}
    assert found["L", "cube"].area == pytest.approx(2 * 0.01, rel=1e-9)


def test_turned_parts_and_round_parts_keep_their_exact_masses() -> None:
    turn = Rotation.from_euler("xyz", (0.3, 0.5, -0.2)).as_matrix()
    ball, rod = hf.Sphere(0.1), hf.Cylinder(0.05, 0.4)
    found = hf.Compound([hf.Part(ball, at(0, 0, 0.6)), hf.Part(rod, at(0.1, 0, 0, turn))]).mass_properties
    v, w = ball.mass_properties.volume, rod.mass_properties.volume
    com = (v * np.array([0, 0, 0.6]) + w * np.array([0.1, 0, 0])) / (v + w)
    assert found.volume == pytest.approx(v + w, rel=1e-12)
    assert np.allclose(found.com, com)
    inertia = ball.mass_properties.inertia + turn @ rod.mass_properties.inertia @ turn.T
    for mass, place in ((v, (0, 0, 0.6)), (w, (0.1, 0, 0))):
        arm = place - com
        inertia = inertia + mass * (np.eye(3) * (arm @ arm) - np.outer(arm, arm))
    assert np.allclose(found.inertia, inertia, rtol=1e-12)


def test_every_triangle_of_a_compound_knows_its_part() -> None:
    shape = compound(T)
    middles = shape.surface.vertices[shape.surface.faces].mean(1)
    assert (shape.part_of == (middles[:, 2] > 0.3 - 1e-9)).all()


@pytest.mark.parametrize("shape", [hf.Capsule(0.05, 0.2), hf.Ellipsoid((0.05, 0.1, 0.03))])
def test_round_shapes_have_the_mass_properties_of_fine_meshes(shape: hf.Capsule | hf.Ellipsoid) -> None:
    fine = hf.Capsule(0.05, 0.2, 400) if isinstance(shape, hf.Capsule) else hf.Ellipsoid(shape.radii, 6)
    mesh = hf.Mesh(fine.surface.vertices, fine.surface.faces)
    assert mesh.is_closed
    found, truth = shape.mass_properties, mesh.mass_properties
    assert truth.volume < found.volume < truth.volume * 1.001
    assert np.allclose(found.inertia, truth.inertia, rtol=2e-3, atol=1e-12)


def test_tessellations_lie_inside_by_no_more_than_they_say() -> None:
    capsule = hf.Capsule(0.05, 0.2)
    middles = capsule.surface.vertices[capsule.surface.faces].mean(1)
    z = np.clip(middles[:, 2], -0.1, 0.1)
    distance = np.linalg.norm(middles - np.column_stack([0 * z, 0 * z, z]), axis=1)
    assert (distance <= 0.05).all()
    assert distance.min() >= 0.05 - capsule.surface.sagitta
    ellipsoid = hf.Ellipsoid((0.05, 0.1, 0.03))
    level = np.linalg.norm(ellipsoid.surface.vertices / ellipsoid.radii, axis=1)
    assert np.allclose(level, 1)


def test_a_half_space_lies_under_all_bodies_wherever_they_are() -> None:
    pose = at(3, -2, 1, Rotation.from_euler("x", 0.4).as_matrix())
    box = hf.Body("box", hf.Box((0.2, 0.2, 0.2)), mass=1, pose=pose @ at(40, 30, 0.1))
    scene = hf.Scene([hf.Body("ground", hf.HalfSpace(), fixed=True, pose=pose), box], 0.9, -9.81 * pose[:3, 2])
    assert hf.stability(scene).status is hf.Status.STABLE
    assert scene.bodies[0].shape == hf.HalfSpace()
    assert scene.bodies[0].shape.reach >= 40
    near = scene.moved({"box": pose @ at(0, 0, 0.1)})
    assert near.bodies[0].shape.reach < 8


def test_more_bodies_do_not_change_an_answer_on_a_half_space() -> None:
    ground = hf.Body("ground", hf.HalfSpace(), fixed=True)
    cube = hf.Body("cube", hf.Box((0.1, 0.1, 0.1)), mass=1, pose=at(0, 0, 0.05))
    far = hf.Body("far", hf.Box((0.1, 0.1, 0.1)), mass=1, pose=at(20, 0, 0.05))
    found = [
        hf.robustness(hf.assemble(hf.Scene(bodies, 0.5), gap=1e-4), "cube", (-0.05, 0, 0.05), (1, 0, 0)).force[0]
        for bodies in ([ground, cube], [ground, cube, far])
    ]
    assert found[0] == pytest.approx(0.5 * 9.81, rel=1e-6)
    assert found[0] == found[1]


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: hf.Capsule(0.1, 0), "Capsule: length"),
        (lambda: hf.Ellipsoid((0.1, -0.1, 0.1)), "Ellipsoid: radii"),
        (lambda: hf.Ellipsoid((0.1, 0.1)), "Ellipsoid: radii"),
        (lambda: hf.Compound([]), "has no parts"),
        (lambda: hf.Compound(3), "needs a list of parts"),
        (lambda: hf.Part(hf.HalfSpace()), "needs a shape with an end"),
        (lambda: hf.Part(hf.Compound([hf.Box((1, 1, 1))])), "give the parts of a compound"),
        (lambda: hf.Part("box"), "shape is a str"),
        (lambda: hf.Body("b", hf.HalfSpace(), mass=1, com=(0, 0, 0)), "HalfSpace that can move"),
        (lambda: hf.HalfSpace().mass_properties, "has no end"),
        (lambda: hf.Compound([hf.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])]).mass_properties, "part 0"),
    ],
)
def test_what_makes_no_sense_is_told(make: object, told: str) -> None:
    with pytest.raises(hf.HoldfastError, match=told):
        make()


def test_all_shapes_go_to_files_and_come_back(tmp_path: Path) -> None:
    parts = [hf.Part(hf.Box((0.1, 0.1, 0.1)), at(0, 0, 0.1), "rubber"), hf.Capsule(0.02, 0.1)]
    bodies = [
        hf.Body("ground", hf.HalfSpace(), fixed=True),
        hf.Body("capsule", hf.Capsule(0.05, 0.2, 24), mass=1, pose=at(1, 0, 0.15)),
        hf.Body("egg", hf.Ellipsoid((0.03, 0.03, 0.04)), density=900, pose=at(2, 0, 0.04)),
        hf.Body("tool", hf.Compound(parts), density=500, pose=at(3, 0, 0.07), material="steel"),
    ]
    scene = hf.Scene(bodies, hf.Friction(0.4, {("rubber", "steel"): 0.9}))
    for suffix in (".yaml", ".json"):
        hf.save_scene(scene, tmp_path / f"scene{suffix}")
        assert hf.load_scene(tmp_path / f"scene{suffix}") == scene


# Cups of convex pieces, as collision models are made: a plate, and walls that lean outwards and meet in mitres


def cup(sides: int, radius: float, height: float, thick: float, lean: float, begin: float) -> list[np.ndarray]:
    """The corners of the plate and of each wall; the walls begin at the height ``begin`` in the plate."""
    turn = 2 * np.pi * np.arange(sides) / sides

    def ring(inward: float, z: float) -> np.ndarray:
        rho = radius - inward + lean * z
        return np.column_stack([rho * np.cos(turn), rho * np.sin(turn), np.full(sides, z)])

    pieces = [np.vstack([ring(0, 0), ring(0, thick)])]
    for k in range(sides):
        ends = [k, (k + 1) % sides]
        pieces.append(np.vstack([ring(inward, z)[ends] for inward in (0, thick) for z in (begin, height)]))
    return pieces


@pytest.mark.parametrize("seed", range(12))
def test_mitred_pieces_are_united_and_weigh_what_their_union_does(seed: int) -> None:
    """Their edges coincide but for rounding; volume and centre beside integrals over the height."""
    rng = np.random.default_rng(seed)
    sides, radius, height = int(rng.integers(3, 13)), rng.uniform(0.03, 0.1), rng.uniform(0.03, 0.12)
    thick, lean = rng.uniform(0.002, 0.006), rng.uniform(0, 0.5)
    begin = (0.0, thick / 2, thick)[seed % 3]
    turn, shift = Rotation.random(random_state=seed).as_matrix(), rng.normal(size=3)
    pieces = [trimesh.convex.convex_hull(p @ turn.T + shift) for p in cup(sides, radius, height, thick, lean, begin)]
    body = hf.Body("cup", hf.Compound([hf.Mesh(piece.vertices, piece.faces) for piece in pieces]), mass=0.2)
    out, inner, z = np.poly1d([lean, radius]), np.poly1d([lean, radius - thick]), np.poly1d([1, 0])
    share = float(sides / 2 * np.sin(2 * np.pi / sides))
    area = [out**2 * share, (out**2 - inner**2) * share]  # of the plate, and of the walls above it

    def over(power: np.poly1d) -> float:
        parts = [(a * power).integ() for a in area]
        return float(parts[0](thick) - parts[0](0) + parts[1](height) - parts[1](thick))

    volume = over(np.poly1d([1]))
    assert body.shape.mass_properties.volume == pytest.approx(volume, rel=1e-9)
    assert body.com_body == pytest.approx(turn @ (0, 0, over(z) / volume) + shift, abs=1e-9)


def test_an_open_part_is_taken_where_the_mass_is_known_or_the_body_fixed() -> None:
    """A plate with an open rim: it touches with both, and asks for what it cannot work out."""
    rim = trimesh.creation.cylinder(0.1, 0.02, sections=24)
    rim.update_faces(np.abs(rim.face_normals[:, 2]) < 0.5)  # the side alone
    at = np.eye(4)
    at[2, 3] = 0.03
    shape = hf.Compound([hf.Box((0.1, 0.1, 0.04)), hf.Part(hf.Mesh(rim.vertices, rim.faces), at)])
    assert set(shape.part_of.tolist()) == {0, 1}
    floor = hf.Body("floor", hf.HalfSpace(), fixed=True)
    lift = np.eye(4)
    lift[2, 3] = 0.02
    known = hf.Body("plate", shape, mass=0.4, com=(0, 0, 0), inertia=np.eye(3) * 1e-3, pose=lift)
    assert hf.stability(hf.Scene([floor, known], 0.5)).status == hf.Status.STABLE
    assert hf.Body("plate", shape, fixed=True).shape.surface.faces.shape[1] == 3
    with pytest.raises(hf.errors.GeometryError, match=r"body 'plate': part 1: .*is not watertight.*give mass=, com="):
        hf.Body("plate", shape, mass=0.4)
