"""Slips of first-time users: each gets a sentence that says what would be right."""

from __future__ import annotations

import json

import pandas as pd
import pytest

import longball as lb

FLIGHT = {"kind": "flight", "launch": {"position": [0, 0, 1], "velocity": [30, 0, 25]}}
BALL = lb.Flight(**FLIGHT)
FLIES = pd.DataFrame({"launch_speed": [103.0], "launch_angle": [28.0]})
PLACE = {"kind": "flight", "launch.position": [0, 0, 1]}
VECTORS = {"position": (15, 0, 2), "velocity": (-40, 0, 0), "acceleration": (8, 0, -5)}


@pytest.mark.parametrize(
    ("call", "error", "said"),
    [
        (lambda: lb.measured(FLIES, "battd"), ValueError, "did you mean batted"),
        (lambda: lb.measured(3, "batted"), TypeError, "a table is a pandas DataFrame"),
        (lambda: lb.fit_pitches(3), TypeError, "not an object of type int"),
        (lambda: lb.in_parks(BALL, "Fenway Park"), TypeError, r"such as \['Fenway Park'\]"),
        (lambda: lb.park("Sutter Health Park"), ValueError, "no source gives the heights"),
        (lambda: lb.movement(lb.Pitch(), since="a"), TypeError, "since = 'a' is not a number"),
        (lambda: lb.spin_for(lb.Pitch(), 3), TypeError, "a movement is needed, lb.Movement"),
        (
            lambda: lb.NineParameters(**VECTORS | {"position": (1, 2)}),
            ValueError,
            r"position = \(1, 2\): a vector \[x, y, z\]",
        ),
        (
            lambda: lb.fit({"landing.distance": "100"}, BALL, unknowns=["launch.speed"]),
            ValueError,
            "landing.distance = '100': a finite number",
        ),
        (
            lambda: lb.uncertainty(BALL, {"launch.speed": -1}),
            ValueError,
            r"launch.speed must be positive \(got -1\)",
        ),
        # columns: the fault of a cell, and not the shapes of arrays
        (
            lambda: lb.solve_many(PLACE | {"launch.velocity": [[30, 0], [20, 0]]}),
            lb.InvalidScene,
            r"launch.velocity must be \[x, y, z\] in m/s",
        ),
        (
            lambda: lb.solve_many(PLACE | {"launch.velocty": [[30, 0, 25]]}),
            lb.InvalidScene,
            "launch.velocty: unknown key, did you mean velocity",
        ),
        # keys
        (lambda: lb.solve({"Kind": "flight"}), lb.InvalidScene, "is missing, and Kind is no key"),
        (
            lambda: BALL.replace(**{"air.temperature": 20}),
            lb.InvalidScene,
            "temperature is a key of air.density",
        ),
        (lambda: BALL.replace(**{"launch.pos": 1}), lb.InvalidScene, "did you mean position"),
    ],
)
def test_a_wrong_call_says_what_would_be_right(call, error, said):
    with pytest.raises(error, match=said):
        call()


def test_a_column_stands_for_one_component_of_a_vector_for_all():
    columns = PLACE | {"launch.velocity": [30, 0, 25], "launch.position[2]": [1.0, 2.0]}
    distances = lb.solve_many(columns)["landing.distance"].tolist()
    higher = BALL.replace(**{"launch.position": [0, 0, 2]})
    assert distances == [lb.solve(one, "batch").landing.distance for one in (BALL, higher)]


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("flight --speed 103 mph --angle 28", "a value with spaces needs quotes"),
        ("flight --speed 103mph --angle 28 --elevation 5,200ft", "a number has no comma"),
        ("flight --speed 103mph --angle 80", "the spin is from a regression for 10° to 60°"),
        ("spin --speed 95 --up 16in", "95 m/s is more than in any game; is it in km/h, mph"),
        ("spin t.csv --speed 95mph", "--speed is for a single pitch: omit the table"),
        ("movement t.csv", "--column NAME=COLUMN gives the table's name of a column"),
        ("homerun --pitches s.jsonl", "not the result of longball fit --json: source: is missing"),
        ("homerun --e 0.4:0.5", "must be FIRST:LAST:STEP"),
    ],
)
def test_a_wrong_command_says_what_would_be_right(called, tmp_path, monkeypatch, command, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "t.csv").write_text("launch_speed\n103\n", encoding="utf-8")
    (tmp_path / "s.jsonl").write_text(json.dumps(FLIGHT), encoding="utf-8")
    assert said in called(*command.split()).stderr
