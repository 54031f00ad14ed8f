"""Known mistakes in the law of motion, and numbers that a candidate's law may have of its own.

What is wrong with a scene's numbers follows from the scene (`misreadings`); here are changes of the
terms that they go into.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

from longball.engines.chain import Model
from longball.judge.changes import Mistake, scene_change
from longball.judge.misreadings import of_weather, with_density
from longball.judge.stages import Change
from longball.model import trace
from longball.model.aerodynamics import DECAY_ALONG_PATH, DRAG, LIFT, spin_across
from longball.model.air import Air, Table, Weather
from longball.model.atmosphere import ZERO_CELSIUS, density
from longball.model.earth import CORIOLIS, ROTATION
from longball.model.force import (
    Drag,
    Flow,
    Force,
    Lift,
    Motion,
    Piecewise,
    Term,
    cross,
    plus,
    scaled,
    size,
)
from longball.model.law import GRAVITY
from longball.model.numbers import DOUBLES, Vector
from longball.model.quantities import at

Which = Callable[[Term], bool]

# --- changes of terms -----------------------------------------------------------------------------


def changed_terms(change: Callable[[Any], Any], *carried: Term) -> Change:
    """Return the change of each term that may act on a ball in flight; None leaves it out."""
    # `carried` are terms behind them, whose parameters those changed may use.
    changed = cache(change)  # the same terms each time, so that their law is traced once

    def model(held: Model) -> Model:
        forces = (new for f in held.forces if (new := changed(f)) is not None)
        return replace(held, forces=(*forces, *carried))

    return Change(model=model)


def of_kind(which: Which, change: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Return the change of terms of a kind to another form, on each branch if they have some."""

    def changed(term: Any) -> Any:
        if isinstance(term, Piecewise):
            new = change(term.term) if which(term.term) else term.term
            return new and (term if new is term.term else replace(term, term=new))
        return change(term) if which(term) else term

    return changed


def drags(term: Term) -> bool:
    """Tell whether a term is a drag."""
    return isinstance(term, Drag)


def lifts(term: Term) -> bool:
    """Tell whether a term is a lift, by spin or about a fixed axis."""
    forced = isinstance(term, Force) and any("lift" in name for name in term.parameters)
    return forced or isinstance(term, Lift)


# The kinds of terms: what they are called, and which they are.
_KINDS: dict[str, Which] = {
    "drag": drags,
    "lift": lifts,
    "gravity": lambda term: term is GRAVITY,
    "Coriolis force": lambda term: term is CORIOLIS,
}


def multiplied(form: Any, factor: Callable[[Motion, Any], Any]) -> Any:
    """Return a drag, a lift or another force times a factor, of the motion and the parameters."""
    match form:
        case Drag():
            return replace(form, rate=lambda m, p: form.rate(m, p) * factor(m, p))
        case Lift():
            return replace(form, factor=lambda m, p: form.factor(m, p) * factor(m, p))
    return replace(form, acceleration=lambda m, p: scaled(factor(m, p), form.acceleration(m, p)))


def _acceleration(form: Any, motion: Motion, p: Any) -> Vector[Any]:
    """Return what a drag, a lift or another force does."""
    match form:
        case Drag():
            return scaled(-(motion.density * form.rate(motion, p)), motion.air.velocity)
        case Lift():
            return scaled(motion.density * form.factor(motion, p), spin_across(motion.lift, p))
    return form.acceleration(motion, p)  # type: ignore[no-any-return]


def _at_launch(scene: Any, frame: Any, numbers: Any) -> tuple[Any, ...]:
    """Return the axes of a frame, and the velocity at launch, m/s: along, up, size."""
    if scene.kind != "flight":
        return frame.cos, frame.sin, None, None, None
    x, y, z = scene.launch.velocity
    return frame.cos, frame.sin, math.hypot(x, y), z, math.hypot(x, y, z)


# What a law of the paper does not know of a flight.
_BEGUN = Term(("cos", "sin", "launch_u", "launch_w", "launch_speed"), _at_launch)


