"""
15. Watched while it moves
==========================

A base drives into a bend that tightens. Fifty times a second it asks what is left to the vase on its tray, and it
brakes before the vase falls, as hard as the vase allows.
"""

import numpy as np

import holdfast as hf

tray = hf.Body("tray", hf.Box((0.8, 0.6, 0.02)), position=(0, 0, -0.01), fixed=True)
vase = hf.Body("vase", hf.Cylinder(0.04, 0.3), mass=1.2, position=(0.2, 0.1, 0.15))
books = [
    hf.Body(f"book {k}", hf.Box((0.2, 0.15, 0.03)), mass=0.6, position=(-0.2, 0, 0.015 + 0.03 * k)) for k in range(3)
]
assembly = hf.assemble(hf.Scene([tray, vase, *books], 0.5, name="tray"))
monitor = hf.Monitor(assembly, seconds=1.0)  # mostly a few milliseconds; more on a busy machine
STEP = 0.02  # s


def moment(speed: float, bend: float, forwards: float) -> hf.answers.Monitored:
    """The base as it is felt on the tray: x ahead, y to the left, turning about its middle."""
    return monitor.update((forwards, speed**2 * bend, 0), (0, 0, speed * bend))


def drive(careful: bool) -> None:
    """Six seconds at 2 m/s, in a bend whose curvature grows by 0.2 1/m every second."""
    speed, least, braked, seconds = 2.0, 1.0, False, []
    for k in range(300):
        bend, forwards = 0.2 * k * STEP, 0.0
        now = moment(speed, bend, 0.0)
        if careful and now.margin < 0.3:
            ways = [(a, moment(speed, bend, a)) for a in (-2.0, -1.0, -0.5, -0.2)]
            forwards, now = next((way for way in ways if way[1].margin > 0.2), (0.0, now))
        if forwards and not braked:
            braked = True
            print(f"{k * STEP:.2f} s: brakes with {-forwards} m/s², for {', '.join(now.moving)} would move first")
        least = min(least, now.margin)
        seconds.append(now.seconds)
        if not now.holds:
            print(f"{k * STEP:.2f} s: {', '.join(now.moving)} {'moves' if now.status == 'unstable' else 'may move'}")
            return
        speed = max(speed + forwards * STEP, 0.3)
    print(f"6 s: all stands; margin at least {least:.2f}, now {speed:.2f} m/s")
    print(f"an update took {1e3 * np.median(seconds):.1f} ms, 99 % at most {1e3 * np.quantile(seconds, 0.99):.1f} ms")


print("without care:")
drive(careful=False)
print("with care:")
drive(careful=True)
