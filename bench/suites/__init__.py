"""Benchmark suites: modules that ``bench.registry`` lists, and what several of them share."""
