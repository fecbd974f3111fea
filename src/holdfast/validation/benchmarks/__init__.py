"""Benchmarks: named scenes, one runner, results saved as JSON, Markdown and a plot."""
