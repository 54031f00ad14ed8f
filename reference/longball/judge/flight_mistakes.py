"""Known mistakes in how a ball flies: its launch, the laws, spin, air, wind, the Earth."""

from __future__ import annotations

import itertools
import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache, partial
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np

from longball.engines.chain import MODEL, Model, OneCase, meet_bat
from longball.judge.any_law import ANY_LAW
from longball.judge.changes import Mistake, reading_change, scene_change
from longball.judge.findings import many
from longball.judge.stages import Change, Numbers, with_values
from longball.model import trace
from longball.model.aerodynamics import (
    BILINEAR,
    CRISIS,
    DECAY_ALONG_PATH,
    DRAG,
    LIFT,
    per_metre,
    spin_across,
    spin_ratio,
)
from longball.model.air import Air, CrisisDrag, Table, Weather
from longball.model.atmosphere import (
    DRY_DENSITY,
    LIGHTER,
    STANDARD_PRESSURE,
    THINNING,
    ZERO_CELSIUS,
    density,
    speed_of_sound,
    station_pressure,
)
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
    square,
    switched,
)
from longball.model.law import GRAVITY
from longball.model.numbers import DOUBLES, Vector, plus
from longball.model.quantities import at, numbers
from longball.model.wind import ROUGHNESS

# --- the law of motion ----------------------------------------------------------------------------


def _terms(change: Callable[[Term], Term | None], *carried: Term) -> Change:
    """Return the change of each term that may act on a ball in flight; None leaves it out."""
    # `carried` are terms behind them, whose parameters those changed may use.
    changed = cache(change)  # the same terms each time, so that their law is traced once

    def model(held: Model) -> Model:
        forces = (new for f in held.forces if (new := changed(f)) is not None)
        return replace(held, forces=(*forces, *carried))

    return Change(model=model)


def _forms(which: Callable[[Term], bool], change: Callable[[Any], Term]) -> Callable[[Any], Any]:
    """Return the change of terms of a kind to another form, on each branch if they have some."""

    def changed(term: Any) -> Any:
        if isinstance(term, Piecewise):
            return replace(term, term=change(term.term)) if which(term.term) else term
        return change(term) if which(term) else term

    return changed


def _strengths(
    changed: Callable[..., Any], which: Callable[[Term], bool] = lambda term: True
) -> Change:
    """Return the change of strengths, or else branches, of terms of a kind."""
    # `changed` takes a term's own before scene, frame and numbers.

    def change(term: Any) -> Any:
        branches = isinstance(term, Piecewise)
        name = "branches" if branches else "strengths"
        new = replace(term, **{name: partial(changed, getattr(term, name))})
        return new if which(term.term if branches else term) else term

    return _terms(change)


def _replaced(term: Term, changed: Term) -> Change:
    return _terms(lambda f: changed if f is term else f)


def _instead(term: Term, acceleration: Callable[[Motion, Any], Vector[Any]]) -> Change:
    """Return the change of one term into a force with that acceleration."""
    return _replaced(term, Force(term.parameters, term.strengths, acceleration))


def _without(left_out: Callable[[Term], bool]) -> Change:
    """Return the change that leaves terms out."""
    return _terms(lambda f: None if left_out(f.term if isinstance(f, Piecewise) else f) else f)


def _drags(term: Term) -> bool:
    return isinstance(term, Drag)


def _lifts(term: Term) -> bool:
    return isinstance(term, Lift) or any("lift" in name for name in term.parameters)


def _lifting(term: Term) -> bool:
    return isinstance(term, Lift | Force) and _lifts(term)


def _multiplied(form: Any, factor: Callable[[Motion, Any], Any]) -> Term:
    """Return a drag, a lift or another force times a factor, of the motion and the parameters."""
    match form:
        case Drag():
            return replace(form, rate=lambda m, p: form.rate(m, p) * factor(m, p))
        case Lift():
            return replace(form, factor=lambda m, p: form.factor(m, p) * factor(m, p))
    return replace(  # type: ignore[no-any-return]
        form, acceleration=lambda m, p: scaled(factor(m, p), form.acceleration(m, p))
    )


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


# More parameters of a term: their names, and their values from the scene and the frame.
More = tuple[tuple[str, ...], Callable[[Any, Any], tuple[Any, ...]]]


def _more(term: Term, more: More) -> Term:
    """Return a term with more parameters."""
    names, values = more

    def strengths(scene: Any, frame: Any, numbers: Any) -> tuple[Any, ...] | None:
        found = term.strengths(scene, frame, numbers)
        return found and (*found, *values(scene, frame))

    return Term((*term.parameters, *names), strengths)


def _launched(scene: Any, frame: Any) -> tuple[Any, ...]:
    """Return the velocity at launch, m/s: along, up, size."""
    if scene.kind != "flight":
        return (None,) * 3
    x, y, z = scene.launch.velocity
    return math.hypot(x, y), z, math.hypot(x, y, z)


_LAUNCH: More = (("launch_u", "launch_w", "launch_speed"), _launched)
_AXES: More = (("cos", "sin"), lambda scene, frame: (frame.cos, frame.sin))  # of the frame


def _in_air(
    term: Term, form: Callable[[Motion, Flow, Any], Vector[Any]], more: More = ((), lambda *_: ())
) -> Change:
    """Return the change of drag or lift to ρ k times a form; `more` are parameters it needs."""
    (strength,), given = term.parameters, _more(term, more)

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

    return _in_air(DRAG, form, _AXES)


def _acceleration(form: Any, motion: Motion, p: Any) -> Vector[Any]:
    """Return what a drag, a lift or another force does."""
    match form:
        case Drag():
            return scaled(-(motion.density * form.rate(motion, p)), motion.air.velocity)
        case Lift():
            return scaled(motion.density * form.factor(motion, p), spin_across(motion.lift, p))
    return form.acceleration(motion, p)  # type: ignore[no-any-return]


def _by_axis(which: Callable[[Term], bool], factors: Sequence[float]) -> Change:
    """Return the change of terms by a factor for each axis of the scene."""

    def changed(form: Any) -> Force:
        def acceleration(motion: Motion, p: Any) -> Vector[Any]:
            own = Flow(_acceleration(form, motion, p), None)
            x, y, z = (f * a for f, a in zip(factors, _in_space(own, p), strict=True))
            return p.cos * x + p.sin * y, p.cos * y - p.sin * x, z

        return Force(form.parameters, form.strengths, acceleration)

    return _terms(_forms(which, changed), Term(_AXES[0], lambda scene, frame, numbers: (
        _AXES[1](scene, frame))))  # fmt: skip


# Of drag or lift: what is done to the components.
_AXES_CHANGED: tuple[tuple[str, str, tuple[float, float, float]], ...] = (
    *((f"without-{axis}", f"leaves the {{}} along {axis} out", factors)
      for axis, factors in (("x", (0, 1, 1)), ("y", (1, 0, 1)))),
    ("level-part", "has the horizontal part of the {}, and not the vertical one", (1, 1, 0)),
    ("vertical-part", "has the vertical part of the {}, and not the horizontal one", (0, 0, 1)),
    *((f"{axis}-sign", f"turns the {{}} along {axis} the wrong way", factors)
      for axis, factors in (("y", (1, -1, 1)), ("z", (1, 1, -1)))),
    ("level-sign", "turns the horizontal part of the {} the wrong way", (-1, -1, 1)),
)  # fmt: skip


def _of_two(x: Any, y: Any) -> Any:
    return trace.sqrt(x * x + y * y)


def _without_side(flow: Flow, p: Any) -> Any:
    """Return the speed without its part across the field."""
    return _of_two(*_in_space(flow, p)[::2])


_DRAG_WITHOUT_SIDE = _in_air(
    DRAG, lambda m, flow, p: scaled(-_without_side(flow, p), flow.velocity), _AXES
)
_LIFT_WITHOUT_SIDE = _in_air(LIFT, lambda m, flow, p: scaled(
    _without_side(flow, p), (-flow.velocity[2], trace.ZERO, flow.velocity[0])), _AXES)  # fmt: skip


def _right_axis(scene: Any, frame: Any) -> Vector[Any]:
    return frame.sin, -frame.cos, 0.0


def _about(axis: Callable[[Any, Any], Vector[Any]]) -> Change:
    """Return the change of the lift to one about an axis in space, from the scene and the frame."""
    in_frame: More = (
        ("axis_s", "axis_y", "axis_z"),
        lambda scene, frame: tuple(frame.turned(axis(scene, frame))),
    )
    return _in_air(LIFT, lambda m, flow, p: scaled(
        flow.speed, cross((p.axis_s, p.axis_y, p.axis_z), flow.velocity)), in_frame)  # fmt: skip


