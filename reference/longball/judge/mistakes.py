"""Known mistakes: what authors of such simulators get wrong, and how to mend it.

A mistake in the law or in the collision is a `Change` of the one chain. A mistake in a formula that
stands by itself is a `Formula`: what the quantity then is, from the scene and the values before it.
Numbers of the scene that are taken for others are not listed here: `longball.judge.fits` finds any.
"""

from __future__ import annotations

import itertools
import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from pydantic import ValidationError

from longball.engines.chain import MODEL, OneCase, collide, reach_plate
from longball.judge.any_law import ANY_LAW
from longball.judge.stages import Change, Numbers, with_values
from longball.model import trace
from longball.model.aerodynamics import DRAG, LIFT, spin_ratio
from longball.model.air import CrisisDrag, Table, Weather
from longball.model.atmosphere import (
    STANDARD_PRESSURE,
    THINNING,
    ZERO_CELSIUS,
    density,
    speed_of_sound,
)
from longball.model.bat import CollisionParameters, collision_parameters, moment_of_inertia
from longball.model.earth import CORIOLIS, ROTATION
from longball.model.force import (
    Branches,
    Drag,
    Flow,
    Force,
    Lift,
    Motion,
    Piecewise,
    Term,
    Wind,
    cross,
    scaled,
    size,
    switched,
)
from longball.model.law import GRAVITY
from longball.model.numbers import DOUBLES, Vector, dot, plus
from longball.model.quantities import at
from longball.model.readings import Reading
from longball.model.scene import parse_scene
from longball.model.wind import ROUGHNESS


@dataclass(frozen=True)
class Mistake:
    """A known mistake in the parts of the chain.

    Attributes
    ----------
    name
        For programs.
    sentence
        What the candidate does, said to its author.
    remedy
        How to mend it.
    change
        The chain with the mistake in it.
    switches
        Whether the law jumps somewhere, so that a candidate's own step across may leave much.
    scaled
        The parameter that a number of the candidate's own then goes into, if there may be one.
    """

    name: str
    sentence: str
    remedy: str
    change: Change
    switches: bool = False
    scaled: str | None = None


# --- the law of motion ----------------------------------------------------------------------------


def _terms(change: Callable[[Term], Term | None]) -> Change:
    """Return the change of each term that may act on a ball in flight; None leaves it out."""
    changed = cache(change)  # the same terms each time, so that their law is traced once
    return Change(
        model=lambda model: replace(
            model, forces=tuple(new for f in model.forces if (new := changed(f)) is not None)
        )
    )


def _carrying(change: Callable[[Term], Term], carried: Term) -> Change:
    """Return the change of each term to one that may use the parameters of another term."""
    changed = cache(change)
    return Change(model=lambda model: replace(model, forces=(*map(changed, model.forces), carried)))


def _form(term: Term) -> Term:
    return term.term if isinstance(term, Piecewise) else term


def _replaced(term: Term, changed: Term) -> Change:
    return _terms(lambda f: changed if f is term else f)


def _instead(term: Term, acceleration: Callable[[Motion, Any], Vector[Any]]) -> Change:
    """Return the change of one term into a force with that acceleration."""
    return _replaced(term, Force(term.parameters, term.strengths, acceleration))


def _without(left_out: Callable[[Term], bool]) -> Change:
    """Return the change that leaves terms out."""
    return _terms(lambda f: None if left_out(_form(f)) else f)


def _lifts(term: Term) -> bool:
    return isinstance(term, Lift) or any("lift" in name for name in term.parameters)


# m/s. A series in time cannot go through the kink of |c| at c = 0. What stands for it has none, and
# is too large by less than SMALL⁴/(8 |c|³): a flight is off by less than 1e-9 of its length.
SMALL = 1e-3


def _size(x: Any) -> Any:
    """Return |x|, smoothly."""
    return (x * x + SMALL * SMALL / 2) / trace.sqrt(x * x + SMALL * SMALL)


def _rising(motion: Motion) -> Any:
    """Return 1 for a ball on its way up and 0 on its way down, smoothly."""
    w = motion.velocity[2]
    return (1.0 + w / trace.sqrt(w * w + SMALL * SMALL)) * 0.5


def _more(term: Term, names: tuple[str, ...], values: Callable[[Any, Any], Any]) -> Term:
    """Return a term with more parameters, whose values are from the scene and the frame."""

    def strengths(scene: Any, frame: Any, numbers: Any) -> tuple[Any, ...] | None:
        found = term.strengths(scene, frame, numbers)
        return found and (*found, *values(scene, frame))

    return Term((*term.parameters, *names), strengths)


def _with_axes(term: Term) -> Term:
    """Return a term with where the axes of the frame point."""
    return _more(term, ("cos", "sin"), lambda scene, frame: (frame.cos, frame.sin))


def _with_launch(term: Term) -> Term:
    """Return a term with the velocity at launch: along, up, size."""

    def values(scene: Any, frame: Any) -> tuple[Any, ...]:
        if scene.kind != "flight":
            return (None,) * 3
        x, y, z = scene.launch.velocity
        return math.hypot(x, y), z, math.hypot(x, y, z)

    return _more(term, ("launch_u", "launch_w", "launch_speed"), values)


def _in_air(
    term: Term, form: Callable[[Motion, Flow, Any], Vector[Any]], extended: Term | None = None
) -> Change:
    """Return the change of drag or lift to ρ k times a form: of the motion, the flow, parameters.

    `extended` is the term with more parameters, if the form needs them.
    """
    (strength,), given = term.parameters, extended or term

    def acceleration(motion: Motion, p: Any) -> Vector[Any]:
        flow = motion.air if term is DRAG else motion.lift
        return scaled(motion.density * getattr(p, strength), form(motion, flow, p))

    return _replaced(term, Force(given.parameters, given.strengths, acceleration))


def _in_space(flow: Flow, p: Any) -> Vector[Any]:
    """Return the velocity in the axes of the scene."""
    (u, v, w), cos, sin = flow.velocity, p.cos, p.sin
    return cos * u - sin * v, sin * u + cos * v, w


def _by_component(square: Callable[[Any], Any]) -> Change:
    """Return the change of the drag to ``-k square(c)`` for each component c in space."""

    def form(motion: Motion, flow: Flow, p: Any) -> Vector[Any]:
        x, y, z = (-square(c) for c in _in_space(flow, p))
        return p.cos * x + p.sin * y, p.cos * y - p.sin * x, z

    return _in_air(DRAG, form, _with_axes(DRAG))


def _summed(motion: Motion, flow: Flow, p: Any) -> Vector[Any]:
    """Return minus the velocity times |x| + |y| + |z| of it."""
    x, y, z = map(_size, _in_space(flow, p))
    return scaled(-(x + y + z), flow.velocity)


def _about(axis: Callable[[Any, Any], Vector[Any]]) -> Change:
    """Return the change of the lift to one about an axis in space, from the scene and the frame."""

    def axis_in_frame(scene: Any, frame: Any) -> tuple[Any, ...]:
        return tuple(frame.turned(axis(scene, frame)))

    def form(motion: Motion, flow: Flow, p: Any) -> Vector[Any]:
        axis = p.axis_s, p.axis_y, p.axis_z
        return scaled(flow.speed, cross(axis, flow.velocity))

    return _in_air(LIFT, form, _more(LIFT, ("axis_s", "axis_y", "axis_z"), axis_in_frame))


def _is_batted(scene: Any, frame: Any) -> bool:
    """Tell whether a flight of an at-bat is that of the batted ball."""
    return scene.kind == "at-bat" and (frame.x, frame.y) != tuple(scene.pitch.release[:2])


def _axis_of_pitch(straight: bool) -> Callable[[Any, Any], Vector[Any]]:
    """Return the axis of the lift, of a batted ball that which the pitch has had.

    Or that of a pitch which comes straight along the field.
    """

    def axis(scene: Any, frame: Any) -> Vector[Any]:
        if not _is_batted(scene, frame):
            return frame.sin, -frame.cos, 0.0
        x, y, _ = (-1.0, 0.0, 0.0) if straight else scene.pitch.thrown
        size = math.hypot(x, y) or 1.0
        return y / size, -x / size, 0.0

    return axis


def _axis_by_arctangent(scene: Any, frame: Any) -> Vector[Any]:
    """Return the axis of a heading atan(v_y/v_x), which is that of the other half of the circle."""
    sign = -1.0 if frame.cos < 0 else 1.0
    return sign * frame.sin, -sign * frame.cos, 0.0


def _drag(factor: Callable[[Motion, Any], Any], given: Term = DRAG) -> Change:
    """Return the change of the drag to ``-k factor v``."""
    changed = Drag(given.parameters, given.strengths, lambda m, p: p.drag * factor(m, p))
    return _replaced(DRAG, changed)


def _vertical_drag(vertical: Callable[[Any], Any]) -> Change:
    """Return the change of the drag's vertical component to ``-k V vertical(w)``."""

    def form(motion: Motion, flow: Flow, p: Any) -> Vector[Any]:
        u, v, w = flow.velocity
        return scaled(-flow.speed, (u, v, vertical(w)))

    return _in_air(DRAG, form)


def _lift(direction: Callable[[Any, Any, Any], Vector[Any]]) -> Change:
    """Return the change of the lift to k_L times a function of u, w and V."""
    return _in_air(
        LIFT, lambda m, flow, p: direction(flow.velocity[0], flow.velocity[2], flow.speed)
    )


def _lift_rising(share: Callable[[Any], Any]) -> Change:
    """Return the change of the lift to one that depends on whether the ball rises."""

    def form(motion: Motion, flow: Flow, p: Any) -> Vector[Any]:
        (u, _, w), rate = flow.velocity, flow.speed * share(_rising(motion))
        return -rate * w, trace.ZERO, rate * u

    return _in_air(LIFT, form)


def _as_at_launch(motion: Motion, flow: Flow, p: Any) -> Vector[Any]:
    """Return V² across the velocity at launch."""
    rate = flow.speed * flow.speed / p.launch_speed
    return -rate * p.launch_w, trace.ZERO, rate * p.launch_u


def _scene(values: Callable[[Any], Mapping[str, Any]]) -> Change:
    """Return the change of a scene's values, by their names; none if it lacks what they need."""

    def change(scene: Any) -> Any:
        try:
            return with_values(scene, values(scene))
        except (ArithmeticError, AttributeError, TypeError, ValueError):
            return scene

    return Change(change)


def _reading(**switches: str) -> Change:
    def change(scene: Any) -> Any:
        try:
            reading = Reading.model_validate(scene.reading.model_dump() | switches)
        except ValidationError:  # it excludes another switch of the scene
            return scene
        return scene.model_copy(update={"reading": reading})

    return Change(change)


def _thrown(values: Callable[[Any], Mapping[str, Any]]) -> Change:
    """Return the change of a pitch that is given by release, speed and aim."""
    return _scene(lambda scene: {} if scene.pitch.aim is None else values(scene.pitch))


def _displaced(factors: Callable[[float], Mapping[str, float]]) -> Change:
    """Return the change of some values by factors of the share of the ball that air would weigh."""

    def values(scene: Any) -> Mapping[str, Any]:
        volume = 4 / 3 * math.pi * scene.ball.radius**3
        share = float(density(scene, DOUBLES)) * volume / scene.ball.mass
        return {name: at(scene, name) * factor for name, factor in factors(share).items()}

    return _scene(values)


_EARTH_RADIUS = 6_371_000.0  # m


def _falling(motion: Motion, p: Any) -> Vector[Any]:
    """Return ``-g (R/(R + z))²`` with the Earth's radius R, upwards."""
    share = _EARTH_RADIUS / (_EARTH_RADIUS + motion.position[2])
    return trace.ZERO, trace.ZERO, -p.gravity * (share * share)


