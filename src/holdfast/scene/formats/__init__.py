"""The formats of scene files: one module for each format, which registers itself with ``registry``.

To add a format, write a module in this package and import it here. If several formats recognise a file, the first in
this list reads it.
"""

from holdfast.scene.formats import native, published, settled_scene  # isort: skip

from holdfast.scene.formats import mjcf, urdf, sdf, gltf, compas, usd, moveit  # isort: skip

__all__ = ["compas", "gltf", "mjcf", "moveit", "native", "published", "sdf", "settled_scene", "urdf", "usd"]
