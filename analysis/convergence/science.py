"""Effect of the time step on P(e) and on the distances, with the same samples."""

import math
from itertools import product
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import ks_2samp

from analysis.convergence.pieces import each
from analysis.paper import printed
from analysis.paper.printed import AT_BATS, P_TEXT
from analysis.writing import LINES, STYLES, Report
from longball import home_run
from longball.engines.ivp import Ivp
from longball.engines.verlet import Verlet
from longball.home_run import RESTITUTIONS, Struck
from longball.model.readings import Inertia, Reading, VerletForces
from longball.model.scene import AtBatScene

CHUNK = 500  # samples of one seed
CHUNKS, FULL_CHUNKS = 6, 100
SEED = 100  # of the first chunk
STEPS = (0.05, 0.03, 0.02, 0.01, 0.007, 0.005, 0.004, 0.003, 0.002, 0.001, 5e-4)  # s
E = P_TEXT[0]
SMALL_BIAS = 1e-3


class Case(NamedTuple):
    """A reading under which the steps are tried."""

    name: str
    inertia: Inertia = "solid_cylinder"
    forces: VerletForces = "old_carried"
    restitutions: tuple[float, ...] = (E,)


DEFAULT = Case("default", restitutions=(min(RESTITUTIONS), E, max(RESTITUTIONS)))
IMPLICIT = "implicit forces"
# Last the slip of the ledger that raises P(0.42) to the paper's height, where home runs are common.
CASES = DEFAULT, Case(IMPLICIT, forces="implicit"), Case("inertia about the centre", "about_centre")
# Balls by the name of a case, step (None: the reference) and e.
Found = dict[tuple[str, float | None, float], Struck]


def strike(case: Case, step: float | None, chunk: int) -> list[Struck]:
    """Solve a chunk of samples; by the reference if there is no step."""
    base = AtBatScene(id="base", reading=Reading(inertia=case.inertia))
    engine = Ivp() if step is None else Verlet(step, case.forces)
    drawn = AT_BATS, case.restitutions, CHUNK, SEED + chunk
    return home_run.monte_carlo(base, *drawn, engine=engine)


class Bias(NamedTuple):
    """Difference of P from the reference's on the same samples, with a 95 % interval."""

    gained: int
    lost: int
    trials: int
    value: float
    interval: tuple[float, float]


def bias(found: Found, case: str, step: float, e: float) -> Bias:
    """Return the change of P by a step.

    The interval is that for matched pairs, with half a sample added to each kind of pair: A.
    Agresti and Y. Min, Stat. Med. 24 (2005) 729. It keeps its level where few pairs differ.
    """
    now, before = found[case, step, e].home_run, found[case, None, e].home_run
    gained, lost, trials = int((now & ~before).sum()), int((before & ~now).sum()), len(now)
    middle = (gained - lost) / (trials + 2)
    variance = ((gained + lost + 1) / (trials + 2) - middle**2) / (trials + 2)
    half = NormalDist().inv_cdf(0.975) * math.sqrt(variance)
    return Bias(gained, lost, trials, (gained - lost) / trials, (middle - half, middle + half))


def largest_step(found: Found, case: str, e: float, allowed: float) -> float | None:
    """Return the largest step at which, and below which, the bias is surely within a limit."""
    within = [max(map(abs, bias(found, case, step, e).interval)) <= allowed for step in STEPS]
    return next((step for i, step in enumerate(STEPS) if all(within[i:])), None)


def run(report: Report, full: bool) -> str:
    """Strike the same samples with the reference and with every step."""
    chunks = range(FULL_CHUNKS if full else CHUNKS)
    keys: list[tuple[Case, float | None]] = list(product(CASES, STEPS))
    keys += [(case, None) for case in CASES if case.name != IMPLICIT]
    calls = [(*key, chunk) for key in keys for chunk in chunks]
    answers = iter(each(report, "P(e) against the step", strike, calls))
    found: Found = {}
    for case, step in keys:
        parts = zip(*(next(answers) for _ in chunks), strict=True)
        for e, same in zip(case.restitutions, parts, strict=True):
            found[case.name, step, e] = Struck.joined(same)
    # The reference has no forces of a scheme.
    found[IMPLICIT, None, E] = found[DEFAULT.name, None, E]
    draw(report, found)
    crossing = crossings(found)
    report.write_table("convergence_crossings", crossing)
    return report.render(
        "science", vars(printed) | globals(), count=len(chunks) * CHUNK, found=found,
        crossing=crossing,
        exact=found[DEFAULT.name, None, E], coarse=found[DEFAULT.name, STEPS[0], E],
        failed=sum(int(found[DEFAULT.name, step, E].failed.sum()) for step in STEPS),
        ks_2samp=ks_2samp,
    )  # fmt: skip


def crossings(found: Found) -> pd.DataFrame:
    """Return every sample of the default reading that a step takes across the 150 m."""
    tables = []
    for e, step in product(DEFAULT.restitutions, STEPS):
        true, now = (found[DEFAULT.name, which, e] for which in (None, step))
        i = np.flatnonzero(now.home_run != true.home_run)
        lost = np.where(now.batted, "lost: shorter", "lost: not batted")
        what = np.where(now.home_run, "gained", lost)[i]
        place = {"e": e, "step_s": step, "seed": SEED + i // CHUNK, "sample": i % CHUNK}
        reach = {"distance_reference_m": true.distance[i], "distance_m": now.distance[i]}
        tables.append(pd.DataFrame({**place, **reach, "what": what}))
    return pd.concat(tables, ignore_index=True)


def draw(report: Report, found: Found) -> None:
    """Draw the bias of P, and the distribution of D."""
    with report.figure("convergence_probability", size=(6.4, 4.0)) as (axes,):
        for case, aside in zip(CASES, (0.95, 1.0, 1.05), strict=True):
            style = STYLES[f"verlet {case.forces}" if case.name == IMPLICIT else case.name]
            ends = [bias(found, case.name, step, E) for step in STEPS]
            p = float(found[case.name, None, E].home_run.mean())
            values = np.array([1 + one.value / p for one in ends])
            bars = np.abs(1 + np.array([one.interval for one in ends]).T / p - values)
            points = style | {"linestyle": "none", "markersize": 5, "capsize": 2}
            points |= {"label": f"{case.name}, P = {p:.3f}"}
            axes.errorbar(np.array(STEPS) * aside, values, bars, **points)
        axes.axhline(1.0, color="black", linewidth=0.8)
        axes.set(xscale="log", xlabel="step Δt, s", ylabel="P(0.42) by the scheme / P")
        axes.set_ylim(0.0, 1.3)
        axes.legend(loc="lower left")
    with report.figure("convergence_distances", size=(6.4, 3.6)) as (axes,):
        edges, top = np.arange(0.0, 201.0, 10.0), 0.0
        cases = (("without steps", None), ("Δt = 0.01 s", 0.01), ("Δt = 0.05 s", 0.05))
        for (name, step), dash in zip(cases, LINES, strict=False):
            one = found[DEFAULT.name, step, E]
            density = np.histogram(one.distance[one.batted], edges)[0] / (10 * one.batted.sum())
            label = f"{name}; first bin: {density[0]:.3f}"
            axes.stairs(density, edges, linestyle=dash, linewidth=1.4, label=label)
            top = max(top, 1.3 * density[1:].max())
        axes.set(xlabel="distance D of batted balls, m", ylabel="probability density, 1/m")
        axes.set_ylim(0.0, top)
        axes.legend()
