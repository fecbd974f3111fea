"""The task of a worker: answer the question of one scene, as rows of the tables."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from holdfast.applications.transport import transport_limits
from holdfast.assembly.assembly import Assembly, assemble
from holdfast.base.arrays import Float
from holdfast.base.borders.worker import ANSWERED, ERROR, MEMORY
from holdfast.base.errors import HoldfastError, HoldfastWarning, message
from holdfast.base.files import noting_files
from holdfast.base.plugins import load_plugin
from holdfast.base.text import quoted
from holdfast.batches.at_rest import add_faults, add_rest, pose_row
from holdfast.batches.job import Digests, Job, Push, Touched, key_of_files
from holdfast.batches.states import scenes_of
from holdfast.batches.tables import TABLES, Row, Tables
from holdfast.engines.answers import Answers
from holdfast.engines.verdict import Status
from holdfast.queries.map import RobustnessMap, robustness_map
from holdfast.queries.push import Robustness, robustness
from holdfast.queries.stability import Stability, stability
from holdfast.scene.formats.registry import load_scene
from holdfast.scene.scene import Scene
from holdfast.scene.shipped import shipped_scene

Tell = Callable[[Tables], None]
_digests = Digests()  # of files that all states of a model share


def answered(job: Job, tell: Tell) -> Tables:
    """Answer the question of a scene and return its rows.

    ``tell`` is called with the rows so far as soon as the scene is read, and before each verb, in case the rest fails.
    An error of holdfast becomes the outcome of the scene, and earlier answers stay.
    """
    scenes: Row = {"number": job.number, "scene": job.name, "path": job.path}
    tables: Tables = {name: [] for name in TABLES} | {"scenes": [scenes]}
    with _warned() as warned:

        def so_far() -> Tables:
            scenes["warnings"] = warned()
            _sum_up(tables)
            where = {"number": job.number, "scene": job.name}
            return {name: [where | row for row in rows] for name, rows in tables.items()}

        try:
            _ask(job, lambda: tell(so_far()), tables)
            scenes["outcome"] = ANSWERED
        except HoldfastError as error:
            causes: list[BaseException | None] = [error]
            while (cause := causes[-1]) is not None:
                causes.append(cause.__cause__ or cause.__context__)
            lacks_memory = any(isinstance(cause, MemoryError) for cause in causes)
            scenes["outcome"], scenes["problem"] = (MEMORY if lacks_memory else ERROR), str(error)
        return so_far()


def warm(job: Job) -> None:
    """Import and load everything that a question needs, so that it does not count as time of a scene.

    Raises HoldfastError for a plug-in that is not that of the question.
    """
    for name, text in job.question.plugins.items():
        here = load_plugin(name)
        if here != text:
            problem = f"a worker has {here}, and not {text}"
            raise HoldfastError(message(f"plug-in {quoted(name)}", problem, "install the same version everywhere"))
    options = {name: own for name, own in job.question.options.items() if name not in ("load", "assemble")}
    asked = type(job.question)(job.question.verbs, options)
    push = Push("", "cube", (0.0, 0.0, 0.1), (1.0, 0.0, -1.0))
    answered(Job(0, "cube", asked, (push,), scene=shipped_scene("cube")), lambda _: None)


def _ask(job: Job, report: Callable[[], None], tables: Tables) -> None:
    """Read a scene and write its answers into ``tables``; answers so far stay there if an error is raised.

    ``report`` is called before each step that may take long.
    """
    scenes, question = tables["scenes"][0], job.question
    scene = _read(job, report, scenes)
    options = question.of("assemble")
    assembly = assemble(scene, **options) if job.state is None else scenes_of(job).assembly(scene, options)
    scenes |= {
        "bodies": len(assembly.movable),
        "fixed": len(assembly.fixed),
        "interfaces": len(assembly.interfaces),
        "groups": len(assembly.groups),
        "overlaps": len(assembly.overlaps),
        "mass": float(assembly.mass.sum()),
    }
    tables["bodies"] = bodies = [_body(assembly, k) for k in range(len(assembly.bodies))]
    tables["interfaces"] = _interfaces(assembly)
    for verb in question.verbs:
        report()
        match verb:
            case "stability":
                _add_verdict(stability(assembly, **question.of(verb)), tables)
                add_faults(assembly, tables["bodies"])
            case "settle":
                if not (scenes.get("status") == Status.STABLE and all(row.get("sinks") is None for row in bodies)):
                    add_rest(scene, question.of(verb), tables)
                else:
                    scenes |= {"settled": scenes["status"], "settled_reason": "stands as it is", "moved": 0.0}
            case "map":
                surfaces = robustness_map(assembly, **question.of(verb))
                tables["pushes"] += _push_rows("map", surfaces, surfaces.body.tolist(), -surfaces.normals)
            case "transport":
                limits = transport_limits(assembly, **question.of(verb))
                rows = _columns(limits.answers, "acceleration")
                directed = zip(limits.directions, rows, strict=True)
                tables["transports"] = [{**_vector("d", way), **row} for way, row in directed]
            case "push":
                known = {body.name for body in scene.bodies}
                by_body: dict[str, list[Push]] = {}
                for push in job.pushes:  # those for all scenes are skipped if this one has no such body
                    if push.scene or push.body in known:
                        by_body.setdefault(push.body, []).append(push)
                for body, pushes in by_body.items():
                    points, ways = ([getattr(p, name) for p in pushes] for name in ("point", "direction"))
                    found = robustness(assembly, body, points, ways, **question.of(verb))
                    tables["pushes"] += _push_rows("push", found, [body] * len(pushes), found.directions)


def _read(job: Job, report: Callable[[], None], scenes: Row) -> Scene:
    """Return the scene of a job; its key and files are written to its row even if it cannot be read."""
    if job.scene is not None:
        scenes |= {"key": job.key, "files": []}
        report()
        return job.scene
    touched = Touched() if job.state is None else scenes_of(job).touched
    try:
        if job.state is None:
            with noting_files(touched.note):
                scene = load_scene(job.place, **job.question.of("load"))
        else:
            scene = scenes_of(job).scene(job)
    finally:
        files = touched.relative_to(job.place)
        scenes |= {"key": key_of_files(job, files, _digests), "files": list(files)}
        report()
    try:
        touched.check()
    except HoldfastError:
        scenes["key"] = ""  # so that no later run reuses the row
        raise
    return scene


def _body(assembly: Assembly, k: int) -> Row:
    body = assembly.bodies[k]
    number = assembly.index[body.name]
    return {
        "body": body.name,
        "fixed": body.fixed,
        "mass": None if body.mass is None else float(body.mass),
        **pose_row(body.pose),
        "group": None if body.fixed else int(assembly.group_of[number]),
    }


def _interfaces(assembly: Assembly) -> list[Row]:
    return [
        {
            "a": interface.bodies[0],
            "b": interface.bodies[1],
            "status": interface.status,
            "certain": interface.certain,
            "flags": list(interface.flags),
            "mu": float(mu),
            "patches": len(interface.patches),
            "area": float(interface.area),
            "separation": interface.separation,
        }
        for interface, mu in zip(assembly.interfaces, assembly.mu, strict=True)
    ]


def _add_verdict(found: Stability, tables: Tables) -> None:
    """Write a verdict into the rows of the scene, its bodies and its interfaces."""
    tables["scenes"][0] |= {
        "status": found.status.value,
        "reason": found.reason,
        "equilibrium_exists": found.equilibrium_exists,
        "moving": list(found.moving),
        "crushed": list(found.crushed),
        "engine": found.engine,
        "notes": list(found.notes),
    }
    group_of = {name: group.verdict.status.value for group in found.groups for name in group.bodies}
    most = {one.body: one.share for one in reversed(found.bearing)}  # the largest share of a body comes last
    for row in tables["bodies"]:
        row["status"] = group_of.get(row["body"])
        row["bearing"] = most.get(row["body"])
    if found.forces is not None:
        normal = np.einsum("ik,ik->i", found.forces.force, found.forces.normal)
        for k, row in enumerate(tables["interfaces"]):
            own = found.forces.interface == k
            row["normal_force"] = float(normal[own].sum())
            row["usage"] = float(np.max(found.forces.usage[own], initial=0.0))  # the largest share of the limit


def _push_rows(source: str, found: Robustness | RobustnessMap, bodies: Sequence[str], ways: Float) -> list[Row]:
    return [
        {"source": source, "body": body, **_vector("", point), **_vector("d", way), **row}
        for body, point, way, row in zip(bodies, found.points, ways, _columns(found.answers, "force"), strict=True)
    ]


def _vector(prefix: str, values: Float) -> Row:
    return {prefix + name: float(v) + 0.0 for name, v in zip("xyz", values, strict=True)}


def _columns(answers: Answers, amount: str) -> list[Row]:
    return [
        {
            amount: float(answers.force[k]),
            "lower": float(answers.lower[k]),
            "upper": float(answers.upper[k]),
            "status": answers.status[k].value,
            "mode": answers.mode[k],
            "moving": list(answers.moving[k]),
        }
        for k in range(len(answers))
    ]


def _sum_up(tables: Tables) -> None:
    """Write the smallest answers and the number of undecided ones into the rows of the scene and its bodies."""
    scenes, pushes, transports = tables["scenes"][0], tables["pushes"], tables["transports"]
    decided = [row for row in pushes if row["status"] != Status.UNDECIDED]
    if decided:
        least = min(decided, key=lambda row: float(row["force"]))
        scenes |= {"weakest": least["force"], "weakest_body": least["body"]}
        scenes |= {"weakest_mode": least["mode"], "weakest_moving": least["moving"]}
    if pushes:
        scenes["weakest_lower"] = min(row["lower"] for row in pushes)
    ways = [row for row in transports if row["status"] != Status.UNDECIDED]
    if ways:
        scenes["acceleration"] = min(row["acceleration"] for row in ways)
    if transports:
        scenes["acceleration_lower"] = min(row["lower"] for row in transports)
    scenes["undecided"] = len(pushes) + len(transports) - len(decided) - len(ways)
    for body in tables["bodies"]:
        body["weakest"] = min((row["force"] for row in decided if row["body"] == body["body"]), default=None)


@contextmanager
def _warned() -> Iterator[Callable[[], list[str]]]:
    """Collect the warnings of holdfast in this block; the yielded function returns those so far, without duplicates."""
    with warnings.catch_warnings(record=True) as raised:
        warnings.simplefilter("always", HoldfastWarning)

        def so_far() -> list[str]:
            texts = [str(each.message) for each in raised if issubclass(each.category, HoldfastWarning)]
            return list(dict.fromkeys(texts))

        yield so_far
