"""The reference engine: `scipy.integrate.solve_ivp` with terminal events.

The events are where solve_ivp is weakest, in two ways. It looks for a change of sign between its
steps, so that a ball that dips and comes back within a step is not seen: here every event is a
function that changes sign once (for the bat see `longball.engines.contact`; for the ground the
lowest point of a dip is an event too). And it finds the event on its interpolant, whose order is
lower than that of its steps: here the last step is taken again, onto the event.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
import scipy.integrate
import scipy.optimize
from numpy.typing import NDArray

from longball.engines import contact
from longball.engines.contact import Acceleration
from longball.engines.engine import Arrival, BatSection, CannotSolve, Stop, Stops, Touch
from longball.model.motion import Forces, PlaneState, acceleration
from longball.model.numbers import DOUBLES, Doubles

METHODS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")

State = PlaneState[float]
Array = NDArray[np.float64]
Event = Callable[[float, Array], float]


@dataclass(frozen=True)
class Surface:
    """Something that a flight can reach: where a function of the state changes sign.

    Attributes
    ----------
    name
        Under which a flight reports it.
    value, rate
        The function, and its derivative in time.
    direction
        +1 if the function rises through zero there, -1 if it falls.
    place
        Puts a state that is within rounding of the surface onto it.
    leaves
        Whether the flight starts on the surface, which then is not an arrival.
    """

    name: str
    value: Callable[[State], float]
    rate: Callable[[State], float]
    direction: int
    place: Callable[[State], State] = lambda state: state
    leaves: bool = False

    def event(self, start: float) -> Event:
        """Return the terminal event for solve_ivp, for a flight that begins at `start`."""

        def event(time: float, y: Array) -> float:
            value = self.value(PlaneState(*y.tolist()))
            if not self.leaves:
                return value
            # Divided by the time, the root at the start is gone and the next one stays.
            return value / (time - start) if time > start else float(-self.direction)

        event.terminal = True  # type: ignore[attr-defined]
        event.direction = self.direction  # type: ignore[attr-defined]
        return event


@dataclass(frozen=True)
class Leg:
    """The accepted steps of a piece of a flight: times, s, and states, a column each."""

    times: Array
    states: Array

    def at(self, step: int) -> tuple[float, State]:
        """Return time and state of a step."""
        return float(self.times[step]), PlaneState(*self.states[:, step].tolist())

    def before(self, time: float) -> tuple[float, State]:
        """Return the last step that is not after a time."""
        return self.at(max(0, int(np.searchsorted(self.times, time, side="right")) - 1))

    def ending_in(self, time: float, state: State) -> Leg:
        """Return the leg with another end."""
        return Leg(np.append(self.times[:-1], time), np.column_stack([self.states[:, :-1], state]))


@dataclass(frozen=True)
class Ivp:
    """Flights by `scipy.integrate.solve_ivp`.

    Attributes
    ----------
    method
        Any of solve_ivp's methods, by name.
    rtol, atol
        Tolerances of its steps, relative and absolute (m and m/s). With DOP853 at the default
        every landing of 700 batted balls was good to 3e-12 m, for 1.4 to 1.5 times the time of a
        plain solve at 1e-12 (`python -m analysis accuracy`).
    """

    method: str = "DOP853"
    rtol: float = 5e-14
    atol: float = 5e-14

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise ValueError(f"method {self.method!r} is not one of {', '.join(METHODS)}")
        smallest = 100 * np.finfo(float).eps  # below this solve_ivp raises it with a warning
        if not smallest <= self.rtol < 1:
            raise ValueError(f"rtol = {self.rtol} is not between {smallest:.3g} and 1")
        if not 0 < self.atol < 1:
            raise ValueError(f"atol = {self.atol} is not between 0 and 1")

    @property
    def numbers(self) -> Doubles:
        """Double precision."""
        return DOUBLES

    @property
    def description(self) -> str:
        """Name, method and tolerances."""
        return f"ivp {self.method} rtol={self.rtol:g} atol={self.atol:g}"

    @property
    def flight_error(self) -> float:
        """Relative error of a state at the end of a flight.

        The steps' errors add up. Over pitches of all sorts, steep ones included, the plate was
        reached within 2.3 tolerances by one-step methods, and within 70 by multistep methods,
        whose steps are many; for the paper's own pitches within 0.02, which is rounding
        (`tests/engines/test_contact.py`).
        """
        tolerances = 100 if self.method in _ONE_STEP else 10
        return tolerances * max(self.rtol, self.atol)

    def fly(self, start: State, forces: Forces[float], stops: Stops[float]) -> Arrival[float]:
        """Fly until the first stop; see `longball.engines.engine.Engine.fly`."""
        try:
            return self._told(self._fly(start, forces, stops), stops)
        except _TooMuchWork as work:
            if not work.settled or self.method in ("Radau", "BDF"):
                raise
            # Stiff: nothing but rounding happens any more, and only an implicit step can be long.
            return replace(self, method="Radau").fly(start, forces, stops)

    def _fly(self, start: State, forces: Forces[float], stops: Stops[float]) -> Arrival[float]:
        accelerate = _limited(acceleration(forces, DOUBLES), forces.gravity or 0.0)
        floor = stops.floor
        if floor is not None and _rests_on(floor, start, accelerate):
            return Arrival("floor", 0.0, start, Leg(np.zeros(1), np.array([start]).T))
        if start.u == start.w == 0.0 and forces.gravity is None:
            # At rest with nothing to move it: without end, and no turning point to wait for.
            return Arrival("time", stops.time_limit, start, Leg(np.zeros(1), np.array([start]).T))
        surfaces = _stop_surfaces(start, stops, accelerate)
        # Only lift can turn a falling ball up again, below the ground perhaps, within one step.
        # Bottoms and tops of the path alternate, so that none is found twice.
        turns = itertools.cycle(_turning_points(accelerate))
        legs: list[Leg] = []
        time, state = 0.0, start
        while True:
            turn = [next(turns)] if floor is not None and forces.lift is not None else []
            leg, met = self._advance(accelerate, time, state, stops.time_limit, surfaces + turn)
            legs.append(leg)
            time, state = leg.at(-1)
            if met is None:
                return Arrival("time", time, state, _joined(legs))
            if floor is not None and met.name == "bottom" and self._dipped(state, floor, time):
                # The way down through the floor, from the parabola around the bottom.
                back = math.sqrt(2 * (floor - state.z) / met.rate(state))
                time, state = self._settle(
                    accelerate, surfaces[0], leg.before(time - back), time - back
                )
                met = surfaces[0]
            if met.name in ("floor", "wall", "vertical"):
                return Arrival(cast(Stop, met.name), time, state, _joined(legs))

    def _told(self, arrival: Arrival[float], stops: Stops[float]) -> Arrival[float]:
        """Return an arrival, unless its error leaves open which stop comes first."""
        state = arrival.state
        error = self.flight_error * max(1.0, abs(state.s), abs(state.z))
        if stops.floor is not None and arrival.stop in ("wall", "time"):
            before = "the plate" if arrival.stop == "wall" else "the time limit"
            DOUBLES.positive(
                state.z - stops.floor, error, f"whether the ball comes down before {before}"
            )
        if stops.wall is not None and arrival.stop == "floor":
            DOUBLES.positive(
                stops.wall - state.s, error, "whether the ball comes down before the plate"
            )
        if arrival.stop == "floor":
            DOUBLES.positive(
                stops.time_limit - arrival.time,
                self.flight_error * arrival.time,
                "whether the ball comes down before the time limit",
            )
        return arrival

    def touch(
        self,
        pitch: Arrival[float],
        forces: Forces[float],
        bat: BatSection[float],
        stops: Stops[float],
    ) -> Touch[float]:
        """Find how a pitch meets the bat; see `longball.engines.engine.Engine.touch`."""
        way = cast(Leg, pitch.record)
        gravity = forces.gravity or 0.0
        near = _first_step_near(way, bat, bat.reach, gravity)
        found = self._search(pitch, forces, bat, stops, *way.at(near))
        if found.touched is False:
            # It may have been closer before it could have touched.
            before = _first_step_near(way, bat, bat.reach - found.margin, gravity)
            if before < near:
                return self._search(pitch, forces, bat, stops, *way.at(before))
        return found

    def _search(
        self,
        pitch: Arrival[float],
        forces: Forces[float],
        bat: BatSection[float],
        stops: Stops[float],
        time: float,
        state: State,
    ) -> Touch[float]:
        """Search for the bat from a time and state of the pitch on."""
        accelerate = _limited(acceleration(forces, DOUBLES), forces.gravity or 0.0)
        # The bat is put at the height of this very state. Settled from it, a few milliseconds
        # away, the closest approach shares its error, which then is none of the margin's.
        plate: tuple[float, State] | None = (pitch.time, pitch.state)
        error = contact.margin_error(bat, pitch.state, self.flight_error)
        if contact.backward_growth(state, pitch.time - time, forces) > math.e:
            plate = None
            error += self.flight_error * max(abs(bat.x), abs(pitch.state.z))
        distance = contact.distance(state, bat)
        gap = distance - bat.reach
        if gap < -error:
            raise CannotSolve(
                f"the ball starts inside the bat: {distance:.6g} m from its axis, "
                f"where the two touch at {bat.reach:.6g} m; release it farther from the plate"
            )
        at_once = gap <= error and contact.radial_velocity(state, bat) < 0
        ends = _search_ends(bat, stops, accelerate)
        closest = -gap
        approaching = contact.radial_velocity(state, bat) < 0
        max_step = contact.longest_step(state, bat, forces)
        while True:
            turn = _radial_turn(bat, accelerate, +1 if approaching else -1)
            leg, met = self._advance(
                accelerate, time, state, stops.time_limit, [*ends, turn], max_step, plate
            )
            end_time, end = leg.at(-1)
            margin = bat.reach - contact.distance(end, bat)
            closest = max(closest, margin)
            if abs(margin) <= error:
                return Touch(margin, None, doubt=contact.doubt(margin, error))
            if margin > 0:
                if at_once:
                    return Touch(margin, True, time, state)
                found = self._first_touching(accelerate, leg, bat, met is turn, plate)
                return Touch(margin, True, *found)
            if met is not turn:
                if met is not None and met.name == "vertical":
                    raise CannotSolve(
                        "the pitch turns vertical over the plate, where a lift that is always up "
                        "has no direction; use lift_direction = fixed_spin_axis"
                    )
                return Touch(closest, False)
            time, state, approaching = end_time, end, not approaching

    def _first_touching(
        self,
        accelerate: Acceleration,
        leg: Leg,
        bat: BatSection[float],
        at_closest: bool,
        base: tuple[float, State] | None,
    ) -> tuple[float, State]:
        """Find where the distance falls to reach, on a leg along which it only falls.

        It is settled from `base`, or else from the last step before it.
        """
        surface = _bat_surface(bat)
        end_time, end = leg.at(-1)
        if at_closest:
            # A straight line through the closest point: d² = d_min² + V² (t - t_min)².
            d = contact.distance(end, bat)
            speed = math.hypot(bat.cos * end.u, end.w)
            guess = end_time - math.sqrt((bat.reach - d) * (bat.reach + d)) / speed
            if guess > leg.times[0]:
                time, state = self._settle(accelerate, surface, base or leg.before(guess), guess)
                if leg.times[0] <= time <= end_time and surface.rate(state) < 0:
                    return time, state
        # A strongly curved path: bisect, step by step.
        start = leg.at(0)
        guess = scipy.optimize.brentq(
            lambda t: surface.value(self._step(accelerate, *start, t)), start[0], end_time
        )
        return self._settle(accelerate, surface, base or leg.before(guess), guess)

    def _dipped(self, bottom: State, floor: float, time: float) -> bool:
        if time == 0.0:
            return False
        error = self.flight_error * max(1.0, abs(floor))
        return DOUBLES.positive(
            floor - bottom.z, error, "whether the ball touches the ground at the bottom of a dip"
        )

    # A trial step may overflow; the step control then takes a shorter one or gives up.
    @np.errstate(all="ignore")
    def _advance(
        self,
        accelerate: Acceleration,
        time: float,
        state: State,
        end: float,
        surfaces: list[Surface],
        max_step: float = math.inf,
        base: tuple[float, State] | None = None,
    ) -> tuple[Leg, Surface | None]:
        """Fly until the first surface is met, and settle on it; None if `end` comes first.

        It is settled from `base`, or else from the last step before it.
        """
        if not all(map(math.isfinite, accelerate(state.u, state.w))):
            raise CannotSolve("the forces at launch are beyond the range of double precision")
        solution = scipy.integrate.solve_ivp(
            _right_hand_side(accelerate),
            (time, end),
            np.array(state),
            method=self.method,
            rtol=self.rtol,
            atol=self.atol,
            max_step=max_step,
            events=[surface.event(time) for surface in surfaces],
        )
        if solution.status < 0:
            raise CannotSolve(
                f"solve_ivp gave up at t = {solution.t[-1]:.6g} s: {solution.message}"
            )
        leg = Leg(solution.t, solution.y)
        if solution.status == 0:
            return leg, None
        met = next(s for s, found in zip(surfaces, solution.t_events, strict=True) if found.size)
        guess, _ = leg.at(-1)
        settled = self._settle(accelerate, met, base or leg.at(-2), guess)
        return leg.ending_in(*settled), met

    def _settle(
        self, accelerate: Acceleration, surface: Surface, base: tuple[float, State], guess: float
    ) -> tuple[float, State]:
        """Step again from an accepted step onto a surface, from a guess of the time there.

        Newton's method on the step itself: the answer is as good as the steps are, whatever the
        interpolant that the guess came from.
        """
        time, state = guess, self._step(accelerate, *base, guess)
        smallest = math.inf
        for _ in range(_NEWTON_STEPS):
            rate = surface.rate(state)
            if rate == 0.0:
                break
            dt = -surface.value(state) / rate
            du, dw = accelerate(state.u, state.w)
            far = abs(dt) > _NUDGE * abs(time - base[0])
            if far or abs(dt) * math.hypot(du, dw) > _NUDGE * math.hypot(state.u, state.w):
                time += dt
                state = self._step(accelerate, *base, time)
                continue
            # Newton's method at least halves dt. If it does not, only rounding is left: s, too
            # large to take up so small a change, would stay, and z move on alone.
            if abs(dt) >= 0.75 * smallest:
                break
            time, smallest = time + dt, abs(dt)
            state = PlaneState(
                state.s + dt * (state.u + 0.5 * dt * du),
                state.z + dt * (state.w + 0.5 * dt * dw),
                state.u + dt * du,
                state.w + dt * dw,
            )
        return time, surface.place(state)

    @np.errstate(all="ignore")
    def _step(self, accelerate: Acceleration, time: float, state: State, end: float) -> State:
        """Integrate to a given time, in one step if the tolerances allow it."""
        if end == time:
            return state
        solver = getattr(scipy.integrate, _ONE_STEP.get(self.method, self.method))(
            _right_hand_side(accelerate),
            time,
            state,
            end,
            rtol=self.rtol,
            atol=self.atol,
            first_step=abs(end - time),
        )
        while solver.status == "running":
            message = solver.step()
        if solver.status == "failed":
            raise CannotSolve(f"{self.method} gave up at t = {solver.t:.6g} s: {message}")
        return PlaneState(*solver.y.tolist())


# A multistep method cannot take its last step again: from one state alone it starts at order 1,
# and reaches its tolerance in many steps whose errors add up.
_ONE_STEP = {"BDF": "Radau", "LSODA": "DOP853"}

# Newton's method squares the error, and at a double root (a graze, a tangential landing) halves it.
# As many halvings as there are from a second to the smallest double find even a flight of 1e-30 s.
_NEWTON_STEPS = 1100

# A Taylor step of second order that changes the velocity by this fraction is exact to its square,
# 1e-16; and z keeps the rounding that it had, which a way that is shorter by more would show.
_NUDGE = 1e-8


def _right_hand_side(accelerate: Acceleration) -> Callable[[float, Array], Sequence[float]]:
    def right_hand_side(_: float, y: Array) -> Sequence[float]:
        _, _, u, w = y.tolist()  # doubles of Python: numpy's are five times slower one by one
        return (u, w, *accelerate(u, w))

    return right_hand_side


# A baseball's flight takes 500 evaluations. Strong lift can loop a ball a thousand times a second,
# and a feather in dense air settles to its final speed in microseconds and then falls for a
# minute: an explicit method would take millions.
_MOST_EVALUATIONS = 200_000


class _TooMuchWork(CannotSolve):
    """A flight that takes more evaluations than any should; settled if its speed is its last."""

    def __init__(self, settled: bool) -> None:
        super().__init__(
            f"the flight takes over {_MOST_EVALUATIONS} evaluations; "
            "try a looser tolerance or a shorter time_limit"
        )
        self.settled = settled


def _limited(accelerate: Acceleration, gravity: float) -> Acceleration:
    """Return an acceleration that can be evaluated a limited number of times."""
    evaluations = 0

    def limited(u: float, w: float) -> tuple[float, float]:
        nonlocal evaluations
        evaluations += 1
        du, dw = accelerate(u, w)
        if evaluations > _MOST_EVALUATIONS:
            raise _TooMuchWork(settled=math.hypot(du, dw) < 1e-3 * gravity)
        return du, dw

    return limited


def _stop_surfaces(start: State, stops: Stops[float], accelerate: Acceleration) -> list[Surface]:
    """Return the surfaces that stop a flight; the floor first, if there is one."""
    surfaces = []
    if (floor := stops.floor) is not None:
        surfaces.append(
            Surface(
                "floor",
                lambda y: y.z - floor,
                lambda y: y.w,
                -1,
                lambda y: y._replace(z=floor),
                leaves=start.z == floor,
            )
        )
    if (wall := stops.wall) is not None:
        surfaces.append(
            Surface("wall", lambda y: y.s - wall, lambda y: y.u, +1, lambda y: y._replace(s=wall))
        )
    if stops.vertical:
        surfaces.append(
            Surface(
                "vertical",
                lambda y: y.u,
                lambda y: accelerate(y.u, y.w)[0],
                -1,
                lambda y: y._replace(u=0.0),
            )
        )
    return surfaces


def _turning_points(accelerate: Acceleration) -> tuple[Surface, Surface]:
    """Return where the path has a bottom, and where it has a top."""

    def fall(y: State) -> float:
        return accelerate(y.u, y.w)[1]

    return Surface("bottom", lambda y: y.w, fall, +1), Surface("top", lambda y: y.w, fall, -1)


def _search_ends(
    bat: BatSection[float], stops: Stops[float], accelerate: Acceleration
) -> list[Surface]:
    """Return what ends the search for the bat besides a turn of the distance."""
    past = Surface("past", lambda y: bat.x + bat.cos * y.s + bat.reach, lambda y: bat.cos * y.u, -1)
    start_over_the_ground = PlaneState(0.0, math.inf, 0.0, 0.0)
    return [past, *_stop_surfaces(start_over_the_ground, replace(stops, wall=None), accelerate)]


def _first_step_near(way: Leg, bat: BatSection[float], within: float, gravity: float) -> int:
    """Return the first step of a pitch in which it may come within a distance of the bat's axis."""
    durations = np.diff(way.times).tolist()
    for step, duration in enumerate(durations):
        if not contact.stays_beyond(within, way.at(step)[1], duration, bat, gravity):
            return step
    return len(durations)


def _radial_turn(bat: BatSection[float], accelerate: Acceleration, direction: int) -> Surface:
    """Return where the distance to the bat's axis is least (+1) or greatest (-1)."""
    return Surface(
        "turn",
        lambda y: contact.radial_velocity(y, bat),
        lambda y: contact.radial_acceleration(y, bat, accelerate),
        direction,
    )


def _bat_surface(bat: BatSection[float]) -> Surface:
    """Return where ball and bat touch."""
    return Surface(
        "bat", lambda y: contact.depth(y, bat), lambda y: contact.radial_velocity(y, bat), -1
    )


def _rests_on(floor: float, start: State, accelerate: Acceleration) -> bool:
    """Tell whether a ball on the floor does not leave it."""
    rising = start.w > 0 or (start.w == 0 and accelerate(start.u, start.w)[1] > 0)
    return start.z <= floor and not rising


def _joined(legs: list[Leg]) -> Leg:
    if len(legs) == 1:
        return legs[0]
    return Leg(
        np.concatenate([leg.times for leg in legs]),
        np.concatenate([leg.states for leg in legs], axis=1),
    )
