"""Sixteen doubles in one value, for compiled code.

numba has no name for the wide registers of a processor. This gives it one: a value of type
`Lanes` is a vector of LLVM, which the compiler spreads over as many registers as the machine
needs. Lane k of a result depends on lane k of the operands alone, each operation is rounded once as
IEEE 754 says, and nothing is contracted or reordered, so a lane's bits are the same whatever its
neighbours hold and whatever the machine.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
import numpy as np
from llvmlite import ir
from numba.core import cgutils as untyped_tools
from numba.core import types
from numba.core.datamodel import models
from numba.extending import intrinsic, overload, register_model
from numpy.typing import NDArray

# Two registers of eight doubles hide the latency of a fused multiply-add where there is AVX-512;
# elsewhere sixteen are spread over more registers, at no loss against eight.
WIDTH = 16

tools: Any = untyped_tools
F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compile a function at its first call, and keep the code for later processes.

    Division follows IEEE 754, and the lock of the interpreter is released.
    """
    return cast(F, numba.njit(cache=True, nogil=True, error_model="numpy")(function))


def operation(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function that returns a signature and a writer of LLVM's code known to numba."""
    return cast(Callable[..., Any], intrinsic(function))


class Lanes(types.Type):
    """The type of a value of sixteen doubles."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


_LANES = Lanes()
_VECTOR = ir.VectorType(ir.DoubleType(), WIDTH)


@register_model(Lanes)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, lanes: Any) -> None:
        super().__init__(manager, lanes, _VECTOR)  # type: ignore[no-untyped-call]


def aligned(*shape: int) -> NDArray[np.float64]:
    """Return zeros of shape (*shape, WIDTH), each row of which fills whole cache lines."""
    cache_line = 64  # bytes
    size = math.prod(shape) * WIDTH
    room = np.zeros(size + cache_line // 8)
    skip = (-room.ctypes.data % cache_line) // 8
    return room[skip : skip + size].reshape(*shape, WIDTH)


@operation
def borrowed(typing: Any, array: Any) -> Any:
    """Return an array without its count of references; its owner must outlive it.

    The counts are changed under a lock at every use of an array, which costs more than the use.
    """

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        whole = context.make_array(signature.args[0])(context, builder, args[0])
        whole.meminfo = tools.get_null_value(whole.meminfo.type)
        whole.parent = tools.get_null_value(whole.parent.type)
        return whole._getvalue()

    return array(array), code


def _row(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """Return the address of ``array[block, row]``, for an array of shape (blocks, rows, WIDTH)."""
    array = context.make_array(signature.args[0])(context, builder, args[0])
    _, rows, width = tools.unpack_tuple(builder, array.shape)
    first = builder.mul(builder.add(builder.mul(args[1], rows), args[2]), width)
    return builder.bitcast(builder.gep(array.data, [first]), _VECTOR.as_pointer())


@operation
def load(typing: Any, array: Any, block: Any, row: Any) -> Any:
    """Return ``array[block, row]`` of an array of shape (blocks, rows, WIDTH)."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.load(_row(context, builder, signature, args), align=8)

    return _LANES(array, types.intp, types.intp), code


@operation
def store(typing: Any, array: Any, block: Any, row: Any, value: Any) -> Any:
    """Write ``array[block, row]`` of an array of shape (blocks, rows, WIDTH)."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        builder.store(args[3], _row(context, builder, signature, args), align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, types.intp, _LANES), code


@operation
def splat(typing: Any, x: Any) -> Any:
    """Return a double in every lane."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        index = ir.IntType(32)
        one = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), args[0], index(0))
        every = ir.Constant(ir.VectorType(index, WIDTH), [0] * WIDTH)
        return builder.shuffle_vector(one, ir.Constant(_VECTOR, ir.Undefined), every)

    return _LANES(types.float64), code


def _intrinsic_of_llvm(name: str, arguments: int) -> Any:
    """Return an operation of LLVM on doubles and on lanes alike."""

    @operation
    def one(typing: Any, a: Any) -> Any:
        return a(a), code

    @operation
    def three(typing: Any, a: Any, b: Any, c: Any) -> Any:
        return a(a, a, a), code

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        kind = args[0].type
        suffix = f"v{WIDTH}f64" if kind == _VECTOR else "f64"
        shape = ir.FunctionType(kind, [kind] * arguments)
        function = tools.get_or_insert_function(builder.module, shape, f"llvm.{name}.{suffix}")
        return builder.call(function, args)

    return one if arguments == 1 else three


fma = _intrinsic_of_llvm("fma", 3)  # a b + c, rounded once
square_root = _intrinsic_of_llvm("sqrt", 1)
magnitude = _intrinsic_of_llvm("fabs", 1)


def _arithmetic(symbol: Callable[..., Any], instruction: str) -> None:
    @operation
    def of_two(typing: Any, a: Any, b: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            return getattr(builder, instruction)(*args)

        return _LANES(_LANES, _LANES), code

    @overload(symbol, strict=False)
    def on_lanes(a: Any, b: Any) -> Any:
        if isinstance(a, Lanes) and isinstance(b, Lanes):
            return lambda a, b: of_two(a, b)
        return None


_arithmetic(operator.add, "fadd")
_arithmetic(operator.sub, "fsub")
_arithmetic(operator.mul, "fmul")
_arithmetic(operator.truediv, "fdiv")
