"""Make an input smaller, greedily, as long as it still shows the same defect."""

from __future__ import annotations

import base64
import copy
import json
from collections.abc import Callable, Iterator
from typing import Any

Data = dict[str, Any]
Fails = Callable[[Data], bool]
MOST = 300  # trials for one input
UPRIGHT = [1.0, 0.0, 0.0, 0.0]
SIMPLE = {"type": "box", "size": [1.0, 1.0, 1.0]}


def smallest(item: Data, fails: Fails, most: int = MOST) -> Data:
    """Return the smallest variant that was found and for which ``fails`` holds; at most ``most`` are tried."""
    left = most
    while True:
        for other in VARIANTS[item["kind"]](item):
            left -= 1
            if left < 0:
                return item
            if fails(other):
                item = other
                break
        else:
            return item


def scenes(item: Data) -> Iterator[Data]:
    """Fewer pushes and bodies first, then fewer keys, simpler shapes, rounder numbers."""
    scene, pushes = item["scene"], item["pushes"]
    for k in range(len(pushes)):
        if len(pushes) > 1:
            yield item | {"pushes": pushes[:k] + pushes[k + 1 :]}
    for k, body in enumerate(scene["bodies"]):
        if all(push["body"] != body["name"] for push in pushes):
            yield item | {"scene": without(scene, k)}
    for key in ("twice", *(["gravity"] if "gravity" in scene else [])):
        if key in item:
            yield {name: part for name, part in item.items() if name != key}
        if key in scene:
            yield item | {"scene": {name: part for name, part in scene.items() if name != key}}
    if isinstance(scene["friction"], dict):
        yield item | {"scene": scene | {"friction": scene["friction"]["default"]}}
    for k, push in enumerate(pushes):
        if push["direction"] is not None:
            yield item | {"pushes": [*pushes[:k], push | {"direction": None}, *pushes[k + 1 :]]}
    for k, body in enumerate(scene["bodies"]):
        if body["shape"]["type"] != "box":
            changed = copy.deepcopy(scene)
            changed["bodies"][k]["shape"] = SIMPLE
            yield item | {"scene": changed}
    for k, body in enumerate(scene["bodies"]):
        if body.get("orientation", UPRIGHT) != UPRIGHT:
            changed = copy.deepcopy(scene)
            changed["bodies"][k]["orientation"] = UPRIGHT
            yield item | {"scene": changed}
    yield from rounder(item)


def without(scene: Data, k: int) -> Data:
    """The scene without a body, and without the friction that names it."""
    name = scene["bodies"][k]["name"]
    found = scene | {"bodies": [body for body in scene["bodies"] if body["name"] != name]}
    if isinstance(scene["friction"], dict) and any(
        name in pair["between"] for pair in scene["friction"].get("pairs", [])
    ):
        found["friction"] = scene["friction"]["default"]
    return found


def rounder(item: Data) -> Iterator[Data]:
    """One number with fewer digits."""
    for path, number in numbers(item):
        for digits in (1, 2, 3):
            shorter = float(f"{number:.{digits}g}")
            if shorter != number:
                changed = copy.deepcopy(item)
                holder: Any = changed
                for key in path[:-1]:
                    holder = holder[key]
                holder[path[-1]] = shorter
                yield changed


def numbers(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], float]]:
    if isinstance(data, float):
        yield path, data
    elif isinstance(data, dict | list):
        for key in data if isinstance(data, dict) else range(len(data)):
            yield from numbers(data[key], (*path, key))


def files(item: Data) -> Iterator[Data]:
    """Shorter by a part of the bytes: halves first, then ever smaller parts; then without the files beside it."""
    content = base64.b64decode(item["content"])
    if item.get("beside"):
        yield item | {"beside": {}}
    length = len(content) // 2
    while length:
        for start in range(0, len(content), length):
            yield item | {"content": base64.b64encode(content[:start] + content[start + length :]).decode()}
        length //= 2


def names(item: Data) -> Iterator[Data]:
    """Half of the name, or all but one character."""
    name = item["name"]
    half = len(name) // 2
    for shorter in (name[:half], name[half:], *(name[:k] + name[k + 1 :] for k in range(min(len(name), 40)))):
        if shorter and shorter != name:
            yield item | {"name": shorter}


VARIANTS: dict[str, Callable[[Data], Iterator[Data]]] = {"scene": scenes, "file": files, "name": names}


def told(item: Data) -> str:
    """An input in one text, to compare lengths."""
    return json.dumps(item)
