"""Exit statuses of all commands: 2, an input cannot be used as asked; 1, the answer is negative.

And whatever is refused is refused before anything is written, and says what is wrong.
"""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from longball import cli
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

# Contents of a file that is no such input; that is missing or empty, none is.
NO_SCENES = {
    "blank": b"\n\n",
    "zip": b"PK\x03\x04 and so on",
    "one object over lines": b'{\n  "kind": "pitch"\n}\n',
    "array": b'[{"kind": "pitch"},\n {"kind": "pitch"}]\n',
}
NO_TABLES = {
    "head": EXAMPLE.read_bytes().partition(b"\n")[0],
    "other columns": b"a,b\n1,2\n",
    "zip": b"PK\x03\x04 and so on",
    "another encoding": b"pitch_type,\xe9\n1,2\n",
    "scenes": SCENE,
    "array": b'[{"launch_speed": 103}]',
}


def test_every_command_is_here():
    here = {" ".join(x[: 1 + (x[0] == "golden")]) for x in
            (OF_SCENES | OF_TABLES | OF_OTHERS).values()}  # fmt: skip
    assert here | NO_FILE == {*cli.COMMANDS}


@pytest.mark.parametrize("command", OF_SCENES | OF_TABLES | OF_OTHERS)
def test_what_cannot_be_used_is_a_wrong_call_and_leaves_nothing(
    called, tmp_path: Path, monkeypatch, command: str
):
    monkeypatch.chdir(tmp_path)
    contents = {"missing": None, "empty": b""}
    contents |= NO_SCENES if command in OF_SCENES else NO_TABLES if command in OF_TABLES else {}
    for what, content in contents.items():
        if content is not None:
            (tmp_path / "FILE").write_bytes(content)
        before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
        run = called(*(OF_SCENES | OF_TABLES | OF_OTHERS)[command])
        assert (run.returncode, run.stdout) == (2, ""), what
        (sentence,) = run.stderr.splitlines()
        assert sentence.startswith("longball: "), what
        assert "FILE" in sentence or "columns are" in sentence, what
        assert what != "scenes" or "FILE: JSON, where a table is needed" in sentence
        assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before, what


BALL = b'{"kind": "flight", "launch": {"position": [0, 0, 1], "velocity": [30, 0, 20]}}\n'
BAD = b'{"kind": "flight", "launch": {"position": [0, 0, 1], "velocity": [30, 0, "x"]}}\n'

