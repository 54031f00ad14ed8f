"""Measured baseball: what models of flight say of a day of measured pitches and batted balls."""

from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
import pandas as pd
import scipy.stats
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares

from analysis.writing import Report
from longball.engines import create
from longball.engines.chain import solve_each
from longball.model.arrays import Array
from longball.model.scene import Ball
from longball.pictures import draw_errors
from longball.pitches import EXAMPLE, prediction, statcast
from longball.pitches.models import MODELS, STANDARD_GRAVITY, FlightModel, regression_spin
from longball.pitches.prediction import ANGLES, Prediction, bands, predict, scenes
from longball.pitches.statcast import GAMES, RPM, MeasuredFlies, MeasuredPitches, read_measured
from longball.questions.parks import in_parks, park, parks
from longball.questions.spin import measured_spin

NATHAN = MODELS["nathan"]
# Shares of active spin that are tried, and those of them that are solved: places at the plate are
# smooth in between. Spin all along the velocity would be a singular point of its direction.
SHARES, SOLVED_SHARES = np.linspace(0.05, 1.0, 951), np.linspace(0.05, 1.0, 7)
BOOTSTRAP = {"n_resamples": 999, "method": "percentile", "rng": 11}
CAUGHT = ("field_out", "sac_fly", "double_play", "field_error")
# Active share by type: quartiles of the pitchers of 2023 on Statcast's leaderboard of active spin
# (baseballsavant.mlb.com/leaderboard/active-spin), as github.com/auto-d/moneyball-ml has it. Its
# axes are seen by cameras, not inferred from the movement.
PUBLISHED = {
    "FF": (0.852, 0.914, 0.960), "SI": (0.813, 0.869, 0.929), "CH": (0.872, 0.938, 0.981),
    "FS": (0.779, 0.854, 0.926), "CU": (0.606, 0.728, 0.833), "ST": (0.429, 0.515, 0.590),
    "FC": (0.367, 0.449, 0.544), "SL": (0.260, 0.334, 0.416),
}  # fmt: skip


def run(report: Report, full: bool) -> str:
    """Predict the day that is shipped with every model, and tell how far off each is."""
    flies, pitches = measured_flies(), measured_pitches()
    launch = launched(flies)
    of_flies = fly_predictions(flies, launch)
    shares, held_out, spread = held_out_shares(pitches)
    sides = side_forces(pitches)
    of_pitches = pitch_predictions(pitches)
    of_pitches[HELD_OUT] = held_out
    with report.figure("reality_flies", rows=3, size=(6.4, 8.4)) as panels:
        for name, axes in zip(COMPARED, panels, strict=True):
            angle, off = np.degrees(flies.angle), of_flies[name].error[:, 0]
            axes.plot(angle, off, ".", markersize=3, color="0.6")
            means = [((a + b) / 2, off[which].mean()) for a, b, which in bands(angle, ANGLES)]
            axes.plot(*zip(*means, strict=True), "ko-", markersize=4)
            axes.axhline(0.0, color="black", linewidth=0.8)
            axes.set(title=name, ylabel="predicted too far by, m", ylim=(-45.0, 60.0))
        panels[-1].set_xlabel("angle of launch, °")
    with report.figure("reality_pitches", size=(6.4, 4.2)) as (axes,):
        draw_errors(axes, held_out)
    there = vars(scipy.stats) | vars(statcast) | vars(prediction) | globals()
    return report.render(
        "reality", there, flies=flies, launch=launch, pitches=pitches, of_flies=of_flies,
        of_pitches=of_pitches, shares=shares, spread=spread, sides=sides,
        day=pd.read_csv(EXAMPLE).iloc[flies.rows - 1], outs=outs(launch),
        single=measured_spin(pitches, NATHAN)["active_share"],
        best=best_constants(flies), scatters=scatter(flies), distance=flies.measured[:, 0],
    )  # fmt: skip


def measured_flies() -> MeasuredFlies:
    """Return the flies of the day that is shipped."""
    return cast(MeasuredFlies, read_measured(EXAMPLE, "batted"))


def measured_pitches() -> MeasuredPitches:
    """Return the pitches of the day that is shipped, all of them higher than they were.

    No model here depends on the height, and none of them loses a pitch to the ground.
    """
    pitches = cast(MeasuredPitches, read_measured(EXAMPLE, "pitch"))
    up = np.array([0.0, 0.0, 2.0])
    return replace(pitches, release=pitches.release + up, measured=pitches.measured + up[1:])