def _in_space(flow: Flow, p: Any) -> Vector[Any]:
    """Return the velocity in the axes of the scene."""
    (u, v, w), cos, sin = flow.velocity, p.cos, p.sin
    return cos * u - sin * v, sin * u + cos * v, w


def _in_frame(vector: Vector[Any], p: Any) -> Vector[Any]:
    x, y, z = vector
    return p.cos * x + p.sin * y, p.cos * y - p.sin * x, z


def _by_axis(which: Which, factors: Sequence[float]) -> Change:
    """Return the change of terms by a factor for each axis of the scene."""

    def changed(form: Any) -> Force:
        def acceleration(motion: Motion, p: Any) -> Vector[Any]:
            x, y, z = _in_space(Flow(_acceleration(form, motion, p), None), p)
            return _in_frame((factors[0] * x, factors[1] * y, factors[2] * z), p)

        return Force(form.parameters, form.strengths, acceleration)

    return changed_terms(of_kind(which, changed), _BEGUN)


def _instead(term: Term, acceleration: Callable[[Motion, Any], Vector[Any]]) -> Change:
    """Return the change of one term into a force with that acceleration."""
    new = Force(term.parameters, term.strengths, acceleration)
    return changed_terms(lambda f: new if f is term else f, _BEGUN)


# m/s. A series in time cannot go through the kink of |c| at c = 0. What stands for it has none, and
# is too large by less than SMALL⁴/(8 |c|³): a flight is off by less than 1e-9 of its length.
SMALL = 1e-3


def _size(x: Any) -> Any:
    """Return |x|, smoothly."""
    return (x * x + SMALL * SMALL / 2) / trace.sqrt(x * x + SMALL * SMALL)


def _of_two(x: Any, y: Any) -> Any:
    return trace.sqrt(x * x + y * y)


# --- what is taken for the speed ------------------------------------------------------------------

# For V in drag and lift: what it is called, and from the motion, the flow and the parameters.
_SPEEDS: tuple[tuple[str, Callable[[Motion, Flow, Any], Any]], ...] = (
    ("the speed at launch", lambda m, flow, p: p.launch_speed),
    ("the horizontal speed", lambda m, flow, p: _of_two(*flow.velocity[:2])),
    ("the speed without v_y", lambda m, flow, p: _of_two(*_in_space(flow, p)[::2])),
    ("the sum of the components' sizes",
     lambda m, flow, p: trace.total(map(_size, _in_space(flow, p)))),
    ("the speed over the ground", lambda m, flow, p: size(m.velocity)),
)  # fmt: skip


def _by_speed(which: Which, speed: Callable[[Motion, Flow, Any], Any]) -> Callable[[Any], Any]:
    def factor(motion: Motion, p: Any, flow: Flow) -> Any:
        return speed(motion, flow, p) / flow.speed

    return of_kind(which, lambda form: multiplied(
        form, lambda m, p: factor(m, p, m.air if drags(form) else m.lift)))  # fmt: skip


def _other_speeds() -> Iterator[Mistake]:
    for words, speed in _SPEEDS:
        drag, lift = (_by_speed(which, speed) for which in (drags, lifts))
        for where, change in (
            ("the drag", drag), ("the lift", lift),
            ("drag and lift", lambda term, d=drag, i=lift: i(d(term))),
        ):  # fmt: skip
            name = f"{where}-by-{words}".replace("the ", "").replace(" ", "-")
            yield Mistake(name, f"takes {words} for V in {where}", "V is the whole present speed "
                          "through the air", changed_terms(change, _BEGUN))  # fmt: skip


# --- the terms ------------------------------------------------------------------------------------

# What is done to the components of a force in the axes of the scene.
_AXES: tuple[tuple[str, str, tuple[float, float, float]], ...] = (
    ("without-x", "leaves the {} along x out", (0, 1, 1)),
    ("without-y", "leaves the {} along y out", (1, 0, 1)),
    ("level-part", "has the horizontal part of the {}, and not the vertical one", (1, 1, 0)),
    ("vertical-part", "has the vertical part of the {}, and not the horizontal one", (0, 0, 1)),
    ("y-sign", "turns the {} along y the wrong way", (1, -1, 1)),
    ("vertical-sign", "turns the {} along z the wrong way", (1, 1, -1)),
    ("level-sign", "turns the horizontal part of the {} the wrong way", (-1, -1, 1)),
)


