"""``python -m analysis [STUDY ...]``: run studies and put the report together.

Without a name, the studies of `make report` run; ``paper`` stands for all studies of
report/paper.md. Each writes its section, tables and figures; the pages are then put together from
all the sections that are there.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

REPORT = Path(__file__).parent.parent / "report"


@dataclass(frozen=True)
class Page:
    """A page of the report.

    Attributes
    ----------
    file
        Its name in report/.
    package
        Where the modules of its studies are.
    head
        What stands above the sections.
    studies
        In the order of the page. Those marked run without being named.
    """

    file: str
    package: str
    head: str
    studies: dict[str, bool]

    def put_together(self, report: Path) -> None:
        """Write the page from the sections that are there."""
        written = [path for name in self.studies if (path := section_path(report, name)).exists()]
        sections = [path.read_text(encoding="utf-8").strip() for path in written]
        page = self.head + "\n\n".join(sections) + "\n"
        (report / self.file).write_text(page, encoding="utf-8")


PAGES = {
    "report": Page(
        "README.md",
        "analysis",
        """# The longball report

What the studies of `python -m analysis` found. Every number, table and figure on this page was
written by them; `make report` writes the first sections anew, and each section names the command
that writes it. The tables are in `tables/` as CSV, in SI units.

[The paper, reproduced](paper.md) has a page of its own: its figures and tables with their
counterparts, and which reading of it comes nearest to its numbers. [Measured baseball](reality.md):
what models of flight say of a day of measured pitches and batted balls. [The seasons](seasons.md):
whether the coefficient of restitution explains the home runs of the paper's Table I. [Simulators
in the wild](wild.md): programs from a package index, held against the golden data.

""",
        {
            "derivation": True,
            "at_bats": True,
            "home_runs": True,
            "ledger": True,
            "accuracy": True,
            "speed_error": False,
            "quadrature": False,
            "convergence": False,
            "stability": False,
            "survival": False,
            "certificates": False,
        },
    ),
    "paper": Page(
        "paper.md",
        "analysis.paper",
        """# The paper, reproduced

Kuninaka, Kosaka and Mizutani, *Home-run probability as a function of the coefficient of
restitution of baseballs*: what it prints, what we get, and why the two differ where they do.
`make paper` writes this page anew; every number, verdict, table and figure on it was computed.
The tables are in `tables/` as CSV.

""",
        {
            "counterparts": False,
            "pitch_fits": False,
            "home_run_figures": False,
            "readings": False,
            "argument": False,
        },
    ),
    "measured": Page(
        "reality.md",
        "analysis",
        """# Measured baseball

""",
        {"reality": False},
    ),
    "question": Page(
        "seasons.md",
        "analysis",
        """# Does the coefficient of restitution explain the seasons?

""",
        {"seasons": False},
    ),
    "simulators": Page(
        "wild.md",
        "analysis",
        """# Simulators in the wild

`python -m analysis wild` writes this page anew.

""",
        {"wild": False},
    ),
}  # fmt: skip


def main() -> None:
    """Run the studies that the command line names."""
    modules = {name: f"{page.package}.{name}" for page in PAGES.values() for name in page.studies}
    parser = argparse.ArgumentParser(prog="python -m analysis", description=__doc__)
    parser.add_argument("studies", nargs="*", metavar="STUDY", help=", ".join([*modules, *PAGES]))
    parser.add_argument("--full", action="store_true", help="take longer, for smaller errors")
    parser.add_argument("--report", type=Path, default=REPORT, help="the folder to write to")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.studies if name not in modules and name not in PAGES]
    if unknown:
        parser.error(
            f"no study {unknown[0]!r}; the studies are {', '.join(modules)}; "
            f"{' and '.join(PAGES)} stand for all of a page"
        )
    for name in chosen(arguments.studies):
        start = time.monotonic()
        section = import_module(modules[name]).run(arguments.report, arguments.full)
        path = section_path(arguments.report, name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(section, encoding="utf-8")
        print(f"{name}: {time.monotonic() - start:.1f} s", file=sys.stderr)
    for page in PAGES.values():
        page.put_together(arguments.report)


def chosen(names: list[str]) -> list[str]:
    """Return the studies that names of studies and pages stand for; without one, the quick ones."""
    if not names:
        return [name for page in PAGES.values() for name, quick in page.studies.items() if quick]
    return [study for name in names for study in (PAGES[name].studies if name in PAGES else [name])]


def section_path(report: Path, name: str) -> Path:
    """Return where a study's section of the report is kept."""
    return report / "sections" / f"{name}.md"


if __name__ == "__main__":
    main()
