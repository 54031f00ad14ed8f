"""Integrators that are not longball's, each used as its manual shows it.

A peer flies records (`longball.engines.batch.flights`) to their first stop and so serves the chain
over columns, for flights and for whole at-bats. Its law of motion is longball's: the traced program
takes a peer's symbols as it takes numbers. What stops a flight is the peer's own event handling,
given the function that comes to mind first: the height above the ground, the way left to the plate,
the distance from the bat's axis less R + r_b. The bat is looked for from the release on.
"""

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
import scipy.integrate

from longball.engines.batch.flights import Records, Stop, arrival_dtype
from longball.model import trace
from longball.model.arrays import Array
from longball.model.trace import Node, Program

Function = Callable[..., tuple[Any, ...]]


class Problem(NamedTuple):
    """The law and the constants that flights share."""

    law: Program  # the law of motion
    strengths: tuple[float, ...]  # values of its parameters
    # What falls through zero where a flight ends, m: a program each, of the law's variables and of
    # the numbers that a flight has for itself.
    stops: tuple[Program, ...]
    bat: bool  # whether the last of them is the touching of the bat

    @property
    def state(self) -> slice:
        """The columns of a flight that hold its state; its own numbers are behind them."""
        return slice(2, 2 + len(self.law.variables))

    def bound(self, numbers: Any) -> tuple[Function, list[Function]]:
        """Return the functions of the flights, for the numbers that a module has functions of.

        Longball's law of motion; and those of a state and a flight's own numbers that fall through
        zero.
        """
        strengths = dict(zip(self.law.parameters, self.strengths, strict=True))
        functions = {name: getattr(numbers, name) for name in ("sqrt", "exp", "log")}
        stops = [stop.bind({}, functions) for stop in self.stops]
        return self.law.bind(strengths, functions), stops


def problem_of(starts: Records, law: Program) -> tuple[Problem, Array]:
    """Return the problem that flights share, and their numbers: an array of shape (n, m).

    It has a row a flight: time and time limit, s; the state; the numbers that it has for itself. A
    ValueError says that not all are under the same forces.
    """
    names = ("time", "time_limit", *law.variables)
    columns, variables = [starts[name] for name in names], [*map(trace.variable, law.variables)]

    def own(column: Array) -> Node:
        """Return a number as a node: 0 or 1, or a variable if it may be another one."""
        for value in (0.0, 1.0):
            if np.all(column == value):
                return trace.constant(value)
        columns.append(column)
        return trace.variable(f"own{len(columns)}")

    def linear(functions: Array) -> Node:
        """Return a linear function of the state from its coefficients and its constant."""
        factors = functions.T[: len(variables) + 1]
        ones = [*variables, trace.constant(1.0)]
        return trace.total(own(factor) * x for factor, x in zip(factors, ones, strict=True))

    stops = [linear(functions) for functions in starts["events"].transpose(1, 0, 2)]
    if bat := bool(np.any(starts["reach"])):
        across, above = linear(starts["across"]), linear(starts["above"])
        stops.append(trace.sqrt(across * across + above * above) - own(starts["reach"]))
    if any(np.ptp(starts[name]) != 0.0 for name in law.parameters):
        raise ValueError("a peer flies balls under the same forces only")
    strengths = tuple(float(starts[name][0]) for name in law.parameters)
    taken = (*law.variables, *(f"own{i + 1}" for i in range(len(names), len(columns))))
    programs = tuple(Program(taken, (), (stop,)) for stop in stops)
    return Problem(law, strengths, programs, bat), np.column_stack(columns)


# Takes what flights have in common, and the flights, as from `problem_of`, and flies each to its
# first stop. Returns an array of shape (n, 2 + variables): which of the stops was met (-1: none);
# when, s, and in what state.
Land = Callable[[Problem, Array], Array]


@dataclass(frozen=True)
class Peer:
    """An integrator, as a `longball.engines.batch.columns.BatchFlyer`."""

    description: str
    land: Land
    flight_error = 0.0  # a peer decides by its numbers as they are

    def fly_all(self, starts: Records, program: Program) -> Records:
        """Fly records to their stops."""
        ends = np.zeros(len(starts), arrival_dtype(program))
        if len(starts) == 0:
            return ends
        problem, flights = problem_of(starts, program)
        place, *ended = self.land(problem, flights).T
        numbers = [*range(len(problem.stops)), Stop.TIME_LIMIT]
        if problem.bat:
            numbers[-2] = Stop.TOUCH
        ends["stop"] = np.array(numbers)[place.astype(int)]
        for name, column in zip(("time", *program.variables), ended, strict=True):
            ends[name] = column
            ends[f"mark_{name}"] = starts[name]  # from where the bat is looked for: the release
        ends["margin"] = math.nan
        return ends

    search_all = fly_all


