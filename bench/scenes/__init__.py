"""Scenes and pushes for benchmarks and tests."""
