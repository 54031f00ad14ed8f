"""The paper's own argument for the form of P(e), step by step (Sec. IV)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from analysis.paper import combinations
from analysis.paper.balls import Balls, Base, Space, cores, strike
from analysis.paper.printed import CARRIES
from analysis.writing import STYLES, figure, render
from longball.engines.batch import solve_columns
from longball.home_run import (
    HOME_RUN_DISTANCE,
    PAPER_CURVES,
    RESTITUTIONS,
    draw,
    fit,
    paper_at_bats,
)
from longball.model.scene import FlightScene, Launch

Array = NDArray[np.float64]

SAMPLES = 400_000
SEED = 21
E, STEP = 0.43, 0.01  # the middle of the paper's range, and the step of the differences
WINDOW = (100.0, 200.0)  # m, "approximately D = 150 m"
NORMAL = NormalDist()


# --- is D near 150 m normal, with mean C₁ e? ------------------------------------------------------


@dataclass(frozen=True)
class Tail:
    """What a reading has at the fence, against the normal distribution that the paper assumes.

    A normal density of D with mean m and deviation σ is fixed by P = Φ((m - 150)/σ) and by its
    density p at 150 m; and P changes with e by p(150) times the mean of dD/de there, whatever
    the density (Leibniz' rule). The paper's form says that both are C₁: m = C₁ e, and dm/de = C₁.

    Attributes
    ----------
    p, density
        P(D ≥ 150 m) and the density at 150 m, 1/m, of the balls in the sample space.
    sigma, mean
        m, of the normal distribution that has both.
    shift
        m, dP/de over the density: the mean of dD/de at the fence.
    curvature
        m, of the density in the window about 150 m: 1/√(-d² ln p/dD²), which is σ for a normal
        one; NaN if the logarithm of the density curves upwards.
    c1, c1_sigma
        m, the paper's form fitted to P(e).
    """

    p: float
    density: float
    sigma: float
    mean: float
    shift: float
    curvature: float
    c1: float
    c1_sigma: float

    @property
    def c1_of_the_mean(self) -> float:
        """Return C₁ = mean / e, m."""
        return self.mean / E


def tail(space: Space, struck: Sequence[Balls]) -> Tail:
    """Compare the balls of a sample space, struck at the paper's restitutions, with the form."""
    rows = [space.estimate(e, balls) for e, balls in zip(RESTITUTIONS, struck, strict=True)]
    middle = RESTITUTIONS.index(E)
    row, distances = rows[middle], space.distances(struck[middle])
    p, density = row.p, density_at_fence(distances) * len(distances) / row.trials
    z = NORMAL.inv_cdf(1 - p)
    sigma = NORMAL.pdf(z) / density
    slope = (rows[middle + 1].p - rows[middle - 1].p) / (2 * STEP)
    fitted = fit(rows)
    return Tail(
        p=p,
        density=density,
        sigma=sigma,
        mean=HOME_RUN_DISTANCE - z * sigma,
        shift=slope / density,
        curvature=width(distances),
        c1=fitted.curve.c1 if fitted else math.nan,
        c1_sigma=fitted.curve.sigma if fitted else math.nan,
    )


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


@dataclass(frozen=True)
class Contact:
    """Speeds at the bat.

    Attributes
    ----------
    mean, deviation
        m/s, of the ball's speed as it meets the bat.
    by_speed
        m/s, how much faster a ball leaves the bat for one deviation of the pitch's speed, all
        else equal.
    by_restitution
        m/s, how much faster at e = 0.45 than at 0.41.
    """

    mean: float
    deviation: float
    by_speed: float
    by_restitution: float

    @property
    def share(self) -> float:
        """What one deviation of the pitch's speed does, of what the restitution does."""
        return abs(self.by_speed / self.by_restitution)


def contact(base: Base, struck: Sequence[Balls]) -> Contact:
    """Return what the scatter of the pitch's speed amounts to, for the balls hit upwards."""
    flies = struck[0].elevation > 0
    speeds = struck[0].pitch_speed[flies]
    samples = draw(paper_at_bats(base.sampling), SAMPLES // 10, SEED)
    factor = 1 + float(speeds.std() / speeds.mean())
    faster = type(samples)(samples.speed * factor, samples.aim, samples.offset, samples.tilt)
    usual, quick = (strike(base, one, [E], threads=cores())[0] for one in (samples, faster))
    return Contact(
        mean=float(speeds.mean()),
        deviation=float(speeds.std()),
        by_speed=float(np.nanmedian(quick.exit_speed - usual.exit_speed)),
        by_restitution=float(np.median(struck[-1].exit_speed[flies] - struck[0].exit_speed[flies])),
    )


# --- is D linear in the exit speed? ---------------------------------------------------------------


@dataclass(frozen=True)
class Line:
    """A straight line laid through D against a speed or a restitution.

    Attributes
    ----------
    slope, intercept
        Of D, in m.
    off
        m, the largest distance of a point from it.
    power
        d ln D / d ln x in the middle: 1 if D is proportional to x.
    """

    slope: float
    intercept: float
    off: float
    power: float


def line(x: Array, d: Array) -> Line:
    """Lay a line through points by least squares."""
    slope, intercept = map(float, np.polyfit(x, d, 1))
    middle = len(x) // 2
    power = np.gradient(d, x)[middle] * x[middle] / d[middle]
    off = np.abs(d - slope * x - intercept).max()
    return Line(slope, intercept, float(off), float(power))


SPEEDS = np.linspace(40.0, 60.0, 21)  # m/s
ELEVATIONS = (20.0, 30.0, 40.0)  # degrees
STRAIGHT = 0.05  # off a line by less than this share of the whole change: linear to the eye


def ranges(base: Base, elevation: float) -> Array:
    """Return D, m, of flights from 1 m above the ground at the speeds above."""
    angle = math.radians(elevation)
    scene = FlightScene(
        id="flight",
        ball=base.scene.ball,
        air=base.scene.air,
        reading=base.scene.reading,
        launch=Launch(position=(0.0, 0.0, 1.0), velocity=(1.0, 0.0, 0.0)),
    )
    columns = {
        "launch.velocity[0]": SPEEDS * math.cos(angle),
        "launch.velocity[2]": SPEEDS * math.sin(angle),
    }
    found: Array = solve_columns(scene, columns)["landing.distance"]
    return found


# --- what does dD/de come to? ---------------------------------------------------------------------


@dataclass(frozen=True)
class Shift:
    """dD/de of single at-bats that land at some distance, by differences over the same swing.

    Attributes
    ----------
    distance
        m, the middle of where they land, ± 5 m.
    balls
        How many.
    median, low, high
        m, dD/de: half of them lie between low and high.
    power
        Median of d ln D / d ln e: 1 if D is proportional to e, as in D = C₁ e.
    bend
        Largest share of dD/de that changes from e = 0.42 to 0.44, for 95 % of them: 0 if D is
        linear in e.
    """

    distance: float
    balls: int
    median: float
    low: float
    high: float
    power: float
    bend: float


def shift(distance: float, struck: Sequence[Balls]) -> Shift | None:
    """Return dD/de of the fair flies that land at a distance; None if there are too few."""
    middle = RESTITUTIONS.index(E)
    below, at, above = (struck[middle + i] for i in (-1, 0, 1))
    here = at.fair & (at.elevation > 0) & (np.abs(at.distance - distance) < 5.0)
    if here.sum() < 100:
        return None
    d = np.array([one.distance[here] for one in (below, at, above)])
    slope = (d[2] - d[0]) / (2 * STEP)
    low, median, high = map(float, np.quantile(slope, (0.25, 0.5, 0.75)))
    bend = np.quantile(np.abs((d[2] - 2 * d[1] + d[0]) / STEP / slope), 0.95)
    power = np.median(slope * E / d[1])
    return Shift(distance, int(here.sum()), median, low, high, float(power), float(bend))


# --- the report -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Tested:
    """What was found for a reading."""

    name: str
    base: Base
    space: Space
    tail: Tail
    contact: Contact
    shifts: list[Shift]
    flights: dict[float, Line]
    exit: Line
    density: Array

    @property
    def lines(self) -> dict[str, Line]:
        """All lines, by the balls through which they are laid."""
        speeds = f"{SPEEDS[0]:g} to {SPEEDS[-1]:g} m/s"
        flown = {f"launched at {a:g}°, {speeds}": laid for a, laid in self.flights.items()}
        return flown | {"all fair flies, mean D by exit speed": self.exit}

    @property
    def bent(self) -> float:
        """How far the flights are off their lines at most, as a share of the change of D."""
        rise = SPEEDS[-1] - SPEEDS[0]
        return max(laid.off / (laid.slope * float(rise)) for laid in self.flights.values())

    @property
    def powers(self) -> list[float]:
        """D ln D / d ln v by elevation."""
        return [laid.power for laid in self.flights.values()]

    @property
    def proportional(self) -> bool:
        """Whether D is proportional to the exit speed, within a tenth of the power."""
        return all(abs(power - 1) < 0.1 for power in self.powers)

    def covers(self, slope: float) -> bool:
        """Tell whether a dD/de lies in the middle half of those of the balls that land at 110 m."""
        return any(at.distance == 110.0 and at.low <= slope <= at.high for at in self.shifts)


def tested(name: str, base: Base, space: Space) -> Tested:
    """Try the argument on a reading."""
    samples = draw(paper_at_bats(base.sampling), SAMPLES, SEED)
    struck = strike(base, samples, RESTITUTIONS, threads=cores())
    shifts = [shift(distance, struck) for distance in (75.0, 110.0, 150.0)]
    middle = struck[RESTITUTIONS.index(E)]
    return Tested(
        name=name,
        base=base,
        space=space,
        tail=tail(space, struck),
        contact=contact(base, struck),
        shifts=[one for one in shifts if one is not None],
        flights={angle: line(SPEEDS, ranges(base, angle)) for angle in ELEVATIONS},
        exit=exit_line(middle),
        density=np.histogram(space.distances(middle), np.arange(0.0, 301.0, 5.0))[0]
        / (5.0 * space.estimate(E, middle).trials),
    )


def exit_line(balls: Balls) -> Line:
    """Lay a line through the mean D of fair flies against their exit speed, m/s."""
    flies = balls.fair & (balls.elevation > 0)
    speed, d = balls.exit_speed[flies], balls.distance[flies]
    edges = np.quantile(speed, np.linspace(0.02, 0.98, 25))
    where = np.digitize(speed, edges)
    groups = [where == i for i in range(1, len(edges))]
    return line(
        np.array([speed[group].mean() for group in groups]),
        np.array([d[group].mean() for group in groups]),
    )


@cache
def everything() -> list[Tested]:
    """Try the argument on the default and the nearest reading; two sections ask for it."""
    return [tested(name, *case) for name, case in combinations.cases().items()]


def run(report: Path, full: bool) -> str:
    """Write the section; `full` changes nothing."""
    found = everything()
    draw_argument(report, found)
    return render(
        report,
        "argument",
        found=found,
        samples=SAMPLES,
        seed=SEED,
        e=E,
        first_e=min(RESTITUTIONS),
        last_e=max(RESTITUTIONS),
        caption=PAPER_CURVES["caption"],
        curves=PAPER_CURVES,
        carries=CARRIES,
        straight=STRAIGHT,
        fence=HOME_RUN_DISTANCE,
    )


def draw_argument(report: Path, found: Sequence[Tested]) -> None:
    """Draw the density with the normal one, and D against the exit speed."""
    d = np.arange(0.0, 300.0, 5.0) + 2.5
    near = (d > WINDOW[0] - 50) & (d < WINDOW[1] + 50)
    with figure(report, "paper_argument", columns=2, size=(9.0, 4.0)) as (left, right):
        for one in found:
            style = STYLES[one.name]
            line = {"color": style["color"], "linestyle": style["linestyle"]}
            left.plot(d, 1e3 * one.density, **line, linewidth=1.6, label=f"{one.name} reading")
            normal = NormalDist(one.tail.mean, one.tail.sigma)
            densities = [1e3 * normal.pdf(x) for x in d[near]]
            left.plot(d[near], densities, **line, linewidth=0.7, label="normal, same P and density")
            for marker, (angle, laid) in zip("v^s", one.flights.items(), strict=True):
                flown = ranges(one.base, angle)
                label = f"{one.name}, {angle:g}°"
                right.plot(
                    SPEEDS, flown, **line, marker=marker, markersize=4, markevery=5, label=label
                )
                right.plot(SPEEDS, laid.slope * SPEEDS + laid.intercept, ":", color="0.5")
        left.axvline(HOME_RUN_DISTANCE, color="black", linewidth=0.8, linestyle=":")
        left.set(xlabel="distance D, m", ylabel="probability density, 1/km", xlim=(0.0, 250.0))
        left.set_ylim(0.0, 1.05 * max(1e3 * one.density[2:].max() for one in found))
        left.legend(fontsize="small")
        right.set(xlabel="exit speed, m/s", ylabel="distance D, m")
        right.legend(fontsize="small", ncols=2)
