"""Scene files: one module a format, each of which registers itself; ``registry`` finds the one that fits a file.

A new format is one module beside these, imported here. Where several formats fit a file, the first in this list has it.
"""

from holdfast.scene.formats import native, published, settled

__all__ = ["native", "published", "settled"]
