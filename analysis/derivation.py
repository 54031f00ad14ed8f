"""The impulse, printed from its derivation in SymPy."""

from __future__ import annotations

from pathlib import Path

import sympy as sp

from longball.model.derivation import steps


def run(report: Path, full: bool) -> str:
    """Return the section; nothing is measured, so `full` changes nothing."""
    lines = [
        "## The impulse, derived\n",
        "Printed from `longball.model.derivation`, where SymPy derives it from the conservation "
        "of momentum and the restitution relation; the functions that longball executes "
        "(`longball.model.impact`) are generated from the same expressions. Equation numbers are "
        "those of the paper's Appendix A.\n",
    ]
    for number, step in enumerate(steps(), 1):
        lines.append(f"{number}. **{step.title}.** {step.explanation}\n")
        lines.append(f"   $$ {sp.latex(step.equation)} $$\n")
    return "\n".join(lines)
