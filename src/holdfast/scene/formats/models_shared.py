"""What the models of scene files share: numbers without conversions, and no unknown keys."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, model_validator

from holdfast.base.text import quoted


def _no_other_type(value: Any) -> Any:  # noqa: ANN401
    """Refuse texts and truth values, which pydantic would convert to numbers."""
    if isinstance(value, bool | str | bytes):
        raise ValueError("needs a number")
    return value


def _truth_value(value: Any) -> Any:  # noqa: ANN401
    """Refuse 0 and 1, "yes" and "no", which pydantic would convert to truth values."""
    if not isinstance(value, bool):
        raise ValueError("needs true or false")
    return value


Number = Annotated[float, BeforeValidator(_no_other_type)]
Whole = Annotated[int, BeforeValidator(_no_other_type)]
Truth = Annotated[bool, BeforeValidator(_truth_value)]
Triple = tuple[Number, Number, Number]
Quadruple = tuple[Number, Number, Number, Number]
Matrix3 = tuple[Triple, Triple, Triple]
Matrix4 = tuple[Quadruple, Quadruple, Quadruple, Quadruple]


MOST_KEYS = 100  # largest number of keys of one map, because pydantic collects the errors of all of them


class Model(BaseModel):
    """Base class of the models of a scene file, without unknown keys and infinite numbers."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _few_keys(cls, data: Any) -> Any:  # noqa: ANN401
        if isinstance(data, dict) and len(data) > MOST_KEYS:
            unknown = next(key for key in data if key not in cls.model_fields)
            raise ValueError(f"has {len(data):,} keys; {quoted(unknown)} and others are unknown")
        return data
