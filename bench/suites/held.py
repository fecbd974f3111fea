"""What really holds: pushes in MuJoCo and in discrete elements, neither of which solves for equilibrium, in newtons.

Jams, piles of round bodies and ordinary pushes; scenes in which `lower` was once above what holds come first. Each
push is raised, in shares of today's `force`, until a code sees it move. ``python -m bench.suites.held [TABLE]`` asks
the engine that is installed about every row of a table again, and tells where `lower` is above what both codes hold.
"""

from __future__ import annotations

import ast
import json
import re
import sys
import time
from collections.abc import Mapping
from functools import cache, partial
from pathlib import Path

import numpy as np

import holdfast as hf
from bench.baselines import penalty
from bench.baselines.mujoco import as_text
from bench.baselines.native import Native
from bench.checkout import CASES, RESULTS
from bench.scenes.jams import FAMILIES, jam
from bench.scenes.piles import PILES, free
from bench.scenes.random_pushes import Push, columns, random_pushes
from bench.suite import Case, Row, Suite, table
from holdfast import Status
from holdfast.answers import Assembly
from holdfast.base.arrays import Float, unit
from holdfast.engines.compliant.elastic_model import Places
from holdfast.scene.shipped import shipped_scene, shipped_scenes

LEFT_OUT = ("tabletop", "bonded_wall", "wedged")  # hollow meshes; 50 bricks; held by nothing but self-stress
SHIPPED = tuple(name for name in shipped_scenes() if name not in LEFT_OUT)
JAMS, PILED, ORDINARY = 300, 100, 10  # jams, piles, and pushes on each shipped scene
PUSHES, SLANT = 6, 60.0  # pushes among which one is chosen, and their slant [deg]
MARGIN = 0.01  # of gravity, by which a pile stands at least
MOST = 30.0  # weights of all bodies, beyond which no code is asked
LEVELS = np.array([0.025, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, *np.arange(0.65, 1.08, 0.05), 1.15, 1.3])  # of `force`
STEPS = (4e-4, 1e-4)  # [s] of MuJoCo: what moves with the first and holds with the second was its softness
SIDE, SIDE_OF_LINES = 5, 3  # nodes along a side of discrete elements; the square of it lies along a line
SOFT = 0.5  # tangential over normal stiffness, at which free piles are asked once more
PARTS = 10  # in which the weight comes on
RISE, FINEST = 0.05, 0.012  # steps of load of discrete elements, in shares of `force`
GONE = 1000.0  # times what the push moves where all nodes stick: that has moved; lines slide before a jam holds
LOOSE = 20.0  # times the largest air between two bodies, which may be taken up besides
SLID = (10.0, 30.0, 100.0)  # such multiples, for which the largest load that stays within is kept
LONG = 30_000  # time steps after which discrete elements neither rest nor move
BEYOND = (1.05, 1.15, 1.3)  # times a load at which they did neither
CODES, SEEN = ("mujoco", "dem"), ("holds", "moves")
SLACK = 1.02  # times what moves, beyond which `lower` is above
# body, point and direction of pushes whose `lower` was above what holds: T1 to T3 of version 0.2
KNOWN = {
    "ceil": ("a", (-0.05, 0, 0.19), (1, 0, 0)),
    "lean1079": ("plank", (0.00606783, -0.04766791, 0.24077966), (0.52199773, 0.33881782, -0.78276486)),
    "tilt_books": ("book0", (-0.01832046, 0.01440752, 0.00935545), (0.60846051, 0.78950702, 0.08033979)),
    "walls26": ("block", (0.12229682, 0.01718949, 0.13341969), (-0.48816778, -0.50808876, -0.70960414)),
    "pipes38": ("p0", (-0.071625, 0.23642569, 0.07452129), (0.50652923, -0.77911562, -0.36933316)),
}
PRINTED = ("e12_35_1", "pipes16_0", "pipes16_1")  # S4 and S5 of 1.0.0rc1; the push is in a text beside the scene


