"""Pictures of the command line and of the report."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from longball.engines.path import Trajectory
from longball.extras import naming_extras
from longball.home_run import PAPER_CURVES, Curve, Estimate, Fit, Integral
from longball.model.arrays import Array
from longball.model.result import Result
from longball.model.scene import Fence
from longball.pitches.prediction import Prediction
from longball.pitches.statcast import MeasuredPitches

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARKERS = "osD^v<>ph8*"


def draw_probability(
    axes: Axes,
    estimates: Sequence[Estimate] | Sequence[Integral],
    fit: Fit | None,
    curves: Mapping[str, Curve] = PAPER_CURVES,
) -> None:
    """Draw estimates with their intervals, the fit, and the paper's two printed curves (Fig. 7).

    Markers and dashes distinguish them in black and white, too.
    """
    e = [row.e for row in estimates]
    low, high = min(e), max(e)
    # A single restitution still gets a picture, as wide as one step of the paper's.
    pad = 0.05 * (high - low) or 0.01
    grid = [low - pad + (high - low + 2 * pad) * i / 200 for i in range(201)]
    for (name, curve), dash in zip(curves.items(), ("--", ":"), strict=False):
        label = f"paper's {name}: C₁ = {curve.c1:g} m, σ = {curve.sigma:g} m"
        axes.plot(grid, [curve(x) for x in grid], dash, color="0.45", label=label)
    if fit:
        label = f"fit: C₁ = {fit.curve.c1:.0f} m, σ = {fit.curve.sigma:.1f} m"
        axes.plot(grid, [fit.curve(x) for x in grid], "-", color="C0", label=label)
    first = estimates[0]
    label = "longball, quadrature"
    if isinstance(first, Estimate):
        label = f"longball, 95 % of {first.trials} at-bats"
    p = [row.p for row in estimates]
    off = [row.p - row.low for row in estimates], [row.high - row.p for row in estimates]
    axes.errorbar(e, p, yerr=off, fmt="ko", markersize=4, capsize=3, label=label)
    axes.set_xlabel("coefficient of restitution e of the ball")
    axes.set_ylabel("probability of a home run P(e)")
    # From zero, so that the eye compares probabilities and not their differences.
    axes.set_ylim(bottom=0.0)
    axes.legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.01), ncols=2, fontsize="small", frameon=False
    )


def draw_errors(axes: Axes, prediction: Prediction) -> None:
    """Draw the errors of predicted balls: pitches at the plate, flies against launch angle.

    For each type of pitch, a mark shows the mean, and bars show one standard deviation.
    """
    measured, solved, error = prediction.measured, prediction.solved, prediction.error
    if isinstance(measured, MeasuredPitches):
        kinds, counts = np.unique(measured.labels[solved], return_counts=True)
        order = np.argsort(-counts)
        # As a catcher sees them: to his right, and up, cm.
        seen = 100.0 * error * [-1.0, 1.0]
        errors = [seen[solved & (measured.labels == kind)].T for kind in kinds[order]]
        labels = ("too far to the catcher's right", "too high")
        for i, (label, marker, aside) in enumerate(zip(labels, "os", (-0.15, 0.15), strict=True)):
            means, spreads = ([f(both[i]) for both in errors] for f in (np.mean, np.std))
            places = np.arange(len(errors)) + aside
            axes.errorbar(means, places, xerr=spreads, fmt=marker, markersize=5, label=label)
        axes.axvline(0.0, color="black", linewidth=0.8)
        names = [
            f"{kind} ({count})" for kind, count in zip(kinds[order], counts[order], strict=True)
        ]
        axes.set_yticks(range(len(names)), names)
        axes.invert_yaxis()
        axes.set(xlabel="predicted less measured place at the plate, cm")
        axes.set_ylabel("type of pitch (number)")
        axes.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    else:
        angle = np.degrees(measured.angle[solved])
        axes.plot(angle, error[solved, 0], "o", markersize=3, alpha=0.6)
        axes.axhline(0.0, color="black", linewidth=0.8)
        axes.set(xlabel="angle of launch, °", ylabel="predicted too far by, m")


@contextmanager
def saved(
    path: Path, size: tuple[float, float], rows: int = 1, **layout: Any
) -> Iterator[tuple[Figure, Any]]:
    """Yield a figure and its axes, one above the other, and write the figure to a file.

    The suffix of the file decides the format.
    """
    with naming_extras():
        import matplotlib

    # Files alone are written: a machine without a screen has no other backend.
    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(rows, figsize=size, layout="constrained", **layout)
    yield figure, axes
    figure.savefig(path, dpi=150)
    plt.close(figure)


# --- paths ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Drawn:
    """A scene for a picture."""

    label: str  # id and outcome
    # Points of its flights, m; an array of shape (n, 3) for each, the pitch first.
    flights: tuple[Array, ...]
    # Its fence from above, m, an array of shape (n, 2); None without one.
    fence: Array | None = None
    # x and height of the fence where the ball comes to it, m; None if it does not.
    passed: tuple[float, float] | None = None
    # How it ended, if the ball was batted or launched and came down: one of `ENDS`.
    end: str | None = None


# In a spray chart: ends, with their colours and markers.
ENDS = {
    "home run": ("#D55E00", "*"),
    "wall": ("#CC79A7", "s"),
    "fair": ("#0072B2", "o"),
    "foul": ("0.6", "x"),
}


# Colours that stay apart for the colour-blind (Okabe and Ito, 2008).
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
FEW = 12  # balls that are drawn as paths, each with its label
_POINTS = 200  # of each flight: lines between them look smooth
_ARC = 50.0  # m, between the arcs of a spray chart
_LABEL = 1.4  # inches: a panel has room for the label of its axis


def drawn(
    label: str,
    trajectory: Trajectory,
    fence: Fence | None = None,
    result: Result | None = None,
) -> Drawn:
    """Return the flights of a scene as points, and its fence; a pitch ends at the contact.

    The `result` gives the point at the fence, and the outcome.
    """
    flights: list[Any] = []
    for i, leg in enumerate(trajectory.legs):
        end = leg.begin + leg.flight.time
        # At the contact itself the velocity after it counts: stop before.
        if i + 1 < len(trajectory.legs):
            end = math.nextafter(trajectory.legs[i + 1].begin, 0.0)
        states = trajectory.sample(np.linspace(leg.begin, end, _POINTS).tolist())
        flights.append(np.array(states)[:, :3])
    passed = None
    if result and result.fence is not None:
        x, _, z = map(float, result.fence.position)
        passed = x, z - float(result.fence.clearance)
    ended = None if result is None else _end(result)
    around = None
    if fence is not None and fence.polyline is not None:
        around = np.array(fence.polyline)[:, :2]
    elif fence is not None and fence.radius is not None:
        angle = np.linspace(0.0, 2 * np.pi, 361)
        around = fence.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return Drawn(label, tuple(flights), around, passed, ended)


def _end(result: Result) -> str | None:
    if result.outcome in ("home_run", "wall"):
        return result.outcome.replace("_", " ")
    # Ties of the foul line are fair, as in the model.
    if result.landing is None:
        return None
    x, y, _ = map(float, result.landing.position)
    return "fair" if abs(y) <= x else "foul"


def save_paths(path: Path, scenes: Sequence[Drawn]) -> None:
    """Draw paths from the side and from above, both to scale, in the format of the file's ending.

    Paths are dashed before the contact and solid after it, with a mark at their end. Fences are
    grey: from above near the paths, and from the side where a ball reaches them.
    """
    # Both panels have one scale, so that the same length is the same distance in both.
    every = np.vstack([points for scene in scenes for points in scene.flights])
    low, high = np.minimum(every.min(axis=0), 0.0), np.maximum(every.max(axis=0), 0.0)
    length, width, height = np.maximum(high - low, 0.05 * (high - low).max())
    inches = min(9.0 / length, 9.0 / (width + height))  # for a metre
    heights = [max(extent * inches, _LABEL) for extent in (height, width)]
    size = (length * inches + 1.2, sum(heights) + 1.8)
    with saved(path, size, 2, height_ratios=heights, sharex=True) as (figure, (side, top)):
        for i, scene in enumerate(scenes):
            _draw_flights(side, top, scene, i, labelled=len(scenes) <= FEW)
        side.axhline(0.0, color="0.6", linewidth=0.8, zorder=0)
        passed = [scene.passed for scene in scenes if scene.passed is not None]
        _draw_fences(side, [np.array([(x, 0.0), (x, height)]) for x, height in passed])
        _draw_fences(top, [scene.fence for scene in scenes if scene.fence is not None])
        for axes, name in ((side, "height z (m)"), (top, "y, to the left (m)")):
            axes.set_aspect("equal", adjustable="datalim")
            axes.plot(0.0, 0.0, marker="P", color="0.4", markersize=6, linestyle="none", zorder=0)
            axes.set_ylabel(name)
        top.set_xlabel("x, from the plate towards the pitcher (m)")
        if len(scenes) <= FEW:
            if any(len(scene.flights) > 1 for scene in scenes):
                side.plot([], [], "--", color="0.4", label="pitch up to the bat")
            known = side.get_legend_handles_labels()
            figure.legend(*known, loc="outside upper left", fontsize="small", ncols=2)


def save_spray_chart(path: Path, scenes: Sequence[Drawn]) -> None:
    """Draw landings from above as a spray chart, in the format of the file's suffix.

    Home plate is at the bottom, the foul lines are at 45°, and x is upwards; arcs show distances.
    """
    landed = [scene for scene in scenes if scene.end is not None]
    places = np.array([scene.flights[-1][-1, :2] for scene in landed])
    fences = {fence.tobytes(): fence for s in landed if (fence := s.fence) is not None}
    # The part of a circle behind the plate would shrink the field to half.
    ahead = [fence[np.abs(fence[:, 1]) <= fence[:, 0]] for fence in fences.values()]
    farthest = 1.08 * max(np.hypot(*x.T).max(initial=_ARC) for x in [places, *ahead])
    with saved(path, (6.4, 5.2)) as (figure, axes):
        for radius in np.arange(_ARC, farthest, _ARC):
            arc = radius * np.exp(1j * np.radians(np.linspace(45.0, 135.0, 91)))
            axes.plot(arc.real, arc.imag, ":", color="0.75", linewidth=0.8, zorder=0)
            axes.annotate(
                f"{radius:g} m", (arc.real[0], arc.imag[0]), (4, -4), textcoords="offset points",
                color="0.4", fontsize="small", va="top",
            )  # fmt: skip
        # The foul lines end at the last arc.
        corner = farthest / math.sqrt(2)
        axes.plot([-corner, 0.0, corner], [corner, 0.0, corner], color="0.3", linewidth=1.0)
        _draw_fences(axes, [np.column_stack([-f[:, 1], f[:, 0]]) for f in fences.values()])
        for end, (colour, marker) in ENDS.items():
            chosen = places[[scene.end == end for scene in landed]]
            if len(chosen):
                axes.plot(
                    -chosen[:, 1], chosen[:, 0], marker, color=colour, markersize=5, alpha=0.8,
                    markeredgewidth=1.0, label=f"{end} ({len(chosen)})",
                )  # fmt: skip
        aside = max(corner, 1.05 * np.abs(places[:, 1]).max())
        behind = min(-0.04 * farthest, 1.05 * places[:, 0].min())
        axes.set(xlim=(-aside, aside), ylim=(behind, farthest), aspect="equal")
        axes.set(xlabel="to the right of home plate (m)", ylabel="x, towards centre field (m)")
        figure.legend(loc="outside upper left", fontsize="small", ncols=4, frameon=False)


def _draw_fences(axes: Axes, lines: Sequence[Array]) -> None:
    """Draw lines that do not extend the limits of the axes."""
    from matplotlib.collections import LineCollection

    drawn = LineCollection([*lines], colors="0.6", linewidths=2.5, zorder=0)
    axes.add_collection(drawn, autolim=False)


def _draw_flights(side: Axes, top: Axes, scene: Drawn, i: int, labelled: bool) -> None:
    """Draw the flights of a scene, the last of them solid and with the scene's label."""
    look: dict[str, Any] = {"color": _COLOURS[i % len(_COLOURS)], "linewidth": 1.4}
    last = look | {
        "marker": MARKERS[i % len(MARKERS)],
        "markevery": [-1],
        "markersize": 5,
        "label": scene.label if labelled else None,
    }
    for axes, column in ((side, 2), (top, 1)):
        *before, batted = scene.flights
        for points in before:
            axes.plot(points[:, 0], points[:, column], "--", **look)
        axes.plot(batted[:, 0], batted[:, column], "-", **last)
