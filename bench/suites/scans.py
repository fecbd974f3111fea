"""Scenes of scans: patches before and after merging, what pushes make of it, and times; beside an older version.

All eight settled scenes. ``before`` is the contact as it is found, ``after`` the merged one. Pushes are random ones on
random bodies by engine ``compliant``; ``same normals`` compares with the unmerged nodes, given the normals of
merged patches, without finer
nodes where those are too coarse: so it differs where nothing is merged, too (beam_frame). Times are those of the
processor, the least of several, with everything compiled. ``stands`` counts, of the pushes that merging lets fall by
more than a tenth, those under midway forces of which the merged contact comes to rest if they are there at once: what
the path found is then a place where bodies slip a little and are caught again.
With ``--beside DIR`` the older checkout takes turns with this one. Version 0.1 puts a point on every facet that is left
of a scan, so its maps have points of their own number, and are compared by the time of a point.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

import holdfast as hf
from bench.checkout import SOURCE, older
from bench.suite import Case, Row, Suite, table
from bench.suites.reliability import SETTLED, random_pushes, settled_file
from holdfast.assembly.contact_nodes import ContactNodes, contact_nodes
from holdfast.base.arrays import Float
from holdfast.base.rigid import tangents
from holdfast.contacts.contact_search import find_contacts
from holdfast.engines.groups import prepared

TOLERANCES: Mapping[str, Mapping[str, float]] = {**SETTLED, "dishes": {"gap": 5e-3}, "masonry_crossvault": {}}
UNCERTAIN = (0.0015, 0.5)  # [m], [deg]: standard deviations of the poses
UNCERTAIN_POSES = "uncertain poses"
PUSHES, SEED = 50, 77
MAPPED = {"kitchen_place": (0.03, 0.09), "lack_table": (0.038, 0.1)}  # spacings [m]: about 1,000 points, and 150
MAPPED_BEFORE = {"kitchen_place": 0.2, "lack_table": 0.3}  # the same in the older version: about 165 points
FALL = 0.1  # relative fall of R from which on it is asked whether the bodies come to rest under more
TIMED = """
import json, sys, time, warnings
warnings.simplefilter("ignore")
import holdfast as hf
path, options, wanted = sys.argv[1], json.loads(sys.argv[2]), float(sys.argv[3])
least = float("inf")
for run in range(4):
    scene = hf.load_scene(path)
    start = time.process_time()
    assembly = hf.assemble(scene, **options)
    least = min(least, time.process_time() - start)
    if wanted or run > 0 and least > 3:
        break
row = {"seconds": least, "patches": sum(len(i.patches) for i in assembly.interfaces)}
if wanted:
    hf.robustness_map(assembly, [assembly.movable[0].name], spacing=10 * wanted)
    start = time.process_time()
    found = hf.robustness_map(assembly, spacing=wanted)
    row = {"seconds": time.process_time() - start, "points": len(found.force)}