def _about_if_fixed(axis: Callable[[Any, Any], Vector[Any]]) -> Change:
    """Return the change that adds a lift about the difference of axes, where not always up."""

    def strengths(scene: Any, frame: Any, numbers: Any) -> tuple[Any, ...] | None:
        found = LIFT.strengths(scene, frame, numbers)
        if not found or scene.reading.lift_direction == "always_up":
            return None
        more = plus(axis(scene, frame), -1.0, _right_axis(scene, frame))
        return (*found, *frame.turned(more))

    def acceleration(motion: Motion, p: Any) -> Vector[Any]:
        flow = motion.lift
        across = cross((p.axis_s, p.axis_y, p.axis_z), flow.velocity)
        return scaled(motion.density * p.lift_about_axis * flow.speed, across)

    names = ("lift_about_axis", "axis_s", "axis_y", "axis_z")
    return _terms(lambda term: term, Force(names, strengths, acceleration))


_ASIDE = 1e-9  # m/s: too slow to move a flight, and enough to give it a heading


def _headed(way: Sequence[float]) -> Change:
    """Return the change of launches straight up or down to ones with a heading."""

    def values(scene: Any) -> Mapping[str, Any]:
        *level, rise = scene.launch.velocity
        aside = (_ASIDE * x for x in way)
        return {} if any(level) else {"launch.velocity": (*aside, rise)}

    return scene_change(values)


def _is_batted(scene: Any, frame: Any) -> bool:
    """Tell whether a flight of an at-bat is that of the batted ball."""
    return scene.kind == "at-bat" and (frame.x, frame.y) != tuple(scene.pitch.release[:2])


def _axis_of_pitch(straight: bool) -> Callable[[Any, Any], Vector[Any]]:
    """Return the axis of the lift: of a batted ball that of the pitch, or of a `straight` one."""

    def axis(scene: Any, frame: Any) -> Vector[Any]:
        if not _is_batted(scene, frame):
            return _right_axis(scene, frame)
        x, y, _ = (-1.0, 0.0, 0.0) if straight else scene.pitch.thrown
        size = math.hypot(x, y) or 1.0
        return y / size, -x / size, 0.0

    return axis


def _drag(factor: Callable[[Motion, Any], Any], more: More = ((), lambda *_: ())) -> Change:
    """Return the change of the drag to ``-k factor v``."""
    given = _more(DRAG, more)
    changed = Drag(given.parameters, given.strengths, lambda m, p: p.drag * factor(m, p))
    return _replaced(DRAG, changed)


def _lift(direction: Callable[[Any, Any, Any], Vector[Any]]) -> Change:
    """Return the change of the lift to k_L times a function of u, w and V."""
    return _in_air(
        LIFT, lambda m, flow, p: direction(flow.velocity[0], flow.velocity[2], flow.speed)
    )


def _lift_rate(rate: Callable[[Motion, Flow], Any]) -> Change:
    """Return the change of the lift to k_L times a rate, m/s, across the velocity: (-w, u)."""

    def form(motion: Motion, flow: Flow, p: Any) -> Vector[Any]:
        (u, _, w), size = flow.velocity, rate(motion, flow)
        return -size * w, trace.ZERO, size * u

    return _in_air(LIFT, form)


def _as_at_launch(motion: Motion, flow: Flow, p: Any) -> Vector[Any]:
    """Return V² across the velocity at launch."""
    rate = flow.speed * flow.speed / p.launch_speed
    return -rate * p.launch_w, trace.ZERO, rate * p.launch_u


def _thrown(values: Callable[[Any], Mapping[str, Any]]) -> Change:
    """Return the change of a pitch that is given by release, speed and aim."""
    return scene_change(lambda scene: {} if scene.pitch.aim is None else values(scene.pitch))


def _through(front: float) -> Callable[[Any], Mapping[str, Any]]:
    """Return the change of the aim to where the throw is to go if it is to x = `front`, m."""

    def values(pitch: Any) -> Mapping[str, Any]:
        x, *beside = pitch.release
        return {"pitch.aim": tuple(b + (a - b) * x / (x - front)
                                   for a, b in zip(pitch.aim, beside, strict=True))}  # fmt: skip

    return values


def _displaced(factors: Callable[[float], Mapping[str, float]]) -> Change:
    """Return the change of some values by factors of the share of the ball that air would weigh."""

    def values(scene: Any) -> Mapping[str, Any]:
        volume = 4 / 3 * math.pi * scene.ball.radius**3
        share = float(density(scene, DOUBLES)) * volume / scene.ball.mass
        return {name: at(scene, name) * factor for name, factor in factors(share).items()}

    return scene_change(values)


_EARTH_RADIUS = 6_371_000.0  # m


def _falling(motion: Motion, p: Any) -> Vector[Any]:
    """Return ``-g (R/(R + z))²`` with the Earth's radius R, upwards."""
    share = _EARTH_RADIUS / (_EARTH_RADIUS + motion.position[2])
    return trace.ZERO, trace.ZERO, -p.gravity * (share * share)


_NO_MORE = "weight, drag and lift are all the forces that there are"
_AGAINST = "the drag is -k V v: against the velocity, in every component"
_ACROSS = "the lift is k_L V (ê × v), which is k_L V (-w, u) in the flight plane"
_ALONG_CROSS = "the lift is along ω × u/|ω × u|, u the ball's velocity through the air"
_SCENE = "take the numbers of the scene"
_HEADING = "the axis ê is horizontal and across the heading at launch: (sin φ, -cos φ, 0)"
_ANEW = "the axis ê is fixed at the launch of each flight: at the impact anew"

# What else may be the axis of the lift: a name, words, the remedy, the axis in space.
_AXES_OF_LIFT: tuple[tuple[str, str, str, Callable[[Any, Any], Vector[Any]]], ...] = (
    ("lift-about-minus-y", "lifts about -y, whatever the ball's heading", _HEADING,
     lambda scene, frame: (0.0, -1.0, 0.0)),
    ("lift-about-own-y", "lifts about y, up whatever the ball's heading", _HEADING,
     lambda scene, frame: (0.0, math.copysign(1.0, -frame.cos), 0.0)),
    ("lift-axis-sign", "has the lift's axis the other way round, (-sin φ, cos φ, 0)",
     _HEADING, lambda scene, frame: (-frame.sin, frame.cos, 0.0)),
    ("lift-about-axis-of-pitch", "lifts a batted ball about the axis that the pitch had",
     _ANEW, _axis_of_pitch(straight=False)),
    ("lift-about-plus-y", "lifts a batted ball about +y, the axis of a straight pitch",
     _ANEW, _axis_of_pitch(straight=True)),
)  # fmt: skip

