"""The ledger of readings, and what each one does to P(e)."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from analysis.writing import figure, markdown_table, shown, table
from longball.home_run import PAPER_CURVES, Estimate, estimate, monte_carlo, paper_at_bats
from longball.model.readings import LEDGER, Reading
from longball.model.scene import AtBatScene

SAMPLES, FULL_SAMPLES = 1_000, 20_000
SEED = 1
E = 0.42  # where the paper's text gives P ≈ 0.17


def run(report: Path, full: bool) -> str:
    """Print the ledger, and P(0.42) with each switch turned alone."""
    count = FULL_SAMPLES if full else SAMPLES
    rows = {}
    for entry in LEDGER:
        for option in entry.options:
            if entry.switch in Reading.model_fields:
                rows[entry.switch, option] = probability(entry.switch, option, count)
    default = rows["speed_table", "columns_swapped"]
    frame = pd.DataFrame(
        [
            {
                "switch": switch,
                "option": option,
                f"P({E})": f"{row.p:.4f}",
                "95 %": f"{row.low:.4f} to {row.high:.4f}",
                "home runs": f"{row.home_runs} of {row.trials}",
            }
            for (switch, option), row in rows.items()
        ]
    )
    draw(report, rows, default)
    ledger = [[f"`{x.switch}`", ", ".join(x.options), x.place, x.why] for x in LEDGER]
    return "\n".join(
        [
            "## The ledger of readings\n",
            "Every place where the paper is silent, ambiguous or wrong is a switch of a scene's "
            "`reading`; the default is the first option.\n",
            markdown_table(["switch", "options", "place in the paper", "why"], ledger),
            f"P({E}) with one switch turned at a time, from the same {count:,} at-bats (seed "
            f"{SEED}):\n",
            table(report, "readings", frame),
            shown(
                "readings",
                f"P({E}) with one switch turned at a time, with 95 % intervals; the dashed line "
                "is the default reading, the dotted one the paper's caption.",
            ),
        ]
    )


def probability(switch: str, option: str, count: int) -> Estimate:
    """Return P(0.42) under the default reading with one switch turned."""
    number = Reading.model_fields[switch].annotation is float
    reading = Reading.model_validate({switch: float(option) if number else option})
    base = AtBatScene(id="base", reading=reading)
    (struck,) = monte_carlo(base, paper_at_bats(reading), [E], count, SEED, workers=-1)
    return estimate(E, struck, reading)


def draw(report: Path, rows: dict[tuple[str, str], Estimate], default: Estimate) -> None:
    """Draw P(0.42) of every option that is not the default."""
    first = {entry.switch: entry.options[0] for entry in LEDGER}
    turned = {key: row for key, row in reversed(rows.items()) if key[1] != first[key[0]]}
    heights = range(len(turned))
    with figure(report, "readings", size=(6.8, 4.2)) as (axes,):
        for height, row in zip(heights, turned.values(), strict=True):
            axes.plot([row.low, row.high], [height, height], color="black", linewidth=1.0)
            axes.plot([row.p], [height], "ko", markersize=4)
        axes.axvline(default.p, color="black", linestyle="--", linewidth=0.8)
        axes.axvline(PAPER_CURVES["caption"](E), color="black", linestyle=":", linewidth=0.8)
        axes.set_yticks(heights, [f"{switch} = {option}" for switch, option in turned])
        axes.set(xlabel=f"P({E})", xlim=(0.0, None))
