"""Exit statuses of all commands: 2, an input cannot be used as asked; 1, the answer is negative.

And whatever is refused is refused before anything is written.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from longball import cli
from longball.cli import golden
from longball.pitches import EXAMPLE

SCENE = b'{"id": "a", "kind": "pitch"}\n'

# Calls that read a file, by the command; every option that writes a file is one of them.
OF_SCENES = {
    "solve": ["solve", "FILE", "-o", "out.jsonl"],
    "solve to a table": ["solve", "FILE", "-o", "out.csv"],
    "plot": ["plot", "FILE", "-o", "out.png"],
    "parks": ["parks", "FILE"],
    "aim": ["aim", "FILE", "--target", "100"],
    "infer": ["infer", "FILE", "--measured", "plate.time=0.5", "--unknown", "pitch.speed"],
    "judge": ["judge", "--scenes", "FILE", "--html", "out.html", "--", "true"],
    "converge": ["converge", "--scenes", "FILE", "--csv", "out.csv", "--", "true", "{dt}"],
    "golden coverage": ["golden", "coverage", "FILE"],
}
OF_TABLES = {
    "fit": ["fit", "FILE"],
    "measured": ["measured", "FILE", "--scenes", "s.jsonl", "--csv", "out.csv"],
    "measured flies": ["measured", "FILE", "--kind", "batted", "--figure", "out.png"],
    "measured games": ["measured", "--example", "--games", "FILE", "--scenes", "s.jsonl"],
    "movement": ["movement", "FILE"],
    "spin": ["spin", "FILE"],
    "infer points": ["infer", "--points", "FILE", "--unknown", "gravity"],
}
OF_OTHERS = {
    "homerun": ["homerun", "--samples", "2", "--e", "0.42", "--pitches", "FILE",
                "--scenes", "s.jsonl", "--csv", "out.csv"],
    "golden export": ["golden", "export", "FILE"],
    "golden list": ["golden", "list", "FILE"],
    "golden check": ["golden", "check", "FILE"],
    "golden write": ["golden", "write", "out", "--family", "FILE"],
}  # fmt: skip
# Without a file: nothing that they read can be wrong.
NO_FILE = {"flight", "readings", "golden path"}

NO_SCENES = {
    "missing": None,
    "empty": b"",
    "blank": b"\n\n",
    "zip": b"PK\x03\x04 and so on",
    "one object over lines": b'{\n  "kind": "pitch"\n}\n',
    "array": b'[{"kind": "pitch"},\n {"kind": "pitch"}]\n',
}
NO_TABLES = {
    "missing": None,
    "empty": b"",
    "head": EXAMPLE.read_bytes().partition(b"\n")[0],
    "other columns": b"a,b\n1,2\n",
    "zip": b"PK\x03\x04 and so on",
    "another encoding": b"pitch_type,\xe9\n1,2\n",
    "scenes": SCENE,
    "array": b'[{"launch_speed": 103}]',
}


def cases(calls, contents):
    return [
        pytest.param(arguments, content, id=f"{name}: {what}")
        for name, arguments in calls.items()
        for what, content in contents.items()
    ]


def test_every_command_is_here():
    every = {*cli.COMMANDS, *(f"golden {name}" for name in golden.COMMANDS)} - {"golden"}
    here = {" ".join(x[: 1 + (x[0] == "golden")]) for x in
            (OF_SCENES | OF_TABLES | OF_OTHERS).values()}  # fmt: skip
    assert here | NO_FILE == every


@pytest.mark.parametrize(
    ("arguments", "content"),
    [*cases(OF_SCENES, NO_SCENES), *cases(OF_TABLES, NO_TABLES),
     *cases(OF_OTHERS, {"missing": None, "empty": b""})],
)  # fmt: skip
def test_what_cannot_be_used_is_a_wrong_call_and_leaves_nothing(
    called, tmp_path: Path, monkeypatch, arguments, content
):
    monkeypatch.chdir(tmp_path)
    if content is not None:
        (tmp_path / "FILE").write_bytes(content)
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    run = called(*arguments)
    assert run.returncode == 2
    assert run.stdout == ""
    (sentence,) = run.stderr.splitlines()
    assert sentence.startswith("longball: ")
    assert "FILE" in sentence or "columns are" in sentence
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before


@pytest.mark.parametrize("command", OF_TABLES)
def test_json_where_a_table_is_expected_is_named(called, tmp_path: Path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "FILE").write_bytes(SCENE)
    assert "FILE: JSON, where a table is needed" in called(*OF_TABLES[command]).stderr


BALL = b'{"kind": "flight", "launch": {"position": [0, 0, 1], "velocity": [30, 0, 20]}}\n'
BAD = b'{"kind": "flight", "launch": {"position": [0, 0, 1], "velocity": [30, 0, "x"]}}\n'


@pytest.mark.parametrize(
    ("arguments", "lines"),
    [
        (["solve"], BALL + BAD),
        (["plot", "-o", "out.png"], BALL + BAD),
        (["parks", "-"], BALL + BAD),
        (["aim", "--target", "900"], BALL),
        (["infer", "--measured", "plate.time=1", "--unknown", "gravity"], BALL),
        (["judge", "--results", "FILE", "--kind", "impact"], b""),
    ],
    ids=lambda x: x[0] if isinstance(x, list) else "",
)  # fmt: skip
def test_a_negative_answer_is_status_1(called, tmp_path: Path, monkeypatch, arguments, lines):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "FILE").write_bytes(b'{"id": "a", "outcome": "struck"}\n')
    assert called(*arguments, stdin=lines).returncode == 1
