"""What an engine or a scene format of one's own is made of, and how it is made known to holdfast.

The names are listed in ``plugins.pyi``, and each is imported when it is first used.
"""

from holdfast.base.names import names_of_stub

__all__, __getattr__, __dir__ = names_of_stub(__name__, __file__)