def by_mujoco(assembly: Assembly, push: Push, force: float) -> Row:
    """Bisect LEVELS with long steps; what moves with them has to move with short ones. None where nothing stands.

    Only what goes far counts: in a jam its friction creeps, by 0.3 mm with steps of 1e-4 s, 0.9 mm with 4e-4 s.
    """
    fell: Row = {"holds_mujoco": None, "moves_mujoco": None}
    worlds = [cache(partial(Native, assembly.scene, step)) for step in STEPS]
    coarse = worlds[0]()
    if not coarse.stands:
        return fell
    held, moved = -1, len(LEVELS)
    while moved - held > 1:
        k = (held + moved) // 2
        held, moved = (held, k) if coarse.moves(push, LEVELS[k] * force, np.inf) else (k, moved)
    while moved < len(LEVELS):
        fine = worlds[1]()
        if not fine.stands:
            return fell
        if fine.moves(push, LEVELS[moved] * force, np.inf):
            break
        held, moved = moved, moved + 1
    shares = np.array([0.0, *LEVELS, np.inf])
    return {"holds_mujoco": shares[held + 1] * force, "moves_mujoco": shares[moved + 1] * force}


def air_of(assembly: Assembly) -> Float:
    """The air [m] between the two bodies of each interface."""
    return np.array([max(interface.separation or 0.0, 0.0) for interface in assembly.interfaces])


def by_elements(assembly: Assembly, push: Push, force: float, ratio: float = 1.0) -> Row:
    """Raise the load from rest to rest, and halve the step where something moves. None where nothing stands.

    The weight comes on in parts, as slowly as the load: where it comes at once, what it shakes stays shaken.
    ``ratio``: tangential over normal stiffness.
    """
    faces = any(patch.kind == "face" for interface in assembly.interfaces for patch in interface.patches)
    nodes = Places.of(assembly, SIDE if faces else SIDE_OF_LINES).nodes
    air = air_of(assembly)[nodes.interface]
    model = penalty.blocks(assembly, nodes, ratio, apart=air / (penalty.SINK * assembly.size))
    weight, column = assembly.weight_wrench(), columns(assembly, [push])[:, 0]
    state = penalty.still(assembly, nodes)
    for k in range(PARTS):
        state, trial = penalty.settled(assembly, model, (k + 1) / PARTS * weight, state, np.inf, LONG)
        if not trial.holds:
            return {"holds_dem": None, "moves_dem": None}
    home, stuck_all = state.q, penalty.bonded(model, column)

    def tried(load: float) -> tuple[penalty.State, bool | None, float]:
        far = GONE * load * stuck_all + LOOSE * float(air.max())
        end, seen = penalty.settled(assembly, model, weight + load * column, state, far, LONG)
        slid = penalty.apart(model, end.q, home)
        return end, seen.holds if slid <= far else False, slid / (load * stuck_all)

    holds, stuck, moves = 0.0, np.inf, np.inf
    within = dict.fromkeys(SLID, 0.0)
    while holds < LEVELS[-1] * force and min(stuck, moves) - holds > FINEST * force:
        load = min(holds + RISE * force, (holds + min(stuck, moves)) / 2)
        end, rests, slid = tried(load)
        if rests:
            state, holds = end, load
            within |= {far: load for far in SLID if slid <= far}
        elif rests is None:
            stuck = load
        else:
            moves = load
    for share in BEYOND if stuck < moves else ():
        if share * stuck < moves and tried(share * stuck)[1] is False:
            moves = share * stuck
    return {"holds_dem": holds, "moves_dem": moves} | {f"slid {far:g}": load for far, load in within.items()}


def answer(assembly: Assembly, push: Push) -> tuple[float, float]:
    """Today's `force` and `lower` [N]; both 0 where the engine is undecided."""
    found = hf.robustness(assembly, push.body, push.point, push.direction)
    return (float(found.force[0]), float(found.lower[0])) if found.verdict.status is Status.STABLE else (0.0, 0.0)


