"""glTF: scenes from its files, and files from scenes.

``reader`` registers the format, ``extras`` defines the data that holdfast adds to the meshes, and ``writer`` writes.
"""

from holdfast.scene.formats.gltf import reader

__all__ = ["reader"]
