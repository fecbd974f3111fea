"""A module imports only lower floors and its own package; nobody imports the command line or ``bench``."""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from pathlib import Path

import pytest

import holdfast

FLOORS = (
    {"native"},
    {"base"},
    {"geometry", "conic"},
    {"scene"},
    {"contacts"},
    {"assembly", "elastic", "settling"},
    {"engines"},
    {"certificates"},
    {"queries"},
    {"applications"},
    {"batches"},
    {"drawing"},
    {"report"},
    {"live", "agents"},
    {"cli"},
)
FRONT = {"answers", "errors", "plugins", "readers", "sets"}  # modules of public names, whose stubs say where these are
FLOOR = {package: number for number, packages in enumerate(FLOORS) for package in packages}
# Besides themselves
ONLY = {"conic": {"base"}, "elastic": {"base", "native"}, "drawing": {"base", "geometry", "native"}}
ROOT = Path(holdfast.__file__).parent
BENCH = Path(__file__).parents[2] / "bench"


def imports(module: str, source: str) -> set[str]:
    """Packages of holdfast that a module's source imports, wherever it does, and ``bench``."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = module.split(".")[: -node.level] if node.level else []
            stem = ".".join([*base, *(node.module or "").split(".")]).strip(".")
            found |= {f"{stem}.{alias.name}" for alias in node.names}
    beside = {"bench"} & {name.split(".")[0] for name in found}
    return beside | {name.split(".")[1] for name in found if name.startswith("holdfast.")}


def lazy(module: str, source: str) -> set[str]:
    """Those of them that are imported within functions alone."""
    tree = ast.parse(source)
    inside = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    found = set().union(*(imports(module, ast.unparse(node)) for node in inside))
    tree.body = [node for node in tree.body if not isinstance(node, ast.FunctionDef)]
    return found - imports(module, ast.unparse(tree))


def violations(sources: Mapping[str, str]) -> list[str]:
    """Of modules by dotted name (``holdfast.scene.body``; packages end in ``__init__``)."""
    found = []
    for module, source in sources.items():
        own = module.split(".")[1]
        for other in sorted(imports(module, source)):
            if own == "__init__":
                drawn = other == "report" and other in lazy(module, source)  # painters, when a picture is wanted
                allowed = other == "base" or drawn
            elif own == "__main__":
                allowed = other == "cli"
            elif own in FRONT:
                allowed = other == "base"
            elif other not in FLOOR or own not in FLOOR:
                allowed = other.startswith("__")
            elif own in ONLY:
                allowed = other == own or other in ONLY[own]
            else:
                allowed = other == own or FLOOR[other] < FLOOR[own]
            if not allowed:
                found.append(f"{module} imports {other}")
    return found


def modules() -> dict[str, str]:
    names = {path: ".".join(("holdfast", *path.relative_to(ROOT).with_suffix("").parts)) for path in ROOT.rglob("*.py")}
    return {name: path.read_text() for path, name in names.items()}


def test_every_module_keeps_to_its_floor() -> None:
    assert violations(modules()) == []


def test_every_module_has_a_floor() -> None:
    assert {name.split(".")[1] for name in modules()} - {"__init__", "__main__"} <= {*FLOOR, *FRONT}
    assert len(modules()) > 40


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("holdfast.scene.body", "from holdfast.contacts.detect import find_interfaces"),
        ("holdfast.scene.body", "import holdfast.drawing.map_png"),
        ("holdfast.scene.body", "from holdfast import engines"),
        ("holdfast.scene.body", "from ..cli import main"),
        ("holdfast.scene.body", "def f():\n    from holdfast.report import description"),
        ("holdfast.scene.body", "if True:\n    import holdfast.queries"),
        ("holdfast.scene.body", "from holdfast import Scene"),
        ("holdfast.base.arrays", "from holdfast.scene.scene import Scene"),
        ("holdfast.native.__init__", "from holdfast.base.arrays import Float"),
        ("holdfast.geometry.surface", "from holdfast.scene.body import Body"),
        ("holdfast.geometry.surface", "from holdfast.conic.solve import solve"),
        ("holdfast.conic.solve", "from holdfast.geometry.surface import Surface"),
        ("holdfast.elastic.system", "from holdfast.assembly.assembly import Assembly"),
        ("holdfast.elastic.system", "from holdfast.contacts.interface import Interface"),
        ("holdfast.drawing.map_png", "from holdfast.queries.map import RobustnessMap"),
        ("holdfast.drawing.map_png", "from holdfast.report.description import Report"),
        ("holdfast.report.description", "from holdfast.cli.main import run"),
        ("holdfast.report.description", "from bench.truth.coupled import robustness"),
        ("holdfast.applications.transport", "def f():\n    from bench import baselines"),
        ("holdfast.engines.rest", "from holdfast.queries.push import robustness"),
        ("holdfast.__init__", "from holdfast.drawing.html_page import write_html"),
        ("holdfast.__init__", "from holdfast.live.start import view"),
        ("holdfast.__init__", "from holdfast.queries.map import robustness_map"),
        ("holdfast.answers", "from holdfast.queries.map import RobustnessMap"),
        ("holdfast.queries.map", "from holdfast.answers import Claim"),
        ("holdfast.__init__", "from holdfast.cli.main import run"),
        ("holdfast.__init__", "from holdfast.report import painters"),
        ("holdfast.__init__", "def f():\n    from holdfast.drawing import map_png"),
        ("holdfast.queries.map", "def f():\n    from holdfast.report import painters"),
        ("holdfast.novelty.thing", "from holdfast.base.arrays import Float"),
    ],
)
def test_a_planted_violation_is_found(module: str, source: str) -> None:
    assert len(violations({module: source})) == 1


@pytest.mark.parametrize(
    ("module", "source"),
    [
        (
            "holdfast.scene.body",
            "import numpy as np\nfrom holdfast.base.arrays import Float\nfrom holdfast.scene import scene",
        ),
        ("holdfast.scene.formats.native", "from ..scene import Scene\nfrom ...base.arrays import Float"),
        ("holdfast.base.arrays", "from holdfast.base.errors import message"),
        (
            "holdfast.drawing.map_png",
            "from holdfast.drawing.picture import Soup\nfrom holdfast.base.files import write_atomically",
        ),
        ("holdfast.report.map_picture", "from holdfast.drawing.picture import Picture"),
        ("holdfast.cli.main", "from holdfast import __version__\nfrom holdfast.drawing.map_png import write_png"),
        ("holdfast.__init__", "from holdfast.base.painters import painters_come_from"),
        ("holdfast.answers", "from holdfast.base.names import names_of_stub"),
        ("holdfast.__init__", "def f():\n    from holdfast.report import painters"),
    ],
)
def test_what_is_allowed_is_let_through(module: str, source: str) -> None:
    assert violations({module: source}) == []


def test_the_map_on_the_page_shows_these_floors() -> None:
    page = (Path(__file__).parents[2] / "docs" / "architecture.md").read_text(encoding="utf-8")
    shown: dict[int, set[str]] = {}
    floor = -1
    for number, package in re.findall(r"^ {4}( {4}| *\d+  ?)(?:  )?(\w+)/  ", page, re.MULTILINE):
        floor = int(number) if number.strip() else floor
        shown.setdefault(floor, set()).add(package)
    assert shown == dict(enumerate(FLOORS))


def test_truths_are_worked_out_without_the_engines() -> None:
    truths = {path.stem: path.read_text() for path in (BENCH / "truth").glob("*.py")}
    assert len(truths) >= 4
    for name, source in truths.items():
        assert not {"engines", "queries", "applications"} & imports(f"bench.truth.{name}", source), name
