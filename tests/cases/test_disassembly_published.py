"""On the published interfaces nothing is called safe whose rest does not stand by an independent verdict."""

from __future__ import annotations

from pathlib import Path

import pytest
import shared

import holdfast as hf
from bench.baselines.fixed_point import Fixed, fixed_point
from holdfast.applications.disassembly.removal import Answer
from holdfast.assembly.contact_nodes import contact_nodes
from holdfast.engines.compliant.elastic_model import Places, elastic_model
from holdfast.engines.rest import find_rest

LONG = ("armadillo", "bridge")  # 366 bodies; verdicts that take minutes

pytestmark = [shared.needed, pytest.mark.slow]


@pytest.mark.parametrize("path", [p for p in shared.paths("published") if p.id not in LONG])
def test_what_is_safe_stands_by_other_verdicts(path: Path) -> None:
    data = shared.contents(path)
    interfaces = [hf.answers.Interface(tuple(i["between"]), i["polygon"], i["normal"]) for i in data["interfaces"]]
    assembly = hf.assemble(hf.load_scene(path), interfaces=interfaces)
    if hf.stability(assembly).status is not hf.Status.STABLE:
        with pytest.raises(hf.HoldfastError, match="only what stands"):
            hf.disassembly_order(assembly)
        return
    d = hf.disassembly_order(assembly)
    for step in range(len(d.order) + 1):
        left = frozenset(d.removals.names) - set(d.order[:step])
        for name in sorted(left):
            if d.removals.by_forces(name, left).answer is not Answer.SAFE:
                continue
            rest = assembly.without([*d.order[:step], name])
            assert not rest.hanging
            weight = rest.weight_wrench()
            assert find_rest(rest, weight).verdict.equilibrium_exists
            if rest.movable:
                nodes = contact_nodes(rest, 49, "quadrature")
                model = elastic_model(Places.at(rest, nodes), weight)
                assert fixed_point(rest, nodes, weight, model.k, model.rho).outcome is not Fixed.MOVES
