"""
14. Put things away
===================

First a cup where people would put it, then a whole tray, so that everything stands after each step.
"""

import sys
from pathlib import Path

import holdfast as hf

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
folder.mkdir(exist_ok=True)

shelf = hf.Body("shelf", hf.Box((0.6, 0.3, 0.02)), position=(0, 0, -0.01), fixed=True)
book = hf.Body("book", hf.Box((0.15, 0.21, 0.03)), mass=0.7, position=(-0.1, 0, 0.015))
vase = hf.Body("vase", hf.Cylinder(0.03, 0.2), mass=0.4, position=(0.1, 0, 0.1))
scene = hf.Scene([shelf, book, vase], 0.5, name="shelf")
cup = hf.Body("cup", hf.Cylinder(0.035, 0.09), mass=0.25)

# beside the vase, out of the front edge, with room for fingers 8 cm apart that come from above
p = hf.plan_placement(
    hf.assemble(scene),
    cup,
    where=hf.Where(supports=["shelf"], next_to="vase", keep_out=[((-0.3, -0.15), (0.3, -0.1))]),
    approach=hf.sets.Approach(direction=(0, 0, -1), gripper=((-0.04, -0.01, -0.02), (0.04, 0.01, 0.1))),
    engine="graph",
)
if p.pose is None or p.rating is None or p.rating.own is None:
    sys.exit(f"no place was found: {p.reason}")
print(f"{p.status} at {p.pose[:3, 3].round(3)}, its own axis up by {p.pose[2, 2]:.2f}")
print(
    f"{p.rating.own:.2g} N move it, {1e3 * p.rating.room:.0f} mm of room; elsewhere {p.robustness:.2g} N move the vase"
)

# six things on a tray, in an order that is chosen
tray = hf.Scene([hf.Body("tray", hf.Box((0.35, 0.25, 0.02)), position=(0, 0, -0.01), fixed=True)], 0.5, name="tray")
things = [
    cup,
    hf.Body("tin", hf.Cylinder(0.04, 0.05), mass=0.4),
    hf.Body("jug", hf.Cylinder(0.04, 0.14), mass=0.9),
    hf.Body("butter", hf.Box((0.1, 0.06, 0.03)), mass=0.25),
    hf.Body("box", hf.Box((0.06, 0.04, 0.08)), mass=0.15),
    hf.Body("salt", hf.Cylinder(0.015, 0.06), mass=0.1),
]
laid = hf.place_all(tray, things, engine="graph")
for step in laid.steps:
    print(f"{step.body} at {step.pose[:3, 3].round(3)}: least push {step.least:.2g} N")
print(laid.status, "-", laid.reason)
laid.save_png(folder / "tray.png")
