"""The amendments of an answer of engine ``compliant``, in the order in which they act.

A load path gives the peak on one grid, and finer grids how far that may be off (compliant/refinement.py, of which
bisection.py and concentrated.py are parts). What these do not know is amended here, in this order:

1. ``LimitReview``: limit analysis proves above which load bodies move. It corrects answers that deserve doubt.
2. ``SelfStressed``: where bodies press each other without any load, or are near their limit, ``lower`` covers other
   stiffness and other nodes.
3. ``Sliding``: ``lower`` is what is reached before contacts have slid far.
4. ``OpenContacts``: ``lower`` leans on no contact that is open and idle at rest.

Two amendments act on the answers of every engine: ``negligible.py`` makes 0 of what rounding alone tells from 0, and
``doubtful_contacts.py`` bounds answers over the presence of contacts that may not exist, with ``absent_contacts.py``
and ``pose_allowance.py``.
"""

from __future__ import annotations

from holdfast.engines.amendments.amendment import Amendment, Asked, AtRest
from holdfast.engines.amendments.limit_review import LimitReview
from holdfast.engines.amendments.open_contacts import OpenContacts
from holdfast.engines.amendments.self_stressed import SelfStressed
from holdfast.engines.amendments.sliding import Sliding
from holdfast.engines.answers import Answers

AMENDMENTS: tuple[type[Amendment], ...] = (LimitReview, SelfStressed, Sliding, OpenContacts)


def amendments_of(state: AtRest) -> tuple[Amendment, ...]:
    """Return all amendments, for one state of rest."""
    return tuple(kind(state) for kind in AMENDMENTS)


def amended(found: Answers, asked: Asked, amendments: tuple[Amendment, ...]) -> Answers:
    """Return the answers ``found`` as amended by all that apply, one after the other, with a step for each of them."""
    for amendment in amendments:
        if amendment.applies(asked):
            found = amendment.amend(found, asked).after(amendment.name, amendment.why)
    return found
