"""
5. Interfaces from elsewhere
============================

Where contacts are known better than the meshes, give them.
"""

import numpy as np

import holdfast as hf

scene = hf.Scene(
    [
        hf.Body("ground", hf.Box((1, 1, 0.1)), position=(0, 0, -0.05), fixed=True),
        hf.Body("cube", hf.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0, 0, 0.05)),
    ],
    friction=0.6,
)
# The cube stands on three feet of 1 cm; the normal points into the second body.
square = 0.005 * np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
feet = [
    hf.answers.Interface(("ground", "cube"), polygon=square + np.array((x, y, 0)), normal=(0, 0, 1))
    for x, y in ((-0.04, -0.04), (0.04, -0.04), (0.0, 0.04))
]
assembly = hf.assemble(scene, interfaces=feet)
r = hf.robustness(assembly, "cube", (0.05, 0, 0.09), (-1, 0, 0))
print(f"a push near the top: {r.force[0]:.3f} N, {r.mode[0]}")