_PAPERS_LAW: tuple[Mistake, ...] = (
    Mistake("drag-per-component", "drags each component by itself, with its own square",
            "the drag is -k V v: every component times the whole speed V",
            _by_component(lambda c: _size(c) * c)),
    Mistake("drag-per-component-in-plane", "drags the horizontal and the vertical speed each by "
            "itself, with its own square", "the drag is -k V v: each times the whole speed V",
            _in_air(DRAG, lambda m, flow, p: (
                *scaled(-_of_two(*flow.velocity[:2]), flow.velocity)[:2],
                -_size(flow.velocity[2]) * flow.velocity[2]))),
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
            _drag(lambda m, p: p.launch_speed, _LAUNCH)),
    Mistake("drag-with-horizontal-speed", "takes the horizontal speed for V in the drag",
            "V is the whole speed", _drag(lambda m, p: _of_two(*m.air.velocity[:2]))),
    *(Mistake(name, f"leaves v_y, the speed across the field, out of V in {where}",
              "V is the whole speed", change)
      for name, where, change in (
          ("drag-without-side-speed", "the drag", _DRAG_WITHOUT_SIDE),
          ("speed-without-side", "drag and lift", _DRAG_WITHOUT_SIDE.then(_LIFT_WITHOUT_SIDE)))),
    Mistake("drag-with-summed-speed", "takes the sum of the components' sizes for V in the drag",
            "V is the root of the sum of their squares",
            _in_air(DRAG, lambda m, flow, p: scaled(
                -trace.total(map(_size, _in_space(flow, p))), flow.velocity), _AXES)),
    Mistake("drag-rising-only", "drags the ball on its way up only",
            "the drag acts on the way down too", _drag(lambda m, p: m.speed * _rising(m)), True),
    Mistake("density-falls", "lets the air grow thinner with height",
            "the scene's density holds at every height",
            scene_change(lambda scene: {"air.density_scale_height": 8500.0})),
    Mistake("drag-always-down", "drags a falling ball down: the vertical drag has no sign",
            _AGAINST, _in_air(DRAG, lambda m, flow, p: scaled(
                -flow.speed, (*flow.velocity[:2], _size(flow.velocity[2]))))),
    Mistake("drag-level-falling", "drags a falling ball in its horizontal components only",
            _AGAINST, _in_air(DRAG, lambda m, flow, p: scaled(-flow.speed, (
                *flow.velocity[:2], flow.velocity[2] * _rising(m)))), True),
    *(Mistake(f"{way.replace(' ', '-')}-{name}", words.format(way), remedy,
              _by_axis(which, factors))
      for way, which, remedy in (
          ("drag", _drags, _AGAINST), ("lift", _lifting, _ACROSS),
          ("lift of a ball with spin", lambda term: isinstance(term, Lift), _ALONG_CROSS))
      for name, words, factors in _AXES_CHANGED),
    Mistake("drag-forward", "drags along the velocity instead of against it", _AGAINST,
            _drag(lambda motion, p: -motion.speed)),
    Mistake("air-for-null", "has the usual air where the scene says null",
            "air = null is none: no drag and no lift", Change(lambda scene: (
                scene if getattr(scene, "air", 0) is not None
                else scene.model_copy(update={"air": Air()})))),
    Mistake("no-drag", "flies without drag", "add -k_D V v",
            _without(_drags)),
    Mistake("no-lift", "flies without lift", "add k_L V (ê × v)", _without(_lifts)),
    Mistake("no-gravity", "flies without gravity", "add -g to the vertical",
            _without(lambda term: term is GRAVITY)),
    Mistake("gravity-falls", "lets gravity fall with height",
            "gravity is the scene's at every height",
            _instead(GRAVITY, _falling)),
    Mistake("gravity-up", "falls upwards", "gravity is -g along z",
            _instead(GRAVITY, lambda m, p: (trace.ZERO, trace.ZERO, p.gravity))),
    Mistake("coefficients-exchanged", "exchanges the coefficients of drag and lift", _SCENE,
            scene_change(lambda s: {"air.drag_coefficient": s.air.lift_coefficient,
                              "air.lift_coefficient": s.air.drag_coefficient})),
    Mistake("lift-coefficient-for-drag", "takes the coefficient of the drag for that of the lift",
            _SCENE, scene_change(lambda s: {"air.lift_coefficient": s.air.drag_coefficient}),
            scaled="air.lift_coefficient"),
    Mistake("lift-sign", "lifts the ball the wrong way",
            "with backspin the lift turns the velocity upwards: k_L V (-w, u) in the flight plane",
            _lift_rate(lambda m, flow: -flow.speed)),
    Mistake("lift-coefficient-size", "takes C_L without its sign",
            "a negative C_L is topspin: it presses the ball down",
            scene_change(lambda s: {"air.lift_coefficient": abs(s.air.lift_coefficient)})),
    Mistake("lift-vertical", "lifts straight up with V², instead of across the velocity", _ACROSS,
            _lift(lambda u, w, speed: (trace.ZERO, trace.ZERO, speed * speed))),
    Mistake("lift-with-v", "lets the lift grow with V, not with V²", "the lift is ½ C_L ρ A V²",
            _lift_rate(lambda m, flow: 1.0), scaled="air.lift_coefficient"),
    Mistake("lift-with-horizontal-speed", "takes the horizontal speed for V in the lift", _ACROSS,
            _lift_rate(lambda m, flow: _size(flow.velocity[0]))),
    Mistake("lift-as-at-launch", "keeps the direction that the lift has at launch", _ACROSS,
            _in_air(LIFT, _as_at_launch, _LAUNCH)),
    Mistake("lift-rising-only", "lifts the ball on its way up only",
            "the lift acts on the way down too",
            _lift_rate(lambda m, flow: flow.speed * _rising(m)), True),
    Mistake("lift-sign-falling", "lifts a falling ball the wrong way", _ACROSS,
            _lift_rate(lambda m, flow: flow.speed * (2.0 * _rising(m) - 1.0)), True),
    *(Mistake(name, sentence + where, remedy, about(axis))
      for name, sentence, remedy, axis in _AXES_OF_LIFT
      for where, about in (("", _about), (", but not where it is always up", _about_if_fixed))),
    *(Mistake(f"heading-of-vertical-{name}", f"has a launch straight up or down head for {name}",
              "its heading is +x", _headed(way))
      for name, way in (("-x", (-1.0, 0.0)), ("y", (0.0, 1.0)), ("-y", (0.0, -1.0)))),
    Mistake("lift-about-forward-axis", "takes |v_x| for v_x in the heading", _HEADING,
            _about_if_fixed(lambda scene, frame: (frame.sin, -abs(frame.cos), 0.0))),
    Mistake("lift-about-left-axis", "takes |v_y| for v_y in the axis of lift", _HEADING,
            _about_if_fixed(lambda scene, frame: (abs(frame.sin), -frame.cos, 0.0))),
    Mistake("heading-by-arctangent", "takes the heading for atan(v_y/v_x), which is the "
            "opposite one where v_x < 0: the lift then has the wrong sign", "take atan2(v_y, v_x), "
            "or divide the horizontal velocity by its size", _about(lambda scene, frame: scaled(
                -1.0 if frame.cos < 0 else 1.0, _right_axis(scene, frame)))),
    Mistake("lift-sideways", "lifts the ball sideways",
            "the spin axis is horizontal: the lift lies in the vertical plane of the launch",
            _lift(lambda u, w, speed: (trace.ZERO, speed * u, trace.ZERO))),
    Mistake("lift-always-up", "keeps the lift on the upper side of the path, beyond the vertical "
            "too", "fix the spin axis at launch, or ask for the reading lift_direction = always_up",
            reading_change(lift_direction="always_up")),
    Mistake("buoyancy", "lets the air buoy the ball up: g (1 - ρ V/m)", _NO_MORE,
            _displaced(lambda share: {"gravity": 1 - share})),
    Mistake("added-mass", "adds half the mass of the air that the ball displaces to its inertia",
            _NO_MORE, _displaced(lambda share: {
                "gravity": 1 / (1 + share / 2), "ball.mass": 1 + share / 2})),
    Mistake("launch-at-origin", "launches the ball at (0, 0, 0)", _SCENE,
            scene_change(lambda scene: {"launch.position": (0.0, 0.0, 0.0)})),
    Mistake("launch-above-origin", "launches the ball above (0, 0), at its height", _SCENE,
            scene_change(lambda scene: {"launch.position[0]": 0.0, "launch.position[1]": 0.0})),
    Mistake("release-fixed", "throws from (18.44, 0, 1.8), whatever pitch.release is", _SCENE,
            _thrown(lambda pitch: {"pitch.release": (18.44, 0.0, 1.8)})),
    Mistake("aim-exchanged", "exchanges side and height of the aim", "pitch.aim is [y, z]",
            _thrown(lambda pitch: {"pitch.aim": pitch.aim[::-1]})),
    Mistake("aim-level", "throws level: the height of the aim is ignored", _SCENE,
            _thrown(lambda pitch: {"pitch.aim[1]": pitch.release[2]})),
    Mistake("throw-without-vertical", "leaves the vertical part of the throw's velocity out",
            "the throw is towards the aim, its height too", _thrown(lambda pitch: {
                "pitch.aim[1]": pitch.release[2], "pitch.speed":
                    pitch.speed * math.hypot(*pitch.way[:2]) / math.hypot(*pitch.way)})),
    Mistake("aim-straight", "throws straight ahead: the side of the aim is ignored", _SCENE,
            _thrown(lambda pitch: {"pitch.aim[0]": pitch.release[1]})),
    Mistake("aim-side-from-release", "counts the side of the aim from the point of release",
            "the aim is a point: y and z where the plate is",
            _thrown(lambda pitch: {"pitch.aim[0]": pitch.aim[0] + pitch.release[1]})),
    Mistake("aim-at-front", "aims at a point above the front of home plate, x = 0.4318 m",
            "the aim is a point of the plane x = 0", _thrown(_through(0.4318))),
    *(Mistake(f"pitch-speed-{name}", f"gives the ball pitch.speed {words}, and the rest of the way "
              "on top", "pitch.speed is the size of the velocity at the release",
              _thrown(lambda pitch, n=count: {  # type: ignore[misc]
                  "pitch.speed":
                      pitch.speed * math.hypot(*pitch.way) / math.hypot(*pitch.way[:n])}))
      for name, words, count in (("along-x", "along x", 1), ("level", "along the ground", 2))),
    Mistake("aim-from-release", "counts the aim from the point of release",
            "the aim is a point: y and z where the plate is",
            _thrown(lambda pitch: {"pitch.aim[0]": pitch.aim[0] + pitch.release[1],
                                   "pitch.aim[1]": pitch.aim[1] + pitch.release[2]})),
)  # fmt: skip


# --- spin, air and wind ---------------------------------------------------------------------------


def _spins(change: Callable[..., Numbers], *places: str) -> Change:
    """Return the change of the ball's spin, where a scene gives one; it may ask for the scene."""

    def values(scene: Any) -> Mapping[str, Any]:
        names = [f"{place}.spin" for place in places or ("launch", "pitch", "incoming")]
        return {name: change(spin, scene) for name in names if (spin := at(scene, name))}

    return scene_change(values)


def _times(factor: float) -> Callable[..., Numbers]:
    return lambda vector, *_: tuple(factor * x for x in vector)


def _arranged(axes: str) -> Callable[..., Numbers]:
    """Return the change of a vector to such components as "x -y 0"."""

    def arranged(vector: Numbers, *_: Any) -> Numbers:
        known = {"0": 0.0, **dict(zip("xyz", vector, strict=True))}
        return tuple(-known[a[1]] if a[0] == "-" else known[a] for a in axes.split())

    return arranged


def _backspin(spin: Numbers, scene: Any) -> Numbers:
    """Return a backspin of that size."""
    x, y, _ = scene.launch.velocity if scene.kind == "flight" else (-1.0, 0.0, 0.0)
    across, size = math.hypot(x, y), math.hypot(*spin)
    return (size * y / across, -size * x / across, 0.0) if across else spin


