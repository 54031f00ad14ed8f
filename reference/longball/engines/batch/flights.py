"""Many flights, sixteen at a time.

All sixteen lanes take a step together (`longball.engines.batch.expansion`). Events are located lane
by lane, on the step's polynomials (`longball.engines.batch.roots`). A lane whose flight has ended
takes the next one.

This code is the same for all laws. It computes ordinary flights. A flight that comes to rest,
overflows, takes too many steps, or has undecided events stops as `Stop.FALLBACK`; the scalar engine
then solves it, or raises the error.

A state is n positions followed by n velocities, and the path of the spin decay if there is one. An
event is an affine function of the state that falls through zero.

A pitch has a *sampling plane*, a distance `records.APPROACH` before the plate. A step ends there,
and the state is recorded, so that the later search for the bat can start from it. The event beyond
it, the plate, is not searched for before.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from longball.engines.batch.expansion import (
    CLEARANCE,
    FARTHEST,
    LENGTH,
    RANGES,
    TIME,
    TIME_COMPENSATION,
    Layout,
    step,
)
from longball.engines.batch.jit import call, fma, inner, shifted, unowned_views
from longball.engines.batch.roots import (
    NEVER,
    curvature,
    differentiate,
    downward,
    first_fall,
    first_zero,
    two_values,
    value,
)
from longball.engines.batch.tangents import TIMES, Tangents, tangents
from longball.engines.batch.writer import WIDTH, aligned
from longball.engines.compiled import compiled
from longball.model.trace import Program

Integer = int | np.int64
Records = NDArray[Any]

# --- records --------------------------------------------------------------------------------------


class Stop(IntEnum):
    """Status of a flight. Numbers from 0 to 99 are those of the event that ended it."""

    FLYING = -2
    SAMPLE = -1  # the last step ended there
    TIME_LIMIT = 100
    TOUCH = 101  # of the bat
    FALLBACK = 102  # left to the scalar engine


def flight_dtype(program: Program, events: int, inputs: int = 0) -> np.dtype[Any]:
    """Type of the inputs: start, strengths, bat, event functions.

    A function is an array of the coefficients of the variables, the constant, and the size that its
    error is relative to.
    """
    size = len(program.variables) + 2
    sources = len(program.parameters) + len(program.variables)
    return np.dtype(
        [
            *((name, np.float64) for name in _FLIGHT),
            # State and strengths; 0 for a force that does not act.
            *((name, np.float64) for name in (*program.variables, *program.parameters)),
            # The components of the distance from the bat's axis, and the sampling plane's function
            *((name, np.float64, (size,)) for name in ("across", "above", "sample")),
            ("events", np.float64, (events, size)),  # they end a flight where they fall
            # Derivatives of parameters and variables by each of some numbers of the scene
            ("changes", np.float64, (inputs, sources)),
        ]
    )


_FLIGHT = (
    "time", "time_limit",  # s
    "error",  # of a state at the end of a flight, relative to its size
    "reach",  # m, the distance from the bat's axis at which it is touched; 0 for no bat
    "margin_error",  # m
    "beyond",  # number of the event to skip until the sampling plane is passed; NaN: none
)  # fmt: skip
_TIME, _LIMIT, _ERROR, _REACH, _MARGIN_ERROR, _BEYOND, _STATE = range(7)
# Functions, in the order of the records.
_ACROSS, _ABOVE, _SAMPLE, _FIRST_EVENT = range(4)


def arrival_dtype(program: Program, inputs: int = 0) -> np.dtype[Any]:
    """Type of the results: status, margin, and times and states under the `PREFIXES`.

    ========  =====================================================================
    ``""``    the end
    mark_     the sampling plane; near a bat the first touch; without either the apex, if
              the ball ceases to rise between the ends of a step
    nearest_  near a bat, where the margin is taken
    ========  =====================================================================

    All numbers of it are NaN if there is no such point.
    """
    names = ("time", *program.variables)
    return np.dtype(
        [
            ("stop", np.int64),  # the number of the event, or a `Stop`
            ("steps", np.int64),  # how many were taken
            ("margin", np.float64),  # of the bat, m
            # time, s, and state
            *((f"{prefix}{name}", np.float64) for prefix in PREFIXES for name in names),
            # Derivatives of these states, each at a fixed time, by the inputs of the flight
            ("rates", np.float64, (len(PREFIXES), inputs, len(program.variables))),
        ]
    )


# Of the names of times and states of arrivals, in the order of `TIMES`.
PREFIXES = ("", "mark_", "nearest_")

# Columns of arrivals.
_STOP, _STEPS, _MARGIN, _END = range(4)


def new_flights(program: Program, shape: tuple[int, ...], events: int, inputs: int) -> Records:
    """Return flights that have no sampling plane, no bat, and events that never happen."""
    flights = np.zeros(shape, flight_dtype(program, events, inputs))
    constant = len(program.variables)
    flights["beyond"] = math.nan
    flights["sample"][..., constant] = flights["events"][..., constant] = math.inf
    return flights


def fly_all(
    program: Program,
    flights: Records,  # of `flight_dtype`, of any shape
    order: int,  # of the series
    truncation: float,  # size of the last terms of the velocity in a step, relative to the speed
) -> Records:
    """Fly every flight to its end; return records of `arrival_dtype`, of the same shape."""
    layout, rows = Layout(program), Tangents(program)
    functions = flights.dtype["events"].shape[0] + 1
    inputs = flights.dtype["changes"].shape[0]
    variables = len(program.variables)
    starts = np.ascontiguousarray(flights).reshape(-1)
    arrivals = np.empty(len(starts), arrival_dtype(program, inputs))
    arrivals["rates"] = math.nan
    x = layout.allocate(order)
    taken, work = x[layout.step].ravel(), np.zeros((variables + _SCRATCH, 2 * order + 4))
    p, slope, second, across, above, state = work[variables:]
    _fly_all(
        step(program).address,
        tangents(program).address if inputs else 0,
        truncation,
        _Workspace(
            half=variables // 2,
            variables=variables,
            parameters=len(program.parameters),
            functions=functions,
            inputs=inputs,
            order=order,
            degree=order + 1,
            rows=x.shape[1],
            width=work.shape[1],
            x=x.ravel(),
            strengths=x[layout.parameters].ravel(),
            step=taken,
            compensation=taken[(variables + RANGES + variables // 2) * WIDTH :],
            linear=aligned(functions * (variables + 2) * WIDTH),
            work=work.ravel(),
            p=p,
            slope=slope,
            second=second,
            across=across,
            above=above,
            state=state,
            times=rows.allocate(inputs).ravel(),
            first_tangent=rows.first,
            tangent_size=rows.size,
            active=np.full(WIDTH, _NONE),
            flying=np.full(WIDTH, _NONE),
        ),
        _Records(
            flight_size=starts.itemsize // 8,
            arrival_size=arrivals.itemsize // 8,
            total=len(starts),
            flights=starts.view(np.float64),
            arrivals=arrivals.view(np.float64),
            statuses=arrivals.view(np.int64),
        ),
    )
    return arrivals.reshape(flights.shape)


# --- the loop -------------------------------------------------------------------------------------

# A flight of 60 s with the paper's ball takes about 100 steps. A ball that almost rests at its apex
# takes three steps for each factor e by which its speed falls there.
_MOST_STEPS = 20_000  # a free choice

_NONE = -1  # number of the flight in a lane that has none


class _Workspace(NamedTuple):
    """Sizes and work arrays that all lanes share."""

    # half, variables, parameters, functions, inputs: numbers of positions, variables, parameters;
    # of the sampling plane and the events; and of the inputs that derivatives are taken by
    half: int
    variables: int
    parameters: int
    functions: int
    inputs: int
    # order, degree: of the velocity's polynomials, and of the position's
    order: int
    degree: int
    # rows, width: rows of a component of the state in `x`, and doubles of one in `work`
    rows: int
    width: int
    # x, strengths, step: the expansion of all lanes, its block of parameters, and that of the step
    x: Any
    strengths: Any
    step: Any
    # Kahan's compensation of each position, a part of `step`; after it those of the present step
    compensation: Any
    # Linear functions of the flights in the lanes: sampling plane and events, with absolute errors
    linear: Any
    # Polynomials of the state of one flight in its step, and of the bat's distance after them
    work: Any
    # p, slope, second: of an event, with its derivatives
    p: Any
    slope: Any
    second: Any
    across: Any
    above: Any
    state: Any  # of a flight at some time
    # times, s: for each lane the end of its step, its mark, and the closest approach to the bat;
    # NaN if there is none. Behind them is the memory of the tangents: see `Tangents`
    times: Any
    first_tangent: int  # row of the first one
    tangent_size: int  # rows of one
    # Numbers of the flights in the lanes now, and in the step
    active: Any
    flying: Any


_SCRATCH = 6  # rows of a workspace after those of the state, from `p` to `state`


class _Records(NamedTuple):
    """Records of all flights: their sizes in doubles, and how many there are."""

    flight_size: int
    arrival_size: int
    total: int
    # flights, arrivals, as doubles; statuses: the latter as integers
    flights: Any
    arrivals: Any
    statuses: Any


class _Slot(NamedTuple):
    """One flight: its records, and its lane."""

    flight: Any
    arrival: Any  # as doubles
    status: Any  # the same, as integers
    lane: int


@compiled
def _fly_all(
    step_code: int, tangents_code: int, truncation: float, s: _Workspace, records: _Records
) -> None:
    """Fill free lanes, step all lanes, locate events lane by lane, and advance, to the last end."""
    s, records = unowned_views(s), unowned_views(records)
    x, step, active, flying, variables = s.x, s.step, s.active, s.flying, s.variables
    block = s.rows * WIDTH
    time_row, length_row = (variables + TIME) * WIDTH, (variables + LENGTH) * WIDTH
    compensation_row, farthest_row = (
        (variables + TIME_COMPENSATION) * WIDTH,
        (variables + FARTHEST) * WIDTH,
    )
    clearance_row = (variables + CLEARANCE) * WIDTH
    climb = 2 * s.half - 1  # w
    next_one = 0
    while True:
        # free lanes take the next flights
        busy = 0
        for lane in range(WIDTH):
            if active[lane] == _NONE and next_one < records.total:
                _launch(s, _slot(records, next_one, lane))
                active[lane] = next_one
                next_one += 1
            flying[lane] = active[lane]
            busy += active[lane] != _NONE
        if busy == 0:
            return

        # one step of all lanes
        call(step_code, (x, s.linear, s.order, s.rows, s.functions, truncation))
        if s.inputs > 0:
            for k in range(variables):  # where the step begins; lanes move on before their tangents
                for lane in range(WIDTH):
                    s.times[(TIMES + k) * WIDTH + lane] = x[k * block + lane]
        for lane in range(WIDTH):
            for k in range(TIMES):
                s.times[k * WIDTH + lane] = math.nan
            i = active[lane]
            if i == _NONE:
                continue

            # bookkeeping of a lane
            slot = _slot(records, i, lane)
            time, length = step[time_row + lane], step[length_row + lane]
            slot.status[_STEPS] += 1
            if not length > 0.0 or slot.status[_STEPS] >= _MOST_STEPS:
                slot.status[_STOP], active[lane] = Stop.FALLBACK, _NONE
                continue
            # The mark is the apex only where neither a bat nor a sampling plane takes it.
            rises = x[climb * block + lane] > 0.0
            rises = rises and slot.flight[_REACH] == 0.0 and math.isnan(slot.flight[_BEYOND])
            for k in range(s.half):
                coordinate = abs(x[k * block + lane])
                if coordinate > step[farthest_row + lane]:
                    step[farthest_row + lane] = coordinate

            # The bound `CLEARANCE` proves most steps free of events; others are searched.
            if (
                step[clearance_row + lane] > 0.0
                and time + length < slot.flight[_LIMIT]
                and slot.flight[_REACH] == 0.0
            ):
                if rises and step[climb * WIDTH + lane] <= 0.0:
                    _load_step(s, lane)
                    _note_apex(s, slot, time, length)
                s.times[lane] = length
                for k in range(variables):
                    x[k * block + lane] = step[k * WIDTH + lane]
            else:
                _load_step(s, lane)
                length = _locate_first_event(s, slot, time, length)
                if slot.status[_STOP] != Stop.FALLBACK and rises and s.state[climb] <= 0.0:
                    _note_apex(s, slot, time, length)
                s.times[lane] = length
                if slot.status[_STOP] >= 0:
                    active[lane] = _NONE
                    continue
                for k in range(variables):
                    x[k * block + lane] = s.state[k]

            # What rounding takes from positions and time is made up for at the next step: Kahan's
            # compensated sum.
            for k in range(s.half):
                s.compensation[k * WIDTH + lane] = s.compensation[(s.half + k) * WIDTH + lane]
            passed = step[compensation_row + lane] + length
            step[time_row + lane] = time + passed
            step[compensation_row + lane] = passed - (time + passed - time)

        # derivatives over the step
        if s.inputs > 0:
            # Up to how many of the times any lane wants them; the last argument of all machine code
            # is a double.
            wanted = 1.0
            for k in range(1, TIMES):
                for lane in range(WIDTH):
                    if not math.isnan(s.times[k * WIDTH + lane]):
                        wanted = k + 1.0
            call(tangents_code, (x, s.times, s.order, s.rows, s.inputs, wanted))
            for lane in range(WIDTH):
                if flying[lane] != _NONE:
                    _keep_tangents(s, _slot(records, flying[lane], lane))


@inner
def _slot(records: _Records, number: Integer, lane: int) -> _Slot:
    end = number * records.arrival_size
    return _Slot(
        shifted(records.flights, number * records.flight_size),
        shifted(records.arrivals, end),
        shifted(records.statuses, end),
        lane,
    )


@inner
def _keep_tangents(s: _Workspace, slot: _Slot) -> None:
    """Keep the tangents of a flight in a step: the last ones at its end, and those at its marks."""
    lane = slot.lane
    target = shifted(slot.arrival, _END + TIMES * (1 + s.variables))
    for k in range(TIMES):
        for i in range(s.inputs):
            row = s.first_tangent + i * s.tangent_size + s.parameters + k * s.variables
            source = shifted(s.times, row * WIDTH + lane)
            for j in range(s.variables):
                if not math.isnan(s.times[k * WIDTH + lane]):
                    target[j] = source[j * WIDTH]
            target = shifted(target, s.variables)


@inner
def _launch(s: _Workspace, slot: _Slot) -> None:
    """Put a flight into its lane."""
    flight, arrival, status, lane = slot
    marked = shifted(arrival, _END + 1 + s.variables)
    status[_STOP], status[_STEPS] = Stop.FLYING, 0
    arrival[_MARGIN] = -math.inf
    arrival[_END] = marked[0] = flight[_TIME]
    s.step[(s.variables + TIME) * WIDTH + lane] = flight[_TIME]
    s.step[(s.variables + TIME_COMPENSATION) * WIDTH + lane] = 0.0
    s.step[(s.variables + FARTHEST) * WIDTH + lane] = 0.0
    for k in range(s.half):
        s.compensation[k * WIDTH + lane] = 0.0
    # state and strengths: a row of the lanes for each number
    source = shifted(flight, _STATE)
    for k in range(s.variables):
        s.x[k * s.rows * WIDTH + lane] = arrival[_END + 1 + k] = marked[1 + k] = source[k]
    source = shifted(source, s.variables)
    for k in range(s.parameters):
        s.strengths[k * WIDTH + lane] = source[k]
    # the functions of the sampling plane and the events, whose errors become absolute
    source = shifted(source, s.parameters + (_SAMPLE - _ACROSS) * (s.variables + 2))
    error = s.variables + 1
    target = shifted(s.linear, lane)
    for _ in range(s.functions):
        for k in range(error):
            target[k * WIDTH] = source[k]
        target[error * WIDTH] = source[error] * flight[_ERROR]
        source, target = shifted(source, s.variables + 2), shifted(target, (error + 1) * WIDTH)
    for i in range(s.inputs):
        target = shifted(s.times, (s.first_tangent + i * s.tangent_size) * WIDTH + lane)
        for k in range(s.parameters + s.variables):
            target[k * WIDTH] = source[k]
        source = shifted(source, s.parameters + s.variables)
    # Where the sampling plane is passed already, or there is none, its function never falls.
    if _event_value(s, np.int64(0), lane, shifted(flight, _STATE)) > 0.0:
        for k in range(s.variables + 1):
            marked[k] = math.nan
    else:
        s.linear[s.variables * WIDTH + lane] = math.inf


@inner
def _event_value(s: _Workspace, number: Integer, lane: int, state: Any) -> float:
    """Value of an event's function at a state."""
    function = shifted(s.linear, number * (s.variables + 2) * WIDTH + lane)
    total: float = function[s.variables * WIDTH]
    for k in range(s.variables):
        total = fma(function[k * WIDTH], state[k], total)
    return total


