"""
A perceived scene
=================

A camera saw a stack of boxes, with errors of millimetres: bring it to rest, and learn how hard a robot may push.
"""

# %%
# The detections: the second box hovers, the third hovers and leans.
import numpy as np

import holdfast as hf

# sphinx_gallery_thumbnail_path = 'images/settled.png'

given = hf.shipped_scene("stack")
seen = given.moved({"cube2": hf.pose(0.004, 0, 0.153), "cube3": hf.pose(-0.003, 0.002, 0.256, pitch=2)})
print(hf.stability(seen).reason)

# %%
# Settle: close gaps and undo overlaps, without a simulation. What fell would be named.
rest = hf.settle(seen)
for name, reason in zip(rest.names, rest.reasons, strict=True):
    print(f"{name} {reason}")
rest

# %%
# Ask the scene at rest as if it were exact:
push = ("cube3", rest.scene.body("cube3").placed(np.array([(-0.05, 0, 0)]))[0], (1, 0, 0))
ideal = hf.robustness(rest.scene, *push)
print(f"{ideal.force[0]:.2f} N")

# %%
# It is not exact. Poses are good to 1 mm and 0.3 degrees, friction to a fifth, masses to a tenth. ``lower`` allows for
# the poses alone, the quantile for everything: 19 of 20 such scenes withstand it.
sigma = (0.001, 0.3)
doubtful = hf.assemble(rest.scene, pose_sigma=sigma)
print(f"lower {hf.robustness(doubtful, *push).lower[0]:.2f} N")
doubts = hf.sets.Uncertain(pose_sigma=sigma, mu_range=0.2, mass_range=0.1, samples=20, seed=1)
under = hf.robustness_under(doubtful, *push, doubts)
print(f"robot {under.quantile(0.05)[0]:.2f} N")

# %%
# What may the robot take out first?
hf.disassembly_order(hf.assemble(rest.scene))
