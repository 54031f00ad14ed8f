"""Predictions of measured balls, compared with the measurements."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise, repeat
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from longball import engines
from longball.engines import chain
from longball.engines.engine import Engine
from longball.extras import naming_extras
from longball.model.arrays import Array, Flags
from longball.model.changes import Changes
from longball.model.result import Result
from longball.model.scene import InvalidScene, Scene, refused, scene_of
from longball.pitches.models import FlightModel, expected_spin, model_of
from longball.pitches.statcast import (
    GAMES,
    MPH,
    Kind,
    MeasuredFlies,
    MeasuredPitches,
    read_measured,
)
from longball.pitches.table import unit_that_explains

if TYPE_CHECKING:
    import pandas as pd

Measured = MeasuredPitches | MeasuredFlies

# Bounds of the groups of flies in the summary, degrees and mph.
ANGLES = (10, 20, 25, 30, 35, 40, 60)
SPEEDS = (60, 80, 90, 95, 100, 105, 125)

_ROWS_SHOWN = 20  # predictions that are printed if no distance was measured


@dataclass(frozen=True)
class Prediction:
    """Predictions of a model for measured balls."""

    measured: Measured
    # Like ``measured.measured``, m: y and z at the plate, shape (n, 2), or the distance, (n, 1).
    # NaN if the ball does not reach the plate or the ground.
    predicted: Array
    without: Mapping[str, int]  # reasons for rows without a prediction, with their numbers
    failed: int  # number of those rows that the engine could not solve

    @property
    def error(self) -> Array:
        """Predicted minus measured, m."""
        return self.predicted - self.measured.measured

    @property
    def solved(self) -> Flags:
        """True for rows with a prediction, shape (n,)."""
        return ~np.isnan(self.predicted[:, 0])

    @property
    def compared(self) -> Flags:
        """True for rows with a prediction and a measurement, shape (n,)."""
        return ~np.isnan(self.error[:, 0])


@dataclass(frozen=True)
class Summary:
    """Errors of a group of balls."""

    group: str
    count: int
    bias: tuple[float, ...]  # mean error of each component, m
    rms: float  # root mean square of the length of the error, m


def scenes(
    measured: Measured,
    model: FlightModel | Sequence[FlightModel],
    spin: Array | None = None,
    change: Changes | None = None,
) -> Iterator[Scene | InvalidScene]:
    """Yield the scene of each measured ball, with one model for all, or one for each.

    `spin`, rad/s, shape (n, 3), is by default `expected_spin`; models without spin ignore it.
    `change` is applied to every scene. For an invalid row, such as a release below the ground, an
    `InvalidScene` that names the row is yielded.
    """
    spin = expected_spin(measured) if spin is None else spin
    models = repeat(model) if isinstance(model, FlightModel) else model
    for i, (row, one) in enumerate(zip(measured.rows.tolist(), models, strict=False)):
        scene = {"id": measured.name(i)} | measured.scene(i)
        if one.spin:
            scene["pitch" if "pitch" in scene else "launch"]["spin"] = spin[i].tolist()
        weather = float(measured.temperature[i]), float(measured.elevation[i])
        try:
            whole = scene | one.blocks(*weather)
            yield scene_of(change(whole) if change else whole)
        except InvalidScene as error:
            yield InvalidScene(f"row {row} below the header is no scene: {error}", scene["id"])


def predict(
    measured: Measured,
    model: FlightModel | Sequence[FlightModel],
    spin: Array | None = None,
    engine: Engine | None = None,
    change: Changes | None = None,
) -> Prediction:
    """Predict measured balls, by default with the batch engine; see `scenes`."""
    # Invalid rows keep their places among the results: these are matched to the rows by position.
    every = list(scenes(measured, model, spin, change))
    valid = [scene for scene in every if not isinstance(scene, InvalidScene)]
    solved = iter(chain.solve_each(valid, engine or engines.create("batch")))
    results = [refused(one) if isinstance(one, InvalidScene) else next(solved) for one in every]
    predicted = np.full(measured.measured.shape, np.nan)
    without: Counter[str] = Counter()
    for i, result in enumerate(results):
        place = _place(result)
        if place is None:
            without[result.error or f"the ball is {result.outcome}"] += 1
        else:
            predicted[i] = place
    return Prediction(measured, predicted, without, sum(r.error is not None for r in results))


def joined(measured: Measured, parts: Sequence[Prediction]) -> Prediction:
    """Return the prediction for measured balls from those for its parts, in order."""
    predicted = np.concatenate([part.predicted for part in parts])
    without = sum((Counter(part.without) for part in parts), Counter[str]())
    return Prediction(measured, predicted, without, sum(part.failed for part in parts))


def measured(
    table: str | Path | pd.DataFrame,
    kind: Kind = "pitch",
    model: str = "nathan",
    *,
    games: str | Path | pd.DataFrame | None = None,
    names: Mapping[str, str] | None = None,
    engine: str | Engine = "batch",
) -> pd.DataFrame:
    """Predict measured pitches or batted balls, each in the weather of its game.

    Parameters
    ----------
    table
        Rows in Statcast's columns and units: a file, CSV or Parquet, or a DataFrame.
    kind
        ``"pitch"``: from the release to the front of the plate; ``"batted"``: to the landing.
    model
        Model of flight: ``"nathan"``, ``"paper"``, … (``longball measured --help``).
    games
        ``game_pk``, ``temperature`` (°F), and ``elevation`` (ft) or ``park`` of each game; by
        default those of the example. Other games are played at 20 °C at sea level.
    names
        The table's own names of Statcast's columns, such as ``{"vx0": "VX0"}``.
    engine
        As `longball.solve` takes it.

    Returns
    -------
    pandas.DataFrame
        A row for each usable ball, with its row number in the table as ``row`` and the columns that
        identify it, such as ``game_pk`` and ``player_name``: measured and predicted values, in SI
        units and the frame of scenes; NaN if the ball does not arrive.

    Raises
    ------
    ValueError
        If a column is missing or in another unit, no row is usable, or the model does not exist.

    Warns
    -----
    UserWarning
        If numbers seem to be in another unit.

    Examples
    --------
    >>> import longball as lb
    >>> import pandas as pd
    >>> flies = pd.DataFrame({"launch_speed": [103.0], "launch_angle": [28.0]})
    >>> lb.measured(flies, "batted").predicted_distance.round(2).tolist()
    [128.33]
    """
    law = model_of(model)
    given = GAMES if games is None else games
    rows = read_measured(table, kind, given, spin=law.spin, names=names)
    solver = engines.create(engine) if isinstance(engine, str) else engine
    prediction = predict(rows, law, engine=solver)
    for question in questions(prediction):
        warnings.warn(question, stacklevel=2)
    return as_frame(prediction)


def questions(prediction: Prediction) -> Iterator[str]:
    """Yield a question for each column that seems to be in another unit."""
    yield from prediction.measured.doubts
    if isinstance(prediction.measured, MeasuredFlies) and prediction.compared.any():
        # Without the wind of the game, single distances are wrong by a tenth; their median is
        # right.
        share = float(np.nanmedian(prediction.measured.measured / prediction.predicted))
        if unit := unit_that_explains(share, "ft"):
            yield (
                f"hit_distance_sc: {share:.2g} times the prediction; is it in {unit} instead of ft?"
            )


def _place(result: Result) -> tuple[float, ...] | None:
    """Return y and z at the plate of a pitch, and the distance of a batted ball."""
    if result.outcome == "crossed" and result.plate is not None:
        return float(result.plate.position[1]), float(result.plate.position[2])
    # A ball stopped by a fence has no distance; a home run has one.
    if result.outcome in ("landed", "home_run") and result.landing is not None:
        return (float(result.landing.distance),)
    return None


def summaries(prediction: Prediction) -> list[Summary]:
    """Return the errors of groups: pitches by type, flies by angle and by speed; all are last."""
    rows = []
    for name, which in (*_groups(prediction.measured), ("all", prediction.compared)):
        error = prediction.error[which & prediction.compared]
        if len(error):
            # Of the length of the error, so that one number covers both components of a pitch.
            rms = float(np.sqrt(np.mean(np.sum(error**2, axis=1))))
            rows.append(Summary(name, len(error), tuple(error.mean(axis=0).tolist()), rms))
    return rows


def _groups(measured: Measured) -> Iterator[tuple[str, Flags]]:
    if isinstance(measured, MeasuredPitches):
        kinds, counts = np.unique(measured.labels, return_counts=True)
        for kind in kinds[np.argsort(-counts, kind="stable")]:
            yield str(kind), measured.labels == kind
        return
    for low, high, which in bands(np.degrees(measured.angle), ANGLES):
        yield f"angle {low} to {high}°", which
    for low, high, which in bands(measured.speed / MPH, SPEEDS):
        yield f"speed {low} to {high} mph", which


def bands(values: Array, bounds: Sequence[int]) -> Iterator[tuple[int, int, Flags]]:
    """Yield the bounds of each band, and flags of its values; the last band includes its end."""
    # Values were whole numbers or tenths before a change of unit and back. Rounding them again
    # keeps a value on its side of a bound.
    rounded = np.round(values, 6)
    for low, high in pairwise(bounds):
        below = rounded <= high if high == bounds[-1] else rounded < high
        yield low, high, (rounded >= low) & below


@naming_extras()
def as_frame(prediction: Prediction) -> pd.DataFrame:
    """Return a row for each ball, in SI units and the frame of scenes."""
    import pandas as pd

    measured = prediction.measured
    columns: dict[str, Any] = {"row": measured.rows}
    columns |= dict(zip(measured.identified, measured.identity.T, strict=True))
    if isinstance(measured, MeasuredPitches):
        columns |= {"pitch_type": measured.labels, "spin_rate": measured.spin_rate}
    else:
        columns |= {"speed": measured.speed, "angle": measured.angle, "bearing": measured.bearing}
    # The weather is part of the prediction, and other models need it for a comparison.
    columns |= {"temperature": measured.temperature, "elevation": measured.elevation}
    for what, values in (("measured", measured.measured), ("predicted", prediction.predicted)):
        columns |= {f"{what}_{name}": values[:, i] for i, name in enumerate(measured.components)}
    return pd.DataFrame(columns)


def as_data(prediction: Prediction) -> dict[str, Any]:
    """Return the summaries as plain data, in SI units and the frame of scenes."""
    measured = prediction.measured
    return {
        "source": measured.source,
        "rows_read": measured.rows_read,
        "rows_used": len(measured),
        "left_out": [each.model_dump() for each in measured.left_out],
        "without_prediction": dict(prediction.without),
        "assumed": list(measured.assumed),
        "components": list(measured.components),
        "groups": [asdict(each) for each in summaries(prediction)],
    }


def as_text(prediction: Prediction, name: str, model: FlightModel) -> str:
    """Return the prediction as text, in the units of the measurements."""
    return "\n".join(_lines(prediction, name, model)) + "\n"


def _lines(prediction: Prediction, name: str, model: FlightModel) -> Iterator[str]:
    measured = prediction.measured
    yield f"{measured.source}: {len(measured)} {measured.what} used of {measured.rows_read} rows"
    yield from (f"  {each}" for each in measured.left_out)
    # Rows that the engine could not solve, and balls that stop before the plate or at a fence.
    yield from (f"  no prediction: {n}, {why}" for why, n in prediction.without.items())
    if measured.weather_unknown:
        yield f"  weather not known: {measured.weather_unknown}; taken as 20 °C at sea level"
    yield from (f"  {each}" for each in measured.assumed)
    yield f"model {name}: {model.source}"
    yield ""
    unit, label = measured.unit
    # A table with speed and angle alone has nothing to compare: print the predictions themselves.
    if isinstance(measured, MeasuredFlies) and not prediction.compared.any():
        yield _row("", "mph", "launch, °", f"distance, {label}")
        for i in np.flatnonzero(prediction.solved)[:_ROWS_SHOWN]:
            asked = measured.speed[i] / MPH, np.degrees(measured.angle[i])
            values = *asked, prediction.predicted[i, 0] / unit
            yield _row(f"row {measured.rows[i]}", *(f"{value:.1f}" for value in values))
        if (more := int(prediction.solved.sum()) - _ROWS_SHOWN) > 0:
            yield f"and {more} more"
        return
    yield _row("", "n", *(f"{name}, {label}" for name, _ in measured.seen), f"RMS, {label}")
    for each in summaries(prediction):
        biases = zip(each.bias, measured.seen, strict=True)
        means = (f"{sign * bias / unit:+.2f}" for bias, (_, sign) in biases)
        yield _row(each.group, str(each.count), *means, f"{each.rms / unit:.2f}")


def _row(group: str, *values: str) -> str:
    return f"{group:20}" + "".join(f" {value:>11}" for value in values)
