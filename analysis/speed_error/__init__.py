"""Speed against error: every engine at every setting, beside its peers, in one run.

The peers are the extra ``peers`` of longball (``pip install 'longball[peers]'``); one that is not
installed is left out, and named.
"""

from pathlib import Path

import pandas as pd

from analysis.speed_error import contenders, laws, measuring, peers, pictures, work
from analysis.speed_error.work import Work, at_bats, flights, known
from analysis.writing import render, write_table
from longball.engines.batch import Batch

ROUNDS, FULL_ROUNDS = 5, 7
SCENES, FULL_SCENES = 100, 300  # of which the errors are looked at
UNIT = f"batch, {Batch().tolerance:g} m"  # the measure of all


def run(report: Path, full: bool) -> str:
    """Measure flights and at-bats; write tables, pictures and the section."""
    rounds, count = (FULL_ROUNDS, FULL_SCENES) if full else (ROUNDS, SCENES)
    size = max(count, contenders.COMPILED)
    measured = [measure(known(one, count), rounds) for one in (flights(size), at_bats(size))]
    timings, rows = (pd.concat(tables, ignore_index=True) for tables in zip(*measured, strict=True))
    write_table(report, "speed_error_timings", timings)
    rounded = rows.map(lambda value: float(f"{value:.3g}") if isinstance(value, float) else value)
    write_table(report, "speed_error", rounded)
    pictures.draw(report, rounded)
    whole = rounded.set_index(rounded["method"] + ", " + rounded["setting"])
    flight, at_bat = (whole[whole["work"] == kind] for kind in ("flight", "at-bat"))
    shares = (at_bat["missed"] / at_bat["contacts"]).groupby(at_bat["method"], sort=False)
    return render(
        report, "speed_error", vars(work) | globals(), count=count, rounds=rounds, full=full,
        flight=flight.to_dict("index"), at_bat=at_bat.to_dict("index"), peers=peers,
        missed=shares.agg(["min", "max"]).to_dict("index"),
        of_laws=laws.section(report, rounds, count // 4),
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
        rows.append({**whose, **times, **found.errors.row()})
        timings += [
            whose | {"round": i, "scenes": entrant.turn, "time, s": f"{entrant.turn * s:.6g}"}
            for i, s in enumerate(found.seconds, 1)
        ]
    return pd.DataFrame(timings), pd.DataFrame(rows)
