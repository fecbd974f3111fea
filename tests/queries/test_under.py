"""Uncertain poses and friction against closed forms: uniform friction, normal overhangs, tips that friction spares."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.scene.shipped.blocks import at, box, cube, floor, stack

G = 9.81
L = 0.1
X = (1, 0, 0)
LOW, TOP = (-0.05, 0, 0.001), (-0.05, 0, 0.1)
KS_999 = 1.95  # Kolmogorov's 99.9 % quantile of sqrt(n) D


def ledge(share: float, movable: bool = False) -> hf.Scene:
    """A cube that hangs over the edge of a block by a share of its length; the block may stand on a floor."""
    block = hf.Body("block", hf.Box((L, L, L)), mass=1, pose=at(0, 0, L / 2), fixed=not movable)
    top = box("cube", (L, L, L), 1, (share * L, 0, 1.5 * L))
    return hf.Scene([floor(), block, top] if movable else [block, top], 0.6)


def under(scene: Any, point: Any, way: Any, *, body: str = "cube", **given: Any) -> hf.answers.RobustnessUnder:
    """Pushes on a body in samples of what is uncertain, by engine ``limit`` unless another one is given."""
    others = {"engine": "limit"} | {name: given.pop(name) for name in ("engine", "standing") if name in given}
    return hf.robustness_under(scene, body, point, way, hf.sets.Uncertain(**given), **others)


def binomial(count: int, share: float) -> tuple[float, float]:
    """Between these lie 99.9 % of the counts, as shares."""
    low, high = stats.binom.interval(0.999, count, share)
    return float(low / count), float(high / count)


@pytest.mark.parametrize("engine", ["compliant", "limit", "graph"])
@pytest.mark.parametrize("mu", [None, (0.6, 0.6)])
def test_nothing_uncertain_gives_the_nominal(engine: Any, mu: Any) -> None:
    assembly, points = hf.assemble(stack()), [(-0.05, 0.01, 0.18), (-0.05, 0, 0.12)]
    u = under(assembly, points, X, body="cube2", engine=engine, mu_range=mu, samples=3, seed=1)
    plain = hf.robustness(assembly, "cube2", points, X, engine=engine)
    assert u.force == pytest.approx(np.broadcast_to(plain.force, (3, 2)), rel=1e-12)
    assert u.nominal == pytest.approx(plain.force, rel=1e-12)
    assert (u.engine, u.claim, u.stands, u.undecided, u.samples, u.seed) == (engine, plain.claim, 1, 0, 3, 1)


@pytest.mark.parametrize(("interval", "low", "high"), [((0.2, 0.8), 0.2, 0.8), (0.3, 0.42, 0.78)])
def test_slip_follows_the_uniform_friction(interval: Any, low: float, high: float) -> None:
    """A relative width of 0.3 about 0.6 is 0.42 to 0.78."""
    count = 120
    u = under(cube(), LOW, X, engine="compliant", mu_range=interval, samples=count, seed=5)
    force = u.force[:, 0] / G
    assert low * 0.999 <= force.min() <= force.max() <= high * 1.001
    distance = stats.kstest(force, stats.uniform(low, high - low).cdf).statistic
    assert distance < KS_999 / np.sqrt(count)
    for q in (0.05, 0.25, 0.5, 0.75, 0.95):
        slack = 3.3 * np.sqrt(q * (1 - q) / count) * (high - low)
        assert u.quantile(q)[0] / G == pytest.approx(low + q * (high - low), abs=slack + 0.01)
    assert u.nominal[0] == pytest.approx(0.6 * G, rel=2e-3)


def test_tipping_does_not_ask_for_friction() -> None:
    """R = m g L / (2 h), at h = L: half the weight."""
    u = under(cube(), TOP, X, engine="compliant", mu_range=(0.55, 0.9), samples=20, seed=2)
    assert np.ptp(u.force) <= 1e-3 * G
    assert u.median == pytest.approx(G / 2, rel=5e-3)


def test_all_pairs_share_one_level() -> None:
    """Two pairs of which the weaker one slips: the push is that of the level of both, as far as it moves them."""
    one = {("cube1", "floor"): (0.2, 0.4)}
    a, b = (
        under(stack(), (-0.05, 0, 0.01), X, body="cube1", mu_range=m, samples=10, seed=3).force
        for m in (one, one | {("cube1", "cube2"): (0.3, 0.5)})
    )
    assert a == pytest.approx(b, rel=1e-6)  # all three slide on the floor, whatever lies between them
    assert 3 * G * 0.2 < a.min() < a.max() < 3 * G * 0.4


@pytest.mark.parametrize(("movable", "factor", "count"), [(False, 1.0, 150), (True, np.sqrt(2), 80)])
def test_an_overhang_falls_as_often_as_the_normal_tail_says(movable: bool, factor: float, count: int) -> None:
    """At 45 % it falls where the deviate along x exceeds 5 % of the length; two bodies deviate by √2 as much."""
    share, sigma = 0.45, 0.04 * L
    up = (share * L, 0, 2 * L), (0, 0, 1)
    u = under(ledge(share, movable), *up, engine="compliant", pose_sigma=sigma, samples=count, seed=11)
    falls = stats.norm.sf((0.5 - share) * L / (factor * sigma))
    low, high = binomial(count, falls)
    assert low <= 1 - u.stands <= high
    assert u.undecided <= 0.01
    still = (u.status[:, 0] == hf.Status.FINITE) | (u.status[:, 0] == hf.Status.INFINITE)
    assert u.stands == pytest.approx(still.mean())
    assert (u.force[~still] == 0).all()
    assert (u.quantile(0.5 * falls) == 0).all()
    assert (u.nominal > 0).all()


def test_a_push_beside_the_overhang_follows_its_deviate() -> None:
    """Down at the free end of an overhang a, it tips about the edge: R = m g (L/2 - a) / a, with a = a0 + deviate."""
    a0, sigma = 0.3 * L, 0.02 * L
    assembly = hf.assemble(ledge(0.3))
    end = (0.3 * L + L / 2, 0, 2 * L)
    u = under(assembly, end, (0, 0, -1), pose_sigma=sigma, samples=40, seed=4)
    deviates = [d[0, 0] for d in _deviates(4, 40, 1)]
    a = a0 + sigma * np.array(deviates)
    assert u.force[:, 0] == pytest.approx(G * (L / 2 - a) / a, rel=1e-6)


def _deviates(seed: int, samples: int, bodies: int) -> list[Any]:
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(samples):
        rng.random()
        found.append(rng.standard_normal((bodies, 6)))
    return found


def test_a_load_rides_on_its_body() -> None:
    """A weight on the cube's free end lets it fall, and moves along when the cube does."""
    assembly = hf.assemble(ledge(0.3))
    end, mass = (0.3 * L + L / 2, 0, 2 * L), 0.5
    load = hf.Load("cube", end, force=(0, 0, -mass * G))
    u = under(assembly, end, (0, 0, -1), standing=[load], pose_sigma=0.02 * L, samples=25, seed=4)
    a = 0.3 * L + 0.02 * L * np.array([d[0, 0] for d in _deviates(4, 25, 1)])
    left = G * (L / 2 - a) / a - mass * G
    assert u.force[:, 0] == pytest.approx(np.maximum(left, 0), rel=1e-6, abs=1e-6)
    assert u.stands == pytest.approx((left > 0).mean())


