"""Tables as people have them: encodings, separators, lines above the head, marks of nothing."""

import gzip
import io

import pandas as pd
import pytest

from longball.pitches.table import TableError, numbers, read_table, texts

TEXT = "a,b,c\n1,2,x\n3,4,y\n"


def read(data: bytes, columns=("a", "b")):
    return read_table(io.BytesIO(data), columns)[1]


def packed(frame: pd.DataFrame) -> bytes:
    file = io.BytesIO()
    frame.to_parquet(file)
    return file.getvalue()


@pytest.mark.parametrize(
    "data",
    [
        TEXT.encode(),
        TEXT.encode("utf-8-sig"),
        TEXT.encode("utf-16"),
        TEXT.replace("\n", "\r\n").encode(),
        gzip.compress(TEXT.encode(), mtime=0),
        packed(pd.DataFrame({"a": [1, 3], "b": [2.0, 4.0], "c": ["x", "y"]})),
        packed(pd.DataFrame({"a": [1, 3], "b": [2.0, 4.0]}, index=[7, 9])),
        b'"Player ID:","12"\n"Name:","Doe, Pat\nJr"\n\n' + TEXT.encode(),
        b"made,by,a,device,with,many,words\n" + TEXT.encode(),
    ],
)
def test_a_table_is_known_by_its_content(data: bytes):
    frame = read(data)
    assert numbers(frame["a"]).tolist() == [1.0, 3.0]
    assert numbers(frame["b"]).tolist() == [2.0, 4.0]


def test_a_stroke_says_that_nothing_was_measured():
    frame = read(b"a,b\n-,x\n-1,--\n", ("a", "b"))
    assert numbers(frame["a"])[1:].tolist() == [-1.0]
    assert numbers(frame["a"])[0] != numbers(frame["a"])[0]
    assert texts(frame["b"]).isna().tolist() == [False, True]


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (b"\xff", "not UTF-8 text: byte 1 is 0xff"),
        (b"PAR1 and nothing more", "table: "),
        (gzip.compress(TEXT.encode(), mtime=0)[:20], "cannot be read"),
        (b"a,c\n1,2\n", "b: the table has no such column; its columns are a, c"),
    ],
)
def test_a_sentence_says_what_is_wrong(data: bytes, sentence: str):
    with pytest.raises(TableError, match=sentence):
        read(data)


def test_a_column_with_a_semicolon_in_its_name_is_a_column():
    assert numbers(read(b"a,b;c,b\n1,2,3\n")["b"]).tolist() == [3.0]


def test_a_name_that_is_given_must_be_there():
    frame = pd.DataFrame({"a": [1], "B": [2]})
    assert [*read_table(frame, ["a"], ["b"])[1]] == ["a"]
    assert [*read_table(frame, ["a"], ["b"], {"b": "B"})[1]] == ["a", "b"]
    with pytest.raises(TableError, match="C: the table has no such column"):
        read_table(frame, ["a"], ["b"], {"b": "C"})
