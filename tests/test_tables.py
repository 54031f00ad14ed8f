"""Many scenes at once: a row that is no scene, or has no answer, costs the others nothing."""

from __future__ import annotations

import csv
import json
import math
import pickle
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import longball as lb
from longball import table_files
from longball.engines import create
from longball.engines.lines import solve_lines
from longball.judge.answers import read_results
from longball.model.csv_files import guarded, unguarded
from longball.model.quantities import flat, nested


def listed(columns: dict[str, object], count: int) -> list[dict[str, object]]:
    """Return the scenes of columns, one by one, as a user would write them."""
    rows = []
    for i in range(count):
        row = {n: x[i] if isinstance(x, list) and n != "launch" else x for n, x in columns.items()}
        rows.append(nested(dict(flat({n: x for n, x in row.items() if x is not None}))))
    return rows


PITCHED = {"kind": "at-bat", "pitch": {"speed": 38.0, "aim": [0, 1.7]}, "swing": {"tilt": 0.1}}
LAUNCHED = {"kind": "flight", "launch": {"position": [0, 0, 1], "velocity": [30.0, 0.0, 25]}}


def test_dicts_have_the_answers_of_their_scenes():
    """With ids or without, of two kinds in turn, and with faults: each as if it were alone."""
    scenes: list[Any] = []
    for i in range(300):
        scene = json.loads(json.dumps(PITCHED if i % 2 else LAUNCHED))
        key, block = ("pitch", "aim") if i % 2 else ("launch", "velocity")
        scene[key][block][1] += 0.001 * i
        scenes.append(scene | ({"id": f"é{i}"} if i % 3 else {}))
    faults = [1, "7", -1, None, True, 2**60, math.nan, np.float32(40), {}, "\ud800"]
    for i, fault in enumerate(faults):
        scenes[30 * i + 1]["pitch"]["speed"] = fault
    scenes[44] |= {"launch.velocity": [30, 0, 25]}  # a column's name is no key
    scenes[46]["id"], scenes[48]["id"], scenes[50] = "", 7, "no scene"

    alone = [one for i in range(0, 300, 10) for one in lb.solve_many(scenes[i : i + 10])]
    together = lb.solve_many(scenes, workers=1)
    assert [x.apex for x in together] == [x.apex for x in alone]
    assert [x.to_dict() for x in together] == [x.to_dict() for x in alone]
    assert [x.scene for x in together] == [x.scene for x in alone]
    assert sum(x.error is not None for x in together) == 11


def test_a_solution_has_the_scene_that_was_solved():
    scenes = [json.loads(json.dumps(LAUNCHED)) for _ in range(100)]
    solutions = lb.solve_many(scenes)
    scenes[1]["launch"]["velocity"][0] = 10.0
    scene = pickle.loads(pickle.dumps(solutions[1])).scene
    assert scene.as_written() == lb.Flight(launch=LAUNCHED["launch"]).as_written()
    assert solutions[1].path.end == solutions[0].landing.time


SMALL = st.sampled_from([-20.0, -1.0, 0.0, 1.0, 20.0])
BAD = st.sampled_from([None, "20", True, [1], -1e31, float("inf")])
NAMES = ["launch.velocity[0]", "launch.velocity[2]", "launch.spin[2]", "launch.position[2]"]


@st.composite
def some_columns(draw) -> tuple[int, dict[str, object]]:
    """Number of rows, and columns: spins beside velocities, starts underground, no numbers."""
    count, columns = draw(st.integers(2, 4)), {}
    for name in draw(st.lists(st.sampled_from(NAMES), min_size=1, max_size=3, unique=True)):
        cells = st.lists(SMALL, min_size=count, max_size=count)
        columns[name] = draw(cells | st.lists(SMALL | BAD, min_size=count, max_size=count))
    return count, columns


