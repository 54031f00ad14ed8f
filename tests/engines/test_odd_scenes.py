"""Scenes in which something odd happens, by every engine against the oracle.

They are corners that random scenes hardly meet. A number may be off by the tolerance of
`tests/nightly.py`; in a scene that is on the verge of another outcome, which has none, by a
hundred times the oracle's own error. Verlet's scheme takes the step that passes a switch of the law
by the form before it: 1 ms times a jump of some 10 m/s².
"""

from __future__ import annotations

import json
import math
from functools import cache

import pytest

from longball.engines import create
from longball.engines.chain import solve
from longball.model.scene import parse_scene
from tests import oracle
from tests.nightly import Value, judged, quantities, truth
from tests.test_oracle import PRESENT

ENGINES = {"ivp": {}, "batch": {}, "enclosure": {}, "multiprecision": {"digits": 16}}
ON_THE_VERGE = 1e-9  # relative, of 1 at least
SCHEME, IN_STEPS = create("verlet", dt=1e-3, forces="implicit"), 1e-2  # relative, of 100 at least
CALM = {"lift_coefficient": 0.0}


def thrown(height, *velocity, **more):
    return {"position": (0.0, 0.0, height), "velocity": velocity} | more


def flight(launch, air=None, **keys):
    return {"kind": "flight", "launch": launch, "air": air} | keys


def blown(launch, above, wind=(15, 0, 0), air=CALM, floor=0.0, **keys):
    """A ball that comes through the height where the wind sets in, ends there, or starts there."""
    air = air | {"wind": {"velocity": wind, "above": above}}
    return flight(launch, air, ground={"height": floor}) | keys


def at_bat(**keys):
    return {"kind": "at-bat"} | keys


def struck(position, velocity, spin=None, **keys):
    incoming = {"position": position, "velocity": velocity, "bat_height": 1.0}
    return {"kind": "impact", "incoming": incoming | ({"spin": spin} if spin else {})} | keys


CONSTANT = {"density": 1.2, "drag_coefficient": 0.4, "lift_coefficient": 0.0}
LOOPS = {"density": 1.2, "drag_coefficient": 0.3, "lift_coefficient": 1.5}
UPWARDS = {"reading": {"lift_direction": "always_up"}}
DECAYING = {"lift_coefficient": {"law": "linear"}, "spin_decay_length": 100.0}
NATHAN = {"reading": {"spin_decay": "nathan"}}
BACK = thrown(2.0, 20.0, 0.0, 20.0, spin=(0.0, -100.0, 0.0))
TABLE = {"law": "table", "of": "speed", "at": (10, 20, 30, 45), "values": (0.9, 0.5, 0.3, 0.6)}
FORCELESS = {"drag_coefficient": 0.0, "lift_coefficient": 0.0, "spin_decay_length": 100.0}
PLAIN = {"bat_ball_restitution": "plain", "reduced_mass": "bat_mass"}
WALLS = [[30.6, 50, 9], [30.6, -5, 9], [30.3, -5, 9], [30.3, 5, 9], [30, 5, 9], [30, -50, 9]]

ZIGZAG = [[60, 50, 9], [60, -5, 9], [45, -5, 9], [45, 5, 1], [30, 5, 1], [30, -50, 1]]

