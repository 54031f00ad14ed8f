"""The probability of a home run, P(e): sampling the paper's at-bats, and counting.

Every sample is drawn once and struck with every restitution asked for, so that differences of
P(e) along e carry little noise. Samples come in blocks with a seed each, so that neither the
number of workers nor the number of samples asked for changes any one of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from longball.engines.at_bat import solve_with_restitutions
from longball.engines.engine import Engine
from longball.engines.ivp import Ivp
from longball.model.readings import Reading
from longball.model.scene import AtBatScene

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

HOME_RUN_DISTANCE = 150.0  # m; paper, Sec. IV
RESTITUTIONS = (0.41, 0.42, 0.43, 0.44, 0.45)  # paper, Fig. 7
MIDDLE_CELL = 3.0  # of the five that the pitching zone is divided into (paper, Sec. II)
BLOCK = 50  # samples drawn from one seed


# --- the paper's random at-bats -------------------------------------------------------------------


@dataclass(frozen=True)
class Mixture:
    """Two normal distributions, the first one drawn with probability `weight`."""

    weight: float
    means: tuple[float, float]
    deviations: tuple[float, float]

    def draw(self, count: int, generator: np.random.Generator) -> Array:
        """Return `count` draws."""
        second = (generator.random(count) >= self.weight).astype(int)
        normal = generator.standard_normal(count)
        means, deviations = np.array(self.means), np.array(self.deviations)
        drawn: Array = means[second] + deviations[second] * normal
        return drawn


@dataclass(frozen=True)
class AtBats:
    """The distributions that at-bats are drawn from.

    Attributes
    ----------
    speed
        m/s, of the pitch (paper, Eq. 3).
    aim
        m, the horizontal coordinate P_y of the point aimed at (paper, Eq. 4).
    offset_deviation
        m, of the height of the bat's axis over the pitch; its mean is 0 (paper, Sec. III.A).
    largest_tilt
        rad, of the swing's axis, which is uniform from 0 (paper, Sec. III.A).
    """

    speed: Mixture
    aim: Mixture
    offset_deviation: float
    largest_tilt: float


def paper_at_bats(reading: Reading) -> AtBats:
    """Return the paper's distributions, as a reading of Table II, Eqs. 2 to 4 and Sec. III."""
    kmh = 1 / 3.6
    large, small = (139.1, 127.8), (4.58, 7.80)  # km/h, Table II
    means, spreads = (large, small) if reading.speed_table == "columns_swapped" else (small, large)
    # As printed, exp(-(v - μ)²/σ²): the standard deviation is σ/√2.
    per_spread = 1.0 if reading.speed_spread == "standard_deviation" else math.sqrt(0.5)
    cells, deviation = (2.0, 4.0), 0.77  # Eq. 4
    width = reading.cell_width
    return AtBats(
        speed=Mixture(
            0.45,
            (means[0] * kmh, means[1] * kmh),
            (spreads[0] * kmh * per_spread, spreads[1] * kmh * per_spread),
        ),
        aim=Mixture(
            0.52,
            ((cells[0] - MIDDLE_CELL) * width, (cells[1] - MIDDLE_CELL) * width),
            (deviation * width, deviation * width),
        ),
        offset_deviation=reading.offset_spread,
        largest_tilt=math.radians(10.0),
    )


@dataclass(frozen=True)
class Samples:
    """Random inputs of at-bats, an array element each: m/s, m, m, rad."""

    speed: Array
    aim: Array
    offset: Array
    tilt: Array

    def __len__(self) -> int:
        return len(self.speed)


def draw(at_bats: AtBats, count: int, seed: int) -> Samples:
    """Return the first `count` samples of a seed."""
    blocks = [draw_block(at_bats, seed, block) for block in range(math.ceil(count / BLOCK))]
    columns = ("speed", "aim", "offset", "tilt")
    return Samples(
        *(np.concatenate([getattr(block, name) for block in blocks])[:count] for name in columns)
    )


def draw_block(at_bats: AtBats, seed: int, block: int) -> Samples:
    """Return the samples of one block, from a seed of its own."""
    generator = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(block,)))
    return Samples(
        speed=at_bats.speed.draw(BLOCK, generator),
        aim=at_bats.aim.draw(BLOCK, generator),
        offset=at_bats.offset_deviation * generator.standard_normal(BLOCK),
        tilt=at_bats.largest_tilt * generator.random(BLOCK),
    )


