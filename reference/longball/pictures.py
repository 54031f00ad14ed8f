"""Pictures, drawn the same way by the command line and by the report."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from longball.home_run import PAPER_CURVES, Estimate, Fit, Integral
from longball.pitches.prediction import Prediction
from longball.pitches.statcast import MeasuredPitches

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MARKERS = "osD^v<>ph8*"


def draw_probability(
    axes: Axes, estimates: Sequence[Estimate] | Sequence[Integral], fit: Fit | None
) -> None:
    """Draw estimates with their intervals, the fit, and the paper's two printed curves (Fig. 7).

    Told apart by marker and dash, so that a print in black and white shows the same.
    """
    e = [row.e for row in estimates]
    low, high = min(e), max(e)
    # A single restitution still gets a picture, as wide as one step of the paper's.
    pad = 0.05 * (high - low) or 0.01
    grid = [low - pad + (high - low + 2 * pad) * i / 200 for i in range(201)]
    for (name, curve), dash in zip(PAPER_CURVES.items(), ("--", ":"), strict=True):
        axes.plot(
            grid,
            [curve(x) for x in grid],
            dash,
            color="0.45",
            label=f"paper's {name}: C₁ = {curve.c1:g} m, σ = {curve.sigma:g} m",
        )
    if fit:
        label = f"fit: C₁ = {fit.curve.c1:.0f} m, σ = {fit.curve.sigma:.1f} m"
        axes.plot(grid, [fit.curve(x) for x in grid], "-", color="C0", label=label)
    first = estimates[0]
    label = "longball, quadrature"
    if isinstance(first, Estimate):
        label = f"longball, 95 % of {first.trials} at-bats"
    axes.errorbar(
        e,
        [row.p for row in estimates],
        yerr=[
            [row.p - row.low for row in estimates],
            [row.high - row.p for row in estimates],
        ],
        fmt="ko",
        markersize=4,
        capsize=3,
        label=label,
    )
    axes.set_xlabel("coefficient of restitution e of the ball")
    axes.set_ylabel("probability of a home run P(e)")
    axes.set_ylim(bottom=0.0)
    axes.legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.01), ncols=2, fontsize="small", frameon=False
    )


def draw_errors(axes: Axes, prediction: Prediction) -> None:
    """Draw the errors of predicted balls: pitches at the plate, flies by their angle of launch."""
    measured, solved, error = prediction.measured, prediction.solved, prediction.error
    if isinstance(measured, MeasuredPitches):
        kinds, counts = np.unique(measured.labels[solved], return_counts=True)
        for i, kind in enumerate(kinds[np.argsort(-counts)]):
            right, up = 100.0 * error[solved & (measured.labels == kind)].T * [[-1.0], [1.0]]
            axes.plot(right, up, MARKERS[i % len(MARKERS)], markersize=2, alpha=0.4, label=kind)
        axes.plot(0.0, 0.0, "k+", markersize=12)
        axes.set(
            xlabel="too far to the catcher's right, cm",
            ylabel="too high, cm",
            aspect="equal",
        )
        axes.legend(markerscale=3, fontsize="small", frameon=False, bbox_to_anchor=(1.0, 1.0))
    else:
        angle = np.degrees(measured.angle[solved])
        axes.plot(angle, error[solved, 0], "o", markersize=3, alpha=0.6)
        axes.axhline(0.0, color="black", linewidth=0.8)
        axes.set(xlabel="angle of launch, °", ylabel="predicted too far by, m")


def save_prediction(path: Path, prediction: Prediction) -> None:
    """Write the picture of a prediction's errors, in the format that the file's ending names."""
    with _saved(path, (5.6, 4.2)) as axes:
        draw_errors(axes, prediction)


def save_probability(
    path: Path, estimates: Sequence[Estimate] | Sequence[Integral], fit: Fit | None
) -> None:
    """Write the picture of P(e) to a file, in the format that its ending names."""
    with _saved(path, (6.4, 4.2)) as axes:
        draw_probability(axes, estimates, fit)


@contextmanager
def _saved(path: Path, size: tuple[float, float]) -> Iterator[Axes]:
    """Yield axes, and write what is drawn on them."""
    import matplotlib

    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=size, layout="constrained")
    yield axes
    figure.savefig(path, dpi=150)
    plt.close(figure)
