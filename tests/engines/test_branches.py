"""A quantity of a state goes by the branch of the law that is valid in that state.

Truth is the equation of motion written out below and integrated by SciPy, which stops where the
wind sets in and goes on with the other wind.
"""

import json
import math

import numpy as np
import pytest
import scipy.integrate

from longball.engines.batch import Batch
from longball.engines.branches import arrived, branches_at
from longball.engines.chain import solve, solve_with_path
from longball.engines.enclosure import Enclosure
from longball.engines.ivp import Ivp
from longball.engines.multiprecision import Multiprecision
from longball.engines.verlet import Verlet
from longball.model.frame import launch_frame
from longball.model.law import law_of
from longball.model.numbers import DOUBLES, Undecided
from longball.model.scene import parse_scene

MASS, RADIUS, DENSITY = 0.145, 0.0366, 1.29
UNIT = DENSITY * math.pi * RADIUS**2 / (2 * MASS)
UP = np.array([0.0, 0.0, 1.0])

# SciPy's steps are off by 1e-12 each, of which a flight takes some hundred. Verlet's scheme takes
# the step that passes a switch by the law before it: 1 ms times a jump of some 10 m/s².
ENGINES = [
    pytest.param(Ivp(), 1e-9, id="ivp"),
    pytest.param(Batch(), 1e-9, id="batch"),
    pytest.param(Multiprecision(10), 1e-9, id="multiprecision"),
    pytest.param(Enclosure(20), 1e-9, id="enclosure"),
    pytest.param(Verlet(1e-3, forces="implicit"), 1e-2, id="verlet"),
]
all_engines = pytest.mark.parametrize(("engine", "error"), ENGINES)


def flown(position, velocity, spin, wind, above, ends, lift=lambda S: S, decay=None, aloft=None,
          longest=0.1):  # fmt: skip
    """Time, position, velocity and spin of a ball in a wind above a height, where `ends` falls.

    C_D is 0.4, and C_L by the spin parameter. A `decay` is Nathan's: e^(-t U/decay) with the
    present airspeed U.
    """
    spin, wind = np.array(spin, float), np.array(wind, float)

    def left(t, u):
        return 1.0 if decay is None else math.exp(-t * np.linalg.norm(u) / decay)

    def rates(t, y, blowing):
        u = y[3:] - blowing * wind
        speed, now = np.linalg.norm(u), spin * left(t, u)
        across = np.cross(now, u)
        drag = -UNIT * 0.4 * speed * u
        size = np.linalg.norm(across)
        lifted = UNIT * lift(RADIUS * size / speed**2) * speed**2 * across / size if size else 0.0
        return [*y[3:], *(drag + lifted - 9.8 * UP)]

    def height(t, y, blowing):
        return y[2] - above

    def end(t, y, blowing):
        return ends(y)

    end.terminal, end.direction, height.terminal = True, -1, True
    t, y = 0.0, np.array([*position, *velocity], float)
    blowing = y[2] > above if aloft is None else aloft
    while True:
        height.direction = -1 if blowing else 1
        step = scipy.integrate.solve_ivp(
            rates, (t, 60.0), y, "DOP853", args=(blowing,), events=[end, height],
            rtol=1e-12, atol=1e-12, max_step=longest,
        )  # fmt: skip
        t, y = step.t[-1], step.y[:, -1]
        if step.t_events[0].size:
            return t, y[:3], y[3:], spin * left(t, y[3:] - blowing * wind)
        assert t < 60.0
        blowing = not blowing


def flight(position, velocity, spin=None, above=0.5, wind=(15.0, 0.0, 0.0), floor=0.0, **keys):
    launch = {"position": position, "velocity": velocity} | ({"spin": spin} if spin else {})
    air = {"lift_coefficient": {"law": "linear"}} | keys.pop("air", {})
    air["wind"] = {"velocity": wind, "above": above}
    whole = {"kind": "flight", "launch": launch, "air": air, "ground": {"height": floor}}
    return parse_scene(json.dumps(whole | keys))


def landed(scene, engine):
    result = solve(scene, engine)
    assert result.error is None
    found = result.landing
    spin = None if found.spin is None else [*map(float, found.spin)]
    return float(found.time), [*map(float, found.position)], [*map(float, found.velocity)], spin


