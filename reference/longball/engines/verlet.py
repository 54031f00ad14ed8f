"""The paper's scheme: velocity Verlet in fixed steps, with the collision of its Appendix B.

One step of length Δt, from position r, velocity v and acceleration a (Frenkel and Smit,
"Understanding Molecular Simulation", 2nd ed., Sec. 4.3)::

    v½ = v + a Δt/2        r' = r + v½ Δt        v' = v½ + a' Δt/2

This is explicit if the force depends on the position only. Here it depends on the velocity, and a'
needs the unknown v'. `TREATMENTS` lists six ways to evaluate it. Everything else is as printed:

- Time is t = kΔt with k counted in whole steps, one rounding, never a sum of steps.
- Plate (Sec. III.A): position, velocity and time are interpolated linearly between the two steps
  around it. The ground likewise, under ``landing="interpolated"``.
- Contact (Sec. III.C): tested at the ends of steps only, as is whether the ball is between the
  bat's ends; contacts between steps are missed. The bat is at its final height from the release on,
  so a step before the plate can already touch it.
- Appendix B: the ball returns to the previous step. From there it moves along a straight line, with
  the velocity of that step, to the contact after Δt', where normal, bat velocity and restitution
  are evaluated. Then half of the averaged force acts over two whole steps from the previous step.

The paper is silent about some details of these steps:

- The ends of the steps at which the contact force acts: see `PUSHES`.
- Contact force and air act together in ordinary steps. The force of the air is computed again where
  the contact force begins and ends; in between, it is carried or not, as elsewhere.
- The contact force is not in the pitch's vertical plane, so these steps are computed in space. Drag
  and lift act in the vertical plane of the current velocity, as on a ball launched with backspin in
  this direction. At their ends, these steps agree with both flights.
- A ball that reaches the ground during these steps has landed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path as File
from typing import Any, NamedTuple, TypeVar, get_args

import numpy as np

from longball.engines.compiled import BEYOND, Code
from longball.engines.engine import CannotSolve, Launch, OutOfRange, Stepped, TooLong, Touch
from longball.engines.event import TURNS_VERTICAL, BatSection, Event, Events, inside_bat
from longball.engines.path import Flight, Path
from longball.engines.path_engine import branches_at, form_at, no_direction, require_law
from longball.engines.polynomial import ARRAYS, Dual
from longball.model.arrays import Array
from longball.model.atmosphere import ROUGHNESS
from longball.model.frame import Frame, launch_frame
from longball.model.law import Law, PlaneState, SpaceState, State
from longball.model.numbers import DOUBLES, Numbers, Vector
from longball.model.readings import AppendixBRoot, ContactForce, VerletForces, VerletLanding
from longball.model.trace import Names, Program, run_source

T = TypeVar("T")
Components = tuple[float, ...]

# Overflow is reported by `_require_finite`, not by NumPy's warnings.
_QUIET = np.errstate(all="ignore")


class Treatment(NamedTuple):
    """Treatment of the force at a step's end, which depends on the velocity there."""

    ahead: float  # a' is evaluated at v + ahead · a Δt
    iterates: bool  # and then at the v' that it leads to, until v' no longer changes
    carries: bool  # the next step begins with it, instead of with the force at v'


# One force evaluation a step if carried, two if not, about eight if iterated. With forces that
# depend on the velocity alone, old_recomputed moves v as Euler's method does, predicted_recomputed
# as Heun's, implicit as the trapezoidal rule; half_step is Euler's method for v at the half steps.
TREATMENTS: dict[VerletForces, Treatment] = {
    "old_carried": Treatment(0.0, iterates=False, carries=True),
    "old_recomputed": Treatment(0.0, iterates=False, carries=False),
    "half_step": Treatment(0.5, iterates=False, carries=True),
    "predicted_carried": Treatment(1.0, iterates=False, carries=True),
    "predicted_recomputed": Treatment(1.0, iterates=False, carries=False),
    "implicit": Treatment(1.0, iterates=True, carries=False),
}

# The steps from the one gone back to at which the contact force F̄/2 is on (1) or off. Each end of
# a step gives Δt/2 of its acceleration to the velocity (first lines), so that the impulse is a
# quarter of F̄ Δt for each. `whole` is constant over two steps and does not enter the third. The
# others behave like ordinary accelerations and are carried into the next step: on at t, t + Δt
# and t + 2Δt (`carried`), at the last two of these (`late`) or at the first two (`early`).
PUSHES: dict[ContactForce, tuple[int, ...]] = {
    "whole": (1, 1, 1),
    "carried": (1, 1, 1, 0),
    "late": (0, 1, 1, 0),
    "early": (1, 1, 0),
}


