"""Customary units: factors to SI units, and zeros of temperature scales."""

from __future__ import annotations

import math
import re

from longball.model.names import one_of

_DEGREE = math.pi / 180.0

# Factors by SI unit. All are exact by definition, except that of the inch of mercury (at 0 °C).
UNITS: dict[str, dict[str, float]] = {
    "m/s": {"m/s": 1.0, "km/h": 1 / 3.6, "mph": 0.44704, "ft/s": 0.3048},
    "m": {"m": 1.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254},
    "kg": {"kg": 1.0, "g": 0.001, "oz": 0.028349523125, "lb": 0.45359237},
    "rad": {"rad": 1.0, "deg": _DEGREE, "°": _DEGREE},
    "rad/s": {"rad/s": 1.0, "deg/s": _DEGREE, "rpm": math.pi / 30.0},
    "m/s²": {"m/s²": 1.0, "m/s2": 1.0, "ft/s²": 0.3048, "ft/s2": 0.3048},
    "K": {"K": 1.0, "C": 1.0, "°C": 1.0, "F": 1 / 1.8, "°F": 1 / 1.8},
    "Pa": {"Pa": 1.0, "hPa": 100.0, "kPa": 1000.0, "mbar": 100.0, "inHg": 3386.389},
    "kg/m³": {"kg/m³": 1.0, "kg/m3": 1.0},
    "s": {"s": 1.0, "ms": 0.001},
}
# Zeros of temperature scales, K.
_ZEROS = {"C": 273.15, "°C": 273.15, "F": 459.67 / 1.8, "°F": 459.67 / 1.8}  # K


def unit_of(description: str) -> str:
    """Return the SI unit at the beginning of a field's description, or "".

    >>> unit_of("m/s; default: the mean of Eq. 3")
    'm/s'
    """
    first = re.match(r"[^\s,;]+", description)
    return first[0] if first and first[0] in UNITS else ""


def in_si(number: float, unit: str, si: str) -> float:
    """Return a number in an SI unit; raise a ValueError for a unit of another quantity."""
    # "5,200ft" is parsed as the number 5 with the unit ",200ft".
    if unit.startswith(","):
        raise ValueError("a number has no comma, as in 5200ft")
    if unit not in UNITS.get(si, {}):
        known = one_of("use", unit, UNITS[si]) if si else "; this number has none"
        raise ValueError(f"the unit {unit!r} does not fit{known}")
    # Temperatures have an offset: 72 °F = 72/1.8 K + 459.67/1.8 K.
    return number * UNITS[si][unit] + _ZEROS.get(unit, 0.0)


_NUMBER = re.compile(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*([^\d\s\[\]]\S*)?\s*")


def read_in_si(text: str, si: str, usual: str = "") -> float | None:
    """Return the number in a text, in an SI unit; None if the text is not a number.

    A number without a unit is in the `usual` unit, by default the SI unit. A ValueError is raised
    for a unit of another quantity.

    >>> read_in_si("90 km/h", "m/s")
    25.0
    """
    parts = _NUMBER.fullmatch(text)
    return parts and in_si(float(parts[1]), parts[2] or usual or si, si)


def from_si(number: float, unit: str, si: str) -> float:
    """Return a number in another unit: the inverse of `in_si`."""
    return (number - _ZEROS.get(unit, 0.0)) / UNITS[si][unit]


def si_of(unit: str) -> str:
    """Return the SI unit of the same quantity as a unit.

    >>> si_of("mph")
    'm/s'
    """
    return next(si for si, units in UNITS.items() if unit in units)
