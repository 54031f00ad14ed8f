"""Simulators that install from a package index, held against the golden data."""

import io
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from analysis.wild.simulators import SIMULATORS, Method, Simulator
from analysis.writing import Report
from longball.convergence import PowerLaw, fit_power_law
from longball.convergence.order import typical
from longball.golden import load
from longball.judge.cases import Case, Exact
from longball.judge.diagnosis.findings import Diagnosis
from longball.judge.evaluation import Evaluation, Judge
from longball.judge.fresh import proven
from longball.judge.serve import serve
from longball.judge.step_sweep import sample
from longball.judge.verdict import Comparison, Measured, right_digits
from longball.model.arrays import Array
from longball.model.quantities import replaced
from longball.model.scene import Scene

SCENES = 10  # that are about enough to show what a method does
PLACES = ("landing.position", "plate.position")


class Tried(NamedTuple):
    """A method of a simulator, held against the truth."""

    simulator: Simulator
    method: Method
    evaluation: Evaluation  # as it is usually run, in scenes with its own constants
    diagnosis: Diagnosis | None  # of the golden scenes; None if it was not asked for
    steps: Array  # the method's, s
    errors: Array  # of the place at each of them, m, typical of all scenes
    law: PowerLaw | None  # how the errors fall; None if no range of steps shows it

    @property
    def name(self) -> str:
        """Simulator and method."""
        return f"{self.simulator.title}, {self.method.name}"

    @property
    def places(self) -> list[Measured]:
        """Where balls land or cross the plate, beside the truth."""
        return [m for c in self.evaluation.comparisons for m in places(c)]

    @property
    def digits(self) -> list[float]:
        """Number of right digits."""
        return [right_digits(m.error, m.size) for m in self.places if m.size]


def run(report: Report, full: bool) -> str:
    """Judge what is installed, draw errors and orders, and say what is not installed."""
    there = [simulator for simulator in SIMULATORS if simulator.version]
    tried = [tried for simulator in there for tried in trials(simulator, full)]
    stepped = [t for t in tried if t.method.order]
    rows = [
        (t.name, t.method.order or 0, *((t.law.order, t.law.half_width) if t.law else (None, 0.0)))
        for t in stepped
    ]
    draw_orders(report, rows)
    return report.render("wild", globals(), there=there, tried=tried)


def draw_orders(report: Report, rows: Sequence[tuple[str, float, float | None, float]]) -> None:
    """Draw the observed order of each method, with its half width, beside the one in theory."""
    with report.figure("wild_orders", size=(6.4, 4.4)) as (axes,):
        names, claimed, seen, halves = zip(*rows, strict=True)
        places = np.arange(len(names))
        style: Any = {"linestyle": "none", "color": "0.5", "markersize": 10, "fillstyle": "none"}
        axes.plot(claimed, places, "s", **style, label="order in theory")
        known = [i for i, order in enumerate(seen) if order is not None]
        axes.errorbar(
            [seen[i] for i in known], known, xerr=[halves[i] for i in known], fmt="o",
            color="black", markersize=5, label="order observed (95 %)",
        )  # fmt: skip
        for i, order in enumerate(seen):
            if order is None:
                axes.text(0.1, i, "none observed", va="center")
        axes.set_yticks(places, names)
        axes.set(xlabel="order of convergence", xlim=(0.0, 6.5))
        axes.invert_yaxis()
        axes.legend(loc="lower center", bbox_to_anchor=(0.35, 1.0), ncols=2)


def trials(simulator: Simulator, full: bool) -> list[Tried]:
    """Hold each method of a simulator against the scenes that it can take."""
    sampled = sample(load(), simulator.families)
    cases: Sequence[Case] = [x for x in sampled if x.expected.outcome in ("landed", "crossed")]
    cases = cases if full else cases[:: max(1, len(cases) // SCENES)]
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
    sweep = replace(judge, cases=own[::2])
    runs = [candidate(simulator, method, knob) for knob in method.knobs]
    errors = [list(map(place_error, sweep.evaluate_function(run).comparisons)) for run in runs]
    off = typical(np.array(errors).T) if errors else np.empty(0)
    steps = np.array(method.knobs) * method.second
    law = fit_power_law(steps, off) if errors else None
    evaluation = judge.evaluate_function(usual)
    return Tried(simulator, method, evaluation, diagnosis, steps, off, law)


def candidate(simulator: Simulator, method: Method, knob: float) -> Callable[[Scene], Any]:
    """Return a simulator as a function from a scene to its answer."""
    fly = import_module(simulator.module).fly

    def answer(scene: Scene) -> Any:
        out = io.StringIO()
        serve(lambda state, p: fly(state, p, method.word, knob), [scene.model_dump_json()], out)
        return json.loads(out.getvalue())

    return answer


def places(comparison: Comparison) -> list[Measured]:
    """Return the place of landing, or at the plate, beside the truth, where there is one."""
    return [m for m in comparison.measured if m.quantity in PLACES]


def place_error(comparison: Comparison) -> float:
    """Return the error of a place of landing, or at the plate, m."""
    return next((m.error for m in places(comparison)), math.nan)


def adapter_lines(simulator: Simulator) -> int:
    """Count the lines of code of an adapter, without imports, docstring and blanks."""
    path = Path(__file__).parent / "adapters" / f"{simulator.module.rpartition('.')[2]}.py"
    lines = path.read_text(encoding="utf-8").split('"""', 2)[2].splitlines()
    return sum(bool(x.strip()) and not x.startswith(("import ", "from ")) for x in lines)
