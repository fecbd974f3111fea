"""Measured and printed numbers that nobody here made, one module a source, each with what holdfast predicts."""
