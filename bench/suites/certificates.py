"""Certificates: how many answers have one, their sizes, what writing and checking takes, what altered ones claim."""

from __future__ import annotations

import copy
import json
import random
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import holdfast as hf
from bench.checkout import ROOT
from bench.scenes.random_assemblies import FAMILIES, standing, with_falling, with_floating
from bench.scenes.random_pushes import random_pushes
from bench.scenes.real_pallets import pallet, pallets
from bench.scenes.shelf import shelf
from bench.suite import Case, Row, Suite
from holdfast.certificates.verify_certificate import NUMBER, RefusedError, claims_of, number
from holdfast.scene.shipped import shipped_scene

PUSHES, EACH, PALLETS, FALLS, ALTERED = 500, 10, 40, 20, 1000
DIRECTIONS = [(1, 0, 0), (0, 1, 0), (-0.6, 0.8, 0)]
CHECKER = ROOT / "tools" / "verify_certificate.py"

SHIPPED = (
    *("cube", "stack", "table", "tall_table", "wall2x2", "slope", "slope_two"),
    *("cantilever", "arch", "v_groove", "wedged", "wedged_floor", "tabletop"),
)
MAKERS = tuple(FAMILIES.values())

Question = tuple[Any, float]  # an answer, and the seconds that it took


def cases() -> Mapping[str, Case]:
    found: dict[str, Case] = {
        "shipped scenes stand": partial(_measured, "shipped scenes stand", _shipped),
        "random pushes": partial(_measured, "random pushes", _pushed),
        "unstable": partial(_measured, "unstable", _falling),
        "shelf with an orange": partial(_measured, "shelf with an orange", _shelf),
        "removals and orders": partial(_measured, "removals and orders", _taken_apart),
        "altered files": _altered,
    }
    if pallets():
        found["accelerations of pallets"] = partial(_measured, "accelerations of pallets", _carried)
    return found


def _timed(ask: Any) -> Question:  # noqa: ANN401 - any question
    start = time.process_time()
    answer = ask()
    return answer, time.process_time() - start


def _shipped() -> Iterator[Question]:
    for name in SHIPPED:
        assembly = hf.assemble(shipped_scene(name))
        if assembly.movable:
            yield _timed(partial(hf.stability, assembly, engine="limit"))


