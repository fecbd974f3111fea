"""Try one input: ask what a user would ask of it, and tell how that ended."""

from __future__ import annotations

import base64
import tempfile
import traceback
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import holdfast as hf
from fuzz import judge, spoken
from fuzz.outcome import Ending, Outcome

Data = dict[str, Any]
PACKAGE = str(Path(hf.__file__).parent)


def tried(item: Data) -> Outcome:
    """Try an input of any kind; whatever is raised becomes an outcome."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", hf.errors.HoldfastWarning)
            warnings.filterwarnings("error", category=RuntimeWarning, module=r"holdfast\.")
            with tempfile.TemporaryDirectory() as folder:
                return TRIALS[item["kind"]](item, Path(folder))
    except MemoryError as error:
        return Outcome(Ending.MEMORY, place_of(error), repr(error)[:300])
    except hf.HoldfastError as error:
        return told(error)
    except Exception as error:
        lines = "".join(traceback.format_exception(error)[-6:])
        return Outcome(Ending.CRASH, f"{type(error).__name__} {place_of(error)}", lines[-1500:])


def warm() -> None:
    """Import and compile everything that a trial needs."""
    cube = {"scene": plain_cube(), "pushes": [{"body": "b", "place": [0, 0, 0], "direction": None, "graph": True}]}
    assert tried({"kind": "scene", **cube}).good
    for output in spoken.OUTPUTS:
        assert tried({"kind": "name", "name": "b", "output": output}).good


def plain_cube() -> Data:
    """A cube on a fixed one, in the native format."""
    shape = {"type": "box", "size": [1, 1, 1]}
    bodies = [
        {"name": "a", "shape": shape, "fixed": True},
        {"name": "b", "shape": shape, "mass": 1, "position": [0, 0, 1]},
    ]
    return {"format": "holdfast-scene/1", "friction": 0.5, "bodies": bodies}


def told(error: hf.HoldfastError) -> Outcome:
    """One of holdfast's own errors is a good ending, unless it hides a lack of memory or is unfit to print."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, MemoryError):
            return Outcome(Ending.MEMORY, place_of(error), repr(cause)[:300])
        cause = cause.__cause__ or cause.__context__
    unfit = spoken.unfit(str(error))
    if unfit:
        return Outcome(Ending.LEAK, f"{unfit} {place_of(error)}", ascii(str(error))[:300])
    return Outcome(Ending.TOLD, type(error).__name__, str(error)[:300])


