"""
12. Carried
===========

Does a pallet hold on the road, what gives way first, and what do straps change?
"""

import numpy as np

import holdfast as hf


def placed(name: str, size: tuple[float, float, float], mass: float, x: float, z: float) -> hf.Body:
    """A carton whose centre is at (x, 0, z) metres."""
    return hf.Body(name, hf.Box(size), mass=mass, position=(x, 0, z), material="carton")


deck = hf.Body("deck", hf.Box((2, 2, 0.1)), position=(0, 0, -0.05), fixed=True)
cartons = [
    placed("left", (0.4, 0.6, 0.4), 20, -0.2, 0.2),
    placed("right", (0.4, 0.6, 0.4), 20, 0.2, 0.2),
    placed("top", (0.6, 0.6, 0.3), 12, 0.0, 0.55),
]
scene = hf.Scene([deck, *cartons], hf.Friction(default=0.35), name="pallet")
pallet = hf.assemble(scene)

# 1. A motion by name: where the numbers are from is told with it.
carried = hf.carry(pallet, "road")
print(carried)
print(f"slow down to {carried.time_scale(margin=0.1):.2f} times the speed, or tie it down")

# 2. A strap over the top, drawn tight to 2 kN, with the friction of the edges.
strap = hf.Strap(
    [("deck", (0, -0.3, 0)), ("top", (0, -0.3, 0.7)), ("top", (0, 0.3, 0.7)), ("deck", (0, 0.3, 0))],
    2000,
    mu=0.15,
)
tied = hf.carry(pallet, "road", standing=strap.loads(pallet))
print(tied)

# 3. Film around both layers, an anti-slip mat as a material, and a motion of one's own: t, ax, ay, az.
film = [load for height in (0.1, 0.3, 0.5, 0.65) for load in hf.Strap.around(pallet, height, 40).loads(pallet)]
mats = hf.assemble(hf.Scene(scene.bodies, hf.Friction(default=0.35, pairs={("carton", "deck"): 0.6}), name="pallet"))
time = np.linspace(0, 4, 41)
bend = np.stack([time, -2 * np.sin(time), 2.5 * np.sin(time) ** 2, 0 * time], axis=1)
print(hf.carry(mats, bend, standing=film))
