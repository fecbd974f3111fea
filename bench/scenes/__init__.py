"""Scenes and pushes that benchmarks measure and tests ask about."""
