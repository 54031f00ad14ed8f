"""Known mistakes: what authors of such simulators get wrong, and how to mend it.

A mistake in the law or in the collision is a `Change` of the one chain. A mistake in a formula that
stands by itself is a `Formula`: what the quantity then is, from the scene and the values before it.
Numbers of the scene that are taken for others are not listed here: `longball.judge.fits` finds any.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from longball.engines.chain import Model
from longball.judge.stages import Change, Numbers, with_values
from longball.model import trace
from longball.model.aerodynamics import DRAG, LIFT
from longball.model.bat import moment_of_inertia
from longball.model.force import Drag, Force, Lift, Motion, Piecewise, Term
from longball.model.law import FORCES, GRAVITY
from longball.model.numbers import DOUBLES, Vector
from longball.model.readings import Reading


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
    """

    name: str
    sentence: str
    remedy: str
    change: Change


# --- the law of motion ----------------------------------------------------------------------------


def _instead(term: Term, acceleration: Callable[[Motion, Any], Vector[Any]]) -> Change:
    """Return the change of one term into a force with that acceleration."""
    return _replaced(term, Force(term.parameters, term.strengths, acceleration))


def _replaced(term: Term, changed: Term) -> Change:
    return _flying(tuple(changed if f is term else f for f in FORCES))


def _flying(forces: tuple[Term, ...]) -> Change:
    return Change(model=Model(forces=forces))


def _without(left_out: Callable[[Term], bool]) -> Change:
    """Return the change that leaves terms out."""
    forms = {f: f.term if isinstance(f, Piecewise) else f for f in FORCES}
    return _flying(tuple(f for f in FORCES if not left_out(forms[f])))


def _lifts(term: Term) -> bool:
    return isinstance(term, Lift) or any("lift" in name for name in term.parameters)


# m/s. A series in time cannot go through the kink of |c| at c = 0. What stands for it has none, and
# is too large by less than SMALL⁴/(8 |c|³): a flight is off by less than 1e-9 of its length.
SMALL = 1e-3


def _size(x: Any) -> Any:
    """Return |x|, smoothly."""
    return (x * x + SMALL * SMALL / 2) / trace.sqrt(x * x + SMALL * SMALL)


def _drag_and_axes(scene: Any, frame: Any, numbers: Any) -> tuple[Any, ...] | None:
    """Return the strengths of the drag, and where the axes of the frame point."""
    found = DRAG.strengths(scene, frame, numbers)
    return found and (*found, frame.cos, frame.sin)


def _by_component(square: Callable[[Any], Any]) -> Change:
    """Return the change of the drag to ``-k square(c)`` for each component c in space."""

    def acceleration(motion: Motion, p: Any) -> Vector[Any]:
        (u, v, w), rate = motion.air.velocity, motion.density * p.drag
        x, y, z = (-rate * square(c) for c in (p.cos * u - p.sin * v, p.sin * u + p.cos * v, w))
        return p.cos * x + p.sin * y, p.cos * y - p.sin * x, z

    return _replaced(DRAG, Force(("drag", "cos", "sin"), _drag_and_axes, acceleration))


def _drag(factor: Callable[[Motion, Any], Any]) -> Change:
    """Return the change of the drag to ``-k factor v``."""
    return _replaced(
        DRAG, Drag(DRAG.parameters, DRAG.strengths, lambda m, p: p.drag * factor(m, p))
    )


def _vertical_drag(vertical: Callable[[Any], Any]) -> Change:
    """Return the change of the drag's vertical component to ``-k V vertical(w)``."""

    def acceleration(motion: Motion, p: Any) -> Vector[Any]:
        (u, v, w), rate = motion.air.velocity, motion.density * p.drag * motion.speed
        return -rate * u, -rate * v, -rate * vertical(w)

    return _instead(DRAG, acceleration)


