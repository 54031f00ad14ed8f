"""at_bat_lab: flights, pitches, impacts and at-bats of baseballs; JSON lines in, JSON lines out.

at_bat_lab.json has mistakes as edits of this text; ruff leaves it as it is.

The ground is the complex plane: p = x + iy, q = dp/dt; the height z and w = dz/dt stand beside it. A spin
is a pair as well, (s, n) for its horizontal and its vertical part, so that spin x velocity is
(i (n q - s w), Im(s* q)). An impact is done in the bat's cross-section, whose plane is complex, too, in the
frame turned by the angle of the normal. Flights are integrated by extrapolated midpoint steps
(Gragg, Bulirsch and Stoer), and an event is found by doing its step again with another length.
"""

import bisect
import cmath
import json
import math
import struct
import sys

PI = math.pi
EARTH = 7.292115e-5  # rad/s
OUTSIDE = math.inf


class Refused(Exception):
    """The scene has no answer."""


# ---------------------------------------------------------------------------------------- integration

ROWS = (2, 4, 6, 8, 10, 12, 14, 16)
LONGEST = 0.4  # s
SHARP = 1e-13


def midpoints(rate, t, y, slope, H, n):
    """Cross a step of length H with n midpoint steps, smoothed at the end."""
    h = H / n
    p, q, z, w, s = y
    dp, dq, dz, dw, ds = slope
    P, Q, Z, W, S = p + h * dp, q + h * dq, z + h * dz, w + h * dw, s + h * ds
    h2 = 2 * h
    for i in range(1, n):
        dp, dq, dz, dw, ds = rate(t + i * h, (P, Q, Z, W, S))
        p, q, z, w, s, P, Q, Z, W, S = P, Q, Z, W, S, p + h2 * dp, q + h2 * dq, z + h2 * dz, w + h2 * dw, s + h2 * ds
    dp, dq, dz, dw, ds = rate(t + H, (P, Q, Z, W, S))
    return (
        0.5 * (p + P + h * dp),
        0.5 * (q + Q + h * dq),
        0.5 * (z + Z + h * dz),
        0.5 * (w + W + h * dw),
        0.5 * (s + S + h * ds),
    )


def extrapolated(rate, t, y, H):
    """Return the state after H, and whether the extrapolation has converged."""
    slope = rate(t, y)
    before = []
    for j, n in enumerate(ROWS):
        row = [midpoints(rate, t, y, slope, H, n)]
        for k in range(1, j + 1):
            ratio = 1.0 / ((n / ROWS[j - k]) ** 2 - 1.0)
            row.append(tuple([a + (a - b) * ratio for a, b in zip(row[k - 1], before[k - 1])]))
        if j > 1:
            new, old = row[j], row[j - 1]
            scale = SHARP * (1.0 + max(abs(new[0]), abs(new[1]), abs(new[2]), abs(new[3])))
            if all([abs(a - b) <= scale for a, b in zip(new, old)]):
                return new, j
        before = row
    return row[-1], len(ROWS)


def step_rule(rate, t, y, H):
    """Return the state after H, and a number that is small where longer steps would do."""
    return extrapolated(rate, t, y, H)


