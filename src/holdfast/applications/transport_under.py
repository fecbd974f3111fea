"""Sample how fast the carrier may accelerate under uncertain poses, friction, masses and faces."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from holdfast.applications.transport import carrier_columns, counted_bodies, transport_limits
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, objects
from holdfast.base.errors import hinting
from holdfast.base.public import Of, Summary, column
from holdfast.engines.answers import Undecided
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, Load, checked_assembly, checked_loads, engine_of
from holdfast.queries.result import vector_text
from holdfast.queries.sampler import Sample, Sampled, sampler
from holdfast.queries.uncertain import Uncertain
from holdfast.scene.scene import Scene


class TransportUnder(Sampled):
    """The largest acceleration of the carrier along each of n directions, in each of ``samples`` samples.

    ``acceleration`` (samples, n) [m/s²] is 0 where a sample does not stand, and inf where no acceleration moves
    anything. Where the sample or the limit is undecided, the 0 is no answer. ``status`` (samples, n) distinguishes
    these cases, as in TransportLimits, and ``undecided_limits`` counts the undecided ones. ``lower`` and ``upper``
    (samples, n) [m/s²] bound the true answer of each sample.

    ``stands`` is the share of samples that certainly stand on the carrier at rest (STABLE), and ``undecided`` the share
    that may stand; the remaining samples do not stand. ``nominal`` (n,) [m/s²] is the limit of the assembly as it was
    given, without uncertainty, and ``nominal_status`` (n,) is its status. The unit ``directions`` (n, 3) are in the
    axes of the scene. ``seed`` is the seed of the samples, and ``notes`` are the simplifications on which the answer
    depends.
    """

    unit: ClassVar[str] = "m/s²"
    place: ClassVar[str] = "along"

    scene: str
    directions: Float = column("n 3")

    plain = "scene directions acceleration status nominal nominal_status stands undecided undecided_limits samples seed"

    acceleration = Of[Float]("_values", "The largest acceleration (samples, n) [m/s²] before anything moves.")
    undecided_limits = Of[Undecided](
        "answers.undecided", "How many of the limits on all samples are not known (``count``, ``share``), and why."
    )

    def summary(self) -> Summary:
        """Summarise the answer by quantiles of the directions with the smallest medians."""
        headline = f"{self.samples} samples of {self.scene or 'assembly'} on its carrier"
        return self.weakest(headline, objects([vector_text(way, ".3f") for way in self.directions]))


@hinting(uncertain=Uncertain)
def transport_under(
    assembly: Assembly | Scene,
    directions: ArrayLike | None = None,
    uncertain: Uncertain | None = None,
    *,
    tilt_degrees: ArrayLike | None = None,
    standing: Iterable[Load] = (),
    engine: EngineChoice = DEFAULT_ENGINE,
    bodies: Sequence[str] | None = None,
) -> TransportUnder:
    """Compute how fast the carrier may accelerate in samples of uncertain poses, friction, masses and faces.

    ``directions``, ``tilt_degrees``, ``standing``, ``engine`` and ``bodies`` have the same meaning as in
    ``transport_limits``, and ``uncertain`` the same as in ``robustness_under``, from which the samples do not differ:
    standing loads move with their body, and directions stay fixed in the scene. With ``bodies``, ``stands`` is about
    the groups of these bodies alone.

    Raises SceneError as ``transport_limits`` does, and HoldfastError as ``robustness_under`` does. See
    docs/howto/uncertainty.md.
    """
    given = checked_assembly(assembly)
    if tilt_degrees is not None:
        given = given.tilted(tilt_degrees)
    method, loads = engine_of(engine), checked_loads(standing)
    samples = sampler(given, uncertain, method, loads, "transport under uncertainty")
    nominal = transport_limits(given, directions, standing=loads, engine=method, bodies=bodies)
    counted, _ = counted_bodies(given, bodies, "transport_under")

    def columns(sample: Sample) -> Float:
        return carrier_columns(sample.assembly, counted, nominal.directions)

    return TransportUnder(
        scene=given.scene.name,
        directions=nominal.directions,
        **samples.fields(nominal, np.flatnonzero(counted), columns),
    )
