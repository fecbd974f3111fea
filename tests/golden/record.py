"""Golden answers: what holdfast answers to a fixed list of questions, as plain data (see tools/golden.py).

A topic is one file of answers: a shipped scene with all engines, or one kind of question over several scenes. Plain
data are dicts, lists, texts, whole numbers, truth values and floats, with "inf", "-inf" and "nan" for what JSON lacks.
"""

from __future__ import annotations

import hashlib
import json
import math
import warnings
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import holdfast as hf

FOLDER = Path(__file__).parent / "answers"
LOG = Path(__file__).parent / "CHANGES.md"  # a line for each time that answers were accepted, the newest one last

Plain = Any  # what json.dumps takes

# What a renaming touches: all that is not called by its public name below goes through these.


@cache
def assembled(scene: str) -> hf.answers.Assembly:
    """The assembly of a shipped scene."""
    return hf.assemble(hf.shipped_scene(scene))


def triangles(body: hf.Body) -> np.ndarray:
    """(f, 3, 3) corners of the triangles of a body's surface in the world, outward by the right hand."""
    surface = body.surface_world
    return np.asarray(surface.vertices[surface.faces])


def top_of(body: hf.Body) -> np.ndarray:
    """(3,) middle of the upper face of the body's box."""
    low, high = body.box
    return np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, high[2]])


# The questions

ENGINES = ("compliant", "limit", "graph")
PUSHES = 12
FEW = {"bonded_wall": 4}  # pushes where one by engine compliant takes a second
ASKED = {"bonded_wall": 2}  # bodies that are pushed, where every one takes engine graph some seconds; else four
SPACING = {  # [m] of the maps: some hundred points a scene at most
    "cube": 0.03,
    "stack": 0.045,
    "table": 0.07,
    "tall_table": 0.1,
    "wall2x2": 0.07,
    "slope": 0.045,
    "slope_two": 0.06,
    "cantilever": 0.065,
    "arch": 0.09,
    "v_groove": 0.03,
    "wedged": 0.03,
    "wedged_floor": 0.03,
    "tabletop": 0.05,
}
MAPPED = {"tabletop": ["upper_book", "coaster"]}  # where not all: curved ones have a cell for every facet
AWRY = 0.3  # [rad] off the axes of symmetry, where two mechanisms give way at once
EIGHT = [[math.cos(AWRY + k * math.pi / 4), math.sin(AWRY + k * math.pi / 4), 0.0] for k in range(8)]


def plain(value: Any) -> Plain:
    """``value`` as plain data."""
    if isinstance(value, Mapping):
        return {" | ".join(key) if isinstance(key, tuple) else str(key): plain(v) for key, v in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, str):
        return str(value)
    if value is None or isinstance(value, bool | np.bool_):
        return None if value is None else bool(value)
    if isinstance(value, int | np.integer):
        return int(value)
    number = float(value)
    return number if math.isfinite(number) else str(number)