NATHAN = {"air": {"spin_decay_length": 100.0}, "reading": {"spin_decay": "nathan"}}


# --- spin -----------------------------------------------------------------------------------------


@all_engines
@pytest.mark.parametrize(
    ("floor", "above"), [(1.0, 0.5), (0.5, 0.5), (0.0, 0.5)], ids=["aloft", "tie", "calm"]
)
@pytest.mark.sampled(every=2)
def test_the_spin_at_the_landing_has_the_wind_that_the_ball_came_through(
    engine, error, floor, above
):
    """On ground at the height above which the wind blows, the ball comes from above."""
    start = (0.0, 0.0, 2.0), (20.0, 0.0, 20.0), (0.0, -100.0, 0.0)
    time, place, velocity, spin = flown(
        *start, (15.0, 0.0, 0.0), above, lambda y: y[2] - floor, decay=100.0
    )
    found = landed(flight(*start, above=above, floor=floor, **NATHAN), engine)
    assert found[0] == pytest.approx(time, rel=error)
    assert found[1] == pytest.approx(place, rel=error, abs=100 * error)
    assert found[2] == pytest.approx(velocity, rel=error, abs=100 * error)
    assert found[3] == pytest.approx(spin, rel=error)


PITCHED = (18.44, 0.0, 1.8), (-40.0, 0.0, 0.0), (0.0, -100.0, 0.0)
ALOFT, DECAY = (10.0, 0.0, 0.0), 300.0


@pytest.fixture(scope="module")
def met():
    """Time, position, velocity and spin of a pitch that stays in the wind, at the contact."""
    _, plate, _, _ = flown(*PITCHED, ALOFT, -1.0, lambda y: y[0], decay=DECAY)

    def gap(y):
        return math.hypot(y[0], y[2] - plate[2]) - (RADIUS + 0.033)

    # Steps of 4 cm do not pass the bat.
    return flown(*PITCHED, ALOFT, -1.0, gap, decay=DECAY, longest=1e-3)


@all_engines
def test_the_spin_at_the_contact_has_the_wind_there(engine, error, met):
    """The pitch stays in the wind up to the contact: what the height is does not matter."""
    time, place, _, there = met
    pitch = {"velocity": PITCHED[1], "spin": PITCHED[2]}
    air = {"lift_coefficient": {"law": "linear"}, "spin_decay_length": DECAY}
    scene = {"kind": "at-bat", "pitch": pitch, "air": air, "reading": {"spin_decay": "nathan"}}
    air["wind"] = {"velocity": ALOFT, "above": 0.1}
    result = solve(parse_scene(json.dumps(scene)), engine)
    assert place[2] > 0.11
    assert [*map(float, result.contact.position)] == pytest.approx(place, abs=10 * error)
    if result.contact.time is not None:
        assert float(result.contact.time) == pytest.approx(time, rel=error)
    # Without friction the spin passes through the impact.
    assert [*map(float, result.impact.spin)] == pytest.approx(there, rel=error)


@all_engines
def test_the_spin_falls_at_once_where_the_wind_sets_in(engine, error):
    """A lift with a kink of S is searched for where S passes it, with the spin on either side."""
    start = (0.0, 0.0, 2.0), (25.0, 0.0, 10.0), (0.0, -150.0, 0.0)
    time, place, velocity, spin = flown(
        *start, (15.0, 0.0, 0.0), 4.0, lambda y: y[2], decay=100.0,
        lift=lambda S: min(1.5 * S, 0.09 + 0.6 * S),
    )  # fmt: skip
    air = NATHAN["air"] | {"lift_coefficient": {"law": "bilinear"}}
    found = landed(flight(*start, above=4.0, **NATHAN | {"air": air}), engine)
    assert found[0] == pytest.approx(time, rel=error)
    assert found[1] == pytest.approx(place, rel=error, abs=100 * error)
    assert found[2] == pytest.approx(velocity, rel=error, abs=100 * error)
    assert found[3] == pytest.approx(spin, rel=error)