# A quantity of a state goes by the branch of the law that is valid in that state.
BRANCHES = {
    # Nathan's spin, e^(-t U/L), has the airspeed of the wind that the ball came through.
    **PRESENT,
    "lands where the wind sets in": blown(BACK, 0.5, air=DECAYING, floor=0.5, **NATHAN),
    "lands in the calm": blown(BACK, 0.5, air=DECAYING, **NATHAN),
    # A lift with a kink of S is searched for where S jumps past it, with the spin on either side.
    "loses spin at once": blown(
        BACK | {"velocity": (25.0, 0.0, 10.0), "spin": (0.0, -150.0, 0.0)}, 4.0,
        air=DECAYING | {"lift_coefficient": {"law": "bilinear"}}, **NATHAN,
    ),
    "rises slower than the air": blown(thrown(2.0, 0, 0, 3), 1.0, (0, 0, 5)),
    "starts into the wind": blown(thrown(1.0, 30, 0, 6), 1.0, (9, 3, 0)),
    "starts along its height": blown(thrown(1.0, 30, 0, 0), 1.0, (9, 3, 0)),
    "starts out of the wind": blown(thrown(1.0, 30, 0, -6), 1.0, (9, 3, 0)),
    "lands at z = 0, where it sets in": blown(thrown(1.0, 30, 0, 25), 0.0, (3, 0, 0)),
    "lands at 1 m, where it sets in": blown(thrown(2.0, 30, 0, 25), 1.0, (3, 0, 0), floor=1.0),
    # A ball straight up flies without lift, whatever the reading, and keeps the drag's table.
    "has a table, and a lift that is always up": flight(
        thrown(1.0, 0, 0, 40), {"drag_coefficient": TABLE}, **UPWARDS
    ),
    # Also where heights are uncertain by the rounding of another number of the launch.
    "rises from the ground": blown(
        {"position": (1.0, 0.0, 0.0), "velocity": (12.0, 9.5, 17.0)}, 0.5,
        air={"lift_coefficient": 0.0, "density_scale_height": 8500.0},
    ),
}  # fmt: skip
SCENES = {
    # the highest point
    "is Galileo's": flight({"position": (1, 2, 0.5), "velocity": (12, 9, 20)}),
    # 15 s is where halving the time limit comes to.
    "lands at a round time": flight(thrown(0.0, 1, 0, 75), gravity=10.0),
    "does not get up to the ground": flight(
        thrown(0.0, 30, 0, 12), ground={"height": 8}, time_limit=5.0
    ),
    **{
        f"goes straight up through air that rises at {w} m/s": flight(
            thrown(1.0, 0, 0, 30), CONSTANT | {"wind": (0, 0, w)}
        )
        for w in (0, 3, -3)
    },
    "is turned upright by its lift": flight(thrown(1.0, 7.5, -2, 58), {}, **UPWARDS),
    **{
        f"has several tops at {u} m/s": flight(
            thrown(15.0, u, 0, w, spin=(0, -100, 0)), LOOPS, time_limit=20.0
        )
        for u, w in ((40, -5), (25, -12))
    },
    "is always lifted on a turning Earth": flight(
        thrown(1.0, 30, 0, 25), {}, earth={"latitude": 0.7}, **UPWARDS
    ),
    **BRANCHES,
    # Without a push of the air the velocity's series ends, and the speed's, of the path, does not.
    **{
        f"has a path at {w} m/s in a wind of {u} m/s": flight(
            thrown(1.0, *v, w, spin=(0, 100, 0)),
            FORCELESS | {"wind": {"velocity": (u, 0, 0), "height": 10, "roughness": 0.03}},
        )
        for v, w in (((40, 3), 20), ((0, 0), 30))
        for u in (0, 3)
    },
    # Whichever of two walls, 30 cm apart, the fence names first.
    "hits the first of two walls": flight(
        thrown(1.0, 44, 0, 2), {}, fence={"polyline": WALLS}
    ),
    "hits the first of two walls, turned": flight(
        thrown(1.0, 44, 0, 2), {}, fence={"polyline": [[x, -y, h] for x, y, h in WALLS[::-1]]}
    ),
    "hits a wall half a metre away": flight(
        thrown(1.0, 30, 0, 2), {}, fence={"polyline": [[0.5, 5, 9], [0.5, -5, 9]]}
    ),
    # Out at x = 30, in again at x = 45 and out at x = 60.
    **{
        f"crosses the first of two chords, {sign:+}": flight(
            thrown(5.0, 60, 0, 5), gravity=1.0,
            fence={"polyline": [[x, sign * y, h] for x, y, h in ZIGZAG[::sign]]},
        )
        for sign in (1, -1)
    },
    # the bat
    "meets the ground before a bat in it": at_bat(swing={"height_offset": -1.5}),
    # Lift turns it round just beyond the plate, which it crosses at 0.16 m/s, there and back.
    "turns round": {
        "kind": "pitch", "air": {"drag_coefficient": 0.1, "lift_coefficient": 1.5},
        "pitch": {"speed": 40, "release": [45.14168982597962, 0, 30], "aim": [0, 30]},
    },
    # So slow that it falls as much as it flies while it passes: V² is less than 2 |d| |a|.
    **{
        f"passes a bat at walking pace, {offset} m": at_bat(
            pitch={"release": [0.5, 0, 1.8], "speed": 1.5, "aim": [0, 2.2]},
            swing={"height_offset": offset},
        )
        for offset in (0.2, 0.1, 0.0, -0.1, -0.2)
    },
    # It comes closer, touches, and never crosses behind the plate.
    "falls onto the bat from above": at_bat(
        pitch={"release": [0.01, 0, 3.0], "speed": 0.02, "aim": [0, 3.0]},
        swing={"height_offset": -1.0}, air=None,
    ),
    # A lob that falls past below the bat, and comes 1.4 mm closer behind it.
    "is closest behind the bat": at_bat(
        pitch={"speed": 14.76, "aim": [0.344, 24.2136]}, swing={"height_offset": -0.1642},
        air={"drag_coefficient": 0.4033, "lift_coefficient": 0.158},
    ),
    # The closest approach may lie steps before any in which the ball could have touched.
    **{
        f"passes {offset} m from the bat": at_bat(swing={"height_offset": offset})
        for offset in (1.0, 10.0, -1.2)
    },
    # The ball falls away from a bat that is swung above it.
    "is closest at the release": at_bat(
        pitch={"release": [0.08, 0, 1.8], "aim": [0, 1.2]}, swing={"height_offset": 1.0}
    ),
    # A ball of 9 mg sinks for a fifth of a second from the bat to the plate's plane.
    "touches long before the plate": at_bat(
        ball={"mass": 8.8e-06, "radius": 0.0167}, bat={"radius": 0.0132}, gravity=105.3,
        air={"density": 3.73, "drag_coefficient": 1.117, "lift_coefficient": 0.792},
        pitch={"speed": 0.1145, "release": [0.361, -0.994, 3.9], "aim": [0.557, 0.324]},
        swing={"height_offset": 0.0726}, **UPWARDS,
    ),
    # It flies at 79° to the bat: where it touches, it is 0.3 m from the plate's plane.
    "comes along the bat": at_bat(pitch={"speed": 60.0, "release": [2.0, -10.0, 1.8]}),
    # The batch engine's search begins 0.25 m before the plate.
    **{
        f"starts {x} m away": at_bat(pitch={"release": [x, 0, 1.8], "aim": [0, 1.8]})
        for x in (0.24, 0.25, 0.26)
    },
    "touches the bat at the release": at_bat(
        air=None, gravity=0.0, ball={"radius": 0.0625}, bat={"radius": 0.03125}, time_limit=2.0,
        pitch={"release": [0.09375, 0.0, 1.8]},
    ),
    # z = 6 - (x - top)², m, above a bat at z = 5.375 - top²: closest on either side of it
    **{
        f"is close before the bat and behind it, {top} m": at_bat(
            air=None, gravity=8.0, ball={"radius": 0.125}, bat={"radius": 0.25},
            pitch={"release": [2.0 + top, 0.0, 2.0], "velocity": [-2.0, 0.0, 8.0]},
            swing={"height_offset": -0.625},
        )
        for top in (0.0, 2.0**-8, -(2.0**-8))
    },
    # Of ẽ M / m = 1 the ball leaves with the bat's own speed: by the impulse's definition.
    **{
        f"stays slower than the bat, {m} kg, {e}": at_bat(
            ball={"mass": m, "restitution": e}, bat={"mass": 0.5}, reading=PLAIN
        )
        for m, e in ((0.25, 0.6), (0.25, 0.5), (0.25, 0.4), (0.25, 0.0), (0.125, 0.4), (2.0, 0.4))
    },
    # It overtakes the bat, of 10 m/s, is struck by its back, and is faster still.
    **{
        f"comes from behind at {u} m/s, {m} kg": struck(
            (-0.0696, 0, 1), (u, 0, 0), ball={"mass": m}, swing={"angular_speed": 20}, reading=PLAIN
        )
        for u in (40.0, 10.5)
        for m in (0.145, 5.0)
    },
    # K is singular to a part in 1e2: by as much a rounding shows in the impulse.
    "is almost too heavy for the bat": struck(
        (0.0696 * math.cos(0.8), 0.0, 1.0 + 0.0696 * math.sin(0.8)),
        (0.0, 0.3, -2.0),
        (-16.0, -10.0, -6.0),
        ball={"mass": 50.0}, bat={"mass": 0.4, "length": 0.2, "friction": 30.0},
        reading={"bat_ball_restitution": "nathan", "reduced_mass": "effective_mass"},
    ),
}  # fmt: skip


