"""Known mistakes in when ball and bat meet, the collision, the fence, readings and outcomes.

How a ball flies is in `flight_mistakes`, formulas that stand by themselves in `formulas`, friction
in `rubbing`. Numbers of the scene that are taken for others are not listed: `fits` finds any.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from itertools import pairwise
from typing import Any

from longball.engines.chain import MODEL, OneCase, collide, reach_plate
from longball.judge.any_law import ANY_LAW
from longball.judge.changes import Mistake, reading_change, scene_change
from longball.judge.formulas import EFFECTIVE, MU, PIVOT, PLAIN, misread
from longball.judge.rubbing import STILL, rubbed
from longball.judge.stages import Change, Numbers, with_values
from longball.model.readings import Reading
from longball.model.scene import Pitch, parse_scene

# --- where ball and bat meet ----------------------------------------------------------------------


def _swung_at(height: Callable[[Any], float]) -> Change:
    """Return the change of the height of the bat's axis, m."""
    return scene_change(lambda scene: {"swing.height_offset": height(scene) - _crossing(scene)})


@lru_cache(maxsize=4096)
def _crossing_of(line: str) -> float:
    case = OneCase(parse_scene(line), ANY_LAW, MODEL)
    reach_plate(case)
    return float(case.answer["plate.position"][2]) if "plate.position" in case.answer else math.nan


def _crossing(scene: Any) -> float:
    """Return the height at which the pitch of a scene crosses the plate, m."""
    return _crossing_of(scene.line())


def _reaching(reach: Callable[[Any], float]) -> Change:
    """Return the change of the distance from the bat's axis at which the ball touches it, m."""
    return Change(meeting=lambda scene: with_values(
        scene, {"bat.radius": reach(scene) - scene.ball.radius}))  # fmt: skip


_HEIGHT = "the bat's height is z'_b + σ_b: that of the ball at the plate, and swing.height_offset"
_AIM = float((Pitch().aim or (0.0, 0.0))[1])  # m, what a program may have built in
_REACH = "ball and bat touch where the ball's centre is R + r_b from the bat's axis"

TOUCHING: tuple[Mistake, ...] = (
    Mistake("height-from-release", "puts the bat at swing.height_offset above the release",
            _HEIGHT, _swung_at(lambda s: s.pitch.release[2] + s.swing.height_offset)),
    Mistake("height-from-aim", "puts the bat at swing.height_offset above the height aimed at",
            _HEIGHT, _swung_at(lambda s: s.pitch.aim[1] + s.swing.height_offset)),
    Mistake("height-from-usual-aim", f"puts the bat at swing.height_offset above z = {_AIM:g} m",
            _HEIGHT, _swung_at(lambda s: _AIM + s.swing.height_offset)),
    Mistake("height-of-offset-alone", "puts the bat at swing.height_offset above z = 0",
            _HEIGHT, _swung_at(lambda s: s.swing.height_offset)),
    Mistake("offset-sign", "counts swing.height_offset downwards", _HEIGHT,
            scene_change(lambda scene: {"swing.height_offset": -scene.swing.height_offset})),
    Mistake("offset-ignored", "puts the bat where the ball crosses the plate", _HEIGHT,
            scene_change(lambda scene: {"swing.height_offset": 0.0})),
    Mistake("touches-at-bat-radius", "lets ball and bat touch at r_b, without the ball's radius",
            _REACH, _reaching(lambda s: s.bat.radius)),
    Mistake("touches-at-ball-radius", "lets ball and bat touch at R, without the bat's radius",
            _REACH, _reaching(lambda s: s.ball.radius)),
    Mistake("touches-at-diameters", "takes diameters for radii where ball and bat touch",
            _REACH, _reaching(lambda s: 2 * (s.ball.radius + s.bat.radius))),
    Mistake("touches-at-ball-diameter", "takes the ball's diameter where ball and bat touch",
            _REACH, _reaching(lambda s: 2 * s.ball.radius + s.bat.radius)),
)  # fmt: skip


TWO_STEP_PUSH = Mistake(
    "two-step-push",
    "lets the bat push for two steps, as Appendix B has it, while the ball flies on",
    "strike at once, at the time and place of touching; only the impulse is meant",
    Change(push=True),
)


def _batted(change: Callable[[Any, Any], Mapping[str, Any]]) -> Change:
    """Return the change of how the batted ball is set free, from the scene and its launch."""
    return Change(launch=lambda scene, launch: replace(launch, **change(scene, launch)))


def _bat_axis(scene: Any, launch: Any) -> dict[str, Any]:
    _, y, _ = launch.position
    return {"position": (0.0, y, _crossing(scene) + scene.swing.height_offset)}


_FREE = "the batted ball flies from contact.position"

