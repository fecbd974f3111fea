"""Planning scenes of MoveIt as text, as moveit_core writes them (planning_scene.cpp, shape_operations.cpp)."""

from __future__ import annotations

import numpy as np
import pytest
from scene_content import Load, loading

import holdfast as hf

TURNED = "0 0 0.7071067811865476 0.7071067811865476"  # by 90 degrees about z
PLAIN = "0 0 0 1"


def piece(shape: str, at: str = "0 0 0", turn: str = PLAIN) -> str:
    return f"{shape}\n{at}\n{turn}\n0 0 0 0\n"


def thing(name: str, at: str, *pieces: str, turn: str = PLAIN, frames: str = "0\n") -> str:
    return f"* {name}\n{at}\n{turn}\n{len(pieces)}\n{''.join(pieces)}{frames}"


TABLE = thing("table", "0 0 0.35", piece("box\n1.2 0.8 0.7"))
TETRAHEDRON = "mesh\n4 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 2 1\n0 1 3\n0 3 2\n1 2 3"


load = loading("kitchen.scene", friction=0.5, density=500, fixed=["table"])


def test_objects_are_bodies_at_their_poses(load: Load) -> None:
    mug = thing(
        "mug of tea",
        "0.1 0.2 0.75",
        piece("cylinder\n0.03 0.1", "0.2 0 0"),
        piece("sphere\n0.01", "0 0 0.1"),
        turn=TURNED,
        frames="1\nhandle\n0 0 1\n0 0 0 1\n",
    )
    scene = load(f"(noname)+\n{TABLE}{mug}.\n", mass={"mug of tea": 0.3}, density=None)
    assert {body.name: body.fixed for body in scene.bodies} == {"table": True, "mug of tea": False}
    body = scene.body("mug of tea")
    assert body.mass == pytest.approx(0.3)
    np.testing.assert_allclose(body.box, ([0.07, 0.19, 0.7], [0.13, 0.43, 0.86]), atol=1e-4)  # turned: x becomes y
    volumes = np.array([np.pi * 0.03**2 * 0.1, 4 / 3 * np.pi * 0.01**3])
    middle = volumes @ [[0.1, 0.4, 0.75], [0.1, 0.2, 0.85]] / volumes.sum()
    np.testing.assert_allclose(body.com_world, middle, atol=1e-3)
    assert scene.mu("table", "mug of tea") == 0.5


def test_meshes_and_masses_by_density(load: Load) -> None:
    scene = load(f"(noname)+\n{thing('corner', '0 0 0', piece(TETRAHEDRON))}.\n", fixed=(), floor=True)
    assert scene.body("corner").mass == pytest.approx(500 / 6)
    assert scene.body("floor").fixed


def test_files_of_older_versions_have_no_pose_of_the_object(load: Load) -> None:
    old = f"(noname)\n* table\n1\n{piece(chr(10).join(['box', '1.2 0.8 0.7']), '0 0 0.35')}.\n"
    boxes = [load(content).body("table").box for content in (old, f"(noname)+\n{TABLE}.\n")]
    np.testing.assert_allclose(*boxes, atol=1e-12)


@pytest.mark.parametrize(
    ("content", "options", "match"),
    [
        (TABLE, {"friction": None}, r"kitchen.scene: says nothing of friction; give friction="),
        (TABLE, {"fixed": ()}, r"nothing in it is fixed; give fixed=\[name\] \(table\), or floor=True"),
        (TABLE, {"fixed": (), "density": None, "floor": True}, "object 'table': has no mass; give mass= or density="),
        (TABLE, {"fixed": ["tabel"]}, "no object is named 'tabel'; did you mean 'table'"),
        (TABLE + TABLE, {}, r"kitchen.scene:12: holds '\* table'; needs .* a name that no other object has"),
        (TABLE.replace("box", "cone"), {}, "holds 'cone'; reads box, sphere, cylinder and mesh"),
        (TABLE.replace("1.2 0.8", "1.2"), {}, r"kitchen.scene:7: .*holds '1.2 0.7'; needs 3 finite numbers"),
        (TABLE.replace(PLAIN, "0 0 0 2", 1), {}, r"kitchen.scene:4: has a quaternion of another length"),
        (thing("table", "0 0 0"), {}, "'table', which has no shape"),
        (thing("table", "0 0 0", piece(TETRAHEDRON.replace("4 4", "4000000 4"))), {}, "needs 3 finite numbers"),
    ],
)
def test_what_is_wrong_is_one_clear_error(content: str, options: dict[str, object], match: str, load: Load) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        load(f"(noname)+\n{content}.\n", **options)


def test_a_file_that_was_cut_off_is_told(load: Load) -> None:
    with pytest.raises(hf.errors.SceneError, match="ends within an object; needs the whole text"):
        load(f"(noname)+\n{TABLE}")
