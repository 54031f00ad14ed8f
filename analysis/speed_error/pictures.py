"""Pictures of speed against error, and of missed contacts."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import pandas as pd
from matplotlib import patheffects
from matplotlib.axes import Axes

from analysis.writing import LINES, figure

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*", "<", ">")
HALO = [patheffects.withStroke(linewidth=2.0, foreground="white")]
BEYOND = 1e-15  # m; smaller errors than doubles can have at 100 m are drawn there

PEERS = ("heyoka scalar", "heyoka batch", "diffrax Tsit5", "diffrax Dopri8", "CVODE Adams")
PLAIN = ("scipy DOP853", "scipy RK45", "scipy LSODA")
OURS = (
    *("batch", "ivp Taylor", "ivp DOP853", "ivp RK45", "ivp LSODA", "ivp Radau"),
    *("verlet half_step", "verlet implicit", "enclosure", "multiprecision"),
)


def draw(report: Path, whole: pd.DataFrame) -> None:
    """Draw the three pictures."""
    for kind, name in (("flight", "speed_error_flights"), ("at-bat", "speed_error_at_bats")):
        with figure(report, name, columns=2, size=(10.0, 5.2)) as (ours, others):
            others.sharex(ours)
            others.sharey(ours)
            ours.set_xscale("log")
            ours.set_yscale("log")
            ours.set_title("longball's engines")
            others.set_title("batch and its peers")
            rows = whole[whole["work"] == kind]
            named = {
                axes: against_error(axes, rows, methods)
                for axes, methods in ((ours, OURS), (others, ("batch", *PEERS, *PLAIN)))
            }
            ours.set_xlim(left=BEYOND / 100)  # room for names
            ours.set_ylabel(f"time a{'n' if kind == 'at-bat' else ''} {kind}, µs")
            for axes, ends in named.items():
                axes.set_xlabel("worst error of D, m")
                axes.axvline(BEYOND, color="0.7", linewidth=0.8)
                _name(axes, ends)
    with figure(report, "speed_error_missed", size=(8.0, 5.5)) as (axes,):
        missed(axes, whole[whole["work"] == "at-bat"])


class End(NamedTuple):
    """The tight end of a line: what to call it, where it is, and whether it is all of the line."""

    name: str
    x: float
    y: float
    alone: bool


def against_error(axes: Axes, rows: pd.DataFrame, methods: tuple[str, ...]) -> list[End]:
    """Draw one line a method, from loose to tight; return what to call its tight end."""
    ends = []
    for i, method in enumerate(methods):
        mine = rows[(rows["method"] == method) & rows["worst error, m"].notna()]
        if mine.empty:
            continue
        x = mine["worst error, m"].clip(lower=BEYOND).to_numpy()
        y = mine["time each, µs"].to_numpy()
        axes.plot(
            x, y, linestyle=LINES[i % len(LINES)], marker=MARKERS[i % len(MARKERS)],
            markersize=4.5, markerfacecolor="white" if i % 2 else None, linewidth=1.1,
        )  # fmt: skip
        tight = int(x.argmin())
        end = mine.iloc[tight]
        share = end["missed"] / end["contacts"] if end["contacts"] else 0.0
        name = f"{method} ({share:.0%} missed)" if share >= 0.005 else method
        ends.append(End(name, float(x[tight]), float(y[tight]), len(mine) == 1))
    return ends


def _name(axes: Axes, ends: list[End]) -> None:
    """Name lines beside their ends, apart from each other: on the right what no line leads to."""
    drawn = axes.get_figure(root=True)
    assert drawn is not None
    drawn.draw_without_rendering()  # the scales are settled then
    line = 10.0  # points, of a name's height
    lowest = {False: -math.inf, True: -math.inf}
    for name, x, y, right in sorted(ends, key=lambda end: end.y):
        _, at = axes.transData.transform((x, y)) * 72.0 / axes.figure.dpi
        height = max(at + (0.8 * line if right else 0.0), lowest[right] + line)
        lowest[right] = height
        axes.annotate(
            name, (x, y), (8.0 if right else -8.0, height - at), textcoords="offset points",
            ha="left" if right else "right", va="center", fontsize=7.0, path_effects=HALO,
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "color": "0.5"},
        )  # fmt: skip


def missed(axes: Axes, rows: pd.DataFrame) -> None:
    """Draw the part of contacts that goes unnoticed, a line a method, a ring a setting.

    The rings shrink from the loosest setting to the tightest, which is a dot.
    """
    share = rows.assign(share=100.0 * rows["missed"] / rows["contacts"])
    methods = share.groupby("method", sort=False)["share"].agg("last").sort_values(kind="stable")
    for place, method in enumerate(methods.index):
        mine = share[share["method"] == method]
        x, settings = mine["share"].to_list(), mine["setting"].to_list()
        sizes = [4.0 + 2.0 * k for k in range(len(x))][::-1]
        for value, size in zip(x, sizes, strict=True):
            axes.plot(
                value, place, marker="o", markersize=size, markeredgecolor="black",
                markerfacecolor="black" if size == sizes[-1] else "none",
                markeredgewidth=0.8, clip_on=False,
            )  # fmt: skip
        times = _span([_two_digits(t) for t in mine["time each, µs"]])
        axes.text(107.0, place, f"{_span(settings)};  {times} µs", va="center", fontsize=7.5)
    axes.set_yticks(range(len(methods)), methods.index)
    axes.invert_yaxis()
    axes.set_xlim(-3.0, 103.0)
    axes.set_xlabel("contacts missed, %")


def _span(texts: list[str]) -> str:
    return texts[0] if texts[0] == texts[-1] else f"{texts[0]} … {texts[-1]}"


def _two_digits(x: float) -> str:
    return f"{float(f'{x:.2g}'):,g}".replace(",", "\u2009")