def _lift(direction: Callable[[Any, Any, Any], Vector[Any]]) -> Change:
    """Return the change of the lift to k_L times a function of u, w and V."""

    def acceleration(motion: Motion, p: Any) -> Vector[Any]:
        (u, _, w), speed = motion.lift
        x, y, z = direction(u, w, speed)
        rate = motion.density * p.lift
        return rate * x, rate * y, rate * z

    return _instead(LIFT, acceleration)


def _reading(**switches: str) -> Change:
    def change(scene: Any) -> Any:
        reading = Reading.model_validate(scene.reading.model_dump() | switches)
        return scene.model_copy(update={"reading": reading})

    return Change(change)


LAW: tuple[Mistake, ...] = (
    Mistake(
        "drag-per-component",
        "drags each component by itself, with its own square",
        "the drag is -k V v: every component times the whole speed V",
        _by_component(lambda c: _size(c) * c),
    ),
    Mistake(
        "unsigned-drag-per-component",
        "drags each component by its own square without a sign, so that a falling ball is pulled "
        "down",
        "the drag is -k V v: against the velocity",
        _by_component(lambda c: c * c),
    ),
    Mistake(
        "drag-with-v",
        "lets the drag grow with V, not with V²",
        "the drag is ½ C_D ρ A V², against the velocity",
        _drag(lambda motion, p: 1.0),
    ),
    Mistake(
        "drag-with-v-cubed",
        "lets the drag grow with V³",
        "the drag is ½ C_D ρ A V²: V v holds the square already",
        _drag(lambda motion, p: motion.speed * motion.speed),
    ),
    Mistake(
        "density-falls",
        "lets the air grow thinner with height",
        "the scene's density holds at every height",
        Change(lambda scene: with_values(scene, {"air.density_scale_height": 8500.0})),
    ),
    Mistake(
        "drag-always-down",
        "drags a falling ball down: the vertical drag has no sign",
        "the drag is against the velocity, on the way down too",
        _vertical_drag(_size),
    ),
    Mistake(
        "vertical-drag-sign",
        "drags along the vertical velocity instead of against it",
        "the drag is against the velocity, in every component",
        _vertical_drag(lambda w: -w),
    ),
    Mistake(
        "drag-forward",
        "drags along the velocity instead of against it",
        "the drag is -k V v",
        _drag(lambda motion, p: -motion.speed),
    ),
    Mistake(
        "horizontal-drag-only",
        "drags the horizontal components only",
        "the drag is -k V v in all three",
        _vertical_drag(lambda w: trace.ZERO),
    ),
    Mistake(
        "no-drag",
        "flies without drag",
        "add -k_D V v",
        _without(lambda term: isinstance(term, Drag)),
    ),
    Mistake("no-lift", "flies without lift", "add k_L V (ê × v)", _without(_lifts)),
    Mistake(
        "no-gravity",
        "flies without gravity",
        "add -g to the vertical",
        _without(lambda term: term is GRAVITY),
    ),
    Mistake(
        "gravity-up",
        "falls upwards",
        "gravity is -g along z",
        _instead(GRAVITY, lambda m, p: (trace.ZERO, trace.ZERO, p.gravity)),
    ),
    Mistake(
        "lift-sign",
        "lifts the ball the wrong way",
        "with backspin the lift turns the velocity upwards: k_L V (-w, u) in the flight plane",
        _lift(lambda u, w, speed: (speed * w, trace.ZERO, -speed * u)),
    ),
    Mistake(
        "lift-vertical",
        "lifts straight up with V², instead of across the velocity",
        "the lift is k_L V (ê × v): it is perpendicular to the velocity",
        _lift(lambda u, w, speed: (trace.ZERO, trace.ZERO, speed * speed)),
    ),
    Mistake(
        "lift-vertical-part",
        "has the vertical part of the lift, and not the horizontal one",
        "the lift is k_L V (-w, u) in the flight plane",
        _lift(lambda u, w, speed: (trace.ZERO, trace.ZERO, speed * u)),
    ),
    Mistake(
        "lift-not-across",
        "turns the horizontal part of the lift the wrong way: it is not perpendicular to the "
        "velocity",
        "the lift is k_L V (-w, u) in the flight plane",
        _lift(lambda u, w, speed: (speed * w, trace.ZERO, speed * u)),
    ),
    Mistake(
        "lift-with-v",
        "lets the lift grow with V, not with V²",
        "the lift is ½ C_L ρ A V²",
        _lift(lambda u, w, speed: (-w, trace.ZERO, u)),
    ),
    Mistake(
        "lift-sideways",
        "lifts the ball sideways",
        "the spin axis is horizontal: the lift lies in the vertical plane of the launch",
        _lift(lambda u, w, speed: (trace.ZERO, speed * u, trace.ZERO)),
    ),
    Mistake(
        "lift-always-up",
        "keeps the lift on the upper side of the path, beyond the vertical too",
        "fix the spin axis at launch, or ask for the reading lift_direction = always_up",
        _reading(lift_direction="always_up"),
    ),
    Mistake(
        "ignores-lift-reading",
        "ignores the reading lift_direction",
        "take reading.lift_direction from the scene",
        _reading(lift_direction="fixed_spin_axis"),
    ),
)


