"""Known mistakes at the bat, at the fence, in what is set free and in what counts as an outcome.

The oblique impulse is that of `longball.model.impact`, put together otherwise: another slip,
another K, a ball that grips or slides where it should not, or slides with another impulse.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import pairwise
from typing import Any

from longball.engines.chain import MODEL, OneCase, collide, meet_bat, reach_plate
from longball.engines.chain.collision import ContactState, Impact
from longball.judge.any_law import ANY_LAW
from longball.judge.changes import Mistake, scene_change
from longball.judge.stages import Change, Numbers, with_values
from longball.model import impact
from longball.model.bat import (
    bat_rotation,
    collision_parameters,
    inertia_factor,
    inverse_mass_arguments,
    tangential_restitution,
)
from longball.model.numbers import DOUBLES, Vector
from longball.model.quantities import at
from longball.model.scene import Pitch, parse_scene

# --- where ball and bat meet ----------------------------------------------------------------------


def _swung_at(height: Callable[[Any], float]) -> Change:
    """Return the change of the height of the bat's axis, m."""
    return scene_change(lambda scene: {"swing.height_offset": height(scene) - _crossing(scene)})


def _offset(more: Callable[[Any], float]) -> Change:
    """Return the change of the height of the bat's axis by so much, m."""
    return scene_change(lambda s: {"swing.height_offset": s.swing.height_offset + more(s)})


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
    *(Mistake(f"bat-{way}-by-{name}", f"puts the bat's axis {name} too {way}", _HEIGHT,
              _offset(lambda s, name=name, sign=sign: sign * at(s, name)))  # type: ignore[misc]
      for way, sign in (("high", 1), ("low", -1)) for name in ("ball.radius", "bat.radius")),
    Mistake("touches-at-bat-radius", "lets ball and bat touch at r_b, without the ball's radius",
            _REACH, _reaching(lambda s: s.bat.radius)),
    Mistake("touches-at-ball-radius", "lets ball and bat touch at R, without the bat's radius",
            _REACH, _reaching(lambda s: s.ball.radius)),
    Mistake("touches-at-diameters", "takes diameters for radii where ball and bat touch",
            _REACH, _reaching(lambda s: 2 * (s.ball.radius + s.bat.radius))),
    Mistake("touches-at-bat-diameter", "takes the bat's diameter where ball and bat touch",
            _REACH, _reaching(lambda s: s.ball.radius + 2 * s.bat.radius)),
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


@lru_cache(maxsize=4096)
def _spin_at_bat(scene: Any) -> Numbers | None:
    """Return the spin with which the ball of a scene comes to the bat, rad/s."""
    _, meeting = meet_bat(OneCase(scene, ANY_LAW, MODEL))
    return None if meeting is None else meeting.contact.spin


def _spinning(spin: Callable[[Any, Any], Any]) -> Change:
    """Return the change of a batted ball's spin, if it has one: of the scene and that spin."""
    return _batted(lambda s, launch: {} if launch.spin is None else {"spin": spin(s, launch.spin)})


_AT_REST = (0.0, 0.0, 0.0)


def _unspun(scene: Any, spin: Any) -> Any:
    return None if isinstance(scene.air and scene.air.lift_coefficient, float) else _AT_REST


_SPINS = "the batted ball has the spin that the impact gives it"

_FREE = "the batted ball flies from contact.position"