def hardest(assembly: Assembly, pushes: list[Push]) -> Push | None:
    """The push with the largest `force` that is not beyond MOST weights, if any is above 0."""
    forces = [force if force < MOST * assembly.weight else 0.0 for force, _ in (answer(assembly, p) for p in pushes)]
    return pushes[int(np.argmax(forces))] if max(forces) > 0 else None


def pile(number: int) -> Assembly:
    """The pile of this number."""
    return hf.assemble(PILES[number % len(PILES)](np.random.default_rng([49, number])))


def known(name: str) -> tuple[Assembly, Push]:
    """A scene and the push about which an engine was once wrong."""
    if name in KNOWN:
        body, point, direction = KNOWN[name]
    else:
        text = re.search(r"scene, (.*)\) force", (CASES / "v1" / f"{name}.txt").read_text())
        assert text is not None
        body, point, direction = ast.literal_eval(f"({text.group(1)})")
    file = CASES / ("jams" if name in KNOWN else "v1") / f"{name}.yaml"
    return hf.assemble(hf.load_scene(file)), Push(body, np.array(point), unit(np.array(direction)))


def scene_of(case: str) -> tuple[str, Assembly]:
    """Family and scene of a case."""
    name, _, number = case.rpartition("_")
    if name == "jam":
        return FAMILIES[int(number) % len(FAMILIES)].__name__, jam(int(number))[0]
    if name == "pile":
        return f"pile {PILES[int(number) % len(PILES)].__name__}", pile(int(number))
    if name in SHIPPED:
        return name, hf.assemble(shipped_scene(name))
    return "known", known(case)[0]


def push_of(case: str, assembly: Assembly) -> Push | None:
    """The push of a case; None where the engine holds none of those drawn, or all, and for piles that hardly stand."""
    name, _, number = case.rpartition("_")
    if name == "jam":
        return hardest(assembly, jam(int(number))[1])
    if name == "pile":
        verdict = hf.stability(assembly)
        if verdict.status is not Status.STABLE or verdict.margin < MARGIN:
            return None
        return hardest(assembly, random_pushes(assembly, np.random.default_rng([50, int(number)]), PUSHES, slant=SLANT))
    if name in SHIPPED:
        return random_pushes(assembly, np.random.default_rng(1), ORDINARY, slant=SLANT)[int(number)]
    return known(case)[1]


def measured(case: str) -> list[Row]:
    """What both codes see, beside what the engine says today; nothing where it says 0 or beyond MOST weights."""
    family, assembly = scene_of(case)
    push = push_of(case, assembly)
    force, lower = (0.0, 0.0) if push is None else answer(assembly, push)
    if push is None or not 0 < force < MOST * assembly.weight:
        return []
    line: Row = {"case": case, "family": family, "body": push.body}
    line |= {"point": as_text(push.point), "direction": as_text(push.direction)}
    line |= {"weight": assembly.weight, "air": float(air_of(assembly).max()), "force": force, "lower": lower}
    for name, ask in (("mujoco", by_mujoco), ("dem", by_elements)):
        start = time.process_time()
        line |= ask(assembly, push, force)
        line[f"{name} s"] = time.process_time() - start
    if family == f"pile {free.__name__}" or case in PRINTED:  # whether these stand at all hangs on stiffness
        softer = by_elements(assembly, push, force, SOFT)
        line |= {f"{key} half": softer[key] for key in ("holds_dem", "moves_dem")}
    return [line]


def cases() -> Mapping[str, Case]:
    """The known ones where the published scenes are, jams, piles, ordinary pushes."""
    names = [*PRINTED, *KNOWN] if CASES.exists() else []
    names += [f"jam_{k}" for k in range(JAMS)] + [f"pile_{k}" for k in range(PILED)]
    names += [f"{scene}_{k}" for scene in SHIPPED for k in range(ORDINARY)]
    return {name: partial(measured, name) for name in names}