@inner
def _load_step(s: _Workspace, lane: int) -> None:
    """Copy the step's polynomials of a lane to the workspace."""
    for i in range(s.variables):
        source, target = shifted(s.x, i * s.rows * WIDTH + lane), shifted(s.work, i * s.width)
        for k in range(s.degree + 1):
            target[k] = source[k * WIDTH]
        if i >= s.half:
            target[s.degree] = 0.0


# --- the end of a step ----------------------------------------------------------------------------


@inner
def _locate_first_event(s: _Workspace, slot: _Slot, time: float, length: float) -> float:
    """Find the first event in the step; return the time to advance, s.

    On entry `s.work` holds the polynomials of the step, on return `s.state` the state at the
    returned time. Each event shortens the interval in which the next functions are searched.
    """
    flight, arrival, status, lane = slot
    stop: int = Stop.FLYING
    end = length
    if not time + length < flight[_LIMIT]:
        stop, end = Stop.TIME_LIMIT, flight[_LIMIT] - time
    near_bat, launched = flight[_REACH] > 0.0, status[_STEPS] <= 1
    if near_bat:
        searched = _search_length(s, flight, end)
        if searched < end:
            stop, end = Stop.FLYING, searched

    # the first fall: of the sampling plane's function, then of the events'
    ahead = flight[_BEYOND] if math.isnan(arrival[_END + 1 + s.variables]) else math.nan
    for number in range(s.functions):
        event = number - 1
        if event == ahead:
            continue
        function = shifted(s.linear, number * (s.variables + 2) * WIDTH + lane)
        error = function[(s.variables + 1) * WIDTH]
        if not _put_function(s, function, np.int64(WIDTH), s.p, lane, end / length):
            continue
        differentiate(s.p, s.degree, s.slope)
        if number > 0 and s.p[0] <= error and (not launched or s.p[0] <= 0.0):
            first = 1  # the order of the first coefficient that is not zero: its sign decides
            while first < s.degree and s.p[first] == 0.0:
                first += 1
            if not s.p[first] > 0.0:  # it does not rise
                if launched:  # on the surface, and not rising: the flight ends at once
                    stop, end = event, 0.0
                    break
            # Within the error of zero where a later step begins: a touch that doubles do not
            # decide.
            elif not launched and not near_bat:
                stop, end = Stop.FALLBACK, 0.0
                break
        fall = first_fall(s.p, s.slope, s.degree, end, error)
        if math.isnan(fall):
            stop, end = Stop.FALLBACK, 0.0
            break
        if fall != NEVER:
            end = fall
            stop = event if number > 0 else Stop.SAMPLE

    status[_STOP] = stop
    if stop == Stop.FALLBACK or (near_bat and _meets_bat(s, slot, time, end, stop >= 0)):
        return end
    _evaluate(s, lane, end)
    if stop == Stop.SAMPLE:
        s.times[WIDTH + lane] = end
        s.linear[s.variables * WIDTH + lane] = math.inf
        _note(s, shifted(arrival, _END + 1 + s.variables), time + end)
    elif stop >= 0:
        _note(s, shifted(arrival, _END), flight[_LIMIT] if stop == Stop.TIME_LIMIT else time + end)
        total = 0.0
        for k in range(s.variables):
            total += s.state[k]
        close_call = not near_bat and end > 0.0 and _is_close_call(s, slot, stop)
        if close_call or not math.isfinite(total):
            status[_STOP] = Stop.FALLBACK
    return end


