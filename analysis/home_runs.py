"""The distribution of D and the probability of a home run: the paper's Figs. 6 and 7."""

import numpy as np

from analysis.paper.distances import BIN, density, highest
from analysis.paper.home_run_figures import draw_stairs
from analysis.paper.printed import AT_BATS, BASE
from analysis.writing import Report
from longball import home_run
from longball.home_run import HOME_RUN_DISTANCE, PAPER_CURVES, RESTITUTIONS
from longball.pictures import draw_probability

SAMPLES, FULL_SAMPLES = 4_000, 100_000
SEED = 1


def run(report: Report, full: bool) -> str:
    """Sample at-bats, count home runs, draw both figures."""
    count = FULL_SAMPLES if full else SAMPLES
    struck = home_run.monte_carlo(BASE, AT_BATS, RESTITUTIONS, count, SEED, workers=-1)
    rows = [home_run.estimate(e, one) for e, one in zip(RESTITUTIONS, struck, strict=True)]
    fitted = home_run.fit(rows)
    with report.figure("probability", rows=2, size=(6.4, 6.6)) as (ours, papers):
        for axes in (ours, papers):
            draw_probability(axes, rows, fitted)
        ours.set_ylim(0.0, 1.3 * max(row.high for row in rows))
        drawn, _ = papers.get_legend_handles_labels()
        n, below = len(PAPER_CURVES), (0.5, 0.15)
        ours.legend(handles=drawn[n:], loc="upper left")
        papers.legend(handles=drawn[:n], loc="lower center", bbox_to_anchor=below)
    ends = {RESTITUTIONS[i]: struck[i] for i in (0, -1)}
    distances = {e: one.distance[one.batted] for e, one in ends.items()}
    densities = {e: density(d) for e, d in distances.items()}
    with report.figure("distances", size=(6.4, 3.6)) as (axes,):
        top = 1.3 * draw_stairs(axes, densities, linewidth=1.4)
        for i, (e, bins) in enumerate(densities.items()):
            cut = f"e = {e:g}: {bins[0]:.3f}"
            axes.annotate(cut, (BIN + 2.0, (0.93 - 0.07 * i) * top), fontsize="small")
        axes.axvline(HOME_RUN_DISTANCE, color="black", linewidth=0.8, linestyle=":")
        axes.annotate("home run", (HOME_RUN_DISTANCE + 2.0, 0.9 * top), fontsize="small")
        axes.set_ylim(0.0, top)
        axes.legend(loc="center right")
    return report.render(
        "home_runs", globals(), count=count, rows=rows, fitted=fitted, highest=highest,
        distances=distances, densities=densities, np=np,
    )  # fmt: skip
