"""The one list of benchmark suites, each imported only when it runs."""

from __future__ import annotations

import difflib
import importlib

from holdfast.base.errors import HoldfastError, message
from holdfast.validation.benchmarks.suite import Suite

# modules of this package, each with a SUITE of the same name
SUITES = (
    "baselines",
    "compliant_maps",
    "contacts",
    "disassembly",
    "graph_slanted",
    "maps",
    "messy",
    "pipeline",
    "placement",
    "reliability",
    "scaling",
    "table1",
    "table2",
    "table3",
    "transport",
)


def suite(name: str) -> Suite:
    """The suite of that name."""
    if name not in SUITES:
        near = difflib.get_close_matches(name, SUITES, n=1)
        remedy = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(SUITES)}"
        raise HoldfastError(message("benchmark", f"{name!r} is unknown", remedy))
    found: Suite = importlib.import_module(f"holdfast.validation.benchmarks.{name}").SUITE
    return found
