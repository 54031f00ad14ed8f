"""The impulse, printed from its derivation in SymPy."""

from pathlib import Path

from sympy import latex

from analysis.writing import render
from longball.model.derivation import steps


def run(report: Path, full: bool) -> str:
    """Return the section; nothing is measured, so `full` changes nothing."""
    return render(report, "derivation", {}, steps=steps(), latex=latex)
