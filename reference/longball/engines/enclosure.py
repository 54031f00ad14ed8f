r"""The enclosure engine: flights in ball arithmetic, with a proof in every step.

Numbers are balls, a midpoint and a radius that holds every rounding (python-flint's `arb`). What
ball arithmetic cannot know is the error of cutting a Taylor series off. It is bounded as follows.

**A step.** The velocity v = (u, w) obeys ``v' = f(v) = -V A v - g e_z`` with V = |v| and
A = [[k_D, k_L], [-k_L, k_D]]. Let p be a pair of polynomials in time with exact coefficients: here
those of the Taylor series (`longball.engines.series`), but how they were found does not matter. Let
V̂ be a polynomial, not negative on [0, h], that ought to be |p|. Then p misses the equation by

    ``p' - f(p) = (p' + V̂ A p + g e_z) + (|p| - V̂) A p``,

and the size of the last term is at most ``|A| |p·p - V̂²|`` with ``|A| = √(k_D² + k_L²)``, because
``(|p| - V̂)(|p| + V̂) = p·p - V̂²``. So both terms are bounded by polynomials, whose coefficients are
computed and their sizes summed. Let δ be the sum. The error e = v - p obeys

    ``|e|' <= λ |e| + δ``,  ``λ = V (√(k_D² + k_L²) - 3 k_D) / 2``,

where λ is the larger eigenvalue of the symmetric part of f's derivative, and V the greatest speed
between v and p; hence ``|e(t)| <= (|e(0)| + δ t) exp(max(λ, 0) t)`` (the logarithmic norm: Hairer,
Nørsett, Wanner, *Solving Ordinary Differential Equations I*, Theorem I.10.6). That v exists is
plain: f is Lipschitz, and since drag only brakes and lift only turns, V grows by g a second at
most. Neither an a-priori box nor a Taylor coefficient over a box is needed; V may be zero; and the
error of a step is handed on as one number, which grows only if the lift is strong.

**An event** is the first zero of a function on the steps. Where neither the function nor its
derivative can vanish there is none, or a single one, which Newton's method encloses; any other
piece is cut in two. What is open when the pieces are tiny is `Undecided`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import cast

import flint
from flint import arb, arb_poly

from longball.engines import contact
from longball.engines.engine import Arrival, BatSection, CannotSolve, Stop, Stops, Touch
from longball.engines.series import extend
from longball.model.motion import Forces, PlaneState, acceleration
from longball.model.numbers import Undecided
from longball.model.result import Bounded

State = PlaneState[arb]
Function = Callable[[arb], arb]

# Bits beyond the digits asked for. A flight's error is some 2¹⁴ roundings: 2⁸ a step, and 2⁵ steps.
# A strong lift that loops for a minute adds 2⁴³; or a graze with a margin of 1e-15 m adds 2²⁷.
_GUARD_BITS = 64

# Error of a step, in roundings of the speed: what the roundings of a hundred coefficients leave.
_TOLERANCE = 2.0**8

# Order of the series for each bit: ln 2 / 2, which makes the work of a flight least if that of a
# step is as the square of its order (Jorba & Zou, Experimental Mathematics 14 (2005) 99).
_ORDER_PER_BIT = 0.35

# A step that cannot be proven is tried again this much shorter: the error falls as the order's
# power of it, to a twentieth.
_SHORTER = 0.95
_MOST_TRIALS = 1000

# A flight of a minute has a hundred steps, one that loops with strong lift some thousand.
_MOST_STEPS = 10_000

# A piece without a clear sign is cut here: not at a half, where a round number may be a zero.
_CUT = 0.4871


class Balls:
    """Real numbers as balls that contain them, written with a number of digits."""

    rounding = 0.0

    def __init__(self, digits: int) -> None:
        self.digits = digits
        self.bits = math.ceil(digits * math.log2(10)) + _GUARD_BITS

    def arithmetic(self) -> AbstractContextManager[object]:
        """Return the context in which balls are as small as the digits want them."""
        return cast(AbstractContextManager[object], flint.ctx.workprec(self.bits))

    @property
    def pi(self) -> arb:
        """The constant."""
        return arb.pi()

    def exact(self, value: float) -> arb:
        """Return the double, with radius 0."""
        return arb(value)

    def sqrt(self, x: arb) -> arb:
        """Return the square root of a number that is known not to be negative."""
        return x.nonnegative_part().sqrt()

    def cos_sin(self, angle: arb) -> tuple[arb, arb]:
        """Return cosine and sine of an angle in radians."""
        return angle.cos(), angle.sin()

    def positive(self, x: arb, error: arb, question: str) -> bool:
        """Tell whether ``x > 0``; see `longball.model.numbers.Numbers.positive`."""
        if x > error:
            return True
        if x <= -error:
            return False
        raise Undecided(self.open(question, x))

    def open(self, question: str, x: arb) -> str:
        """Say that a question is open, since `x` may be zero."""
        return (
            f"{question} cannot be decided with {self.digits} digits: "
            f"the value is zero but for {float(x.abs_upper()):.3g}; take more digits"
        )

    def report(self, x: arb) -> Bounded:
        """Return a decimal number and a radius that contain the ball between them.

        The number has one digit more than was asked for, so that its own rounding, which the
        radius includes, is less than one in the last digit asked for.
        """
        if not x.is_finite():
            raise OverflowError(f"a number is not finite: {x}")
        middle, radius, exponent = (int(part) for part in x.mid_rad_10exp(self.digits + 3))
        value, dropped = _shortened(middle, self.digits + 1)
        bound = radius + abs(value * 10**dropped - middle)
        # Three digits are enough of a radius; rounded up.
        coarse, coarsely = _shortened(bound, 3)
        coarse += coarse * 10**coarsely < bound
        return Bounded(
            value=str(Decimal(f"{value}E{exponent + dropped}")),
            radius=str(Decimal(f"{coarse}E{exponent + coarsely}")) if bound else "0",
        )


def _shortened(whole: int, digits: int) -> tuple[int, int]:
    """Round a whole number to some digits; return those, and how many are dropped."""
    dropped = max(0, len(str(abs(whole))) - digits)
    unit = 10**dropped
    return (whole + unit // 2) // unit, dropped


# --- a flight, step by step -----------------------------------------------------------------------


@dataclass(frozen=True)
class Step:
    """A piece of a flight.

    Attributes
    ----------
    start, length
        s; `start` since the launch.
    s, z, u, w
        Polynomials in the time since `start`; their balls contain the state from 0 to `length`.
    """

    start: arb
    length: arb
    s: arb_poly
    z: arb_poly
    u: arb_poly
    w: arb_poly

    def at(self, t: arb) -> State:
        """Return what contains the states at all times of `t`, s since `start`."""
        return PlaneState(self.s(t), self.z(t), self.u(t), self.w(t))


@dataclass(frozen=True)
class Core:
    """The velocity at the start of a step: an exact one, and how far it is off at most (m/s)."""

    u: arb
    w: arb
    error: arb


@dataclass(frozen=True)
class Motion:
    """Exact velocities from 0 to `length` s, as polynomials: off by ``early + late t`` at most."""

    u: arb_poly
    w: arb_poly
    length: arb
    early: arb
    late: arb


class Path:
    """A flight from its launch, as far as one looks."""

    def __init__(self, start: State, forces: Forces[arb], longest: arb, bits: int) -> None:
        self._forces = forces
        self._longest = longest
        self._bits = bits
        self._steps: list[Step] = []
        self._end = start
        self._core = _core(start.u, start.w, arb(0))
        self._upright = start.u.is_zero() and forces.lift is None
        # What a rounding of the launch's speed is, is no speed.
        self._negligible = (abs(start.u) + abs(start.w)) * arb(2) ** -bits

    def steps(self) -> Iterator[Step]:
        """Yield the steps from the launch on; they do not end."""
        for number in range(_MOST_STEPS):
            if number == len(self._steps):
                self._extend()
            yield self._steps[number]
        raise CannotSolve(
            f"the flight takes more than {_MOST_STEPS} steps; the first "
            f"{float(self._steps[-1].start):.3g} s of it can be had by a lower time_limit"
        )

    def _extend(self) -> None:
        start = self._steps[-1].start + self._steps[-1].length if self._steps else arb(0)
        core = _brought_to_rest(self._core, self._negligible)
        motion = _motion(core, self._forces, self._longest, self._bits)
        error = arb_poly([arb(0, motion.early), arb(0, motion.late)])
        # Nothing pushes a ball aside that flies straight up and down.
        u = motion.u if self._upright else motion.u + error
        w = motion.w + error
        s, z = self._end.s + u.integral(), self._end.z + w.integral()
        step = Step(start, motion.length, s, z, u, w)
        h = motion.length
        self._steps.append(step)
        self._end = step.at(h)
        self._core = _core(motion.u(h), motion.w(h), motion.early + motion.late * h)


def _core(u: arb, w: arb, error: arb) -> Core:
    return Core(u.mid(), w.mid(), (error + u.rad() + w.rad()).upper())


def _brought_to_rest(core: Core, negligible: arb) -> Core:
    """Return a velocity that is not told from rest, or is negligible (m/s), as rest with an error.

    A Taylor step cannot come closer to V = 0 than to a fraction, but the bound on the error holds
    there as well; and from rest there is another series (see `extend`).
    """
    speed = abs(core.u) + abs(core.w)
    if speed == 0 or not (speed <= negligible or speed <= core.error):
        return core
    return Core(arb(0), arb(0), (core.error + speed).upper())


def _motion(core: Core, forces: Forces[arb], longest: arb, bits: int) -> Motion:
    """Take a step, of at most `longest` s, that keeps its error to a few roundings."""
    gravity = arb(0) if forces.gravity is None else forces.gravity
    at_rest = core.u == 0 and core.w == 0
    if (forces.drag is None and forces.lift is None) or (at_rest and gravity == 0):
        u, w = arb_poly([core.u]), arb_poly([core.w, -gravity])
        return Motion(u, w, longest, core.error, arb(0))
    drag = arb(0) if forces.drag is None else forces.drag
    lift = arb(0) if forces.lift is None else forces.lift
    strength = (drag * drag + lift * lift).sqrt()
    start_speed = (core.u * core.u + core.w * core.w).sqrt()

    order = math.ceil(_ORDER_PER_BIT * bits)
    first = 1 if at_rest else 0
    us, ws, speeds = ([arb(0)] * (order + 1) for _ in range(3))
    us[0], ws[0], speeds[first] = core.u, core.w, gravity if at_rest else start_speed
    for n in range(order):
        extend(n, drag, lift, gravity, us, ws, speeds, first)
    u, w, speed = (arb_poly([c.mid() for c in series]) for series in (us, ws, speeds))

    misses = _misses(u, w, speed, drag, lift, gravity)
    leading, following = speed[first], arb_poly(speed.coeffs()[first + 1 :])
    tolerance = _TOLERANCE * arb(2) ** -bits

    h = min(_guess(us, ws, speed, first, tolerance), float(longest))
    for _ in range(_MOST_TRIALS):
        defect = _largest(misses, arb(h))
        size = start_speed + gravity * h
        if h > 0 and _largest([following], arb(h)) * h < leading and defect * h <= tolerance * size:
            break
        h *= _SHORTER
    else:
        raise CannotSolve("the forces are so strong that no step can be proven")

    # The error stays below `tube` as long as the speeds stay below `fastest`, and the other way
    # round: drag only brakes, lift only turns.
    tube = size / 1024 + 4 * core.error
    fastest = size + core.error + tube
    rate = (strength - 3 * drag) / 2 * fastest
    growth = (rate * h).exp().upper() if not rate <= 0 else arb(1)
    early, late = core.error * growth, defect * growth
    if not early + late * h < tube:
        raise CannotSolve(
            "the bound on the velocity's error has grown as large as the speed, as it does under a "
            "strong lift in the long run; take more digits, or a lower time_limit"
        )
    return Motion(u, w, arb(h), early.upper(), late.upper())


def _misses(
    u: arb_poly, w: arb_poly, speed: arb_poly, drag: arb, lift: arb, gravity: arb
) -> list[arb_poly]:
    """Return polynomials whose sizes add up to the δ of the module's docstring."""
    along, aside = speed * u, speed * w
    return [
        u.derivative() + drag * along + lift * aside,
        w.derivative() + drag * aside - lift * along + gravity,
        (drag * drag + lift * lift).sqrt() * (u * u + w * w - speed * speed),
    ]


