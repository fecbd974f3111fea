"""Which bodies at rest meet no stiffness in some motion, so that no load path of theirs begins without a hold.

All of the weight of a box may be concentrated at an edge, and the next nodes just touch without any force. Taken for
pressed, these resist every turn, although one to the outside only opens them. So nodes whose force is nothing but
rounding count as open. Whether the least push moves such a body is another question (balanced.py).
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool, Float
from holdfast.elastic.model import Elastic
from holdfast.elastic.sparse import unresisted_motion
from holdfast.native import core

TAKEN_ALONG = 1e-3  # displacement, relative to the largest in a motion, above which a body takes part in the motion


def unstiff_at(m: Elastic, q: Float, rounding: float) -> Bool:
    """Return which bodies (J,) meet no stiffness in some motion at rest ``q`` (6J,) as long as no node begins to press.

    Forces of nodes up to ``rounding``, as a share of the largest on each of the bodies that touch there, count as none.
    """
    K = np.empty_like(m.bonded)
    firm = m._replace(apart=core.without_touching(m, q, rounding))
    core.evaluate(firm, 1.0, q, np.zeros(len(q)), K)
    return np.asarray(unresisted_motion(m, K) > TAKEN_ALONG)
