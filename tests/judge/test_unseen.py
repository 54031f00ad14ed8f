"""Scenes that nobody has seen: the scenes at hand, moved; and names that they refute."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import partial
from types import SimpleNamespace

import numpy as np

from longball.engines.ivp import Ivp
from longball.golden import load
from longball.judge.answers import Answer
from longball.judge.cases import solved
from longball.judge.diagnosis import unseen
from longball.judge.diagnosis.chain import I
from longball.judge.diagnosis.diagnose import diagnose
from longball.judge.diagnosis.expression import constant
from longball.judge.diagnosis.operators import Edit
from longball.judge.diagnosis.residual import Followed, specialised_to
from longball.judge.diagnosis.unseen import Unseen
from longball.judge.fresh import moved
from longball.model.quantities import numbers
from longball.model.scene import Scene
from tests.judge.material import answered, collected, flights, impacts, known, truth


def test_moved_scenes_have_the_same_keys_and_other_numbers():
    scenes = [case.scene for family in ("fence", "flight-weather") for case in load(family)][::9]
    again = [*moved(scenes, 3)]
    assert again == [*moved(scenes, 3)] != [*moved(scenes, 4)]
    for scene, other in zip(scenes, again, strict=True):
        before, after = dict(numbers(scene)), dict(numbers(other))
        assert before.keys() == after.keys()
        assert other.reading == scene.reading
        kept = {name for name in before if before[name] == after[name]}
        assert all(before[name] == 0 for name in kept - {"time_limit"})


def test_ball_and_bat_of_a_moved_impact_still_touch():
    for scene in moved(impacts(), 1):
        (x, _, z), height = scene.incoming.position, scene.incoming.bat_height
        reach = scene.ball.radius + scene.bat.radius
        assert math.isclose(math.hypot(x, z - height), reach, rel_tol=1e-12)


def answers(scenes: Iterable[Scene], flown: Callable[[Scene], dict]) -> dict[str, Answer]:
    asked = list(scenes)
    told = ({"id": x.id, "outcome": "landed", "landing": flown(x)} for x in asked)
    return collected(asked, told).answers


def landed(scene: Scene) -> dict:
    return {key: answered(scene)["landing"][key] for key in ("time", "position")}


def backwards(scene: Scene) -> dict:
    """The landing of a program that steps x against the velocity."""
    told = landed(scene)
    x, y, z = told["position"]
    return {**told, "position": [2 * scene.launch.position[0] - x, y, z]}


def heavy(scene: Scene) -> dict:
    """In all given scenes, but not in new ones, 9.898 m/s² are 101 % of the gravity."""
    return landed(scene.model_copy(update={"gravity": 9.898}))


def test_what_holds_by_chance_gives_way_to_what_holds_in_new_scenes():
    scenes = []
    for scene in flights():
        _, y, z = scene.launch.position
        launch = scene.launch.model_copy(update={"position": (0.0, y, z)})
        scenes.append(scene.model_copy(update={"launch": launch}))
    cases, said = solved(scenes, Ivp()), answers(scenes, backwards)
    # From x = 0 it is only another sign. Elsewhere it is not.
    by_chance = "landing.position is given as (-x, y, z)"
    assert [found.edit for found in diagnose(cases, said).findings] == [by_chance]
    (found,) = diagnose(cases, said, solve=lambda new: answers(new, backwards)).findings
    assert (found.stage, found.edit) == ("flight", "uses the components (-x, y, z) of dr/dt")


def test_a_name_stays_unless_new_scenes_refute_it():
    scenes = [scene.model_copy(update={"air": None}) for scene in flights()]
    cases, said = solved(scenes, Ivp()), answers(scenes, heavy)
    missed = {"moved-1-0000": Answer("moved-1-0000", "missed", {})}
    (simplest, *_) = diagnose(cases, said).findings
    for new, kind, edit in [
        (partial(answers, flown=heavy), "named", "uses 9.898 for g, whatever the scene says"),
        (lambda new: {}, "named", simplest.edit),
        (lambda new: missed, "named", simplest.edit),
        (partial(answers, flown=backwards), "nearest", None),
    ]:
        (found,) = diagnose(cases, said, solve=new).findings
        assert (found.kind, found.edit) == (kind, edit)
        assert ("but not in" in found.sentence) == (kind == "nearest")


def test_new_scenes_refute_what_their_answers_contradict():
    data = truth(known("flight-vacuum")[:3])
    chain = specialised_to(data)
    (stage,) = (one for one in chain if one.kind == "flight")
    nothing = Unseen(data, chain, lambda new: {}, None)
    heavier = Edit(I["g"], constant(9.898, I["g"].dimension), 0.0, "")
    same = Edit(I["g"], 1.0 * I["g"], 0.0, "")
    assert nothing.follows
    assert nothing.holds(chain, stage, heavier, {})
    assert nothing.mends(chain, stage, heavier, {})
    # Answers of programs with the scene's gravity, and with 9.898 m/s²
    for program, edit, other in ((landed, same, heavier), (heavy, heavier, same)):
        answered = Unseen(data, chain, lambda new, program=program: answers(new, program), None)
        assert answered.follows is (program is landed)
        assert answered.holds(chain, stage, edit, {})
        assert answered.mends(chain, stage, edit, {})
        assert not answered.holds(chain, stage, other, {})
        assert not answered.mends(chain, stage, other, {})


def test_new_scenes_that_refute_an_explanation(monkeypatch):
    """One number, or for an edit with a jump and for a scheme those of more than one scene."""
    data = truth(known("flight-vacuum")[:3])
    chain = specialised_to(data)
    (stage,) = (one for one in chain if one.kind == "flight")
    new = Unseen(data, chain, lambda new: {}, None)
    new.data = data
    scheme = SimpleNamespace(way="a way")
    for beyond, rough, by, expected in (
        (0, False, None, None), (1, False, None, (1, 6)), (1, True, None, None),
        (1, False, scheme, None), (2, True, None, (2, 6)), (2, False, scheme, (2, 6)),
    ):  # fmt: skip
        off = np.zeros((1, 7))
        off[0, :beyond], off[0, 6] = 5.0, math.nan
        one = Followed(stage, np.arange(7), off, *np.ones((4, 1, 7)))
        for each, found in ((one, expected), (one.of(np.array([6])), None)):
            monkeypatch.setattr(unseen, "follow", lambda *_, each=each: ({}, [each]))
            assert new.refuting(chain, data, None)(stage, rough, by) == found


def test_a_conversion_has_to_hold_in_new_scenes(monkeypatch):
    one, other = (SimpleNamespace(edit=name) for name in ("degrees", "feet"))
    new = Unseen(None, (), None, None)
    new.data = "wrong"
    for named, there, holds in (
        ([one], [one], True), ([one], [one, other], True), ([one, other], [one], False),
    ):  # fmt: skip
        monkeypatch.setattr(unseen, "outputs", lambda data, chain, there=there: ("right", there))
        again = new.converted(named)
        assert (again is not None) == holds
        assert again is None or again.data == "right"
