"""Straps: over a box, direct lashings, the capstan, film, bands that pull only; forces conserved; errors told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import at, floor

G, MU, MASS, SIDE = 9.81, 0.4, 20.0, 0.4
X, Y, Z = np.eye(3)
PULL = 150.0  # [N]


def load() -> hf.answers.Assembly:
    """A low box on a wide floor: it slips before it topples."""
    cargo = hf.Body("box", hf.Box((SIDE, SIDE, 0.1)), mass=MASS, pose=at(0, 0, 0.05))
    return hf.assemble(hf.Scene([floor(4, 4), cargo], MU))


def over(pull: float = PULL, friction: float = 0.0) -> hf.Strap:
    """Straight down on both sides of the box, which is 0.1 m high."""
    h = SIDE / 2
    path = [("floor", (0, -h, 0)), ("box", (0, -h, 0.1)), ("box", (0, h, 0.1)), ("floor", (0, h, 0))]
    return hf.Strap(path, pull, mu=friction)


def limits(assembly: hf.answers.Assembly, ways: object, strap: hf.Strap | None, engine: str = "limit") -> np.ndarray:
    held = () if strap is None else strap.loads(assembly)
    return hf.transport_limits(assembly, ways, standing=held, engine=engine).acceleration


@pytest.mark.parametrize("engine", ["graph", "limit", "compliant"])
def test_a_strap_over_a_box_adds_friction(engine: str) -> None:
    """2 mu T beside mu m g."""
    ways = load().scene.horizontal_directions(8)
    assert limits(load(), ways, over(), engine) == pytest.approx(MU * G + 2 * MU * PULL / MASS, rel=1e-3)


@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_friction_at_the_edges_takes_tension(engine: str) -> None:
    """T, T exp(-mu pi/2), T exp(-mu pi): the far side presses less (Euler, Eytelwein); across, it turns the box."""
    edge = 0.3
    strap = over(friction=edge)
    assert strap.tensions == pytest.approx(PULL * np.exp(-edge * np.pi / 2 * np.arange(3)))
    down = PULL * (1 + np.exp(-edge * np.pi))
    along, across = limits(load(), [Y, X], strap, engine)
    assert along == pytest.approx(MU * G + MU * down / MASS, rel=1e-3)
    assert MU * G < across < along * 0.99


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_nothing_is_pulled_out_of_nowhere(friction: float) -> None:
    """Forces and moments on all bodies together are zero, and every straight piece pulls along itself."""
    rng = np.random.default_rng(1)
    path = [("floor", p) for p in rng.normal(size=(6, 3))]
    for closed in (False, True):
        strap = hf.Strap(path, 70.0, mu=0.0 if closed else friction, closed=closed)
        forces = strap.forces()
        assert forces.sum(0) == pytest.approx(np.zeros(3), abs=1e-9)
        assert np.cross(strap.points, forces).sum(0) == pytest.approx(np.zeros(3), abs=1e-9)
    ends = hf.Strap(path, 70.0, mu=friction)
    assert ends.forces()[0] @ (ends.points[1] - ends.points[0]) == pytest.approx(70.0 * ends.lengths[0])
    assert (np.diff(ends.tensions) <= 0).all()


@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_a_direct_lashing_pulls_along_and_presses(engine: str) -> None:
    """m a = T cos(theta) + mu (m g + T sin(theta)) against the way that it pulls, at the height of the centre."""
    anchor, hook = np.array((1.2, 0, 0)), np.array((SIDE / 2, 0, 0.05))
    pull = 40.0  # less than friction, or it would pull the load off
    strap = hf.Strap([("floor", anchor), ("box", hook)], pull)
    way = (anchor - hook) / np.linalg.norm(anchor - hook)
    found = limits(load(), [X, -X], strap, engine)
    friction = MU * (G - pull * way[2] / MASS)
    assert found == pytest.approx([friction + pull * way[0] / MASS, friction - pull * way[0] / MASS], rel=5e-3)
    off = hf.Strap([("floor", anchor), ("box", hook)], 2 * MU * MASS * G)
    assert hf.stability(load(), loads=off.loads(load()), engine=engine).status is hf.Status.UNSTABLE


def test_a_cut_strap_leaves_what_was_there() -> None:
    ways = load().scene.horizontal_directions(8)
    assert (limits(load(), ways, over(0.0)) == limits(load(), ways, None)).all()


def hooked(stiffness: float = 1e5) -> tuple[hf.answers.Assembly, hf.Strap]:
    strap = hf.Strap([("floor", (1.2, 0, 0)), ("box", (SIDE / 2, 0, 0.05))], PULL, spring=stiffness)
    return load(), strap


@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_bands_pull_and_never_push(engine: str) -> None:
    """A band alone: without end where it is drawn, and nothing at all the other way and across."""
    assembly, strap = hooked()
    tied = hf.Strap.tied(assembly, [strap], bedding=1e7)
    t = hf.transport_limits(tied, [X, -X], engine=engine)
    assert t.status[0] is hf.Status.INFINITE
    assert t.acceleration[1] == pytest.approx(MU * G, rel=2e-3)
    for a in (0.0, 0.3 * G, 0.8 * G, -0.3 * G):  # its force on the box, along the contact normal, towards the floor
        s = hf.stability(tied, loads=hf.sets.inertial_loads(tied, acceleration=a * X), engine=engine)
        assert s.forces is not None
        mine = s.forces.interface == len(assembly.interfaces)
        assert mine.any()
        pull = s.forces.force[mine].sum(0)
        assert pull @ (strap.points[0] - strap.points[1]) >= -1e-9
        assert (a >= 0.8 * G) <= (np.linalg.norm(pull) > 1)  # beyond friction it has to bear the rest


def test_what_a_band_bears_beyond_friction() -> None:
    """Equilibrium: T (cos + mu sin) = m (a - mu g) with the least tension that holds, and no more from `limit`."""
    assembly, strap = hooked()
    way = (strap.points[0] - strap.points[1]) / strap.lengths[0]
    a = 0.8 * G
    least = MASS * (a - MU * G) / (way[0] - MU * way[2])
    held = hf.Strap([("floor", strap.points[0]), ("box", strap.points[1])], 1.0)
    for pull, holds in ((1.01 * least, True), (0.99 * least, False)):
        c = hf.carry(assembly, [[0, a, 0, 0]], standing=hf.Strap(_path(held), pull).loads(assembly), engine="limit")
        assert (c.outcome is hf.Status.UNSTABLE) is not holds  # an equilibrium exists, which is not called held
    s = hf.stability(
        hf.Strap.tied(assembly, [strap], bedding=1e7),
        loads=hf.sets.inertial_loads(assembly, acceleration=a * X),
        engine="limit",
    )
    assert s.forces is not None
    pull = np.linalg.norm(s.forces.force[s.forces.interface == len(assembly.interfaces)].sum(0))
    assert pull >= least * (1 - 1e-6)


def _path(strap: hf.Strap) -> list[tuple[str, np.ndarray]]:
    return list(zip(strap.bodies, strap.points, strict=True))


def test_film_holds_two_boxes_together() -> None:
    """A band around two boxes side by side presses them together, and nothing on the whole."""
    boxes = [hf.Body(f"b{k}", hf.Box((0.2, 0.2, 0.2)), mass=1, pose=at(x, 0, 0.1)) for k, x in ((0, -0.1), (1, 0.1))]
    assembly = hf.assemble(hf.Scene([floor(2, 2), *boxes], MU))
    film = hf.Strap.around(assembly, 0.1, 30.0)
    assert film.closed
    assert len(film.points) == 4
    assert film.lengths.sum() == pytest.approx(2 * (0.4 + 0.2))
    on = {name: np.zeros(3) for name in ("b0", "b1")}
    for name, force in zip(film.bodies, film.forces(), strict=True):
        on[name] += force
    assert on["b0"] == pytest.approx((60, 0, 0))
    assert on["b1"] == pytest.approx((-60, 0, 0))
    loads = film.loads(assembly)
    for held, pulled in (((), 1), (loads, 2)):  # away from each other: one slips alone, or both slip together
        r = hf.robustness(assembly, "b0", (-0.2, 0, 0.01), (-1, 0, 0), standing=held, engine="limit")
        assert r.force[0] == pytest.approx(pulled * MU * G, rel=1e-3)
    with pytest.raises(hf.errors.SceneError, match="there is no body at"):
        hf.Strap.around(assembly, 0.5, 30.0)


def test_wrong_straps_are_told() -> None:
    assembly = load()
    h = SIDE / 2
    with pytest.raises(hf.errors.SceneError, match="other side"):  # led under the box, over nothing
        hf.Strap([("floor", (0, -1, 0)), ("box", (0, -h, 0.1)), ("floor", (0, -1, 1e-9))], 1.0).loads(assembly)
    with pytest.raises(hf.errors.SceneError, match="from the surface"):
        hf.Strap([("floor", (0, -1, 0)), ("box", (0, 0, 0.3))], 1.0).loads(assembly)
    with pytest.raises(hf.errors.SceneError, match="crate"):
        hf.Strap([("floor", (0, -1, 0)), ("crate", (0, 0, 0.1))], 1.0).loads(assembly)
    with pytest.raises(hf.errors.SceneError, match="coincide"):
        hf.Strap([("floor", (0, 0, 0)), ("box", (0, 0, 0))], 1.0)
    with pytest.raises(hf.errors.SceneError, match="closed"):
        hf.Strap([("box", X), ("box", Y), ("box", Z)], 1.0, closed=True, mu=0.1)
    with pytest.raises(hf.errors.SceneError, match="no spring"):
        hf.Strap.tied(assembly, [hf.Strap([("floor", (1.2, 0, 0)), ("box", (h, 0, 0.05))], 1.0)], bedding=1e7)
    with pytest.raises(hf.errors.SceneError, match="4 points"):
        hf.Strap.tied(assembly, [hf.Strap(_path(over()), 1.0, spring=1.0)], bedding=1e7)


def test_straps_from_files(tmp_path: Path) -> None:
    text = """
- route: [[floor, 0, -0.2, 0], [box, 0, -0.2, 0.1], [box, 0, 0.2, 0.1], [floor, 0, 0.2, 0]]
  pretension: 150
  mu: 0.3
- {route: [[floor, 1.2, 0, 0], [box, 0.2, 0, 0.05]], pretension: 150, spring: 1e5}
"""
    path = tmp_path / "straps.yaml"
    path.write_text(text)
    assert hf.Strap.from_file(path) == (over(friction=0.3), hooked()[1])
    for wrong, told in (
        ("{}", "list"),
        ("- 3", "pretension"),
        ("- {route: [[floor, 0, 0]], pretension: 1}", "route"),
        ("- {route: [[a, 0, 0, 0], [b, 0, 0, 1]], pretension: 1, sprng: 2}", "spring"),
        ("- {route: [[a, 0, 0, 0], [b, 0, 0, 1]], pretension: x}", "pretension"),
        ("- {route: [[a, 0, 0, 0], [b, 0, 0, 1]], pretension: 1, closed: 3}", "true or false"),
    ):
        path.write_text(wrong)
        with pytest.raises(hf.errors.SceneError, match=told):
            hf.Strap.from_file(path)
