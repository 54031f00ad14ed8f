"""Speed against error: every engine at every setting, beside its peers, in one run.

The peers are the extra ``peers`` of longball (``pip install '.[peers]'``); one that is not
installed is left out, and named.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from analysis.speed_error import contenders, laws, measuring, peers, work
from analysis.speed_error.work import Work, at_bats, flights, known
from analysis.writing import STYLES, Report
from longball.engines.batch import Batch

ROUNDS, FULL_ROUNDS = 5, 7
SCENES, FULL_SCENES = 100, 300  # of which the errors are looked at
COLUMNS = {"median": "median error, m", "most": "99 % error, m", "worst": "worst error, m"}
UNIT = f"batch, {Batch().tolerance:g} m"  # the measure of all


def run(report: Report, full: bool) -> str:
    """Measure flights and at-bats; write tables, pictures and the section."""
    rounds, count = (FULL_ROUNDS, FULL_SCENES) if full else (ROUNDS, SCENES)
    size = max(count, contenders.COMPILED)
    measured = [measure(known(one, count), rounds) for one in (flights(size), at_bats(size))]
    timings, rows = (pd.concat(tables, ignore_index=True) for tables in zip(*measured, strict=True))
    report.write_table("speed_error_timings", timings)
    rounded = rows.map(lambda value: float(f"{value:.3g}") if isinstance(value, float) else value)
    report.write_table("speed_error", rounded)
    draw(report, rounded)
    whole = rounded.set_index(rounded["method"] + ", " + rounded["setting"])
    flight, at_bat = (whole[whole["work"] == kind] for kind in ("flight", "at-bat"))
    shares = (at_bat["missed"] / at_bat["contacts"]).groupby(at_bat["method"], sort=False)
    few = count // 4  # flights under other laws whose errors are looked at
    of_laws = report.render(
        "speed_error_laws", vars(laws), found=laws.compared(rounds, few), count=few,
        ratio=measuring.ratio,
    )  # fmt: skip
    return report.render(
        "speed_error", vars(work) | globals(), count=count, rounds=rounds, full=full,
        flight=flight.to_dict("index"), at_bat=at_bat.to_dict("index"), peers=peers,
        missed=shares.agg(["min", "max"]).to_dict("index"), of_laws=of_laws,
    )  # fmt: skip


def measure(given: Work, rounds: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the timings of one kind of work, a row a turn, and their summary with the errors."""
    ours, plain = contenders.longball_engines(), contenders.plain_scipy(given)
    entrants = (*ours, *plain, *contenders.installed_peers())
    measured = measuring.measure([(entrant, given) for entrant in entrants], rounds)
    unit = next(found for found in measured if found.contender.name == UNIT)
    timings, rows = [], []
    for found in measured:
        entrant = found.contender
        whose = {"work": given.base.kind, "method": entrant.family, "setting": entrant.setting}
        ratio = measuring.ratio(found.seconds, unit.seconds)
        times = {"time each, µs": found.microseconds, "ratio": ratio}
        rows.append({**whose, **times, **found.errors._asdict()})
        timings += [
            whose | {"round": i, "scenes": entrant.turn, "time, s": f"{entrant.turn * s:.6g}"}
            for i, s in enumerate(found.seconds, 1)
        ]
    summary = pd.DataFrame(rows).rename(columns=COLUMNS)
    return pd.DataFrame(timings), summary


ATTAINABLE = 1e-15  # m; smaller errors are those of more digits than doubles have

# What is drawn, by the name at its curve and the end of the curve where it stands; the table has
# all. One method stands for those that are nearly as fast and as exact.
OURS = {
    "batch": ("batch", "left"), "ivp Taylor": ("ivp, Taylor", "left"),
    "ivp DOP853": ("ivp, DOP853", "left"), "verlet implicit": ("verlet, implicit", "right"),
}  # fmt: skip
OTHERS = {
    "batch": ("longball's batch", "left"), "heyoka batch": ("heyoka", "left"),
    "diffrax Tsit5": ("diffrax Tsit5", "left"), "CVODE Adams": ("CVODE Adams", "right"),
    "scipy RK45": ("SciPy RK45", "left"),
}  # fmt: skip


def draw(report: Report, whole: pd.DataFrame) -> None:
    """Draw the three pictures."""
    for kind, name in (("flight", "speed_error_flights"), ("at-bat", "speed_error_at_bats")):
        with report.figure(name, rows=2, size=(6.4, 8.0)) as (ours, others):
            others.sharex(ours)
            others.sharey(ours)
            ours.set(xscale="log", yscale="log", title="longball's engines")
            others.set_title("batch and other programs")
            rows = whole[whole["work"] == kind]
            for axes, methods in ((ours, OURS), (others, OTHERS)):
                against_error(axes, rows, methods)
                axes.set(xlabel="largest error of the distance D, m", ylabel=f"time per {kind}, µs")
    with report.figure("speed_error_missed", size=(6.4, 5.6)) as (axes,):
        missed(axes, whole[whole["work"] == "at-bat"])


def against_error(axes: Axes, rows: pd.DataFrame, methods: Mapping[str, tuple[str, str]]) -> None:
    """Draw one line a method, from loose to tight, with its name at one end."""
    for method, (label, side) in methods.items():
        mine = rows[(rows["method"] == method) & (rows["worst error, m"] > ATTAINABLE)]
        if mine.empty:
            continue
        x, y = mine["worst error, m"], mine["time each, µs"]
        axes.plot(x, y, **STYLES[method], markersize=4.5, linewidth=1.1)
        tightest = mine.iloc[int(x.argmin())]
        share = tightest["missed"] / tightest["contacts"] if tightest["contacts"] else 0.0
        if share >= 0.005:
            label += f" (misses {share:.0%})"
        at = int(x.argmin() if side == "left" else x.argmax())
        offset, align = ((-6, 0), "right") if side == "left" else ((6, 0), "left")
        place: Any = {"textcoords": "offset points", "ha": align, "va": "center"}
        color = STYLES[method]["color"]
        axes.annotate(label, (x.iloc[at], y.iloc[at]), offset, **place, color=color)
    axes.set_xlim(1e-18, 1e5)


def missed(axes: Axes, rows: pd.DataFrame) -> None:
    """Draw the part of contacts that is missed, at the loosest and the tightest setting."""
    share = rows.assign(share=100.0 * rows["missed"] / rows["contacts"])
    methods = share.groupby("method", sort=False)["share"].agg(["first", "last"])
    methods = methods.sort_values(["last", "first"], kind="stable")
    places = np.arange(len(methods))
    style: Any = {"clip_on": False, "zorder": 3}
    axes.hlines(places, methods["last"], methods["first"], color="0.6", linewidth=1.0)
    axes.plot(methods["first"], places, **STYLES["loosest"], **style, label="loosest setting")
    axes.plot(methods["last"], places, **STYLES["tightest"], **style, label="tightest setting")
    axes.legend(loc="lower center", bbox_to_anchor=(0.4, 1.0), ncols=2)
    axes.set_yticks(range(len(methods)), methods.index)
    axes.invert_yaxis()
    axes.set(xlim=(-3.0, 103.0), xlabel="contacts missed, %")