@inner
def _evaluate(s: _Workspace, lane: int, t: float) -> None:
    """Evaluate the state at t, and the new compensations."""
    for i in range(s.half):
        place, rate, compensation = _position_at(s, lane, i, t)
        s.state[i], s.state[s.half + i] = place, rate
        s.compensation[(s.half + i) * WIDTH + lane] = compensation
    for i in range(2 * s.half, s.variables):
        s.state[i] = value(shifted(s.work, i * s.width), s.order, t)


@inner
def _position_at(s: _Workspace, lane: int, i: int, t: float) -> tuple[float, float, float]:
    """Return a position at t on the step, its rate, and the new compensation.

    The change is summed before the position is added, as in `longball.engines.batch.expansion`.
    """
    p, q = shifted(s.work, i * s.width), shifted(s.work, (s.half + i) * s.width)
    start = p[0]
    p[0] = 0.0
    change, rate = two_values(p, q, s.degree, t)
    p[0] = start
    change += s.compensation[i * WIDTH + lane]
    end = start + change
    taken = end - start
    return end, rate, (start - (end - taken)) + (change - taken)


@inner
def _note(s: _Workspace, row: Any, time: float) -> None:
    """Write a time and the state."""
    row[0] = time
    for k in range(s.variables):
        row[1 + k] = s.state[k]


