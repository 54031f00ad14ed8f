"""``python -m analysis [STUDY ...]``: run studies and put the report together.

Without a name, the studies of `make report` run; ``paper`` stands for all studies of
report/paper.md. Each writes its section, tables and figures; the pages are then put together from
all the sections that are there.
"""

import argparse
import sys
import time
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from analysis.writing import HERE, Report, data

REPORT = HERE.parent / "report"


class Page(NamedTuple):
    """A page of the report: its file, and its studies in order, which are in a package."""

    name: str
    studies: list[str]
    package: str = "analysis"


_DATA = data(str(HERE / "pages"))
QUICK = _DATA["quick"]  # run without being named
# By the word that stands for all studies of a page.
PAGES = {word: Page(**page) for word, page in _DATA["pages"].items()}


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
    report, sections = Report(arguments.report), arguments.report / "sections"
    sections.mkdir(parents=True, exist_ok=True)
    for name in chosen(arguments.studies):
        start = time.monotonic()
        section = import_module(modules[name]).run(report, arguments.full)
        (sections / f"{name}.md").write_text(section, encoding="utf-8")
        print(f"{name}: {time.monotonic() - start:.1f} s", file=sys.stderr)
    for page in PAGES.values():
        written = [path for name in page.studies if (path := sections / f"{name}.md").exists()]
        there = "\n\n".join(path.read_text(encoding="utf-8").strip() for path in written)
        text = report.render(f"pages/{page.name}", {}, sections=there)
        (arguments.report / f"{page.name}.md").write_text(text, encoding="utf-8")


def chosen(names: list[str]) -> list[str]:
    """Return the studies that names of studies and pages stand for; without one, the quick ones."""
    pages = [PAGES[name].studies if name in PAGES else [name] for name in names]
    return [study for studies in pages or [QUICK] for study in studies]


if __name__ == "__main__":
    main()
