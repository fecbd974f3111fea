"""Readers of running simulators and of messages of robots that few programs need, beside those in ``holdfast``.

The names are listed in ``readers.pyi``, and each is imported when it is first used.
"""

from holdfast.base.names import names_of_stub

__all__, __getattr__, __dir__ = names_of_stub(__name__, __file__)
