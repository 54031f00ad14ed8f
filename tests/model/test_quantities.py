"""Numbers by their names, on any scene and any result, as models and as plain data."""

import json

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pydantic import ValidationError

from longball.model.quantities import at, flat, nested, number, numbers, replaced
from longball.model.result import Result
from longball.model.scene import AtBatScene, FlightScene, Launch, PitchScene
from tests.calls import check_wrong_calls
from tests.scenes import results, scenes

blocks = scenes() | results()


def a_name(draw, block):
    """One of the names in a block, which must have some."""
    names = [name for name, _ in numbers(block)]
    assume(names)
    return draw.draw(st.sampled_from(names))


@given(blocks)
def test_every_name_leads_to_its_number(block):
    found = list(numbers(block))
    assert len({name for name, _ in found}) == len(found)
    for name, value in found:
        assert number(block, name) is value


@given(blocks)
def test_to_replace_every_number_by_itself_changes_nothing(block):
    assert replaced(block, dict(numbers(block))) == block


@given(blocks, st.floats(-100.0, 100.0), st.data())
def test_what_is_replaced_can_be_read_back_and_nothing_else_changes(block, value, draw):
    name = a_name(draw, block)
    try:
        other = replaced(block, {name: value})
    except ValidationError:  # validated anew: not every number makes a scene
        assert not isinstance(block, Result)
        return
    assert type(other) is type(block)
    assert dict(numbers(other)) == dict(numbers(block)) | {name: value}


@given(blocks, st.data())
def test_an_unknown_name_is_refused_with_the_nearest(block, draw):
    name = a_name(draw, block)
    place = draw.draw(st.integers(0, len(name) - 1))
    names = [known for known, _ in numbers(block)]
    wrong = name[:place] + draw.draw(st.sampled_from(["", "q"])) + name[place + 1 :]
    assume(wrong not in names)
    for refuse in (lambda: number(block, wrong), lambda: replaced(block, {wrong: 1.0})):
        with pytest.raises(ValueError, match="is not the name of a number here") as refusal:
            refuse()
        nearest = str(refusal.value).partition("the nearest are ")[2].split(", ")
        assert set(nearest) <= set(names)
        assert len(nearest) == min(3, len(names))


AT_BAT = AtBatScene(id="a")


WRONG = r"""
# the nearest is what was meant
number(AT_BAT, "pitch.aim.0") -> the nearest are .*pitch\.aim\[0\]
number(AT_BAT, "pitch.aim") -> the nearest are .*pitch\.aim\[0\]
number(AT_BAT, "pitch.release[3]") -> the nearest are .*pitch\.release\[0\]
number(AT_BAT, "speed") -> the nearest are .*pitch\.speed
number(AT_BAT, "ball.mas") -> the nearest are .*ball\.mass
number(AT_BAT, "model_fields") -> the nearest are
number(AT_BAT, "id") -> the nearest are
number(AT_BAT, "reading.inertia") -> the nearest are
number(Result(id="r"), "landing.time") -> landing\.time is not .*; there are none
# what cannot be there
at({"pitch": 7}, "pitch.speed") -> 7 has no speed
at({"aim": []}, "aim[0]") -> \[\] has no \[0\]
at({"aim": [1, 2]}, "aim[01]") -> \[1, 2\] has no \[01\]
at({"pitch": {"aim": 1}}, "pitch.aim[0]") -> 1 has no \[0\]
at({}, "pitch..aim") -> is not the name of a number
# names that contradict each other
nested({"pitch speed": 1.0}) -> is not the name
nested({"pitch": 1.0, "pitch.speed": 1.0}) -> already
nested({"a[0].b": 1.0, "a[0]": 1.0, "a[0].c": 1.0}) -> already
"""


def test_what_is_no_name_says_why():
    check_wrong_calls(WRONG, globals())


def test_what_is_left_out_is_none():
    assert at({}, "pitch.aim[0]") is None
    assert at({"pitch": {"aim": None}}, "pitch.aim[0]") is None
    assert at(AtBatScene(id="a", air=None), "air.density") is None
    assert at({"pitch": {"aim": ["x", True]}}, "pitch.aim[0]") == "x"


def test_numbers_are_put_in_together_and_validated():
    low = FlightScene(id="f", launch=Launch(position=(0.0, 0.0, 0.0), velocity=(1.0, 0.0, 0.0)))
    both = {"ground.height": 2.0, "launch.position[2]": 3.0}
    assert replaced(low, both).launch.position == (0.0, 0.0, 3.0)
    with pytest.raises(ValidationError, match="underground"):
        replaced(low, {"ground.height": 2.0})
    with pytest.raises(ValidationError, match="greater than or equal"):
        replaced(AT_BAT, {"ball.mass": -1.0})


@given(blocks)
def test_flat_data_are_nested_again(block):
    data = json.loads(block.model_dump_json(exclude_none=True, exclude_defaults=True))
    assume(data)
    assert nested(dict(flat(data))) == data


def test_vectors_named_in_part_are_completed():
    pitch = PitchScene()
    assert nested({"pitch.aim[1]": 1.5}, pitch) == {"pitch": {"aim": [0.0, 1.5]}}
    assert nested({"launch.position[1]": 1.5}, pitch) == {"launch": {"position": [None, 1.5]}}