def impulse_share(contact_force: ContactForce) -> float:
    """Impulse of a contact force over F̄ Δt, at any step Δt: 1, 5/4, 1 or 3/4."""
    on = PUSHES[contact_force]
    return (sum(on[:-1]) + sum(on[1:])) / 4


# Steps that are taken at a time: at first a few more than a flight of the paper's steps has, so
# that it takes one array; at most as many as fit a processor's cache.
_FIRST_STEPS, _MOST_STEPS = 128, 4096  # a free choice

# Most steps up to the time limit; compiled, they take about ten seconds. The landing is not known
# before the flight, so the whole time counts. With the default limit of 60 s, steps of 3e-7 s and
# more are allowed.
_MOST_WORK = 200_000_000

# A step takes about ten microseconds as it is; to compile it takes two seconds.
_ENOUGH = 100_000  # a free choice


OPTIONS: dict[str, tuple[str, ...]] = {
    "forces": tuple(TREATMENTS),
    "landing": get_args(VerletLanding),
    "root": get_args(AppendixBRoot),
    "contact_force": tuple(PUSHES),
}


@dataclass(frozen=True, kw_only=True)
class SteppedTouch(Touch):
    """Contact of a pitch with the bat in steps."""

    step: int  # number of the step before the first one in the bat
    before: State  # the state there
    ahead: float  # Δt', s


Top = tuple[float, State] | None


@dataclass(frozen=True)
class SteppedFlight(Flight):
    """A flight whose highest point, on the line between two steps, was recorded on the way.

    To find it later the flight would have to be integrated again.
    """

    top: Top  # s since launch, and the state; None: it only rises

    def highest(self, numbers: Numbers) -> Top:
        """See `Flight.highest`; a hop within one step has none."""
        return None if self.top is None or self.top[0] > self.time else self.top


