"""The paper's question, asked of real balls: whether the restitution explains the home runs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import brentq
from scipy.stats import norm

from analysis.paper import printed
from analysis.paper.home_run_figures import curve_ratio
from analysis.paper.printed import AT_BATS, BASE, PAIRS, Season
from analysis.reality import NATHAN, landings, launched, measured_flies, measured_pitches
from analysis.writing import Report
from longball import home_run
from longball.engines import create
from longball.engines.chain import solve_with_restitutions
from longball.home_run import PAPER_CURVES
from longball.model.arrays import Array, Flags
from longball.model.quantities import number
from longball.model.readings import Reading
from longball.pitches import EXAMPLE
from longball.pitches.models import MODELS, FlightModel
from longball.pitches.prediction import predict
from longball.pitches.statcast import FOOT, MPH, MeasuredFlies, time_of_plane

# The rule book (Official Baseball Rules, 2.01) asks for 325 ft along the lines and 400 ft to
# centre; parks have about this. Straight chords between the points, 8 ft high.
FENCE = ((-45, 330), (-30, 365), (-15, 392), (0, 402), (15, 392), (30, 365), (45, 330))  # °, ft
FENCE_HEIGHT = 8.0 * FOOT

# Table I: the livelier ball and the duller one of each pair, the recent pair first.
SEASON_PAIRS = PAIRS[::-1]
LIVELY, DULL = SEASON_PAIRS[0]
E_LOW = DULL.restitution

GAMES = 864  # of a season in Japan, 2010 to 2013: 12 teams of 144 games
REPLICATES, SEED = 10_000, 12
STEP = 2e-3  # of e, over which home runs are differentiated: they are smooth over 20 times that
FASTER, C = 0.1, 0.002  # m/s and of C_D: steps of the other derivatives


@dataclass(frozen=True)
class Hits:
    """Measured flies with what a livelier ball would do to them."""

    flies: MeasuredFlies  # as they were hit
    pitch: Array  # velocity at the plate, m/s, shape (n, 3)
    home_run: Flags  # whether it was one

    def per_restitution(self, e: float) -> Array:
        """Return dV/de of the velocity off the bat, m/s, shape (n, 3).

        The impulse is proportional to 1 + ẽ, and 1 + ẽ to 1 + e in every reading of the ledger,
        so that dV/de = (V - V_pitch)/(1 + e).
        """
        return (self.flies.velocity - self.pitch) / (1.0 + e)

    def with_restitution(self, change: float, e: float) -> "Hits":
        """Return the hits with a ball whose restitution is larger than `e` by a change."""
        velocity = self.flies.velocity + change * self.per_restitution(e)
        speed = np.linalg.norm(velocity, axis=1)
        angle = np.arcsin(velocity[:, 2] / speed)
        bearing = np.arctan2(-velocity[:, 1], velocity[:, 0])
        return replace(self, flies=replace(self.flies, speed=speed, angle=angle, bearing=bearing))

    def harder(self, change: float) -> "Hits":
        """Return the hits, all of them faster by so many m/s."""
        return replace(self, flies=replace(self.flies, speed=self.flies.speed + change))


def measured_hits(change: Callable[[MeasuredFlies], MeasuredFlies] = lambda x: x) -> Hits:
    """Return the flies of the day that have a pitch, with its velocity at the plate."""
    flies, pitches = measured_flies(), measured_pitches()
    flies = change(flies.chosen(np.isin(flies.rows, pitches.rows)))
    pitches = pitches.chosen(np.isin(pitches.rows, flies.rows))
    v, a = pitches.velocity, pitches.acceleration
    time = time_of_plane(v[:, 0], a[:, 0], -pitches.release[:, 0])
    events = pd.read_csv(EXAMPLE)["events"].to_numpy()[flies.rows - 1]
    return Hits(flies, v + a * time[:, None], events == "home_run")


@dataclass(frozen=True)
class Variant:
    """A way to carry hits to the fence."""

    name: str
    hits: Hits  # as they are struck by the duller ball
    model: FlightModel
    scatter: float  # m, standard deviation of a ball's place of landing about the expected one
    fence: float = 0.0  # m, by which it is moved out
    # Whether a ball passes the fence at the bearing where it is expected to come down, and not at
    # that of its launch.
    by_place: bool = False
    restitution: float = E_LOW  # of the duller ball

    def margins(self, hits: Hits) -> Array:
        """Return each ball's clearance of the fence, m, before the fence is moved.

        A ball clears the fence if it comes down far enough beyond it; over the last metres, from
        the height of the fence to the ground, its path is taken to be straight.
        """
        place, velocity = landings(hits.flies, self.model)
        level = np.hypot(velocity[:, 0], velocity[:, 1])
        carry = np.hypot(place[:, 0], place[:, 1]) + FENCE_HEIGHT * level / velocity[:, 2]
        bearing = np.arctan2(-place[:, 1], place[:, 0]) if self.by_place else hits.flies.bearing
        return carry - fence_distance(bearing)

    def chances(self, hits: Hits) -> Array:
        """Return the probability of a home run of each ball."""
        return np.asarray(norm.cdf((self.margins(hits) - self.fence) / self.scatter))

    def livelier(self, change: float) -> "Hits":
        """Return the hits with a ball whose restitution is larger by a change."""
        return self.hits.with_restitution(change, self.restitution)


def fence_distance(bearing: Array) -> Array:
    """Return the distance of the fence at bearings, m; outside the poles that of the pole."""
    angles = np.radians([angle for angle, _ in FENCE])
    x, y = (f(angles) * [FOOT * far for _, far in FENCE] for f in (np.cos, np.sin))
    within = np.clip(bearing, angles[0], angles[-1])
    i = np.clip(np.searchsorted(angles, within) - 1, 0, len(FENCE) - 2)
    along, across = x[i + 1] - x[i], y[i + 1] - y[i]
    turned = np.cos(within) * across - np.sin(within) * along
    return np.asarray((x[i] * across - y[i] * along) / turned)


class Estimate(NamedTuple):
    """A number; and it again, from resampled games, or from counts drawn anew."""

    value: float
    draws: Array

    def __format__(self, digits: str) -> str:
        """Write the value with its 95 % interval."""
        low, high = self.interval
        return f"{self.value:{digits}} ({low:{digits}} to {high:{digits}})"

    @property
    def interval(self) -> tuple[float, float]:
        """The middle 95 % of the draws."""
        low, high = np.quantile(self.draws, [0.025, 0.975])
        return float(low), float(high)

    def map(self, function: Callable[..., Any], *others: "Estimate") -> "Estimate":
        """Return a function of this estimate and others that are independent of it."""
        values, draws = zip(self, *others, strict=True)
        return Estimate(float(function(*values)), function(*draws))


def of_games(function: Callable[..., Any], variant: Variant, *chances: Array) -> Estimate:
    """Return a function of sums of chances, with draws from a bootstrap over games."""
    _, of_game = np.unique(variant.hits.flies.games, return_inverse=True)
    sums = [np.bincount(of_game, weights=each) for each in chances]
    count, generator = len(sums[0]), np.random.default_rng(SEED)
    drawn = generator.multinomial(count, np.full(count, 1.0 / count), size=REPLICATES)
    draws = function(*(drawn @ each for each in sums))
    return Estimate(float(function(*map(np.sum, sums))), draws)


def slope(variant: Variant, step: float, chances: Callable[[float], Array]) -> Estimate:
    """Return d ln(home runs)/dx from the chances at x = ± a step."""
    below, above = chances(-step), chances(step)
    return of_games(lambda low, high: (high - low) / (high + low) / step, variant, below, above)


def restitution_slope(variant: Variant) -> tuple[float, Estimate]:
    """Return the home runs with the duller ball, and d ln(home runs)/de there."""
    around = {change: variant.chances(variant.livelier(change)) for change in (-STEP, STEP)}
    mean = np.sum([*around.values()]) / 2.0
    return float(mean), slope(variant, STEP, around.__getitem__)


def season_ratios(variant: Variant) -> list[Estimate]:
    """Return the ratio of home runs in each pair of seasons, from the restitutions."""
    changes = [lively.restitution - E_LOW for lively, _ in SEASON_PAIRS]
    dull, *lively = (variant.chances(variant.livelier(x)) for x in (0.0, *changes))
    return [of_games(lambda before, after: after / before, variant, dull, x) for x in lively]


def with_fence_for(variant: Variant, home_runs: float) -> Variant:
    """Return a variant whose fence stands where it lets so many home runs over."""
    margins, scatter = variant.margins(variant.hits), variant.scatter
    fence = brentq(lambda x: norm.cdf((margins - x) / scatter).sum() - home_runs, -20.0, 60.0)
    return replace(variant, fence=float(fence))


def run(report: Report, full: bool) -> str:
    """Differentiate the home runs of a day by the restitution, and hold it against two seasons."""
    hits = measured_hits()
    day, games = int(hits.home_run.sum()), len(np.unique(hits.flies.games))
    japan = games * DULL.home_runs / GAMES
    scatter = float(np.std(predict(hits.flies, NATHAN).error))
    plain = Variant("Nathan's laws, this fence", hits, NATHAN, scatter)
    fitted = with_fence_for(replace(plain, name="the same, fence by the day's count"), day)
    change = brentq(lambda x: fitted.chances(hits.harder(x)).sum() - japan, -8.0, 4.0, xtol=0.001)
    name = "the same, balls slower by Japan's count of 2012"
    slower = replace(fitted, name=name, hits=hits.harder(change))
    further = with_fence_for(replace(plain, name="fence alone by Japan's count"), japan)
    launch = measured_hits(launched)
    # A ball with side spin passes the fence at neither bearing exactly.
    placed = replace(plain, name="the same, passed where the ball comes down", by_place=True)
    others = [
        replace(placed, name="fence by the day's count, passed where the ball comes down"),
        replace(plain, name="launched to where it was fielded", hits=launch, by_place=True),
        replace(plain, name="drag crisis fitted to the day", model=MODELS["crisis"]),
        replace(plain, name="half the scatter", scatter=scatter / 2.0),
        replace(plain, name="e = 0.5 at the bat", restitution=0.5),
    ]
    others = [with_fence_for(variant, day) for variant in others]
    variants = [plain, placed, fitted, *others, further, slower]
    slopes = {variant.name: restitution_slope(variant) for variant in variants}
    ratios = {x.name: season_ratios(x) for x in (fitted, further, slower)}
    counted = [counted_ratio(*pair) for pair in SEASON_PAIRS]
    # What the paper's model makes of each pair of seasons, in the default reading.
    restitutions = [E_LOW, *(lively.restitution for lively, _ in SEASON_PAIRS)]
    dull, *livelier = home_run.integrals(BASE, AT_BATS, restitutions)
    models = [row.p / dull.p for row in livelier]
    draw_ratios(report, counted, ratios[slower.name], models)

    def with_drag(x: float) -> Array:
        """Return chances with another C_D, by the part of it that depends on nothing."""
        drag: Any = NATHAN.drag
        model = replace(NATHAN, drag=drag | {"constant": drag["constant"] + x})
        return replace(slower, model=model).chances(slower.hits)

    by_speed = slope(slower, FASTER, lambda x: slower.chances(slower.hits.harder(x)))
    return report.render(
        "seasons", vars(printed) | globals(), hits=hits, day=day, games=games, plain=plain,
        treatments=[slopes[variant.name] for variant in (plain, placed)],
        moved=[slopes[variant.name] for variant in (fitted, others[0])],
        fitted=fitted, change=change, slopes=slopes, ratios=ratios, counted=counted, models=models,
        alone=ratios[slower.name][0], slope=slopes[slower.name][1],
        explained=ratios[slower.name][0].map(lambda x, y: np.log(x) / np.log(y), counted[0]),
        per_e=float(np.linalg.norm(hits.per_restitution(E_LOW)[hits.home_run], axis=1).mean()),
        by_speed=by_speed.value * MPH, by_drag=slope(slower, C, with_drag).value,
    )  # fmt: skip


def counted_ratio(lively: Season, dull: Season) -> Estimate:
    """Return the ratio of two seasons' home runs; its draws are of two Poisson counts."""
    generator = np.random.default_rng(SEED + 1)
    drawn = (generator.poisson(season.home_runs, REPLICATES) for season in (lively, dull))
    return Estimate(lively.home_runs / dull.home_runs, np.divide(*drawn))


