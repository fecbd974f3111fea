"""The JSON schema of certificates."""

from __future__ import annotations

from typing import Any

from holdfast.certificates.verify_certificate import FORMAT, LISTS, NUMBER, OLDER

NAME = {"type": "string"}


def schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of certificates; what the entries mean is in certificates.md."""
    number = {"anyOf": [{"type": "integer"}, {"type": "string", "pattern": f"^({NUMBER.pattern})$"}]}
    vector = {"type": "array", "items": number, "minItems": 3, "maxItems": 3}
    wrench = _table(body=NAME, force=vector, torque=vector)
    load = _list({"oneOf": [wrench, _table(body=NAME, at=vector, force=vector)]})
    factor = {"anyOf": [number, {"const": "unlimited"}]}
    twist = _table(body=NAME, velocity=vector, turn=vector)
    contact = _table(
        between={"type": "array", "items": NAME, "minItems": 2, "maxItems": 2},
        mu=number,
        points=_list(_table(at=vector, normal=vector)),
    )

    def answered(answer: Any) -> dict[str, Any]:  # noqa: ANN401 - a schema
        return {"answered": _table(engine=NAME, answer=answer)}

    parts = {
        "fixed": NAME,
        "bodies": _table(name=NAME, mass=number, centre=vector),
        "standing": wrench,
        "contacts": contact,
        "rest": vector,
        "resting holds": wrench,
        "proofs": {
            "oneOf": [
                _table(answered({"enum": ["stable", "undecided"]}), kind={"const": "stands"}, claim=NAME),
                _table(
                    answered(factor),
                    kind={"const": "holds"},
                    claim=NAME,
                    load=load,
                    factor=factor,
                    forces=_list(vector),
                    holds=_list(wrench),
                ),
                _table(kind={"const": "moves"}, claim=NAME, load=load, factor=number, motion=_list(twist)),
                _table(kind={"const": "falls"}, claim=NAME, motion=_list(twist)),
            ]
        },
    }
    top = {"format": {"enum": [FORMAT, OLDER]}, "units": NAME, "gravity": vector, "acceleration": vector}
    whole = _table(**top, **{name: _list(parts[name]) for name in LISTS})
    several = _list({"$ref": "#/$defs/certificate"}) | {"minItems": 1}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": FORMAT,
        "$defs": {"certificate": whole},
        "oneOf": [{"$ref": "#/$defs/certificate"}, several],
    }


def _table(optional: dict[str, Any] | None = None, /, **entries: Any) -> dict[str, Any]:  # noqa: ANN401 - schemas
    properties = {**entries, **(optional or {})}
    return {"type": "object", "properties": properties, "required": list(entries), "additionalProperties": False}


def _list(items: Any) -> dict[str, Any]:  # noqa: ANN401 - a schema
    return {"type": "array", "items": items}
