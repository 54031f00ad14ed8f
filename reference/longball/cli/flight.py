"""``longball flight``."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np

from longball import engines
from longball.cli.changes import chosen_changes, in_si
from longball.cli.messages import fail, note, refusing, show, wrong_call
from longball.cli.options import Options
from longball.engines.chain import solve
from longball.model.doubts import doubts
from longball.model.jsonl import json_line
from longball.model.result import signed
from longball.model.scene import InvalidScene
from longball.pitches.models import model_of
from longball.pitches.prediction import scenes
from longball.pitches.statcast import FOOT, HIGHEST, LOWEST, SEA_LEVEL, MeasuredFlies
from longball.questions.parks import park as park_of

# Directions in which a wind blows, along x and y.
WINDS = {"out": (1.0, 0.0), "in": (-1.0, 0.0), "left": (0.0, 1.0), "right": (0.0, -1.0)}

# An elevation above this, m, is probably in ft. Mexico City is at 2,240 m.
HIGHEST_PARK = 3000.0


def flight(o: Options) -> None:
    """Compute the flight of a batted ball.

    By default a published regression on angle and direction gives the spin, as in `longball
    measured`; --set launch.spin=… sets another. --scene prints the scene for other commands:
    longball flight … --scene | longball parks -
    """
    blocks: dict[str, Any] = {}
    height = SEA_LEVEL
    if o.park is not None:
        with refusing("--"):
            where = park_of(o.park)
        height = where.elevation
        # A fence in --set replaces the park's.
        if not any(name.startswith("fence") for name in o.set):
            blocks["fence"] = where.fence.model_dump(mode="json", exclude_none=True)
    if o.wind is not None:
        blocks["air.wind"] = _wind(o.wind)
    change = chosen_changes(o, blocks)
    speed, angle = in_si("--speed", o.speed, "m/s"), in_si("--angle", o.angle, "rad", "deg")
    # `not >` also refuses NaN.
    if not speed > 0.0:
        wrong_call(f"--speed: must be positive (got {speed} m/s)")
    if not abs(angle) <= math.pi / 2:
        wrong_call(f"--angle: must be from -90° to 90° (got {math.degrees(angle):g}°)")
    if o.elevation is not None:
        height = in_si("--elevation", o.elevation, "m")
    if height > HIGHEST_PARK:
        note(f"--elevation: {height:g} m is above all parks; is it in ft?")
    # As a row of a table, so that spin and weather are those of `longball measured`.
    ball = MeasuredFlies(
        rows=np.array([1]),
        games=np.array([0]),
        identity=np.empty((1, 0)),
        temperature=np.array([in_si("--temperature", o.temperature, "K")]),
        elevation=np.array([height]),
        speed=np.array([speed]),
        angle=np.array([angle]),
        # --direction is positive to the left, like y; bearings are positive to right field.
        bearing=np.array([-in_si("--direction", o.direction, "rad", "deg")]),
        side=np.array([{"R": 1.0, "L": -1.0, None: 0.0}[o.bats]]),
        measured=np.full((1, 1), math.nan),
    )
    (asked,) = scenes(ball, model_of(o.model), change=change)
    # The regression is for flies: its backspin grows with the angle, beyond all measured values.
    chosen = any(name.startswith(("launch.spin", "launch.backspin")) for name in o.set)
    if model_of(o.model).spin and not chosen and not LOWEST <= angle <= HIGHEST:
        note("the spin is from a regression for 10° to 60°; --set launch.spin=[x,y,z] sets another")
    if isinstance(asked, InvalidScene):
        fault = str(asked).partition("is no scene: ")[2]
        wrong_call(fault.replace("air.density.temperature", "--temperature"))
    for key, question in doubts(asked):
        note(f"{key}: {question}")
    # Without the id of a row.
    asked = asked.model_copy(update={"id": None})
    if o.scene:
        print(asked.line())
        return
    result = solve(asked, engines.create(o.engine))
    if result.error is not None:
        fail(result.error)
    if o.json:
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


def _rows(result: Any) -> list[list[str]]:
    """Return the rows of the printed table, in SI and customary units."""
    landing, fence, apex = result.landing, result.fence, result.apex
    known: list[tuple[str, Any, str, str, float]] = []
    if landing is not None:
        known.append(("distance", landing.distance, "m", "ft", FOOT))
        known.append(("hang time", landing.hang_time, "s", "", 1.0))
        known.append(("landing angle", landing.angle, "rad", "°", math.pi / 180.0))
    if apex is not None:
        known.append(("apex", apex.position[2], "m", "ft", FOOT))
    if fence is not None:
        known.append(("at the fence", math.hypot(*fence.position[:2]), "m", "ft", FOOT))
        known.append(("above its top", fence.clearance, "m", "ft", FOOT))
    rows = [["outcome", str(result.outcome), ""]]
    for name, x, unit, theirs, size in known:
        customary = f"{float(x) / size:.1f} {theirs}" if theirs else ""
        rows.append([name, f"{float(x):.3f} {unit}", customary])
    return rows