def counted_slope(lively: Season, dull: Season) -> Estimate:
    """Return d ln(home runs)/de by two seasons."""
    change = lively.restitution - dull.restitution
    return counted_ratio(lively, dull).map(lambda ratio: np.log(ratio) / change)


DRAWN = 20  # at-bats, of which some two thirds meet the bat
COLLISIONS = (
    *(Reading(), Reading(reduced_mass="effective_mass")),
    *(Reading(bat_ball_restitution="nathan"), Reading(bat_ball_restitution="plain")),
)


def proportionality() -> float:
    """Return the relative deviation of the collision's dV/de from (V - V_pitch)/(1 + e).

    The largest difference over sampled at-bats and all readings of the collision.
    """
    worst, drawn = 0.0, home_run.draw(AT_BATS, DRAWN, SEED)
    for reading in COLLISIONS:
        for scene in home_run.scenes(BASE.model_copy(update={"reading": reading}), drawn):
            assert scene is not None  # every speed is positive under this reading of Table II
            results = solve_with_restitutions(scene, [E_LOW, 0.5], create("ivp"))
            if all(result.impact for result in results):
                low, high = (float(number(result, "impact.impulse")) for result in results)
                slope = (high - low) / (0.5 - E_LOW)
                worst = max(worst, abs(slope / (low / (1.0 + E_LOW)) - 1.0))
    return worst