def by_scipy(method: str, rtol: float, max_step: float, problem: Problem, flights: Array) -> Array:
    """Fly by `scipy.integrate.solve_ivp` with terminal events.

    The largest step, s, is for the way on which the bat is looked for.
    """
    rates, heights = problem.bound(math)
    options: Any = {"method": method, "rtol": rtol, "atol": rtol}
    options["max_step"] = max_step if problem.bat else math.inf

    def motion(_: float, y: Array) -> tuple[float, ...]:
        return rates(*y.tolist())

    def stop(height: Callable[..., tuple[float]], own: list[float]) -> Any:
        def event(_: float, y: Array) -> float:
            return height(*y.tolist(), *own)[0]

        event.terminal = True  # type: ignore[attr-defined]
        event.direction = -1  # type: ignore[attr-defined]
        return event

    arrived = []
    for flight in flights:
        span, start, own = flight[:2], flight[problem.state], flight[problem.state.stop :]
        events = [stop(height, own.tolist()) for height in heights]
        found = scipy.integrate.solve_ivp(motion, span, start, events=events, **options)
        met = [place for place, times in enumerate(found.t_events) if len(times)]
        arrived.append((met[0] if met else -1, found.t[-1], *found.y[:, -1]))
    return np.array(arrived)


_ROOT_FOUND = 2  # CVODE's status of a solve that an event has ended


def by_cvode(rtol: float, problem: Problem, flights: Array) -> Array:
    """Fly by CVODE of SUNDIALS, by scikit-sundae: its Adams method, its root finding."""
    rates, falling = problem.bound(math)
    own: list[float] = []

    def motion(_: float, y: Array, rate: Array) -> None:
        rate[:] = rates(*y.tolist())

    def stop(_: float, y: Array, heights: Array) -> None:
        state = y.tolist()
        for place, height in enumerate(falling):
            heights[place] = height(*state, *own)[0]

    stop.terminal = [True] * len(falling)  # type: ignore[attr-defined]
    stop.direction = [-1] * len(falling)  # type: ignore[attr-defined]
    solver = import_module("sksundae.cvode").CVODE(
        motion, method="Adams", rtol=rtol, atol=rtol, max_num_steps=100_000,
        eventsfn=stop, num_events=len(falling),
    )  # fmt: skip
    arrived = []
    for flight in flights:
        own[:] = flight[problem.state.stop :].tolist()
        found = solver.solve(flight[:2], flight[problem.state])
        # It keeps the events of all its solves, the latest last.
        met = found.status == _ROOT_FOUND
        place = np.flatnonzero(found.i_events[-1])[0] if met else -1
        arrived.append((place, found.t[-1], *found.y[-1]))
    return np.array(arrived)


def by_heyoka(tolerance: float, problem: Problem, flights: Array) -> Array:
    """Fly by heyoka's adaptive Taylor integrator: scalar.

    Tolerance 0 is its default, the rounding.
    """
    integrator, places = _heyoka(problem, tolerance)
    state, pars = integrator.state, integrator.pars
    arrived = np.empty((len(flights), problem.state.stop))
    for flight, end in zip(flights, arrived, strict=True):
        integrator.time = flight[0]
        integrator.reset_cooldowns()
        state[:] = flight[problem.state]
        pars[:] = flight[problem.state.stop :]
        end[0] = places.get(int(integrator.propagate_until(flight[1])[0]), -1)
        end[1], end[2:] = integrator.time, state
    return arrived


LANES = 16  # of heyoka's batch mode


def by_heyoka_batch(tolerance: float, problem: Problem, flights: Array) -> Array:
    """Fly by heyoka's integrator in batch mode: several flights at once, by vector instructions.

    Those of a group are of like duration. A propagation ends when any of them meets a terminal
    event, the others at the end of their step. The next one gives each flight a time limit of its
    own: to those that have landed the time they have, so that their steps have no length.

    This is the quickest of the ways that were tried from Python; half of its time passes within
    heyoka. Events whose callbacks note the landing and let the flight go on took 1.2 times as long,
    a call for each step 1.8 times, the next flight in the place of each that has landed twice as
    long. Eight and 32 lanes take as long as sixteen within a tenth; four, up to 1.4 times as long.
    """
    integrator, places = _heyoka(problem, tolerance, LANES)
    state, pars, times = integrator.state, integrator.pars, integrator.time
    flying = int(import_module("heyoka").taylor_outcome.success)
    order = np.argsort(_duration(problem, flights))
    groups = _in_groups(flights[order], LANES)
    ends = np.empty((*groups.shape[:2], problem.state.stop))
    for group, end in zip(groups, ends, strict=True):
        integrator.set_time(group[:, 0].tolist())
        integrator.reset_cooldowns()
        state[:] = group[:, problem.state].T
        pars[:] = group[:, problem.state.stop :].T
        met, limits = [flying] * LANES, group[:, 1].tolist()
        while flying in met:
            still = np.array(met) == flying
            integrator.propagate_until(np.where(still, limits, times).tolist())
            ended = [int(found[0]) for found in integrator.propagate_res]
            met = np.where(still, ended, met).tolist()
        end[:, 0] = [places.get(outcome, -1) for outcome in met]
        end[:, 1], end[:, 2:] = times, state.T
    return ends.reshape(-1, problem.state.stop)[np.argsort(order)]