def test_within_the_error_of_the_switch_the_spin_is_undecided():
    scene = flight((0.0, 0.0, 2.0), (20.0, 0.0, 20.0), (0.0, -100.0, 0.0), **NATHAN)
    spin = scene.launch.spin
    frame, start = launch_frame((0.0, 0.0, 2.0), (20.0, 0.0, 20.0), DOUBLES, spin)
    law = law_of(scene, frame, DOUBLES)
    near = law.state_of(start)._replace(z=math.nextafter(0.5, 1.0), w=-1.0)
    with pytest.raises(Undecided, match="passes the height above which the wind blows"):
        arrived(law, near, DOUBLES, 1e-14)
    assert arrived(law, near, DOUBLES, 0.0).form == (1,)
    for w, entered, left in ((1.0, 1, 0), (0.0, 0, 0), (-1.0, 0, 1)):
        on = near._replace(z=0.5, w=w)
        assert branches_at(law, on, DOUBLES) == [entered]
        assert arrived(law, on, DOUBLES, 1e-14).form == (left,)


def test_a_spin_that_does_not_depend_on_the_wind_is_decided_anywhere():
    scene = flight(
        (0.0, 0.0, 2.0), (20.0, 0.0, 20.0), (0.0, -100.0, 0.0), air={"spin_decay_length": 100.0}
    )
    frame, start = launch_frame((0.0, 0.0, 2.0), (20.0, 0.0, 20.0), DOUBLES, scene.launch.spin)
    law = law_of(scene, frame, DOUBLES)
    assert not law.bends_of_spin
    assert arrived(law, law.state_of(start)._replace(z=0.5), DOUBLES, 1e-14).form == (0,)


# --- forces ---------------------------------------------------------------------------------------


@all_engines
def test_straight_up_in_an_air_that_rises_faster(engine, error):
    start = (0.0, 0.0, 2.0), (0.0, 0.0, 3.0)
    time, _, velocity, _ = flown(*start, (0, 0, 0), (0.0, 0.0, 5.0), 1.0, lambda y: y[2])
    air = {"lift_coefficient": 0.0}
    found = landed(flight(*start, wind=(0.0, 0.0, 5.0), above=1.0, air=air), engine)
    assert found[0] == pytest.approx(time, rel=error)
    assert found[2] == pytest.approx(velocity, rel=error)


SPEEDS, DRAGS = (10.0, 20.0, 30.0, 45.0), (0.9, 0.5, 0.3, 0.6)


@pytest.fixture(scope="module")
def fallen():
    """Time and velocity of a ball straight up and down: w' = -g - k C_D(|w|) |w| w."""

    def rates(t, y):
        return y[1], -9.8 - UNIT * np.interp(abs(y[1]), SPEEDS, DRAGS) * abs(y[1]) * y[1]

    def ground(t, y):
        return y[0]

    ground.terminal, ground.direction = True, -1
    fall = scipy.integrate.solve_ivp(
        rates, (0.0, 60.0), (1.0, 40.0), "DOP853", rtol=1e-12, atol=1e-12, max_step=1e-3,
        events=ground,
    )  # fmt: skip
    return fall.t[-1], fall.y[1, -1]


@all_engines
def test_a_lift_that_is_always_up_keeps_the_tables_of_the_drag(engine, error, fallen):
    """A ball straight up flies without lift."""
    table = {"law": "table", "of": "speed", "at": SPEEDS, "values": DRAGS}
    scene = {
        "kind": "flight", "launch": {"position": (0.0, 0.0, 1.0), "velocity": (0.0, 0.0, 40.0)},
        "air": {"drag_coefficient": table}, "reading": {"lift_direction": "always_up"},
    }  # fmt: skip
    found = landed(parse_scene(json.dumps(scene)), engine)
    time, velocity = fallen
    assert found[0] == pytest.approx(time, rel=error)
    assert found[2][2] == pytest.approx(velocity, rel=error)


def test_steps_that_push_the_ball_take_the_drag_of_its_speed():
    """Verlet's bat pushes for two steps: in the air as it is there, by a table, as by a number."""
    swung = {"kind": "at-bat", "swing": {"height_offset": -0.03}}
    # A table that is 0.4 wherever the ball is, and else is not.
    table = {"law": "table", "of": "speed", "at": (1.0, 2.0), "values": (9.0, 0.4)}
    found = [
        solve(parse_scene(json.dumps(swung | {"air": {"drag_coefficient": drag}})), Verlet(1e-4))
        for drag in (0.4, table)
    ]
    number, tabled = (result.landing for result in found)
    # Roundings: 0.4 is the end of a line.
    assert tabled.position == pytest.approx(number.position, abs=1e-9)


