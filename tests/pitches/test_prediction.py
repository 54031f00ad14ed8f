"""Measured balls predicted: what a scene gives comes back, by groups, and as a command."""

import csv
import io
import json
import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from longball.cli import app
from longball.engines import create
from longball.engines.chain import solve
from longball.model.scene import parse_scene
from longball.pitches import EXAMPLE
from longball.pitches.models import ACTIVE_SHARE, MODELS
from longball.pitches.prediction import measured, predict, summaries
from longball.pitches.statcast import read_measured

FOOT, MPH = 0.3048, 0.44704
ENGINE = create("ivp")


def table(*rows):
    lines = [",".join(rows[0]), *(",".join(map(str, row.values())) for row in rows)]
    return "\n".join(lines) + "\n"


def batted_row(scene, model):
    """Return the row of a ball hit at a speed (mph), an angle and a bearing (°), and its result."""
    speed, angle, bearing = scene
    theta, beta = math.radians(angle), math.radians(bearing)
    level = speed * MPH * math.cos(theta)
    velocity = [level * math.cos(beta), -level * math.sin(beta), speed * MPH * math.sin(theta)]
    launch = {"position": [2 * FOOT, 0, 3 * FOOT], "velocity": velocity}
    if MODELS[model].spin:  # of a right-handed batter, by the regression
        rpm = -763 + 120 * angle + 21 * bearing, -849 - 94 * bearing
        back, side = (2 * math.pi / 60 * x for x in rpm)
        level = -side * math.sin(theta)
        launch["spin"] = [
            -back * math.sin(beta) + level * math.cos(beta),
            -back * math.cos(beta) - level * math.sin(beta),
            side * math.cos(theta),
        ]
    blocks = MODELS[model].blocks(293.15, 0.0)
    flight = {"id": "x", "kind": "flight", "launch": launch} | blocks
    landing = solve(parse_scene(json.dumps(flight)), ENGINE).landing
    return {
        "game_pk": 1, "stand": "R", "launch_speed": speed, "launch_angle": angle,
        "hit_distance_sc": repr(float(landing.distance) / FOOT),
        "hc_x": 125.42 + 100 * math.sin(beta), "hc_y": 198.27 - 100 * math.cos(beta),
    }  # fmt: skip


@pytest.mark.parametrize("model", ["vacuum", "paper", "nathan", "giordano", "crisis"])
def test_a_fly_comes_back(model):
    rows = [batted_row(ball, model) for ball in ((100, 30, 0), (80, 15, -20), (95, 55, 40))]
    flies = read_measured(io.StringIO(table(*rows)), "batted")
    prediction = predict(flies, MODELS[model], engine=ENGINE)
    # Lost in feet and back, and in the degrees that a bearing is found from: some 1e-15 of 120 m.
    assert np.abs(prediction.error).max() < 1e-11
    assert not prediction.without
    other = predict(flies, MODELS["vacuum" if model == "paper" else "paper"], engine=ENGINE)
    assert np.abs(other.error).min() > 1.0


