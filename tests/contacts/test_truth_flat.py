"""Contacts against closed forms, flat ones and lines and points: plain, moved, of any size, in either order."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from contact_truth import (
    CRISP,
    FLAT,
    Case,
    Solid,
    agree,
    aligned,
    by_pair,
    irregular,
    motion,
    peg,
    regular,
)

import holdfast as hf
from holdfast.base.arrays import Float, Int
from holdfast.scene.shipped import shipped_scene

# bodies that rest on each other exactly must not be called overlapping; scenes of a kilometre may be remarked upon
pytestmark = [
    pytest.mark.filterwarnings("error::holdfast.errors.HoldfastWarning"),
    pytest.mark.filterwarnings("ignore:.* across:holdfast.errors.HoldfastWarning"),
]

SCENES = {**FLAT, "peg": peg}
ALL = {**SCENES, **CRISP}
SMALL = [n for n in SCENES if n not in ("half bond", "stack bond", "chequered")]
NOT_AT_EXACT_POSES = {"sliver", "occluded", "ambiguous_gap", "not_manifold", "orientation_unknown"}


@pytest.mark.parametrize(("moved", "scale"), [(False, 1.0), (True, 1e-3), (True, 1.0), (True, 1e3)])
@pytest.mark.parametrize("name", ALL)
def test_hulls_normals_and_areas_are_exact(name: str, moved: bool, scale: float) -> None:
    """To 1e-9 m and 1e-9 relative; in larger and smaller scenes the lengths along."""
    case = ALL[name]().placed(motion(len(name)) if moved else np.eye(4), scale)
    interfaces = hf.assemble(case.scene(), allow_large=True).interfaces
    agree(interfaces, case, 1e-9 * scale, 1e-9)
    for interface in interfaces if name in SCENES else ():
        assert interface.status == "touching"
        assert not NOT_AT_EXACT_POSES & set(interface.flags), interface


@pytest.mark.parametrize("name", SMALL)
def test_no_motion_changes_anything(name: str) -> None:
    """Rounding differs with each: pieces that meet along edges, crumbs of next to no area, rings that nearly close."""
    for seed in range(100, 108):
        case = SCENES[name]().placed(motion(seed))
        agree(hf.assemble(case.scene()).interfaces, case, 1e-9, 1e-9)


@pytest.mark.parametrize("seed", [None, *range(5)])
def test_the_shipped_wall_brick_by_brick(seed: int | None) -> None:
    """Quarter bond, 126 rectangles; each one from the intervals of its two bricks.

    In other frames clipped pieces meet along edges up to rounding; their union must neither fail nor drop one.
    """
    scene = shipped_scene("bonded_wall")
    solids = tuple(Solid(b.name, b.shape, np.asarray(b.pose), b.fixed) for b in scene.bodies)
    case = Case(solids, aligned(solids))
    assert len(case.truth) == 126
    case = case if seed is None else case.placed(motion(seed))
    agree(hf.assemble(case.scene()).interfaces, case, 1e-9, 1e-9)


WALLS = [pytest.param(n, irregular, marks=pytest.mark.slow) for n in ("half bond", "stack bond", "chequered")]
FINE = [(n, irregular) for n in SMALL] + [(n, regular) for n in ("turned stack", "cans", "bowl", "interlock")]


@pytest.mark.parametrize(("name", "how"), [*FINE, *WALLS])
def test_fine_triangles_change_nothing(name: str, how: Callable[[Float, Int], tuple[Float, Int]]) -> None:
    """20,000 triangles a body and more, regular or with vertices strewn over the faces: the same to 1e-6."""
    case = SCENES[name]()
    fine = case.remeshed(how)
    assert min(len(s.shape.surface.faces) for s in fine.solids) >= 20_000
    agree(hf.assemble(fine.placed(motion(5)).scene()).interfaces, case.placed(motion(5)), 1e-7, 1e-6)


@pytest.mark.parametrize("name", ALL)
def test_the_other_order_gives_the_mirrored_interfaces(name: str) -> None:
    case = ALL[name]()
    forth = by_pair(hf.assemble(case.scene()).interfaces)
    back = hf.assemble(case.scene(reverse=True)).interfaces
    agree(back, case, 1e-9, 1e-9)
    for interface in back:
        assert forth[frozenset(interface.bodies)].bodies == interface.bodies[::-1]