@settings(max_examples=25)
@given(some_columns(), st.sampled_from(["batch", "ivp"]))
# Between two velocities that are no multiples of the spin one is.
@example((3, {"launch.velocity[0]": [-10.0, 0.0, 10.0], "launch.velocity[2]": [20.0] * 3}), "batch")
def test_columns_have_the_answers_and_the_errors_of_their_scenes(some, engine: str):
    count, columns = some
    usual = {"launch.position": [0, 0, 1], "launch.velocity": [20, 0, 20], "launch.spin": [0, 0, 5]}
    columns = {"kind": "flight", "time_limit": 5.0, **dict(flat(usual)), **columns}
    alone = lb.solve_many(listed(columns, count), engine)
    if all(one.code == "invalid" for one in alone):
        with pytest.raises(lb.InvalidScene, match="no row is a scene"):
            lb.solve_many(columns, engine)
        return
    table = lb.solve_many(columns, engine)
    for row, one in zip(table.to_dict("records"), alone, strict=True):
        told = {n: x for n, x in row.items() if isinstance(x, list | tuple) or not pd.isna(x)}
        wanted = {n: x for n, x in flat(one.result.data()) if x is not None}
        assert told == wanted


def test_a_cell_that_contradicts_another_is_the_error_of_its_row(tmp_path: Path):
    columns = {"kind": "pitch", "air": ["null", None], "air.density": [1.2, 1.3]}
    table = lb.solve_many(columns)
    said = "air.density: unknown key; put it inside air, not beside it"
    assert table.error[0] == said
    assert table.outcome[1] == "crossed"
    # Whichever stands first.
    again = lb.solve_many(dict(reversed(columns.items())))
    assert again.error[0] == said
    file = tmp_path / "scenes.csv"
    file.write_text("kind,air.density,air\npitch,1.2,null\npitch,1.3,\n")
    first, second = map(json.loads, table_files.scene_lines(file).splitlines()[1:])
    assert (first["air"], second["air"]) == (None, {"density": 1.3})
    assert lb.solve_many([first])[0].error == said


def test_odd_cells_of_files_are_errors_of_their_rows(tmp_path: Path):
    parquet = tmp_path / "scenes.parquet"
    days = pd.to_timedelta([3, None], unit="D")
    pd.DataFrame({"kind": "pitch", "pitch.speed": days}).to_parquet(parquet)
    text = tmp_path / "scenes.csv"
    text.write_text("kind,gravity\npitch," + "[" * 100_000 + "\npitch,NaN\npitch,9.8\n")
    odd, usual = lb.solve_many(table_files.scene_lines(parquet).splitlines())
    assert odd.error == "pitch.speed: must be a number in m/s (got '3 days 00:00:00')"
    assert usual.outcome == "crossed"
    nested_, nan, usual = lb.solve_many(table_files.scene_lines(text).splitlines()[1:])
    assert nested_.error.startswith("gravity: must be a number in m/s²")
    assert nan.error == "gravity: must be a finite number (got nan)"
    assert usual.outcome == "crossed"


def test_a_number_that_overflows_in_one_row_does_so_in_no_other():
    """exp(1.217e-4 · 1e30 m), the pressure below the sea, is beyond doubles."""
    launch = {"position": [0, 0, 1], "velocity": [30, 0, 20]}
    heights = [0.0] * 20 + [-1e30]
    scenes = [
        {"kind": "flight", "launch": launch, "air": {"density": {"elevation": h}}} for h in heights
    ]
    *usual, last = lb.solve_many(scenes)
    assert {one.outcome for one in usual} == {"landed"}
    assert last.code == "out_of_range"
    columns = {"kind": "flight", "launch": launch, "air.density.elevation": heights}
    assert lb.solve_many(columns).code.isna().tolist() == [True] * 20 + [False]


# --- types of numbers -----------------------------------------------------------------------------


def time_at(**pitch) -> float:
    return lb.solve({"kind": "pitch", "pitch": pitch}, "batch").plate.time


@pytest.mark.parametrize(
    "column",
    [
        np.ma.array([40.0, 30.0], mask=[False, True]),
        np.ma.array([40, 30], mask=[False, True]),
        [40.0, np.ma.masked],
        [40.0, None],
        pd.Series([40, None], dtype="Int64"),
        [Decimal(40), pd.NA],
    ],
)
@pytest.mark.parametrize("engine", ["batch", "ivp"])
def test_what_is_masked_is_not_given(column, engine: str):
    table = lb.solve_many({"kind": "pitch", "pitch.speed": column}, engine)
    wanted = [time_at(speed=40.0), time_at()]
    assert table["plate.time"].tolist() == pytest.approx(wanted, rel=1e-14)


