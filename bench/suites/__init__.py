"""Benchmark suites: the modules that ``bench.registry`` lists, and parts that several of them share."""
