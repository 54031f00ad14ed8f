"""``python -m analysis [STUDY ...]``: run studies and put the report together.

Without a name, the studies of `make report` run. Each writes its section, tables and figures;
report/README.md is then put together from all the sections that are there.
"""

from __future__ import annotations

import argparse
import sys
import time
from importlib import import_module
from pathlib import Path

# In the order of the report. Those marked are run by `make report`; the others take longer.
STUDIES = {
    "derivation": True,
    "at_bats": True,
    "home_runs": True,
    "quadrature": False,
    "readings": True,
    "accuracy": True,
    "convergence": False,
    "stability": False,
    "survival": False,
    "pitch_fits": False,
}

REPORT = Path(__file__).parent.parent / "report"

HEAD = """# The longball report

What the studies of `python -m analysis` found. Every number, table and figure on this page was
written by them; `make report` writes the first sections anew, and each section names the command
that writes it. The tables are in `tables/` as CSV, in SI units.

"""


def main() -> None:
    """Run the studies that the command line names."""
    parser = argparse.ArgumentParser(prog="python -m analysis", description=__doc__)
    parser.add_argument("studies", nargs="*", metavar="STUDY", help=", ".join(STUDIES))
    parser.add_argument("--full", action="store_true", help="take longer, for smaller errors")
    parser.add_argument("--report", type=Path, default=REPORT, help="the folder to write to")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.studies if name not in STUDIES]
    if unknown:
        parser.error(f"no study {unknown[0]!r}; the studies are {', '.join(STUDIES)}")
    for name in arguments.studies or [name for name, quick in STUDIES.items() if quick]:
        start = time.monotonic()
        section = import_module(f"analysis.{name}").run(arguments.report, arguments.full)
        path = section_path(arguments.report, name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(section, encoding="utf-8")
        print(f"{name}: {time.monotonic() - start:.1f} s", file=sys.stderr)
    written = [path for name in STUDIES if (path := section_path(arguments.report, name)).exists()]
    sections = [path.read_text(encoding="utf-8").strip() for path in written]
    page = HEAD + "\n\n".join(sections) + "\n"
    (arguments.report / "README.md").write_text(page, encoding="utf-8")


def section_path(report: Path, name: str) -> Path:
    """Return where a study's section of the report is kept."""
    return report / "sections" / f"{name}.md"


if __name__ == "__main__":
    main()
