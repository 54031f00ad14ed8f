"""Known mistakes in formulas: what a quantity then is, from the scene and the values before it.

Each formula is written once, with what may stand in the place of each of its symbols.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from longball.judge.quantities import QUANTITIES, QuantitySpec
from longball.judge.stages import Numbers
from longball.model.bat import (
    CollisionParameters,
    collision_parameters,
    inertia_factor,
    moment_of_inertia,
)
from longball.model.impact import energy_change
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

    def begun(self, key: str) -> Numbers:
        """Return the ball's position, velocity or spin where it is launched, or leaves the bat."""
        if self.scene.kind == "flight":
            return tuple(getattr(self.scene.launch, key))
        return self.position if key == "position" else self[f"impact.{key}"]

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
    normal = property(lambda self: self["contact.normal"])
    closing = property(lambda self: self.number("contact.normal_speed"))  # Ṽ·n, m/s
    impulse = property(lambda self: self.number("impact.impulse"))  # J, N s


Value = Callable[[View], Any]


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


# --- formulas with their symbols ------------------------------------------------------------------

# A symbol's value, and what else may be taken for it, by what that is called.
Symbol = tuple[Value, Mapping[str, Value]]


def _substituted(
    quantity: str, law: str, formula: Callable[..., Any], symbols: Mapping[str, Symbol]
) -> Iterator[Formula]:
    """Yield a formula with each of its symbols taken for something else."""
    # What is behind a semicolon says what that means.
    right = {name: value for name, (value, _) in symbols.items()}
    for symbol, (_, others) in symbols.items():
        for words, other in others.items():

            def value(v: View, values: Mapping[str, Value] = right | {symbol: other}) -> Numbers:
                found = formula(*(one(v) for one in values.values()))
                return found if isinstance(found, tuple) else (found,)

            taken, _, meaning = words.partition("; ")
            sentence = f"takes {taken} for {symbol} in {law}{f': {meaning}' * bool(meaning)}"
            yield Formula(quantity, f"{quantity}: {symbol} = {taken}", sentence, law, value)


def _unit(v: Numbers) -> Numbers:
    size = math.hypot(*v)
    return tuple(x / size for x in v)


def _times(factor: float, vector: Numbers) -> Numbers:
    return tuple(factor * x for x in vector)


def _tilt(v: View) -> float:
    return float(v.scene.swing.tilt)


def _reach(v: View) -> float:
    return float(v.scene.ball.radius + v.scene.bat.radius)


def _printed(e: float, one: float, ratio: float) -> float:
    return e * (one + ratio) + ratio


_SIN_COS: dict[str, Symbol] = {
    "cos θ": (lambda v: math.cos(_tilt(v)), {"1": lambda v: 1.0}),
    "sin θ": (lambda v: math.sin(_tilt(v)), {"θ": _tilt, "tan θ": lambda v: math.tan(_tilt(v))}),
}

_MU: Symbol = (lambda v: v.mu, {
    "1/(1/m + 1/M_eff); the reduced mass of M_eff": lambda v: v.bare,
    "m; the ball's mass": lambda v: v.m,
    "M; the bat's mass": lambda v: v.M,
    "mM/(m + M); the bat's whole mass": lambda v: v.m * v.M / (v.m + v.M),
    "mM/(M - m)": lambda v: v.m * v.M / (v.M - v.m),
    "m + M": lambda v: v.m + v.M,
    "(m + M)/2; the mean of the masses": lambda v: (v.m + v.M) / 2,
    "2mM/(m + M)": lambda v: 2 * v.m * v.M / (v.m + v.M),
    "μ/m; it is divided by the ball's mass": lambda v: v.mu / v.m,
    "1/√(1/m² + 1/M²); the masses are squared": lambda v: 1 / math.hypot(1 / v.m, 1 / v.M),
})  # fmt: skip

# What may be taken for the ball's velocity at the contact.
_V: Mapping[str, Value] = {
    "the velocity at the plate": lambda v: v["plate.velocity"],
    "the velocity of the release": lambda v: v.scene.pitch.thrown,
    "the release's speed": lambda v: _times(
        math.hypot(*v.scene.pitch.thrown) / math.hypot(*v.before), v.before),
    "(V_x, V_y, 0)": lambda v: (*v.before[:2], 0.0),
}  # fmt: skip

