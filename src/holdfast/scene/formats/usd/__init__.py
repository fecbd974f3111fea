"""USD: stages with UsdPhysics, through usd-core (the extra ``usd``)."""

from holdfast.scene.formats.usd import reader

__all__ = ["reader"]
