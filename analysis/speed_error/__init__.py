"""Speed against error: every engine at every setting, beside its peers, in one run.

The peers are the extra ``peers`` of longball (``pip install 'longball[peers]'``); one that is not
installed is left out, and named.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from analysis.speed_error import contenders, laws, measuring, pictures
from analysis.speed_error.peers import HeyokaBatch
from analysis.speed_error.work import SEED, TRUE_DIGITS, Known, at_bats, flights, known
from analysis.writing import shown, table
from longball.engines.batch import Batch

ROUNDS, FULL_ROUNDS = 5, 7
SCENES, FULL_SCENES = 100, 300  # of which the errors are looked at

# Who stands in the short table: the measure of all first.
_SHORT = (
    f"batch, {Batch().tolerance:g} m",
    "batch, 1e-08 m",
    "heyoka batch, default",
    "heyoka scalar, default",
    "diffrax Tsit5, 1e-09",
    "diffrax Dopri8, 1e-12",
    "CVODE Adams, 1e-12",
    "scipy DOP853, 1e-12",
    "scipy RK45, 1e-12",
    "scipy LSODA, 1e-12",
    "ivp Taylor, default",
    "ivp DOP853, 5e-14",
    "ivp RK45, 1e-12",
    "ivp LSODA, 1e-12",
    "ivp Radau, 1e-08",
    "verlet implicit, 0.002 s",
    "enclosure, 30 digits",
    "multiprecision, 30 digits",
)


def run(report: Path, full: bool) -> str:
    """Measure flights and at-bats; write tables, pictures and the section."""
    rounds, count = (FULL_ROUNDS, FULL_SCENES) if full else (ROUNDS, SCENES)
    size = max(count, contenders.COMPILED)
    measured = [measure(known(work, count), rounds) for work in (flights(size), at_bats(size))]
    table(report, "speed_error_timings", pd.concat([timings for timings, _ in measured]))
    whole = pd.concat([rows for _, rows in measured], ignore_index=True)
    rounded = whole.map(lambda value: float(f"{value:.3g}") if isinstance(value, float) else value)
    table(report, "speed_error", rounded)
    of_laws = laws.section(report, rounds, count // 4)
    return section(report, rounded, rounds, count, full) + of_laws


def section(report: Path, whole: pd.DataFrame, rounds: int, count: int, full: bool) -> str:
    """Draw the pictures, and write the section."""
    pictures.draw(report, whole)
    absent = contenders.missing_peers()
    return "\n".join(
        [
            "## Speed against error: all engines, and their peers\n",
            f"Everyone lands the same balls: launches at 25 to 50 m/s and 5° to 60°, and whole "
            f"at-bats of the paper's distributions (seed {SEED}). The error is that of D against "
            f"{TRUE_DIGITS} proven digits by the engine `enclosure`, over the first {count} of "
            "each (fewer for the slowest: `tables/speed_error.csv` says how many). Times are "
            f"medians of {rounds} interleaved rounds on one thread; every one of them is in "
            "`tables/speed_error_timings.csv`. A ratio is the median of the rounds' ratios to the "
            "batch engine's time, and bears what the machine does besides; the times do not. "
            f"{measuring.machine()}; {measuring.versions()} "
            f"(`python -m analysis speed_error{' --full' if full else ''}`)."
            + (f" Not installed, and left out: {', '.join(absent)}.\n" if absent else "\n"),
            found(whole),
            table(report, "speed_error_short", short(whole)),
            "*Scipy*, *CVODE*, *diffrax* and *heyoka* find their events themselves; their chain of "
            f"an at-bat is longball's, over columns. *heyoka batch* takes {HeyokaBatch.lanes} "
            "flights of like duration at once. *Missed*: the bat was not noticed, of at-bats with "
            "a contact; errors of D are over those that were noticed. *ivp*, *verlet*, "
            "*enclosure* and *multiprecision* solve scene by scene, each result made and "
            "checked.\n",
            shown(
                "speed_error_flights",
                "Speed against error of flights: longball's engines and their peers. Each line is "
                "one method over its tolerances or steps; towards the lower left is better. What "
                "is more exact than doubles can be is drawn at the grey line.",
            ),
            shown("speed_error_at_bats", "The same for whole at-bats that are not missed."),
            shown(
                "speed_error_missed",
                "Contacts that go unnoticed. A ring for each tolerance or step, the smaller the "
                "tighter, and a dot for the tightest; on the right the first and the last of "
                "them, with the time an at-bat takes.",
            ),
        ]
    )


def measure(given: Known, rounds: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the timings of one kind of work, a row a turn, and their summary with the errors."""
    entrants = [
        *contenders.longball_engines(),
        *contenders.plain_scipy(given.work),
        *contenders.installed_peers(),
    ]
    measured = measuring.measure([(entrant, given) for entrant in entrants], rounds)
    unit = next(found for found in measured if found.contender.name == _SHORT[0])
    timings, rows = [], []
    for found in measured:
        entrant = found.contender
        whose: dict[str, object] = {
            "work": given.work.base.kind,
            "method": entrant.family,
            "setting": entrant.setting,
        }
        times = {
            "time each, µs": found.microseconds,
            "ratio": measuring.ratio(found.seconds, unit.seconds),
        }
        rows.append(whose | times | found.errors.row())
        timings += [
            whose | {"round": i, "scenes": entrant.turn, "time, s": f"{entrant.turn * s:.6g}"}
            for i, s in enumerate(found.seconds, 1)
        ]
    return pd.DataFrame(timings), pd.DataFrame(rows)


