"""Sample the robustness under uncertain poses, friction, masses and faces: quantiles, and how often it stands."""

from __future__ import annotations

from collections.abc import Iterable
from typing import ClassVar

from numpy.typing import ArrayLike

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.arrays import Float
from holdfast.base.errors import hinting
from holdfast.base.public import Of, Summary, column
from holdfast.engines.answers import Undecided
from holdfast.queries.push import robustness
from holdfast.queries.request import (
    DEFAULT_ENGINE,
    EngineChoice,
    Load,
    body_number,
    checked_assembly,
    checked_loads,
    engine_of,
    push_columns,
)
from holdfast.queries.result import places_of
from holdfast.queries.sampled import Sampled
from holdfast.queries.sampler import Sample, sampler
from holdfast.queries.uncertain import Uncertain
from holdfast.scene.scene import Scene


class RobustnessUnder(Sampled):
    """The largest push at each of n points, in each of ``samples`` samples of the uncertain quantities.

    ``force`` (samples, n) [N] is 0 where a sample does not stand, and inf where no push moves anything. Where the
    sample or the push is undecided, the 0 is no answer. ``status`` (samples, n) distinguishes these cases, as in
    Robustness, and ``undecided_pushes`` counts the undecided ones. ``lower`` and ``upper`` (samples, n) [N] bound the
    true answer of each sample.

    ``stands`` is the share of samples that certainly stand (STABLE), and ``undecided`` the share that may stand; the
    remaining samples do not stand. ``nominal`` (n,) [N] is R of the assembly as it was given, without uncertainty, and
    ``nominal_status`` (n,) is its status. ``points`` (n, 3) [m], the unit ``directions`` (n, 3) and ``verdict`` also
    belong to that assembly, in the world frame. ``seed`` is the seed of the samples, and ``notes`` are the
    simplifications on which the answer depends.
    """

    unit: ClassVar[str] = "N"
    place: ClassVar[str] = "where"

    body: str
    points: Float = column("n 3")
    directions: Float = column("n 3")

    plain = "body points directions force status nominal nominal_status stands undecided undecided_pushes samples seed"

    force = Of[Float]("_values", "The largest force (samples, n) [N] before anything moves.")
    undecided_pushes = Of[Undecided](
        "answers.undecided", "How many of the pushes on all samples are not known (``count``, ``share``), and why."
    )

    def summary(self) -> Summary:
        """Summarise the answer by quantiles at the points with the smallest medians."""
        headline = f"{self.samples} samples of {len(self.nominal):,} pushes on {self.body}"
        return self.weakest(headline, places_of(self.points))


@hinting(uncertain=Uncertain)
def robustness_under(
    assembly: Assembly | Scene,
    body: str,
    points: ArrayLike,
    directions: ArrayLike,
    uncertain: Uncertain | None = None,
    *,
    standing: Iterable[Load] = (),
    engine: EngineChoice = DEFAULT_ENGINE,
) -> RobustnessUnder:
    """Compute R(p, e) in samples of uncertain poses, friction, masses and faces.

    ``uncertain`` says what is uncertain and how many samples are drawn, see Uncertain. By default, only the existence
    of uncertain contacts is. ``body``, ``points``, ``directions``, ``standing`` and ``engine`` have the same meaning as
    in ``robustness``.

    Points and standing loads move with their body; directions, forces and moments stay fixed in the world. The contacts
    of each sample are detected again, between the pairs that touch in ``assembly``, with a tolerance that allows for
    the deviations. Gaps and overlaps within this tolerance are accepted; the outline, place and tilt of the contacts
    change.

    Uncertain contacts (see ``Interface.certain``) are present only in some samples, unless something would fall without
    them. With ``pose_sigma``, they are present where the sampled poses close them to within the default gap; otherwise
    each is present in half of the samples.

    Raises HoldfastError if ``pose_sigma`` is given for an assembly whose interfaces were given, or exceeds the
    thickness of a body. See docs/howto/uncertainty.md.
    """
    assembly = checked_assembly(assembly)
    method, loads = engine_of(engine), checked_loads(standing)
    samples = sampler(assembly, uncertain, method, loads, f"robustness of {body!r} under uncertainty")
    nominal = robustness(assembly, body, points, directions, standing=loads, engine=method)
    number = body_number(assembly, body)

    def columns(sample: Sample) -> Float:
        return push_columns(sample.assembly, number, sample.along(body, nominal.points), nominal.directions)

    return RobustnessUnder(
        body=body,
        points=nominal.points,
        directions=nominal.directions,
        **samples.fields(nominal, [] if number == FIXED else [number], columns),
    )
