"""The faults of poses, in words, in the order in which they are checked."""

OVERLAPS, FALLS, OUTSIDE = "overlaps the scene", "slides or falls off", "outside the region"
TURNED, UNSUPPORTED, SHUT_IN = "not in an allowed orientation", "not on enough of the supports", "no way in"
FORBIDDEN, KEPT_OUT = "touches what it must not", "reaches into a region to keep out of"
HANGS, BALANCED = "juts out over an edge", "is only balanced"
AWAY, GRIPPED = "not next to what it should be next to", "no room for the gripper"
CRUSHED = "crushes a body"
FALLEN, UNSURE, REFUSED = "does not stand with it", "undecided with it", "refused by the second engine"
MARGINAL = "would not stand if it were heavier by the margin"
STAGES = (
    *(FALLS, OVERLAPS, OUTSIDE, TURNED, KEPT_OUT, AWAY, UNSUPPORTED, HANGS, FORBIDDEN, SHUT_IN, GRIPPED),
    *(UNSURE, FALLEN, BALANCED, CRUSHED, REFUSED, MARGINAL),
)  # in the order of the checks: an attempt with a later fault passed more of them