FULL_SPIN = "Nathan, backspin and side spin"
LAUNCHED = "the same, launched so that it comes down where it was fielded"
COMPARED = ("the paper", "constants fitted to the day", FULL_SPIN)


def fly_predictions(flies: MeasuredFlies, launch: MeasuredFlies) -> dict[str, Prediction]:
    """Predict the flies, and their launches as `launched` has them, by each model."""
    backspin = flies.spin(np.full(len(flies), 2000.0 * RPM), np.zeros(len(flies)))
    return {
        "no air": predict(flies, MODELS["vacuum"]),
        "the paper": predict(flies, MODELS["paper"]),
        "constants fitted to the day": predict(flies, MODELS["constants"]),
        "Giordano and Nakanishi": predict(flies, MODELS["giordano"]),
        "Nathan, 2,000 rpm of backspin for all": predict(flies, NATHAN, backspin),
        "Nathan, backspin by the angle": predict(flies, NATHAN, regression_spin(flies, False)),
        FULL_SPIN: predict(flies, NATHAN),
        LAUNCHED: predict(launch, NATHAN),
        "drag crisis fitted to the day": predict(flies, MODELS["crisis"]),
    }


def launched(flies: MeasuredFlies) -> MeasuredFlies:
    """Return the flies, launched so that they land at the bearings that were measured.

    Each turn takes off part of the difference: after 8 of them some 1e-4 rad are left.
    """
    launch = flies
    for _ in range(8):
        place = landings(launch, NATHAN)[0]
        reached = np.arctan2(-place[:, 1], place[:, 0])
        launch = replace(launch, bearing=launch.bearing + 0.6 * (flies.bearing - reached))
    return launch


def landings(flies: MeasuredFlies, model: FlightModel) -> tuple[Array, Array]:
    """Return position and velocity at landing, shape (n, 3) each."""
    flights: list[Any] = [*scenes(flies, model)]  # all of them are valid
    found: list[Any] = [result.landing for result in solve_each(flights, create("batch"))]
    assert all(found)
    return np.array([x.position for x in found]), np.array([x.velocity for x in found])


def best_constants(flies: MeasuredFlies) -> tuple[float, float]:
    """Return the constant C_D and C_L that bring the distances nearest to the measured ones."""

    def off(x: Array) -> Array:
        model = replace(MODELS["constants"], drag=float(x[0]), lift=float(x[1]))
        return predict(flies, model).error[:, 0]

    # Steps of 1e-3 move a landing by decimetres, far above rounding and far below the scatter.
    found = least_squares(off, (0.4, 0.1), diff_step=1e-3, xtol=1e-4)
    return float(found.x[0]), float(found.x[1])


def scatter(flies: MeasuredFlies) -> tuple[float, float]:
    """Return the scatter, m, that no function of speed and angle predicts, nor of bearing too.

    Polynomials of degree 4, fitted to all other balls and asked for the one left out.
    """
    pulled = flies.bearing * flies.side
    distance, found = flies.measured[:, 0], []
    for variables in ((flies.speed, flies.angle), (flies.speed, flies.angle, pulled)):
        scaled = np.array([(x - x.mean()) / x.std() for x in variables])
        powers = [p for p in np.ndindex(*([5] * len(scaled))) if sum(p) <= 4]
        columns = [np.prod(scaled.T ** np.array(p), axis=1) for p in powers]
        q, _ = np.linalg.qr(np.stack(columns, axis=1))
        found.append(float(rms((distance - q @ (q.T @ distance)) / (1.0 - np.sum(q**2, axis=1)))))
    return found[0], found[1]


def rms(x: Array, axis: int = -1) -> Array:
    """Return the root mean square."""
    return np.asarray(np.sqrt(np.mean(x**2, axis=axis)))


