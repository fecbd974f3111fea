"""A module imports only lower floors and its own package; nobody imports the command line."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from pathlib import Path

import pytest

import holdfast

FLOORS = (
    {"errors", "arrays", "rigid", "compiled", "progress", "files"},
    {"scene", "conic"},
    {"contacts", "shipped"},
    {"assembly"},
    {"engines", "truth"},
    {"robustness"},
    {"applications", "baselines"},
    {"viewer"},
    {"report"},
    {"benchmarks"},
    {"cli"},
)
FLOOR = {package: number for number, packages in enumerate(FLOORS) for package in packages}
ONLY = {"shipped": {"scene"}, "viewer": set()}  # besides floor 0 and themselves
ROOT = Path(holdfast.__file__).parent


def imports(module: str, source: str) -> set[str]:
    """Packages of holdfast that a module's source imports, wherever it does."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = module.split(".")[: -node.level] if node.level else []
            stem = ".".join([*base, *(node.module or "").split(".")]).strip(".")
            found |= {f"{stem}.{alias.name}" for alias in node.names}
    return {name.split(".")[1] for name in found if name.startswith("holdfast.")}


def violations(sources: Mapping[str, str]) -> list[str]:
    """Of modules by dotted name (``holdfast.scene.body``; packages end in ``__init__``)."""
    found = []
    for module, source in sources.items():
        own = module.split(".")[1]
        for other in sorted(imports(module, source)):
            if own == "__init__":
                allowed = FLOOR.get(other, 99) < FLOOR["viewer"]
            elif own == "__main__":
                allowed = other == "cli"
            elif other not in FLOOR or own not in FLOOR:
                allowed = other.startswith("__")
            elif own in ONLY:
                allowed = other == own or FLOOR[other] == 0 or other in ONLY[own]
            else:
                beside = FLOOR[own] == FLOOR[other] == 0
                allowed = other == own or FLOOR[other] < FLOOR[own] or beside
            if not allowed:
                found.append(f"{module} imports {other}")
    return found


def modules() -> dict[str, str]:
    names = {path: ".".join(("holdfast", *path.relative_to(ROOT).with_suffix("").parts)) for path in ROOT.rglob("*.py")}
    return {name: path.read_text() for path, name in names.items()}


def test_every_module_keeps_to_its_floor() -> None:
    assert violations(modules()) == []


def test_every_module_has_a_floor() -> None:
    assert {name.split(".")[1] for name in modules()} - {"__init__", "__main__"} <= set(FLOOR)
    assert len(modules()) > 40


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("holdfast.scene.body", "from holdfast.contacts.detect import find_interfaces"),
        ("holdfast.scene.body", "import holdfast.viewer.png"),
        ("holdfast.scene.body", "from holdfast import engines"),
        ("holdfast.scene.body", "from ..cli import main"),
        ("holdfast.scene.body", "from ..conic.solve import solve"),
        ("holdfast.scene.body", "def f():\n    from holdfast.report import data"),
        ("holdfast.scene.body", "if True:\n    import holdfast.robustness"),
        ("holdfast.scene.body", "from holdfast import Scene"),
        ("holdfast.arrays", "from holdfast.scene.scene import Scene"),
        ("holdfast.conic.solve", "from holdfast.scene.scene import Scene"),
        ("holdfast.shipped.blocks", "from holdfast.conic.solve import solve"),
        ("holdfast.viewer.png", "from holdfast.robustness.map import RobustnessMap"),
        ("holdfast.viewer.png", "from holdfast.report.data import plain"),
        ("holdfast.report.data", "from holdfast.cli.main import run"),
        ("holdfast.applications.transport", "from holdfast.baselines.mujoco import settle"),
        ("holdfast.truth.coupled", "from holdfast.engines.compliant.engine import Compliant"),
        ("holdfast.engines.rest", "from holdfast.robustness.query import robustness"),
        ("holdfast.__init__", "from holdfast.viewer.html import write_html"),
        ("holdfast.__init__", "from holdfast.cli.main import run"),
        ("holdfast.novelty.thing", "from holdfast.arrays import Float"),
    ],
)
def test_a_planted_violation_is_found(module: str, source: str) -> None:
    assert len(violations({module: source})) == 1


@pytest.mark.parametrize(
    ("module", "source"),
    [
        (
            "holdfast.scene.body",
            "import numpy as np\nfrom holdfast.arrays import Float\nfrom holdfast.scene import scene",
        ),
        ("holdfast.scene.formats.native", "from ..scene import Scene\nfrom ...arrays import Float"),
        ("holdfast.arrays", "from holdfast.errors import message"),
        ("holdfast.viewer.png", "from holdfast.viewer.soup import Soup\nfrom holdfast.files import write_atomically"),
        ("holdfast.shipped.blocks", "from holdfast.scene.scene import Scene"),
        ("holdfast.report.picture", "from holdfast.viewer.picture import Picture"),
        ("holdfast.cli.main", "from holdfast import __version__\nfrom holdfast.viewer.png import write_png"),
        ("holdfast.__init__", "from holdfast.robustness.map import robustness_map"),
    ],
)
def test_what_is_allowed_is_let_through(module: str, source: str) -> None:
    assert violations({module: source}) == []