_FORMULAS: tuple[tuple[str, str, Callable[..., Any], dict[str, Symbol]], ...] = (
    ("contact.normal", "n = (x, 0, z - z_b)/d", lambda way, length: _times(1 / length, way), {
        "(x, 0, z - z_b)": (lambda v: v.axis, {
            "(z - z_b, 0, x); x and z are exchanged": lambda v: v.axis[::-1],
            "(x, 0, z - z'_b); without the offset": lambda v: (
                v.position[0], 0.0, v.position[2] - v["plate.position"][2]),
            "a horizontal way to the ball": lambda v: (
                math.copysign(math.hypot(*v.axis), v.position[0]), 0.0, 0.0)}),
        "d": (lambda v: math.hypot(*v.axis), {
            "1": lambda v: 1.0, "R + r_b": _reach, "R": lambda v: v.scene.ball.radius,
            "r_b": lambda v: v.scene.bat.radius})}),
    ("contact.bat_velocity", "V_b = ω r̃ (cos θ, 0, sin θ) with r̃ = L/2 - y",
     lambda speed, lever, x, z: (speed * lever * x, 0.0, speed * lever * z), {
        "ω": (lambda v: v.scene.swing.angular_speed, {}),
        "r̃": (lambda v: v.lever, {
            "L/2 + y; it then turns about the other end": lambda v: v.scene.bat.length - v.lever,
            "-y; it then turns about the middle": lambda v: -v.position[1],
            "r̃²": lambda v: v.lever**2,
            "L/2 - |y|": lambda v: v.scene.bat.length / 2 - abs(v.position[1]),
            "L; the lever of the tip": lambda v: v.scene.bat.length,
            "L/2; whatever y is": lambda v: v.scene.bat.length / 2}),
        **_SIN_COS}),
    ("contact.bat_velocity", "V_b = ω r̃ (cos θ, 0, sin θ)", lambda speed, both: (
        speed * both[0], 0.0, speed * both[1]), {
        "ω r̃": (lambda v: v.scene.swing.angular_speed * v.lever, {}),
        "(cos θ, sin θ)": (lambda v: (math.cos(_tilt(v)), math.sin(_tilt(v))), {
            "(sin θ, cos θ); sine and cosine are exchanged": lambda v: (
                math.sin(_tilt(v)), math.cos(_tilt(v))),
            "(1, 0); without the tilt": lambda v: (1.0, 0.0),
            "(1, θ)": lambda v: (1.0, _tilt(v)),
            "θ in degrees": lambda v: (math.cos(math.radians(_tilt(v))),
                                       math.sin(math.radians(_tilt(v)))),
            "-θ": lambda v: (math.cos(_tilt(v)), -math.sin(_tilt(v)))})}),
    ("contact.normal_speed", "Ṽ·n with Ṽ = V - V_b", lambda ball, bat, n: dot(
        plus(ball, -1.0, bat), n), {
        "V": (lambda v: v.before, _V),
        "V_b": (lambda v: v["contact.bat_velocity"], {
            "0; as of a bat at rest": lambda v: (0.0, 0.0, 0.0),
            "-V_b; the bat's velocity is added": lambda v: _times(
                -1.0, v["contact.bat_velocity"])}),
        "n": (lambda v: v.normal, {
            "the direction of -Ṽ": lambda v: _times(-1.0, _unit(v.relative)),
            "(n_x, 0, 0)": lambda v: (v.normal[0], 0.0, 0.0),
            "(0, 0, n_z)": lambda v: (0.0, 0.0, v.normal[2])})}),
    ("impact.impulse", "J = -μ(1 + ẽ)(Ṽ·n)", lambda mu, e, w: -mu * e * w, {
        "μ": _MU,
        "1 + ẽ": (lambda v: 1 + v.restitution, {
            "1 + e": lambda v: 1 + v.e, "1 - ẽ": lambda v: 1 - v.restitution,
            "ẽ": lambda v: v.restitution, "1": lambda v: 1.0}),
        "Ṽ·n": (lambda v: v.closing, {
            "V·n; without the bat's velocity": lambda v: dot(v.before, v.normal),
            "-|Ṽ|": lambda v: -math.hypot(*v.relative)})}),
    ("impact.velocity", "V' = V + (J/m) n", lambda v, j, m, n: plus(v, j / m, n), {
        "V": (lambda v: v.before, {
            "0": lambda v: (0.0, 0.0, 0.0), "Ṽ": lambda v: v.relative,
            "V + V_b": lambda v: plus(v.before, 1.0, v["contact.bat_velocity"]), **_V}),
        "J": (lambda v: v.impulse, {"-J": lambda v: -v.impulse}),
        "m": (lambda v: v.m, {
            "M; the bat's mass": lambda v: v.M, "1; it is not divided": lambda v: 1.0,
            "μ": lambda v: v.mu}),
        "n": (lambda v: v.normal, {
            "the direction of -Ṽ": lambda v: _times(-1.0, _unit(v.relative))})}),
    ("impact.energy_change", "ΔE = -½ μ (1 - ẽ²)(Ṽ·n)²", lambda half, mu, loss, w: (
        -half * mu * loss * w * w), {
        "½": (lambda v: 0.5, {}),
        "μ": (_MU[0], {words: _MU[1][words] for words in [*_MU[1]][:3]}),
        "1 - ẽ²": (lambda v: 1 - v.restitution**2, {
            "1 - e²": lambda v: 1 - v.e**2, "1 - ẽ": lambda v: 1 - v.restitution,
            "(1 - ẽ)²": lambda v: (1 - v.restitution) ** 2}),
        "Ṽ·n": (lambda v: v.closing, {"|Ṽ|": lambda v: math.hypot(*v.relative)})}),
    ("landing.distance", "D = √(x² + y²) at the landing", lambda d: d, {
        "√(x² + y²)": (lambda v: 0.0, {
            "√(x² + y² + z²); all three coordinates": lambda v: math.hypot(*v["landing.position"]),
            "√(x² + z²)": lambda v: math.hypot(*v["landing.position"][::2]),
            "x": lambda v: v["landing.position"][0],
            "|x|": lambda v: abs(v["landing.position"][0]),
            "x² + y²": lambda v: sum(x * x for x in v["landing.position"][:2]),
            "|x| + |y|": lambda v: sum(map(abs, v["landing.position"][:2])),
            "the way from the launch; or from where the ball was met": lambda v: math.dist(
                v["landing.position"][:2], v.begun("position")[:2])})}),
)  # fmt: skip