@pytest.mark.parametrize(
    "column",
    [
        np.array([40, 30], "m8[ns]"),
        np.array(["2026-01-01"] * 2, "M8[ns]"),
        pd.to_timedelta([40, 30], unit="s"),
        pd.Series(pd.to_timedelta([40, 30], unit="ns")),
        np.array([40 + 0j, 30]),
        np.array([True, True]),
        np.array([b"40", b"30"]),
        np.longdouble("1e4000"),
        10**400,
        np.timedelta64(40, "ns"),
    ],
)
@pytest.mark.parametrize("engine", ["batch", "ivp"])
def test_what_is_no_number_is_refused_by_the_name_of_its_column(column, engine: str):
    with pytest.raises(lb.InvalidScene, match=r"no row is a scene: pitch\.speed: must be"):
        lb.solve_many({"kind": "pitch", "pitch.speed": column}, engine)


# --- who flew -------------------------------------------------------------------------------------


def test_a_scene_that_the_compiled_code_leaves_names_the_engine_that_solved_it():
    """Without gravity the compiled code flies no ball with a spin, which friction makes."""
    scene = {"kind": "at-bat", "gravity": 0, "bat": {"friction": 0.5}, "time_limit": 1.0}
    version = f"longball {lb.__version__}"
    expected = f"{version} ivp Taylor"
    assert lb.solve(scene, "batch").engine == expected
    assert {one.engine for one in lb.solve_many([scene] * 20)} == {expected}
    assert {*lb.solve_many({**scene, "ball.mass": [0.14, 0.15]}).engine} == {expected}
    assert lb.solve({**scene, "gravity": 9.8}, "batch").engine == f"{version} batch tolerance=1e-13"


# --- CSV ------------------------------------------------------------------------------------------

FORMULAS = ["=cmd|calc!A1", "+1+1", "-1+1", "@SUM(1)", "\t=1", "\r=1", "'=1", "''-x"]


@given(st.text())
@example("=")
@example("'=")
@example("-5")
@example("'")
def test_a_text_is_read_back_as_it_was_and_is_no_formula(text: str):
    cell = guarded(text)
    assert unguarded(cell) == text
    try:
        float(cell)
    except ValueError:
        assert not cell.startswith(("=", "+", "-", "@", "\t", "\r"))


def test_ids_that_are_formulas_go_through_csv(tmp_path: Path):
    scenes = [{"kind": "pitch", "id": name} for name in FORMULAS]
    file, asked = tmp_path / "results.csv", tmp_path / "scenes.csv"
    table_files.write_table(file, [one.result.line().encode() for one in lb.solve_many(scenes)])
    with file.open(encoding="utf-8", newline="") as lines:
        cells = [row["id"] for row in csv.DictReader(lines)]
    assert cells == [f"'{name}" for name in FORMULAS]
    # The judge reads them back, and so does solve.
    assert sorted(read_results(file, FORMULAS).answers) == sorted(FORMULAS)
    with asked.open("w", encoding="utf-8", newline="") as out:
        csv.writer(out).writerows([("kind", "id"), *(("pitch", cell) for cell in cells)])
    read = [json.loads(line)["id"] for line in table_files.scene_lines(asked).splitlines() if line]
    assert read == FORMULAS


def solved(path: Path) -> list[dict[str, Any]]:
    lines = table_files.scene_lines(path).split(b"\n")
    return [json.loads(answer.text) for answer in solve_lines(lines, create("ivp"))]


def test_tables_that_libraries_write_are_scenes_as_they_are(tmp_path: Path):
    """An index, ids that are numbers, vectors in one column, UTF-16."""
    speeds, names = [30.0, 35.0], [101, 102]
    frame = pd.DataFrame({"id": names, "kind": "pitch", "pitch.speed": speeds})
    aims = [[0.0, 2.5], [0.1, 2.0]]
    frame.to_csv(tmp_path / "index.csv")
    frame[frame.id > 101].to_csv(tmp_path / "filtered.csv")
    pd.read_csv(tmp_path / "index.csv").to_csv(tmp_path / "again.csv", index=False)
    frame.to_csv(tmp_path / "utf-16.csv", index=False, encoding="utf-16")
    frame.assign(**{"pitch.aim": aims}).to_parquet(tmp_path / "listed.parquet")
    frame.astype({"id": float}).to_parquet(tmp_path / "floats.parquet")
    times = [lb.solve(lb.Pitch(pitch={"speed": speed})).plate.time for speed in speeds]
    for file in ("index.csv", "again.csv", "utf-16.csv", "floats.parquet"):
        answers = solved(tmp_path / file)
        assert [x["id"] for x in answers] == ["101", "102"], file
        assert [x["plate"]["time"] for x in answers] == times, file
    assert [x["id"] for x in solved(tmp_path / "filtered.csv")] == ["102"]
    for answer, speed, aim in zip(solved(tmp_path / "listed.parquet"), speeds, aims, strict=True):
        scene = lb.Pitch(pitch={"speed": speed, "aim": aim})
        assert answer["plate"]["position"] == [*lb.solve(scene).plate.position]


