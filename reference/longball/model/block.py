"""Blocks of a scene, and the numbers in them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, NoReturn

from pydantic import BaseModel, ConfigDict, Field, SerializerFunctionWrapHandler, model_serializer


class Strict(BaseModel):
    """What has fixed keys, and values of fixed types."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Block(Strict):
    """A part of a scene: numbers under fixed keys."""

    def named(self) -> Iterator[str]:
        """Yield the keys that it is written with: all but those left out that have no default."""
        for key, field in type(self).model_fields.items():
            if getattr(self, key) is not None or field.get_default() is not None:
                yield key

    @model_serializer(mode="wrap")
    def _written(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        written = handler(self)
        return {key: written[key] for key in self.named() if key in written}


# Sizes within which no product of the model's formulas overflows or underflows a double.
LARGEST, SMALLEST = 1e30, 1e-30

Quantity = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
NotNegative = Annotated[float, Field(ge=0.0, le=LARGEST)]
Positive = Annotated[float, Field(ge=SMALLEST, le=LARGEST)]
Point = tuple[Quantity, Quantity, Quantity]


def refuse(sentence: str) -> NoReturn:
    """Refuse a value by a ValueError with this sentence."""
    raise ValueError(sentence)
