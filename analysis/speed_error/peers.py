"""Integrators that are not longball's, each used as its manual shows it.

A peer flies records (`longball.engines.batch.flights`) to their first stop and so serves the batch
engine's chain, for flights and for whole at-bats. What stops a flight is the peer's own event
handling, given the function that comes to mind first: the height above the ground, the way left to
the plate, the distance from the bat's axis less R + r_b. The bat is looked for from the release on.
"""

from __future__ import annotations

import math
import os
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import scipy.integrate
from longball.model.motion import Forces, acceleration
from numpy.typing import NDArray

from longball.engines.batch.flights import ARRIVAL, FLOOR, TIME_LIMIT, TOUCH, WALL, Records

Array = NDArray[np.float64]

# A flight asks for the first, the first two or all three.
STOPS = (FLOOR, WALL, TOUCH)
_TIME_AND_STATE = ("time", "s", "z", "u", "w")


class Flight(NamedTuple):
    """A flight as in `longball.engines.batch.flights.FLIGHT`, without what no peer looks at."""

    time: Any
    s: Any
    z: Any
    u: Any
    w: Any
    floor: Any
    wall: Any
    bat_x: Any
    bat_cos: Any
    bat_height: Any
    reach: Any

    @property
    def stops(self) -> int:
        """How many of `STOPS` are asked for."""
        return 3 if self.reach > 0.0 else 2 if self.wall < math.inf else 1


def law(field: Forces[float], sqrt: Callable[[Any], Any]) -> Callable[[Any, Any], tuple[Any, Any]]:
    """Return longball's law of motion, ``(u, w) -> (u', w')``, for any kind of numbers."""
    numbers: Any = SimpleNamespace(sqrt=sqrt, exact=lambda value: value)
    return acceleration(field, numbers)


def height(place: int, flight: Flight, s: Any, z: Any, sqrt: Callable[[Any], Any]) -> Any:
    """Return what falls through zero at one of `STOPS`, m, for any kind of numbers."""
    if place == 0:
        return z - flight.floor
    if place == 1:
        return flight.wall - s
    along, across = flight.bat_x + flight.bat_cos * s, z - flight.bat_height
    return sqrt(along * along + across * across) - flight.reach


@dataclass(frozen=True)
class Peer(ABC):
    """An integrator, under the forces of a scene and up to its time limit, s.

    It is a `longball.engines.batch.chain.Fleet`.
    """

    field: Forces[float]
    time_limit: float

    @property
    def flight_error(self) -> float:
        """0: a peer decides by its numbers as they are."""
        return 0.0

    @abstractmethod
    def land(self, flights: Array, stops: int) -> Array:
        """Fly each flight to its first stop.

        Parameters
        ----------
        flights : array, shape (n, 11)
            A `Flight` a row.
        stops
            How many of `STOPS` each asks for.

        Returns
        -------
        array, shape (n, 6)
            Which of `STOPS` was met (-1: none); when, s, and in what state.
        """

    def fly_all(self, starts: Records) -> Records:
        """Fly records to their stops."""
        ends = np.zeros(len(starts), ARRIVAL)
        if len(starts) == 0:
            return ends
        flights = np.column_stack([starts[name] for name in Flight._fields])
        first = Flight(*flights[0].tolist())
        place, *ended = self.land(flights, first.stops).T
        ends["stop"] = np.array([*STOPS, TIME_LIMIT])[place.astype(int)]
        for name, column in zip(_TIME_AND_STATE, ended, strict=True):
            ends[name] = column
            ends[f"mark_{name}"] = starts[name]  # from where the bat is looked for: the release
        ends["margin"] = math.nan
        return ends

    search_all = fly_all


@dataclass(frozen=True)
class Scipy(Peer):
    """`scipy.integrate.solve_ivp` with terminal events.

    Attributes
    ----------
    max_step
        s, of its steps while the bat is looked for.
    """

    method: str
    rtol: float
    max_step: float = math.inf

    def land(self, flights: Array, stops: int) -> Array:
        """Fly one after the other."""
        accelerate = law(self.field, math.sqrt)

        def motion(_: float, y: Array) -> tuple[float, ...]:
            _, _, u, w = y.tolist()
            return (u, w, *accelerate(u, w))

        return np.array([self._land_one(Flight(*row), stops, motion) for row in flights.tolist()])

    def _land_one(
        self, flight: Flight, stops: int, motion: Callable[[float, Array], Any]
    ) -> tuple[float, ...]:
        def stop(place: int) -> Callable[[float, Array], float]:
            def event(_: float, y: Array) -> float:
                s, z, _, _ = y.tolist()
                return float(height(place, flight, s, z, math.sqrt))

            event.terminal = True  # type: ignore[attr-defined]
            event.direction = -1  # type: ignore[attr-defined]
            return event

        found = scipy.integrate.solve_ivp(
            motion,
            (flight.time, self.time_limit),
            np.array(flight[1:5]),
            method=self.method,
            rtol=self.rtol,
            atol=self.rtol,
            max_step=self.max_step if flight.reach > 0.0 else math.inf,
            events=[stop(place) for place in range(stops)],
        )
        met = [place for place, times in enumerate(found.t_events) if len(times)]
        return (met[0] if met else -1, found.t[-1], *found.y[:, -1])