def scenes(base: AtBatScene, samples: Samples, first: int = 0) -> Iterator[AtBatScene | None]:
    """Yield a scene a sample: `base` with what was drawn, and an id that counts from `first`.

    Yields None for a speed that is not positive, which only the printed columns of Table II draw:
    such a ball is never pitched.
    """
    for i in range(len(samples)):
        if samples.speed[i] <= 0:
            yield None
            continue
        aim = (float(samples.aim[i]), base.pitch.aim[1])
        pitch = base.pitch.model_copy(update={"speed": float(samples.speed[i]), "aim": aim})
        swing = base.swing.model_copy(
            update={"height_offset": float(samples.offset[i]), "tilt": float(samples.tilt[i])}
        )
        yield base.model_copy(
            update={"id": f"sample-{first + i:06d}", "pitch": pitch, "swing": swing}
        )


def with_restitution(scene: AtBatScene, restitution: float) -> AtBatScene:
    """Return a scene with another restitution of the ball, which its id tells."""
    ball = scene.ball.model_copy(update={"restitution": restitution})
    return scene.model_copy(update={"id": f"{scene.id}-e{restitution:g}", "ball": ball})


# --- Monte Carlo ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Struck:
    """What became of a number of at-bats, an array element each.

    Attributes
    ----------
    x, y
        m, where the ball landed; NaN if it was not batted.
    failed
        Whether the engine could not tell.
    """

    x: Array
    y: Array
    failed: Flags

    @property
    def distance(self) -> Array:
        """Distance from the plate, m; NaN if not batted."""
        return np.hypot(self.x, self.y)

    @property
    def batted(self) -> Flags:
        """Whether the ball was batted and landed."""
        return ~np.isnan(self.x)

    @property
    def fair(self) -> Flags:
        """Whether it landed within 45° of the line from the plate to the pitcher."""
        return np.abs(self.y) <= self.x


def monte_carlo(
    base: AtBatScene,
    at_bats: AtBats,
    restitutions: Sequence[float],
    count: int,
    seed: int,
    *,
    engine: Engine[float] | None = None,
    workers: int = 1,
    progress: Callable[[int], None] = lambda done: None,
) -> list[Struck]:
    """Return what becomes of sampled at-bats, the same ones at each restitution.

    Parameters
    ----------
    base
        Everything about the at-bats that is not random, its reading of the ledger included.
    at_bats
        The distributions of what is.
    restitutions
        Values of e; one `Struck` is returned for each.
    count, seed
        Number of samples, and where they come from. Fewer samples are the first of more.
    engine
        The reference engine if none is given.
    workers
        Processes; -1 for one a core. The answer does not depend on it, to the last bit.
    progress
        Called with the number of samples done.
    """
    from joblib import Parallel, delayed  # slow to import, and not needed for --help

    solver = engine or Ivp()
    tasks = (
        delayed(_strike_block)(base, at_bats, tuple(restitutions), count, seed, block, solver)
        for block in range(math.ceil(count / BLOCK))
    )
    blocks: list[Array] = []
    for block in Parallel(n_jobs=workers, return_as="generator")(tasks):
        blocks.append(block)
        progress(min(count, len(blocks) * BLOCK))
    landed = np.concatenate(blocks, axis=2)
    return [Struck(x, y, failed > 0) for x, y, failed in landed]


def _strike_block(
    base: AtBatScene,
    at_bats: AtBats,
    restitutions: Sequence[float],
    count: int,
    seed: int,
    block: int,
    engine: Engine[float],
) -> Array:
    """Return x, y and failure of a block's samples: an array (restitution, 3, sample)."""
    first = block * BLOCK
    samples = draw_block(at_bats, seed, block)
    landed = np.full((len(restitutions), 3, min(BLOCK, count - first)), np.nan)
    landed[:, 2] = 0.0
    for i, scene in zip(range(landed.shape[2]), scenes(base, samples, first), strict=False):
        if scene is None:
            continue
        for k, result in enumerate(solve_with_restitutions(scene, restitutions, engine)):
            if result.error is not None:
                landed[k, 2, i] = 1.0
            elif result.landing is not None:
                landed[k, :2, i] = result.landing.position[:2]
    return landed


