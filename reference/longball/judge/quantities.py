"""The quantities of a result that are judged: their names, units and components.

A quantity is a number or a vector of a result's block: ``landing.distance``, ``plate.position``.
Values are decimals, exactly as written: neither the truth's thirty digits nor a candidate's
seventeen are rounded before the comparison.
"""

from __future__ import annotations

import decimal
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from decimal import Decimal

from longball.engines.chain import BLOCKS as MODELS
from longball.engines.chain import PARTS
from longball.model.quantities import at, number, numbers
from longball.model.result import Result

Value = tuple[Decimal, ...]

# With this many digits, differences of 30-digit numbers and of doubles are exact: a double near 1,
# written out, has at most 53 decimals.
ARITHMETIC = decimal.Context(prec=80)


@dataclass(frozen=True)
class QuantitySpec:
    """The name of a quantity of a result, and its parts."""

    name: str  # ``block.key``
    unit: str  # SI; empty for a pure number
    size: int = 1  # 1 for a number, 3 for a vector

    @property
    def names(self) -> tuple[str, ...]:
        """The names of its numbers."""
        many = tuple(f"{self.name}[{i}]" for i in range(self.size))
        return many if self.size > 1 else (self.name,)


_UNITS = ("s", "m", "m/s", "N s", "J", "rad/s", "rad")


def _specs() -> dict[str, QuantitySpec]:
    """Return the numbers and vectors of the blocks; a field's description begins with its unit."""
    # The result's model is the only list of quantities. A number may have a radius there, and is
    # annotated as `Bounded`; texts and flags are not.
    keys = [(part, *key) for part, model in PARTS.items() for key in model.model_fields.items()]
    found = {}
    for block, key, field in keys:
        if "Bounded" in (held := str(field.annotation)):
            unit = (field.description or "").partition(",")[0].partition(";")[0]
            size = 3 if "tuple" in held else 1
            name = f"{block}.{key}"
            found[name] = QuantitySpec(name, unit if unit in _UNITS else "", size)
    return found


QUANTITIES: dict[str, QuantitySpec] = _specs()

BLOCKS = tuple(MODELS)

# Rows of a verdict for candidates that answer with points. Each row has the worst point of a path.
PATH = {name: QuantitySpec(name, unit, 3) for name, unit in
        (("path.position", "m"), ("path.velocity", "m/s"))}  # fmt: skip


def values_of(result: Result) -> dict[str, Value]:
    """Return all quantities of a result, by name."""
    found: dict[str, Value] = {}
    for name, x in numbers(result):
        if isinstance(x, int):  # the number of a chord
            continue
        quantity = name.partition("[")[0]
        value = Decimal(repr(x) if isinstance(x, float) else x.value)
        found[quantity] = (*found.get(quantity, ()), value)
    return found


AT_VERTEX = 1e-9  # m: nearer to a corner of the fence, either of its chords is right
# A candidate may omit these: most programs do not compute them.
OPTIONAL = (
    "impact.recontact",
    "apex.time",
    "apex.position",
    "landing.angle",
    "plate.approach.vertical",
    "plate.approach.horizontal",
)


def told_by(result: Result) -> dict[str, object]:
    """Return a result's flags, texts and counts, by name."""
    found = {}
    for part in PARTS:
        held = at(result, part)
        for key in () if held is None else type(held).model_fields:
            name = f"{part}.{key}"
            if name not in {**QUANTITIES, **PARTS} and getattr(held, key) is not None:
                found[name] = getattr(held, key)
    if result.fence is not None and abs(float(result.fence.margin or 1.0)) < AT_VERTEX:
        del found["fence.segment"]
    return found


def untrue(result: Result, told: Mapping[str, object]) -> list[tuple[str, object, object]]:
    """Return wrong flags, texts and counts: the name, the right value, the given one."""
    # A fact that is missing in the truth is not judged, except `impact.recontact`: if this is
    # absent, ball and bat do not meet again.
    right = told_by(result)
    known = {name: given for name, given in told.items() if name in right or name in OPTIONAL}
    return [(n, right.get(n), given) for n, given in known.items() if given != right.get(n)]


# Quantities that require a contact, and those that require one between the bat's ends. `WITHOUT`
# are the quantities that an outcome with a `contact` block does not have.
MET = ("contact.time", "contact.position")
STRUCK = ("contact.normal", "contact.bat_velocity", "contact.normal_speed")
WITHOUT = {"missed": (*MET, *STRUCK), "beyond_bat": STRUCK}


def superfluous(outcome: str | None, expected: Iterable[str], given: Iterable[str]) -> list[str]:
    """Return given blocks that the truth lacks, and quantities that the outcome cannot have."""
    blocks = {name.partition(".")[0] for name in expected}
    own = {name: name.partition(".")[0] for name in given if name not in OPTIONAL}
    named = {block for block in own.values() if block not in blocks}
    named |= {*WITHOUT.get(outcome or "", ())} & {n for n, block in own.items() if block in blocks}
    return [name for name in (*BLOCKS, *QUANTITIES) if name in named]


def radius_of(result: Result, quantity: str) -> Value:
    """Return the proven radius of a quantity of a result; 0 where none is proven."""
    held = (number(result, name) for name in QUANTITIES[quantity].names)
    return tuple(Decimal(getattr(x, "radius", None) or 0) for x in held)


def difference(a: Value, b: Value) -> float:
    """Return the distance of two values: the length of the difference of vectors."""
    with decimal.localcontext(ARITHMETIC):
        return float(sum(((x - y) * (x - y) for x, y in zip(a, b, strict=True)), Decimal(0)).sqrt())


def length(value: Value) -> float:
    """Return the size of a value: the length of a vector."""
    return difference(value, (Decimal(0),) * len(value))
