"""Which edits cases notice, beside edits whose effect is known."""

from __future__ import annotations

import json

import numpy as np
import pytest

from longball.engines.ivp import Ivp
from longball.golden import load
from longball.judge import coverage as module
from longball.judge.cases import solved
from longball.judge.coverage import NO_NUMBER, THE_SAME, TOO_SMALL, coverage
from longball.judge.diagnosis.chain import CHAIN, I, area
from longball.judge.diagnosis.expression import constant, function, named
from longball.judge.diagnosis.operators import Edit
from longball.model.scene import parse_scene


@pytest.fixture
def noticed(monkeypatch):
    """Return a function from an edit and cases to the ids that notice it, or why none does."""

    def found(edit: Edit, cases) -> set[str] | str:
        (stage, *_) = [s for s in CHAIN if s.edited(edit.place, edit.new) is not s]
        monkeypatch.setattr(module, "every_edit", lambda every: [(stage, edit)])
        monkeypatch.setattr(module, "LIMITS", ())
        covered = coverage(cases)
        if covered.unnoticed:
            ((_, _, why),) = covered.unnoticed
            return why
        return {c.id for c, seen in zip(covered.cases, covered.noticed[0], strict=True) if seen}

    return found


def edit(place, by) -> Edit:
    return Edit(place, by, 0.0, "")


def test_an_edit_is_noticed_where_its_number_is_used(noticed):
    cases = [*load("flight-vacuum")[:4], *load("flight-drag")[:4], *load("impact")[:4]]
    air = {case.id for case in cases[4:8]}
    assert noticed(edit(area, 4.0 * area), cases) == air
    everything = noticed(edit(I["g"], 1.1 * I["g"]), cases)
    assert everything == {case.id for case in cases[:8]}
    struck = {c.id for c in cases[8:] if c.expected.impact is not None}
    assert struck <= noticed(edit(I["M"], 1.1 * I["M"]), cases)


def test_why_an_edit_is_not_noticed(noticed):
    cases = load("flight-drag")[:4]
    size = function("abs", I["m"], dimension=I["m"].dimension)
    assert noticed(edit(I["m"], size), cases) == THE_SAME
    assert noticed(edit(I["m"], I["M"]), cases) == NO_NUMBER  # a flight has no bat
    assert noticed(edit(I["m"], (1.0 + 1e-14) * I["m"]), cases) in (THE_SAME, TOO_SMALL)


def test_the_end_of_a_flight_moves_about_as_much_as_it_does(noticed):
    """A hundredth of the threshold is not noticed, a hundred times is."""
    case = load("flight-both")[0]
    slope = abs(case.condition.derivatives["landing.distance"]["gravity"])
    distance = case.quantities["landing.distance"].double
    step = max(1e3 * case.attainable("landing.distance"), module.SEEN * distance) / slope
    assert noticed(edit(I["g"], I["g"] + constant(100 * step, I["g"].dimension)), [case])
    little = edit(I["g"], I["g"] + constant(step / 100, I["g"].dimension))
    assert noticed(little, [case]) in (TOO_SMALL, THE_SAME)


def test_time_limits():
    scenes = {
        "cut": ('"time_limit":5.5', "cuts the time limit to whole seconds", True),
        "whole": ('"time_limit":6.0', "cuts the time limit to whole seconds", False),
        "late": ('"time_limit":5.1', "uses twice the time limit", True),
    }
    for text, words, seen in scenes.values():
        line = f'{{"kind":"flight",{text},"launch":{{"position":[0,0,1],"velocity":[30,0,25]}}}}'
        (case,) = solved([parse_scene(line)], Ivp())
        (limit,) = [one for one in module.LIMITS if one.words == words]
        assert limit.notices(case) is seen


def test_edits_of_the_same_effect_count_once(monkeypatch):
    both = [edit(area, 4.0 * area), edit(I["R"], named("2R", 2.0 * I["R"]))]
    (flight,) = [s for s in CHAIN if s.name == "flight"]
    monkeypatch.setattr(module, "every_edit", lambda every: [(flight, one) for one in both])
    monkeypatch.setattr(module, "LIMITS", ())
    found = coverage(load("flight-drag")[:4])
    assert len(found.edits) == 1
    assert np.array_equal(found.noticed, [[True] * 4])


def test_the_command_tells_what_own_scenes_miss(called, tmp_path, monkeypatch):
    (flight,) = [s for s in CHAIN if s.name == "flight"]
    (swung,) = [s for s in CHAIN if s.name == "bat velocity"]
    tried = [(flight, edit(I["g"], 1.1 * I["g"])), (swung, edit(I["L"], 1.1 * I["L"]))]
    monkeypatch.setattr(module, "every_edit", lambda every: tried)
    monkeypatch.setattr(module, "LIMITS", ())
    monkeypatch.setattr("longball.golden.reader.load", lambda name: load("impact")[:3])
    own = tmp_path / "own.jsonl"
    own.write_text('{"kind":"flight","launch":{"position":[0,0,1],"velocity":[30,0,20]}}\n')
    found = called("golden", "coverage", own, "--json")
    told = json.loads(found.stdout)
    assert [(one["stage"], one["noticed"]) for one in told["stages"]] == [
        ("bat velocity", 0), ("flight", 1),
    ]  # fmt: skip
    assert [one["case"] for one in told["missed"]] == ["impact-0000"]
    shown = called("golden", "coverage", own)
    assert "bat velocity:  (impact-0000)" in shown.stdout
    assert "1 scene: 1 of 2 edits detected" in shown.stderr
