"""Lines of JSON in, lines of JSON out."""

from __future__ import annotations

import json
from importlib import resources

import jsonschema
import pytest

from longball.engines.ivp import Ivp
from longball.engines.lines import solve_line, solve_lines
from longball.model.schema import FOLDER, schemas, text

SCENES = [
    b'{"id":"f","kind":"flight","launch":{"position":[0,0,1],"velocity":[30,2,20]}}',
    b'{"id":"p","kind":"pitch","air":null,"gravity":0}',
    b'{"id":"i","kind":"impact","incoming":{"position":[0.0696,0,1],"velocity":[-40,0,0],"bat_height":1}}',
    b'{"id":"a","kind":"at-bat","reading":{"inertia":"thin_rod","cell_width":0.2}}',
    b'{"id":"m","kind":"at-bat","swing":{"height_offset":0.2}}',
    b"nonsense",
]


def test_the_shipped_schemas_are_those_of_the_models():
    for name, schema in schemas().items():
        assert (FOLDER / name).read_text(encoding="utf-8") == text(schema)
        assert resources.files("longball").joinpath("schema", name).is_file()


@pytest.mark.parametrize("line", SCENES)
def test_scenes_and_results_obey_the_schemas(line: bytes):
    schema = schemas()
    if line.startswith(b"{"):
        jsonschema.validate(json.loads(line), schema["scene.schema.json"])
    written = json.loads(solve_line(1, line, Ivp()).line())
    jsonschema.validate(written, schema["result.schema.json"])


@pytest.mark.parametrize(
    "scene",
    [
        {"id": "x", "kind": "pitch", "ball": {"mass": -1}},
        {"id": "x", "kind": "pitch", "bat": {}},
        {"id": "x", "kind": "flight"},
        {"id": 1, "kind": "pitch"},
        {"id": "x", "kind": "pitch", "reading": {"inertia": "rod"}},
    ],
)
def test_the_schema_refuses_what_the_code_refuses(scene: dict):
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(scene, schemas()["scene.schema.json"])
    assert solve_line(1, json.dumps(scene).encode(), Ivp()).error is not None


def test_lines_are_numbered_as_in_the_file():
    results = list(solve_lines([b"\n", b"junk\n", b"  \n", b"junk"], Ivp()))
    assert [r.error.split(":")[0] for r in results] == ["line 2", "line 4"]
