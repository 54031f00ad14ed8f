"""The impulse, printed from its derivation in SymPy."""

from sympy import latex

from analysis.writing import Report
from longball.model.derivation import equations


def run(report: Report, full: bool) -> str:
    """Return the section; nothing is measured, so `full` changes nothing."""
    return report.render("derivation", {}, equations=equations(), latex=latex)
