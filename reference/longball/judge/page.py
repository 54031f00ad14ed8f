"""The verdict as one page of HTML with its pictures in it."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Iterable, Iterator, Sequence
from html import escape
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from longball.convergence.figure import draw_convergence
from longball.engines.chain import solve_with_path
from longball.engines.ivp import Ivp
from longball.extras import naming_extras
from longball.judge.answers import quoted
from longball.judge.evaluation import Evaluation
from longball.judge.quantities import Value, values_of
from longball.judge.text import ERRORS, LONGEST_NAME, counts, describe, error_cells, silence
from longball.judge.verdict import Comparison, Measured, Verdict
from longball.model.scene import ImpactScene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

SHOWN = 20  # failures and issues on the page
NOTHING = 1e-17  # where a relative error of zero is drawn on a logarithmic axis
WHOLE = 1.0  # where one is drawn that is as large as its quantity, or larger

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; max-width: 68em; margin: 2em auto; padding: 0 1em;
  color: #222 }
h1 { font-size: 1.4em } h2 { font-size: 1.1em; margin-top: 2em }
.passed { color: #1a6b2f } .failed { color: #a3201c }
table { border-collapse: collapse; font-size: 13px } th { text-align: left; font-weight: 600 }
td, th { padding: .15em .7em .15em 0; border-bottom: 1px solid #ddd; vertical-align: top }
td.n { text-align: right; font-variant-numeric: tabular-nums }
img { max-width: 100% } pre, code { font-size: 12px; white-space: pre-wrap; word-break: break-word }
"""


def page(evaluation: Evaluation) -> str:
    """Return an evaluation as HTML that needs no other file."""
    verdict = evaluation.verdict
    candidate = escape(quoted(verdict.candidate, LONGEST_NAME))
    word = "passed" if verdict.passed else "failed"
    parts = [
        "<!doctype html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{candidate}: {word}</title><style>{STYLE}</style></head><body>",
        f'<h1><span class="{word}">{word.upper()}</span> {candidate}</h1>',
        *_head(verdict),
        *_diagnosis(verdict),
        *_pictures(evaluation),
        *_convergence(verdict),
        *_sampling(verdict),
        *_errors(verdict),
        *_failures(verdict),
        *_rest(verdict),
        "</body></html>",
    ]
    return "\n".join(parts) + "\n"


# --- words ----------------------------------------------------------------------------------------


def _head(verdict: Verdict) -> Iterator[str]:
    if verdict.cases:
        yield from _list(counts(verdict))
        yield (
            f"<p>Contacts missed {len(verdict.contacts_missed)}, "
            f"invented {len(verdict.contacts_invented)}.</p>"
        )
    yield from _list(verdict.reasons)


def _diagnosis(verdict: Verdict) -> Iterator[str]:
    diagnosis = verdict.diagnosis
    if diagnosis is None:
        return
    yield f"<h2>Diagnosis</h2><p>{escape(diagnosis.sentence)}</p>"
    rows = [
        (
            s.name,
            "" if s.share is None else f"{max(0.0, s.share):.1%}",
            s.sentence,
            s.remedy,
            ", ".join(s.twins),
        )
        for s in diagnosis.suspects
    ]
    if rows:
        head = ("suspect", "explains alone", "what it does", "how to mend it", "twins")
        yield from _table(head, rows, numbers=(1,))
    if diagnosis.invisible:
        yield f"<p>Not to be seen in these scenes: {escape(', '.join(diagnosis.invisible))}.</p>"


def _convergence(verdict: Verdict) -> Iterator[str]:
    report = verdict.convergence
    if report is None:
        return
    yield "<h2>Convergence: a family of time steps against the truth</h2>"
    yield _image(lambda figure: draw_convergence(figure.add_subplot(), report), (7, 4.6), "orders")
    yield f"<pre>{escape(report.text())}</pre>"


def _sampling(verdict: Verdict) -> Iterator[str]:
    sampling = verdict.sampling
    if sampling is None:
        return
    yield f"<h2>Sampling: {sampling.at_bats} different at-bats of {escape(sampling.source)}</h2>"
    rows = [
        ("right" if found.right else "WRONG", found.sentence, ", ".join(found.named))
        for found in sampling.found
    ]
    yield from _table(("", "beside the paper's", "known mistakes"), rows, numbers=())


