"""Contents of results, and their written form."""

import json
from itertools import product

import pytest
from pydantic import ValidationError

from longball.model.result import (
    Bounded,
    Certified,
    Contact,
    Result,
)


def read(**values):
    return Result.model_validate_json(json.dumps({"id": "a"} | values))


def test_only_what_is_known_is_written():
    result = Result(id="a", outcome="missed", contact=Contact(margin=-0.01))
    assert result.line() == '{"id": "a", "outcome": "missed", "contact": {"margin": -0.01}}'


def test_a_line_without_an_id_has_a_null_for_it():
    assert Result(id=None, error="not JSON").line() == '{"id": null, "error": "not JSON"}'


def test_doubles_are_written_exactly():
    for x in (0.1, 1 / 3, 5e-324, 1.7976931348623157e308, -0.0, 123456789.123456789):
        (written,) = json.loads(Result(id="a", contact=Contact(margin=x)).line())[
            "contact"
        ].values()
        assert written.hex() == x.hex()


def test_numbers_with_digits_and_radius():
    values = "1", "-1.5", "+0.25", "1e10", "1.25E-400", "0" * 90 + ".5"
    for value, radius in product(values, (None, "0", "1.5e-45")):
        result = read(contact={"margin": {"value": value, "radius": radius}})
        assert result.contact.margin == Bounded(value=value, radius=radius)
        assert float(result.contact.margin) == float(value)
        # A radius that is not proven is null, and not left out.
        assert json.loads(result.line())["contact"]["margin"] == {"value": value, "radius": radius}


def test_a_double_with_a_radius():
    result = read(contact={"margin": {"value": 0.1, "radius": "2.3e-17"}})
    assert result.contact.margin == Certified(value=0.1, radius="2.3e-17")
    assert float(result.contact.margin) == 0.1
    assert result.line().endswith('{"margin": {"value": 0.1, "radius": "2.3e-17"}}}')


def test_what_is_no_number():
    for number in (
        "1.0", True, [], float("nan"), float("inf"), {"radius": "1"}, {"value": 1.0},
        {"value": "nan"}, {"value": "1,5"}, {"value": "0x1p3"}, {"value": ".5"}, {"value": ""},
        {"value": "1\n"}, {"value": "\u0663"}, {"value": "1", "radius": "-1"},
        {"value": "1", "radius": 0.5}, {"value": "1", "digits": 3},
        {"value": 1.0, "radius": None}, {"value": float("inf"), "radius": "1"},
        {"value": 1.0, "radius": "inf"}, {"value": 1.0, "radius": 1.0},
    ):  # fmt: skip
        with pytest.raises(ValidationError):
            read(contact={"margin": number})


@pytest.mark.parametrize(
    "values",
    [
        {"outcome": "hit"},
        {"plate": {"time": 1.0}},
        {"landing": {}},
        {"plate": {"time": 1.0, "position": [1, 2], "velocity": [1, 2, 3]}},
        {"extra": 1},
        {"id": 1},
        {"error": 1},
        {"error": "odd", "code": "odd"},
    ],
)
def test_what_is_no_result(values):
    with pytest.raises(ValidationError):
        read(**values)


def test_the_id_is_always_there():
    with pytest.raises(ValidationError):
        Result.model_validate_json('{"outcome": "missed"}')
