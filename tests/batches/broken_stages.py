"""Stages that are right, or broken in one known way, and what the rule for USD validators must say of each.

Shipped and random scenes, written as stages, and stages by hand where holdfast writes none like them.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

import holdfast as hf
from holdfast.scene.shipped import shipped_scene

Expected = set[tuple[str, str]]  # severity and prim of each finding but notes
FAIL, WARN = "failure", "warning"
HEAD = '#usda 1.0\n(\n metersPerUnit = {}\n upAxis = "{}"\n defaultPrim = "World"\n)\n'
MATERIAL = (
    'def Material "rough" (prepend apiSchemas = ["PhysicsMaterialAPI"]) {{ float physics:staticFriction = {} \n}}\n'
)
GROUND = (
    'def Plane "ground" (prepend apiSchemas = ["PhysicsCollisionAPI", "MaterialBindingAPI"])\n'
    '{ uniform token axis = "%s"\n rel material:binding:physics = </World/rough> \n}\n'
)
BOX = (
    '{} "{}" ({} prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI", "PhysicsCollisionAPI"{}])\n'
    "{{ float physics:mass = 1\n double size = {}\n {}\n double3 xformOp:translate = ({})\n"
    ' uniform token[] xformOpOrder = ["xformOp:translate"]\n}}\n'
)


def box(name: str, at: str, size: float = 0.1, *, bound: bool = True, kind: str = "def Cube", more: str = "") -> str:
    """A cube of 1 kg with its centre ``at`` a place."""
    binding = "rel material:binding:physics = </World/rough>" if bound else ""
    return BOX.format(kind, name, more, ', "MaterialBindingAPI"' if bound else "", size, binding, at)


def text(content: str, metres: float = 1.0, up: str = "Z", mu: float = 0.5, ground: bool = True) -> str:
    plane = GROUND % up if ground else ""
    inside = MATERIAL.format(mu) + plane + content
    return HEAD.format(metres, up) + 'def Xform "World"\n{\n' + inside + "}\n"


def crates(*where: tuple[float, float], pitch: float = 0.0) -> hf.Scene:
    """Cubes of 0.1 m at (x, height of the foot) on a floor; the last one is turned."""
    cube = hf.Box((0.1, 0.1, 0.1))
    poses = [hf.pose(x=x, z=z + 0.05, pitch=pitch if k == len(where) - 1 else 0) for k, (x, z) in enumerate(where)]
    bodies = [hf.Body(f"crate{k}", cube, mass=1, pose=pose) for k, pose in enumerate(poses)]
    return hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), *bodies], 0.5)


def ladder(mu: float) -> hf.Scene:
    """A board of 1 m that leans by 30° against a wall, with its lowest edge on the floor and its upper one at the wall.

    A thin one stands if mu >= tan(30° / 2) = 0.268: the friction angle at both ends is at least half the lean.
    """
    lean, length, thick = np.radians(30), 1.0, 0.02
    high = (length * np.cos(lean) + thick * np.sin(lean)) / 2
    wide = (length * np.sin(lean) + thick * np.cos(lean)) / 2
    board = hf.Box((thick, 0.2, length))
    wall = hf.Body("wall", hf.Box((0.1, 1, 2)), fixed=True, pose=hf.pose(x=wide + 0.05, z=1))
    body = hf.Body("board", board, mass=2, pose=hf.pose(z=high, pitch=30))
    return hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), wall, body], mu)


def pile(seed: int, shift: float = 0.0, lift: float = 0.0) -> hf.Scene:
    """Six random boxes, one on the other, each with its centre well over the one below; the top one is displaced."""
    random = np.random.default_rng(seed)
    bodies, z = [hf.Body("floor", hf.HalfSpace(), fixed=True)], 0.0
    for k in range(6):
        size, at = random.uniform(0.1, 0.14, 3), random.uniform(-0.01, 0.01, 2)
        last = k == 5
        pose = hf.pose(x=at[0] + shift * last, y=at[1], z=z + size[2] / 2 + lift * last)
        bodies.append(hf.Body(f"box{k}", hf.Box(tuple(size)), mass=float(random.uniform(0.5, 2)), pose=pose))
        z += size[2]
    return hf.Scene(bodies, 0.5)


def saved(scene: hf.Scene) -> Callable[[Path], None]:
    return lambda path: hf.save_scene(scene, path)


def written(content: str, **others: str) -> Callable[[Path], None]:
    """Writes a stage by hand, and other layers into a folder beside its own."""

    def write(path: Path) -> None:
        path.write_text(content, encoding="utf-8")
        parts = path.parent.parent / "parts"
        parts.mkdir(exist_ok=True)
        for name, layer in others.items():
            (parts / f"{name}.usda").write_text(layer, encoding="utf-8")

    return write


def moved(scene: hf.Scene, name: str, dz: float) -> hf.Scene:
    return scene.moved({name: hf.pose(z=dz) @ scene.body(name).pose})


# A crate that hovers in a layer of its own, and one within an instance
PART = HEAD.format(1, "Z") + 'def Xform "World" {\n' + MATERIAL.format(0.5) + box("crate", "0, 0, 0.06") + "}\n"
ASSEMBLY = (
    f'class Xform "_pair"\n{{\n{box("inner", "0, 0, 0.055")}}}\n'
    'def "pair" (inherits = </World/_pair>\n instanceable = true)\n{\n}\n'
)
CRATE = box("_crate", "0, 0, 0.055", kind="class Cube")
INSTANCES = CRATE + "".join(
    f'def "c{k}" (inherits = </World/_crate>\n instanceable = true)\n{{ double3 xformOp:translate = ({k}, 0, {z})\n}}\n'
    for k, z in enumerate((0.05, 0.055))
)
REFERENCED = 'def "a" (references = @../parts/part.usda@</World>)\n{\n}\n'
JOINT = (
    'def PhysicsRevoluteJoint "hinge" {\n rel physics:body0 = </World/a>\n rel physics:body1 = </World/b>\n}\n'
    + box("a", "0, 0, 0.05")
    + box("b", "1, 0, 0.05")
)

TABLETOP = hf.Scene(shipped_scene("tabletop").bodies, 0.4)  # USD has no friction of pairs

PILE = ("tray", "mug", "coaster", "full_bottle")  # what touches each other there
SUNK = {(FAIL, "/World/mug"), (FAIL, "/World/coaster"), *((WARN, f"/World/{name}") for name in PILE)}

STAGES: dict[str, tuple[Callable[[Path], None], Expected]] = {
    "good_crates": (saved(crates((0, 0), (0, 0.1), (0.5, 0))), set()),
    "good_table": (saved(shipped_scene("table")), set()),
    "good_tabletop": (saved(TABLETOP), set()),
    "good_ladder": (saved(ladder(0.3)), set()),
    "good_pile": (saved(pile(1)), set()),
    "good_within_tolerance": (saved(crates((0, 0.0001))), set()),
    "good_centimetres_y_up": (written(text(box("a", "0, 5, 0", 10), 0.01, "Y")), set()),
    "nothing_that_moves": (written(text("")), set()),
    "hovers_110_mm": (saved(crates((0, 0), (1, 0.11))), {(FAIL, "/World/crate1")}),
    "hovers_5_mm": (saved(crates((0, 0.005))), {(FAIL, "/World/crate0"), (WARN, "/World/crate0")}),
    "hovers_in_pile": (saved(pile(2, lift=0.02)), {(FAIL, "/World/box5")}),
    "sunk_8_mm": (saved(crates((0, -0.008))), {(FAIL, "/World/crate0"), (WARN, "/World/crate0")}),
    "sunk_tabletop": (saved(moved(TABLETOP, "mug", -0.003)), SUNK),
    "over_an_edge": (saved(crates((0, 0), (0.06, 0.1))), {(FAIL, "/World/crate1")}),
    "over_an_edge_in_pile": (saved(pile(3, shift=0.1)), {(FAIL, "/World/box5")}),
    "leaning_on_nothing": (saved(crates((0, 0.006), pitch=8)), {(FAIL, "/World/crate0"), (WARN, "/World/crate0")}),
    "ladder_slips": (saved(ladder(0.2)), {(FAIL, "/World/board")}),
    "friction_missing": (written(text(box("a", "0, 0, 0.05", bound=False))), {(WARN, "/World/a")}),
    "collider_missing": (
        written(text(box("a", "0, 0, 0.05") + box("b", "1, 0, 0.05").replace(', "PhysicsCollisionAPI"', ""))),
        {(WARN, "/World/b")},
    ),
    "friction_huge": (written(text(box("a", "0, 0, 0.05"), mu=50)), {(WARN, "/")}),
    "density_huge": (written(text(box("a", "0, 0, 0.01", 0.02))), {(WARN, "/World/a")}),
    "huge_in_millimetres": (
        written(text(box("a", "0, 0, 50", 100) + box("b", "500, 0, 50", 100))),
        {(WARN, "/")},
    ),
    "instances": (written(text(INSTANCES)), {(FAIL, "/World/c1"), (WARN, "/World/c1")}),
    "within_an_instance": (written(text(ASSEMBLY)), {(FAIL, "/World/pair/inner"), (WARN, "/World/pair/inner")}),
    "referenced": (written(text(REFERENCED), part=PART), {(FAIL, "/World/a/crate"), (WARN, "/World/a/crate")}),
    "reference_lost": (written(text(REFERENCED.replace("part.", "gone.") + box("b", "1, 0, 0.05"))), {(WARN, "/")}),
    "centimetres_y_up": (
        written(text(box("a", "0, 5.8, 0", 10), 0.01, "Y")),
        {(FAIL, "/World/a"), (WARN, "/World/a")},
    ),
    "joint": (written(text(JOINT)), {(WARN, "/World/hinge")}),
    "no_floor": (written(text(box("a", "0, 0, 0.05"), ground=False)), {(WARN, "/")}),
}
