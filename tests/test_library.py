"""`import longball as lb`, as a notebook uses it."""

from __future__ import annotations

import copy
import doctest
import json
import math
import pickle
import pydoc
import re
from decimal import Decimal
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import longball as lb
from longball import api, engines, solution, tables
from longball.convergence import studies
from longball.engines import event, tangent, taylor
from longball.model import law
from longball.model.quantities import flat
from longball.pitches import prediction
from longball.questions import movement, parks, spin
from tests.calls import check_wrong_calls
from tests.engines.test_lines import ERRORS

AT_BAT = {
    "pitch": {"speed": 38.64, "aim": [-0.144, 1.8]},
    "swing": {"height_offset": -0.03, "tilt": 0.14},
}


class TestImport:
    def test_every_name_of_dir_is_there(self):
        assert dir(lb) == sorted(lb.__all__)
        assert all(getattr(lb, name) is not None for name in dir(lb))
        with pytest.raises(AttributeError, match="solv'"):
            _ = lb.solv

    @pytest.mark.parametrize(
        "module",
        [
            lb,
            api,
            solution,
            studies,
            tables,
            movement,
            parks,
            prediction,
            spin,
            event,
            law,
            tangent,
            taylor,
        ],
    )
    def test_the_examples_print_what_they_say(self, module):
        results = doctest.testmod(module)
        assert results.attempted > 0
        assert results.failed == 0


class TestScenes:
    def test_models_mappings_lines_and_arrays_are_the_same_scene(self):
        line = json.dumps({"kind": "at-bat", **AT_BAT})
        arrays = {
            "pitch": {"speed": np.float32(38.5), "aim": np.array([0, 2])},
            "swing": {"tilt": np.int64(0)},
        }
        ways = [lb.AtBat(**AT_BAT), {"kind": "at-bat", **AT_BAT}, line, line.encode()]
        answers = {lb.solve(way).result for way in ways}
        assert len(answers) == 1
        assert lb.AtBat(**arrays).pitch == lb.AtBat(pitch={"speed": 38.5, "aim": (0, 2)}).pitch

    def test_help_fits_a_screen_and_shows_no_name_of_pydantic(self):
        said = pydoc.plain(pydoc.render_doc(lb.AtBat))
        assert len(said.splitlines()) < 60
        assert "AtBat(*, id=None, ball={}, reading={}, air={}, gravity=9.8," in said
        assert "model_" not in said
        assert "mass : float\n |      kg; not" in pydoc.plain(pydoc.render_doc(lb.Bat))
        assert {"pitch", "swing", "replace"} < {*dir(lb.AtBat())}
        assert dir(lb.Launch) == ["position", "spin", "velocity"]
        assert not [x for x in dir(lb.AtBat()) + dir(lb.Bat) if x.startswith(("_", "model_"))]
        assert repr(lb.AtBat(swing={"tilt": 0.2})) == "AtBat(swing={'tilt': 0.2})"

    def test_a_block_is_written_like_a_scene(self):
        assert lb.Launch(position=[0, 0, 1], velocity=np.arange(3)) == lb.Launch(
            position=(0.0, 0.0, 1.0), velocity=(0.0, 1.0, 2.0)
        )
        assert repr(lb.Bat(mass=np.float32(0.5))) == "Bat(mass=0.5)"


