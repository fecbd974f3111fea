"""glTF: scenes from its files, and files from scenes.

``reader`` registers the format, ``extras`` is what holdfast says in a file beside the meshes, and ``writer`` writes.
"""

from holdfast.scene.formats.gltf import reader

__all__ = ["reader"]