BATTED: tuple[Mistake, ...] = (
    Mistake("batted-above-origin", "lets the batted ball fly from above (0, 0)", _FREE,
            _batted(lambda s, launch: {"position": (0.0, 0.0, launch.position[2])})),
    Mistake("batted-from-bat-axis", "lets the batted ball fly from the bat's axis", _FREE,
            _batted(_bat_axis)),
    *(Mistake(f"batted-from-{height:g}", f"lets the batted ball fly from the height of {height:g} "
              "m", _FREE, _batted(lambda s, launch, height=height: {  # type: ignore[misc]
                  "position": (*launch.position[:2], height)})) for height in (0.0, 1.0)),
    Mistake("batted-upwards", "lets a ball that is batted down fly upwards",
            "the batted ball flies with impact.velocity", _batted(lambda s, launch: {
                "velocity": (*launch.velocity[:2], abs(launch.velocity[2]))})),
)  # fmt: skip

# Mistakes that the parts after them hide if their own quantity is not answered: changes of the
# whole chain, tried where a stage's inputs are longball's own.
READINGS: tuple[Mistake, ...] = (
    Mistake("plain-restitution", PLAIN, EFFECTIVE, reading_change(bat_ball_restitution="plain")),
    Mistake("nathan", "uses Nathan's formula: e with the effective mass in μ",
            "the paper prints ẽ = e(1 + m/M_eff) + m/M_eff with μ from the bat's mass M",
            reading_change(bat_ball_restitution="nathan")),
    *misread("effective-mass"),
    Mistake("reduced-mass", "takes μ from M_eff", MU,
            reading_change(reduced_mass="effective_mass")),
    *misread("thin-rod", "inertia-about-centre"),
    Mistake("landing-of-surface", "lets the ball land when its surface touches the ground, at "
            "z = R", "the ball lands when its centre reaches the ground, unless the reading "
            "ground_contact says otherwise", reading_change(ground_contact="surface")),
    Mistake("ignores-reading", "ignores the scene's reading block",
            "take the switches of scene.reading, or leave those scenes out with --golden",
            Change(lambda scene: scene.model_copy(update={"reading": Reading()}))),
)  # fmt: skip

# Whoever takes no heed of one switch has its default: of those that scenes set otherwise.
IGNORED: tuple[Mistake, ...] = tuple(
    Mistake(f"ignores-{name}", f"ignores reading.{name}: acts as if it were {field.default}",
            f"take reading.{name} from the scene", reading_change(**{name: field.default}))
    for name, field in Reading.model_fields.items()
)  # fmt: skip

TIME_LIMIT_IGNORED = Mistake(
    "time-limit-ignored", "flies on beyond time_limit",
    "a ball that has not come down after time_limit seconds of flight is airborne",
    scene_change(lambda scene: {"time_limit": 1e4}),
)  # fmt: skip

# What shows in outcomes alone.
OUTCOMES: tuple[Mistake, ...] = (
    TIME_LIMIT_IGNORED,
    Mistake("ground-ignored", "has the ground at z = 0, whatever ground.height is",
            "the ball lands at ground.height", scene_change(lambda scene: {"ground.height": 0.0})),
)  # fmt: skip


# --- the collision --------------------------------------------------------------------------------


def _met(change: Callable[[Any, Any], dict[str, Any]]) -> Change:
    """Return the change of what goes into the collision, from the scene and the contact."""

    def struck(cases: Any, contact: Any, error: Any, *carried: Any) -> tuple[Any, ...]:
        other = replace(contact, **change(cases.scene, contact))
        return collide(cases, other, error, *carried)

    return Change(model=lambda model: replace(model, collide=struck))