def _winds(change: Callable[[Numbers], Numbers]) -> Change:
    def values(scene: Any) -> Mapping[str, Any]:
        place = "air.wind" if isinstance(scene.air.wind, tuple) else "air.wind.velocity"
        return {place: change(at(scene, place))}

    return scene_change(values)


def _wind_not_in_lift_by_spin(scene: Any) -> Any:
    """Return a scene whose wind acts on drag alone, if its ball is launched with a spin."""
    launch = getattr(scene, "launch", None) or getattr(scene, "pitch", None)
    spins = launch is not None and launch.spin is not None
    return reading_change(wind_acts_on="drag").scene(scene) if spins else scene


def with_density(scene: Any, value: float) -> Any:
    """Return a scene with another density at height 0, kg/m³."""
    # That of the weather is linear in the pressure, on which nothing else hangs.
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


def _vapour_warmer(by: float) -> Change:
    """Return the change of the density to that with the vapour's pressure at T + by, K."""

    def formula(scene: Any, weather: Any) -> float:
        t = weather.temperature
        dry, hot = (_of_weather(scene, humidity=0.0, temperature=x) for x in (t, t + by))
        vapour = hot - _of_weather(scene, temperature=t + by)
        return dry - vapour * float((t + by) / t)

    return _density(formula)


def _with_vapour(pressure: Callable[[float], float]) -> Change:
    """Return the change of the saturated vapour's pressure, Pa, to a formula of t in °C."""

    def formula(scene: Any, weather: Any) -> float:
        t = weather.temperature - ZERO_CELSIUS
        dry = _of_weather(scene, humidity=0.0)
        vapour = LIGHTER * weather.humidity * pressure(t)
        return dry * (1 - vapour / station_pressure(scene, DOUBLES))  # type: ignore[no-any-return]

    return _density(formula)


def _gas(scene: Any, weather: Any) -> float:
    """Return the density of an ideal gas with R = 287.058 J/(kg K), and water's 461.495."""
    t = weather.temperature
    lighter = _of_weather(scene, humidity=0.0) - _of_weather(scene)
    vapour = lighter * t / (DRY_DENSITY * ZERO_CELSIUS) * STANDARD_PRESSURE / LIGHTER
    dry = station_pressure(scene, DOUBLES) - vapour
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


# Where the density that falls by e in H is 1, as a height of the scene; that of the scale is 0.
_LEVELS: tuple[tuple[str, str, Callable[[Any], float]], ...] = (
    ("launch", "from the launch",
     lambda s: (s.launch.position if s.kind == "flight" else s.pitch.release)[2]),
    ("ground", "from the ground", lambda s: s.ground.height),
)  # fmt: skip


def _denser(factor: Callable[[Any, float], float], other: float | None = 0.0) -> Change:
    """Return the change of the density by a factor, from the scene and H; `other` is the new H."""

    def change(scene: Any) -> Any:
        scale = getattr(getattr(scene, "air", None), "density_scale_height", None)
        if scale is None:
            return scene
        new = with_density(scene, float(density(scene, DOUBLES)) * factor(scene, scale))
        return new if other == 0.0 else with_values(new, {"air.density_scale_height": other})

    return Change(change)


def _sound(formula: Callable[[float], float]) -> Change:
    """Return the change of the speed of sound to a formula of T in K."""

    def heard(nodes: Any, values: Any, scene: Any) -> tuple[Any, Any]:
        share = formula(scene.air.density.temperature) / speed_of_sound(scene, DOUBLES)
        return [float(x * share) for x in nodes], values

    return _tables(heard, "mach")


def _at_launch(scene: Any) -> Mapping[str, Any]:
    """Return the coefficients with the values that they have at the launch's speed."""
    found: dict[str, Any] = {}
    flight, law = scene.kind == "flight", scene.air.drag_coefficient
    speed = math.hypot(*scene.launch.velocity) if flight else scene.pitch.speed
    if isinstance(law, CrisisDrag):
        high, low = law.high_speed, law.low_speed
        value = high + (low - high) / (1 + math.exp((speed - law.speed) / law.width))
        found = {f"air.drag_coefficient.{key}_speed": value for key in ("high", "low")}
    for name in _COEFFICIENTS:
        table = at(scene, name)
        if getattr(table, "of", "") in ("speed", "mach"):
            x = speed if table.of == "speed" else speed / float(speed_of_sound(scene, DOUBLES))
            value = float(np.interp(x, table.at, table.values))
            found[f"{name}.values"] = (value,) * len(table.values)
    return found


def _lift_times(share: Callable[[Flow, Any], Any]) -> Callable[[Any], Any]:
    """Return the change of a spinning ball's lift by a factor, from its flow and the parameters."""
    return _forms(
        lambda term: isinstance(term, Lift),
        lambda form: _multiplied(form, lambda m, p: share(m.lift, p)),
    )


# 1 if the scene's lift is one by the whole spin, and else 0: None would keep the term from acting.
_TOTAL = Term(("of_total",), lambda scene, frame, numbers: (
    float(scene.reading.spin_parameter == "total"),))  # fmt: skip


def _lift_limit(scene: Any, frame: Any, numbers: Any) -> tuple[Any] | None:
    """Return k times the largest C_L that a scene carries."""
    unit = None if scene.air is None else per_metre(scene, 1.0, numbers)
    return None if unit is None else (unit * getattr(scene, "lift_limit", NO_LIMIT),)


def _limited(form: Lift, m: Motion, p: Any) -> Any:
    """Return what makes a lift one of the largest C_L, where it is of a larger one."""
    most = p.lift_limit * square(m.lift.velocity)
    active = size(spin_across(m.lift, p))
    active += p.of_total * (p.spin * m.lift.speed - active)
    return most / _larger(form.factor(m, p) * active, most, NARROW * most)


NO_LIMIT = 1e9  # a C_L that is never met
NARROW = 1e-7  # relative: how wide the bend is in what stands for the larger of two

_LIMITED = _terms(
    _forms(lambda term: isinstance(term, Lift),
           lambda form: _multiplied(form, lambda m, p: _limited(form, m, p))),
    Term(("lift_limit",), _lift_limit),
    _TOTAL,
)  # fmt: skip


def _limit_lift(most: Callable[[Any], float]) -> Change:
    """Return the change of a spinning ball's C_L to at most a number, from the law."""

    def change(scene: Any) -> Any:
        law = getattr(getattr(scene, "air", None), "lift_coefficient", None)
        return scene.model_copy(update={"lift_limit": most(law)}) if hasattr(law, "law") else scene

    return Change(change).then(_LIMITED)


def _bilinear(
    change: Callable[[Any], Any], given: Any, scene: Any, frame: Any, numbers: Any
) -> Branches | None:
    """Return the branches of a table of the lift, with other lines if it is the bilinear law."""
    found = given(scene, frame, numbers)
    if found is None or not found.levels or scene.air.lift_coefficient.law != "bilinear":
        return found  # type: ignore[no-any-return]
    return Branches(found.levels, change(found.strengths))


def _lift_at(ratio: float, law: Any) -> float:
    """Return the C_L of a law at a spin parameter; none is met if it does not depend on that."""
    match law.law:
        case "rational":
            return float(law.numerator * ratio / (law.constant + law.slope * ratio))
        case "linear":
            return float(law.slope * ratio)
        case "bilinear":
            return min(at_0 + slope * ratio for at_0, slope in BILINEAR[1])
    return NO_LIMIT


def _lift_of(which: str, most: float, law: Any) -> float:
    """Return a C_L if a law is the one; none is met if it is another."""
    return most if which in ("", law.law) else NO_LIMIT


_MOST = 0.2, 0.25, 0.3, 0.35, 0.4, 0.5  # what people may limit C_L, or S, to


def _by_whole_spin(f: Any) -> Any:
    """Return a lift whose size goes with the whole spin, where it goes with spin at all."""
    by_spin = not {"linear_lift", "rational_lift"}.isdisjoint(f.parameters)
    return _lift_times(lambda flow, p: 1.0 + (1.0 if by_spin else p.of_total) * (
        1.0 / _active(flow, p) - 1.0))(f)  # fmt: skip


def _active(flow: Flow, p: Any) -> Any:
    """Return ω_T/ω of the spin at launch."""
    a, b = spin_ratio(flow, p, whole=False)
    return trace.ZERO if b is trace.ZERO else b * flow.speed / (a * p.spin)


def _batted_spin(spin: Callable[[Any, Any], Any]) -> Change:
    """Return the change of a batted ball's spin, if it has one; it may ask for the scene."""
    return Change(launch=lambda scene, launch: launch if launch.spin is None else replace(
        launch, spin=spin(launch.spin, scene)))  # fmt: skip


def _decayed_before(spin: Any, scene: Any) -> Any:
    """Return a spin after as much decay as the pitch's has at the bat."""
    thrown = scene.pitch.spin and math.hypot(*scene.pitch.spin)
    return scaled(math.hypot(*(_spin_at_bat(scene) or ())) / thrown, spin) if thrown else spin


