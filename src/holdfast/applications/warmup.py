"""Compile every compiled function, by small queries that together call all of them.

Numba compiles a function for the types of its arguments, and a query uses the same types as those of users.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from contextlib import suppress
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from holdfast.applications.disassembly.order import disassembly_order
from holdfast.applications.settled import settle
from holdfast.assembly.assembly import assemble
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, HoldfastWarning, message
from holdfast.base.machine_code import ready, saved, shipped_folder, version_folder
from holdfast.base.progress import report, reported
from holdfast.base.text import quoted
from holdfast.elastic.sparse import MOST_DENSE
from holdfast.engines.compliant.engine import Compliant
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.limit.combination import combined
from holdfast.queries.map import robustness_map
from holdfast.queries.push import robustness
from holdfast.queries.stability import stability
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Cylinder
from holdfast.scene.shipped import shipped_scene

STAGE = "compiling, question by question"
COMPILED = "all-compiled"  # marker file in the folder of machine code of this version: everything is compiled
ALL = "all"


def compile_all(group: str = ALL, processes: int = 1) -> int:
    """Compile what the questions of a group need, into the folder of machine code; return the number of functions.

    In this process, or in several that share the folder: only what two of them need at the same time is compiled twice.
    Raises HoldfastError if there is no such group.
    """
    count = _compiled(group, processes)
    if group == ALL:
        with suppress(OSError):  # if the folder is not writable, every process compiles for itself
            (version_folder() / COMPILED).touch()
    return count


def all_compiled() -> bool:
    """Whether everything was compiled for this version, or came with the package."""
    return (version_folder() / COMPILED).exists() or shipped_folder() is not None


def compile_once() -> None:
    """Compile everything, unless that was done for this version, so that it does not count as time of a question."""
    if not all_compiled():
        compile_all()


def _compiled(group: str, processes: int) -> int:
    if group not in (*GROUPS, ALL):
        problem, remedy = f"there is no group {quoted(group)}", f"name one of: {', '.join((*GROUPS, ALL))}"
        raise HoldfastError(message("warmup", problem, remedy))
    asked = [(name, number) for name in (GROUPS if group == ALL else [group]) for number in range(len(GROUPS[name]))]
    if processes == 1:
        for each in reported(STAGE, asked):
            _ask(*each)
        return max(saved(), ready()[0])
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        running = {pool.submit(_ask, *each) for each in asked}
        while running:
            report("functions compiled", saved(), 0)
            done, running = wait(running, timeout=1.0, return_when=FIRST_COMPLETED)
            for question in done:
                question.result()
    report(STAGE, len(asked), len(asked))
    return saved()


def _ask(group: str, number: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HoldfastWarning)
        GROUPS[group][number]()


def _map(name: str, engine: str) -> None:
    """Make a map, and its picture where pictures can be made."""
    surfaces = robustness_map(assemble(shipped_scene(name)), spacing=0.03, engine=engine)
    if find_spec("matplotlib") is not None:
        with TemporaryDirectory() as folder:
            surfaces.save_png(Path(folder) / "map.png")


def _combination() -> None:
    """Call the function that bounds a certified map between the points where it is solved."""
    combined(np.eye(6), np.eye(6), np.zeros((6, 2), dtype=np.int64), np.ones(6), np.ones((2, 6)))


def _fall() -> None:
    """Simulate the fall of a tower that overhangs."""
    sizes = {"lower": (0.0, 0.1), "upper": (0.06, 0.2)}
    blocks = [Body(name, Box((0.1, 0.1, 0.1)), mass=1.0, pose=_at(x, z)) for name, (x, z) in sizes.items()]
    stability(assemble(_on_floor(*blocks)))


def _tin() -> None:
    """Detect the contacts of a body that is not a cuboid, by its triangles."""
    assemble(_on_floor(Body("tin", Cylinder(0.05, 0.1), mass=1.0, pose=_at(0.0, 0.1))))


def _settled() -> None:
    """Settle a turned box that penetrates the floor."""
    pose = _at(0.0, 0.099)
    pose[:3, :3] = [[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]]
    settle(_on_floor(Body("box", Box((0.1, 0.1, 0.1)), mass=1.0, pose=pose)))


def _again() -> None:
    """Bring a cube to rest from near its rest position."""
    assembly = assemble(shipped_scene("cube"))
    grid = Grid.of(assembly, assembly.weight_wrench(), Compliant().springs)
    grid.system.come_to_rest(near=2 * grid.settled.q)


def _tower() -> None:
    """Push a tower that is too large for dense equations, so that the frontal solver is used."""
    size, count = 0.1, MOST_DENSE // 6 + 1
    heights = 0.05 + size * (0.5 + np.arange(count))
    blocks = [Body(f"{k}", Box((size, size, size)), mass=1.0, pose=_at(0.0, z)) for k, z in enumerate(heights)]
    robustness(assemble(_on_floor(*blocks)), "0", (-0.5 * size, 0.0, heights[0]), (1, 0, 0))


def _on_floor(*bodies: Body) -> Scene:
    return Scene([Body("floor", Box((1.0, 1.0, 0.1)), fixed=True), *bodies], 0.5)


def _at(x: float, z: float) -> Float:
    pose = np.eye(4)
    pose[:3, 3] = x, 0.0, z
    return pose


# By what they are about; those that take longest come first, for other processes to do the rest meanwhile
GROUPS: dict[str, tuple[Callable[[], object], ...]] = {
    "table": (lambda: _map("table", "compliant"), _again),
    "meshes": (_tin, _settled, _fall),
    "towers": (_tower,),
    "other": (
        lambda: disassembly_order(assemble(shipped_scene("stack"))),
        lambda: _map("table", "graph"),
        lambda: _map("cube", "limit"),
        _combination,
    ),
}
