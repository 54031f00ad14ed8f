"""The ledger and the switches are the same thing, told twice."""

from dataclasses import fields
from typing import get_args, get_type_hints

import pytest

from longball.engines.verlet import Verlet
from longball.home_run import PAPER_CURVES
from longball.model.readings import (
    FIGURE_SWITCH,
    LEDGER,
    SCHEME_OPTIONS,
    Fig7Parameters,
    Reading,
    SamplingReading,
    readings_of,
)
from longball.model.scene import InvalidScene

MODELS = {"scene": Reading, "sampling": SamplingReading}
SWITCHES = {entry.switch: entry for entry in LEDGER if entry.is_switch}
OF_MODELS = {name: entry for name, entry in SWITCHES.items() if entry.belongs in MODELS}


def test_every_switch_has_its_entry():
    assert len({entry.switch for entry in LEDGER}) == len(LEDGER)
    assert set(SWITCHES) == {
        *Reading.model_fields, *SamplingReading.model_fields, *SCHEME_OPTIONS, FIGURE_SWITCH,
    }  # fmt: skip
    # The masses and the friction are no switches but values of a scene.
    assert {entry.switch for entry in LEDGER} - set(SWITCHES) == {"masses", "friction"}


def test_the_options_are_those_of_the_ledger_with_the_default_first():
    for switch, entry in OF_MODELS.items():
        model = MODELS[entry.belongs]
        field = model.model_fields[switch]
        assert str(field.default) == entry.options[0], switch
        if options := get_args(field.annotation):
            assert options == entry.options, switch
        else:
            assert all(model(**{switch: float(option)}) for option in entry.options)


def test_the_switches_of_the_scheme_are_options_of_its_engine():
    for switch, option in SCHEME_OPTIONS.items():
        entry = SWITCHES[switch]
        assert entry.belongs == "scheme", switch
        (field,) = (field for field in fields(Verlet) if field.name == option)
        assert field.default == entry.options[0], switch
        assert get_args(get_type_hints(Verlet)[option]) == entry.options


def test_the_switch_of_the_figure_chooses_a_printed_curve():
    assert SWITCHES[FIGURE_SWITCH].belongs == "figure"
    assert SWITCHES[FIGURE_SWITCH].options == get_args(Fig7Parameters) == tuple(PAPER_CURVES)


def test_a_reading_is_written_only_if_it_differs():
    for switch, entry in OF_MODELS.items():
        if len(entry.options) == 1:
            continue
        default, other, *_ = entry.options
        model = MODELS[entry.belongs]
        convert = str if get_args(model.model_fields[switch].annotation) else float
        assert model(**{switch: convert(default)}).model_dump() == {}
        assert model(**{switch: convert(other)}).model_dump() == {switch: convert(other)}


def test_switches_of_scene_and_sampling_are_told_apart():
    assert readings_of({"inertia": "thin_rod", "cell_width": 0.2}) == (
        Reading(inertia="thin_rod"),
        SamplingReading(cell_width=0.2),
    )
    with pytest.raises(ValueError, match="verlet_forces"):
        readings_of({"verlet_forces": "implicit"})


def test_readings_that_contradict_each_other_are_refused():
    with pytest.raises(InvalidScene, match="plain needs the bat's whole mass"):
        Reading(bat_ball_restitution="plain", reduced_mass="effective_mass")


@pytest.mark.parametrize(
    ("model", "values"),
    [
        (Reading, {"inertia": "rod"}),
        (Reading, {"unknown": 1}),
        (Reading, {"cell_width": 0.2}),
        (SamplingReading, {"inertia": "thin_rod"}),
        (SamplingReading, {"cell_width": 0.0}),
        (SamplingReading, {"offset_spread": float("nan")}),
    ],
)
def test_what_is_no_reading(model, values):
    with pytest.raises(InvalidScene):
        model(**values)