_NO_MORE = "weight, drag and lift are all the forces that there are"
_AGAINST = "the drag is -k V v: against the velocity, in every component"
_ACROSS = "the lift is k_L V (ê × v), which is k_L V (-w, u) in the flight plane"
_SCENE = "take the numbers of the scene"

_PAPERS_LAW: tuple[Mistake, ...] = (
    Mistake("drag-per-component", "drags each component by itself, with its own square",
            "the drag is -k V v: every component times the whole speed V",
            _by_component(lambda c: _size(c) * c)),
    Mistake("unsigned-drag-per-component", "drags each component by its own square without a "
            "sign, so that a falling ball is pulled down", _AGAINST,
            _by_component(lambda c: c * c)),
    Mistake("drag-with-v", "lets the drag grow linearly with V, not with V²",
            "the drag is ½ C_D ρ A V², against the velocity", _drag(lambda motion, p: 1.0),
            scaled="air.drag_coefficient"),
    Mistake("drag-with-v-cubed", "lets the drag grow with V³",
            "the drag is ½ C_D ρ A V²: V v holds the square already",
            _drag(lambda motion, p: motion.speed * motion.speed), scaled="air.drag_coefficient"),
    Mistake("drag-with-launch-speed", "drags with the speed at launch all the time",
            "the drag is -k V v with the present speed V",
            _drag(lambda m, p: p.launch_speed, _with_launch(DRAG))),
    Mistake("drag-with-horizontal-speed", "takes the horizontal speed for V in the drag",
            "V is the whole speed", _drag(lambda m, p: trace.sqrt(
                m.air.velocity[0] * m.air.velocity[0] + m.air.velocity[1] * m.air.velocity[1]))),
    Mistake("drag-with-summed-speed", "takes the sum of the components' sizes for V in the drag",
            "V is the root of the sum of their squares",
            _in_air(DRAG, _summed, _with_axes(DRAG))),
    Mistake("drag-rising-only", "drags the ball on its way up only",
            "the drag acts on the way down too", _drag(lambda m, p: m.speed * _rising(m)), True),
    Mistake("density-falls", "lets the air grow thinner with height",
            "the scene's density holds at every height",
            _scene(lambda scene: {"air.density_scale_height": 8500.0})),
    Mistake("drag-always-down", "drags a falling ball down: the vertical drag has no sign",
            _AGAINST, _vertical_drag(_size)),
    Mistake("vertical-drag-sign", "drags along the vertical velocity instead of against it",
            _AGAINST, _vertical_drag(lambda w: -w)),
    Mistake("drag-forward", "drags along the velocity instead of against it", _AGAINST,
            _drag(lambda motion, p: -motion.speed)),
    Mistake("horizontal-drag-only", "drags the horizontal components only", _AGAINST,
            _vertical_drag(lambda w: trace.ZERO)),
    Mistake("no-drag", "flies without drag", "add -k_D V v",
            _without(lambda term: isinstance(term, Drag))),
    Mistake("no-lift", "flies without lift", "add k_L V (ê × v)", _without(_lifts)),
    Mistake("no-gravity", "flies without gravity", "add -g to the vertical",
            _without(lambda term: term is GRAVITY)),
    Mistake("gravity-falls", "lets gravity fall with height",
            "gravity is the scene's at every height",
            _instead(GRAVITY, _falling)),
    Mistake("gravity-up", "falls upwards", "gravity is -g along z",
            _instead(GRAVITY, lambda m, p: (trace.ZERO, trace.ZERO, p.gravity))),
    Mistake("coefficients-exchanged", "exchanges the coefficients of drag and lift", _SCENE,
            _scene(lambda s: {"air.drag_coefficient": s.air.lift_coefficient,
                              "air.lift_coefficient": s.air.drag_coefficient})),
    Mistake("lift-coefficient-for-drag", "takes the coefficient of the drag for that of the lift",
            _SCENE, _scene(lambda s: {"air.lift_coefficient": s.air.drag_coefficient}),
            scaled="air.lift_coefficient"),
    Mistake("lift-sign", "lifts the ball the wrong way",
            "with backspin the lift turns the velocity upwards: k_L V (-w, u) in the flight plane",
            _lift(lambda u, w, speed: (speed * w, trace.ZERO, -speed * u))),
    Mistake("lift-vertical", "lifts straight up with V², instead of across the velocity", _ACROSS,
            _lift(lambda u, w, speed: (trace.ZERO, trace.ZERO, speed * speed))),
    Mistake("lift-vertical-part", "has the vertical part of the lift, and not the horizontal one",
            _ACROSS, _lift(lambda u, w, speed: (trace.ZERO, trace.ZERO, speed * u))),
    Mistake("lift-not-across", "turns the horizontal part of the lift the wrong way: it is not "
            "perpendicular to the velocity", _ACROSS,
            _lift(lambda u, w, speed: (speed * w, trace.ZERO, speed * u))),
    Mistake("lift-with-v", "lets the lift grow with V, not with V²", "the lift is ½ C_L ρ A V²",
            _lift(lambda u, w, speed: (-w, trace.ZERO, u)), scaled="air.lift_coefficient"),
    Mistake("lift-with-horizontal-speed", "takes the horizontal speed for V in the lift", _ACROSS,
            _lift(lambda u, w, speed: (-_size(u) * w, trace.ZERO, _size(u) * u))),
    Mistake("lift-as-at-launch", "keeps the direction that the lift has at launch", _ACROSS,
            _in_air(LIFT, _as_at_launch, _with_launch(LIFT))),
    Mistake("lift-rising-only", "lifts the ball on its way up only",
            "the lift acts on the way down too", _lift_rising(lambda up: up), True),
    Mistake("lift-sign-falling", "lifts a falling ball the wrong way", _ACROSS,
            _lift_rising(lambda up: 2.0 * up - 1.0), True),
    Mistake("lift-about-minus-y", "lifts about -y, whatever the ball's heading",
            "the axis ê is horizontal and across the heading at launch",
            _about(lambda scene, frame: (0.0, -1.0, 0.0))),
    Mistake("lift-about-axis-of-pitch", "lifts a batted ball about the axis that the pitch had",
            "the axis ê is fixed at the launch of each flight: at the impact anew",
            _about(_axis_of_pitch(straight=False))),
    Mistake("lift-about-plus-y", "lifts a batted ball about +y, the axis of a straight pitch",
            "the axis ê is fixed at the launch of each flight: at the impact anew",
            _about(_axis_of_pitch(straight=True))),
    Mistake("heading-by-arctangent", "takes the heading for atan(v_y/v_x), which is the "
            "opposite one where v_x < 0: the lift then has the wrong sign", "take atan2(v_y, v_x), "
            "or divide the horizontal velocity by its size", _about(_axis_by_arctangent)),
    Mistake("lift-sideways", "lifts the ball sideways",
            "the spin axis is horizontal: the lift lies in the vertical plane of the launch",
            _lift(lambda u, w, speed: (trace.ZERO, speed * u, trace.ZERO))),
    Mistake("lift-always-up", "keeps the lift on the upper side of the path, beyond the vertical "
            "too", "fix the spin axis at launch, or ask for the reading lift_direction = always_up",
            _reading(lift_direction="always_up")),
    Mistake("buoyancy", "lets the air buoy the ball up: g (1 - ρ V/m)", _NO_MORE,
            _displaced(lambda share: {"gravity": 1 - share})),
    Mistake("added-mass", "adds half the mass of the air that the ball displaces to its inertia",
            _NO_MORE, _displaced(lambda share: {
                "gravity": 1 / (1 + share / 2), "ball.mass": 1 + share / 2})),
    Mistake("launch-at-origin", "launches the ball at (0, 0, 0)", _SCENE,
            _scene(lambda scene: {"launch.position": (0.0, 0.0, 0.0)})),
    Mistake("launch-above-origin", "launches the ball above (0, 0), at its height", _SCENE,
            _scene(lambda scene: {"launch.position[0]": 0.0, "launch.position[1]": 0.0})),
    Mistake("release-fixed", "throws from (18.44, 0, 1.8), whatever pitch.release is", _SCENE,
            _thrown(lambda pitch: {"pitch.release": (18.44, 0.0, 1.8)})),
    Mistake("aim-exchanged", "exchanges side and height of the aim", "pitch.aim is [y, z]",
            _thrown(lambda pitch: {"pitch.aim": pitch.aim[::-1]})),
    Mistake("aim-level", "throws level: the height of the aim is ignored", _SCENE,
            _thrown(lambda pitch: {"pitch.aim[1]": pitch.release[2]})),
    Mistake("aim-straight", "throws straight ahead: the side of the aim is ignored", _SCENE,
            _thrown(lambda pitch: {"pitch.aim[0]": pitch.release[1]})),
    Mistake("aim-side-from-release", "counts the side of the aim from the point of release",
            "the aim is a point: y and z where the plate is",
            _thrown(lambda pitch: {"pitch.aim[0]": pitch.aim[0] + pitch.release[1]})),
    Mistake("pitch-speed-along-x", "gives the ball pitch.speed along x, and the rest of the way "
            "on top", "pitch.speed is the size of the velocity at the release",
            _thrown(lambda pitch: {"pitch.speed": pitch.speed * math.hypot(*pitch.way)
                                   / abs(pitch.way[0])})),
    Mistake("aim-from-release", "counts the aim from the point of release",
            "the aim is a point: y and z where the plate is",
            _thrown(lambda pitch: {"pitch.aim[0]": pitch.aim[0] + pitch.release[1],
                                   "pitch.aim[1]": pitch.aim[1] + pitch.release[2]})),
)  # fmt: skip


# --- spin, air and wind ---------------------------------------------------------------------------


def _seeing(which: Callable[[Term], bool], change: Callable[[Any], Any]) -> Change:
    """Return the change that gives some terms their strengths in another scene."""

    def under(f: Any) -> Any:
        if not which(_form(f)):
            return f
        name = "branches" if isinstance(f, Piecewise) else "strengths"
        given = getattr(f, name)
        return replace(f, **{name: lambda scene, *rest: given(change(scene), *rest)})

    return _terms(under)


def _spins(change: Callable[[Any, Numbers], Any], *places: str) -> Change:
    """Return the change of the ball's spin, where a scene gives one."""

    def values(scene: Any) -> Mapping[str, Any]:
        names = [f"{place}.spin" for place in places or ("launch", "pitch", "incoming")]
        return {name: change(scene, spin) for name in names if (spin := at(scene, name))}

    return _scene(values)


def _exchange(spin: Numbers, i: int, j: int) -> Numbers:
    found = list(spin)
    found[i], found[j] = found[j], found[i]
    return tuple(found)


def _times(factor: float) -> Callable[[Any, Numbers], Numbers]:
    return lambda scene, spin: tuple(factor * w for w in spin)


def _backspin(scene: Any, spin: Numbers) -> Numbers:
    """Return a backspin of that size."""
    if scene.kind == "flight":
        x, y, _ = scene.launch.velocity
    else:
        x, y = -1.0, 0.0
    across = math.hypot(x, y)
    size = math.hypot(*spin)
    return (size * y / across, -size * x / across, 0.0) if across else spin


def _winds(change: Callable[[Numbers], Numbers]) -> Change:
    def values(scene: Any) -> Mapping[str, Any]:
        wind = scene.air.wind
        if isinstance(wind, tuple):
            return {"air.wind": change(wind)}
        return {"air.wind.velocity": change(wind.velocity)}

    return _scene(values)


def _air(term: Term) -> bool:
    return isinstance(term, Drag | Lift) or term in (DRAG, LIFT) or _lifts(term)