@pytest.mark.parametrize(("hand", "sign"), [("R", 1), ("L", -1)])
def test_a_pitch_comes_back(hand, sign):
    # Thrown at (5, -135, -6) ft/s, with 2,300 rpm about an axis seen at 200°, a share of it active.
    velocity = np.array([-135.0, -5.0, -6.0]) * FOOT
    along = velocity / np.linalg.norm(velocity)
    axis = np.array([0.0, -math.cos(math.radians(200)), math.sin(math.radians(200))])
    axis -= axis @ along * along
    axis /= np.linalg.norm(axis)
    share = ACTIVE_SHARE["FF"]
    spin = 2300 * 2 * math.pi / 60 * (share * axis + sign * math.sqrt(1 - share**2) * along)
    release = [(54.5 - 17 / 12) * FOOT, 2 * FOOT, 6 * FOOT]
    pitch = {"release": release, "velocity": velocity.tolist(), "spin": spin.tolist()}
    model = MODELS["nathan"]
    scene = {"id": "x", "kind": "pitch", "pitch": pitch} | model.blocks(293.15, 0.0)
    _, y, z = map(float, solve(parse_scene(json.dumps(scene)), ENGINE).plate.position)
    row = {
        "game_pk": 1, "pitch_type": "FF", "p_throws": hand, "release_spin_rate": 2300,
        "spin_axis": 200, "release_pos_x": -2, "release_pos_y": 54.5, "release_pos_z": 6,
        "vx0": 5, "vy0": -135, "vz0": -6, "ax": 0, "ay": 0, "az": 0,
        "plate_x": repr(-y / FOOT), "plate_z": repr(z / FOOT),
    }  # fmt: skip
    pitches = read_measured(io.StringIO(table(row)), "pitch")
    assert np.abs(predict(pitches, model, engine=ENGINE).error).max() < 1e-12
    # Without its spin it drops by half a metre.
    assert predict(pitches, replace(model, lift=0.0), engine=ENGINE).error[0, 1] < -0.3


def test_groups():
    rows = [batted_row(ball, "vacuum") for ball in ((100, 30, 0), (100, 29.9, 0), (70, 60, 0))]
    prediction = predict(
        read_measured(io.StringIO(table(*rows)), "batted"), MODELS["paper"], ENGINE
    )
    found = {each.group: each for each in summaries(prediction)}
    assert {name: each.count for name, each in found.items()} == {
        "angle 25 to 30°": 1, "angle 30 to 35°": 1, "angle 40 to 60°": 1,
        "speed 60 to 80 mph": 1, "speed 100 to 105 mph": 2, "all": 3,
    }  # fmt: skip
    off = prediction.error[:, 0]
    assert found["all"].bias == pytest.approx([off.mean()])
    assert found["all"].rms == pytest.approx(math.sqrt((off**2).mean()))
    assert found["speed 100 to 105 mph"].bias == pytest.approx([off[:2].mean()])


# ---- the command ---------------------------------------------------------------------------------


def longball(*arguments, stdin=""):
    return CliRunner().invoke(app, ["measured", *arguments], input=stdin)


FLIES = table(
    batted_row((100, 30, 0), "paper"),
    batted_row((80, 15, -20), "paper"),
    batted_row((80, 15, -20), "paper") | {"hc_x": "NA"},
)
COMMAND = ("--kind", "batted", "--model", "paper", "--engine", "ivp")


def test_the_command_prints_what_it_used_and_the_errors():
    run = longball("-", *COMMAND, stdin=FLIES)
    assert run.exit_code == 0
    lines = run.stdout.splitlines()
    assert lines[0].endswith("2 batted balls used of 3 rows")
    assert lines[1] == "  omitted: 1, hc_x is missing (row 3)"
    assert lines[2] == "  weather not known: 2; taken as 20 °C at sea level"
    assert lines[-1].split() == ["all", "2", "+0.00", "0.00"]


