"""The questions that an assembly can answer: does it stand, and how hard can it be pushed before something moves."""
