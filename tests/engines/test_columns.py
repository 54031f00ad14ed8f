"""A scene has the same answer, to the bit, alone and among any number of others, in any order."""

import contextlib
import itertools
import json

from hypothesis import given, settings
from hypothesis import strategies as st

from longball.engines.batch import Batch, solve_columns
from longball.engines.chain import solve
from longball.model.quantities import numbers, replaced
from longball.model.readings import LEDGER, Reading
from longball.model.scene import AtBatScene, parse_scene
from tests.scenes import cases_of, paper_cases, paper_scenes

ENGINE = Batch()


def alone(scenes):
    return [solve(scene, ENGINE) for scene in scenes]


def together(scenes):
    return ENGINE.solve_all(scenes)


# --- every kind of scene, every reading ----------------------------------------------------------


def readings():
    """Each option of each switch that a scene has, the others being default."""
    for entry in LEDGER:
        if entry.switch in Reading.model_fields:
            for option in entry.options:
                yield Reading.model_validate({entry.switch: option})


def every_kind(whole):
    """Golden scenes of every kind and outcome, hard ones included, under every reading."""
    each = 1 if whole else 5
    cases = paper_cases()
    chosen = [case.scene for case in cases[:: 5 * each]]
    chosen += [case.scene for case in cases if case.id.startswith("hard-")][::each]
    for family in ("impact-oblique", "fence"):
        chosen += [case.scene for case in cases_of(family)][::each]
    yield from chosen
    plain = [scene for scene in chosen if scene.reading == Reading()][::9]
    for reading, scene in itertools.product(readings(), plain):
        with contextlib.suppress(ValueError):  # a launch that is underground in this reading
            yield type(scene)(**dict(scene) | {"reading": reading})


def test_one_by_one_or_all_at_once(nightly):
    scenes = list(every_kind(nightly))
    assert len(scenes) > (800 if nightly else 150)
    wanted = [result.line() for result in alone(scenes)]
    assert [result.line() for result in together(scenes)] == wanted


@settings(max_examples=settings().max_examples // 3)
@given(st.lists(paper_scenes(), min_size=1, max_size=40), st.randoms())
def test_any_scenes_in_any_order(scenes, chance):
    wanted = [result.line() for result in alone(scenes)]
    order = list(range(len(scenes)))
    chance.shuffle(order)
    found = together([scenes[i] for i in order])
    assert [result.line() for result in found] == [wanted[i] for i in order]


@settings(max_examples=settings().max_examples // 3)
@given(st.lists(paper_scenes("at-bat"), min_size=1, max_size=5))
def test_columns_are_scenes(scenes):
    """A table of columns has the numbers of the results, and no others."""
    base = AtBatScene(id="base", reading=scenes[0].reading)
    names = [name for name, _ in numbers(base) if name != "reading"]
    columns = {
        name: [dict(numbers(scene))[name] for scene in scenes]
        for name in names
        if name in dict(numbers(scenes[0]))
    }
    table = solve_columns(base, columns, ENGINE)
    for i, result in enumerate(alone(scenes)):
        assert table["outcome"][i] == (result.outcome or "")
        if result.outcome is None:
            continue
        texts = {"outcome": result.outcome, "engine": result.engine}
        known = {n: c[i] for n, c in table.items() if c[i] == c[i]}
        assert known == texts | dict(numbers(result))


def test_rows_without_gravity_are_flown_by_the_engine_that_flies_them_alone():
    """Nothing keeps such a ball from coming to rest, which the compiled code leaves to others."""
    line = {"kind": "pitch", "id": "x", "earth": {"latitude": 0.7}, "pitch": {"spin": [0, 90, 20]}}
    scene = parse_scene(json.dumps(line))
    gravity = [9.8, 0.0, 9.8]
    table = solve_columns(scene, {"gravity": gravity}, ENGINE)
    for i, g in enumerate(gravity):
        result = solve(replaced(scene, {"gravity": g}), ENGINE)
        assert (table["outcome"][i], table["engine"][i]) == ("crossed", result.engine)
        assert table["plate.time"][i] == result.plate.time
    assert table["engine"][0] != table["engine"][1]


def test_pitches_along_the_plane_of_the_plate_are_declined_as_alone():
    """They never cross it, so that nothing says how large an error of the crossing is."""
    line = {"kind": "pitch", "id": "x", "pitch": {"velocity": [-30.0, 2.0, 1.0]}}
    crossing = parse_scene(json.dumps(line))
    beside = parse_scene(json.dumps(line | {"pitch": {"velocity": [0.0, 2.0, 1.0]}}))
    results = together([crossing, beside] * 16)
    wanted = [result.line() for result in alone([crossing, beside])]
    assert [result.line() for result in results] == wanted * 16
    assert results[1].code == "out_of_range"


def test_values_of_a_table_in_columns_of_a_ball_without_spin():
    """Under a table of the spin parameter it keeps the first value; the nodes do not matter."""
    drag = {"law": "table", "of": "spin_parameter", "at": [0.0, 0.5], "values": [0.3, 0.5]}
    launch = {"position": [0, 0, 1], "velocity": [30, 0, 20], "spin": [0.0, 0.0, 0.0]}
    line = {"kind": "flight", "launch": launch, "air": {"drag_coefficient": drag}}
    scene, name = parse_scene(json.dumps(line)), "air.drag_coefficient.values[0]"
    values = [0.3, 0.4]
    table = solve_columns(scene, {name: values}, ENGINE)
    wanted = [solve(replaced(scene, {name: x}), ENGINE).landing.distance for x in values]
    assert table["landing.distance"].tolist() == wanted
