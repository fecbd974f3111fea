"""The scenes that come with holdfast, by name; examples and tests use them."""

from holdfast.scene.shipped.shipped_list import shipped_scene, shipped_scenes

__all__ = ["shipped_scene", "shipped_scenes"]