def _without_spin(given: Any, scene: Any, frame: Any, numbers: Any) -> Any:
    """Return strengths that the laws by spin have without one, too: by the paper's C_L."""
    if frame.spin is None and scene.air is not None and scene.air.lift_needs_spin:
        scene = with_values(scene, {"air.lift_coefficient": Air().lift_coefficient})
    return given(scene, frame, numbers)


def _pitch_without_spin(given: Any, scene: Any, frame: Any, numbers: Any) -> Any:
    """Return the strengths of a pitch that flies without its spin, and comes to the bat with it."""
    thrown = scene.kind != "flight" and not _is_batted(scene, frame)
    return _without_spin(given, scene, replace(frame, spin=None) if thrown else frame, numbers)


_NO_SPIN = _strengths(_without_spin, lambda term: term is not LIFT)


@lru_cache(maxsize=4096)
def _spin_at_bat(scene: Any) -> Numbers | None:
    """Return the spin with which the ball of a scene comes to the bat, rad/s."""
    _, meeting = meet_bat(OneCase(scene, ANY_LAW, MODEL))
    return None if meeting is None else meeting.contact.spin


def _of_diameter(given: Any, scene: Any, frame: Any, numbers: Any) -> Any:
    """Return strengths that have the diameter for R, but for the area."""
    ball = {"ball.radius": 2 * scene.ball.radius, "ball.mass": 4 * scene.ball.mass}
    return given(with_values(scene, ball), frame, numbers)


def _profile(rise: Callable[[Any, Any], Any]) -> Change:
    """Return the change of the wind's growth with height to a function of z and parameters."""

    def changed(f: Any) -> Any:
        if not (isinstance(f, Wind) and ROUGHNESS in f.parameters):
            return f
        more = _more(f, (("wind_height", "start_height"), lambda scene, frame: (
            scene.air.wind.height, _LEVELS[0][2](scene))))  # fmt: skip

        def velocity(position: Vector[Any], p: Any) -> Vector[Any]:
            own = trace.log(1.0 + p.wind_height / p.roughness) * rise(position[2], p)
            return scaled(own, (p.log_wind_s, p.log_wind_y, trace.ZERO))

        return Wind(more.parameters, more.strengths, velocity, f.lifts)

    return _terms(changed)


_BLEND = 5e-3  # m: a height at which two forms of the wind go over into each other is so wide


def _larger(a: Any, b: Any, blend: Any = _BLEND) -> Any:
    """Return the larger of two, smoothly."""
    return (a + b + trace.sqrt((a - b) * (a - b) + blend * blend)) * 0.5


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
            yield Mistake(f"{a}-{b}-exchanged", sentence, _SCENE, scene_change(values))


def _turning(motion: Motion, p: Any) -> Vector[Any]:
    """Return the Coriolis and the centrifugal acceleration."""
    omega, (s, y, z) = (p.earth_s, p.earth_y, p.earth_z), motion.position
    away = cross(omega, cross(omega, (s, y, z + _EARTH_RADIUS)))
    return plus(CORIOLIS.acceleration(motion, p), -1.0, away)  # type: ignore[return-value]


def _turning_without(*components: str) -> Change:
    """Return the change of the Coriolis acceleration to one without components of Ω."""
    none = dict.fromkeys(components, trace.ZERO)
    return _instead(CORIOLIS, lambda m, p: CORIOLIS.acceleration(
        m, SimpleNamespace(**vars(p) | none)))  # fmt: skip


def _coriolis(changed: Callable[[Vector[Any]], Vector[Any]]) -> Change:
    """Return the change of the Coriolis acceleration to a function of it."""
    return _instead(CORIOLIS, lambda m, p: changed(CORIOLIS.acceleration(m, p)))


_COEFFICIENTS = "air.drag_coefficient", "air.lift_coefficient"


def _tables(change: Callable[..., Any], of: str = "") -> Change:
    """Return the change of nodes and values of a scene's tables, or of those over one thing."""

    def values(scene: Any) -> Mapping[str, Any]:
        found: dict[str, Any] = {}
        for name in _COEFFICIENTS:
            table = at(scene, name)
            if isinstance(table, Table) and of in ("", table.of):
                nodes, there = change(table.at, table.values, scene)
                found |= {f"{name}.at": tuple(nodes), f"{name}.values": tuple(there)}
        return found

    return scene_change(values)


_NARROW = 1e-15  # relative: half the width of the line that stands for a jump in a table


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

    def steps(nodes: Sequence[float], values: Sequence[float], scene: Any) -> tuple[Any, Any]:
        pairs = [one for one in zip(jumps(nodes), pairwise(values), strict=True) if one[0]]
        at = [x for jump, _ in pairs for x in (jump * (1 - _NARROW), jump * (1 + _NARROW))]
        return at, [value for _, pair in pairs for value in pair]

    return _tables(steps).then(_terms(_jumping))


def _extrapolated(
    nodes: Sequence[float], values: Sequence[float], scene: Any, below: bool, above: bool
) -> tuple[list[float], list[float]]:
    """Return a table that goes on below its first node to 0, or far above its last one."""

    def line(x: float, i: int, k: int) -> float:
        slope = (values[k] - values[i]) / (nodes[k] - nodes[i])
        return values[i] + slope * (x - nodes[i])

    low = [0.0] if below and nodes[0] != 0.0 else []
    high = [100 * nodes[-1]] if above else []
    ends = [line(x, 0, 1) for x in low], [line(x, -2, -1) for x in high]
    return [*low, *nodes, *high], [*ends[0], *values, *ends[1]]


def _level_from(
    most: float, nodes: Sequence[float], values: Sequence[float], scene: Any
) -> tuple[list[float], list[float]]:
    """Return a table that keeps the value at a node from there on."""
    more = sorted({*nodes, most})
    return more, np.interp(np.minimum(more, most), nodes, values).tolist()


def _with_defaults(place: str, law: str, scene: Any) -> Mapping[str, Any]:
    """Return a coefficient with the defaults of all its numbers, if it is of a law."""
    held = at(scene, place)
    fields = type(held).model_fields.items() if held.law == law else ()
    return {f"{place}.{name}": f.default for name, f in fields if not f.is_required()}


def _earth(key: str, change: Callable[[float], float]) -> Change:
    """Return the change of an angle of the Earth's rotation."""
    return scene_change(lambda scene: {f"earth.{key}": change(getattr(scene.earth, key))})


_EARTH = "add -2 Ω × v, Ω = 7.292115e-5 rad/s (cos λ north + sin λ up)"
_BILINEAR = "C_L is 1.5 S, and 0.09 + 0.6 S from S = 0.1 on"
_AZIMUTH = "earth.azimuth is that of +x, clockwise from north"
_S = "C_L follows S = R ω_T/U by the scene's law, however large S is"
_SPEEDS = ("km/h", 1 / 3.6), ("mph", 0.44704), ("ft/s", 0.3048)  # and what they are in m/s
_LINEAR = "a table is linear between its nodes, and constant outside"


def _ground_speed(term: Drag) -> Drag:
    """Return a drag by the speed over the ground."""
    return replace(term, rate=lambda motion, p: term.rate(
        motion._replace(air=Flow(motion.air.velocity, size(motion.velocity))), p))  # fmt: skip


def _with_spin_of_launch(form: Callable[[Motion, Any], Any]) -> Callable[[Motion, Any], Any]:
    """Return a function of the motion with the spin that the ball has at launch."""
    return lambda motion, p: form(motion._replace(spin_left=trace.as_node(1.0)), p)


