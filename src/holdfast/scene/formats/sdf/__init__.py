"""SDF: worlds and models, as Gazebo loads them."""

from holdfast.scene.formats.sdf import reader

__all__ = ["reader"]
