"""What the engines are compared with: ground truths, baselines, and the benchmark suites that measure both."""