def test_the_command_writes_scenes_that_solve_predicts(tmp_path):
    scenes_file, csv_file = tmp_path / "scenes.jsonl", tmp_path / "predictions.csv"
    files = ("--scenes", str(scenes_file), "--csv", str(csv_file), "--json")
    run = longball("-", *COMMAND, *files, stdin=FLIES)
    assert run.exit_code == 0
    data = json.loads(run.stdout)
    assert (data["model"], data["rows_used"], data["components"]) == ("paper", 2, ["distance"])
    assert data["groups"][-1]["group"] == "all"
    with open(csv_file, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    solved = [solve(parse_scene(line), ENGINE) for line in scenes_file.read_text().splitlines()]
    assert [each.id for each in solved] == ["row 1", "row 2"]
    for row, result in zip(rows, solved, strict=True):
        assert float(row["predicted_distance"]) == result.landing.distance


def test_the_command_draws(tmp_path):
    run = longball("-", *COMMAND, "--figure", str(tmp_path / "a.svg"), stdin=FLIES)
    assert run.exit_code == 0
    assert (tmp_path / "a.svg").read_text().startswith("<?xml")
    run = longball("-", *COMMAND, "--figure", str(tmp_path / "a.doc"), stdin=FLIES)
    assert run.exit_code == 2


def test_what_is_wrong_is_said():
    what_if = "launch_speed,launch_angle\n"
    for options, stdin, sentence in (
        ((), f"{what_if}99,0.5\n", "is it in rad?"),
        ((), f"{what_if}46,28\n", "is it in m/s?"),
        (("--games", str(EXAMPLE)), FLIES, "the table of games: temperature"),
    ):
        run = longball("-", *COMMAND, *options, stdin=stdin)
        assert (run.exit_code, run.stdout) == (2, "")
        assert sentence in " ".join(run.stderr.split())


def test_a_row_that_is_no_scene_is_named_and_costs_the_others_nothing(tmp_path):
    # Faster than any double that a scene takes; the table itself has no fault.
    row = batted_row((80, 15, -20), "paper") | {"launch_speed": "1e40"}
    lines = tmp_path / "scenes.jsonl"
    table = FLIES + ",".join(map(str, row.values())) + "\n"
    run = longball("-", "--json", "--scenes", str(lines), *COMMAND, stdin=table)
    assert run.exit_code == 1
    said, alone = (
        json.loads(run.stdout),
        json.loads(longball("-", "--json", *COMMAND, stdin=FLIES).stdout),
    )
    (why,) = said["without_prediction"].keys() - alone["without_prediction"]
    assert why.startswith("row 4 below the header is no scene: launch.velocity[0]: must be")
    assert said["groups"] == alone["groups"]
    assert len(lines.read_text().splitlines()) == alone["rows_used"]


def test_a_speed_and_an_angle_are_predicted(tmp_path):
    picture = tmp_path / "errors.png"
    what_if = "launch_speed,launch_angle\n103,28\n90,30\n"
    run = longball("-", *COMMAND, "--figure", str(picture), stdin=what_if)
    assert run.exit_code == 0
    speed, angle = 103 * 0.44704, math.radians(28)
    launch = {
        "position": [0.6096, 0, 0.9144],
        "velocity": [speed * math.cos(angle), 0, speed * math.sin(angle)],
    }
    scene = parse_scene(json.dumps({"kind": "flight", "launch": launch}))
    feet = solve(scene, ENGINE).landing.distance / 0.3048
    lines = run.stdout.splitlines()
    assert "  no column hc_x: hit to centre field" in lines
    assert lines[-2].split() == ["row", "1", "103.0", "28.0", f"{feet:.1f}"]
    assert "there is no error to draw" in run.stderr
    assert not picture.exists()
    assert json.loads(longball("-", *COMMAND, "--json", stdin=what_if).stdout)["groups"] == []


def test_a_what_if_changes_every_scene():
    run = longball("-", *COMMAND, "--set", "air.drag_coefficient=0.5", "--json", stdin=FLIES)
    flies = read_measured(io.StringIO(FLIES), "batted")
    dragged = replace(MODELS["paper"], drag=0.5)
    *_, every = summaries(predict(flies, dragged, engine=ENGINE))
    assert json.loads(run.stdout)["groups"][-1]["rms"] == every.rms > 1.0


PITCH = {
    "pitch_type": "FF", "p_throws": "R", "release_spin_rate": 2300, "spin_axis": 200,
    "release_speed": 92, "release_pos_x": -2, "release_pos_y": 54.5, "release_pos_z": 6,
    "vx0": 5, "vy0": -135, "vz0": -6, "ax": -10, "ay": 28, "az": -16, "plate_x": 0, "plate_z": 2.5,
}  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "rows", "said"),
    [
        # m/s, of which one passes for a slow fly in mph
        ("batted", [{"launch_speed": v} for v in (40, 42, 45, 61)], "is it in m/s?"),
        # one row in km/h
        (
            "batted",
            [{"launch_speed": v} for v in (103, 100, 166, 95)],
            "launch_speed: row 3 below the header has 166, outside of what is usual, 60 to 125 mph;"
            " is it in km/h or ft/s?",
        ),
        ("batted", [{"launch_speed": v} for v in (103, 50, 40, 95)], None),
        # one row in m, one in rad/s
        ("pitch", [PITCH, PITCH | {"release_pos_y": 16.6}, PITCH], "is it in m?"),
        ("pitch", [PITCH, PITCH | {"release_spin_rate": 240.0}, PITCH], "is it in rad/s?"),
        ("pitch", [PITCH], None),
    ],
)
def test_a_unit_that_betrays_itself_is_asked_about(recwarn, kind, rows, said):
    frame = pd.DataFrame([{"launch_angle": 28} | row for row in rows])
    measured(frame, kind)
    asked = [str(each.message) for each in recwarn]
    run = longball("-", "--kind", kind, stdin=frame.to_csv(index=False))
    assert run.exit_code == 0
    notes = [x.removeprefix("longball: ") for x in run.stderr.splitlines() if "is it in" in x]
    assert notes == asked
    assert (said or "") in "".join(asked)
    assert bool(said) == bool(asked)