def test_samples_are_the_scenes_with_moved_bodies() -> None:
    """Rebuilt by hand: every body turned about its centre of mass and shifted, the push on the same spot of it."""
    sigma, mu, point = (0.0005, 0.3), (0.4, 0.8), np.array([-0.05, 0.03, 0.27])
    load = hf.Load("cube2", (0.05, 0.01, 0.15), force=(0.3, 0.2, -1), moment=(0, 0.01, 0.02))
    doubts = {"pose_sigma": sigma, "mu_range": mu, "samples": 5, "seed": 7}
    u = under(hf.assemble(stack(), gap=1e-3), point, (1, 0.2, 0), body="cube3", standing=[load], **doubts)
    rng = np.random.default_rng(7)
    for force in u.force[:, 0]:
        level, deviates = rng.random(), rng.standard_normal((3, 6))
        moves, bodies = {}, []
        for body in stack().bodies:
            move = np.eye(4)
            if not body.fixed:
                d = deviates[len(moves)]
                there, back = np.eye(4), np.eye(4)
                there[:3, 3], back[:3, 3] = body.com_world + sigma[0] * d[:3], -body.com_world
                turn = np.eye(4)
                turn[:3, :3] = Rotation.from_rotvec(np.radians(sigma[1]) * d[3:]).as_matrix()
                move = moves[body.name] = there @ turn @ back
            bodies.append(dataclasses.replace(body, pose=move @ body.pose))
        gap = 4 * np.sqrt((1e-3 / 4) ** 2 + 2 * sigma[0] ** 2)
        assembly = hf.assemble(hf.Scene(bodies, 0.4 + 0.4 * level), pose_sigma=(gap / 4, np.sqrt(2) * sigma[1]))
        spot, place = ((moves[name] @ [*p, 1])[:3] for name, p in (("cube3", point), ("cube2", np.asarray(load.point))))
        moved = dataclasses.replace(load, point=place)
        again = hf.robustness(assembly, "cube3", spot, (1, 0.2, 0), standing=[moved], engine="limit")
        assert force == pytest.approx(again.force[0], rel=1e-6)
    assert np.std(u.force) > 0.05 * np.mean(u.force)