# ẽ where it is not e itself, as the reading of the paper has it.
_RESTITUTION: tuple[tuple[str, Callable[[View], float]], ...] = (
    ("e", lambda v: v.e),
    ("m/M for m/M_eff", lambda v: _printed(v.e, 1, v.m / v.M)),
    ("M_eff/m for m/M_eff, inverted", lambda v: _printed(v.e, 1, 1 / v.ratio)),
    ("r̃ from the bat's other end, L/2 + y", lambda v: _printed(
        v.e, 1, v.ratio * ((v.scene.bat.length - v.lever) / v.lever) ** 2)),
    ("e(1 + m/M_eff), with m/M_eff left out", lambda v: v.e * (1 + v.ratio)),
    ("e m/M_eff + m/M_eff, without the 1", lambda v: _printed(v.e, 0, v.ratio)),
    ("e(1 + m/M_eff) - m/M_eff, subtracted", lambda v: v.e * (1 + v.ratio) - v.ratio),
    ("the mean of e and ẽ", lambda v: (v.e + _printed(v.e, 1, v.ratio)) / 2),
    ("(e - m/M_eff)/(1 + m/M_eff), the collision efficiency",
     lambda v: (v.e - v.ratio) / (1 + v.ratio)),
)  # fmt: skip


def _restitutions() -> Iterator[Formula]:
    name, law = "impact.restitution", "ẽ = e(1 + m/M_eff) + m/M_eff with M_eff = I/r̃²"
    for words, formula in _RESTITUTION:

        def value(v: View, formula: Callable[[View], float] = formula) -> Numbers:
            printed = v.scene.reading.bat_ball_restitution == "as_printed"
            return (formula(v) if printed else v.e,)

        yield Formula(name, f"{name}: {words}", f"takes {words} for ẽ", law, value)


