"""Derivatives in columns: against closed forms, and against those of single scenes.

Both come from the same equations by other code: of columns from the compiled steps, of one scene
from a flight that has its derivative among its variables. They are held together within 1e-12 of
the size of the quantity for an input that changes by its size, as `test_tangent` holds the latter.
Past a bat, where rounding turns the direction of the impulse, both are held against 30 digits.
"""

import math

import numpy as np
import pytest

import longball as lb
from longball.api import as_scene
from longball.engines.batch import solve_columns, solve_columns_with_slopes
from longball.engines.enclosure import Enclosure
from longball.engines.ivp import Ivp
from longball.engines.tangent import derivatives_of
from longball.golden.case import ROUNDING
from longball.model.inputs import inputs, value_of
from longball.model.quantities import replaced
from tests.calls import check_wrong_calls
from tests.scenes import FAMILIES, cases_of

GOOD = 1e-12  # of the size of a quantity

FLIGHT = {"kind": "flight", "launch": {"position": [0, 0, 1], "velocity": [30, 1, 20]}}
SPINNING = {
    "kind": "flight",
    "launch": {"position": [0, 0, 1], "velocity": [30, 1, 20], "spin": [10, -200, 30]},
    "air": {"wind": [2, 1, 0], "lift_coefficient": {"law": "rational"}},
}
DECAYING = SPINNING | {"air": {"lift_coefficient": {"law": "rational"}, "spin_decay_length": 150}}
ASIDE = SPINNING | {"air": {"side_coefficient": {"value": 0.08, "direction": [0.2, 1, 0.3]}}}
PROFILE = {"velocity": [3, 1, 0], "height": 10, "roughness": 0.03}
CRISIS_IN_PROFILE = SPINNING | {"air": {"drag_coefficient": {"law": "crisis"}, "wind": PROFILE}}
# Of no force, and with derivatives by the coefficients.
FEEBLE = FLIGHT | {"air": {"drag_coefficient": 0.0, "lift_coefficient": 0.0, "wind": PROFILE}}
FENCE = [[30, 80, 4], [70, 20, 4], [60, -60, 3], [0, -90, 3]]
FENCED = FLIGHT | {"fence": {"polyline": FENCE}}
UPWARD = FLIGHT | {"reading": {"lift_direction": "always_up"}}
PITCH = {"kind": "pitch", "pitch": {"speed": 38.0, "aim": [0.1, 1.0]}}
AT_BAT = {"kind": "at-bat", "pitch": {"speed": 38.6, "aim": [-0.1, 1.8]}}
RUBBED = {
    "kind": "at-bat",
    "pitch": {"speed": 38.6, "aim": [-0.1, 1.8], "spin": [20, 150, 30]},
    "bat": {"friction": 0.4},
    "air": {"lift_coefficient": {"law": "rational"}},
}
IMPACT = {
    "kind": "impact",
    "incoming": {"position": [0.0696, 0.1, 1.0], "velocity": [-35, 0, -3], "bat_height": 1.0},
}


def drawn(count, **ranges):
    rng = np.random.default_rng(1)
    return {name.replace("__", "."): rng.uniform(*ends, count) for name, ends in ranges.items()}


def velocities(count):
    found = drawn(count, x=(20, 40), y=(-5, 5), z=(-2, 30))
    return {f"launch.velocity[{i}]": column for i, column in enumerate(found.values())}


AIR_ONLY = ["gravity", "air.density", "ball.mass"]
AIR = [*AIR_ONLY, "air.drag_coefficient"]
COMPONENTS = [f"launch.velocity[{i}]" for i in range(3)]
TRACKED = ["launch.speed", "launch.angle", "launch.direction"]
OF_SPIN = ["launch.spin[0]", "launch.backspin", "launch.side_spin", "launch.gyrospin"]


