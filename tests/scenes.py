"""Scenes that several files test: the golden cases, and scenes drawn at random.

`random_scene` mixes all keys and readings of the model: a scene is drawn as a JSON object from a
`random.Random`, so that a seed and a number name it. Each key and each reading is there in some of
the scenes, with any of the others that it may stand with; where a key is missing, its default
holds. Random scenes of the paper's model are the judge's (`fresh`).
"""

from __future__ import annotations

import json
import random
from contextlib import suppress
from functools import cache
from types import UnionType
from typing import Annotated, Union, get_args, get_origin

import numpy as np
from hypothesis import strategies as st
from pydantic import BaseModel

from analysis.random_scenes import random_reading
from analysis.scene_search import drawn
from longball import golden
from longball.golden.reader import EXTENDED
from longball.judge import fresh
from longball.model import result
from longball.model.scene import InvalidScene, parse_scene

FAMILIES = tuple(golden.header().families)


@cache
def cases_of(family: str) -> tuple[golden.Case, ...]:
    """Return the golden cases of a family."""
    return tuple(golden.load(family))


def all_cases() -> list[golden.Case]:
    """Return the golden cases of all families, in the order of the files."""
    return [case for family in FAMILIES for case in cases_of(family)]


def paper_cases() -> list[golden.Case]:
    """Return the golden cases of the paper's model."""
    return [case for family in FAMILIES if family not in EXTENDED for case in cases_of(family)]


def case_of(identity: str) -> golden.Case:
    """Return the golden case of an id."""
    return next(case for case in all_cases() if case.id == identity)


# --- for hypothesis -------------------------------------------------------------------------------


def between(low, high):
    return st.floats(low, high, allow_subnormal=False)


def scenes():
    """Scenes of all kinds with any keys and readings."""
    return st.integers(0, 10**6).map(
        lambda seed: parse_scene(json.dumps(random_scene(random.Random(seed))))
    )


def paper_scenes(*kinds):
    """Scenes of the paper's model, of some kinds or of all."""
    return st.builds(
        lambda seed, kind: next(fresh.random_scenes(1, seed, [kind])),
        st.integers(0, 10**6),
        st.sampled_from(kinds or fresh.DRAWN),
    )


decimals = st.from_regex(r"[+-]?[0-9]{1,40}(\.[0-9]{1,40})?([eE][+-]?[0-9]{1,3})?", fullmatch=True)
radii = st.from_regex(r"[0-9](\.[0-9]{1,8})?[eE]-[0-9]{1,3}", fullmatch=True)
finite = st.floats(allow_nan=False, allow_infinity=False)
# Values of the parts of which the fields of results are made; other types have hypothesis's own.
VALUES = {
    float: finite,
    result.Bounded: st.builds(result.Bounded, value=decimals, radius=st.none() | radii),
    result.Certified: st.builds(result.Certified, value=finite, radius=radii),
}


def any_of(kind):
    """Any value of a type that a field of a result may have."""
    if kind in VALUES:
        return VALUES[kind]
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        fields = {name: field.annotation for name, field in kind.model_fields.items()}
        if kind is result.Result:
            del fields["path"]  # points, whose lines are long
        return st.builds(kind, **{name: any_of(each) for name, each in fields.items()})
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return any_of(parts[0])
    if origin is tuple:
        return st.tuples(*map(any_of, parts))
    if origin in (Union, UnionType):
        return st.one_of(*map(any_of, parts))
    return st.from_type(kind)


def results():
    """Any valid result, of whatever engine."""
    return any_of(result.Result)


# --- drawn at random ------------------------------------------------------------------------------


# Numbers of the search's scenes, whose kinds take turns. Every third is the paper's: few of those,
# and more flights and at-bats than others.
FIRST = (4, 4, 8, 8, 1, 2, 7, 7, 11, 11, 0, 3)


def random_scene(rng):
    """A scene of `analysis.scene_search`, as it is written, without some of its keys.

    Half of the flights go forwards, some to a fence that is near; half of the bats may miss.
    """
    (scene,) = drawn(1, rng.getrandbits(32), first=rng.choice(FIRST))
    written = json.loads(scene.as_written())
    del written["id"]
    if not written["reading"]:
        options = random_reading(np.random.default_rng(rng.getrandbits(32)))
        written["reading"] = options | {"lift_direction": "fixed_spin_axis"}
    if "launch" in written and rng.random() < 0.5:
        x, y, z = written["launch"]["velocity"]
        written["launch"]["velocity"] = [abs(x) + abs(y), y, z]
    if "fence" in written and rng.random() < 0.5:
        far, top = rng.uniform(5, 80), rng.uniform(1, 20)
        written["fence"] = {"polyline": [[far, far, top], [1.5 * far, 0, 5], [far, -far, top]]}
    if "height_offset" in written.get("swing", {}) and rng.random() < 0.5:
        written["swing"]["height_offset"] = rng.uniform(-0.08, 0.08)
    for _ in range(20):
        few = thinned(written, rng)
        with suppress(InvalidScene):
            parse_scene(json.dumps(few))
            return few
    return random_scene(rng)


def thinned(block, rng):
    """A block without some of its keys, in it and in the blocks of it."""
    return {
        key: thinned(value, rng) if isinstance(value, dict) else value
        for key, value in block.items()
        if key == "kind" or rng.random() < 0.85
    }
