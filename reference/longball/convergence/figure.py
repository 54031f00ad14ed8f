"""Figure of a convergence report."""

from __future__ import annotations

from typing import TYPE_CHECKING

from longball.convergence.report import ConvergenceReport

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_convergence(axes: Axes, report: ConvergenceReport) -> None:
    """Draw error against step for every quantity: fitted steps filled, the others hollow."""
    # Quantities may have the same errors, as distance and landing point do: later markers are
    # smaller.
    for size, order, marker in zip(range(9, 2, -1), report.orders, "osD^v<>", strict=False):
        label = order.quantity
        fitted = [(step, error) for step, error, use in order.errors if use == "fitted"]
        if order.order is not None and order.constant is not None:
            label += f", order {order.order:.2f}"
            line = [order.constant * step**order.order for step, _ in fitted]
            axes.plot([step for step, _ in fitted], line, "-", color="0.6", linewidth=1, zorder=1)
        steps, errors = [e[0] for e in order.errors], [e[1] for e in order.errors]
        (drawn,) = axes.plot(steps, errors, marker, markersize=size, markerfacecolor="none")
        steps, errors = [e[0] for e in fitted], [e[1] for e in fitted]
        axes.plot(steps, errors, marker, markersize=size, color=drawn.get_color(), label=label)
    axes.set(xscale="log", yscale="log", xlabel="step, s", ylabel="error, SI units")
    # Matplotlib's labels of minor ticks, such as 3 × 10⁻², overlap over one or two decades.
    axes.xaxis.set_minor_formatter(lambda x, _: f"{x:g}" if f"{x:e}"[0] in "25" else "")
    axes.xaxis.set_major_formatter("{x:g}")
    axes.legend(fontsize="small", frameon=False)