def _errors(verdict: Verdict) -> Iterator[str]:
    if not verdict.rows:
        return
    yield "<h2>Errors</h2>"
    yield from _table(ERRORS, map(error_cells, verdict.rows), numbers=(2, 3, 4, 5, 7, 8, 9, 10))
    confused = [(c.expected, c.obtained, str(c.cases)) for c in verdict.outcomes]
    yield "<h2>Outcomes</h2>"
    yield from _table(("expected", "obtained", "scenes"), confused, numbers=(2,))


def _failures(verdict: Verdict) -> Iterator[str]:
    if not verdict.failures:
        return
    shown = verdict.failures[:SHOWN]
    yield f"<h2>Wrong answers, the worst first ({len(shown)} of {len(verdict.failures)})</h2>"
    for failure in shown:
        flags = f" [{', '.join(failure.flags)}]" if failure.flags else ""
        yield f"<details><summary>{escape(failure.id + flags)}</summary>"
        yield from _list(describe(fault) for fault in failure.faults)
        yield f"<pre>{escape(str(failure.scene))}</pre></details>"


def _rest(verdict: Verdict) -> Iterator[str]:
    sentences = [*silence(verdict, SHOWN), *(f"issue: {c}" for c in verdict.complaints[:SHOWN])]
    if sentences:
        yield "<h2>Other findings</h2>"
        yield from _list(sentences)
    if verdict.complaints and verdict.standard_error:
        yield f"<h2>The end of its standard error</h2><pre>{escape(verdict.standard_error)}</pre>"


def _list(sentences: Iterable[str]) -> Iterator[str]:
    items = [f"<li>{escape(sentence)}</li>" for sentence in sentences]
    if items:
        yield f"<ul>{''.join(items)}</ul>"


def _table(
    head: Sequence[str], rows: Iterable[Sequence[str]], numbers: Sequence[int]
) -> Iterator[str]:
    yield "<table><tr>" + "".join(f"<th>{escape(cell)}</th>" for cell in head) + "</tr>"
    for row in rows:
        cells = (
            f'<td class="n">{escape(cell)}</td>' if i in numbers else f"<td>{escape(cell)}</td>"
            for i, cell in enumerate(row)
        )
        yield f"<tr>{''.join(cells)}</tr>"
    yield "</table>"


# --- pictures -------------------------------------------------------------------------------------


def _pictures(evaluation: Evaluation) -> Iterator[str]:
    measured = [(c, m) for c in evaluation.comparisons for m in c.measured if m.size > 0]
    if not measured:
        return
    yield "<h2>Errors by family, and over difficulty</h2>"
    yield _image(lambda figure: draw_errors(figure, measured), (10, 4.6), "errors")
    worst = worst_flight(evaluation.comparisons)
    if worst:
        yield f"<h2>The worst flight against the truth: {escape(worst.case.id)}</h2>"
        yield _image(lambda figure: draw_flight(figure, worst), (10, 4.6), "the worst flight")


@naming_extras()
def _image(draw: Callable[[Figure], None], size: tuple[float, float], what: str) -> str:
    # A figure of its own, without pyplot: no display is asked for, and no state is left.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    draw(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    data = base64.b64encode(buffer.getvalue()).decode()
    return f'<p><img alt="{what}" src="data:image/png;base64,{data}"></p>'


def draw_errors(figure: Figure, measured: Sequence[tuple[Comparison, Measured]]) -> None:
    """Draw relative errors by family (left), and over what is attainable (right)."""
    left, right = figure.subplots(1, 2)
    families = list(dict.fromkeys(c.case.family for c, _ in measured))
    spread = np.random.default_rng(0)  # so that points do not hide each other
    for passed, marker, colour in ((True, "o", "0.55"), (False, "x", "black")):
        points = [(c, m) for c, m in measured if m.passed is passed]
        if not points:
            continue
        errors = [_relative(m.error, m) for _, m in points]
        label = f"{'within' if passed else 'beyond'} tolerance ({len(points)})"
        style = {"marker": marker, "color": colour, "s": 14, "linewidths": 0.8}
        rows = [families.index(c.case.family) + spread.uniform(-0.3, 0.3) for c, _ in points]
        left.scatter(errors, rows, label=label, **style)
        attainable = [_relative(m.attainable, m) for _, m in points]
        right.scatter(attainable, errors, **style)
    left.set_xscale("log")
    left.set_yticks(range(len(families)), families)
    left.invert_yaxis()
    left.set_xlabel(
        f"error, relative to the quantity\n(none: at {NOTHING:g}; larger than it: at 1)"
    )
    figure.legend(loc="outside upper left", ncols=2, frameon=False, fontsize="small")
    _draw_attainable(right, [_relative(m.attainable, m) for _, m in measured if m.attainable > 0])


