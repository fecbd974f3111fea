"""The evidence for holdfast: ground truths, baselines and benchmark suites, which are not part of the package."""
