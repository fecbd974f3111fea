"""No verdict STABLE where bodies fall: random scenes of which many all but do, beside finer nodes and MuJoCo."""

from __future__ import annotations

import pytest
from verdict_scenes import FAMILIES, drawn

from holdfast import Compliant, Status, assemble, stability
from holdfast.answers import Assembly

FEW, MANY = 6, 100  # scenes of a family by default, and where there is time
FINE = 25  # nodes a side of the grid that has to hold them, too
CLOSE = 1e-4  # [s] time step at which a simulated fall counts: five times as long ones let slopes of blocks go


def stable(assembly: Assembly) -> bool:
    """Whether an engine that promises something says so."""
    return any(stability(assembly, engine=engine).status is Status.STABLE for engine in ("limit", "compliant"))


def holds(assembly: Assembly) -> bool:
    """Whether it comes to rest on fine nodes, whatever they have in reserve."""
    return Compliant(nodes=FINE).on(assembly, assembly.weight_wrench()).verdict().status is Status.STABLE


@pytest.mark.parametrize("family", FAMILIES)
def test_what_is_stable_rests_on_fine_nodes(family: str) -> None:
    said = [assembly for assembly in (assemble(drawn(family, k)) for k in range(FEW)) if stable(assembly)]
    assert said
    assert all(holds(assembly) for assembly in said)


@pytest.mark.referee
@pytest.mark.parametrize("family", FAMILIES)
def test_what_is_stable_stays_in_a_simulation(family: str) -> None:
    pytest.importorskip("mujoco", reason="the drop test needs MuJoCo: pip install -e '.[bench]'")
    from bench.baselines.drop import drop

    said, fallen = 0, []
    for number in range(MANY):
        assembly = assemble(drawn(family, number))
        if not stable(assembly):
            continue
        said += 1
        if not holds(assembly):
            fallen.append((number, "on fine nodes"))
        elif not drop(assembly, lift=0).stands and not drop(assembly, lift=0, step=CLOSE).stands:
            fallen.append((number, "in the simulation"))
    assert said >= MANY / 5
    assert not fallen
