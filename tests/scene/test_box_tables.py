"""Tables of boxes: columns, corners, masses, and what is wrong with them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scene_content import Load, loading

import holdfast as hf

HEAD = "name,size_x,size_y,size_z,x,y,z,mass,fixed\n"
TABLE = HEAD + "table,2,2,0.1,0,0,-0.05,,true\ncrate,0.1,0.2,0.2,0,0,0.1,4,\n"


load = loading("boxes.csv", friction=0.5)


def test_a_crate_on_a_table(load: Load) -> None:
    scene = load(TABLE)
    assert {body.name: body.fixed for body in scene.bodies} == {"table": True, "crate": False}
    push = hf.robustness(scene, "crate", (-0.05, 0, 0.15), (1, 0, 0))
    assert push.force == pytest.approx(4 * 9.81 * 0.05 / 0.15, rel=1e-3)


@pytest.mark.parametrize("between", [";", "\t", ","])
def test_corners_masses_by_density_and_a_turn(between: str, load: Load) -> None:
    content = "length;width;height;x_min;y_min;z_min;yaw\n0.4;0.2;0.1;0;0;0;0\n\n0.4;0.2;0.1;0;0;0.1;90\n"
    scene = load(content.replace(";", between), density=500, floor=True)
    assert [body.name for body in scene.movable] == ["box 1", "box 2"]
    assert scene.body("box 1").mass == pytest.approx(4)
    np.testing.assert_allclose(scene.body("box 1").box, ((0, 0, 0), (0.4, 0.2, 0.1)), atol=1e-12)
    np.testing.assert_allclose(scene.body("box 2").box, ((0.1, -0.1, 0.1), (0.3, 0.3, 0.2)), atol=1e-12)


NAMES = [
    "name,size_x,size_y,size_z,x,y,z,mass",
    "id,sx,sy,sz,x,y,z,weight",
    "label,SX,SY,SZ,cx,cy,cz,kg",
    "item,dx,dy,dz,pos_x,pos_y,pos_z,mass_kg",
    "name,length [m],width [m],height [m],x [m],y [m],z [m],mass [kg]",
    "name,size_x_m,size_y_m,size_z_m,x_m,y_m,z_m,m",
    "name,L,W,H,center_x,center_y,center_z,Weight (kg)",
    "box,width,depth,height,px,py,pz,mass",
    "name,size.x,size.y,size.z,position.x,position.y,position.z,mass",
]
OF_CORNERS = [
    "min_x,min_y,min_z",
    "xmin,ymin,zmin",
    "x0,y0,z0",
    "corner_x,corner_y,corner_z",
    "origin_x,origin_y,origin_z",
]


@pytest.mark.parametrize("names", NAMES)
def test_the_usual_names_of_columns_say_the_same(names: str, load: Load) -> None:
    scene = load(f"{names}\ncrate,0.1,0.2,0.3,1,2,0.15,4\n", floor=True)
    (body,) = scene.movable
    assert (body.name, body.mass) == ("crate", 4.0)
    np.testing.assert_allclose(body.box, ((0.95, 1.9, 0), (1.05, 2.1, 0.3)), atol=1e-12)
    assert scene.notes == ("lengths are taken as metres: a table has no units",)


@pytest.mark.parametrize("names", OF_CORNERS)
def test_the_usual_names_of_corners_say_the_same(names: str, load: Load) -> None:
    scene = load(f"id,name,sx,sy,sz,{names},mass\n7,crate,0.1,0.2,0.3,1,2,0,4\n", floor=True)
    np.testing.assert_allclose(scene.body("crate").box, ((1, 2, 0), (1.1, 2.2, 0.3)), atol=1e-12)
    assert "columns that are not read: id" in scene.notes


def test_millimetres_are_not_taken_as_metres(load: Load) -> None:
    with pytest.raises(hf.errors.SceneError, match="has no columns for a size among 'name', 'sx"):
        load("name,sx [mm],sy [mm],sz [mm],x,y,z,mass\na,100,100,100,0,0,0,1\n", floor=True)


def test_materials_and_columns_that_are_not_read(load: Load) -> None:
    content = TABLE.replace("fixed\n", "fixed,material,colour\n").replace("true\n", "true,oak,red\n")
    content = content.replace(",4,\n", ",4,,tin,blue\n")
    scene = load(content, friction=hf.Friction(pairs={("oak", "tin"): 0.3}))
    assert scene.mu("table", "crate") == 0.3
    assert "columns that are not read: colour" in scene.notes


@pytest.mark.parametrize(
    ("content", "options", "match"),
    [
        (TABLE, {"friction": None}, "boxes.csv: says nothing of friction; give friction="),
        ("a,b\n1,2\n", {}, r"boxes.csv:1: has no columns for a size among 'a', 'b'; begin the table with name,size_x"),
        ("dx,dy,dz\n1,2,3\n", {}, r"boxes.csv:1: has no columns for a place"),
        (TABLE.replace("0.2,0.2", "0.2"), {}, r"boxes.csv:3: has 8 columns of 9; needs one box a line"),
        (
            TABLE.replace("0.1,4", "0.1 m,4"),
            {},
            r"boxes.csv:3: z is '0.1 m'; needs a number, with a point for decimals",
        ),
        (TABLE.replace("0.2,0.2", "-0.2,0.2"), {}, r"boxes.csv:3: Box: size"),
        (TABLE.replace("crate", "table"), {}, r"boxes.csv:3: is the second box named 'table'"),
        (TABLE.replace(",4,", ",,"), {}, r"boxes.csv:3: has no mass; give a column mass, or density="),
        (TABLE.replace("true", "maybe"), {}, r"boxes.csv:2: fixed is 'maybe'; needs true or false"),
        (TABLE.replace("true", ""), {"density": 5}, r"nothing in it is fixed; give floor=True"),
        (TABLE, {"fixed": ["crat"]}, r"no box is named 'crat'; did you mean 'crate'"),
        (HEAD, {}, "has no boxes"),
        ("", {}, "has no columns for a size"),
        (HEAD.replace("name", "x"), {}, "two columns are named 'x'"),
    ],
)
def test_what_is_wrong_is_one_clear_error(content: str, options: dict[str, Any], match: str, load: Load) -> None:
    with pytest.raises(hf.HoldfastError, match=match) as caught:
        load(content, **options)
    assert "\n" not in str(caught.value)
