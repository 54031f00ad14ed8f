"""The command line, called in this process; `test_environment.py` has what hangs on a process."""

from __future__ import annotations

import csv
import json
import math
import re
import subprocess
import sys
from functools import partial
from pathlib import Path

import pandas as pd
import pytest

import longball as lb
from longball import cli, table_files
from longball.cli.options import COMMANDS as USAGE
from longball.cli.scenes import read_scenes
from longball.cli.solve import ENGINE_OPTIONS
from longball.golden import probabilities
from longball.home_run.quadrature import Nodes
from longball.pitches import EXAMPLE

FLIGHT = b'{"id":"f","kind":"flight","launch":{"position":[0,0,1],"velocity":[30,2,20]}}'
AT_BAT = b'{"id":"a","kind":"at-bat"}'


def results(run: subprocess.CompletedProcess) -> list[dict]:
    return [json.loads(line) for line in run.stdout.splitlines()]


class TestSolve:
    def test_reads_stdin_and_answers_in_order(self, called):
        run = called("solve", "-", stdin=FLIGHT + b"\n\n" + AT_BAT)
        assert run.returncode == 0
        assert run.stderr == ""
        assert [(r["id"], r["outcome"]) for r in results(run)] == [("f", "landed"), ("a", "batted")]

    def test_reads_and_writes_files(self, called, tmp_path: Path):
        source, output = tmp_path / "scenes.jsonl", tmp_path / "results.jsonl"
        source.write_bytes(FLIGHT + b"\r\n" + AT_BAT + b"\r\n")
        run = called("solve", str(source), "-o", str(output))
        assert run.returncode == 0
        assert run.stdout == ""
        assert len(output.read_bytes().splitlines()) == 2

    def test_bad_lines_are_answered_and_lose_nothing(self, called):
        lines = [
            AT_BAT,
            AT_BAT[:-3],
            b"\x80\xff\x00",
            b'{"id":"n","kind":"pitch","gravity":NaN}',
            FLIGHT,
        ]
        run = called("solve", stdin=b"\n".join(lines))
        assert run.returncode == 1
        assert "3 of 5 lines" in run.stderr
        first, truncated, binary, nan, last = results(run)
        assert first["outcome"] == "batted"
        assert truncated["id"] == "2"
        assert truncated["error"].startswith("line 2: not JSON")
        assert "line 3: not UTF-8" in binary["error"]
        assert nan["id"] == "n"
        assert "line 4: gravity" in nan["error"]
        assert last["outcome"] == "landed"

    @pytest.mark.parametrize("name", ["results.csv", "results.parquet"])
    def test_tables_go_in_and_come_out(self, called, tmp_path: Path, name: str):
        source, output = tmp_path / "scenes.csv", tmp_path / name
        source.write_text(
            "id,kind,pitch.speed,pitch.aim[1],air\n007,pitch,38.6,1.7,\nb,pitch,,,null\nc,pitch,-1,,"
        )
        run = called("solve", str(source), "-o", str(output))
        assert run.returncode == 1  # the third row
        # As texts: pandas 2 rounds the last digit of a number another way than Python.
        read = pd.read_parquet if output.suffix == ".parquet" else partial(pd.read_csv, dtype=str)
        table = read(output)
        assert table.id.astype(str).str.lstrip("0").tolist() == ["7", "b", "c"]
        scenes = [
            lb.Pitch(pitch={"speed": 38.6, "aim": [0, 1.7]}),
            lb.Pitch(air=None),
        ]
        assert [*map(float, table["plate.time"][:2])] == [lb.solve(x).plate.time for x in scenes]
        assert table.error[2].startswith("line 4: pitch.speed")
        same = called("solve", str(source))
        assert [r["id"] for r in results(same)] == ["007", "b", "c"]

    def test_rows_of_a_table_are_numbered_as_its_lines(self, tmp_path: Path):
        table = tmp_path / "scenes.csv"
        table.write_text(
            'kind,pitch.speed,air\n\npitch,.5e2,\npitch,30,"{""density"":\n1}",\n,,\npitch,-1\n'
        )
        lines = table_files.scene_lines(table).split(b"\n")
        assert [n for n, line in enumerate(lines, 1) if line] == [3, 4, 7]
        assert json.loads(lines[3]) == {
            "kind": "pitch", "pitch": {"speed": 30}, "air": {"density": 1},
        }  # fmt: skip
        assert json.loads(lines[2])["pitch"] == {"speed": 50.0}

    def test_a_table_that_does_not_fit_its_head_is_refused(self, tmp_path):
        table = tmp_path / "scenes.csv"
        for text, said in (
            ("kind,gravity,\npitch,9,8", "line 2: '8' is in a column without a name"),
            ("kind,pitch.aim[99999999999]\npitch,9", "no list has so many places"),
            ("kind;gravity\npitch;9,8", "head has semicolons where commas must"),
        ):
            table.write_text(text)
            with pytest.raises(ValueError, match=said):
                table_files.scene_lines(table)

    def test_an_ending_in_capitals_is_one(self, called, tmp_path: Path):
        source, output = tmp_path / "SCENES.CSV", tmp_path / "RESULTS.CSV"
        source.write_text("kind\npitch\n")
        assert called("solve", str(source), "-o", str(output)).returncode == 0
        assert pd.read_csv(output).outcome.tolist() == ["crossed"]

    def test_spaces_around_names_mean_nothing(self, tmp_path: Path):
        table = tmp_path / "scenes.csv"
        table.write_text('kind, pitch.speed , air\npitch, 30, "{""density"": 1}"\n')
        _, line = table_files.scene_lines(table).split(b"\n")
        assert json.loads(line) == {
            "kind": "pitch", "pitch": {"speed": 30}, "air": {"density": 1},
        }  # fmt: skip

    def test_a_table_that_makes_no_sense_is_a_wrong_call(self, called, tmp_path: Path):
        source = tmp_path / "scenes.csv"
        source.write_text("kind,pitch speed\npitch,3")
        run = called("solve", str(source))
        assert (run.returncode, run.stdout) == (2, "")
        assert "'pitch speed' is not the name" in run.stderr
        run = called("solve", "--path", "-o", str(tmp_path / "results.csv"))
        assert run.returncode == 2
        assert "cannot hold paths" in run.stderr

    @pytest.mark.parametrize("engine", ["ivp", "batch"])
    def test_the_path_is_in_the_result(self, called, engine: str):
        scenes = b"\n".join([AT_BAT, FLIGHT] * 10)
        run = called("solve", "--points", "5", "--engine", engine, stdin=scenes)
        at_bat, flight = results(run)[:2]
        assert [row[0] for row in flight["path"]] == pytest.approx(
            [flight["landing"]["time"] * i / 4 for i in range(5)]
        )
        assert flight["path"][0] == [0, 0, 0, 1, 30, 2, 20]
        end = at_bat["landing"]["time"], *at_bat["landing"]["position"]
        assert at_bat["path"][-1][:4] == pytest.approx(end, abs=1e-12)
        assert len(results(called("solve", "--path", stdin=FLIGHT))[0]["path"]) == 201

    @pytest.mark.parametrize("engine", ["ivp", "batch"])
    def test_scenes_are_changed_by_options(self, called, tmp_path: Path, engine: str):
        launch = {"position": [0, 0, 1], "velocity": [40, 0, 25]}
        park = {"polyline": [[70, 70, 2], [70, -70, 2]]}
        (tmp_path / "park.json").write_text(json.dumps(park))
        scene = {"kind": "flight", "launch": launch}
        changes = {"air": {"wind": [5, 0, 0]}, "reading": {"wind_acts_on": "drag"}, "fence": park}
        run = called(
            "solve", "--engine", engine, "--set", "air.wind=[18, 0, 0] km/h",
            "--reading", "wind_acts_on=drag", "--fence", str(tmp_path / "park.json"),
            stdin=json.dumps(scene).encode(),
        )  # fmt: skip
        plain = called("solve", "--engine", engine, stdin=json.dumps(scene | changes).encode())
        assert json.loads(run.stdout)["outcome"] == "home_run"
        assert run.stdout == plain.stdout

    def test_a_change_reaches_workers(self, called):
        lines = b'{"kind":"pitch"}\n' * 40
        alone = called("solve", "--set", "pitch.speed=95mph", stdin=lines)
        many = called("solve", "--set", "pitch.speed=95mph", "--workers", "2", stdin=lines)
        assert many.stdout == alone.stdout
        assert alone.stdout != called("solve", stdin=lines).stdout

    def test_what_is_probably_not_meant_is_asked(self, called):
        lines = b'{"kind":"pitch","ball":{"mass":145}}\n' * 2
        run = called("solve", stdin=lines)
        assert run.returncode == 0
        (said,) = run.stderr.splitlines()
        assert said == (
            "longball: scene 1: ball.mass: 145 kg is more than in any game; is it in g or oz? "
            "(and 1 more)"
        )
        high = called("flight", "--speed", "103mph", "--angle", "80").stderr
        assert "the spin is from a regression for 10° to 60°" in high
        fast = called("spin", "--speed", "95", "--up", "16in").stderr
        assert "95 m/s is more than in any game; is it in km/h, mph" in fast
        assert called("solve", "--quiet", stdin=lines).stderr == ""

    @pytest.mark.parametrize(
        ("name", "content", "said"),
        [
            (
                "a.jsonl",
                b"PK\x03\x04",
                "not text but a spreadsheet or a zip archive; save the sheet",
            ),
            ("a.jsonl", b"\x1f\x8b\x08", "not text but gzip; gunzip unpacks it"),
            ("a.parquet", b"kind\npitch\n", "not Parquet: its first four bytes must be PAR1"),
            ("a.csv", b"player,mph\nA,103\n", "no column is a key of a scene, such as kind or"),
        ],
    )
    def test_a_file_of_something_else_is_one_sentence(self, called, tmp_path, name, content, said):
        file = tmp_path / name
        file.write_bytes(content)
        run = called("solve", str(file))
        assert (run.returncode, run.stdout) == (2, "")
        assert f"{file}: {said}" in run.stderr

    def test_utf16_lines_are_named(self, called):
        (line,) = results(called("solve", stdin='{"kind":"pitch"}'.encode("utf-16")))
        assert line["error"].endswith("iconv -f utf-16 -t utf-8 converts UTF-16")

    def test_the_source_is_not_overwritten(self, called, tmp_path: Path):
        source, link = tmp_path / "scenes.jsonl", tmp_path / "link.jsonl"
        source.write_bytes(FLIGHT)
        link.hardlink_to(source)
        for read, written in ((source, source), (source, link), (link, source)):
            run = called("solve", str(read), "-o", str(written))
            assert run.returncode == 2
            assert "is also the input" in run.stderr
            assert source.read_bytes() == FLIGHT