@dataclass(frozen=True)
class Verlet(Stepped):
    """Flights and contacts in fixed steps."""

    dt: float = 0.05  # s, the step; the paper's
    # Switches of the ledger: verlet_forces, verlet_landing, appendix_b_root, contact_force
    forces: VerletForces = "old_carried"
    landing: VerletLanding = "interpolated"
    root: AppendixBRoot = "first"
    contact_force: ContactForce = "whole"

    numbers = DOUBLES
    # Events are decided by the computed values; the steps' error is part of the scheme.
    flight_error = 0.0

    def __post_init__(self) -> None:
        if not 0 < self.dt < math.inf:
            raise ValueError(f"dt = {self.dt} is not a positive number of seconds")
        for name, options in OPTIONS.items():
            if (chosen := getattr(self, name)) not in options:
                raise ValueError(f"{name} {chosen!r} is not one of {', '.join(options)}")

    @property
    def description(self) -> str:
        """Name, step and readings."""
        chosen = (f"{name}={getattr(self, name)}" for name in OPTIONS)
        return f"verlet dt={self.dt!r} {' '.join(chosen)}"

    @_QUIET
    def fly(self, law: Law, start: State, events: Events, limit: float) -> Flight:
        """Fly until the first of several events; see `longball.engines.engine.Engine.fly`.

        An event is searched at the steps only.

        Raises `TooLong` before the first step if there are too many up to the time limit.
        """

        def chords() -> Iterator[Chord]:
            for done, states in self._march(law, start, limit):
                rows = (law.state(*row) for row in states.T.tolist())
                for count, (before, after) in enumerate(pairwise(rows), done):
                    begin = count * self.dt
                    yield Chord(begin, (count + 1) * self.dt - begin, before, after)

        path = Path(chords())
        # at once: a ball that starts on a surface, or below it, and does not rise
        for event in events:
            if event.value(start) > 0.0:
                continue
            rates = form_at(law, start, DOUBLES).rates(DOUBLES)(*start)
            _, acceleration = _halves(rates)
            # Where the value neither rises nor falls, its second derivative tells.
            changes = rates, (*acceleration, *(0.0 for _ in acceleration))
            signs = (event.value(law.state(*map(Dual, start, x))).rate for x in changes)
            if next((change for change in signs if change != 0.0), -1.0) < 0.0:
                return Flight(path, event.name, 0.0, start)

        # the first step at whose end a value is not positive; the highest point on the way
        count, before, after = 0, start, start
        top: Top = None if start.w > 0.0 else (0.0, start)
        for done, states in self._march(law, start, limit):
            columns = law.state(*states)
            met = np.array([event.value(columns)[1:] <= 0.0 for event in events])
            step = 1 + int(met.any(axis=0).argmax()) if met.any() else states.shape[1] - 1
            count = done + step
            before, after = (law.state(*row) for row in states.T[step - 1 : step + 1].tolist())
            self._require_finite((*before, *after))
            # the highest point so far: here, or before
            rises = columns.w[: step + 1] > 0.0
            for k in np.flatnonzero(rises[:-1] & ~rises[1:]).tolist():
                a, b = (law.state(*row) for row in states.T[k : k + 2].tolist())
                fraction = _fraction_to_zero(a.w, b.w)
                state = _between(a, b, fraction)
                if top is None or state.z > top[1].z:
                    top = (done + k + fraction) * self.dt, state
            if met.any():
                stop, time, state = self.stop_between(count, before, after, events)
                # The last step may go beyond the limit: the flight then ends with the one before.
                if time > limit:
                    stop, time, state = "time", (count - 1) * self.dt, before
                return SteppedFlight(path, stop, time, state, top)
        return SteppedFlight(path, "time", count * self.dt, after, top)

    def stop_between(
        self, count: int, before: State, after: State, events: Events
    ) -> tuple[str, float, State]:
        """First event in step number `count`: its name, time, s, and the state."""
        ends = [(event, event.value(before), event.value(after)) for event in events]
        met = [(_fraction_to_zero(a, b), event) for event, a, b in ends if b <= 0.0]
        fraction, event = min(met, key=lambda each: each[0])
        if event.name == "ground" and self.landing == "first_below":
            return event.name, count * self.dt, after
        state = _between(before, after, fraction)
        return event.name, (count - 1 + fraction) * self.dt, event.place(state)

    @_QUIET
    def touch(
        self,
        pitch: Flight,
        law: Law,
        bat: BatSection,
        events: Events,
        limit: float,
    ) -> Touch:
        """Find the first step in the bat; see `longball.engines.engine.Engine.touch`.

        The margin is that of the closest step. If the ball is inside the bat at a step but Appendix
        B's line from the step before misses the bat, the contact is in doubt.
        """
        start = pitch.path.at(0.0)
        closest = _distance(bat, start)
        if closest < bat.reach:
            raise inside_bat(closest, bat.reach)

        # the first step inside the bat, and the closest step
        step, hit = 0, None
        for done, states in self._march(law, start, limit):
            columns = law.state(*states)
            distance = _distance(bat, columns)
            ended = [event.value(columns) <= 0.0 for event in events]
            past = bat.frame.towards_x(columns) <= -bat.reach
            over = np.logical_or.reduce([past, *ended])[1:]
            last = 1 + int(over.argmax()) if over.any() else states.shape[1] - 1
            self._require_finite(states[:, last].tolist())
            # The step in which the ball lands or turns vertical is excluded, as the pitch is over;
            # the step that takes it past the bat is not, as it may still overlap the bat's back.
            seen = 1 + last - any(end[last] for end in ended)
            closest = min(closest, distance[:seen].min())
            inside = distance[1:seen] < bat.reach
            if hit is None and inside.any():
                step = done + int(inside.argmax())
                hit = [law.state(*row) for row in states.T[step - done : step - done + 2].tolist()]
            if over.any():
                if hit is None:
                    for event, end in zip(events, ended, strict=True):
                        if event.name == "vertical" and end[last]:
                            raise CannotSolve(TURNS_VERTICAL)
                break
        margin = bat.reach - float(closest)
        if hit is None:
            return Touch(margin, False)

        # the touching, on the line from the step before
        before, inside_state = hit
        ahead = line_touch(before, bat, self.root)
        if ahead is None:
            return Touch(
                margin,
                None,
                doubt=f"Appendix B has no Δt': the ball is in the bat at step {step + 1} of "
                f"{self.dt!r} s, but the straight line from the step before does not meet it",
            )
        position, velocity = _halves(before)
        place, split = position[: len(velocity)], 2 * len(velocity)
        rates = form_at(law, before, DOUBLES).rates(DOUBLES)(*before)
        along = _plus(before[split:], ahead, rates[split:])
        touching = law.state(*_plus(place, ahead, velocity), *velocity, *along)
        return SteppedTouch(
            margin,
            True,
            step * self.dt + ahead,
            touching,
            step=step,
            before=before,
            inside=inside_state,
            ahead=ahead,
            leaving=self.root == "larger",
        )

    def rebound(
        self,
        frame: Frame,
        touch: SteppedTouch,
        delta_v: Vector,
        law_in: Callable[[Frame], Law],
        ground: Event,
    ) -> Launch:
        """Push for two or three steps from the step before the contact (paper, Appendix B)."""
        air, dt, on = air_in_space(law_in), self.dt, PUSHES[self.contact_force]
        # F̄/(2m) where it is on, m/s². With F̄ Δt the whole impulse (paper, Sec. III.C), that is
        # delta_v/(2 Δt).
        pushes = [tuple(each * change / (2 * dt) for change in delta_v) for each in on]
        position, velocity = frame.position(touch.before), frame.velocity(touch.before)
        force = air(position, velocity)
        for done, push in enumerate(pairwise(pushes), 1):
            before = SpaceState(*position, *velocity)
            position, velocity, force = plain_step(
                position, velocity, force, *push, dt, *TREATMENTS[self.forces], air
            )
            # A ball that is down before it is free has landed.
            count, after = touch.step + done, SpaceState(*position, *velocity)
            self._require_finite(after)
            if ground.value(after) <= 0.0:
                _, time, down = self.stop_between(count, before, after, [ground])
                x, y, z, u, v, w = down
                delay = time - touch.step * dt - touch.ahead
                return Launch((x, y, z), (u, v, w), time, delay, True)
        return Launch(position, velocity, (touch.step + done) * dt, done * dt - touch.ahead)

    def _march(self, law: Law, start: State, limit: float) -> Iterator[tuple[int, Array]]:
        """Integrate until the time limit; yield ``(first, states)``.

        `states` has shape (components, steps + 1). Its first column is step number `first`,
        repeated from the end of the array before. Arrays grow up to `_MOST_STEPS` columns.

        Raises `TooLong` before the first step; see `fly`.
        """
        if limit / self.dt > _MOST_WORK:
            raise TooLong(
                f"time_limit = {limit:.6g} s takes more than {_MOST_WORK:,} steps of {self.dt!r} s;"
                f" take a time_limit of {_MOST_WORK * self.dt:.3g} s or less, or a longer step"
            )
        steps, treatment = math.ceil(limit / self.dt), TREATMENTS[self.forces]
        last, done, length = np.array(start, dtype=float), 0, _FIRST_STEPS
        branches = branches_at(law, start, DOUBLES)
        require_law(law, branches, 0.0)
        form = law.on(branches) if law.switches else law
        force = _acceleration(form, start)
        while done < steps:
            states = np.full((len(start), 1 + min(length, steps - done)), math.nan)
            states[:, 0] = last
            march = steps_of(form.program).count(states.shape[1]).march
            with suppress(*BEYOND):
                begin = _halves(last.tolist())
                force = march(states, *begin, force, self.dt, *treatment, _parameters(form))
            # A step is taken on one branch of the law, whatever it passes. The first one that ends
            # on another branch is the last of the array; the next step begins on that branch.
            passed, turned = np.zeros((2, states.shape[1] - 1), bool)
            # Below the ground, where a step may end, a profile of the wind may be undefined.
            with np.errstate(all="ignore"):
                for switch, branch in zip(law.switches, branches, strict=True):
                    for number, threshold in enumerate(switch.thresholds):
                        beyond = form.beyond(switch, threshold, ARRAYS)(states[:, 1:])
                        passed |= (beyond > 0.0) != (number < branch)
                if "side" in form.strengths:
                    # The airspeed passes the direction of the side force, which turns round: its
                    # cross products at the two ends have opposite signs.
                    aside = np.array(np.broadcast_arrays(*form.aside(form.state(*states), ARRAYS)))
                    turned = np.einsum("ij,ij->j", aside[:, :-1], aside[:, 1:]) < 0.0
            passed |= turned
            if passed.any():
                states = states[:, : 2 + int(np.argmax(passed))]
            yield done, states
            last, done, length = (
                states[:, -1],
                done + states.shape[1] - 1,
                min(4 * length, _MOST_STEPS),
            )
            if passed.any():
                if turned[: states.shape[1] - 1].any():
                    raise no_direction(done * self.dt)
                branches = branches_at(law, law.state(*last.tolist()), DOUBLES)
                require_law(law, branches, done * self.dt)
                form = law.on(branches)
                force = _acceleration(form, last.tolist())

    def _require_finite(self, numbers: Sequence[float]) -> None:
        if not all(map(math.isfinite, numbers)):
            raise OutOfRange(
                f"the numbers do not stay finite in steps of {self.dt!r} s, or an "
                "implicit step does not settle: the step is too long for these forces"
            )


