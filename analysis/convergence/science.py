"""What the time step does to P(e) and to the distances, on the same samples."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from pathlib import Path
from statistics import NormalDist

import numpy as np
import pandas as pd
from scipy.stats import ks_2samp

from analysis import Array
from analysis.convergence.pieces import each
from analysis.writing import LINES, STYLES, figure, render, write_table
from longball.engines.ivp import Ivp
from longball.engines.verlet import Verlet
from longball.home_run import (
    HOME_RUN_DISTANCE,
    PAPER_CURVES,
    RESTITUTIONS,
    Struck,
    monte_carlo,
    paper_at_bats,
)
from longball.model.readings import Inertia, Reading, SamplingReading, VerletForces
from longball.model.scene import AtBatScene

CHUNK = 500  # samples of one seed
CHUNKS, FULL_CHUNKS = 6, 100
SEED = 100  # of the first chunk
STEPS = (0.05, 0.03, 0.02, 0.01, 0.007, 0.005, 0.004, 0.003, 0.002, 0.001, 5e-4)  # s
E = 0.42  # where the paper's text gives P ≈ 0.17
PAPER_SAMPLES = 1_000
SMALL_BIAS = 1e-3


@dataclass(frozen=True)
class Case:
    """A reading under which the steps are tried."""

    name: str
    inertia: Inertia
    forces: VerletForces
    restitutions: tuple[float, ...]

    @property
    def base(self) -> AtBatScene:
        """What is not random about the at-bats."""
        return AtBatScene(id="base", reading=Reading(inertia=self.inertia))


IMPLICIT = "implicit forces"
CASES = (
    Case("default", "solid_cylinder", "old_carried", (min(RESTITUTIONS), E, max(RESTITUTIONS))),
    Case(IMPLICIT, "solid_cylinder", "implicit", (E,)),
    # The slip of the ledger that raises P(0.42) to the paper's height, where home runs are common.
    Case("inertia about the centre", "about_centre", "old_carried", (E,)),
)


def strike(case: Case, step: float | None, chunk: int) -> list[Struck]:
    """Return what becomes of a chunk of samples; by the reference if there is no step."""
    return monte_carlo(
        case.base,
        paper_at_bats(SamplingReading()),
        case.restitutions,
        CHUNK,
        SEED + chunk,
        engine=Ivp() if step is None else Verlet(step, case.forces),
    )


@dataclass(frozen=True)
class Bias:
    """How P differs from the reference's on the same samples, with an interval of 95 %."""

    gained: int
    lost: int
    trials: int

    @property
    def value(self) -> float:
        """Return the difference of P."""
        return (self.gained - self.lost) / self.trials

    @property
    def interval(self) -> tuple[float, float]:
        """Return the interval for matched pairs, with half a sample added to each kind of pair.

        A. Agresti and Y. Min, Stat. Med. 24 (2005) 729: it keeps its level where few pairs differ.
        """
        count = self.trials + 2
        difference = (self.gained - self.lost) / count
        variance = ((self.gained + self.lost + 1) / count - difference**2) / count
        half = NormalDist().inv_cdf(0.975) * math.sqrt(variance)
        return difference - half, difference + half

    @property
    def worst(self) -> float:
        """Return the largest bias, of either sign, in the interval."""
        return max(map(abs, self.interval))


def bias(stepped: Struck, true: Struck) -> Bias:
    """Compare two engines on the same samples."""
    now, before = stepped.distance >= HOME_RUN_DISTANCE, true.distance >= HOME_RUN_DISTANCE
    return Bias(int((now & ~before).sum()), int((before & ~now).sum()), len(true.x))


@dataclass(frozen=True)
class Found:
    """What becomes of the samples, by the name of a case, step (None: the reference) and e."""

    struck: dict[tuple[str, float | None, float], Struck]

    def bias(self, case: str, step: float, e: float) -> Bias:
        """Return how a step changes P."""
        return bias(self.struck[case, step, e], self.struck[case, None, e])

    def p(self, case: str, e: float) -> float:
        """Return P by the reference."""
        return float(np.mean(self.struck[case, None, e].distance >= HOME_RUN_DISTANCE))

    def largest_step(self, case: str, e: float, allowed: float) -> float | None:
        """Return the largest step at which, and below which, the bias is surely within a limit."""
        largest = None
        for step in sorted(STEPS):
            if self.bias(case, step, e).worst > allowed:
                break
            largest = step
        return largest


