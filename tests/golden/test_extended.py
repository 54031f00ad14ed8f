"""The families of oblique impacts and fences: what they hold, and that it is consistent."""

import pytest

from longball import golden

IMPACTS, FENCES = golden.load("impact-oblique"), golden.load("fence")


def flagged(cases, flag):
    return [case for case in cases if flag in case.flags]


@pytest.mark.parametrize("cases", [IMPACTS, FENCES], ids=["impacts", "fences"])
def test_there_are_enough_and_all_are_proven_and_confirmed(cases):
    assert len(cases) >= 40
    for case in cases:
        assert not {"unconfirmed", "wide"} & set(case.flags), case.id
        assert (case.expected.outcome is None) is bool({"refused", "undecided"} & set(case.flags))


def test_the_friction_margin_tells_grip_from_slide():
    modes = set()
    for case in IMPACTS:
        impact = case.expected.impact
        if impact is not None:
            modes.add(impact.mode)
            if impact.mode != "frictionless":
                assert (float(impact.friction_margin) > 0) is (impact.mode == "grip")
    assert modes == {"grip", "slide", "frictionless"}
    close = [abs(float(c.expected.impact.friction_margin)) for c in flagged(IMPACTS, "grip-slide")]
    assert sum(margin < 1.1e-12 for margin in close) >= 6


def test_known_impacts():
    by_name = {case.id.removeprefix("impact-oblique-"): case.expected for case in IMPACTS}
    for name in ("superball", "no-rub"):
        assert abs(float(by_name[name].impact.energy_change)) < 1e-27
    assert float(by_name["created"].impact.energy_change) > 0
    assert "jam" in by_name["disc-jams"].error
    assert float(by_name["about-the-normal"].impact.spin[0]) == 250
    for name in ("at-bat-under", "at-bat-over", "at-bat-slides"):
        assert by_name[name].landing.spin is not None


def test_the_clearance_tells_a_home_run_from_a_wall():
    outcomes = set()
    for case in FENCES:
        met = case.expected.fence
        if met is not None and case.expected.outcome is not None:
            outcomes.add(case.expected.outcome)
            assert (float(met.clearance) > 0) is (case.expected.outcome != "wall"), case.id
    assert outcomes == {"home_run", "wall", "landed"}  # landed: over the fence, but foul
    foul = next(case.expected for case in FENCES if case.id == "fence-foul")
    assert (foul.outcome, foul.landing.fair) == ("landed", False)


def test_balls_are_blown_back():
    cases = flagged(FENCES, "blown-back")
    assert len(cases) == 4
    for case in cases:
        assert case.expected.outcome == "home_run"
        assert float(case.expected.landing.position[0]) < float(case.expected.fence.position[0]) - 3


def test_the_papers_rule_as_a_circle():
    for case in FENCES:
        if case.id.startswith("fence-circle"):
            over = case.expected.outcome == "home_run"
            assert over is (float(case.expected.landing.distance) >= 150)
