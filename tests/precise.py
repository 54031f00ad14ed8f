"""Truth for the tests: scenes solved in high precision, from the equations alone.

Nothing of longball is imported, and little is alike: a flight is flown in space, not in a plane,
by Taylor series about as many times as it needs; events are found by Newton's method on the
series. The numbers are balls (python-flint's `arb`), so the roundings carry their own proof; the
series are cut where their terms fall below the precision asked for, which is no proof, and
`test_precise.py` holds it against exact results.

A scene is the JSON object of the contract with every value written out, as a `dict`. Only the
default reading is known here. Results have the contract's keys.

Regular scenes only: the ball moves all the time, a pitch flies fast past the bat, and a batted
ball does not touch the ground between two eighths of a step and rise again.
"""

from operator import mul

import flint
from flint import arb

DIGITS = 40


def in_digits(digits):
    """Compute with so many digits, and a dozen for the roundings (context, or decorator)."""
    return flint.ctx.workdps(digits + 12)


def vector(values):
    return [arb(value) for value in values]


def dot(a, b):
    return sum(map(mul, a, b))


def cross(a, b):
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def length(a):
    return dot(a, a).nonnegative_part().sqrt()  # a ball about zero has a negative side too


def newton(function, guess):
    """Root of a function that returns its value and its derivative, from a guess nearby."""
    time = guess.mid()
    close = arb(10) ** (-flint.ctx.dps // 2)
    for _ in range(20):
        value, rate = function(time)
        step = (value / rate).mid()
        time = (time - step).mid()
        if abs(step) < close:  # the next step would be about the square of this one
            return time
    raise ArithmeticError("Newton's method does not converge")


# ---- flights -------------------------------------------------------------------------------------


def force_constants(scene):
    """k_D, k_L (1/m) and g (m/s²), from m r'' = -½ C_D ρ A V² v̂ + ½ C_L ρ A V² n̂ + m g."""
    air = scene["air"] or {"density": 0.0, "drag_coefficient": 0.0, "lift_coefficient": 0.0}
    mass, radius = arb(scene["ball"]["mass"]), arb(scene["ball"]["radius"])
    dynamic = arb(air["density"]) * arb.pi() * radius * radius / (2 * mass)
    return (
        dynamic * arb(air["drag_coefficient"]),
        dynamic * arb(air["lift_coefficient"]),
        arb(scene["gravity"]),
    )


class Path:
    """A flight as a chain of Taylor series in the time since launch.

    The lift's direction is n̂ = axis × v̂, with the axis of a backspin that is fixed at launch:
    horizontal, and to the right of where the ball is heading; +x if it goes straight up or down.
    """

    def __init__(self, position, velocity, constants, digits=DIGITS):
        heading = [velocity[0], velocity[1], arb(0)]
        if heading[0] == 0 and heading[1] == 0:
            heading[0] = arb(1)
        self.axis = [c / length(heading) for c in cross(heading, vector((0, 0, 1)))]
        self.constants = constants
        self.order = 2 * digits
        self.smallest = arb(10) ** -(digits + 4)
        self.pieces = []
        self._expand(arb(0), position, velocity)

    def acceleration(self, v):
        drag, lift, gravity = self.constants
        speed, turning = length(v), cross(self.axis, v)
        a = [speed * (lift * t - drag * c) for t, c in zip(turning, v, strict=True)]
        return [a[0], a[1], a[2] - gravity]

    def _expand(self, start, position, velocity):
        """Add the Taylor series about `start`: time, those of r and v, and how far they reach."""
        drag, lift, gravity = self.constants
        r, v = [[c] for c in position], [[c] for c in velocity]
        speed = []
        for n in range(self.order):
            squared = sum(map(last_of_product, v, v))
            if n == 0:
                speed.append(squared.sqrt())
            else:  # V·V = V²
                inner = sum(map(mul, speed[1:], speed[:0:-1]))
                speed.append((squared - inner) / (2 * speed[0]))
            moving = [last_of_product(speed, c) for c in v]
            turning = cross(self.axis, moving)
            for i in range(3):
                a = lift * turning[i] - drag * moving[i]
                if n == 0 and i == 2:
                    a -= gravity
                r[i].append(v[i][n] / (n + 1))
                v[i].append(a / (n + 1))
        # The terms fall like those of a geometric series: where one is small, so are all after it.
        # In balls, since near rest they are beyond the range of a double.
        reach = arb(1)
        for n in (self.order - 1, self.order):
            size = max(abs(c[n]).upper() for c in v)
            if size > self.smallest:
                reach = min(reach, (self.smallest / size).root(n).mid())
        self.pieces.append((start, r, v, reach))

    def _go_on(self):
        start, _, _, reach = self.pieces[-1]
        end = (start + reach).mid()
        self._expand(end, *self._evaluate(self.pieces[-1], end))

    def _evaluate(self, piece, time):
        start, r, v, _ = piece
        t = time - start
        return [horner(c, t) for c in r], [horner(c, t) for c in v]

    def at(self, time):
        """Position and velocity at a time since launch."""
        while time > self.pieces[-1][0] + self.pieces[-1][3]:
            self._go_on()
        piece = next((p for p in reversed(self.pieces) if time >= p[0]), self.pieces[0])
        return self._evaluate(piece, time)

    def grid(self):
        """Yield times since launch without end, eight to a series."""
        index = 0
        while True:
            start, _, _, reach = self.pieces[index]
            yield from ((start + reach * eighth / 8).mid() for eighth in range(1, 9))
            index += 1
            if index == len(self.pieces):
                self._go_on()

    def highest(self):
        """Time at which it first does not rise."""

        def climb(time):
            _, v = self.at(time)
            return v[2], self.acceleration(v)[2]

        above = arb(0)
        if not climb(above)[0] > 0:
            return above
        for below in self.grid():
            if climb(below)[0] < 0:
                break
            above = below
        return newton(climb, ((above + below) / 2).mid())

    def landing(self, floor, time_limit):
        """Time of the first fall to a height; None if it does not come before the time limit."""

        def height(time):
            r, v = self.at(time)
            return r[2] - floor, v[2]

        above = arb(0)
        for below in self.grid():
            value, rate = height(below)
            if value < 0 and rate < 0:
                break
            if below > time_limit:
                return None
            above = below
        for _ in range(8):  # bisection, so that Newton's method cannot stray
            middle = ((above + below) / 2).mid()
            if height(middle)[0] < 0:
                below = middle
            else:
                above = middle
        time = newton(height, below)
        return time if time <= time_limit else None


def last_of_product(a, b):
    """Coefficient of the product of two series, at the highest power that both are known to."""
    return sum(map(mul, a, reversed(b)))


def horner(coefficients, t):
    value = coefficients[-1]
    for coefficient in coefficients[-2::-1]:
        value = value * t + coefficient
    return value


# ---- pitch and bat -------------------------------------------------------------------------------


class Throw:
    """A pitch, where it crosses the plate, and how it passes a bat."""

    def __init__(self, scene, digits=DIGITS):
        release, aim = vector(scene["pitch"]["release"]), vector(scene["pitch"]["aim"])
        toward = [-release[0], aim[0] - release[1], aim[1] - release[2]]
        speed = arb(scene["pitch"]["speed"]) / length(toward)
        velocity = [speed * c for c in toward]
        self.reach = arb(scene["ball"]["radius"]) + arb(scene["bat"]["radius"])
        self.path = Path(release, velocity, force_constants(scene), digits)

        def to_plate(time):
            r, v = self.path.at(time)
            return r[0], v[0]

        self.plate_time = newton(to_plate, release[0] / -velocity[0])
        self.plate = self.path.at(self.plate_time)

    def bat_height(self, offset):
        """z_b = z'_b + σ_b."""
        return self.plate[0][2] + arb(offset)

    def from_axis(self, time, bat_height):
        """Vector from the bat's axis to the ball, and velocity, both across the axis."""
        r, v = self.path.at(time)
        return [r[0], arb(0), r[2] - bat_height], [v[0], arb(0), v[2]], self.path.acceleration(v)

    def closest(self, bat_height):
        """Time of the closest approach to the bat's axis, and the distance there."""

        def radial_velocity(time):
            d, v, a = self.from_axis(time, bat_height)
            return dot(d, v), dot(v, v) + dot(d, a)

        time = newton(radial_velocity, self.plate_time)
        return time, length(self.from_axis(time, bat_height)[0])

    def margin(self, offset):
        """R + r_b minus the closest distance of the undisturbed pitch, m."""
        return self.reach - self.closest(self.bat_height(offset))[1]

    def offset_for(self, margin, side):
        """Offset (a double, m) of a bat above (+1) or below (-1) the pitch that has this margin.

        Rounding the offset to a double changes the margin: ask for it again.
        """
        wanted = self.reach - arb(margin)
        offset = side * wanted
        for _ in range(2):  # the first step is off by 1e-5 m, the second by the square of that
            height = self.bat_height(offset)
            time, distance = self.closest(height)
            # The time is the best one, so that the distance changes with the bat's height alone.
            slope = -self.from_axis(time, height)[0][2] / distance
            offset = (offset - (distance - wanted) / slope).mid()
        return float(offset)

    def first_touching(self, bat_height):
        """Time of the first touching; None if there is none."""
        closest, distance = self.closest(bat_height)
        if distance > self.reach:
            return None

        def depth(time):
            d, v, _ = self.from_axis(time, bat_height)
            return dot(d, d) - self.reach * self.reach, 2 * dot(d, v)

        half_chord = (self.reach * self.reach - distance * distance).sqrt()
        time = newton(depth, closest - half_chord / length(self.path.at(closest)[1]))
        assert time < closest
        return time


# ---- scenes --------------------------------------------------------------------------------------


def solve(scene, digits=DIGITS):
    """Result of a scene, with `arb` for numbers."""
    assert scene["reading"] == {}, "only the default reading is known here"
    kinds = {"flight": _flight, "pitch": _pitch, "impact": _impact, "at-bat": _at_bat}
    with in_digits(digits):
        return kinds[scene["kind"]](scene, digits)


def _flight(scene, digits):
    launch = scene["launch"]
    landing = _landing(
        scene, vector(launch["position"]), vector(launch["velocity"]), arb(0), digits
    )
    return {"outcome": "landed" if landing else "airborne"} | landing


def _landing(scene, position, velocity, start, digits):
    path = Path(position, velocity, force_constants(scene), digits)
    floor = arb(scene["ground"]["height"])
    time = path.landing(floor, arb(scene["time_limit"]))
    if time is None:
        return {}
    r, v = path.at(time)
    top = path.highest()
    return {
        "apex": {"time": start + top, "position": path.at(top)[0]},
        "landing": {
            "time": start + time,
            "hang_time": time,
            "position": r,
            "velocity": v,
            "distance": (r[0] * r[0] + r[1] * r[1]).sqrt(),
            "angle": arb.atan2(-v[2], (v[0] * v[0] + v[1] * v[1]).sqrt()),
        },
    }


def _pitch(scene, digits):
    throw = Throw(scene | {"bat": {"radius": 0.0}}, digits)
    return {"outcome": "crossed", "plate": _plate(throw)}


def _plate(throw):
    r, v = throw.plate
    approach = {
        "vertical": arb.atan2(v[2], (v[0] * v[0] + v[1] * v[1]).sqrt()),
        "horizontal": arb.atan2(v[1], -v[0]),
    }
    return {"time": throw.plate_time, "position": r, "velocity": v, "approach": approach}


def _impact(scene, digits):
    incoming = scene["incoming"]
    blow, impact = _collision(
        scene,
        vector(incoming["position"]),
        vector(incoming["velocity"]),
        arb(incoming["bat_height"]),
    )
    if not blow:
        return {"outcome": "beyond_bat"}
    return {"outcome": "struck" if impact else "separating", "contact": blow} | impact


def _at_bat(scene, digits):
    throw = Throw(scene, digits)
    height = throw.bat_height(scene["swing"]["height_offset"])
    time = throw.first_touching(height)
    contact = {"margin": throw.margin(scene["swing"]["height_offset"])}
    known = {"plate": _plate(throw), "contact": contact}
    if time is None:
        return {"outcome": "missed"} | known
    position, velocity = throw.path.at(time)
    contact |= {"time": time, "position": position}
    blow, impact = _collision(scene, position, velocity, height)
    contact |= blow
    if not blow:
        return {"outcome": "beyond_bat"} | known
    if not impact:
        return {"outcome": "separating"} | known
    landing = _landing(scene, position, impact["impact"]["velocity"], time, digits)
    return {"outcome": "batted" if landing else "airborne"} | known | impact | landing


def _collision(scene, position, velocity, bat_height):
    """Contact and impact: nothing beyond the bat's ends, contact alone if the two separate."""
    ball, bat, swing = scene["ball"], scene["bat"], scene["swing"]
    m, mass = arb(ball["mass"]), arb(bat["mass"])
    bat_length, radius = arb(bat["length"]), arb(bat["radius"])
    if not abs(position[1]) < bat_length / 2:
        return {}, {}
    d = [position[0], arb(0), position[2] - bat_height]
    normal = [c / length(d) for c in d]
    omega, tilt = arb(swing["angular_speed"]), arb(swing["tilt"])
    from_b = [arb(0), position[1] - bat_length / 2, arb(0)]
    bat_velocity = cross([-omega * tilt.sin(), arb(0), omega * tilt.cos()], from_b)
    relative = [a - b for a, b in zip(velocity, bat_velocity, strict=True)]
    normal_speed = dot(relative, normal)
    contact = {
        "position": position,
        "normal": normal,
        "bat_velocity": bat_velocity,
        "normal_speed": normal_speed,
    }
    if not normal_speed < 0:
        return contact, {}
    inertia = mass * (bat_length**2 / 3 + radius**2 / 4)
    ratio = m * dot(from_b, from_b) / inertia  # m/M_eff with M_eff = I/r̃²
    restitution = arb(ball["restitution"]) * (1 + ratio) + ratio
    impulse = -(1 + restitution) * normal_speed / (1 / m + 1 / mass)
    after = [v + impulse / m * n for v, n in zip(velocity, normal, strict=True)]
    bat_after = [v - impulse / mass * n for v, n in zip(bat_velocity, normal, strict=True)]

    def energy(ball_velocity, of_bat):
        return (m * dot(ball_velocity, ball_velocity) + mass * dot(of_bat, of_bat)) / 2

    return contact, {
        "impact": {
            "restitution": restitution,
            "impulse": impulse,
            "velocity": after,
            "energy_change": energy(after, bat_after) - energy(velocity, bat_velocity),
        }
    }
