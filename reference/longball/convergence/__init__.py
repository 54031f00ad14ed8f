"""Observed orders of convergence, extrapolated limits and errors of a family of time steps.

`study` takes a function of the time step; `converge` takes a solver of scenes.
"""

from longball.convergence.order import PowerLaw, fit_power_law
from longball.convergence.probe import chosen_steps
from longball.convergence.report import ConvergenceReport
from longball.convergence.studies import Sample, converge, study

__all__ = [
    "ConvergenceReport",
    "PowerLaw",
    "Sample",
    "chosen_steps",
    "converge",
    "fit_power_law",
    "study",
]
