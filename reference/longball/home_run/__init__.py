"""The probability of a home run, P(e).

`at_bats` has the paper's distributions and draws from them; `simulation` computes the landings of
the samples; `estimation` counts home runs and fits the paper's form of P(e). `quadrature` needs no
samples: it integrates between the `crossings` of the `clearance`, the signed distance of an at-bat
from the boundary of the home runs. `randomised` is an independent check of it.
"""

from longball.home_run.at_bats import (
    BLOCK,
    MIDDLE_CELL,
    AtBats,
    Mixture,
    Samples,
    draw,
    draw_block,
    paper_at_bats,
    refuse_drawn,
    scenes,
    with_restitution,
)
from longball.home_run.estimation import (
    FEWEST,
    PAPER_CURVES,
    RESTITUTIONS,
    Curve,
    Estimate,
    Fit,
    columns,
    estimate,
    estimates,
    fit,
    fit_form,
    wilson,
)
from longball.home_run.quadrature import Integral, integrals
from longball.home_run.randomised import Randomised, scrambled
from longball.home_run.simulation import HOME_RUN_DISTANCE, Struck, monte_carlo

__all__ = [
    "BLOCK",
    "FEWEST",
    "HOME_RUN_DISTANCE",
    "MIDDLE_CELL",
    "PAPER_CURVES",
    "RESTITUTIONS",
    "AtBats",
    "Curve",
    "Estimate",
    "Fit",
    "Integral",
    "Mixture",
    "Randomised",
    "Samples",
    "Struck",
    "columns",
    "draw",
    "draw_block",
    "estimate",
    "estimates",
    "fit",
    "fit_form",
    "integrals",
    "monte_carlo",
    "paper_at_bats",
    "refuse_drawn",
    "scenes",
    "scrambled",
    "wilson",
    "with_restitution",
]
