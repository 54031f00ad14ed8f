"""Known mistakes in formulas: what a quantity then is, from the scene and the values before it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from longball.judge.changes import Mistake, reading_change
from longball.judge.stages import Numbers
from longball.model.bat import CollisionParameters, collision_parameters, moment_of_inertia
from longball.model.force import cross
from longball.model.numbers import DOUBLES, dot, plus
from longball.model.readings import Reading


@dataclass(frozen=True)
class View:
    """A scene, and the values that a formula has before it, by the names of the quantities."""

    scene: Any
    values: Mapping[str, Numbers]
    before: Numbers  # the ball's velocity before the impact, m/s
    height: float  # of the bat's axis, m

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
    def start(self) -> Numbers:
        """Where the ball's flight begins that ends with its landing, m."""
        return tuple(self.scene.launch.position) if self.scene.kind == "flight" else self.position

    @property
    def axis(self) -> Numbers:
        """From the bat's axis to the ball, m."""
        return self.position[0], 0.0, self.position[2] - self.height

    def collision(self, **switches: str) -> CollisionParameters[float]:
        """Return ẽ and μ, with some switches of the reading set otherwise."""
        scene = self.scene
        reading = Reading.model_validate(scene.reading.model_dump() | switches)
        return collision_parameters(scene.ball, scene.bat, self.lever, reading, DOUBLES)

    # The paper's symbols.
    m = property(lambda self: float(self.scene.ball.mass))  # kg
    M = property(lambda self: float(self.scene.bat.mass))  # kg
    e = property(lambda self: float(self.scene.ball.restitution))
    lever = property(lambda self: float(self.scene.bat.length) / 2 - self.position[1])  # r̃, m
    mu = property(lambda self: self.collision().reduced_mass)  # kg
    bare = property(lambda self: self.collision(  # μ from M_eff, kg
        bat_ball_restitution="nathan", reduced_mass="bat_mass").reduced_mass)  # fmt: skip
    ratio = property(lambda self: self.m / self.bare - 1)  # m/M_eff
    restitution = property(lambda self: self.number("impact.restitution"))  # ẽ
    relative = property(lambda self: plus(self.before, -1.0, self["contact.bat_velocity"]))  # Ṽ

    inertia = property(lambda self: float(  # the bat's, kg m²
        moment_of_inertia(self.scene.bat, self.scene.reading, DOUBLES)))  # fmt: skip
    kick = property(lambda self: tuple(  # J n, N s
        self.number("impact.impulse") * n for n in self["contact.normal"]))  # fmt: skip


Number = Callable[[View], float]
Value = Callable[[View], Numbers]


@dataclass(frozen=True)
class Formula:
    """A known mistake in one formula."""

    quantity: str  # what it computes
    # See `Mistake`.
    name: str
    sentence: str
    remedy: str
    value: Callable[..., Numbers]  # what it then is


@dataclass(frozen=True)
class Numbered(Formula):
    """A known mistake with any number in it: braces in the sentence, an argument of `value`."""

    # What the number is, if the quantity is what a candidate says.
    number: Callable[[View, Numbers], float]

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


def _closing(velocity: Value) -> Value:
    """Return the part of a velocity along the normal."""
    return lambda v: (dot(velocity(v), v["contact.normal"]),)


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


def _energy_not_halved(v: View) -> Numbers:
    """Return P·(g + K P), which is 2 ΔE - P·g, with the whole impulse P and the slip g."""
    ball, bat, n = v.scene.ball, v.scene.bat, v["contact.normal"]
    x, z = _cos_sin(v.scene.swing.tilt)
    of_ball = _across(v.values.get("contact.spin", (0.0, 0.0, 0.0)), n)
    of_bat = _across((-v.scene.swing.angular_speed * z, 0.0, v.scene.swing.angular_speed * x), n)
    slip = plus(plus(v.relative, -ball.radius, of_ball), -bat.radius, of_bat)
    push = plus(v["impact.velocity"], -1.0, v.before)
    return (2 * v.number("impact.energy_change:follows") - v.m * dot(push, slip),)


