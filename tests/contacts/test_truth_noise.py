"""Contacts of bodies that are a little off: gaps, penetrations, tilts, and thin plates between."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from contact_truth import (
    CRISP,
    FLAT,
    UP,
    Case,
    Solid,
    apart,
    block,
    bond,
    by_pair,
    cells,
    common,
    floor,
    frame,
    motion,
    rectangle,
    shoelace,
    spin,
)

import holdfast as hf

SCENES: dict[str, Callable[[], Case]] = {**FLAT, "quarter bond": lambda: bond(10, 5, 0.25)}


def none_missed(assembly: hf.answers.Assembly, case: Case, share: float) -> None:
    """Every pair of the truth has its interface with that share of its area; others are flagged slivers."""
    found = by_pair(assembly.interfaces)
    for pair, truths in case.truth.items():
        assert frozenset(pair) in found, f"missed {pair}"
        interface = found.pop(frozenset(pair))
        sense = 1 if interface.bodies == pair else -1
        assert "sliver" not in interface.flags, f"{pair} is a sliver: {interface}"
        area = sum(t.area for t in truths)
        assert interface.area >= (1 - share) * area, f"{pair}: {interface.area} for {area}"
        assert interface.area <= (1 + share) * area, f"{pair}: {interface.area} for {area}"
        for truth in truths:
            along = [p.area for p in interface.patches if sense * p.normal @ truth.normal > np.cos(np.radians(1))]
            level_with = sum(t.area for t in truths if t.normal @ truth.normal > 0.999)
            assert sum(along) == pytest.approx(level_with, rel=share), f"{pair}: {sum(along)} along {truth.normal}"
    for interface in found.values():
        assert "sliver" in interface.flags, f"invented {interface}"


@pytest.mark.parametrize("moved", [False, True], ids=["plain", "moved"])
@pytest.mark.parametrize("amount", [1e-3, -1e-3], ids=["gap", "penetration"])
@pytest.mark.parametrize("name", SCENES)
def test_a_millimetre_too_far_or_too_near(name: str, amount: float, moved: bool) -> None:
    """Every contact open or overlapping by 1 mm, within 1.5 mm: nothing missed, nothing but slivers added."""
    case = SCENES[name]()
    case = case.placed(motion(3)) if moved else case
    with warnings.catch_warnings():
        warnings.simplefilter("error", hf.errors.HoldfastWarning)
        assembly = hf.assemble(case.displaced(amount).scene(), gap=1.5e-3, angle_degrees=1)
    none_missed(assembly, case, 0.08)


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("name", SCENES)
def test_a_third_of_a_degree_askew(name: str, seed: int) -> None:
    """Every body turned by 0.3 degrees about an axis of its own, within 3 mm and 1 degree."""
    case = SCENES[name]()
    assembly = hf.assemble(case.tilted(0.3, seed).scene(), gap=3e-3, angle_degrees=1)
    none_missed(assembly, case, 0.08)


@pytest.mark.parametrize("amount", [1e-3, 0.0, -1e-3], ids=["gap", "exact", "penetration"])
@pytest.mark.parametrize("name", CRISP)
def test_lines_and_points_a_millimetre_off(name: str, amount: float) -> None:
    """Found all the same, about where they were, no wider than the tilt limit makes them."""
    case = CRISP[name]().placed(motion(9))
    found = by_pair(hf.assemble(case.displaced(amount).scene(), gap=1.5e-3, angle_degrees=1).interfaces)
    assert {frozenset(pair) for pair in case.truth} == set(found)
    for pair, truths in case.truth.items():
        interface = found[frozenset(pair)]
        sense = 1 if interface.bodies == pair else -1
        for truth in truths:
            near = [p for p in interface.patches if sense * p.normal @ truth.normal > np.cos(np.radians(1.5))]
            assert near, f"{pair}: no patch along {truth.normal}"
            # a crossing of blunt edges moves along them by several times the gap
            assert min(apart(p.hull, truth.hull) for p in near) < 6e-3, f"{pair}"
        assert interface.area <= sum(t.area for t in truths) * 1.05 + 1e-9


def sandwich(
    plate: Solid, *, sink: float = 0.0, gap: float = 2e-3, turn: bool = False, order: tuple[int, ...] = (0, 1, 2)
) -> dict[frozenset[str], hf.answers.Interface]:
    """A plate of 1 mm on a cube, another cube on the plate, each ``sink`` into the other; interfaces by pair."""
    below = replace(block("below", (0.1, 0.1, 0.1), (0, 0, -0.05)), fixed=True)
    above = block("above", (0.1, 0.1, 0.1), (0, 0, 0.051 - 2 * sink))
    solids = (below, replace(plate, pose=frame(z=-sink) @ plate.pose), above)
    case = Case(tuple(solids[k] for k in order), {}).placed(motion(4) if turn else np.eye(4))
    return by_pair(hf.assemble(case.scene(), gap=gap).interfaces)


def sheet(width: float, depth: float, x: float = 0, y: float = 0, degrees: float = 0) -> Solid:
    return Solid("plate", hf.Box(np.array([width, depth, 1e-3])), frame(x, y, 5e-4, spin(degrees)), step=UP)


BOXES = frozenset(("below", "above"))
OTHERS = {frozenset(("below", "plate")), frozenset(("plate", "above"))}


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
@pytest.mark.parametrize("size", [0.1, 0.14])
def test_boxes_do_not_touch_through_a_plate(order: tuple[int, ...], size: float) -> None:
    found = sandwich(sheet(size, size), order=order)
    assert set(found) == OTHERS
    for interface in found.values():
        assert interface.area == pytest.approx(0.01, rel=1e-9)


@pytest.mark.parametrize("sink", [-2e-4, 2e-4])
def test_nor_when_the_plate_sits_loose_or_deep(sink: float) -> None:
    assert set(sandwich(sheet(0.12, 0.12), sink=sink, turn=True)) == OTHERS


def test_two_plates_hide_the_boxes_and_the_far_plate() -> None:
    """Two sheets of 0.5 mm: each touches only its neighbours."""
    low = Solid("low", hf.Box(np.array([0.1, 0.1, 5e-4])), frame(z=2.5e-4))
    high = Solid("high", hf.Box(np.array([0.1, 0.1, 5e-4])), frame(z=7.5e-4))
    below = replace(block("below", (0.1, 0.1, 0.1), (0, 0, -0.05)), fixed=True)
    above = block("above", (0.1, 0.1, 0.1), (0, 0, 0.051))
    found = by_pair(hf.assemble(Case((below, low, high, above), {}).scene(), gap=2e-3).interfaces)
    assert set(found) == {frozenset(p) for p in (("below", "low"), ("low", "high"), ("high", "above"))}


SQUARE = rectangle(0.1, 0.1)
WINDOW = cells(
    np.array([-0.06, -0.02, 0.03, 0.06]),
    np.array([-0.06, -0.03, 0.01, 0.06]),
    np.array([0, 1e-3]),
    np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]])[:, :, None],
)


@pytest.mark.parametrize("turn", [False, True])
@pytest.mark.parametrize(
    ("plate", "open_area"),
    [
        (sheet(0.05, 0.1, -0.025), 0.005),
        (sheet(0.1, 0.2, -0.05, 0, 0), 0.005),
        (sheet(0.2, 0.2, -0.1, 0.02, 20), 0.01 - shoelace(common(rectangle(0.2, 0.2, -0.1, 0.02, 20), SQUARE))),
        (sheet(0.04, 0.04, 0.01, 0.005, 33), 0.01 - 0.0016),
        (Solid("plate", WINDOW), 0.05 * 0.04),
    ],
    ids=["half", "half and beyond", "askew", "island", "window"],
)
def test_what_a_plate_leaves_open_still_touches(plate: Solid, open_area: float, turn: bool) -> None:
    """The boxes face each other at 1 mm beside the plate: that part is an interface, and says that it was cut."""
    found = sandwich(plate, turn=turn)
    assert set(found) == OTHERS | {BOXES}
    assert found[BOXES].area == pytest.approx(open_area, rel=1e-6)
    assert "occluded" in found[BOXES].flags
    for pair in OTHERS:
        assert found[pair].area == pytest.approx(0.01 - open_area, rel=1e-9)
        assert "occluded" not in found[pair].flags


def test_a_plate_beside_the_gap_hides_nothing() -> None:
    """The same plate next to the boxes, not between them."""
    found = sandwich(sheet(0.05, 0.1, 0.0755))
    assert found[BOXES].area == pytest.approx(0.01, rel=1e-9)
    assert "occluded" not in found[BOXES].flags


@pytest.mark.parametrize("distance", [1.01e-3, 5e-3])
def test_bodies_beyond_the_gap_are_not_joined(distance: float) -> None:
    """Face to face, edge to face and corner to face, just out of reach and 5 mm away."""
    tipped = frame(0.2, 0, distance + 0.05 * np.sqrt(2), spin(45, "x"))
    cubes = [
        block("flat", (0.1, 0.1, 0.1), (0, 0, 0.05 + distance)),
        Solid("edge", hf.Box(np.full(3, 0.1)), tipped),
        # a ball's triangles lie inside it by up to the sagitta, which is added to its gap
        Solid("ball", hf.Sphere(0.05), frame(-0.2, 0, 0.05 + distance + hf.Sphere(0.05).surface.sagitta)),
    ]
    assert hf.assemble(Case((floor(), *cubes), {}).scene(), gap=1e-3).interfaces == ()