# --- the rules between the steps ------------------------------------------------------------------

Value = TypeVar("Value", float, Array)


def interpolate(before: Value, after: Value, fraction: float) -> Value:
    """Return the value at a fraction of the way from one step to the next."""
    return before + fraction * (after - before)


def _between(before: State, after: State, fraction: float) -> State:
    return type(before)(*(interpolate(a, b, fraction) for a, b in zip(before, after, strict=True)))


def _fraction_to_zero(before: float, after: float) -> float:
    """Fraction of a step after which a value has fallen to zero, on a line."""
    # A ball that is set free below the ground, or launched on it, is there at once.
    return max(0.0, before / (before - after)) if after != before else 0.0


@dataclass(frozen=True)
class Chord:
    """The straight line between two steps; see `longball.engines.event.Piece`."""

    begin: float
    length: float
    before: State
    after: State

    def at(self, t: float) -> State:
        """Return the state at a time on the line, s since it begins."""
        return (
            self.after if t == self.length else _between(self.before, self.after, t / self.length)
        )

    def curve(self, value: Callable[[Any], Any]) -> ChordCurve:
        """Return the value of an event along the line."""
        return ChordCurve(value(self.before), value(self.after), self.length)


class ChordCurve(NamedTuple):
    """The value of an event as the scheme sees it: at the steps, and between them on a line."""

    before: float
    after: float
    length: float

    def __call__(self, t: float) -> float:
        """Return the value."""
        return float(interpolate(self.before, self.after, t / self.length))

    def positive(self, a: float, b: float) -> bool:
        """See `longball.engines.event.Curve.positive`: here exact, as the value is linear."""
        return self(a) > 0.0 and self(b) > 0.0

    def turns(self, a: float, b: float) -> tuple[float, ...]:
        """Return nothing: a line does not turn."""
        return ()

    def zero(self, a: float, b: float) -> float:
        """See `longball.engines.event.Curve.zero`."""
        return interpolate(a, b, _fraction_to_zero(self(a), self(b)))


