"""
2. How hard may one push here?
==============================

The answer names its kind, its bounds and what gives way.
"""

import holdfast as hf

assembly = hf.assemble(hf.shipped_scene("table"))
points = [(-0.25, 0.0, 0.225), (-0.24, 0.0, 0.25), (0.0, 0.0, 0.25), (0.2, -0.1, 0.225)]
directions = [(1, 0, 0), (0, 0, -1), (0, 0, -1), (0, 1, 0)]
r = hf.robustness(assembly, body="slab", points=points, directions=directions)
print(f"engine {r.engine}, claim: {r.claim}")
for k in range(len(points)):
    what = r.mechanism[k].text if r.mechanism[k] else "nothing moves"
    print(f"push at {points[k]} along {directions[k]}: {r.force[k]:.4g} N ({r.status[k]}, {r.mode[k]}): {what}")