def with_density(scene: Any, value: float) -> Any:
    """Return a scene with another density at height 0, kg/m³.

    Where the weather gives it, it is linear in the pressure, on which nothing else hangs.
    """
    if not isinstance(scene.air.density, Weather):
        return with_values(scene, {"air.density": value})
    nothing = _of_weather(scene, pressure=0.0)
    per_pascal = (_of_weather(scene, pressure=STANDARD_PRESSURE) - nothing) / STANDARD_PRESSURE
    return with_values(scene, {"air.density.pressure": (value - nothing) / per_pascal})


def _density(formula: Callable[[Any, Any], float]) -> Change:
    """Return the change of the density to that of a formula of the scene and its weather."""

    def change(scene: Any) -> Any:
        weather = getattr(getattr(scene, "air", None), "density", None)
        known = isinstance(weather, Weather)
        return with_density(scene, formula(scene, weather)) if known else scene

    return Change(change)


def _of_weather(scene: Any, **other: float) -> float:
    named = {f"air.density.{name}": value for name, value in other.items()}
    return float(density(with_values(scene, named), DOUBLES))


def _dry_of_celsius(scene: Any, weather: Any) -> float:
    """Return the density with T in °C where K belongs, but for the vapour's pressure."""
    t = weather.temperature
    return _of_weather(scene) * float(t / (t - ZERO_CELSIUS))


def _vapour_of_kelvin(scene: Any, weather: Any) -> float:
    """Return the density with the vapour's pressure at T in K where °C belongs."""
    t = weather.temperature
    dry, hot = (_of_weather(scene, humidity=0.0, temperature=x) for x in (t, t + ZERO_CELSIUS))
    vapour = hot - _of_weather(scene, temperature=t + ZERO_CELSIUS)
    return dry - vapour * float((t + ZERO_CELSIUS) / t)


def _at_station(scene: Any, weather: Any) -> float:
    """Return the pressure at the height of the park."""
    if scene.reading.pressure == "station":
        return float(weather.pressure)
    return float(weather.pressure * math.exp(-1.217e-4 * weather.elevation))


def _with_vapour(pressure: Callable[[float], float]) -> Change:
    """Return the change of the saturated vapour's pressure, Pa, to a formula of t in °C."""

    def formula(scene: Any, weather: Any) -> float:
        t = weather.temperature - ZERO_CELSIUS
        dry = _of_weather(scene, humidity=0.0)
        vapour = 0.3783 * weather.humidity * pressure(t)
        return dry * (1 - vapour / _at_station(scene, weather))  # type: ignore[no-any-return]

    return _density(formula)


def _with_pressure(pressure: Callable[[Any], float]) -> Change:
    """Return the change of the pressure at the park to a formula of the weather."""

    def formula(scene: Any, weather: Any) -> float:
        if scene.reading.pressure == "station":
            return _of_weather(scene)
        return _of_weather(scene, elevation=0.0, pressure=pressure(weather))

    return _density(formula)


def _gas(scene: Any, weather: Any) -> float:
    """Return the density of an ideal gas with R = 287.058 J/(kg K), and water's 461.495."""
    t = weather.temperature
    vapour = (_of_weather(scene, humidity=0.0) - _of_weather(scene)) * t / (1.2929 * ZERO_CELSIUS)
    vapour *= STANDARD_PRESSURE / 0.3783
    dry = _at_station(scene, weather) - vapour
    return float(dry / (287.058 * t) + vapour / (461.495 * t))


# Of the saturated vapour's pressure p_0 e^(a t/(b + t)): what it is called, p_0 in Pa, a and b.
_VAPOURS: tuple[tuple[str, tuple[float, ...], float, float], ...] = (
    ("Tetens", (610.78, 610.8, 611.16), 17.27, 237.3),
    ("Magnus", (611.2, 611.16, 610.94), 17.62, 243.12),
    ("Magnus", (610.94, 611.16), 17.625, 243.04),
    ("Bolton", (611.2, 611.16), 17.67, 243.5),
    ("Buck (1981)", (611.21, 611.16), 17.502, 240.97),
    ("Buck without the second term", (611.16, 611.21), 18.687, 257.14),
)


def _vapours() -> Iterator[Mistake]:
    for name, starts, a, b in _VAPOURS:
        for start in starts:
            yield Mistake(
                f"vapour-of-{name.split()[0].lower()}-{start:g}-{a:g}",
                f"takes the vapour pressure by another formula, {start:g} Pa e^({a:g} t/({b:g} + "
                f"t)) ({name})", _WEATHER,
                _with_vapour(lambda t, p=start, a=a, b=b: p * math.exp(a * t / (b + t))),  # type: ignore[misc]
            )  # fmt: skip


# Where the density that falls by e in H is 1, as a height of the scene; that of the scale is 0.
_LEVELS: tuple[tuple[str, str, Callable[[Any], float]], ...] = (
    (
        "launch",
        "from the launch",
        lambda s: (s.launch.position if s.kind == "flight" else s.pitch.release)[2],
    ),
    ("ground", "from the ground", lambda s: s.ground.height),
)


def _denser(factor: Callable[[Any, float], float], other: float | None = 0.0) -> Change:
    """Return the change of the density by a factor, from the scene and H; `other` is the new H."""

    def change(scene: Any) -> Any:
        scale = getattr(getattr(scene, "air", None), "density_scale_height", None)
        if scale is None:
            return scene
        new = with_density(scene, float(density(scene, DOUBLES)) * factor(scene, scale))
        return new if other == 0.0 else with_values(new, {"air.density_scale_height": other})

    return Change(change)


def _thinning(density: Callable[[Any], Any]) -> Change:
    """Return the change of the density aloft to a function of z/H."""
    return _replaced(THINNING, replace(
        THINNING, density=lambda position, p: density(p.thinning * position[2])))  # fmt: skip


def _sound(formula: Callable[[float], float]) -> Change:
    """Return the change of the speed of sound to a formula of T in K."""

    def values(scene: Any) -> Mapping[str, Any]:
        found: dict[str, Any] = {}
        for name in ("air.drag_coefficient", "air.lift_coefficient"):
            table = at(scene, name)
            if getattr(table, "of", "") == "mach":
                share = formula(scene.air.density.temperature) / speed_of_sound(scene, DOUBLES)
                found[f"{name}.at"] = tuple(float(x * share) for x in table.at)
        return found

    return _scene(values)


def _launch_speed(scene: Any) -> float:
    return math.hypot(*scene.launch.velocity) if scene.kind == "flight" else scene.pitch.speed


def _at_launch(scene: Any) -> Mapping[str, Any]:
    """Return the coefficients with the values that they have at the launch's speed."""
    found: dict[str, Any] = {}
    speed, law = _launch_speed(scene), scene.air.drag_coefficient
    if isinstance(law, CrisisDrag):
        high, low = law.high_speed, law.low_speed
        value = high + (low - high) / (1 + math.exp((speed - law.speed) / law.width))
        found = {f"air.drag_coefficient.{key}_speed": value for key in ("high", "low")}
    for name in ("air.drag_coefficient", "air.lift_coefficient"):
        table = at(scene, name)
        if getattr(table, "of", "") in ("speed", "mach"):
            x = speed if table.of == "speed" else speed / float(speed_of_sound(scene, DOUBLES))
            value = float(np.interp(x, table.at, table.values))
            found[f"{name}.values"] = (value,) * len(table.values)
    return found


def _lift_times(share: Callable[[Flow, Any], Any]) -> Callable[[Any], Any]:
    """Return the change of a spinning ball's lift by a factor, from its flow and the parameters."""

    def changed(f: Any) -> Any:
        form = _form(f)
        if not isinstance(form, Lift):
            return f
        new = replace(form, factor=lambda m, p: form.factor(m, p) * share(m.lift, p))
        return replace(f, term=new) if isinstance(f, Piecewise) else new

    return changed


_TOTAL = "of_total"
_BY_SPIN = {"linear_lift", "rational_lift"}


def _by_whole_spin(f: Any) -> Any:
    """Return a lift whose size goes with the whole spin, where it goes with spin at all."""
    by_spin = not _BY_SPIN.isdisjoint(f.parameters)
    return _lift_times(lambda flow, p: 1.0 + (1.0 if by_spin else getattr(p, _TOTAL)) * (
        1.0 / _active(flow, p) - 1.0))(f)  # fmt: skip


def _of_total(scene: Any, frame: Any, numbers: Any) -> tuple[float | None]:
    """Return 1 if the scene's lift is one by the whole spin."""
    return (1.0 if scene.reading.spin_parameter == "total" else None,)


def _active(flow: Flow, p: Any) -> Any:
    """Return ω_T/ω of the spin at launch."""
    a, b = spin_ratio(flow, p, whole=False)
    return trace.ZERO if b is trace.ZERO else b * flow.speed / (a * p.spin)


def _batted_spin(spin: Callable[[Any], Any]) -> Change:
    """Return the change of a batted ball's spin to what is made of the scene."""

    def under(f: Any) -> Any:
        name = "branches" if isinstance(f, Piecewise) else "strengths"
        given = getattr(f, name)

        def changed(scene: Any, frame: Any, numbers: Any) -> Any:
            if frame.spin is not None and _is_batted(scene, frame):
                frame = replace(frame, spin=spin(scene))
            return given(scene, frame, numbers)

        return replace(f, **{name: changed})

    return _terms(under)


def _profile(rise: Callable[[Any, Any], Any]) -> Change:
    """Return the change of the wind's growth with the height to a function of z and parameters.

    Those are its `roughness` and its `wind_height`.
    """

    def height(scene: Any, frame: Any) -> tuple[Any, ...]:
        return (scene.air.wind.height,)

    def changed(f: Any) -> Any:
        if not (isinstance(f, Wind) and ROUGHNESS in f.parameters):
            return f
        more = _more(f, ("wind_height",), height)

        def velocity(position: Vector[Any], p: Any) -> Vector[Any]:
            own = trace.log(1.0 + p.wind_height / p.roughness) * rise(position[2], p)
            return scaled(own, (p.log_wind_s, p.log_wind_y, trace.ZERO))

        return Wind(more.parameters, more.strengths, velocity, f.lifts)

    return _terms(changed)


# m: a height at which two forms of the wind go over into each other is so wide.
_BLEND = 5e-3


def _larger(a: Any, b: Any) -> Any:
    """Return the larger of two, smoothly."""
    return (a + b + trace.sqrt((a - b) * (a - b) + _BLEND * _BLEND)) * 0.5


def _smaller(a: Any, b: Any) -> Any:
    return -_larger(-a, -b)


def _exchanged() -> Iterator[Mistake]:
    """Yield mistakes that exchange two numbers of one block."""
    blocks = {
        "air.lift_coefficient": ("numerator", "constant", "slope"),
        "air.drag_coefficient": (
            "high_speed", "low_speed", "speed", "width", "per_spin", "constant"),
        "air.wind": ("height", "roughness"),
        "earth": ("latitude", "azimuth"),
    }  # fmt: skip
    for block, keys in blocks.items():
        for a, b in itertools.combinations(keys, 2):
            names = f"{block}.{a}", f"{block}.{b}"

            def values(scene: Any, names: tuple[str, str] = names) -> Mapping[str, Any]:
                held = [at(scene, name) for name in names]
                return {} if None in held else dict(zip(names, held[::-1], strict=True))

            sentence = f"exchanges {a} and {b} of {block}"
            yield Mistake(f"{a}-{b}-exchanged", sentence, _SCENE, _scene(values))


_NEAR_EARTH = 6_371_000.0  # m, from its centre


def _turning(motion: Motion, p: Any) -> Vector[Any]:
    """Return the Coriolis and the centrifugal acceleration."""
    omega, (s, y, z) = (p.earth_s, p.earth_y, p.earth_z), motion.position
    away = cross(omega, cross(omega, (s, y, z + _NEAR_EARTH)))
    return plus(CORIOLIS.acceleration(motion, p), -1.0, away)  # type: ignore[return-value]


