"""The friction table of a scene file: coefficients, and what joins faces."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field, model_validator

from holdfast.base.errors import SceneError, message
from holdfast.base.text import quoted
from holdfast.scene.formats.models_shared import Model, Number
from holdfast.scene.friction import Combine, Friction


def _numbers(value: Any) -> Any:  # noqa: ANN401
    """Refuse a map of numbers with a value that is not a number, and name the first one."""
    wrong = [key for key, item in value.items() if isinstance(item, bool | str)] if isinstance(value, dict) else []
    if wrong:
        raise ValueError(f"needs a number for {quoted(wrong[0])}, got {quoted(value[wrong[0]])}")
    return value


class PairModel(Model):
    """What holds between two bodies or materials: friction, and what joins their faces."""

    between: tuple[str, str]
    mu: Number | None = None
    tension: Number | None = Field(None, description="strength against being pulled apart [Pa]")
    cohesion: Number | None = Field(None, description="strength against sliding without pressure [Pa]")

    @model_validator(mode="after")
    def _says_something(self) -> PairModel:
        if (self.mu, self.tension, self.cohesion) == (None, None, None):
            raise ValueError("needs mu, tension or cohesion")
        return self


class FrictionModel(Model):
    """Static Coulomb friction, and what joins faces."""

    default: Number | None = None
    pairs: list[PairModel] = Field([], fail_fast=True)
    values: Annotated[dict[str, Number], BeforeValidator(_numbers)] = Field(
        {}, description="one coefficient a body, for imported scenes; needs combine"
    )
    combine: Combine | None = Field(None, description="how two values make a pair's")


def friction_of(model: float | FrictionModel) -> Friction:
    """Return the friction table of a scene file."""
    if not isinstance(model, FrictionModel):
        return Friction(default=model)
    seen: set[tuple[str, str]] = set()
    for pair in model.pairs:
        if {pair.between, pair.between[::-1]} & seen:
            raise SceneError(message("friction", f"pair {quoted(pair.between)} stands twice", "give each pair once"))
        seen.add(pair.between)
    given = [(each.between, each) for each in model.pairs]
    return Friction(
        model.default,
        {between: each.mu for between, each in given if each.mu is not None},
        model.values,
        model.combine,
        {between: each.tension for between, each in given if each.tension is not None},
        {between: each.cohesion for between, each in given if each.cohesion is not None},
    )


def friction_data(friction: Friction) -> dict[str, Any]:
    """Return a friction table as a scene file holds it."""
    table: dict[str, Any] = {"default": friction.default}
    tables = {"mu": friction.pairs, "tension": friction.tension, "cohesion": friction.cohesion}
    table["pairs"] = [
        {"between": list(pair)} | {name: given[pair] for name, given in tables.items() if pair in given}
        for pair in dict.fromkeys(pair for given in tables.values() for pair in given)
    ]
    table["values"] = dict(friction.values)
    table["combine"] = friction.combine
    return {key: value for key, value in table.items() if value not in (None, [], {})}
