"""250 pushes of a triangle by a robot: Zhou, Paolini, Bagnell and Mason 2016. Only summary numbers are saved."""

from __future__ import annotations

import csv
import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

import holdfast as hf
from bench.checkout import CASES
from bench.experiments.source import ENGINES, Source, block
from bench.suite import Case, Row
from holdfast.base.arrays import Float

FILE = CASES / "experiments" / "pushes_hardboard.csv"
MASS, G = 1.518, 9.8  # [kg], and [m/s²] as the authors have it
SETS = {  # by the places of the feet in the file
    "10_130_10_10_10_130": "feet at the corners",
    "10_90_10_10_30_130": "feet askew",
    "30_90_30_30_30_90": "feet half way in",
    "30_63.33_43.33_30_43.33_63.33": "feet near the middle",
    "patch": "whole face",
}
ARMS = (0, 15, 30, 50, 110)  # [mm]
TURNS = 0.02  # [rad]; less is taken for no rotation
RANGES = (0.1, 0.2, 0.3)  # relative width of friction
SAMPLES = 200
FACES = hf.Imperfect(2e-4, material="wood")  # as docs/explanation/near_hardware.md has it for wood


NEAR, APART = "30_63.33_43.33_30_43.33_63.33", 2.0  # the set that scatters most; its feet moved out or in [mm]


@dataclass(frozen=True, eq=False)
class Pushes:
    """One set: at ``points`` (n, 3) [m] ``along`` (n, 3), the forces ``measured`` (n,) [N], and what is predicted.

    ``turned`` (n,) is the measured rotation [rad].
    """

    name: str
    mu: float
    assembly: hf.answers.Assembly
    points: Float
    along: Float
    measured: Float
    turned: Float

    @property
    def arm(self) -> Float:
        """Lever arms (n,) about the centre of mass [mm]."""
        (x, y, _), (ex, ey, _) = self.points.T, self.along.T
        return np.asarray(1000 * np.abs(x * ey - y * ex))

    @cached_property
    def spin(self) -> Float:
        """The rates (n,) of turning about the vertical with which each push begins, at any scale."""
        found = hf.robustness(self.assembly, "triangle", self.points, self.along)
        return np.array([mechanism.twists[0, 5] for mechanism in found.mechanism])

    @cached_property
    def predicted(self) -> dict[str, Float]:
        """Forces (n,) [N] by the engines and a null model that knows no points, and what doubts leave of them."""
        asked = (self.assembly, "triangle", self.points, self.along)
        found = {engine: hf.robustness(*asked, engine=engine).force for engine in ENGINES}
        found["μ m g"] = np.full(len(self.points), self.mu * MASS * G)
        found["lower"] = hf.robustness(*asked).lower
        for width in RANGES:
            doubt = hf.sets.Uncertain(mu_range=width, samples=SAMPLES)
            found[f"5 % quantile, friction within {width:.0%}"] = hf.robustness_under(*asked, doubt).quantile(0.05)
        found["lower, wooden faces"] = hf.robustness(*asked, imperfect=FACES).lower
        return found


def triangle(support: str, mu: float) -> hf.Scene:
    """The triangle about its centre of mass, on a whole face or on three feet of 2 x 2 x 2 mm."""
    low = 0.0 if support == "patch" else 0.002
    corners = np.array([[0, 0], [0.15, 0], [0, 0.15]]) - 0.05
    vertices = np.vstack([np.column_stack([corners, np.full(3, z)]) for z in (low, low + 0.05)])
    faces = [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]]
    shape: Any = hf.Mesh(vertices, np.array(faces))
    if support != "patch":
        places = np.array([float(word) for word in support.split("_")]).reshape(2, 3).T / 1000 - 0.05
        feet = [block("foot", (0.002,) * 3, (x, y, 0.001)) for x, y in places]
        shape = hf.Compound([shape, *(hf.Part(foot.shape, foot.pose) for foot in feet)])
    body = hf.Body("triangle", shape, mass=MASS, com=(0, 0, low + 0.025))
    return hf.Scene([hf.Body("board", hf.HalfSpace(), fixed=True), body], friction=mu, gravity=(0, 0, -G))


def sets() -> Iterator[Pushes]:
    """Every set of pushes."""
    with FILE.open() as stream:
        rows = list(csv.DictReader(stream))
    names = ("point_x", "point_y", "point_z", "dir_x", "dir_y", "measured_N", "rot_rad")
    for (support, mu), group in itertools.groupby(rows, lambda row: (row["support_mm_from_corner"], row["mu_authors"])):
        x, y, z, dx, dy, force, turned = np.array([[float(push[name]) for name in names] for push in group]).T
        points, along = np.column_stack([x, y, z]), np.column_stack([dx, dy, np.zeros(len(dx))])
        assembly = hf.assemble(triangle(support, float(mu)))
        yield Pushes(SETS[support], float(mu), assembly, points, along, force, turned)