def _coriolis_part(which: Callable[[Vector[Any]], Vector[Any]]) -> Change:
    return _instead(CORIOLIS, lambda m, p: which(CORIOLIS.acceleration(m, p)))


def _over_ground(term: Drag) -> Force:
    """Return a drag along the velocity over the ground, by the airspeed."""

    def acceleration(motion: Motion, p: Any) -> Vector[Any]:
        rate = motion.density * term.rate(motion, p)
        x, y, z = motion.velocity
        return -rate * x, -rate * y, -rate * z

    return Force(term.parameters, term.strengths, acceleration)


def _tables(change: Callable[..., Any], of: str = "") -> Change:
    """Return the change of nodes and values of a scene's tables, or of those over one thing."""

    def values(scene: Any) -> Mapping[str, Any]:
        found: dict[str, Any] = {}
        for name in ("air.drag_coefficient", "air.lift_coefficient"):
            table = at(scene, name)
            if isinstance(table, Table) and of in ("", table.of):
                nodes, there = change(table.at, table.values)
                found |= {f"{name}.at": tuple(nodes), f"{name}.values": tuple(there)}
        return found

    return _scene(values)


# Relative: half the width of the line that stands for a jump in a table; it is left out again.
_NARROW = 1e-15


def _jumping(f: Any) -> Any:
    """Return the term of a table of steps, without the lines between them."""
    if not (isinstance(f, Piecewise) and "table" in f.parameters[0]):
        return f

    def branches(scene: Any, frame: Any, numbers: Any) -> Branches | None:
        found = f.branches(scene, frame, numbers)
        held = scene.air and at(scene, f"air.{f.parameters[0].partition('_')[0]}_coefficient")
        if found is None or not isinstance(held, Table):
            return found
        return Branches(found.levels[::2], found.strengths[::2])

    return replace(f, branches=branches)


def _stepped(jumps: Callable[[Sequence[float]], Sequence[float]]) -> Change:
    """Return the change of tables to steps that jump at some places, from the nodes."""

    def steps(nodes: Sequence[float], values: Sequence[float]) -> tuple[Any, Any]:
        pairs = [one for one in zip(jumps(nodes), pairwise(values), strict=True) if one[0]]
        at = [x for jump, _ in pairs for x in (jump * (1 - _NARROW), jump * (1 + _NARROW))]
        return at, [value for _, pair in pairs for value in pair]

    return _tables(steps).then(_terms(_jumping))


def _extrapolated(
    nodes: Sequence[float], values: Sequence[float]
) -> tuple[list[float], list[float]]:
    """Return a table that goes on outside, from 0 to far beyond its last node."""

    def line(x: float, i: int, k: int) -> float:
        slope = (values[k] - values[i]) / (nodes[k] - nodes[i])
        return values[i] + slope * (x - nodes[i])

    far = 100 * nodes[-1]
    below = [] if nodes[0] == 0.0 else [0.0]
    ends = [line(0.0, 0, 1)] * len(below), [line(far, -2, -1)]
    return [*below, *nodes, far], [*ends[0], *values, *ends[1]]


def _coriolis(factor: float) -> Change:
    return _instead(CORIOLIS, lambda m, p: scaled(factor, CORIOLIS.acceleration(m, p)))


def _earth(key: str, change: Callable[[float], float]) -> Change:
    """Return the change of an angle of the Earth's rotation."""
    return _scene(lambda scene: {f"earth.{key}": change(getattr(scene.earth, key))})


_EARTH = "add -2 Ω × v, Ω = 7.292115e-5 rad/s (cos λ north + sin λ up)"
_LINEAR = "a table is linear between its nodes, and constant outside"


def _ground_speed(term: Drag) -> Drag:
    """Return a drag by the speed over the ground."""
    return replace(term, rate=lambda motion, p: term.rate(
        motion._replace(air=Flow(motion.air.velocity, size(motion.velocity))), p))  # fmt: skip


_DIRECTION = "take the direction of spin from the scene's vector, whichever way the ball flies"
_PROFILE = "the wind is W_h ln((z + z_0)/z_0)/ln((h + z_0)/z_0)"
_ALOFT = "the density is that at z = 0 times e^(-z/density_scale_height)"
_SOUND = "the speed of sound is 331.3 √(T/273.15)"
_UNIT = "spin is in rad/s"
_WEATHER = (
    "ρ = 1.2929 (273.15/T)(p e^(-βh) - 0.3783 φ p_s)/101325, T in K, φ from 0 to 1, "
    "p_s of T - 273.15 in °C"
)
_WIND = "the wind is subtracted from the ball's velocity, in drag and lift alike: u = v - W"

