"""Processor time of a new process: the first after the installation, and later ones; beside an older version.

A first process finds nothing that this package or Matplotlib keeps: no bytecode of its own modules, no list of fonts,
no machine code. The unit is a process that imports NumPy and SciPy alone. With ``--beside DIR`` the older checkout
takes turns with this one.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from statistics import median

from bench.checkout import SOURCE, older
from bench.suite import Case, Row, Suite

UNIT = "import numpy, scipy, scipy.sparse, scipy.spatial"
# A tower of 16 cubes needs the frontal solver
TOWER = """
import numpy as np, holdfast as hf
def at(z): return np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, z], [0, 0, 0, 1.0]])
cubes = [hf.Body(str(k), hf.Box((0.1,) * 3), mass=1.0, pose=at(0.05 + 0.1 * k)) for k in range(16)]
scene = hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), *cubes], hf.Friction(0.5))
hf.robustness(hf.assemble(scene), "0", (-0.05, 0, 0.05), (1, 0, 0))
"""
COMMANDS = {
    "imports of NumPy and SciPy": ["-c", UNIT],
    "import holdfast": ["-c", "import holdfast"],
    "--help": ["-m", "holdfast", "--help"],
    "assess table": ["-m", "holdfast", "assess", "table"],
    "assess tabletop (meshes)": ["-m", "holdfast", "assess", "tabletop"],
    "map table --png": ["-m", "holdfast", "map", "table", "--png", "map.png"],
    "a push on a tower": ["-c", TOWER],
    "disassemble stack": ["-m", "holdfast", "disassemble", "stack"],
}
FIRST, LATER = 3, 7  # processes of each kind


def processor_time(arguments: list[str], source: Path, folder: Path) -> float:
    """Seconds of processor time that Python takes with these arguments; all files that it writes go to ``folder``."""
    own = {"PYTHONPATH": str(source), "HOLDFAST_CACHE_DIR": str(folder / "code"), "MPLCONFIGDIR": str(folder / "fonts")}
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}  # as users have it
    environment = kept | own | {"XDG_CACHE_HOME": str(folder / "cache"), "OPENBLAS_NUM_THREADS": "1"}
    before = os.times()
    subprocess.run([sys.executable, *arguments], cwd=folder, env=environment, capture_output=True, check=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def measured(arguments: list[str]) -> Row:
    """The times of one command, of this version and of the older one."""
    before = older.get()
    sources = {"": SOURCE} | ({} if before is None else {"older ": before.resolve() / "src"})
    found: dict[str, list[float]] = {}
    for _ in range(FIRST):
        for name, source in sources.items():
            with tempfile.TemporaryDirectory() as folder:
                own = Path(folder) / "src"  # a copy without bytecode
                shutil.copytree(source, own, ignore=shutil.ignore_patterns("__pycache__"))
                found.setdefault(f"{name}first s", []).append(processor_time(arguments, own, Path(folder)))
                if len(found[f"{name}first s"]) == FIRST:
                    times = [processor_time(arguments, own, Path(folder)) for _ in range(LATER)]
                    found[f"{name}later s"] = times
    return {name: median(times) for name, times in found.items()}


def labelled(label: str) -> list[Row]:
    """A row of the table, in seconds and in imports of NumPy and SciPy."""
    unit, row = measured(COMMANDS["imports of NumPy and SciPy"])["later s"], measured(COMMANDS[label])
    row |= {f"{name.removesuffix(' s')}, in imports": time / unit for name, time in list(row.items())}
    return [{"case": label} | row | {"first over later": row["first s"] / row["later s"]}]


def cases() -> Mapping[str, Case]:
    """Return the commands by label."""
    return {label: partial(labelled, label) for label in COMMANDS}


SUITE = Suite("startup", __doc__, cases)