class Course:
    """A ball on its way: one step after another, from t0, y0 to t1, y1."""

    def __init__(self, law, t, y):
        self.law, self.rate = law, law.rate
        self.start = t
        self.t1, self.y1 = t, y
        self.H = min(0.1, LONGEST)
        self.flip = None

    def after(self, dt):
        """Return the state dt after the step's beginning."""
        if dt == 0.0:
            return self.y0
        if dt == self.h:
            return self.y1
        if dt not in self.seen:
            self.seen[dt] = step_rule(self.rate, self.t0, self.y0, dt)[0]
        return self.seen[dt]

    def advance(self, limit):
        """Take a step, at most up to the time `limit`; end it where the law changes."""
        if self.flip:
            self.y1 = self.flip(self.y1)
            self.flip = None
        self.t0, self.y0, self.seen = self.t1, self.y1, {}
        while True:
            last = self.t0 + self.H >= limit
            H = limit - self.t0 if last else self.H
            y, effort = step_rule(self.rate, self.t0, self.y0, H)
            if effort < len(ROWS) or H < 1e-11:
                break
            self.H = H / 4
        if not math.isfinite(abs(y[0]) + abs(y[1]) + y[2] + y[3]):
            raise Refused("the ball leaves the range of doubles")
        self.h, self.y1, self.t1 = H, y, limit if last else self.t0 + H
        if effort <= 5:
            self.H = max(self.H, min(LONGEST / 4 if self.law.nodes else LONGEST, H * 2.5))
        for size, node in self.law.nodes:
            off = size(self.t0, self.y0) - node
            if abs(off) > 1e-11 and (size(self.t1, self.y1) - node) * off < 0.0:
                self.cut(pinch(lambda dt: size(self.t0 + dt, self.after(dt)) - node, 0.0, self.h))
        for watch, flip in self.law.switches():
            dt = self.first_rise(watch)
            if dt is not None and (dt < self.h or self.flip is None):
                self.cut(dt)
                self.flip = flip
                if flip == self.law.cross_layer:
                    p, q, z, w, s = self.y1
                    self.y1 = p, q, self.law.layer, w, s

    def cut(self, dt):
        self.y1 = self.after(dt)
        self.h, self.t1 = dt, self.t0 + dt

    def summit(self, watch, a, b):
        """Find where the slope of a watch, positive at a, vanishes before b."""
        return pinch(lambda dt: watch(self.after(dt), self.law)[1], a, b)

    def first_rise(self, watch):
        """Return when, after the step's beginning, a watch first becomes positive; None if it does not."""
        f0, d0 = watch(self.y0, self.law)
        f1, d1 = watch(self.y1, self.law)
        if f0 > 0.0:
            return None
        low, high = 0.0, self.h
        if f0 == 0.0:
            if d0 > 0.0 or (d0 == 0.0 and f1 >= 0.0):
                return 0.0
            if f1 <= 0.0 and not (d0 < 0.0 and d1 < 0.0):
                return None
            if f1 > 0.0:
                low = pinch(lambda dt: watch(self.after(dt), self.law)[1], 0.0, self.h)
                low = max(low - 1e-9, 0.0) if watch(self.after(low), self.law)[0] >= 0 else low
        if f1 < 0.0:
            if not (d0 > 0.0 > d1):
                return None
            high = self.summit(watch, 0.0, self.h)
            if watch(self.after(high), self.law)[0] < 0.0:
                return None
        elif f1 == 0.0 and d1 <= 0.0:
            return None
        return self.polish(watch, low, high)

    def polish(self, watch, low, high):
        """Find the zero of a watch, not positive at low, and not negative at high: Newton from a cubic's zero."""
        (fa, da), (fb, db) = watch(self.after(low), self.law), watch(self.after(high), self.law)
        h, a, b = high - low, 0.0, 1.0
        for _ in range(40):
            u = 0.5 * (a + b)
            v = 1.0 - u
            cubic = v * v * ((1 + 2 * u) * fa + u * h * da) + u * u * ((1 + 2 * v) * fb - v * h * db)
            a, b = (u, b) if cubic < 0.0 else (a, u)
        dt = low + h * b
        for _ in range(100):
            f, d = watch(self.after(dt), self.law)
            if f == 0.0:
                break
            low, high = (dt, high) if f < 0.0 else (low, dt)
            move = -f / d if d > 0.0 else OUTSIDE
            if not low <= dt + move <= high:
                move = 0.5 * (low + high) - dt
            elif abs(move) < 1e-9 * max(self.h, 1e-3):
                return dt + move
            if dt + move == dt:
                break
            dt += move
        return dt


def pinch(f, a, b):
    """Find a zero between a and b, where f has different signs (Anderson and Bjorck)."""
    fa, fb = f(a), f(b)
    if fa == 0.0:
        return a
    if fb == 0.0 or (fa < 0.0) == (fb < 0.0):
        return b
    for turn in range(200):
        c = b - fb * (b - a) / (fb - fa)
        if not min(a, b) < c < max(a, b) or turn % 12 == 11:
            c = 0.5 * (a + b)
        if c in (a, b):
            break
        fc = f(c)
        if fc == 0.0:
            return c
        if (fc < 0.0) != (fb < 0.0):
            a, fa = b, fb
        else:
            m = 1.0 - fc / fb
            fa *= m if m > 0.0 else 0.5
        b, fb = c, fc
        if abs(b - a) <= 2e-16 * max(abs(a), abs(b)):
            break
    return b


# ---------------------------------------------------------------------------------------- the air


def weather_density(weather, reading):
    T, p = weather.get("temperature", 288.15), weather.get("pressure", 101325.0)
    humidity, h = weather.get("humidity", 0.0), weather.get("elevation", 0.0)
    t = T - 273.15
    steam = 611.16 * math.exp((18.687 - t / 234.5) * t / (257.14 + t))
    if reading.get("pressure", "sea_level") == "sea_level":
        p = p * math.exp(-1.217e-4 * h)
    return 1.2929 * 273.15 / T * (p - 0.3783 * humidity * steam) / 101325.0


