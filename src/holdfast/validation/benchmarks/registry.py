"""The one list of benchmark suites, each imported only when it runs."""

from __future__ import annotations

import importlib

from holdfast.base.errors import HoldfastError, message, nearest_of
from holdfast.validation.benchmarks.suite import Suite

# modules of this package, each with a SUITE of the same name
SUITES = (
    "baselines",
    "bounds",
    "cargo",
    "carriage",
    "compliant_maps",
    "constraint",
    "contacts",
    "dense",
    "disassembly",
    "edits",
    "graph_slanted",
    "imperfect",
    "maps",
    "messy",
    "paths",
    "pipeline",
    "placement",
    "questions",
    "reliability",
    "scaling",
    "scans",
    "settle",
    "startup",
    "table1",
    "table2",
    "table3",
    "transport",
)


def suite(name: str) -> Suite:
    """The suite of that name."""
    if name not in SUITES:
        raise HoldfastError(message("benchmark", f"{name!r} is unknown", nearest_of(name, SUITES)))
    found: Suite = importlib.import_module(f"holdfast.validation.benchmarks.{name}").SUITE
    return found
