"""Search for an order of removals: of all bodies depth-first, or of some bodies with the fewest removals."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from holdfast.applications.disassembly.removal import Answer, Removal, Removals
from holdfast.assembly.assembly import FIXED
from holdfast.base.progress import report

M = TypeVar("M")


@dataclass(frozen=True)
class Plan:
    """The result of a search: ``steps`` in order, and how good they are.

    ``reached`` means that all goals are taken out, and ``proven`` that no order is better. ``bound`` is a lower bound
    on the number of removals of any order that takes out all goals; it is inf if there is no such order.
    """

    steps: tuple[Removal, ...]
    reached: bool
    proven: bool
    bound: float


def depth_first(moves: Callable[[tuple[M, ...]], Iterator[M]], count: int) -> Iterator[tuple[M, ...]]:
    """Yield each way, of at most ``count`` moves, when nothing goes on from it; ``moves`` yields what follows a way."""
    way: tuple[M, ...] = ()
    open_ = [moves(way)]
    while open_:
        move = next(open_[-1], None)
        if move is None:
            yield way
            open_.pop()
            way = way[:-1]
        else:
            way = (*way, move)
            report("bodies taken out", len(way), count)
            open_.append(moves(way))


def everything(removals: Removals, budget: int) -> Plan:
    """Take out all bodies one by one, the highest along the lift first.

    The search is depth-first: if no body can be taken out, it goes back one step and remembers the dead end.
    """
    whole, order = frozenset(removals.names), from_the_top(removals)
    dead: set[frozenset[str]] = set()
    doubts: dict[str, frozenset[str]] = {}
    undecided = spent = False

    def safe(steps: tuple[Removal, ...]) -> Iterator[Removal]:
        nonlocal undecided, spent
        remaining = whole - {step.body for step in steps}
        for name in _candidates(order, remaining, doubts):
            if remaining - {name} in dead:
                continue
            spent = removals.checks >= budget
            if spent:
                return
            removal = removals.answer(name, remaining)
            undecided = undecided or removal.answer is Answer.UNDECIDED
            if removal.answer is Answer.SAFE:
                yield removal
            else:
                doubts[name] = frozenset((*removal.moving, *(n for n, _ in removal.blockers))) & remaining
        dead.add(remaining)

    longest: tuple[Removal, ...] = ()
    for steps in depth_first(safe, len(whole)):
        if len(steps) == len(whole):
            return Plan(steps, True, True, float(len(whole)))
        longest = steps if len(steps) >= len(longest) else longest
        if spent:
            break
    closed = not undecided and not spent
    return Plan(longest, False, closed, float("inf") if closed else float(len(whole)))


def from_the_top(removals: Removals) -> list[str]:
    """Return the bodies ordered by their centres of mass along the lift, the farthest first."""
    assembly = removals.assembly
    height = {body.name: float(assembly.com[k] @ removals.lift) for k, body in enumerate(assembly.movable)}
    return sorted(removals.names, key=lambda name: -height[name])


def _candidates(order: list[str], remaining: frozenset[str], doubts: dict[str, frozenset[str]]) -> Iterator[str]:
    """Yield the remaining bodies in order, but last those that probably still cannot be taken out.

    These are the bodies that could not be taken out before, while all bodies that prevented it are still there.
    """
    left = [name for name in order if name in remaining]
    doubtful = {name for name in left if name in doubts and doubts[name] and doubts[name] <= remaining}
    yield from (name for name in left if name not in doubtful)
    yield from (name for name in left if name in doubtful)


def fewest(removals: Removals, goals: frozenset[str], budget: int) -> Plan:
    """Take out ``goals`` with as few removals as possible, by a best-first search with a lower bound.

    The bound counts the bodies that must be removed: those in the way of a goal, those that would hang in the air
    without it, and in turn those that must be removed before these.
    """
    whole = frozenset(removals.names)
    needed = necessary(removals, goals, whole)
    if needed is None:
        return Plan((), False, True, float("inf"))
    first = _straight(removals, goals, needed)
    if first is not None and len(first) == len(needed):
        return Plan(first, True, True, float(len(needed)))
    return _BestFirstSearch(removals, goals, needed, first, budget).plan()


def necessary(removals: Removals, goals: frozenset[str], remaining: frozenset[str]) -> frozenset[str] | None:
    """Return the bodies that every order must take out up to the last goal, or None if the goals cannot be reached."""
    before: dict[str, set[str]] = {}
    waiting = list(goals & remaining)
    while waiting:
        name = waiting.pop()
        if name in before:
            continue
        ahead = {blocker for blocker, _ in removals.exits.blockers(name, remaining)}
        if not ahead <= remaining:
            return None  # a fixed body is in the way
        before[name] = ahead | hanging_without(removals, name, remaining)
        waiting += before[name]
    return frozenset(before) if _orderable(before) else None


def hanging_without(removals: Removals, name: str, remaining: frozenset[str]) -> set[str]:
    """Return the bodies that would hang in the air without ``name``, through which all their support leads."""
    index, present = removals.assembly.index, remaining - {name}
    reached = [hold.body for hold in removals.assembly.scene.holds if hold.body in present]
    reached += [one for one in present if any(index[other] == FIXED for other in removals.beside[one])]
    carried = set(reached)
    while reached:
        for other in removals.beside[reached.pop()]:
            if other in present and other not in carried:
                carried.add(other)
                reached.append(other)
    return set(present) - carried


def _orderable(before: dict[str, set[str]]) -> bool:
    """Tell whether there is an order in which each body comes after all bodies that must go before it."""
    left = {name: set(others) for name, others in before.items()}
    while left:
        free = [name for name, others in left.items() if not others & left.keys()]
        if not free:
            return False
        for name in free:
            del left[name]
    return True


def _straight(removals: Removals, goals: frozenset[str], needed: frozenset[str]) -> tuple[Removal, ...] | None:
    """Find some order by a greedy search, or return None.

    It takes out the ``needed`` bodies, and any others that turn out to fall or to be in the way.
    """
    order, wanted = from_the_top(removals), set(needed)
    remaining, steps = frozenset(removals.names), []
    while goals & remaining:
        grown: set[str] = set()
        for name in (n for n in order if n in wanted and n in remaining):
            removal = removals.answer(name, remaining)
            if removal.answer is Answer.SAFE:
                steps.append(removal)
                remaining -= {name}
                report("bodies taken out", len(steps), len(wanted))
                break
            grown |= {*removal.moving, *(n for n, _ in removal.blockers)} & remaining
        else:
            if grown <= wanted:
                return None
            wanted |= grown
    return tuple(steps)


class _BestFirstSearch:
    """A best-first search over sets of remaining bodies for the fewest removals that take out all ``goals``.

    Whether a body comes out is computed only when its turn comes. ``needed`` are the bodies that every order has to
    take out (``necessary``), ``first`` is the order that a greedy search found, None if it found none, and ``budget``
    is the largest number of checks by contact forces.
    """

    def __init__(
        self,
        removals: Removals,
        goals: frozenset[str],
        needed: frozenset[str],
        first: tuple[Removal, ...] | None,
        budget: int,
    ) -> None:
        self.removals, self.goals, self.first, self.budget = removals, goals, first, budget
        self.whole = frozenset(removals.names)
        self.needed = needed
        # contacts on the shortest path from each body to a goal: near bodies are tried first
        self.hops, edge, far = dict.fromkeys(goals, 0), set(goals), 0
        while edge:
            far += 1
            near = {n for name in edge for n in removals.beside[name] if removals.assembly.index[n] >= 0}
            edge = near - self.hops.keys()
            self.hops |= dict.fromkeys(edge, far)
        # bound on the removals, hops, -removals so far, ticket, remaining bodies, the body to go next, removals so far
        self.heap: list[tuple[int, int, int, int, frozenset[str], str, tuple[Removal, ...]]] = []
        self.ticket = itertools.count()  # of equal entries the older one goes first, and sets are never compared
        self.unsure = float("inf")  # lower bound on the removals of orders that an undecided answer excluded

    def plan(self) -> Plan:
        """Return the best order found and a lower bound for all orders."""
        removals, seen = self.removals, {self.whole}
        self._grow(self.whole, self.needed, ())
        limit = float("inf") if self.first is None else float(len(self.first))
        while self.heap:
            bound = self.heap[0][0]
            least = min(float(bound), self.unsure)
            if bound >= limit or removals.checks >= self.budget:
                return self._given_up(min(least, limit))
            _, _, _, _, remaining, name, steps = heapq.heappop(self.heap)
            after = remaining - {name}
            if after in seen:
                continue
            removal = removals.answer(name, remaining)
            if removal.answer is not Answer.SAFE:
                if removal.answer is Answer.UNDECIDED:
                    self.unsure = min(self.unsure, float(bound))
                continue
            seen.add(after)
            taken = (*steps, removal)
            if not self.goals & after:
                best = min(float(len(taken)), self.unsure)
                return Plan(taken, True, best == len(taken), best)
            needed = necessary(removals, self.goals, after)
            if needed is not None:
                self._grow(after, needed, taken)
        return self._given_up(min(limit, self.unsure))

    def _grow(self, remaining: frozenset[str], needed: frozenset[str], steps: tuple[Removal, ...]) -> None:
        """Add every body that could be next to the queue; a body in ``needed`` does not increase the count."""
        for name in (n for n in self.removals.names if n in remaining):
            if any(
                blocker in remaining or blocker not in self.whole for blocker, _ in self.removals.exits.in_the_way(name)
            ):
                continue
            count = len(steps) + 1 + len(needed - {name})
            hops = self.hops.get(name, len(self.whole))
            heapq.heappush(self.heap, (count, hops, -len(steps), next(self.ticket), remaining, name, steps))

    def _given_up(self, bound: float) -> Plan:
        """Return the order of the greedy search, if there is one, as this search found no better one."""
        if self.first is None:
            return Plan((), False, bound == float("inf"), bound)
        return Plan(self.first, True, bound >= len(self.first), bound)
