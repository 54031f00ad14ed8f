"""The paper's own argument for the form of P(e), step by step (Sec. IV)."""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import binned_statistic, norm

from analysis.paper import balls, combinations, printed
from analysis.paper.balls import Balls, Base, Space, strike
from analysis.speed_error.work import launches
from analysis.writing import STYLES, Report
from longball import home_run
from longball.engines.batch import solve_columns
from longball.home_run import HOME_RUN_DISTANCE, RESTITUTIONS
from longball.model.arrays import Array

E, STEP = 0.43, 0.01  # the middle of the paper's range, and the step of the differences
WINDOW = (100.0, 200.0)  # m, "approximately D = 150 m"
MIDDLE = RESTITUTIONS.index(E)

# --- is D near 150 m normal, with mean C₁ e? ------------------------------------------------------


def tail(space: Space, struck: Sequence[Balls]) -> dict[str, float]:
    """Compare the balls of a sample space, struck at the paper's restitutions, with its form.

    A normal density of D with mean m and deviation σ is fixed by P = Φ((m - 150)/σ) and by its
    density p at 150 m; and P changes with e by p(150) times the mean of dD/de there, whatever
    the density (Leibniz' rule). The paper's form says that both are C₁: m = C₁ e, and dm/de = C₁.
    """
    rows = space.estimates(struck)
    p, distances = rows[MIDDLE].p, space.distances(struck[MIDDLE])
    density = density_at_fence(distances) * len(distances) / rows[MIDDLE].trials
    z = float(norm.isf(p))
    sigma = float(norm.pdf(z)) / density
    slope = (rows[MIDDLE + 1].p - rows[MIDDLE - 1].p) / (2 * STEP)
    fitted = home_run.fit(rows)
    return {
        "p": p,  # P(D ≥ 150 m) of the balls in the sample space
        "density": density,  # 1/m, theirs at 150 m
        "sigma": sigma,  # m, of the normal distribution that has both
        "mean": HOME_RUN_DISTANCE - z * sigma,  # m, of the same
        "shift": slope / density,  # m: the mean of dD/de at the fence
        "curvature": width(distances),  # m, the σ of a normal density that bends like this one
        "c1": fitted.curve.c1 if fitted else math.nan,  # m, of the paper's form fitted to P(e)
        "c1_sigma": fitted.curve.sigma if fitted else math.nan,  # m, of the same
    }


def log_density(distances: Array) -> Array:
    """Return a parabola for ln p(D) in the window, highest power first; D - 150 m in metres."""
    edges = np.arange(WINDOW[0], WINDOW[1] + 1, 5.0)
    counts = np.histogram(distances, edges)[0]
    filled = counts > 0
    middles = (edges[:-1] + edges[1:])[filled] / 2 - HOME_RUN_DISTANCE
    # The logarithm of a count n has the standard error 1/√n.
    heights = np.log(counts[filled] / (len(distances) * np.diff(edges)[filled]))
    return np.polyfit(middles, heights, 2, w=np.sqrt(counts[filled]))


def density_at_fence(distances: Array) -> float:
    """Return the density of D at 150 m, 1/m, from the smooth curve through the window."""
    return math.exp(log_density(distances)[2])


def width(distances: Array) -> float:
    """Return σ if the density in the window were normal; NaN if it is not peaked at all."""
    bend = log_density(distances)[0]
    return math.sqrt(-1 / (2 * bend)) if bend < 0 else math.nan


# --- is the pitch's speed at contact nearly constant? ---------------------------------------------


