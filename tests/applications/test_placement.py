"""Placement: what it promises of the pose, what it refuses, what its options do."""

from __future__ import annotations

import time
from dataclasses import fields
from functools import cache

import manifold3d
import numpy as np
import pytest

import holdfast as hf
from bench.scenes.placement_scenes import TABLE_II, TABLE_III
from holdfast.applications.placement.planner import planner
from holdfast.applications.resting_poses import StandingFaces
from holdfast.base.rigid import pose_from
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import about_y, at, box, floor

ENGINES = ("compliant", "limit", "graph", hf.Graph(isolated=True))


@cache
def cube_scene() -> hf.answers.Assembly:
    return hf.assemble(hf.Scene([floor(0.3, 0.3), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.5))


def plan(body: hf.Body | None = None, assembly: hf.answers.Assembly | None = None, **given) -> hf.answers.Placement:
    """A place for a small cube beside or on the larger one, unless other bodies are given."""
    kinds = {kind: {f.name for f in fields(kind)} for kind in (hf.Where, hf.sets.Approach, hf.Search)}
    values = [kind(**{name: given.pop(name) for name in names & given.keys()}) for kind, names in kinds.items()]
    return hf.plan_placement(assembly or cube_scene(), body or thing(), *values, **{"engine": "graph"} | given)


def thing(size=(0.05, 0.05, 0.05), mass=0.2, name="object"):
    return hf.Body(name, hf.Box(size), mass=mass)


@cache
def placed(name: str, engine: str = "graph", seed: int = 0) -> hf.answers.Placement:
    scene = {**TABLE_II, **TABLE_III}[name]()
    return hf.plan_placement(
        hf.assemble(scene.scene), scene.body, scene.where, scene.approach, hf.Search(seed=seed), engine=engine
    )


@pytest.mark.parametrize("engine", ENGINES, ids=("compliant", "limit", "graph", "isolated"))
def test_a_cube_on_a_cube(engine) -> None:
    p = plan(supports=["cube"], engine=engine)
    assert p.status is hf.Status.STABLE
    assert p.attempts >= 1
    assert p.pose[2, 3] == pytest.approx(0.125, abs=1e-6)
    assert np.abs(p.pose[:3, :3]).max(1) @ [0, 0, 1] == pytest.approx(1, abs=1e-9)  # a face is level
    assert [i.bodies for i in p.contacts] == [("cube", "object")]
    again = hf.robustness_map(p.assembly, engine=engine)
    assert p.robustness == again.weakest().force
    assert p.weakest.point == again.weakest().point
    assert hf.stability(p.assembly).status is hf.Status.STABLE


@pytest.mark.parametrize("name", [*TABLE_II, *TABLE_III])
def test_scenes_of_the_tables(name: str) -> None:
    """Touches what it must, overlaps nothing, stands: found again from the scene alone."""
    where = {**TABLE_II, **TABLE_III}[name]().where
    p = placed(name)
    assert p.status is hf.Status.STABLE, p.reason
    again = hf.assemble(p.assembly.scene)
    assert not again.overlaps
    assert hf.stability(again).status is hf.Status.STABLE
    touched = {other for i in again.interfaces if "object" in i.bodies for other in i.bodies} - {"object"}
    assert "floor" not in touched
    assert len(touched & set(where.supports)) >= where.least_supports
    separations = [abs(s) for i in p.contacts for patch in i.patches for s in patch.separation]
    assert max(separations) < p.assembly.tolerances.gap
    assert len(again.interfaces) == len(p.assembly.interfaces)


def test_the_same_seed_gives_the_same_pose() -> None:
    first, again, other = (plan(seed=s) for s in (3, 3, 4))
    assert (first.pose == again.pose).all()
    assert first.robustness == again.robustness
    assert (first.pose != other.pose).any()


def test_the_pose_of_the_object_does_not_matter() -> None:
    elsewhere = hf.Body("object", hf.Box((0.05, 0.05, 0.05)), mass=0.2, pose=pose_from(np.ones(3), np.ones(4)))
    one, two = (plan(body, seed=1) for body in (thing(), elsewhere))
    assert one.pose == pytest.approx(two.pose, abs=1e-12)


@pytest.mark.parametrize("region", [((-0.15, 0.06), (-0.05, 0.15)), ((-0.15, -0.15, 0.09), (0.15, 0.15, 0.11))])
def test_the_region_is_kept_to(region) -> None:
    low, high = np.array(region)
    for seed in range(2):
        p = plan(box=region, seed=seed)
        assert (p.pose[:2, 3] >= low[:2]).all()
        assert (p.pose[:2, 3] <= high[:2]).all()
        assert (p.points >= low[: len(low)] - 1e-12)[:, : len(low)].all() if len(low) == 3 else True
        assert p.pose[2, 3] == pytest.approx(0.125 if len(low) == 3 else 0.025, abs=1e-6)


def test_allowed_orientations_are_kept_to() -> None:
    slab = thing((0.08, 0.06, 0.02))
    upright = pose_from(np.zeros(3), about_y(np.pi / 2))[:3, :3]  # long side up
    for seed in range(2):
        assert abs(plan(slab, orientations=upright, seed=seed).pose[2, 0]) == pytest.approx(1, abs=1e-6)
        exact = plan(slab, orientations=upright, free_yaw=False, seed=seed)
        assert exact.pose[:3, :3] == pytest.approx(upright, abs=1e-6)


def test_supports_several_and_forbidden() -> None:
    blocks = [box(name, (0.08, 0.08, 0.08), 1, (x, 0, 0.04)) for name, x in (("left", -0.08), ("right", 0.08))]
    assembly = hf.assemble(hf.Scene([floor(), *blocks], 0.5))
    plank = thing((0.25, 0.04, 0.02))
    p = plan(plank, assembly, supports=["left", "right"], least_supports=2)
    assert {name for i in p.contacts for name in i.bodies} == {"left", "right", "object"}
    assert p.pose[2, 3] == pytest.approx(0.09, abs=1e-6)
    q = plan(plank, assembly, avoid=["left", "right"])
    assert {name for i in q.contacts for name in i.bodies} == {"floor", "object"}
    never = plan(plank, assembly, supports=["left"], avoid=["left"], solves=8)
    assert never.pose is None
    assert never.faults["touches what it must not"] > 0


def test_a_way_in_from_above() -> None:
    """Under a shelf there is room, but no way in from above."""
    shelf = hf.Body("shelf", hf.Box((0.2, 0.2, 0.01)), pose=pose_from(np.array([0, 0, 0.2]), np.eye(4)[0]), fixed=True)
    assembly = hf.assemble(
        hf.Scene([floor(0.2, 0.2), shelf, box("far", (0.02, 0.02, 0.02), 1, (0.09, 0.09, 0.01))], 0.5)
    )
    inside = plan(assembly=assembly, supports=["floor"])
    assert inside.pose[2, 3] == pytest.approx(0.025, abs=1e-6)
    from_above = plan(assembly=assembly, supports=["floor"], direction=(0, 0, -1), solves=30)
    assert from_above.pose is None
    assert sum(from_above.faults.values()) == from_above.attempts == 30


def test_the_best_of_several() -> None:
    one, best = (plan(thing((0.03, 0.03, 0.09)), candidates=count) for count in (1, 8))
    assert len(best.candidates) == 8
    keys = [candidate.rating.key for candidate in best.candidates]
    assert keys == sorted(keys, reverse=True)
    assert best.robustness >= one.robustness * (1 - 1e-9)  # equally good places differ by rounding
    assert (best.pose == best.candidates[0].pose).all()


def test_heavier_objects_shun_weak_points() -> None:
    """On the overhang of a table's slab a push of 98 N tips it: heavy things are put elsewhere, light ones need not."""
    assembly = hf.assemble(shipped_scene("table"))
    light, heavy = (
        planner(assembly, thing(mass=m), where=hf.Where(supports=["slab"]), engine="graph").support for m in (0.1, 30.0)
    )
    out = np.abs(light.points[:, 0]) > 0.205

    def share(support):
        return support.chance[out].sum() / out.mean()

    assert share(light) > 0.95
    assert share(heavy) < 0.35


@pytest.mark.parametrize("name", [pytest.param(k, marks=() if k == "slant" else pytest.mark.slow) for k in TABLE_III])
def test_the_isolated_map_leads_astray(name: str) -> None:
    """The strongest points that ``isolated`` knows of: many let the scene fall; fewer of those of ``compliant``."""
    scene = TABLE_III[name]()
    assembly = hf.assemble(scene.scene)
    fallen = {}
    for engine in (hf.Graph(isolated=True), hf.Compliant()):
        asked = planner(assembly, scene.body, scene.where, scene.approach, hf.Search(confirm=None), engine=engine)
        support, rng = asked.support, np.random.default_rng(0)
        strongest = np.flatnonzero(support.force >= np.quantile(support.force, 0.9, method="lower"))
        faults = [asked.attempt(rng, points=[k])[0].fault for k in rng.choice(strongest, 16)]
        fallen[engine.name, getattr(engine, "isolated", False)] = faults.count("does not stand with it")
    assert fallen["graph", True] >= 3
    assert fallen["compliant", False] <= 2


def test_too_large_an_object_gets_a_reason_and_the_nearest_try() -> None:
    """A cube of 0.1 m for a slot of 0.04 m."""
    scene = TABLE_II["S4"]()
    p = hf.plan_placement(
        scene.scene, thing((0.1, 0.1, 0.1)), scene.where, scene.approach, hf.Search(solves=15), engine="graph"
    )
    assert p.status is hf.Status.UNDECIDED
    assert p.pose is None
    assert p.robustness == 0
    assert p.attempts == 15
    assert "15 attempts" in p.reason
    assert p.best.fault in p.reason


def test_a_load_that_no_place_bears_gets_a_reason() -> None:
    """On a beam balanced on a narrow fulcrum nothing heavy stands but right above it, and there is no room there."""
    scene = TABLE_III["balance"]()
    p = plan(thing(mass=40), hf.assemble(scene.scene), supports=["left", "right"], avoid=["floor"], solves=12)
    assert p.pose is None
    assert "does not stand with it" in p.reason
    assert p.best.fault == "does not stand with it"
    assert p.best.pose.shape == (4, 4)


def test_a_spent_budget_is_told() -> None:
    p = plan(thing((2, 2, 2), 5), seconds=1e-9)
    assert p.pose is None
    assert "the time was used up" in p.reason
    assert p.attempts == 0


def test_no_point_in_the_region() -> None:
    p = plan(box=((5, 5), (6, 6)))
    assert p.pose is None
    assert "in the box" in p.reason


def test_an_unstable_scene_is_refused_with_the_verdict() -> None:
    over = box("over", (0.1, 0.1, 0.1), 1, (0.18, 0, 0.05))
    assembly = hf.assemble(hf.Scene([floor(0.3, 0.3), over], 0.5))
    p = hf.plan_placement(assembly, thing())
    assert p.status is hf.Status.UNSTABLE
    assert p.pose is None
    assert p.attempts == 0
    assert "does not stand" in p.reason
    assert "over" in p.reason


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"box": (1, 2)}, "low and high corner"),
        ({"supports": "cube"}, "list of names"),
        ({"supports": ["cub"]}, "did you mean 'cube'"),
        ({"least_supports": 3}, "no more than there are"),
        ({"apart": 0.01}, "ask place_all"),
        ({"orientations": np.eye(3) * 2}, "not rigid"),
        ({"weights": hf.sets.Weights}, "Weights"),
        ({"body": hf.Body("object", hf.Box((1, 1, 1)), fixed=True)}, "fixed"),
        ({"body": thing(name="cube")}, "another name"),
    ],
)
def test_bad_options_say_what_is_wrong(asked, words: str) -> None:
    with pytest.raises(hf.HoldfastError, match=words):
        plan(**asked)


