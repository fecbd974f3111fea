"""Questions of specialists: convex sets of loads and accelerations, sensitivities, the worst case, cartons.

The names are listed in ``sets.pyi``, and each is imported when it is first used.
"""

from holdfast.base.names import names_of_stub

__all__, __getattr__, __dir__ = names_of_stub(__name__, __file__)
