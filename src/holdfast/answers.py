"""The types of answers, and of the parts that answers consist of.

The names are listed in ``answers.pyi``, and each is imported when it is first used.
"""

from holdfast.base.names import names_of_stub

__all__, __getattr__, __dir__ = names_of_stub(__name__, __file__)
