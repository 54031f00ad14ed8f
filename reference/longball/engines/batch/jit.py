"""Pointers and calls for compiled code, beyond numba's own functions.

Arrays are passed as pointers: a pointer is one word, its indices are not wrapped around, and its
references are not counted; the code is compiled several times faster, and runs faster, than with
arrays.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
from llvmlite import ir
from numba.core import types as untyped_types
from numba.extending import intrinsic

types: Any = untyped_types

F = TypeVar("F", bound=Callable[..., Any])


def inner(function: F) -> F:
    """Compile a function for compiled functions to call, not for Python.

    Division follows IEEE 754.
    """
    settings: dict[str, Any] = {
        "error_model": "numpy",
        "no_cpython_wrapper": True,
        "no_cfunc_wrapper": True,
    }
    return cast(F, numba.njit(**settings)(function))


def operation(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function that returns a signature and a writer of LLVM's code known to numba."""
    return cast(Callable[..., Any], intrinsic(function))


@operation
def _fused(typing: Any, a: Any, b: Any, c: Any) -> Any:
    double = types.float64
    return double(double, double, double), lambda context, builder, signature, args: builder.fma(
        *args
    )


fma = cast(Callable[[float, float, float], float], _fused)  # a b + c, rounded once


@operation
def unowned_views(typing: Any, fields: Any) -> Any:
    """Return a tuple, also a named one, with pointers in place of its arrays.

    They point to the first elements of the arrays, which must outlive them.
    """
    kinds = [types.CPointer(x.dtype) if isinstance(x, types.Array) else x for x in fields.types]
    views = types.BaseTuple.from_types(kinds, getattr(fields, "instance_class", None))

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        values = [builder.extract_value(args[0], i) for i in range(len(kinds))]
        for i, kind in enumerate(fields.types):
            if isinstance(kind, types.Array):
                values[i] = context.make_array(kind)(context, builder, values[i]).data
        return context.make_tuple(builder, views, values)

    return views(fields), code


@operation
def shifted(typing: Any, pointer: Any, places: Any) -> Any:
    """Return the pointer to the element at an index."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.gep(args[0], [args[1]])

    return pointer(pointer, types.intp), code


@operation
def call(typing: Any, address: Any, arguments: Any) -> Any:
    """Call machine code at an address with a tuple of arguments; it returns an integer."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        values = [builder.extract_value(args[1], i) for i in range(len(arguments))]
        shape = ir.FunctionType(ir.IntType(64), [value.type for value in values])
        return builder.call(builder.inttoptr(args[0], shape.as_pointer()), values)

    return types.int64(types.int64, arguments), code
