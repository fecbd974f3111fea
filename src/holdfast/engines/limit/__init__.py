"""Limit analysis: the largest load for which an equilibrium exists, over the exact friction cone, with certificates."""