print(json.dumps(row))
"""


def assembled(name: str) -> tuple[hf.Scene, hf.answers.Assembly]:
    path = settled_file(name)
    assert path is not None
    scene = hf.load_scene(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return scene, hf.assemble(scene, gap=TOLERANCES[name].get("gap"), angle_degrees=TOLERANCES[name].get("angle"))


def unmerged(assembly: hf.answers.Assembly) -> hf.answers.Assembly:
    """The same contacts as they were found."""
    found = find_contacts(assembly.scene, assembly.tolerances, merge=False)
    return replace(assembly, interfaces=found.interfaces)


def count(assembly: hf.answers.Assembly) -> int:
    return sum(len(interface.patches) for interface in assembly.interfaces)


def patches(name: str) -> list[Row]:
    scene, usual = assembled(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        wide = hf.assemble(scene, pose_sigma=UNCERTAIN)
    spots = [p.spots for a in (usual, wide) for i in a.interfaces for p in i.patches if p.spots is not None]
    return [
        {
            "case": f"patches, {name}",
            "before": count(unmerged(usual)),
            "after": count(usual),
            "uncertain poses, before": count(unmerged(wide)),
            "uncertain poses, after": count(wide),
            "largest residual, mm": 1e3 * max((s.residual for s in spots if not s.bent), default=0.0),
            "largest spread, deg": max((s.spread for s in spots), default=0.0),
        }
    ]


def levelled(raw: hf.answers.Assembly, found: hf.answers.Assembly) -> ContactNodes:
    """The nodes of contacts as they were found, with the normals of the merged patches."""
    nodes = contact_nodes(raw, 49, "quadrature")
    axes = np.array(nodes.axes)
    for k, interface in enumerate(found.interfaces):
        own = nodes.interface == k
        flat = [patch for patch in interface.patches if not patch.bent]
        if "merged" in interface.flags and len(flat) == len(interface.patches):
            off = [np.abs((nodes.points[own] - p.polygon[0]) @ p.normal) for p in flat]
            alike = [nodes.normals[own] @ p.normal for p in flat]
            nearest = np.argmax(np.array(alike) - np.array(off) / found.tolerances.gap, axis=0)
            normal = np.array([p.normal for p in flat])[nearest]
            axes[own] = np.stack([normal, *tangents(normal)], axis=1)
    return replace(nodes, axes=axes)


def changes(ours: Float, theirs: Float) -> Float:
    both = np.isfinite(ours) & np.isfinite(theirs) & (theirs > 0)
    return ours[both] / theirs[both] - 1


def pushes(name: str) -> list[Row]:
    _, found = assembled(name)
    raw = unmerged(found)
    if not any("merged" in interface.flags for interface in found.interfaces):
        return [{"case": f"pushes, {name}", "patches": f"{count(raw)} to {count(found)}, nothing merged"}]
    W = random_pushes(found, PUSHES, SEED)
    before, after = (prepared(hf.Compliant(), a).load_factor(W) for a in (raw, found))
    limits = [prepared(hf.Limit(), a).load_factor(W).upper for a in (raw, found)]
    level = hf.Compliant().on(raw, raw.weight_wrench(), levelled(raw, found)).load_factor(W)
    known = np.array([str(status) == "finite" for status in level.status])
    change, limit = changes(after.force, before.force), changes(limits[1], limits[0])
    same = changes(after.force[known], level.force[known])
    finite = np.isfinite(before.force) & np.isfinite(after.force)
    fallen = np.flatnonzero(finite & (after.force < (1 - FALL) * before.force)).tolist()
    return [
        {
            "case": f"pushes, {name}",
            "patches": f"{count(raw)} to {count(found)}",
            "compared": len(change),
            "median change %": 100 * float(np.median(np.abs(change))),
            "largest rise %": 100 * float(change.max(initial=0)),
            "largest fall %": -100 * float(change.min(initial=0)),
            "fell by a tenth": len(fallen),
            "stands": sum(stands_under(found, W[:, k], (before.force[k] + after.force[k]) / 2) for k in fallen),
            "same normals: median %": 100 * float(np.median(np.abs(same))) if len(same) else 0.0,
            "rise %": 100 * float(same.max(initial=0)),
            "fall %": -100 * float(same.min(initial=0)),
            "limit: median %": 100 * float(np.median(np.abs(limit))),
            "limit: rise %": 100 * float(limit.max(initial=0)),
            "status differs": sum(a is not b for a, b in zip(before.status, after.status, strict=True)),
        }
    ]


def stands_under(assembly: hf.answers.Assembly, load: Float, force: float) -> bool:
    """Whether bodies come to rest under their weight and this force along a load column (6J,), there at once."""
    state = hf.Compliant().on(assembly, assembly.weight_wrench() + force * load)
    return state.verdict().status is hf.Status.STABLE


def timed(which: str, source: Path, name: str, wanted: float) -> Row:
    """Return the processor time of the version in ``source``: of a map at this spacing [m] or, if 0, to assemble."""
    folder = Path(tempfile.gettempdir(), f"holdfast-scans-{which}")
    folder.mkdir(exist_ok=True)
    own = {"PYTHONPATH": str(source), "HOLDFAST_CACHE_DIR": str(folder), "NUMBA_CACHE_DIR": str(folder)}
    file, _, uncertain = name.partition(", ")
    options = {"pose_sigma": UNCERTAIN} if uncertain == UNCERTAIN_POSES else TOLERANCES[file]
    command = [sys.executable, "-c", TIMED, str(settled_file(file)), json.dumps(options), str(wanted)]
    ran = subprocess.run(command, env=os.environ | own | {"OPENBLAS_NUM_THREADS": "1"}, capture_output=True, check=True)
    return dict(json.loads(ran.stdout))


def assembling(name: str) -> list[Row]:
    row: Row = {"case": f"assemble, {name}"}
    for which, source in versions().items():
        found = timed(which, source, name, 0)
        row |= {f"{which}: seconds s": found["seconds"], f"{which}: patches": found["patches"]}
    return [compared(row, "seconds s")]


def mapping(name: str) -> list[Row]:
    row: Row = {"case": f"map, {name}"}
    for which, source in versions().items():
        spacings = MAPPED[name] if which == "this" else (MAPPED_BEFORE[name],)
        for words, spacing in zip(("", ", fewer"), spacings, strict=False):
            found = timed(which, source, name, spacing)
            row |= {
                f"{which}{words}: points": found["points"],
                f"{which}{words}: seconds": found["seconds"],
                f"{which}{words}: ms a point": 1e3 * found["seconds"] / found["points"],
            }
    return [compared(row, "ms a point")]


def versions() -> dict[str, Path]:
    """The folders of the sources of this version and, if asked for, of the older one."""
    before = older.get()
    return {"this": SOURCE} | ({} if before is None else {"older": before.resolve() / "src"})


def compared(row: Row, key: str) -> Row:
    """The row, with how many times as long the older version took by the column ``key``."""
    return row | {"older / this": row[f"older: {key}"] / row[f"this: {key}"]} if f"older: {key}" in row else row


def cases() -> Mapping[str, Case]:
    names = [name for name in TOLERANCES if settled_file(name) is not None]
    found: dict[str, Case] = {f"patches, {name}": partial(patches, name) for name in names}
    uncertain = [f"{name}, {UNCERTAIN_POSES}" for name in names if name == "kitchen_place"]
    found |= {f"assemble, {name}": partial(assembling, name) for name in (*names, *uncertain)}
    found |= {f"pushes, {name}": partial(pushes, name) for name in names}
    return found | {f"map, {name}": partial(mapping, name) for name in MAPPED if name in names}


def written(rows: list[Row]) -> str:
    kinds = ("patches", "assemble", "pushes", "map")
    parts = [[row for row in rows if str(row["case"]).startswith(kind)] for kind in kinds]
    return "\n\n".join(table(part) for part in parts if part)


SUITE = Suite("scans", __doc__, cases, written=written)