def test_scenes_without_an_id_bear_the_number_of_their_line(called, tmp_path: Path):
    file = tmp_path / "scenes.jsonl"
    file.write_bytes(b'\n{"kind":"pitch"}\n\n' + AT_BAT + b'\n{"kind":"pitch"}\n')
    assert [scene.id for scene in read_scenes(str(file))] == ["2", "a", "5"]
    answers = tmp_path / "answers.jsonl"
    assert called("solve", str(file), "-o", str(answers)).returncode == 0
    run = called("judge", "--scenes", str(file), "--results", str(answers))
    assert run.returncode == 0, run.stdout
    table = tmp_path / "scenes.csv"
    table.write_text("kind,id\npitch,\npitch,a\n")
    assert [scene.id for scene in read_scenes(str(table))] == ["2", "a"]
    file.write_bytes(b"\nnonsense")
    run = called("converge", "--scenes", str(file), "--", "true", "{dt}")
    assert f"{file}, line 2: not JSON" in run.stderr


class TestPlot:
    def test_paths_are_drawn(self, called, tmp_path: Path):
        pictures = [tmp_path / name for name in ("p.svg", "p.png")]
        for picture in pictures:
            run = called("plot", "-o", str(picture), stdin=AT_BAT + b"\n" + FLIGHT)
            assert run.returncode == 0
            assert run.stdout == ""
            assert run.stderr == f"longball: the picture is in {picture}\n"
        assert b"<svg" in pictures[0].read_bytes()
        assert pictures[1].read_bytes().startswith(b"\x89PNG")

    @pytest.mark.parametrize("fence", [{"radius": 80}, {"polyline": [[70, 70, 2], [70, -70, 2]]}])
    def test_fences_are_drawn(self, called, fence, tmp_path: Path):
        scene = json.loads(FLIGHT) | {"kind": "flight"}
        pictures = [tmp_path / name for name in ("with.svg", "without.svg")]
        for picture, more in zip(pictures, ({"fence": fence}, {}), strict=True):
            line = json.dumps(scene | more).encode()
            assert called("plot", "-o", str(picture), stdin=line).returncode == 0
        lines = [picture.read_text(encoding="utf-8").count("#999999") for picture in pictures]
        assert lines[0] > lines[1]

    def test_many_balls_are_a_spray_chart(self, called, tmp_path: Path):
        def plotted(count: int) -> str:
            velocities = [[5, -15, 10], *[[30, 2, 20]] * (count - 1)]
            launches = ({"position": [0, 0, 1], "velocity": velocity} for velocity in velocities)
            scenes = ({"kind": "flight", "launch": launch} for launch in launches)
            lines = "\n".join(map(json.dumps, scenes)).encode()
            picture = tmp_path / "p.svg"
            assert called("plot", "-o", str(picture), "--fence", "70", stdin=lines).returncode == 0
            return picture.read_text(encoding="utf-8")

        spray = plotted(20)
        assert "<!-- home run (19) -->" in spray
        assert "<!-- foul (1) -->" in spray
        assert "towards centre field" in spray
        assert "height z (m)" in plotted(3)

    def test_many_pitches_are_paths(self, called, tmp_path: Path):
        picture = tmp_path / "p.svg"
        lines = b'{"kind": "pitch"}\n' * 20
        assert called("plot", "-o", str(picture), stdin=lines).returncode == 0
        assert "height z (m)" in picture.read_text(encoding="utf-8")