_ROOT_FOUND = 2  # CVODE's status of a solve that an event has ended


@dataclass(frozen=True)
class Cvode(Peer):
    """CVODE of SUNDIALS by scikit-sundae: its Adams method, its root finding."""

    rtol: float

    def land(self, flights: Array, stops: int) -> Array:
        """Fly one after the other, by one solver."""
        accelerate = law(self.field, math.sqrt)
        current = [Flight(*flights[0].tolist())]

        def motion(_: float, y: Array, rate: Array) -> None:
            _, _, u, w = y.tolist()
            rate[:] = (u, w, *accelerate(u, w))

        def stop(_: float, y: Array, heights: Array) -> None:
            s, z, _, _ = y.tolist()
            for place in range(stops):
                heights[place] = height(place, current[0], s, z, math.sqrt)

        stop.terminal = [True] * stops  # type: ignore[attr-defined]
        stop.direction = [-1] * stops  # type: ignore[attr-defined]
        solver = import_module("sksundae.cvode").CVODE(
            motion,
            method="Adams",
            rtol=self.rtol,
            atol=self.rtol,
            eventsfn=stop,
            num_events=stops,
            max_num_steps=100_000,
        )
        arrived = np.empty((len(flights), 6))
        for flight, end in zip(flights, arrived, strict=True):
            current[0] = Flight(*flight.tolist())
            found = solver.solve(np.array([flight[0], self.time_limit]), flight[1:5])
            # It keeps the events of all its solves, the latest last.
            met = found.status == _ROOT_FOUND
            end[0] = np.flatnonzero(found.i_events[-1])[0] if met else -1
            end[1], end[2:] = found.t[-1], found.y[-1]
        return arrived


@dataclass(frozen=True)
class Heyoka(Peer):
    """heyoka's adaptive Taylor integrator: scalar. Tolerance 0 is its default, the rounding."""

    tolerance: float = 0.0

    def land(self, flights: Array, stops: int) -> Array:
        """Fly one after the other, by one integrator."""
        integrator = _heyoka(self, stops)
        state, pars, limit = integrator.state, integrator.pars, self.time_limit
        given, places = slice(5, 5 + len(pars)), _places(stops)
        arrived = np.empty((len(flights), 6))
        for flight, end in zip(flights, arrived, strict=True):
            integrator.time = flight[0]
            integrator.reset_cooldowns()
            state[:] = flight[1:5]
            pars[:] = flight[given]
            end[0] = places.get(int(integrator.propagate_until(limit)[0]), -1)
            end[1], end[2:] = integrator.time, state
        return arrived


@dataclass(frozen=True)
class HeyokaBatch(Heyoka):
    """heyoka's integrator in batch mode: several flights at once, by vector instructions.

    A propagation ends when any of its flights meets a terminal event, the others at the end of
    their step. The next one gives each flight a time limit of its own: to those that have landed
    the time they have, so that their steps have no length.

    This is the quickest of the ways that were tried from Python; half of its time passes within
    heyoka. Events whose callbacks note the landing and let the flight go on took 1.2 times as long,
    a call for each step 1.8 times, the next flight in the place of each that has landed twice as
    long. Eight and 32 lanes take as long as sixteen within a tenth; four, up to 1.4 times as long.
    """

    lanes: int = 16

    def land(self, flights: Array, stops: int) -> Array:
        """Fly in groups of flights of like duration; the last one is filled up."""
        integrator = _heyoka_batch(self, stops)
        state, pars, times = integrator.state, integrator.pars, integrator.time
        given, places = slice(5, 5 + len(pars)), _places(stops)
        flying = int(import_module("heyoka").taylor_outcome.success)
        start = Flight(*flights.T)
        order = np.argsort(start.w if stops == 1 else (start.wall - start.s) / start.u)
        order = np.pad(order, (0, -len(order) % self.lanes), "edge")
        groups = flights[order].reshape(-1, self.lanes, len(Flight._fields))
        ends = np.empty((*groups.shape[:2], 6))
        for group, end in zip(groups, ends, strict=True):
            integrator.set_time(group[:, 0].tolist())
            integrator.reset_cooldowns()
            state[:], pars[:] = group[:, 1:5].T, group[:, given].T
            met = [flying] * self.lanes
            while flying in met:
                limits = [
                    self.time_limit if outcome == flying else time
                    for outcome, time in zip(met, times.tolist(), strict=True)
                ]
                integrator.propagate_until(limits)
                met = [
                    int(found[0]) if outcome == flying else outcome
                    for outcome, found in zip(met, integrator.propagate_res, strict=True)
                ]
            end[:, 0] = [places.get(outcome, -1) for outcome in met]
            end[:, 1], end[:, 2:] = times, state.T
        arrived = np.empty((len(flights), 6))
        arrived[order] = ends.reshape(-1, 6)
        return arrived