def _pushed() -> Iterator[Question]:
    rng = np.random.default_rng(11)
    for k in range(PUSHES // EACH):
        assembly = standing(MAKERS[k % len(MAKERS)], rng)
        for push in random_pushes(assembly, rng, EACH, slant=60):
            yield _timed(partial(hf.robustness, assembly, push.body, push.point, push.direction, engine="limit"))


def _falling() -> Iterator[Question]:
    rng = np.random.default_rng(12)
    for k in range(FALLS):
        scene = (with_floating, with_falling)[k % 2](standing(MAKERS[k % len(MAKERS)], rng).scene, rng)
        yield _timed(partial(hf.stability, hf.assemble(scene), engine="limit"))


def _shelf() -> Iterator[Question]:
    assembly = hf.assemble(shelf())
    for name in [body.name for body in assembly.movable]:
        top = assembly.scene.body(name).surface_world.vertices
        yield _timed(partial(hf.robustness, assembly, name, top[np.argmax(top[:, 2])], (1, 0, -0.5), engine="limit"))


def _taken_apart() -> Iterator[Question]:
    for scene in (*map(shipped_scene, SHIPPED), shelf()):
        assembly = hf.assemble(scene)
        if assembly.movable and hf.stability(assembly).stable:
            yield _timed(partial(hf.disassembly_order, assembly))
            yield _timed(partial(hf.build_order, assembly, pushes=0))
            for body in assembly.movable:
                yield _timed(partial(hf.can_remove, assembly, body.name))


def _carried() -> Iterator[Question]:
    for boxes in pallets()[:PALLETS]:
        assembly = hf.assemble(pallet(boxes))
        yield _timed(partial(hf.transport_limits, assembly, DIRECTIONS, engine="limit"))


def _measured(name: str, questions: Any) -> list[Row]:  # noqa: ANN401 - a generator function
    sizes, writing, checking, asking, gaps = [], [], [], [], []
    kinds: Counter[str] = Counter()
    failed: list[str] = []
    with TemporaryDirectory() as folder:
        path = Path(folder) / "certificate.json"
        for answer, asked in questions():
            start = time.process_time()
            try:
                answer.save_certificate(path)
            except hf.HoldfastError as error:
                failed.append(str(error).split(": ", 1)[1][:90])
                continue
            writing.append(time.process_time() - start)
            asking.append(asked)
            begin = time.perf_counter()
            said = subprocess.run(
                [sys.executable, "-I", "-S", str(CHECKER), str(path)], capture_output=True, check=False
            )
            checking.append(time.perf_counter() - begin)
            kinds["verified" if said.returncode == 0 else "NOT verified"] += 1
            sizes.append(path.stat().st_size)
            gaps += _gaps(json.loads(path.read_text()))
    return [
        {
            "case": name,
            "answers": len(sizes) + len(failed),
            **kinds,
            "no exact proof": len(failed),
            "why": "; ".join(f"{count} {why}" for why, count in Counter(failed).most_common(2)),
            "median kB": float(np.median(sizes)) / 1e3,
            "largest kB": float(np.max(sizes)) / 1e3,
            "asked, median s": float(np.median(asking)),
            "written, median s": float(np.median(writing)),
            "written, longest s": float(np.max(writing)),
            "checked alone, median s": float(np.median(checking)),
            "checked alone, longest s": float(np.max(checking)),
            "holds to moves, median gap": float(np.median(gaps)) if gaps else 0.0,
            "holds to moves, largest gap": float(np.max(gaps)) if gaps else 0.0,
        }
    ]


def _gaps(data: Any) -> list[float]:  # noqa: ANN401 - JSON
    """By how much, relative, the factors of which it is proved that they hold and that they move lie apart."""
    found, held = [], None
    for proof in (proof for state in (data if isinstance(data, list) else [data]) for proof in state["proofs"]):
        if proof["kind"] == "holds":
            held = proof
        elif proof["kind"] == "moves" and held is not None and held["load"] == proof["load"]:
            found.append(1 - float(held["factor"]) / float(proof["factor"]))
    return found


def _altered() -> list[Row]:
    """Files with one thing altered: a number, its sign, a unit, a contact that is missing, a name, a claim."""
    rng = random.Random(13)
    files = []
    with TemporaryDirectory() as folder:
        path = Path(folder) / "certificate.json"
        for answer, _ in _pushed():
            try:
                answer.save_certificate(path)
            except hf.HoldfastError:
                continue
            files.append(json.loads(path.read_text()))
            if len(files) == 20:
                break
    outcome: Counter[str] = Counter()
    for k in range(ALTERED):
        data = copy.deepcopy(files[k % len(files)])
        what = _alter(data, rng)
        try:
            claims_of(json.dumps(data))
            outcome[what] += 1
        except RefusedError:
            outcome["refused"] += 1
    harmless = ", ".join(f"{count} {what}" for what, count in outcome.most_common() if what != "refused")
    return [
        {"case": "altered files", "files": ALTERED, "refused": outcome["refused"], "still proved as altered": harmless}
    ]


def _alter(data: Any, rng: random.Random) -> str:  # noqa: ANN401 - JSON
    """Alter one thing in place, and say what."""
    kind = rng.choice(["number"] * 6 + ["contact", "unit", "claim", "name"])
    if kind == "contact":
        data["contacts"].pop(rng.randrange(len(data["contacts"])))
    elif kind == "unit":
        data["units"] = rng.choice(["mm, kg, s, N, N m", "m, g, s, N, N m", ""])
    elif kind == "claim":
        rng.choice(data["proofs"])["claim"] += "0"
    elif kind == "name":
        rng.choice(data["bodies"])["name"] += "x"
    else:
        place = rng.choice(list(places(data)))
        part = data
        for key in place[:-1]:
            part = part[key]
        value = float(number(part[place[-1]]))
        part[place[-1]] = repr(rng.choice([-value if value else 1.0, value * (1 + 1e-6) + 1e-9, 2 * value + 1e-3]))
        return str(place[-2] if isinstance(place[-1], int) else place[-1])
    return kind


def places(data: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:  # noqa: ANN401 - JSON
    """Yield the keys that lead to each number of a certificate."""
    if isinstance(data, dict | list):
        for key, part in data.items() if isinstance(data, dict) else enumerate(data):
            yield from places(part, (*place, key))
    elif isinstance(data, str) and NUMBER.fullmatch(data):
        yield place


SUITE = Suite("certificates", __doc__, cases)
