"""The errors and warnings of holdfast; all errors are HoldfastErrors.

The names are listed in ``errors.pyi``, and each is imported when it is first used.
"""

from holdfast.base.names import names_of_stub

__all__, __getattr__, __dir__ = names_of_stub(__name__, __file__)
