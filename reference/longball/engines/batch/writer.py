"""Machine code on lanes: a function whose values are a double of each of several flights.

It is written in LLVM's language. Lane k of a result depends on lane k of the operands alone, each
operation is rounded once as IEEE 754 says, and nothing is contracted or reordered, so a lane's bits
are the same whatever its neighbours hold.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from threading import Lock
from typing import Any, TypeVar

import numpy as np
from llvmlite import binding, ir

from longball.engines.compiled import stored
from longball.model.arrays import Array
from longball.model.trace import Node, Program

# Two registers of eight doubles hide the latency of a fused multiply-add where there is AVX-512;
# elsewhere sixteen are spread over more registers, at no loss against eight.
WIDTH = 16


def aligned(*shape: int) -> Array:
    """Return zeros that begin on a cache line."""
    cache_line = 64  # bytes
    size = math.prod(shape)
    memory = np.zeros(size + cache_line // 8)
    skip = (-memory.ctypes.data % cache_line) // 8
    return memory[skip : skip + size].reshape(*shape)


# --- code on lanes --------------------------------------------------------------------------------

INDEX = ir.IntType(64)
DOUBLE = ir.DoubleType()


def _operator(of_integers: str, of_numbers: str) -> Callable[[Value, Value | float], Value]:
    """Return an operator that writes one instruction of LLVM, by the type of its operands."""

    def write(self: Value, other: Value | float) -> Value:
        name = of_integers if self.is_whole else of_numbers
        return Value(self.build, getattr(self.build, name)(self.code, self.same(other).code))

    return write


def _comparison(symbol: str) -> Callable[[Value, Value | float], Value]:
    """Return a comparison; of numbers it fails for NaN."""

    def write(self: Value, other: Value | float) -> Value:
        build = self.build
        compare = build.icmp_signed if self.is_whole else build.fcmp_ordered
        return Value(build, compare(symbol, self.code, self.same(other).code))

    return write


class Value:
    """A number or a flag in each lane, or an index that all lanes share, in code being written.

    Operators write instructions; numbers of Python are constants.
    """

    def __init__(self, build: Any, code: Any) -> None:
        self.build, self.code = build, code

    @property
    def is_whole(self) -> bool:
        """True if it is an index, or has an integer in each lane."""
        return bool(getattr(self.code.type, "element", self.code.type) == INDEX)

    def same(self, x: Value | float) -> Value:
        """Return a value, or a number of Python as one of the type of this value."""
        if isinstance(x, Value):
            return x
        kind = self.code.type
        if isinstance(kind, ir.VectorType):
            return Value(self.build, ir.Constant(kind, [ir.Constant(kind.element, x)] * kind.count))
        return Value(self.build, ir.Constant(kind, x))

    __add__ = __radd__ = _operator("add", "fadd")
    __sub__ = _operator("sub", "fsub")
    __mul__ = __rmul__ = _operator("mul", "fmul")
    __truediv__ = _operator("sdiv", "fdiv")
    __rshift__ = _operator("ashr", "ashr")
    __and__ = _operator("and_", "and_")
    __or__ = _operator("or_", "or_")
    __lt__, __gt__, equals = _comparison("<"), _comparison(">"), _comparison("==")

    def differs(self, x: float) -> Value:
        """Return flags of the lanes with another number, or NaN."""
        different = self.build.fcmp_unordered("!=", self.code, self.same(x).code)
        return Value(self.build, different)

    def __neg__(self) -> Value:
        return Value(self.build, self.build.fneg(self.code))

    def select(self, yes: Value, no: Value) -> Value:
        """Return `yes` where this flag is set, else `no`."""
        return Value(self.build, self.build.select(self.code, yes.code, no.code))

    def to(self, conversion: str, kind: Any) -> Value:
        """Return the value in another type of LLVM, by the name of a conversion."""
        return Value(self.build, getattr(self.build, conversion)(self.code, kind))


class Rows:
    """An array in the code being written; a row has a number for each lane."""

    def __init__(self, build: Any, pointer: Any) -> None:
        self.build, self.pointer = build, pointer

    def __getitem__(self, row: Value) -> Value:
        place = self.build.gep(self.pointer, [row.code])
        return Value(self.build, self.build.load(place, align=8))

    def __setitem__(self, row: Value, value: Value) -> None:
        self.build.store(value.code, self.build.gep(self.pointer, [row.code]), align=8)


Values = dict[Node, Value]


class Writer:
    """Writes a function whose values are a double in each of some lanes.

    Its arguments are two pointers to arrays of lanes, three integers and a double.
    """

    def __init__(self, module: Any, name: str, lanes: int = WIDTH) -> None:
        self.lanes = lanes
        self.type = ir.VectorType(DOUBLE, lanes)
        arguments = [self.type.as_pointer()] * 2 + [INDEX] * 3 + [DOUBLE]
        self.function = ir.Function(module, ir.FunctionType(INDEX, arguments), name)
        self.build = build = ir.IRBuilder(self.function.append_basic_block())
        first, second, *numbers = self.function.args
        self.arrays = Rows(build, first), Rows(build, second)
        self.numbers = [Value(build, number) for number in numbers]

    def number(self, value: float) -> Value:
        """Return a number, the same in every lane."""
        return Value(self.build, ir.Constant(self.type, ir.Undefined)).same(value)

    def index(self, value: Value | int) -> Value:
        """Return an integer that indexes rows; it may be a value already."""
        return self.numbers[0].same(value)

    def spread(self, scalar: Value) -> Value:
        """Return a double or an integer in every lane."""
        if scalar.code.type == INDEX:
            scalar = scalar.to("sitofp", DOUBLE)
        nothing = ir.Constant(self.type, ir.Undefined)
        place = ir.Constant(ir.IntType(32), 0)
        first = self.build.insert_element(nothing, scalar.code, place)
        every = ir.Constant(ir.VectorType(ir.IntType(32), self.lanes), [0] * self.lanes)
        return Value(self.build, self.build.shuffle_vector(first, nothing, every))

    def call(self, name: str, *arguments: Value) -> Value:
        """Call a function of LLVM: fma, sqrt, exp, log, fabs."""
        shape = ir.FunctionType(self.type, [self.type] * len(arguments))
        full = f"llvm.{name}.v{self.lanes}f64"
        known = self.function.module.globals
        function = known[full] if full in known else ir.Function(self.function.module, shape, full)
        return Value(self.build, self.build.call(function, [x.code for x in arguments]))

    def fma(self, a: Value, b: Value, c: Value) -> Value:
        """Return ``a b + c``, rounded once."""
        return self.call("fma", a, b, c)

    def repeat(
        self,
        begin: Value | int,
        end: Value | int,
        carried: Sequence[Value],
        body: Callable[[Value, list[Value]], Sequence[Value]],
    ) -> list[Value]:
        """Write a loop over i from `begin` to below `end`.

        `body` takes i and the carried values, and returns those for the next i.
        """
        build, entry = self.build, self.build.block
        head, inside, after = (self.function.append_basic_block() for _ in range(3))
        build.branch(head)
        build.position_at_end(head)
        phis = [build.phi(INDEX), *(build.phi(self.type) for _ in carried)]
        i, *values = (Value(build, phi) for phi in phis)
        starts = [self.index(begin), *carried]
        build.cbranch((i < end).code, inside, after)
        build.position_at_end(inside)
        following = body(i, values)
        for phi, start, value in zip(phis, starts, [i + 1, *following], strict=True):
            phi.add_incoming(start.code, entry)
            phi.add_incoming(value.code, build.block)
        build.branch(head)
        build.position_at_end(after)
        return values

    # --- traced programs ---

    def evaluate(
        self, nodes: Iterable[Node], given: Callable[[Node], Value], values: Values
    ) -> None:
        """Add the values of nodes to those of the nodes that they are computed from.

        `given` has those of variables and parameters.
        """
        for node in nodes:
            of_state = node.kind in ("variable", "parameter")
            values[node] = given(node) if of_state else self.value(node, values)

    def value(self, node: Node, values: Values) -> Value:
        """Return the value of a node, from those of the nodes before it."""
        match node.kind:
            case "constant":
                return self.number(node.args[0])
            case "sum":
                value = self.combination(node, values, values)
                rest = node.args[0]
                zero = rest.kind == "constant" and rest.args[0] == 0.0
                return value if zero else value + values[rest]
            case "plus":
                return values[node.args[0]] + values[node.args[1]]
            case "product":
                return values[node.args[0]] * values[node.args[1]]
            case "quotient":
                return values[node.args[0]] / values[node.args[1]]
            case _:
                return self.call(node.kind, values[node.args[0]])

    def combination(self, node: Node, values: Values, coefficients: Values) -> Value:
        """Return a sum without its constant."""
        total: Value | None = None
        for coefficient, x in node.args[1:]:
            known = coefficient.args[0] if coefficient.kind == "constant" else None
            if known == 1.0:
                total = values[x] if total is None else total + values[x]
            elif total is None:
                total = coefficients[coefficient] * values[x]
            else:
                total = self.fma(coefficients[coefficient], values[x], total)
        assert total is not None
        return total


# --- machine code ---------------------------------------------------------------------------------

_compiling = Lock()
T = TypeVar("T")


def once(make: Callable[[Program], T]) -> Callable[[Program], T]:
    """Keep what is made of a program, also where several threads ask for it at once."""
    known = cache(make)

    def made(program: Program) -> T:
        with _compiling:
            return known(program)

    return made


class Code:
    """A function of machine code, compiled once per machine for what it is made of."""

    def __init__(self, name: str, program: Program, write: Callable[[Any], object]) -> None:
        binding.initialize_native_target()
        binding.initialize_native_asmprinter()
        target = binding.Target.from_default_triple().create_target_machine(
            cpu=binding.get_host_cpu_name(),
            features=binding.get_host_cpu_features().flatten(),
            opt=3,
            codemodel="jitdefault",
            jit=True,
        )

        def machine_code() -> bytes:
            module = ir.Module()
            write(module)
            checked = binding.parse_assembly(str(module))
            checked.verify()
            options = binding.create_pipeline_tuning_options(speed_level=3)
            passes = binding.create_pass_builder(target, options)
            passes.getModulePassManager().run(checked, passes)
            code: bytes = target.emit_object(checked)
            return code

        # The program's text says what is compiled; how it is, the sources in the name of the file.
        code = stored(name, [program.source], machine_code)
        # owns the code
        self._engine = binding.create_mcjit_compiler(binding.parse_assembly(""), target)
        self._engine.add_object_file(binding.ObjectFileRef.from_data(code))
        self._engine.finalize_object()
        self.address: int = self._engine.get_function_address(name)