def _across(turning: Numbers, n: Numbers) -> Numbers:
    return cross((turning[0], turning[1], turning[2]), (n[0], n[1], n[2]))


def _less(quantity: str, what: Value) -> Value:
    """Return what follows for a quantity, less something."""
    return lambda v: plus(v[f"{quantity}:follows"], -1.0, what(v))


def _distance(formula: Callable[[float, float, float], float]) -> Value:
    return lambda v: (formula(*v["landing.position"]),)


_I = "I = M(L²/3 + r_b²/4) about the end B"
PLAIN = "uses e where ẽ belongs"
EFFECTIVE = "ẽ = e(1 + m/M_eff) + m/M_eff with M_eff = I/r̃²"
_N = "n points from the bat's axis to the ball: (x, 0, z - z_b)/d"
PIVOT = "the pivot B is at y = +L/2: r̃ = L/2 - y"
_V_B = "V_b = ω r̃ (cos θ, 0, sin θ) with r̃ = L/2 - y"
MU = "1/μ = 1/m + 1/M, with the bat's mass M"
_J = "J = -μ(1 + ẽ)(Ṽ·n) with 1/μ = 1/m + 1/M"
_V = "V' = V + (J/m) n"
_DE = "ΔE = -½ μ (1 - ẽ²)(Ṽ·n)²"
_SPUN = "ω' = ω - (R/I) n × P with I = inertia_factor m R²"
_D = "D is the horizontal distance from the origin to the landing"


def _unit(v: Numbers) -> Numbers:
    size = math.hypot(*v)
    return tuple(x / size for x in v)


def _slender(v: View) -> float:
    """Return the bat's moment of inertia without its part of r_b², by its mass, m²."""
    return float(v.inertia / v.M - _round(v) * v.scene.bat.radius**2)


def _round(v: View) -> float:
    """Return c of the moment of inertia M(… + c r_b²)."""
    return 0.0 if v.scene.reading.inertia == "thin_rod" else 0.25


@dataclass(frozen=True)
class _Part:
    """A number times a size, and the rest: of the bat's moment of inertia by its mass."""

    size: Number  # m²
    rest: Number  # m²

    def ratio(self, v: View, number: float) -> float:
        """Return m/M_eff with a number."""
        return float(v.ratio * v.inertia / (v.M * (self.rest(v) + number * self.size(v))))

    def number(self, v: View, ratio: float) -> float:
        """Return the number with which m/M_eff is a ratio."""
        return float((v.inertia * v.ratio / (ratio * v.M) - self.rest(v)) / self.size(v))

    def restitution(self, v: View, number: float) -> Numbers:
        """Return ẽ with a number."""
        return _restitution(lambda v, e, r: _printed(e, self.ratio(v, number)))(v)

    def impulse(self, v: View, number: float) -> Numbers:
        """Return the impulse with a number, where the reading takes μ from M_eff."""
        bare = math.isclose(v.mu, v.bare, rel_tol=1e-12)
        return _push(lambda v: v.m / (1 + self.ratio(v, number)) if bare else v.mu)(v)

    def pushed(self, v: View, said: Numbers) -> float:
        """Return the number in the μ that an impulse is made with."""
        mu = -said[0] / ((1 + v.restitution) * v.number("contact.normal_speed"))
        return self.number(v, v.m / mu - 1)


_OF_RADIUS = _Part(lambda v: v.scene.bat.radius**2, _slender)
_OF_LENGTH = _Part(lambda v: v.scene.bat.length**2, lambda v: _round(v) * v.scene.bat.radius**2)


def _of_ball_radius(v: View) -> float:
    """Return c of the moment of inertia that has the ball's radius for the bat's."""
    return _round(v) * float(v.scene.ball.radius / v.scene.bat.radius) ** 2


def _with_component(vector: Numbers, i: int, value: float) -> Numbers:
    return (*vector[:i], value, *vector[i + 1 :])