# --- the collision --------------------------------------------------------------------------------


class View:
    """A scene, and the values that a formula has before it, by the names of the quantities."""

    def __init__(self, scene: Any, values: Mapping[str, Numbers], before: Numbers, height: float):
        self.scene, self.values, self.before, self.height = scene, values, before, height

    def __getitem__(self, name: str) -> Numbers:
        return self.values[name]

    def number(self, name: str) -> float:
        """Return a quantity that is one number."""
        return self.values[name][0]

    @property
    def position(self) -> Numbers:
        """Of the ball at the contact, m."""
        held = self.values.get("contact.position")
        return held if held is not None else tuple(self.scene.incoming.position)

    @property
    def lever(self) -> float:
        """r̃, m."""
        return float(self.scene.bat.length) / 2 - self.position[1]

    def inertia(self, **switches: str) -> float:
        """Return the bat's moment of inertia, kg m²."""
        reading = Reading.model_validate(self.scene.reading.model_dump() | switches)
        return float(moment_of_inertia(self.scene.bat, reading, DOUBLES))

    @property
    def relative(self) -> Numbers:
        """Ṽ, m/s."""
        bat = self["contact.bat_velocity"]
        return tuple(v - b for v, b in zip(self.before, bat, strict=True))

    @property
    def along(self) -> float:
        """Ṽ·n, m/s."""
        return self.number("contact.normal_speed")

    @property
    def restitution(self) -> float:
        """ẽ."""
        return self.number("impact.restitution")

    @property
    def kick(self) -> Numbers:
        """J n, N s."""
        return tuple(self.number("impact.impulse") * n for n in self["contact.normal"])


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
    value: Callable[[View], Numbers]


def _spun(v: View, lever: float, cos: float, sin: float) -> Numbers:
    speed = v.scene.swing.angular_speed * lever
    return speed * cos, 0.0, speed * sin


def _effective(inertia: Callable[[View], float], power: int = 2) -> Callable[[View], Numbers]:
    """Return ẽ with another moment of inertia, or another power of r̃."""

    def value(v: View) -> Numbers:
        ratio = v.scene.ball.mass * v.lever**power / inertia(v)
        e = v.scene.ball.restitution
        return (e * (1 + ratio) + ratio,)

    return value


def _mu(v: View, other: float) -> float:
    m = v.scene.ball.mass
    return float(m * other / (m + other))


def _push(mass: Callable[[View], float], e: Callable[[View], float]) -> Callable[[View], Numbers]:
    return lambda v: (-mass(v) * (1 + e(v)) * v.along,)


def _after(factor: Callable[[View], float], keep: float = 1.0) -> Callable[[View], Numbers]:
    return lambda v: tuple(keep * b + factor(v) * k for b, k in zip(v.before, v.kick, strict=True))


def _energy(mass: Callable[[View], float], loss: Callable[[View], float]) -> Any:
    return lambda v: (-0.5 * mass(v) * loss(v) * v.along**2,)