@inner
def _note_apex(s: _Workspace, slot: _Slot, time: float, length: float) -> None:
    """Mark where a ball ceases to rise within a step, if it did not do so higher before."""
    top = shifted(slot.arrival, _END + 1 + s.variables)
    climb = shifted(s.work, (2 * s.half - 1) * s.width)
    differentiate(climb, s.order, s.slope)
    sag = downward(s.slope, s.order - 1, length)
    t = first_zero(climb, s.slope, s.order, 1.0, 0.0, 0.0, length, sag)
    t = t if t < length else length
    highest = s.half  # of the mark: its time, then the positions, z the last of them
    height = s.work[(s.half - 1) * s.width]
    rise = value(shifted(s.work, (s.half - 1) * s.width), s.degree, t) - height
    if top[0] == top[0] and not height + rise > top[highest]:
        return
    top[0] = time + t
    s.times[WIDTH + slot.lane] = t
    for i in range(s.half):
        top[1 + i], top[1 + s.half + i], _ = _position_at(s, slot.lane, i, t)
    for i in range(2 * s.half, s.variables):
        top[1 + i] = value(shifted(s.work, i * s.width), s.order, t)


@inner
def _put_function(
    s: _Workspace, function: Any, stride: Integer, p: Any, lane: Integer, part: float
) -> bool:
    """Form the polynomial of an event's function; return True.

    Skip it and return False if bounds prove it above its error on the fraction `part` of the step;
    ``part = inf`` disables the shortcut.
    """
    constant = function[s.variables * stride]
    least = constant - function[(s.variables + 1) * stride]
    for i in range(s.variables):
        factor = function[i * stride]
        if factor != 0.0:
            # The bound Σ |c_k| t^k is convex and 0 at t = 0: on a fraction f of the step it is at
            # most f times its value at the end.
            reach = math.inf
            if i < s.half:
                reach = s.step[(s.variables + RANGES + i) * WIDTH + lane]
            least += factor * s.work[i * s.width] - abs(factor) * (part * reach)
    if least > 0.0:
        return False
    for k in range(s.degree + 1):
        p[k] = 0.0
    p[0] = constant
    for i in range(s.variables):
        factor = function[i * stride]
        if factor != 0.0:
            row = shifted(s.work, i * s.width)
            for k in range(s.degree + 1):
                p[k] = fma(factor, row[k], p[k])
    return True


