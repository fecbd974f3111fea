"""
6. Several loads at once
========================

A tray that accelerates, with somebody leaning on the stack it carries.
"""

import numpy as np

import holdfast as hf

assembly = hf.assemble(hf.shipped_scene("stack"))
lean = hf.Load("cube3", point=(0, 0, 0.3), force=(0, 0, -5.0))
for name, direction in (("+x", (1, 0, 0)), ("+x +y", (1, 1, 0))):
    unit = np.array(direction) / np.linalg.norm(direction)
    # An acceleration of the support by 1 m/s² pulls every body back by its mass.
    carried = zip(assembly.movable, assembly.mass, strict=True)
    inertia = [hf.Load(body.name, point=body.com_world, force=-mass * unit) for body, mass in carried]
    free = hf.load_factor(assembly, inertia)
    pressed = hf.load_factor(assembly, inertia, standing=[lean])
    print(f"along {name}: {free.factor:.3f} m/s² ({free.mode}), with 5 N on top {pressed.factor:.3f} m/s²")