def _rising(motion: Motion, p: Any) -> Any:
    """Return 1 for a ball on its way up and 0 on its way down, smoothly."""
    w = motion.velocity[2]
    return (1.0 + w / trace.sqrt(w * w + SMALL * SMALL)) * 0.5


# What drag and lift may be multiplied by.
_FACTORS: tuple[tuple[str, str, Callable[[Motion, Any], Any]], ...] = (
    ("with-v", "lets the {} grow linearly with V, not with V²", lambda m, p: 1.0 / m.speed),
    ("with-v-cubed", "lets the {} grow with V³", lambda m, p: m.speed),
    (
        "the-same-aloft",
        "has the density of z = 0 at all heights in the {}",
        lambda m, p: 1.0 / m.density,
    ),
    ("rising-only", "has the {} act on the ball's way up only", _rising),
)

_FORCES = {
    "drag": "the drag is -k V v: against the velocity, in every component",
    "lift": "the lift is k_L V (ê × v), which is k_L V (-w, u) in the flight plane; with spin it "
    "is along ω × u",
    "gravity": "gravity is -g along z",
    "Coriolis force": "add -2 Ω × v, Ω = 7.292115e-5 rad/s (cos λ north + sin λ up)",
}


def _of_forces() -> Iterator[Mistake]:
    """Yield what may be wrong with any of the forces."""
    for kind, remedy in _FORCES.items():
        which, slug = _KINDS[kind], kind.partition(" ")[0].lower()
        article = "the " * (" " in kind)
        yield Mistake(f"no-{slug}", f"flies without {article}{kind}", remedy,
                      changed_terms(of_kind(which, lambda form: None)))  # fmt: skip
        turned = of_kind(which, lambda form: multiplied(form, lambda m, p: -1.0))
        sentence = f"turns the {kind} the wrong way round: the sign"
        yield Mistake(f"{slug}-sign", sentence, remedy, changed_terms(turned))
        for name, words, factors in _AXES if kind != "gravity" else ():
            yield Mistake(f"{slug}-{name}", words.format(kind), remedy, _by_axis(which, factors))
    for kind in ("drag", "lift"):
        place, remedy = f"air.{kind}_coefficient", f"the {kind} is ½ C ρ A V², all the way"
        for name, words, factor in _FACTORS:
            change = changed_terms(of_kind(_KINDS[kind], partial(multiplied, factor=factor)))
            scaled_by = place if name == "with-v" else None
            yield Mistake(f"{kind}-{name}", words.format(kind), remedy, change,
                          name == "rising-only", scaled_by)  # fmt: skip


def _squared(square: Callable[[Any], Any]) -> Change:
    """Return the change of the drag to ``-k square(c)`` for each component c in space."""

    def acceleration(m: Motion, p: Any) -> Vector[Any]:
        x, y, z = map(square, _in_space(m.air, p))
        return scaled(-(m.density * p.drag), _in_frame((x, y, z), p))

    return _instead(DRAG, acceleration)


def _lift(direction: Callable[[Flow, Any], Vector[Any]]) -> Change:
    """Return the change of the lift of a ball without spin to k_L times a vector."""
    return _instead(LIFT, lambda m, p: scaled(m.density * p.lift, direction(m.lift, p)))


def _about(axis: Callable[[Any, Any], Vector[Any]]) -> Change:
    """Return the change of the lift to one about an axis in space, from the scene and the frame.

    Where the lift is always up, its axis turns with the ball, and stays.
    """

    def strengths(scene: Any, frame: Any, numbers: Any) -> tuple[Any, ...] | None:
        found = LIFT.strengths(scene, frame, numbers)
        if not found or scene.reading.lift_direction == "always_up":
            return None
        return (*found, *frame.turned(plus(axis(scene, frame), (-frame.sin, frame.cos, 0.0))))

    def acceleration(m: Motion, p: Any) -> Vector[Any]:
        """Return what the lift about the difference of the two axes does."""
        across = cross((p.axis_s, p.axis_y, p.axis_z), m.lift.velocity)
        return scaled(m.density * p.lift_about_axis * m.lift.speed, across)

    names = ("lift_about_axis", "axis_s", "axis_y", "axis_z")
    return changed_terms(lambda term: term, Force(names, strengths, acceleration))