def _relative(error: float, measured: Measured) -> float:
    """Return an error relative to its quantity, as far as a logarithmic axis shows it."""
    return min(max(error / measured.size, NOTHING), WHOLE)


def _draw_attainable(axes: Axes, attainable: Sequence[float]) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    if attainable:
        ends = np.array([min(attainable) / 2, max(attainable) * 2])
        axes.plot(ends, ends, "k-", linewidth=0.8, label="as good as doubles can be")
        axes.legend(fontsize="small", frameon=False, loc="center right")
    axes.set_xlabel(
        "difficulty: error that double precision\ncannot avoid, relative to the quantity"
    )
    axes.set_ylabel("error, relative to the quantity")


def worst_flight(comparisons: Sequence[Comparison]) -> Comparison | None:
    """Return the failed comparison of a ball in flight that is farthest off; None if none is."""
    found = [
        c
        for c in comparisons
        if not c.passed and c.answer and not isinstance(c.case.scene, ImpactScene)
    ]  # fmt: skip

    def off(comparison: Comparison) -> tuple[float, float]:
        errors = {m.quantity: m.error for m in comparison.measured}
        return (
            errors.get("landing.position", -1.0),
            max((e for n, e in errors.items() if n.endswith(".position")), default=0.0),
        )

    return max(found, key=off, default=None)


def draw_flight(figure: Figure, comparison: Comparison) -> None:
    """Draw a true flight from the side and from above, and where the candidate puts its points."""
    assert comparison.answer is not None
    side, above = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    for i, (label, points) in enumerate(_paths(comparison)):
        side.plot(points[0], points[2], ("k-", "k--")[i], linewidth=1, label=f"truth, {label}")
        above.plot(points[0], points[1], ("k-", "k--")[i], linewidth=1)
    truth = values_of(comparison.case.expected)
    labels = {
        "plate.position": "plate",
        "contact.position": "contact",
        "landing.position": "landing",
    }
    for (name, label), marker in zip(labels.items(), "s^o", strict=True):
        given = comparison.answer.values.get(name)
        if given is None:
            continue
        x, y, z = map(float, given)
        for axes, height in ((side, z), (above, y)):
            axes.plot(x, height, marker, mfc="none", mec="C3", ms=8, ls="none",
                      label=f"candidate, {label}" if axes is side else None)  # fmt: skip
        _draw_error(side, above, truth.get(name), given)
    outcome = comparison.answer.outcome or "no outcome"
    title = f"expected {comparison.case.expected.outcome}, candidate: {outcome}"
    errors = {m.quantity: m.error for m in comparison.measured}
    if "landing.position" in errors:
        title += f"; it lands {errors['landing.position']:.2g} m off"
    side.set_title(title, fontsize="medium")
    side.set_ylabel("height z, m")
    above.set_ylabel("aside y, m")
    above.set_xlabel("x, m: from the plate (0) toward the pitcher")
    side.legend(fontsize="small", frameon=False, loc="best")


def _draw_error(side: Axes, above: Axes, expected: Value | None, given: Value) -> None:
    if expected is None:
        return
    (x0, y0, z0), (x1, y1, z1) = map(float, expected), map(float, given)
    first = not any(line.get_label() == "error" for line in side.lines)
    side.plot([x0, x1], [z0, z1], "C3:", linewidth=2, label="error" if first else None)
    above.plot([x0, x1], [y0, y1], "C3:", linewidth=2)


def _paths(comparison: Comparison) -> Iterator[tuple[str, Array]]:
    """Yield the true pitch and the true flight as points: x, y and z, m."""
    scene = comparison.case.scene
    _, trajectory = solve_with_path(scene, Ivp())
    legs = trajectory.legs
    for leg, after in zip_longest(legs, legs[1:]):
        seconds = after.begin if after else leg.flight.time
        name = "batted ball" if leg.begin else "flight" if scene.kind == "flight" else "pitch"
        times = np.linspace(0.0, seconds, 200).tolist()
        yield name, np.array([*map(leg.frame.position, leg.flight.path.sample(times))]).T
