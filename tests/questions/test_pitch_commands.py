"""`longball movement`, `spin` and `measured`: numbers of single pitches, for a table of them."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

import longball as lb
from longball.cli import tables
from longball.pitches.models import MODELS, STANDARD_GRAVITY
from longball.pitches.statcast import read_measured
from longball.pitches.table import EXAMPLE
from longball.questions.movement import PFX

FEW = 40


@pytest.fixture(scope="module")
def few(tmp_path_factory):
    """The first pitches of the example, as a file."""
    lines = EXAMPLE.read_text(encoding="utf-8").splitlines(keepends=True)
    file = tmp_path_factory.mktemp("table") / "few.csv"
    file.write_text("".join(lines[: FEW + 1]), encoding="utf-8")
    return file


@pytest.mark.parametrize("options", [[], ["--pfx"]])
def test_pitches_move_as_their_nine_parameters_do_in_a_vacuum(called, few, options):
    """The movement is the distance to the pitch that gravity alone moves, at the same time."""
    done = called("movement", few, "--json", *options)
    assert done.returncode == 0, done.stderr
    pitches, rows = read_measured(few, "pitch", spin=False), done.stdout.splitlines()
    assert len(rows) == len(pitches) > FEW // 2
    for i, line in enumerate(rows):
        row = json.loads(line)
        columns = pitches.release[i], pitches.velocity[i], pitches.acceleration[i]
        fit = lb.NineParameters(*(tuple(map(float, x)) for x in columns))
        free = fit.at(PFX) if options else fit
        thrown = {"release": free.position, "velocity": free.velocity}
        alone = lb.solve({"kind": "pitch", "air": None, "pitch": thrown, "gravity": 9.80665})
        plate = fit.at(0.0)
        late = (fit.velocity[0] - plate.velocity[0]) / -fit.acceleration[0]
        begun = (fit.velocity[0] - free.velocity[0]) / -fit.acceleration[0]
        # gravity alone, for as long as the pitch takes
        fall = 0.5 * STANDARD_GRAVITY * (late - begun) ** 2
        place = [free.position[j] + free.velocity[j] * (late - begun) for j in (1, 2)]
        assert alone.outcome in ("crossed", "grounded")
        assert row["across"] == pytest.approx(plate.position[1] - place[0], abs=1e-12)
        assert row["up"] == pytest.approx(plate.position[2] - place[1] + fall, abs=1e-12)
        assert (row["vertical"], row["horizontal"]) == pytest.approx(plate.approach, abs=1e-12)
        assert row["clock"] == lb.clock(row["across"], row["up"])


def test_pitches_have_the_spin_that_each_has_alone(called, few):
    done = called("spin", few, "--json")
    assert done.returncode == 0, done.stderr
    pitches, rows = read_measured(few, "pitch"), done.stdout.splitlines()
    assert len(rows) == len(pitches) > FEW // 2
    for i, line in enumerate(rows):
        row = json.loads(line)
        columns = pitches.release[i], pitches.velocity[i], pitches.acceleration[i]
        fit = lb.NineParameters(*(tuple(map(float, x)) for x in columns))
        late = (fit.velocity[0] - fit.at(0.0).velocity[0]) / -fit.acceleration[0]
        middle = pitches.velocity[i] + 0.5 * late * pitches.acceleration[i]
        weather = pitches.temperature[i].item(), pitches.elevation[i].item()
        alone = lb.spin_from_movement(
            {"kind": "pitch"} | MODELS["nathan"].blocks(*weather),
            middle,
            pitches.acceleration[i],
            rate=pitches.spin_rate[i],
        )
        assert row["transverse"] == pytest.approx(alone.rate, rel=1e-10)
        assert row["active_share"] == pytest.approx(alone.active_share, rel=1e-10)


def test_a_type_whose_spin_nobody_knows_has_no_median(called, few, tmp_path):
    table = pd.read_csv(few)
    table["ax"] *= 40.0  # no spin gives so much lift
    table.to_csv(tmp_path / "wild.csv", index=False)
    done = called("spin", tmp_path / "wild.csv")
    assert done.returncode == 0, done.stderr
    assert "-" in done.stdout.splitlines()[1].split()
    assert "nan" not in done.stdout
    assert "exceeds the limit of the law of lift" in done.stderr


def test_a_speed_and_a_movement_are_enough_for_the_spin(called):
    asked = ["spin", "--speed", "95 mph", "--release", "16.5,0.6,1.8", "--up", "16in"]
    done = called(*asked, "--across", "0.2", "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    scene = found["scene"]
    assert scene["pitch"]["speed"] == pytest.approx(95 * 0.44704, rel=1e-15)
    assert scene["pitch"]["release"] == [16.5, 0.6, 1.8]
    moved = lb.movement(scene)
    assert (moved.across, moved.up) == pytest.approx((0.2, 16 * 0.0254), abs=1e-9)
    assert found["transverse"] == pytest.approx(np.linalg.norm(scene["pitch"]["spin"]), rel=1e-15)
    shown = called(*asked, "--across", "0.2").stdout
    assert f"{found['transverse']:.1f} rad/s" in shown
    assert found["clock"] in shown
    since = called(*asked, "--pfx", "--json")
    assert json.loads(since.stdout)["transverse"] > found["transverse"]
    thin = called(*asked, "--set", "air.density.elevation=1600", "--json")
    assert (
        json.loads(thin.stdout)["transverse"]
        > json.loads(called(*asked, "--json").stdout)["transverse"]
    )


def test_types_of_pitch_are_summed_up(called):
    done = called("spin", "--example")
    assert done.returncode == 0
    assert done.stdout.splitlines()[1].split()[:2] == ["FF", "1441"]
    assert "the active share of 695 pitches is above 1" in done.stderr


@pytest.mark.parametrize("command", ["movement", "spin", "measured"])
def test_rows_in_parts_have_the_same_answers(called, monkeypatch, command):
    whole = called(command, "--example", "--json")
    monkeypatch.setattr(tables, "PART", 1_000)
    parts = called(command, "--example", "--json")
    assert parts.returncode == 0, parts.stderr
    assert parts.stdout == whole.stdout


def test_a_table_without_pitches_says_so(called, few, tmp_path):
    file = tmp_path / "empty.csv"
    file.write_text(few.read_text(encoding="utf-8").splitlines()[0] + "\n", encoding="utf-8")
    done = called("movement", file)
    assert done.returncode == 2
    assert "empty.csv" in done.stderr