def _places(stops: int) -> dict[int, int]:
    """Return the places in `STOPS`, by the numbers of the outcomes that stand for them."""
    return {-1 - place: place for place in range(stops)}


@cache
def _heyoka(peer: Heyoka, stops: int) -> Any:
    """Return the compiled integrator of flights with so many stops."""
    hy: Any = import_module("heyoka")
    motion, heights = _expressions(peer.field, stops)
    events = [hy.t_event(falls, direction=hy.event_direction.negative) for falls in heights]
    return hy.taylor_adaptive(motion, np.ones(4), t_events=events, tol=peer.tolerance)


@cache
def _heyoka_batch(peer: HeyokaBatch, stops: int) -> Any:
    """Return the compiled integrator of many flights with so many stops."""
    hy: Any = import_module("heyoka")
    motion, heights = _expressions(peer.field, stops)
    events = [hy.t_event_batch(falls, direction=hy.event_direction.negative) for falls in heights]
    start = np.ones((4, peer.lanes))
    return hy.taylor_adaptive_batch(motion, start, t_events=events, tol=peer.tolerance)


def _expressions(field: Forces[float], stops: int) -> tuple[list[tuple[Any, Any]], list[Any]]:
    """Return the equations of motion, and what falls through zero at the stops, for heyoka."""
    hy: Any = import_module("heyoka")
    s, z, u, w = hy.make_vars("s", "z", "u", "w")
    u_rate, w_rate = law(field, hy.sqrt)(u, w)
    there = Flight(*[None] * 5, *(hy.par[i] for i in range(6)))
    heights = [height(place, there, s, z, hy.sqrt) for place in range(stops)]
    return [(s, u), (z, w), (u, u_rate), (w, w_rate)], heights


# What diffrax flies at once: its code is made for an array of one size.
LOCKSTEP = 256


@dataclass(frozen=True)
class Diffrax(Peer):
    """diffrax by one of its solvers: compiled, many flights in lock-step."""

    solver: str
    rtol: float

    def land(self, flights: Array, stops: int) -> Array:
        """Fly in groups; the last one is filled up with its last flight."""
        fly = _diffrax(self.solver, self.field, self.time_limit, stops)
        full = np.pad(flights, ((0, -len(flights) % LOCKSTEP), (0, 0)), "edge")
        groups = [
            np.column_stack(fly(full[i : i + LOCKSTEP], self.rtol))
            for i in range(0, len(full), LOCKSTEP)
        ]
        return np.concatenate(groups)[: len(flights)]


@cache
def _diffrax(solver: str, field: Forces[float], time_limit: float, stops: int) -> Any:
    """Return the compiled function of flights with so many stops."""
    os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false")  # one thread
    jax: Any = import_module("jax")
    jax.config.update("jax_enable_x64", True)
    diffrax: Any = import_module("diffrax")
    optimistix: Any = import_module("optimistix")
    jnp = jax.numpy
    accelerate = law(field, jnp.sqrt)

    def motion(_: Any, y: Any, __: Any) -> Any:
        return jnp.stack([y[2], y[3], *accelerate(y[2], y[3])])

    def one(row: Any, rtol: Any) -> Any:
        flight = Flight(*row)

        def stop(place: int) -> Any:
            return lambda t, y, args, **_: height(place, flight, y[0], y[1], jnp.sqrt)

        found = diffrax.diffeqsolve(
            diffrax.ODETerm(motion),
            getattr(diffrax, solver)(),
            flight.time,
            time_limit,
            None,
            row[1:5],
            stepsize_controller=diffrax.PIDController(rtol=rtol, atol=rtol),
            event=diffrax.Event(
                [stop(place) for place in range(stops)],
                optimistix.Newton(rtol, rtol),
                direction=False,
            ),
            max_steps=100_000,
            throw=False,
        )
        met = jnp.stack(found.event_mask)
        sure = found.result == diffrax.RESULTS.event_occurred
        return jnp.where(sure, met.argmax(), -1), found.ts[-1], found.ys[-1]

    return jax.jit(jax.vmap(one, in_axes=(0, None)))
