"""Coefficients of friction from measured pushes."""
