"""
20. Make it firmer
==================

A vase stands near the side of a post: where should it stand, and what does a braking robot gain by that?
"""

import sys
from pathlib import Path

import holdfast as hf

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
folder.mkdir(exist_ok=True)

post = hf.Body("post", hf.Box((0.1, 0.1, 0.3)), position=(0, 0, 0.15), fixed=True)
vase = hf.Body("vase", hf.Cylinder(0.04, 0.2), mass=1.0, position=(0.03, 0.01, 0.4))
scene = hf.Scene([post, vase], 0.5)

# 1. Pushed anywhere
found = hf.firmer(scene, "vase")
print(found)
for step in found:
    x, y = step.poses["vase"][:2, 3]
    print(f"at ({1e3 * x:3.0f}, {1e3 * y:3.0f}) mm the least push is {step.least['vase']:.2f} N")

# 2. The post is a robot that brakes: what it may do is limited to one side
brake = [(0.0, -1.5, 0.0, 0.0), (0.5, -1.5, 0.0, 0.0)]  # t [s], acceleration [m/s²]
rides = hf.firmer(scene, "vase", motion=brake, engine="limit")
print(f"it could brake {rides.before:.2f} times as hard; now {rides.after:.2f} times")

found.save_png(folder / "firmer.png")
hf.save_scene(found.assembly.scene, folder / "firmer.yaml")
