"""A Python function as a candidate: ``longball judge -- python my_simulator.py``.

>>> from longball.judge import serve
>>>
>>> def fly(state, parameters):
...     ...  # x, y, z, vx, vy, vz and the numbers of the scene
...     return points  # rows of t, x, y, z or t, x, y, z, vx, vy, vz; or {"position": …, "time": …}
>>>
>>> serve(fly)
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TextIO

from longball.model.plain import plain
from longball.model.quantities import numbers
from longball.model.scene import InvalidScene, parse_scene

State = tuple[float, float, float, float, float, float]
Fly = Callable[[State, Mapping[str, float]], Any]


def serve(
    function: Fly, scenes: Iterable[str] | None = None, results: TextIO | None = None
) -> None:
    """Answer flights and pitches with a function, one line of JSON for each scene.

    Parameters
    ----------
    function
        Takes the state at launch (m, m/s) and the numbers of the scene by their names
        (``air.density``, ``ball.mass``, ``gravity``, ``ground.height``; what the scene does not
        have is left out). Returns points, from the launch on, or a mapping with what a ``landing``
        (``plate`` of a pitch) holds: time, position, velocity, distance. A ball is airborne if its
        points go on in the air to ``time_limit``, or if it lands after that.
    scenes, results
        Lines of JSON; standard input and output if not given.
    """
    out = results or sys.stdout
    for line in scenes if scenes is not None else sys.stdin:
        if line.strip():
            print(json.dumps(_answer(function, line)), file=out, flush=True)


def _answer(function: Fly, line: str) -> dict[str, Any]:
    try:
        scene: Any = parse_scene(line)
    except InvalidScene as error:
        return {"id": error.scene_id, "error": str(error)}
    if scene.kind not in ("flight", "pitch"):
        return {"id": scene.id, "error": f"only flights and pitches are served, not {scene.kind}"}
    if scene.kind == "flight":
        position, velocity = scene.launch.position, scene.launch.velocity
    else:
        position, velocity = scene.pitch.release, scene.pitch.thrown
    values = {name: float(value) for name, value in numbers(scene)}
    try:
        made = plain(function((*position, *velocity), values))
    except Exception as error:  # whatever a simulator raises is the answer to this scene
        return {"id": scene.id, "error": f"{type(error).__name__}: {error}"}
    if not isinstance(made, Mapping):
        return {"id": scene.id, "path": made}
    time = made.get("time")
    if isinstance(time, float | int) and time > scene.time_limit:
        return {"id": scene.id, "outcome": "airborne"}
    block, outcome = ("landing", "landed") if scene.kind == "flight" else ("plate", "crossed")
    return {"id": scene.id, "outcome": outcome, block: dict(made)}
