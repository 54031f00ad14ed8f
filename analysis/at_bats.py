"""A few at-bats, from the pitcher's hand to the ground."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import NDArray

from analysis.writing import LINES, figure, render, table
from longball.engines.chain import solve_with_path
from longball.engines.ivp import Ivp
from longball.engines.path import Trajectory
from longball.model.result import Result
from longball.model.scene import AtBatScene, Pitch, Swing

Array = NDArray[np.float64]

# A pitch at the mean speed of the straight balls, on the middle cell, and four swings at it:
# heights of the bat's axis over the pitch, m, and tilts, rad.
SWINGS = {
    "fly ball": (-0.0300, math.radians(8.0)),
    "line drive": (-0.0120, math.radians(5.0)),
    "grounder": (0.0200, math.radians(2.0)),
    "pop-up": (-0.0550, math.radians(5.0)),
    "miss": (0.0750, math.radians(5.0)),
}
AIM_Y = -0.144  # m: cell 2, on the barrel's side
BEHIND = 0.01  # s: the pitch is drawn to a third of a metre behind the plate
PITCH: dict[str, Any] = {"color": "black", "linewidth": 0.8}


def run(report: Path, full: bool) -> str:
    """Solve the at-bats and draw them; `full` changes nothing."""
    scenes = {name: at_bat(name, *swing) for name, swing in SWINGS.items()}
    solved = {name: solve_with_path(scene, Ivp()) for name, scene in scenes.items()}
    pitch = solved["miss"][1]
    with figure(report, "at_bats", size=(7.0, 3.6)) as (axes,):
        axes.plot(*along(pitch, 0.0, pitch.end + BEHIND), label="pitch", **PITCH)
        for (name, (result, way)), dash in zip(solved.items(), LINES, strict=True):
            if result.landing is not None:
                label = f"{name}, {result.landing.distance:.0f} m"
                axes.plot(*along(way, way.legs[-1].begin, way.end), linestyle=dash, label=label)
        axes.set(xlabel="x toward the pitcher, m", ylabel="height z, m", aspect="equal", ylim=0.0)
        axes.legend(fontsize="small", loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=5)
    with figure(report, "at_bats_contact", columns=len(SWINGS), size=(9.0, 2.6)) as panels:
        for axes, (name, (result, way)) in zip(panels, solved.items(), strict=True):
            draw_contact(axes, scenes[name], result, way)
            axes.plot(*along(pitch, 0.0, pitch.end + BEHIND), **PITCH)
            axes.set(title=name, xlabel="x, m", xlim=(-0.15, 0.15), ylim=(1.08, 1.38))
            axes.set_aspect("equal")
        panels[0].set_ylabel("height z, m")
    rows = [row(name, solved[name][0], *swing) for name, swing in SWINGS.items()]
    return render(report, "at_bats", rows=table(report, "at_bats", pd.DataFrame(rows)))


def at_bat(name: str, offset: float, tilt: float) -> AtBatScene:
    """Return the scene of one swing."""
    return AtBatScene(
        id=name,
        pitch=Pitch(speed=139.1 / 3.6, aim=(AIM_Y, 1.8)),
        swing=Swing(height_offset=offset, tilt=tilt),
    )


def row(name: str, result: Result, offset: float, tilt: float) -> dict[str, str]:
    """Return the line of the table for one at-bat."""
    contact, impact, landing = result.contact, result.impact, result.landing
    assert contact is not None
    hit = impact is not None and landing is not None
    speed = math.hypot(*map(float, impact.velocity)) if impact else math.nan
    return {
        "at-bat": name,
        "offset, m": f"{offset:+.4f}",
        "tilt, deg": f"{math.degrees(tilt):.0f}",
        "outcome": str(result.outcome),
        "margin, m": f"{contact.margin:+.4f}",
        "ẽ": f"{impact.restitution:.4f}" if impact else "",
        "exit speed, m/s": f"{speed:.2f}" if impact else "",
        "hang time, s": f"{landing.hang_time:.3f}" if hit and landing else "",
        "D, m": f"{landing.distance:.3f}" if hit and landing else "",
    }


def along(way: Trajectory[float], begin: float, end: float) -> tuple[Array, Array]:
    """Return x and z, m, at 400 times of a trajectory."""
    x, _, z, *_ = np.array(way.sample(np.linspace(begin, end, 400).tolist())).T
    return x, z


def draw_contact(axes: Axes, scene: AtBatScene, result: Result, way: Trajectory[float]) -> None:
    """Draw bat and ball at their touching, the bat where the swing has put it, and what follows."""
    plate, contact = result.plate, result.contact
    assert plate is not None
    assert contact is not None
    height = float(plate.position[2]) + scene.swing.height_offset
    axes.add_patch(Circle((0.0, height), scene.bat.radius, facecolor="0.8", edgecolor="black"))
    if contact.position is not None:
        x, _, z = map(float, contact.position)
        axes.add_patch(Circle((x, z), scene.ball.radius, fill=False, linestyle=":"))
        begin = way.legs[-1].begin
        axes.plot(*along(way, begin, min(way.end, begin + BEHIND)), color="C0", linewidth=1.8)
