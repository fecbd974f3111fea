"""What the engines are compared with: dynamic simulations and the paper's optimisation; no engine knows of them."""

from holdfast.validation.baselines.answers import Answers, simulated
from holdfast.validation.baselines.ipopt import optimised

__all__ = ["Answers", "optimised", "simulated"]
