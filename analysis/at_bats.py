"""A few at-bats, from the pitcher's hand to the ground."""

import math
from typing import Any

import numpy as np
from matplotlib.patches import Circle

from analysis.writing import LINES, Report, data
from longball.engines.chain import solve_with_path
from longball.engines.ivp import Ivp
from longball.engines.path import Trajectory
from longball.model.arrays import Array
from longball.model.quantities import number
from longball.model.scene import AtBatScene, Pitch, Swing

# A pitch at the mean speed of the straight balls, on the middle cell, and the swings at it.
PITCH = Pitch(speed=139.1 / 3.6, aim=(-0.144, 1.8))  # cell 2, on the barrel's side
SWINGS = data(__file__)
BEHIND = 0.01  # s: the pitch is drawn to a third of a metre behind the plate


def run(report: Report, full: bool) -> str:
    """Solve the at-bats and draw them; `full` changes nothing."""
    scenes = {
        name: AtBatScene(pitch=PITCH, swing=Swing(height_offset=offset, tilt=math.radians(tilt)))
        for name, (offset, tilt) in SWINGS.items()
    }
    solved = {name: solve_with_path(scene, Ivp()) for name, scene in scenes.items()}
    way = solved["miss"][1]
    pitch: Any = along(way, 0.0, way.end + BEHIND)
    thin: Any = {"color": "black", "linewidth": 0.8}
    with report.figure("at_bats", size=(7.0, 3.6)) as (axes,):
        axes.plot(*pitch, label="pitch", **thin)
        for (name, (result, way)), dash in zip(solved.items(), LINES, strict=True):
            if result.landing is not None:
                label = f"{name}, {result.landing.distance:.0f} m"
                axes.plot(*along(way, way.legs[-1].begin, way.end), linestyle=dash, label=label)
        axes.set(xlabel="x towards the pitcher, m", ylabel="height z, m", aspect="equal", ylim=0.0)
        axes.legend(fontsize="small", loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=5)
    with report.figure("at_bats_contact", columns=len(SWINGS), size=(6.4, 2.0)) as panels:
        for axes, (name, (result, way)) in zip(panels, solved.items(), strict=True):
            scene = scenes[name]
            height = number(result, "plate.position[2]") + scene.swing.height_offset
            bat = Circle((0.0, height), scene.bat.radius, facecolor="0.8", edgecolor="black")
            axes.add_patch(bat)
            if result.contact and result.contact.position is not None:
                x, _, z = map(float, result.contact.position)
                axes.add_patch(Circle((x, z), scene.ball.radius, fill=False, linestyle=":"))
                begin = way.legs[-1].begin
                batted = along(way, begin, min(way.end, begin + BEHIND))
                axes.plot(*batted, color="C0", linewidth=1.8)
            axes.plot(*pitch, **thin)
            axes.set(title=name, xlabel="x, m", xlim=(-0.15, 0.15), ylim=(1.08, 1.38), aspect=1.0)
            axes.set(xticks=(-0.1, 0.0, 0.1), yticks=(1.1, 1.2, 1.3))
            axes.tick_params(labelleft=axes is panels[0])
        panels[0].set_ylabel("height z, m")
    return report.render("at_bats", globals(), solved=solved)


def along(way: Trajectory, begin: float, end: float) -> tuple[Array, Array]:
    """Return x and z, m, at 400 times of a trajectory."""
    x, _, z, *_ = np.array(way.sample(np.linspace(begin, end, 400).tolist())).T
    return x, z