def short(whole: pd.DataFrame) -> pd.DataFrame:
    """Return the table of a few."""
    flight, at_bat = by_name(whole, "flight"), by_name(whole, "at-bat")
    return pd.DataFrame(
        [
            {
                "method": name,
                "flight, µs": f"{flight[name]['time each, µs']:.3g}",
                "ratio": f"{flight[name]['ratio']:.3g}",
                "worst error of D, m": f"{flight[name]['worst error, m']:.1e}",
                "at-bat, µs": f"{at_bat[name]['time each, µs']:.3g}",
                "at-bats: worst error of D, m": f"{at_bat[name]['worst error, m']:.1e}".replace(
                    "nan", "–"
                ),
                "contacts missed": f"{at_bat[name]['missed'] / at_bat[name]['contacts']:.1%}",
            }
            for name in _SHORT
            if name in flight
        ]
    )


def by_name(whole: pd.DataFrame, kind: str) -> dict[str, dict[str, Any]]:
    """Return the rows of one kind of work, by method and setting."""
    chosen = whole[whole["work"] == kind]
    rows = (dict(zip(chosen.columns, row, strict=True)) for row in chosen.itertuples(index=False))
    return {f"{row['method']}, {row['setting']}": row for row in rows}


def found(whole: pd.DataFrame) -> str:
    """Say what was found."""
    flight = by_name(whole, "flight")
    best = flight[_SHORT[0]]
    beside = [
        f"{name} takes {flight[name]['ratio']:.3g} times as long and is off by "
        f"{flight[name]['worst error, m']:.1e} m"
        for name in _SHORT
        if name.startswith(("heyoka", "diffrax", "CVODE", "scipy DOP853")) and name in flight
    ]
    dial = [row["ratio"] for row in flight.values() if row["method"] == "batch"]
    at_bat = by_name(whole, "at-bat")
    dear = at_bat[contenders.SHORTEST]["ratio"] / at_bat["ivp DOP853, 1e-08"]["ratio"]
    shares: dict[str, list[float]] = {}
    for row in at_bat.values():
        shares.setdefault(row["method"], []).append(row["missed"] / row["contacts"])
    never = [method for method, share in shares.items() if max(share) == 0.0]
    missing = [
        f"{method} " + " to ".join(dict.fromkeys(f"{x:.0%}" for x in (min(share), max(share))))
        for method, share in shares.items()
        if max(share) > 0.0
    ]
    return (
        f"**Flights.** The batch engine lands a ball in {best['time each, µs']:.2g} µs, off by "
        f"{best['worst error, m']:.1e} m at worst; beside it, {'; '.join(beside)}. Over its whole "
        f"dial its time stays between {min(dial):.2f} and {max(dial):.2f} of that.\n\n"
        f"**Contacts.** {', '.join(never)} noticed every contact. The others missed, from their "
        f"best setting to their worst: {'; '.join(missing)}. The ball passes the bat within some "
        "4 ms, between two steps of whoever looks for a change of sign at its steps. A tight "
        f"tolerance helps by chance; steps of 2 ms, which miss few, make DOP853 {dear:.2g} times "
        "as slow as the engine `ivp`, which looks for the closest approach. "
        "Who misses the bat has no batted ball to fly, which makes those at-bats look cheap.\n"
    )
