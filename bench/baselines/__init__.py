"""The baselines of the engines: dynamic simulations and the paper's optimisation. Engines do not import them."""

from bench.baselines.answers import Answers, simulated
from bench.baselines.ipopt import optimised

__all__ = ["Answers", "optimised", "simulated"]