# Relative, of the largest coordinate: a flight that comes back to the ground from a height keeps
# that height's roundings. Twice those of `longball.engines.event`, as lanes sum in another order.
_ROUNDING = 8 * 2.0**-53
# Fraction of the time limit. An event that lies this close to the limit, and is fallen through so
# slowly that rounding could move it past, is undecided.
_SOON = 1e-9  # a free choice


@inner
def _rounding(s: _Workspace, number: Integer, lane: int) -> float:
    """Return the rounding error of a linear function's value, from those of the coordinates."""
    function = shifted(s.linear, number * (s.variables + 2) * WIDTH + lane)
    total = 0.0
    for k in range(s.half):
        total += abs(function[k * WIDTH])
    return float(_ROUNDING * total * s.step[(s.variables + FARTHEST) * WIDTH + lane])


@inner
def _is_close_call(s: _Workspace, slot: _Slot, stop: int) -> bool:
    """True if another event, or the time limit, may be as early as what stopped the flight."""
    flight, arrival, _, lane = slot
    for number in range(1, s.functions):
        error = s.linear[((number + 1) * (s.variables + 2) - 1) * WIDTH + lane]
        error = max(error, _rounding(s, number, lane))
        if number - 1 != stop and abs(_event_value(s, number, lane, s.state)) <= error:
            return True
    if stop == Stop.TIME_LIMIT:
        return False
    left, late = flight[_LIMIT] - arrival[_END], flight[_ERROR] * flight[_LIMIT]
    # the rate of the function, which is one of the positions, as those of most events are
    function = shifted(s.linear, (stop + 1) * (s.variables + 2) * WIDTH + lane)
    rate = 0.0
    for k in range(s.half):
        rate += function[k * WIDTH] * s.state[s.half + k]
    soon = left <= _SOON * flight[_LIMIT] and left * abs(rate) < _rounding(s, stop + 1, lane)
    return bool(left <= late or soon)


