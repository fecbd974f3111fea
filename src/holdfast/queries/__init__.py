"""Questions to an assembly: does it stand, how hard may one push here, and over all surfaces."""
