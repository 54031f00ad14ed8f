"""The pieces that the studies of the time step share: the truth, and work that can be resumed."""

import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import joblib
import numpy as np
from rich.console import Console
from rich.progress import track

import longball
from analysis.writing import Report
from longball.engines.chain import approach_of, solve
from longball.engines.engine import Engine
from longball.engines.ivp import Ivp
from longball.model.scene import AtBatScene, FlightScene

# Good to 1e-11 m (`python -m analysis accuracy`), and no error of an at-bat shown here is smaller
# than five times that.
TRUTH = Ivp()


def each(
    report: Report, what: str, work: Callable[..., Any], calls: Iterable[Sequence[object]]
) -> list[Any]:
    """Return a function's values for many arguments, on all cores.

    Every answer is kept as soon as it is there, and not computed again while the package and the
    studies, which it depends on, are the same.
    """
    folders = Path(longball.__file__).parent, Path(__file__).parent.parent
    files = sorted(path for folder in folders for path in folder.rglob("*.py"))
    code = joblib.hash([path.read_bytes() for path in files])
    kept = joblib.Memory(report.folder / ".resume" / code, verbose=0).cache(work)
    tasks = [joblib.delayed(kept)(*arguments) for arguments in calls]
    answers = joblib.Parallel(n_jobs=-1, return_as="generator")(tasks)
    console = Console(stderr=True)
    return list(track(answers, what, len(tasks), console=console, disable=not console.is_terminal))


def distance(scene: AtBatScene | FlightScene, engine: Engine) -> float:
    """Return D by an engine, m; NaN if no ball lands."""
    landing = solve(scene, engine).landing
    return float(landing.distance) if landing else math.nan


class Pass(NamedTuple):
    """A pitch that touches the bat."""

    time: float  # s, of the touching
    window: float  # s, in which the undisturbed pitch overlaps the bat: a chord at constant speed
    speed: float  # m/s in the plane across the bat
    level: float  # its horizontal share


def passing(scene: AtBatScene) -> Pass | None:
    """Return a pitch's passage through the bat, by the reference; None for a miss."""
    approach = approach_of(scene, TRUTH)
    if approach is None or approach.touch.time is None or approach.touch.state is None:
        return None
    touch, frame = approach.touch, approach.pitch.frame
    if abs(frame.position(approach.touch.state)[1]) >= scene.bat.length / 2:
        return None
    across, _, falling = frame.velocity(approach.touch.state)
    speed, reach = math.hypot(across, falling), scene.ball.radius + scene.bat.radius
    window = 2 * math.sqrt(touch.margin * (2 * reach - touch.margin)) / speed
    return Pass(approach.touch.time, window, speed, abs(across) / speed)


def golden(count: int) -> list[float]:
    """Return so many shares of 1 that are spread evenly, whatever their number."""
    share = (np.sqrt(5.0) - 1) / 2
    return [float((0.5 + index * share) % 1.0) for index in range(count)]