class TestGolden:
    def test_list_path_and_export(self, called, tmp_path: Path):
        listed = called("golden", "list", "--json")
        assert json.loads(listed.stdout)["families"]["hard"]["file"] == "hard.jsonl"
        assert "flight-both" in called("golden", "list", "--quiet").stdout
        folder = called("golden", "path").stdout.strip()
        assert (Path(folder) / "header.json").is_file()
        archive = tmp_path / "golden.zip"
        run = called("golden", "export", str(archive), "--quiet")
        assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
        assert archive.read_bytes().startswith(b"PK")
        assert called("golden", "list", str(tmp_path)).returncode == 2


class TestHomerun:
    def test_json_holds_the_contract(self, called):
        run = called("homerun", "--samples", "60", "--e", "0.41:0.45:0.02", "--json",
                       "--workers", "1", "--reading", "inertia=about_centre", "--reading",
                       "sample_space=batted", "--reading", "fig7_parameters=text")  # fmt: skip
        assert run.returncode == 0
        data = json.loads(run.stdout)
        assert [row["e"] for row in data["rows"]] == [0.41, 0.43, 0.45]
        for row in data["rows"]:
            assert row["low"] <= row["p"] <= row["high"]
            assert row["p"] == row["home_runs"] / row["trials"]
        assert data["reading"] == {
            "inertia": "about_centre", "sample_space": "batted", "fig7_parameters": "text",
        }  # fmt: skip

    @pytest.mark.nightly
    def test_quadrature_has_errors_and_slopes(self, called, tmp_path: Path, monkeypatch):
        # Two rules that take little, and differ in both numbers: their difference is the error. The
        # errors of better ones are tested with the golden data.
        monkeypatch.setattr("longball.home_run.quadrature.LEVELS", (Nodes(2, 1), Nodes(3, 2)))
        table, figure = tmp_path / "p.csv", tmp_path / "p.png"
        files = ("--csv", str(table), "--figure", str(figure))
        run = called("homerun", "--method", "quadrature", "--e", "0.45", "--json", *files)
        assert run.returncode == 0
        data = json.loads(run.stdout)
        assert (data["method"], data["fit"]) == ("quadrature", None)
        (row,) = data["rows"]
        assert set(row) == {"e", "p", "error", "slope", "slope_error"}
        (known,) = [x for x in probabilities().cases[0].rows if x.e == 0.45]
        assert abs(row["p"] - known.p) <= row["error"] + known.error
        assert abs(row["slope"] - known.slope) <= row["slope_error"] + known.slope_error
        with open(table, encoding="utf-8", newline="") as file:
            (written,) = csv.DictReader(file)
        assert {name: float(value) for name, value in written.items()} == row
        assert figure.read_bytes().startswith(b"\x89PNG")

    def test_the_paper_has_no_curve_for_another_fence(self, called, tmp_path: Path):
        few = ("homerun", "--samples", "20", "--e", "0.42", "--fence")
        run = called(*few, "100", "--figure", str(tmp_path / "p.png"), "--json")
        assert run.returncode == 0
        data = json.loads(run.stdout)
        assert (data["paper"], data["fit"]) == ({}, None)
        run = called(*few, "150")
        assert "paper's caption" in run.stdout
        assert "need 3 values of e" in run.stdout

    def test_writes_table_picture_and_scenes(self, called, tmp_path: Path):
        table, picture, scenes = (tmp_path / name for name in ("p.csv", "p.png", "s.jsonl"))
        run = called(
            "homerun", "--samples", "12", "--e", "0.42,0.44", "--workers", "1",
            "--csv", str(table), "--figure", str(picture), "--scenes", str(scenes),
        )  # fmt: skip
        assert run.returncode == 0
        assert "paper's caption" in run.stdout
        assert [row["e"] for row in csv.DictReader(table.read_text().splitlines())] == [
            "0.42",
            "0.44",
        ]
        assert picture.read_bytes().startswith(b"\x89PNG")
        solved = called("solve", str(scenes))
        assert solved.returncode == 0
        assert [r["id"] for r in results(solved)][:2] == [
            "sample-000000-e0.42",
            "sample-000000-e0.44",
        ]
        assert len(results(solved)) == 24


