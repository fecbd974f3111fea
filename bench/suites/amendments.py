"""What each amendment of ``compliant`` buys: answers with one or two of its rules switched off, beside all of them.

A rule is a whole amendment, or a part of one. ``raised`` counts answers whose ``lower`` rises by more than 1 % without
it, ``above proof`` those that lie by more than 1 % above what limit analysis proves to move. Load paths are followed
once for all, and what the rules ask beyond them is remembered with the time that it took, so ``s saved`` is the time of
all that is no longer asked. Pairs are of rules that alone change nothing in a case. A rule that no case needs goes:
NEEDED_BY names one for each.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any
from unittest import mock

import numpy as np

import holdfast as hf
from bench.checkout import CASES
from bench.scenes.random_assemblies import FAMILIES, standing
from bench.scenes.random_pushes import columns, random_pushes
from bench.scenes.real_pallets import pallet, pallets
from bench.suite import Case, Row, Suite, table
from bench.suites.imperfect import imperfect_faces
from bench.suites.messy import messy
from holdfast.assembly.assembly import Assembly, assemble
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError
from holdfast.base.memory import Same
from holdfast.engines.answers import Answers
from holdfast.engines.compliant import amendment, self_stressed
from holdfast.engines.compliant import engine as compliant_engine
from holdfast.engines.compliant.amendment import LimitReview, OpenContacts, Sliding
from holdfast.engines.compliant.engine import Compliant, RestingState, Rough
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.load_bearing import LoadBearing
from holdfast.engines.compliant.refinement import Refined
from holdfast.engines.compliant.self_stressed import SelfStressed
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.imperfect import RandomFaces
from holdfast.engines.joint_answers import without_negligible
from holdfast.engines.limit.limit_state import LimitState
from holdfast.engines.verdict import Status
from holdfast.scene.shipped import shipped_scene

SCENES = ("cube", "stack", "table", "tall_table", "slope_two", "wall2x2", "v_groove", "arch", "wedged_floor")
TROUBLED = ("block", "tower", "table", "pyramid", "wall", "arch", "leaning", "groove")  # families with messy scenes
MEMBERS, MESSY = 4, 8  # assemblies of each random family, plain and messy
EVERY, MOST_BOXES = 8, 60  # each so-manieth pallet of no more boxes
SLANTS = (0.0, 35.0, 60.0)  # [°] largest angles from the normal
PUSHES = {"scene": 40, "family": 14, "pallet": 6, "messy": 4, "jam": 40, "rough": 6}  # on an assembly at each slant
SAMPLES, SEED = 4, 50
SAME, CLEARLY, RAISED = 0.001, 0.05, 0.01  # relative changes

TESTS = "tests/engines"
PRESSED = f"{TESTS}/compliant/test_load_bearing.py"
# A case of this suite, or a test, whose answers change without the rule
NEEDED_BY = {
    "limit analysis": "jam place_20",
    "stiffness": "jam place_20",
    "sliding far": "scene v_groove",
    "contacts that are open at rest": "jam place_20",
    "limit: contradiction": "tests/cases/test_experiments.py::test_pushes_of_a_robot_are_predicted",
    "limit: confirmed endless": "jam pipes38",
    "limit: rests alone": "rough v_groove",
    "limit: few carry": f"{PRESSED}::test_a_press_that_leads_far_ends_where_the_lever_says",
    "limit: huge": "scene wedged_floor",
    "stress: ratios": "jam pipes38",
    "stress: coarse nodes": "scene v_groove",
    "stress: two nodes": "scene wedged_floor",
    "stress: three nodes": "jam place_20",
    "stress: five nodes": "scene v_groove",
    "stress: near the limit": "jam place_20",
    "stress: jams": "scene v_groove",
    "negligible": f"{TESTS}/test_balanced_bounds.py::test_a_plank_balanced_on_an_edge_anywhere_holds_nothing_at_all",
}

Patch = tuple[Any, str, Any]  # an object, the name of its attribute, and the value in its place


def _never(*_: object) -> bool:
    return False


def rules() -> dict[str, list[Patch]]:
    """Return what switches each rule off."""
    kinds = compliant_engine.AMENDMENTS
    whole = {
        kind.name: [(compliant_engine, "AMENDMENTS", tuple(k for k in kinds if k is not kind))]
        for kind in (LimitReview, SelfStressed, Sliding, OpenContacts)
    }
    parts: dict[str, list[Patch]] = {
        "limit: contradiction": [(amendment, "CONTRADICTION", np.inf)],
        "limit: confirmed endless": [(amendment, "ENDLESS", np.inf)],
        "limit: rests alone": [(amendment, "rests_alone", _never)],
        "limit: few carry": [(LoadBearing, "balance", _never)],
        "limit: huge": [(amendment, "HUGE", np.inf)],
        "stress: ratios": [(self_stressed, "RATIOS", (1.0, 1.0))],
        "stress: coarse nodes": [(self_stressed, "COARSE", (10**6,))],
        "stress: two nodes": [(self_stressed, "COARSE", (3, 5))],
        "stress: three nodes": [(self_stressed, "COARSE", (2, 5))],
        "stress: five nodes": [(self_stressed, "COARSE", (2, 3))],
        "stress: near the limit": [(self_stressed, "LEVEL", 0.0)],
        "stress: jams": [(self_stressed, "JAMMED", np.inf)],
    }
    return whole | parts | {"negligible": []}


class Remembered:
    """What costly functions returned, with the time that they took: a call asks once for the same arguments."""

    def __init__(self) -> None:
        self.known: dict[Any, tuple[Any, float, Any]] = {}
        self.asked: dict[Any, float] = {}
        self.depth = 0

    def wrapped(self, function: Callable[..., Any], key: Callable[..., Any]) -> Callable[..., Any]:
        """Return ``function`` with a memory; ``key`` makes the key of its arguments."""

        def ask(*args: Any, **options: Any) -> Any:  # noqa: ANN401 - any function
            which = (function, key(*args, **options))
            if which not in self.known:
                start = time.process_time()
                self.depth += 1
                try:
                    found = function(*args, **options)
                finally:
                    self.depth -= 1
                # the arguments live on, so ids are unique
                self.known[which] = found, time.process_time() - start, (args, options)
            if not self.depth:  # what is asked on the way is part of what asks it
                self.asked[which] = self.known[which][1]
            return self.known[which][0]

        return ask

    @contextmanager
    def working(self) -> Iterator[None]:
        """Remember load paths, grids, and what limit analysis proves."""

        def on_grid(grid: Any, *args: Any, **options: Any) -> Any:  # noqa: ANN401 - any arguments
            return (id(grid), *(a.tobytes() if isinstance(a, np.ndarray) else a for a in args), *options.items())

        def of_grid(assembly: Assembly, wrench: Float, springs: Any, nodes: Any = None, *, hold: Any = None) -> Any:  # noqa: ANN401
            known = springs.nodes, springs.ratio, id(springs.stiffness), id(springs.faces), id(nodes)
            return Same(assembly), wrench.tobytes(), *known, None if hold is None else hold.tobytes()

        def on_refined(refined: Refined, W: Float, *, bounds: bool) -> Any:  # noqa: ANN401
            return id(refined.grid), W.tobytes(), bounds

        def of_limit(state: LimitState, W: Float, *accuracy: Any) -> Any:  # noqa: ANN401
            return Same(state.assembly), state.wrench.tobytes(), W.tobytes(), repr(accuracy)

        with ExitStack() as stack:
            for owner, name, key in (
                (Grid, "paths", on_grid),
                (LoadBearing, "balance", on_grid),
                (LimitState, "load_factor", of_limit),
                (Refined, "answers", on_refined),
                (Grid, "of", of_grid),
                (Assembly, "without_interfaces", lambda assembly, absent: (Same(assembly), frozenset(absent))),
            ):
                own = self.wrapped(getattr(owner, name), key)
                stack.enter_context(mock.patch.object(owner, name, own))
            yield


@dataclass
class Asked:
    """Pushes W (6J, n) on one group at rest, its ``state`` and what is remembered of it."""

    state: RestingState
    W: Float
    memory: Remembered = field(default_factory=Remembered)

    def without(self, *names: str) -> tuple[Answers, float]:
        """Answer without these rules, and say how long all that was asked took [s]."""
        with ExitStack() as stack:
            stack.enter_context(self.memory.working())
            for rule in names:
                for owner, name, value in rules()[rule]:
                    stack.enter_context(mock.patch.object(owner, name, value))
            self.memory.asked.clear()
            found = RestingState(self.state.decided, self.state.refined, self.state.neutral).load_factor(self.W)
            if "negligible" not in names:
                found = without_negligible(found, self.W, self.state.grid.assembly)
        return found, sum(self.memory.asked.values())


def at_rest(assembly: Assembly, slants: tuple[float, ...], count: int, engine: Engine, seed: int) -> list[Asked]:
    """Draw pushes on all groups that stand, ``count`` at each slant on the whole."""
    rng = np.random.default_rng([SEED, seed])
    W = columns(assembly, [p for slant in slants for p in random_pushes(assembly, rng, count, slant=slant)])
    groups, found = prepared(engine, assembly), []
    for number in range(len(assembly.groups)):
        group = groups.group(number)
        if group.part is None or not isinstance(group.state, RestingState) or group.verdict.status is not Status.STABLE:
            continue
        own = W[group.part.rows]
        own = own[:, own.any(axis=0)]
        if own.shape[1]:
            found.append(Asked(group.state, np.ascontiguousarray(own)))
    return found


def compared(full: Answers, other: Answers, top: Float) -> dict[str, float]:
    """Count the answers of ``other`` that differ from ``full``; ``top`` (n,) is what limit analysis proves."""
    apart = np.maximum(_apart(full.force, other.force), _apart(full.lower, other.lower))
    apart[full.status != other.status] = np.inf
    rise = np.where(other.lower > full.lower, _apart(full.lower, other.lower), 0.0)
    known = (full.lower > 0) & np.isfinite(other.lower)
    below = [np.where(np.isfinite(a.lower), a.lower, 1e300) <= (1 + RAISED) * top + 1e-6 for a in (full, other)]
    undecided = [int((a.status == Status.UNDECIDED).sum()) for a in (full, other)]
    return {
        "changed": int((apart > SAME).sum()),
        "by 5 %": int((apart > CLEARLY).sum()),
        "raised": int((rise > RAISED).sum()),
        "highest %": 100 * float(rise[known].max(initial=0.0)),
        "above proof": int((below[0] & ~below[1]).sum()),
        "undecided more": undecided[1] - undecided[0],
    }


def _apart(one: Float, other: Float) -> Float:
    with np.errstate(invalid="ignore", divide="ignore"):
        apart = np.abs(other - one) / np.maximum(np.abs(one), 1e-9)
    apart[one == other] = 0.0
    return np.where(np.isnan(apart), np.inf, apart)


def without(name: str, wanted: Collection[str]) -> dict[str, int]:
    """Count the answers of a case that change without each of the ``wanted`` rules."""
    found = dict.fromkeys(wanted, 0)
    for asked in sources()[name]():
        full, _ = asked.without()
        for rule in wanted:
            found[rule] += int(compared(full, asked.without(rule)[0], full.upper)["changed"])
    return found


def _case(name: str, drawn: Callable[[], Iterator[Asked]]) -> list[Row]:
    """Return one row for each rule, and one for each pair that changes something which neither rule does alone."""
    every, size, spent = list(rules()), 0, 0.0
    counts: dict[str, dict[str, float]] = {}
    for asked in drawn():
        full, cost = asked.without()
        top = np.where(np.isfinite(full.upper), full.upper, np.inf)
        size, spent = size + len(full), spent + cost
        quiet = []
        for rule in every:
            other, less = asked.without(rule)
            own = compared(full, other, top) | {"s saved": cost - less}
            quiet += [rule] if not own["changed"] else []
            _add(counts, rule, own)
        for one, two in itertools.combinations(quiet, 2):
            own = compared(full, asked.without(one, two)[0], top)
            if own["changed"]:
                _add(counts, f"{one} + {two}", own | {"s saved": 0.0})
    rows: list[Row] = [{"case": name, "rule": "all", "pushes": size, "s": spent}]
    return rows + [{"case": f"{name}: {rule}", "rule": rule} | own for rule, own in counts.items()]


def _add(counts: dict[str, dict[str, float]], rule: str, own: dict[str, float]) -> None:
    before = counts.setdefault(rule, dict.fromkeys(own, 0.0))
    for key, value in own.items():
        before[key] = max(before[key], value) if key == "highest %" else before[key] + value


def _scene(name: str) -> Iterator[Asked]:
    yield from at_rest(assemble(shipped_scene(name)), SLANTS, PUSHES["scene"], Compliant(), 0)


def _family(name: str) -> Iterator[Asked]:
    for member in range(MEMBERS):
        try:
            assembly = standing(FAMILIES[name], np.random.default_rng([SEED, member]))
        except HoldfastError:  # none of many draws stands
            continue
        yield from at_rest(assembly, SLANTS, PUSHES["family"], Compliant(), member)


def _messy(name: str) -> Iterator[Asked]:
    rng = np.random.default_rng([SEED, list(FAMILIES).index(name)])
    for member in range(MESSY):
        yield from at_rest(assemble(messy(name, rng)), (0.0, 60.0), PUSHES["messy"], Compliant(), member)


def _pallet(boxes: list[dict[str, object]]) -> Iterator[Asked]:
    yield from at_rest(assemble(pallet(boxes)), (0.0, 35.0), PUSHES["pallet"], Compliant(), 0)


def _jam(name: str) -> Iterator[Asked]:
    assembly = assemble(hf.load_scene(CASES / "jams" / f"{name}.yaml"))
    yield from at_rest(assembly, SLANTS, PUSHES["jam"], Compliant(), 0)


def _rough(name: str) -> Iterator[Asked]:
    imperfect = imperfect_faces(SAMPLES, SEED)
    for sample in range(SAMPLES):
        engine = Rough(Compliant(), RandomFaces(imperfect, sample))
        yield from at_rest(assemble(shipped_scene(name)), (60.0,), PUSHES["rough"], engine, sample)


def sources() -> Mapping[str, Callable[[], Iterator[Asked]]]:
    """What pushes are drawn for each scene, family, pallet or jam."""
    some = [boxes for boxes in pallets() if len(boxes) <= MOST_BOXES][::EVERY]
    jams = sorted(file.stem for file in (CASES / "jams").glob("*.yaml"))
    drawn: dict[str, Callable[[], Iterator[Asked]]] = {f"jam {name}": partial(_jam, name) for name in jams}
    drawn |= {f"scene {name}": partial(_scene, name) for name in SCENES}
    drawn |= {f"family {name}": partial(_family, name) for name in FAMILIES}
    drawn |= {f"pallet {k}: {len(boxes)} boxes": partial(_pallet, boxes) for k, boxes in enumerate(some)}
    drawn |= {f"rough {name}": partial(_rough, name) for name in ("table", "wall2x2", "arch", "v_groove")}
    drawn |= {f"messy {name}": partial(_messy, name) for name in TROUBLED}
    return drawn


def cases() -> Mapping[str, Case]:
    """One case a scene, family, pallet or jam."""
    return {name: partial(_case, name, source) for name, source in sources().items()}


def written(rows: list[Row]) -> str:
    """What each rule changes over all cases, and over each kind of case where it changes anything."""
    kinds = list(dict.fromkeys(row["case"].split()[0] for row in rows))
    pushes = {kind: sum(row.get("pushes", 0) for row in rows if row["case"].split()[0] == kind) for kind in kinds}
    each: list[Row] = [_together(rule, rows, sum(pushes.values())) for rule in dict.fromkeys(r["rule"] for r in rows)]
    lines = [line for line in each if line["rule"] != "all"]
    counted: list[Row] = [{"kind": kind, "pushes": count} for kind, count in pushes.items()]
    parts = [table(counted), table([line for line in lines if "+" not in line["rule"]])]
    parts += [table([line for line in lines if "+" in line["rule"]] or [{"rule": "no pair changes more"}])]
    for kind in kinds:
        mine = [row for row in rows if row["case"].split()[0] == kind]
        own = [_together(rule, mine, pushes[kind]) for rule in dict.fromkeys(row["rule"] for row in mine)]
        parts.append(f"## {kind}\n\n" + table([line for line in own if line["changed %"] and line["rule"] != "all"]))
    return "\n\n".join(parts)


def _together(rule: str, rows: list[Row], pushes: int) -> Row:
    mine = [row for row in rows if row["rule"] == rule and "changed" in row]
    line: Row = {"rule": rule}
    for key, heading in (("changed", "changed %"), ("by 5 %", "by 5 %, %")):
        line[heading] = 100 * float(sum(row[key] for row in mine)) / max(pushes, 1)
    for key in ("raised", "above proof", "undecided more"):
        line[key] = int(sum(row[key] for row in mine))
    line["highest %"] = max((float(row["highest %"]) for row in mine), default=0.0)
    return line | {"s saved": float(sum(row["s saved"] for row in mine))}


SUITE = Suite("amendments", __doc__, cases, written=written)
