"""How the studies write: tables as CSV and Markdown, figures as PNG."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import jinja2
import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
import pandas as pd
from cycler import cycler
from matplotlib.axes import Axes

# Told apart without colour too, for a print in black and white.
LINES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))


def _style(color: str, marker: str, line: object = "-", *, filled: bool = True) -> dict[str, Any]:
    face = color if filled else "white"
    return {"color": color, "marker": marker, "linestyle": line, "markerfacecolor": face}


# The colours of Okabe and Ito, which colour-blind readers tell apart.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "black")

# A method, an engine, a reading of the paper, a part of its scheme or of a mixture looks the same
# in every figure; marks and lines tell them apart in grey.
STYLES = {
    "batch": _style("black", "o"),
    "ivp Taylor": _style("#0072B2", "s"),
    "ivp DOP853": _style("#0072B2", "^", "--"),
    "ivp RK45": _style("#0072B2", "v", "-.", filled=False),
    "ivp LSODA": _style("#0072B2", "D", ":", filled=False),
    "ivp Radau": _style("#0072B2", "P", ":"),
    "verlet old_carried": _style("black", "o"),
    "verlet old_recomputed": _style("#E69F00", "s", filled=False),
    "verlet half_step": _style("0.45", "<", "--"),
    "verlet predicted_carried": _style("#D55E00", "D", "-."),
    "verlet predicted_recomputed": _style("#0072B2", "v", ":"),
    "verlet implicit": _style("#CC79A7", ">"),
    "enclosure": _style("#009E73", "*"),
    "multiprecision": _style("#009E73", "X", "--"),
    "heyoka scalar": _style("#D55E00", "s", "--"),
    "heyoka batch": _style("#D55E00", "D"),
    "diffrax Tsit5": _style("#E69F00", "v", ":", filled=False),
    "diffrax Dopri8": _style("#E69F00", "^", "-."),
    "CVODE Adams": _style("0.45", "P", "--"),
    "scipy DOP853": _style("#56B4E9", "^", "--"),
    "scipy RK45": _style("#56B4E9", "v", "-.", filled=False),
    "scipy LSODA": _style("#56B4E9", "D", ":", filled=False),
    "Monte Carlo": _style("#D55E00", "^", "--", filled=False),
    "scrambled points": _style("#E69F00", "D", "-.", filled=False),
    "quadrature": _style("#0072B2", "o"),
    "default": _style("#0072B2", "o", "-", filled=False),
    "nearest": _style("#D55E00", "s", "-."),
    "paper's caption": _style("0.45", "*", "--"),
    "paper's text": _style("0.45", "X", ":", filled=False),
    "inertia about the centre": _style("#009E73", "^", ":"),
    "straight line to the contact": _style("#0072B2", "s"),
    "half force over two steps": _style("#E69F00", "o", "--"),
    "force": _style("#009E73", "^", "-."),
    "plate on the line between steps": _style("#D55E00", "D", ":"),
    "ground on the line between steps": _style("#CC79A7", "v", "--", filled=False),
    "first point below the ground": _style("0.45", "*", "-."),
    "mixture": _style("black", ""),
    "first part": _style("#D55E00", "", "--"),
    "second part": _style("#0072B2", "", ":"),
    "measured": _style("black", "o", "none", filled=False),
}

plt.rcParams.update(
    {
        "axes.grid": True,
        "axes.prop_cycle": cycler(color=COLOURS),
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


def render(report: Path, name: str, study: Mapping[str, object], **values: object) -> str:
    """Return the Markdown of analysis/templates/NAME.md, a Jinja template, with values put in.

    A template sees these values, and what the study's module defines, its ``globals()``; besides
    Jinja's own, it has the filter ``f``, which formats as the function `format` does,
    ``{{ rms | f(".1f") }}``; ``shown(figure, caption)``; and ``{% call table(name) %}`` around a
    Markdown table, whose rows become report/tables/NAME.csv, too.

    Raises
    ------
    jinja2.UndefinedError
        If the template names a value that is not given.
    """

    def table(name: str, caller: Callable[[], str]) -> str:
        markdown = caller()
        header, _, *rows = (_cells(line) for line in markdown.strip().splitlines())
        write_table(report, name, pd.DataFrame(rows, columns=header))
        return markdown

    return _TEMPLATES.get_template(f"{name}.md").render(**{**study, **values, "table": table})


def _cells(line: str) -> list[str]:
    """Return the cells of a line of a Markdown table; a bar in a cell is escaped."""
    cells = re.split(r"(?<!\\)\|", line.strip())[1:-1]
    return [cell.strip().replace("\\|", "|") for cell in cells]


def write_table(report: Path, name: str, frame: pd.DataFrame) -> None:
    """Write report/tables/NAME.csv."""
    path = report / "tables" / f"{name}.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    frame.to_csv(path, index=False, lineterminator="\n")


def _shown(name: str, caption: str) -> str:
    """Return the Markdown that shows a figure of the report."""
    return f"![{caption}](figures/{name}.png)\n\n*{caption}*\n"


_TEMPLATES = jinja2.Environment(
    loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
    autoescape=False,
)
_TEMPLATES.filters["f"] = format
_TEMPLATES.globals["shown"] = _shown
