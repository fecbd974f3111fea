"""Round parts of compounds on flat faces: exact contact, and none for what lies inside other parts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from placed import FLOOR, at
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.base.arrays import Float
from holdfast.contacts.round_contacts import feet
from holdfast.contacts.tolerances import Angles

G = 9.81
FEET = ((-0.4, -0.2), (0.4, -0.2), (0.4, 0.2), (-0.4, 0.2))


LYING = Rotation.from_euler("zy", (20, 90), degrees=True).as_matrix()  # the z axis along x


def patches(*bodies: hf.Body, gap: float = 1e-4) -> tuple[hf.answers.Patch, ...]:
    (interface,) = hf.assemble(hf.Scene([FLOOR, *bodies], 0.5), gap=gap).interfaces
    return interface.patches


def table(radius: float = 0.03) -> hf.Compound:
    """A top of 1 by 0.6 by 0.05 m on four balls, which stand at FEET."""
    balls = [hf.Part(hf.Sphere(radius), at(x, y, radius, Rotation.random(random_state=3).as_matrix())) for x, y in FEET]
    return hf.Compound([hf.Part(hf.Box((1, 0.6, 0.05)), at(z=0.025 + 1.5 * radius)), *balls])


def motion(seed: int) -> Float:
    rng = np.random.default_rng(seed)
    return at(*rng.normal(size=3), turn=Rotation.random(random_state=seed).as_matrix())


@pytest.mark.parametrize("seed", range(3))
def test_a_table_on_balls_stands_on_four_points_in_any_frame(seed: int) -> None:
    move = motion(seed) if seed else np.eye(4)
    floor = hf.Body("floor", hf.Box((2, 2, 0.1)), pose=move @ at(z=-0.05), fixed=True)
    body = hf.Body("table", table(), mass=3, pose=move)
    scene = hf.Scene([floor, body], 0.5, gravity=move[:3, :3] @ (0, 0, -G))
    (interface,) = hf.assemble(scene, gap=1e-4).interfaces
    assert {patch.kind for patch in interface.patches} == {"point"}
    local = [(patch.polygon[0] - move[:3, 3]) @ move[:3, :3] for patch in interface.patches]
    for foot in FEET:
        assert min(np.linalg.norm(place - (*foot, 0.0)) for place in local) < 1e-9
    assert len(local) == 4
    assert np.allclose([patch.normal for patch in interface.patches], move[:3, 2], atol=1e-12)


def test_a_table_on_balls_tips_about_the_line_of_two_feet() -> None:
    """Pressed down beyond its feet: m g times the half distance of the feet, over the overhang; pushed: µ m g."""
    assembly = hf.assemble(hf.Scene([FLOOR, hf.Body("table", table(), mass=3, com=(0, 0, 0))], 0.5), gap=1e-4)
    down = hf.robustness(assembly, "table", [(0.5, 0, 0.095), (0, -0.3, 0.095)], (0, 0, -1), engine="limit")
    assert down.force == pytest.approx([3 * G * 0.4 / 0.1, 3 * G * 0.2 / 0.1], rel=1e-6)
    for engine in ("limit", "compliant"):
        (pushed,) = hf.robustness(assembly, "table", (0.5, 0, 0.045), (-1, 0, 0), engine=engine).force
        assert pushed == pytest.approx(min(0.5 * 3 * G, 3 * G * 0.4 / 0.045), rel=1e-4)


def test_a_compound_of_one_ball_is_like_the_ball() -> None:
    place = at(0.1, 0.2, 0.05)
    for shape in (hf.Sphere(0.05), hf.Ellipsoid((0.07, 0.06, 0.05)), hf.Capsule(0.02, 0.06)):
        (alone,) = patches(hf.Body("it", shape, mass=1, pose=place))
        part = hf.Part(shape, motion(5))
        (same,) = patches(hf.Body("it", hf.Compound([part]), mass=1, pose=place @ np.linalg.inv(motion(5))))
        assert same.polygon == pytest.approx(alone.polygon, abs=1e-9)
        assert same.separation == pytest.approx(alone.separation, abs=1e-12)


def test_bars_welded_by_a_plate_stand_as_two_separate_bars_would() -> None:
    """A sled of two lying capsules: the lines of the two bars alone, cut by nothing."""
    bars = [hf.Part(hf.Capsule(0.02, 0.3), at(0, y, 0.02, LYING)) for y in (-0.1, 0.1)]
    sled = hf.Body("sled", hf.Compound([*bars, hf.Part(hf.Box((0.2, 0.3, 0.02)), at(z=0.045))]), mass=2)
    alone = [hf.Body(f"bar{k}", bar.shape, mass=1, pose=bar.pose) for k, bar in enumerate(bars)]
    apart = [i.patches[0] for i in hf.assemble(hf.Scene([FLOOR, *alone], 0.5), gap=1e-4).interfaces]
    found = sorted(patches(sled), key=lambda patch: patch.polygon[0, 1])
    assert [patch.kind for patch in found] == ["line", "line"]
    for one, two in zip(found, apart, strict=True):
        assert one.polygon == pytest.approx(two.polygon, abs=1e-9)


def test_a_finger_of_capsules_presses_with_its_tip_on_a_box() -> None:
    """A fixed finger bent by 30 degrees over a box: it touches the top where the ball of its last capsule is lowest."""
    tilt = Rotation.from_euler("y", 30, degrees=True).as_matrix()
    tip = np.array([0.0, 0.0, 0.1 + 0.01])  # the middle of the last half ball
    low = hf.Part(hf.Capsule(0.01, 0.06), at(*(tip + tilt @ (0, 0, 0.03)), turn=tilt))
    high = hf.Part(hf.Capsule(0.01, 0.06), at(*(tip + tilt @ (0, 0, 0.06) + (0, 0, 0.03))))
    finger = hf.Body("finger", hf.Compound([low, high]), fixed=True)
    box = hf.Body("box", hf.Box((0.1, 0.1, 0.1)), mass=1, pose=at(z=0.05))
    (interface,) = (
        i for i in hf.assemble(hf.Scene([FLOOR, box, finger], 0.5), gap=1e-5).interfaces if "finger" in i.bodies
    )
    (patch,) = interface.patches
    assert patch.kind == "point"
    assert patch.polygon[0] == pytest.approx((0, 0, 0.1), abs=1e-9)
    assert patch.normal == pytest.approx((0, 0, 1), abs=1e-12)  # into the finger, the second body


@pytest.mark.parametrize("depth", [0.0, 5e-5])
def test_what_lies_inside_another_part_does_not_touch(depth: float) -> None:
    """A capsule lies through a block: it touches on either side of it, and in between the block does."""
    rod = hf.Part(hf.Capsule(0.02, 0.5), at(0, 0, 0.02 + depth, LYING))
    block = hf.Part(hf.Box((0.2, 0.1, 0.1)), at(z=0.05))
    found = patches(hf.Body("both", hf.Compound([rod, block]), mass=1))
    faces = [patch for patch in found if patch.kind == "face"]
    assert [patch.area for patch in faces] == pytest.approx([0.02], rel=1e-9)
    lines = sorted(sorted(patch.polygon[:, 0].tolist()) for patch in found if patch.kind == "line")
    if depth:
        assert np.allclose(lines, [(-0.25, -0.1), (0.1, 0.25)], atol=1e-9)
    else:  # on the bottom of the block is not inside it
        assert np.allclose(lines, [(-0.25, 0.25)], atol=1e-9)
    assert len(found) == len(faces) + len(lines)


def test_a_facet_of_a_round_part_is_no_flat_face() -> None:
    """A ball divided so coarsely that its facets meet at 42 degrees: no sharp edges for all that."""
    coarse = hf.Body("coarse", hf.Compound([hf.Sphere(0.1, 0), hf.Part(hf.Box((0.05,) * 3), at(0.3))]), fixed=True)
    surface = hf.Sphere(0.1, 0).surface
    normal, middle = surface.normals[0], surface.vertices[surface.faces[0]].mean(0)
    ball = hf.Body("ball", hf.Compound([hf.Sphere(0.01)]), mass=1, pose=at(*(middle + 0.01 * normal)))
    assert feet(coarse, ball, gap=1e-4, depth=1e-4, breadth=1e-5, angles=Angles(1, 1)) == []
    flat = hf.Body("flat", hf.Mesh(surface.vertices, surface.faces), fixed=True)
    assert len(feet(flat, ball, gap=1e-4, depth=1e-4, breadth=1e-5, angles=Angles(1, 1))) == 1


def test_a_ball_inside_a_block_makes_no_contact_of_its_own() -> None:
    block = hf.Part(hf.Box((0.2, 0.1, 0.1)), at(z=0.05))
    for z in (0.05, 0.0305):  # deep inside, and half a millimetre above the bottom
        ball = hf.Part(hf.Sphere(0.03), at(z=z))
        (patch,) = patches(hf.Body("both", hf.Compound([ball, block]), mass=1), gap=1e-3)
        assert patch.area == pytest.approx(0.02, rel=1e-9)


def test_two_round_parts_at_one_place_touch_once() -> None:
    """Capsules with a ball at each end, as humanoids are made of: the ball is the end of the capsule."""
    leg = [
        hf.Part(hf.Capsule(0.03, 0.4), at(z=0.23)),
        hf.Part(hf.Sphere(0.03), at(z=0.03)),
        hf.Part(hf.Sphere(0.03), at(z=0.43)),
    ]
    (patch,) = patches(hf.Body("leg", hf.Compound(leg), mass=1))
    assert patch.polygon == pytest.approx(np.zeros((1, 3)), abs=1e-9)


def test_a_flat_part_beside_a_ball_keeps_its_contact() -> None:
    """The peg lies where the tessellated ball seems to touch, too: it must not be taken for the ball."""
    peg = hf.Part(hf.Box((0.004, 0.004, 0.03)), at(0.008, 0, 0.015))
    found = patches(hf.Body("both", hf.Compound([hf.Part(hf.Sphere(0.03), at(z=0.03)), peg]), mass=1), gap=1e-3)
    assert sum(patch.area for patch in found) == pytest.approx(0.004**2, rel=1e-6)
    points = [patch.polygon[0] for patch in found if patch.kind == "point"]
    assert np.allclose(points, np.zeros((1, 3)), atol=1e-9)


def test_a_ball_between_flat_parts_of_another_body_touches_the_flat_ones_alone() -> None:
    """The floor has a bump of a ball: what lies on the floor beside it touches the floor as a plane."""
    bump = hf.Part(hf.Sphere(0.2), at(0.5, 0, -0.19))
    ground = hf.Body("ground", hf.Compound([hf.Part(hf.Box((2, 2, 0.5)), at(z=-0.25)), bump]), fixed=True)
    ball = hf.Body(
        "ball", hf.Compound([hf.Sphere(0.05), hf.Part(hf.Box((0.01, 0.01, 0.2)), at(z=0.1))]), mass=1, pose=at(z=0.05)
    )
    (interface,) = hf.assemble(hf.Scene([ground, ball], 0.5), gap=1e-4).interfaces
    (patch,) = interface.patches
    assert patch.polygon == pytest.approx(np.zeros((1, 3)), abs=1e-9)
    top = hf.assemble(hf.Scene([ground, ball.moved(at(0.5, 0, 0.06))], 0.5), gap=1e-4)
    assert [i.bodies for i in top.interfaces] == [("ground", "ball")]


@pytest.mark.parametrize("seed", range(12))
def test_mujoco_finds_the_same_contact(seed: int) -> None:
    """Bodies of three round geoms at random, the lowest of which touches the plane."""
    mujoco: Any = pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'holdfast-robotics[mujoco]'")
    rng = np.random.default_rng(seed)
    geoms = ""
    for kind, size in (("sphere", ".1"), ("capsule", ".05 .1"), ("ellipsoid", ".1 .07 .04")):
        place, turn = " ".join(map(str, rng.normal(size=3) / 10)), " ".join(map(str, rng.normal(size=4)))
        geoms += f'<geom type="{kind}" size="{size}" pos="{place}" quat="{turn}"/>'
    world = f'<geom name="floor" type="plane" size="1 1 1"/><body name="b"><freejoint/>{geoms}</body>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{world}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    data.qpos[3:7] = rng.normal(size=4)
    mujoco.mj_forward(model, data)  # which finds it deep in the floor, or not
    lowest = min([np.inf, *data.contact.dist.tolist()])
    data.qpos[2] = 1.0 if not np.isfinite(lowest) else -lowest
    for _ in range(60):  # down until the lowest geom is a hundredth of a millimetre deep
        mujoco.mj_forward(model, data)
        if data.ncon and min(data.contact.dist) <= 0:
            data.qpos[2] -= min(data.contact.dist) + 1e-5
            mujoco.mj_forward(model, data)
            break
        data.qpos[2] -= 0.02
    (interface,) = hf.assemble(hf.from_mujoco(model, data), gap=2e-5).interfaces
    (k,) = np.flatnonzero(data.contact.dist <= 2e-5)
    (patch,) = interface.patches
    assert patch.polygon[0] == pytest.approx(data.contact.pos[k], abs=1e-9)
    assert patch.separation[0] == pytest.approx(float(data.contact.dist[k]), abs=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_a_cart_stands_on_the_lines_of_its_wheels_in_any_frame(seed: int) -> None:
    """Wheels 0.03 m wide, rolled at random; pressed down beyond them it tips about the line of one axle."""
    move = motion(seed) if seed else np.eye(4)
    rng = np.random.default_rng(seed)
    axle = Rotation.from_euler("x", 90, degrees=True)
    wheels = [
        hf.Part(hf.Cylinder(0.05, 0.03), at(x, y, 0.05, (axle * Rotation.from_rotvec([0, 0, roll])).as_matrix()))
        for (x, y), roll in zip(FEET, rng.uniform(0, 6, 4), strict=True)
    ]
    shape = hf.Compound([hf.Part(hf.Box((1, 0.3, 0.05)), at(z=0.075)), *wheels])
    floor = hf.Body("floor", hf.Box((2, 2, 0.1)), pose=move @ at(z=-0.05), fixed=True)
    cart = hf.Body("cart", shape, mass=3, com=(0, 0, 0.07), pose=move)
    assembly = hf.assemble(hf.Scene([floor, cart], 0.5, gravity=move[:3, :3] @ (0, 0, -G)), gap=1e-4)
    (interface,) = assembly.interfaces
    assert [patch.kind for patch in interface.patches] == ["line"] * 4
    local = np.sort([((p.polygon - move[:3, 3]) @ move[:3, :3]).ravel() for p in interface.patches], axis=0)
    ends = np.sort([np.sort([(x, y - 0.015, 0), (x, y + 0.015, 0)], axis=0).ravel() for x, y in FEET], axis=0)
    assert np.sort(local.reshape(-1, 3), axis=0) == pytest.approx(np.sort(ends.reshape(-1, 3), axis=0), abs=1e-9)
    place = move[:3, :3] @ (0.5, 0, 0.1) + move[:3, 3]
    down = hf.robustness(assembly, "cart", place, move[:3, :3] @ (0, 0, -1), engine="limit")
    assert down.force == pytest.approx([3 * G * 0.4 / 0.1], rel=1e-6)


def test_two_dumbbells_touch_ball_on_ball() -> None:
    """The ends of the bars lie inside the balls, and the bars between them lie apart."""
    bar = hf.Part(hf.Capsule(0.01, 0.2))
    shape = hf.Compound([bar, *(hf.Part(hf.Sphere(0.03), at(z=z)) for z in (-0.1, 0.1))])
    turn = Rotation.from_euler("y", 90, degrees=True).as_matrix()
    one = hf.Body("one", shape, pose=at(turn=turn), fixed=True)
    two = hf.Body("two", shape, mass=1, pose=at(0, 0, 0.06, turn))
    (interface,) = hf.assemble(hf.Scene([one, two], 0.5), gap=1e-3).interfaces
    assert [patch.kind for patch in interface.patches] == ["point", "point"]
    places = sorted((patch.polygon[0] for patch in interface.patches), key=lambda place: float(place[0]))
    assert np.array(places) == pytest.approx(np.array([(-0.1, 0, 0.03), (0.1, 0, 0.03)]), abs=1e-9)
