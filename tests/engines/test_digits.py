"""The digits that are asked for: reached, or said to be missed."""

import json
from decimal import Decimal

import flint
import mpmath
import pytest

from longball.engines.chain import solve, solve_once, solve_with_path
from longball.engines.digits import shortened
from longball.engines.enclosure import Enclosure
from longball.engines.engine import TooLong
from longball.engines.ivp import Ivp
from longball.engines.multiprecision import Multiprecision
from longball.model.quantities import flat, numbers_of, vector_of
from longball.model.result import Bounded
from longball.model.scene import AtBatScene, PitchScene, parse_scene

# C_L falls by 0.4 where S grows by 0.01: a proven error grows with the force's rate of change.
STEEP = parse_scene(
    json.dumps(
        {
            "kind": "flight",
            "ground": {"height": -0.03},
            "air": {
                "lift_coefficient": {
                    "law": "table",
                    "of": "spin_parameter",
                    "at": [0.0, 0.2, 0.374, 0.384, 0.555],
                    "values": [0.0, 0.178, 0.31, -0.092, 0.489],
                },
                "spin_decay_length": 1000.0,
            },
            "launch": {
                "position": [1.8, 1.2, 24.0],
                "velocity": [24.0, -2.0, 4.0],
                "spin": [0.0, -236.0, 0.0],
            },
        }
    )
)


@pytest.mark.parametrize("digits", [6, 20])
@pytest.mark.sampled(every=2)
def test_where_digits_are_lost_it_works_with_more(digits):
    raw, _ = solve_once(STEEP, Enclosure(digits))
    lost = raw.error or Decimal(raw.landing.distance.radius) > Decimal(10) ** (1 - digits)
    assert lost
    found, way = solve_with_path(STEEP, Enclosure(digits))
    assert found == solve(STEEP, Enclosure(digits))
    assert found.error is None
    assert found.engine == f"enclosure digits={digits + 20}"
    # This engine shares neither steps nor bounds with that of doubles.
    doubles = dict(flat(solve(STEEP, Ivp()).data()))
    numbers = dict(numbers_of(found))
    for name, number in numbers.items():
        size = sum(Decimal(numbers[part].value) ** 2 for part in vector_of(name)).sqrt()
        radius = Decimal(number.radius)
        assert radius <= size * Decimal(10) ** -digits
        # Doubles, too, lose a digit or two of the sixteen that they have.
        off = abs(Decimal(number.value) - Decimal(doubles[name]))
        assert off <= radius + size * Decimal("1e-13")
    assert float(way.end.mid()) == pytest.approx(float(found.landing.time), abs=10.0**-digits)


class Stubborn(Enclosure):
    def finer(self):
        yield Enclosure(self.digits + 1)


def test_digits_that_are_missed_are_said_to_be():
    found = solve(STEEP, Stubborn(20))
    assert found.code == "out_of_range"
    assert found.outcome is found.landing is None
    assert found.error.startswith("landing.")
    assert found.error.endswith("is not proven to 20 digits; take fewer digits")
    assert found.engine == "enclosure digits=21"


@pytest.mark.parametrize(
    ("line", "name"),
    [
        ('{"kind":"at-bat","swing":{"height_offset":3}}', "contact.margin"),
        (
            '{"kind":"flight","launch":{"position":[0,0,1],"velocity":[40,0,25]},'
            '"fence":{"polyline":[[90,80,1e9],[90,-80,1e9]]}}',
            "fence.clearance",
        ),
    ],
    ids=["a bat far above", "a high fence"],
)
@pytest.mark.parametrize("digits", [6, 20])
@pytest.mark.sampled(every=3)
def test_differences_of_lengths_are_no_more_exact_than_themselves(line, name, digits):
    scene = parse_scene(line)
    found = solve(scene, Enclosure(digits))
    assert found.error is None
    assert found.engine == f"enclosure digits={digits}"
    # This engine shares neither steps nor bounds with that of proofs.
    truth = Decimal(dict(numbers_of(solve(scene, Multiprecision(40))))[name].value)
    number = dict(numbers_of(found))[name]
    assert Decimal(number.radius) <= abs(truth) * Decimal(10) ** -digits
    assert abs(Decimal(number.value) - truth) <= Decimal(number.radius)


class Tired(Enclosure):
    def finer(self):
        yield Brief(self.digits + 20)


class Brief(Enclosure):
    def fly(self, law, start, events, limit):
        raise TooLong("the flight takes too many steps")


def test_what_takes_too_long_with_more_digits_is_said_as_it_was_with_fewer():
    found = solve(STEEP, Tired(6))
    assert found.code == "undecided"
    assert "cannot be decided with 6 digits" in found.error
    assert solve(STEEP, Tired(20)).code == "out_of_range"


def test_as_many_digits_as_there_are_have_none_beyond():
    assert [engine.digits for engine in Enclosure(30).finer()] == [50, 90]
    assert [engine.digits for engine in Enclosure(470).finer()] == [490]
    assert not [*Enclosure(500).finer()]
    assert not hasattr(Multiprecision(30), "finer")


def test_a_number_that_is_cut_off_still_contains_the_truth():
    assert shortened(Bounded(value="1.26", radius="0.001"), 1).model_dump() == {
        "value": "1.3",
        "radius": "0.041",
    }


@pytest.mark.parametrize("engine", [Enclosure, Multiprecision])
def test_engines_of_different_digits_do_not_meet(engine):
    few, many = engine(20), engine(40)
    scenes = [AtBatScene(id="a"), PitchScene(id="p")]
    alone = [[solve(scene, each) for scene in scenes] for each in (few, many)]
    before = flint.ctx.prec, mpmath.mp.prec
    for scene, *expected in zip(scenes, *alone, strict=True):
        assert [solve(scene, few), solve(scene, many)] == expected
    assert (flint.ctx.prec, mpmath.mp.prec) == before
    assert len(alone[1][1].plate.time.value) > len(alone[0][1].plate.time.value)