class TestSolve:
    def test_options_are_the_engines(self):
        digits = lb.solve(lb.AtBat(**AT_BAT), engine="enclosure", digits=20)
        step = lb.solve(lb.AtBat(**AT_BAT), engine="verlet", dt=1e-4)
        own = lb.solve(lb.AtBat(**AT_BAT), engine=engines.create("ivp"))
        assert len(digits.landing.distance.value) >= 20
        # The scheme as printed is of first order: ∂D/∂t of a contact a step late, 40 m/s.
        assert step.landing.distance == pytest.approx(float(digits.landing.distance), abs=0.1)
        assert own.landing.distance == pytest.approx(float(digits.landing.distance), abs=1e-4)

    def test_options_may_be_numbers_of_numpy(self):
        assert engines.create("enclosure", digits=np.int64(20)).description == "enclosure digits=20"
        assert engines.create("verlet", dt=np.float64(0.1)) == engines.create("verlet", dt=0.1)
        assert engines.create("ivp", method="RK45", rtol=None) == engines.create(
            "ivp", method="RK45"
        )

    @pytest.mark.parametrize(
        ("line", "error"),
        [
            (next(line for code, _, line in ERRORS if code == wanted), error)
            for wanted, error in (
                ("undecided", lb.Undecided),
                ("out_of_range", lb.CannotSolve),
                ("unsupported", lb.CannotSolve),
            )
        ],
    )
    def test_what_cannot_be_solved_raises(self, line: str, error: type[Exception]):
        (unsolved,) = lb.solve_many([line], "ivp")
        for attempt in (lambda: lb.solve(line), lambda: unsolved.path):
            with pytest.raises(error) as raised:
                attempt()
            assert raised.value.code == unsolved.code
            assert str(raised.value) == unsolved.error

    def test_a_certified_answer_has_proven_errors(self):
        scene = lb.AtBat(**AT_BAT)
        result = lb.solve(scene, certify=True)
        exact = lb.solve(scene, "enclosure", digits=25).landing.distance
        distance = result.landing.distance
        assert distance.value == lb.solve(scene).landing.distance
        assert abs(Decimal(distance.value) - Decimal(exact.value)) <= Decimal(distance.radius)
        assert f"landing.distance          {distance.value} ± {distance.radius} m" in repr(result)
        table = lb.solve_many({"kind": "pitch", "pitch.speed": [30.0, 40.0]}, certify=True)
        assert (table["plate.time.radius"].astype(float) < 1e-12).all()
        head = [f"plate.{n}.{of}" for n in ("time", "position[0]") for of in ("value", "radius")]
        assert [*table][1:5] == head
        with pytest.raises(lb.Undecided, match="proven to be"):
            lb.solve(scene, "verlet", certify=True, dt=0.05)

    def test_a_result_shows_itself(self):
        shown = lb.solve(lb.AtBat(id="<b>", **AT_BAT))
        assert "landing.distance          101.406 m" in repr(shown)
        assert "<td>landing.distance</td><td>101.406</td><td>m</td>" in shown._repr_html_()
        assert "&lt;b&gt;" in shown._repr_html_()
        assert {"landing", "path", "outcome"} <= {*dir(shown)}

    @pytest.mark.parametrize("engine", ["ivp", "enclosure"])
    def test_a_result_can_be_pickled_and_copied(self, engine: str):
        result = lb.solve(lb.AtBat(**AT_BAT), engine)
        end = result.path.end
        for same in (pickle.loads(pickle.dumps(result)), copy.deepcopy(result)):
            assert same.result == result.result
            assert same.path.end == end

    def test_a_result_of_the_extended_model_shows_itself(self):
        launch = {"position": [0, 0, 1], "velocity": [40, 0, 20], "spin": [0, -200, 0]}
        air = {"lift_coefficient": {"law": "linear", "slope": 1.0}}
        shown = lb.solve(lb.Flight(launch=launch, air=air, fence={"radius": 100}))
        assert shown.outcome == "home_run"
        assert "landing.fair      True" in repr(shown)
        assert "landing.spin      (0, -200, 0) rad/s" in repr(shown)
        grip = lb.solve(
            lb.Impact(
                incoming={
                    "position": [0.0696, 0, 1],
                    "velocity": [-30, 0, 0],
                    "bat_height": 1,
                    "spin": [0, 100, 0],
                },
                bat={"friction": 0.5},
            )
        )
        assert f"impact.mode            {grip.impact.mode}" in repr(grip)


