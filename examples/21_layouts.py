"""
21. Validate layouts
====================

A validator for a generator of layouts: poses of all objects in, whether they stand and why not out.

Generators such as that of Isaac Lab-Arena draw poses, and ask validators which of them to keep. This one needs nothing
but the shapes. It prepares them once, and looks at each layout for itself.
"""

import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import holdfast as hf

Poses = Mapping[str, NDArray[np.float64]]  # by the name of an object (n, 4, 4), object to world


@dataclass(frozen=True)
class LayoutValidator:
    """Tells which layouts stand: nothing falls, hovers or overlaps by more than a thousandth of its size."""

    assembly: hf.answers.Assembly

    @staticmethod
    def of(objects: Sequence[hf.Body], friction: float = 0.5) -> "LayoutValidator":
        """Prepare the objects of a scene, furniture included."""
        return LayoutValidator(hf.assemble(hf.Scene(objects, friction)))

    def validate(self, poses: Poses) -> tuple[list[bool], list[str]]:
        """Return for each of n layouts whether it stands, and the reason."""
        found = [self._stability(layout) for layout in layouts_of(poses)]
        return [one.stable for one in found], [one.reason for one in found]

    def _stability(self, layout: Mapping[str, NDArray[np.float64]]) -> hf.answers.Stability:
        with warnings.catch_warnings(action="ignore"):  # of overlaps, which the reason names
            return hf.stability(self.assembly.moved(layout))


def layouts_of(poses: Poses) -> list[dict[str, NDArray[np.float64]]]:
    count = len(next(iter(poses.values())))
    return [{name: each[k] for name, each in poses.items()} for k in range(count)]


table = hf.Body("table", hf.Box((1.0, 0.6, 0.04)), position=(0, 0, -0.02), fixed=True)
sizes = {"cracker box": (0.16, 0.06, 0.21), "sugar": (0.09, 0.04, 0.17), "pudding": (0.11, 0.09, 0.03)}
boxes = [
    hf.Body(name, hf.Box(size), mass=0.4, position=(0.3 * k - 0.3, 0, size[2] / 2))
    for k, (name, size) in enumerate(sizes.items())
]
can = hf.Body("can", hf.Cylinder(0.033, 0.12), mass=0.35, position=(0, 0.2, 0.06))
validator = LayoutValidator.of([table, *boxes, can])

rng = np.random.default_rng(0)
drawn = {
    body.name: np.array(
        [
            hf.pose(rng.uniform(-0.5, 0.5), rng.uniform(-0.3, 0.3), body.pose[2, 3], yaw=rng.uniform(0, 360))
            for _ in range(300)
        ]
    )
    for body in (*boxes, can)
}
drawn["can"][1, 2, 3] += 0.11  # one that hangs
validator.validate({name: poses[:5] for name, poses in drawn.items()})  # the first ones prepare what the others need
start = time.process_time()
valid, reasons = validator.validate(drawn)
milliseconds = 1e3 * (time.process_time() - start) / len(valid)
print(f"{sum(valid)} of {len(valid)} layouts stand, {milliseconds:.1f} ms of a core each")
for k in [k for k, stands in enumerate(valid) if not stands][:4]:
    print(f"layout {k}: {reasons[k]}")

# a layout that stands, to look at more closely
first = valid.index(True)
assembly = validator.assembly.moved({name: poses[first] for name, poses in drawn.items()})
print(f"layout {first}: {len(assembly.interfaces)} contacts, {hf.stability(assembly).status}")
