"""Simulators that install from a package index, held against the golden data."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.wild.simulators import SIMULATORS, Method, Simulator
from analysis.writing import figure, render, shown, table
from longball.convergence import PowerLaw, fit_power_law
from longball.convergence.order import typical
from longball.golden import load
from longball.judge.cases import Case, Exact
from longball.judge.evaluation import Evaluation, Judge
from longball.judge.findings import Diagnosis
from longball.judge.fresh import proven
from longball.judge.serve import serve
from longball.judge.step_sweep import sample
from longball.judge.verdict import Comparison
from longball.model.quantities import replaced
from longball.model.scene import Scene

Array = NDArray[np.float64]

SCENES = 10  # that are about enough to show what a method does
PLACES = ("landing.position", "plate.position")


@dataclass(frozen=True)
class Tried:
    """A method of a simulator, held against the truth.

    Attributes
    ----------
    evaluation
        As it is usually run, in scenes with its own constants.
    diagnosis
        What is said of the golden scenes; None if it was not asked.
    errors
        Of the place of landing at each of the method's steps, m, typical of all scenes.
    """

    simulator: Simulator
    method: Method
    evaluation: Evaluation
    diagnosis: Diagnosis | None
    errors: Array

    @property
    def name(self) -> str:
        """Simulator and method."""
        return f"{self.simulator.title}, {self.method.name}"

    @property
    def steps(self) -> Array:
        """The method's steps, s."""
        return np.array(self.method.knobs) * self.method.second

    @property
    def law(self) -> PowerLaw | None:
        """How the errors fall; None if no range of steps shows it."""
        return fit_power_law(self.steps, self.errors) if len(self.errors) else None


def run(report: Path, full: bool) -> str:
    """Judge what is installed, and say what is not."""
    there = [simulator for simulator in SIMULATORS if simulator.version]
    tried = [tried for simulator in there for tried in trials(simulator, full)]
    draw(report, tried)
    return render(
        report,
        "wild",
        missing=[simulator.title for simulator in SIMULATORS if simulator not in there],
        simulators=table(report, "wild_simulators", simulator_table(there)),
        agreement=table(report, "wild_agreement", agreement_table(tried)),
        orders=table(report, "wild_orders", order_table(tried)),
        orders_figure=shown("wild_orders", CAPTION),
        diagnoses=table(report, "wild_diagnoses", diagnosis_table(tried)),
        remarks=[(s.title, s.remark) for s in there if s.remark],
    )