# --- values that are others -----------------------------------------------------------------------


def _less(quantity: str, what: Value) -> Value:
    """Return what follows for a quantity, less something."""
    return lambda v: plus(v[f"{quantity}:follows"], -1.0, what(v))


def _kept(axis: int) -> Value:
    """Return the velocity after the impact with one component of that before it."""
    return lambda v: (*(after := v["impact.velocity:follows"])[:axis], v.before[axis],
                      *after[axis + 1 :])  # fmt: skip


def _struck(v: View) -> Numbers:
    """Return V + (J/m) n."""
    return plus(v.before, v.impulse / v.m, v.normal)


def _across(vector: Numbers, normal: Numbers) -> Numbers:
    """Return a vector without its part along the normal."""
    return plus(vector, -dot(vector, normal), normal)


def _along_normal(quantity: str) -> Value:
    return lambda v: _times(dot(v[f"{quantity}:follows"], v.normal), v.normal)


def _whole_impulse(v: View) -> Numbers:
    """Return m|V' - V| of a bat with friction; nothing of others, where it says nothing."""
    rough = v.scene.bat.friction is not None
    return (v.m * math.dist(v["impact.velocity"], v.before),) if rough else ()


def _energy_of_ball(v: View) -> Numbers:
    after, before = (sum(x * x for x in w) for w in (v["impact.velocity"], v.before))
    turning = 0.0
    if "impact.spin" in v.values:
        ball = v.scene.ball
        square = inertia_factor(ball, DOUBLES) * ball.radius**2  # of the radius of gyration, m²
        spun, spinning = (sum(x * x for x in v[name]) for name in ("impact.spin", "contact.spin"))
        turning = square * (spun - spinning)
    return (0.5 * v.m * (after - before + turning),)


# What a quantity may be that is none of the answer's, by its unit.
_GIVEN: Mapping[str, Mapping[str, Value]] = {
    "m": {"the place of the launch": lambda v: v.begun("position"),
          "the place of the release": lambda v: v.scene.pitch.release},
    "m/s": {"the velocity of the launch": lambda v: v.begun("velocity"),
            "the velocity of the release": lambda v: v.scene.pitch.thrown,
            "the velocity before the impact": lambda v: v.before},
    "rad/s": {"the spin of the launch": lambda v: v.begun("spin"),
              "the spin before the impact": lambda v: v["contact.spin"]},
}  # fmt: skip


def _for_another(spec: QuantitySpec) -> Iterator[Formula]:
    """Yield that a quantity is another one of the same kind, of the answer or of the scene."""
    alike = [q.name for q in QUANTITIES.values() if (q.unit, q.size) == (spec.unit, spec.size)]
    # What a candidate gives later may have been made from this one.
    later = alike[alike.index(spec.name) :]
    keys = {name: f"{name}:follows" if name in later else name for name in alike}
    others: dict[str, Value] = {name: lambda v, key=key: v[key] for name, key in keys.items()}  # type: ignore[misc]
    others |= _GIVEN.get(spec.unit, {}) if spec.size == 3 else {}
    for words, other in others.items():

        def value(v: View, other: Value = other) -> Numbers:
            return tuple(other(v))

        launch = words.endswith("launch") and not spec.name.startswith(("landing", "fence"))
        if words != spec.name and not launch:
            yield Formula(spec.name, f"{spec.name}: {words}", f"gives for {spec.name} {words}",
                          f"{spec.name} is another quantity", value)  # fmt: skip


