"""What the time step does to P(e) and to the distances, on the same samples."""

import math
from itertools import product
from pathlib import Path
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import ks_2samp

from analysis import Array
from analysis.convergence.pieces import each
from analysis.paper.balls import joined
from analysis.writing import LINES, STYLES, figure, render, write_table
from longball import home_run
from longball.engines.ivp import Ivp
from longball.engines.verlet import Verlet
from longball.home_run import RESTITUTIONS, Struck
from longball.model.readings import Inertia, Reading, SamplingReading, VerletForces
from longball.model.scene import AtBatScene

CHUNK = 500  # samples of one seed
CHUNKS, FULL_CHUNKS = 6, 100
SEED = 100  # of the first chunk
STEPS = (0.05, 0.03, 0.02, 0.01, 0.007, 0.005, 0.004, 0.003, 0.002, 0.001, 5e-4)  # s
E = 0.42  # where the paper's text gives P ≈ 0.17
PAPER_SAMPLES = 1_000
SMALL_BIAS = 1e-3


class Case(NamedTuple):
    """A reading under which the steps are tried."""

    name: str
    inertia: Inertia
    forces: VerletForces
    restitutions: tuple[float, ...]


IMPLICIT = "implicit forces"
CASES = (
    Case("default", "solid_cylinder", "old_carried", (min(RESTITUTIONS), E, max(RESTITUTIONS))),
    Case(IMPLICIT, "solid_cylinder", "implicit", (E,)),
    # The slip of the ledger that raises P(0.42) to the paper's height, where home runs are common.
    Case("inertia about the centre", "about_centre", "old_carried", (E,)),
)
DEFAULT = CASES[0]
# Balls by the name of a case, step (None: the reference) and e.
Found = dict[tuple[str, float | None, float], Struck]


def strike(case: Case, step: float | None, chunk: int) -> list[Struck]:
    """Return what becomes of a chunk of samples; by the reference if there is no step."""
    base = AtBatScene(id="base", reading=Reading(inertia=case.inertia))
    at_bats, seed = home_run.paper_at_bats(SamplingReading()), SEED + chunk
    engine = Ivp() if step is None else Verlet(step, case.forces)
    return home_run.monte_carlo(base, at_bats, case.restitutions, CHUNK, seed, engine=engine)


class Bias(NamedTuple):
    """How P differs from the reference's on the same samples, with an interval of 95 %."""

    gained: int
    lost: int
    trials: int
    value: float
    interval: tuple[float, float]


def bias(found: Found, case: str, step: float, e: float) -> Bias:
    """Return how a step changes P.

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
    largest = None
    for step in sorted(STEPS):
        if max(map(abs, bias(found, case, step, e).interval)) > allowed:
            break
        largest = step
    return largest


def run(report: Path, full: bool) -> str:
    """Strike the same samples with the reference and with every step."""
    chunks = range(FULL_CHUNKS if full else CHUNKS)
    keys: list[tuple[Case, float | None]] = list(product(CASES, STEPS))
    keys += [(case, None) for case in CASES if case.name != IMPLICIT]
    calls = [(case, step, chunk) for case, step in keys for chunk in chunks]
    answers = iter(each(report, "P(e) against the step", strike, calls))
    found: Found = {}
    for case, step in keys:
        parts = zip(*(next(answers) for _ in chunks), strict=True)
        for e, same in zip(case.restitutions, parts, strict=True):
            found[case.name, step, e] = joined(same)
    # The reference has no forces of a scheme.
    found[IMPLICIT, None, E] = found[DEFAULT.name, None, E]
    draw(report, found)
    crossing, rows = crossings(found), probability_rows(found)
    write_table(report, "convergence_crossings", crossing)
    write_table(report, "convergence_probability", rows)
    return render(
        report, "science", globals(), count=len(chunks) * CHUNK, found=found, crossing=crossing,
        exact=found[DEFAULT.name, None, E], coarse=found[DEFAULT.name, STEPS[0], E],
        failed=sum(int(found[DEFAULT.name, step, E].failed.sum()) for step in STEPS),
        kinds=crossing["what"].value_counts(), harmless=harmless(found),
        rows=rows[(rows["e"] == E) & (rows["step, s"] >= 0.002)].to_numpy().tolist(),
    )  # fmt: skip


def harmless(found: Found) -> dict[str, float] | None:
    """Return the largest step that loses no home run though pitches pass the bat unseen."""
    for step in sorted(STEPS, reverse=True):
        true, one = (found[DEFAULT.name, which, E].batted.mean() for which in (None, step))
        if bias(found, DEFAULT.name, step, E).lost == 0 and true - one > 0.005:
            return {"step": step, "unseen": true - one}
    return None


def noise(p: float) -> float:
    """Return the standard error of P from as many samples as the paper's."""
    return math.sqrt(p * (1 - p) / PAPER_SAMPLES)