class TestPath:
    def test_times_of_any_shape(self):
        path = lb.solve(lb.AtBat(**AT_BAT)).path
        state = path.at([[0.1, 0.2, 0.3], [1.0, 2.0, 3.0]])
        assert state.position.shape == state.velocity.shape == (2, 3, 3)
        assert np.array_equal(path.at(2.0).position, state.position[1, 1])
        table = path.sample(50)
        assert list(table) == ["t", "x", "y", "z", "vx", "vy", "vz"]
        assert (len(table), table.t.iloc[-1], table.z.iloc[-1]) == (50, path.end, 0.0)
        # dx/dt is vx: chords of a flight of constant acceleration a are off by a Δt²/24.
        flight = table[table.t > 1.0]
        slope = np.diff(flight.x) / np.diff(flight.t)
        middle = path.at((flight.t.to_numpy()[1:] + flight.t.to_numpy()[:-1]) / 2)
        assert slope == pytest.approx(middle.velocity[:, 0], abs=0.01)

    def test_an_impact_has_none(self):
        touching = {"position": [0.0696, 0, 1], "velocity": [-30, 0, 0], "bat_height": 1}
        with pytest.raises(ValueError, match="no path"):
            _ = lb.solve(lb.Impact(incoming=touching)).path

    def test_it_is_drawn_from_the_side_to_scale(self):
        plt = pytest.importorskip("matplotlib.pyplot")
        path = lb.solve(lb.AtBat(**AT_BAT)).path
        axes = path.plot()
        try:
            assert path.plot(axes) is axes
            first, second = (line.get_xydata() for line in axes.lines)
            assert np.array_equal(first, second)
            assert first[0] == pytest.approx([18.44, 1.8])
            assert first[-1] == pytest.approx(path.at(path.end).position[[0, 2]])
            assert axes.get_aspect() == 1.0
        finally:
            plt.close("all")


def test_a_scene_shows_what_was_written():
    scene = lb.AtBat(**AT_BAT, gravity=9.81, air={"drag_coefficient": {"law": "crisis"}})
    assert "crisis" in repr(scene)
    assert "bat=" not in repr(scene)
    assert eval(repr(scene), {"AtBat": lb.AtBat}) == scene
    assert repr(lb.Pitch()) == "Pitch()"


class TestSolveMany:
    def test_a_list_keeps_its_order_and_its_errors(self):
        scenes = [lb.AtBat(**AT_BAT), {"kind": "x", "id": "wrong"}, '{"kind": "pitch"}']
        first, wrong, last = lb.solve_many(scenes)
        assert first.landing == lb.solve(scenes[0], engine="batch").landing
        assert (wrong.outcome, wrong.id) == (None, "wrong")
        assert wrong.error.startswith("kind: 'x'")
        assert last.path.at(0.0).position.tolist() == [18.44, 0.0, 1.8]
        with pytest.raises(TypeError, match=r"lb\.solve takes one"):
            lb.solve_many(scenes[0])

    @pytest.mark.parametrize("engine", ["batch", "ivp"])
    def test_the_index_is_kept(self, engine: str):
        frame = pd.DataFrame({"kind": "pitch", "pitch.speed": [30.0, 35.0, 40.0]})[::-2]
        assert lb.solve_many(frame, engine).index.tolist() == [2, 0]

    @pytest.mark.parametrize(
        "columns",
        [{"kind": "pitch", "pitch.speed": []}, pd.DataFrame(columns=["kind", "gravity"]), {}],
    )
    def test_no_rows_are_an_empty_table(self, columns):
        table = lb.solve_many(columns)
        assert (len(table), [*table]) == (0, ["outcome", "error", "code"])

    def test_a_text_may_be_a_block(self):
        columns = {"kind": "pitch", "air": ["null", '{"density": 1.2}']}
        alone = [lb.solve({"kind": "pitch", "air": air}) for air in (None, {"density": 1.2})]
        table = lb.solve_many(columns, "ivp")
        assert table["plate.time"].tolist() == [result.plate.time for result in alone]

    @pytest.mark.parametrize("missing", ["kind", "launch.velocity[1]", "launch.position[0]"])
    def test_a_column_that_is_missing_is_named(self, missing: str):
        columns = {"kind": "flight", "launch": {"position": [0, 0, 1], "velocity": [30, 0, 25]}}
        table = {**dict(flat(columns)), "gravity": [9.8, 9.9]}
        del table[missing]
        named = re.escape(f"no row is a scene: {missing}: is missing")
        with pytest.raises(lb.InvalidScene, match=f"{named}.*the columns are"):
            lb.solve_many(table)

    @pytest.mark.parametrize(
        "scenes", [[{"kind": "at-bat", "id": "a"}] * 2, {"kind": ["pitch"] * 2, "id": ["a"] * 2}]
    )
    def test_ids_that_are_there_twice_are_told(self, scenes):
        with pytest.warns(UserWarning, match="1 ids are those of more than one scene, such as 'a'"):
            assert len(lb.solve_many(scenes)) == 2


