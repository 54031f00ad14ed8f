"""The families of real baseball: what they hold, and that it is consistent."""

import math

import numpy as np
import pytest

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.golden.reader import EXTENDED
from tests.scenes import cases_of

CASES = {family: cases_of(family) for family in EXTENDED}
IMPACTS, FENCES, KINKS = (CASES[name] for name in ("impact-oblique", "fence", "flight-kinks"))


def flagged(cases, flag):
    return [case for case in cases if flag in case.flags]


@pytest.mark.parametrize("family", EXTENDED)
def test_there_are_enough_and_all_are_proven_and_confirmed(family):
    few = family in ("hard-real", "defaults", "various-real")  # with no law of their own
    assert len(CASES[family]) >= (30 if few else 40)
    for case in CASES[family]:
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


# --- hard cases -----------------------------------------------------------------------------------


def test_the_hard_cases_are_there():
    """Where engines break, by the flags; the others have tests of their own."""
    hard = {case.id.removeprefix("hard-real-"): case for case in CASES["hard-real"]}
    for name in ("gyro-forward-30", "gyro-backward-30"):
        launch = hard[name].scene.launch
        along = np.dot(launch.velocity, launch.spin) / math.hypot(*launch.velocity)
        assert abs(along) == pytest.approx(math.hypot(*launch.spin), rel=1e-4)
    # The spin stays parallel to a vertical flight: it lands where it was launched.
    assert float(hard["parallel-up-30"].expected.landing.distance) == 0
    for name in ("tail-wind-5", "tail-wind-20"):
        # It drifts with the wind, rises, and stops in the air.
        scene = hard[name].scene
        assert scene.air.wind[0] == scene.launch.velocity[0]
        assert scene.launch.velocity[2] > 0
    assert len(flagged(FENCES, "vertex")) >= 4
    names = {case.id.removeprefix("flight-kinks-") for case in KINKS}
    for node in ("speed-node", "spin-node", "wind"):
        assert {f"{node}-{side}-1e-12" for side in ("above", "below")} | {f"{node}-at"} <= names


# --- kinks ----------------------------------------------------------------------------------------


def test_doubles_decide_a_touch_of_a_node_but_not_of_a_wind():
    """On both sides of a node forces are the same; where a wind sets in, they jump."""
    by_name = {case.id.removeprefix("flight-kinks-"): case for case in KINKS}
    for name in ("speed-node-at", "spin-node-at"):
        found, true = (solve(by_name[name].scene, Ivp()), by_name[name].expected)
        expected = [float(x) for x in true.landing.position]
        assert found.landing.position == pytest.approx(expected, abs=1e-12)
    assert solve(by_name["wind-at"].scene, Ivp()).code == "undecided"