def _axis_of_pitch(scene: Any, frame: Any) -> Vector[Any]:
    """Return the axis of the lift: of a batted ball that of its pitch."""
    batted = scene.kind == "at-bat" and (frame.x, frame.y) != tuple(scene.pitch.release[:2])
    if not batted:
        return frame.sin, -frame.cos, 0.0
    x, y, _ = scene.pitch.thrown
    across = math.hypot(x, y) or 1.0
    return y / across, -x / across, 0.0


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


def _through(front: float) -> Change:
    """Return the change of the aim to where the throw is to go if it is to x = `front`, m."""

    def values(scene: Any) -> Mapping[str, Any]:
        x, *beside = scene.pitch.release
        pairs = zip(scene.pitch.aim, beside, strict=True)
        return {"pitch.aim": tuple(b + (a - b) * x / (x - front) for a, b in pairs)}

    return scene_change(values)


def _faster(count: int) -> Change:
    """Return the change of the pitch's speed to one of the first components of the velocity."""
    return scene_change(lambda scene: {"pitch.speed": scene.pitch.speed * math.hypot(
        *scene.pitch.way) / math.hypot(*scene.pitch.way[:count])})  # fmt: skip


def _turned(key: str, angle: Callable[[float], float]) -> Change:
    """Return the change of an angle of the Earth's rotation."""
    return scene_change(lambda scene: {f"earth.{key}": angle(getattr(scene.earth, key))})


# --- the weather ----------------------------------------------------------------------------------


def _density(formula: Callable[[Any, Weather], float]) -> Change:
    """Return the change of the density to that of a formula of the scene and its weather."""

    def change(scene: Any) -> Any:
        weather = getattr(getattr(scene, "air", None), "density", None)
        if not isinstance(weather, Weather):
            return scene
        return with_density(scene, formula(scene, weather))

    return Change(change)


def _vapour_in_kelvin(scene: Any, weather: Weather) -> float:
    """Return the density with the vapour's pressure at t = T."""
    t, hot = weather.temperature, weather.temperature + ZERO_CELSIUS
    dry = [of_weather(scene, humidity=0.0, temperature=x) for x in (t, hot)]
    return dry[0] - (dry[1] - of_weather(scene, temperature=hot)) * hot / t


_WEATHER = (
    "ρ = 1.2929 (273.15/T)(p e^(-βh) - 0.3783 φ p_s)/101325, T in K, φ from 0 to 1, "
    "p_s of T - 273.15 in °C"
)
_NO_MORE = "weight, drag and lift are all the forces that there are"
_SCENE = "take the numbers of the scene"
_HEADING = "the axis ê is horizontal and across the heading at launch: (sin φ, -cos φ, 0)"
_RELEASED = "pitch.speed is the size of the velocity at the release"

