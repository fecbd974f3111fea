"""Answers as plain data for ``--json``: ``to_dict`` and, in addition, data of the assembly."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.strengths import strengths_of
from holdfast.base.archive import to_dict
from holdfast.queries.stability import Stability

if TYPE_CHECKING:
    from holdfast.applications.placement.result import Placement


def interfaces_data(assembly: Assembly) -> list[dict[str, Any]]:
    """Return the interfaces of an assembly as plain data."""
    return [
        {
            "bodies": list(interface.bodies),
            "area": interface.area,
            "status": interface.status,
            "flags": list(interface.flags),
            "certain": interface.certain,
            "gap": gap,
            "mu": mu,
            "tension": strength.tension,
            "patches": [{"polygon": p.polygon.tolist(), "normal": p.normal.tolist()} for p in interface.patches],
        }
        for interface, mu, gap, strength in zip(
            assembly.interfaces, assembly.mu, assembly.gaps, strengths_of(assembly), strict=True
        )
    ]


def stability_data(assembly: Assembly, result: Stability) -> dict[str, Any]:
    """Return the data that ``holdfast assess --json`` prints."""
    return {
        "scene": assembly.scene.name,
        **result.to_dict(),
        "gap": assembly.tolerances.gap,
        "gap_by_pair": assembly.tolerances.by_pair,
        "angle_degrees": assembly.tolerances.angle,
        "overlaps": to_dict(assembly.overlaps),
        "interfaces": interfaces_data(assembly),
    }


def placement_data(result: Placement) -> dict[str, Any]:
    """Return the data that ``holdfast place --json`` prints."""
    contacts = [] if result.assembly is None else interfaces_data(result.assembly)
    return result.to_dict() | {"contacts": [contact for contact in contacts if result.name in contact["bodies"]]}
