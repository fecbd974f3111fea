"""One answer in JSON: the envelope ``holdfast-answer/1``, which commands, rows of batches and ``answer.data()`` share.

``QUESTIONS`` declares for each class of answers what goes into rows and what into ``details``; ``envelope_keys`` says
what each key means. The JSON schema is made from that, and an envelope from the plain data of an answer, its
``to_dict``: every entry becomes part of a row, a detail, or one of the keys that all questions share.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_
from typing import Annotated, Any, Literal, Protocol

from holdfast.base.envelope_keys import DETAIL, ENVELOPE, ROW

FORMAT = "holdfast-answer/1"
EXIT = {"stable": 0, "unstable": 1, "undecided": 3, None: 0}  # exit code of a command by the verdict of its answer
STABLE, UNSTABLE, UNDECIDED = "stable", "unstable", "undecided"
SHARED = {"claim", "lower_bound", "reason", "notes", "verdict", "status", "outcome", "stable"}  # told in the envelope


class AnswerToTell(Protocol):
    """An answer of any class: what it is told as is declared for the name of the class."""

    def to_dict(self) -> dict[str, Any]:
        """Return plain data."""


def standing(answer: Any) -> str | None:  # noqa: ANN401 - any answer that has a verdict
    """Return the verdict of an answer: that on its state at rest, or what its rows make of it.

    It is unstable although bodies stand where one is crushed, and undecided although they stand where no row is
    decided.
    """
    status = str(answer.verdict.status)
    table = getattr(answer, "answers", None)
    if status != STABLE:
        return status
    if getattr(answer, "crushed", ()) or (table is not None and UNSTABLE in table.status):
        return UNSTABLE
    return UNDECIDED if table is not None and len(table) and not table.decided.any() else STABLE


def _by_status(answer: Any) -> str:  # noqa: ANN401
    return str(answer.status)


def _of_place(answer: Any) -> str | None:  # noqa: ANN401
    return standing(answer) if answer.stable else str(answer.status)


def _of_order(answer: Any) -> str:  # noqa: ANN401
    return STABLE if answer.reached else UNSTABLE if answer.proven else UNDECIDED


def _of_removal(answer: Any) -> str:  # noqa: ANN401
    return {"safe": STABLE, "unsafe": UNSTABLE}.get(answer.answer, UNDECIDED)


def _none(answer: Any) -> None:  # noqa: ANN401
    """Return that the question has no verdict."""


@dataclass(frozen=True)
class EnvelopeLayout:
    """How the answers of one class are told.

    ``rows`` lists the entries of plain data that go into rows: columns, or entries of each item of the list ``each``.
    ``details`` lists the others. ``points>point`` is told under another name, what ends in ``?`` may be missing; the
    columns ``^force`` are one for each sample, ``-normals`` are told with the opposite sign, and ``@time`` is what
    ``where`` says of each row. ``verdict`` returns the verdict of an answer.
    """

    name: str
    rows: str = ""
    details: str = ""
    each: str = ""
    verdict: Callable[[Any], str | None] = standing


def told_as(listed: str) -> dict[str, tuple[str, bool]]:
    """Return the names that a question tells, each with the entry of plain data that it is and whether it is always."""
    found = {}
    for word in listed.split():
        name, _, shown = word.removesuffix("?").partition(">")
        found[shown or name.lstrip("^-@")] = name, not word.endswith("?")
    return found


_TABLE = "engine at_rest upper_bound undecided"  # details of what has a table of answers
_COLUMNS = f"{_TABLE} holds? exists?"
_BOUNDS = "lower upper status mode moving"
_PUSH = "body points>point directions>direction"
_FALL = "moving mechanism"
_BODY_OUT = "body answer reason blockers moving lift hold holds"

QUESTIONS: dict[str, EnvelopeLayout] = {
    "Stability": EnvelopeLayout(
        "stability",
        "bodies status reason",
        f"engine equilibrium_exists self_stress forces residual {_FALL} certificate bearing scene? gap? gap_by_pair? "
        "angle_degrees? overlaps? interfaces?",
        each="groups",
    ),
    "Robustness": EnvelopeLayout("push", f"force {_BOUNDS} {_PUSH} mechanism", _COLUMNS),
    "LoadFactor": EnvelopeLayout("load_factor", f"factor {_BOUNDS} mechanism", _TABLE),
    "RobustnessMap": EnvelopeLayout(
        "map",
        f"force {_BOUNDS} body points>point -normals>direction",
        f"{_COLUMNS} scene weakest weakest_of_each_body",
    ),
    "RobustnessUnder": EnvelopeLayout(
        "robustness_under",
        f"nominal>force nominal_status>status ^force>samples ^status>sample_statuses {_PUSH}",
        "engine at_rest upper_bound stands undecided>undecided_share undecided_pushes samples seed",
    ),
    "TransportUnder": EnvelopeLayout(
        "transport_under",
        "nominal>acceleration nominal_status>status ^acceleration>samples ^status>sample_statuses directions>direction",
        "engine at_rest upper_bound scene stands undecided>undecided_share undecided_limits samples seed",
    ),
    "Sensitivity": EnvelopeLayout("sensitivity", f"force {_BOUNDS} body", f"{_TABLE} d_mu d_mass d_com d_point"),
    "WorstCase": EnvelopeLayout(
        "worst_case",
        f"force {_BOUNDS} body nominal nominal_status masses coms",
        f"{_COLUMNS} corners guarantee mu",
    ),
    "ConvexSet": EnvelopeLayout(
        "convex_set",
        details="engine inner outer vertices box accuracy accuracy_wanted solves units frame",
        verdict=_none,
    ),
    "Constraint": EnvelopeLayout(
        "constraint",
        details="body engine known price com box accuracy accuracy_of_most accuracy_wanted solves above above_by",
        verdict=_none,
    ),
    "Derivatives": EnvelopeLayout(
        "gradients", "force known from_multipliers", "engine slopes before after kinks", verdict=_none
    ),
    "StabilityOfPoses": EnvelopeLayout(
        "stability_of_poses", "status reason moving poses", "engine bodies", verdict=_none
    ),
    "RobustnessOfPoses": EnvelopeLayout(
        "robustness_of_poses", f"force {_BOUNDS} {_PUSH} poses", "engine bodies upper_bound", verdict=_none
    ),
    "TransportLimits": EnvelopeLayout(
        "transport", f"acceleration {_BOUNDS} directions>direction mechanism", f"{_COLUMNS} scene gravity"
    ),
    "MeasuredFriction": EnvelopeLayout(
        "calibrate",
        "force bodies>body points>point directions>direction moved predicted",
        "engine undecided>problem mu intervals mu_range undetermined scatter scatter_estimated confidence",
        verdict=lambda answer: UNDECIDED if answer.undecided else None,
    ),
    "Carried": EnvelopeLayout(
        "carry",
        f"factor @time {_BOUNDS} mechanism",
        f"{_COLUMNS} scene profile source time first time_scale samples",
        verdict=lambda answer: str(answer.outcome),
    ),
    "Monitored": EnvelopeLayout("monitor", details="margin upper moving seconds late", verdict=_by_status),
    "Disassembly": EnvelopeLayout(
        "disassemble",
        _BODY_OUT,
        "scene engine lift goal order assembly_order reached proven fewest blocked undecided hands? falsework?",
        each="steps",
        verdict=_of_order,
    ),
    "BuildOrder": EnvelopeLayout(
        "build",
        "force body reason hold holds weakest",
        "scene engine lift order reached proven first stuck hands? falsework?",
        each="steps",
        verdict=_of_order,
    ),
    "Removal": EnvelopeLayout("remove", _BODY_OUT, verdict=_of_removal),
    "SafePushes": EnvelopeLayout(
        "safe",
        f"effect reason lower upper {_PUSH}",
        "engine force unreached tool_radius travel doubt",
        verdict=lambda answer: STABLE if (answer.effect != "unknown").any() else UNDECIDED,
    ),
    "Settled": EnvelopeLayout(
        "settle", "body moved turned_degrees reason pose", "fell travel steps", each="bodies", verdict=_by_status
    ),
    "RestingPoses": EnvelopeLayout(
        "rest",
        "pose height support probability tipping_degrees least_push energy rolls",
        "body mu",
        each="poses",
        verdict=_none,
    ),
    "Placement": EnvelopeLayout(
        "place",
        "name>body robustness>force lower pose points normals fault rating",
        f"{_TABLE} name>body robustness lower weakest attempts faults beneath best time_to_stable elapsed contacts?",
        each="candidates",
        verdict=_of_place,
    ),
    "Placements": EnvelopeLayout(
        "place_all",
        "body pose own beneath rests_on",
        "scene engine order left apart least tries elapsed",
        each="steps",
        verdict=_by_status,
    ),
    "Firmer": EnvelopeLayout("firmer", "poses least undecided", f"{_TABLE} before after solves tried", each="steps"),
    "BatchReport": EnvelopeLayout(
        "batch",
        details="folder outcomes verdicts failures asked kept seconds",
        verdict=lambda answer: UNDECIDED if set(answer.outcomes) - {"answered"} else None,
    ),
    "scene": EnvelopeLayout(
        "scene",
        "force? acceleration? lower? body? mode? moving?",
        "scene path? outcome engine? moving? crushed? hovers? sinks? settled? seconds? result?",
    ),
    "check": EnvelopeLayout("check", details="counts written? fixed? left?"),
    "convert": EnvelopeLayout("convert", details="written bodies movable"),
    "doctor": EnvelopeLayout("doctor", details="holdfast python system executable cores packages plugins"),
}
OF_SCENES = ("batch", "check")  # whose rows are envelopes of the question "scene"


def envelope(
    question: str,
    *,
    verdict: str | None = None,
    reason: str = "",
    claim: str | None = None,
    bound: str | None = None,
    rows: Sequence[dict[str, Any]] = (),
    details: dict[str, Any] | None = None,
    notes: Sequence[str] = (),
) -> dict[str, Any]:
    """Return an envelope as plain data; each note stands there once."""
    return {
        "version": FORMAT,
        "question": question,
        "verdict": verdict,
        "reason": reason,
        "claim": claim,
        "bound": None if bound == "none" else bound,
        "rows": list(rows),
        "details": details or {},
        "notes": list(dict.fromkeys(notes)),
    }


def enveloped(
    answer: AnswerToTell,
    *,
    rows: Sequence[dict[str, Any]] | None = None,
    details: dict[str, Any] | None = None,
    notes: Sequence[str] = (),
) -> dict[str, Any]:
    """Return the envelope of an answer, with further ``details``, with ``notes`` before its own, or with other rows."""
    plain, question = answer.to_dict(), question_of(answer)
    verdict, found = question.verdict(answer), _rows(answer, plain, question)
    shown = {name: told for told, (name, _) in told_as(question.details).items()}
    of_rows = {name.lstrip("^-@") for name, _ in told_as(question.rows).values()} - shown.keys()
    told = {shown.get(name, name): value for name, value in plain.items() if name not in {*SHARED, *of_rows}}
    if "verdict" in plain:
        told["at_rest"] = plain["verdict"]
    return envelope(
        question.name,
        verdict=verdict,
        reason=reason_of(answer, verdict),
        claim=plain.get("claim"),
        bound=plain.get("lower_bound"),
        rows=found if rows is None else rows,
        details=told | (details or {}),
        notes=[*notes, *plain.get("notes", ())],
    )


def question_of(answer: AnswerToTell) -> EnvelopeLayout:
    """Return how an answer is told; of a class that is not listed all is a detail, and it has no verdict."""
    kind = type(answer).__name__
    return QUESTIONS.get(kind) or EnvelopeLayout(kind.lower(), verdict=_none)


def verdict_of(answer: AnswerToTell) -> str | None:
    """Return the verdict of an answer: stable, unstable, undecided, or None where its question has none."""
    return question_of(answer).verdict(answer)


def reason_of(answer: Any, verdict: str | None) -> str:  # noqa: ANN401 - any answer
    """Return the reason for a verdict in words: of the answer, of its rows, or of its state at rest."""
    table, rest = getattr(answer, "answers", None), getattr(answer, "verdict", None)
    crushed = bool(getattr(answer, "crushed", ()))
    if crushed and rest is not None and rest.stable:
        return f"crushed: {answer.bearing[0].text}"
    if isinstance(getattr(answer, "reason", None), str):
        return str(answer.reason)
    if getattr(answer, "stuck", ()):
        return "; ".join(f"{one.body}: {one.reason}" for one in answer.stuck)
    if rest is None:
        return str(answer.summary().headline)
    if verdict == UNDECIDED and rest.stable and table is not None:
        return str(table.undecided.text)
    if verdict == UNSTABLE and rest.stable and table is not None:
        return str(table.mechanism[list(table.status).index(UNSTABLE)].text)
    return str(rest.reason)


def _rows(answer: Any, plain: dict[str, Any], question: EnvelopeLayout) -> list[dict[str, Any]]:  # noqa: ANN401
    """Return the rows of an answer from its plain data, without the list whose items they are."""
    parts: list[dict[str, Any]] | None = plain.pop(question.each) if question.each else None
    if parts == []:
        return []
    columns: dict[str, Any] = {}
    for shown, (listed, _) in told_as(question.rows).items():
        name = listed.lstrip("^-@")
        if parts and name in parts[0]:
            columns[shown] = [part[name] for part in parts]
        elif listed.startswith("@"):
            columns[shown] = [answer.where(row)[name] for row in range(len(answer.answers))]
        elif listed.startswith("^"):
            columns[shown] = [list(samples) for samples in zip(*plain[name], strict=True)]
        elif listed.startswith("-"):
            columns[shown] = [[0.0 - x for x in vector] for vector in plain[name]]
        else:
            columns[shown] = plain[name]
    first: Any = next(iter(columns.values()), [])
    if parts is None and not isinstance(first, list):
        return [columns]
    return [
        {name: value if isinstance(value, str) else value[row] for name, value in columns.items()}
        for row in range(len(first if parts is None else parts))
    ]


def schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of envelopes: one object for each question."""
    from pydantic import Field, TypeAdapter
    from pydantic.json_schema import GenerateJsonSchema

    class WithoutTitles(GenerateJsonSchema):
        def field_title_should_be_set(self, schema: Any) -> bool:  # noqa: ANN401
            return False

    details = _kinds("detail", DETAIL)
    rows, top = _kinds("row", ROW), _kinds("envelope", ENVELOPE)
    models: dict[str, Any] = {}
    for each in sorted(QUESTIONS.values(), key=lambda each: each.name in OF_SCENES):
        name = each.name
        row: Any = models["scene"] if name in OF_SCENES else _object(f"{name}_row", rows, each.rows)
        parts = {"rows": list[row], "details": _object(f"{name}_details", details, each.details)}
        models[name] = _object(name, top | parts | {"question": Literal[name]}, " ".join(ENVELOPE))
    every: Any = reduce(or_, models.values())
    adapter: TypeAdapter[Any] = TypeAdapter(Annotated[every, Field(discriminator="question")])
    whole = adapter.json_schema(schema_generator=WithoutTitles)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": FORMAT} | whole


def _kinds(part: str, known: dict[str, tuple[Any, str]]) -> dict[str, Any]:
    """Return the type of each key with its meaning; each stands once in a schema."""
    from pydantic import Field
    from typing_extensions import TypeAliasType

    return {
        name: TypeAliasType(f"{part}_{name}", Annotated[kind, Field(description=meaning)])
        for name, (kind, meaning) in known.items()
    }


def _object(title: str, kinds: dict[str, Any], listed: str) -> Any:  # noqa: ANN401 - types
    """Return the type of an object with these keys; those that may be missing have no default in the schema."""
    from pydantic import Field, create_model

    def without_default(entry: dict[str, Any]) -> None:
        entry.pop("default", None)

    missing = Field(None, json_schema_extra=without_default)
    entries = {name: (kinds[name], ... if always else missing) for name, (_, always) in told_as(listed).items()}
    return create_model(title, **entries)  # type: ignore[call-overload]
