"""URDF: a robot, or a thing, as rigid bodies."""

from holdfast.scene.formats.urdf import reader

__all__ = ["reader"]