def look_up(at, values):
    """Return the function that is linear between nodes and constant outside."""
    last = len(at) - 1

    def value(x):
        if x <= at[0]:
            return values[0]
        if x >= at[last]:
            return values[last]
        i = bisect.bisect_right(at, x) - 1
        return values[i] + (values[i + 1] - values[i]) * (x - at[i]) / (at[i + 1] - at[i])

    return value


def sound_speed(air):
    return 331.3 * math.sqrt(air["density"]["temperature"] / 273.15)


def drag_law(air):
    """Return C_D as a function of the speed, the spin (rad/s), and the spin parameter."""
    law = air.get("drag_coefficient", 0.4)
    if not isinstance(law, dict):
        return lambda U, spin, S: law
    name = law["law"]
    if name == "constant":
        value = law["value"]
        return lambda U, spin, S: value
    if name == "spin":
        base, per_spin = law.get("constant", 0.3008), law.get("per_spin", 2.788e-4)
        return lambda U, spin, S: base + per_spin * spin
    if name == "crisis":
        fast, slow = law.get("high_speed", 0.33), law.get("low_speed", 0.5)
        middle, width, per_spin = law.get("speed", 31.4), law.get("width", 3.0), law.get("per_spin", 0.0)

        def crisis(U, spin, S):
            slowness = 0.5 - 0.5 * math.tanh(0.5 * (U - middle) / width)
            return fast + (slow - fast) * slowness + per_spin * spin

        return crisis
    table = look_up(law["at"], law["values"])
    if law["of"] == "speed":
        return lambda U, spin, S: table(U)
    if law["of"] == "mach":
        sound = sound_speed(air)
        return lambda U, spin, S: table(U / sound)
    return lambda U, spin, S: table(S)


def lift_law(air):
    """Return C_L as a function of the speed and the spin parameter."""
    law = air.get("lift_coefficient", 0.2)
    if not isinstance(law, dict):
        return lambda U, S: law
    name = law["law"]
    if name == "constant":
        value = law["value"]
        return lambda U, S: value
    if name == "rational":
        top, base, slope = law.get("numerator", 1.12), law.get("constant", 0.583), law.get("slope", 2.333)
        return lambda U, S: top / (slope + base / S) if S else 0.0
    if name == "linear":
        slope = law.get("slope", 1.0)
        return lambda U, S: slope * S
    if name == "bilinear":
        return lambda U, S: 1.5 * S if S < 0.1 else 0.09 + 0.6 * S
    table = look_up(law["at"], law["values"])
    if law["of"] == "speed":
        return lambda U, S: table(U)
    if law["of"] == "mach":
        sound = sound_speed(air)
        return lambda U, S: table(U / sound)
    return lambda U, S: table(S)


def wind_law(air):
    """Return the wind (horizontal, vertical) as a function of height, and the height where it begins."""
    wind = air.get("wind")
    if wind is None:
        return None, None
    if isinstance(wind, list):
        blow = complex(wind[0], wind[1]), wind[2]
        return (lambda z: blow), None
    level = wind["velocity"]
    blow = complex(level[0], level[1]), level[2]
    if "above" in wind:
        return (lambda z: blow), wind["above"]
    rough = wind.get("roughness", 0.03)
    full = math.log1p(wind["height"] / rough)

    def profile(z):
        share = math.log(max((z + rough) / rough, 1e-30)) / full
        return blow[0] * share, blow[1] * share

    return profile, None


def magnitude(spin):
    return math.hypot(abs(spin[0]), spin[1])