def contact(base: Base, struck: Sequence[Balls]) -> dict[str, float]:
    """Return the scatter of the exit speed from that of the pitch, m/s, for balls hit upwards."""
    flies = struck[0].elevation > 0
    speeds = struck[0].pitch_speed[flies]
    samples = base.drawn(balls.SAMPLES // 10)
    faster = replace(samples, speed=samples.speed * (1 + speeds.std() / speeds.mean()))
    usual, quick = (strike(base, one, [E])[0] for one in (samples, faster))
    return {
        "mean": speeds.mean(),  # of the ball's speed as it meets the bat
        "deviation": speeds.std(),
        # Gained by one deviation of the pitch's speed, all else equal; and from e = 0.41 to 0.45.
        "by_speed": np.nanmedian(quick.exit_speed - usual.exit_speed),
        "by_restitution": np.median(struck[-1].exit_speed[flies] - struck[0].exit_speed[flies]),
    }


# --- is D linear in the exit speed? ---------------------------------------------------------------


class Line(NamedTuple):
    """A straight line laid through D, m, against a speed or a restitution."""

    slope: float
    intercept: float
    off: float  # m, the largest distance of a point from it
    bent: float  # the same as a share of the change along it
    power: float  # d ln D / d ln x in the middle: 1 if D is proportional to x


def line(x: Array, d: Array) -> Line:
    """Lay a line through points by least squares."""
    slope, intercept = map(float, np.polyfit(x, d, 1))
    middle = len(x) // 2
    power = np.gradient(d, x)[middle] * x[middle] / d[middle]
    off = float(np.abs(d - slope * x - intercept).max())
    return Line(slope, intercept, off, off / (slope * float(x[-1] - x[0])), float(power))


SPEEDS = np.linspace(40.0, 60.0, 21)  # m/s
ELEVATIONS = (20.0, 30.0, 40.0)  # degrees
STRAIGHT = 0.05  # off a line by less than this share of the whole change: linear to the eye


def ranges(base: Base, elevation: float) -> Array:
    """Return D, m, of flights from 1 m above the ground at the speeds above."""
    same = {name: getattr(base.scene, name) for name in ("ball", "air", "reading")}
    flown = launches(SPEEDS, math.radians(elevation), **same)
    return solve_columns(flown.base, flown.columns)["landing.distance"]


def exit_line(balls: Balls) -> Line:
    """Lay a line through the mean D of fair flies against their exit speed, m/s."""
    flies = balls.fair & (balls.elevation > 0)
    speed, d = balls.exit_speed[flies], balls.distance[flies]
    edges = np.quantile(speed, np.linspace(0.02, 0.98, 25))
    return line(*binned_statistic(speed, [speed, d], bins=edges).statistic)


# --- what does dD/de come to? ---------------------------------------------------------------------


def shift(distance: float, struck: Sequence[Balls]) -> dict[str, float] | None:
    """Return dD/de of the fair flies that land at a distance; None if there are too few."""
    at = struck[MIDDLE]
    here = at.fair & (at.elevation > 0) & (np.abs(at.distance - distance) < 5.0)
    if here.sum() < 100:
        return None
    below, d, above = (struck[MIDDLE + i].distance[here] for i in (-1, 0, 1))
    slope = (above - below) / (2 * STEP)
    low, median, high = np.quantile(slope, (0.25, 0.5, 0.75))
    return {
        "balls": int(here.sum()),
        **{"low": low, "median": median, "high": high},  # m, dD/de; half lie between low and high
        "power": np.median(slope * E / d),  # d ln D / d ln e: 1 if D is proportional to e
        # Largest share of dD/de that changes from e = 0.42 to 0.44, for 95 % of them: 0 if linear.
        "bend": np.quantile(np.abs((above - 2 * d + below) / STEP / slope), 0.95),
    }


def tested(name: str, base: Base, space: Space) -> SimpleNamespace:
    """Try the argument on a reading."""
    struck = strike(base, base.drawn(), RESTITUTIONS)
    shifts = {distance: shift(distance, struck) for distance in (75.0, 110.0, 150.0)}
    counts = np.histogram(space.distances(struck[MIDDLE]), np.arange(0.0, 301.0, 5.0))[0]
    return SimpleNamespace(
        name=name, base=base, space=space, tail=tail(space, struck), contact=contact(base, struck),
        # By the middle of where the balls land, ± 5 m.
        shifts={distance: found for distance, found in shifts.items() if found},
        # By elevation.
        flights={angle: line(SPEEDS, ranges(base, angle)) for angle in ELEVATIONS},
        exit=exit_line(struck[MIDDLE]),
        # Of D, 1/m, in bins of 5 m.
        density=counts / (5.0 * space.estimate(E, struck[MIDDLE]).trials),
    )  # fmt: skip


@cache
def everything() -> list[SimpleNamespace]:
    """Try the argument on the default and the nearest reading; two sections ask for it."""
    return [tested(name, *case) for name, case in combinations.cases().items()]


def run(report: Report, full: bool) -> str:
    """Draw the densities, and D against the exit speed; `full` changes nothing."""
    found = everything()
    d = np.arange(0.0, 300.0, 5.0) + 2.5
    near = (d > WINDOW[0] - 50) & (d < WINDOW[1] + 50)
    with report.figure("paper_argument", rows=2, size=(6.4, 8.0)) as (above, below):
        top = 1.05 * max(one.density[2:].max() for one in found)
        for i, one in enumerate(found):
            line = {key: STYLES[one.name][key] for key in ("color", "linestyle")}
            above.plot(d, one.density, **line, linewidth=1.8, label=f"{one.name} reading")
            normal = norm.pdf(d[near], one.tail["mean"], one.tail["sigma"])
            normal[normal > top] = np.nan  # where it leaves the figure
            # One label serves both.
            label = "_" * i + "normal density, same P and same value at 150 m"
            above.plot(d[near], normal, color=line["color"], linewidth=0.7, label=label)
            alike = one.flights == found[1 - i].flights
            lines = {} if i and alike else one.flights  # those of the first stand for both
            for angle, laid in lines.items():
                flown = ranges(one.base, angle)
                first = angle == ELEVATIONS[0]
                label = "_" * (not first) + ("both readings" if alike else f"{one.name} reading")
                below.plot(SPEEDS, flown, color=line["color"], linewidth=1.8, label=label)
                label = "_" * (i > 0 or not first) + "straight line laid through it"
                straight = laid.slope * SPEEDS + laid.intercept
                below.plot(SPEEDS, straight, color="black", linestyle=":", label=label)
                place: Any = {"textcoords": "offset points", "va": "center", "ha": "right"}
                below.annotate(f"{angle:g}°", (SPEEDS[0], flown[0]), (-4, 0), **place)
        above.axvline(HOME_RUN_DISTANCE, color="black", linewidth=0.8, label="150 m")
        above.set(xlabel="distance D, m", ylabel="probability density, 1/m")
        above.set(xlim=(0.0, 250.0), ylim=(0.0, top))
        above.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
        below.set(xlabel="exit speed, m/s", ylabel="distance D, m", xlim=(38.5, 61.0))
        below.legend(loc="upper left")
    return report.render("argument", vars(printed) | globals(), found=found)
