"""Speed and error of the reference engine, beside plain solve_ivp with its own events."""

import numpy as np

from analysis.speed_error import contenders, measuring, work
from analysis.speed_error.work import Work
from analysis.writing import Report
from longball.model.quantities import at

COUNT, FULL_COUNT = 60, 600  # at-bats that are batted, whose errors are looked at
TIMED = 256  # enough for a turn of the quickest to take a twentieth of a second
SEED = 7
ROUNDS = 9  # interleaved repetitions of each timing
TOLERANCES = (1e-6, 1e-9, 1e-12)
UNIT = "solve_ivp DOP853 1e-12, its own event"


def run(report: Report, full: bool) -> str:
    """Measure on batted balls of the paper's distributions."""
    count = FULL_COUNT if full else COUNT
    struck, results = work.batted(max(count, TIMED), SEED)
    # The flights of the batted balls as scenes of their own.
    columns = {
        f"launch.{name}[{i}]": np.array([float(at(x, f"{block}.{name}[{i}]")) for x in results])
        for i in range(3)
        for name, block in (("position", "contact"), ("velocity", "impact"))
    }
    flights = work.known(Work(work.launches(np.ones(1), 0.0).base, columns), count)
    its_own = "solve_ivp DOP853 {:g}, its own event".format
    candidates = {
        **{its_own(r): contenders.plain("DOP853", r) for r in TOLERANCES},
        **{f"longball ivp DOP853 {r:g}": contenders.ivp("DOP853", r) for r in TOLERANCES[1:]},
        "longball ivp DOP853": contenders.ivp("DOP853"),
        "longball ivp, Taylor's method": contenders.ivp("Taylor"),
    }
    turns = [(one._replace(turn=TIMED), flights) for one in candidates.values()]
    measured = dict(zip(candidates, measuring.measure(turns, ROUNDS), strict=True))
    pairs = list(zip(results, work.truth(struck[:count]), strict=False))
    return report.render(
        "accuracy", globals(), count=count, measured=measured,
        unit=measured[UNIT], default=measured["longball ivp, Taylor's method"],
        worst=lambda x: max(measuring.difference(at(a, x), at(b, x)) for a, b in pairs),
    )  # fmt: skip
