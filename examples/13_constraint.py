"""
13. A planner's constraint
==========================

An optimiser (scipy) finds how hard a hand may push, within what a body can take.
"""

import time

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import LinearConstraint, NonlinearConstraint, minimize

import holdfast as hf

# 1. What the slab of the table can take, as a function of the wrench: what holds, checked in between.
table = hf.assemble(hf.shipped_scene("table"))
limit = hf.sets.constraint(table, "slab")
print(limit)

# 2. A hand pushes at the left edge of the slab. It should push along +x and a little sideways, as hard as it can
#    without moving anything, and use at most 80 % of what the slab takes. A push leads into the body: f_x >= 0.
hand = np.array([-0.25, 0.05, 0.225])
wanted = np.array([1.0, 0.4, 0.0])
torque = limit.wrenches(hand, np.eye(3))  # the wrench of a force at the hand is a linear function of the force


def missed(force: NDArray[np.float64]) -> float:
    return -float(force @ wanted)


def missed_more(force: NDArray[np.float64]) -> NDArray[np.float64]:
    return -wanted


def used(force: NDArray[np.float64]) -> list[float]:
    return [float(limit.usage(force @ torque))]


def used_more(force: NDArray[np.float64]) -> NDArray[np.float64]:
    return torque @ limit.cut(force @ torque)


within = NonlinearConstraint(used, -np.inf, 0.8, jac=used_more)
grip = LinearConstraint([(0.5, y, z) for y in (-1, 1) for z in (-1, 1)], lb=0)  # |f_y| + |f_z| <= f_x / 2: no slip
found = minimize(
    missed,
    x0=np.array([0.1, 0.0, 0.0]),
    jac=missed_more,
    constraints=(within, grip),
    method="SLSQP",
)
force = found.x
share = used(force)[0]
print(f"the hand pushes with ({force[0]:.2f}, {force[1]:.2f}, {force[2]:.2f}) N and uses {share:.0%}")

# 3. The same push, asked directly, as one does with the push that is to be made: it may be 1/0.8 times as large.
size = float(np.linalg.norm(force))
told = hf.robustness(table, "slab", hand, force / size)
print(f"it holds up to {told.lower[0] / size:.3f} times as much; the constraint promised {1 / share:.3f}")
assert told.lower[0] > size

# 4. A whole trajectory of pushes at once.
turns = np.linspace(0, 2 * np.pi, 5_000)
pushes = np.stack([np.cos(turns), np.sin(turns), np.zeros_like(turns)], axis=1)
start = time.perf_counter()
factors = np.asarray(limit.value(limit.wrenches(hand, pushes)))
print(f"{len(turns)} level pushes in {time.perf_counter() - start:.2f} s: {factors.min():.2f} to {factors.max():.2f} N")
