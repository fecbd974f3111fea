"""The one list of benchmark suites, each imported only when it runs."""

from __future__ import annotations

import importlib

from bench.suite import Suite
from holdfast.base.errors import HoldfastError, message, nearest_of

# modules of this package, each with a SUITE of the same name
SUITES = (
    "amendments",
    "baselines",
    "bounds",
    "bricks",
    "calibration",
    "cargo",
    "carriage",
    "certificates",
    "checked_constraint",
    "compliant_maps",
    "constraint",
    "contacts",
    "crushed",
    "dense",
    "disassembly",
    "experiments",
    "firmer",
    "gradients",
    "graph_slanted",
    "held",
    "holding",
    "imperfect",
    "instant",
    "maps",
    "messy",
    "monitor",
    "paths",
    "pipeline",
    "placement",
    "poses",
    "questions",
    "resting",
    "reliability",
    "scaling",
    "scans",
    "settle",
    "startup",
    "table1",
    "table2",
    "table3",
    "transport",
    "trees",
)


def suite(name: str) -> Suite:
    """The suite of that name."""
    if name not in SUITES:
        raise HoldfastError(message("benchmark", f"{name!r} is unknown", nearest_of(name, SUITES)))
    found: Suite = importlib.import_module(f"bench.suites.{name}").SUITE
    return found