def line_touch(before: State, bat: BatSection, root: AppendixBRoot) -> float | None:
    """Return Δt', s, after which a ball on a straight line at constant velocity touches the bat.

    The roots of |d + v Δt'|² = reach² (paper, Appendix B). None if they are not real and positive.
    """
    a = bat.frame.velocity(before)[0] ** 2 + before.w**2
    b = bat.approach(before)
    c = bat.outside(before)
    discriminant = b * b - a * c
    if b >= 0.0 or discriminant < 0.0:
        return None
    # Added, not subtracted, so that neither root cancels.
    larger = -b + math.sqrt(discriminant)
    return float(larger / a if root == "larger" else c / larger)


def _distance(bat: BatSection, state: State) -> Any:
    """Return the distance from the bat's axis, m, of a state, or of states in columns."""
    return np.hypot(bat.frame.towards_x(state), state.z - bat.height)


def _halves(state: Sequence[T]) -> tuple[tuple[T, ...], tuple[T, ...]]:
    """Return positions and velocities of a state, or velocities and accelerations of its rates.

    The path through the air, which a state may end with, goes with the positions.
    """
    dimensions = len(state) // 2
    split = 2 * dimensions
    return (*state[:dimensions], *state[split:]), tuple(state[dimensions:split])


# --- the step, for a law --------------------------------------------------------------------------

_SOURCE = File(__file__).with_name("verlet_steps.py").read_text(encoding="utf-8")