# In the bat's parameters: names, sentences, remedies, and the switches of the reading that make
# them.
_MISREAD: dict[str, tuple[str, str, dict[str, str]]] = {
    "effective-mass": ("takes M_eff = I/r̃, as printed, which is no mass", "M_eff = I/r̃²",
                       {"effective_mass": "as_printed"}),
    "thin-rod": ("takes the bat for a thin rod", _I, {"inertia": "thin_rod"}),
    "inertia-about-centre": ("takes the bat's moment of inertia about its centre", _I,
                             {"inertia": "about_centre"}),
}  # fmt: skip


def misread(*names: str) -> Iterator[Mistake]:
    """Yield formulas that are readings of the paper as changes of the whole chain."""
    for name in names:
        sentence, remedy, switches = _MISREAD[name]
        yield Mistake(name, sentence, remedy, reading_change(**switches))


def _as_fast_as_released(v: View) -> Numbers:
    share = math.hypot(*v.scene.pitch.thrown) / math.hypot(*v.before)
    return tuple(share * x for x in v.before)


_AT_CONTACT = "V is the ball's velocity at the contact"

# What may be taken for V.
_BEFORE: tuple[tuple[str, str, Value], ...] = (
    ("plate-velocity", "the ball's velocity at the plate", lambda v: v["plate.velocity"]),
    ("release-speed", "the speed at the release for that at the contact", _as_fast_as_released),
    ("level-velocity", "0 for the ball's vertical velocity", lambda v: (*v.before[:2], 0.0)),
)  # fmt: skip

