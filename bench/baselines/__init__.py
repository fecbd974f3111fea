"""What the engines are compared with: dynamic simulations and the paper's optimisation; no engine knows of them."""

from bench.baselines.answers import Answers, simulated
from bench.baselines.ipopt import optimised

__all__ = ["Answers", "optimised", "simulated"]