BATTED: tuple[Mistake, ...] = (
    Mistake("batted-above-origin", "lets the batted ball fly from above (0, 0)", _FREE,
            _batted(lambda s, launch: {"position": (0.0, 0.0, launch.position[2])})),
    Mistake("batted-from-bat-axis", "lets the batted ball fly from the bat's axis", _FREE,
            _batted(_bat_axis)),
    *(Mistake(f"batted-from-{axis}=0", f"lets the batted ball fly from {axis} = 0", _FREE,
              _batted(lambda s, launch, i=i: {"position": (  # type: ignore[misc]
                  *launch.position[:i], 0.0, *launch.position[i + 1 :])}))
      for i, axis in enumerate("xyz")),
    Mistake("batted-upwards", "lets a ball that is batted down fly upwards",
            "the batted ball flies with impact.velocity", _batted(lambda s, launch: {
                "velocity": (*launch.velocity[:2], abs(launch.velocity[2]))})),
    Mistake("batted-without-spin", "lets the batted ball fly without spin", _SPINS,
            _spinning(lambda s, spin: _AT_REST)),
    Mistake("batted-about-fixed-axis", "lifts the batted ball about a fixed axis where C_L is a "
            "number, as if it had no spin", _SPINS, _spinning(_unspun)),
    Mistake("batted-spin-reversed", "turns the batted ball's spin the other way round", _SPINS,
            _spinning(lambda s, spin: tuple(-x for x in spin))),
    Mistake("spin-of-pitch-kept", "lets the batted ball fly with the spin of the pitch", _SPINS,
            _spinning(lambda s, spin: _spin_at_bat(s))),
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


Floats = Vector[float]
Matrix = tuple[float, ...]

STILL = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Parts:
    """What the impulse is put together from; a mistake has another part."""

    # Of ball and bat as they go into the slip, rad/s: from the contact and the scene.
    spin: Callable[[ContactState[float]], Floats] = lambda contact: contact.spin or STILL
    rotation: Callable[[Any], Floats] = lambda scene: bat_rotation(scene.swing, DOUBLES)
    # Their tangential restitution, from the scene's and ẽ.
    tangential: Callable[[float, float], float] = lambda given, e: given
    # Of ball and bat as they go into the slip, m, from the scene.
    radii: Callable[[Any], tuple[float, float]] = lambda s: (s.ball.radius, s.bat.radius)
    # Those of `inverse_mass` that are others, from the scene and the right ones.
    arguments: Callable[[Any, Mapping[str, float]], Mapping[str, float]] = lambda scene, given: {}
    # K, 1/kg, from what it is and from its own K_nn, which 1/μ stands for.
    matrix: Callable[[Matrix, float], Matrix] = lambda k, own: k
    # Whether the ball grips, from whether it should.
    grips: Callable[[bool], bool] = lambda grips: grips
    # The impulse of a ball that slides, N s: from the right one, the gripping one, and the
    # frictionless one along the normal.
    sliding: Callable[[Floats, Floats, float], Floats] = lambda slid, gripped, plain: slid


def rubbed(**parts: Any) -> Change:
    """Return the change of some of the `Parts`."""
    made = Parts(**parts)

    def collision(cases: Any, contact: Any, error: Any, *carried: Any) -> tuple[Any, ...]:
        if cases.scene.bat.friction is None:
            return collide(cases, contact, error, *carried)
        return cases, _struck(cases.scene, contact, made), *carried

    return Change(model=lambda model: replace(model, collide=collision))


def _struck(scene: Any, contact: ContactState[float], parts: Parts) -> Impact[float]:
    """Return the impulse with such parts, and what it does."""
    ball, bat, normal = scene.ball, scene.bat, contact.normal
    pair = collision_parameters(ball, bat, contact.lever_arm, scene.reading, DOUBLES)
    e = pair.restitution
    e_t = parts.tangential(tangential_restitution(bat, DOUBLES), e)
    motion = contact.velocity, parts.spin(contact), contact.bat_velocity, parts.rotation(scene)
    g = contact.normal_speed, *impact.slip(*motion, normal, *parts.radii(scene))[1:]
    given = inverse_mass_arguments(ball, bat, contact.lever_arm, scene.reading, DOUBLES)
    own, *others = impact.inverse_mass(**{**given, **parts.arguments(scene, given)})
    k = parts.matrix((1 / pair.reduced_mass, *others), own)

    wanted = impact.gripping_impulse(k, e, e_t, g)
    rubbed = math.hypot(*wanted[1:])
    margin = bat.friction * wanted[0] - rubbed
    grips = parts.grips(margin > 0)
    push = wanted
    if not grips:
        initial = scene.reading.slide_direction == "initial"
        way = g[1:] if initial else (-wanted[1], -wanted[2])
        speed = math.hypot(*way) or 1.0  # without slip there is no direction, and no friction
        direction = way[0] / speed, way[1] / speed
        resistance = impact.sliding_resistance(k, bat.friction, direction)
        slid = impact.sliding_impulse(resistance, e, bat.friction, g, direction)
        push = parts.sliding(slid, wanted, impact.impulse(pair.reduced_mass, e, g[0]))
    factor = inertia_factor(ball, DOUBLES)
    return Impact(
        e,
        push[0],
        impact.velocity_after_push(contact.velocity, push, normal, ball.mass),
        impact.push_energy(push, g, k),
        impact.spin_after_push(contact.spin or STILL, push, normal, ball.mass, ball.radius, factor),
        "grip" if grips else "slide",
        margin / (bat.friction * abs(wanted[0])),
    )


def _along(factor: Callable[[Floats, Floats, float], float]) -> Callable[..., Floats]:
    """Return a sliding impulse with another normal part, and friction in proportion."""

    def sliding(slid: Floats, gripped: Floats, plain: float) -> Floats:
        share = factor(slid, gripped, plain) / slid[0]
        return share * slid[0], share * slid[1], share * slid[2]

    return sliding


def _reversed(vector: Floats) -> Floats:
    x, y, z = vector
    return -x, -y, -z


_PIVOT = "the pivot B is at y = +L/2: r̃ = L/2 - y"
_SLIP = "g = V + ω × (-R n) - V_b - Ω_b × (r_b n), with the bat's Ω_b = ω'(-sin θ, 0, cos θ)"
_K = "g' = g + K P, with K of ball and bat at the point of contact, and n·K n = 1/μ"
_CONE = (
    "the ball grips if the gripping impulse lies within the cone |P_t| ≤ μ_f P_n, else it slides"
)
_SLID = "P = -(1 + ẽ) g_n/(n·K(n - μ_f t)) (n - μ_f t)"

IMPACT: tuple[Mistake, ...] = (
    Mistake("other-pivot", "measures r̃ from the bat's end A, at y = -L/2", _PIVOT,
            _met(lambda s, contact: {"lever_arm": s.bat.length - contact.lever_arm})),
    Mistake("middle-lever", "takes half the bat's length for r̃, whatever y is", _PIVOT,
            _met(lambda s, contact: {"lever_arm": s.bat.length / 2})),
    Mistake("lever-of-size", "takes |y| for y in r̃", _PIVOT, _met(lambda s, contact: {
        "lever_arm": min(contact.lever_arm, s.bat.length - contact.lever_arm)})),
    Mistake("spin-of-release", "strikes the ball with the spin of the release",
            "spin falls by e along spin_decay_length, on the way to the bat too",
            _met(lambda s, contact: {} if s.kind != "at-bat" or contact.spin is None
                 else {"spin": s.pitch.spin})),
    Mistake("friction-without-spin", "leaves the ball's spin out of the slip", _SLIP,
            rubbed(spin=lambda contact: STILL)),
    Mistake("friction-spin-sign", "counts the ball's spin the other way round in the slip", _SLIP,
            rubbed(spin=lambda contact: _reversed(contact.spin or STILL))),
    Mistake("friction-without-rotation", "leaves the bat's rotation out of the slip", _SLIP,
            rubbed(rotation=lambda scene: STILL)),
    Mistake("friction-rotation-sign", "counts the bat's rotation the other way round in the slip",
            _SLIP, rubbed(rotation=lambda s: _reversed(bat_rotation(s.swing, DOUBLES)))),
    Mistake("friction-bat-radius", "takes the bat's radius for the ball's in the slip", _SLIP,
            rubbed(radii=lambda s: (s.bat.radius, s.bat.radius))),
    Mistake("friction-ball-radius", "takes the ball's radius for the bat's in the slip", _SLIP,
            rubbed(radii=lambda s: (s.ball.radius, s.ball.radius))),
    Mistake("friction-uncoupled", "leaves out of K what couples the normal to the slip along the "
            "bat", _K, rubbed(matrix=lambda k, own: (k[0], 0.0, *k[2:]))),
    Mistake("friction-bat-fixed", "leaves the bat out of K, as if it gave way along the normal "
            "only", _K, rubbed(arguments=lambda s, given: {
                "inverse_bat_mass": 0.0, "inertia": math.inf, "axial_inertia": math.inf})),
    Mistake("friction-own-normal", "has n·K n of the bat itself in place of 1/μ", _K,
            rubbed(matrix=lambda k, own: (own, *k[1:]))),
    Mistake("friction-on-axis", "has K on the bat's axis, not at the point of contact", _K,
            rubbed(arguments=lambda s, given: {"bat_radius": 0.0})),
    Mistake("one-restitution", "takes ẽ for the tangential restitution",
            "bat.tangential_restitution, or 0.3", rubbed(tangential=lambda given, e: e)),
    Mistake("always-grips", "lets the ball grip always", _CONE, rubbed(grips=lambda grips: True)),
    Mistake("always-slides", "lets the ball slide always", _CONE,
            rubbed(grips=lambda grips: False)),
    Mistake("slides-with-gripping-impulse", "slides with the normal part of the gripping impulse",
            _SLID, rubbed(sliding=_along(lambda slid, gripped, plain: gripped[0]))),
    Mistake("slides-with-plain-impulse", "slides with the normal impulse of a bat without "
            "friction, -μ(1 + ẽ) g_n", _SLID,
            rubbed(sliding=_along(lambda slid, gripped, plain: plain))),
    Mistake("slides-forward", "lets the friction act along the slip, not against it", _SLID,
            rubbed(sliding=lambda slid, *others: (slid[0], -slid[1], -slid[2]))),
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
    Mistake("fence-height-in-feet", "takes the fence's height for feet", "heights are in m",
            _fence(lambda v: ((x, y, 0.3048 * height) for x, y, height in v))),
    Mistake("fence-without-steps", "leaves out the second of two vertices at one place",
            "where the height steps, a vertex is given twice", _fence(lambda v: (
                b for a, b in pairwise((None, *v)) if a is None or a[:2] != b[:2]))),
)  # fmt: skip