def probability_rows(found: Found) -> pd.DataFrame:
    """Return bias against step, a line for each case, restitution and step."""
    rows = []
    for case in CASES:
        for e, step in product(case.restitutions, STEPS):
            one, p = bias(found, case.name, step, e), found[case.name, None, e].home_run.mean()
            row = {"reading": case.name, "e": e, "step, s": step}
            row |= {"P, reference": f"{p:.5f}", "bias": f"{one.value:+.5f}"}
            row |= {"95 %": "{:+.5f} to {:+.5f}".format(*one.interval)}
            rows.append(row | {"gained": one.gained, "lost": one.lost, "of": one.trials})
    return pd.DataFrame(rows)


def errors_of_both(one: Struck, true: Struck) -> Array:
    """Return the errors of D, m, of the balls that both bat."""
    return (one.distance - true.distance)[one.batted & true.batted]


def apart(one: Struck, other: Struck) -> float:
    """Return the largest difference of the distribution functions of D among batted balls."""
    return float(ks_2samp(one.distance[one.batted], other.distance[other.batted]).statistic)


def crossings(found: Found) -> pd.DataFrame:
    """Return every sample of the default reading that a step takes across the 150 m."""
    rows = []
    for e, step in product(DEFAULT.restitutions, STEPS):
        true, now = (found[DEFAULT.name, which, e] for which in (None, step))
        for index in np.flatnonzero(now.home_run != true.home_run):
            lost = "lost: shorter" if now.batted[index] else "lost: not batted"
            what = "gained" if now.home_run[index] else lost
            place = {"e": e, "step_s": step, "seed": SEED + index // CHUNK, "sample": index % CHUNK}
            place |= {"distance_reference_m": true.distance[index]}
            rows.append(place | {"distance_m": now.distance[index], "what": what})
    return pd.DataFrame(rows)


def draw(report: Path, found: Found) -> None:
    """Draw the bias of P, and the distribution of D."""
    with figure(report, "convergence_probability", columns=2, size=(9.0, 3.8)) as (left, right):
        for case, aside in zip(CASES, (0.95, 1.0, 1.05), strict=True):
            style = STYLES[f"verlet {case.forces}" if case.name == IMPLICIT else case.name]
            ends = [bias(found, case.name, step, E) for step in STEPS]
            p = float(found[case.name, None, E].home_run.mean())
            values = np.array([1 + one.value / p for one in ends])
            bars = np.abs(1 + np.array([one.interval for one in ends]).T / p - values)
            label = f"{case.name}, P = {p:.3f}"
            points = style | {"linestyle": "none", "markersize": 4, "capsize": 2}
            left.errorbar(np.array(STEPS) * aside, values, bars, **points, label=label)
            if case.name != IMPLICIT:
                limit = 1 - noise(p) / p
                left.axhline(limit, color=style["color"], linestyle=":")
                left.annotate(
                    f"noise of {PAPER_SAMPLES:,} samples, {case.name}", (0.02, limit), (0, -2),
                    xycoords=("axes fraction", "data"), textcoords="offset points",
                    va="top", fontsize="x-small",
                )  # fmt: skip
        left.set(xscale="log", xlabel="step Δt, s", ylabel="P(0.42) / P of the reference")
        left.set_ylim(0.0, 1.3)
        left.legend(loc="lower left", fontsize="small")
        edges, top = np.arange(0.0, 201.0, 10.0), 0.0
        for step, dash in zip((None, 0.01, 0.05), LINES, strict=False):
            one = found[DEFAULT.name, step, E]
            density = np.histogram(one.distance[one.batted], edges)[0] / (0.01 * one.batted.sum())
            label = "reference" if step is None else f"Δt = {step:g} s"
            label += f"; first bin: {density[0]:.0f}"
            right.stairs(density, edges, linestyle=dash, linewidth=1.4, label=label)
            top = max(top, 1.3 * density[1:].max())
        right.set(xlabel="D, m", ylabel="density among batted balls, 1/km", ylim=(0.0, top))
        right.legend()
