"""Every removal in every state along an order, beside MuJoCo: ``python tests/referees/disassembly_confirmed.py``.

Arguments are names of shipped scenes, or files of published cases, which are taken with their own interfaces.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path

from holdfast import Assembly, Disassembly, HoldfastError, Interface, assemble, disassembly_order, load_scene
from holdfast.applications.disassembly.removal import Removal
from holdfast.assembly.nodes import contact_nodes
from holdfast.scene.shipped import shipped_scene, shipped_scenes
from holdfast.validation.baselines import mujoco

NODES = 16  # an interface
SHARE = 0.6  # of the weight taken, besides all of it
LARGE = ("bonded_wall",)  # a simulation of 3,000 nodes takes minutes


def seen(whole: Assembly, name: str, force: float) -> bool | None:
    """Whether MuJoCo sees all rest without a body and with a share of its weight taken; None if it cannot tell."""
    rest = whole.without([name])
    if rest.hanging:
        return False
    trials = [mujoco.holds(rest, None, contact_nodes(rest, NODES, "quadrature")).holds] if rest.movable else []
    if False not in trials:
        load = 0 * whole.weight_wrench()
        up = -whole.scene.gravity
        k = 6 * whole.index[name]
        load[k : k + 3] = force * up
        trials.append(mujoco.holds(whole, load, contact_nodes(whole, NODES, "quadrature")).holds)
    return False if False in trials else None if None in trials else True


def compared(d: Disassembly) -> list[tuple[int, Removal, bool | None]]:
    """For every state and every body in it: the step, the answer by contact forces, what MuJoCo sees."""
    rows = []
    for step in range(len(d.order) + 1):
        left = frozenset(d.removals.names) - set(d.order[:step])
        whole = d.removals.assembly.without(d.order[:step])
        for body in whole.movable:
            answer = d.removals.by_forces(body.name, left)
            rows.append((step, answer, seen(whole, body.name, SHARE * (body.mass or 0.0))))
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
