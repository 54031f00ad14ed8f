"""Blocks of a scene, and the numbers in them."""

from __future__ import annotations

from collections.abc import Iterator
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

from pydantic import BaseModel, ConfigDict, Field, SerializerFunctionWrapHandler, model_serializer

if TYPE_CHECKING:  # to type checkers, whose rules for models hang on pydantic's own class
    from pydantic._internal._model_construction import ModelMetaclass as _Public
else:

    class _Public(type(BaseModel)):
        """The type of a class that shows its fields and methods of its own, and not pydantic's."""

        def __dir__(self) -> list[str]:
            own = (base for base in self.__mro__ if base.__module__.startswith("longball."))
            fields = getattr(self, "__pydantic_fields__", ())
            names = {*fields, *(name for base in own for name in vars(base))}
            return sorted(name for name in names if not name.startswith(("_", "model_")))


class Strict(BaseModel, metaclass=_Public):
    """What has fixed keys, and values of fixed types."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Block(Strict):
    """A part of a scene: numbers under fixed keys."""

    def __dir__(self) -> list[str]:
        return dir(type(self))

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        """Give the class a signature of its keys and defaults; {} is a block of defaults."""
        keys = []
        for name, field in cls.model_fields.items():
            default = Parameter.empty if field.is_required() else field.get_default()
            default = {} if isinstance(default, BaseModel) else default
            keys.append(Parameter(name, Parameter.KEYWORD_ONLY, default=default))
        cls.__signature__ = Signature(keys)

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
