"""All engines against the oracle, on random scenes that mix all keys and readings.

`make nightly` does the same with thousands; `tests/nightly.py` gives the reason of the tolerance.
"""

import json
from pathlib import Path
from typing import get_args

import pytest

import longball as lb
from longball.model.result import Outcome
from tests import nightly, oracle

SEED = 1
SCENES = 200
PIECE = 10
SCHEMA = Path(lb.__file__).parent / "schema" / "scene.schema.json"


@pytest.mark.parametrize("first", range(0, SCENES, PIECE))
@pytest.mark.sampled(every=5)
def test_random_scenes(first):
    rows, doubtful = nightly.piece(SEED, first, first + PIECE)
    assert [row for row in rows if row.off is None or row.wrong] == []
    assert len(doubtful) <= 1


def names_in(value):
    """All keys of a scene, and all words that it takes for values."""
    if isinstance(value, dict):
        return set(value).union(*map(names_in, value.values()))
    if isinstance(value, list):
        return set().union(*map(names_in, value))
    return {value} if isinstance(value, str) else set()


def names_of(schema):
    """All keys that a schema knows, and all words that it allows."""
    found = set()
    if isinstance(schema, dict):
        found = set(schema.get("properties", {})) | set(schema.get("enum", []))
        found |= {schema["const"]} if "const" in schema else set()
        found = found.union(*map(names_of, schema.values()))
    elif isinstance(schema, list):
        found = found.union(*map(names_of, schema))
    return {name for name in found if isinstance(name, str)}


def test_random_scenes_have_every_key_option_and_outcome():
    scenes, _ = nightly.drawn(SEED, range(SCENES))
    # An id changes nothing; the options that are defaults are what is left out.
    defaults = {*oracle.READINGS.values(), "pivot", "id"}
    wanted = names_of(json.loads(SCHEMA.read_text(encoding="utf-8"))) - defaults
    assert wanted - set().union(*map(names_in, scenes)) == set()
    assert {lb.solve(scene).outcome for scene in scenes} == set(get_args(Outcome))


def test_the_comparison_notices_what_is_wrong():
    scene = {"kind": "at-bat", "swing": {"height_offset": -0.02}, "fence": {"radius": 50}}
    true = nightly.truth(scene)
    answer = json.loads(lb.solve(scene).result.line())

    def worst(**blocks):
        return max(found[3] for found in nightly.differences(answer | blocks, true))

    assert worst() < 1
    assert worst(outcome="wall") > 1
    assert worst(landing=None) > 1
    landing = dict(answer["landing"])
    assert worst(landing=landing | {"distance": landing["distance"] + 1e-8}) > 1
    assert worst(landing=landing | {"fair": not landing["fair"]}) > 1
    assert worst(landing=landing | {"height": 0.0}) > 1


def test_the_tolerance_covers_the_oracles_own_error():
    """Flown in steps of half the length it has the same answers."""
    for scene in nightly.drawn(SEED, range(8))[0]:
        half = oracle.solve(scene, oracle.STEP / 2).result
        assert max(found[3] for found in nightly.differences(half, nightly.truth(scene))) < 1


def test_a_scene_in_doubt_is_left_out():
    """A graze by a tenth of a micrometre."""
    graze = {"kind": "at-bat", "swing": {"height_offset": 0.0}}
    assert nightly.truth(graze) is not None
    reach = 0.0366 + 0.033
    low, high = reach, 2 * reach
    for _ in range(24):
        graze["swing"]["height_offset"] = (low + high) / 2
        if oracle.solve(graze).result["contact"]["margin"] > 0:
            low = graze["swing"]["height_offset"]
        else:
            high = graze["swing"]["height_offset"]
    assert nightly.truth(graze) is None