def test_solves_bound_a_search_that_no_clock_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same seed and the same solves give the same answer on any machine, however slow it is."""
    search = {"solves": 20, "seed": 3, "spacing": 0.05}
    assert hf.Search(**search).limit is None
    assert hf.Search().limit == 60
    assert hf.Search(seconds=5, solves=20).limit == 5
    found = plan(**search)
    real, began = time.perf_counter, time.perf_counter()
    monkeypatch.setattr(time, "perf_counter", lambda: began + 1e6 * (real() - began))
    slow = plan(**search)
    assert (slow.pose == found.pose).all()
    assert slow.attempts == found.attempts <= 20


def test_faces_of_a_box_with_its_mass_to_one_side() -> None:
    body = hf.Body("b", hf.Box((0.2, 0.1, 0.06)), mass=1, com=(0, 0.04, 0))
    faces = StandingFaces(body).faces()
    assert len(faces) == 6
    by_normal = {tuple(np.round(face.normal).astype(int)): face for face in faces}
    assert by_normal[0, 0, -1].tilt == pytest.approx(np.arctan(0.01 / 0.03))
    assert by_normal[0, 1, 0].tilt == pytest.approx(np.arctan(0.03 / 0.01))
    assert by_normal[0, 0, -1].foot == pytest.approx([0, 0.04, -0.03])
    assert faces[0].tilt == max(face.tilt for face in faces)


@pytest.mark.parametrize(
    ("mass", "search", "stands"),
    [
        (1.5, hf.Search(mass_margin=0.2), True),
        (1.5, hf.Search(mass_margin=0.5), False),
        (1.8, hf.Search(), True),
        (1.85, hf.Search(), False),
    ],
)
def test_the_margin_makes_the_object_heavier(mass: float, search: hf.Search, stands: bool) -> None:
    """A plank of 1 kg juts out 0.1 m over a block; 0.05 m past the edge it carries 2 kg and not more.

    By default the object may be heavier by a tenth: 1.8 kg may be 1.98 kg, and 1.85 kg may be 2.035 kg.
    """
    block = hf.Body("block", hf.Box((0.2, 0.1, 0.1)), pose=at(0, 0, -0.05), fixed=True)
    plank = hf.Body("plank", hf.Box((0.4, 0.1, 0.02)), mass=1, pose=at(0, 0, 0.01))
    assembly = hf.assemble(hf.Scene([block, plank], 0.5))
    body = hf.Body("object", hf.Box((0.04, 0.04, 0.04)), mass=mass)
    asked = planner(assembly, body, where=hf.Where(supports=["plank"]), search=search, engine="graph")
    fault = "" if stands else "would not stand if it were heavier by the margin"
    assert asked.checks.fault(at(0.15, 0, 0.04))[0] == fault


@pytest.mark.parametrize("confirm", [None, "limit", "compliant"])
def test_a_pose_counts_only_where_the_second_engine_is_sure_as_well(confirm: str | None) -> None:
    """Beside a wedged cube, which engine ``graph`` finds stable, ``limit`` undecided and ``compliant`` unstable."""
    assembly = hf.assemble(hf.shipped_scene("wedged"))
    body = hf.Body("object", hf.Box((0.01, 0.01, 0.01)), mass=0.01)
    asked = planner(assembly, body, search=hf.Search(confirm=confirm), engine="graph")
    on_a_wall = asked.checks.fault(at(-0.075, 0, 0.255))[0]
    assert on_a_wall == ("" if confirm is None else "refused by the second engine")


@pytest.mark.parametrize(("lean", "fault"), [(12, ""), (8, "not in an allowed orientation")])
def test_an_object_leans_no_further_than_it_may(lean: float, fault: str) -> None:
    """On a plane that slopes by 10 degrees."""
    pitch = np.radians(10)
    plane = hf.Body("plane", hf.Box((0.4, 0.3, 0.02)), pose=at(0, 0, 0, about_y(pitch)), fixed=True)
    approach = hf.sets.Approach(orientations="upright", lean_degrees=lean)
    asked = planner(hf.assemble(hf.Scene([plane], 0.5)), thing(), None, approach)
    assert asked.checks.fault(at(*(0.035 * np.array([np.sin(pitch), 0, np.cos(pitch)])), about_y(pitch)))[0] == fault


@pytest.mark.parametrize(("x", "fault"), [(-0.03, ""), (0.0, "not on enough of the supports")])
def test_an_object_stands_on_its_supports_alone(x: float, fault: str) -> None:
    """Two blocks of one height side by side, of which the right one is not to be stood on (T5)."""
    pair = [
        hf.Body(name, hf.Box((0.1, 0.1, 0.1)), pose=at(x, 0, 0.05), fixed=True)
        for name, x in (("a", -0.05), ("b", 0.05))
    ]
    rest = hf.assemble(hf.Scene(pair, 0.5))
    asked = planner(rest, thing(), hf.Where(supports=["a"]), engine="graph")
    assert asked.checks.fault(at(x, 0, 0.125))[0] == fault


@pytest.mark.parametrize(
    ("height", "low", "high", "fits"),
    [
        (0.09, (-0.1, -0.01, 0.0), (0.1, 0.01, 0.1), True),
        (0.11, (-0.1, -0.01, 0.0), (0.1, 0.01, 0.1), False),
        (0.11, (-0.1, -0.01, 0.02), (0.1, 0.01, 0.1), True),
        (0.11, (-0.04, -0.01, 0.0), (0.04, 0.01, 0.1), True),
        (0.11, (0.0, -0.01, 0.0), (0.1, 0.01, 0.1), False),
        (0.09, (-0.06, -0.01, -0.02), (0.06, 0.01, 0.1), False),
    ],
    ids=["over low walls", "against high ones", "raised", "narrow", "to one side", "down beside it"],
)
def test_a_gripper_is_as_high_as_the_top_of_the_object(
    height: float, low: tuple[float, ...], high: tuple[float, ...], fits: bool
) -> None:
    """A block 0.06 m wide and 0.1 m high, with walls 2 cm from all its sides."""
    sides = [((0.02, 0.16, height), (s * 0.06, 0)) for s in (-1, 1)] + [
        ((0.1, 0.02, height), (0, s * 0.06)) for s in (-1, 1)
    ]
    walls = [hf.Body(f"w{k}", hf.Box(size), pose=at(*xy, height / 2), fixed=True) for k, (size, xy) in enumerate(sides)]
    rest = hf.assemble(hf.Scene([floor(), *walls], 0.5))
    approach = hf.sets.Approach(gripper=[low, high])
    asked = planner(rest, thing((0.06, 0.06, 0.1)), None, approach, engine="graph")
    assert asked.checks.fault(at(0, 0, 0.05))[0] == ("" if fits else "no room for the gripper")


def bracket() -> hf.Mesh:
    """A U lying open to one side: a box of 0.12 x 0.06 x 0.04 m with a notch; not convex."""
    notch = manifold3d.Manifold.cube((0.06, 0.04, 0.1), True).translate((0, 0.02, 0))
    mesh = (manifold3d.Manifold.cube((0.12, 0.06, 0.04), True) - notch).to_mesh64()
    return hf.Mesh(mesh.vert_properties[:, :3], mesh.tri_verts)


SHAPES = {"u": bracket(), "tin": hf.Cylinder(0.03, 0.09, 24), "ball": hf.Sphere(0.04, 2)}


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_any_shape(shape) -> None:
    """Also one that is not convex; a polyhedron of a ball rests on one of its triangles."""
    p = plan(hf.Body("object", shape, mass=0.3), supports=["cube"], avoid=["floor"])
    assert p.status is hf.Status.STABLE
    assert not hf.assemble(p.assembly.scene).overlaps
    lowest = (p.body.surface_world.vertices[:, 2]).min()
    assert lowest == pytest.approx(0.1, abs=2e-6)
