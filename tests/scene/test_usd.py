"""USD: units, axes, shapes, masses, materials, joints and layers of stages, against closed forms and UsdPhysics."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from scene_content import Load, loading

import holdfast as hf
from holdfast.scene.formats.surfaces import Surfaces

pxr = pytest.importorskip("pxr", reason="needs usd-core, of the extra usd")

HEAD = '#usda 1.0\n(\n    metersPerUnit = {}\n    kilogramsPerUnit = {}\n    upAxis = "{}"\n)\n'
GROUND = (
    'def Plane "ground" (prepend apiSchemas = ["PhysicsCollisionAPI", "MaterialBindingAPI"])\n'
    '{ uniform token axis = "%s"\n rel material:binding:physics = </rough> }\n'
    'def Material "rough" (prepend apiSchemas = ["PhysicsMaterialAPI"]) { float physics:staticFriction = 0.5 }\n'
)
API = '"PhysicsRigidBodyAPI", "PhysicsMassAPI", "PhysicsCollisionAPI", "MaterialBindingAPI"'


def stage(content: str, metres: float = 1, kilograms: float = 1, up: str = "Z") -> str:
    return HEAD.format(metres, kilograms, up) + GROUND % up + content


def prim(content: str = "", kind: str = "Cube", name: str = "a", at: str = "0, 0, 1", api: str = API) -> str:
    place = f"double3 xformOp:translate = ({at})\n uniform token[] xformOpOrder = [{{}}]\n"
    order = '"xformOp:translate"' + (
        "".join(f', "{op}"' for op in ("xformOp:orient", "xformOp:scale") if op in content)
    )
    bound = "rel material:binding:physics = </rough>"
    return f'def {kind} "{name}" (prepend apiSchemas = [{api}])\n{{ {place.format(order)} {bound}\n {content} }}\n'


def lines(content: str) -> str:
    """The content with a line break before every closing brace, as USD needs it after a property."""
    return content.replace(" }", "\n}\n")


load = loading("scene.usda", lines)


def test_units_and_the_axis_that_is_up(load: Load) -> None:
    """Centimetres, grams and y up: everything comes in metres and kilograms, with z up."""
    mass = "float physics:mass = 500\n float3 physics:diagonalInertia = (100, 200, 300)"
    content = prim(f"double size = 20\n {mass}", at="3, 40, 5")
    scene = load(stage(content, 0.01, 0.001, "Y"))
    body = scene.body("a")
    np.testing.assert_allclose(body.com_world, [0.03, -0.05, 0.40], atol=1e-15)
    assert body.shape == hf.Box((0.2, 0.2, 0.2))
    assert body.mass == pytest.approx(0.5, rel=1e-12)
    np.testing.assert_allclose(body.inertia_com, np.diag([1e-5, 2e-5, 3e-5]), rtol=1e-6, atol=1e-20)
    np.testing.assert_allclose(scene.body("ground").pose[:3, 2], [0, 0, 1], atol=1e-15)
    np.testing.assert_allclose(scene.gravity, [0, 0, -9.81], atol=1e-15)
    assert "y is up in the file: turned about x so that z is up" in scene.notes


def test_densities_are_in_the_units_of_the_stage(load: Load) -> None:
    """A decimetre cube of one gram a cubic centimetre."""
    body = load(stage(prim("double size = 10\n float physics:density = 1"), 0.01, 0.001, "Y")).body("a")
    assert body.mass == pytest.approx(1, rel=1e-12)
    np.testing.assert_allclose(body.inertia_com, np.eye(3) / 600, atol=1e-15)


def test_gravity_is_in_the_units_and_axes_of_the_stage(load: Load) -> None:
    gravity = "float physics:gravityMagnitude = 981\n vector3f physics:gravityDirection = (0, -4, 3)"
    scene = load(stage(f'def PhysicsScene "s" {{ {gravity} }}' + prim("float physics:mass = 1"), 0.01, 1, "Y"))
    np.testing.assert_allclose(scene.gravity, [0, -9.81 * 0.6, -9.81 * 0.8], atol=1e-12)


SHAPES = {
    "Cube": ("double size = 0.5", hf.Box((0.5, 0.5, 0.5))),
    "Sphere": ("double radius = 0.5", hf.Sphere(0.5)),
    "Cylinder": ("double radius = 0.5\n double height = 2", hf.Cylinder(0.5, 2)),
    "Capsule": ("double radius = 0.5\n double height = 2", hf.Capsule(0.5, 2)),
}


@pytest.mark.parametrize("kind", SHAPES)
def test_shapes_are_what_they_are(kind: str, load: Load) -> None:
    content, shape = SHAPES[kind]
    body = load(stage(prim(f"{content}\n float physics:density = 300", kind))).body("a")
    assert body.shape == shape
    assert body.mass == pytest.approx(300 * shape.mass_properties.volume, rel=1e-7)  # USD keeps single precision
    np.testing.assert_allclose(body.inertia_com, 300 * shape.mass_properties.inertia, rtol=1e-7, atol=1e-12)


def test_axes_and_scale(load: Load) -> None:
    scale = "float3 xformOp:scale = (2, 0.5, 0.5)\n float physics:mass = 1"
    lying = load(stage(prim(f'uniform token axis = "X"\n double radius = 1\n double height = 3\n {scale}', "Cylinder")))
    body = lying.body("a")
    np.testing.assert_allclose(body.box[1] - body.box[0], [6, 1, 1], atol=1e-3)  # inscribed sides
    np.testing.assert_allclose(body.inertia_com[0, 0], 0.5**2 / 2, rtol=1e-6)
    assert load(stage(prim(f"double radius = 1\n {scale}", "Sphere"))).body("a").shape == hf.Ellipsoid((2, 0.5, 0.5))
    with pytest.raises(hf.errors.SceneError, match=r"/a: is a Capsule with the scale \(2.0, 0.5, 0.5\)"):
        load(stage(prim(scale, "Capsule")))


def test_a_body_of_several_colliders_adds_their_masses(load: Load) -> None:
    inner = [
        prim("float physics:mass = 2", name="low", at="0, 0, 0", api=API.replace('"PhysicsRigidBodyAPI", ', "")),
        prim("float physics:density = 0.5", name="high", at="0, 0, 2", api=API.replace('"PhysicsRigidBodyAPI", ', "")),
    ]
    scene = load(stage(prim("".join(inner), "Xform", api='"PhysicsRigidBodyAPI"')))
    body = scene.body("a")
    assert isinstance(body.shape, hf.Compound)
    assert body.mass == pytest.approx(2 + 0.5 * 8, rel=1e-12)
    np.testing.assert_allclose(body.com_world, [0, 0, 1 + 2 * 4 / 6], atol=1e-12)
    across = (2 + 4) * 8 / 12 + 2 * 4 / 6 * 4
    np.testing.assert_allclose(np.diag(body.inertia_com), [across, across, (2 + 4) * 8 / 12], rtol=1e-12)


def test_a_mass_that_is_given_comes_first_with_its_centre_and_axes(load: Load) -> None:
    turned = "quatf physics:principalAxes = (0.5, 0.5, 0.5, 0.5)\n float3 physics:diagonalInertia = (1, 2, 4)"
    own = f"float physics:mass = 3\n point3f physics:centerOfMass = (0, 0.25, 0)\n {turned}"
    body = load(stage(prim(own))).body("a")
    assert (body.mass, body.com_body.tolist()) == (3.0, [0, 0.25, 0])
    np.testing.assert_allclose(body.inertia_com, np.diag([4, 1, 2]), atol=1e-12)  # x to y, y to z, z to x
    shifted = load(stage(prim(own.replace(turned, "")))).body("a")
    like = hf.Body("like", hf.Box((2, 2, 2)), mass=3, com=(0, 0.25, 0))
    np.testing.assert_allclose(shifted.inertia_com, like.inertia_com, rtol=1e-12)


def test_densities_of_materials_and_of_nothing(load: Load) -> None:
    content = stage(prim())
    dense = content.replace("staticFriction = 0.5", "staticFriction = 0.5\n float physics:density = 300")
    assert load(dense).body("a").mass == pytest.approx(2400, rel=1e-12)
    scene = load(content)
    assert scene.body("a").mass == pytest.approx(8000, rel=1e-12)
    assert "/a: density 1000 kg/m³, as nothing says it" in scene.notes
    assert load(content, density=10).body("a").mass == pytest.approx(80, rel=1e-12)


def test_friction_of_a_pair_is_the_least_unless_it_is_told(load: Load) -> None:
    smooth = (
        'def Material "smooth" (prepend apiSchemas = ["PhysicsMaterialAPI"]) { float physics:staticFriction = 0.25 }'
    )
    content = stage(smooth + prim("float physics:mass = 1").replace("</rough>", "</smooth>"))
    assert load(content).mu("a", "ground") == 0.25
    assert load(content, combine="mean").mu("a", "ground") == 0.375
    assert load(content, combine="product").mu("a", "ground") == 0.125
    bare = content.replace("rel material:binding:physics = </smooth>", "")
    with pytest.raises(hf.errors.SceneError, match="/a: has no physics material, so no friction; give friction="):
        load(bare)
    assert load(bare, friction=0.125).mu("a", "ground") == 0.125


TETRAHEDRON = (
    "point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]\n int[] faceVertexCounts = [3, 3, 3, 3]\n"
    "int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]\n float physics:density = 6\n"
)


def test_meshes_and_what_stands_for_them(load: Load) -> None:
    def approximated(kind: str, content: str = TETRAHEDRON) -> hf.Body:
        token = f'uniform token physics:approximation = "{kind}"'
        return load(stage(prim(f"{content} {token}", "Mesh"))).body("a")

    for kind in ("none", "convexDecomposition", "convexHull"):
        assert approximated(kind).mass == pytest.approx(1, rel=1e-12)
    assert approximated("boundingCube").mass == pytest.approx(6, rel=1e-12)
    assert approximated("boundingSphere").mass == pytest.approx(6 * 4 / 3 * np.pi * 0.75**1.5, rel=1e-12)
    left = TETRAHEDRON + 'uniform token orientation = "leftHanded"\n'
    turned = trimesh.Trimesh(approximated("none", left).shape.vertices, approximated("none", left).shape.faces)
    assert turned.volume == pytest.approx(-1 / 6)  # as the file winds them; the surface is wound outward later
    with pytest.raises(hf.errors.SceneError, match="has the approximation 'blob'"):
        approximated("blob")


def test_instances_are_bodies_of_their_own(load: Load) -> None:
    crate = prim("float physics:mass = 1", name="body", at="0, 0, 0")
    places = "".join(
        f'def Xform "i{k}" (instanceable = true\n references = </crate>)\n'
        f"{{ double3 xformOp:translate = (0, 0, {3 * k})\n"
        ' uniform token[] xformOpOrder = ["xformOp:translate"] }\n'
        for k in (1, 2)
    )
    scene = load(stage(f'class Xform "crate" {{ {crate} }}\n{places}'), friction=0.5)
    assert {body.name: body.com_world[2] for body in scene.movable} == {"i1/body": 3.0, "i2/body": 6.0}


def joint(kind: str, rest: str = "rel physics:body1 = </b>") -> str:
    return f'def {kind} "j" {{ rel physics:body0 = </a>\n {rest} }}\n'


def test_joints_weld_or_are_refused_by_name(load: Load) -> None:
    both = prim("float physics:mass = 1") + prim("float physics:mass = 3", name="b", at="0, 0, 5")
    welded = load(stage(both + joint("PhysicsFixedJoint")))
    assert [body.name for body in welded.movable] == ["a"]
    assert welded.body("a").mass == 4.0
    np.testing.assert_allclose(welded.body("a").com_world, [0, 0, 4], atol=1e-12)
    with pytest.raises(hf.errors.SceneError, match=r"/j: can move; .*/j \(PhysicsRevoluteJoint\).*; give rigid=True"):
        load(stage(both + joint("PhysicsRevoluteJoint")))
    assert load(stage(both + joint("PhysicsRevoluteJoint")), rigid=True).body("a").mass == 4.0
    to_world = load(stage(both + joint("PhysicsFixedJoint", "")))
    assert (to_world.body("a").fixed, to_world.body("b").fixed) == (True, False)


def test_what_is_kinematic_off_or_filtered(load: Load) -> None:
    kinematic = prim("bool physics:kinematicEnabled = true", name="k")
    off = prim("bool physics:rigidBodyEnabled = false", name="o", at="9, 0, 1")
    ghost = prim("bool physics:collisionEnabled = false", name="g", at="0, 9, 1")
    filtered = prim("rel physics:filteredPairs = </b>", api=f'{API}, "PhysicsFilteredPairsAPI"', at="0, 0, 5")
    scene = load(stage(kinematic + off + ghost + filtered + prim(name="b", at="0, 0, 9")))
    assert {body.name: body.fixed for body in scene.bodies} == {
        "ground": True,
        "k": True,
        "o": True,
        "a": False,
        "b": False,
    }
    assert scene.excluded == (("a", "b"),)
    assert "/g: has no collider, so it is left out" in scene.notes


def test_single_colliders_may_be_filtered(load: Load) -> None:
    cube = 'def Cube "{}" (prepend apiSchemas = [{}])\n{{ rel material:binding:physics = </rough>\n {} }}\n'
    own = '"PhysicsCollisionAPI", "MaterialBindingAPI"'
    left = cube.format("left", own, "")
    right = cube.format("right", own + ', "PhysicsFilteredPairsAPI"', "rel physics:filteredPairs = </b>")
    both = f'def Xform "a" (prepend apiSchemas = ["PhysicsRigidBodyAPI"])\n{{\n{left}{right} }}\n'
    scene = load(stage(both + prim(name="b", at="0, 0, 9")))
    assert scene.excluded == ((("a", 1), "b"),)


@pytest.mark.parametrize(
    ("rest", "excluded"),
    [
        ("rel physics:filteredGroups = </two>", [("a", "b")]),
        ("rel physics:filteredGroups = </one>", [("a", "c")]),
        ("rel physics:filteredGroups = </three>", []),  # which is not there
        ("rel physics:filteredGroups = </one>\n bool physics:invertFilteredGroups = true", [("a", "b")]),
        ('rel physics:filteredGroups = </two>\n string physics:mergeGroup = "x"', [("a", "b")]),
    ],
)
def test_collision_groups_exclude(rest: str, excluded: list[tuple[str, str]], load: Load) -> None:
    group = 'def PhysicsCollisionGroup "{}" {{ rel collection:colliders:includes = [{}]\n {} }}\n'
    groups = group.format("one", "</a>, </c>", rest) + group.format("two", "</b>", "")
    scene = load(stage(prim() + prim(name="b", at="0, 0, 5") + prim(name="c", at="0, 0, 9") + groups))
    expected = excluded + ([("b", "c")] if ("a", "b") in excluded else [])
    assert scene.excluded == tuple(expected)


def test_packages_and_binary_files_say_the_same(load: Load, tmp_path: Path) -> None:
    from pxr import Usd, UsdUtils

    scene = load(stage(prim("float physics:mass = 1")))
    Usd.Stage.Open(str(tmp_path / "scene.usda")).Export(str(tmp_path / "scene.usdc"))
    UsdUtils.CreateNewUsdzPackage(str(tmp_path / "scene.usdc"), str(tmp_path / "scene.usdz"))
    for suffix in ("usdc", "usdz"):
        other = hf.load_scene(tmp_path / f"scene.{suffix}")
        assert other.bodies == scene.bodies
        assert other.friction == scene.friction


def test_layers_are_composed_from_the_folder_alone(load: Load, tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    crate = prim(name="c", api='"PhysicsRigidBodyAPI", "PhysicsCollisionAPI"').replace("rel material:binding", "rel x")
    (tmp_path / "parts" / "crate.usda").write_text(lines(f'#usda 1.0\n(\n defaultPrim = "c"\n)\n{crate}'))
    named = 'def "c" (references = @{}@) {{ }}\n'
    assert load(stage(named.format("./parts/crate.usda")), friction=0.5).body("c").shape == hf.Box((2, 2, 2))
    outside = tmp_path.parent / "outside.usda"
    outside.write_text((tmp_path / "parts" / "crate.usda").read_text())
    with pytest.raises(hf.errors.SceneError, match=r"outside.usda', outside of the folder"):
        load(stage(named.format("../outside.usda")), friction=0.5)
    assert load(stage(named.format("../outside.usda")), friction=0.5, package={"x": tmp_path.parent}).body("c")
    (tmp_path / "parts" / "more.usda").write_text("#usda 1.0\n(\n subLayers = [@/etc/passwd@]\n)\n")
    with pytest.raises(hf.errors.SceneError, match=r"names '/etc/passwd', outside of the folder"):
        load(stage(named.format("./parts/more.usda")))
    with pytest.raises(hf.errors.SceneError, match="needs a path, file://"):
        load(stage(named.format("https://example.org/a.usd")))
    with pytest.raises(hf.errors.SceneError, match=r"none.usda: no such layer"):
        load(stage(named.format("./none.usda")))


OPEN = TETRAHEDRON.replace("[3, 3, 3, 3]", "[3, 3, 3]").replace(", 0, 3, 2]", "]")

WRONG: dict[str, tuple[str, str]] = {
    "half": ("#usda 1.0\n( doc = ", "scene.usda: is no USD"),
    "nothing": ("#usda 1.0\n", "nothing in it is fixed"),
    "negative units": (stage(prim(), -1), "metersPerUnit: is -1"),
    "units of nan": (
        stage(prim()).replace("PerUnit = 1", "PerUnit = nan"),
        "is nan|is no USD",
    ),
    "negative mass": (stage(prim("float physics:mass = -1")), "/a: physics:mass: is -1"),
    "negative density": (stage(prim("float physics:density = -1")), "/a: physics:density: is -1"),
    "negative size": (stage(prim("double size = -1\n float physics:mass = 1")), "Box: size: is"),
    "nan in a place": (stage(prim(at="nan, 0, 0")), "/a: matrix: contains nan"),
    "negative friction": (
        stage(prim()).replace("staticFriction = 0.5", "staticFriction = -1"),
        "staticFriction: is -1",
    ),
    "negative inertia": (
        stage(prim("float physics:mass = 1\n float3 physics:diagonalInertia = (1, 1, -1)")),
        "negative",
    ),
    "no metres": (stage(prim()).replace("PerUnit = 1\n    kilo", "PerUnit = </a>\n    kilo"), "is no USD: "),
    "no axis": (stage(prim('uniform token axis = "null"', "Capsule")), "/a: axis is 'null'; needs X, Y or Z"),
    "no number": (stage(prim('string physics:mass = "heavy"')), "/a: physics:mass is 'heavy'; needs a number"),
    "no relation": (stage(prim() + joint("PhysicsFixedJoint", "float physics:body1 = 1")), "is no USD: "),
    "flat": (stage(prim("float3 xformOp:scale = (1, 1, 0)")), "/a: is scaled to nothing"),
    "capsule of another kind": (
        stage(prim(kind="Capsule_1")),
        "/a: is a collider of the type 'Capsule_1'; reads .*Cone",
    ),
    "plane that moves": (stage(prim(kind="Plane")), "/a: is a plane in a body that moves"),
    "instancer": (stage('def PointInstancer "p" { }'), "/p: is a PointInstancer"),
    "no points": (stage(prim(kind="Mesh")), "/a: has no points"),
    "corners": (stage(prim(TETRAHEDRON.replace("[0, 2, 1,", "[9, 2, 1,"), "Mesh")), "names a point that is not there"),
    "counts": (stage(prim(TETRAHEDRON.replace("[3, 3, 3, 3]", "[3, 3, 3, 4]"), "Mesh")), "has 12 corners of 13"),
    "open mesh": (stage(prim(OPEN, "Mesh")), "watertight"),
    "joint to nothing": (stage(prim() + joint("PhysicsFixedJoint")), "/j: joins '/b', which is not there"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_one_clear_error(name: str, load: Load) -> None:
    content, match = WRONG[name]
    with pytest.raises(hf.HoldfastError, match=match) as caught:
        load(content)
    assert "scene.usda" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_reference_to_itself_ends(load: Load) -> None:
    assert load(stage('def "c" (references = @./scene.usda@</c>) { }' + prim())).body("a").mass == 8000


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"combine": "sum"}, "combine: is 'sum'; needs one of product, least"),
        ({"fixed": ["z"]}, "fixed: no body is named 'z'"),
        ({"fixed": "a"}, "fixed: is 'a'; needs a list"),
        ({"density": 0}, "density: is 0"),
        ({"friction": -1}, "friction: is -1"),
    ],
)
def test_options_are_checked(options: dict[str, object], match: str, load: Load) -> None:
    with pytest.raises(hf.errors.SceneError, match=match):
        load(stage(prim()), **options)


def test_of_two_rules_of_physx_the_later_one_counts() -> None:
    surfaces = Surfaces("least", sole=False)
    a, b, c = surfaces.material(0.5, "mean"), surfaces.material(0.4, "product"), surfaces.material(0.9)
    found = {frozenset(pair): mu for pair, mu in surfaces.pairs().items()}
    expected = {(a, a): 0.5, (a, b): 0.2, (a, c): 0.7, (b, b): 0.16, (b, c): 0.36, (c, c): 0.9}
    assert {pair: found[frozenset(pair)] for pair in expected} == pytest.approx(expected)
    assert Surfaces("least").material(0.5, "mean") == Surfaces("least").material(0.5)


def test_two_bodies_with_one_name_are_refused_by_their_prims(load: Load) -> None:
    """The path of a prim, which names it where names repeat, may be the display name of another."""
    twins = 'def Xform "g" {\n' + prim() + "}\n" + prim(at="3, 0, 1")
    named = prim(name="b", at="6, 0, 1").replace("prepend", 'displayName = "g/a"\n prepend')
    assert {"a", "g/a"} <= {body.name for body in load(stage(twins)).bodies}
    with pytest.raises(hf.errors.SceneError, match="is a body with the name 'g/a', as is another"):
        load(stage(twins + named))