def carry_slope(variant: Variant) -> float:
    """Return dD/de of the day's home runs, m, on the average."""
    around = (variant.livelier(change).flies for change in (-STEP, STEP))
    places = (landings(flies, variant.model)[0][variant.hits.home_run] for flies in around)
    below, above = (np.hypot(place[:, 0], place[:, 1]) for place in places)
    return float((above - below).mean() / (2.0 * STEP))


def draw_ratios(
    report: Report, counted: Sequence[Estimate], expected: Sequence[Estimate], models: list[float]
) -> None:
    """Draw the ratios of both pairs of seasons."""
    with report.figure("seasons", size=(6.4, 3.2)) as (axes,):
        rows = zip(SEASON_PAIRS, counted, expected, models, strict=True)
        for i, (pair, seen, alone, model) in enumerate(rows):
            hide = "_" * i  # the labels of the first pair serve both
            for estimate, y, marker, label in (
                (seen, i + 0.075, "ks", f"{hide}counted"),
                (alone, i - 0.075, "C0o", f"{hide}measured balls, e alone"),
            ):
                bars = np.abs(np.array([estimate.interval]).T - estimate.value)
                axes.errorbar(estimate.value, y, None, bars, marker, capsize=3, label=label)
            curve = curve_ratio(PAPER_CURVES["caption"], pair)
            axes.plot(curve, i - 0.2, "C1^", label=f"{hide}the paper's curve")
            axes.plot(model, i - 0.2, "C2v", label=f"{hide}the paper's model, as we read it")
        axes.axvline(1.0, color="black", linewidth=0.8)
        years = [f"{dull.year} to {lively.year}" for lively, dull in SEASON_PAIRS]
        axes.set_yticks(range(len(years)), years)
        axes.set(ylim=(-0.6, len(years) - 0.4), xlabel="ratio of home runs")
        axes.legend(fontsize="small", loc="upper center", ncols=2, bbox_to_anchor=(0.5, 1.25))
