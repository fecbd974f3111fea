"""
9. How fast may a robot drive off with this on its tray?
========================================================

Then a path that is too fast, slowed down.
"""

import sys
from pathlib import Path

import numpy as np

import holdfast as hf

out = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("out")
out.mkdir(exist_ok=True)

assembly = hf.assemble(hf.shipped_scene("slope_two"))
ahead, back = np.array([0, 1, 0]), np.array([0, -1, 0])
t = hf.transport_limits(assembly, [ahead, back], engine="limit")
for name, a, mode, moving in zip(("ahead", "back"), t.acceleration, t.mode, t.moving, strict=True):
    print(f"{name}: {a:.2f} m/s², then {mode} of {', '.join(moving)} ({t.engine}: {t.claim})")

# the tray is tilted by 5 degrees, and the robot turns on the spot, half a metre from the tray
around = hf.transport_limits(
    assembly,
    tilt_degrees=(5, 0, 0),
    standing=hf.sets.inertial_loads(
        assembly, angular_velocity=(0, 0, 1.0), angular_acceleration=(0, 0, 0.5), pivot=(0, -0.5, 0)
    ),
    engine="limit",
)
print(f"tilted and turning, the least of 100 directions: {around.acceleration.min():.2f} m/s²")
level = hf.transport_limits(assembly, engine="limit")
level.save_png(out / "transport.png", others=[around], names=["level", "tilted, turning"])

# all sustainable accelerations as half-spaces, for a planner in any language
safe = hf.sets.sustainable_accelerations(assembly)
safe.save(out / "accelerations.json")
time = np.linspace(0, 2, 101)[:, None]
path = 4 * np.sin(np.pi * time) * [0.5, 1.0, 0.0]  # m/s²: off, and to a stop
s = hf.sets.safe_time_scale(path, safe, margin=0.2)
print(f"play the path at {s:.0%} of its speed: it takes {2 / s:.2f} s instead of 2 s")
print(f"of the set it then uses at most {np.max(safe.usage(s**2 * path)):.0%}")