def _undecayed(which: type[Term], form: str) -> Change:
    """Return the change of drags, or of the sizes of lifts, to ones by the spin at launch."""
    change = _forms(
        lambda term: isinstance(term, which),
        lambda held: replace(held, **{form: _with_spin_of_launch(getattr(held, form))}),
    )

    def changed(f: Any) -> Any:
        new = change(f)
        if new is f or not isinstance(new, Piecewise):
            return new
        return replace(new, argument=_with_spin_of_launch(new.argument))

    return _terms(changed)


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
    *(Mistake(f"spin-{name}", sentence, remedy, _spins(change, *places))
      for remedy, known in (
          (_UNIT, (
              ("in-rpm", "takes the spin for rpm", _times(math.pi / 30)),
              ("to-rpm", "turns the spin into rpm", _times(30 / math.pi)),
              ("in-revolutions", "takes the spin for revolutions per second", _times(2 * math.pi)),
              ("in-degrees", "takes the spin for degrees per second", _times(math.pi / 180)))),
          (_DIRECTION, (
              ("sign", "takes the spin with the other sign", _times(-1.0)),
              ("sign-of-pitches", "takes the spin of a ball that flies to the plate with the other "
               "sign", _times(-1.0), "pitch", "incoming"),
              ("sign-of-flights", "takes the spin of a ball that flies away from the plate with "
               "the other sign", _times(-1.0), "launch"),
              ("side-sign", "has the spin's y the other way round", _arranged("x -y z")),
              ("y-only", "takes the spin's y only", _arranged("0 y 0")),
              ("x-left-out", "leaves the spin's x out", _arranged("0 y z")),
              ("y-left-out", "leaves the spin's y out", _arranged("x 0 z")),
              ("z-left-out", "leaves the spin's z out", _arranged("x y 0")),
              ("x-sign", "has the spin's x the other way round", _arranged("-x y z")),
              ("z-sign", "has the spin's z the other way round", _arranged("x y -z")),
              ("xy-exchanged", "exchanges the spin's x and y", _arranged("y x z")),
              ("xz-exchanged", "exchanges the spin's x and z", _arranged("z y x")),
              ("yz-exchanged", "exchanges the spin's y and z", _arranged("x z y")))))
      for name, sentence, change, *places in known),
    Mistake("spin-of-pitch-kept", "lets the batted ball fly with the spin of the pitch",
            "the batted ball has the spin that the impact gives it",
            _batted_spin(lambda spin, scene: _spin_at_bat(scene))),
    Mistake("batted-spin-forgotten", "lets the batted ball fly by the lift of a ball of which no "
            "spin is given", "the batted ball has the spin that the impact gives it",
            _batted_spin(lambda *_: None).then(_NO_SPIN)),
    *(Mistake(name, f"throws the pitch by the lift of a ball of which no spin is given{words}",
              "take pitch.spin from the scene", change)
      for name, words, change in (
          ("pitch-spin-forgotten", "",
           scene_change(lambda scene: {"pitch.spin": None}).then(_NO_SPIN)),
          ("pitch-spin-not-in-flight", "; it comes to the bat with its spin",
           _strengths(_pitch_without_spin, lambda term: term is not LIFT)))),
    Mistake("spin-decay-goes-on", "lets the batted ball's spin fall as if it had flown "
            "with the pitch",
            "path and time of the decay begin anew at the contact", _batted_spin(_decayed_before)),
    Mistake("batted-without-spin", "lets the batted ball fly without spin",
            "the batted ball has the spin that the impact gives it",
            _batted_spin(lambda *_: (0.0, 0.0, 0.0))),
    *(Mistake(f"spin-parameter-at-most-{most:g}", f"takes at most {most:g} for S", _S,
              _tables(partial(_level_from, most), "spin_parameter").then(
                  _limit_lift(partial(_lift_at, most))), True) for most in (0.1, 0.15, *_MOST)),
    *(Mistake(f"{law or 'spin'}-lift-at-most-{most:g}", f"has a C_L of at most {most:g} under "
              f"{f'the {law} law' if law else 'every law'} of spin", _S,
              _limit_lift(partial(_lift_of, law, most)), True)
      for law in ("", "linear") for most in _MOST),
    *(Mistake(f"bilinear-{name}", f"{words} the bilinear lift", _BILINEAR, _strengths(
          partial(_bilinear, change), lambda term: "lift_slope" in term.parameters), True)
      for name, words, change in (
          ("first-line", "has 1.5 S throughout in", lambda lines: (lines[0],) * 2),
          ("second-line", "has 0.09 + 0.6 S throughout in", lambda lines: (lines[1],) * 2),
          ("without-0.09", "leaves the 0.09 out of", lambda lines: (
              lines[0], (lines[0][0], lines[1][1]))))),
    Mistake("lift-of-whole-spin-across", "takes the C_L of the whole spin, gyro spin included, "
            "along ω × u", "S = R ω_T/U with ω_T = |ω × u|/U",
            reading_change(spin_parameter="total").then(
                _terms(_lift_times(lambda flow, p: 1.0 / _active(flow, p))))),
    Mistake("lift-by-whole-spin", "multiplies by the whole spin, gyro spin included, in the "
            "lift's size", "S = R ω_T/U with ω_T = |ω × u|/U",
            _terms(_by_whole_spin, _TOTAL)),
    Mistake("lift-not-along-unit", "divides ω × u by ωU, and not by its length, in the "
            "direction of the lift", _ALONG_CROSS,
            _terms(_lift_times(_active))),
    Mistake("magnus-order", "takes u × ω for ω × u: the lift by spin has the wrong sign",
            _ALONG_CROSS,
            _terms(_lift_times(lambda flow, p: -1.0))),
    Mistake("spin-all-back", "takes the size of the spin for backspin", _DIRECTION,
            _spins(_backspin)),
    Mistake("spin-total", "takes the whole spin, gyro spin included, where the part across the "
            "velocity belongs", "S = R ω_T/U with ω_T = |ω × u|/U",
            reading_change(spin_parameter="total", drag_spin="total")),
    Mistake("spin-parameter-total", "takes the whole spin for the spin parameter of the lift",
            "S = R ω_T/U with ω_T = |ω × u|/U", reading_change(spin_parameter="total")),
    Mistake("drag-spin-total", "takes the whole spin for that which adds to the drag",
            "ω_T = |ω × u|/U", reading_change(drag_spin="total")),
    Mistake("spin-parameter-of-diameter", "takes the diameter for the radius in the spin parameter",
            "S = R ω_T/U", _strengths(_of_diameter, _lifts)),
    Mistake("spin-decay-in-time", "lets the spin decay with time",
            "spin falls by e along spin_decay_length of path through the air",
            reading_change(spin_decay="time")),
    Mistake("spin-decay-at-speed", "takes e^(-t U/L) with the present speed U",
            "spin falls by e along spin_decay_length of path through the air",
            reading_change(spin_decay="nathan")),
    Mistake("ignores-decay-reading", "ignores the reading spin_decay",
            "take reading.spin_decay from the scene", reading_change(spin_decay="path")),
    Mistake("spin-decay-squared", "lets the spin fall as e^(-2s/L) of the path s",
            "spin falls by e along spin_decay_length of path through the air",
            reading_change(spin_decay="path").then(scene_change(
                lambda scene: {"air.spin_decay_length": scene.air.spin_decay_length / 2}))),
    Mistake("no-spin-decay", "lets the spin stay as it is at the launch",
            "spin falls by e along spin_decay_length of path through the air",
            scene_change(lambda scene: {"air.spin_decay_length": None})),
    Mistake("no-spin-decay-in-drag", "takes the spin at launch in the drag, undecayed",
            "drag and lift are by the present spin", _undecayed(Drag, "rate")),
    Mistake("no-spin-decay-in-lift", "takes the spin at launch in the lift, undecayed",
            "drag and lift are by the present spin", _undecayed(Lift, "factor")),
    Mistake("spin-decay-over-ground", "lets the spin decay along the path over the ground",
            "spin falls by e along spin_decay_length of path through the air",
            _replaced(DECAY_ALONG_PATH, replace(
                DECAY_ALONG_PATH, rate=lambda motion, p: size(motion.velocity)))),
    Mistake("spin-decay-level", "lets the spin decay along the horizontal part of the path",
            "spin falls by e along spin_decay_length of path through the air",
            _replaced(DECAY_ALONG_PATH, replace(
                DECAY_ALONG_PATH, rate=lambda motion, p: _of_two(*motion.air.velocity[:2])))),
    Mistake("wind-sign", "takes the wind for where it blows from", "wind is where it blows to",
            _winds(_arranged("-x -y -z"))),
    Mistake("wind-side-sign", "has the wind's y the other way round", "+y is left of the catcher",
            _winds(_arranged("x -y z"))),
    Mistake("wind-exchanged", "exchanges x and y of the wind", "wind is [x, y, z], +x outwards",
            _winds(_arranged("y x z"))),
    Mistake("wind-ignored", "flies without the wind", _WIND,
            scene_change(lambda scene: {"air.wind": None})),
    Mistake("wind-level", "leaves the wind's vertical part out", _WIND,
            _winds(_arranged("x y 0"))),
    Mistake("wind-not-in-lift", "leaves the wind out of the lift", _WIND,
            reading_change(wind_acts_on="drag")),
    Mistake("wind-not-in-lift-by-spin", "leaves the wind out of the lift of balls with spin",
            _WIND, Change(_wind_not_in_lift_by_spin)),
    Mistake("wind-in-size-only", "drags by the airspeed, but along the velocity over the ground",
            _WIND, _terms(_forms(_drags, lambda f: Force(f.parameters, f.strengths, lambda m, p: (
                scaled(-(m.density * f.rate(m, p)), m.velocity)))))),
    Mistake("wind-in-direction-only", "drags along the velocity through the air, but by the speed "
            "over the ground", _WIND,
            _terms(_forms(_drags, _ground_speed))),
    Mistake("speed-over-ground", "takes the speed over the ground for U in k C_D U u, and the "
            "airspeed in C_D", _WIND,
            _terms(_forms(_drags, lambda form: _multiplied(
                form, lambda m, p: size(m.velocity) / m.speed)))),
    Mistake("crisis-over-ground", "takes the speed over the ground for U in the drag crisis",
            "C_D = a + (b - a)/(1 + e^((U - U_c)/δ)), with the airspeed U",
            _replaced(CRISIS, replace(CRISIS, rate=lambda m, p: _ground_speed(CRISIS).rate(m, p) * (
                m.speed / size(m.velocity))))),
    Mistake("wind-everywhere", "has the same wind at all heights",
            "a wind with `above` blows above that height, one with `height` grows with ln z",
            scene_change(lambda scene: {"air.wind": scene.air.wind.velocity})),
    *(Mistake(f"wind-above-{name}", f"counts the height of a wind with `above` {sentence}",
              "the wind blows above the plane z = `above`", scene_change(
                  lambda s, level=level: {"air.wind.above": s.air.wind.above + level(s)}), True)  # type: ignore[misc]
      for name, sentence, level in _LEVELS),
    Mistake("wind-below", "has a wind with `above` blow below that height, and not above it",
            "the wind blows above the plane z = `above`", _strengths(
                lambda given, *of: (found := given(*of)) and Branches(
                    found.levels, found.strengths[::-1]),
                lambda term: "above_s" in term.parameters), True),
    Mistake("wind-profile-without-offset", "lets the wind grow as ln(z/z_0)/ln(h/z_0)",
            _PROFILE, _profile(lambda z, p: trace.log(_larger(z, p.roughness) / p.roughness)
                               / trace.log(p.wind_height / p.roughness)), True),
    Mistake("wind-profile-capped", "has the same wind at all heights above that of the profile",
            _PROFILE, _profile(lambda z, p: trace.log(1.0 - _larger(-z, -p.wind_height)
                                                      / p.roughness)
                               / trace.log(1.0 + p.wind_height / p.roughness)), True),
    Mistake("wind-profile-denominator", "divides by ln(h/z_0) in the wind's profile", _PROFILE,
            _profile(lambda z, p: trace.log(1.0 + z / p.roughness)
                     / trace.log(p.wind_height / p.roughness))),
    Mistake("wind-profile-linear", "lets the wind grow as z/h, up to h", _PROFILE,
            _profile(lambda z, p: trace.exp(trace.log(_larger(
                -_larger(-z, -p.wind_height), trace.ZERO) / p.wind_height))), True),
    Mistake("wind-profile-from-launch", "counts the height of a wind with `roughness` from the "
            "launch", _PROFILE, _profile(lambda z, p: trace.log(
                1.0 + _larger(z - p.start_height, trace.ZERO) / p.roughness)
                / trace.log(1.0 + p.wind_height / p.roughness)), True),
    Mistake("wind-profile-power", "lets the wind grow as (z/h)^(1/7)", _PROFILE,
            _profile(lambda z, p: trace.exp(
                trace.log(_larger(z, trace.ZERO) / p.wind_height) / 7.0)), True),
    Mistake("celsius-for-kelvin", "takes the temperature for °C: adds 273.15 once more", _WEATHER,
            _density(lambda s, w: _of_weather(s, temperature=w.temperature + ZERO_CELSIUS))),
    Mistake("celsius-in-gas-law", "divides by the temperature in °C", _WEATHER,
            _density(lambda s, w: (
                _of_weather(s) * (w.temperature / (w.temperature - ZERO_CELSIUS))))),
    Mistake("kelvin-in-vapour", "takes the vapour pressure at the temperature in K", _WEATHER,
            _vapour_warmer(ZERO_CELSIUS)),
    *(Mistake(f"vapour-zero-at-{zero:g}", f"takes {zero:g} K for 0 °C in the vapour pressure",
              _WEATHER, _vapour_warmer(ZERO_CELSIUS - zero)) for zero in (273.0, 273.16)),
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
            reading_change(pressure="sea_level")),
    Mistake("vapour-lowered", "lowers the vapour's pressure by the elevation, as the air's",
            _WEATHER, _density(lambda s, w: (
                _of_weather(s, elevation=0.0) * (station_pressure(s, DOUBLES) / w.pressure)))),
    Mistake("zero-at-273", "takes 273 K for 0 °C", _WEATHER,
            _density(lambda s, w: _of_weather(s) * (
                273.0 / (w.temperature - ZERO_CELSIUS + 273.0) * w.temperature / ZERO_CELSIUS))),
    Mistake("weather-ignored", "has air of 1.2929 kg/m³, whatever the weather", _WEATHER,
            _density(lambda s, w: DRY_DENSITY)),
    *(Mistake(f"vapour-of-{name.split()[0].lower()}-{start:g}-{a:g}",
              f"takes the vapour pressure by another formula, {start:g} Pa e^({a:g} t/({b:g} + t)) "
              f"({name})", _WEATHER,
              _with_vapour(lambda t, p=start, a=a, b=b: p * math.exp(a * t / (b + t))))  # type: ignore[misc]
      for name, starts, a, b in _VAPOURS for start in starts),
    Mistake("barometric-formula", "takes the barometric formula of the standard atmosphere, "
            "p (1 - 2.25577e-5 h)^5.25588, for the park's pressure", _WEATHER,
            _density(lambda s, w: _of_weather(s) if s.reading.pressure == "station" else
                     _of_weather(s, elevation=0.0, pressure=w.pressure * (
                         1 - 2.25577e-5 * w.elevation) ** 5.25588))),
    Mistake("ideal-gas", "takes an ideal gas with 287.058 J/(kg K), and 461.495 for the vapour",
            _WEATHER, _density(_gas)),
    *(Mistake(f"density-falls-from-{name}", f"counts the height in e^(-z/H) {sentence}", _ALOFT,
              _denser(lambda scene, scale, level=level: math.exp(level(scene) / scale)))  # type: ignore[misc]
      for name, sentence, level in _LEVELS),
    Mistake("density-of-launch-height", "has the density of the launch's height at all heights",
            _ALOFT, _denser(lambda scene, scale: math.exp(-_LEVELS[0][2](scene) / scale), None)),
    Mistake("density-falls-linearly", "lets the density fall as 1 - z/H", _ALOFT,
            _replaced(THINNING, replace(
                THINNING, density=lambda position, p: 1.0 - p.thinning * position[2]))),
    Mistake("sound-linear", "takes 331.3 + 0.606 t for the speed of sound", _SOUND,
            _sound(lambda t: 331.3 + 0.606 * (t - ZERO_CELSIUS))),
    Mistake("sound-of-gas", "takes √(1.4 · 287 T) for the speed of sound", _SOUND,
            _sound(lambda t: math.sqrt(1.4 * 287.0 * t))),
    *(Mistake(f"sound-{speed:g}", f"has a speed of sound of {speed:g} m/s, whatever the weather",
              _SOUND, _sound(lambda t, speed=speed: speed)) for speed in (340.0, 343.0, 340.29)),  # type: ignore[misc]
    Mistake("coefficients-at-launch", "takes drag and lift coefficients of the speed at launch all "
            "the time", "C_D and C_L follow the present speed through the air",
            scene_change(_at_launch)),
    Mistake("density-the-same-aloft", "has the same density at all heights",
            "the density falls by e in density_scale_height",
            scene_change(lambda scene: {"air.density_scale_height": None})),
    *(Mistake(f"{way}-the-same-aloft", f"has the density of z = 0 at all heights in the {way}",
              "the density falls by e in density_scale_height, for drag and lift alike",
              _terms(_forms(which, lambda form: _multiplied(form, lambda m, p: 1.0 / m.density))))
      for way, which in (("drag", _drags), ("lift", _lifting))),
    Mistake("no-earth", "leaves the Earth's rotation out", "add -2 Ω × v",
            scene_change(lambda scene: {"earth": None})),
    Mistake("earth-sign", "turns the Earth the other way round", _EARTH,
            _coriolis(lambda a: scaled(-1.0, a))),
    Mistake("earth-once", "takes Ω × v where 2 Ω × v belongs", _EARTH,
            _coriolis(lambda a: scaled(0.5, a))),
    Mistake("earth-by-airspeed", "takes the velocity through the air in -2 Ω × v", _EARTH,
            _instead(CORIOLIS, lambda m, p: CORIOLIS.acceleration(
                m._replace(velocity=m.air.velocity), p))),
    Mistake("centrifugal", "adds the centrifugal acceleration, which gravity holds already",
            "the scene's gravity is that at the place: add -2 Ω × v alone",
            _instead(CORIOLIS, _turning)),
    Mistake("earth-vertical-only", "takes the vertical part of -2 Ω × v alone", _EARTH,
            _coriolis(lambda a: (trace.ZERO, trace.ZERO, a[2]))),
    Mistake("earth-level-only", "leaves the vertical part of -2 Ω × v out", _EARTH,
            _coriolis(lambda a: (a[0], a[1], trace.ZERO))),
    Mistake("earth-without-upward-axis", "leaves the vertical part of Ω out", _EARTH,
            _turning_without("earth_z")),
    Mistake("earth-without-level-axis", "leaves the horizontal part of Ω out", _EARTH,
            _turning_without("earth_s", "earth_y")),
    Mistake("colatitude", "counts the latitude from the pole", _EARTH,
            _earth("latitude", lambda angle: math.pi / 2 - angle)),
    *(Mistake(f"azimuth{turn:+d}", f"{words} degrees in the azimuth", _AZIMUTH,
              _earth("azimuth", lambda angle, turn=turn: angle + math.radians(turn)))  # type: ignore[misc]
      for turn, words in ((90, "has 90 more"), (-90, "has 90 fewer"), (180, "has 180 more"))),
    *(Mistake(f"azimuth-{name}", f"counts the azimuth {words}", _AZIMUTH,
              _earth("azimuth", change))
      for name, words, change in (
          ("from-east", "from the east, counterclockwise", lambda angle: math.pi / 2 - angle),
          ("sign", "the other way round", operator.neg))),
    Mistake("latitude-sign", "takes southern latitudes for northern ones", _EARTH,
            _earth("latitude", abs)),
    *(Mistake(f"{key}-in-degrees", f"takes the {key} for degrees", f"earth.{key} is in radians",
              _earth(key, math.radians)) for key in ("latitude", "azimuth")),
    Mistake("latitude-reversed", "takes northern latitudes for southern ones, and the other way "
            "round", _EARTH, _earth("latitude", operator.neg)),
    Mistake("earth-in-degrees", "takes latitude and azimuth for degrees",
            "the angles of `earth` are in radians",
            _earth("latitude", math.radians).then(_earth("azimuth", math.radians))),
    Mistake("azimuth-ignored", "takes +x for north", _AZIMUTH,
            _earth("azimuth", lambda angle: 0.0)),
    *(Mistake(f"{law}-defaults", f"takes the defaults of the {law} law of {place}, whatever the "
              "scene says", _SCENE, scene_change(partial(_with_defaults, place, law)))
      for place, law in (("air.drag_coefficient", "crisis"), ("air.lift_coefficient", "rational"),
                         ("air.lift_coefficient", "linear"))),
    *(Mistake(f"table-{name}", f"takes a table's value at the {words}", _LINEAR,
              _stepped(jumps), True)
      for name, words, jumps in (
          ("in-steps", "node below", lambda nodes: nodes[1:]),
          ("of-next", "node above", lambda nodes: nodes[:-1]),
          ("of-nearest", "nearest node", lambda nodes: [(a + b) / 2 for a, b in pairwise(nodes)]))),
    *(Mistake(f"table-extrapolated{name}", f"goes on along the {words} a table", _LINEAR,
              _tables(partial(_extrapolated, below=name != "-above", above=name != "-below")))
      for name, words in (("", "first and last line outside"), ("-below", "first line below"),
                          ("-above", "last line above"))),
    Mistake("table-reversed", "takes the values of a table in the reverse order", _LINEAR,
            _tables(lambda at, values, scene: (at, values[::-1]))),
    Mistake("table-even", "takes the nodes of a table for evenly spaced", _LINEAR,
            _tables(lambda at, values, scene: (
                np.linspace(at[0], at[-1], len(at)).tolist(), values))),
    *(Mistake(f"table-in-{unit}", f"takes a table of the airspeed for one in {unit}",
              "the nodes of a table of the airspeed are in m/s", _tables(
                  lambda at, values, scene, f=factor: ([x * f for x in at], values), "speed"))
      for unit, factor in _SPEEDS),
    *(Mistake(f"crisis-in-{unit}", f"compares the speed in {unit} with the numbers of the "
              "drag crisis",
              "they are in m/s", scene_change(lambda scene, f=factor: {  # type: ignore[misc]
                  f"air.drag_coefficient.{key}": at(scene, f"air.drag_coefficient.{key}") * f
                  for key in ("speed", "width")})) for unit, factor in _SPEEDS),
    Mistake("crisis-without-width", "leaves the width out of the drag crisis: e^(U - U_c)",
            "C_D = a + (b - a)/(1 + e^((U - U_c)/δ))",
            scene_change(lambda scene: {"air.drag_coefficient.width": 1.0})),
    *_exchanged(),
)  # fmt: skip