EXTENDED: tuple[Mistake, ...] = (
    Mistake("spin-in-rpm", "takes the spin for rpm", _UNIT,
            _spins(_times(math.pi / 30))),
    Mistake("spin-to-rpm", "turns the spin into rpm", _UNIT,
            _spins(_times(30 / math.pi))),
    Mistake("spin-in-revolutions", "takes the spin for revolutions per second", _UNIT,
            _spins(_times(2 * math.pi))),
    Mistake("spin-sign", "takes the spin with the other sign", _DIRECTION,
            _spins(_times(-1.0))),
    Mistake("spin-sign-of-pitches", "takes the spin of a ball that flies to the plate with the "
            "other sign", _DIRECTION, _spins(_times(-1.0), "pitch", "incoming")),
    Mistake("spin-sign-of-flights", "takes the spin of a ball that flies away from the plate with "
            "the other sign", _DIRECTION, _spins(_times(-1.0), "launch")),
    Mistake("spin-in-degrees", "takes the spin for degrees per second", _UNIT,
            _spins(_times(math.pi / 180))),
    Mistake("spin-side-sign", "has the spin's y the other way round", _DIRECTION,
            _spins(lambda scene, spin: (spin[0], -spin[1], spin[2]))),
    Mistake("spin-y-only", "takes the spin's y only", _DIRECTION,
            _spins(lambda scene, spin: (0.0, spin[1], 0.0))),
    *(Mistake(f"spin-{axis}-left-out", f"leaves the spin's {axis} out", _DIRECTION, _spins(
        lambda scene, spin, i=i: (*spin[:i], 0.0, *spin[i + 1 :])))  # type: ignore[misc]
      for i, axis in enumerate("xyz")),
    *(Mistake(f"spin-{axis}-sign", f"has the spin's {axis} the other way round", _DIRECTION, _spins(
        lambda scene, spin, i=i: (*spin[:i], -spin[i], *spin[i + 1 :])))  # type: ignore[misc]
      for i, axis in ((0, "x"), (2, "z"))),
    *(Mistake(f"spin-{'xyz'[i]}{'xyz'[j]}-exchanged", f"exchanges the spin's {'xyz'[i]} and "
              f"{'xyz'[j]}", _DIRECTION, _spins(
                  lambda scene, spin, i=i, j=j: _exchange(spin, i, j)))  # type: ignore[misc]
      for i, j in ((0, 1), (0, 2), (1, 2))),
    Mistake("spin-of-pitch-kept", "lets the batted ball fly with the spin of the pitch",
            "the batted ball has the spin that the impact gives it",
            _batted_spin(lambda scene: scene.pitch.spin)),
    Mistake("batted-spin-forgotten", "lets the batted ball fly by the lift of a ball of which no "
            "spin is given", "the batted ball has the spin that the impact gives it",
            _batted_spin(lambda scene: None)),
    Mistake("batted-without-spin", "lets the batted ball fly without spin",
            "the batted ball has the spin that the impact gives it",
            _batted_spin(lambda scene: (0.0, 0.0, 0.0))),
    Mistake("lift-of-whole-spin-across", "takes the C_L of the whole spin, gyro spin included, "
            "along ω × u", "S = R ω_T/U with ω_T = |ω × u|/U",
            _reading(spin_parameter="total").then(
                _terms(_lift_times(lambda flow, p: 1.0 / _active(flow, p))))),
    Mistake("lift-by-whole-spin", "multiplies by the whole spin, gyro spin included, in the "
            "lift's size", "S = R ω_T/U with ω_T = |ω × u|/U",
            _carrying(_by_whole_spin, Term((_TOTAL,), _of_total))),
    Mistake("lift-not-along-unit", "divides ω × u by ωU, and not by its length, in the "
            "direction of the lift", "the lift is along ω × u/|ω × u|",
            _terms(_lift_times(_active))),
    Mistake("spin-all-back", "takes the size of the spin for backspin", _DIRECTION,
            _spins(_backspin)),
    Mistake("spin-total", "takes the whole spin, gyro spin included, where the part across the "
            "velocity belongs", "S = R ω_T/U with ω_T = |ω × u|/U",
            _reading(spin_parameter="total", drag_spin="total")),
    Mistake("spin-parameter-total", "takes the whole spin for the spin parameter of the lift",
            "S = R ω_T/U with ω_T = |ω × u|/U", _reading(spin_parameter="total")),
    Mistake("drag-spin-total", "takes the whole spin for that which adds to the drag",
            "ω_T = |ω × u|/U", _reading(drag_spin="total")),
    Mistake("spin-parameter-of-diameter", "takes the diameter for the radius in the spin parameter",
            "S = R ω_T/U", _seeing(_lifts, lambda s: with_values(
                s, {"ball.radius": 2 * s.ball.radius, "ball.mass": 4 * s.ball.mass}))),
    Mistake("spin-decay-in-time", "lets the spin decay with time",
            "spin falls by e along spin_decay_length of path through the air",
            _reading(spin_decay="time")),
    Mistake("spin-decay-at-speed", "takes e^(-t U/L) with the present speed U",
            "spin falls by e along spin_decay_length of path through the air",
            _reading(spin_decay="nathan")),
    Mistake("ignores-decay-reading", "ignores the reading spin_decay",
            "take reading.spin_decay from the scene", _reading(spin_decay="path")),
    Mistake("spin-decay-squared", "lets the spin fall as e^(-2s/L) of the path s",
            "spin falls by e along spin_decay_length of path through the air",
            _reading(spin_decay="path").then(_scene(
                lambda scene: {"air.spin_decay_length": scene.air.spin_decay_length / 2}))),
    Mistake("no-spin-decay", "lets the spin stay as it is at the launch",
            "spin falls by e along spin_decay_length of path through the air",
            _scene(lambda scene: {"air.spin_decay_length": None})),
    Mistake("wind-sign", "takes the wind for where it blows from", "wind is where it blows to",
            _winds(lambda w: tuple(-x for x in w))),
    Mistake("wind-side-sign", "has the wind's y the other way round", "+y is left of the catcher",
            _winds(lambda w: (w[0], -w[1], w[2]))),
    Mistake("wind-exchanged", "exchanges x and y of the wind", "wind is [x, y, z], +x outwards",
            _winds(lambda w: (w[1], w[0], w[2]))),
    Mistake("wind-ignored", "flies without the wind", _WIND,
            _scene(lambda scene: {"air.wind": None})),
    Mistake("wind-level", "leaves the wind's vertical part out", _WIND,
            _winds(lambda w: (w[0], w[1], 0.0))),
    Mistake("wind-not-in-lift", "leaves the wind out of the lift", _WIND,
            _reading(wind_acts_on="drag")),
    Mistake("wind-in-size-only", "drags by the airspeed, but along the velocity over the ground",
            _WIND, _terms(lambda f: _over_ground(f) if isinstance(f, Drag) else f)),
    Mistake("wind-in-direction-only", "drags along the velocity through the air, but by the speed "
            "over the ground", _WIND,
            _terms(lambda f: _ground_speed(f) if isinstance(f, Drag) else f)),
    Mistake("wind-everywhere", "has the same wind at all heights",
            "a wind with `above` blows above that height, one with `height` grows with ln z",
            _scene(lambda scene: {"air.wind": scene.air.wind.velocity})),
    Mistake("wind-profile-without-offset", "lets the wind grow as ln(z/z_0)/ln(h/z_0)",
            _PROFILE, _profile(lambda z, p: trace.log(_larger(z, p.roughness) / p.roughness)
                               / trace.log(p.wind_height / p.roughness)), True),
    Mistake("wind-profile-capped", "has the same wind at all heights above that of the profile",
            _PROFILE, _profile(lambda z, p: trace.log(1.0 + _smaller(z, p.wind_height)
                                                      / p.roughness)
                               / trace.log(1.0 + p.wind_height / p.roughness)), True),
    Mistake("wind-profile-denominator", "divides by ln(h/z_0) in the wind's profile", _PROFILE,
            _profile(lambda z, p: trace.log(1.0 + z / p.roughness)
                     / trace.log(p.wind_height / p.roughness))),
    Mistake("wind-profile-power", "lets the wind grow as (z/h)^(1/7)", _PROFILE,
            _profile(lambda z, p: trace.exp(
                trace.log(_larger(z, trace.ZERO) / p.wind_height) / 7.0)), True),
    Mistake("celsius-for-kelvin", "takes the temperature for °C: adds 273.15 once more", _WEATHER,
            _density(lambda s, w: _of_weather(s, temperature=w.temperature + ZERO_CELSIUS))),
    Mistake("celsius-in-gas-law", "divides by the temperature in °C", _WEATHER,
            _density(_dry_of_celsius)),
    Mistake("kelvin-in-vapour", "takes the vapour pressure at the temperature in K", _WEATHER,
            _density(_vapour_of_kelvin)),
    Mistake("humidity-per-cent", "takes the humidity for per cent", _WEATHER,
            _density(lambda s, w: _of_weather(s, humidity=w.humidity / 100))),
    Mistake("humidity-to-per-cent", "turns the humidity into per cent", _WEATHER,
            _density(lambda s, w: _of_weather(s, humidity=w.humidity * 100))),
    Mistake("dry-air", "leaves the humidity out", _WEATHER,
            _density(lambda s, w: _of_weather(s, humidity=0.0))),
    Mistake("elevation-ignored", "takes the pressure for that of the park",
            "pressure is that at sea level, unless the reading `pressure` says station",
            _density(lambda s, w: _of_weather(s, elevation=0.0))),
    Mistake("elevation-at-station", "lowers a station's pressure by the elevation",
            "with the reading pressure = station the elevation does nothing",
            _reading(pressure="sea_level")),
    Mistake("weather-ignored", "has air of 1.2929 kg/m³, whatever the weather", _WEATHER,
            _density(lambda s, w: 1.2929)),
    *_vapours(),
    Mistake("barometric-formula", "takes the barometric formula of the standard atmosphere, "
            "p (1 - 2.25577e-5 h)^5.25588, for the park's pressure", _WEATHER,
            _with_pressure(lambda w: w.pressure * (1 - 2.25577e-5 * w.elevation) ** 5.25588)),
    Mistake("ideal-gas", "takes an ideal gas with 287.058 J/(kg K), and 461.495 for the vapour",
            _WEATHER, _density(_gas)),
    *(Mistake(f"density-falls-from-{name}", f"counts the height in e^(-z/H) {sentence}", _ALOFT,
              _denser(lambda scene, scale, level=level: math.exp(level(scene) / scale)))  # type: ignore[misc]
      for name, sentence, level in _LEVELS),
    Mistake("density-of-launch-height", "has the density of the launch's height at all heights",
            _ALOFT, _denser(lambda scene, scale: math.exp(-_LEVELS[0][2](scene) / scale), None)),
    Mistake("density-falls-linearly", "lets the density fall as 1 - z/H", _ALOFT,
            _thinning(lambda x: 1.0 - x)),
    Mistake("sound-linear", "takes 331.3 + 0.606 t for the speed of sound", _SOUND,
            _sound(lambda t: 331.3 + 0.606 * (t - ZERO_CELSIUS))),
    Mistake("sound-of-gas", "takes √(1.4 · 287 T) for the speed of sound", _SOUND,
            _sound(lambda t: math.sqrt(1.4 * 287.0 * t))),
    *(Mistake(f"sound-{speed:g}", f"has a speed of sound of {speed:g} m/s, whatever the weather",
              _SOUND, _sound(lambda t, speed=speed: speed)) for speed in (340.0, 343.0, 340.29)),  # type: ignore[misc]
    Mistake("coefficients-at-launch", "takes drag and lift coefficients of the speed at launch all "
            "the time", "C_D and C_L follow the present speed through the air", _scene(_at_launch)),
    Mistake("density-the-same-aloft", "has the same density at all heights",
            "the density falls by e in density_scale_height",
            _scene(lambda scene: {"air.density_scale_height": None})),
    Mistake("no-earth", "leaves the Earth's rotation out", "add -2 Ω × v",
            _scene(lambda scene: {"earth": None})),
    Mistake("earth-sign", "turns the Earth the other way round", _EARTH, _coriolis(-1.0)),
    Mistake("earth-once", "takes Ω × v where 2 Ω × v belongs", _EARTH, _coriolis(0.5)),
    Mistake("earth-by-airspeed", "takes the velocity through the air in -2 Ω × v", _EARTH,
            _instead(CORIOLIS, lambda m, p: CORIOLIS.acceleration(
                m._replace(velocity=m.air.velocity), p))),
    Mistake("centrifugal", "adds the centrifugal acceleration, which gravity holds already",
            "the scene's gravity is that at the place: add -2 Ω × v alone",
            _instead(CORIOLIS, _turning)),
    Mistake("earth-vertical-only", "takes the vertical part of -2 Ω × v alone", _EARTH,
            _coriolis_part(lambda a: (trace.ZERO, trace.ZERO, a[2]))),
    Mistake("earth-level-only", "leaves the vertical part of -2 Ω × v out", _EARTH,
            _coriolis_part(lambda a: (a[0], a[1], trace.ZERO))),
    Mistake("colatitude", "counts the latitude from the pole", _EARTH,
            _earth("latitude", lambda angle: math.pi / 2 - angle)),
    Mistake("azimuth-from-east", "counts the azimuth from the east", _EARTH,
            _earth("azimuth", lambda angle: math.pi / 2 - angle)),
    Mistake("latitude-sign", "takes southern latitudes for northern ones", _EARTH,
            _earth("latitude", abs)),
    Mistake("latitude-in-degrees", "takes the latitude for degrees", "earth.latitude is in radians",
            _earth("latitude", math.radians)),
    Mistake("azimuth-in-degrees", "takes the azimuth for degrees", "earth.azimuth is in radians",
            _earth("azimuth", math.radians)),
    Mistake("azimuth-sign", "counts the azimuth the other way round",
            "earth.azimuth is that of +x, clockwise from north", _earth("azimuth", operator.neg)),
    Mistake("azimuth-ignored", "takes +x for north", "earth.azimuth is that of +x",
            _earth("azimuth", lambda angle: 0.0)),
    Mistake("table-in-steps", "takes a table's value at the node below", _LINEAR,
            _stepped(lambda nodes: nodes[1:]), True),
    Mistake("table-of-next", "takes a table's value at the node above", _LINEAR,
            _stepped(lambda nodes: nodes[:-1]), True),
    Mistake("table-of-nearest", "takes a table's value at the nearest node", _LINEAR,
            _stepped(lambda nodes: [(a + b) / 2 for a, b in pairwise(nodes)]), True),
    Mistake("table-extrapolated", "goes on along the first and last line outside a table", _LINEAR,
            _tables(lambda at, values: _extrapolated(at, values))),
    *(Mistake(f"table-in-{unit}", f"takes a table of the airspeed for one in {unit}",
              "the nodes of a table of the airspeed are in m/s", _tables(
                  lambda at, values, f=factor: ([x * f for x in at], values), "speed"))
      for unit, factor in (("km/h", 1 / 3.6), ("mph", 0.44704), ("ft/s", 0.3048))),
    Mistake("crisis-without-width", "leaves the width out of the drag crisis: e^(U - U_c)",
            "C_D = a + (b - a)/(1 + e^((U - U_c)/δ))",
            _scene(lambda scene: {"air.drag_coefficient.width": 1.0})),
    *_exchanged(),
)  # fmt: skip

# The most decimals that a scene's numbers may be rounded to, where that shows.
_MOST_DECIMALS = 6


def _rounded(place: str, decimals: int) -> Mistake:
    """Return that some numbers of the scene are rounded."""

    def values(scene: Any) -> Mapping[str, Any]:
        return {place: tuple(round(x, decimals) for x in at(scene, place))}

    said = f"rounds {place} to {decimals} decimal{'s' * (decimals != 1)}"
    return Mistake(f"rounded:{place}:{decimals}", said, "take the numbers of the scene as they are",
                   _scene(values))  # fmt: skip


ROUNDED = tuple(
    _rounded(place, decimals)
    for place in ("launch.velocity", "launch.position")
    for decimals in range(_MOST_DECIMALS + 1)
)

LAW = (*_PAPERS_LAW, *EXTENDED, *ROUNDED)


# --- numbers of the law ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Own:
    """A number that the law has, and no scene: the 2 of V².

    Attributes
    ----------
    words
        What it is.
    usual
        What it is in longball.
    change
        The chain with the number that a scene carries under the name, along with its own.
    """

    words: str
    usual: float
    change: Change


def _always(name: str, usual: float) -> Term:
    """Return the term that carries a number."""
    return Term((name,), lambda scene, frame, numbers: (getattr(scene, name, usual),))


def _carried(term: Term) -> Callable[[Any], Any]:
    """Return the function from parameters to the one that a term carries; 0 on no branch yet."""
    (name,) = term.parameters
    return lambda p: getattr(p, name, trace.ZERO)


def _of_drag(carried: Term, factor: Callable[[Motion, Any], Any]) -> Change:
    """Return the change of all drag by a factor: of the motion and the number carried."""
    number = _carried(carried)

    def changed(f: Any) -> Any:
        form = _form(f)
        if not isinstance(form, Drag):
            return f
        new = replace(form, rate=lambda m, p: form.rate(m, p) * factor(m, number(p)))
        return replace(f, term=new) if isinstance(f, Piecewise) else new

    return _carrying(changed, carried)


def _of_lift(carried: Term, factor: Callable[[Motion, Any], Any]) -> Change:
    """Return the same change of all lift."""
    number = _carried(carried)

    def changed(f: Any) -> Any:
        form = _form(f)
        if isinstance(form, Lift):
            new: Term = replace(form, factor=lambda m, p: form.factor(m, p) * factor(m, number(p)))
        elif isinstance(form, Force) and _lifts(form):
            new = replace(form, acceleration=lambda m, p: scaled(
                factor(m, number(p)), form.acceleration(m, p)))  # fmt: skip
        else:
            return f
        return replace(f, term=new) if isinstance(f, Piecewise) else new

    return _carrying(changed, carried)


def _to_power(flow: Flow, more: Any) -> Any:
    """Return the speed to a power."""
    return trace.exp(more * trace.log(flow.speed * flow.speed + SMALL * SMALL) * 0.5)


def _moving(name: str, rises: bool) -> Term:
    """Return the term that carries a number while the ball rises, or falls, and 1 otherwise."""

    def branches(scene: Any, frame: Any, numbers: Any) -> Branches:
        number = (getattr(scene, name, 1.0),)
        return Branches((0.0,), ((1.0,), number) if rises else (number, (1.0,)))

    return Piecewise(
        (name,), switched, Term((name,), switched), branches,
        lambda motion, p: (motion.velocity[2], 1.0), "the ball is at its highest point",
    )  # fmt: skip