# --- the bat --------------------------------------------------------------------------------------

# Beyond this multiple of `reach` from the bat, a step is not searched but shortened: at 16 reaches
# d² - reach² has lost log2(16²) = 8 bits.
_FAR = 16.0  # a free choice


@inner
def _search_length(s: _Workspace, flight: Any, end: float) -> float:
    """Return the length, s, of the part of a step that has to be searched for the bat.

    Puts the components of the distance to the bat's axis on the workspace.
    """
    # No literals: numba would compile the function anew for each.
    one, none = np.int64(1), np.int64(0)
    across = shifted(flight, _STATE + s.variables + s.parameters)
    _put_function(s, across, one, s.across, none, math.inf)
    _put_function(s, shifted(across, s.variables + 2), one, s.above, none, math.inf)
    distance, reach = _distance(s, 0.0), flight[_REACH]
    if distance <= _FAR * reach:
        return end
    x, z = 0.0, 0.0
    for k in range(s.degree, 0, -1):
        x, z = fma(x, end, abs(s.across[k])), fma(z, end, abs(s.above[k]))
    farthest: float = end * math.sqrt(x * x + z * z)
    if distance - reach > farthest:
        return end
    # To half of _FAR, where the next step is searched; convex as in `_put_function`.
    return float(end * (distance - 0.5 * _FAR * reach) / farthest)


