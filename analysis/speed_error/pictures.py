"""Pictures of speed against error, and of missed contacts."""

from pathlib import Path

import pandas as pd
from matplotlib.axes import Axes

from analysis.writing import STYLES, figure

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
        with figure(report, name, columns=2, size=(10.0, 5.6)) as (ours, others):
            others.sharex(ours)
            others.sharey(ours)
            ours.set(xscale="log", yscale="log", title="longball's engines")
            others.set_title("batch and its peers")
            ours.set_ylabel(f"time a{'n' if kind == 'at-bat' else ''} {kind}, µs")
            rows, below = whole[whole["work"] == kind], (0.5, -0.12)
            for axes, methods in ((ours, OURS), (others, ("batch", *PEERS, *PLAIN))):
                against_error(axes, rows, methods)
                axes.set_xlabel("worst error of D, m")
                axes.axvline(BEYOND, color="0.7", linewidth=0.8)
                axes.legend(loc="upper center", bbox_to_anchor=below, ncols=3, fontsize="x-small")
    with figure(report, "speed_error_missed", size=(8.0, 5.5)) as (axes,):
        missed(axes, whole[whole["work"] == "at-bat"])


def against_error(axes: Axes, rows: pd.DataFrame, methods: tuple[str, ...]) -> None:
    """Draw one line a method, from loose to tight."""
    for method in methods:
        mine = rows[(rows["method"] == method) & rows["worst error, m"].notna()]
        if mine.empty:
            continue
        x, y = mine["worst error, m"].clip(lower=BEYOND), mine["time each, µs"]
        end = mine.iloc[int(x.argmin())]
        share = end["missed"] / end["contacts"] if end["contacts"] else 0.0
        label = f"{method} ({share:.0%} missed)" if share >= 0.005 else method
        axes.plot(x, y, **STYLES[method], markersize=4.5, linewidth=1.1, label=label)


def missed(axes: Axes, rows: pd.DataFrame) -> None:
    """Draw the part of contacts that is missed: a bar over all settings, a dot the tightest."""
    share = rows.assign(share=100.0 * rows["missed"] / rows["contacts"])
    methods = share.groupby("method", sort=False)["share"].agg("last").sort_values(kind="stable")
    for place, method in enumerate(methods.index):
        mine = share[share["method"] == method]
        x, times = mine["share"], mine["time each, µs"].map("{:.2g}".format).astype(float)
        axes.plot([x.min(), x.max()], [place, place], color="0.6", linewidth=5.0, zorder=2)
        axes.plot(x.iloc[-1], place, "o", color="black", markersize=6, clip_on=False, zorder=3)
        written = times.map("{:,g}".format).str.replace(",", "\u2009")
        ends = " … ".join(dict.fromkeys(written.iloc[[0, -1]]))
        settings = " … ".join(dict.fromkeys(mine["setting"].iloc[[0, -1]]))
        axes.text(107.0, place, f"{settings};  {ends} µs", va="center", fontsize=7.5)
    axes.set_yticks(range(len(methods)), methods.index)
    axes.invert_yaxis()
    axes.set(xlim=(-3.0, 103.0), xlabel="contacts missed, %")
