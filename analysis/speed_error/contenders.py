"""Contenders: every engine of longball over its settings, and the installed peers."""

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np

from analysis.speed_error import peers
from analysis.speed_error.work import Work
from longball.engines import create
from longball.engines.batch import Batch, solve_columns
from longball.engines.batch.columns import BatchFlyer
from longball.engines.batch.many import BLOCK
from longball.engines.chain import solve
from longball.engines.engine import Engine
from longball.engines.ivp import Ivp
from longball.engines.verlet import TREATMENTS, Verlet
from longball.model.result import Number
from longball.model.scene import AtBatScene

# The packages of peers, and the modules that they bring.
PEERS = {"heyoka": "heyoka", "diffrax": "diffrax", "scikit-sundae": "sksundae"}


class Answers(NamedTuple):
    """Outcomes (empty: no answer) and distances D, m (None: none)."""

    outcomes: Sequence[str]
    distances: Sequence[Number | None]


class Contender(NamedTuple):
    """Someone who can solve the work, at one setting."""

    family: str  # what the settings belong to: a line of a diagram
    setting: str  # tolerance or step
    solve: Callable[[Work], Answers]
    turn: int  # scenes that a turn of the timing has
    most: int | None = None  # scenes that its error is looked at over; None: all

    @property
    def name(self) -> str:
        """Family and setting."""
        return f"{self.family}, {self.setting}"


def in_columns(flyer: BatchFlyer, work: Work) -> Answers:
    """Solve the work over columns."""
    table = solve_columns(work.base, work.columns, flyer)
    nothing = np.full(len(work), np.nan)  # where no ball lands, there is no such column
    distances = table.get("landing.distance", nothing).tolist()
    return Answers(table["outcome"].tolist(), [x if x == x else None for x in distances])


def one_by_one(engine: Engine, work: Work) -> Answers:
    """Solve the work scene by scene."""
    results = [solve(scene, engine) for scene in work.scenes]
    distances = [result.landing and result.landing.distance for result in results]
    return Answers([result.outcome or "" for result in results], distances)


# Scenes a turn, so that few turns take more than a tenth of a second.
COMPILED, QUICK, SLOW = 4 * BLOCK, 512, 16


def batch(tolerance: float) -> Contender:
    """Return the batch engine, over columns."""
    return Contender("batch", f"{tolerance:g} m", partial(in_columns, Batch(tolerance)), COMPILED)


def ivp(method: str, rtol: float | None = None) -> Contender:
    """Return the reference engine, scene by scene."""
    turn, most = {"Taylor": (QUICK, None), "Radau": (2, 20)}.get(method, (SLOW, None))
    engine = Ivp(method, rtol, rtol)
    setting = f"{engine.tolerances['rtol']:g}" if engine.tolerances else "default"
    return Contender(f"ivp {method}", setting, partial(one_by_one, engine), turn, most)


PROVEN = partial(one_by_one, create("enclosure", digits=30))
ENCLOSURE = Contender("enclosure", "30 digits", PROVEN, 5, 50)


def longball_engines() -> Iterator[Contender]:
    """Yield longball's engines over their settings, from loose to tight."""
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 1e-14):
        yield batch(tolerance)
    every = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
    rtols = {"Taylor": (None,), "DOP853": (*every, None), "RK45": every, "LSODA": every}
    for method, some in (rtols | {"Radau": every[:3]}).items():
        yield from (ivp(method, rtol) for rtol in some)
    for treatment in TREATMENTS:
        for dt in (0.05, 0.01, 2e-3, 4e-4):
            verlet = partial(one_by_one, Verlet(dt, treatment))
            yield Contender(f"verlet {treatment}", f"{dt:g} s", verlet, QUICK)
    yield ENCLOSURE
    precise = partial(one_by_one, create("multiprecision", digits=30))
    yield Contender("multiprecision", "30 digits", precise, 1, 5)


SHORT_STEPS, SHORTEST_STEP = "scipy DOP853 1e-9 in short steps", 2e-3  # s
SHORTEST = f"{SHORT_STEPS}, {SHORTEST_STEP:g} s"


def plain_scipy(work: Work) -> Iterator[Contender]:
    """Yield solve_ivp as its manual shows it, with its own events."""
    for method in ("DOP853", "RK45", "LSODA"):
        for rtol in (1e-6, 1e-9, 1e-12):
            yield plain(method, rtol)
    if isinstance(work.base, AtBatScene):
        for max_step in (0.05, 0.01, SHORTEST_STEP):
            short = partial(peers.by_scipy, "DOP853", 1e-9, max_step)
            yield of_peer(SHORT_STEPS, f"{max_step:g} s", short)


def of_peer(family: str, setting: str, land: peers.Land, turn: int = SLOW) -> Contender:
    """Return a peer as a contender."""
    peer = peers.Peer(f"{family}, {setting}", land)
    return Contender(family, setting, partial(in_columns, peer), turn)


def plain(method: str, rtol: float) -> Contender:
    """Return solve_ivp by a method, with its own events."""
    return of_peer(f"scipy {method}", f"{rtol:g}", partial(peers.by_scipy, method, rtol, math.inf))


def heyoka(tolerance: float = 0.0) -> Iterator[Contender]:
    """Yield heyoka's scalar and its batch mode; tolerance 0 stands for its default."""
    setting = f"{tolerance:g}" if tolerance else "default"
    for mode, land in (("scalar", peers.by_heyoka), ("batch", peers.by_heyoka_batch)):
        yield of_peer(f"heyoka {mode}", setting, partial(land, tolerance), BLOCK)


def installed_peers() -> Iterator[Contender]:
    """Yield the peers of `PEERS` that are installed, from loose to tight."""
    absent = missing_peers()
    for rtol in (1e-6, 1e-9, 1e-12):
        if "scikit-sundae" not in absent:
            yield of_peer("CVODE Adams", f"{rtol:g}", partial(peers.by_cvode, rtol))
        for name in ("Tsit5", "Dopri8") if "diffrax" not in absent else ():
            land = partial(peers.by_diffrax, name, rtol)
            yield of_peer(f"diffrax {name}", f"{rtol:g}", land, peers.LOCKSTEP)
        if "heyoka" not in absent:
            yield from heyoka(rtol)
    if "heyoka" not in absent:
        yield from heyoka()


def missing_peers() -> list[str]:
    """Return the packages of peers that are not installed."""
    return [package for package, module in PEERS.items() if find_spec(module) is None]