class Law:
    """Acceleration of a ball from t, y, with a spin vector or (None) the paper's lift."""

    def __init__(self, scene, t, y, spin):
        p, q, z, w, s = y
        ball, air, reading = scene["ball"], scene.get("air", {}), scene.get("reading", {})
        self.begin = t
        self.spin = spin
        self.size = magnitude(spin) if spin else 0.0
        heading = q / abs(q) if q else 1.0 + 0.0j
        self.heading = heading
        self.windy = self.stuck = False
        self.nodes = []
        self.layer = None
        self.upward = False
        gravity = scene.get("gravity", 9.8)
        turn = None
        if scene.get("earth"):
            latitude, azimuth = scene["earth"]["latitude"], scene["earth"].get("azimuth", 0.0)
            turn = EARTH * math.cos(latitude) * cmath.exp(1j * azimuth), EARTH * math.sin(latitude)
        self.decay_length = None
        self.wind = None
        if air is None:

            def fall(t, y):
                p, q, z, w, s = y
                dq, dw = 0j, -gravity
                if turn:
                    dq -= 2j * (turn[1] * q - turn[0] * w)
                    dw -= 2 * (turn[0].conjugate() * q).imag
                return q, dq, w, dw, 0.0

            self.rate = fall
            return
        m, R = ball.get("mass", 0.145), ball.get("radius", 0.0366)
        density = air.get("density", 1.29)
        if isinstance(density, dict):
            density = weather_density(density, reading)
        area = PI * R * R
        k0 = density * area / (2 * m)
        scale_height = air.get("density_scale_height")
        c_drag, c_lift = drag_law(air), lift_law(air)
        self.wind, self.layer = wind_law(air)
        if self.layer is not None:
            self.windy = z > self.layer or (z == self.layer and w > 0.0)
        self.decay_length = air.get("spin_decay_length") if spin else None
        self.decay_kind = reading.get("spin_decay", "path")
        whole_drag = reading.get("drag_spin") == "total"
        whole_S = reading.get("spin_parameter") == "total"
        lift_in_wind = reading.get("wind_acts_on") != "drag"
        self.upward = not spin and reading.get("lift_direction") == "always_up"
        axis = heading * -1j  # to the right
        for name, size in (("drag_coefficient", self.seen_by_drag), ("lift_coefficient", self.seen_by_lift)):
            law = air.get(name)
            if isinstance(law, dict) and law["law"] == "bilinear":
                self.nodes.append((size("spin_parameter"), 0.1))
            if isinstance(law, dict) and law["law"] == "table":
                unit = sound_speed(air) if law["of"] == "mach" else 1.0
                self.nodes += [(size(law["of"]), node * unit) for node in law["at"]]
        self.R, self.whole_S, self.lift_in_wind = R, whole_S, lift_in_wind
        if self.upward and not q:
            self.stuck = True
        size = self.size
        sqrt, exp = math.sqrt, math.exp

        def rate(t, y):
            p, q, z, w, s = y
            dq, dw = 0j, -gravity
            if turn:
                dq -= 2j * (turn[1] * q - turn[0] * w)
                dw -= 2 * (turn[0].conjugate() * q).imag
            uq, uw = self.through_air(q, w, z)
            U = sqrt(uq.real * uq.real + uq.imag * uq.imag + uw * uw)
            if U == 0.0:
                return q, dq, w, dw, 0.0
            k = k0 * exp(-z / scale_height) if scale_height else k0
            if not spin:
                f = k * c_drag(U, 0.0, 0.0) * U
                dq -= f * uq
                dw -= f * uw
                if not self.stuck:
                    lq, lw = (uq, uw) if lift_in_wind else (q, w)
                    V = U if lift_in_wind else sqrt(abs(q) ** 2 + w * w)
                    f = k * c_lift(V, 0.0) * V
                    dq -= f * 1j * axis * lw
                    dw += f * (axis.conjugate() * lq).imag
                return q, dq, w, dw, U
            fade = self.fade(t - self.begin, s, U)
            sq, sn = spin[0] * fade, spin[1] * fade
            cq, cw = 1j * (sn * uq - sq * uw), (sq.conjugate() * uq).imag
            c = sqrt(cq.real * cq.real + cq.imag * cq.imag + cw * cw)
            across = c / U
            whole = size * fade
            f = k * U * c_drag(U, whole if whole_drag else across, R * (whole if whole_S else across) / U)
            dq -= f * uq
            dw -= f * uw
            V = U
            if not lift_in_wind:
                V = sqrt(abs(q) ** 2 + w * w)
                cq, cw = 1j * (sn * q - sq * w), (sq.conjugate() * q).imag
                c = sqrt(cq.real * cq.real + cq.imag * cq.imag + cw * cw)
                across = c / V if V else 0.0
            if c > 0.0:
                S = R * (whole if whole_S else across) / V
                f = k * R * c_lift(V, S) / S
                dq += f * cq
                dw += f * cw
            return q, dq, w, dw, U

        self.rate = rate

    def through_air(self, q, w, z):
        """Return the velocity through the air."""
        if self.wind is None or (self.layer is not None and not self.windy):
            return q, w
        blow = self.wind(z)
        return q - blow[0], w - blow[1]

    def fade(self, t, s, U):
        """Return the fraction of the spin that is left."""
        if not self.decay_length:
            return 1.0
        if self.decay_kind == "path":
            return math.exp(-s / self.decay_length)
        if self.decay_kind == "time":
            return math.exp(-t * 44.704 / self.decay_length)
        return math.exp(-t * U / self.decay_length)

    def spin_at(self, t, y):
        p, q, z, w, s = y
        uq, uw = self.through_air(q, w, z)
        fade = self.fade(t - self.begin, s, math.hypot(abs(uq), uw))
        return self.spin[0] * fade, self.spin[1] * fade

    def seen_by_drag(self, of):
        return lambda t, y: self.abscissa(of, t, y, True)

    def seen_by_lift(self, of):
        return lambda t, y: self.abscissa(of, t, y, self.lift_in_wind)

    def abscissa(self, of, t, y, in_wind):
        """Return the speed or the spin parameter, where the steps of a law with kinks have to end."""
        p, q, z, w, s = y
        uq, uw = self.through_air(q, w, z)
        airspeed = math.hypot(abs(uq), uw)
        uq, uw = (uq, uw) if in_wind else (q, w)
        U = math.hypot(abs(uq), uw)
        if of != "spin_parameter":
            return U
        if not self.spin or not U:
            return 0.0
        fade = self.fade(t - self.begin, s, airspeed)
        sq, sn = self.spin[0] * fade, self.spin[1] * fade
        c = math.hypot(abs(sn * uq - sq * uw), (sq.conjugate() * uq).imag)
        return self.R * (self.size * fade if self.whole_S else c / U) / U

    def switches(self):
        """Return the watches that end a step, each with what happens then."""
        found = []
        if self.layer is not None:
            found.append((self.below_layer if self.windy else self.above_layer, self.cross_layer))
        if self.upward and not self.stuck:
            found.append((self.past_vertical, self.stick))
        return found

    def above_layer(self, y, law):
        return y[2] - self.layer, y[3]

    def below_layer(self, y, law):
        return self.layer - y[2], -y[3]

    def cross_layer(self, y):
        self.windy = not self.windy
        return (y[0], y[1], self.layer, y[3], y[4])

    def past_vertical(self, y, law):
        slope = self.rate(0.0, y)
        return -(self.heading.conjugate() * y[1]).real, -(self.heading.conjugate() * slope[1]).real

    def stick(self, y):
        self.stuck = True
        return (y[0], 0j, y[2], y[3], y[4])


