"""No test works out what it expects with a number of the code that it checks.

A constant that a test imports moves together with the code: halve a margin, and such a test still passes. So no module
of tests imports a number in capitals from a module of holdfast; it says the number, or follows from what it means.
Tables, names and arrays (COMMANDS, FORMATS, colours, the axes of the world) tell things apart, and may be imported.
"""

from __future__ import annotations

import ast
import importlib
import re
from collections.abc import Iterator
from functools import cache
from numbers import Number
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
CAPITALS = re.compile(r"[A-Z][A-Z0-9_]*")
# What is still imported, by module: to be replaced by numbers, and not to grow
LEFT: dict[str, set[str]] = {
    "assembly/test_axes.py": {"holdfast.base.rigid.BESIDE", "holdfast.base.rigid.NOTHING"},
    "assembly/test_caution.py": {"holdfast.assembly.caution.WORST"},
    "assembly/test_operator.py": {"holdfast.engines.compliant.places.SEVERAL"},
    "base/test_kinds.py": {"holdfast.base.kinds.LARGEST"},
    "base/toys.py": {"holdfast.base.linking.SHORT"},
    "cli/test_streams.py": {"holdfast.cli.stopping.STOPPED"},
    "contacts/test_cuboids.py": {"holdfast.contacts.detect.NEGLIGIBLE_WIDTH"},
    "contacts/test_merging.py": {"holdfast.contacts.merging.BROAD", "holdfast.contacts.merging.FEW"},
    "drawing/test_colours.py": {
        "holdfast.drawing.colours.COVERED",
        "holdfast.drawing.colours.FALLS",
        "holdfast.drawing.colours.FIXED",
        "holdfast.drawing.colours.INFINITE",
        "holdfast.drawing.colours.UNDECIDED",
        "holdfast.drawing.colours.ZERO",
    },
    "drawing/test_html.py": {
        "holdfast.drawing.colours.INFINITE",
        "holdfast.drawing.colours.UNDECIDED",
        "holdfast.drawing.colours.ZERO",
    },
    "drawing/test_notebook.py": {"holdfast.drawing.colours.INFINITE"},
    "drawing/test_png.py": {
        "holdfast.drawing.colours.INFINITE",
        "holdfast.drawing.colours.ZERO",
        "holdfast.drawing.shade.SHADE_LOSS",
    },
    "drawing/test_raster.py": {
        "holdfast.drawing.raster.CREASE",
        "holdfast.drawing.raster.OUTLINE",
        "holdfast.drawing.raster.PLAIN",
    },
    "drawing/test_tone.py": {"holdfast.drawing.colours.FIXED", "holdfast.drawing.colours.INFINITE"},
    "drawing/test_undecided_pictures.py": {
        "holdfast.drawing.colours.FALLS",
        "holdfast.drawing.colours.UNDECIDED",
        "holdfast.drawing.colours.ZERO",
    },
    "elastic/test_elastic_cubic.py": {"holdfast.elastic.cubic.NOWHERE", "holdfast.elastic.cubic.ONCE"},
    "elastic/test_elastic_dips.py": {
        "holdfast.elastic.step_control.BRIEF",
        "holdfast.elastic.step_control.CLOSE",
        "holdfast.elastic.step_control.DEEPER",
        "holdfast.elastic.step_control.DIP",
        "holdfast.elastic.step_control.FALLEN",
        "holdfast.elastic.step_control.HIDDEN",
        "holdfast.elastic.step_control.LEVEL",
        "holdfast.elastic.step_control.QUICK",
        "holdfast.elastic.step_control.SOON",
    },
    "elastic/test_elastic_law.py": {"holdfast.elastic.linear.ROUNDED", "holdfast.elastic.linear.SINGULAR"},
    "elastic/test_elastic_paths.py": {
        "holdfast.elastic.step_control.FALLEN",
        "holdfast.elastic.step_control.QUICK",
        "holdfast.elastic.stepper.AWAY",
        "holdfast.elastic.stepper.HARDLY_AWAY",
        "holdfast.elastic.stepper.MOST_CHANGES",
    },
    "elastic/test_fronts.py": {"holdfast.elastic.linear.SINGULAR"},
    "engines/compliant/test_compliant_endless.py": {
        "holdfast.engines.compliant.refinement.COARSE",
        "holdfast.engines.compliant.refinement.LEAST_ERROR",
        "holdfast.engines.compliant.refinement.SHARP",
    },
    "engines/compliant/test_compliant_recovery.py": {
        "holdfast.engines.compliant.refinement.LEAST_ERROR",
        "holdfast.engines.compliant.refinement.SAFETY",
    },
    "engines/compliant/test_compliant_verdicts.py": {"holdfast.elastic.resting.EXACT"},
    "engines/compliant/test_concentrated.py": {"holdfast.elastic.path.REFINED"},
    "engines/compliant/test_imperfect_faces.py": {"holdfast.elastic.path.REFINED"},
    "engines/compliant/test_load_bearing.py": {"holdfast.engines.compliant.load_bearing.HUGE"},
    "engines/compliant/test_next_grid.py": {
        "holdfast.engines.compliant.refinement.LEAST_ERROR",
        "holdfast.engines.compliant.refinement.SAFETY",
    },
    "engines/compliant/test_oranges.py": {"holdfast.elastic.linear.ROUNDED"},
    "engines/compliant/test_reserve.py": {"holdfast.engines.compliant.reserve.FINELY"},
    "engines/limit/test_limit_failure.py": {"holdfast.contacts.interface.BITS"},
    "engines/limit/test_limit_shortcuts.py": {"holdfast.engines.limit.interior.ENOUGH"},
    "engines/test_lone_bodies.py": {"holdfast.engines.compliant.reserve.AMPLE"},
    "fuzz/worker.py": {"holdfast.base.borders.outcomes.MEGABYTE"},
    "live/test_guard.py": {"holdfast.live.guard.MOST_BYTES", "holdfast.live.guard.MOST_SAID"},
    "live/test_model.py": {"holdfast.live.steps.BETWEEN", "holdfast.live.window_model.STEEPEST"},
    "live/test_portions.py": {
        "holdfast.drawing.colours.FIXED",
        "holdfast.live.portions.COARSER",
        "holdfast.queries.map.MAX_POINTS",
    },
    "live/test_scenery.py": {
        "holdfast.drawing.colours.COVERED",
        "holdfast.drawing.colours.FALLS",
        "holdfast.drawing.colours.FIXED",
    },
    "scene/test_mesh_files.py": {"holdfast.geometry.gltf.BINARY_CHUNK", "holdfast.geometry.gltf.JSON_CHUNK"},
    "scene/test_typed_scenes.py": {"holdfast.scene.formats.plain_data.MAX_DEPTH"},
}


