"""Numbers by their names, on any scene and any result, as models and as plain data."""

import json

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pydantic import ValidationError

from longball.model.quantities import at, flat, nested, number, numbers, replaced
from longball.model.result import Result
from longball.model.scene import AtBatScene, FlightScene, Launch, PitchScene
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


@pytest.mark.parametrize(
    ("name", "nearest"),
    [
        ("pitch.aim.0", "pitch.aim[0]"),
        ("pitch.aim", "pitch.aim[0]"),
        ("pitch.release[3]", "pitch.release[0]"),
        ("speed", "pitch.speed"),
        ("ball.mas", "ball.mass"),
        ("model_fields", ""),
        ("id", ""),
        ("reading.inertia", ""),
    ],
)
def test_the_nearest_is_what_was_meant(name: str, nearest: str):
    with pytest.raises(ValueError, match="the nearest are") as refusal:
        number(AT_BAT, name)
    assert nearest in str(refusal.value)


def test_where_there_is_no_number_none_is_near():
    with pytest.raises(ValueError, match=r"landing\.time is not .*; there are none"):
        number(Result(id="r"), "landing.time")


@pytest.mark.parametrize(
    ("data", "name", "why"),
    [
        ({"pitch": 7}, "pitch.speed", "7 has no speed"),
        ({"aim": []}, "aim[0]", r"\[\] has no \[0\]"),
        ({"aim": [1, 2]}, "aim[01]", r"\[1, 2\] has no \[01\]"),
        ({"pitch": {"aim": 1}}, "pitch.aim[0]", r"1 has no \[0\]"),
        ({}, "pitch..aim", "is not the name of a number"),
    ],
)
def test_what_cannot_be_there(data: dict, name: str, why: str):
    with pytest.raises(ValueError, match=why):
        at(data, name)


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


@pytest.mark.parametrize(
    "names", [("pitch speed",), ("pitch", "pitch.speed"), ("a[0].b", "a[0]", "a[0].c")]
)
def test_names_that_contradict_each_other(names):
    with pytest.raises(ValueError, match=r"is not the name|already"):
        nested(dict.fromkeys(names, 1.0))
