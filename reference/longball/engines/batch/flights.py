"""Many flights, sixteen at a time, each to its own end.

The series are expanded for sixteen flights at once (`longball.engines.batch.expansion`). Whatever a
flight decides, it decides alone: the first of its events within the step, found on the step's
polynomials (`longball.engines.batch.roots`); a lane whose flight has ended takes the next one.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longball.engines import series
from longball.engines.batch.expansion import (
    DRAG,
    FORCES,
    GRAVITY,
    LENGTH,
    LIFT,
    S_RANGE,
    SPEED,
    STEP,
    TIME,
    Z_RANGE,
    S,
    U,
    W,
    Z,
    choose_steps,
    expand,
    room,
    take_steps,
)
from longball.engines.batch.lanes import WIDTH, borrowed, compiled, fma, kept
from longball.engines.batch.roots import (
    NEVER,
    curvature,
    differentiate,
    downward,
    first_fall,
    first_zero,
    value,
)

Array = NDArray[np.float64]
Records = NDArray[Any]

# One record a flight. Starts: time (s), state (m, m, m/s, m/s). Forces as in
# `longball.model.motion.Forces`, 0 for none. Stops as in `longball.engines.engine.Stops`, with
# -inf and inf for no floor and no wall, and the relative error of a state at the end of a flight.
# `mark`: the distance s whose passing is noted. The bat as in
# `longball.engines.engine.BatSection`, with reach 0 for no bat, and the error (m) of its margin.
FLIGHT = np.dtype(
    [
        (name, np.float64)
        for name in (
            *("time", "s", "z", "u", "w"),
            *("drag", "lift", "gravity"),
            *("time_limit", "floor", "error", "wall", "vertical", "mark"),
            *("bat_x", "bat_cos", "bat_height", "reach", "margin_error"),
        )
    ]
)

# How a flight ends: at a stop; touching the bat; or without an answer, for a reason.
FLOOR, WALL, VERTICAL, TIME_LIMIT, TOUCH = range(5)
GRAZES_FLOOR, GRAZES_BAT, INSIDE_BAT, OUT_OF_RANGE, TOO_LONG = range(10, 15)
# While it flies: on its way, or for a moment at rest, at the apex of a flight straight up.
FLYING, RESTING = -1, -2

# One record a flight: how it ends, when (s) and in what state; when and in what state it passed the
# mark, or first touched the bat; the margin of the bat, m; the steps taken. `doubt`, m: what lies
# within its error, if that is the reason for no answer. `size`, m: the largest height there was,
# 1 m at least, to which the error of a height is relative.
ARRIVAL = np.dtype(
    [
        ("stop", np.int64),
        ("steps", np.int64),
        *(
            (name, np.float64)
            for name in (
                *("time", "s", "z", "u", "w"),
                *("mark_time", "mark_s", "mark_z", "mark_u", "mark_w"),
                *("margin", "doubt", "size"),
            )
        ),
    ]
)

# A flight of 60 s with the paper's ball takes some 100 steps; a ball that all but rests at its
# apex takes three steps for each factor e of its speed there.
MOST_STEPS = 20_000

# Beyond this many reaches from the bat a step is not searched but shortened: the square of the
# distance, of which reach² is to be told apart, is rounded to 16² half ulps of reach² at most.
_FAR = 16.0


# Rows of a desk, on which one flight is worked on: the polynomials of its step as in an expansion,
# and an event's polynomial with its derivatives.
P, SLOPE, BEND = range(5, 8)

_extend = compiled(series.extend)


def fly_all(flights: Records, order: int, truncation: float) -> Records:
    """Fly every flight to its end.

    Parameters
    ----------
    flights : records of FLIGHT, shape (n,)
    order
        Of the series.
    truncation
        Size of the last terms of the velocity in a step, relative to the speed.

    Returns
    -------
    records of ARRIVAL, shape (n,)
    """
    arrivals = np.empty(len(flights), ARRIVAL)
    desk = np.zeros((8, 2 * order + 4))
    _fly_all(flights, arrivals, room(order), desk, np.zeros(WIDTH, np.int64), order, truncation)
    return arrivals


@kept
def _fly_all(
    flights: Records,
    arrivals: Records,
    lanes: Array,
    table: Array,
    crew: NDArray[np.int64],
    order: int,
    truncation: float,
) -> None:
    x, desk, flying = borrowed(lanes), borrowed(table), borrowed(crew)
    flying[:] = _NONE
    next_one = 0
    while True:
        for lane in range(WIDTH):
            while True:
                if flying[lane] == _NONE:
                    flying[lane] = _take_off(flights, arrivals, next_one, x, lane, desk)
                    next_one = flying[lane] + 1
                i = flying[lane]
                if i >= len(flights) or x[U, 0, lane] != 0.0 or x[W, 0, lane] != 0.0:
                    break
                if not _leaves_rest(flights[i], arrivals[i], x, lane, desk, order, truncation):
                    flying[lane] = _NONE
        if flying.min() >= len(flights):
            return
        expand(x, order)
        choose_steps(x, order, truncation)
        take_steps(x, order)
        for lane in range(WIDTH):
            i = flying[lane]
            if i < len(flights) and not _goes_on(flights[i], arrivals[i], x, lane, desk, order):
                flying[lane] = _NONE


_NONE = -1  # flies in a lane


@compiled
def _take_off(
    flights: Records, arrivals: Records, index: int, x: Array, lane: int, desk: Array
) -> int:
    """Put the next flight that needs a series into a lane; return its index."""
    while index < len(flights):
        flight, arrival = flights[index], arrivals[index]
        _clear(flight, arrival)
        x[FORCES, DRAG, lane], x[FORCES, LIFT, lane] = flight.drag, flight.lift
        x[FORCES, GRAVITY, lane] = flight.gravity
        _put(x, lane, flight.s, flight.z, flight.u, flight.w)
        x[STEP, TIME, lane] = flight.time
        if not _is_over(flight, arrival) and not _flies_freely(flight, arrival, desk):
            break
        index += 1
    return index


@compiled
def _put(x: Array, lane: int, s: float, z: float, u: float, w: float) -> None:
    x[S, 0, lane], x[Z, 0, lane], x[U, 0, lane], x[W, 0, lane] = s, z, u, w


@compiled
def _clear(flight: Any, arrival: Any) -> None:
    arrival.steps = 0
    arrival.margin = -math.inf
    arrival.doubt = 0.0
    arrival.size = max(1.0, abs(flight.z))
    if flight.floor > -math.inf:
        arrival.size = max(arrival.size, abs(flight.floor))
    _note_arrival(arrival, FLYING, flight.time, flight.s, flight.z, flight.u, flight.w)
    _note_mark(arrival, flight.time, flight.s, flight.z, flight.u, flight.w)
    if flight.s < flight.mark:
        arrival.mark_time = math.nan


@compiled
def _note_arrival(
    arrival: Any, stop: int, time: float, s: float, z: float, u: float, w: float
) -> None:
    arrival.stop = stop
    arrival.time = time
    arrival.s, arrival.z, arrival.u, arrival.w = s, z, u, w


@compiled
def _note_mark(arrival: Any, time: float, s: float, z: float, u: float, w: float) -> None:
    arrival.mark_time = time
    arrival.mark_s, arrival.mark_z, arrival.mark_u, arrival.mark_w = s, z, u, w


@compiled
def _is_over(flight: Any, arrival: Any) -> bool:
    """Tell whether a flight ends at its start: on the floor, and not leaving it."""
    if flight.z > flight.floor or flight.w > 0.0:
        return False
    speed = math.sqrt(flight.u * flight.u + flight.w * flight.w)
    lifted = -speed * (flight.drag * flight.w - flight.lift * flight.u) - flight.gravity > 0.0
    if flight.w == 0.0 and lifted:
        return False
    arrival.stop = FLOOR
    return True


@compiled
def _flies_freely(flight: Any, arrival: Any, desk: Array) -> bool:
    """Fly without a series where no air acts, be it that the ball stays at rest."""
    stays = flight.u == 0.0 and flight.w == 0.0 and flight.gravity == 0.0
    if not stays and (flight.drag != 0.0 or flight.lift != 0.0):
        return False
    desk[S, 0], desk[S, 1], desk[S, 2] = flight.s, flight.u, 0.0
    desk[Z, 0], desk[Z, 1], desk[Z, 2] = flight.z, flight.w, -0.5 * flight.gravity
    desk[U, 0], desk[U, 1] = flight.u, 0.0
    desk[W, 0], desk[W, 1] = flight.w, -flight.gravity
    time = flight.time
    while arrival.stop == FLYING:
        arrival.steps += 1
        taken = _settle(flight, arrival, desk, 1, time, flight.time_limit - time)
        time += taken
        desk[S, 0] += taken * desk[S, 1]
        desk[Z, 0] += taken * (desk[Z, 1] + taken * desk[Z, 2])
        desk[W, 0] += taken * desk[W, 1]
        desk[Z, 1] = desk[W, 0]
    return True


@compiled
def _leaves_rest(
    flight: Any,
    arrival: Any,
    x: Array,
    lane: int,
    desk: Array,
    order: int,
    truncation: float,
) -> bool:
    """Take a flight from rest through its first step, in which V = g t + …; see `_goes_on`."""
    s, z, u, w = desk[S], desk[Z], desk[U], desk[W]
    s[0], z[0], u[0], w[0] = x[S, 0, lane], x[Z, 0, lane], 0.0, 0.0
    desk[SPEED, 0], desk[SPEED, 1] = 0.0, flight.gravity
    for n in range(order):
        _extend(n, flight.drag, flight.lift, flight.gravity, u, w, desk[SPEED], 1)
    for k in range(order + 1):
        s[k + 1], z[k + 1] = u[k] / (k + 1), w[k] / (k + 1)
    # Every second coefficient of u and w is zero, so that the last two terms are among four.
    step = flight.time_limit
    for k in range(order - 3, order + 1):
        last = max(abs(u[k]), abs(w[k]))
        if last > 0.0:
            step = min(step, (truncation * flight.gravity / last) ** (1.0 / (k - 1)))
    arrival.steps += 1
    taken = _settle(flight, arrival, desk, order, x[STEP, TIME, lane], step)
    return _moves_on(arrival, x, lane, desk, order, taken)


@compiled
def _goes_on(flight: Any, arrival: Any, x: Array, lane: int, desk: Array, order: int) -> bool:
    """Take a flight to the end of its step, or of itself; tell whether it goes on."""
    time, step = x[STEP, TIME, lane], x[STEP, LENGTH, lane]
    arrival.steps += 1
    nothing_near = (
        flight.reach == 0.0
        and flight.vertical == 0.0
        and x[U, 0, lane] != 0.0
        and time + step < flight.time_limit
        and x[Z, 0, lane] - x[STEP, Z_RANGE, lane] > flight.floor + flight.error * arrival.size
        and x[S, 0, lane] + x[STEP, S_RANGE, lane] < min(flight.mark, flight.wall)
    )
    if nothing_near:
        x[STEP, TIME, lane] = time + step
        _put(x, lane, x[STEP, S, lane], x[STEP, Z, lane], x[STEP, U, lane], x[STEP, W, lane])
        return _is_in_order(arrival, x, lane, step)
    for k in range(order + 1):
        desk[S, k], desk[Z, k] = x[S, k, lane], x[Z, k, lane]
        desk[U, k], desk[W, k] = x[U, k, lane], x[W, k, lane]
    desk[S, order + 1], desk[Z, order + 1] = x[S, order + 1, lane], x[Z, order + 1, lane]
    taken = _settle(flight, arrival, desk, order, time, step)
    return _moves_on(arrival, x, lane, desk, order, taken)


@compiled
def _moves_on(arrival: Any, x: Array, lane: int, desk: Array, order: int, taken: float) -> bool:
    """Put the state after the step on the desk into the lane, unless the flight has ended."""
    if arrival.stop >= 0:
        return False
    x[STEP, TIME, lane] += taken
    s, z, u, w = _state(desk, order, taken)
    if arrival.stop == RESTING:
        arrival.stop, u, w = FLYING, 0.0, 0.0
    _put(x, lane, s, z, u, w)
    return _is_in_order(arrival, x, lane, taken)


@compiled
def _is_in_order(arrival: Any, x: Array, lane: int, taken: float) -> bool:
    """Tell whether a flight has a state to go on from, and makes way."""
    arrival.size = max(arrival.size, abs(x[Z, 0, lane]))
    if not math.isfinite(x[S, 0, lane] + x[Z, 0, lane] + x[U, 0, lane] + x[W, 0, lane]):
        arrival.stop = OUT_OF_RANGE
    elif x[STEP, TIME, lane] + taken == x[STEP, TIME, lane] or arrival.steps >= MOST_STEPS:
        arrival.stop = TOO_LONG
    return bool(arrival.stop < 0)


@compiled
def _settle(flight: Any, arrival: Any, desk: Array, order: int, time: float, step: float) -> float:
    """Note what ends a flight within a step, if anything does; return how far the step goes.

    The polynomials of the step are on the desk, u and w of degree `order`, s and z of one more.
    """
    stop, end = FLYING, step
    if not time + step < flight.time_limit:
        stop, end = TIME_LIMIT, flight.time_limit - time
    p, slope, bend = desk[P], desk[SLOPE], desk[BEND]
    if flight.reach > 0.0:
        end_of_search = _search_length(flight, desk[S, 0], desk[Z, 0], desk[U, 0], desk[W, 0], end)
        if end_of_search < end:
            stop, end = FLYING, end_of_search
    if flight.drag != 0.0 and flight.lift == 0.0 and desk[U, 0] == 0.0 and desk[W, 0] > 0.0:
        for k in range(order + 1):
            p[k] = desk[W, k]
        differentiate(p, order, slope)
        top, _ = first_fall(p, slope, bend, order, end, 0.0)
        if top != NEVER:
            stop, end = RESTING, top
    if flight.vertical != 0.0:
        # From u = 0 it falls or rises with its first coefficient that is not zero: divided by the
        # power of t before that, u has the same roots but the one at the start.
        first = 0
        while first < order - 1 and desk[U, first] == 0.0:
            first += 1
        for k in range(first, order + 1):
            p[k - first] = desk[U, k]
        differentiate(p, order - first, slope)
        upright = 0.0
        if p[0] >= 0.0:
            upright, _ = first_fall(p, slope, bend, order - first, end, 0.0)
        if upright != NEVER:
            stop, end = VERTICAL, upright
    # The mark lies before the wall. A step ends there, for what lies beyond is to share the
    # rounding of that state.
    before_mark = flight.reach == 0.0 and math.isnan(arrival.mark_time)
    reached = NEVER
    if flight.wall < math.inf:
        _turn_over(flight.mark if before_mark else flight.wall, desk, order)
        reached, _ = first_fall(p, slope, bend, order + 1, end, 0.0)
        if reached != NEVER:
            stop, end = FLYING if before_mark else WALL, reached
    doubt = flight.error * arrival.size
    if desk[Z, 0] - _farthest(flight, desk[U, 0], desk[W, 0], end) <= flight.floor + doubt:
        for k in range(order + 2):
            p[k] = desk[Z, k]
        p[0] -= flight.floor
        landed, depth = first_fall(p, desk[W], bend, order + 1, end, doubt)
        if math.isnan(landed):
            arrival.stop, arrival.doubt = GRAZES_FLOOR, depth
            return end
        if landed != NEVER:
            stop, end = FLOOR, landed
    if before_mark and end == reached:
        s, z, u, w = _state(desk, order, end)
        _note_mark(arrival, time + end, s, z, u, w)
    if math.isnan(end):
        arrival.stop = TOO_LONG
        return 0.0
    if flight.reach > 0.0 and _meets_bat(flight, arrival, desk, order, time, end, stop >= 0):
        return end
    if stop >= 0:
        s, z, u, w = _state(desk, order, end)
        _note_arrival(
            arrival,
            stop,
            flight.time_limit if stop == TIME_LIMIT else time + end,
            flight.wall if stop == WALL else s,
            flight.floor if stop == FLOOR else z,
            0.0 if stop == VERTICAL else u,
            w,
        )
    elif stop == RESTING:
        arrival.stop = RESTING
    return end


@compiled
def _state(desk: Array, order: int, t: float) -> tuple[float, float, float, float]:
    """Return s, z, u, w at a time within the step on the desk."""
    s, z, u, w = desk[S, order + 1], desk[Z, order + 1], 0.0, 0.0
    for k in range(order, -1, -1):
        s, z = fma(s, t, desk[S, k]), fma(z, t, desk[Z, k])
        u, w = fma(u, t, desk[U, k]), fma(w, t, desk[W, k])
    return s, z, u, w


@compiled
def _turn_over(wall: float, desk: Array, order: int) -> None:
    """Put the polynomial ``wall - s`` on the desk."""
    for k in range(order + 1):
        desk[P, k] = -desk[S, k]
        desk[SLOPE, k] = -desk[U, k]
    desk[P, order + 1] = -desk[S, order + 1]
    desk[P, 0] += wall


@compiled
def _search_length(flight: Any, s: float, z: float, u: float, w: float, end: float) -> float:
    """Return how far, s, a step that may touch the bat is to be searched: not from afar."""
    distance = _distance(flight, s, z)
    if distance <= _FAR * flight.reach:
        return end
    if distance - flight.reach > _farthest(flight, u, w, end):
        return end
    far: float = distance - 0.5 * _FAR * flight.reach
    return end * far / _farthest(flight, u, w, end)


@compiled
def _distance(flight: Any, s: float, z: float) -> float:
    """Return the distance of the ball's centre from the bat's axis, m."""
    across, above = flight.bat_x + flight.bat_cos * s, z - flight.bat_height
    return math.sqrt(across * across + above * above)


@compiled
def _farthest(flight: Any, u: float, w: float, duration: float) -> float:
    """Return how far, m, a ball can get in a duration.

    Drag only brakes and lift only turns, so the speed grows by at most g a second.
    """
    speed = math.sqrt(u * u + w * w)
    return float((speed + flight.gravity * duration) * duration)


@compiled
def _meets_bat(
    flight: Any, arrival: Any, desk: Array, order: int, time: float, end: float, last: bool
) -> bool:
    """Follow the distance to the bat through a step; tell whether that settles how they meet.

    The distance falls to a minimum, rises to a maximum, and so on; a touching is settled at the
    first minimum that is certainly nearer than `reach` (see `longball.engines.contact`). Where
    the ball first touches is noted on the way there.
    """
    p, slope, bend = desk[P], desk[SLOPE], desk[BEND]
    reach = flight.reach
    degree = _depth(flight, desk, order, end)
    differentiate(p, degree, slope)
    differentiate(slope, degree - 1, bend)
    bend_of_slope = curvature(bend, degree - 2, end)
    approaching = slope[0] < 0.0
    if arrival.steps <= 1:
        gap = _distance(flight, desk[S, 0], desk[Z, 0]) - reach
        if gap < -flight.margin_error:
            arrival.stop, arrival.doubt = INSIDE_BAT, gap
            return True
        if gap <= flight.margin_error and approaching:
            _note_mark(arrival, time, desk[S, 0], desk[Z, 0], desk[U, 0], desk[W, 0])
    begin = 0.0
    while True:
        sign = -1.0 if approaching else 1.0
        turn = first_zero(slope, bend, degree - 1, sign, 0.0, begin, end, bend_of_slope)
        if math.isnan(turn):
            arrival.stop = TOO_LONG
            return True
        until = min(turn, end)
        margin = reach - _distance(
            flight, value(desk[S], order + 1, until), value(desk[Z], order + 1, until)
        )
        settled = last or turn != NEVER
        if settled:
            arrival.margin = max(arrival.margin, margin)
        if settled and abs(margin) <= flight.margin_error:
            arrival.stop, arrival.margin, arrival.doubt = GRAZES_BAT, margin, margin
            return True
        if margin > 0.0 and math.isnan(arrival.mark_time):
            bend_of_depth = downward(slope, degree - 1, end)
            touch = first_zero(p, slope, degree, 1.0, 0.0, begin, until, bend_of_depth)
            touch = touch if touch < until else until
            s, z, u, w = _state(desk, order, touch)
            _note_mark(arrival, time + touch, s, z, u, w)
        if settled and margin > 0.0:
            arrival.margin = margin
            _note_arrival(
                arrival,
                TOUCH,
                arrival.mark_time,
                arrival.mark_s,
                arrival.mark_z,
                arrival.mark_u,
                arrival.mark_w,
            )
            return True
        if turn == NEVER:
            return False
        begin = turn
        approaching = not approaching


@compiled
def _depth(flight: Any, desk: Array, order: int, end: float) -> int:
    """Put the polynomial ``(d² - reach²)/2`` on the desk; return its degree.

    The terms of s and z that stay below a hundredth of the rounding of `reach` are left out.
    """
    p, x, z = desk[P], desk[SLOPE], desk[BEND]
    negligible = 1e-18 * flight.reach
    terms, power = 2, 1.0
    for k in range(order + 2):
        x[k], z[k] = flight.bat_cos * desk[S, k], desk[Z, k]
        if k > 1 and (abs(x[k]) + abs(z[k])) * power > negligible:
            terms = k + 1
        power *= end
    x[0] += flight.bat_x
    z[0] -= flight.bat_height
    distance = math.sqrt(x[0] * x[0] + z[0] * z[0])
    p[0] = 0.5 * (distance - flight.reach) * (distance + flight.reach)
    for n in range(1, 2 * terms - 1):
        total = 0.0
        for j in range(max(0, n - terms + 1), (n + 1) // 2):
            total += x[j] * x[n - j] + z[j] * z[n - j]
        if n % 2 == 0:
            total += 0.5 * (x[n // 2] * x[n // 2] + z[n // 2] * z[n // 2])
        p[n] = total
    return 2 * terms - 2