# What is called, and what has to be said of it. "aim" and "infer" get a ball on standard input.
WRONG = r"""
--nonsense -> no such option --nonsense; see
aim -> --target
aim --target 1,x -> --target x: must be a number, alone or with a unit: m
aim - --target -20 -> a distance must be positive
aim - --target far -> --target far: must be a number
aim - --target 90 --unknown gravity -> longball: unknowns: gravity cannot be aimed
converge --scenes - --golden pitch -- '{dt}' -> not both
converge --expected nan -- true '{dt}' -> --expected nan is not
converge --scenes - -- true '{dt}' -> no scenes in standard input
converge --kind impact -- '{dt}' -> none of the scenes is of this kind
converge --figure x.nonsense -- true '{dt}' -> x.nonsense
fit --example rows.csv -> either --example or rows.csv
fit --example --column speeed=v -> speeed
fit --example --column speed_unit=knots -> speed_unit
flight --speed 40 -> --angle is missing: Angle above the horizontal
flight --speed '103 moh' --angle 28 -> did you mean mph?
flight --speed -3 --angle 28 -> must be positive
flight --speed 40 --angle 28 --park coors -> did you mean Coors Field?
flight --speed 40 --angle 28 --park Denver -> did you mean Coors Field?
flight --speed 40 --angle 128 -> must be from -90° to 90°
flight --angle 28 -> --speed is missing: Exit speed
flight --speed 40 --angle 28 --wind '10 mph' -> must be a speed and one of out, in, left, right
flight --speed 103 mph --angle 28 -> a value with spaces needs quotes
flight --speed 103mph --angle 28 --elevation 5,200ft -> a number has no comma
flight --speed 40 --angle 28 --model nathn -> did you mean nathan?
flight --speed 40 --angle 28 --bats S -> must be one of R, L
golden chekc -> no such command 'chekc', did you mean check?
golden write x --family ptch -> --family ptch: there is none, did you mean
golden write --part half nowhere -> half
golden write -> DIR
homerun --fence {here} -> must be a radius, such as 120 or 400ft, or a JSON file
homerun --reading inertia=rod -> inertia
homerun --reading inertia -> NAME=VALUE
homerun --fence 100 --method quadrature -> --method monte-carlo
homerun --fence 0.1 -> fence.radius = 0.1 m
homerun --reading cell_width=-1 -> cell_width
homerun --reading fig7_parameters=x -> caption, text
homerun --reading verlet_forces=implicit -> --engine verlet --forces
homerun --set bat.mess=1 -> bat.mess: no scene has this key, did you mean
homerun --set air.density.temperature=27 -> air.density.temperature: must
homerun --set pitch.speed=40 -> pitch.speed
homerun --set air=null --set air.density=1 -> air
homerun --e 0.5:0.4:0.1 -> the last value is below the first
homerun --e 0.4:0.5 -> must be FIRST:LAST:STEP
homerun --e 1.5 -> --e
homerun --e 0:1:1e-9 -> --e
homerun --samples 0 -> samples
homerun --method guess -> guess
homerun --engine verlet -> verlet
homerun --method quadrature --engine ivp -> ivp
homerun --method quadrature --scenes x.jsonl -> scenes
homerun --csv /no/such/folder/p.csv -> --csv /no/such/folder/p.csv
homerun --method quadrature --samples 1000 -> --samples
homerun --method quadrature --seed 1 -> --seed
homerun --set 'pitch.velocity=[-40,0,0]' -> pitch.velocity: it varies
homerun --set 'pitch.aim[0]=1' -> pitch.aim
homerun --pitches {flight} -> not the result of longball fit --json: source: is missing
infer --unknown gravity -> either --points FILE or --measured
infer --measured distance=1 --unknown gravity -> result has this key, did you mean landing.distance?
infer --measured 'landing.distance=1 s' --unknown gravity -> the unit 's' does not fit; use m,
infer --points {example} --unknown gravity -> t, x, y, z: the table
infer - --measured landing.distance=far --unknown launch.speed -> a finite number
infer - --measured landing.distance=90 --unknown launch.sped -> mean launch.speed
infer - --measured landing.distance=90 -> --unknown is missing
infer - --points {empty} --unknown launch.speed -> the table is empty
judge --tolerance x -- true -> --tolerance x: must be a number
judge --golden flight-vacum -- true -> did you mean flight-vacuum?
judge --profile converge -- true -> did you mean converged?
judge --random 3 --kind fligth -- true -> did you mean flight?
judge --results r.csv --as-csv -> --as-csv is for a COMMAND
judge --expected inf -- true '{dt}' -> --expected inf is not
judge --html /no/such/folder/p.html -- true -> --html /no/such/folder
judge -> COMMAND
judge --results r.jsonl -- true -> not both
judge --samples /no/such/file -> /no/such/file
judge --profile exact --tolerance 1 -- true -> takes no tolerance
judge --knob n=1,2,3 -- true -> {n}
judge --knob n=3,1,2 -- true '{n}' -> from coarse to fine
judge --random 3 --golden pitch -- true -> not two of them
judge --column a=id -- true -> --column
judge --expected 2 -- true -> {dt}
judge --steps 0.1:0.01:5 -- true -> {dt}
judge --steps 0.1:0.01:5 --knob n=1,2,3 -- true '{n}' -> not both
judge --seed 2 -- true -> --random
judge --golden pitch --kind flight -- true -> there is no golden case of these
judge --readings --random 3 -- true -> --readings is for golden cases
judge --steps 0.01:0.1:5 -- true '{dt}' -> from coarse to fine
judge -- /no/such/program -> /no/such/program
judge -- '' -> longball
judge --format xml -- true -> one of text, json, junit, github
measured --example --kind bat -> --kind bat: must be one of
measured --example --set bat.mess=1 -> bat.mess: no scene has this key
measured --example rows.csv -> either --example or rows.csv
measured --model best -> best: must be one of vacuum, paper,
measured --engine best -> best: must be one of ivp,
movement {flies} -> --column NAME=COLUMN gives the table's name of a column
movement --example --column vx0 -> NAME=VALUE
nonsense -> nonsense
parks --park Fenway -> did you mean Fenway Park?
plot :b:.jsonl -> :b:.jsonl
plot --set bat.mess=1 -> bat.mess: no scene has this key, did you mean
solve --engine bach -> enclosure, multiprecision, verlet, did you mean b
solve --egine ivp -> no such option --egine, did you mean --engine?
solve a.jsonl b.jsonl -> unexpected b.jsonl: the command takes [SCENES|-
solve --fence Fenway -> --fence Fenway: must be a radius, such as 120 or 400ft
solve --points 1 -> --points 1: must be at least 2
judge --timeout nan -- true -> --timeout nan: must be at least 0.001
readings --e nan -> --e nan: must be at least 0
solve --points 1000000001 -> --points 1000000001: must be at most
solve --integrator Euler -> Euler
solve --rtol 1e-20 -> rtol
solve --atol -1 -> atol
solve --workers 0 -> workers
solve -o /no/such/folder/file -> /no/such/folder/file
solve --engine verlet --root middle -> one of first, larger
solve --set bat.mess=1 -> bat.mess: no scene has this key, did you mean
solve --set pitch.speed=95mhp -> did you mean mph?
solve --set density=1 -> no scene has this key, did you mean air.density?
solve --reading inertial=thin_rod -> did you mean inertia?
solve --reading sample_space=fair -> it is for longball homer
solve --reading verlet_forces=implicit -> --engine verlet --forces
solve --fence '120 feet' -> --fence 120 feet: the unit 'feet' does not fit
solve -o x.xyz -> x.xyz: the endings of results are
solve -o '' -> a file is needed
solve --digits 20 -> takes no --digits; it takes --integrator, --rtol, --atol
solve --engine batch --landing-error 0 -> --landing-error = 0.0 m
solve --engine enclosure --digits 501 -> --digits = 501
solve --dt -> --dt: a value is needed: verlet: time step, s
solve --certify=yes -> --certify takes no value
sovle -> no such command 'sovle', did you mean solve? The commands are solve,
spin --example --model paper -> a constant does not depend on the spin
spin --up 16in -> --up: it needs --speed
spin t.csv --speed 40 -> --speed is for a single pitch: omit the table
spin --example --speed 40 -> --example: it is for a table
spin --speed 40 --games g.csv -> --games: it is for a table
spin --speed 40 --release 3,4 -> pitch.release[2]: is missing
spin --speed '95 mph' --up 3 -> no spin moves a ball so far
spin --speed fast -> --speed fast: must be a number
"""


