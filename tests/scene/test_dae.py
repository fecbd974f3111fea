"""COLLADA meshes: units, transformations and faces as the standard says, and one clear error for all else."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import holdfast as hf
from holdfast.base.arrays import Float
from holdfast.scene.meshes.read import triangles_of

CORNERS = "0 0 0 1 0 0 1 2 0 0 2 0 0 0 3 1 0 3 1 2 3 0 2 3"  # of a box of 1 by 2 by 3
QUADS = [str(k) for k in (0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7)]
TRIANGLES = " ".join(" ".join((a, b, c, a, c, d)) for a, b, c, d in np.array(QUADS).reshape(-1, 4))
VERTEX = '<input semantic="VERTEX" source="#v" offset="0"/>'
POLYLIST = f'<polylist count="6">{VERTEX}<vcount>{"4 " * 6}</vcount><p>{" ".join(QUADS)}</p></polylist>'
AXES = "".join(f'<param name="{axis}" type="float"/>' for axis in "XYZ")
Z_UP = "<up_axis>Z_UP</up_axis>"


def dae(node: str = '<instance_geometry url="#g"/>', faces: str = POLYLIST, asset: str = Z_UP, more: str = "") -> str:
    numbers = len(CORNERS.split())
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{asset}</asset>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="a" count="{numbers}">{CORNERS}</float_array>
<technique_common><accessor source="#a" count="{numbers // 3}" stride="3">{AXES}</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>{faces}</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node>{node}</node></visual_scene></library_visual_scenes>{more}
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>"""


def read(folder: Path, content: str) -> hf.Mesh:
    (folder / "part.dae").write_text(content)
    return hf.Mesh.from_file(folder / "part.dae")


def corners(mesh: hf.Mesh) -> Float:
    return np.array([mesh.surface.vertices.min(0), mesh.surface.vertices.max(0)])


TRIANGLE_LIST = f'<triangles count="12">{VERTEX}<p>{TRIANGLES}</p></triangles>'
SECOND = VERTEX.replace('"0"', '"1"')
WITH_NORMALS = f'<triangles count="12"><input semantic="NORMAL" source="#n" offset="0"/>{SECOND}<p>{{}}</p></triangles>'
POLYGONS = f'<polygons count="6">{VERTEX}{{}}</polygons>'


@pytest.mark.parametrize(
    "faces",
    [
        POLYLIST,
        TRIANGLE_LIST,
        WITH_NORMALS.format(" ".join(f"7 {k}" for k in TRIANGLES.split())),
        POLYGONS.format("".join(f"<p>{' '.join(QUADS[4 * k : 4 * k + 4])}</p>" for k in range(6))),
        POLYLIST.replace("4 4 4 4 4 4 ", "4 4 4 ").replace(" ".join(QUADS), " ".join(QUADS[:12]))
        + POLYLIST.replace("4 4 4 4 4 4 ", "4 4 4 ").replace(" ".join(QUADS), " ".join(QUADS[12:])),
        POLYLIST + '<lines count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1</p></lines>',
    ],
)
def test_faces_of_every_kind_are_the_same_box(faces: str, tmp_path: Path) -> None:
    mesh = read(tmp_path, dae(faces=faces))
    assert mesh.is_closed
    assert mesh.mass_properties.volume == pytest.approx(6.0, rel=1e-12)
    assert mesh.mass_properties.com == pytest.approx((0.5, 1, 1.5), abs=1e-12)


def test_each_list_of_faces_has_its_own_vertices(tmp_path: Path) -> None:
    """A second box of the same corners, three times as large along x, in the same geometry."""
    content = dae(faces="{0}" + POLYLIST + POLYLIST.replace("#v", "#w"))
    shifted = " ".join(str(float(word) * (3 if k % 3 == 0 else 1)) for k, word in enumerate(CORNERS.split()))
    source = re.search(r'<source id="s">.*?</source>', content, re.DOTALL).group()  # type: ignore[union-attr]
    second = source.replace('"s"', '"t"').replace(CORNERS, shifted)
    second += '<vertices id="w"><input semantic="POSITION" source="#t"/></vertices>'
    (tmp_path / "part.dae").write_text(content.replace("{0}", second))
    vertices, faces = triangles_of(tmp_path / "part.dae")
    assert np.ptp(vertices[faces[:12].ravel()], axis=0) == pytest.approx((1, 2, 3))
    assert np.ptp(vertices[faces[12:].ravel()], axis=0) == pytest.approx((3, 2, 3))


def test_units_become_metres_and_a_scale_comes_on_top(tmp_path: Path) -> None:
    asset = f'<unit name="inch" meter="0.0254"/>{Z_UP}'
    assert corners(read(tmp_path, dae(asset=asset)))[1] == pytest.approx(0.0254 * np.array([1, 2, 3]), rel=1e-12)
    twice = hf.Mesh.from_file(tmp_path / "part.dae", scale=(1, 1, 2))
    assert corners(twice)[1] == pytest.approx(0.0254 * np.array([1, 2, 6]), rel=1e-12)