def test_what_is_measured_has_no_doubts(recwarn):
    for kind in ("pitch", "batted"):
        assert not read_measured(EXAMPLE, kind).doubts


def test_where_nothing_is_predicted_the_command_fails():
    run = longball("-", *COMMAND, stdin=table(batted_row((80, 15, -20), "paper")))
    assert run.exit_code == 0
    # Thrown so slowly, at 60 ft/s and downwards, that it comes down before the plate.
    pitch = {
        "pitch_type": "EP", "release_pos_x": 0, "release_pos_y": 55, "release_pos_z": 1,
        "vx0": 0, "vy0": -61, "vz0": -20, "ax": 0, "ay": 0, "az": -32, "plate_x": 0, "plate_z": 1,
    }  # fmt: skip
    run = longball("-", "--model", "paper", "--engine", "ivp", stdin=table(pitch))
    assert run.exit_code == 1
    assert "no ball could be predicted" in run.stderr


def test_a_name_that_is_not_there_comes_with_the_nearest(tmp_path):
    own = table({"launch_speed": 103, "launch_angle": 28}).replace("launch_speed", "ExitSpeed")
    run = longball("-", *COMMAND, "--column", "launch_speed=ExitSped", stdin=own)
    assert "no such column, did you mean ExitSpeed? Its columns are" in run.stderr
    (tmp_path / "flies.csv").write_text(own)
    run = longball(str(tmp_path / "fly.csv"), *COMMAND)
    assert "No such file or directory, did you mean flies.csv?" in run.stderr


def test_a_missing_column_comes_with_what_helps():
    run = longball("-", stdin="pitch_type\nFF\n")
    assert "; Statcast's tables have spin_axis from 2020 on, and longball measured " in run.stderr
    run = longball("-", "--model", "paper", stdin="pitch_type\nFF\n")
    assert "--column NAME=COLUMN gives the table's name of a column" in run.stderr
    renamed = FLIES.replace("launch_speed", "ExitSpeed")
    run = longball("-", *COMMAND, "--column", "launch_speed=ExitSpeed", stdin=renamed)
    assert run.exit_code == 0


def test_published_laws_predict_the_flies_of_a_day_to_21_feet():
    flies = read_measured(EXAMPLE, "batted")
    *_, every = summaries(predict(flies, MODELS["nathan"]))
    assert every.count == 385
    assert every.rms < 21 * FOOT
    *_, paper = summaries(predict(flies, MODELS["paper"]))
    # The paper's model, which knows of no spin: 40 ft by every program that was asked.
    assert paper.rms == pytest.approx(40 * FOOT, abs=0.5 * FOOT)