_MOST_DECIMALS = 6  # the most decimals that a scene's numbers may be rounded to, where that shows

ROUNDED = tuple(
    Mistake(f"rounded:{place}:{decimals}",
            f"rounds {place} to {many(decimals, 'decimal')}",
            "take the numbers of the scene as they are",
            scene_change(lambda scene, place=place, decimals=decimals: {  # type: ignore[misc]
                place: tuple(round(x, decimals) for x in at(scene, place))}))
    for place in ("launch.velocity", "launch.position")
    for decimals in range(_MOST_DECIMALS + 1)
)  # fmt: skip


def _single(value: Any) -> Any:
    """Return a number or a vector in single precision."""
    return tuple(map(_single, value)) if isinstance(value, tuple) else float(np.float32(value))


def _to_digits(count: int, x: float) -> float:
    return float(f"{x:.{count}g}")


def _to_half(x: float) -> float:
    with np.errstate(over="ignore"):  # 65504 is the largest
        return float(np.float16(x))


def _with_single_strength(scene: Any) -> Any:
    """Return a scene with the density of a k = ρ A/(2 m) in single precision."""
    if getattr(scene, "air", None) is None:
        return scene
    dense, ball = float(density(scene, DOUBLES)), scene.ball
    k = dense * math.pi * ball.radius**2 / (2 * ball.mass)
    return with_density(scene, dense * _single(k) / k) if k else scene