# ---------------------------------------------------------------------------------------- what is watched


def ground_level(scene, height):
    if scene.get("reading", {}).get("ground_contact") == "surface":
        return height + scene["ball"].get("radius", 0.0366)
    return height


def ground_watch(level):
    def watch(y, law):
        slope = -y[3]
        if y[2] == level and slope == 0.0:
            slope = -law.rate(law.begin, y)[3]
        return level - y[2], slope

    return watch


def plate_watch(y, law):
    return -y[0].real, -y[1].real


def bat_watch(reach, height):
    def watch(y, law):
        x, z = y[0].real, y[2] - height
        return reach * reach - x * x - z * z, -2.0 * (x * y[1].real + z * y[3])

    return watch


def passed_watch(reach):
    return lambda y, law: (-reach - y[0].real, -y[1].real)


def chord_watch(a, b):
    along = (b - a).conjugate()
    return lambda y, law: ((along * (y[0] - a)).imag, (along * y[1]).imag)


def circle_watch(radius):
    return lambda y, law: (
        y[0].real ** 2 + y[0].imag ** 2 - radius * radius,
        2 * (y[0].real * y[1].real + y[0].imag * y[1].imag),
    )


class Fence:
    """The fence of a scene."""

    def __init__(self, scene):
        fence = scene["fence"]
        self.surface = 0.0
        if scene.get("reading", {}).get("fence_clearance") == "surface":
            self.surface = scene["ball"].get("radius", 0.0366)
        self.round = "radius" in fence
        if self.round:
            self.watches = [circle_watch(fence["radius"])]
            return
        nodes = [(complex(x, y), height) for x, y, height in fence["polyline"]]
        self.chords = list(zip(nodes, nodes[1:]))
        self.watches = [chord_watch(a, b) for (a, _), (b, _) in self.chords]

    def crossing(self, course):
        """Return the first crossing of the step as dt and what it looks like; None if there is none."""
        best = None
        for number, watch in enumerate(self.watches):
            dt = None
            if self.round or self.chords[number][0][0] != self.chords[number][1][0]:
                dt = course.first_rise(watch)
            if dt is None or (best and best[0] <= dt):
                continue
            y = course.after(dt)
            if self.round:
                best = dt, {"clearance": y[2] - self.surface, "segment": 0}
                continue
            (a, low), (b, high) = self.chords[number]
            share = ((y[0] - a) / (b - a)).real
            if 0.0 <= share < 1.0:
                top = low + (high - low) * share
                margin = min(share, 1.0 - share) * abs(b - a)
                best = dt, {"clearance": y[2] - self.surface - top, "segment": number, "margin": margin}
        return best


