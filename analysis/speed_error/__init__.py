"""Speed against error: every engine at every setting, beside its peers, in one run.

The peers are the extra ``peers`` of longball (``pip install 'longball[peers]'``); one that is not
installed is left out, and named.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from analysis.speed_error import contenders, laws, measuring, peers, pictures, work
from analysis.speed_error.work import Known, at_bats, flights, known
from analysis.writing import render, write_table
from longball.engines.batch import Batch

ROUNDS, FULL_ROUNDS = 5, 7
SCENES, FULL_SCENES = 100, 300  # of which the errors are looked at

# Who stands in the short table: the measure of all first.
SHORT = (
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
    measured = [measure(known(one, count), rounds) for one in (flights(size), at_bats(size))]
    write_table(report, "speed_error_timings", pd.concat([timings for timings, _ in measured]))
    whole = pd.concat([rows for _, rows in measured], ignore_index=True)
    rounded = whole.map(lambda value: float(f"{value:.3g}") if isinstance(value, float) else value)
    write_table(report, "speed_error", rounded)
    of_laws = laws.section(report, rounds, count // 4)
    return section(report, rounded, rounds, count, full) + of_laws


def section(report: Path, whole: pd.DataFrame, rounds: int, count: int, full: bool) -> str:
    """Draw the pictures, and write the section."""
    pictures.draw(report, whole)
    flight, at_bat = by_name(whole, "flight"), by_name(whole, "at-bat")
    shares: dict[str, list[float]] = {}
    for row in at_bat.values():
        shares.setdefault(row["method"], []).append(row["missed"] / row["contacts"])
    return render(
        report, "speed_error", globals(), count=count, rounds=rounds, full=full,
        flight=flight, at_bat=at_bat, work=work, peers=peers,
        dial=[row["ratio"] for row in flight.values() if row["method"] == "batch"],
        never=[method for method, share in shares.items() if max(share) == 0.0],
        missing={method: share for method, share in shares.items() if max(share) > 0.0},
        dear=at_bat[contenders.SHORTEST]["ratio"] / at_bat["ivp DOP853, 1e-08"]["ratio"],
    )  # fmt: skip


def measure(given: Known, rounds: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the timings of one kind of work, a row a turn, and their summary with the errors."""
    entrants = [
        *contenders.longball_engines(),
        *contenders.plain_scipy(given.work),
        *contenders.installed_peers(),
    ]
    measured = measuring.measure([(entrant, given) for entrant in entrants], rounds)
    unit = next(found for found in measured if found.contender.name == SHORT[0])
    timings, rows = [], []
    for found in measured:
        entrant = found.contender
        whose: dict[str, object] = {"work": given.work.base.kind, "method": entrant.family}
        whose["setting"] = entrant.setting
        ratio = measuring.ratio(found.seconds, unit.seconds)
        times = {"time each, µs": found.microseconds, "ratio": ratio}
        rows.append(whose | times | found.errors.row())
        timings += [
            whose | {"round": i, "scenes": entrant.turn, "time, s": f"{entrant.turn * s:.6g}"}
            for i, s in enumerate(found.seconds, 1)
        ]
    return pd.DataFrame(timings), pd.DataFrame(rows)


def by_name(whole: pd.DataFrame, kind: str) -> dict[str, dict[str, Any]]:
    """Return the rows of one kind of work, by method and setting."""
    chosen = whole[whole["work"] == kind]
    rows = (dict(zip(chosen.columns, row, strict=True)) for row in chosen.itertuples(index=False))
    return {f"{row['method']}, {row['setting']}": row for row in rows}
