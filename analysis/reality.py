"""Measured baseball: what models of flight say of a day of measured pitches and batted balls."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares
from scipy.stats import bootstrap

from analysis.writing import figure, render
from longball.model.scene import Ball
from longball.pictures import draw_errors
from longball.pitches import EXAMPLE, prediction, statcast
from longball.pitches.models import MODELS, STANDARD_GRAVITY, FlightModel, regression_spin
from longball.pitches.prediction import ANGLES, Prediction, bands, predict, solve
from longball.pitches.statcast import RPM, MeasuredFlies, MeasuredPitches, read_measured
from longball.pitches.table import Floats as Array

NATHAN = MODELS["nathan"]
ONE_SPIN = 2000.0 * RPM  # rad/s, where every batted ball is given the same backspin
# Shares of active spin that are tried, and those of them that are solved: places at the plate are
# smooth in between. Spin all along the velocity would be a singular point of its direction.
SHARES, SOLVED_SHARES = np.linspace(0.05, 1.0, 951), np.linspace(0.05, 1.0, 7)
REPLICATES, SEED = 999, 11
CATCH = 1.5  # m, a height at which flies are caught
CAUGHT = ("field_out", "sac_fly", "double_play", "field_error")


def run(report: Path, full: bool) -> str:
    """Predict the day that is shipped with every model, and tell how far off each is."""
    flies, pitches = measured_flies(), measured_pitches()
    launch = launched(flies)
    of_flies = fly_predictions(flies, launch)
    shares, held_out, spread = held_out_shares(pitches)
    of_pitches = pitch_predictions(pitches)
    of_pitches[HELD_OUT] = held_out
    draw_flies(report, flies, of_flies)
    with figure(report, "reality_pitches", size=(5.6, 4.2)) as (axes,):
        draw_errors(axes, held_out)
    return render(
        report, "reality", vars(statcast) | vars(prediction) | globals(),
        flies=flies, launch=launch, pitches=pitches, of_flies=of_flies, of_pitches=of_pitches,
        shares=shares, spread=spread, day=pd.read_csv(EXAMPLE).iloc[flies.rows - 1],
        best=best_constants(flies), scatters=scatter(flies), distance=flies.measured[:, 0],
    )  # fmt: skip


def too_far(prediction: Prediction) -> Array:
    """Return by how much flies are predicted to go too far, ft."""
    return prediction.error[:, 0] / statcast.FOOT


def left_out(pitches: MeasuredPitches, word: str) -> int:
    """Return how many pitches are left out for a reason."""
    return next(omission.count for omission in pitches.left_out if word in omission.reason)


def measured_flies() -> MeasuredFlies:
    """Return the flies of the day that is shipped."""
    flies = read_measured(EXAMPLE, "batted")
    assert isinstance(flies, MeasuredFlies)
    return flies


def measured_pitches() -> MeasuredPitches:
    """Return the pitches of the day that is shipped, all of them higher than they were.

    No model here depends on the height, and none of them loses a pitch to the ground.
    """
    pitches = read_measured(EXAMPLE, "pitch")
    assert isinstance(pitches, MeasuredPitches)
    up = np.array([0.0, 0.0, 2.0])
    return replace(pitches, release=pitches.release + up, measured=pitches.measured + up[1:])


# --- batted balls ---------------------------------------------------------------------------------

FULL_SPIN = "Nathan, backspin and side spin"
LAUNCHED = "the same, launched so that it comes down where it was fielded"
COMPARED = ("the paper", "best constants", FULL_SPIN)


def fly_predictions(flies: MeasuredFlies, launch: MeasuredFlies) -> dict[str, Prediction]:
    """Return what each model says of the flies, and of their launches as `launched` has them."""
    backspin = flies.spin(np.full(len(flies), ONE_SPIN), np.zeros(len(flies)))
    by_angle = regression_spin(flies, side_spin=False)
    return {
        "no air": predict(flies, MODELS["vacuum"]),
        "the paper": predict(flies, MODELS["paper"]),
        "best constants": predict(flies, MODELS["constants"]),
        "Giordano and Nakanishi": predict(flies, MODELS["giordano"]),
        "Nathan, 2,000 rpm of backspin for all": predict(flies, NATHAN, backspin),
        "Nathan, backspin by the angle": predict(flies, NATHAN, by_angle),
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
    found = [result.landing for result in solve(flies, model)]
    assert all(found)
    return (
        np.array([x.position for x in found if x], dtype=np.float64),
        np.array([x.velocity for x in found if x], dtype=np.float64),
    )


def catch_shift(flies: MeasuredFlies) -> Array:
    """Return how much sooner than on the ground a ball comes down to where it is caught, m."""
    _, velocity = landings(flies, NATHAN)
    return CATCH * np.hypot(velocity[:, 0], velocity[:, 1]) / -velocity[:, 2]


def best_constants(flies: MeasuredFlies) -> tuple[float, float]:
    """Return the constant C_D and C_L that bring the distances nearest to the measured ones."""

    def off(x: Array) -> Array:
        model = replace(MODELS["constants"], drag=float(x[0]), lift=float(x[1]))
        return predict(flies, model).error[:, 0]

    # Steps of 1e-3 move a landing by decimetres, far above rounding and far below the scatter.
    found = least_squares(off, (0.4, 0.1), diff_step=1e-3, xtol=1e-4)
    return float(found.x[0]), float(found.x[1])


def scatter(flies: MeasuredFlies) -> tuple[float, float]:
    """Return what no function of speed and angle can predict, and none of the bearing too, m.

    Polynomials of degree 4, fitted to all other balls and asked for the one left out.
    """
    pulled = flies.bearing * flies.side
    found = []
    for variables in ((flies.speed, flies.angle), (flies.speed, flies.angle, pulled)):
        columns = [np.ones(len(flies))]
        scaled = [(x - x.mean()) / x.std() for x in variables]
        for powers in np.ndindex(*([5] * len(scaled))):
            if 0 < sum(powers) <= 4:
                columns.append(np.prod([x**p for x, p in zip(scaled, powers, strict=True)], axis=0))
        q, _ = np.linalg.qr(np.stack(columns, axis=1))
        distance = flies.measured[:, 0]
        found.append(float(rms((distance - q @ (q.T @ distance)) / (1.0 - np.sum(q**2, axis=1)))))
    return found[0], found[1]


def mean_spin(flies: MeasuredFlies) -> float:
    """Return the mean size of the spins that the regression expects, rpm."""
    return float(np.linalg.norm(regression_spin(flies), axis=1).mean() / RPM)


def rms(x: Array, axis: int = -1) -> Array:
    """Return the root mean square."""
    return np.asarray(np.sqrt(np.mean(x**2, axis=axis)))


def rms_interval(off: Array) -> Any:
    """Return the 95 % interval of an RMS by a bootstrap."""
    drawn = bootstrap((off,), rms, n_resamples=REPLICATES, method="percentile", rng=SEED)
    return drawn.confidence_interval


def draw_flies(report: Path, flies: MeasuredFlies, predictions: dict[str, Prediction]) -> None:
    """Draw the errors of three models by the angle of launch."""
    with figure(report, "reality_flies", columns=3, size=(9.0, 3.4)) as axes:
        for name, one in zip(COMPARED, axes, strict=True):
            angle, off = np.degrees(flies.angle), predictions[name].error[:, 0]
            one.plot(angle, off, ".", markersize=3, color="0.6")
            means = [((a + b) / 2, off[which].mean()) for a, b, which in bands(angle, ANGLES)]
            one.plot(*zip(*means, strict=True), "ko-", markersize=4)
            one.axhline(0.0, color="black", linewidth=0.8)
            one.set(title=name, xlabel="angle of launch, °", ylim=(-45.0, 60.0))
        axes[0].set_ylabel("predicted too far by, m")


# --- pitches --------------------------------------------------------------------------------------

HELD_OUT = "Nathan, the active share of its type, fitted to the other games"
FLOOR = "each pitch's own constant C_D, C_L and axis"


def pitch_predictions(pitches: MeasuredPitches) -> dict[str, Prediction]:
    """Return what each model says of the pitches, with nothing fitted to other pitches."""
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
    across = push - along
    density, ball, model = 1.2, Ball(), MODELS["constants"]
    k = density * np.pi * ball.radius**2 / (2.0 * ball.mass)
    drag = np.linalg.norm(along, axis=1) / (k * size[:, 0] ** 2)
    lift = np.linalg.norm(across, axis=1) / (k * size[:, 0] ** 2)
    own = [
        replace(model, drag=c_d, lift=c_l, density=density, spin=True)
        for c_d, c_l in zip(drag.tolist(), lift.tolist(), strict=True)
    ]
    return predict(pitches, own, np.cross(v, across))


def held_out_shares(
    pitches: MeasuredPitches,
) -> tuple[dict[str, float], Prediction, dict[str, tuple[float, float]]]:
    """Fit the active share of each type of pitch, and predict games that it was not fitted to.

    Returns the share of each type that fits all games best; the prediction of each game with the
    shares that fit the other ones best; and the range of those shares.
    """
    tried = [
        predict(pitches, NATHAN, pitches.spin(np.full(len(pitches), share))).predicted
        for share in SOLVED_SHARES
    ]
    # Predictions at every share: a hundredth of an inch from those solved.
    predicted = CubicSpline(SOLVED_SHARES, np.array(tried))(SHARES)
    squares = np.sum((predicted - pitches.measured) ** 2, axis=2)
    usual = int(np.argmin(squares.sum(axis=1)))
    shares, spread = {}, {}
    found = np.empty(pitches.measured.shape)
    for kind in np.unique(pitches.labels):
        of_kind = pitches.labels == kind
        here = {game: of_kind & (pitches.games == game) for game in set(pitches.games[of_kind])}
        sums = {game: squares[:, which].sum(axis=1) for game, which in here.items()}
        total = np.sum(list(sums.values()), axis=0)
        shares[str(kind)] = float(SHARES[np.argmin(total)])
        fitted = [int(np.argmin(total - own)) if len(sums) > 1 else usual for own in sums.values()]
        for which, best in zip(here.values(), fitted, strict=True):
            found[which] = predicted[best, which]
        spread[str(kind)] = float(SHARES[min(fitted)]), float(SHARES[max(fitted)])
    return shares, Prediction(pitches, found, {}, 0), spread