def test_the_frame_in_which_a_body_is_drawn_changes_no_sample() -> None:
    """The cube as a box about its own frame, and as a mesh half a metre from it: bodies turn about their masses."""
    sigma, away = (0.0005, 0.3), np.array([0.5, -0.2, 0.3])
    solid = hf.Box((L, L, L)).surface
    pose = at(*(np.array([0, 0, L / 2]) - away))
    drawn = hf.Body("cube", hf.Mesh(solid.vertices + away, solid.faces), mass=1, pose=pose)
    one, other = (
        under(hf.Scene([floor(), body], 0.6), LOW, X, pose_sigma=sigma, samples=6, seed=3)
        for body in (box("cube", (L, L, L), 1, (0, 0, L / 2)), drawn)
    )
    assert one.stands == other.stands == 1
    assert other.force == pytest.approx(one.force, rel=1e-6)


def test_a_tilt_leans_the_contact_by_half() -> None:
    """A cube tilted by θ on a level floor: the contact's normal lies between the two, R = m g tan(atan μ - θ / 2)."""
    angle, sigma = 0.3, (1e-4, 0.3)
    u = under(cube(), LOW, X, pose_sigma=sigma, samples=25, seed=8)
    assert u.stands == 1
    tilt = np.array([np.radians(angle) * d[0, 4] for d in _deviates(8, 25, 1)])
    assert u.force[:, 0] / G == pytest.approx(np.tan(np.arctan(0.6) - tilt / 2), rel=1e-3)


def test_contacts_arise_between_known_pairs_only() -> None:
    """A wall that the cube does not touch carries nothing, however wide the tolerance of the samples is."""
    wall = hf.Body("wall", hf.Box((0.1, 0.3, 0.3)), pose=at(0.05 + 0.05 + 0.004, 0, 0.15), fixed=True)
    scene = hf.Scene([floor(), box("cube", (L, L, L), 1, (0, 0, L / 2)), wall], 0.5)
    u = under(scene, LOW, X, pose_sigma=0.002, samples=10, seed=0)
    assert u.force == pytest.approx(np.full((10, 1), 0.5 * G), rel=1e-6)
    touching = hf.robustness(hf.assemble(scene, pose_sigma=0.002), "cube", LOW, X, engine="limit")
    assert np.isinf(touching.force[0])


def test_a_contact_that_is_not_certain_is_there_in_half_of_the_samples() -> None:
    """A post 4.5 mm away, where bodies touch within 5 mm: where it is there it stops the cube, whatever the push."""
    post = hf.Body("post", hf.Box((L, L, L)), pose=at(0.1045, 0, L / 2), fixed=True)
    assembly = hf.assemble(hf.Scene([*cube().bodies, post], 0.6), gap=5e-3)
    u = under(assembly, LOW, X, mu_range=(0.6, 0.6), samples=300, seed=4)
    low, high = binomial(300, 0.5)
    assert low <= np.isinf(u.force).mean() <= high
    assert u.force[np.isfinite(u.force)] == pytest.approx(0.6 * G, rel=1e-6)


