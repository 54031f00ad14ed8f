"""The ledger and the switches are the same thing, told twice."""

from typing import get_args

import pytest
from pydantic import ValidationError

from longball.model.readings import LEDGER, Reading
from longball.model.scene import Ball, Bat

SWITCHES = {entry.switch: entry for entry in LEDGER if entry.switch in Reading.model_fields}


def test_every_switch_has_its_entry():
    assert len({entry.switch for entry in LEDGER}) == len(LEDGER)
    assert set(SWITCHES) == set(Reading.model_fields)
    # The masses are no switch but values of a scene.
    assert {entry.switch for entry in LEDGER} - set(SWITCHES) == {"masses"}


@pytest.mark.parametrize("switch", Reading.model_fields)
def test_the_options_are_those_of_the_ledger_with_the_default_first(switch):
    field, entry = Reading.model_fields[switch], SWITCHES[switch]
    assert str(field.default) == entry.options[0]
    if options := get_args(field.annotation):
        assert options == entry.options
    else:
        assert all(Reading(**{switch: float(option)}) for option in entry.options)


def test_the_masses_of_the_ledger_are_the_scenes():
    (entry,) = (entry for entry in LEDGER if entry.switch == "masses")
    assert entry.options == (f"ball.mass = {Ball().mass}, bat.mass = {Bat().mass}",)


@pytest.mark.parametrize("entry", LEDGER, ids=lambda entry: entry.switch)
def test_every_entry_says_where_and_why(entry):
    assert entry.place
    assert entry.why.endswith((".", "?"))


@pytest.mark.parametrize("switch", [s for s, e in SWITCHES.items() if len(e.options) > 1])
def test_a_reading_is_written_only_if_it_differs(switch):
    default, other, *_ = SWITCHES[switch].options
    convert = str if get_args(Reading.model_fields[switch].annotation) else float
    assert Reading(**{switch: convert(default)}).model_dump() == {}
    assert Reading(**{switch: convert(other)}).model_dump() == {switch: convert(other)}


def test_readings_that_contradict_each_other_are_refused():
    with pytest.raises(ValidationError, match="plain takes the bat's whole mass"):
        Reading(bat_ball_restitution="plain", reduced_mass="effective_mass")


@pytest.mark.parametrize(
    "values",
    [{"inertia": "rod"}, {"unknown": 1}, {"cell_width": 0.0}, {"offset_spread": float("nan")}],
)
def test_what_is_no_reading(values):
    with pytest.raises(ValidationError):
        Reading(**values)
