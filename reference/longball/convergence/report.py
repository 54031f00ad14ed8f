"""Report of a family of time steps, as JSON, CSV and text."""

from __future__ import annotations

import csv
import io
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from longball.text_table import aligned


class Frozen(BaseModel):
    """A part of a report; its numbers are finite, because JSON has no others."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


Use = Literal["fitted", "pre-asymptotic", "floor", "no range", "no error"]
OrderVerdict = Literal[
    "as expected", "other order", "wrong limit", "exact", "not resolved", "no expectation"
]

# Verdicts that make `longball converge` fail.
BAD: tuple[OrderVerdict, ...] = ("other order", "wrong limit", "not resolved")


class Level(Frozen):
    """A step of the family, for one quantity."""

    step: float = Field(description="s")
    error: float | None = Field(description="typical of all scenes; null if none has one")
    scenes: int = Field(description="that have an error here")
    phases: int = Field(description="of the step, that the error is the root mean square of")
    use: Use = Field(description="whether the order is fitted to it, and if not, why")


class Order(Frozen):
    """Convergence of one quantity."""

    quantity: str
    unit: str
    order: float | None = Field(description="observed; null if there is no asymptotic range")
    low: float | None = Field(description="of the 95 % interval of the order")
    high: float | None
    constant: float | None = Field(description="C of the error C h^p, in unit/s^p")
    expected: float | None
    jump: float = Field(description="change of the error with the step's phase, relative")
    jumps: bool = Field(description="whether it was averaged over phases for that")
    rungs: tuple[Level, ...]
    verdict: OrderVerdict
    why: str

    @property
    def errors(self) -> list[tuple[float, float, Use]]:
        """Steps with an error: the step, s, the error, and its use in the fit."""
        return [(r.step, r.error, r.use) for r in self.rungs if r.error is not None]


class Limit(Frozen):
    """The value at h = 0 of one quantity of one scene, by Richardson's extrapolation."""

    scene: str
    quantity: str
    value: tuple[float, ...]
    error: float = Field(description="estimated: the change that one more step made")
    off: float | None = Field(description="distance from the truth; null if there is none")


class Lost(Frozen):
    """A step, and the number of scenes with a wrong outcome or none."""

    step: float
    lost: int
    of: int


class ConvergenceReport(Frozen):
    """Convergence in a family of steps."""

    engine: str | None = Field(description="as the implementation names itself")
    against_truth: bool = Field(description="whether errors are against a truth, or a finest step")
    orders: tuple[Order, ...] = Field(description="one for each quantity")
    limits: tuple[Limit, ...] = Field(description="extrapolated, by scene and quantity")
    lost: tuple[Lost, ...] = Field(description="steps at which scenes ended otherwise")

    @property
    def passed(self) -> bool:
        """True if no verdict is bad, and at least one quantity was measured."""
        return bool(self.orders) and not any(order.verdict in BAD for order in self.orders)

    @property
    def faults(self) -> list[str]:
        """Return the faults. Without an expected order, only a wrong limit is one."""
        if not self.orders:
            return ["no answer has a quantity that could converge"]
        return [
            f"{order.quantity}: {order.verdict}"
            for order in self.orders
            if order.verdict == "wrong limit" or (order.expected and order.verdict in BAD)
        ]

    def text(self) -> str:
        """Return the report as text: a table, a sentence for each quantity, and lost scenes."""
        head = ("quantity", "order", "95 %", "expected", "C", "steps fitted, s", "verdict")
        lines = aligned([head, *(_row(order) for order in self.orders)])
        lines += ["", *(f"{order.quantity}: {order.why}" for order in self.orders)]
        # Scenes without the right outcome at a step contribute nothing to its errors. A program
        # that refuses a kind loses the same scenes at every step: one line for all.
        lost = {row.step: f"{row.lost} of {row.of} scenes" for row in self.lost if row.lost}
        where = {step: f"step {step:.3g} s" for step in lost}
        if len({*lost.values()}) == 1 and len(lost) == len(self.lost):
            where = {next(iter(lost)): "every step"}
        lines += [f"{at}: {lost[h]} refused, or with a wrong outcome" for h, at in where.items()]
        return "\n".join(lines) + "\n"

    def csv(self) -> str:
        """Return every step of every quantity as a table."""
        out = io.StringIO()
        write = csv.writer(out, lineterminator="\n").writerow
        write(["quantity", "unit", "step_s", "error", "scenes", "phases", "use"])
        for order in self.orders:
            for level in order.rungs:
                error = "" if level.error is None else repr(level.error)
                row = (order.quantity, order.unit, repr(level.step), error)
                write([*row, level.scenes, level.phases, level.use])
        return out.getvalue()


def _row(order: Order) -> tuple[str, ...]:
    expected = "" if order.expected is None else f"{order.expected:g}"
    if order.order is None or order.constant is None:
        return (order.quantity, "", "", expected, "", "", order.verdict)
    fitted = [step for step, _, use in order.errors if use == "fitted"]
    constant = f"{order.constant:.3g} {order.unit}/s^{order.order:.2f}"
    interval = f"{order.low:.3f} to {order.high:.3f}"
    steps = f"{max(fitted):.2g} to {min(fitted):.2g}"
    return order.quantity, f"{order.order:.3f}", interval, expected, constant, steps, order.verdict