def trials(simulator: Simulator, full: bool) -> list[Tried]:
    """Hold each method of a simulator against the scenes that it can take."""
    cases: Sequence[Case] = [
        case
        for case in sample(load(), simulator.families)
        if case.expected.outcome in ("landed", "crossed")
    ]
    if not full:
        cases = cases[:: max(1, len(cases) // SCENES)]
    own = cases
    if simulator.constants:
        own = proven([replaced(case.scene, simulator.constants) for case in cases])
    return [trial(simulator, method, cases, own) for method in simulator.methods]


def trial(
    simulator: Simulator, method: Method, cases: Sequence[Case], own: Sequence[Case]
) -> Tried:
    """Judge a method as it is usually run, and see how it converges.

    Only the first of a simulator is diagnosed, which takes longest.
    """
    usual, diagnosis = candidate(simulator, method, method.usual), None
    if method is simulator.methods[0]:
        step = method.usual * method.second if method.order else None
        judge = Judge(cases, Exact(), partial=True, dt=step)
        diagnosis = judge.evaluate_function(usual).verdict.diagnosis
    judge = Judge(own, Exact(), partial=True, diagnose=False)
    evaluation = judge.evaluate_function(usual)
    sweep = replace(judge, cases=own[::2])
    runs = [candidate(simulator, method, knob) for knob in method.knobs]
    errors = [list(map(place_error, sweep.evaluate_function(run).comparisons)) for run in runs]
    typically = typical(np.array(errors).T) if errors else np.empty(0)
    return Tried(simulator, method, evaluation, diagnosis, typically)


def candidate(simulator: Simulator, method: Method, knob: float) -> Callable[[Scene], Any]:
    """Return a simulator as a function from a scene to its answer."""
    fly = import_module(simulator.module).fly

    def answer(scene: Scene) -> Any:
        out = io.StringIO()
        serve(lambda state, p: fly(state, p, method.word, knob), [scene.model_dump_json()], out)
        return json.loads(out.getvalue())

    return answer


def place_error(comparison: Comparison) -> float:
    """Return how far off a place of landing, or at the plate, is, m."""
    return next((m.error for m in comparison.measured if m.quantity in PLACES), math.nan)


def simulator_table(simulators: Sequence[Simulator]) -> pd.DataFrame:
    """Return what was tried, and how."""
    return pd.DataFrame(
        {
            "simulator": f"{s.title} {s.version}",
            "licence": s.licence,
            "made for": s.purpose,
            "what was put in": s.adapted,
            "scenes": ", ".join(s.families),
            "adapter, lines": adapter_lines(s),
        }
        for s in simulators
    )


def adapter_lines(simulator: Simulator) -> int:
    """Return how many lines of code an adapter has: without imports, docstring and blanks."""
    path = Path(__file__).parent / "adapters" / f"{simulator.module.rpartition('.')[2]}.py"
    text = path.read_text(encoding="utf-8").split('"""', 2)[2]
    return sum(
        bool(line.strip()) and not line.startswith(("import ", "from "))
        for line in text.splitlines()
    )


def agreement_table(tried: Sequence[Tried]) -> pd.DataFrame:
    """Return how far off the place of landing, or at the plate, is, and digits of it."""
    rows = []
    for t in tried:
        places = [m for c in t.evaluation.comparisons for m in c.measured if m.quantity in PLACES]
        errors = [m.error for m in places]
        digits = [m.digits for m in places if m.digits is not None]
        rows.append(
            {
                "simulator": t.name,
                "step or tolerance": f"{t.method.usual * t.method.second:.2g}",
                "scenes": len(places),
                "worst, m": f"{max(errors):.1e}" if errors else "",
                "median, m": f"{median(errors):.1e}" if errors else "",
                "digits, median": f"{median(digits):.1f}" if digits else "",
                "digits, worst": f"{min(digits):.1f}" if digits else "",
            }
        )
    return pd.DataFrame(rows)


def order_table(tried: Sequence[Tried]) -> pd.DataFrame:
    """Return claimed and observed orders."""
    rows = []
    for t in tried:
        if t.method.order:
            law = t.law
            rows.append(
                {
                    "simulator": t.name,
                    "claimed": t.method.order,
                    "observed": f"{law.order:.2f}" if law else "none",
                    "95 %": f"{law.low:.2f} to {law.high:.2f}" if law else "",
                    "finest step, s": f"{t.steps[-1]:.2g}",
                    "error there, m": f"{t.errors[-1]:.1e}",
                }
            )
    return pd.DataFrame(rows)


def diagnosis_table(tried: Sequence[Tried]) -> pd.DataFrame:
    """Return what the judge says is behind the errors, of those that were diagnosed."""
    rows = []
    for t in tried:
        if t.diagnosis:
            told = [f"{f.kind}: {f.sentence}" for f in t.diagnosis.findings]
            rows.append({"simulator": t.name, "what the judge says": "; ".join(told)})
    return pd.DataFrame(rows)


CAPTION = (
    "Left: the error of the place of landing, typical of the scenes, by the step. Right: the order "
    "that is claimed, squares, and the one that is observed, in the colours of the left, with its "
    "95 % interval."
)
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "black")
MARKS = "osD^vP*X"


def draw(report: Path, tried: Sequence[Tried]) -> None:
    """Draw errors by the step, and claimed and observed order."""
    stepped = [t for t in tried if t.method.order]
    with figure(report, "wild_orders", columns=2, size=(9.0, 4.4)) as (left, right):
        for row, t in enumerate(stepped):
            style: dict[str, Any] = {
                "color": COLORS[row % len(COLORS)],
                "marker": MARKS[row % len(MARKS)],
            }
            left.loglog(t.steps, t.errors, **style, markersize=4, linewidth=1)
            right.plot(
                [t.method.order or 0], [row], "s", color="0.7", markersize=9, fillstyle="none"
            )
            if law := t.law:
                right.errorbar(law.order, row, xerr=law.half_width, **style, markersize=5)
            else:
                right.text(0.1, row, "none", color=style["color"], va="center")
        left.set(xlabel="step, s", ylabel="error of the place of landing, m")
        right.set_yticks(range(len(stepped)), [t.name for t in stepped])
        right.set(xlabel="order", xlim=(0.0, None))
        right.invert_yaxis()