def asked(question: Callable[[], Plain]) -> Plain:
    """The answer, or the class of the error: its text is nobody's contract."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hf.errors.HoldfastWarning)
        try:
            return question()
        except hf.HoldfastError as error:
            return {"error": type(error).__name__}


def fields(answer: object, *names: str) -> dict[str, Plain]:
    """These attributes of an answer."""
    return {name: plain(getattr(answer, name)) for name in names}


def pushes_on(scene: str) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """(body, points (n, 3), directions (n, 3)): straight and slanted, inward and outward, at middles of triangles."""
    rng = np.random.default_rng(20240 + sum(map(ord, scene)))
    bodies = assembled(scene).movable
    drawn: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    count = FEW.get(scene, PUSHES)
    chosen = rng.permutation(len(bodies))[: ASKED.get(scene, 4)]
    for k in range(count):
        body = bodies[chosen[k % len(chosen)]]
        corners = triangles(body)
        a, b, c = corners[rng.integers(len(corners))]
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        slant = rng.uniform(-1, 1, 3)
        direction = (-normal, slant - normal, slant, slant + normal)[(k // len(chosen)) % 4]
        drawn.setdefault(body.name, []).append(((a + b + c) / 3, direction))
    return [(name, *(np.array(v) for v in zip(*pairs, strict=True))) for name, pairs in drawn.items()]


def contacts_of(assembly: hf.answers.Assembly) -> Plain:
    """What was found to touch."""
    interfaces = [
        {
            "bodies": plain(i.bodies),
            "status": plain(i.status),
            "flags": plain(i.flags),
            "kinds": [plain(patch.kind) for patch in i.patches],
            "area": plain(i.area),
            "centroid": plain([patch.centroid for patch in i.patches]),
            "normal": plain([patch.normal for patch in i.patches]),
        }
        for i in assembly.interfaces
    ]
    return {
        "interfaces": interfaces,
        "mu": plain(assembly.mu),
        "mass": plain(assembly.mass),
        "com": plain(assembly.com),
        "occluded": plain(assembly.occluded),
        "overlaps": [plain(o.bodies) for o in assembly.overlaps],
    }


def stability_of(assembly: hf.answers.Assembly, **options: Any) -> Plain:
    """The verdict, the sum of the contact forces of every interface, the motion if it falls."""
    answer = hf.stability(assembly, **options)
    result = fields(
        answer, "claim", "status", "equilibrium_exists", "self_stress", "residual", "moving", "reason", "notes"
    )
    forces = answer.forces
    if forces is not None:
        result["nodes"] = len(forces.force)
        sums = np.zeros((len(assembly.interfaces), 3))
        np.add.at(sums, forces.interface, forces.force)
        result["contact_force"] = plain(sums)
        usage = np.zeros(len(assembly.interfaces))
        np.maximum.at(usage, forces.interface, forces.usage)
        result["contact_usage"] = plain(usage)
    if answer.mechanism is not None:
        result["mechanism"] = fields(answer.mechanism, "mode", "moving", "twists", "text")
    if answer.certificate is not None:
        result["certificate"] = fields(answer.certificate, "power", "violation")
    return result


def texts_of(mechanisms: Any) -> Plain:
    """The motions in words."""
    return ["" if m is None else m.text for m in mechanisms]


def robustness_of(assembly: hf.answers.Assembly, body: str, points: Any, ways: Any, **options: Any) -> Plain:
    """R with bounds and all that gives way."""
    answer = hf.robustness(assembly, body, points, ways, **options)
    names = ("body", "points", "directions", "claim", "force", "status", "lower", "upper", "moving", "mode", "notes")
    return fields(answer, *names) | {"mechanism": texts_of(answer.mechanism)}


def pushed(scene: str, **options: Any) -> Plain:
    """All pushes on a scene."""
    assembly = assembled(scene)
    return [asked(lambda b=b, p=p, e=e: robustness_of(assembly, b, p, e, **options)) for b, p, e in pushes_on(scene)]


def map_of(assembly: hf.answers.Assembly, spacing: float, **options: Any) -> Plain:
    """A map, its weakest point and those of its bodies."""
    m = hf.robustness_map(assembly, spacing=spacing, **options)
    arrays = ("points", "body", "force", "status", "lower", "upper", "moving", "mode")
    weakest = [{"body": plain(p.body), "force": plain(p.force)} for p in m.weakest_of_each_body()]
    hidden = {name: len(cells.points) for name, cells in m.hidden.items()}
    return {"count": len(m.force), "weakest": weakest, "hidden": hidden, "notes": plain(m.notes)} | fields(m, *arrays)


def standing_on(assembly: hf.answers.Assembly) -> list[hf.Load]:
    """A tenth of the total weight, slanted, and a moment, on the last movable body."""
    body = assembly.movable[-1]
    pull = 0.1 * assembly.weight
    return [hf.Load(body.name, top_of(body), (0.2 * pull, 0.1 * pull, -pull), (0.0, 0.0, 0.001 * pull))]


def scene_topic(scene: str) -> Plain:
    """All engines on one scene."""
    assembly = assembled(scene)
    result: dict[str, Plain] = {"contacts": contacts_of(assembly)}
    for engine in ENGINES:
        answers = {
            "stability": asked(lambda e=engine: stability_of(assembly, engine=e)),
            "pushes": pushed(scene, engine=engine),
        }
        if scene in SPACING:
            bodies, spacing = MAPPED.get(scene), SPACING[scene]
            answers["map"] = asked(lambda e=engine, b=bodies, s=spacing: map_of(assembly, s, bodies=b, engine=e))
        if scene != "bonded_wall":
            body, points, ways = pushes_on(scene)[0]
            answers["standing"] = asked(
                lambda e=engine, b=body, p=points, w=ways: robustness_of(
                    assembly, b, p, w, standing=standing_on(assembly), engine=e
                )
            )
        result[engine] = answers
    if scene != "bonded_wall":
        result["bounded"] = pushed(scene, engine="compliant", bounds=True)
    return result


def engines_topic() -> Plain:
    """Options of engines, and maps in which every point is solved."""
    cube, groove = assembled("cube"), assembled("v_groove")
    result: dict[str, Plain] = {
        f"table: {cone} of {sides}": pushed("table", engine=hf.Limit(cone, sides))
        for cone in ("inscribed", "circumscribed")
        for sides in (4, 8)
    }
    for engine in ENGINES:
        result[f"cube: {engine}, every point"] = map_of(cube, 0.04, engine=engine, accuracy=0.0)
        result[f"v_groove: {engine}, every point"] = map_of(groove, 0.04, engine=engine, accuracy=0.0)
    return result


def loads_topic() -> Plain:
    """Several loads at once, standing ones, on a support that accelerates."""
    names = ("claim", "factor", "status", "lower", "upper", "moving", "mode", "notes")
    result: dict[str, Plain] = {}
    for scene in ("cube", "table", "arch", "cantilever"):
        assembly = assembled(scene)
        first = assembly.movable[0]
        loads = [
            hf.Load(first.name, top_of(first), (3.0, 1.0, -0.5)),
            hf.Load(assembly.movable[-1].name, moment=(0.01, 0.02, 0.3)),
        ]
        for engine in ENGINES:
            result[f"{scene}: {engine}"] = asked(
                lambda a=assembly, n=loads, e=engine: fields(hf.load_factor(a, n, engine=e), *names)
            )
            result[f"{scene}: {engine}, accelerated"] = asked(
                lambda a=assembly, n=loads, e=engine: fields(
                    hf.load_factor(a, n, standing=standing_on(a), acceleration=(0.3, -0.2, 0.5), engine=e), *names
                )
            )
    return result


def transport_topic() -> Plain:
    """Accelerations of the carrier, level, tilted and turning; how fast a path may be driven."""
    arrays = ("directions", "claim", "acceleration", "status", "lower", "upper", "moving", "mode", "notes")
    turning = {
        "angular_acceleration": (0.0, 0.1, 0.4),
        "angular_velocity": (0, 0, 0.5),
    }
    result: dict[str, Plain] = {}

    def told(limits: hf.answers.TransportLimits) -> Plain:
        status = plain(limits.verdict.status)
        return fields(limits, *arrays) | {"mechanism": texts_of(limits.mechanism), "verdict": status}

    for scene in ("cube", "stack", "cantilever", "slope_two", "arch"):
        assembly = assembled(scene)
        for engine in ENGINES:
            result[f"{scene}: {engine}"] = asked(
                lambda a=assembly, e=engine: told(hf.transport_limits(a, EIGHT, engine=e))
            )
            result[f"{scene}: {engine}, turning"] = asked(
                lambda a=assembly, e=engine: told(
                    hf.transport_limits(
                        a,
                        EIGHT[::2],
                        tilt_degrees=np.degrees((0.03, -0.02, 0.0)),
                        standing=hf.sets.inertial_loads(a, pivot=(0.1, 0.0, 0.0), **turning),
                        engine=e,
                    )
                )
            )
    stack = assembled("stack")
    path = [[1.0, 0.5, 0.0], [0.0, -2.0, 0.3], [0.5, 0.0, -1.0]]
    limits = hf.transport_limits(stack, path, bounds=True)
    result["stack: along a path"] = told(limits) | {"speed": plain(hf.sets.safe_time_scale(path, limits, margin=0.1))}
    return result


def sets_topic() -> Plain:
    """Convex sets by what they contain, not by their facets, of which there are many alike."""
    rng = np.random.default_rng(7)
    result: dict[str, Plain] = {}

    def told(found: hf.answers.ConvexSet, reach: np.ndarray) -> Plain:
        ways = rng.standard_normal((40, len(found.box)))
        points = ways / np.linalg.norm(ways, axis=1)[:, None] * reach
        names = ("claim", "accuracy", "accuracy_wanted", "solves", "box", "units", "frame", "notes")
        counts = {"facets": len(found.inner[1]), "cuts": len(found.outer[1]), "corners": len(found.vertices)}
        return fields(found, *names) | {
            **counts,
            "usage": plain(found.usage(points)),
            "contains": plain(found.contains(points)),
        }

    for scene in ("cube", "table", "cantilever"):
        assembly = assembled(scene)
        found = hf.sets.sustainable_accelerations(assembly, accuracy=0.05)
        result[f"{scene}: accelerations"] = told(found, np.full(3, 3.0))
    cube = assembled("cube")
    reach = 0.3 * cube.weight * np.repeat([1.0, 0.2 * cube.size], 3)
    result["cube: wrenches"] = told(hf.sets.admissible_wrenches(cube, "cube", accuracy=0.3), reach)
    return result


def uncertainty_topic() -> Plain:
    """Derivatives, the worst of a box, samples."""
    result: dict[str, Plain] = {}
    derivatives = ("claim", "force", "lower", "upper", "d_mu", "d_mass", "d_com", "d_point", "moving")
    worst = ("claim", "force", "lower", "upper", "status", "nominal", "mu", "masses", "coms", "corners", "guarantee")
    samples = ("claim", "force", "status", "nominal", "stands", "undecided", "notes")
    for scene in ("table", "slope_two", "cantilever"):
        assembly = assembled(scene)
        body, points, ways = pushes_on(scene)[0]
        result[f"{scene}: sensitivity"] = [
            asked(lambda a=assembly, b=body, p=p, e=e: fields(hf.sets.sensitivity(a, b, p, e), *derivatives))
            for p, e in zip(points, ways, strict=True)
        ]
        mass = {body: (0.9 * assembly.scene.body(body).mass, 1.1 * assembly.scene.body(body).mass)}
        result[f"{scene}: worst case"] = asked(
            lambda a=assembly, b=body, p=points, e=ways, m=mass: fields(
                hf.sets.worst_case(a, b, p, e, mu_range=0.1, mass_range=m, com_range={b: (0.003, 0.002, 0.0)}), *worst
            )
        )
        for engine in ENGINES:
            result[f"{scene}: samples by {engine}"] = asked(
                lambda a=assembly, b=body, p=points, w=ways, e=engine: fields(
                    hf.robustness_under(
                        a,
                        b,
                        p,
                        w,
                        uncertain=hf.sets.Uncertain(pose_sigma=(0.0005, 0.1), mu_range=0.2, samples=3, seed=11),
                        engine=e,
                    ),
                    *samples,
                )
            )
    return result


def disassembly_topic() -> Plain:
    """Orders of removals, with the reasons for all bodies at the start, and the paper's table."""
    removal = ("body", "answer", "reason", "blockers", "moving", "lift", "hold")
    result: dict[str, Plain] = {}

    def told(d: hf.answers.Disassembly) -> Plain:
        names = ("claim", "order", "remaining", "reached", "proven", "fewest", "blocked")
        return fields(d, *names) | {
            "steps": [fields(step, *removal) for step in d.steps],
            "answers": [fields(answer, *removal) for answer in d.answers()],
            "paper": [fields(row, "body", "force", "weight", "removable") for row in d.paper_table()],
        }

    questions: list[tuple[str, str | None]] = [
        ("stack", None), ("table", None), ("wall2x2", None), ("wall2x2", "b0_1"), ("cantilever", None),
        ("arch", None), ("slope_two", None), ("tabletop", None),
    ]  # fmt: skip
    for scene, goal in questions:
        for engine in ENGINES:
            name = f"{scene}: {engine}" + ("" if goal is None else f", for {goal}")
            result[name] = asked(
                lambda s=scene, e=engine, g=goal: told(hf.disassembly_order(assembled(s), engine=e, goal=g))
            )
    return result


