"""Speed against error: every engine at every setting, beside its peers, in one run.

The peers are the extra ``peers`` of longball (``pip install '.[peers]'``); one that is not
installed is left out, and named.
"""

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
    summary = pd.DataFrame(rows).drop(columns="worst_time").rename(columns=COLUMNS)
    return pd.DataFrame(timings), summary


BEYOND = 1e-15  # m; smaller errors than doubles can have at 100 m are drawn there

PEERS = ("heyoka scalar", "heyoka batch", "diffrax Tsit5", "diffrax Dopri8", "CVODE Adams")
PLAIN = ("scipy DOP853", "scipy RK45", "scipy LSODA")
OURS = (
    *("batch", "ivp Taylor", "ivp DOP853", "ivp RK45", "ivp LSODA", "ivp Radau"),
    *("verlet half_step", "verlet implicit", "enclosure", "multiprecision"),
)


def draw(report: Report, whole: pd.DataFrame) -> None:
    """Draw the three pictures."""
    for kind, name in (("flight", "speed_error_flights"), ("at-bat", "speed_error_at_bats")):
        with report.figure(name, columns=2, size=(10.0, 5.6)) as (ours, others):
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
    with report.figure("speed_error_missed", size=(8.0, 5.5)) as (axes,):
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