# Quantities: what they are, what stands there instead, and as what.
_OTHERS: tuple[tuple[str, str, tuple[tuple[str, Value], ...]], ...] = (
    ("contact.position", "contact.position is the ball's centre in the axes of the scene",
     (("the height above the bat's axis", _less(
         "contact.position", lambda v: (0.0, 0.0, v.height))),)),
    ("plate.position", "plate.position is in the axes of the scene",
     (("the height above that aimed at", _less(
         "plate.position", lambda v: (0.0, 0.0, v.scene.pitch.aim[1]))),)),
    ("contact.margin", "the margin is reach less the least distance from the bat's axis",
     (("the margin by the height at the plate", lambda v: (
         _reach(v) - abs(v["plate.position"][2] - v.height),)),
      ("the margin as a share of R + r_b", lambda v: (
          v.number("contact.margin:follows") / _reach(v),)))),
    ("contact.normal", "n points from the bat's axis to the ball",
     (("against the velocity", lambda v: _times(-1.0, _unit(v.before))),
      ("1 for its cosine", lambda v: (
          math.copysign(1.0, v.position[0]), 0.0, _unit(v.axis)[2])))),
    ("impact.impulse", "impact.impulse is its part along n, in N s",
     (("the size of the whole impulse, the friction's part included", _whole_impulse),
      ("its part along x", lambda v: (v.number("impact.impulse:follows") * v.normal[0],)))),
    ("impact.velocity", "V' = V + P/m with the impulse P, of which J = P·n",
     (*((f"v_{letter} as before the impact", _kept(i)) for i, letter in enumerate("xyz")),
      ("the part along the normal only", _along_normal("impact.velocity")),
      ("the whole velocity reversed, -ẽ V", lambda v: _times(-v.restitution, v.before)),
      ("the whole relative velocity reversed, V_b - ẽ Ṽ", lambda v: plus(
          v["contact.bat_velocity"], -v.restitution, v.relative)),
      ("V - (1 + ẽ)(Ṽ·n) n, mirrored at the bat", lambda v: plus(
          v.before, -(1 + v.restitution) * v.closing, v.normal)),
      ("V' with its part along the bat's surface reversed", lambda v: plus(
          _struck(v), -2.0, _across(v.before, v.normal))),
      ("V' with the velocity of the bat along its surface", lambda v: plus(
          plus(_struck(v), -1.0, _across(v.before, v.normal)), 1.0,
          _across(v["contact.bat_velocity"], v.normal))),
      ("V + (J/m) n, without the friction's part", _struck))),
    ("impact.energy_change", "the energy is that of ball and bat together",
     (("the energy of the ball only", _energy_of_ball),
      ("that of the normal impulse alone", lambda v: (
          energy_change(v.mu, v.restitution, v.closing),)))),
    ("impact.spin", "ω' = ω - (R/I) n × P with I = inertia_factor m R²",
     (("its change alone, without the spin before", _less(
          "impact.spin", lambda v: v["contact.spin"])),
      ("a spin without its part about the normal", _less(
          "impact.spin", _along_normal("impact.spin"))),
      ("a change of the other sign", lambda v: plus(
          _times(2.0, v["contact.spin"]), -1.0, v["impact.spin:follows"])))),
    ("landing.path", "landing.path is ∫ U dt along the flight",
     (("the straight way", lambda v: (
         math.dist(v["landing.position"], v.begun("position")),)),
      ("the way at the landing's speed", lambda v: (
          v.number("landing.hang_time") * math.hypot(*v["landing.velocity"]),)))),
    ("landing.time", "landing.time is since the start of the scene: contact.time + hang_time",
     (("the time of the plate + hang_time", lambda v: (
          v.number("plate.time") + v.number("landing.hang_time"),)),
      ("2 contact.time + hang_time", lambda v: (
          2 * v.number("contact.time") + v.number("landing.hang_time"),)))),
    ("landing.hang_time", "landing.hang_time is since contact or launch",
     (("the time since the plate", lambda v: (
         v.number("landing.time") - v.number("plate.time"),)),)),
    ("landing.position", "the batted ball flies from contact.position, in the axes of the scene",
     (("the place of a flight from where the pitch crosses the plate", lambda v: plus(
         v["landing.position:follows"], 1.0, plus(
             v["plate.position"], -1.0, v["contact.position"]))),
      ("the way from the launch", _less(
         "landing.position", lambda v: v.begun("position"))))),
    ("landing.velocity", "landing.velocity is the vector over the ground where the ball lands",
     (("the speed for v_z", lambda v: (
         *(there := v["landing.velocity:follows"])[:2], -math.hypot(*there))),
      ("the velocity through the air", _less("landing.velocity", lambda v: v.scene.air.wind)))),
)  # fmt: skip

