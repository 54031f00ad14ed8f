"""The verdict as one page of HTML with its pictures in it."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Iterator, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jinja2 import Environment

from longball.convergence.figure import draw_convergence
from longball.engines.chain import solve_with_path
from longball.engines.ivp import Ivp
from longball.extras import naming_extras
from longball.judge import text
from longball.judge.answers import printable, quoted
from longball.judge.evaluation import Evaluation
from longball.judge.quantities import values_of
from longball.judge.verdict import Comparison, Measured
from longball.model.arrays import Array
from longball.model.scene import ImpactScene

if TYPE_CHECKING:
    from matplotlib.figure import Figure


SHOWN = 20  # failures and issues on the page
NOTHING = 1e-17  # where a relative error of zero is drawn on a logarithmic axis
WIDTH, DPI = 5.2, 150  # of pictures, inches: their letters can be read on a narrow screen
WHOLE = 1.0  # where one is drawn that is as large as its quantity, or larger


def page(evaluation: Evaluation) -> str:
    """Return an evaluation as HTML that needs no other file."""
    source = (Path(__file__).parent / "page.html.j2").read_text(encoding="utf-8")
    template = Environment(autoescape=True, trim_blocks=True).from_string(source)
    html: str = template.render(
        v=evaluation.verdict, pictures=list(_pictures(evaluation)), shown=SHOWN,
        text=text, quoted=quoted, printable=printable,
    )  # fmt: skip
    return html


def _pictures(evaluation: Evaluation) -> Iterator[tuple[str, str]]:
    report = evaluation.verdict.convergence
    worst = worst_flight(evaluation.comparisons)
    if worst:
        title = f"The worst flight against the truth: {worst.case.id}"
        yield title, _image(lambda figure: draw_flight(figure, worst), 5.4)
    measured = [(c, m) for c in evaluation.comparisons for m in c.measured if m.size > 0]
    if measured:
        title = "Errors by family, and over difficulty"
        yield title, _image(lambda figure: draw_errors(figure, measured), 6.4)
    if report is not None:
        yield "Orders", _image(lambda f: draw_convergence(f.add_subplot(), report), 4.2)


@naming_extras()
def _image(draw: Callable[[Figure], None], height: float) -> str:
    """Return a figure of that height, inches, as an image that a telephone can show."""
    # Without pyplot, which needs a display on some machines and keeps every figure.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    FigureCanvasAgg(figure)
    draw(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI)
    data = base64.b64encode(buffer.getvalue()).decode()
    return f"data:image/png;base64,{data}"


def draw_errors(figure: Figure, measured: Sequence[tuple[Comparison, Measured]]) -> None:
    """Draw relative errors by family (left), and over what is attainable (right)."""
    left, right = figure.subplots(2, 1)
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
    none = f"(none: at {NOTHING:g}; larger than it: at 1)"
    left.set_xlabel(f"error, relative to the quantity\n{none}")
    figure.legend(loc="outside upper left", ncols=2, frameon=False, fontsize="small")
    if known := [_relative(m.attainable, m) for _, m in measured if m.attainable > 0]:
        ends = np.array([min(known) / 2, max(known) * 2])
        right.plot(ends, ends, "k-", linewidth=0.8, label="as good as doubles can be")
        right.legend(fontsize="small", frameon=False, loc="center right")
    right.set_xscale("log")
    right.set_yscale("log")
    right.tick_params(axis="x", which="minor", labelbottom=False)  # on a short axis they overlap
    difficulty = "difficulty: error that double precision\ncannot avoid, relative to the quantity"
    right.set_xlabel(difficulty)
    right.set_ylabel("error, relative to the quantity")


def _relative(error: float, measured: Measured) -> float:
    """Return an error relative to its quantity, as far as a logarithmic axis shows it."""
    return min(max(error / measured.size, NOTHING), WHOLE)


def worst_flight(comparisons: Sequence[Comparison]) -> Comparison | None:
    """Return the failed comparison of a ball in flight that is farthest off; None if none is."""
    wrong = (c for c in comparisons if not c.passed and c.answer)
    found = [c for c in wrong if not isinstance(c.case.scene, ImpactScene)]

    def off(comparison: Comparison) -> tuple[float, float]:
        errors = {m.quantity: m.error for m in comparison.measured}
        places = [e for n, e in errors.items() if n.endswith(".position")]
        return errors.get("landing.position", -1.0), max(places, default=0.0)

    return max(found, key=off, default=None)


def draw_flight(figure: Figure, comparison: Comparison) -> None:
    """Draw a true flight from the side and from above, with a candidate's points."""
    # The errors have a separate panel: a centimetre is invisible in a hundred metres.
    assert comparison.answer is not None
    side, above, off = figure.subplots(3, 1, height_ratios=(3, 2, 2))
    above.sharex(side)
    for i, (label, points) in enumerate(_paths(comparison)):
        side.plot(points[0], points[2], ("k-", "k--")[i], linewidth=1, label=f"truth, {label}")
        above.plot(points[0], points[1], ("k-", "k--")[i], linewidth=1)
    truth = values_of(comparison.case.expected)
    rows: list[tuple[str, list[float]]] = []
    for block, marker in zip(("plate", "contact", "landing"), "s^o", strict=True):
        given = comparison.answer.values.get(f"{block}.position")
        if given is None:
            continue
        x, y, z = map(float, given)
        for axes, height in ((side, z), (above, y)):
            axes.plot(x, height, marker, mfc="none", mec="C3", ms=8, ls="none", clip_on=False,
                      label=f"candidate, {block}" if axes is side else None)  # fmt: skip
        expected = truth.get(f"{block}.position")
        if expected is not None:
            rows.append((block, [float(a - b) for a, b in zip(given, expected, strict=True)]))
    for i, (_, errors) in enumerate(rows):
        for j, error in enumerate(errors):
            axis = "xyz"[j] if i == 0 else None
            off.barh(i + 0.25 * (1 - j), error, height=0.22, color=f"C{j}", label=axis)
    if rows:
        off.set_yticks(range(len(rows)), [name for name, _ in rows])
        off.legend(fontsize="small", frameon=False, ncols=3)
    off.set_xlabel("candidate - truth, m")
    outcome = comparison.answer.outcome or "no outcome"
    title = f"expected {comparison.case.expected.outcome}, candidate: {outcome}"
    side.set_title(title, fontsize="medium")
    side.set_ylabel("height z, m")
    above.set_ylabel("aside y, m")
    above.set_xlabel("x, m: from the plate (0) towards the pitcher")
    side.legend(fontsize="small", frameon=False, loc="best")


def _paths(comparison: Comparison) -> Iterator[tuple[str, Array]]:
    """Yield the true pitch and the true flight as points: x, y and z, m."""
    scene = comparison.case.scene
    _, trajectory = solve_with_path(scene, Ivp())
    legs = trajectory.legs
    for leg, after in zip_longest(legs, legs[1:]):
        seconds = after.begin if after else leg.flight.time
        name = "batted ball" if leg.begin else "flight" if scene.kind == "flight" else "pitch"
        times = np.linspace(0.0, seconds, 200).tolist()
        yield name, np.array([*map(leg.frame.position, map(leg.flight.path.at, times))]).T