def is_fair(y):
    return abs(y[0].imag) <= y[0].real


# ---------------------------------------------------------------------------------------- scenes


def vector(horizontal, vertical):
    return [horizontal.real, horizontal.imag, vertical]


def state(position, velocity):
    return complex(position[0], position[1]), complex(velocity[0], velocity[1]), position[2], velocity[2], 0.0


def moment(t, y):
    return {"time": t, "position": vector(y[0], y[2]), "velocity": vector(y[1], y[3])}


def spin_of(block):
    spin = block.get("spin")
    return None if spin is None else (complex(spin[0], spin[1]), spin[2])


def fly(scene, result, t, y, spin, outcome):
    """Fly from t, y to the ground; write landing and fence into the result, and the outcome."""
    level = ground_level(scene, scene.get("ground", {}).get("height", 0.0))
    if y[2] < level:
        raise Refused("the ball starts below the ground")
    law = Law(scene, t, y, spin)
    course = Course(law, t, y)
    limit = t + scene.get("time_limit", 60.0)
    down = ground_watch(level)
    fence = Fence(scene) if scene.get("fence") else None
    launch = y[0]
    fair = None
    result["outcome"] = "airborne"
    while course.t1 < limit:
        course.advance(limit)
        landed = course.first_rise(down)
        crossed = fence.crossing(course) if fence and fair is None else None
        if crossed and (landed is None or crossed[0] < landed):
            dt, block = crossed
            when, there = course.t0 + dt, course.after(dt)
            fair = is_fair(there)
            result["fence"] = {**moment(when, there), **block}
            if block["clearance"] <= 0.0:
                result["outcome"] = "wall"
                return
            if fair or fence.round:
                outcome = result["outcome"] = "home_run"
        if landed is not None:
            when, there = course.t0 + landed, course.after(landed)
            origin = 0j
            if scene.get("reading", {}).get("distance_origin") == "launch":
                origin = launch
            landing = moment(when, there)
            landing["hang_time"] = when - t
            landing["distance"] = abs(there[0] - origin)
            if spin:
                landing["spin"] = vector(*law.spin_at(when, there))
                if law.decay_length and law.decay_kind == "path":
                    landing["path"] = there[4]
            if fence:
                landing["fair"] = is_fair(there) if fair is None else fair
            result["landing"] = landing
            result["outcome"] = outcome
            return


def throw(scene):
    """Return the pitch at its release: state and spin."""
    pitch = scene["pitch"]
    release = pitch.get("release", [18.44, 0.0, 1.8])
    if "velocity" in pitch:
        return state(release, pitch["velocity"]), spin_of(pitch)
    aim, speed = pitch.get("aim", [0.0, 1.8]), pitch.get("speed", 36.9125)
    sideways, rise = aim[0] - release[1], aim[1] - release[2]
    elevation = math.atan2(rise, math.hypot(release[0], sideways))
    heading = complex(-release[0], sideways)
    level = speed * math.cos(elevation) * heading / abs(heading)
    return state(release, [level.real, level.imag, speed * math.sin(elevation)]), spin_of(pitch)


def to_plate(scene, height):
    """Throw the pitch; return its outcome, and when and how it crosses the plate."""
    y, spin = throw(scene)
    level = ground_level(scene, height)
    if y[2] < level:
        raise Refused("the pitch starts below the ground")
    course = Course(Law(scene, 0.0, y, spin), 0.0, y)
    limit = scene.get("time_limit", 60.0)
    down = ground_watch(level)
    while course.t1 < limit:
        course.advance(limit)
        landed, crossed = course.first_rise(down), course.first_rise(plate_watch)
        if landed is not None and (crossed is None or landed < crossed):
            return "grounded", None, None
        if crossed is not None:
            return "crossed", course.t0 + crossed, course.after(crossed)
    return "airborne", None, None


def solve_pitch(scene, result):
    outcome, when, there = to_plate(scene, 0.0)
    result["outcome"] = outcome
    if there:
        result["plate"] = moment(when, there)