def place_of(error: BaseException) -> str:
    """The innermost function of holdfast that an error came through, as module:function."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename.startswith(PACKAGE)]
    if not frames:
        return "outside"
    module = frames[-1].filename[len(PACKAGE) + 1 :].removesuffix(".py").replace("/", ".")
    return f"{module}:{frames[-1].name}"


def scene_trial(item: Data, folder: Path) -> Outcome:
    """Read, assemble and push, by engines that must agree; ask some again."""
    path = folder / "scene.json"
    path.write_text(spoken.json_text(item["scene"]))
    found = answers(path, item["pushes"])
    again = answers(path, item["pushes"]) if item.get("twice") else []
    broken: list[tuple[Ending, str, str]] = []
    for k, (weights, each) in enumerate(found):
        for answer in each:
            broken += [(Ending.NAN, name, "") for name in judge.nans(answer)]
            broken += [(Ending.CONTRADICTION, rule, text) for rule, text in judge.contradictions(answer)]
        limit, others = each[0], each[1:]
        for other in others:
            if other.claim is not hf.answers.Claim.ESTIMATED:
                broken += [(Ending.CONTRADICTION, rule, text) for rule, text in judge.between(limit, other, *weights)]
        if again:
            pairs = zip(each, again[k][1], strict=True)
            broken += [(Ending.CONTRADICTION, f"{a.engine} changed", "") for a, b in pairs if judge.changed(a, b)]
    if broken:
        ending, rule, text = broken[0]
        return Outcome(ending, rule, text)
    words = sorted({f"{answer.engine} {status}" for _, each in found for answer in each for status in answer.status})
    return Outcome(Ending.OK, "", ", ".join(words))


def answers(path: Path, pushes: list[Data]) -> list[tuple[tuple[float, float], list[hf.answers.Robustness]]]:
    """For each push the weights of all bodies and of the pushed one, and the answers of limit analysis and others."""
    scene = hf.load_scene(path)
    assembly = hf.assemble(scene)
    found = []
    for push in pushes:
        point, normal = surface_point(scene.body(push["body"]), push["place"])
        along = -normal if push["direction"] is None else np.array(push["direction"])
        engines = ("limit", "compliant", *(["graph"] if push.get("graph") else []))
        asked = [hf.robustness(assembly, push["body"], point, along, engine=engine) for engine in engines]
        own = float((scene.body(push["body"]).mass or 0.0) * np.linalg.norm(scene.gravity))
        found.append(((float(assembly.weight), own), asked))
    return found


def surface_point(body: hf.Body, place: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """A point of the surface and its outward normal, world frame, by numbers in 0..1."""
    surface = body.surface_world
    k = min(int(place[0] * len(surface.faces)), len(surface.faces) - 1)
    a, b, c = surface.vertices[surface.faces[k]]
    u, v = place[1:]
    if u + v > 1:
        u, v = 1 - u, 1 - v
    return a + u * (b - a) + v * (c - a), surface.normals[k]


def file_trial(item: Data, folder: Path) -> Outcome:
    """Read a file by its suffix, beside the files that it may refer to, and use what it gave."""
    for name, content in item.get("beside", {}).items():
        (folder / name).write_bytes(base64.b64decode(content))
    path = folder / f"input{item['suffix']}"
    path.write_bytes(base64.b64decode(item["content"]))
    return READERS[item["reader"]](path, **item.get("options", {}))


def read_scene(path: Path, **options: Any) -> Outcome:
    scene = hf.load_scene(path, **options)
    for body in scene.bodies:
        if not np.isfinite(body.surface_world.vertices).all():
            return Outcome(Ending.NAN, "vertices", body.name)
        if not body.fixed and not np.isfinite(np.append(body.com_world, body.inertia_com)).all():
            return Outcome(Ending.NAN, "mass properties", body.name)
    repr(scene)
    return Outcome(Ending.OK, "", f"{len(scene.bodies)} bodies")


def read_mesh(path: Path) -> Outcome:
    mesh = hf.Mesh.from_file(path)
    if not np.isfinite(mesh.surface.vertices).all():
        return Outcome(Ending.NAN, "vertices")
    found = mesh.mass_properties
    if not np.isfinite([found.volume, *found.com, *found.inertia.ravel()]).all():
        return Outcome(Ending.NAN, "mass properties")
    return Outcome(Ending.OK, "", f"{len(mesh.surface.faces)} triangles")


def read_answer(path: Path) -> Outcome:
    answer = hf.load_answer(path)
    repr(answer)
    answer.summary()
    answer.to_dict()
    return Outcome(Ending.OK, "", type(answer).__name__)


READERS: dict[str, Callable[..., Outcome]] = {"scene": read_scene, "mesh": read_mesh, "answer": read_answer}


def name_trial(item: Data, folder: Path) -> Outcome:
    """Give a body, its material and its scene a name, and write it to everything that names are written to."""
    for output, text in spoken.outputs(item["name"], folder, item["output"]):
        unfit = spoken.unfit(text, output)
        if unfit:
            return Outcome(Ending.LEAK, f"{unfit} in {output}", ascii(text)[:300])
    return Outcome(Ending.OK)


TRIALS: dict[str, Callable[[Data, Path], Outcome]] = {"scene": scene_trial, "file": file_trial, "name": name_trial}