def placement_topic() -> Plain:
    """Where a box goes: every field but the times."""
    box = hf.Body("box", hf.Box((0.06, 0.05, 0.04)), mass=0.4)
    brick = hf.Body("brick", hf.Box((0.05, 0.05, 0.05)), mass=50)

    def told(p: hf.answers.Placement) -> Plain:
        result = fields(p, "claim", "status", "reason", "pose", "robustness", "attempts", "faults", "points", "normals")
        result["contacts"] = [{"bodies": plain(i.bodies), "area": plain(i.area)} for i in p.contacts]
        result["weakest"] = None if p.weakest is None else fields(p.weakest, "body", "force", "mode", "moving")
        result["candidates"] = [fields(c, "pose", "points", "fault", "robustness") for c in p.candidates]
        result["best"] = None if p.best is None else fields(p.best, "pose", "fault")
        return result

    cantilever, table = assembled("cantilever"), assembled("table")
    return {
        "cantilever": told(
            hf.plan_placement(
                cantilever,
                box,
                where=hf.Where(supports=["B", "C", "D"]),
                search=hf.Search(candidates=2, spacing=0.03, seed=3, solves=400),
                engine="graph",
            )
        ),
        "cantilever: too heavy": told(
            hf.plan_placement(
                cantilever,
                brick,
                where=hf.Where(supports=["C"], avoid=["floor"]),
                search=hf.Search(solves=4, seed=3),
                engine="graph",
            )
        ),
        "table": told(
            hf.plan_placement(
                table,
                box,
                where=hf.Where(box=[[-0.2, -0.1], [0.2, 0.1]]),
                search=hf.Search(spacing=0.04, solves=30, seed=5),
                engine="limit",
            )
        ),
    }


