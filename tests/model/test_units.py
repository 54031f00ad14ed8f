"""Units: quantities that are the same in several of them."""

import math

import pytest

from longball.model.units import UNITS, from_si, read_in_si, si_of, unit_of

SAME = {
    "m/s": ("25", "25 m/s", "90 km/h", f"{25 / 0.44704!r} mph", f"{25 / 0.3048!r} ft/s"),
    "m": ("0.6096", "0.6096m", "60.96 cm", "609.6 mm", "2 ft", "24in"),
    "kg": ("0.45359237", "0.45359237 kg", "453.59237 g", "16 oz", "1 lb"),
    "rad": (repr(math.pi), f"{math.pi!r} rad", "180 deg", "180°"),
    "rad/s": (repr(math.pi), f"{math.pi!r} rad/s", "180 deg/s", "30 rpm"),
    "m/s²": ("3.048", "3.048 m/s²", "3.048m/s2", "10 ft/s²", "10 ft/s2"),
    "K": ("373.15", "373.15 K", "100 C", "100°C", "212 F", "212 °F"),
    "Pa": ("3386.389", "3386.389 Pa", "33.86389 hPa", "3.386389 kPa", "33.86389 mbar", "1 inHg"),
    "kg/m³": ("1.2", "1.2 kg/m³", "1.2kg/m3"),
    "s": ("0.5", "5e-1 s", "500 ms"),
}


@pytest.mark.parametrize("si", SAME)
def test_the_same_in_several_units(si):
    number, *others = SAME[si]
    assert {*UNITS[si]} <= {text.lstrip("-+.0123456789e ") for text in others}
    for text in others:
        assert read_in_si(text, si) == pytest.approx(float(number), rel=1e-14)
    for unit in UNITS[si]:
        found = from_si(read_in_si("7", si, unit), unit, si)
        assert found == pytest.approx(7.0, rel=1e-13)
        assert si_of(unit) == unit_of(f"{si}; of something") == si