FORMULAS: tuple[Formula, ...] = (
    *_wrong("plate.velocity", "plate.velocity is where the ball crosses x = 0",
        ("velocity-of-release", "gives the release's velocity for that at the plate",
         lambda v: tuple(v.scene.pitch.thrown))),
    *_wrong("plate.position", "plate.position is in the axes of the scene",
        ("plate-from-aim", "counts the height at the plate from that aimed at",
         lambda v: (*(there := v["plate.position:follows"])[:2],
                    there[2] - v.scene.pitch.aim[1]))),
    *_wrong("contact.position", "contact.position is the ball's centre in the axes of the scene",
        ("contact-from-axis", "counts the height of the contact from the bat's axis",
         lambda v: plus(v["contact.position:follows"], -1.0, (0.0, 0.0, v.height)))),
    *_wrong("contact.margin", "the margin is reach less the least distance from the bat's axis",
        ("margin-at-plate", "takes the margin from the height above the bat's axis at the plate",
         lambda v: (v.scene.ball.radius + v.scene.bat.radius
                    - abs(v["plate.position"][2] - v.height),)),
        ("margin-share", "divides the margin by R + r_b", lambda v: (
            v.number("contact.margin:follows") / (v.scene.ball.radius + v.scene.bat.radius),),
         "contact.margin is in m")),
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
        ("normal-level-to-ball", "has the normal level, whatever the height of the ball above the "
         "bat", lambda v: (math.copysign(1.0, v.position[0]), 0.0, 0.0)),
        ("normal-small-angle", "takes 1 for the cosine of the normal's angle",
         lambda v: (math.copysign(1.0, v.position[0]), 0.0, _unit(v.axis)[2])),
        ("normal-against-velocity", "has the normal against the ball's velocity",
         lambda v: tuple(-x for x in _unit(v.before))),
        ("offset-ignored", "takes the normal without swing.height_offset",
         lambda v: _unit((v.position[0], 0.0, v.position[2] - v["plate.position"][2])),
         "the bat's height is z'_b + σ_b"),
        ("normal-swapped", "exchanges x and z of the normal", lambda v: _unit(v.axis[::-1]))),
    *_wrong("contact.bat_velocity", _V_B,
        ("other-pivot", "lets the bat turn about its end A, at y = -L/2",
         _swung(lambda v: v.scene.bat.length / 2 + v.position[1]), PIVOT),
        ("other-pivot-backwards", "turns the bat about its end A, and backwards",
         _swung(lambda v: -v.scene.bat.length / 2 - v.position[1]), PIVOT),
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
        ("tilt-sine", "takes the sine of the tilt for the tilt",
         _swung(tilt=lambda t: _cos_sin(math.sin(t)))),
        ("tilt-tangent", "takes the tangent of the tilt for the tilt",
         _swung(tilt=lambda t: _cos_sin(math.tan(t)))),
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
        *((name, f"takes {words}", _closing(
            lambda v, before=before: plus(before(v), -1.0, v["contact.bat_velocity"])), _AT_CONTACT)  # type: ignore[misc]
          for name, words, before in _BEFORE)),
    Formula("impact.restitution", "plain-restitution", PLAIN, EFFECTIVE, lambda v: (v.e,)),
    *(Formula("impact.restitution", name, sentence, remedy,
              lambda v, s=switches: (v.collision(**s).restitution,))
      for name, (sentence, remedy, switches) in _MISREAD.items()),
    *_wrong("impact.restitution", EFFECTIVE,
        ("bat-mass-ratio", "takes the bat's whole mass for M_eff",
         _restitution(lambda v, e, r: _printed(e, v.m / v.M))),
        ("bat-inertia-of-ball-radius", "takes the ball's radius for the bat's in its moment of "
         "inertia", lambda v: _OF_RADIUS.restitution(v, _of_ball_radius(v)),
         _I),
        ("other-pivot", "measures r̃ from the bat's end A, at y = -L/2", _restitution(
            lambda v, e, r: _printed(e, r * ((v.scene.bat.length - v.lever) / v.lever) ** 2)),
         PIVOT),
        ("ratio-once", "leaves m/M_eff out behind e(1 + m/M_eff)",
         _restitution(lambda v, e, r: e * (1 + r))),
        ("ratio-without-one", "leaves the 1 out: e m/M_eff + m/M_eff",
         _restitution(lambda v, e, r: e * r + r)),
        ("ratio-inverted", "takes M_eff/m for m/M_eff",
         _restitution(lambda v, e, r: _printed(e, 1 / r))),
        ("ratio-subtracted", "subtracts m/M_eff", _restitution(lambda v, e, r: e * (1 + r) - r)),
        ("bat-speed-ratio", "gives the collision efficiency (e - m/M_eff)/(1 + m/M_eff)",
         _restitution(lambda v, e, r: (e - r) / (1 + r)))),
    *_wrong("impact.impulse", _J,
        ("reduced-mass", "takes μ from M_eff", _push(lambda v: v.bare), MU),
        ("bat-inertia-of-ball-radius", "takes the ball's radius for the bat's in its moment of "
         "inertia", lambda v: _OF_RADIUS.impulse(v, _of_ball_radius(v)), _I),
        ("impulse-per-mass", "divides the impulse by the ball's mass",
         lambda v: (_push()(v)[0] / v.m,), "impact.impulse is in N s"),
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
        *((f"velocity-{axis}-kept", f"leaves v_{axis} as it was before the impact",
           lambda v, i=i: _with_component(v["impact.velocity:follows"], i, v.before[i]))
          for i, axis in enumerate("xyz")),
        ("velocity-along-normal", "keeps the velocity along the normal only",
         lambda v: tuple(n * dot(v["impact.velocity:follows"], v["contact.normal"])
                         for n in v["contact.normal"])),
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
        *((f"{name}-after", f"starts from {words}",
           lambda v, before=before: plus(before(v), 1 / v.m, v.kick), _AT_CONTACT)
          for name, words, before in _BEFORE),
        ("friction-left-out", "leaves the friction's part of the impulse out",
         _after(lambda v: 1 / v.m), "V' = V + P/m with the whole impulse P")),
    *_wrong("impact.energy_change", _DE,
        ("energy-with-e", "uses e where ẽ belongs", _energy(loss=lambda v: 1 - v.e**2)),
        ("energy-e-not-squared", "uses 1 - ẽ where 1 - ẽ² belongs",
         _energy(loss=lambda v: 1 - v.restitution)),
        ("energy-one-minus-e-squared", "uses (1 - ẽ)² where 1 - ẽ² belongs",
         _energy(loss=lambda v: (1 - v.restitution) ** 2)),
        ("energy-with-effective-mass", "takes μ from M_eff", _energy(lambda v: v.bare)),
        ("energy-of-ball", "counts the ball's energy only", lambda v: (0.5 * v.m * (
            sum(x * x for x in v["impact.velocity"]) - sum(x * x for x in v.before)),)),
        ("energy-of-whole-speed", "takes the size of Ṽ, not its part along n", lambda v: (
            -0.5 * v.mu * (1 - v.restitution**2) * dot(v.relative, v.relative),)),
        ("energy-with-ball-mass", "takes the ball's mass for μ", _energy(lambda v: v.m)),
        ("energy-not-halved", "leaves the ½ out: P·(g + K P)", _energy_not_halved,
         "ΔE = P·(g + K P/2), with the whole impulse P"),
        ("energy-without-friction", "counts what the normal impulse does, and not what friction "
         "does", _energy(), "ΔE = P·(g + K P/2), with the whole impulse P")),
    *_wrong("impact.spin", _SPUN,
        ("spin-kept", "keeps the spin that the ball came with", lambda v: v["contact.spin"]),
        ("spin-about-normal-lost", "leaves out the spin about the normal",
         lambda v: plus(v["impact.spin:follows"], -dot(v["impact.spin:follows"],
                                                       v["contact.normal"]), v["contact.normal"]),
         "friction does not act on the spin about the normal: it stays as it was"),
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
         lambda v: tuple(v.scene.launch.spin) if v.scene.kind == "flight" else v["impact.spin"])),
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
    *_wrong("landing.position", "the batted ball flies from contact.position",
        ("batted-from-plate", "lets the batted ball fly from where the pitch crosses the plate",
         lambda v: plus(v["landing.position:follows"], 1.0, plus(
             v["plate.position"], -1.0, v["contact.position"]))),
        ("position-from-start", "counts landing.position from where the flight begins",
         _less("landing.position", lambda v: v.start), "landing.position is in the axes of the "
         "scene")),
    *_wrong("landing.path", "landing.path is ∫ U dt along the flight",
        ("path-straight", "measures the path on a straight line from where the flight begins",
         lambda v: (math.dist(v["landing.position"], v.start),)),
        ("path-by-landing-speed", "takes the speed at the landing for that of all the flight",
         lambda v: (v.number("landing.hang_time") * math.hypot(*v["landing.velocity"]),))),
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
             lambda v, radii: plus(v["contact.position:follows"], -radii * v.scene.ball.radius,
                                   v["contact.normal"]),
             lambda v, said: dot(plus(v["contact.position:follows"], -1.0, said),
                                 v["contact.normal"]) / v.scene.ball.radius),
    Numbered("contact.normal", "normal-by-number", "divides the normal by {} m, not by its length",
             "n is a unit vector", lambda v, length: tuple(x / length for x in v.axis),
             lambda v, said: math.hypot(*v.axis) / math.hypot(*said)),
    Numbered("contact.normal", "normal-along-bat", "gives the normal a part along the bat: "
             "(x, {} y, z - z_b) stands for (x, 0, z - z_b)",
             "n is perpendicular to the bat's axis: its y is 0",
             lambda v, share: _unit((v.axis[0], share * v.position[1], v.axis[2])),
             lambda v, said: said[1] * math.hypot(*v.axis)
             / (v.position[1] * math.hypot(said[0], said[2]))),
    Numbered("contact.bat_velocity", "pivot-elsewhere", "lets the bat turn about a point {} times "
             "its length from the middle", PIVOT,
             lambda v, share: _swung(lambda w: share * w.scene.bat.length - w.position[1])(v),
             lambda v, said: (math.copysign(math.hypot(*said), said[0])
                              / v.scene.swing.angular_speed + v.position[1]) / v.scene.bat.length),
    *(one for name, words, part in (
          ("bat-inertia", "r_b² for the bat's radius", _OF_RADIUS),
          ("bat-inertia-of-length", "L² for the bat's length", _OF_LENGTH))
      for sentence in [f"has {{}} {words} in its moment of inertia, M(L²/3 + r_b²/4)"]
      for one in (
          Numbered("impact.restitution", name, sentence, _I, part.restitution,
                   lambda v, said, part=part: part.number(v, (said[0] - v.e) / (1 + v.e))),  # type: ignore[misc]
          Numbered("impact.impulse", name, sentence, _I, part.impulse, part.pushed))),
)  # fmt: skip
