"""Results in files: JSON Lines and tables."""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path

import pytest

from longball.judge.answers import COLUMNS, BadTable, Collector, read_results
from longball.judge.quantities import QUANTITIES
from longball.model import result

ASKED = ("a", "b", "c")


def written(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def said(collected) -> str:
    return "\n".join(map(str, collected.issues))


def test_the_quantities_are_those_of_a_result():
    fields = {
        f"{block}.{key}"
        for block, model in (
            ("plate", result.Plate),
            ("plate.approach", result.Approach),
            ("contact", result.Contact),
            ("impact", result.Impact),
            ("apex", result.Apex),
            ("fence", result.Fence),
            ("landing", result.Landing),
        )
        for key in model.model_fields
    }
    assert set(QUANTITIES) == fields - {
        "impact.mode",
        "impact.recontact",
        "fence.segment",
        "landing.fair",
        "plate.approach",
    }  # told, not measured; a block of its own


def test_json_lines_keep_every_digit(tmp_path: Path):
    path = written(
        tmp_path,
        "results.jsonl",
        '\ufeff{"id": "a", "outcome": "landed", "landing": {"distance": 100.1}}\r\n'
        '{"id": "b", "landing": {"distance": '
        '{"value": "100.10000000000000000000000000001", "radius": "1e-30"}, '
        '"time": {"value": 4.25, "radius": "1e-15"}, "hang_time": {"value": true}}}\n'
        '{"id": "c", "error": "too hard\\u001b"}\n',
    )
    collected = read_results(path, ASKED)
    a, b, c = (collected.answers[name] for name in ASKED)
    assert a.values["landing.distance"] == (Decimal("100.1"),)
    assert b.values["landing.distance"] == (Decimal("100.10000000000000000000000000001"),)
    assert b.values["landing.time"] == (Decimal("4.25"),)
    assert c.error == "too hard\\x1b"
    assert "landing.hang_time is" in said(collected)


# Lines of output with a part of the complaint about each; right lines have no complaint.
LINES = [
    (b'{"id": "a", "outcome": "landed", "landing": {"distance": 1.5}}', ""),
    (b"hello", "not JSON from character 1 on: hello"),
    (b"\xff\xfe", "not UTF-8 text: byte 1 is 0xff"),
    (b"[1, 2]", "not a result, which is a JSON object"),
    (b'{"outcome": 1}', "not a result: it has no id"),
    (b'{"id": 7}', "not a result: the id 7 is not text"),
    (b"", ""),
    (b"[" * 60_000, "not a result: brackets nested too deeply"),
    (b'{"id": "z"}', "no scene has the id z"),
    (b'{"id": "a", "outcome": "missed"}', "a is answered again; the first answer counts"),
    (b'{"id": "b", "outcome": "lan', 'not JSON from character 24 on: "lan; it is cut off'),
    (b'{"id": "b", "landing": {"distance": 1', "it is cut off"),
    (b'{"id": "b", "landing": {"distance": 1}', "it is cut off"),
    (b'{"id": "b"} and more', "not JSON from character 13 on: and more"),
    (b'{"id": "\\u001b]0;evil\\u0007' + b"x" * 1000 + b'"}', "no scene has the id \\x1b]0;evil"),
    (b'{"id": "b", "outcome": "home run", "landing": 150, "plate": null}',
     "home run is not an outcome"),
    (b'{"id": "c", "outcome": ["landed"], "landing": {"distance": NaN, "time": 1e999, '
     b'"hang_time": "4", "position": [1, 2], "velocity": [1, true, null]}}',
     'landing.position is ["1", "2"]; must be three finite numbers'),
    (b'{"id": "d", "landing": {"distance": ' + b"9" * 20_000 + b"}}", "landing.distance is 9999"),
    (b'{"id": "e", "landing": {"distance": 1e-999999999999}}', "e: landing.distance is 1"),
]  # fmt: skip


def test_lines_that_are_no_answers_are_told_and_the_rest_read():
    collector = Collector([*ASKED, "d", "e"])
    for number, (line, _) in enumerate(LINES, 1):
        collector.take_line(number, line)
    for number, (_, sentence) in enumerate(LINES, 1):
        found = [issue.sentence for issue in collector.issues if issue.line == number]
        assert any(sentence in one for one in found) if sentence else not found, number
        assert not any("\x1b" in one or len(one) > 200 for one in found)
        cut = any("it is cut off" in one for one in found)
        assert cut == ("it is cut off" in sentence)
    a, b, c = (collector.answers[name] for name in ASKED)
    assert (a.outcome, a.values) == ("landed", {"landing.distance": (Decimal("1.5"),)})
    assert "b: landing is not a JSON object" in said(collector)
    assert "c: landing.distance is NaN; must be a finite number" in said(collector)
    assert (b.outcome, c.outcome, c.values, len(c.unreadable)) == (None, None, {}, 5)


def test_a_table(tmp_path: Path):
    path = written(
        tmp_path,
        "results.csv",
        "id,outcome,plate.time,landing.distance,landing.position[0],landing.position[1],"
        "landing.position[2],remark\r\n"
        "a,batted,0.55,100.5,100,10.012492197250394,0,far\r\n"
        "b,missed,0.5,,,,,\r\n"
        "c,batted,x,nan,1,,0,\r\n",
    )
    collected = read_results(path, ASKED)
    a, b, c = (collected.answers[name] for name in ASKED)
    assert a.outcome == "batted"
    assert a.values["landing.position"] == (Decimal(100), Decimal("10.012492197250394"), Decimal(0))
    assert set(b.values) == {"plate.time"}
    assert c.unreadable == {"plate.time", "landing.distance", "landing.position"}
    assert "line 4: c: landing.distance is NaN" in said(collected)


def test_columns_that_are_not_used_are_told(tmp_path: Path):
    collected = read_results(written(tmp_path, "r.csv", "id, dist\na, 3\n"), ASKED)
    assert "line 1: the column dist is not used: it is not a key of a result" in said(collected)
    assert collected.faults == 0


def test_a_table_with_names_of_its_own(tmp_path: Path):
    path = written(tmp_path, "results.csv", "case,D [m]\na,100.5\nz,3\na,4\n")
    collected = read_results(path, ASKED, {"case": "id", "D [m]": "landing.distance"})
    assert collected.answers["a"].values == {"landing.distance": (Decimal("100.5"),)}
    assert "line 3: no scene has the id z" in said(collected)
    assert "line 4: a is answered again" in said(collected)


@pytest.mark.parametrize(
    ("content", "columns", "why"),
    [
        ("case,landing.time\n", {}, "--column COLUMN=id; the columns are case, landing.time$"),
        ("id;landing.time\n", {}, "head has semicolons where commas must"),
        ("", {}, "no id column"),
        ('id,"D\n', {}, "its head is not CSV"),
        ("id,D\n", {"E": "landing.distance"}, "no column E; the columns are id, D"),
        ("id,D\n", {"D": "distance"}, "cannot hold distance"),
        ("id,D,landing.distance\n", {"D": "landing.distance"}, "two columns hold the same"),
    ],
)
def test_a_table_that_cannot_be_read(tmp_path: Path, content: str, columns: dict, why: str):
    with pytest.raises(BadTable, match=why):
        read_results(written(tmp_path, "results.csv", content), ASKED, columns)


def test_a_broken_row_is_told_and_the_rest_read(tmp_path: Path):
    content = b'id,outcome\na,missed\n\xff,missed\nb,"miss\nc,missed\n'
    collected = read_results(written(tmp_path, "r.csv", content), ASKED)
    assert [a.outcome for a in collected.answers.values()] == ["missed", "missed"]
    assert "line 3: not UTF-8 text: byte 1 is 0xff" in said(collected)
    assert 'line 4: not a row of CSV: b,"miss' in said(collected)


def test_columns_are_for_tables(tmp_path: Path):
    with pytest.raises(BadTable, match="CSV"):
        read_results(written(tmp_path, "r.jsonl", ""), ASKED, {"x": "id"})
    with pytest.raises(BadTable, match="results are read from"):
        read_results(written(tmp_path, "r.parquet", "PAR1"), ASKED)


def test_every_quantity_has_a_column():
    assert {name.partition("[")[0] for name in COLUMNS} >= set(QUANTITIES)


def test_a_row_of_a_table_that_is_cut_is_no_answer(tmp_path: Path):
    text = "id,outcome,landing.distance,landing.time\na,landed,100.5,4.5\nb,landed,10"
    collected = read_results(written(tmp_path, "results.csv", text), ASKED)
    assert [*collected.answers] == ["a"]
    assert said(collected) == "line 3: it is cut off: 3 of 4 cells of a result"
