"""The baselines of the engines: dynamic simulations and the paper's optimisation. Engines do not import them.

    assembly = hf.assemble(hf.shipped_scene("table"))
    push = assembly, "slab", (-0.25, 0, 0.225), (1, 0, 0)  # or n points and n directions
    simulated(*push, engine="pybullet", protocol="printed")  # Algorithm 2 of the paper
    simulated(*push, engine="pybullet")  # held loads; or "mujoco", "lmgc90"
    optimised(*push, sides=8)  # eq. 28-32 by IPOPT

Each returns ``Answers``. How each works, and what the paper leaves open: bench/notes/baselines.md.
"""

from bench.baselines.answers import Answers, simulated
from bench.baselines.ipopt import optimised

__all__ = ["Answers", "optimised", "simulated"]
