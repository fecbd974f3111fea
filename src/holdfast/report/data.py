"""Answers as plain data that every JSON reader takes: infinity is the text "inf", arrays are lists."""

from __future__ import annotations

import dataclasses
import math
from enum import Enum
from typing import Any

import numpy as np

from holdfast.applications.transport import TransportLimits
from holdfast.assembly.assembly import Assembly
from holdfast.engines.contract import Mechanism
from holdfast.queries.map import MapPoint, RobustnessMap
from holdfast.queries.stability import Stability


def plain(value: Any) -> Any:  # noqa: ANN401 - any result to plain data
    """Dicts, lists, texts, numbers and None; keys are attribute names."""
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, Mechanism):
        return {name: plain(getattr(value, name)) for name in ("moving", "twists", "mode", "text")}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, float):
        if math.isnan(value):
            raise ValueError("an answer holds NaN: a defect in holdfast")
        return value if math.isfinite(value) else "inf" if value > 0 else "-inf"
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


def interfaces_data(assembly: Assembly) -> list[dict[str, Any]]:
    """The interfaces of an assembly."""
    return [
        {
            "bodies": list(interface.bodies),
            "area": interface.area,
            "status": interface.status,
            "flags": list(interface.flags),
            "mu": mu,
            "patches": [{"polygon": p.polygon.tolist(), "normal": p.normal.tolist()} for p in interface.patches],
        }
        for interface, mu in zip(assembly.interfaces, assembly.mu, strict=True)
    ]


def stability_data(assembly: Assembly, result: Stability) -> dict[str, Any]:
    """What ``holdfast assess --json`` prints."""
    data: dict[str, Any] = plain(result)
    return {
        "scene": assembly.scene.name,
        **data,
        "gap": assembly.tolerances.gap,
        "angle": assembly.tolerances.angle,
        "overlaps": plain(assembly.overlaps),
        "interfaces": interfaces_data(assembly),
    }


def map_data(result: RobustnessMap) -> dict[str, Any]:
    """What ``holdfast map --json`` prints."""
    names = ("points", "normals", "body", "force", "status", "lower", "upper", "moving", "mode", "notes")
    data: dict[str, Any] = {name: plain(getattr(result, name)) for name in names}
    weakest: list[MapPoint] = list(result.weakest_of_each_body())
    return {
        "scene": result.assembly.scene.name,
        "engine": result.engine,
        "claim": result.claim.value,
        "verdict": {"status": result.verdict.status.value, "reason": result.verdict.reason},
        "weakest": plain(result.weakest()),
        "weakest_of_each_body": plain(weakest),
        **data,
    }


def transport_data(result: TransportLimits) -> dict[str, Any]:
    """What ``holdfast transport --json`` prints."""
    names = ("directions", "acceleration", "status", "lower", "upper", "moving", "mode", "mechanism", "notes")
    return {
        "scene": result.assembly.scene.name,
        "engine": result.engine,
        "claim": result.claim.value,
        "verdict": {"status": result.verdict.status.value, "reason": result.verdict.reason},
        "gravity": plain(result.assembly.scene.gravity),
        **{name: plain(getattr(result, name)) for name in names},
    }