def is_numeric(value: object) -> bool:
    """A number, or a row of them."""
    if isinstance(value, tuple | list | frozenset | set):
        return bool(value) and all(is_numeric(part) for part in value)
    return isinstance(value, Number) and not isinstance(value, bool)


@cache
def value_of(module: str, name: str) -> object:
    """What a name in a module is; None for one that a missing extra hides."""
    try:
        return getattr(importlib.import_module(module), name, None)
    except ImportError:
        return None


def numbers_imported(source: str) -> Iterator[str]:
    """The numbers of holdfast that a module takes, as ``module.NAME``: imported, or reached through the module."""
    tree = ast.parse(source)
    modules: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            modules |= {a.asname or a.name: a.name for a in node.names if a.name.split(".")[0] == "holdfast"}
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "holdfast" and not node.level:
            for alias in node.names:
                modules[alias.asname or alias.name] = f"{node.module}.{alias.name}"
                if CAPITALS.fullmatch(alias.name) and is_numeric(value_of(str(node.module), alias.name)):
                    yield f"{node.module}.{alias.name}"
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and CAPITALS.fullmatch(node.attr) and isinstance(node.ctx, ast.Load):
            module = modules.get(ast.unparse(node.value), "")
            if module and is_numeric(value_of(module, node.attr)):
                yield f"{module}.{node.attr}"


def offenders() -> dict[str, set[str]]:
    found = {
        path.relative_to(TESTS).as_posix(): set(numbers_imported(path.read_text(encoding="utf-8")))
        for path in sorted(TESTS.rglob("*.py"))
    }
    return {module: names for module, names in found.items() if names}


def test_no_test_imports_a_number_of_what_it_checks() -> None:
    found = offenders()
    assert {module: more for module, names in found.items() if (more := names - LEFT.get(module, set()))} == {}


def test_what_is_left_is_still_there() -> None:
    found = offenders()
    assert {module: gone for module, names in LEFT.items() if (gone := names - found.get(module, set()))} == {}


@pytest.mark.parametrize("source", [
    "from holdfast.base.kinds import LARGEST as MOST",
    "def f():\n    from holdfast.base.kinds import LARGEST",
    "from holdfast.base import kinds\nx = kinds.LARGEST",
    "import holdfast.base.kinds as k\nx = 2 * k.LARGEST",
    "import holdfast.base.kinds\nx = holdfast.base.kinds.LARGEST",
])  # fmt: skip
def test_a_planted_import_is_found(source: str) -> None:
    assert len(list(numbers_imported(source))) == 1


@pytest.mark.parametrize("source", [
    "from holdfast.engines.verdict import Status\nx = Status.STABLE",
    "from holdfast.base.kinds import fits",
    "from holdfast.base.machine_code import FEATURES, FOLDER_VARIABLE",
    "import holdfast as hf\nx = hf.Status.STABLE",
    "import numpy as np\nx = np.NAN",
])  # fmt: skip
def test_what_is_no_number_may_be_imported(source: str) -> None:
    assert list(numbers_imported(source)) == []
