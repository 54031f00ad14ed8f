"""The legend of the golden set, its header: all that its files do not say by themselves."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version

import flint

from longball import __version__
from longball.engines.enclosure import Enclosure
from longball.engines.multiprecision import Multiprecision
from longball.golden.case import Case, Family, Header
from longball.golden.files import FORMAT
from longball.golden.truth import CONFIRMING, DIGITS, WORK

NUMBERS = {
    "scene": "A number of a scene means the double nearest to what is written, exactly.",
    "value": "Decimal string of 31 digits, the nearest to the middle of the enclosure but for "
    "rounding; zeros at its end may be left out.",
    "zero": "A value of 0 with a radius above 0 is one that is not told from zero.",
    "radius": "Proven: |truth - value| <= radius, where truth is the exact real solution of the "
    "model for the doubles of the scene. It is at most 1e-30 of the quantity's size, or, where the "
    "value is 0, at most 1e-30 of its unit.",
    "size": "Of a number its absolute value; of a component the length of its vector; of "
    "contact.margin R + r_b, since a margin is a difference of lengths; of impact.friction_margin "
    "at least 1; of fence.clearance and fence.margin the length of fence.position.",
    "double": "The double nearest to value; of the two nearest, the one with an even last bit.",
    "hex": "The same double in C's hexadecimal notation.",
    "attainable": "u (sum of |dQ/dx| |x| over all inputs x + |dQ/d(height_offset)| z_b + |Q|), "
    "u = 2^-53, |Q| of a component the length of its vector: the error that rounding every input, "
    "the bat's height and the result once makes unavoidable. A careful implementation in double "
    "precision stays within a small multiple.",
    "digits": "-log10(attainable / |Q|), at least 0; |Q| of a component the length of its vector.",
    "derivatives": "Central differences; three digits (longball.golden.condition).",
    "agreement": "Largest |value - independent value| over all numbers, in units of 1e-30 of the "
    "quantity's size. The value's own rounding, up to 0.5 of a unit in its 31st digit, is in it.",
}

LEVELS = {
    "lower": "Double precision can know 13 digits or more of what is asked for: distance and time "
    "of landing, time and height at the plate, impulse, closing speed or margin, by outcome.",
    "average": "10 to 13 digits.",
    "higher": "Fewer than 10 digits, or an outcome that a few ulps of an input decide, or none.",
}

FLAGS = {
    "airborne": "Made to be in the air still when the time limit is over.",
    "at-release": "Ball and bat touch at the release, or all but.",
    "bat-end": "Touching at |y| = L/2, where the bat ends, or within rounding of it.",
    "blown-back": "The wind takes the ball over the fence and back.",
    "closed-form": "The solution is known in elementary functions (longball.model.exact).",
    "decay": "The spin is gone after some metres.",
    "dip": "Lift turns the falling ball up again, just above or just below the ground.",
    "extreme": "Sizes far from baseball.",
    "fragile": "A step of 2^-50 of some input, a few ulps, changes the outcome or leaves none: an "
    "implementation in double precision that answers otherwise, or not at all, need not be wrong.",
    "friction": "Ball and bat rub.",
    "grazing": "The margin between touching and missing the bat is from 1e-3 down to 1e-15 m.",
    "grip-slide": "Friction has from 1e-3 down to 1e-15 of itself to spare, or too little by that.",
    "gyro": "The spin is along the velocity, or all but, or hardly there.",
    "kink": "The ball comes near a kink of a law or of the wind, or crosses it.",
    "loops": "The path loops.",
    "many-digits": "30 digits of work did not decide the outcome or reach the promised radius; "
    "expected.engine says how many did, or how many were tried in vain.",
    "on-ground": "Launched from the ground's own height.",
    "perpendicular": "Ball and bat neither approach nor separate, or hardly.",
    "profile": "A wind that grows with the logarithm of the height.",
    "reading": "A reading of the paper other than the default: see scene.reading.",
    "refused": "The scene has no solution by the contract; the expected result is an error.",
    "rest": "The speed vanishes on the way, or nearly: the equations are not smooth there.",
    "restitution": "The restitution between ball and bat is 0, 1, or above.",
    "second-touching": "After its impact the ball would touch the bat again; the model has one "
    "impact and flies on as if the bat were gone.",
    "tangential": "The ball comes to the ground, or passes it, at a small angle; or its apex is at "
    "the height where a wind sets in.",
    "threshold": "The distance is 150 m, a home run's, within 1e-9 m.",
    "tie": "Two events at the same instant, or within rounding of it.",
    "unconfirmed": "The independent method has another outcome or none, or differs by more than "
    "the radius.",
    "undecided": "The outcome could not be proven; the expected result is an error that says why. "
    "An implementation that answers must say how it knows.",
    "vertex": "The ball passes a corner of the fence, or its end, within 1e-3 down to 1e-15 m.",
    "vertical": "The path is vertical, or passes the vertical.",
    "wide": "A radius is larger than the header promises.",
}


def header(
    cases: Mapping[str, list[Case]], about: Mapping[str, str], histories: Mapping[str, str]
) -> Header:
    """Return the header of a set of families; `about` says what each one is."""
    used = {flag for family in cases.values() for case in family for flag in case.flags}
    return Header(
        title="Longball's golden data: scenes of baseball at-bats with proven results",
        format=FORMAT,
        licence="CC0-1.0",
        numbers=NUMBERS,
        levels=LEVELS,
        flags={flag: FLAGS[flag] for flag in sorted(used)},
        families={
            name: Family(file=f"{name}.jsonl", cases=len(family), about=about[name])
            for name, family in cases.items()
        },
        histories=dict(histories),
        made_by=made_by(),
    )


def made_by() -> dict[str, str]:
    """Return who computes, and the versions of everything that takes part."""
    return {
        "truth": f"{Enclosure(DIGITS).description}, and up to {WORK[-1]} where it takes more",
        "confirmation": f"{Multiprecision(CONFIRMING[0]).description}, and up to {CONFIRMING[-1]} "
        "where it takes more",
        "longball": __version__,
        "python-flint": version("python-flint"),
        "FLINT": flint.__FLINT_VERSION__,
        "mpmath": version("mpmath"),
        "numpy": version("numpy"),
    }
