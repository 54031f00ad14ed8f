"""Measured baseball: what models of flight say of a day of measured pitches and batted balls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares
from scipy.stats import bootstrap

from analysis.writing import figure, render, shown, table
from longball.model.scene import Ball
from longball.pictures import draw_errors
from longball.pitches import EXAMPLE
from longball.pitches.models import MODELS, STANDARD_GRAVITY, FlightModel, regression_spin
from longball.pitches.prediction import (
    ANGLES,
    INCH,
    Prediction,
    bands,
    predict,
    solve,
    summaries,
)
from longball.pitches.statcast import FOOT, RPM, MeasuredFlies, MeasuredPitches, read_measured
from longball.pitches.table import Booleans
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
    of_pitches = pitch_predictions(pitches) | {
        "Nathan, the active share of its type, fitted to the other games": held_out
    }
    nathan = of_flies["Nathan, backspin and side spin"]
    events = pd.read_csv(EXAMPLE)["events"].to_numpy()[flies.rows - 1]
    draw_flies(report, flies, of_flies)
    with figure(report, "reality_pitches", size=(5.6, 4.2)) as (axes,):
        draw_errors(axes, held_out)
    best = best_constants(flies)
    by_place, by_place_and_bearing = scatter(flies)
    caught = np.isin(events, CAUGHT)
    return render(
        report,
        "reality",
        n_flies=len(flies),
        n_pitches=len(pitches),
        rows_read=pitches.rows_read,
        bounced=next(x.count for x in pitches.left_out if "bounced" in x.reason),
        spinless=next(x.count for x in pitches.left_out if "spin" in x.reason),
        flies=table(report, "reality_flies", fly_table(of_flies)),
        flies_figure=shown("reality_flies", FLIES_CAPTION),
        angles=table(report, "reality_angles", angle_table(flies, of_flies)),
        events=table(report, "reality_events", event_table(nathan, events)),
        pitches=table(report, "reality_pitches", pitch_table(of_pitches)),
        types=table(report, "reality_types", type_table(pitches, held_out, shares, spread)),
        pitches_figure=shown("reality_pitches", PITCHES_CAPTION),
        paper=error(of_flies["the paper"]) / FOOT,
        nathan=error(nathan) / FOOT,
        launched=error(of_flies[LAUNCHED]) / FOOT,
        mean_spin=mean_rate(regression_spin(flies)),
        launched_spin=mean_rate(regression_spin(launch)),
        turned=turned(launch, flies),
        held_out=error(held_out) / INCH,
        paper_pitches=error(of_pitches["the paper"]) / INCH,
        floor=error(of_pitches[FLOOR]) / INCH,
        best=best,
        by_place=by_place / FOOT,
        by_place_and_bearing=by_place_and_bearing / FOOT,
        drawn=drawn_correlation(flies, caught),
        not_drawn=drawn_correlation(flies, events == "single"),
        caught_bias=nathan.error[caught].mean() / FOOT,
        catch=catch_shift(flies)[caught].mean() / FOOT,
    )


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


def error(prediction: Prediction) -> float:
    """Return the root mean square of the length of the error, m."""
    return summaries(prediction)[-1].rms


# --- batted balls ---------------------------------------------------------------------------------

COMPARED = ("the paper", "best constants", "Nathan, backspin and side spin")
LAUNCHED = "the same, launched so that it comes down where it was fielded"


def fly_predictions(flies: MeasuredFlies, launch: MeasuredFlies) -> dict[str, Prediction]:
    """Return what each model says of the flies, and of their launches as `launched` has them."""
    none = np.zeros(len(flies))
    backspin = flies.spin(np.full(len(flies), ONE_SPIN), none)
    return {
        "no air": predict(flies, MODELS["vacuum"]),
        "the paper": predict(flies, MODELS["paper"]),
        "best constants": predict(flies, MODELS["constants"]),
        "Giordano and Nakanishi": predict(flies, MODELS["giordano"]),
        "Nathan, 2,000 rpm of backspin for all": predict(flies, NATHAN, backspin),
        "Nathan, backspin by the angle": predict(
            flies, NATHAN, regression_spin(flies, side_spin=False)
        ),
        "Nathan, backspin and side spin": predict(flies, NATHAN),
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
        residual = (distance - q @ (q.T @ distance)) / (1.0 - np.sum(q**2, axis=1))
        found.append(float(np.sqrt(np.mean(residual**2))))
    return found[0], found[1]


def drawn_correlation(flies: MeasuredFlies, which: Booleans) -> float:
    """Return the correlation of the distance and of where the drawing has the fielder."""
    raw = pd.read_csv(EXAMPLE).iloc[flies.rows[which] - 1]
    drawn = np.hypot(raw["hc_x"] - 125.42, 198.27 - raw["hc_y"])
    return float(np.corrcoef(flies.measured[which, 0], drawn)[0, 1])


def mean_rate(spin: Array) -> float:
    """Return the mean size of spins, rpm."""
    return float(np.linalg.norm(spin, axis=1).mean() / RPM)


def turned(launch: MeasuredFlies, flies: MeasuredFlies) -> float:
    """Return how far balls turn from their launch, on the average of sizes, degrees."""
    return float(np.degrees(np.abs(launch.bearing - flies.bearing)).mean())


def fly_table(predictions: Mapping[str, Prediction]) -> pd.DataFrame:
    """Return bias and RMS of the distance by model, with an interval of the RMS."""

    def rms(x: Array, axis: int = -1) -> Array:
        return np.asarray(np.sqrt(np.mean(x**2, axis=axis)))

    rows = []
    for name, prediction in predictions.items():
        off = prediction.error[prediction.solved, 0] / FOOT
        interval = bootstrap(
            (off,), rms, n_resamples=REPLICATES, method="percentile", rng=SEED
        ).confidence_interval
        rows.append(
            {
                "model": name,
                "bias, ft": f"{off.mean():+.1f}",
                "RMS, ft": f"{rms(off):.1f}",
                "95 % of it": f"{interval.low:.1f} to {interval.high:.1f}",
                "RMS, m": f"{rms(off) * FOOT:.2f}",
            }
        )
    return pd.DataFrame(rows)


def angle_table(flies: MeasuredFlies, predictions: Mapping[str, Prediction]) -> pd.DataFrame:
    """Return the bias by the angle of launch."""
    chosen = {name: predictions[name] for name in COMPARED}
    rows = []
    for low, high, which in bands(np.degrees(flies.angle), ANGLES):
        rows.append(
            {"angle": f"{low}° to {high}°", "n": int(which.sum())}
            | {
                f"{name}: bias, ft": f"{x.error[which, 0].mean() / FOOT:+.1f}"
                for name, x in chosen.items()
            }
        )
    return pd.DataFrame(rows)


def event_table(prediction: Prediction, events: NDArray[Any]) -> pd.DataFrame:
    """Return bias and RMS by what came of the ball."""
    groups = {
        "caught or dropped": CAUGHT,
        "single": ("single",),
        "double or triple": ("double", "triple"),
        "home run": ("home_run",),
    }
    rows = []
    for name, kinds in groups.items():
        off = prediction.error[np.isin(events, kinds), 0] / FOOT
        rms = np.sqrt(np.mean(off**2))
        rows.append(
            {"ball": name, "n": len(off), "bias, ft": f"{off.mean():+.1f}", "RMS, ft": f"{rms:.1f}"}
        )
    return pd.DataFrame(rows)


FLIES_CAPTION = (
    "Predicted minus measured distance by the angle of launch, a point for each ball, and the mean "
    "of each group of angles."
)


def draw_flies(report: Path, flies: MeasuredFlies, predictions: Mapping[str, Prediction]) -> None:
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

FLOOR = "each pitch's own constant C_D, C_L and axis"


def pitch_predictions(pitches: MeasuredPitches) -> dict[str, Prediction]:
    """Return what each model says of the pitches, with nothing fitted to other pitches."""
    whole = pitches.spin(np.ones(len(pitches)))
    paper = MODELS["paper"]
    return {
        "no air": predict(pitches, MODELS["vacuum"]),
        "the paper": predict(pitches, paper),
        "the paper, its lift across the measured axis": predict(
            pitches, replace(paper, spin=True), whole
        ),
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

    Returns
    -------
    tuple
        The share of each type that fits all games best; the prediction of each game with the
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


def pitch_table(predictions: Mapping[str, Prediction]) -> pd.DataFrame:
    """Return bias and RMS at the plate by model."""
    rows = []
    for name, prediction in predictions.items():
        every = summaries(prediction)[-1]
        rows.append(
            {
                "model": name,
                "n": every.count,
                "to the right, in": f"{-every.bias[0] / INCH:+.2f}",
                "up, in": f"{every.bias[1] / INCH:+.2f}",
                "RMS, in": f"{every.rms / INCH:.2f}",
                "RMS, cm": f"{100 * every.rms:.2f}",
            }
        )
    return pd.DataFrame(rows)


def type_table(
    pitches: MeasuredPitches,
    prediction: Prediction,
    shares: Mapping[str, float],
    spread: Mapping[str, tuple[float, float]],
) -> pd.DataFrame:
    """Return the active share by type of pitch, and how well games held out are predicted."""
    rows = []
    for each in summaries(prediction)[:-1]:
        low, high = spread[each.group]
        rows.append(
            {
                "type": each.group,
                "n": each.count,
                "games": len(np.unique(pitches.games[pitches.labels == each.group])),
                "active share": f"{shares[each.group]:.3f}",
                "one game left out": f"{low:.3f} to {high:.3f}",
                "to the right, in": f"{-each.bias[0] / INCH:+.2f}",
                "up, in": f"{each.bias[1] / INCH:+.2f}",
                "RMS, in": f"{each.rms / INCH:.2f}",
            }
        )
    return pd.DataFrame(rows)


PITCHES_CAPTION = (
    "Predicted minus measured place at the plate, games held out, as a catcher sees it: every "
    "pitch, and the mean of each type with a standard deviation either way."
)
