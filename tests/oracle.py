"""The oracle: scenes of every kind and key solved once more, from `docs/model.md` alone.

The sections follow the page, with its equations beside the lines that compute them. Nothing of
longball is imported, and no method is shared with it. Flights are flown in space by SciPy's
DOP853, in steps that end wherever the law has a kink or a jump. Events are found by sampling the
flight densely and by Brent's method. Formulas are written out, term by term.

The same formulas take floats or numbers of many digits (mpmath). In many digits the flight of
doubles tells only where to look: at a time in mpmath a state is integrated by `extrapolation.py`,
from the nearest one known, and signs that doubles cannot tell, kinks and events are found with it.

A scene is the JSON object of the contract; what it leaves out is filled in here. `solve` returns an
`Answer`: a result with the contract's keys, and the scene's distance from another outcome.
"""

import math
from bisect import bisect_left, bisect_right
from itertools import pairwise
from typing import NamedTuple

import mpmath
import numpy as np
from mpmath import mpf
from scipy.integrate import DOP853
from scipy.optimize import brentq

from tests import extrapolation

STEP = 0.04  # s, the longest step: the dense output is then as precise as the steps
SAMPLES = 8  # of a step: two events within one of them are taken for none, or found as a dip
FINE = mpf("1e-15")  # below what doubles tell, above the roundings of many digits
NEAR = 1e-8  # a value so near to zero is asked for again in many digits, if there are any

# ---- numbers -------------------------------------------------------------------------------------


def of(number):
    """Functions of a number: those of floats, or of mpmath."""
    return mpmath if isinstance(number, mpf) else math


def mapped(number, data):
    """Data with `number` of each of its numbers."""
    if isinstance(data, dict):
        return {key: mapped(number, value) for key, value in data.items()}
    if isinstance(data, list | tuple | np.ndarray):
        return [mapped(number, value) for value in data]
    return number(data) if isinstance(data, int | float | mpf) else data


# ---- vectors -------------------------------------------------------------------------------------


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def length(a):
    square = dot(a, a)
    return of(square).sqrt(square)


def times(factor, a):
    return (factor * a[0], factor * a[1], factor * a[2])