def by_set(pushes: Pushes) -> Row:
    """Medians and scatter of predicted over measured, the friction that central pushes see, the sense of rotation."""
    found: Row = {"case": f"pushes, {pushes.name}", "pushes": len(pushes.measured), "friction": pushes.mu}
    central = pushes.arm < ARMS[1]
    found["friction seen"] = float(np.median(pushes.measured[central])) / (MASS * G)
    for name in (*ENGINES, "μ m g"):
        ratio = pushes.predicted[name] / pushes.measured
        found |= {name: float(np.median(ratio)), f"{name}, scatter": float(ratio.std() / ratio.mean())}
    turning = np.abs(pushes.turned) > TURNS
    right = turning & (np.sign(pushes.spin) == np.sign(pushes.turned))
    found["measured twice"] = int((pushes.measured > 2 * pushes.predicted["compliant"]).sum())
    return found | {"turn": int(turning.sum()), "turn as predicted": int(right.sum())}


def _by_arm(pushes: Pushes) -> Iterator[Row]:
    """Medians and the range of 80 % of predicted over measured, for each range of lever arms."""
    for low, high in itertools.pairwise(ARMS):
        here = (pushes.arm >= low) & (pushes.arm < high)
        found: Row = {
            "case": f"pushes, {pushes.name}, {low} to {high} mm",
            "set": pushes.name,
            "pushes": int(here.sum()),
        }
        found |= {"arm mm": float(np.median(pushes.arm[here]))}
        for name in (*ENGINES, "μ m g"):
            ratio = (pushes.predicted[name] / pushes.measured)[here]
            found[name] = float(np.median(ratio))
            found |= {f"{name}, {share} %": float(np.quantile(ratio, share / 100)) for share in (10, 90)}
        yield found


def margins(every: list[Pushes]) -> Iterator[Row]:
    """How many of the pushes measured more than each number that a robot might take."""
    face = [pushes for pushes in every if pushes.name == "whole face"]
    kinds = {"all": every, "feet": [pushes for pushes in every if pushes not in face], "whole face": face}
    for name in every[0].predicted:
        for share in (1.0, 0.9, 0.8) if name == "compliant" else (1.0,):
            found: Row = {"case": f"margin: {f'{share:g} ' if share < 1 else ''}{name}"}
            for kind, some in kinds.items():
                ratio = share * _ratio(some, name)
                found |= {
                    f"{kind}, above %": 100 * float((ratio <= 1).mean()),
                    f"{kind}, median": float(np.median(ratio)),
                }
            yield found | {"all, most": share * float(_ratio(every, name).max())}


def _ratio(every: list[Pushes], name: str) -> Float:
    """Predicted over measured of all pushes, by one method."""
    return np.concatenate([pushes.predicted[name] / pushes.measured for pushes in every])


def _fit(every: list[Pushes], name: str) -> float:
    """R² of a method over all pushes."""
    measured = np.concatenate([pushes.measured for pushes in every])
    off = np.concatenate([pushes.predicted[name] for pushes in every]) - measured
    return 1 - float((off**2).sum() / ((measured - measured.mean()) ** 2).sum())


def band(face: Pushes) -> Row:
    """Pushes of the whole face between ``compliant`` and ``limit``, both with the friction that central pushes see."""
    away = face.arm >= ARMS[1]
    seen = float(np.median(face.measured[~away])) / (MASS * G) / face.mu
    low, high = (seen * face.predicted[name][away] for name in ("compliant", "limit"))
    measured = face.measured[away]
    inside = (measured >= 0.95 * low) & (measured <= 1.05 * high)
    return {"case": "whole face: band", "pushes": int(away.sum()), "inside": int(inside.sum())} | {
        "below": int((measured < 0.95 * low).sum()),
        "above": int((measured > 1.05 * high).sum()),
    }


def _moved(near: Pushes) -> Iterator[Row]:
    """What two millimetres in the places of feet that stand close together do at the longest lever arms."""
    far = near.arm >= ARMS[-2]
    for out in (-APART, 0.0, APART):
        support = "_".join(str(float(word) + out * np.sign(float(word) - 45)) for word in NEAR.split("_"))
        found = hf.robustness(triangle(support, near.mu), "triangle", near.points[far], near.along[far])
        ratio = found.force / near.measured[far]
        yield {
            "case": f"feet near the middle, moved out by {out:g} mm",
            "pushes": int(far.sum()),
            "median": float(np.median(ratio)),
        }


def _all() -> list[Row]:
    every = list(sets())
    rows = [by_set(pushes) for pushes in every]
    rows += [found for pushes in every for found in _by_arm(pushes)]
    rows += margins(every)
    rows += _moved(next(pushes for pushes in every if pushes.name == SETS[NEAR]))
    rows.append({"case": "pushes, R²"} | {name: _fit(every, name) for name in (*ENGINES, "μ m g")})
    return [*rows, band(next(pushes for pushes in every if pushes.name == "whole face"))]


def cases() -> Mapping[str, Case]:
    """All sets at once, where the logs are at hand."""
    return {"pushes": _all} if FILE.exists() else {}


SOURCE = Source(
    "pushes",
    "J. Zhou, R. Paolini, J. A. Bagnell, M. T. Mason, A convex polynomial force-motion model for planar sliding:"
    " identification and application, ICRA 2016, 372-377",
    "the mean force of a finger that pushes a triangle of aluminium over hardboard, at random points and directions",
    "their friction, 4.2 N over m g = 0.2823; feet of 2 x 2 mm; nothing is fitted",
    cases,
)