def without_topic() -> Plain:
    """Assemblies from which bodies were taken."""
    result: dict[str, Plain] = {}
    for scene, gone in (("stack", "cube3"), ("table", "leg_left"), ("wall2x2", "b0_0"), ("cantilever", "D")):
        rest = assembled(scene).without([gone])
        result[f"{scene} without {gone}"] = {"contacts": contacts_of(rest)} | {
            engine: asked(lambda r=rest, e=engine: stability_of(r, engine=e)) for engine in ENGINES
        }
    tabletop = assembled("tabletop")
    for body in tabletop.movable:
        result[f"tabletop without {body.name}"] = contacts_of(tabletop.without([body.name]))
    return result


TOPICS: dict[str, Callable[[], Plain]] = {
    **{f"scene_{name}": lambda name=name: scene_topic(name) for name in hf.sets.shipped_scenes()},
    "engines": engines_topic,
    "loads": loads_topic,
    "transport": transport_topic,
    "sets": sets_topic,
    "uncertainty": uncertainty_topic,
    "disassembly": disassembly_topic,
    "placement": placement_topic,
    "without": without_topic,
}


QUICK = (
    "scene_cube",
    "scene_table",
    "scene_cantilever",
    "scene_v_groove",
    "scene_slope",
    "loads",
    "transport",
    "without",
)


def recorded(topic: str) -> Plain:
    """The accepted answers."""
    return json.loads((FOLDER / f"{topic}.json").read_text(encoding="utf-8"))


def mark() -> str:
    """What the log calls the accepted answers by: the beginning of a hash of all of them."""
    digest = hashlib.sha256()
    for path in sorted(FOLDER.glob("*.json")):
        digest.update(f"{path.name}\n{path.read_text(encoding='utf-8')}".encode())
    return digest.hexdigest()[:16]


def as_text(data: Plain, indent: int = 0) -> str:
    """JSON with sorted keys, a list of numbers or texts on one line; floats as exact as repr."""
    pad = " " * (indent + 1)
    if isinstance(data, dict) and data:
        rows = [f"{pad}{json.dumps(k, ensure_ascii=False)}: {as_text(v, indent + 1)}" for k, v in sorted(data.items())]
        return "{\n" + ",\n".join(rows) + "\n" + " " * indent + "}"
    if isinstance(data, list) and any(isinstance(v, dict) for v in data):
        return "[\n" + ",\n".join(pad + as_text(v, indent + 1) for v in data) + "\n" + " " * indent + "]"
    return json.dumps(data, ensure_ascii=False)