# --- vectors as one column ------------------------------------------------------------------------

LAUNCHES = [[30.0, 0.0, 20.0], [40.0, 2.0, 20.0]]


@pytest.mark.parametrize(
    "velocity",
    [LAUNCHES, np.array(LAUNCHES), [tuple(x) for x in LAUNCHES], pd.Series(LAUNCHES)],
    ids=["lists", "array", "tuples", "series"],
)
@pytest.mark.parametrize("position", [[0.6, 0, 0.9], np.array([0.6, 0.0, 0.9]), "[0.6, 0, 0.9]"])
def test_a_vector_may_be_one_column_or_one_list_for_all(velocity, position):
    columns = {"kind": "flight", "launch.position": position, "launch.velocity": velocity}
    table = lb.solve_many(columns)
    scenes = [{"kind": "flight", "launch": {"position": [0.6, 0, 0.9], "velocity": v}}
              for v in LAUNCHES]  # fmt: skip
    expected = [solution.landing.distance for solution in lb.solve_many(scenes)]
    assert table["landing.distance"].tolist() == expected


def test_a_column_stands_for_one_component_of_a_vector_for_all():
    columns = {"kind": "flight", "launch.position": [0, 0, 1], "launch.velocity": [30, 0, 25]}
    table = lb.solve_many(columns | {"launch.position[2]": [1.0, 2.0]})
    scenes = [{"kind": "flight", "launch": {"position": [0, 0, z], "velocity": [30, 0, 25]}}
              for z in (1, 2)]  # fmt: skip
    expected = [lb.solve(scene, "batch").landing.distance for scene in scenes]
    assert table["landing.distance"].tolist() == expected


def test_a_cell_that_is_no_vector_is_the_error_of_its_row():
    cells = [[30, 0, 20], [40, 0], None, [40, 0, math.nan], [1, 2, 3, 4]]
    table = lb.solve_many(
        {"kind": "flight", "launch.position": [0, 0, 1], "launch.velocity": cells}
    )
    assert table.outcome.isna().tolist() == [False, True, True, True, True]
    assert table.error[1].startswith("launch.velocity[2]: is missing")
    assert table.error[3] == "launch.velocity[2]: must be a finite number (got nan)"
    assert table.error[2] == "launch.velocity: is missing; it is [x, y, z] in m/s"
    assert table.error[4] == "launch.velocity: must be [x, y, z] in m/s, and has 4 values"
    with pytest.raises(lb.InvalidScene, match=r"launch.velocity\[2\]: is missing"):
        lb.solve_many({"kind": "flight", "launch.position": [0, 0, 1], "launch.velocity": [30, 0]})


def test_paths_come_with_the_results():
    columns = {"kind": "flight", "launch.position": [0, 0, 1], "launch.velocity": [*LAUNCHES, None]}
    table = lb.solve_many(columns, paths=5)
    assert table.path[2] is None
    for row, velocity in enumerate(LAUNCHES):
        path = lb.solve(
            {"kind": "flight", "launch": {"position": [0, 0, 1], "velocity": velocity}}
        ).path
        times = np.linspace(0.0, path.end, 5)
        assert table.path[row].shape == (5, 7)
        assert table.path[row][:, 0] == pytest.approx(times)
        assert table.path[row][:, 1:4] == pytest.approx(path.at(times).position, abs=1e-9)
    (solution,) = lb.solve_many([{"kind": "at-bat"}], paths=3)
    assert len(solution.to_dict()["path"]) == 3
