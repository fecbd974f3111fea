"""The evidence: ground truths, baselines and benchmark suites, beside the package and never shipped with it."""
