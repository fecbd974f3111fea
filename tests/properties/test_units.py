"""S3: one load has one answer, whatever the unit that it is given in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import holdfast as hf

CASE = Path(__file__).parents[3] / "shared" / "cases" / "v1" / "slope2204.yaml"
UNITS = (1.0, 0.1, 3.0, 9.81, 1e-4, 1234.5)


def loads(assembly: hf.answers.Assembly, rng: np.random.Generator) -> list[hf.Load]:
    """A random force and moment on two of the bodies, of the size of their weights."""
    found = []
    for body in rng.choice(np.array(assembly.movable, dtype=object), size=min(2, len(assembly.movable)), replace=False):
        force, moment = rng.normal(size=(2, 3)) * body.mass
        found.append(hf.Load(body.name, body.com_world, force, moment * 0.1 * assembly.size))
    return found


def in_unit(given: list[hf.Load], unit: float) -> list[hf.Load]:
    return [hf.Load(one.body, one.point, unit * one.force, unit * one.moment) for one in given]


@pytest.mark.parametrize("engine", ["compliant", "limit"])
@pytest.mark.parametrize("name", ["table", "slope_two", "arch", "v_groove", "tabletop", "wedged_floor"])
def test_a_load_in_other_units_has_the_same_answer(name: str, engine: str) -> None:
    assembly, rng = hf.assemble(hf.shipped_scene(name)), np.random.default_rng(3)
    for _ in range(4):
        one = loads(assembly, rng)
        found = [hf.load_factor(assembly, in_unit(one, unit), engine=engine) for unit in UNITS]
        for unit, other in zip(UNITS, found, strict=True):
            assert other.status is found[0].status
            assert unit * other.factor == pytest.approx(found[0].factor, rel=1e-6)
            assert unit * other.lower == pytest.approx(found[0].lower, rel=1e-6)


@pytest.mark.skipif(not CASE.is_file(), reason=f"needs {CASE}")
def test_a_load_near_two_peaks_has_one_answer() -> None:
    """It was 0.0343 g in three units and 0.0409 g in three.

    All forces act along one line and none twists a contact, so that friction asked for is the slope's: less than it has
    everywhere. The upper three tip where the centre of what b1 presses with reaches the edge of its disc, or of b0's.
    """
    assembly = hf.assemble(hf.load_scene(CASE))
    (tips,) = [share for share in np.linspace(0, 0.1, 100_001) if not _centred(assembly, share)][:1]
    for unit in UNITS:
        pulls = [
            hf.Load(body.name, at, (unit * body.mass, 0, 0))
            for body, at in zip(assembly.movable, assembly.com, strict=True)
        ]
        found = hf.load_factor(assembly, pulls)
        assert unit * found.factor / 9.81 == pytest.approx(tips, rel=1e-4)
        assert unit * found.lower / 9.81 == pytest.approx(tips, rel=1e-4)


def _centred(assembly: hf.answers.Assembly, share: float) -> bool:
    """Whether the resultant of three upper cylinders of a tower, pulled along x, meets both discs that touch below."""
    low, high = assembly.movable[0], assembly.movable[1]
    up, pull = low.pose[:3, 2], np.array([share, 0, -1.0])
    mass, com = assembly.mass[1:], assembly.com[1:]
    middle = mass @ com / mass.sum()
    foot = high.pose[:3, 3] - up * high.shape.height / 2
    place = middle + pull * ((foot - middle) @ up) / (pull @ up)
    for body in (low, high):
        x, y = body.pose[:3, :2].T @ (place - body.pose[:3, 3])
        angle = np.pi / body.shape.segments
        turned = np.remainder(np.arctan2(y, x), 2 * angle) - angle  # from the middle of a side of the polygon
        if np.hypot(x, y) * np.cos(turned) > body.shape.radius * np.cos(angle):
            return False
    return True
