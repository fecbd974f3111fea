"""
11. Where to put the next thing
===============================

The planner chooses points that withstand much, lets the object down on them, judges the pose and rates it.
"""

import sys
from pathlib import Path

import holdfast as hf

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
folder.mkdir(exist_ok=True)

# a box onto a plank that a counterweight holds down: its free end would not bear it
assembly = hf.assemble(hf.shipped_scene("cantilever"))
box = hf.Body("box", hf.Box((0.06, 0.05, 0.04)), mass=0.4)
p = hf.plan_placement(
    assembly, box, where=hf.Where(supports=["B", "C", "D"]), search=hf.Search(candidates=4), engine="graph"
)
if p.pose is None or p.weakest is None:
    sys.exit(f"no place was found: {p.reason}")
print(f"{p.status} after {p.attempts} attempts at {p.pose[:3, 3].round(3)}, on {p.contacts[0].bodies[0]}")
print(f"least push afterwards: {p.robustness:.3g} N on {p.weakest.body} ({p.weakest.mode})")
p.save_png(folder / "placement.png")

# a brick that no place there bears: a reason, and the try that came nearest
brick = hf.Body("brick", hf.Box((0.05, 0.05, 0.05)), mass=50)
none = hf.plan_placement(
    assembly,
    brick,
    where=hf.Where(supports=["C"], avoid=["floor", "A", "B", "D"]),
    search=hf.Search(solves=10),
    engine="graph",
)
print(none.status, "-", none.reason)
