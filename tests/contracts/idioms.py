"""How the documentation tells users to write things: mypy checks it as users write it, a test runs every function.

Nothing here is annotated for mypy's sake and no error is silenced: what fails here fails for users.
"""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import holdfast as hf


def bodies() -> list[hf.Body]:
    """Sizes and poses from tuples, lists and arrays alike, whole numbers included."""
    pose = np.eye(4)
    pose[:3, 3] = (0.1, 0, 0.1)
    floor = hf.Body(
        "floor", hf.Box((1, 1, 0.1)), pose=[(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, -0.05), (0, 0, 0, 1)], fixed=True
    )
    vase = hf.Body("vase", hf.Cylinder(0.03, 0.2), mass=0.4, pose=pose, material="glass")
    tilted = hf.Body("brick", hf.Box([0.2, 0.1, 0.05]), density=2000, com=(0, 0, 0.001), inertia=np.eye(3) * 1e-3)
    ball = hf.Body("ball", hf.Sphere(0.05), mass=1, com=[0, 0, 0])
    block = hf.Body("block", hf.Box(np.array([0.1, 0.1, 0.1])), mass=1.0)
    wedge = hf.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
    return [floor, vase, tilted, ball, block, hf.Body("wedge", wedge, mass=1.0)]


def scenes() -> hf.Scene:
    """Friction as one number or as a table."""
    everywhere = hf.Friction(default=0.5)
    by_pair = hf.Friction(default=0.5, pairs={("glass", "floor"): 0.3})
    imported = hf.Friction(values={"floor": 0.4, "vase": 0.6}, combine="min")
    ground, vase, *_ = bodies()
    for friction in (everywhere, by_pair, imported):
        hf.Scene([ground, vase], friction)
    stool = hf.Body("stool", hf.Box((0.3, 0.3, 0.4)), mass=3, position=(0.5, 0, 0.2), rpy_degrees=(0, 0, 30))
    lamp = hf.Body("lamp", hf.Cylinder(0.1, 0.3), mass=1, pose=hf.pose(0.5, 0, 0.55, yaw=30))
    (hf.Scene([ground, vase], 0.5) + hf.Scene([ground, stool, lamp], 0.5)).without("vase", "lamp").tilted((0, 5, 0))
    return hf.Scene([ground, vase], 0.5, gravity=(0, 0, -9.81), name="shelf")


def moved_bodies() -> hf.Body:
    """A body elsewhere, from a pose as an array or as rows."""
    pose = np.eye(4)
    pose[:3, 3] = (0.2, 0, 0.1)
    vase = bodies()[1].moved(pose)
    return vase.moved([(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0.1), (0, 0, 0, 1)])


def files(folder: Path) -> hf.Scene:
    """Scenes by name, from files and to files; paths as text too."""
    names: tuple[str, ...] = tuple(hf.sets.shipped_scenes())
    scene = hf.shipped_scene(names[0])
    hf.save_scene(scene, folder / "copy.yaml")
    hf.save_scene(scene, str(folder / "copy.json"))
    return hf.load_scene(folder / "copy.yaml")


def contacts() -> hf.answers.Assembly:
    """Contacts found with tolerances of one's own, or given."""
    scene = hf.shipped_scene("cube")
    hf.assemble(scene, gap=0.001, angle_degrees=1)
    hf.assemble(scene, pose_sigma=0.001)
    hf.assemble(scene, pose_sigma=(0.001, 0.3))
    square = [(-0.05, -0.05, 0), (0.05, -0.05, 0), (0.05, 0.05, 0), (-0.05, 0.05, 0)]
    return hf.assemble(scene, interfaces=[hf.answers.Interface(("floor", "cube"), polygon=square, normal=(0, 0, 1))])


def edited_assemblies() -> hf.answers.Assembly:
    """An assembly with a body moved, taken out or put in."""
    assembly = hf.assemble(hf.shipped_scene("stack"))
    lower = assembly.without("cube3")
    cube = assembly.scene.body("cube3")
    assert cube.pose is not None
    return lower.with_body(cube).moved({"cube3": cube.pose})


def pushes() -> float:
    """One push or many; every array of the answer has a type."""
    assembly = hf.assemble(scenes())
    r = hf.robustness(assembly, body="vase", points=(0.07, 0, 0.15), directions=(1, 0, 0))
    hf.robustness(assembly, "vase", [(0.07, 0, 0.15), (0.13, 0, 0.15)], [(1, 0, 0), (-1, 0, 0)], engine="graph")
    hf.robustness(assembly, "vase", np.array([[0.07, 0, 0.15]]), [0, 0, -1], bounds=True, engine=hf.Limit())
    hf.robustness(
        assembly, "vase", [0.07, 0, 0.15], (1, 0, 0), standing=[hf.Load("vase", (0.1, 0, 0.2), force=(0, 0, -1))]
    )
    lower: NDArray[np.float64] = r.lower
    for force, status, mode, moving in zip(r.force, r.status, r.mode, r.moving, strict=True):
        print(f"{force:.2f} N, {status}, {mode} of {', '.join(moving)}")
    return float(lower[0])


