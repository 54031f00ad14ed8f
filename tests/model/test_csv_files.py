"""The head and the rows of CSV files, below the lines that devices write above them."""

from __future__ import annotations

import pytest

from longball.model.csv_files import read_rows

KNOWN = {"speed", "angle"}.__contains__


def read(text: str) -> tuple[list[str], list[tuple[int, list[str]]]]:
    head, rows = read_rows(text.encode("latin-1"), KNOWN)
    return head, [*rows]


def test_the_head_is_the_row_with_the_most_known_names():
    lines = "Device 7, angle\n\n speed, angle ,note\n40,0.5\n\n41,0.6,x,\n"
    rows = [(4, ["40", "0.5"]), (6, ["41", "0.6", "x", ""])]
    assert read(lines) == (["speed", "angle", "note"], rows)
    assert read("a,b\n1,2\n") == (["a", "b"], [(2, ["1", "2"])])
    assert read("speed,a;b\n1,2\n")[0] == ["speed", "a;b"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the table is empty"),
        ("a;b\n1;2\n", "not a table in CSV; its head has semicolons where commas must separate"),
        ("a\tb\n1\t2\n", "its head has tabs where commas must separate the cells"),
        ("speed,angle\n1,\xe9", "not UTF-8 text: byte 15 is 0xe9"),
        ("PK\x03\x04\xe9", "not text but a spreadsheet or a zip archive"),
        ("speed,speed\n", "the column speed appears twice"),
        ("speed\n1\n1,2\n", "line 3: 2 cells, but the head has 1"),
    ],
)
def test_a_file_that_is_no_table(text: str, message: str):
    with pytest.raises(ValueError, match=message):
        read(text)