BALL = lb.Flight(launch={"position": [0, 0, 1], "velocity": [30, 0, 25]})
FLIES = pd.DataFrame({"launch_speed": [103.0], "launch_angle": [28.0]})
PLACE = {"kind": "flight", "launch.position": [0, 0, 1]}
FILE = Path("scenes.csv")
PITCH = {"kind": "pitch"}
VECTORS = {"position": (15, 0, 2), "velocity": (-40, 0, 0), "acceleration": (8, 0, -5)}


# Calls, and what is said of each.
WRONG = r"""
# what is no scene
lb.solve({"kind": "at-bat", "pitch": {"sped": 3}}) -> pitch.sped
lb.solve({"kind": "at-bat", "pitch": {"speed": -3}}) -> pitch.speed
lb.solve({"kind": "at-bat", "gravity": float("nan")}) -> gravity
lb.solve({"kind": "at-bat", "gravity": 1j}) -> complex
lb.solve({"kind": "at-bat", "pitch": {"aim": (x for x in "12")}}) -> pitch.aim:
lb.solve("no scene") -> not JSON
lb.solve(3) -> int
lb.solve(None) -> NoneType
lb.AtBat(pitch={"aim": [1]}) -> pitch.aim\[1\]: is missing
lb.Pitch(kind="flight") -> kind: must be 'pitch'
lb.Flight(launch={"position": [0, 0, 1], "velocity": [1, 2, 3, 4]})
    -> velocity: must be \[x, y, z\] in m/s, and has 4 values
lb.AtBat({"kind": "at-bat"}) -> AtBat takes keywords: id, ball,
lb.Bat(mass=-1) -> mass: must be positive
lb.Swing(tlit=0.1) -> tlit: unknown key, did you mean tilt
lb.launch(-1, 0.5) -> speed: must be positive \(got -1\)
BALL.replace(**{"launch.spni": 0.2}) -> launch.spni: unknown key, did you mean spin\?
# engines and their options
lb.solve(PITCH, "verne") -> engine
lb.solve(PITCH, "ivp", dt=1.0) -> dt
lb.solve(PITCH, "enclosure", digits=20.0) -> digits
lb.solve(PITCH, "multiprecision", digits="20") -> digits
lb.solve(PITCH, "verlet", dt="a") -> dt
lb.solve(PITCH, "batch", tolerance=True) -> tolerance
lb.solve(PITCH, "ivp", method="RK45", rtol="a") -> rtol
lb.solve(PITCH, 3) -> engine
lb.solve(PITCH, engines.create("ivp"), rtol=1e-9) -> rtol
# results and paths
lb.solve(lb.Pitch())["landing.distnce"] -> landing.distnce: no result has it, did you mean
lb.solve(PITCH).path.at(-1e-9) -> outside the path
lb.solve(PITCH).path.at(float("nan")) -> outside the path
lb.solve(PITCH).path.at([0.0, 100.0]) -> outside the path
# columns
lb.solve_many(PITCH | {"pitch.sped": [1.0, 2.0]}) -> pitch.sped
lb.solve_many(PITCH | {"pitch.speed": [1.0], "gravity": [1.0, 2.0]}) -> equally long
lb.solve_many(PITCH | {"pitch.speed": [1.0], "pitch": "x"}) -> pitch
lb.solve_many(PITCH | {"pitch speed": [1.0]}) -> not the name
lb.solve_many(None) -> not an object of type NoneType
lb.solve_many(3) -> not an object of type int
lb.solve_many(pd.Series([3.0])) -> not an object of type Series
lb.solve_many(pd.Series(["a"], ["kind"])) -> not an object of type Series
# P(e)
lb.home_run_probability(1.5) -> e = 1\.5
lb.home_run_probability(0.4, "guess") -> guess
lb.home_run_probability(0.4, scene=PITCH) -> an at-bat is
lb.home_run_probability(0.4, scene=lb.AtBat(pitch={"speed": 30})) -> pitch\.speed: it varies
lb.home_run_probability(0.4, reading={"foo": 1}) -> 'foo' is not a switch
lb.home_run_probability(0.4, reading={"inertia": "rod"})
    -> inertia: must be .* \(got 'rod'\), did you mean thin_rod\?$
# values
lb.solve(lb.Pitch(), certify="yes") -> certify = 'yes' is not True or False
lb.solve_many([], certify=1) -> certify = 1 is not True or False
lb.solve_many([], paths=1) -> paths = 1
lb.solve_many([], paths=2, certify=True) -> cannot be certified
lb.solve_many([], workers="a") -> workers = 'a' is not a whole number
lb.home_run_probability(0.4, workers=2.5) -> workers = 2.5 is not a whole
lb.home_run_probability(0.4, "monte-carlo", seed=-1) -> seed = -1 is less than 0
lb.home_run_probability(0.4, samples=9) -> samples: quadrature draws none
lb.home_run_probability([]) -> e = \[\]: one coefficient of restitution or more
lb.home_run_probability("a") -> e = 'a': a number or an array
lb.solve(lb.Pitch()).path.at("0.1") -> time = '0.1': a number or an array
lb.solve(lb.Pitch()).path.at([True]) -> time = \[True\]: a number or an array
lb.home_run_probability(0.4, reading="a") -> reading: a mapping from switches
lb.solve(lb.Pitch()).path.sample(0) -> points = 0 is less than 2
lb.solve(lb.Pitch()).path.sample(2.5) -> points = 2.5 is not a whole number
lb.solve(lb.Pitch()).path.sample([0.1, 0.2]) -> path\.at takes times
lb.golden.load("bunts") -> no family 'bunts'; the families are flight-vacuum
lb.judge.assert_case(lb.golden.load("pitch")[0], 3) -> int
lb.golden.load("pitch")[0].attainable("foo") -> foo is not the name of a number
# of a first-time user
lb.solve("scene.json") -> the name of a file: scene.json; pass its text
lb.solve(FILE) -> the name of a file: scenes.csv
lb.solve([{"kind": "pitch"}]) -> lb.solve_many takes several
lb.launch(speed="103 mph", angle=0.4) -> speed: must be a number in m/s \(got
lb.launch(speed=46.0, angle=28) -> angle: .* \(got 28\); 28° are 0.4887 rad
lb.Flight(launch={"speed": 46.0}) -> launch.speed: unknown key; .*; lb.launch\(…\)
lb.solve(lb.Pitch()).time -> no attribute 'time', did you mean plate.time
lb.Solve -> has no attribute 'Solve', did you mean solve
lb.measured(FLIES, "battd") -> did you mean batted
lb.measured(3, "batted") -> a table is a pandas DataFrame
lb.fit_pitches(3) -> not an object of type int
lb.in_parks(BALL, "Fenway Park") -> such as \['Fenway Park'\]
lb.park("Sutter Health Park") -> no source gives the heights
lb.movement(lb.Pitch(), since="a") -> since = 'a' is not a number
lb.spin_for(lb.Pitch(), 3) -> a movement is needed, lb.Movement
lb.NineParameters(**VECTORS | {"position": (1, 2)}) -> position = \(1, 2\): a vector \[x, y, z\]
lb.fit({"landing.distance": "100"}, BALL, unknowns=["launch.speed"])
    -> landing.distance = '100': a finite number
lb.uncertainty(BALL, {"launch.speed": -1}) -> launch.speed must be positive \(got -1\)
# columns: the fault of a cell, and not the shapes of arrays
lb.solve_many(PLACE | {"launch.velocity": [[30, 0], [20, 0]]})
    -> launch.velocity must be \[x, y, z\] in m/s
lb.solve_many(PLACE | {"launch.velocty": [[30, 0, 25]]})
    -> launch.velocty: unknown key, did you mean velocity
lb.solve_many(PITCH | {"pitch.speed": ["39", "40"]})
    -> pitch\.speed: must be a number in m/s \(got '39'\) \(row 0 of 2\)
# keys
lb.solve({"Kind": "flight"}) -> is missing, and Kind is not a key
BALL.replace(**{"air.temperature": 20}) -> temperature is a key of air.density
BALL.replace(**{"launch.pos": 1}) -> did you mean position
"""


