"""Scenes that come with holdfast, by name: used by examples, tests and benchmarks alike."""

from holdfast.scene.shipped.registry import SHIPPED, shipped_scene

__all__ = ["SHIPPED", "shipped_scene"]