# In many digits a scene takes a second. Steps are long there: several switches fall on one.
BY_DAY = [*BRANCHES][2::3]


@cache
def answer_of(name):
    """Result of a scene by the oracle."""
    return oracle.solve(json.loads(json.dumps(SCENES[name]))).result


def about(name, error, least):
    """Quantities of a scene by the oracle, and an error relative to their size, `least` or more."""
    return {
        key: Value(x, error * max(least, math.hypot(*x)) if isinstance(x, list) else 0.0)
        for key, x in quantities(answer_of(name))
    }


@pytest.mark.parametrize("name", SCENES)
def test_an_odd_scene_ends_as_the_oracle_says(name, nightly):
    scene = parse_scene(json.dumps(SCENES[name]))
    true = truth(json.loads(json.dumps(SCENES[name]))) or about(name, ON_THE_VERGE, 1.0)
    for engine, options in ENGINES.items():
        if engine == "multiprecision" and not (nightly or name in BY_DAY):
            continue
        result = solve(scene, create(engine, **options))
        off, sentence = judged(json.loads(result.line()), true)
        assert off is not None, (engine, sentence)
        assert off <= 1, (engine, sentence)
        if engine == "batch":
            assert create(engine).solve_all([scene] * 20) == [result] * 20


@pytest.mark.parametrize("name", [*BRANCHES, *(name for name in SCENES if "tops" in name)])
def test_the_scheme_takes_the_branch_of_a_step_and_the_highest_of_several_tops(name):
    found = dict(
        quantities(json.loads(solve(parse_scene(json.dumps(SCENES[name])), SCHEME).line()))
    )
    true = about(name, IN_STEPS, 100.0)
    keys = (f"landing.{part}" for part in ("time", "position", "velocity", "spin"))
    for key in (*keys, "apex.time", "apex.position"):
        if key in true:
            value, tolerance = true[key]
            assert math.dist(found[key], value) <= tolerance, key