# --- on a surface ---------------------------------------------------------------------------------

THIN = {"density_scale_height": 8500.0, "lift_coefficient": 0.0}


@all_engines
@pytest.mark.parametrize("climb", [17.0, -17.0])
@pytest.mark.sampled(every=3)
def test_a_launch_from_the_ground_goes_by_its_velocity(engine, error, climb):
    """Also where heights are uncertain by the rounding of another number of the launch."""
    launch = {"position": (1.0, 0.0, 0.0), "velocity": (12.0, 9.5, climb)}
    scene = parse_scene(json.dumps({"kind": "flight", "launch": launch, "air": THIN}))

    def rates(t, y):
        drag = UNIT * 0.4 * math.exp(-y[2] / 8500.0)
        return [*y[3:], *(-drag * np.linalg.norm(y[3:]) * y[3:] - 9.8 * UP)]

    def ground(t, y):
        return y[2]

    ground.terminal, ground.direction = True, -1
    path = scipy.integrate.solve_ivp(
        rates, (0.0, 9.0), (1.0, 0.0, 0.0, 12.0, 9.5, 17.0), "DOP853", rtol=1e-12, atol=1e-12,
        events=ground,
    )  # fmt: skip
    time, place, _, _ = landed(scene, engine)
    assert time == pytest.approx(path.t[-1] if climb > 0 else 0.0, rel=error)
    assert place == pytest.approx(path.y[:3, -1] if climb > 0 else (1, 0, 0), abs=100 * error)


@all_engines
@pytest.mark.parametrize("climb", [6.0, 0.0, -6.0])
@pytest.mark.sampled(every=2)
def test_a_launch_from_where_the_wind_sets_in_goes_by_its_velocity(engine, error, climb):
    """Upwards into the wind, else into the calm; a level one falls."""
    start = (0.0, 0.0, 1.0), (30.0, 0.0, climb)
    time, place, _, _ = flown(
        *start, (0, 0, 0), (9.0, 3.0, 0.0), 1.0, lambda y: y[2], aloft=climb > 0
    )
    air = {"lift_coefficient": 0.0}
    found = landed(flight(*start, wind=(9.0, 3.0, 0.0), above=1.0, air=air), engine)
    assert found[0] == pytest.approx(time, rel=error)
    assert found[1] == pytest.approx(place, rel=error, abs=100 * error)


@all_engines
def test_a_ball_that_stays_at_that_height_is_in_the_calm(engine, error):
    launch = {"position": (0.0, 0.0, 1.0), "velocity": (30.0, 0.0, 0.0)}
    air = {"lift_coefficient": 0.0, "wind": {"velocity": (25.0, 0.0, 0.0), "above": 1.0}}
    scene = {"kind": "flight", "launch": launch, "air": air, "gravity": 0.0, "time_limit": 2.0}
    result, way = solve_with_path(parse_scene(json.dumps(scene)), engine)
    if isinstance(engine, Enclosure):  # which knows the height to within its error only
        assert result.code == "undecided"
        return
    assert result.outcome == "airborne"
    with engine.numbers.arithmetic():
        position, _ = way.at(engine.numbers.exact(1.0))
    slow = UNIT * 0.4
    assert float(position[0]) == pytest.approx(math.log1p(slow * 30.0) / slow, rel=error)


@all_engines
@pytest.mark.parametrize("height", [0.0, 1.0])
@pytest.mark.sampled(every=3)
def test_where_ground_and_switch_coincide_the_ground_ends_the_flight(engine, error, height):
    start = (0.0, 0.0, height + 1.0), (30.0, 0.0, 25.0)
    time, place, _, _ = flown(*start, (0, 0, 0), (3.0, 0.0, 0.0), -9.0, lambda y: y[2] - height)
    air = {"lift_coefficient": 0.0}
    scene = flight(*start, wind=(3.0, 0.0, 0.0), above=height, floor=height, air=air)
    found = landed(scene, engine)
    assert found[0] == pytest.approx(time, rel=error)
    assert found[1] == pytest.approx(place, rel=error, abs=100 * error)
