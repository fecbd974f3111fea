"""Checks plain data against the JSON schema of ``holdfast-answer/1``, more strictly than the published one."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import jsonschema

from holdfast.base.envelope import schema


@cache
def _strict() -> dict[str, Any]:
    """The schema, in which no object that it lists the keys of may have another."""
    whole = json.loads(json.dumps(schema()))
    jsonschema.Draft202012Validator.check_schema(whole)
    for part in whole["$defs"].values():
        if "properties" in part:
            part["additionalProperties"] = False
    return whole


def problems(data: Any) -> list[str]:
    """What is wrong with an envelope; nothing, if it is strict JSON and as the schema says."""
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    defs = _strict()["$defs"]
    if data["question"] not in defs:
        return [f"the schema has no question {data['question']!r}"]
    found = jsonschema.Draft202012Validator({**defs[data["question"]], "$defs": defs}).iter_errors(data)
    return [f"{list(error.path)}: {error.message:.300}" for error in found]
