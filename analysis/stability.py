"""Every engine on every hard case: digits right, digits attainable, verdict, time."""

import math
import time
from decimal import Decimal

import numpy as np
import pandas as pd
from joblib import Parallel, delayed

from analysis.writing import Report, data
from longball import engines
from longball.engines.chain import solve
from longball.engines.compiled import compile_at_once
from longball.engines.engine import CannotSolve
from longball.golden import Case, load
from longball.golden.case import decisive
from longball.model.quantities import numbers
from longball.model.result import Number, Result

ENGINES = data(__file__)
VERDICTS = ("right", "not answered", "inaccurate", "wrong")  # the worst last
# The errors of a chain's few dozen roundings add up to some attainable errors; a hundred is what
# the judge's profile `exact` allows.
ALLOWED = 100.0
MOST_DIGITS = 30.0  # of the golden values


def run(report: Report, full: bool) -> str:
    """Solve the golden set's hard family by every engine; `full` adds all other families."""
    cases = load() if full else load("hard")
    tasks = (delayed(try_case)(case, name) for name in ENGINES for case in cases)
    frame = pd.DataFrame(Parallel(n_jobs=-1, batch_size=16)(tasks))
    seconds = frame["seconds"].map("{:.2g}".format).astype(float)
    rounded = frame.round({"digits": 1, "attainable": 1}).assign(seconds=seconds)
    report.write_table("stability", rounded)
    draw(report, frame)
    return report.render("stability", globals(), cases=len(cases), frame=frame)


def draw(report: Report, frame: pd.DataFrame) -> None:
    """Draw how many cases have each verdict, a bar for each engine; darker is worse."""
    counts = frame.groupby(["engine", "verdict"], sort=False).size().unstack(fill_value=0)
    counts = counts.reindex(columns=list(VERDICTS), fill_value=0)
    with report.figure("stability", size=(6.4, 3.4)) as (axes,):
        left = np.zeros(len(counts))
        for verdict, shade in zip(VERDICTS, ("0.9", "0.7", "0.4", "black"), strict=True):
            bars = axes.barh(counts.index, counts[verdict], left=left, color=shade, label=verdict)
            dark = verdict in VERDICTS[2:]
            labels = [str(count) if count >= FEWEST else "" for count in counts[verdict]]
            axes.bar_label(bars, labels, label_type="center", color="white" if dark else "black")
            left += counts[verdict].to_numpy()
        axes.invert_yaxis()
        axes.grid(visible=False)
        axes.set(xlabel="hard cases", xlim=(0.0, left.max()))
        axes.legend(loc="lower center", bbox_to_anchor=(0.45, 1.0), ncols=4)


FEWEST = 8  # cases in a bar that is wide enough for their number


def try_case(case: Case, name: str) -> dict[str, object]:
    """Solve a case by an engine: digits right (NaN if it gave no number), and how long it took."""
    compile_at_once()
    start = time.perf_counter()
    try:
        result = solve(case.scene, engines.create(**ENGINES[name]))
    except CannotSolve as reason:
        result = Result(id=case.id, error=str(reason))
    seconds = time.perf_counter() - start
    compared = dict(zip(("verdict", "digits", "attainable"), compare(case, result), strict=True))
    answer = result.outcome or str(result.error)
    return {"case": case.id, "engine": name, **compared, "seconds": seconds, "answer": answer}


def compare(case: Case, result: Result) -> tuple[str, float, float]:
    """Return verdict, digits right and digits attainable of a case's main quantity."""
    if case.expected.outcome is None:
        return ("right" if result.outcome is None else "wrong"), math.nan, math.nan
    if result.outcome != case.expected.outcome:
        return ("not answered" if result.outcome is None else "wrong"), math.nan, math.nan
    expected, found = dict(numbers(case.expected)), dict(numbers(result))
    path = next((path for path in decisive(case.expected) if path in expected), None)
    if path not in found:
        return ("right" if path is None else "inaccurate"), math.nan, math.nan
    truth = exactly(expected[path])
    error, attainable = abs(exactly(found[path]) - truth), case.attainable(path)
    size = float(abs(truth)) or 1.0
    verdict = "right" if float(error) <= ALLOWED * attainable else "inaccurate"
    return verdict, digits_of(float(error) / size), digits_of(attainable / size)


def exactly(number: Number | int) -> Decimal:
    """Return a number of a result as it is."""
    return Decimal(number) if isinstance(number, float | int) else Decimal(number.value)


def digits_of(relative_error: float) -> float:
    """Return the digits that a relative error leaves, from 0 to those of the golden values."""
    return max(0.0, -math.log10(max(relative_error, 10**-MOST_DIGITS)))
