"""Scenes that come with holdfast, by name: used by examples, tests and benchmarks alike."""

from holdfast.scene.shipped.registry import shipped_scene, shipped_scenes

__all__ = ["shipped_scene", "shipped_scenes"]