def meet(scene, height, bat_height, reach):
    """Throw the pitch at the bat; return the margin, and when, how and with which spin they touch."""
    y, spin = throw(scene)
    law = Law(scene, 0.0, y, spin)
    course = Course(law, 0.0, y)
    limit = scene.get("time_limit", 60.0)
    down, passed, bat = ground_watch(ground_level(scene, height)), passed_watch(reach), bat_watch(reach, bat_height)
    if bat(y, law)[0] > 0.0:
        raise Refused("the release is within the bat's reach")
    closest = OUTSIDE
    touch = None

    def gap(y):
        return math.hypot(y[0].real, y[2] - bat_height)

    while course.t1 < limit:
        course.advance(limit)
        ends = [dt for dt in (course.first_rise(down), course.first_rise(passed)) if dt is not None]
        if ends:
            course.cut(min(ends))
        if touch is None:
            dt = course.first_rise(bat)
            if dt is not None:
                y = course.after(dt)
                touch = course.t0 + dt, y, law.spin_at(course.t0 + dt, y) if spin else None
        closest = min(closest, gap(course.y0), gap(course.y1))
        if bat(course.y0, law)[1] > 0.0 > bat(course.y1, law)[1]:
            closest = min(closest, gap(course.after(course.summit(bat, 0.0, course.h))))
        if ends:
            break
    return reach - closest, touch


def strike(scene, position, velocity, spin, bat_height, contact):
    """Let the impulse act. Return the outcome, and the ball's velocity and spin, after it; fill in `contact`."""
    ball, bat, swing, reading = scene["ball"], scene["bat"], scene["swing"], scene.get("reading", {})
    m, R, e = ball.get("mass", 0.145), ball.get("radius", 0.0366), ball.get("restitution", 0.42)
    M, L, r = bat.get("mass", 0.9), bat.get("length", 1.0), bat.get("radius", 0.033)
    speed, tilt = swing.get("angular_speed", 34.0), swing.get("tilt", math.pi / 36)
    y = position[1]
    if abs(y) >= L / 2:
        return "beyond_bat", None, None, None
    # The cross-section is the complex plane x + iz; turned by the normal's angle, the first axis is the
    # normal, the second is normal x y.
    slope = math.atan2(position[2] - bat_height, position[0])
    normal = cmath.exp(1j * slope)
    arm = L / 2 - y
    swung = speed * arm * cmath.exp(1j * tilt)
    contact["normal"] = [normal.real, 0.0, normal.imag]
    contact["bat_velocity"] = [swung.real, 0.0, swung.imag]
    flat = complex(velocity[0], velocity[2])
    local = flat / normal
    slip = (flat - swung) / normal
    closing = slip.real
    contact["normal_speed"] = closing
    if closing >= 0.0:
        return "separating", None, None, None
    girth = r * r / 4
    rod = {"thin_rod": L * L / 3, "about_centre": L * L / 12 + girth}.get(reading.get("inertia"), L * L / 3 + girth)
    inertia = M * rod
    free = bat.get("support") == "free"
    if free:
        inertia = M * (L * L / 12 + (0.0 if reading.get("inertia") == "thin_rod" else girth))
        effective = 1.0 / (1.0 / M + y * y / inertia)
    elif reading.get("effective_mass") == "as_printed":
        effective = inertia / arm
    else:
        effective = inertia / arm**2
    kind = reading.get("bat_ball_restitution", "as_printed")
    bounce = e + (1 + e) * m / effective if kind == "as_printed" else e
    heavy = kind == "nathan" or (kind == "as_printed" and reading.get("reduced_mass") == "effective_mass")
    softness = 1 / m + 1 / (effective if heavy else M)  # one over the reduced mass
    friction = bat.get("friction")
    block = {"restitution": bounce}
    if not friction:
        impulse = -(1 + bounce) * closing / softness
        local += impulse / m
        block["energy_change"] = -0.5 * (1 - bounce**2) * closing**2 / softness
        if spin:
            block["mode"] = "frictionless"
    else:
        spin = spin or (0j, 0.0)
        I = ball.get("inertia_factor", 0.4) * m * R * R
        grip_back = bat.get("tangential_restitution", 0.3)
        twirl = complex(spin[0].real, spin[1]) / normal  # along the normal, and along normal x y
        twirl_y = spin[0].imag
        turning = speed * cmath.exp(1j * tilt) * 1j / normal
        g_n, g_y, g_t = closing, velocity[1] - R * twirl.imag - r * turning.imag, slip.imag + R * twirl_y
        lever = y if free else y - L / 2
        own = 1 / m + R * R / I + (1 / M if free else 0.0)
        k_nn, k_ny = softness, -lever * r / inertia
        k_yy = own + r * r / inertia
        k_tt = own + lever**2 / inertia + r * r / (M * r * r / 2)
        want_n, want_y, want_t = -(1 + bounce) * g_n, -(1 + grip_back) * g_y, -(1 + grip_back) * g_t
        det = k_nn * k_yy - k_ny * k_ny
        P_n, P_y = (want_n * k_yy - want_y * k_ny) / det, (want_y * k_nn - want_n * k_ny) / det
        P_t = want_t / k_tt
        along = math.hypot(P_y, P_t)
        block["friction_margin"] = 1 - along / (friction * P_n)
        block["mode"] = "grip"
        if along > friction * P_n:
            block["mode"] = "slide"
            e_y, e_t = g_y, g_t
            if reading.get("slide_direction") == "final":
                e_y, e_t = -P_y, -P_t
            length = math.hypot(e_y, e_t)
            mu = friction if length else 0.0
            e_y, e_t = (e_y / length, e_t / length) if length else (0.0, 0.0)
            below = k_nn - mu * k_ny * e_y
            if below <= 0.0:
                raise Refused("ball and bat jam")
            P_n = want_n / below
            P_y, P_t = -mu * P_n * e_y, -mu * P_n * e_t
        impulse = P_n
        local += complex(P_n, P_t) / m
        velocity = [velocity[0], velocity[1] + P_y / m, velocity[2]]
        twirl -= 1j * R / I * P_y
        twirl_y += R / I * P_t
        back = twirl * normal
        spin = complex(back.real, twirl_y), back.imag
        block["energy_change"] = (
            P_n * (g_n + 0.5 * (k_nn * P_n + k_ny * P_y))
            + P_y * (g_y + 0.5 * (k_ny * P_n + k_yy * P_y))
            + P_t * (g_t + 0.5 * k_tt * P_t)
        )
    flat = local * normal
    block["impulse"] = impulse
    block["velocity"] = [flat.real, velocity[1], flat.imag]
    if spin:
        block["spin"] = vector(*spin)
    return "struck", block["velocity"], spin, block