def _faster_sound(scene: Any) -> Any:
    """Return a scene with the nodes of its tables of the Mach number as the speed of sound."""
    share = getattr(scene, "sound", 1.0)
    return _tables(lambda nodes, values: ([x * share for x in nodes], values), "mach").scene(scene)


def _share(motion: Motion, number: Any) -> Any:
    return number


OWN: dict[str, Own] = {
    "drag_exponent": Own("the exponent of V in the drag", 2.0, _of_drag(
        _always("drag_exponent", 2.0), lambda m, n: _to_power(m.air, n - 2.0))),
    "lift_exponent": Own("the exponent of V in the lift", 2.0, _of_lift(
        _always("lift_exponent", 2.0), lambda m, n: _to_power(m.lift, n - 2.0))),
    **{
        f"{way}_{how}": Own(f"the share of the {way} on a {how} ball", 1.0, of(
            _moving(f"{way}_{how}", how == "rising"), _share))
        for way, of in (("drag", _of_drag), ("lift", _of_lift)) for how in ("rising", "falling")
    },
    "rotation": Own("the Earth's rotation in rad/s", ROTATION, _carrying(
        lambda f: replace(CORIOLIS, acceleration=lambda m, p: scaled(
            p.rotation / ROTATION, CORIOLIS.acceleration(m, p))) if f is CORIOLIS else f,
        _always("rotation", ROTATION))),
    "sound": Own("the share of the speed of sound", 1.0, Change(_faster_sound)),
}  # fmt: skip
SPIN = tuple(mistake for mistake in EXTENDED if mistake.name.startswith("spin-"))


# --- the fence ------------------------------------------------------------------------------------


def _fence(change: Callable[[Any], Any]) -> Change:
    """Return the change of the vertices of a fence."""
    return _scene(lambda scene: {"fence.polyline": tuple(change(scene.fence.polyline))})


_PARTS = 64  # of a chord that is bent


def _by_angle(vertices: Sequence[Numbers]) -> Iterator[Numbers]:
    polar = [(math.hypot(x, y), math.atan2(y, x), height) for x, y, height in vertices]
    for a, b in pairwise(polar):
        for i in range(_PARTS):
            r, angle, height = (p + (q - p) * i / _PARTS for p, q in zip(a, b, strict=True))
            yield r * math.cos(angle), r * math.sin(angle), height
    yield vertices[-1]


FENCE: tuple[Mistake, ...] = (
    Mistake("fence-by-angle", "bends the fence: its distance is linear in the angle",
            "vertices are joined by straight chords", _fence(_by_angle)),
    Mistake("fence-without-height", "takes the fence for a line on the ground",
            "the third number of a vertex is the fence's height there",
            _fence(lambda v: ((x, y, 0.0) for x, y, _ in v))),
    Mistake("fence-height-of-first", "has a chord as high as its first vertex",
            "the height is linear along a chord",
            _fence(lambda v: [w for a, b in pairwise(v) for w in (a, (b[0], b[1], a[2]))])),
    Mistake("fence-height-of-last", "has a chord as high as its last vertex",
            "the height is linear along a chord",
            _fence(lambda v: [w for a, b in pairwise(v) for w in ((a[0], a[1], b[2]), b)])),
    Mistake("fence-cleared-by-surface", "asks the ball's whole surface to clear the fence",
            "the centre does, unless the reading fence_clearance says surface",
            _reading(fence_clearance="surface")),
    Mistake("fence-cleared-by-centre", "asks the ball's centre alone to clear the fence",
            "take reading.fence_clearance from the scene", _reading(fence_clearance="centre")),
)  # fmt: skip


# --- the collision --------------------------------------------------------------------------------


@dataclass(frozen=True)
class View:
    """A scene, and the values that a formula has before it, by the names of the quantities."""

    scene: Any
    values: Mapping[str, Numbers]
    before: Numbers
    height: float

    def __getitem__(self, name: str) -> Numbers:
        return self.values[name]

    def number(self, name: str) -> float:
        """Return a quantity that is one number."""
        return self.values[name][0]

    @property
    def m(self) -> float:
        """The ball's mass, kg."""
        return float(self.scene.ball.mass)

    @property
    def M(self) -> float:  # noqa: N802 (the paper's symbol)
        """The bat's mass, kg."""
        return float(self.scene.bat.mass)

    @property
    def e(self) -> float:
        """The ball's restitution."""
        return float(self.scene.ball.restitution)

    @property
    def position(self) -> Numbers:
        """Of the ball at the contact, m."""
        held = self.values.get("contact.position")
        return held if held is not None else tuple(self.scene.incoming.position)

    @property
    def axis(self) -> Numbers:
        """From the bat's axis to the ball, m."""
        x, _, z = self.position
        return x, 0.0, z - self.height

    @property
    def start(self) -> Numbers:
        """Where the batted ball's flight begins, m."""
        launch = getattr(self.scene, "launch", None)
        return self.position if launch is None else tuple(launch.position)

    @property
    def lever(self) -> float:
        """r̃, m."""
        return float(self.scene.bat.length) / 2 - self.position[1]

    def collision(self, **switches: str) -> CollisionParameters[float]:
        """Return ẽ and μ, with some switches of the reading set otherwise."""
        scene = self.scene
        reading = Reading.model_validate(scene.reading.model_dump() | switches)
        return collision_parameters(scene.ball, scene.bat, self.lever, reading, DOUBLES)

    @property
    def mu(self) -> float:
        """μ, kg."""
        return self.collision().reduced_mass

    @property
    def bare(self) -> float:
        """μ from M_eff, kg."""
        return self.collision(bat_ball_restitution="nathan", reduced_mass="bat_mass").reduced_mass

    @property
    def ratio(self) -> float:
        """m/M_eff."""
        return self.m / self.bare - 1

    @property
    def inertia(self) -> float:
        """The bat's, kg m²."""
        return float(moment_of_inertia(self.scene.bat, self.scene.reading, DOUBLES))

    @property
    def relative(self) -> Numbers:
        """Ṽ, m/s."""
        return plus(self.before, -1.0, self["contact.bat_velocity"])

    @property
    def restitution(self) -> float:
        """ẽ."""
        return self.number("impact.restitution")

    @property
    def kick(self) -> Numbers:
        """J n, N s."""
        return tuple(self.number("impact.impulse") * n for n in self["contact.normal"])


Number = Callable[[View], float]
Value = Callable[[View], Numbers]


@dataclass(frozen=True)
class Formula:
    """A known mistake in one formula.

    Attributes
    ----------
    quantity
        What it computes.
    name, sentence, remedy
        See `Mistake`.
    value
        What it then is.
    """

    quantity: str
    name: str
    sentence: str
    remedy: str
    value: Value


@dataclass(frozen=True)
class Numbered:
    """A known mistake in one formula with a number in it that may be any.

    Attributes
    ----------
    quantity, name, remedy
        See `Formula`.
    sentence
        With braces for the number.
    number
        What the number is, if the quantity is what a candidate says.
    value
        What the quantity is with a number.
    """

    quantity: str
    name: str
    sentence: str
    remedy: str
    number: Callable[[View, Numbers], float]
    value: Callable[[View, float], Numbers]

    def of(self, number: float) -> Formula:
        """Return the mistake with a number."""
        return Formula(
            self.quantity, f"{self.name}={number:.6g}", self.sentence.format(f"{number:.9g}"),
            self.remedy, lambda view: self.value(view, number),
        )  # fmt: skip


def _wrong(quantity: str, remedy: str, *known: tuple[Any, ...]) -> Iterator[Formula]:
    """Yield mistakes in a formula: names, sentences and values, and remedies if they differ."""
    for name, sentence, value, *other in known:
        yield Formula(quantity, name, sentence, other[0] if other else remedy, value)


def _cos_sin(angle: float) -> tuple[float, float]:
    return math.cos(angle), math.sin(angle)


def _swung(
    lever: Number = lambda v: v.lever, tilt: Callable[[float], tuple[float, ...]] = _cos_sin
) -> Value:
    """Return ω times a lever, m, along what is made of the tilt: x and z."""

    def value(v: View) -> Numbers:
        speed = v.scene.swing.angular_speed * lever(v)
        x, z = tilt(v.scene.swing.tilt)
        return speed * x, 0.0, speed * z

    return value


def _restitution(formula: Callable[[View, float, float], float]) -> Value:
    """Return ẽ by a formula of e and m/M_eff, where it is not e itself."""

    def value(v: View) -> Numbers:
        printed = v.scene.reading.bat_ball_restitution == "as_printed"
        return (formula(v, v.e, v.ratio) if printed else v.e,)

    return value


def _printed(e: float, ratio: float) -> float:
    return e * (1 + ratio) + ratio


def _read(**switches: str) -> Value:
    """Return ẽ with some switches of the reading set otherwise."""
    return lambda v: (v.collision(**switches).restitution,)


def _closing(velocity: Value) -> Value:
    """Return the part of a velocity along the normal."""
    return lambda v: (dot(velocity(v), v["contact.normal"]),)


def _along(vector: Numbers, normal: Numbers) -> Numbers:
    part = dot(vector, normal)
    return tuple(part * n for n in normal)


def _push(mass: Number = lambda v: v.mu, e: Number = lambda v: v.restitution) -> Value:
    return lambda v: (-mass(v) * (1 + e(v)) * v.number("contact.normal_speed"),)


def _after(factor: Number, keep: float = 1.0) -> Value:
    return lambda v: tuple(keep * b + factor(v) * k for b, k in zip(v.before, v.kick, strict=True))


def _whole_impulse(v: View) -> Numbers:
    """Return m|V' - V| of a bat with friction; nothing of others, where it says nothing."""
    rough = v.scene.bat.friction is not None
    return (v.m * math.dist(v["impact.velocity"], v.before),) if rough else ()


def _energy(mass: Number = lambda v: v.mu, loss: Number = lambda v: 1 - v.restitution**2) -> Value:
    return lambda v: (-0.5 * mass(v) * loss(v) * v.number("contact.normal_speed") ** 2,)


def _less(quantity: str, what: Value) -> Value:
    """Return what follows for a quantity, less something."""
    return lambda v: plus(v[f"{quantity}:follows"], -1.0, what(v))


def _distance(formula: Callable[[float, float, float], float]) -> Value:
    return lambda v: (formula(*v["landing.position"]),)


_I = "I = M(L²/3 + r_b²/4) about the end B"
_PLAIN = "uses e where ẽ belongs"
_EFFECTIVE = "ẽ = e(1 + m/M_eff) + m/M_eff with M_eff = I/r̃²"
_N = "n points from the bat's axis to the ball: (x, 0, z - z_b)/d"
_PIVOT = "the pivot B is at y = +L/2: r̃ = L/2 - y"
_V_B = "V_b = ω r̃ (cos θ, 0, sin θ) with r̃ = L/2 - y"
_MU = "1/μ = 1/m + 1/M, with the bat's mass M"
_J = "J = -μ(1 + ẽ)(Ṽ·n) with 1/μ = 1/m + 1/M"
_V = "V' = V + (J/m) n"
_DE = "ΔE = -½ μ (1 - ẽ²)(Ṽ·n)²"
_SPUN = "ω' = ω - (R/I) n × P with I = inertia_factor m R²"
_D = "D is the horizontal distance from the origin to the landing"


def _unit(v: Numbers) -> Numbers:
    size = math.hypot(*v)
    return tuple(x / size for x in v)