# --- counting -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Estimate:
    """P(e) counted from samples, with its Wilson interval of 95 %.

    Attributes
    ----------
    e
        The ball's coefficient of restitution.
    home_runs, trials
        What was counted, among how many of the sample space that the reading names.
    failed
        Samples that the engine could not tell, counted as no home runs.
    p, low, high
        The share of home runs, and the interval; NaN without a trial.
    """

    e: float
    home_runs: int
    trials: int
    failed: int
    p: float
    low: float
    high: float


def estimate(e: float, struck: Struck, reading: Reading) -> Estimate:
    """Count the home runs at one restitution: D >= 150 m (paper, Sec. IV)."""
    match reading.sample_space:
        case "pitches":
            space = np.ones_like(struck.batted)
        case "batted":
            space = struck.batted
        case "fair":
            space = struck.fair
    hits = int(np.count_nonzero(space & (struck.distance >= HOME_RUN_DISTANCE)))
    trials = int(np.count_nonzero(space))
    p = hits / trials if trials else math.nan
    low, high = wilson(hits, trials)
    return Estimate(e, hits, trials, int(np.count_nonzero(struck.failed)), p, low, high)


def wilson(successes: int, trials: int, level: float = 0.95) -> tuple[float, float]:
    """Return Wilson's score interval for a probability; NaN without a trial.

    E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209.
    """
    if trials == 0:
        return math.nan, math.nan
    z = NormalDist().inv_cdf(0.5 + level / 2)
    p, shrink = successes / trials, 1 + z * z / trials
    centre = (p + z * z / (2 * trials)) / shrink
    half = z / shrink * math.sqrt(p * (1 - p) / trials + z * z / (4 * trials * trials))
    # At the ends the interval reaches the end itself, which rounding may miss.
    low = 0.0 if successes == 0 else centre - half
    return low, 1.0 if successes == trials else centre + half


@dataclass(frozen=True)
class Curve:
    """P(e) = ½ [1 - erf((150 - C₁ e) / (√2 σ))], the paper's form (Sec. IV); C₁ and σ in m."""

    c1: float
    sigma: float

    def __call__(self, e: float) -> float:
        """Return P at a restitution."""
        return 0.5 * math.erfc((HOME_RUN_DISTANCE - self.c1 * e) / (math.sqrt(2) * self.sigma))


PAPER_CURVES = {"caption": Curve(242.0, 52.2), "text": Curve(271.0, 59.8)}  # Fig. 7 and its text


@dataclass(frozen=True)
class Fit:
    """The paper's form fitted to estimates, with standard errors in m."""

    curve: Curve
    c1_error: float
    sigma_error: float


def fit(estimates: Sequence[Estimate]) -> Fit | None:
    """Fit C₁ and σ to estimates by least squares, each weighted by its Wilson interval.

    Returns None where the samples do not determine two parameters: fewer than three estimates,
    or fewer than two of them strictly between 0 and 1.

    The standard errors take the estimates for independent; estimates from the same samples are
    not, and vary together.
    """
    from scipy.optimize import curve_fit
    from scipy.special import erfc

    inner = [row for row in estimates if 0 < row.p < 1]
    if len(estimates) < 3 or len(inner) < 2:
        return None

    def form(e: Array, slope: float, intercept: float) -> Array:
        return 0.5 * np.asarray(erfc((intercept - slope * e) / math.sqrt(2)))

    e = np.array([row.e for row in inner])
    p = np.array([row.p for row in inner])
    half = np.array([(row.high - row.low) / 2 for row in inner]) / NormalDist().inv_cdf(0.975)
    # In a = C₁/σ and b = 150/σ the form is a probit line, a e - b, which gives the start.
    start = np.polyfit(e, [NormalDist().inv_cdf(value) for value in p], 1)
    (a, b), covariance = curve_fit(
        form, e, p, p0=(start[0], -start[1]), sigma=half, absolute_sigma=True
    )
    sigma, c1 = HOME_RUN_DISTANCE / b, HOME_RUN_DISTANCE * a / b
    to_c1 = np.array([HOME_RUN_DISTANCE / b, -c1 / b])
    return Fit(
        Curve(float(c1), float(sigma)),
        float(np.sqrt(to_c1 @ covariance @ to_c1)),
        float(sigma / b * np.sqrt(covariance[1, 1])),
    )
