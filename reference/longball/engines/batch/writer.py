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

Value = Any  # of LLVM: a number in each lane
Values = dict[Node, Value]

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


class Writer:
    """Writes a function whose values are a double in each of some lanes.

    Its arguments are two pointers to arrays of lanes, three integers and a double.
    """

    def __init__(self, module: Any, name: str, lanes: int = WIDTH) -> None:
        self.lanes = lanes
        self.type = ir.VectorType(DOUBLE, lanes)
        arguments = [self.type.as_pointer()] * 2 + [INDEX] * 3 + [DOUBLE]
        self.function = ir.Function(module, ir.FunctionType(INDEX, arguments), name)
        self.arguments = self.function.args
        self.builder = build = ir.IRBuilder(self.function.append_basic_block())
        self.add, self.subtract = build.fadd, build.fsub
        self.multiply, self.divide = build.fmul, build.fdiv

    def number(self, value: float) -> Value:
        """Return a number, the same in every lane."""
        return ir.Constant(self.type, [ir.Constant(DOUBLE, value)] * self.lanes)

    def spread(self, scalar: Value) -> Value:
        """Return a double or an integer in every lane."""
        if scalar.type == INDEX:
            scalar = self.builder.sitofp(scalar, DOUBLE)
        nothing = ir.Constant(self.type, ir.Undefined)
        first = self.builder.insert_element(nothing, scalar, ir.Constant(ir.IntType(32), 0))
        every = ir.Constant(ir.VectorType(ir.IntType(32), self.lanes), [0] * self.lanes)
        return self.builder.shuffle_vector(first, nothing, every)

    def index(self, value: Value | int) -> Value:
        """Return an integer that indexes rows; it may be a value already."""
        return ir.Constant(INDEX, value) if isinstance(value, int) else value

    def load(self, array: Value, index: Value) -> Value:
        """Return a row of an array."""
        return self.builder.load(self.builder.gep(array, [index]), align=8)

    def store(self, array: Value, index: Value, value: Value) -> None:
        """Write a row of an array."""
        self.builder.store(value, self.builder.gep(array, [index]), align=8)

    def call(self, name: str, *arguments: Value) -> Value:
        """Call a function of LLVM: fma, sqrt, exp, log, fabs."""
        shape = ir.FunctionType(self.type, [self.type] * len(arguments))
        full = f"llvm.{name}.v{self.lanes}f64"
        known = self.function.module.globals
        function = known[full] if full in known else ir.Function(self.function.module, shape, full)
        return self.builder.call(function, arguments)

    def fma(self, a: Value, b: Value, c: Value) -> Value:
        """Return ``a b + c``, rounded once."""
        return self.call("fma", a, b, c)

    def choose(self, a: Value, comparison: str, b: Value, yes: Value, no: Value) -> Value:
        """Return `yes` in the lanes where a comparison holds, else `no`; it fails for NaN."""
        return self.builder.select(self.builder.fcmp_ordered(comparison, a, b), yes, no)

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
        build, entry = self.builder, self.builder.block
        head, inside, after = (self.function.append_basic_block() for _ in range(3))
        build.branch(head)
        build.position_at_end(head)
        i = build.phi(INDEX)
        i.add_incoming(self.index(begin), entry)
        values = [build.phi(value.type) for value in carried]
        for phi, value in zip(values, carried, strict=True):
            phi.add_incoming(value, entry)
        build.cbranch(build.icmp_signed("<", i, self.index(end)), inside, after)
        build.position_at_end(inside)
        for phi, value in zip(values, body(i, values), strict=True):
            phi.add_incoming(value, build.block)
        i.add_incoming(build.add(i, self.index(1)), build.block)
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
                return value if zero else self.add(value, values[rest])
            case "plus":
                return self.add(*(values[x] for x in node.args))
            case "product":
                return self.multiply(*(values[x] for x in node.args))
            case "quotient":
                return self.divide(*(values[x] for x in node.args))
            case _:
                return self.call(node.kind, values[node.args[0]])

    def combination(self, node: Node, values: Values, coefficients: Values) -> Value:
        """Return a sum without its constant."""
        total = None
        for coefficient, x in node.args[1:]:
            known = coefficient.args[0] if coefficient.kind == "constant" else None
            if known == 1.0:
                total = values[x] if total is None else self.add(total, values[x])
            elif total is None:
                total = self.multiply(coefficients[coefficient], values[x])
            else:
                total = self.fma(coefficients[coefficient], values[x], total)
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
