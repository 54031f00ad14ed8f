"""``longball flight``."""

from __future__ import annotations

import math
import re
from typing import Any, Literal

import numpy as np

from longball import engines
from longball.cli.changes import chosen_changes, in_si
from longball.cli.messages import fail, note, refusing, show, wrong_call
from longball.engines.chain import solve
from longball.model.doubts import doubts
from longball.model.jsonl import json_line
from longball.model.result import signed
from longball.model.scene import InvalidScene
from longball.pitches.models import Model, model_of
from longball.pitches.prediction import scenes
from longball.pitches.statcast import (
    FOOT,
    HIGHEST,
    LOWEST,
    SEA_LEVEL,
    USUAL_TEMPERATURE,
    MeasuredFlies,
)
from longball.questions.parks import park as park_of

# Directions in which a wind blows, along x and y.
WINDS = {"out": (1.0, 0.0), "in": (-1.0, 0.0), "left": (0.0, 1.0), "right": (0.0, -1.0)}

# An elevation above this, m, is probably in ft. Mexico City is at 2,240 m.
HIGHEST_PARK = 3000.0


def flight(
    speed: str,
    angle: str,
    direction: str = "0",
    park: str | None = None,
    wind: str | None = None,
    temperature: str = str(USUAL_TEMPERATURE),
    elevation: str | None = None,
    bats: Literal["R", "L"] | None = None,
    model: Model = "nathan",
    set_: list[str] | None = None,
    engine: engines.Name = "ivp",
    scene: bool = False,
    json_: bool = False,
) -> None:
    """Compute the flight of a batted ball.

    By default a published regression on angle and direction gives the spin, as in `longball
    measured`; --set launch.spin=… sets another. --scene prints the scene for other commands:
    longball flight … --scene | longball parks -
    """
    blocks: dict[str, Any] = {}
    height = SEA_LEVEL
    if park is not None:
        with refusing("--"):
            where = park_of(park)
        height = where.elevation
        # A fence in --set replaces the park's.
        if not any(text.startswith("fence") for text in set_ or ()):
            blocks["fence"] = where.fence.model_dump(mode="json", exclude_none=True)
    if wind is not None:
        blocks["air.wind"] = _wind(wind)
    change = chosen_changes(set_, None, blocks=blocks)
    ball = _ball(
        in_si("--speed", speed, "m/s"),
        in_si("--angle", angle, "rad", "deg"),
        # --direction is positive to the left, like y; measured bearings are positive to right
        # field.
        -in_si("--direction", direction, "rad", "deg"),
        {"R": 1.0, "L": -1.0, None: 0.0}[bats],
        in_si("--temperature", temperature, "K"),
        height if elevation is None else in_si("--elevation", elevation, "m"),
    )
    # Through the code for rows of tables, so that spin and weather are those of `longball
    # measured`.
    (asked,) = scenes(ball, model_of(model), change=change)
    if ball.elevation[0] > HIGHEST_PARK:
        note(f"--elevation: {ball.elevation[0]:g} m is above all parks; is it in ft?")
    # The regression is for flies: its backspin grows with the angle, beyond all measured values.
    chosen = any(text.startswith(("launch.spin", "launch.backspin")) for text in set_ or ())
    if model_of(model).spin and not chosen and not LOWEST <= ball.angle[0] <= HIGHEST:
        note("the spin is from a regression for 10° to 60°; --set launch.spin=[x,y,z] sets another")
    if isinstance(asked, InvalidScene):
        fault = str(asked).partition("is no scene: ")[2]
        wrong_call(fault.replace("air.density.temperature", "--temperature"))
    for key, question in doubts(asked):
        note(f"{key}: {question}")
    # Without the id of a row.
    asked = asked.model_copy(update={"id": None})
    if scene:
        print(asked.line())
        return
    result = solve(asked, engines.create(engine))
    if result.error is not None:
        fail(result.error)
    if json_:
        by = {"engine": signed(result.engine or "")}
        print(json_line(result.model_dump(exclude_none=True) | by))
        return
    show(["", "SI", "ft, mph, °"], _rows(result))


def _wind(text: str) -> list[float]:
    """Return the wind vector of a text such as 10 mph out, m/s."""
    amount, _, word = text.strip().rpartition(" ")
    # "10 mph from left" has too many words for a speed and a direction.
    if word not in WINDS or not re.fullmatch(r"[-+.\deE]+\s*[^\s\d]*", amount):
        words = ", ".join(WINDS)
        wrong_call(f"--wind {text}: must be a speed and one of {words}, such as '10 mph out'")
    # Horizontal winds in four directions; --set air.wind takes any vector.
    speed = in_si("--wind", amount, "m/s")
    return [speed * component for component in WINDS[word]] + [0.0]


def _ball(
    speed: float, angle: float, bearing: float, side: float, temperature: float, elevation: float
) -> MeasuredFlies:
    """Return one ball in the form of measured ones; the bearing is positive to right field."""
    # `not >` also refuses NaN.
    if not speed > 0.0:
        wrong_call(f"--speed: must be positive (got {speed} m/s)")
    if not abs(angle) <= math.pi / 2:
        wrong_call(f"--angle: must be from -90° to 90° (got {math.degrees(angle):g}°)")
    return MeasuredFlies(
        rows=np.array([1]),
        games=np.array([0]),
        identity=np.empty((1, 0)),
        temperature=np.array([temperature]),
        elevation=np.array([elevation]),
        speed=np.array([speed]),
        angle=np.array([angle]),
        bearing=np.array([bearing]),
        side=np.array([side]),
        measured=np.full((1, 1), math.nan),
    )


def _rows(result: Any) -> list[list[str]]:
    """Return the rows of the printed table, in SI and customary units."""
    rows = [["outcome", str(result.outcome), ""]]

    def add(name: str, value: Any, unit: str, theirs: str, factor: float) -> None:
        number = float(value)
        rows.append([name, f"{number:.3f} {unit}", f"{number / factor:.1f} {theirs}"])

    landing, fence, apex = result.landing, result.fence, result.apex
    if landing is not None:
        add("distance", landing.distance, "m", "ft", FOOT)
        rows.append(["hang time", f"{float(landing.hang_time):.3f} s", ""])
        add("landing angle", landing.angle, "rad", "°", math.pi / 180.0)
    if apex is not None:
        add("apex", apex.position[2], "m", "ft", FOOT)
    if fence is not None:
        x, y, _ = map(float, fence.position)
        add("at the fence", math.hypot(x, y), "m", "ft", FOOT)
        add("above its top", fence.clearance, "m", "ft", FOOT)
    return rows
