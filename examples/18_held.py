"""
18. Held in a hand
==================

A cup between two fingers: which grip force it needs, and how hard it may be pulled. An arch that two hands build.
"""

import holdfast as hf

floor = hf.Body("floor", hf.HalfSpace(), fixed=True)
cup = hf.Body("cup", hf.Cylinder(0.04, 0.1), mass=0.3, position=(0, 0, 1))


def gripped(force: float) -> hf.Scene:
    """The cup between two fingers that press with at most this force [N]."""
    pads = hf.Grip("cup", [(0.04, 0, 1), (-0.04, 0, 1)], [(-1, 0, 0), (1, 0, 0)], mu=0.4, force=force)
    return hf.Scene([floor, cup], 0.5, holds=[pads])


for force in (3.6, 3.7, 10.0):
    held = gripped(force)
    verdict = hf.stability(held, engine="limit")
    pull = hf.load_factor(held, [hf.Load("cup", (0, 0, 1), (0, 0, -1))], engine="limit")
    print(f"fingers of {force} N: {verdict.status}, and {float(pull):.2f} N pull it out")

order = hf.build_order(hf.shipped_scene("arch"), hands=2)
for step in order.steps:
    print(f"put in {step.body}", *(f"while you {hold.text}" for hold in step.holds))