TABLE = "kind,v,cell\n" + "".join(
    f"{kind},{base + 0.1 * i},{1 + i % 5}\n"
    for kind, base in (("fast", 139.0), ("slow", 127.0))
    for i in range(40)
)


class TestFit:
    @pytest.mark.nightly
    def test_columns_and_units_are_told_by_options(self, called):
        columns = (
            "pitch_type=kind", "speed=v", "speed_unit=km/h", "across=cell", "place_unit=cell",
            "height=null", "view=pitcher",
        )  # fmt: skip
        options = [word for column in columns for word in ("--column", column)]
        rows = TABLE + "fast,,3\nslow,120.0,\n"
        run = called("fit", "-", "--json", "--straight", "fast", *options, stdin=rows.encode())
        assert run.returncode == 0
        fitted = json.loads(run.stdout)
        assert (fitted["rows_read"], fitted["rows_used"]) == (82, 80)
        # 139.0 to 142.9 in steps of 0.1: their mean is 140.95 km/h.
        mean = fitted["speed"]["straight_mean"]["value"]
        assert mean * 3.6 == pytest.approx(140.95, rel=1e-12)
        assert fitted["aim"]["cells"] == [16, 16, 16, 16, 16]
        assert {each["reason"]: each["first_rows"] for each in fitted["left_out"]} == {
            "v is missing": [81],
            "cell is missing": [82],
        }

    @pytest.mark.nightly
    def test_what_is_fitted_is_drawn_from(self, called, tmp_path: Path):
        path = tmp_path / "fitted.json"
        path.write_text(called("fit", "--example", "--json").stdout, encoding="utf-8")
        few = ("--samples", "300", "--e", "0.42", "--workers", "1")
        scenes = tmp_path / "s.jsonl"
        run = called("homerun", "--pitches", str(path), *few, "--scenes", str(scenes))
        assert run.returncode == 0
        speeds = [json.loads(line)["pitch"]["speed"] for line in scenes.read_text().splitlines()]
        # The mean of a day of MLB's is 39.9 m/s, of the paper's pitches 36.9; s/√300 is 0.15.
        with open(EXAMPLE, encoding="utf-8") as file:
            mph = [float(row["release_speed"]) for row in csv.DictReader(file)]
        expected = 0.44704 * sum(mph) / len(mph)
        assert sum(speeds) / len(speeds) == pytest.approx(expected, abs=4 * 0.16)
        table = lb.home_run_probability(0.42, "monte-carlo", samples=300, pitches=path)
        assert f"0.42  {table.p[0]:.4f}" in run.stdout