def _largest(polynomials: list[arb_poly], h: arb) -> arb:
    """Bound the sum of the sizes of polynomials from 0 to h, by the sizes of their terms."""
    either_side = arb(0, h)
    return sum((abs(polynomial(either_side)) for polynomial in polynomials), arb(0)).upper()


def _guess(us: list[arb], ws: list[arb], speed: arb_poly, first: int, tolerance: arb) -> float:
    """Return the time, s, at which the series' last terms are small next to the speed.

    But not the whole time in which a speed that falls steadily would come to nothing.
    """
    leading, falling = speed[first], abs(speed[first + 1])
    times = [leading / falling * (1 - arb(2) ** -10)] if falling != 0 else []
    for n in (len(us) - 2, len(us) - 1):
        size = abs(us[n].mid()) + abs(ws[n].mid())
        if size > 0:
            times.append(((tolerance * leading / size).log() / (n - first)).exp())
    return min((float(time) for time in times), default=math.inf)


# --- the engine -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Enclosure:
    """Flights with proven bounds.

    Attributes
    ----------
    digits
        What a result is to be good to, relatively. A number's own radius tells what it is good to.
    """

    digits: int = 30

    def __post_init__(self) -> None:
        if self.digits < 1:
            raise ValueError(f"digits = {self.digits} is not positive")

    @property
    def numbers(self) -> Balls:
        """Balls of as many digits."""
        return Balls(self.digits)

    @property
    def description(self) -> str:
        """Name and digits."""
        return f"enclosure digits={self.digits}"

    @property
    def flight_error(self) -> float:
        """Balls carry their own error."""
        return 0.0

    def fly(self, start: State, forces: Forces[arb], stops: Stops[arb]) -> Arrival[arb]:
        """Fly until the first stop; see `longball.engines.engine.Engine.fly`."""
        balls = self.numbers
        with balls.arithmetic():
            path = Path(start, forces, stops.time_limit.upper(), balls.bits)
            return _first_stop(path, forces, stops, balls)

    def touch(
        self,
        pitch: Arrival[arb],
        forces: Forces[arb],
        bat: BatSection[arb],
        stops: Stops[arb],
    ) -> Touch[arb]:
        """Find how a pitch meets the bat; see `longball.engines.engine.Engine.touch`."""
        balls = self.numbers
        with balls.arithmetic():
            return _touch(cast(Path, pitch.record), forces, bat, stops, balls)


