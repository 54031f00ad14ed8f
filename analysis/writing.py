"""Output of the studies: tables as CSV and Markdown, figures as PNG."""

import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2
import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes

# Told apart without colour too, for a print in black and white.
LINES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))

HERE = Path(__file__).parent


def data(module: str) -> dict[str, Any]:
    """Load the TOML file beside a module, by the module's ``__file__``."""
    return tomllib.loads(Path(module).with_suffix(".toml").read_text("utf-8"))


plt.style.use(HERE / "report.mplstyle")
STYLES: dict[str, dict[str, Any]] = {
    name: {"linestyle": "-", "markerfacecolor": style["color"]} | style
    for name, style in data(str(HERE / "styles")).items()
}


@dataclass(frozen=True)
class Report:
    """The folder that studies write into."""

    folder: Path

    @contextmanager
    def figure(
        self, name: str, size: tuple[float, float], columns: int = 1, rows: int = 1
    ) -> Iterator[list[Axes]]:
        """Draw into the axes that are yielded; the figure becomes figures/NAME.png.

        A README shows 6.4 inches at its full width; what is wider shrinks, and its type too.
        """
        drawn, axes = plt.subplots(rows, columns, figsize=size, layout="constrained", squeeze=False)
        yield list(axes.flat)
        drawn.savefig(self._file("figures", f"{name}.png"))
        plt.close(drawn)

    def write_table(self, name: str, frame: pd.DataFrame, float_format: str | None = None) -> None:
        """Write tables/NAME.csv."""
        path = self._file("tables", f"{name}.csv")
        frame.to_csv(path, index=False, lineterminator="\n", float_format=float_format)

    def render(self, name: str, study: Mapping[str, object], **values: object) -> str:
        """Return the Markdown of analysis/templates/NAME.md, a Jinja template, with values put in.

        A template sees these values, and what the study's module defines, its ``globals()``;
        besides Jinja's own, it has the filter ``f``, which formats as the function `format` does,
        ``{{ rms | f(".1f") }}``; ``shown(figure, caption)``; and ``{% call table(name) %}`` around
        a Markdown table, whose rows become tables/NAME.csv, too.

        Raises
        ------
        jinja2.UndefinedError
            If the template names a value that is not given.
        """

        def table(name: str, caller: Callable[[], str]) -> str:
            markdown = caller()
            header, _, *rows = (_cells(line) for line in markdown.strip().splitlines())
            self.write_table(name, pd.DataFrame(rows, columns=header))
            return markdown

        return _TEMPLATES.get_template(f"{name}.md").render(**{**study, **values, "table": table})

    def _file(self, *parts: str) -> Path:
        path = self.folder.joinpath(*parts)
        path.parent.mkdir(parents=True, exist_ok=True)
        return path


def _formatted(x: object, spec: str) -> str:
    """Return a value in a format; a dash for NaN, a number that nobody has found."""
    return "-" if x != x else format(x, spec)


def _cells(line: str) -> list[str]:
    """Return the cells of a line of a Markdown table; a bar in a cell is escaped."""
    cells = re.split(r"(?<!\\)\|", line.strip())[1:-1]
    return [cell.strip().replace("\\|", "|") for cell in cells]


_TEMPLATES = jinja2.Environment(
    loader=jinja2.FileSystemLoader(HERE / "templates"),
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
    autoescape=False,
)
_TEMPLATES.filters["f"] = _formatted
_TEMPLATES.globals["shown"] = "![{1}](figures/{0}.png)\n\n*{1}*\n".format
