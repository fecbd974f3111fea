"""The JSON schema of certificates."""

from __future__ import annotations

from typing import Any

from holdfast.certificates.verify_certificate import FORMAT, LISTS, NUMBER

NAME = {"type": "string"}


def schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of certificates; what the entries mean is in certificates.md."""
    number = {"anyOf": [{"type": "integer"}, {"type": "string", "pattern": f"^({NUMBER.pattern})$"}]}
    vector = {"type": "array", "items": number, "minItems": 3, "maxItems": 3}
    wrench = _table(body=NAME, force=vector, torque=vector)
    twist = _table(body=NAME, velocity=vector, turn=vector)
    contact = _table(
        between={"type": "array", "items": NAME, "minItems": 2, "maxItems": 2},
        mu=number,
        points=_list(_table(at=vector, normal=vector)),
    )
    parts = {
        "fixed": NAME,
        "bodies": _table(name=NAME, mass=number, centre=vector),
        "standing": wrench,
        "contacts": contact,
        "rest": vector,
        "resting holds": wrench,
        "proofs": {
            "oneOf": [
                _table(kind={"const": "stands"}, claim=NAME),
                _table(
                    kind={"const": "holds"},
                    claim=NAME,
                    load=_list(wrench),
                    factor={"anyOf": [number, {"const": "unlimited"}]},
                    forces=_list(vector),
                    holds=_list(wrench),
                ),
                _table(kind={"const": "moves"}, claim=NAME, load=_list(wrench), factor=number, motion=_list(twist)),
                _table(kind={"const": "falls"}, claim=NAME, motion=_list(twist)),
            ]
        },
    }
    top = {"format": {"const": FORMAT}, "units": NAME, "gravity": vector, "acceleration": vector}
    whole = _table(**top, **{name: _list(parts[name]) for name in LISTS})
    several = _list({"$ref": "#/$defs/certificate"}) | {"minItems": 1}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": FORMAT,
        "$defs": {"certificate": whole},
        "oneOf": [{"$ref": "#/$defs/certificate"}, several],
    }


def _table(**entries: Any) -> dict[str, Any]:  # noqa: ANN401 - schemas
    return {"type": "object", "properties": entries, "required": list(entries), "additionalProperties": False}


def _list(items: Any) -> dict[str, Any]:  # noqa: ANN401 - a schema
    return {"type": "array", "items": items}
