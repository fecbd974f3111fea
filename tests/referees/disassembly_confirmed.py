"""Every removal in every state along an order, beside MuJoCo: ``python tests/referees/disassembly_confirmed.py``.

Arguments are names of shipped scenes, or files of published cases, which are taken with their own interfaces.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path

from bench.baselines.handled import rests_without
from holdfast import HoldfastError, assemble, disassembly_order, load_scene
from holdfast.answers import Assembly, Disassembly, Interface
from holdfast.applications.disassembly.removal import Removal
from holdfast.scene.shipped import shipped_scene, shipped_scenes

LARGE = ("bonded_wall",)  # a simulation of 3,000 nodes takes minutes


def compared(d: Disassembly) -> list[tuple[int, Removal, bool | None]]:
    """For every state and every body in it: the step, the answer by contact forces, what MuJoCo sees."""
    rows = []
    for step in range(len(d.order) + 1):
        left = frozenset(d.removals.names) - set(d.order[:step])
        whole = d.removals.assembly.without(d.order[:step])
        for body in whole.movable:
            answer = d.removals.by_forces(body.name, left)
            rows.append((step, answer, rests_without(whole, body.name)))
    return rows


def of(name: str) -> Assembly:
    """The assembly of a shipped scene, or of a published file."""
    if not name.endswith(".json"):
        return assemble(shipped_scene(name))
    given = json.loads(Path(name).read_text())["interfaces"]
    interfaces = [Interface(tuple(i["between"]), i["polygon"], i["normal"]) for i in given]
    return assemble(load_scene(name), interfaces=interfaces)


def main(names: list[str]) -> None:
    """Print a line a scene: how many answers of which kind, and what MuJoCo says to them."""
    for name in names:
        try:
            d = disassembly_order(of(name))
        except HoldfastError as error:
            sys.stdout.write(f"{name}: refused: {str(error)[:80]}\n")
            continue
        counts = Counter((str(answer.answer), rests) for _, answer, rests in compared(d))
        sys.stdout.write(f"{name}: {dict(counts)}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:] or [name for name in shipped_scenes() if name not in LARGE])