def test_a_wrong_call_says_what_would_be_right():
    check_wrong_calls(WRONG, globals())


def test_probability_of_a_home_run():
    table = lb.home_run_probability(0.45, "monte-carlo", samples=2000, workers=1)
    switched = lb.home_run_probability(
        [0.45], "monte-carlo", samples=2000, reading={"inertia": "about_centre"}
    )
    assert list(table)[:4] == ["e", "p", "low", "high"]
    assert table.low[0] < table.p[0] < table.high[0] < switched.p[0]


class TestJudge:
    def test_a_function_that_is_wrong_or_fails_is_found(self):
        def candidate(scene):
            if scene.gravity < 9:
                raise ZeroDivisionError("gravity")
            result = json.loads(lb.solve(scene).result.line())
            result["landing"]["distance"] += 1.0
            return result

        verdict = lb.judge.judge(candidate, "flight-drag")
        assert not verdict.passed
        assert "ZeroDivisionError: gravity" in verdict.line()


def test_a_launch_is_what_trackers_measure():
    # To the left at a right angle to centre field: all by hand.
    launch = lb.launch(40.0, math.pi / 6, math.pi / 2, backspin=200.0, side_spin=30.0)
    level, half = math.sqrt(3) / 2, 0.5
    assert launch.velocity == pytest.approx((0.0, 40 * level, 40 * half), abs=1e-14)
    # Backspin about +x, which lifts a ball that flies to +y; the rest in the plane of y and z.
    assert launch.spin == pytest.approx((200.0, -30 * half, 30 * level), abs=1e-13)
    assert lb.launch(40.0, 0.5).spin is None


def test_a_scene_with_other_values_is_checked():
    scene = lb.AtBat(pitch={"speed": 38.0}, swing={"tilt": 0.14})
    other = scene.replace(**{"swing.tilt": 0.2, "pitch.aim[1]": 1.7, "air": None})
    written = {"pitch": {"speed": 38.0, "aim": [0.0, 1.7]}, "swing": {"tilt": 0.2}, "air": None}
    assert other == lb.AtBat(**written)
    assert scene.swing.tilt == 0.14


def test_quantities_have_names():
    solution = lb.solve(lb.Pitch())
    assert solution["plate.position[2]"] == solution.plate.position[2]
    assert solution["landing.distance"] is None
    assert solution.to_dict() == json.loads(solution.result.line(), object_hook=_tuples)


def _tuples(block):
    return {key: tuple(x) if isinstance(x, list) else x for key, x in block.items()}
