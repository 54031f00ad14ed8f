"""Lines of JSON in, lines of JSON out."""

from __future__ import annotations

import json
from importlib import resources
from io import BufferedIOBase, BytesIO

import jsonschema
import pytest

from longball.engines import ENGINES, create
from longball.engines.batch import Batch
from longball.engines.ivp import Ivp
from longball.engines.lines import solve_lines
from longball.engines.parallel import in_parallel
from longball.model.scene import parse_scene
from longball.model.schema import FOLDER, schemas, text

SCENES = [
    b'{"id":"f","kind":"flight","launch":{"position":[0,0,1],"velocity":[30,2,20]}}',
    b'{"id":"p","kind":"pitch","air":null,"gravity":0}',
    b'{"id":"i","kind":"impact","incoming":{"position":[0.0696,0,1],"velocity":[-40,0,0],"bat_height":1}}',
    b'{"id":"a","kind":"at-bat","reading":{"inertia":"thin_rod"}}',
    b'{"id":"m","kind":"at-bat","swing":{"height_offset":0.2}}',
    b"nonsense",
]


def test_the_shipped_schemas_are_those_of_the_models():
    for name, schema in schemas().items():
        assert (FOLDER / name).read_text(encoding="utf-8") == text(schema)
        assert resources.files("longball").joinpath("schema", name).is_file()


@pytest.fixture(scope="module")
def validators() -> tuple[jsonschema.Draft202012Validator, jsonschema.Draft202012Validator]:
    """Of scenes and of results: to make one takes longer than to use it."""
    scene, result = (
        jsonschema.Draft202012Validator(schemas()[f"{name}.schema.json"])
        for name in ("scene", "result")
    )
    return scene, result


def test_scenes_and_results_obey_the_schemas(validators):
    scene, result = validators
    for line in SCENES:
        if line.startswith(b"{"):
            scene.validate(json.loads(line))
        result.validate(json.loads(next(solve_lines([line], Ivp())).text))


TAKEN = [
    {"id": 1, "kind": "pitch", "pitch": {"velocity": [-40, 0, 0]}},
    {"kind": "pitch", "pitch": {"velocity": None, "speed": 40}},
    {"kind": "at-bat", "fence": {"radius": None, "polyline": [[67, 67, 3], [67, -67, 3]]}},
    {"kind": "at-bat", "fence": {"radius": 120}},
]
REFUSED = [
    {"id": "x", "kind": "pitch", "ball": {"mass": -1}},
    {"id": "x", "kind": "pitch", "bat": {}},
    {"id": "x", "kind": "flight"},
    {"id": 1.5, "kind": "pitch"},
    {"kind": "pitch", "pitch": {"speed": 40, "velocity": [-40, 0, 0]}},
    {"kind": "pitch", "pitch": {"aim": [0, 1], "velocity": [-40, 0, 0]}},
    {"kind": "at-bat", "fence": {"radius": 120, "polyline": [[67, 67, 3], [67, -67, 3]]}},
    {"kind": "at-bat", "fence": {}},
    {"id": "x", "kind": "pitch", "reading": {"inertia": "rod"}},
]


def test_the_schema_takes_and_refuses_what_the_code_does(validators):
    for scene, taken in (*((x, True) for x in TAKEN), *((x, False) for x in REFUSED)):
        assert validators[0].is_valid(scene) is taken, scene
        result = next(solve_lines([json.dumps(scene).encode()], Ivp()))
        assert (result.failure is None) is taken, scene


def test_lines_are_numbered_as_in_the_file():
    results = list(solve_lines([b"\n", b"junk\n", b"  \n", b"junk"], Ivp()))
    assert [r.failure.split(":")[0] for r in results] == ["line 2", "line 4"]


# A scene for each sort of error; and the engines that have it.
SMOOTH = ("ivp", "batch", "enclosure", "multiprecision")
ERRORS = [
    ("invalid", (*ENGINES,), "junk"),
    ("invalid", (*ENGINES,), '{"id":"x","kind":"at-bat","pitch":{"release":[0.05,0,1.8]}}'),
    (
        "undecided",
        SMOOTH,  # the paper's scheme does not know of doubt
        '{"id":"x","kind":"flight","air":null,"gravity":10,"time_limit":10,'
        '"launch":{"position":[0,0,0],"velocity":[1,0,50]}}',
    ),
    (
        "too_long",
        ("ivp", "batch"),
        '{"id":"x","kind":"flight","air":{"density":1e9,"drag_coefficient":1e-6},'
        '"launch":{"position":[0,0,1000],"velocity":[40,0,1]}}',
    ),
    (
        "out_of_range",
        ("ivp", "enclosure", "multiprecision", "verlet"),
        '{"id":"x","kind":"flight","ball":{"radius":1e30,"mass":1e-30},'
        '"air":{"density":1e30,"drag_coefficient":1e30},'
        '"launch":{"position":[0,0,1e30],"velocity":[1e30,0,0]}}',
    ),
    (
        "unsupported",
        SMOOTH,
        '{"id":"x","kind":"at-bat","reading":{"lift_direction":"always_up"},'
        '"air":{"drag_coefficient":0,"lift_coefficient":200},'
        '"pitch":{"release":[0.2,0,1.8],"aim":[0,1.8],"speed":30},"swing":{"height_offset":1}}',
    ),
]


