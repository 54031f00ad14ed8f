"""Which reading of the paper gives its numbers: the study `python -m analysis readings`."""

from analysis.paper import combinations, numbers, switches, variance
from analysis.writing import Report


def run(report: Report, full: bool) -> str:
    """Write the section; `full` changes nothing: the errors of the samples are below the paper's.

    What is said of the nearest reading needs all combinations first, so that they come first in
    time, and below in the section.
    """
    cases = combinations.cases()
    sections = (
        switches.section(report, cases),
        numbers.section(report, cases),
        combinations.section(report),
        numbers.sensitivities(report, cases),
        variance.section(report, {name: base for name, (base, _) in cases.items()}),
    )
    return report.render("readings", {}, sections=sections)
