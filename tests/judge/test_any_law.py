"""Flights under any law: as far as they are looked at, kept, and forgotten where they fail."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from longball.engines.ivp import Ivp
from longball.judge.any_law import ANY_LAW, Effort, Stride
from longball.judge.cases import solved
from longball.judge.explanations import Sought, Work
from longball.judge.fits import implied
from longball.judge.law_mistakes import LAW
from longball.judge.stages import ANY_LAW_ERROR, NONE, Change, follow, trial_of, with_values
from longball.model.frame import launch_frame
from longball.model.law import Law, law_of
from longball.model.numbers import DOUBLES
from tests.judge.material import at_bats, flights, pitches
from tests.judge.test_changed_laws import gold
from tests.judge.test_reasons import answered, result

NEW = {m.name: m.change for m in LAW}


@pytest.mark.parametrize("change", [NONE, NEW["drag-with-v"], NEW["lift-with-v"]])
def test_a_flight_that_is_followed_to_its_time_alone_is_the_same(change: Change):
    for case in solved([*at_bats(8), *flights()[:8], *pitches()[:4]], Ivp()):
        trial = trial_of(case, answered(case, result(case.scene)))
        for only in (("pitch",), ("flight",)):
            whole = {c.quantity: c for c in follow(trial, change)}
            alone = {c.quantity: c for c in follow(trial, change, only) if c.stage in only}
            # Under another law a pitch may not reach the plate, and nothing follows from it.
            assert whole.keys() >= alone.keys() or not whole
            for name, check in alone.items() if whole else ():
                near = pytest.approx(whole[name].expected, rel=ANY_LAW_ERROR, abs=ANY_LAW_ERROR)
                assert check.expected == near


def some_law() -> Law[float]:
    scene = flights()[5]
    return law_of(
        scene, launch_frame(scene.launch.position, scene.launch.velocity, DOUBLES)[0], DOUBLES
    )


def test_a_step_of_which_the_ends_alone_are_known_has_no_state_within():
    a, b = (1.0, 2.0), (3.0, 4.0)
    stride = Stride(0.5, 0.25, a, b)
    assert (stride.at(0.0), stride.at(0.25)) == (a, b)
    begin, end = 1.1, 1.3  # which rounds to another length: 1.3 - 1.1 + 1.1 > 1.3
    assert Stride(begin, math.nextafter(end - begin, 1), a, b).at(end - begin) == b
    with pytest.raises(ValueError, match="no state within a step"):
        stride.at(0.1)


def test_the_last_flights_are_kept_and_a_failing_one_is_not():
    effort, law, made = Effort(), some_law(), []

    def pieces(name: str) -> Iterator[str]:
        made.append(name)
        yield name
        if name == "bad":
            raise OverflowError

    def path(name: str) -> list[str]:
        return [*effort.path(law, (name,), lambda: pieces(name), "kind", 2).pieces()]

    assert path("a") == path("a") == ["a"]
    assert made == ["a"]
    for _ in range(2):
        with pytest.raises(OverflowError):
            path("bad")
    assert made == ["a", "bad", "bad"]
    path("b"), path("c"), path("a")  # of two that are kept the oldest goes
    assert made[3:] == ["b", "c", "a"]
    effort.forget()
    path("c")
    assert made[-1] == "c"


def test_a_step_too_far_leads_back_to_the_number():
    """With a tenth of the spin: the first step of Gauss and Newton goes beyond 0."""
    cases = [c for c in gold("flight-spin-lift")
             if getattr(c.scene.air.lift_coefficient, "law", "") == "rational"]  # fmt: skip
    seen = 0
    for case in cases[:6]:
        spin = case.scene.launch.spin
        wrong = with_values(case.scene, {"launch.spin": tuple(0.1047 * x for x in spin)})
        trial = trial_of(case, answered(case, result(wrong)))
        sought = Sought([trial], [], ("flight",), NONE, Work())
        (value,), left = implied(trial, ["spin"], sought) or ([0.0], 1.0)
        assert value / np.linalg.norm(spin) == pytest.approx(0.1047, rel=1e-6)
        assert left < 1e-6
        seen += 1
    assert seen == 6


def test_any_law_takes_a_flight_to_its_end():
    (case,) = solved(flights()[4:5], Ivp())
    trial = trial_of(case, answered(case, result(case.scene)))
    for c in follow(trial, Change(engine=ANY_LAW)):
        assert c.follows