LAW: tuple[Mistake, ...] = (
    *_of_forces(),
    *_other_speeds(),
    Mistake("no-lift-of-spin", "flies without the lift of a spin", _FORCES["lift"], changed_terms(
        of_kind(lambda term: isinstance(term, Lift), lambda form: None))),
    Mistake("drag-per-component", "drags each component by itself, with its own square",
            "the drag is -k V v: every component times the whole speed V",
            _squared(lambda c: _size(c) * c)),
    Mistake("drag-per-component-in-plane", "drags the horizontal and the vertical speed each by "
            "itself, with its own square", "the drag is -k V v: each times the whole speed V",
            _instead(DRAG, lambda m, p: scaled(-(m.density * p.drag), (
                *scaled(_of_two(*m.air.velocity[:2]), m.air.velocity)[:2],
                _size(m.air.velocity[2]) * m.air.velocity[2])))),
    Mistake("unsigned-drag-per-component", "drags each component by its own square without a "
            "sign, so that a falling ball is pulled down", _FORCES["drag"],
            _squared(lambda c: c * c)),
    Mistake("drag-always-down", "drags a falling ball down: the vertical drag has no sign",
            _FORCES["drag"], _instead(DRAG, lambda m, p: scaled(
                -(m.density * p.drag * m.speed),
                (*m.air.velocity[:2], _size(m.air.velocity[2]))))),
    Mistake("density-falls", "lets the air grow thinner with height",
            "the scene's density holds at every height",
            scene_change(lambda scene: {"air.density_scale_height": 8500.0})),
    Mistake("air-for-null", "has the usual air where the scene says null",
            "air = null is none: no drag and no lift", Change(lambda scene: (
                scene if getattr(scene, "air", 0) is not None
                else scene.model_copy(update={"air": Air()})))),
    Mistake("gravity-falls", "lets gravity fall with height",
            "gravity is the scene's at every height", _instead(GRAVITY, _falling)),
    Mistake("buoyancy", "lets the air buoy the ball up: g (1 - ρ V/m)", _NO_MORE,
            _displaced(lambda share: {"gravity": 1 - share})),
    Mistake("added-mass", "adds half the mass of the air that the ball displaces to its inertia",
            _NO_MORE, _displaced(lambda share: {
                "gravity": 1 / (1 + share / 2), "ball.mass": 1 + share / 2})),
    Mistake("lift-vertical", "lifts straight up with V², instead of across the velocity",
            _FORCES["lift"],
            _lift(lambda flow, p: (trace.ZERO, trace.ZERO, flow.speed * flow.speed))),
    Mistake("lift-sideways", "lifts the ball sideways", _FORCES["lift"],
            _lift(lambda flow, p: (trace.ZERO, flow.speed * flow.velocity[0], trace.ZERO))),
    Mistake("lift-as-at-launch", "keeps the direction that the lift has at launch", _FORCES["lift"],
            _lift(lambda flow, p: scaled(flow.speed * flow.speed / p.launch_speed, (
                -p.launch_w, trace.ZERO, p.launch_u)))),
    Mistake("lift-about-minus-y", "lifts about -y, whatever the ball's heading", _HEADING,
            _about(lambda scene, frame: (0.0, -1.0, 0.0))),
    Mistake("lift-axis-sign", "has the lift's axis the other way round where it is fixed, "
            "(-sin φ, cos φ, 0)", _HEADING, _about(lambda scene, frame: (
                -frame.sin, frame.cos, 0.0))),
    Mistake("lift-about-forward-axis", "takes |v_x| for v_x in the heading", _HEADING,
            _about(lambda scene, frame: (frame.sin, -abs(frame.cos), 0.0))),
    Mistake("heading-by-arctangent", "takes the heading for atan(v_y/v_x), which is the opposite "
            "one where v_x < 0", _HEADING, _about(lambda scene, frame: scaled(
                -1.0 if frame.cos < 0 else 1.0, (frame.sin, -frame.cos, 0.0)))),
    Mistake("lift-about-axis-of-pitch", "lifts a batted ball about the axis that the pitch had",
            "the axis ê is fixed at the launch of each flight: at the impact anew",
            _about(_axis_of_pitch)),
    Mistake("wind-in-size-only", "drags by the airspeed, but along the velocity over the ground",
            "the wind is subtracted from the ball's velocity, in drag and lift alike: u = v - W",
            changed_terms(of_kind(drags, lambda f: Force(
                f.parameters, f.strengths,
                lambda m, p: scaled(-(m.density * f.rate(m, p)), m.velocity))))),
    Mistake("spin-decay-over-ground", "lets the spin decay along the path over the ground",
            "spin falls by e along spin_decay_length of path through the air",
            changed_terms(lambda term: replace(term, rate=lambda m, p: size(m.velocity))
                          if term is DECAY_ALONG_PATH else term)),
    Mistake("aim-at-front", "aims at a point above the front of home plate, x = 0.4318 m",
            "the aim is a point of the plane x = 0", _through(0.4318)),
    Mistake("pitch-speed-along-x", "gives the ball pitch.speed along x, and the rest of the way "
            "on top", _RELEASED, _faster(1)),
    Mistake("pitch-speed-level", "gives the ball pitch.speed along the ground, and the rest of the "
            "way on top", _RELEASED, _faster(2)),
    Mistake("aim-from-release", "counts the aim from the point of release",
            "the aim is a point: y and z where the plate is", scene_change(lambda scene: {
                "pitch.aim": tuple(a + b for a, b in zip(
                    scene.pitch.aim, scene.pitch.release[1:], strict=True))})),
    *(Mistake(f"{key}-from-{name}", f"counts the {key} from the {name}",
              f"earth.{key} is in radians, {right}", _turned(key, angle))
      for key, name, right, angle in (
          ("latitude", "pole", "from the equator", lambda x: math.pi / 2 - x),
          ("azimuth", "east", "from north to east", lambda x: x + math.pi / 2),
          ("azimuth", "west", "from north to east", lambda x: x - math.pi / 2),
          ("azimuth", "south", "from north to east", lambda x: x + math.pi))),
    Mistake("azimuth-sign", "counts the azimuth from north to west", "earth.azimuth is in radians, "
            "from north to east", _turned("azimuth", lambda x: -x)),
    Mistake("celsius-for-kelvin", "takes the temperature for °C: adds 273.15 once more", _WEATHER,
            _density(lambda s, w: of_weather(s, temperature=w.temperature + ZERO_CELSIUS))),
    Mistake("celsius-in-gas-law", "divides by the temperature in °C", _WEATHER,
            _density(lambda s, w: of_weather(s) * w.temperature / (w.temperature - ZERO_CELSIUS))),
    Mistake("kelvin-in-vapour", "takes the vapour pressure at the temperature in K", _WEATHER,
            _density(_vapour_in_kelvin)),
)  # fmt: skip