def off(scene, columns, names, engine, every=1):
    """Largest difference from the derivatives of single scenes, of the size of a quantity."""
    base = as_scene(scene)
    table, slopes = solve_columns_with_slopes(base, columns, names)
    assert slopes.alone == []
    largest = 0.0
    for i in range(0, len(table["outcome"]), every):
        row = replaced(base, {name: column.item(i) for name, column in columns.items()})
        there = [name for name in slopes.columns if np.isfinite(table[name][i])]
        known = derivatives_of(row, [q for q in there if q != "contact.margin"], names, engine)
        for quantity, by in known.items():
            vector = quantity.partition("[")[0]
            parts = [column[i] for name, column in table.items() if name.startswith(vector)]
            for slope, (name, other) in zip(
                slopes.columns[quantity][:, i], by.items(), strict=True
            ):
                other = float(getattr(other, "value", other))
                size = abs(other) + math.hypot(*parts) / (abs(value_of(row, name)) or 1.0)
                largest = max(largest, abs(slope - other) / size if size else abs(slope))
    return largest


@pytest.mark.parametrize(
    ("scene", "columns", "names"),
    [
        (FLIGHT, velocities(16), [*COMPONENTS, *AIR, "launch.position[2]"]),
        (FLIGHT, velocities(8), TRACKED),
        (SPINNING, velocities(8), [*COMPONENTS, *AIR, *OF_SPIN, "air.wind[0]"]),
        (CRISIS_IN_PROFILE, velocities(6), [*COMPONENTS, *AIR_ONLY, "air.wind.roughness"]),
        (FEEBLE, velocities(6), ["air.drag_coefficient", "air.lift_coefficient"]),
        (DECAYING, velocities(6), [*TRACKED, *OF_SPIN, "air.spin_decay_length", "gravity"]),
        (
            DECAYING | {"reading": {"spin_decay": "nathan"}},
            velocities(4),
            [*COMPONENTS, "air.spin_decay_length"],
        ),
        (
            ASIDE,
            velocities(6),
            [*TRACKED, "air.side_coefficient.value", "air.side_coefficient.direction[1]"],
        ),
        (FENCED, velocities(8), [*TRACKED, "fence.polyline[1][0]", "fence.polyline[2][2]"]),
        (UPWARD, velocities(8), [*TRACKED, "air.lift_coefficient"]),
        (
            PITCH,
            drawn(8, pitch__speed=(30, 45)),
            ["pitch.speed", "pitch.aim[0]", "pitch.aim[1]", "pitch.release[0]", *AIR],
        ),
        (
            IMPACT,
            drawn(8, bat__mass=(0.8, 1.0), swing__angular_speed=(30, 40)),
            ["bat.mass", "ball.mass", "ball.radius", "incoming.position[1]", "swing.tilt"],
        ),
    ],
)
@pytest.mark.sampled(every=2)
def test_columns_have_the_derivatives_of_their_scenes(scene, columns, names, nightly):
    assert off(scene, columns, names, Ivp(), every=1 if nightly else 3) < GOOD


@pytest.mark.parametrize("scene", [AT_BAT, pytest.param(RUBBED, marks=pytest.mark.nightly)])
def test_at_bats_have_the_derivatives_that_are_proven(scene, nightly):
    columns = drawn(6, pitch__speed=(30, 45), swing__height_offset=(-0.03, 0), swing__tilt=(0, 0.3))
    names = ["pitch.speed", "swing.height_offset", "bat.mass", "ball.radius", *AIR]
    few = names if nightly else names[:4]
    assert off(scene, columns, few, Enclosure(30), every=3 if nightly else 6) < GOOD


def test_the_margin_of_a_miss_changes_with_the_bat():
    # The margin is R + r_b less the closest distance, which the bat's radius has no part in.
    columns = {"swing.height_offset": np.array([-0.3, 0.3])}
    names = ["swing.height_offset", "bat.radius"]
    table, slopes = solve_columns_with_slopes(as_scene(AT_BAT), columns, names)
    assert (table["outcome"] == "missed").all()
    by_height, by_bat = slopes.columns["contact.margin"]
    assert by_bat == pytest.approx([1.0, 1.0], abs=1e-12)
    base = as_scene(AT_BAT)
    for i, height in enumerate(columns["swing.height_offset"]):
        row = replaced(base, {"swing.height_offset": height})
        known = derivatives_of(row, ["contact.margin"], names, Enclosure(30))["contact.margin"]
        assert by_height[i] == pytest.approx(float(known["swing.height_offset"].value), rel=1e-11)