FORMULAS: tuple[Formula, ...] = (
    *(one for row in _FORMULAS for one in _substituted(*row)),
    *_restitutions(),
    *(one for spec in QUANTITIES.values() for one in _for_another(spec)),
    *(
        Formula(quantity, f"{quantity}: {words}", f"gives for {quantity} {words}", remedy, value)
        for quantity, remedy, others in _OTHERS
        for words, value in others
    ),
)


# --- formulas with any number ---------------------------------------------------------------------


def _round(v: View) -> float:
    """Return c of the bat's moment of inertia M(… + c r_b²)."""
    return 0.0 if v.scene.reading.inertia == "thin_rod" else 0.25


def _in_inertia(name: str, square: Value, usual: Value, words: str) -> Numbered:
    """Return that a square in the bat's moment of inertia has another number than the usual one."""

    def inertia(v: View, number: float) -> float:
        own = moment_of_inertia(v.scene.bat, v.scene.reading, DOUBLES)
        return float(own + (number - usual(v)) * v.M * square(v))

    def restitution(v: View, number: float) -> Numbers:
        printed = v.scene.reading.bat_ball_restitution == "as_printed"
        ratio = v.ratio * inertia(v, usual(v)) / inertia(v, number)
        return (_printed(v.e, 1, ratio) if printed else v.e,)

    def number(v: View, said: Numbers) -> float:
        other = inertia(v, usual(v)) * (v.ratio * (1 + v.e) / (said[0] - v.e) - 1)
        return float(usual(v) + other / (v.M * square(v)))

    return Numbered("impact.restitution", name, f"has {{}} {words} in its moment of inertia, "
                    "M(L²/3 + r_b²/4)", "I = M(L²/3 + r_b²/4) about the end B",
                    restitution, number)  # fmt: skip


NUMBERED: tuple[Numbered, ...] = (
    Numbered("contact.position", "contact-off-centre", "gives as the contact a point off the "
             "ball's centre, nearer to the bat by {} times the ball's radius",
             "contact.position is where the ball's centre is",
             lambda v, radii: plus(
                 v["contact.position:follows"], -radii * v.scene.ball.radius, v.normal),
             lambda v, said: dot(
                 plus(v["contact.position:follows"], -1.0, said), v.normal) / v.scene.ball.radius),
    Numbered("contact.normal", "normal-by-number", "divides the normal by {} m, not by its length",
             "n is a unit vector", lambda v, length: _times(1 / length, v.axis),
             lambda v, said: math.hypot(*v.axis) / math.hypot(*said)),
    Numbered("contact.normal", "normal-along-bat", "gives the normal a part along the bat: "
             "(x, {} y, z - z_b) stands for (x, 0, z - z_b)",
             "n is perpendicular to the bat's axis: its y is 0",
             lambda v, share: _unit((v.axis[0], share * v.position[1], v.axis[2])),
             lambda v, said: said[1] * math.hypot(*v.axis)
             / (v.position[1] * math.hypot(said[0], said[2]))),
    Numbered("contact.bat_velocity", "pivot-elsewhere", "lets the bat turn about a point {} times "
             "its length from the middle", "the pivot B is at y = +L/2: r̃ = L/2 - y",
             lambda v, share: tuple(
                 v.scene.swing.angular_speed * (share * v.scene.bat.length - v.position[1]) * x
                 for x in (math.cos(_tilt(v)), 0.0, math.sin(_tilt(v)))),
             lambda v, said: (math.copysign(math.hypot(*said), said[0])
                              / v.scene.swing.angular_speed + v.position[1]) / v.scene.bat.length),
    _in_inertia("bat-inertia", lambda v: v.scene.bat.radius**2, _round,
                "r_b² for the bat's radius"),
    _in_inertia("bat-inertia-of-length", lambda v: v.scene.bat.length**2, lambda v: 1 / 3,
                "L² for the bat's length"),
)  # fmt: skip