def test_a_sample_of_which_nothing_is_known_does_not_stand() -> None:
    u = under(hf.shipped_scene("wedged"), (-0.05, 0, 0.15), X, mu_range=0.1, samples=3)
    assert (u.stands, u.undecided) == (0, 1)


def test_no_contact_is_lost_to_the_deviates() -> None:
    doubts = {"pose_sigma": (0.001, 0.2), "samples": 12, "seed": 6}
    u = under(stack(), (0, 0, 0.3), (0, 0, -1), body="cube3", engine="compliant", **doubts)
    assert u.stands == 1
    assert np.isinf(u.quantile(0)).all()
    assert not np.isnan(u.median).any()


def test_given_interfaces_let_friction_vary() -> None:
    found = hf.assemble(cube())
    given = hf.assemble(cube(), interfaces=found.interfaces)
    one, other = (under(each, LOW, X, mu_range=0.2, samples=20, seed=1).force for each in (given, found))
    assert one == pytest.approx(other)
    with pytest.raises(hf.HoldfastError, match=r"pose_sigma = 0.001, but the interfaces .* given; .* vary mu_range"):
        under(given, LOW, X, pose_sigma=0.001)


def test_a_density_stays_a_mass() -> None:
    body = hf.Body("cube", hf.Box((L, L, L)), density=1000.0, pose=at(0, 0, L / 2))
    assembly = hf.assemble(hf.Scene([floor(), body], 0.6))
    u = under(assembly, LOW, X, pose_sigma=1e-4, samples=3, seed=1)
    assert u.force == pytest.approx(np.full((3, 1), 0.6 * G), rel=1e-6)


def test_quantiles_are_forces_of_samples() -> None:
    points = [LOW, TOP, (-0.05, 0, 0.05)]
    u = under(cube(), points, X, mu_range=0.5, samples=21, seed=9)
    assert u.force.shape == u.status.shape == (21, 3)
    assert u.quantile(0) == pytest.approx(u.force.min(0), rel=0, abs=0)
    assert u.quantile(1) == pytest.approx(u.force.max(0), rel=0, abs=0)
    assert u.median == pytest.approx(np.median(u.force, axis=0), rel=0, abs=0)
    for q in np.linspace(0, 1, 30):
        assert ((u.force >= u.quantile(q)).mean(0) >= 1 - q - 1e-12).all()
    force = np.repeat(np.where(np.arange(21) < 12, 0.0, np.inf), 3)
    half = dataclasses.replace(u, answers=dataclasses.replace(u.answers, force=force, lower=force, upper=force))
    assert (half.median == 0).all()
    assert np.isinf(half.quantile(0.6)).all()


@pytest.mark.parametrize("engine", ["compliant", "limit"])
def test_the_seed_decides(engine: Any) -> None:
    assembly = hf.assemble(ledge(0.45))

    def asked(seed: int, samples: int = 6) -> bytes:
        doubts = {"pose_sigma": (0.003, 0.3), "mu_range": 0.3, "samples": samples, "seed": seed}
        return under(assembly, (0, 0, 2 * L), X, engine=engine, **doubts).force.tobytes()

    first = asked(1)
    assert asked(1) == first
    assert asked(2) != first
    assert asked(1, 9)[: len(first)] == first


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"samples": 2.5}, r"samples: is 2\.5; needs a whole number of at least 1"),
        ({"pose_sigma": (1e-3, -1)}, r"rotation \[deg\]: is -1; needs"),
        ({"pose_sigma": (1, 2, 3)}, r"pose_sigma = \(1, 2, 3\); needs metres, or a pair"),
        ({"pose_sigma": 2.0}, r"pose_sigma = 2 m, but body 'cube' is only 0\.1 m thick; needs metres"),
        ({"mu_range": {("cube", "wall"): (0, 1)}}, r"no contact between \('cube', 'wall'\); name touching"),
        ({"body": "cub"}, r"'cub'; did you mean 'cube'"),
        ({"point": (0, 0, 0.5)}, r"point 0 at .* from the surface; needs points on the body"),
    ],
)
def test_what_makes_no_sense_is_refused(options: dict[str, Any], match: str) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        under(cube(), **{"point": LOW, "way": X} | options)
