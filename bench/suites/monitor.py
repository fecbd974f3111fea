"""How long updates of a monitor take, on 300 random motions, and what they say beside the engines asked at once.

The monitor's clock is the processor's, so that nothing else that the machine does makes answers late. ``holds`` counts
the motions that hold by the ``lower`` of engine ``compliant``, ``moves`` those that are proved to move by ``limit``.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial
from unittest import mock

import numpy as np

import holdfast as hf
from bench.scenes import dense_pallet
from bench.scenes.fitted import rails, tabletop
from bench.scenes.real_pallets import pallet, pallets
from bench.scenes.shelf import full_shelf
from bench.suite import Case, Row, Suite
from holdfast.applications.transport import motion_columns, motion_coordinates
from holdfast.engines.groups import prepared
from holdfast.scene.shipped import shipped_scene

MOTIONS = 300
PALLETS = (36,)  # numbers of real pallets, ordered by their boxes: one of 40
USUAL, LONG = 0.02, 0.1  # [s] time of an update, and of one on many bodies
MANY = 30  # bodies


def cases() -> Mapping[str, Case]:
    """One case a scene."""
    scenes: dict[str, Callable[[], hf.Scene]] = {
        "table": partial(shipped_scene, "table"),
        "tabletop of 7": partial(shipped_scene, "tabletop"),
        "things alone, 7": partial(tabletop, 1),
        "box between rails": rails,
        "box between rails, 0.05 mm": partial(rails, 5e-5),
        "stacked boxes, 8": partial(dense_pallet.pallet, 2, 2, 2),
        "shelf of 20": full_shelf,
        "stacked boxes, 40": partial(dense_pallet.pallet, 5, 2, 4),
    }
    found = pallets()
    for k in PALLETS[: len(found)]:
        scenes[f"pallet {k} of {len(found[k])}"] = partial(pallet, found[k])
    return {name: partial(_rows, name, make) for name, make in scenes.items()}


def _rows(name: str, make: Callable[[], hf.Scene]) -> list[Row]:
    assembly = hf.assemble(make())
    a, omega, alpha, change = np.random.default_rng(1).normal(size=(4, MOTIONS, 3))
    a, omega, change = 2 * a, 0.7 * omega, change * (0.5, 0.5, 0.2)
    x = motion_coordinates(a - change, alpha, omega)
    size = np.linalg.norm(x, axis=1)
    loads = motion_columns(assembly, np.zeros(3)) @ (x / size[:, None]).T
    lower = prepared(hf.Compliant(), assembly).load_factor(loads).lower
    upper = prepared(hf.Limit(), assembly).load_factor(loads).upper
    seconds = LONG if len(assembly.movable) > MANY else USUAL
    with mock.patch("time.perf_counter", time.process_time):
        start = time.process_time()
        monitor = hf.Monitor(assembly, seconds=seconds)
        built, gravity = time.process_time() - start, assembly.scene.gravity
        found = [
            monitor.update(a[k], omega[k], gravity + change[k], angular_acceleration=alpha[k]) for k in range(MOTIONS)
        ]
    spent, holds = np.array([one.seconds for one in found]), np.array([one.holds for one in found])
    row: Row = {"case": name, "bodies": len(assembly.movable), "groups": len(assembly.groups), "seconds": seconds}
    row |= {"prepare s": built}
    row |= {f"{which} s": float(np.quantile(spent, q)) for which, q in (("median", 0.5), ("99 %", 0.99), ("most", 1.0))}
    row["late %"] = 100 * float(np.mean([one.late for one in found]))
    row |= {
        "holds": int((size < lower).sum()),
        "said so": int(holds.sum()),
        "too much": int((holds & (size >= lower)).sum()),
    }
    said = sum(one.status is hf.Status.UNSTABLE for one in found)
    return [row | {"moves": int((size > upper).sum()), "proved so": said}]


SUITE = Suite("monitor", __doc__, cases)
