"""Mean relative error of ``graph`` against the decoupled truth over 1,000 random normal pushes (paper, Table I)."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

import holdfast as hf
from holdfast.shipped import shipped_scene

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "tests" / "closed_form"))

from test_graph_truth import pushes, truth  # noqa: E402 - the tests own the truth

CASES = {
    "cube": ("cube", ["cube"], 0.00),
    "stack": ("stack", ["cube1", "cube2", "cube3"], 1.00),
    "table slab": ("table", ["slab"], 1.20),
    "table, all bodies": ("table", ["slab", "leg_left", "leg_right"], 1.20),
}


def measure() -> list[dict[str, Any]]:
    rows = []
    for label, (scene, names, printed) in CASES.items():
        built = shipped_scene(scene)
        assembly = hf.assemble(built)
        errors, wrong, total = [], 0, 0
        for name, points, normals in pushes(built, names, 1000, seed=0):
            answer = hf.robustness(assembly, name, points, -normals, engine="graph").force
            exact = truth(scene, name, points, normals)
            both = np.isfinite(answer) & np.isfinite(exact)
            errors.append(np.abs(answer[both] / exact[both] - 1))
            wrong += int((np.isfinite(answer) != np.isfinite(exact)).sum())
            total += len(points)
        error = 100 * np.concatenate(errors)
        rows.append(
            {
                "case": label,
                "pushes": total,
                "mean error %": float(error.mean()),
                "worst error %": float(error.max()),
                "class differs": wrong,
                "paper mean error %": printed,
            }
        )
    return rows
