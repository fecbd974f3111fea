"""R = min(R_slip, R_top) by definition and enumeration: no flow, no closed form of the slip root, no hull code.

Takes only the contact forces of the force program; everything that follows is redone in the plainest way.
"""

import itertools

import numpy as np
from engine_scenes import Array

from holdfast import Graph
from holdfast.answers import Assembly
from holdfast.engines.verdict import ContactForces


def inside_cone(f: Array, normal: Array, mu: Array) -> Array:
    fn = (f * normal).sum(-1)
    return np.asarray(mu * fn - np.linalg.norm(f - fn[..., None] * normal, axis=-1))


def slip_limit(f: Array, normal: Array, mu: Array, e: Array, largest: float = 1e7) -> Array:
    """The largest s in [0, largest] with f + s e in the cone, for every node, by bisection; inf at ``largest``.

    The cone is convex, so that the s that keep within it are one interval from 0.
    """
    low, high = np.zeros(len(f)), np.full(len(f), largest)
    # e inside the cone adds for ever; rounding at `largest` must not decide on its boundary
    for_ever = inside_cone(np.broadcast_to(e, f.shape), normal, mu) >= -1e-9
    for _ in range(100):
        middle = (low + high) / 2
        holds = inside_cone(f + middle[:, None] * e, normal, mu) >= 0
        low, high = np.where(holds, middle, low), np.where(holds, high, middle)
    return np.where(for_ever, np.inf, low)


def hull_edges(points: Array) -> list[tuple[int, int]]:
    """Pairs of points on an edge of the convex hull: seen along the edge, all others lie within less than a half turn.

    Where the points are flat, an edge seen from above has all others on one side.
    """
    pairs = []
    flat_normal = np.linalg.svd(points - points.mean(0))[2][2]
    is_flat = np.ptp(points @ flat_normal) < 1e-9
    for i, j in itertools.combinations(range(len(points)), 2):
        along = points[j] - points[i]
        if np.linalg.norm(along) < 1e-9:
            continue
        along = along / np.linalg.norm(along)
        across = points - points[i]
        across = across - np.outer(across @ along, along)
        away = across[np.linalg.norm(across, axis=1) > 1e-9]
        if is_flat:
            side = away @ np.cross(flat_normal, along)
            if (side > 0).all() or (side < 0).all():
                pairs.append((i, j))
            continue
        u = away[0] / np.linalg.norm(away[0])
        angles = np.sort(np.arctan2(away @ np.cross(along, u), away @ u))
        gaps = np.diff(np.append(angles, angles[0] + 2 * np.pi))
        if gaps.max() > np.pi + 1e-6:
            pairs.append((i, j))
    return pairs


class Reference:
    """The method on one assembly with the contact forces that the engine found."""

    def __init__(self, assembly: Assembly, forces: ContactForces) -> None:
        self.assembly, self.forces = assembly, forces
        self.mu = np.array(assembly.mu)[forces.interface]
        self.ends = np.array(assembly.ends)
        self.count = len(assembly.movable)

    def slip(self, body: int, e: Array) -> float:
        """Over all sets of bodies that hold the pushed one: the least capacity of the interfaces around them."""
        f = self.forces
        up, down = (
            np.bincount(f.interface, slip_limit(f.force, f.normal, self.mu, sign * e), len(self.ends))
            for sign in (1, -1)
        )
        best = np.inf
        for mask in range(1, 1 << self.count):
            if not mask >> body & 1:
                continue
            inside = np.array([k >= 0 and bool(mask >> int(k) & 1) for k in self.ends.ravel()]).reshape(-1, 2)
            leaves = up[inside[:, 0] & ~inside[:, 1]].sum() + down[inside[:, 1] & ~inside[:, 0]].sum()
            best = min(best, float(leaves))
        return best

    def cuts(self, body: int) -> list[set[int]]:
        """Connected sets with the pushed body whose complement, the fixed node (-1) in it, is connected."""
        everything = {-1, *range(self.count)}
        sets = (
            set(chosen)
            for size in range(1, self.count + 1)
            for chosen in itertools.combinations(range(self.count), size)
        )
        return [s for s in sets if body in s and self._connected(s) and self._connected(everything - s)]

    def _connected(self, group: set[int]) -> bool:
        reached = {min(group)}
        while True:
            more = {int(x) for pair in self.ends for x in pair if set(map(int, pair)) <= group and set(pair) & reached}
            if more <= reached:
                return reached == group
            reached |= more

    def topple(self, body: int, p: Array, e: Array) -> float:
        """Over all cuts and both senses of all axes: what the contacts resist with over what the push gains."""
        best = np.inf
        for group in self.cuts(body):
            severed = [k for k, (a, b) in enumerate(self.ends) if (a in group) != (b in group)]
            corners = np.vstack([patch.polygon for k in severed for patch in self.assembly.interfaces[k].patches])
            corners = np.unique(np.round(corners, 9), axis=0)
            nodes = np.flatnonzero(np.isin(self.forces.interface, severed))
            b_moves = np.array([self.ends[k, 1] in group for k in self.forces.interface[nodes]])
            away = np.where(b_moves, 1.0, -1.0)[:, None]  # turns forces and normals into those ON the moving side
            on_moving, normal = away * self.forces.force[nodes], away * self.forces.normal[nodes]
            points, mu = self.forces.points[nodes], self.mu[nodes]
            axes = [(corners[i], corners[j] - corners[i]) for i, j in hull_edges(corners)]
            if np.abs(np.abs(normal @ normal[0]) - 1).max() < 1e-4:
                share = mu * (on_moving * normal).sum(1)
                axes.append((share @ points / share.sum(), normal[0]))
            for origin, along in axes:
                for a in (along / np.linalg.norm(along), -along / np.linalg.norm(along)):
                    gain = np.cross(a, p - origin) @ e
                    if gain <= 1e-9:
                        continue
                    velocity = np.cross(a, points - origin)  # of the moving side
                    resists = self._work(on_moving, normal, mu, velocity)
                    best = min(best, max(resists, 0.0) / gain)
        return best

    @staticmethod
    def _work(on_moving: Array, normal: Array, mu: Array, velocity: Array) -> float:
        """Power lost with the contacts: those that open no longer give theirs, those that slide go to their limit."""
        speed = np.linalg.norm(velocity, axis=1)
        goes = speed > 1e-8
        opening = (velocity * normal).sum(1)
        if (opening[goes] < -1e-6 * speed[goes]).any():
            return float("inf")
        slides = goes & (np.abs(opening) <= 1e-6 * speed)
        opens = goes & ~slides
        work = (on_moving[opens] * velocity[opens]).sum()
        if slides.any():
            e = -velocity[slides] / speed[slides, None]  # friction on the moving side grows against its velocity
            work += (slip_limit(on_moving[slides], normal[slides], mu[slides], e) * speed[slides]).sum()
        return float(work)

    def robustness(self, body: str, p: Array, e: Array) -> float:
        number = self.assembly.index[body]
        return min(self.slip(number, e), self.topple(number, p, e))


def reference_of(assembly: Assembly, **options: object) -> Reference:
    forces = Graph(**options).prepare(assembly).verdict().forces  # type: ignore[arg-type]
    assert forces is not None
    return Reference(assembly, forces)