_I = "I = M(L²/3 + r_b²/4) about the end B"
_EFFECTIVE = "ẽ = e(1 + m/M_eff) + m/M_eff with M_eff = I/r̃²"
_V_B = "V_b = ω r̃ (cos θ, 0, sin θ) with r̃ = L/2 - y"
_J = "J = -μ(1 + ẽ)(Ṽ·n) with 1/μ = 1/m + 1/M"
_V = "V' = V + (J/m) n"
_DE = "ΔE = -½ μ (1 - ẽ²)(Ṽ·n)²"
_D = "D is the horizontal distance from the origin to the landing"


def _cos(v: View) -> float:
    return math.cos(v.scene.swing.tilt)


def _sin(v: View) -> float:
    return math.sin(v.scene.swing.tilt)


def _axis(v: View) -> Numbers:
    x, _, z = v.position
    return x, 0.0, z - v.height


def _unit(v: Numbers) -> Numbers:
    size = math.hypot(*v)
    return tuple(x / size for x in v)


def _bare(v: View) -> float:
    """Return μ with the bat's effective mass."""
    return _mu(v, v.inertia() / v.lever**2)


FORMULAS: tuple[Formula, ...] = (
    Formula("contact.normal", "normal-not-unit", "does not divide the normal by its length",
            "n is a unit vector", _axis),
    Formula("contact.normal", "normal-in-space", "takes the normal from the bat's middle, along y "
            "too", "n is perpendicular to the bat's axis: its y is 0",
            lambda v: _unit((v.position[0], v.position[1], v.position[2] - v.height))),
    Formula("contact.normal", "offset-ignored", "takes the normal without swing.height_offset",
            "the bat's height is z'_b + σ_b",
            lambda v: _unit((v.position[0], 0.0, v.position[2] - v["plate.position"][2]))),
    Formula("contact.normal", "normal-swapped", "exchanges x and z of the normal",
            "n points from the bat's axis to the ball: (x, 0, z - z_b)/d",
            lambda v: _unit(_axis(v)[::-1])),
    Formula("contact.bat_velocity", "other-pivot", "lets the bat turn about its end A, at y = -L/2",
            "the pivot B is at y = +L/2: r̃ = L/2 - y",
            lambda v: _spun(v, v.scene.bat.length / 2 + v.position[1], _cos(v), _sin(v))),
    Formula("contact.bat_velocity", "other-pivot-backwards", "turns the bat about its end A, and "
            "backwards", "the pivot B is at y = +L/2: r̃ = L/2 - y",
            lambda v: _spun(v, -v.scene.bat.length / 2 - v.position[1], _cos(v), _sin(v))),
    Formula("contact.bat_velocity", "pivot-in-the-middle", "lets the bat turn about its middle",
            _V_B, lambda v: _spun(v, -v.position[1], _cos(v), _sin(v))),
    Formula("contact.bat_velocity", "tip-speed", "gives all of the bat the speed of its tip", _V_B,
            lambda v: _spun(v, v.scene.bat.length, _cos(v), _sin(v))),
    Formula("contact.bat_velocity", "middle-speed", "gives all of the bat the speed of its middle",
            _V_B, lambda v: _spun(v, v.scene.bat.length / 2, _cos(v), _sin(v))),
    Formula("contact.bat_velocity", "tilt-sign", "tilts the swing downwards", _V_B,
            lambda v: _spun(v, v.lever, _cos(v), -_sin(v))),
    Formula("contact.bat_velocity", "tilt-ignored", "swings level: the tilt is not used", _V_B,
            lambda v: _spun(v, v.lever, 1.0, 0.0)),
    Formula("contact.bat_velocity", "tilt-swapped", "exchanges sine and cosine of the tilt", _V_B,
            lambda v: _spun(v, v.lever, _sin(v), _cos(v))),
    Formula("contact.bat_velocity", "tilt-in-degrees", "takes the tilt of the swing for degrees",
            "swing.tilt is in radians",
            lambda v: _spun(v, v.lever, math.cos(math.radians(v.scene.swing.tilt)),
                            math.sin(math.radians(v.scene.swing.tilt)))),
    Formula("contact.bat_velocity", "tilt-to-degrees", "turns the tilt into degrees before its "
            "sine", "swing.tilt is in radians",
            lambda v: _spun(v, v.lever, math.cos(math.degrees(v.scene.swing.tilt)),
                            math.sin(math.degrees(v.scene.swing.tilt)))),
    Formula("contact.normal_speed", "bat-at-rest", "takes the ball's own velocity, as if the bat "
            "were at rest", "Ṽ = V - V_b",
            lambda v: (sum(a * n for a, n in zip(v.before, v["contact.normal"], strict=True)),)),
    Formula("contact.normal_speed", "velocities-added", "adds the bat's velocity to the ball's",
            "Ṽ = V - V_b", lambda v: (sum((a + b) * n for a, b, n in zip(
                v.before, v["contact.bat_velocity"], v["contact.normal"], strict=True)),)),
    Formula("contact.normal_speed", "whole-speed", "takes the size of Ṽ, not its part along n",
            "Ṽ·n", lambda v: (-math.hypot(*v.relative),)),
    Formula("contact.normal_speed", "plate-velocity", "takes the ball's velocity at the plate",
            "take it at the contact",
            lambda v: (sum((a - b) * n for a, b, n in zip(
                v["plate.velocity"], v["contact.bat_velocity"], v["contact.normal"],
                strict=True)),)),
    Formula("impact.restitution", "plain-restitution", "uses e where ẽ belongs", _EFFECTIVE,
            lambda v: (v.scene.ball.restitution,)),
    Formula("impact.restitution", "effective-mass", "takes M_eff = I/r̃, as printed, which is no "
            "mass", "M_eff = I/r̃²", _effective(lambda v: v.inertia(), 1)),
    Formula("impact.restitution", "thin-rod", "takes the bat for a thin rod", _I,
            _effective(lambda v: v.inertia(inertia="thin_rod"))),
    Formula("impact.restitution", "inertia-about-centre", "takes the bat's moment of inertia about "
            "its centre", _I, _effective(lambda v: v.inertia(inertia="about_centre"))),
    Formula("impact.restitution", "hollow-bat", "takes the bat for a hollow cylinder", _I,
            _effective(lambda v: v.scene.bat.mass * (
                v.scene.bat.length**2 / 3 + v.scene.bat.radius**2 / 2))),
    Formula("impact.restitution", "bat-mass-ratio", "takes the bat's whole mass for M_eff",
            _EFFECTIVE, _effective(lambda v: v.scene.bat.mass, 0)),
    Formula("impact.restitution", "other-pivot", "measures r̃ from the bat's end A, at y = -L/2",
            "the pivot B is at y = +L/2: r̃ = L/2 - y", lambda v: (
                v.scene.ball.restitution + (1 + v.scene.ball.restitution) * v.scene.ball.mass
                * (v.scene.bat.length - v.lever)**2 / v.inertia(),)),
    Formula("impact.restitution", "ratio-once", "leaves m/M_eff out behind e(1 + m/M_eff)",
            _EFFECTIVE, lambda v: (v.scene.ball.restitution * (
                1 + v.scene.ball.mass * v.lever**2 / v.inertia()),)),
    Formula("impact.restitution", "ratio-subtracted", "subtracts m/M_eff", _EFFECTIVE,
            lambda v: (v.scene.ball.restitution * (1 + v.scene.ball.mass * v.lever**2 / v.inertia())
                       - v.scene.ball.mass * v.lever**2 / v.inertia(),)),
    Formula("impact.restitution", "bat-speed-ratio", "gives the collision efficiency "
            "(e - m/M_eff)/(1 + m/M_eff)", _EFFECTIVE,
            lambda v: ((v.scene.ball.restitution - v.scene.ball.mass * v.lever**2 / v.inertia())
                       / (1 + v.scene.ball.mass * v.lever**2 / v.inertia()),)),
    Formula("impact.impulse", "reduced-mass", "takes μ from M_eff", "1/μ = 1/m + 1/M, with the "
            "bat's mass M", _push(_bare, lambda v: v.restitution)),
    Formula("impact.impulse", "ball-mass-for-mu", "takes the ball's mass for μ", _J,
            _push(lambda v: v.scene.ball.mass, lambda v: v.restitution)),
    Formula("impact.impulse", "bat-mass-for-mu", "takes the bat's mass for μ", _J,
            _push(lambda v: v.scene.bat.mass, lambda v: v.restitution)),
    Formula("impact.impulse", "sum-of-masses", "takes m + M for μ", _J,
            _push(lambda v: v.scene.ball.mass + v.scene.bat.mass, lambda v: v.restitution)),
    Formula("impact.impulse", "plain-e-in-impulse", "uses 1 + e where 1 + ẽ belongs", _J,
            _push(lambda v: _mu(v, v.scene.bat.mass), lambda v: v.scene.ball.restitution)),
    Formula("impact.impulse", "one-minus-e", "uses 1 - ẽ where 1 + ẽ belongs", _J,
            _push(lambda v: _mu(v, v.scene.bat.mass), lambda v: -v.restitution)),
    Formula("impact.impulse", "no-one-plus", "uses ẽ where 1 + ẽ belongs", _J,
            _push(lambda v: _mu(v, v.scene.bat.mass), lambda v: v.restitution - 1)),
    Formula("impact.impulse", "inelastic", "leaves the restitution out: the impulse is -μ Ṽ·n", _J,
            _push(lambda v: _mu(v, v.scene.bat.mass), lambda v: 0.0)),
    Formula("impact.velocity", "impulse-over-bat-mass", "divides the impulse by the bat's mass", _V,
            _after(lambda v: 1 / v.scene.bat.mass)),
    Formula("impact.velocity", "impulse-not-divided", "adds the impulse without dividing it by the "
            "ball's mass", _V, _after(lambda v: 1.0)),
    Formula("impact.velocity", "impulse-sign", "subtracts the impulse", _V,
            _after(lambda v: -1 / v.scene.ball.mass)),
    Formula("impact.velocity", "impulse-alone", "forgets the velocity before the impact", _V,
            _after(lambda v: 1 / v.scene.ball.mass, 0.0)),
    Formula("impact.velocity", "impulse-over-reduced-mass", "divides the impulse by μ", _V,
            _after(lambda v: 1 / _mu(v, v.scene.bat.mass))),
    Formula("impact.velocity", "relative-velocity", "starts from Ṽ instead of V", _V,
            lambda v: tuple(r + k / v.scene.ball.mass
                            for r, k in zip(v.relative, v.kick, strict=True))),
    Formula("impact.velocity", "plate-velocity-after", "starts from the velocity at the plate", _V,
            lambda v: tuple(r + k / v.scene.ball.mass
                            for r, k in zip(v["plate.velocity"], v.kick, strict=True))),
    Formula("impact.energy_change", "energy-with-e", "uses e where ẽ belongs", _DE,
            _energy(lambda v: _mu(v, v.scene.bat.mass), lambda v: 1 - v.scene.ball.restitution**2)),
    Formula("impact.energy_change", "energy-e-not-squared", "uses 1 - ẽ where 1 - ẽ² belongs", _DE,
            _energy(lambda v: _mu(v, v.scene.bat.mass), lambda v: 1 - v.restitution)),
    Formula("impact.energy_change", "energy-with-effective-mass", "takes μ from M_eff", _DE,
            _energy(_bare, lambda v: 1 - v.restitution**2)),
    Formula("impact.energy_change", "energy-of-ball", "counts the ball's energy only", _DE,
            lambda v: (0.5 * v.scene.ball.mass * (
                sum(x * x for x in v["impact.velocity"]) - sum(x * x for x in v.before)),)),
    Formula("impact.energy_change", "energy-with-ball-mass", "takes the ball's mass for μ", _DE,
            _energy(lambda v: v.scene.ball.mass, lambda v: 1 - v.restitution**2)),
    Formula("landing.time", "time-since-contact", "counts landing.time from the contact",
            "landing.time is since the start of the scene; landing.hang_time since the contact",
            lambda v: v["landing.hang_time"]),
    Formula("landing.time", "contact-counted-twice", "adds the contact's time twice",
            "landing.time = contact.time + landing.hang_time",
            lambda v: (2 * v.number("contact.time") + v.number("landing.hang_time"),)),
    Formula("landing.hang_time", "hang-time-since-start", "counts landing.hang_time from the start "
            "of the scene", "landing.hang_time is since contact or launch",
            lambda v: v["landing.time"]),
    Formula("landing.distance", "distance-from-contact", "measures the distance from where the "
            "ball was met, not from the plate", _D,
            lambda v: (math.dist(v["landing.position"][:2], v.position[:2]),)),
    Formula("landing.distance", "distance-from-launch", "measures the distance from the launch",
            _D, lambda v: (math.dist(v["landing.position"][:2], v.scene.launch.position[:2]),)),
    Formula("landing.distance", "distance-in-space", "measures the distance in space, height too",
            _D, lambda v: (math.hypot(*v["landing.position"]),)),
    Formula("landing.distance", "distance-along-x", "takes x for the distance", _D,
            lambda v: (v["landing.position"][0],)),
    Formula("landing.distance", "distance-abs-x", "takes |x| for the distance", _D,
            lambda v: (abs(v["landing.position"][0]),)),
    Formula("landing.distance", "distance-squared", "forgets the root of x² + y²", _D,
            lambda v: (v["landing.position"][0] ** 2 + v["landing.position"][1] ** 2,)),
    Formula("landing.distance", "distance-summed", "adds |x| and |y|", _D,
            lambda v: (abs(v["landing.position"][0]) + abs(v["landing.position"][1]),)),
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
    Mistake(
        "plain-restitution", "uses e where ẽ belongs", _EFFECTIVE,
        _reading(bat_ball_restitution="plain"),
    ),
    Mistake(
        "nathan", "uses Nathan's formula: e with the effective mass in μ",
        "the paper prints ẽ = e(1 + m/M_eff) + m/M_eff with μ from the bat's mass M",
        _reading(bat_ball_restitution="nathan"),
    ),
    Mistake(
        "effective-mass", "takes M_eff = I/r̃, as printed, which is no mass", "M_eff = I/r̃²",
        _reading(effective_mass="as_printed"),
    ),
    Mistake(
        "reduced-mass", "takes μ from M_eff", "1/μ = 1/m + 1/M, with the bat's mass M",
        _reading(reduced_mass="effective_mass"),
    ),
    Mistake("thin-rod", "takes the bat for a thin rod", _I, _reading(inertia="thin_rod")),
    Mistake(
        "inertia-about-centre", "takes the bat's moment of inertia about its centre", _I,
        _reading(inertia="about_centre"),
    ),
    Mistake(
        "landing-of-surface", "lets the ball land when its surface touches the ground, at z = R",
        "the ball lands when its centre reaches the ground, unless the reading ground_contact says "
        "otherwise", _reading(ground_contact="surface"),
    ),
    Mistake(
        "ignores-reading", "ignores the scene's reading block",
        "take the switches of scene.reading, or leave those scenes out with --golden",
        Change(lambda scene: scene.model_copy(update={"reading": Reading()})),
    ),
)  # fmt: skip

# What shows in outcomes alone.
OUTCOMES: tuple[Mistake, ...] = (
    Mistake(
        "time-limit-ignored", "flies on beyond time_limit",
        "a ball that has not come down after time_limit seconds of flight is airborne",
        Change(lambda scene: with_values(scene, {"time_limit": 1e4})),
    ),
    Mistake(
        "ground-ignored", "has the ground at z = 0, whatever ground.height is",
        "the ball lands at ground.height",
        Change(lambda scene: with_values(scene, {"ground.height": 0.0})),
    ),
)  # fmt: skip
