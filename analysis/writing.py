"""How the studies write: tables as CSV and Markdown, figures as PNG."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes

TEMPLATES = Path(__file__).parent / "templates"

# Told apart without colour too, for a print in black and white.
LINES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))

plt.rcParams.update(
    {
        "axes.grid": True,
        "axes.spines.right": False,
        "axes.spines.top": False,
        "figure.dpi": 150,
        "font.size": 9,
        "grid.alpha": 0.3,
        "legend.frameon": False,
    }
)


@contextmanager
def figure(
    report: Path, name: str, *, rows: int = 1, columns: int = 1, size: tuple[float, float]
) -> Iterator[list[Axes]]:
    """Draw into the axes that are yielded; the figure becomes report/figures/NAME.png."""
    drawn, axes = plt.subplots(rows, columns, figsize=size, layout="constrained", squeeze=False)
    yield list(axes.flat)
    path = report / "figures" / f"{name}.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    drawn.savefig(path)
    plt.close(drawn)


def filled(name: str, **values: object) -> str:
    """Return the Markdown of analysis/templates/NAME.md with values where it names them.

    The syntax is that of `str.format`, so that a template says with how many digits a number is
    written: ``{rms:.1f}``.
    """
    return (TEMPLATES / f"{name}.md").read_text(encoding="utf-8").format(**values)


def shown(name: str, caption: str) -> str:
    """Return the Markdown that shows a figure of the report."""
    return f"![{caption}](figures/{name}.png)\n\n*{caption}*\n"


def table(report: Path, name: str, frame: pd.DataFrame) -> str:
    """Write report/tables/NAME.csv and return the same rows as Markdown."""
    path = report / "tables" / f"{name}.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    frame.to_csv(path, index=False, lineterminator="\n")
    return markdown_table(list(frame.columns), frame.to_numpy().tolist())


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return rows as a Markdown table; a bar in a cell is escaped."""

    def line(cells: Sequence[object]) -> str:
        return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"

    return "\n".join([line(header), line(["---"] * len(header)), *map(line, rows)]) + "\n"