def again(row: Row, scenes: Path) -> Row:
    """A row with what the engine says now, on the scene of that name in a folder or, if there is none, built anew."""
    file = scenes / f"{row['case']}.yaml"
    assembly = hf.assemble(hf.load_scene(file)) if file.exists() else scene_of(row["case"])[1]
    point, direction = (np.array([float(word) for word in row[key].split()]) for key in ("point", "direction"))
    force, lower = answer(assembly, Push(row["body"], point, direction))
    return row | {"force now": force, "lower now": lower}


def group(row: Row) -> str:
    """Known, jams, piles or ordinary."""
    name = row["case"].rpartition("_")[0]
    return {"jam": "jams", "pile": "piles"}.get(name, "ordinary" if name in SHIPPED else "known")


def said(row: Row, what: str) -> float:
    """What the engine says now, or said when the row was measured."""
    return float(row[f"{what} now" if f"{what} now" in row else what])


def softer(row: Row) -> str:
    """A line where `lower` is above what MuJoCo and half as stiff elements both see move, or do not see stand."""
    moves = [float(row[key] or 0) for key in ("moves_mujoco", "moves_dem half")]
    name = f"- `lower` of {row['case']}: {said(row, 'lower'):.4g} N; half as stiff and in MuJoCo it moves at"
    return f"{name} {moves[1]:.4g} and {moves[0]:.4g}" if said(row, "lower") > SLACK * max(moves) else ""


def written(rows: list[Row]) -> str:
    """How cautious `lower` and `force` are beside what both codes hold, and where one is above what both see move."""
    half = [softer(row) for row in rows if "moves_dem half" in row]
    rows = [row for row in rows if row["holds_mujoco"] is not None and row["holds_dem"] is not None]
    lines, text = [], []
    for name in ("known", "jams", "piles", "ordinary"):
        of = [row for row in rows if group(row) == name]
        holds, moves = (np.array([[float(row[f"{what}_{code}"]) for code in CODES] for row in of]) for what in SEEN)
        for what in ("lower", "force") if of else ():
            says = np.array([said(row, what) for row in of])
            line: Row = {"case": name, "cases": len(of), "of": what}
            for words, held in (("both hold", holds.min(1)), ("one holds", holds.max(1))):
                share = says[held > 0] / held[held > 0]
                for quantile, at in (("10 %", 0.1), ("median", 0.5)):
                    line[f"over what {words}, {quantile}"] = float(np.quantile(share, at)) if len(share) else ""
            above = says > SLACK * moves.max(1)
            line["above what both see move"] = int(above.sum())
            for far in SLID:
                beyond = [min(float(row[f"slid {far:g}"]) + RISE * row["force"], float(row["moves_dem"])) for row in of]
                line[f"the same, slid {far:g}"] = int((says > SLACK * np.maximum(moves[:, 0], beyond)).sum())
            lines.append(line)
            text += [
                f"- `{what}` of {of[k]['case']}, {of[k]['family']}: {says[k]:.4g} N; "
                f"MuJoCo moves at {moves[k, 0]:.4g}, discrete elements at {moves[k, 1]:.4g}"
                for k in np.flatnonzero(above)
            ]
    return "\n".join([table(lines), "", *text, *filter(None, half)]).strip()


def main() -> None:
    """Ask the engine about all rows of a table again, and print."""
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else RESULTS / "held.json"
    text = path.read_text()
    rows = [json.loads(line) for line in text.splitlines()] if path.suffix == ".jsonl" else json.loads(text)["rows"]
    sys.stdout.write(written([again(row, path.parent / "scenes") for row in rows]) + "\n")


SUITE = Suite("held", __doc__, cases, written=written)

if __name__ == "__main__":
    main()
