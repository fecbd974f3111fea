"""
8. Poses and friction are known only roughly
============================================

What may one count on, and how often does it stand at all?
"""

import holdfast as hf

floor = hf.Body("floor", hf.Box((1, 1, 0.1)), fixed=True)
shelf = hf.Body("shelf", hf.Box((0.1, 0.1, 0.1)), position=(0, 0, 0.1), fixed=True)
jar = hf.Body(
    "jar", hf.Box((0.1, 0.1, 0.1)), mass=1, position=(0.042, 0, 0.2)
)  # hangs over the shelf by 42 mm of its 100
assembly = hf.assemble(hf.Scene([floor, shelf, jar], friction=0.5))

points = [(-0.008, 0, 0.16), (0.092, 0, 0.25)]
directions = [(1, 0, 0), (0, 0, -1)]
u = hf.robustness_under(
    assembly,
    "jar",
    points,
    directions,
    uncertain=hf.sets.Uncertain(pose_sigma=(0.004, 0.2), mu_range=(0.3, 0.5), samples=60, seed=1),
)
print(f"stands in {u.stands:.0%} of {u.samples} samples, undecided {u.undecided:.0%} ({u.engine}, {u.claim})")
for name, nominal, low, middle in zip(("sideways", "down"), u.nominal, u.quantile(0.05), u.median, strict=True):
    print(f"{name}: {nominal:.2f} N as given, {middle:.2f} N in the median, {low:.2f} N in 95 % of the samples")
