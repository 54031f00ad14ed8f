"""Blocks of a scene, and the numbers in them."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from contextlib import suppress
from inspect import Parameter, Signature
from textwrap import wrap
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NoReturn

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    ValidationError,
    model_serializer,
)

from longball.model.annotations import spelled

# Type checkers have special rules for pydantic's own metaclass, which a subclass would lose.
if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass as _Public
else:

    class _Public(type(BaseModel)):
        """Metaclass whose `dir` lists fields and longball's methods, without pydantic's."""

        def __dir__(self) -> list[str]:
            fields, names = getattr(self, "__pydantic_fields__", ()), self.shown
            if names is None:
                own = (base for base in self.__mro__ if base.__module__.startswith("longball."))
                names = {name for base in own for name in vars(base)} - {"shown"}
            public = (name for name in names if not name.startswith(("_", "model_")))
            return sorted({*fields, *public})


class Strict(BaseModel, metaclass=_Public):
    """A model with fixed keys, whose values have fixed types."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)

    # Names that help and completion show in addition to the fields; None means all public ones.
    shown: ClassVar[tuple[str, ...] | None] = None

    def __dir__(self) -> list[str]:
        return dir(type(self))

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        """Add the fields to the docstring, with their types and descriptions."""
        if cls.__doc__ and cls.model_fields:
            title = "Parameters" if issubclass(cls, Block) else "Attributes"
            rows = [inspect.cleandoc(cls.__doc__), "", title, "----------"]
            for name, field in cls.model_fields.items():
                if name == "kind":  # the class itself decides it
                    continue
                rows.append(f"{name} : {spelled(field.annotation, lambda model: model.__name__)}")
                rows += [f"    {line}" for line in wrap(field.description or "", 90)]
            cls.__doc__ = "\n".join(rows)


if TYPE_CHECKING:
    _Called = _Public
else:

    class _Called(_Public):
        """Metaclass of models that users create: it converts arrays, and words its errors."""

        def __call__(self, *values: object, **keys: object) -> Any:
            if values:
                raise TypeError(
                    f"{self.__name__} takes keywords: {', '.join(self.model_fields)}; a mapping "
                    "is given as **mapping"
                )
            # The fast path, for valid Python values. Otherwise the values are converted to JSON,
            # which takes lists and arrays as vectors, and validated again for the messages.
            with suppress(ValidationError):
                return super().__call__(**keys)
            from longball.model.explain import explain
            from longball.model.plain import json_text
            from longball.model.scene import InvalidScene

            try:
                return self.model_validate_json(json_text(keys))
            except ValidationError as error:
                raise InvalidScene(explain(error, self)) from None
            except RecursionError:
                raise InvalidScene("its blocks are nested too deeply") from None


class Given(Strict, metaclass=_Called):
    """A model that users create; an `InvalidScene` names the key at fault."""


class Block(Given):
    """A part of a scene: numbers under fixed keys."""

    shown: ClassVar[tuple[str, ...] | None] = ()

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        """Give the class a signature of its keys and defaults; {} is a block of defaults."""
        super().__pydantic_init_subclass__(**kwargs)
        keys = []
        for name, field in cls.model_fields.items():
            default = Parameter.empty if field.is_required() else field.get_default()
            default = {} if isinstance(default, BaseModel) else default
            keys.append(Parameter(name, Parameter.KEYWORD_ONLY, default=default))
        cls.__signature__ = Signature(keys)

    def __repr_args__(self) -> Iterator[tuple[str, Any]]:
        # Defaults are omitted: a scene has about sixty numbers and switches.
        yield from self.model_dump(exclude_defaults=True).items()

    def named(self) -> Iterator[str]:
        """Yield the keys of the written block: those with a value or a default."""
        for key, field in type(self).model_fields.items():
            if getattr(self, key) is not None or field.get_default() is not None:
                yield key

    @model_serializer(mode="wrap")
    def _written(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        written = handler(self)
        return {key: written[key] for key in self.named() if key in written}


# Limits of numbers: within them no product in the model's formulas overflows or underflows a
# double.
LARGEST, SMALLEST = 1e30, 1e-30

Quantity = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
NotNegative = Annotated[float, Field(ge=0.0, le=LARGEST)]
Positive = Annotated[float, Field(ge=SMALLEST, le=LARGEST)]
Point = tuple[Quantity, Quantity, Quantity]


def refuse(sentence: str) -> NoReturn:
    """Raise a ValueError with this sentence."""
    raise ValueError(sentence)