def test_a_wrong_call_says_what_is_wrong(called, tmp_path: Path):
    given = {"example": EXAMPLE, "here": __file__}
    for name, text in (("empty", ""), ("flies", "launch_speed\n103\n"), ("flight", BALL.decode())):
        given[name] = tmp_path / f"{name}.csv"
        given[name].write_text(text, encoding="utf-8")
    faults = []
    for line in WRONG.strip().splitlines():
        call, _, said = line.partition(" -> ")
        for name, file in given.items():
            call = call.replace(f"{{{name}}}", str(file))
        run = called(*shlex.split(call), stdin=BALL if call.startswith(("aim", "infer")) else b"")
        sentences = run.stderr.splitlines()
        right = (run.returncode, run.stdout) == (2, "") and said in run.stderr
        if not (right and all(x.startswith("longball: ") for x in sentences)):
            faults.append((line, run))
    assert faults == []


@pytest.mark.parametrize(
    ("arguments", "lines"),
    [
        (["solve"], BALL + BAD),
        (["plot", "-o", "out.png"], BALL + BAD),
        (["parks", "-"], BALL + BAD),
        (["aim", "--target", "900"], BALL),
        (["infer", "--measured", "plate.time=1", "--unknown", "gravity"], BALL),
        (["infer", "--measured", "landing.distance=90", "--unknown", "ball.restitution"], BALL),
        (["judge", "--results", "FILE", "--kind", "impact"], b""),
    ],
    ids=lambda x: x[0] if isinstance(x, list) else "",
)  # fmt: skip
def test_a_negative_answer_is_status_1(called, tmp_path: Path, monkeypatch, arguments, lines):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "FILE").write_bytes(b'{"id": "a", "outcome": "struck"}\n')
    assert called(*arguments, stdin=lines).returncode == 1
