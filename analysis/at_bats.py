"""A few at-bats, from the pitcher's hand to the ground."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from analysis.writing import LINES, figure, shown, table
from longball.engines.at_bat import solve
from longball.engines.engine import Stops
from longball.engines.ivp import Ivp, Leg
from longball.model.motion import forces, into_plane
from longball.model.numbers import DOUBLES
from longball.model.result import Result, Triple
from longball.model.scene import AtBatScene, Pitch, Swing

Point = tuple[float, float, float]
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


def run(report: Path, full: bool) -> str:
    """Solve the at-bats and draw them; `full` changes nothing."""
    scenes = {name: at_bat(name, *swing) for name, swing in SWINGS.items()}
    results = {name: solve(scene, Ivp()) for name, scene in scenes.items()}
    with figure(report, "at_bats", rows=2, size=(7.0, 5.6)) as (whole, near):
        for (name, result), dash in zip(results.items(), LINES, strict=True):
            if result.landing is None:
                continue
            x, z = batted_path(scenes[name], result)
            whole.plot(x, z, linestyle=dash, label=f"{name}, {result.landing.distance:.0f} m")
            near.plot(x, z, linestyle=dash)
        x, z = pitched_path(scenes["miss"])
        for axes in (whole, near):
            axes.plot(x, z, color="black", linewidth=0.8, label="pitch")
            axes.set_xlabel("x toward the pitcher, m")
            axes.set_ylabel("height z, m")
        whole.legend(fontsize="small", ncols=2)
        near.set(xlim=(-0.25, 0.55), ylim=(1.05, 1.4), title="over the plate", aspect="equal")
        draw_bats(near, scenes, results)
    caption = (
        "Five swings at one pitch. Above: the whole flights. Below: the bats, as circles, and the "
        "ball where it touches each of them."
    )
    return "\n".join(
        [
            "## A few at-bats\n",
            "One pitch of 139.1 km/h on cell 2, and five swings that differ by a few centimetres "
            "of height and a few degrees of tilt. `margin` is how deep the undisturbed pitch "
            "would have gone into the bat; `ẽ` is the restitution between ball and bat.\n",
            table(
                report, "at_bats", pd.DataFrame([row(n, results[n], *SWINGS[n]) for n in SWINGS])
            ),
            shown("at_bats", caption),
        ]
    )


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
    speed = math.hypot(*doubles(impact.velocity)) if impact else math.nan
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


def batted_path(scene: AtBatScene, result: Result) -> tuple[Array, Array]:
    """Return x and z along the flight of a batted ball."""
    assert result.contact is not None
    assert result.contact.position is not None
    assert result.impact is not None
    stops = Stops(time_limit=scene.time_limit, floor=scene.ground.height)
    return path(scene, doubles(result.contact.position), doubles(result.impact.velocity), stops)


def pitched_path(scene: AtBatScene) -> tuple[Array, Array]:
    """Return x and z along the pitch, as far as a third of a metre behind the plate."""
    x, y, z = scene.pitch.release
    toward = (-x, scene.pitch.aim[0] - y, scene.pitch.aim[1] - z)
    scale = scene.pitch.speed / math.hypot(*toward)
    velocity = (toward[0] * scale, toward[1] * scale, toward[2] * scale)
    return path(
        scene, scene.pitch.release, velocity, Stops(time_limit=scene.time_limit, wall=x + 0.33)
    )


def path(
    scene: AtBatScene, position: Point, velocity: Point, stops: Stops[float]
) -> tuple[Array, Array]:
    """Return x and z, m, along a flight: the solver's steps, joined by their own velocities."""
    plane, start = into_plane(position, velocity, DOUBLES)
    field = forces(scene.ball, scene.air, scene.gravity, False, DOUBLES)
    record = Ivp().fly(start, field, stops).record
    assert isinstance(record, Leg)
    spline = CubicHermiteSpline(record.times, record.states[:2].T, record.states[2:].T)
    s, z = spline(np.linspace(record.times[0], record.times[-1], 400)).T
    return plane.x + plane.cos * s, z


def doubles(triple: Triple) -> Point:
    """Return a vector of a result as doubles."""
    x, y, z = triple
    return float(x), float(y), float(z)


def draw_bats(axes: Axes, scenes: dict[str, AtBatScene], results: dict[str, Result]) -> None:
    """Draw bat and ball at their touching, the bat where the swing has put it."""
    for name, result in results.items():
        scene, plate, contact = scenes[name], result.plate, result.contact
        assert plate is not None
        assert contact is not None
        height = float(plate.position[2]) + scene.swing.height_offset
        axes.add_patch(Circle((0.0, height), scene.bat.radius, fill=False, linewidth=0.8))
        if contact.position is not None:
            x, _, z = doubles(contact.position)
            ball = Circle((x, z), scene.ball.radius, fill=False, linewidth=0.8, linestyle=":")
            axes.add_patch(ball)