def _in_groups(flights: Array, size: int) -> Array:
    """Return flights in groups of a size; the last is filled up with the last flight."""
    full = np.pad(flights, ((0, -len(flights) % size), (0, 0)), "edge")
    return full.reshape(-1, size, flights.shape[1])


def _duration(problem: Problem, flights: Array) -> Array:
    """Return about how long flights will take, s: as long as if their acceleration stayed."""
    state, own = flights[:, problem.state].T, flights[:, problem.state.stop :].T
    law, heights = problem.bound(np)
    rates = np.broadcast_arrays(*law(*state))
    half = len(state) // 2
    shortest = np.full(len(flights), math.inf)
    for height in heights[:-1] if problem.bat else heights:

        def ahead(change: Any, height: Any = height) -> Any:
            return height(*(state[:half] + change), *state[half:], *own)[0]

        here = ahead(0.0)
        fall, bend = here - ahead(np.array(rates[:half])), ahead(np.array(rates[half:])) - here
        with np.errstate(invalid="ignore"):
            time = 2 * here / (fall + np.sqrt(fall * fall - 2 * bend * here))
        shortest = np.where(time > 0.0, np.minimum(time, shortest), shortest)
    return shortest


@cache
def _heyoka(problem: Problem, tolerance: float, lanes: int = 0) -> tuple[Any, dict[int, int]]:
    """Return the compiled integrator of flights, scalar or of several lanes.

    And the places of the stops, by the numbers of the outcomes that stand for them.
    """
    hy: Any = import_module("heyoka")
    names = problem.law.variables
    state = hy.make_vars(*names)
    own = [hy.par[i] for i in range(len(problem.stops[0].variables) - len(names))]
    rates, heights = problem.bound(hy)
    kind, shape = ("_batch", (len(names), lanes)) if lanes else ("", (len(names),))
    event, falling = getattr(hy, f"t_event{kind}"), hy.event_direction.negative
    events = [event(height(*state, *own)[0], direction=falling) for height in heights]
    motion = list(zip(state, rates(*state), strict=True))
    family = getattr(hy, f"taylor_adaptive{kind}")
    integrator = family(motion, np.ones(shape), t_events=events, tol=tolerance)
    return integrator, {-1 - place: place for place in range(len(events))}


# What diffrax flies at once: its code is made for an array of one size.
LOCKSTEP = 256


def by_diffrax(solver: str, rtol: float, problem: Problem, flights: Array) -> Array:
    """Fly by diffrax, by one of its solvers: compiled, many flights in lock-step."""
    fly, groups = _diffrax(solver, problem), _in_groups(flights, LOCKSTEP)
    flown = [np.column_stack(fly(group, rtol)) for group in groups]
    return np.concatenate(flown)[: len(flights)]


@cache
def _diffrax(solver: str, problem: Problem) -> Any:
    """Return the compiled function of flights."""
    os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false")  # one thread
    jax: Any = import_module("jax")
    jax.config.update("jax_enable_x64", True)
    diffrax: Any = import_module("diffrax")
    optimistix: Any = import_module("optimistix")
    jnp = jax.numpy
    rates, heights = problem.bound(jnp)

    def one(row: Any, rtol: Any) -> Any:
        own = row[problem.state.stop :]

        def stop(height: Any) -> Any:
            return lambda t, y, args, **_: height(*y, *own)[0]

        events = [stop(height) for height in heights]
        found = diffrax.diffeqsolve(
            diffrax.ODETerm(lambda t, y, args: jnp.stack(rates(*y))), getattr(diffrax, solver)(),
            row[0], row[1], None, row[problem.state], max_steps=100_000, throw=False,
            stepsize_controller=diffrax.PIDController(rtol=rtol, atol=rtol),
            event=diffrax.Event(events, optimistix.Newton(rtol, rtol), direction=False),
        )  # fmt: skip
        met = jnp.stack(found.event_mask)
        sure = found.result == diffrax.RESULTS.event_occurred
        return jnp.where(sure, met.argmax(), -1), found.ts[-1], found.ys[-1]

    return jax.jit(jax.vmap(one, in_axes=(0, None)))