def outs(flies: MeasuredFlies) -> pd.DataFrame:
    """Fly each ball in its own park by Nathan's laws, and home runs in all parks.

    A row for each fly: whether it was a home run, and whether it is said to be one; how far from
    the top of the fence it passes, m, infinite if it does not get there; and in how many of all
    parks a home run is said to be one.
    """
    of_game = pd.read_csv(GAMES).set_index("game_pk").park
    was = pd.read_csv(EXAMPLE).events.iloc[flies.rows - 1].eq("home_run")
    rows = []
    for scene, game, was_out in zip(scenes(flies, NATHAN), flies.games, was, strict=True):
        own = park(of_game[game])
        found = {each.park: each for each in in_parks(scene, parks() if was_out else [own])}
        over = found[own].clearance
        near = np.inf if over is None else abs(over)
        rows.append((was_out, found[own].is_out, near, sum(x.is_out for x in found.values())))
    return pd.DataFrame(rows, columns=["was", "said", "near", "parks"])


HELD_OUT = "Nathan, the active share of its type, fitted to the other games"
FLOOR = "each pitch's own constant C_D, C_L and axis"


def pitch_predictions(pitches: MeasuredPitches) -> dict[str, Prediction]:
    """Predict the pitches by each model, with nothing fitted to other pitches."""
    whole = pitches.spin(np.ones(len(pitches)))
    across = replace(MODELS["paper"], spin=True)
    return {
        "no air": predict(pitches, MODELS["vacuum"]),
        "the paper": predict(pitches, MODELS["paper"]),
        "the paper, its lift across the measured axis": predict(pitches, across, whole),
        "Nathan, all of the spin active": predict(pitches, NATHAN, whole),
        FLOOR: own_constants(pitches),
    }


def own_constants(pitches: MeasuredPitches) -> Prediction:
    """Predict each pitch with the constants that its recorded acceleration means halfway.

    What is left is the difference between constant coefficients and a constant acceleration, and
    the rounding of the table: no model of flight can be told to be better than this.
    """
    speed = pitches.velocity[:, 0]
    halfway = -pitches.release[:, 0] / speed / 2.0
    v = pitches.velocity + pitches.acceleration * halfway[:, None]
    size = np.linalg.norm(v, axis=1, keepdims=True)
    push = pitches.acceleration - np.array([0.0, 0.0, -STANDARD_GRAVITY])
    along = np.sum(push * v, axis=1, keepdims=True) / size**2 * v
    across, ball = push - along, Ball()
    model = replace(MODELS["constants"], density=1.2, spin=True)
    k = 1.2 * np.pi * ball.radius**2 / (2.0 * ball.mass)
    sizes = (np.linalg.norm(x, axis=1) / (k * size[:, 0] ** 2) for x in (along, across))
    coefficients = zip(*(x.tolist() for x in sizes), strict=True)
    own = [replace(model, drag=c_d, lift=c_l) for c_d, c_l in coefficients]
    return predict(pitches, own, np.cross(v, across))


Shares = dict[str, Any]  # by type of pitch


def at_shares(pitches: MeasuredPitches) -> Array:
    """Predict the pitches at every share: a hundredth of an inch from those solved."""
    spins = (pitches.spin(np.full(len(pitches), share)) for share in SOLVED_SHARES)
    tried = [predict(pitches, NATHAN, spin).predicted for spin in spins]
    return np.asarray(CubicSpline(SOLVED_SHARES, np.array(tried))(SHARES))


def held_out_shares(pitches: MeasuredPitches) -> tuple[Shares, Prediction, Shares]:
    """Fit the active share of each type of pitch, and predict games that it was not fitted to.

    Returns the share of each type that fits all games best; the prediction of each game with the
    shares that fit the other ones best; and the range of those shares.
    """
    predicted = at_shares(pitches)
    squares: Any = pd.DataFrame(np.sum((predicted - pitches.measured) ** 2, axis=2).T)
    of_games = squares.groupby([pitches.labels, pitches.games]).sum()
    of_kinds = of_games.groupby(level=0)
    in_one = of_kinds[0].transform("size") == 1  # fitted to all pitches
    others = of_kinds.transform("sum") - of_games
    fitted = others.idxmin(axis=1).mask(in_one, squares.sum().idxmin())
    best = fitted.loc[pd.MultiIndex.from_arrays([pitches.labels, pitches.games])]
    found = Prediction(pitches, predicted[best, np.arange(len(best))], {}, 0)
    shares, ends = of_kinds.sum().idxmin(axis=1), fitted.groupby(level=0).agg(["min", "max"])
    return shares.map(SHARES.item).to_dict(), found, ends.map(SHARES.item).T.to_dict("list")