class TestReadings:
    def test_says_what_each_reading_does(self, called):
        run = called("readings", "--samples", "20", "--workers", "1", "--json")
        rows = json.loads(run.stdout)["rows"]
        ledger = {entry["switch"]: entry["belongs"] for entry in json.loads(run.stdout)["ledger"]}
        for row in rows:
            asked = ledger[row["switch"]] in ("scene", "sampling") and row["switch"] not in (
                "masses",
                "friction",
            )
            assert ("p" in row) == asked


def test_help_imports_no_command():
    code = (
        "import sys; sys.argv = ['longball', '--help']; from longball.__main__ import main\n"
        "try: main()\nfinally: print({'numpy', 'pydantic', 'rich'} & set(sys.modules))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    assert run.stdout.endswith("set()\n")
    for name in cli.MODULES:
        assert re.search(rf"^  {name} +[A-Z]", run.stdout, re.MULTILINE)


@pytest.mark.parametrize(
    ("what", "more"),
    [
        ("import longball", {"numpy", "pydantic", "typer"}),
        ("import longball.cli", {"numpy", "pydantic", "rich"}),
        ("import longball.pitches", set()),
        ("import longball.model.impact", {"numpy"}),
        ("from longball import golden; golden.load('impact')", set()),
    ],
)
def test_heavy_libraries_wait_until_they_are_needed(what: str, more: set[str]):
    heavy = {"sympy", "pandas", "matplotlib", "numba", "flint", "mpmath", "joblib", "scipy"} | more
    code = f"import sys; {what}; print(*({heavy} & set(sys.modules)))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert run.stdout.strip() == b""


# --- aim and infer --------------------------------------------------------------------------------

VACUUM = (
    b'{"kind": "flight", "air": null, "launch": {"position": [0, 0, 0], "velocity": [40, 0, 5]}}'
)


def test_aim_prints_scenes_that_hit(called):
    done = called("aim", "--target", "100m", stdin=VACUUM)
    assert done.returncode == 0
    # d = v² sin 2θ / g
    low = 0.5 * math.asin(9.8 * 100 / 1625)
    angles = [
        math.atan2(velocity[2], velocity[0])
        for velocity in (json.loads(x)["launch"]["velocity"] for x in done.stdout.splitlines())
    ]
    assert angles == pytest.approx([low, math.pi / 2 - low], rel=1e-12)


def test_infer_finds_what_was_launched(called, tmp_path):
    points = tmp_path / "points.csv"
    points.write_text("t,x,y,z\n0.5,12.5,0,8\n1.0,25,0,\n", encoding="utf-8")
    unknowns = ["--unknown", "launch.velocity[0]", "--unknown", "launch.velocity[2]"]
    done = called("infer", "--points", points, *unknowns, "--json", "--sigma", "0.1", stdin=VACUUM)
    found = json.loads(done.stdout)
    # 8 = w/2 - 9.8/8
    assert found["value"] == pytest.approx(
        {"launch.velocity[0]": 25.0, "launch.velocity[2]": 18.45}, rel=1e-12
    )
    assert found["scene"]["launch"]["velocity"] == pytest.approx([25.0, 0.0, 18.45], rel=1e-12)
    measured = "--measured", "landing.distance=10000 cm"
    far = called("infer", *measured, "--unknown", "gravity", "--json", stdin=VACUUM)
    # 2 u w/d
    assert json.loads(far.stdout)["value"] == pytest.approx({"gravity": 2 * 40 * 5 / 100})


def test_predictions_keep_what_identifies_a_row(called, tmp_path):
    table, predictions, scenes = (tmp_path / name for name in ("a.csv", "b.csv", "c.jsonl"))
    table.write_text(
        "launch_speed,launch_angle,player_name,game_pk,events\n"
        '80,5,"Doe, Jo",1,single\n'
        '103,28,"Doe, Pat",1,home_run\n'
        "95,35,,2,field_out\n",
        encoding="utf-8",
    )
    files = "--csv", str(predictions), "--scenes", str(scenes)
    assert called("measured", str(table), "--kind", "batted", *files).returncode == 0
    with open(predictions, encoding="utf-8", newline="") as file:
        rows = [*csv.DictReader(file)]
    assert [(row["row"], row["game_pk"], row["player_name"], row["events"]) for row in rows] == [
        ("2", "1", "Doe, Pat", "home_run"),
        ("3", "2", "", "field_out"),
    ]
    ids = [json.loads(line)["id"] for line in scenes.read_text(encoding="utf-8").splitlines()]
    assert ids == ["row 2, 1, Doe, Pat, home_run", "row 3, 2, field_out"]


def test_commands_use_the_options_that_they_have():
    """Options have no types, so that no linter finds a name that is none."""
    folder = Path(cli.__file__).parent
    used = {
        file.stem: {*re.findall(r"\bo\.(\w+)", file.read_text(encoding="utf-8"))}
        for file in folder.glob("*.py")
    }
    shared = used["tables"] | used["cluster"] | {"set", "fence", "reading", "games"}
    shared |= {*ENGINE_OPTIONS.values()}
    declared: dict[str, set[str]] = {}
    for command, words in USAGE.items():
        names = {re.match(r"\w+", word)[0] for word in words.split()}
        declared.setdefault(command.split()[0], set()).update(names)
    for module, names in declared.items():
        assert used[module] - {"refuse"} <= names, module
        assert names <= used[module] | shared, module
