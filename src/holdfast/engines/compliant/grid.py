"""An assembly on elastic contacts with a given grid of nodes: its state of rest, load paths and motions.

Contacts that are open as detected and carry nothing at rest are *idle*: bodies need not touch there, so no bound leans
on them. Rest is the same without all of them. A load may close them; but how far bodies have to move first, in
compressions that are not known, is the gap over the compression: to the law of elastic contacts a gap of a tenth of a
millimetre is none, to a steel cube it is the end of the world.

What presses a contact is *concentrated* on few of its nodes under a body that tips over a corner. Few nodes say little
about what the contact would hold: two nodes on a round rim resist a twist by their distance, a point of the rim does
not. Nor do twice as many nodes tell, as long as the force gathers on as few of them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from threading import RLock

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.progress import reported
from holdfast.contacts.contact_search import EXACT
from holdfast.contacts.interface import Interface
from holdfast.elastic.model import WEAKEST_SPRING, Elastic, with_springs
from holdfast.elastic.system import PathOutcome, PathResult, RestOutcome, RestSearch, System
from holdfast.engines.compliant.elastic_model import Places, Springs, force_unit, own_rows, world_rows
from holdfast.engines.compliant.load_bearing import HUGE, LoadBearing
from holdfast.engines.limit.limit_state import LimitState, balanced_under
from holdfast.engines.mechanism import Mechanism, describe_all, modes_of, without_slight
from holdfast.native import core

FEW = 12.0  # a contact's force is concentrated if fewer nodes share it, counted by (sum f)² / sum f²
EDGE = 5.5  # the same on a rectangle, where the six or so nodes along an edge still show where a body tips over it
SPREAD = 0.5  # share of the contact's nodes that must be more than these: a ball has one node anyway


def concentrated(places: Places, m: Elastic, q: Float) -> Bool:
    """Tell which contacts (k, interfaces) are concentrated, and count, at displacements q (k, 6J) of a model."""
    nodes, found = places.nodes, np.zeros((len(q), len(places.assembly.interfaces)), dtype=bool)
    first = np.flatnonzero(np.diff(nodes.interface, prepend=-1))  # node of each contact that has any
    few = np.where(places.rectangular[nodes.interface[first]], min(EDGE, FEW), FEW)
    most = np.minimum(few, SPREAD * np.diff(first, append=len(nodes)))
    ends = np.append(first, len(nodes))
    those = np.zeros((len(q), len(first)), dtype=bool)
    core.concentrated(m, ends, nodes.a[first], nodes.b[first], most, np.ascontiguousarray(q), those)
    found[:, nodes.interface[first]] = those
    return found


HARDLY = 1e-9  # a contact that carries no more than this share of the total weight at rest carries nothing but rounding
LEANS = 0.01  # an answer leans on contacts that are idle at rest if they carry more than this share of the load


def is_open(assembly: Assembly, interface: Interface) -> bool:
    """Tell whether surfaces are further apart than rounding explains, by EXACT times the tolerance of the pair."""
    if interface.separation is None:
        return False
    one, two = (assembly.scene.body(name) for name in interface.bodies)
    tolerance = assembly.tolerances.between(one, two).gap
    inside = one.shape.surface.sagitta + two.shape.surface.sagitta  # triangles lie inside of curved surfaces
    return interface.separation - inside > EXACT * tolerance


def open_pair(assembly: Assembly, number: int) -> str:
    """Name the pair of bodies of an open interface, with how far they are apart."""
    interface = assembly.interfaces[number]
    return f"{'-'.join(interface.bodies)} ({(interface.separation or 0.0) * 1e3:.2g} mm apart)"


FINER = 2  # number of nodes along a side on the next finer grid, as a multiple of this grid's
MOST_KEPT = 2_500_000  # nodes, in all, of grids with more nodes at some contacts: some 100 MB
CHUNK = 64  # number of motions that are turned into mechanisms at a time


@dataclass(frozen=True, eq=False)
class Grid:
    """An assembly under ``wrench`` (6J,) [N, N m] on contact ``places`` with ``springs``, and its state of rest.

    ``system`` is the elastic system in the units of the model. ``hold`` (J,) names the bodies that a regularisation
    spring keeps in their places where no contact resists their motion; None for none.
    """

    places: Places
    wrench: Float
    springs: Springs
    system: System
    hold: Bool | None = None
    _rest: list[RestSearch] = field(default_factory=list, init=False, repr=False)
    _finer: list[Grid] = field(default_factory=list, init=False, repr=False)
    _local: dict[tuple[bytes, int, int], Grid] = field(default_factory=dict, init=False, repr=False)
    _making: RLock = field(default_factory=RLock, init=False, repr=False)  # of finer grids, and of rest

    @classmethod
    def of(
        cls,
        assembly: Assembly,
        wrench: Float,
        springs: Springs,
        nodes: ContactNodes | None = None,
        *,
        hold: Bool | None = None,
    ) -> Grid:
        """Return the assembly on ``nodes`` or, if None, on a grid with ``springs.nodes`` along a side.

        A regularisation spring keeps the bodies ``hold`` (J,) in their places or, if they do not come to rest so, all
        bodies.
        """
        places = Places.of(assembly, springs.nodes) if nodes is None else Places.at(assembly, nodes)
        return cls._on(places, wrench, springs, hold)

    @classmethod
    def _on(
        cls, places: Places, wrench: Float, springs: Springs, hold: Bool | None, model: Elastic | None = None
    ) -> Grid:
        """Return the same on given ``places``; ``model`` is that without a hold, if it is known."""
        if model is None:
            model = springs.model(places, wrench)
        grid = cls(places, wrench, springs, System.of(model if hold is None else with_springs(model, hold)), hold)
        if hold is None or hold.all() or grid.settled.outcome is RestOutcome.RESTS:
            return grid
        return cls._on(places, wrench, springs, np.ones_like(hold), model)

    @property
    def settled(self) -> RestSearch:
        """The end of the search for rest, which is made when it is first asked for: finer grids mostly have no need."""
        with self._making:  # not a cached property: those of all grids would wait for each other
            if not self._rest:
                self._rest.append(self.system.come_to_rest())
            return self._rest[0]

    @property
    def assembly(self) -> Assembly:
        """The assembly."""
        return self.places.assembly

    @property
    def nodes(self) -> ContactNodes:
        """The contact nodes."""
        return self.places.nodes

    @property
    def finer(self) -> Grid:
        """The grid with FINER times as many nodes along a side."""
        with self._making:  # threads that ask at the same time share one
            if not self._finer:
                springs = replace(self.springs, nodes=FINER * self.springs.nodes)
                self._finer.append(Grid.of(self.assembly, self.wrench, springs, hold=self.hold))
            return self._finer[0]

    def with_more(self, contacts: Int, more: int, times: int = 1) -> Grid:
        """Return the grid with ``more`` nodes along a side at these ``contacts``, ``times`` as many at all others.

        Those that were asked for last are kept, as long as they have MOST_KEPT nodes in all at most.
        """
        key = (contacts.tobytes(), more, times)
        with self._making:
            grid = self._local.pop(key, None)
        if grid is None:  # threads ask for grids of their own: none waits for another's
            places = Places(self.assembly, times * self.springs.nodes, tuple(contacts.tolist()), more)
            grid = Grid._on(places, self.wrench, self.springs, self.hold)
        with self._making:
            self._local[key] = grid
            count = sum(len(each.system.model.k) for each in self._local.values())
            while count > MOST_KEPT and len(self._local) > 1:
                count -= len(self._local.pop(next(iter(self._local))).system.model.k)
        return grid

    @cached_property
    def with_hold(self) -> Grid:
        """The grid on the same nodes with a regularisation spring of every body."""
        if self.hold is not None and self.hold.all():
            return self
        return self.holding(np.ones(len(self.assembly.movable), dtype=bool))

    def holding(self, bodies: Bool) -> Grid:
        """Return the grid on the same nodes with a regularisation spring of ``bodies`` (J,)."""
        model = self.system.model if self.hold is None else None
        return Grid._on(self.places, self.wrench, self.springs, bodies, model)

    def loads_held(self, W: Float) -> Bool:
        """Tell which columns of W (6J, k) load a body with a regularisation spring, which may help to bear them."""
        if self.hold is None:
            return np.zeros(W.shape[1], dtype=bool)
        return np.asarray((W.reshape(-1, 6, W.shape[1])[self.hold] != 0).any(axis=(0, 1)))

    @cached_property
    def certain(self) -> LimitState:
        """Limit analysis of the same assembly under the same wrench, which proves above which load bodies move."""
        return balanced_under(self.assembly, self.wrench)

    @cached_property
    def lightest(self) -> float:
        """The weight of the lightest body, in the model's unit of force."""
        return float(np.linalg.norm(self.wrench.reshape(-1, 6)[:, :3], axis=1).min() / self.unit)

    @cached_property
    def unit(self) -> float:
        """The model's unit of force [N]."""
        return force_unit(self.assembly, self.wrench)

    def loads(self, W: Float) -> Float:
        """Convert load columns W (6J, k) [N, N m] to rows (k, 6J) in the units of the model."""
        return own_rows(self.assembly, np.ascontiguousarray(W.T) / self.unit)

    def paths(self, W: Float, *, most: float = np.inf) -> PathResult:
        """Follow the load paths of columns W (6J, k) [N, N m], none of which may be zero.

        All paths are lost if the assembly does not rest on this grid. No path is followed beyond ``most`` times its
        load.

        A path that leads to HUGE times the weight that counts beside its load is endless if few bodies carry that alone
        (load_bearing.py): what would be met further out are other branches, or rounding. Where systems are dear, it is
        only followed so far at first.
        """
        loads = self.loads(W)
        if self.settled.outcome is not RestOutcome.RESTS:
            return PathResult.lost(*loads.shape).sealed()
        farthest = np.full(len(loads), most)
        if self.system.fronts is not None and most == np.inf:
            beside = np.array([self.load_bearing.weight(load) for load in loads])
            farthest = HUGE * beside / np.abs(loads).max(axis=1, initial=0.0)
        found = self._followed.paths(self.settled.q, loads, most=farthest)
        return self._led_on(loads, found) if most == np.inf else found

    def _led_on(self, loads: Float, found: PathResult) -> PathResult:
        """Return the paths ``found`` of ``loads`` (k, 6J), of which those that led to HUGE times a weight are decided.

        They are endless if few bodies carry the load alone; if not, they are followed as far as they lead.
        """
        size = found.peak * np.abs(loads).max(axis=1, initial=0.0)
        large = np.flatnonzero((found.outcome != PathOutcome.ENDLESS) & (size >= HUGE * self.lightest)).tolist()
        there = np.array([k for k in large if size[k] >= HUGE * self.load_bearing.weight(loads[k])], dtype=np.int64)
        far = reported("loads that lead far", there.tolist())
        alone = np.array([self.load_bearing.balance(loads[k]) for k in far], dtype=bool)
        if alone.any():
            ends, outcome, peak = there[alone], found.outcome.copy(), found.peak.copy()
            first, before = found.first.copy(), found.before.copy()
            for sure in (first, before):
                sure[ends] = np.where(sure[ends] < peak[ends], sure[ends], np.inf)
            outcome[ends], peak[ends] = PathOutcome.ENDLESS, np.inf
            found = found._replace(outcome=outcome, peak=peak, first=first, before=before).sealed()
        left = there[~alone & (found.outcome[there] == PathOutcome.REACHED)]
        return found if not len(left) else found.replaced(left, self._followed.paths(self.settled.q, loads[left]))

    @cached_property
    def load_bearing(self) -> LoadBearing:
        """What tells whether few bodies carry a load alone."""
        return LoadBearing(self.system.model, self.settled.q)

    @cached_property
    def idle(self) -> tuple[int, ...]:
        """The numbers of interfaces that are open as detected and carry nothing at rest."""
        there = np.flatnonzero(self._carried(self.settled.q) <= HARDLY).tolist()
        return tuple(k for k in there if is_open(self.assembly, self.assembly.interfaces[k]))

    def _carried(self, q: Float) -> Float:
        """Return the normal force of each interface (interfaces,) at q (6J,), in the model's unit."""
        forces = np.empty((len(self.nodes), 3))
        core.node_forces(self.system.model, q, forces)
        return np.bincount(self.nodes.interface, forces[:, 0], len(self.assembly.interfaces)).astype(np.float64)

    def leans(self, W: Float, paths: PathResult) -> Bool:
        """Tell at which of the ends of ``paths`` of columns W (6J, k) contacts that are ``idle`` at rest carry some."""
        found = np.zeros(len(paths.peak), dtype=bool)
        if not self.idle:
            return found
        s = np.where(paths.outcome == PathOutcome.PEAK, paths.peak, 1.0)  # of endless ones under the load alone
        thrust = s * np.linalg.norm(self.loads(W).reshape(len(s), -1, 6)[:, :, :3], axis=2).sum(1)
        for row in range(len(s)):
            found[row] = self._carried(paths.q[row])[list(self.idle)].sum() > LEANS * thrust[row]
        return found

    @cached_property
    def _followed(self) -> System:
        """The system whose load paths are followed: on faces that are not flat, one with the weakest of springs.

        There a body may come to lie on two high spots, about which it rocks until it meets the next one, while the load
        stays the same. No contact resists that, so without a hold the path would have no direction and end.
        """
        faces = self.springs.faces
        if faces is None or faces.imperfect.flatness == 0:
            return self.system
        return replace(self.system, model=with_springs(self.system.model, stiffness=WEAKEST_SPRING))

    def loads_nearby(self, W: Float, s: Float, q: Float, plane: Float) -> Float:
        """Return the factors (k,) of columns W (6J, k) near points of their paths that were found on a coarser grid.

        The points have factors ``s`` (k,), displacements ``q`` (k, 6J) and planes ``plane`` (k, 6J), in units of the
        model. A factor is -1 if none is found.
        """
        return self.system.loads_nearby(self.loads(W), s, q, plane)

    def concentrated(self, q: Float) -> Bool:
        """Tell at which contacts (k, interfaces) forces are concentrated on few nodes at displacements q (k, 6J).

        On faces that are not ideal they do so on any grid, on the high spots: there none is named.
        """
        if self.springs.faces is not None:
            return np.zeros((len(q), len(self.assembly.interfaces)), dtype=bool)
        return concentrated(self.places, self.system.model, q)

    def mechanisms(self, motions: Float) -> list[Mechanism]:
        """Return the mechanisms of ``motions`` (k, 6J), which are in the units of the model."""
        found: list[Mechanism] = []
        for first in range(0, len(motions), CHUNK):
            twists = without_slight(world_rows(self.assembly, motions[first : first + CHUNK]), self.assembly.size)
            modes = modes_of(self.assembly, self.nodes, twists, self.places.velocities(twists), dual=False)
            found += describe_all(self.places.kinematics, twists, modes, dual=False)
        return found
