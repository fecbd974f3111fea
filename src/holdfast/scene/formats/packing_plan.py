"""Reads packing plans (.json): of py3dbp, of skjolber's 3d-bin-container-packing, and of the benchmark BED-BPP."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from contextlib import suppress
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import checked_number, checked_whole, checked_word
from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import SceneError, located, message
from holdfast.base.ranges import COORDINATES, PLACE, SCALE
from holdfast.base.text import listed, quoted
from holdfast.scene.body import Body
from holdfast.scene.formats.links import checked_fixed, not_read, pose_of, scene_of, unique, unknown_keys, with_floor
from holdfast.scene.formats.named_meshes import Numbers, Weights
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.source import Source
from holdfast.scene.friction import Friction
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box

Data: TypeAlias = Any  # plain data of a file

MOST_PLACED = 100_000  # boxes of one plan, as of a table; contact detection would take hours for more
APART = 1.0  # [m] between containers, which a plan does not place: far enough that nothing touches
# Which of width, height and depth lies along x, y and z, by py3dbp's rotation_type
TURNED = ((0, 1, 2), (1, 0, 2), (1, 2, 0), (2, 1, 0), (2, 0, 1), (0, 2, 1))
WIDTHS, LENGTHS = ("width", "height", "depth"), ("length/mm", "width/mm", "height/mm")
# Keys of boxes that are read, or do not matter; a note lists all others
KNOWN = {
    "py3dbp": ("name", "partno", *WIDTHS, "weight", "position", "rotation_type", "typeof", "level", "updown", "color",
               "number_of_decimals"),
    "skjolber": ("id", "name", "dx", "dy", "dz", "weight", "step", "plugins", "type", "boxItemKey", "groupId"),
    "BED-BPP": ("article", "id", "product_group", *LENGTHS, "weight/kg", "sequence"),
}  # fmt: skip


class PlacedBox(NamedTuple):
    """A box of a plan: where the file has it, its name, its size and centre [m], and its mass [kg] if it is said."""

    where: str
    name: str
    size: list[float]
    centre: list[float]
    mass: float | None


def sniff(source: Source) -> bool:
    """Tell whether the file is JSON of a packing plan, by the keys of its outermost maps."""
    return _program(source.data) is not None


def _program(data: Data) -> str | None:
    """Return which program writes plans that begin like this one."""
    first = data[0] if isinstance(data, list) and data else data
    if not isinstance(first, dict) or not first:
        return None
    if isinstance(first.get("bins"), list) or {"items", "unfitted_items"} <= first.keys():
        return "py3dbp"
    results = first.get("results")
    result = results[0] if isinstance(results, list) and results else first
    if isinstance(result, dict) and isinstance(result.get("containers"), list):
        return "skjolber"
    plan = next(iter(first.values()))
    action = plan[0] if isinstance(plan, list) and plan else None
    return "BED-BPP" if isinstance(action, dict) and "flb_coordinates" in action else None


def read(
    source: Source,
    *,
    friction: Friction | float | None = None,
    density: Numbers | None = None,
    mass: Numbers | None = None,
    fixed: Collection[str] = (),
    floor: bool = True,
    scale: float | None = None,
    up_axis: Literal["y", "z"] = "z",
    gravity: ArrayLike = (0.0, 0.0, -9.81),
) -> Scene:
    """Return the scene of a plan: a box for each item that was placed, on the bottom of its container, z = 0.

    Read are a ``Packer``, a ``Bin`` or a list of those of py3dbp and its forks, as ``json.dumps(packer, default=...)``
    writes their attributes, the file of skjolber's visualizer, and packing plans of BED-BPP. ``scale`` [m] is the unit
    of lengths: without it a metre, in BED-BPP a millimetre. Weights are in kg; ``mass`` [kg] and ``density`` [kg/m³]
    are for boxes without one. ``up_axis`` is the axis of the plan that points up, and ``fixed`` names boxes that never
    move. Without ``floor`` the containers have no bottom.

    Raises SceneError or GeometryError if the plan is malformed, or if friction or a mass is missing.
    """
    where, program = str(source.path), str(_program(source.data))
    if friction is None:
        raise SceneError(message(where, "says nothing of friction", "give friction="))
    unit = 1e-3 if program == "BED-BPP" else 1.0  # [m]; its keys say millimetres
    notes = ["the plan says no units: lengths are taken as metres"] if scale is None and unit == 1 else []
    unit = unit if scale is None else checked_number(scale, "scale", above=0, within=SCALE)
    axes = (0, 2, 1) if checked_word(up_axis, ("y", "z"), "up_axis") == "y" else (0, 1, 2)
    boxes = _boxes(source.data, program, where, unit, axes, notes)
    names = unique(box.name for box in boxes)
    weights, fixed_names = Weights(mass, density, names), checked_fixed(fixed, names, "box")
    bodies = []
    for box, name in zip(boxes, names, strict=True):
        weight = (None, None) if name in fixed_names else weights.of(name, (box.mass, None))
        if weight == (None, None) and name not in fixed_names:
            raise SceneError(message(box.where, "has no mass", "give density= or mass="))
        with located(box.where):
            pose = pose_of(box.centre, (0, 0, 0))
            bodies.append(Body(name, Box(np.array(box.size)), *weight, pose=pose, fixed=name in fixed_names))
    notes.append(f"{up_axis} is taken as up, and z = 0 as the bottom of all containers; their walls are left out")
    remedy = f"leave floor= out, or give fixed=[name] ({listed(names)})"
    return scene_of(with_floor(bodies, floor, where, remedy), friction, gravity, source.path.stem, notes)


def _boxes(data: Data, program: str, where: str, unit: float, axes: Sequence[int], notes: list[str]) -> list[PlacedBox]:
    """Return all boxes of a plan; containers stand beside each other along x. Adds to the notes."""
    with foreign(where, f"is no packing plan of {program}", "docs/reference/formats.md says what is read"):
        containers = list(_containers(data, program))
        placed = sum(len(items) for _, _, items in containers)
        left = sum(len(each.get("unfitted_items", ())) for each in _bins(data)) if program == "py3dbp" else 0
    if not 0 < placed <= MOST_PLACED:
        raise SceneError(message(where, "has no placed boxes, or too many", f"needs 1 to {MOST_PLACED:,}"))
    found, beyond = list[PlacedBox](), list[str]()
    start, unknown, several = 0.0, Counter[str](), len(containers) > 1
    for name, length, items in containers:
        ends = [length]
        for number, item in enumerate(items, 1):
            here = f"{where}: {quoted(name)}: box {number}"
            with located(here), foreign(here, f"is no box of {program}", "needs a size and a place"):
                box, corner, size = _placed(item, program)
                weight = box.get("weight/kg" if program == "BED-BPP" else "weight")
                mass = None if weight is None else _number(weight, "weight")
                unknown.update(unknown_keys(box, KNOWN[program], "boxes"))
                unknown.update(["the roundness of cylinders"] if box.get("typeof") == "cylinder" else [])
            own = next((str(box[key]) for key in ("partno", "article", "name", "id") if box.get(key)), f"box {number}")
            low, lengths = ([unit * row[axis] for axis in axes] for row in (corner, size))
            centre = [start * (axis == 0) + low[axis] + lengths[axis] / 2 for axis in range(3)]
            found.append(PlacedBox(here, f"{name}/{own}" if several else own, lengths, centre, mass or None))
            ends.append(corner[0] + size[0])
        if 0 < length < max(ends) * (1 - COORDINATES):  # as py3dbp's first bins without distribute_items=True
            beyond.append(name)
        start += unit * max(ends) + APART
    notes += [f"items that fit nowhere are left out, {left} of them"] if left else []
    notes += [f"{len(containers)} containers stand beside each other, {APART:g} m apart"] if several else []
    notes += [f"boxes reach beyond their container along x, in {listed(beyond)}: are they placed right?"][: len(beyond)]
    notes += not_read(unknown)
    return found


def _bins(data: Data) -> list[Data]:
    return data if isinstance(data, list) else data.get("bins", [data])


def _containers(data: Data, program: str) -> Iterator[tuple[str, float, list[Data]]]:
    """Yield the name of each bin, container or order, its length along x, and its items as the file has them."""
    match program:
        case "py3dbp":
            for number, each in enumerate(_bins(data), 1):
                name = each.get("partno") or each.get("name") or f"bin {number}"
                yield str(name), _number(each["width"], "width of a bin"), each["items"]
        case "skjolber":  # since version 4 with several results
            inside = (each for result in data.get("results", [data]) for each in result["containers"])
            for number, each in enumerate(inside, 1):
                name = each.get("name") or each.get("id") or f"container {number}"
                yield str(name), _number(each["dx"], "dx of a container"), each["stack"]["placements"]
        case _:
            yield from ((order, 0.0, actions) for order, actions in data.items())


def _placed(item: Data, program: str) -> tuple[Data, list[float], list[float]]:
    """Return what was placed, its least corner, and its size along x, y, z as it lies, in units of the file."""
    match program:
        case "py3dbp":
            sides = [item[key] for key in WIDTHS]
            turn = TURNED[checked_whole(item.get("rotation_type", 0), "rotation_type", 0, len(TURNED) - 1)]
            box, corner, size = item, item["position"], [sides[k] for k in turn]
        case "skjolber":
            box, corner = item["stackable"], [item[axis] for axis in "xyz"]
            size = [box[f"d{axis}"] for axis in "xyz"]
        case _:
            box, corner, size = item["item"], item["flb_coordinates"], [item["item"][key] for key in LENGTHS]
            if checked_whole(item["orientation"], "orientation", 0, 1):
                size = [size[1], size[0], size[2]]
    x, y, z = (_number(value, "place") for value in corner)
    return box, [x, y, z], [_number(value, "size") for value in size]


def _number(value: Data, what: str) -> float:
    """Return a number, which files of Python's decimals have as text."""
    with suppress(ValueError):
        value = float(value) if isinstance(value, str) else value
    return checked_number(value, what, within=PLACE)


PACKING_PLAN = Format("packing plan", (".json",), sniff, read, mark="`bins`, `containers` or `flb_coordinates`")