@cache
def steps_of(program: Program) -> Code:
    """Compile `longball.engines.verlet_steps` together with the functions of a law."""
    return Code(_SOURCE + print_law(program), _ENOUGH)


def print_law(program: Program) -> str:
    """Print the functions that the steps under a law call, in as many dimensions as it has.

    Vectors are tuples, printed component by component: numba cannot build a tuple in a loop.
    """
    positions, velocities = _halves(program.variables)
    dimensions = range(len(velocities))
    names = Names()
    # the law, as `longball.model.trace` prints it
    lines = [line for node in program.nodes if (line := names.define(node))]
    unpack = [
        f"{', '.join(each)}, = {name}"
        for each, name in (
            (positions, "position"), (velocities, "velocity"), (program.parameters, "parameters")
        )
        if each
    ]  # fmt: skip
    if ROUGHNESS in program.parameters:
        # A step may end below the ground, and the logarithmic profile is undefined below -z₀. Take
        # the wind of height 0 there, which is none.
        unpack.append(f"z = z if z > -{ROUGHNESS} else 0.0")

    def each(text: str) -> str:
        return "".join(text.format(i=i) + ", " for i in dimensions)

    # The state is (positions, velocities, path): the path through the air counts as a position,
    # whose rate is the airspeed.
    both = len(velocities)
    outputs = ", ".join(names[output] for output in program.outputs[both : 2 * both])
    numbers = [f"{name}[{i}]" for name in ("position", "velocity") for i in dimensions]
    numbers += [f"position[{i}]" for i in range(both, len(positions))]
    paths = "".join(
        f"{name} + dt * {names[rate]}, "
        for name, rate in zip(program.variables, program.outputs, strict=True)
        if name in positions[both:]
    )
    functions = {
        "accelerate(position, velocity, parameters)": [*unpack, *lines, f"return {outputs}"],
        "plus(a, factor, b)": [f"return ({each('a[{i}] + factor * b[{i}]')})"],
        "moved(position, dt, velocity, parameters)": [
            *(unpack + lines if paths else []),
            f"return ({each('position[{i}] + dt * velocity[{i}]')}{paths})",
        ],
        "largest(a)": [f"return max({each('abs(a[{i}])')})"],
        "write(states, k, position, velocity)": [
            f"states[{i}, k] = {number}" for i, number in enumerate(numbers)
        ],
    }
    written = "".join(
        f"\n\ndef {head}:\n" + "".join(f"    {line}\n" for line in body)
        for head, body in functions.items()
    )
    return f"\n\nfrom math import exp, log, sqrt\n{written}"


def _plus(a: Sequence[float], factor: float, b: Sequence[float]) -> tuple[float, ...]:
    """Return ``a + factor b``, component by component."""
    return tuple([x + factor * y for x, y in zip(a, b, strict=True)])  # faster than a generator


# The step in plain Python, for any vectors; its `parameters` are the acceleration.
plain_step: Callable[..., Any] = run_source(
    _SOURCE,
    "step",
    {
        "accelerate": lambda position, velocity, air: air(position, velocity),
        "plus": _plus,
        "moved": lambda position, dt, velocity, _: _plus(position, dt, velocity),
        "largest": lambda a: max(map(abs, a)),
    },
)


def air_in_space(law_in: Callable[[Frame], Law]) -> Callable[..., Vector]:
    """Return the acceleration as a function of position and velocity in space.

    It lies in the vertical plane of the velocity. `law_in(frame)` is the law of a flight there.
    """

    def air(position: Vector, velocity: Vector) -> Vector:
        frame, launch = launch_frame(position, velocity, DOUBLES)
        law = law_in(frame)
        there = law.state_of(launch)
        acceleration = _acceleration(form_at(law, there, DOUBLES), there)
        state = PlaneState if len(acceleration) == 2 else SpaceState
        return frame.velocity(state(*(0.0 for _ in acceleration), *acceleration))

    return air


def _acceleration(law: Law, state: Sequence[float]) -> Components:
    """Return the acceleration in a state; NaN beyond the range of doubles."""
    position, velocity = _halves(list(map(float, state)))
    try:
        acceleration: Components = (
            steps_of(law.program).count().accelerate(position, velocity, _parameters(law))
        )
    except BEYOND:
        return (math.nan,) * len(velocity)
    return acceleration


def _parameters(law: Law) -> Components:
    return tuple(float(law.strengths[name]) for name in law.program.parameters)
