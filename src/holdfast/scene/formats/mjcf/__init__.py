"""MuJoCo: scenes from MJCF files and from running simulations, and MJCF files from scenes.

``reader`` registers the format, ``guard`` refuses hostile files before MuJoCo sees them, ``live`` makes a scene of a
compiled model and its state, with ``groups`` (what moves), ``shapes`` and ``rules`` (who touches whom, with which
friction), and ``writer`` writes.
"""

from holdfast.scene.formats.mjcf import reader

__all__ = ["reader"]