IMPACT: tuple[Mistake, ...] = (
    Mistake("other-pivot", "measures r̃ from the bat's end A, at y = -L/2", PIVOT,
            _met(lambda s, contact: {"lever_arm": s.bat.length - contact.lever_arm})),
    Mistake("middle-lever", "takes half the bat's length for r̃, whatever y is", PIVOT,
            _met(lambda s, contact: {"lever_arm": s.bat.length / 2})),
    Mistake("lever-of-size", "takes |y| for y in r̃", PIVOT,
            _met(lambda s, contact: {
                "lever_arm": min(contact.lever_arm, s.bat.length - contact.lever_arm)})),
    Mistake("free-lever-from-end", "measures a free bat's lever from its end, and not from its "
            "centre", "bat.support = free: M_eff = 1/(1/M + y²/I) with I about the centre",
            _met(lambda s, contact: {} if s.bat.support != "free" else {
                "lever_arm": s.bat.length / 2 - contact.lever_arm})),
    Mistake("spin-of-release", "strikes the ball with the spin of the release",
            "spin falls by e along spin_decay_length, on the way to the bat too",
            _met(lambda s, contact: {} if s.kind != "at-bat" or contact.spin is None
                 else {"spin": s.pitch.spin})),
    Mistake("friction-without-spin", "leaves the ball's spin out of the slip",
            "g = V + ω × (-R n) - V_b: the surface moves with the spin",
            rubbed(spin=lambda contact: STILL)),
    Mistake("friction-without-rotation", "leaves the bat's rotation out of the slip",
            "g = V + ω × (-R n) - V_b - Ω_b × (r_b n): the bat's surface turns with Ω_b",
            rubbed(rotation=lambda scene: STILL)),
    Mistake("friction-ignored", "strikes without friction", "see bat.friction",
            scene_change(lambda scene: {"bat.friction": None})),
    Mistake("slides-finally", "lets the friction act along what would end the slip",
            "against the slip as it begins, unless the reading slide_direction says final",
            reading_change(slide_direction="final")),
    Mistake("free-for-pivot", "lets the bat with friction move as a free one, where it turns about "
            "its end", "bat.support = pivot, if it is not given: the bat turns about its end",
            scene_change(lambda scene: {} if scene.bat.friction is None
                         else {"bat.support": "free"})),
    Mistake("pivot-for-free", "has a free bat turn about its end",
            "bat.support = free: it moves and turns about its centre",
            scene_change(lambda scene: {"bat.support": "pivot"})),
)  # fmt: skip


# --- the fence ------------------------------------------------------------------------------------


def _fence(change: Callable[[Any], Any]) -> Change:
    """Return the change of the vertices of a fence."""
    return scene_change(lambda scene: {"fence.polyline": tuple(change(scene.fence.polyline))})


_PARTS = 64  # of a chord that is bent


def _by_angle(vertices: Sequence[Numbers]) -> Iterator[Numbers]:
    polar = [(math.hypot(x, y), math.atan2(y, x), height) for x, y, height in vertices]
    for a, b in pairwise(polar):
        for i in range(_PARTS):
            r, angle, height = (p + (q - p) * i / _PARTS for p, q in zip(a, b, strict=True))
            yield r * math.cos(angle), r * math.sin(angle), height
    yield vertices[-1]


def _level(
    height: Callable[[float, float], float], vertices: Sequence[Numbers]
) -> Iterator[Numbers]:
    """Yield the vertices of a fence whose chords are level, from the heights at their ends."""
    for (*a, low), (*b, high) in pairwise(vertices):
        yield from ((*a, height(low, high)), (*b, height(low, high)))


_HEIGHT_ALONG = "the height is linear along a chord"

FENCE: tuple[Mistake, ...] = (
    Mistake("fence-by-angle", "bends the fence: its distance is linear in the angle",
            "vertices are joined by straight chords", _fence(_by_angle)),
    Mistake("fence-without-height", "takes the fence for a line on the ground",
            "the third number of a vertex is the fence's height there",
            _fence(lambda v: ((x, y, 0.0) for x, y, _ in v))),
    *(Mistake(f"fence-height-of-{name}", f"has a chord as high as {words}", _HEIGHT_ALONG,
              _fence(partial(_level, height)))
      for name, words, height in (
          ("first", "its first vertex", lambda a, b: a), ("last", "its last vertex",
                                                          lambda a, b: b),
          ("higher", "its higher vertex", max), ("lower", "its lower vertex", min),
          ("mean", "the mean of its vertices", lambda a, b: (a + b) / 2))),
    Mistake("fence-height-reversed", "lets the height along a chord run the other way",
            _HEIGHT_ALONG, _fence(lambda v: (
                end for (*a, low), (*b, high) in pairwise(v) for end in ((*a, high), (*b, low))))),
    Mistake("fence-one-height", "has a fence that is everywhere as high as its first vertex",
            _HEIGHT_ALONG, _fence(lambda v: ((x, y, v[0][2]) for x, y, _ in v))),
    Mistake("fence-height-in-feet", "takes the fence's height for feet", "heights are in m",
            _fence(lambda v: ((x, y, 0.3048 * height) for x, y, height in v))),
    Mistake("fence-without-steps", "leaves out the second of two vertices at one place",
            "where the height steps, a vertex is given twice", _fence(lambda v: (
                b for a, b in pairwise((None, *v)) if a is None or a[:2] != b[:2]))),
    Mistake("fence-cleared-by-surface", "asks the ball's whole surface to clear the fence",
            "the centre does, unless the reading fence_clearance says surface",
            reading_change(fence_clearance="surface")),
    Mistake("fence-cleared-by-centre", "asks the ball's centre alone to clear the fence",
            "take reading.fence_clearance from the scene",
            reading_change(fence_clearance="centre")),
)  # fmt: skip