def _turned_inertia(v: View, said: Numbers) -> float:
    """Return c of the moment of inertia M(L²/3 + c r_b²) that a candidate's ẽ is made with."""
    bat = v.scene.bat
    inertia = v.inertia * v.ratio * (1 + v.e) / (said[0] - v.e)
    return float((inertia / bat.mass - bat.length**2 / 3) / bat.radius**2)


def _with_inertia(v: View, c: float) -> Numbers:
    bat = v.scene.bat
    inertia = bat.mass * (bat.length**2 / 3 + c * bat.radius**2)
    return _restitution(lambda v, e, r: _printed(e, r * v.inertia / inertia))(v)


def _tilted(v: View, share: float) -> Numbers:
    x, _, z = v.axis
    return _unit((x, share * v.position[1], z))


def _off_centre(v: View, radii: float) -> Numbers:
    place, step = v["contact.position:follows"], radii * v.scene.ball.radius
    return plus(place, -step, v["contact.normal"])


# In the bat's parameters: names, sentences, remedies, and the switches of the reading that make
# them.
_MISREAD: dict[str, tuple[str, str, dict[str, str]]] = {
    "effective-mass": ("takes M_eff = I/r̃, as printed, which is no mass", "M_eff = I/r̃²",
                       {"effective_mass": "as_printed"}),
    "thin-rod": ("takes the bat for a thin rod", _I, {"inertia": "thin_rod"}),
    "inertia-about-centre": ("takes the bat's moment of inertia about its centre", _I,
                             {"inertia": "about_centre"}),
}  # fmt: skip


def _misread(*names: str) -> Iterator[Mistake]:
    for name in names:
        sentence, remedy, switches = _MISREAD[name]
        yield Mistake(name, sentence, remedy, _reading(**switches))


FORMULAS: tuple[Formula, ...] = (
    *_wrong("plate.velocity", "plate.velocity is where the ball crosses x = 0",
        ("velocity-of-release", "gives the release's velocity for that at the plate",
         lambda v: tuple(v.scene.pitch.thrown))),
    *_wrong("contact.margin", "the margin is reach less the least distance from the bat's axis",
        ("margin-at-plate", "takes the margin from the height above the bat's axis at the plate",
         lambda v: (v.scene.ball.radius + v.scene.bat.radius
                    - abs(v["plate.position"][2] - v.height),))),
    *_wrong("contact.normal", _N,
        ("normal-not-unit", "does not divide the normal by its length", lambda v: v.axis,
         "n is a unit vector"),
        ("normal-by-reach", "divides the normal by R + r_b, whatever its length is",
         lambda v: tuple(x / (v.scene.ball.radius + v.scene.bat.radius) for x in v.axis),
         "n is a unit vector"),
        ("normal-by-ball-radius", "divides the normal by R, not by its length",
         lambda v: tuple(x / v.scene.ball.radius for x in v.axis), "n is a unit vector"),
        ("normal-by-bat-radius", "divides the normal by r_b, not by its length",
         lambda v: tuple(x / v.scene.bat.radius for x in v.axis), "n is a unit vector"),
        ("normal-level", "has the normal along x, whatever the height of the ball above the bat",
         lambda v: (1.0, 0.0, 0.0)),
        ("offset-ignored", "takes the normal without swing.height_offset",
         lambda v: _unit((v.position[0], 0.0, v.position[2] - v["plate.position"][2])),
         "the bat's height is z'_b + σ_b"),
        ("normal-swapped", "exchanges x and z of the normal", lambda v: _unit(v.axis[::-1]))),
    *_wrong("contact.bat_velocity", _V_B,
        ("other-pivot", "lets the bat turn about its end A, at y = -L/2",
         _swung(lambda v: v.scene.bat.length / 2 + v.position[1]), _PIVOT),
        ("other-pivot-backwards", "turns the bat about its end A, and backwards",
         _swung(lambda v: -v.scene.bat.length / 2 - v.position[1]), _PIVOT),
        ("pivot-in-the-middle", "lets the bat turn about its middle",
         _swung(lambda v: -v.position[1])),
        ("lever-of-size", "takes |y| for y in the lever",
         _swung(lambda v: v.scene.bat.length / 2 - abs(v.position[1]))),
        ("tip-speed", "gives all of the bat the speed of its tip",
         _swung(lambda v: v.scene.bat.length)),
        ("middle-speed", "gives all of the bat the speed of its middle",
         _swung(lambda v: v.scene.bat.length / 2)),
        ("tilt-sign", "tilts the swing downwards", _swung(tilt=lambda t: _cos_sin(-t))),
        ("tilt-ignored", "swings level: the tilt is not used", _swung(tilt=lambda t: (1.0, 0.0))),
        ("tilt-swapped", "exchanges sine and cosine of the tilt",
         _swung(tilt=lambda t: _cos_sin(t)[::-1])),
        ("tilt-small-angle", "takes 1 for the cosine of the tilt, and the tilt for its sine",
         _swung(tilt=lambda t: (1.0, t))),
        ("tilt-cosine-left-out", "leaves the cosine of the tilt out",
         _swung(tilt=lambda t: (1.0, math.sin(t)))),
        ("tilt-in-degrees", "takes the tilt of the swing for degrees",
         _swung(tilt=lambda t: _cos_sin(math.radians(t))), "swing.tilt is in radians"),
        ("tilt-to-degrees", "turns the tilt into degrees before its sine",
         _swung(tilt=lambda t: _cos_sin(math.degrees(t))), "swing.tilt is in radians")),
    *_wrong("contact.normal_speed", "Ṽ = V - V_b",
        ("bat-at-rest", "takes the ball's own velocity, as if the bat were at rest",
         _closing(lambda v: v.before)),
        ("velocities-added", "adds the bat's velocity to the ball's",
         _closing(lambda v: plus(v.before, 1.0, v["contact.bat_velocity"]))),
        ("whole-speed", "takes the size of Ṽ, not its part along n",
         lambda v: (-math.hypot(*v.relative),), "Ṽ·n"),
        ("plate-velocity", "takes the ball's velocity at the plate",
         _closing(lambda v: plus(v["plate.velocity"], -1.0, v["contact.bat_velocity"])),
         "take it at the contact")),
    Formula("impact.restitution", "plain-restitution", _PLAIN, _EFFECTIVE, lambda v: (v.e,)),
    *(Formula("impact.restitution", name, sentence, remedy, _read(**switches))
      for name, (sentence, remedy, switches) in _MISREAD.items()),
    *_wrong("impact.restitution", _EFFECTIVE,
        ("bat-mass-ratio", "takes the bat's whole mass for M_eff",
         _restitution(lambda v, e, r: _printed(e, v.m / v.M))),
        ("other-pivot", "measures r̃ from the bat's end A, at y = -L/2", _restitution(
            lambda v, e, r: _printed(e, r * ((v.scene.bat.length - v.lever) / v.lever) ** 2)),
         _PIVOT),
        ("ratio-once", "leaves m/M_eff out behind e(1 + m/M_eff)",
         _restitution(lambda v, e, r: e * (1 + r))),
        ("ratio-inverted", "takes M_eff/m for m/M_eff",
         _restitution(lambda v, e, r: _printed(e, 1 / r))),
        ("ratio-subtracted", "subtracts m/M_eff", _restitution(lambda v, e, r: e * (1 + r) - r)),
        ("bat-speed-ratio", "gives the collision efficiency (e - m/M_eff)/(1 + m/M_eff)",
         _restitution(lambda v, e, r: (e - r) / (1 + r)))),
    *_wrong("impact.impulse", _J,
        ("reduced-mass", "takes μ from M_eff", _push(lambda v: v.bare), _MU),
        ("ball-mass-for-mu", "takes the ball's mass for μ", _push(lambda v: v.m)),
        ("bat-mass-for-mu", "takes the bat's mass for μ", _push(lambda v: v.M)),
        ("sum-of-masses", "takes m + M for μ", _push(lambda v: v.m + v.M)),
        ("mean-of-masses", "takes (m + M)/2 for μ", _push(lambda v: (v.m + v.M) / 2)),
        ("harmonic-mean", "takes 2mM/(m + M) for μ",
         _push(lambda v: 2 * v.m * v.M / (v.m + v.M))),
        ("impulse-of-ball-speed", "takes the ball's own velocity along n, as if the bat were at "
         "rest", lambda v: (-v.mu * (1 + v.restitution) * dot(v.before, v["contact.normal"]),)),
        ("plain-e-in-impulse", "uses 1 + e where 1 + ẽ belongs", _push(e=lambda v: v.e)),
        ("one-minus-e", "uses 1 - ẽ where 1 + ẽ belongs", _push(e=lambda v: -v.restitution)),
        ("whole-impulse", "gives the size of the whole impulse, the friction's part included",
         _whole_impulse, "impact.impulse is its part along n"),
        ("no-one-plus", "uses ẽ where 1 + ẽ belongs", _push(e=lambda v: v.restitution - 1)),
        ("inelastic", "leaves the restitution out: the impulse is -μ Ṽ·n", _push(e=lambda v: 0.0))),
    *_wrong("impact.velocity", _V,
        ("impulse-over-bat-mass", "divides the impulse by the bat's mass",
         _after(lambda v: 1 / v.M)),
        ("impulse-not-divided", "adds the impulse without dividing it by the ball's mass",
         _after(lambda v: 1.0)),
        ("impulse-sign", "subtracts the impulse", _after(lambda v: -1 / v.m)),
        ("impulse-alone", "forgets the velocity before the impact", _after(lambda v: 1 / v.m, 0.0)),
        ("impulse-over-reduced-mass", "divides the impulse by μ", _after(lambda v: 1 / v.mu)),
        ("relative-velocity", "starts from Ṽ instead of V",
         lambda v: plus(v.relative, 1 / v.m, v.kick)),
        ("velocity-along-normal", "keeps the velocity along the normal only",
         lambda v: _along(v["impact.velocity:follows"], v["contact.normal"])),
        ("velocity-reversed", "turns the whole velocity round, -ẽ times it",
         lambda v: tuple(-v.restitution * b for b in v.before)),
        ("impulse-along-relative-velocity", "lets the impulse act along the whole relative "
         "velocity, not along the normal",
         lambda v: plus(v.before, -v.mu / v.m * (1 + v.restitution), v.relative)),
        ("relative-velocity-reversed", "turns the whole relative velocity round, -ẽ times it",
         lambda v: plus(v["contact.bat_velocity"], -v.restitution, v.relative)),
        ("velocity-mirrored", "mirrors the velocity at the bat's surface, V - (1 + ẽ)(Ṽ·n) n",
         lambda v: plus(v.before, -(1 + v.restitution) * v.number("contact.normal_speed"),
                        v["contact.normal"])),
        ("bat-velocity-added", "adds the bat's velocity to the ball's",
         lambda v: plus(v["impact.velocity:follows"], 1.0, v["contact.bat_velocity"])),
        ("plate-velocity-after", "starts from the velocity at the plate",
         lambda v: plus(v["plate.velocity"], 1 / v.m, v.kick)),
        ("friction-left-out", "leaves the friction's part of the impulse out",
         _after(lambda v: 1 / v.m), "V' = V + P/m with the whole impulse P")),
    *_wrong("impact.energy_change", _DE,
        ("energy-with-e", "uses e where ẽ belongs", _energy(loss=lambda v: 1 - v.e**2)),
        ("energy-e-not-squared", "uses 1 - ẽ where 1 - ẽ² belongs",
         _energy(loss=lambda v: 1 - v.restitution)),
        ("energy-with-effective-mass", "takes μ from M_eff", _energy(lambda v: v.bare)),
        ("energy-of-ball", "counts the ball's energy only", lambda v: (0.5 * v.m * (
            sum(x * x for x in v["impact.velocity"]) - sum(x * x for x in v.before)),)),
        ("energy-with-ball-mass", "takes the ball's mass for μ", _energy(lambda v: v.m)),
        ("energy-without-friction", "counts what the normal impulse does, and not what friction "
         "does", _energy(), "ΔE = P·(g + K P/2), with the whole impulse P")),
    *_wrong("impact.spin", _SPUN,
        ("spin-kept", "keeps the spin that the ball came with", lambda v: v["contact.spin"]),
        ("spin-change-sign", "changes the spin the other way", lambda v: plus(
            v["contact.spin"], -1.0, plus(v["impact.spin:follows"], -1.0, v["contact.spin"]))),
        ("spin-after-of-release", "adds to the spin of the release, not to that at the contact",
         lambda v: plus(v["impact.spin:follows"], -1.0,
                        plus(v["contact.spin"], -1.0, v.scene.pitch.spin)),
         "spin falls by e along spin_decay_length, on the way to the bat too"),
        ("spin-before-forgotten", "forgets the spin that the ball came with",
         _less("impact.spin", lambda v: v["contact.spin"]))),
    *_wrong("landing.spin", "spin falls by e along spin_decay_length of path through the air",
        ("spin-of-launch", "gives the spin of the launch for that at landing",
         lambda v: tuple(v.scene.launch.spin))),
    *_wrong("landing.time", "landing.time = contact.time + landing.hang_time",
        ("time-since-contact", "counts landing.time from the contact",
         lambda v: v["landing.hang_time"],
         "landing.time is since the start of the scene; landing.hang_time since the contact"),
        ("time-since-plate", "counts the flight from the plate, not from the contact",
         lambda v: (v.number("plate.time") + v.number("landing.hang_time"),)),
        ("contact-counted-twice", "adds the contact's time twice",
         lambda v: (2 * v.number("contact.time") + v.number("landing.hang_time"),))),
    *_wrong("landing.hang_time", "landing.hang_time is since contact or launch",
        ("hang-time-since-start", "counts landing.hang_time from the start of the scene",
         lambda v: v["landing.time"])),
    *_wrong("landing.velocity", "landing.velocity is a vector",
        ("speed-for-vertical", "gives the speed for the vertical velocity",
         lambda v: (*(there := v["landing.velocity:follows"])[:2], -math.hypot(*there))),
        ("velocity-through-air", "gives the velocity through the air",
         _less("landing.velocity", lambda v: v.scene.air.wind),
         "landing.velocity is over the ground"),
        ("velocity-of-launch", "gives the velocity of the launch",
         lambda v: tuple(v.scene.launch.velocity), "landing.velocity is where the ball lands")),
    *_wrong("landing.distance", _D,
        ("distance-from-start", "measures the distance from the launch, or from where the ball was "
         "met, and not from the plate",
         lambda v: (math.dist(v["landing.position"][:2], v.start[:2]),)),
        ("distance-in-space", "measures the distance in space, height too", _distance(math.hypot)),
        ("distance-of-x-and-z", "takes z for y in the distance",
         _distance(lambda x, y, z: math.hypot(x, z))),
        ("distance-along-x", "takes x for the distance", _distance(lambda x, y, z: x)),
        ("distance-abs-x", "takes |x| for the distance", _distance(lambda x, y, z: abs(x))),
        ("distance-squared", "forgets the root of x² + y²",
         _distance(lambda x, y, z: x**2 + y**2)),
        ("distance-summed", "adds |x| and |y|", _distance(lambda x, y, z: abs(x) + abs(y)))),
)  # fmt: skip


