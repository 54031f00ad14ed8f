"""Appendix B's contact force as the step vanishes: which readings of it converge, and to what."""

import numpy as np

from analysis.convergence.pieces import TRUTH, distance, each, passing
from analysis.paper.balls import Base
from analysis.speed_error.work import batted
from analysis.writing import Report
from longball.convergence.order import fit_power_law, typical
from longball.engines.verlet import PUSHES, Verlet, impulse_share
from longball.model.quantities import replaced
from longball.model.scene import AtBatScene

SCENES, FULL_SCENES = 8, 60
SEED = 4
STEPS = [float(step) for step in np.geomspace(0.05, 1e-5, 12)]
SHOWN = (0.05, 1e-3, 1e-5)  # s, of the table


def errors(scene: AtBatScene, step: float) -> dict[str, tuple[float, float]]:
    """Return the error of D by contact force, m: against the whole impulse, and against its own.

    The step is changed so that a whole number of steps ends in the middle of the bat.
    """
    way = passing(scene)
    assert way is not None
    inside = way.time + way.window / 2
    dt = inside / max(1, round(inside / step))
    true = distance(scene, TRUTH)
    found: dict[str, tuple[float, float]] = {}
    for force in PUSHES:
        # The impulse of another restitution is the force's share of the whole one.
        restitution = Base(scene, contact_force=force).restitution(scene.ball.restitution)
        own = distance(replaced(scene, {"ball.restitution": restitution}), TRUTH)
        d = distance(scene, Verlet(dt, "implicit", contact_force=force))
        found[force] = d - true, d - own
    return found


def run(report: Report, full: bool) -> str:
    """Measure the error of D at falling steps, under each reading of the contact force."""
    scenes = batted(FULL_SCENES if full else SCENES, SEED)[0].scenes
    calls = [(scene, step) for scene in scenes for step in STEPS]
    measured = each(report, "contact force", errors, calls)
    found = {}
    for force in PUSHES:
        rows = np.array([one[force] for one in measured]).reshape(len(scenes), len(STEPS), 2)
        whole, own = (typical(np.abs(rows[:, :, i])) for i in range(2))
        found[force] = whole, *(fit_power_law(np.array(STEPS), of) for of in (whole, own))
    # The step next to each that is shown.
    shown = [int(np.abs(np.log(np.array(STEPS) / step)).argmin()) for step in SHOWN]
    return report.render(
        "pushes", globals(), scenes=len(scenes), found=found, shown=shown,
        impulse_share=impulse_share,
    )  # fmt: skip