def test_nodes_are_moved_turned_and_stretched_in_the_order_of_the_file(tmp_path: Path) -> None:
    """Turned by 90 degrees about z after it is stretched along x, then moved: the last one written acts first."""
    steps = "<translate>10 0 0</translate><rotate>0 0 2 90</rotate><scale>5 1 1</scale>"
    found = corners(read(tmp_path, dae(steps + '<instance_geometry url="#g"/>')))
    assert found == pytest.approx(np.array([(8, 0, 0), (10, 5, 3)]), abs=1e-12)
    inner = '<node><matrix>1 0 0 7 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#g"/></node>'
    found = corners(read(tmp_path, dae("<rotate>0 0 1 90</rotate>" + inner)))
    assert found == pytest.approx(np.array([(-2, 7, 0), (0, 8, 3)]), abs=1e-12)


def test_a_mirrored_node_keeps_its_outside_and_nodes_may_be_named_twice(tmp_path: Path) -> None:
    mirrored = read(tmp_path, dae('<scale>-1 1 1</scale><instance_geometry url="#g"/>'))
    assert corners(mirrored)[0] == pytest.approx((-1, 0, 0))
    assert mirrored.mass_properties.volume == pytest.approx(6.0)
    assert mirrored.report.flipped == 0
    library = '<library_nodes><node id="n"><instance_geometry url="#g"/></node></library_nodes>'
    both = '<node><translate>5 0 0</translate><instance_node url="#n"/></node><instance_node url="#n"/>'
    assert read(tmp_path, dae(both, more=library)).mass_properties.volume == pytest.approx(12.0)


def test_a_urdf_may_use_it(tmp_path: Path) -> None:
    (tmp_path / "part.dae").write_text(dae(asset=f'<unit meter="0.1"/>{Z_UP}'))
    (tmp_path / "part.urdf").write_text(
        '<robot name="part"><link name="base"><inertial><mass value="1"/></inertial><collision><geometry>'
        '<mesh filename="part.dae" scale="1 1 2"/></geometry></collision></link></robot>'
    )
    scene = hf.load_scene(tmp_path / "part.urdf", friction=0.5, floor=True)
    assert scene.body("part").box[1] == pytest.approx((0.1, 0.2, 0.6))


MANY = (
    "".join(f'<node id="n{k}">' + f'<instance_node url="#n{k + 1}"/>' * 10 + "</node>" for k in range(12))
    + '<node id="n12"><instance_geometry url="#g"/></node>'
)
ITSELF = '<library_nodes><node id="n"><instance_node url="#n"/></node></library_nodes>'
WRONG = {
    "y up": (dae(asset="<up_axis>Y_UP</up_axis>"), r"line:3: <up_axis>: says 'Y_UP'; programs disagree"),
    "no up": (dae(asset=""), "says no <up_axis>, which means Y_UP"),
    "document type": ('<!DOCTYPE COLLADA [<!ENTITY a "b">]>' + dae()[38:], "has a document type"),
    "no xml": ("<COLLADA><asset>", "is not XML"),
    "not collada": ("<robot/>", "is not <COLLADA>"),
    "another file": (dae('<instance_geometry url="other.dae#g"/>'), "names another file, 'other.dae#g'"),
    "web": (dae('<instance_geometry url="https://example.org/g"/>'), "names another file"),
    "not there": (dae('<instance_geometry url="#h"/>'), "refers to '#h'; needs a <geometry> of this file"),
    "no scene": (dae().replace("<scene>", "<extra>").replace("</scene>", "</extra>"), "has no <scene>"),
    "cut": (dae(faces=POLYLIST.replace("0 3 2 1", "0 3 2")), "has 23 corners; needs faces of at least 3, 24 in all"),
    "vertex": (dae(faces=POLYLIST.replace("7</p>", "8</p>")), "names vertex 8 of 8"),
    "negative": (dae(faces=POLYLIST.replace("7</p>", "-1</p>")), "names vertex"),
    "word": (dae(faces=POLYLIST.replace("7</p>", "x</p>")), "no number"),
    "fraction": (dae(faces=POLYLIST.replace("7</p>", "6.5</p>")), "no whole number"),
    "short": (dae().replace('count="8"', 'count="9"'), "reads 9 rows of 3 from 24 numbers"),
    "nan": (dae().replace(CORNERS, CORNERS.replace("2 3", "nan 3")), "part.dae"),
    "strips": (dae(faces=POLYLIST.replace("polylist", "tristrips")), "<tristrips>: is not read"),
    "skinned": (dae('<instance_controller url="#g"/>'), "<instance_controller>: is not read"),
    "itself": (dae('<instance_node url="#n"/>', more=ITSELF), "the limits are 50"),
    "many": (dae('<instance_node url="#n0"/>', more=f"<library_nodes>{MANY}</library_nodes>"), "the limits are"),
    "empty": (dae("<extra/>"), "holds no triangles"),
    "zero axis": (dae('<rotate>0 0 0 90</rotate><instance_geometry url="#g"/>'), "turns about a zero axis"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_one_clear_error(name: str, tmp_path: Path) -> None:
    content, match = WRONG[name]
    with pytest.raises(hf.errors.GeometryError, match=match) as caught:
        read(tmp_path, content)
    assert "part.dae" in str(caught.value)
    assert "\n" not in str(caught.value)
