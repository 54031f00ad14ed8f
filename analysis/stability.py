"""Every engine on every hard case: digits right, digits attainable, verdict, time."""

import math
import time
from decimal import Decimal
from itertools import groupby

import pandas as pd
from joblib import Parallel, delayed
from matplotlib.colors import ListedColormap

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
VERDICTS = ("right", "declined", "short", "wrong")  # the worst last
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
    # The verdicts, cases across and engines down; darker is worse.
    names = list(frame["case"].unique())
    grid = frame["verdict"].map(VERDICTS.index).to_numpy().reshape(len(ENGINES), len(names))
    shades = ListedColormap(["0.95", "0.7", "0.4", "black"])
    with report.figure("stability", size=(9.0, 4.6)) as (axes,):
        image = axes.imshow(
            grid, shades, aspect="auto", interpolation="nearest", vmin=-0.5, vmax=3.5
        )
        axes.set_yticks(range(len(ENGINES)), list(ENGINES))
        start, ticks = -0.5, {}
        for group, members in groupby(names, key=lambda case: "-".join(case.split("-")[:2])):
            edge = start + len(list(members))
            axes.axvline(edge, color="0.8", linewidth=0.4)
            if edge - start > 2.5:  # a group of one or two is too narrow for its name
                ticks[(start + edge) / 2] = group.removeprefix("hard-")
            start = edge
        axes.set_xticks(list(ticks), list(ticks.values()), rotation=90, fontsize="x-small")
        axes.grid(visible=False)
        bar = axes.figure.colorbar(image, ax=axes, ticks=range(4), shrink=0.6)
        bar.ax.set_yticklabels(VERDICTS)
    return report.render("stability", globals(), cases=len(cases), frame=frame)


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
        return ("declined" if result.outcome is None else "wrong"), math.nan, math.nan
    expected, found = dict(numbers(case.expected)), dict(numbers(result))
    path = next((path for path in decisive(case.expected) if path in expected), None)
    if path not in found:
        return ("right" if path is None else "short"), math.nan, math.nan
    truth = exactly(expected[path])
    error, attainable = abs(exactly(found[path]) - truth), case.attainable(path)
    size = float(abs(truth)) or 1.0
    verdict = "right" if float(error) <= ALLOWED * attainable else "short"
    return verdict, digits_of(float(error) / size), digits_of(attainable / size)


def exactly(number: Number | int) -> Decimal:
    """Return a number of a result as it is."""
    return Decimal(number) if isinstance(number, float | int) else Decimal(number.value)


def digits_of(relative_error: float) -> float:
    """Return how many digits a relative error leaves, from 0 to those of the golden values."""
    return max(0.0, -math.log10(max(relative_error, 10**-MOST_DIGITS)))
