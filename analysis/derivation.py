"""The impulse, printed from its derivation in SymPy."""

from pathlib import Path

from sympy import latex

from analysis.writing import render
from longball.model.derivation import equations


def run(report: Path, full: bool) -> str:
    """Return the section; nothing is measured, so `full` changes nothing."""
    return render(report, "derivation", {}, equations=equations(), latex=latex)
