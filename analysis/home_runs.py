"""The distribution of D and the probability of a home run: the paper's Figs. 6 and 7."""

from pathlib import Path

import numpy as np
import pandas as pd

from analysis import Array
from analysis.paper.distances import BIN, highest
from analysis.writing import LINES, figure, render, write_table
from longball import home_run
from longball.home_run import HOME_RUN_DISTANCE, PAPER_CURVES, RESTITUTIONS
from longball.model.readings import SamplingReading
from longball.model.scene import AtBatScene
from longball.pictures import draw_probability

SAMPLES, FULL_SAMPLES = 4_000, 100_000
SEED = 1


def run(report: Path, full: bool) -> str:
    """Sample at-bats, count home runs, draw both figures."""
    base, at_bats = AtBatScene(id="base"), home_run.paper_at_bats(SamplingReading())
    count = FULL_SAMPLES if full else SAMPLES
    struck = home_run.monte_carlo(base, at_bats, RESTITUTIONS, count, SEED, workers=-1)
    rows = [home_run.estimate(e, one) for e, one in zip(RESTITUTIONS, struck, strict=True)]
    fitted = home_run.fit(rows)
    with figure(report, "probability", columns=2, size=(9.0, 4.2)) as (ours, papers):
        for axes in (ours, papers):
            draw_probability(axes, rows, fitted)
        ours.set_ylim(0.0, 1.3 * max(row.high for row in rows))
        handles, labels = papers.get_legend_handles_labels()
        n, below = len(PAPER_CURVES), (0.5, 0.15)
        ours.legend(handles[n:], labels[n:], fontsize="small", loc="upper left")
        papers.legend(
            handles[:n], labels[:n], fontsize="small", loc="lower center", bbox_to_anchor=below
        )
    ends = {e: struck[RESTITUTIONS.index(e)] for e in (min(RESTITUTIONS), max(RESTITUTIONS))}
    distances = {e: one.distance[one.batted] for e, one in ends.items()}
    draw_distances(report, distances)
    return render(
        report, "home_runs", globals(), count=count, rows=rows, fitted=fitted,
        distances=distances, highest=highest,
    )  # fmt: skip


def draw_distances(report: Path, distances: dict[float, Array]) -> None:
    """Draw the density of D by restitution (Fig. 6)."""
    last = BIN * np.ceil(max(d.max() for d in distances.values()) / BIN)
    edges = np.arange(0.0, last + BIN, BIN)
    columns: dict[str, object] = {"D from, m": edges[:-1], "D to, m": edges[1:]}
    densities = {e: np.histogram(d, edges)[0] / (BIN * len(d)) for e, d in distances.items()}
    top = 1.3e3 * max(density[1:].max() for density in densities.values())
    with figure(report, "distances", size=(6.4, 3.6)) as (axes,):
        for i, (e, density) in enumerate(densities.items()):
            columns[f"density at e = {e:g}, 1/m"] = density
            label = f"e = {e:g}"
            axes.stairs(1e3 * density, edges, linestyle=LINES[i], linewidth=1.4, label=label)
            cut = f"{label}: {1e3 * density[0]:.1f} per km"
            axes.annotate(cut, (BIN + 2.0, (0.93 - 0.07 * i) * top), fontsize="small")
        axes.axvline(HOME_RUN_DISTANCE, color="black", linewidth=0.8, linestyle=":")
        axes.annotate("home run", (HOME_RUN_DISTANCE + 2.0, 0.9 * top), fontsize="small")
        axes.set(xlabel="distance D from the plate, m", ylabel="probability density, 1/km")
        axes.set_ylim(0.0, top)
        axes.legend(loc="center right")
    write_table(report, "distances", pd.DataFrame(columns))