@pytest.mark.parametrize(
    ("code", "engine", "line"),
    [(code, name, line) for code, names, line in ERRORS for name in names],
)
@pytest.mark.sampled(every=2)
def test_an_error_has_a_code_of_its_sort(code: str, engine: str, line: str, monkeypatch):
    monkeypatch.setattr("longball.engines.ivp._MOST_STEPS", 500)  # of those that are too many
    result = next(solve_lines([line.encode()], create(engine)))
    assert json.loads(result.text)["code"] == code
    assert result.failure.startswith("line 1: ")


def test_scenes_at_once_have_codes_too():
    results = Batch().solve_all([parse_scene(ERRORS[2][2])] * 20)
    assert {result.code for result in results} == {"undecided"}


# --- many lines at once ---------------------------------------------------------------------------

# Enough of a kind to be solved as columns, some that have no answer, and kinds in turn.
MANY = [
    *SCENES,
    *(
        b'{"id":"h%d","kind":"at-bat","swing":{"height_offset":%r}}' % (i, i * 1e-3 - 0.07)
        for i in range(140)
    ),
    b"",
    b'{"id":"g","kind":"at-bat","pitch":{"release":[0.05,0,1.8]}}',
    *(
        b'{"id":"v%d","kind":"flight","air":null,"launch":{"position":[0,0,1],"velocity":[%d,2,20]}}'
        % (i, i)
        for i in range(20)
    ),
]


def test_lines_at_once_have_the_answers_of_one_by_one():
    engine = Batch()
    alone = [next(solve_lines([b""] * n + [line], engine)) for n, line in enumerate(MANY) if line]
    assert sum(result.failure is not None for result in alone) > 1
    assert list(solve_lines(BytesIO(b"\n".join(MANY)), engine)) == alone
    assert list(solve_lines(MANY, engine, workers=2)) == alone
    assert list(solve_lines(MANY, engine)) == alone


def test_there_are_no_more_workers_than_cores_and_calls(monkeypatch):
    asked = []
    monkeypatch.setattr("joblib.effective_n_jobs", lambda n: 4)
    monkeypatch.setattr(
        "joblib.Parallel", lambda n_jobs, **_: asked.append(n_jobs) or (lambda tasks: [*tasks])
    )
    for calls, workers in ((1, 1000), (3, -1), (9, 1000), (9, 2), (0, 2), (9, 1)):
        assert len(in_parallel(abs, [(1,)] * calls, workers, threads=True)) == calls
    assert asked == [1, 3, 4, 2, 1, 1]
    for none in (0, -2):
        with pytest.raises(ValueError, match=f"workers = {none}: a positive number"):
            in_parallel(abs, [(1,)], none)


def test_what_is_told_and_not_measured_is_no_double():
    scene = {"kind": "flight", "fence": {"radius": 100}}
    scene |= {"launch": {"position": [0, 0, 1], "velocity": [40, 0, 21]}}
    lines = [json.dumps(scene).encode()] * 20
    for engine in (Batch(), Ivp()):
        (result, *_) = solve_lines(BytesIO(b"\n".join(lines)), engine)
        data = json.loads(result.text)
        assert data["landing"]["fair"] is True
        assert isinstance(data["fence"]["segment"], int)


class Pipe(BufferedIOBase):
    """Gives what was written piece by piece, and remembers how many pieces were asked for."""

    def __init__(self, *pieces: bytes) -> None:
        self.pieces = pieces
        self.asked = 0

    def read1(self, size: int = -1, /) -> bytes:
        self.asked += 1
        return self.pieces[self.asked - 1] if self.asked <= len(self.pieces) else b""


@pytest.mark.parametrize("engine", [Batch(), Ivp()], ids=["batch", "ivp"])
def test_no_line_waits_for_one_that_is_not_there(engine):
    f, i = SCENES[0], SCENES[2]
    pipe = Pipe(f + b"\n" + i + b"\n" + f[:20], f[20:40], f[40:] + b"\n", i)
    results = solve_lines(pipe, engine)
    answered = [(result.id, pipe.asked) for result in results]
    # The last line has no end of its own: the end of the pipe is it.
    assert answered == [("f", 1), ("i", 1), ("f", 3), ("i", 5)]


@pytest.mark.parametrize("engine", [Ivp(), Batch()])
def test_a_result_without_an_id_bears_the_number_of_its_line(engine):
    lines = [b"\n", b'{"kind":"pitch"}\n', b'{"kind":"pitch","id":"p"}\n', b"junk"]
    results = list(solve_lines(lines, engine))
    assert [r.id for r in results] == ["2", "p", "4"]