NUMBERED: tuple[Numbered, ...] = (
    Numbered("contact.position", "contact-off-centre", "gives as the contact a point off the "
             "ball's centre, nearer to the bat by {} times the ball's radius",
             "contact.position is where the ball's centre is",
             lambda v, said: dot(plus(v["contact.position:follows"], -1.0, said),
                                  v["contact.normal"]) / v.scene.ball.radius, _off_centre),
    Numbered("contact.normal", "normal-along-bat", "gives the normal a part along the bat: "
             "(x, {} y, z - z_b) stands for (x, 0, z - z_b)",
             "n is perpendicular to the bat's axis: its y is 0",
             lambda v, said: said[1] * math.hypot(*v.axis)
             / (v.position[1] * math.hypot(said[0], said[2])), _tilted),
    Numbered("contact.bat_velocity", "pivot-elsewhere", "lets the bat turn about a point {} times "
             "its length from the middle", _PIVOT,
             lambda v, said: (math.copysign(math.hypot(*said), said[0])
                              / v.scene.swing.angular_speed + v.position[1]) / v.scene.bat.length,
             lambda v, share: _swung(lambda w: share * w.scene.bat.length - w.position[1])(v)),
    Numbered("impact.restitution", "bat-inertia", "acts as if the bat's moment of inertia were "
             "M(L²/3 + {} r_b²)", _I, _turned_inertia, _with_inertia),
)  # fmt: skip


# --- where ball and bat meet ----------------------------------------------------------------------


def _swung_at(height: Callable[[Any], float]) -> Change:
    """Return the change of the height of the bat's axis, m."""
    return _scene(lambda scene: {"swing.height_offset": height(scene) - _crossing(scene)})


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
_REACH = "ball and bat touch where the ball's centre is R + r_b from the bat's axis"

TOUCHING: tuple[Mistake, ...] = (
    Mistake("height-from-release", "puts the bat at swing.height_offset above the release",
            _HEIGHT, _swung_at(lambda s: s.pitch.release[2] + s.swing.height_offset)),
    Mistake("height-from-aim", "puts the bat at swing.height_offset above the height aimed at",
            _HEIGHT, _swung_at(lambda s: s.pitch.aim[1] + s.swing.height_offset)),
    Mistake("height-of-offset-alone", "puts the bat at swing.height_offset above z = 0",
            _HEIGHT, _swung_at(lambda s: s.swing.height_offset)),
    Mistake("offset-sign", "counts swing.height_offset downwards", _HEIGHT,
            _scene(lambda scene: {"swing.height_offset": -scene.swing.height_offset})),
    Mistake("offset-ignored", "puts the bat where the ball crosses the plate", _HEIGHT,
            _scene(lambda scene: {"swing.height_offset": 0.0})),
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

# Mistakes that the parts after them hide if their own quantity is not answered: changes of the
# whole chain, tried where a stage's inputs are longball's own.
READINGS: tuple[Mistake, ...] = (
    Mistake("plain-restitution", _PLAIN, _EFFECTIVE, _reading(bat_ball_restitution="plain")),
    Mistake("nathan", "uses Nathan's formula: e with the effective mass in μ",
            "the paper prints ẽ = e(1 + m/M_eff) + m/M_eff with μ from the bat's mass M",
            _reading(bat_ball_restitution="nathan")),
    *_misread("effective-mass"),
    Mistake("reduced-mass", "takes μ from M_eff", _MU, _reading(reduced_mass="effective_mass")),
    *_misread("thin-rod", "inertia-about-centre"),
    Mistake("landing-of-surface", "lets the ball land when its surface touches the ground, at "
            "z = R", "the ball lands when its centre reaches the ground, unless the reading "
            "ground_contact says otherwise", _reading(ground_contact="surface")),
    Mistake("ignores-reading", "ignores the scene's reading block",
            "take the switches of scene.reading, or leave those scenes out with --golden",
            Change(lambda scene: scene.model_copy(update={"reading": Reading()}))),
)  # fmt: skip

# Whoever takes no heed of one switch has its default: of those that scenes set otherwise.
IGNORED: tuple[Mistake, ...] = tuple(
    Mistake(f"ignores-{name}", f"ignores reading.{name}: acts as if it were {field.default}",
            f"take reading.{name} from the scene", _reading(**{name: field.default}))
    for name, field in Reading.model_fields.items()
)  # fmt: skip

# What shows in outcomes alone.
OUTCOMES: tuple[Mistake, ...] = (
    Mistake("time-limit-ignored", "flies on beyond time_limit",
            "a ball that has not come down after time_limit seconds of flight is airborne",
            _scene(lambda scene: {"time_limit": 1e4})),
    Mistake("ground-ignored", "has the ground at z = 0, whatever ground.height is",
            "the ball lands at ground.height", _scene(lambda scene: {"ground.height": 0.0})),
)  # fmt: skip


# --- friction -------------------------------------------------------------------------------------


def _rubbed_without_spin(cases: Any, contact: Any, error: Any, *carried: Any) -> tuple[Any, ...]:
    """Apply the oblique impulse as if the ball came without spin."""
    if contact.spin is None:
        return collide(cases, contact, error, *carried)
    cases, impact, *rest = collide(cases, replace(contact, spin=(0.0, 0.0, 0.0)), error, *carried)
    return cases, replace(impact, spin=plus(impact.spin, 1.0, contact.spin)), *rest


def _rubbed_without_rotation(
    cases: Any, contact: Any, error: Any, *carried: Any
) -> tuple[Any, ...]:
    """Apply the oblique impulse as if the bat's surface moved like its axis."""
    scene = with_values(cases.scene, {"swing.angular_speed": 0.0})
    still = OneCase(scene, cases.engine, cases.model)
    return cases, *collide(still, contact, error, *carried)[1:]


def _colliding(collision: Callable[..., tuple[Any, ...]]) -> Change:
    return Change(model=lambda model: replace(model, collide=collision))


def _struck_with_spin_of_release(
    cases: Any, contact: Any, error: Any, *carried: Any
) -> tuple[Any, ...]:
    """Apply the impulse to a ball that has the spin still with which it was thrown."""
    if cases.scene.kind != "at-bat" or contact.spin is None:
        return collide(cases, contact, error, *carried)
    return collide(cases, replace(contact, spin=cases.scene.pitch.spin), error, *carried)


def _levered(lever: Callable[[Any, float], float]) -> Change:
    """Return the change of r̃ in the bat's parameters, from the scene and the right one, m."""

    def struck(cases: Any, contact: Any, error: Any, *carried: Any) -> tuple[Any, ...]:
        arm = lever(cases.scene, contact.lever_arm)
        return collide(cases, replace(contact, lever_arm=arm), error, *carried)

    return _colliding(struck)


IMPACT: tuple[Mistake, ...] = (
    Mistake("other-pivot", "measures r̃ from the bat's end A, at y = -L/2", _PIVOT,
            _levered(lambda scene, arm: scene.bat.length - arm)),
    Mistake("middle-lever", "takes half the bat's length for r̃, whatever y is", _PIVOT,
            _levered(lambda scene, arm: scene.bat.length / 2)),
    Mistake("lever-of-size", "takes |y| for y in r̃", _PIVOT,
            _levered(lambda scene, arm: min(arm, scene.bat.length - arm))),
    Mistake("spin-of-release", "strikes the ball with the spin of the release",
            "spin falls by e along spin_decay_length, on the way to the bat too",
            _colliding(_struck_with_spin_of_release)),
    Mistake("friction-without-spin", "leaves the ball's spin out of the slip",
            "g = V + ω × (-R n) - V_b: the surface moves with the spin",
            _colliding(_rubbed_without_spin)),
    Mistake("friction-without-rotation", "leaves the bat's rotation out of the slip",
            "g = V + ω × (-R n) - V_b - Ω × (r_b n): the bat's surface turns about its axis",
            _colliding(_rubbed_without_rotation)),
    Mistake("friction-ignored", "strikes without friction", "see bat.friction",
            _scene(lambda scene: {"bat.friction": None})),
    Mistake("slides-finally", "lets the friction act along what would end the slip",
            "against the slip as it begins, unless the reading slide_direction says final",
            _reading(slide_direction="final")),
    Mistake("pivot-for-free", "has a free bat turn about its end",
            "bat.support = free: it moves and turns about its centre",
            _scene(lambda scene: {"bat.support": "pivot"})),
)  # fmt: skip