@inner
def _distance(s: _Workspace, t: float) -> float:
    """Return the distance of the ball's centre from the bat's axis, m."""
    across, above = two_values(s.across, s.above, s.degree, t)
    return math.sqrt(across * across + above * above)


@inner
def _meets_bat(s: _Workspace, slot: _Slot, time: float, end: float, last: bool) -> bool:
    r"""Search the step for the bat. True if that ends the flight: touched, or left to others.

    The distance falls to a minimum, rises to a maximum, and so on; a touching is settled at the
    first minimum that is certainly nearer than `reach`. Where the ball first touches is noted on
    the way there:

        \                       _
         \                     /
        --\-------------------/---- reach
           \                 /
            ^ noted         /
             \_____________/
                    ^ settled

    A margin within its error is left to the scalar engine.
    """
    flight, arrival, status, lane = slot
    reach, error = flight[_REACH], flight[_MARGIN_ERROR]
    noted = shifted(arrival, _END + 1 + s.variables)
    # (d² - reach²)/2 and its derivatives, with bounds on their curvature
    degree = _put_gap(s, reach, end)
    differentiate(s.p, degree, s.slope)
    differentiate(s.slope, degree - 1, s.second)
    sag_of_slope = curvature(s.second, degree - 2, end)
    sag_of_gap = downward(s.slope, degree - 1, end)
    if not math.isfinite(sag_of_slope + sag_of_gap):
        status[_STOP] = Stop.FALLBACK
        return True
    approaching = s.slope[0] < 0.0
    # the release, which must not lie in the bat, and may lie on it
    if status[_STEPS] <= 1:
        gap = _distance(s, 0.0) - reach
        arrival[_MARGIN] = -gap
        if gap <= error:
            if gap != 0.0:
                status[_STOP] = Stop.FALLBACK
                return True
            if approaching:
                _evaluate(s, lane, 0.0)
                _note(s, noted, time)
                s.times[WIDTH + lane] = 0.0
    # from turn to turn of the distance
    begin = 0.0
    while True:
        sign = -1.0 if approaching else 1.0
        turn = first_zero(s.slope, s.second, degree - 1, sign, 0.0, begin, end, sag_of_slope)
        until = min(turn, end)
        margin = reach - _distance(s, until)
        settled = last or turn != NEVER
        if math.isnan(turn) or (settled and abs(margin) <= error):
            status[_STOP] = Stop.FALLBACK
            return True
        if settled and margin > arrival[_MARGIN]:
            arrival[_MARGIN] = margin
            _evaluate(s, lane, until)
            _note(s, shifted(arrival, _END + 2 * (1 + s.variables)), time + until)
            s.times[2 * WIDTH + lane] = until
        if margin > 0.0 and math.isnan(noted[0]):
            touch = first_zero(s.p, s.slope, degree, 1.0, 0.0, begin, until, sag_of_gap)
            touch = touch if touch < until else until
            _evaluate(s, lane, touch)
            _note(s, noted, time + touch)
            s.times[WIDTH + lane] = touch
        if settled and margin > 0.0:
            status[_STOP], arrival[_MARGIN] = Stop.TOUCH, margin
            for k in range(s.variables + 1):
                arrival[_END + k] = noted[k]
            return True
        if turn == NEVER:
            return False
        begin = turn
        approaching = not approaching


@inner
def _put_gap(s: _Workspace, reach: float, end: float) -> int:
    """Put the polynomial ``(d² - reach²)/2`` on the workspace; return its degree.

    It is positive outside. The terms of d that stay below a hundredth of the rounding of `reach`
    are left out.
    """
    p, x, z = s.p, s.across, s.above
    negligible = 1e-18 * reach
    terms, power = 2, 1.0
    for k in range(s.degree + 1):
        if k > 1 and (abs(x[k]) + abs(z[k])) * power > negligible:
            terms = k + 1
        power *= end
    distance = math.sqrt(x[0] * x[0] + z[0] * z[0])
    p[0] = 0.5 * (distance - reach) * (distance + reach)
    for n in range(1, 2 * terms - 1):
        total = 0.0
        for j in range(max(0, n - terms + 1), (n + 1) // 2):
            total += x[j] * x[n - j] + z[j] * z[n - j]
        if n % 2 == 0:
            total += 0.5 * (x[n // 2] * x[n // 2] + z[n // 2] * z[n // 2])
        p[n] = total
    return 2 * terms - 2