def run(report: Path, full: bool) -> str:
    """Strike the same samples with the reference and with every step."""
    chunks = range(FULL_CHUNKS if full else CHUNKS)
    keys: list[tuple[Case, float | None]] = [(case, step) for case in CASES for step in STEPS]
    keys += [(case, None) for case in CASES if case.name != IMPLICIT]
    calls = [(case, step, chunk) for case, step in keys for chunk in chunks]
    answers = iter(each(report, "P(e) against the step", strike, calls))
    struck = {
        (case.name, step, e): one
        for case, step in keys
        for e, one in zip(case.restitutions, together([next(answers) for _ in chunks]), strict=True)
    }
    # The reference has no forces of a scheme.
    struck[IMPLICIT, None, E] = struck[CASES[0].name, None, E]
    found = Found(struck)
    draw(report, found)
    crossing = crossings(found)
    write_table(report, "convergence_crossings", crossing)
    rows = probability_rows(found)
    write_table(report, "convergence_probability", rows)
    default, printed = CASES[0].name, STEPS[0]
    true, coarse = struck[default, None, E], struck[default, printed, E]
    return render(
        report, "science", globals(), count=len(chunks) * CHUNK, found=found, coarse=coarse,
        exact=true, p=found.p(default, E), bias=found.bias(default, printed, E).value,
        paper=PAPER_CURVES["caption"](E), off=np.abs(errors_of_both(coarse, true)),
        failed=sum(int(struck[default, step, E].failed.sum()) for step in STEPS),
        crossing=crossing, kinds=crossing["what"].value_counts(), harmless=harmless(found),
        rows=rows[(rows["e"] == E) & (rows["step, s"] >= 0.002)].to_numpy().tolist(),
        stepped=[(step, struck[default, step, E]) for step in STEPS],
    )  # fmt: skip


def harmless(found: Found) -> dict[str, float] | None:
    """Return the largest step that loses no home run though pitches pass the bat unseen."""
    case = CASES[0].name
    for step in sorted(STEPS, reverse=True):
        true, one = (found.struck[case, which, E] for which in (None, step))
        unseen = float(true.batted.mean() - one.batted.mean())
        if found.bias(case, step, E).lost == 0 and unseen > 0.005:
            return {"step": step, "unseen": unseen}
    return None


def together(chunks: list[list[Struck]]) -> list[Struck]:
    """Return one `Struck` for each restitution from those of the chunks."""
    columns = ("x", "y", "failed")
    return [
        Struck(*(np.concatenate([getattr(one, name) for one in same]) for name in columns))
        for same in zip(*chunks, strict=True)
    ]


def noise(p: float) -> float:
    """Return the standard error of P from as many samples as the paper's."""
    return math.sqrt(p * (1 - p) / PAPER_SAMPLES)


def probability_rows(found: Found) -> pd.DataFrame:
    """Return bias against step, a line for each case, restitution and step."""
    rows = []
    for case in CASES:
        for e, step in itertools.product(case.restitutions, STEPS):
            one = found.bias(case.name, step, e)
            row = {"reading": case.name, "e": e, "step, s": step}
            row |= {"P, reference": f"{found.p(case.name, e):.5f}", "bias": f"{one.value:+.5f}"}
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
    case, rows = CASES[0], []
    for e, step in itertools.product(case.restitutions, STEPS):
        true, now = (found.struck[case.name, which, e].distance for which in (None, step))
        for index in np.flatnonzero((now >= HOME_RUN_DISTANCE) != (true >= HOME_RUN_DISTANCE)):
            lost = "lost: not batted" if math.isnan(now[index]) else "lost: shorter"
            what = "gained" if now[index] >= HOME_RUN_DISTANCE else lost
            place = {"e": e, "step_s": step, "seed": SEED + index // CHUNK, "sample": index % CHUNK}
            distances = {"distance_reference_m": true[index], "distance_m": now[index]}
            rows.append(place | distances | {"what": what})
    return pd.DataFrame(rows)


def draw(report: Path, found: Found) -> None:
    """Draw the bias of P, and the distribution of D."""
    with figure(report, "convergence_probability", columns=2, size=(9.0, 3.8)) as (left, right):
        for case, aside in zip(CASES, (0.95, 1.0, 1.05), strict=True):
            style = STYLES[f"verlet {case.forces}" if case.name == IMPLICIT else case.name]
            ends = [found.bias(case.name, step, E) for step in STEPS]
            p = found.p(case.name, E)
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
            one = found.struck[CASES[0].name, step, E]
            density = np.histogram(one.distance[one.batted], edges)[0] / (0.01 * one.batted.sum())
            label = "reference" if step is None else f"Δt = {step:g} s"
            label += f"; first bin: {density[0]:.0f}"
            right.stairs(density, edges, linestyle=dash, linewidth=1.4, label=label)
            top = max(top, 1.3 * density[1:].max())
        right.set(xlabel="D, m", ylabel="density among batted balls, 1/km", ylim=(0.0, top))
        right.legend()