_DOUBLES = "use doubles throughout"

# What a program may hold in single precision that is in doubles otherwise.
SINGLES = (
    Mistake("single:scene", "takes the scene's numbers in single precision", _DOUBLES,
            scene_change(lambda scene: {n: _single(float(x)) for n, x in numbers(scene)})),
    Mistake("single:k", "has k = ρ A/(2 m) in single precision", _DOUBLES,
            Change(_with_single_strength)),
    *(Mistake(f"read-to:{name}", f"reads the scene's numbers to {name} only", _DOUBLES,
              scene_change(lambda scene, short=short: {  # type: ignore[misc]
                  n: short(float(x)) for n, x in numbers(scene)}))
      for name, short in (
          *((many(n, "decimal"), partial(round, ndigits=n)) for n in range(1, 7)),
          *((f"{n} digits", partial(_to_digits, n)) for n in range(2, 8)),
          ("half precision", _to_half))),
    *(Mistake(f"single:{place}", f"takes {place} in single precision", _DOUBLES,
              scene_change(lambda scene, place=place: {place: _single(at(scene, place))}))  # type: ignore[misc]
      for place in ("gravity", "launch.velocity", "launch.position", "air.density", "ball.mass",
                    "ball.radius")),
)  # fmt: skip

LAW = (*_PAPERS_LAW, *EXTENDED, *ROUNDED)


# --- numbers of the law ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Own:
    """A number that the law has, and no scene: the 2 of V²."""

    words: str  # what it is
    usual: float  # what it is in longball
    # The chain with the number that a scene carries under the name, along with its own.
    change: Change


def _to_power(flow: Flow, more: Any) -> Any:
    """Return the speed to a power."""
    return trace.exp(more * trace.log(flow.speed * flow.speed + SMALL * SMALL) * 0.5)


def _own(
    words: str, name: str, usual: float, which: Callable[[Term], bool],
    factor: Callable[[Motion, Any], Any], carried: Callable[[str], Term] | None = None
) -> Own:  # fmt: skip
    """Return a number that a factor of terms hangs on: of the motion and the number."""
    # It is a parameter of a term that does nothing else; 0 on no branch yet.
    constant = Term((name,), lambda scene, frame, numbers: (getattr(scene, name, usual),))
    change = _forms(which, lambda form: _multiplied(
        form, lambda m, p: factor(m, getattr(p, name, trace.ZERO))))  # fmt: skip
    return Own(words, usual, _terms(change, carried(name) if carried else constant))


def _while_rising(rises: bool) -> Callable[[str], Term]:
    """Return the term that carries a number while the ball rises, or falls, and 1 otherwise."""

    def carried(name: str) -> Term:
        def branches(scene: Any, frame: Any, numbers: Any) -> Branches:
            number = (getattr(scene, name, 1.0),)
            return Branches((0.0,), ((1.0,), number) if rises else (number, (1.0,)))

        return Piecewise(
            (name,), switched, Term((name,), switched), branches,
            lambda motion, p: (motion.velocity[2], 1.0), "the ball is at its highest point",
        )  # fmt: skip

    return carried


OWN: dict[str, Own] = {
    "drag_exponent": _own("the exponent of V in the drag", "drag_exponent", 2.0, _drags,
                          lambda m, n: _to_power(m.air, n - 2.0)),
    "lift_exponent": _own("the exponent of V in the lift", "lift_exponent", 2.0, _lifting,
                          lambda m, n: _to_power(m.lift, n - 2.0)),
    **{
        f"{way}_{how}": _own(f"the share of the {way} on a {how} ball", f"{way}_{how}", 1.0, which,
                             lambda m, n: n, _while_rising(how == "rising"))
        for way, which in (("drag", _drags), ("lift", _lifting)) for how in ("rising", "falling")
    },
    "rotation": _own("the Earth's rotation in rad/s", "rotation", ROTATION,
                     lambda term: term is CORIOLIS, lambda m, n: n / ROTATION),
    "sound": Own("the share of the speed of sound", 1.0, _tables(lambda nodes, values, scene: (
        [x * getattr(scene, "sound", 1.0) for x in nodes], values), "mach")),
}  # fmt: skip
SPIN = tuple(mistake for mistake in EXTENDED if mistake.name.startswith("spin-"))