def engines() -> list[hf.answers.Stability]:
    """Engines by name or with options, and verdicts under loads."""
    assembly = hf.assemble(hf.shipped_scene("table"))
    chosen = (
        hf.Graph(nodes=12),
        hf.Limit(cone="inscribed", sides=8),
        hf.Compliant(stiffness={("slab", "leg_left"): 3.0}),
    )
    verdicts = [hf.stability(assembly, engine=engine) for engine in chosen]
    s = hf.stability(assembly, loads=[hf.Load("slab", (0, 0, 0.25), force=(0, 0, -5))])
    if s.status is hf.Status.UNSTABLE and s.certificate is not None:
        print(s.certificate.power, s.moving)
    return [*verdicts, s]


def load_factors() -> float:
    """Several loads at once, or an acceleration of the support."""
    assembly = hf.assemble(hf.shipped_scene("table"))
    f = hf.load_factor(assembly, loads=[hf.Load("slab", (0, 0, 0.25), force=(1, 0, 0), moment=[0, 0, 0.1])])
    g = hf.load_factor(assembly, loads=[], acceleration=(1, 0, 0), standing=[hf.Load("slab", moment=(0, 0, 0.1))])
    return min(f.factor, g.factor)


def maps(folder: Path) -> str:
    """A map, its weakest point, and pictures."""
    m = hf.robustness_map(hf.shipped_scene("cube"), spacing=0.05)
    weak = m.weakest()
    finite = m.points[m.force < np.inf]
    print(f"{weak.body}: {weak.force:.2f} N, {weak.mode}, at {weak.point}; {len(finite)} points")
    m.save_png(folder / "map.png")
    m.save_html(folder / "map.html")
    m.save_glb(folder / "map.glb")
    m.save_ply(folder / "map.ply")
    return weak.body


def uncertain() -> float:
    """Samples of poses, and the worst over intervals."""
    assembly = hf.assemble(hf.shipped_scene("cube"))
    point, direction = (-0.05, 0, 0.05), (1, 0, 0)
    u = hf.robustness_under(
        assembly, "cube", point, direction, uncertain=hf.sets.Uncertain(samples=4, seed=0, pose_sigma=(0.001, 0.3))
    )
    w = hf.sets.worst_case(assembly, "cube", point, direction, mass_range={"cube": (0.9, 1.1)})
    s = hf.sets.sensitivity(assembly, "cube", point, direction)
    friction = hf.friction_from(
        assembly, [("cube", point, direction, 4.4), ("cube", point, direction, 5.1, False)], scatter=0.1
    )
    hf.sets.worst_case(assembly, "cube", point, direction, mu_range=friction.mu_range)
    hf.transport_under(assembly, direction, hf.sets.Uncertain(mu_range=friction.mu_range, mass_range=0.1, samples=4))
    low, middle = u.quantile((0.05, 0.5))
    print(low, middle, u.stands, s.force)
    return float(w)


def carriers(folder: Path) -> float:
    """Accelerations of what carries the scene."""
    assembly = hf.assemble(hf.shipped_scene("slope"))
    t = hf.transport_limits(
        assembly,
        [(1, 0, 0), (0, 1, 0)],
        standing=hf.sets.inertial_loads(assembly, angular_velocity=(0, 0, 1)),
        engine="limit",
    )
    safe = hf.sets.sustainable_accelerations(assembly)
    safe.save(folder / "safe.json")
    A, b = hf.load_answer(folder / "safe.json").inner
    hf.sets.admissible_wrenches(assembly, "cube1").contains(np.zeros(6))
    return float(t.acceleration.min() + (A @ (0, 0, 0) - b).max())


def constraints() -> NDArray[np.float64]:
    """How much of what a body can take many wrenches use, and where to go to use less."""
    c = hf.sets.constraint(hf.shipped_scene("cube"), "cube", solves=100, near=[(1, 0, 0, 0, 0, 0)])
    w = c.wrenches((-0.05, 0, 0.05), [(1, 0, 0), (2, 0, -1)])
    factor, used = c.value(w[0]), c.usage(w)
    print(factor, used)
    return c.gradient(w) + c.cut(w)


def orders_and_places() -> NDArray[np.float64]:
    """What may be lifted out, and where the next thing can stand."""
    assembly = hf.assemble(hf.shipped_scene("stack"))
    d = hf.disassembly_order(assembly, lift=(0, 0, 1), goal=["cube1"])
    print(d.order)
    p = hf.plan_placement(
        assembly, hf.Body("mug", hf.Cylinder(0.03, 0.08), mass=0.2), search=hf.Search(seed=1), engine="graph"
    )
    return np.eye(4) if p.pose is None else p.pose


def answers(folder: Path) -> str:
    """Scenes where assemblies are needed, answers to keep and to send elsewhere, one family of errors."""
    s = hf.stability(hf.shipped_scene("cube"))
    s.save(folder / "answer.json")
    again = hf.load_answer(folder / "answer.json")
    print(again, copy.deepcopy(s).status, pickle.loads(pickle.dumps(s)).status, s.to_dict()["status"])
    try:
        hf.shipped_scene("cubes")
    except hf.HoldfastError as error:
        return str(error)
    return ""