@pytest.mark.parametrize("scene", [FLIGHT, SPINNING, FENCED, UPWARD])
def test_results_have_the_same_bits_with_derivatives_and_without(scene):
    columns = velocities(300)
    plain = solve_columns(as_scene(scene), columns)
    table, _ = solve_columns_with_slopes(as_scene(scene), columns, ["gravity", "launch.speed"])
    assert table.keys() == plain.keys()
    for name, column in plain.items():
        np.testing.assert_array_equal(table[name], column)


def test_neither_threads_nor_the_order_of_rows_change_a_bit():
    columns = velocities(40_000)
    columns["launch.velocity[1]"][::3] = 0.0
    names = ["launch.angle", "air.density", "launch.velocity[1]"]
    _, one = solve_columns_with_slopes(as_scene(FLIGHT), columns, names)
    backwards = {name: column[::-1].copy() for name, column in columns.items()}
    _, two = solve_columns_with_slopes(as_scene(FLIGHT), backwards, names, threads=2)
    assert one.columns.keys() == two.columns.keys()
    for name, column in one.columns.items():
        np.testing.assert_array_equal(column, two.columns[name][:, ::-1])


# --- what is left to single scenes ----------------------------------------------------------------


def test_a_kink_is_refused_in_its_row_alone():
    # along the ground from the ground; from a height; straight up
    columns = {
        "kind": "flight",
        "launch.position[0]": 0.0,
        "launch.position[1]": 0.0,
        "launch.position[2]": [0.0, 1.0, 1.0],
        "launch.velocity[0]": [30.0, 30.0, 0.0],
        "launch.velocity[1]": 0.0,
        "launch.velocity[2]": [0.0, 0.0, 30.0],
    }
    names = ["launch.position[2]", "launch.velocity[0]"]
    found = lb.solve_many(columns, derivatives=names)
    ground, plain, upright = found["refused"]
    assert "launch.position[2]: whether the ball starts below the ground" in ground
    assert plain != plain
    assert "launch.velocity[0]: whether the launch is vertical depends on" in upright
    engines = found["derivatives"].tolist()
    assert ["ivp" in engine for engine in engines] == [True, False, True]
    for name in names:
        column = found[f"landing.distance by {name}"]
        assert column.isna().tolist() == [name in x if x == x else False for x in found["refused"]]
        scene = lb.Flight(launch={"position": [0, 0, 1], "velocity": [30, 0, 0]})
        known = lb.solve(scene, derivatives=names).derivatives["landing.distance"]
        assert column[1] == pytest.approx(known[name], rel=1e-12)


TABLE = {"law": "table", "of": "speed", "at": [20, 50], "values": [0.5, 0.3]}


@pytest.mark.parametrize(
    ("scene", "columns", "names", "alone"),
    [
        # A shallow landing takes more digits than doubles have.
        (
            FLIGHT | {"launch": {"position": [0, 0, 1e-9], "velocity": [30, 0, 1]}},
            {"launch.velocity[2]": [-1e-3, 20.0]}, ["launch.position[2]"], [0],
        ),
        # The lanes fly no ball straight down.
        (
            FLIGHT | {"air": {"lift_coefficient": 0.0}},
            {"launch.velocity[0]": [0.0, 30.0], "launch.velocity[1]": [0.0, 0.0],
             "launch.velocity[2]": [-5.0, -5.0]}, ["launch.velocity[2]", "gravity"], [0],
        ),
        # Nor does the compiled code know tables.
        (
            FLIGHT | {"air": {"drag_coefficient": TABLE}},
            {"launch.velocity[2]": [10.0, 20.0]}, ["gravity"], [0, 1],
        ),
    ],
)  # fmt: skip
def test_rows_that_columns_leave_have_the_derivatives_of_their_scenes(scene, columns, names, alone):
    base, columns = as_scene(scene), {name: np.array(column) for name, column in columns.items()}
    _, slopes = solve_columns_with_slopes(base, columns, names)
    assert slopes.alone == alone
    for i in alone:
        row = replaced(base, {name: column.item(i) for name, column in columns.items()})
        proven = derivatives_of(row, ["landing.time"], names, Enclosure(30))["landing.time"]
        found = slopes.columns["landing.time"][:, i]
        assert found == pytest.approx([float(proven[name].value) for name in names], rel=1e-12)


