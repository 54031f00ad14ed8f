"""The distribution of D and the probability of a home run: the paper's Figs. 6 and 7."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from analysis.writing import figure, shown, table
from longball.home_run import (
    PAPER_CURVES,
    RESTITUTIONS,
    Estimate,
    Struck,
    estimate,
    fit,
    monte_carlo,
    paper_at_bats,
)
from longball.model.readings import SamplingReading
from longball.model.scene import AtBatScene
from longball.pictures import draw_probability

SAMPLES, FULL_SAMPLES = 4_000, 100_000
SEED = 1
BIN = 10.0  # m


def run(report: Path, full: bool) -> str:
    """Sample at-bats, count home runs, draw both figures."""
    base = AtBatScene(id="base")
    count = FULL_SAMPLES if full else SAMPLES
    struck = monte_carlo(
        base, paper_at_bats(SamplingReading()), RESTITUTIONS, count, SEED, workers=-1
    )
    rows = [estimate(e, one) for e, one in zip(RESTITUTIONS, struck, strict=True)]
    return "\n".join(
        [
            "## The distance D and the probability of a home run\n",
            f"{count:,} at-bats drawn from the paper's distributions (seed {SEED}), the same ones "
            "for every e, under the default reading of the ledger, solved by the batch engine.\n",
            distances(report, dict(zip(RESTITUTIONS, struck, strict=True))),
            probability(report, rows),
        ]
    )


def distances(report: Path, struck: dict[float, Struck]) -> str:
    """Draw the density of D for the lowest and the highest e (Fig. 6)."""
    ends = {e: struck[e].distance[struck[e].batted] for e in (min(struck), max(struck))}
    last = BIN * np.ceil(max(d.max() for d in ends.values()) / BIN)
    edges = np.arange(0.0, last + BIN, BIN)
    columns: dict[str, object] = {"D from, m": edges[:-1], "D to, m": edges[1:]}
    lines, top = [], 0.0
    with figure(report, "distances", size=(6.4, 3.6)) as (axes,):
        for (e, d), style in zip(ends.items(), ("-", "--"), strict=True):
            density = np.histogram(d, edges)[0] / (BIN * len(d))
            columns[f"density at e = {e:g}, 1/m"] = density
            axes.stairs(1e3 * density, edges, linestyle=style, linewidth=1.4, label=f"e = {e:g}")
            lines.append(
                f"At e = {e:g}, {len(d)} of {len(struck[e].x)} at-bats are batted; D has its "
                f"highest bin around {edges[int(np.argmax(density))] + BIN / 2:g} m, its median at "
                f"{np.median(d):.1f} m, and {100 * np.mean(d >= 150):.2f} % of it lies beyond "
                "150 m."
            )
            top = max(top, 1.3e3 * density[1:].max())
        axes.axvline(150.0, color="black", linewidth=0.8, linestyle=":")
        axes.set_ylim(0.0, top)
        axes.annotate("home run", (152.0, axes.get_ylim()[1] * 0.9), fontsize="small")
        axes.set(xlabel="distance D from the plate, m", ylabel="probability density, 1/km")
        axes.legend()
    table(report, "distances", pd.DataFrame(columns))
    lines.append("The paper's Fig. 6 has its highest peaks at 75 m and 125 m.\n")
    caption = (
        "Density of D among batted balls, in bins of 10 m, the first cut off (the paper's Fig. 6)."
    )
    return " ".join(lines) + "\n" + shown("distances", caption)


def probability(report: Path, rows: list[Estimate]) -> str:
    """Draw P(e) with the paper's two printed curves and a fit of our own (Fig. 7)."""
    fitted = fit(rows)
    with figure(report, "probability", size=(6.4, 4.2)) as (axes,):
        draw_probability(axes, rows, fitted)
    frame = pd.DataFrame(
        {
            "e": [row.e for row in rows],
            "P(e)": [f"{row.p:.5f}" for row in rows],
            "95 % from": [f"{row.low:.5f}" for row in rows],
            "95 % to": [f"{row.high:.5f}" for row in rows],
            "home runs": [row.home_runs for row in rows],
            "of": [row.trials for row in rows],
            **{
                f"paper's {name}": [f"{curve(row.e):.5f}" for row in rows]
                for name, curve in PAPER_CURVES.items()
            },
        }
    )
    text = "These home runs do not determine C₁ and σ."
    if fitted:
        text = (
            f"The paper's form fitted to them: C₁ = {fitted.curve.c1:.0f} ± "
            f"{fitted.c1_error:.0f} m, σ = {fitted.curve.sigma:.1f} ± {fitted.sigma_error:.1f} m "
            "(standard errors, as if the estimates were independent; they share their samples, "
            "so that the slope is known better and the height worse)."
        )
    factor = PAPER_CURVES["caption"](0.42) / next(row.p for row in rows if row.e == 0.42)
    text += (
        f" At e = 0.42 the paper's caption is {factor:.0f} times the default reading: the printed "
        "parameters do not determine the paper's figure, and the next section shows which readings "
        "move it."
    )
    caption = "P(e) with Wilson intervals, fits and the paper's two printed curves (Fig. 7)."
    return "\n".join(
        [table(report, "probability", frame), text + "\n", shown("probability", caption)]
    )