def solve_impact(scene, result):
    incoming = scene["incoming"]
    position = incoming["position"]
    reach = scene["ball"].get("radius", 0.0366) + scene["bat"].get("radius", 0.033)
    if abs(math.hypot(position[0], position[2] - incoming["bat_height"]) - reach) > 1e-9:
        raise Refused("ball and bat do not touch")
    contact = {"position": position}
    outcome, velocity, spin, block = strike(
        scene, position, incoming["velocity"], spin_of(incoming), incoming["bat_height"], contact
    )
    result["outcome"] = outcome
    if outcome != "beyond_bat":
        result["contact"] = contact
    if block:
        result["impact"] = block


def solve_at_bat(scene, result):
    ground = scene.get("ground", {}).get("height", 0.0)
    outcome, when, there = to_plate(scene, ground)
    if not there:
        result["outcome"] = outcome
        return
    result["plate"] = moment(when, there)
    bat_height = there[2] + scene["swing"].get("height_offset", 0.0)
    reach = scene["ball"].get("radius", 0.0366) + scene["bat"].get("radius", 0.033)
    margin, touch = meet(scene, ground, bat_height, reach)
    contact = result["contact"] = {"margin": margin}
    if touch is None:
        result["outcome"] = "missed"
        return
    t, y, spin = touch
    contact["time"], contact["position"] = t, vector(y[0], y[2])
    outcome, velocity, spin, block = strike(scene, contact["position"], vector(y[1], y[3]), spin, bat_height, contact)
    result["outcome"] = outcome
    if outcome != "struck":
        return
    result["impact"] = block
    fly(scene, result, t, state(contact["position"], velocity), spin, "batted")


def solve_flight(scene, result):
    launch = scene["launch"]
    fly(scene, result, 0.0, state(launch["position"], launch["velocity"]), spin_of(launch), "landed")


SOLVERS = {"flight": solve_flight, "pitch": solve_pitch, "impact": solve_impact, "at-bat": solve_at_bat}


def solve(scene):
    """Return the result of a scene."""
    result = {"id": scene.get("id")}
    try:
        SOLVERS[scene["kind"]](scene, result)
        json.dumps(result, allow_nan=False)
    except Refused as reason:
        return {"id": result["id"], "error": str(reason), "code": "invalid"}
    except (OverflowError, ZeroDivisionError, ValueError, IndexError) as reason:
        return {"id": result["id"], "error": f"{type(reason).__name__}: {reason}", "code": "unsupported"}
    return result


def serve():
    for number, line in enumerate(sys.stdin, 1):
        if not line.strip():
            continue
        scene = json.loads(line)
        scene.setdefault("id", str(number))
        print(json.dumps(solve(scene)), flush=True)


if __name__ == "__main__":
    serve()