def test_a_ball_that_grazes_the_bat_is_left_to_its_scene():
    """At a margin of 1e-5 m, the contact needs more digits than doubles have."""
    offsets = {"swing.height_offset": np.array([0.0697617089, 0.06])}
    table, slopes = solve_columns_with_slopes(as_scene(AT_BAT), offsets, ["pitch.speed"])
    assert table["contact.margin"][0] == pytest.approx(1e-5, rel=0.01)
    assert slopes.alone == [0]


def test_a_launch_at_rest_has_no_speed_to_change():
    columns = {f"launch.velocity[{i}]": np.array([0.0, 20.0]) for i in range(3)}
    _, slopes = solve_columns_with_slopes(as_scene(FLIGHT), columns, ["launch.speed", "gravity"])
    assert slopes.refused.keys() == {0}
    assert "the scene has no launch" in slopes.refused[0]["launch.speed"]
    assert "at rest in the air" in slopes.refused[0]["gravity"]
    for column in slopes.columns["landing.time"]:
        assert np.isnan(column).tolist() == [True, False]


def test_lists_and_other_engines_have_the_derivatives_of_single_scenes():
    names = ["gravity", "launch.speed"]
    scene = lb.Flight(**{k: x for k, x in FLIGHT.items() if k != "kind"})
    known = lb.solve(scene, derivatives=names).derivatives["landing.distance"]
    good, bad = lb.solve_many([FLIGHT, {"kind": "flight"}], derivatives=names)
    assert good.derivatives["landing.distance"] == known
    assert bad.error
    columns = {"kind": "flight", "launch.position": [0, 0, 1], "launch.velocity[0]": [30.0, 30.0]}
    columns |= {"launch.velocity[1]": 1.0, "launch.velocity[2]": [20.0, 20.0]}
    table = lb.solve_many(columns, "ivp", derivatives=names)
    for name in names:
        assert table[f"landing.distance by {name}"].tolist() == [known[name]] * 2
    assert table["derivatives"].str.contains("ivp").all()


WRONG = """
lb.solve_many(TWO, derivatives=["launch.sped"]) -> did you mean launch.speed
lb.solve_many(TWO, derivatives="launch.speed") -> a list of names is needed
lb.solve_many(TWO, derivatives=True, certify=True) -> not certified
lb.solve_many(TWO, derivatives=True, engine="verlet", dt=1e-3) -> has no derivatives
"""
TWO = {
    "kind": "flight",
    "launch.position": [0, 0, 1],
    "launch.velocity[0]": [30.0, 31.0],
    "launch.velocity[1]": 1.0,
    "launch.velocity[2]": 20.0,
}


def test_derivatives_that_cannot_be_had_are_refused():
    check_wrong_calls(WRONG, globals())


# --- golden data ----------------------------------------------------------------------------------


@pytest.mark.nightly
@pytest.mark.parametrize("family", FAMILIES)
def test_golden_scenes_have_in_columns_the_derivatives_that_they_have_alone(family):
    """A derivative is of the size of what its quantity is made of, over the size of its input.

    That is the attainable error of the golden case, in roundings: of a clearance of 1 mm, or of a
    ball from a bat, it is far more than the quantity. Of a flight it is up to four times as much.
    Where the two differ by more, 30 digits tell whether it is the columns that are off.
    """
    cases = [case for case in cases_of(family) if case.condition is not None]
    compared, faults = 0, []
    for case in cases[::4]:
        of = inputs(case.scene)
        names = [*of][::3]
        if not names:
            continue
        columns = {names[0]: np.full(2, of[names[0]])}
        table, slopes = solve_columns_with_slopes(case.scene, columns, names)
        known = derivatives_of(case.scene, slopes.columns, names, Ivp())
        for quantity, found in slopes.columns.items():
            if quantity not in case.quantities or quantity == "contact.margin":
                continue
            if not np.isfinite(table[quantity][0]):
                continue
            unit = case.attainable(quantity) / ROUNDING
            for name, slope in zip(names, found[:, 0], strict=True):
                compared += 1
                other = known[quantity][name]
                good = 0.25 * GOOD * (abs(other) + unit / (abs(of[name]) or 1.0))
                if abs(slope - other) > good:
                    proven = derivatives_of(case.scene, [quantity], [name], Enclosure(30))
                    if not abs(slope - float(proven[quantity][name].value)) <= good:
                        faults.append((case.id, quantity, name))
    assert faults == []
    assert compared > 10
