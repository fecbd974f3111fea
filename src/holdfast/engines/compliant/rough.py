"""Engine ``compliant`` on one sample of imperfect faces."""

from __future__ import annotations

from dataclasses import dataclass, replace

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.engines.compliant.compliant_state import CLAIM, NAME, CompliantState
from holdfast.engines.compliant.engine import Compliant, prepared_on
from holdfast.engines.compliant.random_faces import Faces


@dataclass(frozen=True, eq=False)
class Rough:
    """The engine on the ``faces`` of one sample: bodies first come to rest on high spots, where load paths begin.

    The stiffness of the faces is multiplied by that which the engine has for pairs of bodies or materials.
    """

    engine: Compliant
    faces: Faces

    name = NAME
    claim = CLAIM

    def prepare(
        self, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None
    ) -> CompliantState:
        """Find the state of rest on these faces; the arguments and errors are those of ``Compliant.prepare``."""
        return prepared_on(assembly, replace(self.engine.springs, faces=self.faces), standing, acceleration)
