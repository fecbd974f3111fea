"""How hard can you push here before something moves: robustness of rigid assemblies in frictional contact.

The public names are listed in ``__init__.pyi``, and each is imported when it is first used, so that ``import holdfast``
costs next to nothing. Types of answers are in ``holdfast.answers``, questions of specialists in ``holdfast.sets``,
errors other than HoldfastError in ``holdfast.errors``, readers of some simulators and of messages in
``holdfast.readers``, and what engines and formats of one's own need in ``holdfast.plugins``.
"""

import os
import sys

# `python -m holdfast` searches the current folder first, where anybody's scenes and other files may be: no longer from
# here on, unless holdfast itself lies there. While Python looks for the module it has put "-m" into sys.argv.
if getattr(sys, "argv", [])[:1] == ["-m"] and sys.path[0] == os.getcwd() != os.path.dirname(os.path.dirname(__file__)):
    del sys.path[0]

from holdfast.base.names import homes_in_stub, names_of_stub
from holdfast.base.painters import painters_come_from

__version__ = "1.0.0"


def _elsewhere(name: str) -> str | None:
    """Say where a name is that ``holdfast`` does not show: in another public module, or with a public class."""
    homes = homes_in_stub(__file__)
    for module in (each for each, home in homes.items() if home == __name__):
        if name in homes_in_stub(os.path.join(os.path.dirname(__file__), f"{module}.py")):
            return f"holdfast.{module}.{name}"
    if os.path.lexists(os.path.join(os.path.dirname(__file__), name)):
        return None  # a package that the import system is about to look for: nothing else need be imported
    for owner in (each for each in __all__ if each[0].isupper()):
        if name in vars(__getattr__(owner)):
            return f"holdfast.{owner}.{name}"
    return None


__all__, __getattr__, __dir__ = names_of_stub(__name__, __file__, _elsewhere)


def _painters() -> None:
    """Import what draws answers: heavy, so not before the first picture is wanted."""
    from holdfast.report import painter_list

    painter_list.register()


painters_come_from(_painters)
