"""The queries about an assembly: does it stand, and how hard can it be pushed before something moves."""