# --- roots ----------------------------------------------------------------------------------------


def _first_root(value: Function, slope: Function, a: arb, b: arb, question: str) -> arb | None:
    """Enclose the first zero in (a, b] of a function that is not negative at `a`.

    Parameters
    ----------
    value, slope
        Enclose the function and its derivative over all of a ball.
    a, b
        Exact numbers.

    Returns
    -------
    arb or None
        A ball that contains that zero, a simple one, and no other; None if there is no zero.

    Raises
    ------
    Undecided
        At a double zero, or one that is not told from b.
    """
    smallest = (b - a) * arb(2) ** (-flint.ctx.prec // 2)
    pieces = [(a, b)]
    while pieces:
        a, b = pieces.pop()
        piece = a.union(b)
        if value(piece) > 0:
            continue
        rate = slope(piece)
        if rate > 0:
            continue  # from at least zero it rises
        if rate < 0:
            end = value(b)
            if end > 0:
                continue
            if end < 0:
                return _newton(value, slope, a, b)
        if not b - a > smallest:
            raise Undecided(f"{question} cannot be decided; take more digits")
        middle = (a + (b - a) * _CUT).mid()
        pieces += [(middle, b), (a, middle)]
    return None


def _newton(value: Function, slope: Function, a: arb, b: arb) -> arb:
    """Enclose the zero in [a, b] of a function that falls from there to there."""
    root = a.union(b)
    while True:
        middle = min(max(root.mid(), a), b)
        there = value(middle)
        closer = root.intersection(middle - there / slope(root))
        if not 2 * closer.rad() < root.rad():
            # So flat at one end that its slope says little: the sign at the middle says half.
            if there > 0:
                closer = middle.union(root.upper())
            elif there < 0:
                closer = root.lower().union(middle)
            if not 1.5 * closer.rad() < root.rad():
                return closer
        root = closer


@dataclass(frozen=True)
class Surface:
    """Something that stops a flight: where a function of the state falls to zero.

    Attributes
    ----------
    name, question
        The stop, and what is asked if it cannot be decided.
    value
        The function on a step, as a polynomial.
    slope
        Its derivative on a step.
    place
        Puts a state onto the surface.
    """

    name: Stop
    question: str
    value: Callable[[Step], arb_poly]
    slope: Callable[[Step, arb], arb]
    place: Callable[[State], State]

    def first(self, step: Step, until: arb) -> arb | None:
        """Enclose the first time on a step at which the surface is met; see `_first_root`."""
        value = self.value(step)
        since = self._leaves(value, until) if step.start == 0 else arb(0)
        if since is None:
            return arb(0)
        return _first_root(
            value, lambda t: self.slope(step, t), since, until, f"whether {self.question}"
        )

    def _leaves(self, value: arb_poly, until: arb) -> arb | None:
        """Return a time up to which a flight from launch is off the surface; None if it is not.

        A launch from the surface leaves it if the first coefficient that is not zero is positive.
        """
        coefficients = value.coeffs()
        zeros = next((n for n, c in enumerate(coefficients) if not c.is_zero()), None)
        if zeros is None or (zeros > 0 and coefficients[zeros] < 0):
            return None
        if coefficients[zeros] < 0:
            raise CannotSolve(f"the flight starts beyond the point where {self.question}")
        if not coefficients[zeros] > 0:
            raise Undecided(f"whether at launch {self.question} cannot be decided")
        if zeros == 0:
            return arb(0)
        rest = arb_poly(coefficients[zeros:])
        while not rest(arb(0).union(until)) > 0:
            until = until / 2
        return until


def _surfaces(forces: Forces[arb], stops: Stops[arb], balls: Balls) -> list[Surface]:
    accelerate = acceleration(forces, balls)
    surfaces = []
    if (floor := stops.floor) is not None:
        surfaces.append(
            Surface(
                "floor",
                "the ball touches the ground",
                lambda step: step.z - floor,
                lambda step, t: step.w(t),
                lambda state: state._replace(z=floor),
            )
        )
    if (wall := stops.wall) is not None:
        surfaces.append(
            Surface(
                "wall",
                "the ball reaches the plate",
                lambda step: wall - step.s,
                lambda step, t: -step.u(t),
                lambda state: state._replace(s=wall),
            )
        )
    if stops.vertical:
        surfaces.append(
            Surface(
                "vertical",
                "the ball turns vertical",
                lambda step: step.u,
                lambda step, t: accelerate(step.u(t), step.w(t))[0],
                lambda state: state._replace(u=arb(0)),
            )
        )
    return surfaces


def _first_stop(path: Path, forces: Forces[arb], stops: Stops[arb], balls: Balls) -> Arrival[arb]:
    surfaces = _surfaces(forces, stops, balls)
    limit = stops.time_limit
    for step in path.steps():
        until = min(step.length, (limit - step.start).upper())
        met = [
            (root, surface)
            for surface in surfaces
            if (root := surface.first(step, until)) is not None
        ]
        if met:
            root, surface = _earliest(met)
            time = step.start + root
            if time < limit:
                return Arrival(surface.name, time, surface.place(step.at(root)), path)
            if not time > limit:
                raise Undecided(
                    f"whether {surface.question} within the time limit cannot be decided; "
                    "take more digits"
                )
        end = step.start + step.length
        if end >= limit or met:
            return Arrival("time", limit, step.at(limit - step.start), path)
    raise AssertionError("a path does not end")


def _earliest(met: list[tuple[arb, Surface]]) -> tuple[arb, Surface]:
    for root, surface in met:
        # What holds at launch comes before all else; the ground is asked first.
        if root.is_zero() or all(root < other for other, rival in met if rival is not surface):
            return root, surface
    questions = " or ".join(surface.question for _, surface in met)
    raise Undecided(f"whether {questions} first cannot be decided; take more digits")


# --- the bat --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Leg:
    """A part of a pitch on which the distance to the bat's axis only falls, or only rises.

    Attributes
    ----------
    pieces
        Steps, and the times on each, from where to where, that make up the leg.
    end
        State at the leg's end.
    """

    pieces: list[tuple[Step, arb, arb]]
    end: State


def _touch(
    path: Path, forces: Forces[arb], bat: BatSection[arb], stops: Stops[arb], balls: Balls
) -> Touch[arb]:
    """Go from one turn of the distance to the next, up to one that is less than `reach`.

    The first touching lies on the way there: before it the distance was never as little.
    """
    start = next(path.steps()).at(arb(0))
    gap = balls.sqrt(_distance_squared(start, bat)) - bat.reach
    if gap < 0:
        raise CannotSolve(
            f"the ball starts inside the bat: {float(gap + bat.reach):.6g} m from its axis, "
            f"where the two touch at {float(bat.reach):.6g} m; release it farther from the plate"
        )
    if not gap >= 0:
        raise Undecided(balls.open("whether the ball starts inside the bat or touches it", gap))
    past = -(bat.x + bat.reach) / bat.cos
    end = _first_stop(path, forces, replace(stops, wall=past), balls)
    closest = -gap
    for leg in _legs(path, forces, bat, end, balls):
        margin = bat.reach - balls.sqrt(_distance_squared(leg.end, bat))
        closest = closest.max(margin)
        if margin > 0:
            return Touch(margin, True, *_first_touching(leg, bat))
        if not margin < 0:
            question = "whether the ball touches the bat"
            return Touch(margin, None, doubt=balls.open(question, margin))
    if end.stop == "vertical":
        raise CannotSolve(
            "the pitch turns vertical over the plate, where a lift that is always up "
            "has no direction; use lift_direction = fixed_spin_axis"
        )
    return Touch(closest, False)


def _distance_squared(state: State, bat: BatSection[arb]) -> arb:
    x, z = bat.x + bat.cos * state.s, state.z - bat.height
    return x * x + z * z


def _legs(
    path: Path, forces: Forces[arb], bat: BatSection[arb], end: Arrival[arb], balls: Balls
) -> Iterator[Leg]:
    accelerate = acceleration(forces, balls)
    start = next(path.steps()).at(arb(0))
    approaching = balls.positive(
        -contact.radial_velocity(start, bat), arb(0), "whether the ball approaches the bat"
    )
    pieces: list[tuple[Step, arb, arb]] = []
    for step in path.steps():
        ends_here = end.time <= step.start + step.length
        until = (end.time - step.start).upper() if ends_here else step.length
        since: arb | None = arb(0)
        while since is not None and since < until:
            turn = _turn(step, since, until, approaching, bat, accelerate)
            pieces.append((step, since, until if turn is None else turn.upper()))
            since = None
            if turn is not None:
                yield Leg(pieces, step.at(turn))
                pieces, approaching, since = [], not approaching, turn.upper()
        if ends_here:
            yield Leg(pieces, end.state)
            return


def _turn(
    step: Step,
    since: arb,
    until: arb,
    approaching: bool,
    bat: BatSection[arb],
    accelerate: Callable[[arb, arb], tuple[arb, arb]],
) -> arb | None:
    """Enclose where the distance turns from falling to rising, or back."""
    sign = -1 if approaching else 1
    return _first_root(
        lambda t: sign * contact.radial_velocity(step.at(t), bat),
        lambda t: sign * contact.radial_acceleration(step.at(t), bat, accelerate),
        since,
        until,
        "whether the ball comes closer to the bat or recedes",
    )


def _first_touching(leg: Leg, bat: BatSection[arb]) -> tuple[arb, State]:
    """Enclose where the distance falls to `reach`, on a leg that ends with less."""
    for step, since, until in leg.pieces:
        root = _first_root(
            lambda t: (_distance_squared(step.at(t), bat) - bat.reach * bat.reach) / 2,  # noqa: B023
            lambda t: contact.radial_velocity(step.at(t), bat),  # noqa: B023
            since,
            until,
            "when the ball touches the bat",
        )
        if root is not None:
            return step.start + root, step.at(root)
    raise AssertionError("a continuous function that changes sign has a zero")
