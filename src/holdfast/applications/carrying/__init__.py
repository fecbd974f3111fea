"""Whether what stands on a carrier is still there after a given motion of the carrier."""