# --- numbers of the law ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Own:
    """A number that the law has, and no scene: the 2 of V²."""

    words: str  # what it is
    usual: float  # what it is in longball
    # The chain with the number that a scene carries under the name, along with its own.
    change: Change


def _own(
    words: str, name: str, usual: float, which: Which, factor: Callable[[Motion, Any], Any]
) -> Own:
    """Return a number that a factor of terms hangs on: of the motion and the number."""
    # It is a parameter of a term that does nothing else; 0 on no branch yet.
    constant = Term((name,), lambda scene, frame, numbers: (getattr(scene, name, usual),))
    change = of_kind(which, lambda form: multiplied(
        form, lambda m, p: factor(m, getattr(p, name, trace.ZERO))))  # fmt: skip
    return Own(words, usual, changed_terms(change, constant))


def _to_power(flow: Flow, more: Any) -> Any:
    """Return the speed to a power."""
    return trace.exp(more * trace.log(flow.speed * flow.speed + SMALL * SMALL) * 0.5)


def _heard(scene: Any) -> Mapping[str, Any]:
    """Return the nodes of tables over the Mach number, with another speed of sound."""
    names = [f"air.{way}_coefficient" for way in ("drag", "lift")]
    tables = {name: at(scene, name) for name in names}
    return {
        f"{name}.at": tuple(x * getattr(scene, "sound", 1.0) for x in table.at)
        for name, table in tables.items() if isinstance(table, Table) and table.of == "mach"
    }  # fmt: skip


OWN: dict[str, Own] = {
    "drag_exponent": _own("the exponent of V in the drag", "drag_exponent", 2.0, drags,
                          lambda m, n: _to_power(m.air, n - 2.0)),
    "lift_exponent": _own("the exponent of V in the lift", "lift_exponent", 2.0, lifts,
                          lambda m, n: _to_power(m.lift, n - 2.0)),
    "rotation": _own("the Earth's rotation in rad/s", "rotation", ROTATION,
                     _KINDS["Coriolis force"], lambda m, n: n / ROTATION),
    "sound": Own("the share of the speed of sound", 1.0, scene_change(_heard)),
}  # fmt: skip
