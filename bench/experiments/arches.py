"""How thin a circular arch may be, by its friction: Cocchetti and Rizzi 2020."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

import holdfast as hf
from bench.experiments.source import Source, balances, least, row, threshold
from bench.suite import Case, Row

CONTINUOUS = {
    0.395832: "0.107426",
    0.309215: "0.200637",
}  # the corners of the curve of an arch that has a joint anywhere
VOUSSOIRS = {  # own linear programs
    13: {0.7: "0.10253", 0.38: "0.11604", 0.33: "0.17077", 0.31: "0.19461"},
    27: {0.7: "0.10672", 0.38: "0.12112", 0.33: "0.17265", 0.31: "0.19600"},
}
LEAST_FRICTION = {13: "0.3051", 27: "0.3090"}
MANY = 55
WHY = f"joints only between {MANY} voussoirs, not everywhere"


def arch(count: int, thickness: float, mu: float, *, half_angle: float = np.pi / 2, radius: float = 1.0) -> hf.Scene:
    """Voussoirs with straight sides and radial joints between fixed ends; thickness over the mean radius."""
    angles = np.linspace(-half_angle, half_angle, count + 1)
    rim = [radius * (1 + side * thickness / 2) * np.column_stack([np.sin(angles), np.cos(angles)]) for side in (-1, 1)]

    def prism(name: str, quad: np.ndarray, *, fixed: bool = False) -> hf.Body:
        vertices = np.vstack([np.column_stack([quad[:, 0], np.full(4, y), quad[:, 1]]) for y in (0.0, radius)])
        faces = [[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]]
        faces += [t for k in range(4) for t in ([k, 4 + k, 4 + (k + 1) % 4], [k, 4 + (k + 1) % 4, (k + 1) % 4])]
        return hf.Body(name, hf.Mesh(vertices, np.array(faces)), density=None if fixed else 2000.0, fixed=fixed)

    quads = [np.array([rim[0][k], rim[1][k], rim[1][k + 1], rim[0][k + 1]]) for k in range(count)]
    bodies = [prism(f"v{k}", quad) for k, quad in enumerate(quads)]
    for name, k, sign in (("left", 0, -1), ("right", count, 1)):
        along = radius * sign * np.array([np.cos(angles[k]), -np.sin(angles[k])])
        ends = [rim[0][k], rim[1][k], rim[1][k] + along, rim[0][k] + along]
        bodies.append(prism(name, np.array(ends if sign > 0 else ends[::-1]), fixed=True))
    return hf.Scene(bodies, friction=mu)


def _thickness(count: int, mu: float, printed: str) -> list[Row]:
    ends = (0.98 * float(printed), 1.02 * float(printed))
    case = f"arch, {count} voussoirs, friction {mu:g}"
    return [threshold(case, printed, lambda thickness: arch(count, thickness, mu), ends) | {"friction": mu}]


def thinnest(count: int, mu: float, accuracy: float, ends: tuple[float, float] = (0.09, 0.21)) -> float:
    """The least thickness at which an equilibrium exists."""
    return least(lambda thickness: balances(arch(count, thickness, mu)), *ends, accuracy)


def _continuous(mu: float, printed: str) -> list[Row]:
    found = thinnest(MANY, mu, 1e-5, (0.97 * float(printed), 1.03 * float(printed)))
    return [row(f"arch, joints anywhere, friction {mu:g}", printed, "limit", WHY, limit=found) | {"friction": mu}]


def _curve() -> list[Row]:
    mus = [0.31, 0.33, 0.35, 0.37, 0.385, 0.39, 0.395, 0.7]
    return [
        {
            "case": "arch, 27 voussoirs, by friction",
            "friction": mus,
            "limit": [round(thinnest(27, mu, 2e-4), 4) for mu in mus],
        }
    ]


def _friction(count: int) -> list[Row]:
    case = f"arch as thick as one likes, {count} voussoirs: friction"
    return [threshold(case, LEAST_FRICTION[count], lambda mu: arch(count, 0.3, mu), (0.3, 0.32))]


def cases() -> Mapping[str, Case]:
    """One case for each number of voussoirs and friction."""
    found: dict[str, Case] = {f"arch {mu}": partial(_continuous, mu, text) for mu, text in CONTINUOUS.items()}
    for count, rows in VOUSSOIRS.items():
        found |= {f"arch {count} {mu}": partial(_thickness, count, mu, text) for mu, text in rows.items()}
        found[f"arch {count}"] = partial(_friction, count)
    return found | {"arch curve": _curve}


SOURCE = Source(
    "arches",
    "G. Cocchetti, E. Rizzi, Frattura ed Integrità Strutturale 51 (2020) 356-375, after M. Milankovitch 1907;"
    " for finite numbers of voussoirs own linear programs",
    "the least thickness, over the mean radius, of a semicircular arch that stands",
    "equal voussoirs with straight sides and radial joints between fixed ends",
    cases,
)