# --- a side force of each type --------------------------------------------------------------------

# C_S by which a place at the plate is said to move in proportion, and the active share there; the
# force that is fitted so is then solved as it is.
SMALL_SIDE, SHARE_OF_SIDE = 0.05, 0.5


@dataclass(frozen=True)
class Sides:
    """Each type's own side force: fitted to half of the games, tested on the other half.

    Both halves have both parts. Types that are not in both are left out.
    """

    pitches: MeasuredPitches
    fitted: Array  # to the other half: C_S to the arm side and up, shape (n, 2)
    # m, shape (n, 2): predicted with the active share of the other half, and with its force, too
    without: Array
    within: Array

    def rms(self, which: Any = slice(None)) -> tuple[float, float]:
        """Return the errors of some pitches without and with the force, m."""
        errors = ((x - self.pitches.measured)[which] for x in (self.without, self.within))
        without, within = (float(rms(np.linalg.norm(x, axis=1))) for x in errors)
        return without, within

    def coefficients(self, kind: str) -> Array:
        """Return C_S to the arm side and upwards, fitted to each half, shape (2, 2)."""
        return np.unique(self.fitted[self.pitches.labels == kind], axis=0)

    def gain(self, which: Any = slice(None)) -> float:
        """Return the reduction of the error of some pitches by the force, in."""
        without, within = self.rms(which)
        return (without - within) / statcast.INCH

    def by_game(self) -> Array:
        """Return the reduction of the error by the force for each game, in."""
        games = self.pitches.games
        return np.array([self.gain(games == game) for game in np.unique(games)])


def side_forces(pitches: MeasuredPitches) -> Sides:
    """Fit the active share of each type with and without a side force, and predict other games."""
    odd = np.isin(pitches.games, np.unique(pitches.games)[1::2])
    halves = [pitches.labels[half] for half in (odd, ~odd)]
    kept = np.isin(pitches.labels, np.intersect1d(*halves))
    pitches, odd = pitches.chosen(kept), odd[kept]
    off = at_shares(pitches) - pitches.measured
    # to the side of the pitcher's arm, and upwards
    sideways = np.outer(pitches.hand, [0.0, 1.0, 0.0])
    pushed = sideways, np.tile([0.0, 0.0, 1.0], (len(pitches), 1))
    spin = pitches.spin(np.full(len(pitches), SHARE_OF_SIDE))
    start = predict(pitches, NATHAN, spin).predicted
    slopes = np.stack(
        [
            (predict(pitches, sided(SMALL_SIDE, way), spin).predicted - start) / SMALL_SIDE
            for way in pushed
        ],
        axis=2,
    )  # m, shape (n, 2, 2): of the place by C_S either way
    fitted, share, plain = np.zeros((len(pitches), 2)), np.zeros(len(pitches)), np.array(start)
    for half in (odd, ~odd):
        for kind in np.unique(pitches.labels):
            own = pitches.labels == kind
            there, here = own & half, np.flatnonzero(own & ~half)
            squares = np.sum(off[:, there] ** 2, axis=(1, 2))
            plain[here] = off[np.argmin(squares), here] + pitches.measured[here]
            # Of each share the best force: the normal equations of places linear in C_S.
            matrix = np.einsum("nij,nik->jk", slopes[there], slopes[there])
            right = np.einsum("nij,sni->sj", slopes[there], off[:, there])
            forces = -np.linalg.solve(matrix, right.T).T
            best = np.argmin(squares + np.sum(right * forces, axis=1))
            fitted[here], share[here] = forces[best], SHARES[best]
    ways = fitted[:, :1] * pushed[0] + fitted[:, 1:] * pushed[1]
    models = sided(np.linalg.norm(fitted, axis=1), ways)
    within = predict(pitches, models, pitches.spin(share)).predicted
    return Sides(pitches, fitted, plain, within)


def sided(value: Any, ways: Array) -> list[FlightModel]:
    """Return Nathan's model with a side force of each pitch."""
    values = np.broadcast_to(value, len(ways)).tolist()
    return [
        replace(NATHAN, side={"value": size, "direction": way})
        for size, way in zip(values, ways.tolist(), strict=True)
    ]