def minus(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


# ---- keys and defaults ---------------------------------------------------------------------------

DEFAULTS = {
    "ball": {"mass": 0.145, "radius": 0.0366, "restitution": 0.42, "inertia_factor": 0.4},
    "air": {"density": 1.29, "drag_coefficient": 0.4, "lift_coefficient": 0.2},
    "pitch": {"speed": 36.9125, "release": [18.44, 0.0, 1.8], "aim": [0.0, 1.8]},
    "bat": {"mass": 0.9, "length": 1.0, "radius": 0.033, "tangential_restitution": 0.3},
    "swing": {"angular_speed": 34.0, "tilt": math.pi / 36, "height_offset": 0.0},
    "ground": {"height": 0.0},
}
READINGS = {
    "effective_mass": "inertia_over_r_squared",
    "bat_ball_restitution": "as_printed",
    "reduced_mass": "bat_mass",
    "inertia": "solid_cylinder",
    "lift_direction": "fixed_spin_axis",
    "ground_contact": "centre",
    "slide_direction": "initial",
    "spin_parameter": "transverse",
    "drag_spin": "transverse",
    "spin_decay": "path",
    "wind_acts_on": "both",
    "pressure": "sea_level",
    "fence_clearance": "centre",
    "distance_origin": "plate",
}
LAWS = {
    "spin": {"constant": 0.3008, "per_spin": 2.788e-4},
    "crisis": {"high_speed": 0.33, "low_speed": 0.5, "speed": 31.4, "width": 3.0, "per_spin": 0.0},
    "rational": {"numerator": 1.12, "constant": 0.583, "slope": 2.333},
    "linear": {"slope": 1.0},
}
WEATHER = {"temperature": 288.15, "pressure": 101325.0, "humidity": 0.0, "elevation": 0.0}


def filled(scene):
    """Write every default into a scene."""
    full = {"gravity": 9.8, "time_limit": 60.0, "earth": None, "fence": None} | scene
    for block, values in DEFAULTS.items():
        if block == "air" and scene.get("air", {}) is None:
            full["air"] = {"density": 0.0, "drag_coefficient": 0.0, "lift_coefficient": 0.0}
        else:
            full[block] = values | scene.get(block, {})
    air = full["air"] = dict(full["air"])
    if isinstance(air["density"], dict):
        air["density"] = WEATHER | air["density"]
    for key in ("drag_coefficient", "lift_coefficient"):
        if isinstance(air[key], dict):
            air[key] = LAWS.get(air[key]["law"], {}) | air[key]
    full["reading"] = READINGS | scene.get("reading", {})
    return full


# ---- air: density, wind, coefficients ------------------------------------------------------------


def density(air, reading):
    """ρ at height 0."""
    if not isinstance(air["density"], dict):
        return air["density"]
    weather = air["density"]
    kelvin, celsius = weather["temperature"], weather["temperature"] - 273.15
    pressure = weather["pressure"]
    exp = of(kelvin).exp
    if reading["pressure"] == "sea_level":
        pressure = pressure * exp(-1.217e-4 * weather["elevation"])
    saturated = 611.16 * exp((18.687 - celsius / 234.5) * celsius / (257.14 + celsius))
    dry = pressure - 0.3783 * weather["humidity"] * saturated
    return 1.2929 * (273.15 / kelvin) * dry / 101325  # never a constant times a constant: it rounds


def speed_of_sound(air):
    """331.3 √(T/273.15), where there is a temperature."""
    if not isinstance(air["density"], dict):
        return math.nan
    warmth = air["density"]["temperature"] / 273.15
    return 331.3 * of(warmth).sqrt(warmth)


def wind(blowing, z, above):
    """W at a height; `above` tells on which side of the jump the ball is."""
    if not isinstance(blowing, dict):
        return blowing
    if "above" in blowing:
        return blowing["velocity"] if above else (0.0, 0.0, 0.0)
    rough = blowing.get("roughness", 0.03)
    log = of(z).log
    share = log((z + rough) / rough) / log((blowing["height"] + rough) / rough)
    return times(share, blowing["velocity"])


class Coefficient:
    """C_D or C_L: a formula, or straight lines between the nodes of one argument.

    On which of the lines the ball is, the flight tells: it changes at the ends of steps only.
    """

    def __init__(self, given):
        law = given if isinstance(given, dict) else {"law": "constant", "value": given}
        self.keys, self.name, self.of, self.nodes = law, law["law"], None, []
        if self.name == "table":
            self.of, self.nodes, values = law["of"], law["at"], law["values"]
            self.lines = [(values[0], 0.0)]
            for (a, left), (b, right) in pairwise(zip(self.nodes, values, strict=True)):
                slope = (right - left) / (b - a)
                self.lines.append((left - slope * a, slope))
            self.lines.append((values[-1], 0.0))
        elif self.name == "bilinear":
            self.of, self.nodes = "spin_parameter", [0.1]
            self.lines = [(0.0, 1.5), (0.09, 0.6)]

    def argument(self, U, S, sound):
        return {"speed": U, "mach": U / sound, "spin_parameter": S}[self.of]

    def value(self, U, S, spin, sound, piece):
        c = self.keys
        if self.nodes:
            constant, slope = self.lines[piece]
            return constant + slope * self.argument(U, S, sound)
        if self.name == "spin":
            return c["constant"] + c["per_spin"] * spin
        if self.name == "crisis":
            beyond = min((U - c["speed"]) / c["width"], 700)  # e^700 is a double, e^710 is none
            fall = 1 / (1 + of(U).exp(beyond))
            at_speed = c["high_speed"] + (c["low_speed"] - c["high_speed"]) * fall
            return at_speed + c["per_spin"] * spin
        if self.name == "rational":
            return c["numerator"] * S / (c["constant"] + c["slope"] * S)
        if self.name == "linear":
            return c["slope"] * S
        return c["value"]


# ---- flight --------------------------------------------------------------------------------------


class Branch(NamedTuple):
    """Smooth form of the law: it changes at the ends of steps only."""

    above: bool  # the wind's height
    drag: int  # line of the drag's table
    lift: int
    vertical: bool  # `always_up` after the ball has turned vertical


def across(direction, along):
    """The unit vector of a direction made perpendicular to the unit vector `along`."""
    direction = times(1 / length(direction), direction)
    part = minus(direction, times(dot(direction, along), along))
    if length(part) < 2e-6:
        raise Unclear("a side force along the velocity")
    return times(1 / length(part), part)


class Law:
    """The acceleration of a ball. A state is r, v and the path through the air since the launch."""

    def __init__(self, scene, velocity, spin):
        ball, air, reading = scene["ball"], scene["air"], scene["reading"]
        m = of(ball["mass"])
        self.many_digits = m is mpmath
        self.in_floats = self
        if self.many_digits:
            self.in_floats = Law(*(mapped(float, given) for given in (scene, velocity, spin)))
        self.radius, self.gravity, self.reading = ball["radius"], scene["gravity"], reading
        # k = ρ A/(2m) at height 0, which falls as e^{-z/H}.
        area = m.pi * ball["radius"] ** 2
        self.k = density(air, reading) * area / (2 * ball["mass"])
        self.scale_height = air.get("density_scale_height")
        self.wind = air.get("wind")
        self.drag = Coefficient(air["drag_coefficient"])
        self.lift = Coefficient(air["lift_coefficient"])
        self.side = air.get("side_coefficient")
        self.sound = speed_of_sound(air)
        self.spin, self.decay_length = spin, air.get("spin_decay_length")
        # ê = (sin φ, -cos φ, 0), with the first velocity along (cos φ, sin φ).
        level = m.hypot(velocity[0], velocity[1])
        self.heading = (velocity[0] / level, velocity[1] / level) if level else (1.0, 0.0)
        self.axis = (self.heading[1], -self.heading[0], 0.0)
        self.rotation = None
        if scene["earth"] is not None:
            latitude, azimuth = scene["earth"]["latitude"], scene["earth"].get("azimuth", 0.0)
            level = 7.292115e-5 * m.cos(latitude)
            self.rotation = (
                level * m.cos(azimuth),
                level * m.sin(azimuth),
                7.292115e-5 * m.sin(latitude),
            )

    def through_air(self, y, branch):
        """u = v - W."""
        if self.wind is None:
            return tuple(y[3:6])
        return minus(y[3:6], wind(self.wind, y[2], branch.above))

    def spin_at(self, t, y, branch):
        """ω, which keeps its direction: e^{-s/L}, or e^{-t V_r/L}, or e^{-t U/L}."""
        if self.decay_length is None or self.spin is None:
            return self.spin
        way = {
            "path": lambda: y[6],
            "time": lambda: t * 44.704,
            "nathan": lambda: t * length(self.through_air(y, branch)),
        }[self.reading["spin_decay"]]()
        return times(of(way).exp(-way / self.decay_length), self.spin)

    def parameters(self, spin, u):
        """U, S and c = ω × u of a ball that moves with u."""
        U = length(u)
        if spin is None or U == 0:
            return U, 0.0, (0.0, 0.0, 0.0)
        c = cross(spin, u)
        turning = length(c) / U if self.reading["spin_parameter"] == "transverse" else length(spin)
        return U, self.radius * turning / U, c

    def arguments(self, t, y, branch):
        """Arguments of the tables of drag and lift."""
        spin, u = self.spin_at(t, y, branch), self.through_air(y, branch)
        lifted = u if self.reading["wind_acts_on"] == "both" else tuple(y[3:6])
        found = []
        for law, moving in ((self.drag, u), (self.lift, lifted)):
            U, S, _ = self.parameters(spin, moving)
            found.append(law.argument(U, S, self.sound) if law.nodes else 0.0)
        return found

    def slopes(self, t, y, branch):
        """Rates of r, v and the path."""
        return [*y[3:6], *self.acceleration(t, y, branch), length(self.through_air(y, branch))]

    def branch_at(self, t, y, before=None, above=None):
        """The branch of a state that is on no switch, unless `above` tells the side of the wind."""
        if above is None:
            height = self.wind.get("above") if isinstance(self.wind, dict) else None
            above = height is not None and y[2] > height
        vertical = before.vertical if before else not (y[3] or y[4])
        branch = Branch(above, 0, 0, vertical)
        drag, lift = self.arguments(t, y, branch)
        return branch._replace(
            drag=bisect_right(self.drag.nodes, drag), lift=bisect_right(self.lift.nodes, lift)
        )

    def switches(self, t, y, branch):
        """Name, value, lower and upper bound of what has to stay between them on this branch."""
        if isinstance(self.wind, dict) and "above" in self.wind:
            height = self.wind["above"]
            yield ("above", y[2], *((height, math.inf) if branch.above else (-math.inf, height)))
        for name, law, value in zip(
            ("drag", "lift"), (self.drag, self.lift), self.arguments(t, y, branch), strict=True
        ):
            if law.nodes:
                nodes, piece = [-math.inf, *law.nodes, math.inf], getattr(branch, name)
                yield name, value, nodes[piece], nodes[piece + 1]
        upwards = self.spin is None and self.reading["lift_direction"] == "always_up"
        if upwards and not branch.vertical:
            forward = self.heading[0] * y[3] + self.heading[1] * y[4]
            yield "vertical", forward, 0.0, math.inf

    def acceleration(self, t, y, branch):
        """-k C_D U u + lift + k C_S U² ê - g ẑ - 2 Ω × v."""
        v = tuple(y[3:6])
        total = [0.0, 0.0, -self.gravity]
        if self.rotation is not None:
            for i, turned in enumerate(cross(self.rotation, v)):
                total[i] -= 2 * turned
        k = self.k
        if self.scale_height:
            k = k * of(k).exp(-y[2] / self.scale_height)
        if k == 0:
            return total
        spin, u = self.spin_at(t, y, branch), self.through_air(y, branch)
        U, S, c = self.parameters(spin, u)
        if U > 0:
            whole = self.reading["drag_spin"] == "total"
            turning = 0.0 if spin is None else length(spin) if whole else length(cross(spin, u)) / U
            drag = self.drag.value(U, S, turning, self.sound, branch.drag)
            for i in range(3):
                total[i] -= k * drag * U * u[i]
        # All of the lift is that of u, or of v.
        moving = u
        if self.reading["wind_acts_on"] == "drag":
            moving = v
            U, S, c = self.parameters(spin, moving)
        if U == 0:
            return total
        lift = self.lift.value(U, S, 0.0, self.sound, branch.lift)
        direction = self.lift_direction(spin, moving, U, c, branch)
        for i in range(3):
            total[i] += k * lift * U * U * direction[i]
        if self.side is not None and self.side["value"] != 0:
            aside = across(self.side["direction"], times(1 / U, moving))
            for i in range(3):
                total[i] += k * self.side["value"] * U * U * aside[i]
        return total

    def lift_direction(self, spin, moving, U, c, branch):
        if spin is None:
            # `always_up`: the ball moves forward until it is vertical, so that + points upwards.
            if self.reading["lift_direction"] == "always_up" and branch.vertical:
                return (0.0, 0.0, 0.0)
            return times(1 / U, cross(self.axis, moving))  # ê × u/U
        if length(c) == 0:
            return (0.0, 0.0, 0.0)
        if self.reading["spin_parameter"] == "total":  # k R (C_L/S) c = k C_L U² c/(U ω)
            return times(1 / (U * length(spin)), c)
        return times(1 / length(c), c)


class Unclear(Exception):
    """A scene in which the page says nothing of what happens, or that it has no answer."""


class Flight:
    """A ball's states at times since its start, until it is under the floor or `beyond` is true.

    At a time in mpmath a state has many digits; at one in doubles it is that of DOP853.
    """

    def __init__(self, law, start, floor, limit, beyond=lambda y: False, longest=STEP):
        self.law, self.floor, self.limit = law, floor, limit
        self.beyond, self.longest = beyond, longest
        self.legs = []  # in many digits: where a smooth form of the law begins, and its states
        t, y = self.sharp(0.0), np.array([*start, self.sharp(0.0)])
        branch, seen = law.branch_at(t, y), y.astype(float)
        self.times, self.pieces, self.states = [0.0], [(lambda t: seen, branch)], {0.0: seen}
        while t < limit and not self.over(y):
            t, y, branch = self._fly(t, y, branch)

    def sharp(self, t):
        """A time with the digits that the law has."""
        return mpf(t) if self.law.many_digits else t

    def over(self, y):
        # A hair under the floor, so that a landing at the very height of a switch is passed, too.
        return y[2] < self.floor - 1e-9 or self.beyond(y)

    def _fly(self, t, y, branch):
        """Fly on one branch to its end: time, state and branch to go on with."""
        law, leg = self.law.in_floats, None
        if self.law.many_digits:
            leg = extrapolation.Leg(lambda t, y: self.law.slopes(t, y, branch), t, y)
            self.legs.append((t, leg, branch))

        def slopes(t, y):
            return law.slopes(t, y.tolist(), branch)

        start, limit = float(t), float(self.limit)
        y = np.array(y, dtype=float)
        solver = DOP853(slopes, start, y, limit, rtol=1e-13, atol=1e-14, max_step=self.longest)
        while solver.status == "running" and not self.over(solver.y):
            if isinstance(law.wind, dict) and "height" in law.wind:
                # Below the roughness there is no profile: step to the ground by halves.
                fall = float(solver.y[2] - self.floor) / (2 * length(solver.y[3:6]) + 1e-9)
                solver.max_step = min(self.longest, max(fall, 2e-5))
            solver.step()
            assert solver.status != "failed", "DOP853 finds no step"
            dense = solver.dense_output()

            def at(t, dense=dense):
                return np.array(leg.at(t)) if isinstance(t, mpf) else dense(t)

            grid = np.linspace(solver.t_old, solver.t, SAMPLES + 1)
            for before, now, y in zip(grid, grid[1:], dense(grid[1:]).T, strict=False):
                switch = self._switch(at, t if before == start else before, now, y, branch)
                self.times.append(now if switch is None else float(switch[0]))
                self.pieces.append((dense, branch))
                if switch is not None:
                    return switch
                self.states[now] = y
        return solver.t, solver.y, branch

    def _switch(self, at, before, now, y, branch):
        """Time, state and next branch at the first switch of the law between two times, if any."""
        law, first = self.law, None
        for index, (name, value, *bounds) in enumerate(law.in_floats.switches(now, y, branch)):
            for step, bound in zip((-1, 1), bounds, strict=True):
                if math.isinf(bound) or not (law.many_digits or step * (bound - value) < 0):
                    continue
                time = self._leaving(at, before, now, branch, index, step)
                if time is not None and (first is None or time < first[0]):
                    first = (time, name, step)
        if first is None:
            return None
        time, name, step = first
        y = at(time)
        if name == "vertical":
            if law.rotation is not None:
                raise Unclear("always_up: a ball that turns vertical while the Earth turns")
            y[3] = y[4] = self.sharp(0.0)
            return time, y, branch._replace(vertical=True)
        if name == "above":
            # The airspeed jumps: the tables are read anew on the other side.
            y[2] = law.wind["above"]
            return time, y, law.branch_at(time, y, branch, above=step > 0)
        return time, y, branch._replace(**{name: getattr(branch, name) + step})

    def _leaving(self, at, before, now, branch, index, step):
        """Time at which what has to stay within bounds leaves them on one side, if it does."""

        def room(t, y=None):
            law = self.law if isinstance(t, mpf) else self.law.in_floats
            _, value, *bounds = list(law.switches(t, at(t) if y is None else y, branch))[index]
            return step * (bounds[step > 0] - value)

        def rate(t):
            law, h = (self.law, FINE) if isinstance(t, mpf) else (self.law.in_floats, 1e-6)
            y = at(t)
            way = np.array(law.slopes(t, y.tolist(), branch)) * h
            return (room(t + h, y + way) - room(t - h, y - way)) / (2 * h)

        if not self.law.many_digits:
            # After a restart on the bound itself, the ball may seem to be a rounding outside.
            return self.root(room, before, now) if room(before) > 0 else before
        on_bound = isinstance(before, mpf) and abs(room(before)) < 100 * extrapolation.tolerance()
        if on_bound and rate(before) < 0:
            return before  # where the leg starts
        return first_fall(self, room, rate, Doubt(), "", [before, now])

    def root(self, function, low, high):
        """Zero of a function of time between two times at which its signs differ."""
        if not self.law.many_digits:
            return brentq(function, low, high, xtol=1e-15)
        try:
            guess = brentq(lambda t: float(function(t)), float(low), float(high), xtol=1e-15)
        except ValueError:  # in doubles they do not
            return extrapolation.zero(function, mpf(low), mpf(high))
        near = max(mpf(low), guess - mpf(NEAR)), min(mpf(high), guess + mpf(NEAR))
        if function(near[0]) * function(near[1]) > 0:
            near = mpf(low), mpf(high)
        return extrapolation.zero(function, *near)

    def leg(self, t):
        """Where a time in mpmath lies: the leg that comes there, and its branch."""
        place = bisect_left(self.legs, t, key=lambda leg: leg[0])
        return self.legs[max(place - 1, 0)][1:]

    def at(self, t):
        """State at a time."""
        if isinstance(t, mpf):
            return np.array(self.leg(t)[0].at(t))
        if t not in self.states:
            self.states[t] = self.pieces[bisect_left(self.times, t)][0](t)
        return self.states[t]

    def spin(self, t, doubt):
        """ω at a time, in the air in which the ball has come there."""
        y, law = self.at(t), self.law
        if law.reading["spin_decay"] == "nathan" and isinstance(law.wind, dict):
            doubt.weigh("the wind in which a spin is told", y[2] - law.wind.get("above", math.inf))
        many = isinstance(t, mpf)
        branch = self.leg(t)[1] if many else self.pieces[bisect_left(self.times, t)][1]
        return law.spin_at(t, y, branch)


# ---- events --------------------------------------------------------------------------------------


class Doubt:
    """The least distance of a scene from another outcome, in SI units."""

    def __init__(self):
        self.least, self.question = math.inf, "nothing"

    def weigh(self, question, distance):
        if not abs(distance) >= self.least:
            self.least, self.question = abs(distance), question


def seen(flight, function, t):
    """Value of a function at a time in doubles, in many digits if it may be zero."""
    value = function(t)
    return value if abs(value) > NEAR else function(flight.sharp(t))


def falls(flight, value, rate, doubt, question, times=None):
    """Yield the times at which a function of time falls through zero; dips between samples, too.

    Of the rate only the sign matters.
    """
    times = flight.times if times is None else times
    before, height, slope = times[0], seen(flight, value, times[0]), rate(times[0])
    for now in times[1:]:
        height_now, slope_now = seen(flight, value, now), rate(now)
        # From zero, perhaps for less than a sample; two samples may be at zero.
        rises = abs(height) < FINE and slope > 0 and not slope_now > 0
        if (height > 0 or rises) and height_now <= 0:
            yield flight.root(value, flight.root(rate, before, now) if rises else before, now)
        elif height > 0 and slope < 0 < slope_now:
            bottom = flight.root(rate, before, now)
            doubt.weigh(question, value(bottom))
            if value(bottom) < 0:
                yield flight.root(value, before, bottom)
        before, height, slope = now, height_now, slope_now


def first_fall(flight, value, rate, doubt, question, times=None):
    return next(falls(flight, value, rate, doubt, question, times), None)


def landing_time(flight, doubt):
    """Time at which the centre falls through the floor: 0, if it starts there and does not rise."""
    zero = flight.sharp(0.0)
    start = flight.at(zero)
    if start[2] == flight.floor:
        branch = flight.law.branch_at(zero, start)
        rise = start[5] or flight.law.acceleration(zero, start, branch)[2]
        doubt.weigh("a start on the ground", rise)
        if rise <= 0:
            return zero
    time = first_fall(
        flight,
        lambda t: flight.at(t)[2] - flight.floor,
        lambda t: flight.at(t)[5],
        doubt,
        "a dip to the ground",
    )
    if time is not None:
        doubt.weigh("landing at the time limit", time - flight.limit)
    return time


# ---- pitch ---------------------------------------------------------------------------------------


def thrown(scene):
    """First velocity of a pitch: given, or V₀ towards the point aimed at."""
    pitch = scene["pitch"]
    if "velocity" in pitch:
        return tuple(pitch["velocity"])
    way = minus((0.0, *pitch["aim"]), pitch["release"])
    return times(pitch["speed"] / length(way), way)


def floor_of(scene):
    """Height of the ball's centre when it lands."""
    surface = scene["reading"]["ground_contact"] == "surface"
    return scene["ground"]["height"] + (scene["ball"]["radius"] if surface else 0.0)


def plate_of(flight, doubt):
    """The first crossing of x = 0, unless the pitch lands before; and the outcome of a pitch."""
    time = first_fall(
        flight, lambda t: flight.at(t)[0], lambda t: flight.at(t)[3], doubt, "the plate"
    )
    landing = landing_time(flight, doubt)
    if time is not None and landing is not None:
        doubt.weigh("plate or ground", (time - landing) * 30)
    if landing is not None and (time is None or landing < time):
        return None, "grounded"
    if time is None:
        return None, "airborne"
    doubt.weigh("plate at the time limit", time - flight.limit)
    y = flight.at(time)
    m = of(time)
    approach = {
        "vertical": m.atan2(y[5], m.hypot(y[3], y[4])),
        "horizontal": m.atan2(y[4], -y[3]),
    }
    plate = {"time": time, "position": y[:3], "velocity": y[3:6], "approach": approach}
    return plate, "crossed"


def touching(flight, height, reach, doubt):
    """First time at R + r_b from the bat's axis, if any, and the margin, over the search."""

    def gap(t):
        y = flight.at(t)
        return of(y[0]).hypot(y[0], y[2] - height) - reach

    def opening(t):
        y = flight.at(t)
        return y[0] * y[3] + (y[2] - height) * y[5]

    passed = first_fall(
        flight, lambda t: flight.at(t)[0] + reach, lambda t: flight.at(t)[3], doubt, "the bat"
    )
    ends = [t for t in (passed, landing_time(flight, doubt), flight.times[-1]) if t is not None]
    end = min(ends)  # in many digits, if it is an event
    # Past the bat the ball flies some centimetres: finer samples than those of the flight.
    coarse = [t for t in flight.times if t < end]
    last = float(end)
    fine = np.linspace(next((t for t in coarse if flight.at(t)[0] < 4), last), last, 400)
    samples = sorted({*coarse, *fine})
    closest = min(samples, key=gap)
    around = samples.index(closest)
    low, high = samples[max(around - 1, 0)], samples[min(around + 1, len(samples) - 1)]
    if opening(low) < 0 < opening(high):
        closest = flight.root(opening, low, high)
    margin = -gap(end if closest == last else flight.sharp(closest))
    doubt.weigh("a graze", margin)
    start = flight.sharp(0.0)
    if gap(start) == 0 and opening(start) < 0:
        return start, margin  # released where they touch
    return first_fall(flight, gap, opening, Doubt(), "", samples), margin


# ---- contact and impact --------------------------------------------------------------------------


def bat_inertia(scene):
    """I about B, and J about the middle, both across the axis, as the reading `inertia` has it."""
    bat = scene["bat"]
    M, L, rb = bat["mass"], bat["length"], bat["radius"]
    thick = 0.0 if scene["reading"]["inertia"] == "thin_rod" else rb**2 / 4
    middle = M * (L**2 / 12 + thick)
    if scene["reading"]["inertia"] == "about_centre":
        return middle, middle
    return M * (L**2 / 3 + thick), middle


def contact_of(scene, normal, position, velocity):
    """n, V_b and Ṽ·n."""
    swing = scene["swing"]
    theta, arm = swing["tilt"], scene["bat"]["length"] / 2 - position[1]
    speed = swing["angular_speed"] * arm
    m = of(theta)
    bat_velocity = (speed * m.cos(theta), 0.0, speed * m.sin(theta))
    return {
        "position": position,
        "normal": normal,
        "bat_velocity": bat_velocity,
        "normal_speed": dot(minus(velocity, bat_velocity), normal),
    }


def collide(scene, contact, velocity, spin, doubt):
    """The impulse on the ball, by the readings of its size, and with friction."""
    ball, bat, reading = scene["ball"], scene["bat"], scene["reading"]
    m, M, y = ball["mass"], bat["mass"], contact["position"][1]
    n, bat_velocity, closing = (contact[k] for k in ("normal", "bat_velocity", "normal_speed"))
    arm = bat["length"] / 2 - y
    about_pivot, about_middle = bat_inertia(scene)
    if bat.get("support") == "free":
        effective = 1 / (1 / M + y**2 / about_middle)
    elif reading["effective_mass"] == "as_printed":
        effective = about_pivot / arm
    else:
        effective = about_pivot / arm**2
    e, struck = ball["restitution"], M
    if reading["bat_ball_restitution"] == "as_printed":
        e = e * (1 + m / effective) + m / effective
        if reading["reduced_mass"] == "effective_mass":
            struck = effective
    elif reading["bat_ball_restitution"] == "nathan":
        struck = effective
    mu = 1 / (1 / m + 1 / struck)
    impact = {"restitution": e}
    if "friction" in bat:
        P, impact["spin"], more = rub(scene, contact, velocity, spin, e, mu, doubt)
        impact |= more
    else:
        P = -mu * (1 + e) * closing * np.array(n)
        impact["impulse"] = -mu * (1 + e) * closing
        impact["energy_change"] = -mu * (1 - e**2) * closing**2 / 2
        if spin is not None:
            impact |= {"spin": spin, "mode": "frictionless"}
    after = np.array(velocity) + P / m
    impact["velocity"] = after
    # A bat that swings on strikes again a ball that leaves more slowly than the bat came.
    ahead = dot(after, n) - dot(bat_velocity, n)
    together = sum(map(abs, velocity)) + sum(map(abs, bat_velocity))
    doubt.weigh("recontact", abs(ahead) / together - 1e-6)
    if abs(ahead) < 1e-6 * together:
        impact["recontact"] = "possible"
    elif ahead < 0:
        impact["recontact"] = "certain"
    return impact


def solved(K, g):
    """P of K P = g."""
    if K.dtype == float:
        return np.linalg.solve(K, g)
    return np.array(list(mpmath.lu_solve(mpmath.matrix(K.tolist()), mpmath.matrix(g.tolist()))))


def rub(scene, contact, velocity, spin, e, mu, doubt):
    """The oblique impact: the impulse P, the spin after it, and what else the result tells."""
    ball, bat, swing = scene["ball"], scene["bat"], scene["swing"]
    m, R, M, L, rb = ball["mass"], ball["radius"], bat["mass"], bat["length"], bat["radius"]
    inertia, theta, friction = ball["inertia_factor"] * m * R**2, swing["tilt"], bat["friction"]
    n, V, Vb = (np.array(v) for v in (contact["normal"], velocity, contact["bat_velocity"]))
    before = np.zeros(3) if spin is None else np.array(spin)
    sin, cos = of(theta).sin(theta), of(theta).cos(theta)
    turning = swing["angular_speed"] * np.array([-sin, 0.0, cos])
    g = V + np.cross(before, -R * n) - Vb - np.cross(turning, rb * n)
    # K = 1/m + R²/I (1 - n nᵀ) + K_bat, with 1/μ in place of n·K n.
    about_pivot, about_middle = bat_inertia(scene)
    free = bat.get("support") == "free"
    across = about_middle if free else about_pivot
    to_axis = np.array([0.0, contact["position"][1] - (0.0 if free else L / 2), 0.0])
    r = to_axis + rb * n
    by_r = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
    K = np.eye(3) / m + R**2 / inertia * (np.eye(3) - np.outer(n, n))
    K += by_r.T @ np.diag([1 / across, 2 / (M * rb**2), 1 / across]) @ by_r
    if free:
        K += np.eye(3) / M
    K += (1 / mu - n @ K @ n) * np.outer(n, n)
    # Grip: K P = -[(1 + ẽ)(g·n) n + (1 + e_T) g_t].
    slip = g - (g @ n) * n
    grip = -solved(K, (1 + e) * (g @ n) * n + (1 + bat["tangential_restitution"]) * slip)
    across_n = grip - (grip @ n) * n
    margin = 1 - length(across_n) / (friction * (grip @ n))
    doubt.weigh("grip or slide", margin)
    doubt.weigh("no normal impulse of a grip", grip @ n)
    mode, P = "grip", grip
    if not length(across_n) <= friction * (grip @ n):
        final = scene["reading"]["slide_direction"] == "final"
        along = -across_n if final else slip
        size = length(along)
        along = along / size if size else along
        pushing = n @ K @ (n - friction * along)
        doubt.weigh("jamming", pushing * mu)
        if pushing <= 0:
            raise Unclear("ball and bat jam")
        mode, P = "slide", -(1 + e) * (g @ n) / pushing * (n - friction * along)
    spin = before - R / inertia * np.cross(n, P)
    return (
        P,
        spin,
        {
            "mode": mode,
            "friction_margin": margin,
            "impulse": P @ n,
            "energy_change": P @ (g + K @ P / 2),
        },
    )


# ---- fence ---------------------------------------------------------------------------------------


def is_fair(y, doubt):
    doubt.weigh("fair or foul", abs(y[1]) - y[0])
    return bool(abs(y[1]) <= y[0])


def fence_crossings(scene, flight, doubt):
    """Yield time, height of the fence, segment and margin of the crossings of each chord."""
    fence = scene["fence"]
    if "radius" in fence:
        time = first_fall(
            flight,
            lambda t: fence["radius"] - of(flight.at(t)[0]).hypot(*flight.at(t)[:2]),
            lambda t: -(flight.at(t)[:2] @ flight.at(t)[3:5]),
            doubt,
            "a touch of the circle",
        )
        if time is not None:
            yield time, 0.0, 0, None
        return
    for segment, (a, b) in enumerate(pairwise(fence["polyline"])):
        along = np.array(b[:2]) - a[:2]
        chord = of(along[0]).hypot(*along)
        if chord == 0:
            continue  # the height steps

        def inside(t, a=a, along=along, chord=chord):
            r = flight.at(t)[:2] - a[:2]
            return -(along[0] * r[1] - along[1] * r[0]) / chord

        def inward(t, along=along, chord=chord):
            v = flight.at(t)[3:5]
            return -(along[0] * v[1] - along[1] * v[0]) / chord

        for time in falls(flight, inside, inward, Doubt(), ""):
            part = (flight.at(time)[:2] - a[:2]) @ along / chord**2
            doubt.weigh("a vertex of the fence", min(abs(part), abs(1 - part)) * chord)
            if 0 <= part < 1:
                height = a[2] + part * (b[2] - a[2])
                yield time, height, segment, min(part, 1 - part) * chord


def fence_of(scene, flight, landing, doubt):
    """The crossing by which the ball leaves the field before it lands, if it does."""
    if scene["fence"] is None:
        return None
    crossings = sorted(fence_crossings(scene, flight, doubt), key=lambda found: found[0])
    for time, height, segment, margin in crossings:
        if landing is not None:
            doubt.weigh("ground or fence", (time - landing) * 30)
        if landing is None or time < landing:
            doubt.weigh("fence at the time limit", time - flight.limit)
            y = flight.at(time)
            surface = scene["reading"]["fence_clearance"] == "surface"
            clearance = y[2] - height - (scene["ball"]["radius"] if surface else 0.0)
            doubt.weigh("over the fence", clearance)
            block = {"time": time, "position": y[:3], "velocity": y[3:6], "clearance": clearance}
            block["segment"] = segment
            return block | ({} if margin is None else {"margin": margin})
    return None


# ---- scenes --------------------------------------------------------------------------------------


class Answer(NamedTuple):
    result: dict
    doubt: Doubt


def solve(scene, longest=STEP, digits=None):
    """Result of a scene, and its distance from another outcome; in doubles, or so many digits."""
    scene, doubt = filled(scene), Doubt()
    kinds = {"flight": of_flight, "pitch": of_pitch, "impact": of_impact, "at-bat": of_at_bat}
    solve_kind = kinds[scene["kind"]]
    if digits is None:
        return Answer(solve_kind(scene, doubt, longest), doubt)
    with mpmath.workdps(digits + extrapolation.SPARE):
        scene = mapped(lambda number: mpf(float(number)), scene)
        return Answer(solve_kind(scene, doubt, longest), doubt)


def of_flight(scene, doubt, longest):
    launch = scene["launch"]
    ball = tuple(launch["position"]), tuple(launch["velocity"]), launch.get("spin")
    return fly_out(scene, "landed", ball, 0.0, doubt, longest)


def of_pitch(scene, doubt, longest):
    flight = pitched(scene, 0.0, longest)
    plate, outcome = plate_of(flight, doubt)
    return {"outcome": outcome} | ({"plate": plate} if plate else {})


def pitched(scene, reach, longest):
    """A pitch, until it has passed x = -reach."""
    velocity = thrown(scene)
    return Flight(
        Law(scene, velocity, scene["pitch"].get("spin")),
        (*scene["pitch"]["release"], *velocity),
        floor_of(scene),
        scene["time_limit"],
        lambda y: y[0] < -reach,
        longest,
    )


def of_impact(scene, doubt, _):
    incoming = scene["incoming"]
    position, velocity = tuple(incoming["position"]), tuple(incoming["velocity"])
    doubt.weigh("the bat's end", abs(position[1]) - scene["bat"]["length"] / 2)
    if abs(position[1]) >= scene["bat"]["length"] / 2:
        return {"outcome": "beyond_bat"}
    normal = (position[0], 0.0, position[2] - incoming["bat_height"])
    contact = contact_of(scene, times(1 / length(normal), normal), position, velocity)
    doubt.weigh("closing or separating", contact["normal_speed"])
    if contact["normal_speed"] >= 0:
        return {"outcome": "separating", "contact": contact}
    impact = collide(scene, contact, velocity, incoming.get("spin"), doubt)
    return {"outcome": "struck", "contact": contact, "impact": impact}


def of_at_bat(scene, doubt, longest):
    reach = scene["ball"]["radius"] + scene["bat"]["radius"]
    flight = pitched(scene, reach, longest)
    plate, outcome = plate_of(flight, doubt)
    if plate is None:
        return {"outcome": outcome}
    height = plate["position"][2] + scene["swing"]["height_offset"]
    time, margin = touching(flight, height, reach, doubt)
    contact = {"margin": margin}
    known = {"plate": plate, "contact": contact}
    if time is None:
        return {"outcome": "missed"} | known
    y = flight.at(time)
    position, velocity = tuple(y[:3]), tuple(y[3:6])
    contact |= {"time": time, "position": position}
    doubt.weigh("the bat's end", abs(y[1]) - scene["bat"]["length"] / 2)
    if abs(y[1]) >= scene["bat"]["length"] / 2:
        return {"outcome": "beyond_bat"} | known
    normal = times(1 / reach, (y[0], 0.0, y[2] - height))
    contact |= contact_of(scene, normal, position, velocity)
    doubt.weigh("closing or separating", contact["normal_speed"])
    if contact["normal_speed"] >= 0:
        return {"outcome": "separating"} | known
    impact = collide(scene, contact, velocity, flight.spin(time, doubt), doubt)
    ball = position, tuple(impact["velocity"]), impact.get("spin")
    return known | {"impact": impact} | fly_out(scene, "batted", ball, time, doubt, longest)


def highest(flight, end, start):
    """The highest place where a ball ceases to rise, or its launch if it does not rise there."""

    def climb(t):
        return flight.at(t)[5]

    seen = [t for t in flight.times if t < end] + [end]
    tops = [] if climb(seen[0]) > 0 else [seen[0]]
    for before, now in pairwise(seen):
        if climb(before) > 0 >= climb(now):
            tops.append(flight.root(climb, before, now))
    if not tops:
        return {}
    top = flight.sharp(max(tops, key=lambda t: flight.at(t)[2]))
    return {"apex": {"time": start + top, "position": flight.at(top)[:3]}}


def fly_out(scene, landed, ball, start, doubt, longest):
    """Fly a launched or batted ball to fence and ground."""
    position, velocity, spin = ball
    law = Law(scene, velocity, spin)
    flight = Flight(
        law, (*position, *velocity), floor_of(scene), scene["time_limit"], longest=longest
    )
    time = landing_time(flight, doubt)
    fence = fence_of(scene, flight, time, doubt)
    found = {}
    if fence:
        found["fence"] = fence | {"time": start + fence["time"]}
        if fence["clearance"] <= 0:
            return {"outcome": "wall"} | highest(flight, fence["time"], start) | found
    if time is not None:
        y = flight.at(time)
        found |= highest(flight, time, start)
        origin = (0.0, 0.0) if scene["reading"]["distance_origin"] == "plate" else position
        m = of(time)
        found["landing"] = {
            "time": start + time,
            "hang_time": time,
            "position": y[:3],
            "velocity": y[3:6],
            "distance": m.hypot(y[0] - origin[0], y[1] - origin[1]),
            "angle": m.atan2(-y[5], m.hypot(y[3], y[4])),
        }
        if spin is not None:
            found["landing"]["spin"] = flight.spin(time, doubt)
            if law.decay_length is not None and scene["reading"]["spin_decay"] == "path":
                found["landing"]["path"] = y[6]
        if scene["fence"] is not None:
            found["landing"]["fair"] = is_fair(fence["position"] if fence else y, doubt)
    if fence and ("radius" in scene["fence"] or is_fair(fence["position"], doubt)):
        return {"outcome": "home_run"} | found
    return {"outcome": "airborne" if time is None else landed} | found
