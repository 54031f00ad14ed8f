"""``longball flight``."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np
import typer

from longball import engines
from longball.cli.changes import SetOption, chosen_changes
from longball.cli.common import AnyEngine, Json, note, refusing, show, tell, wrong_call
from longball.engines.chain import solve
from longball.model.doubts import doubts
from longball.model.names import one_of
from longball.model.result import signed
from longball.model.scene import InvalidScene
from longball.model.units import UNITS, read_in_si
from longball.pitches.models import MODELS, model_of
from longball.pitches.prediction import scenes
from longball.pitches.statcast import FOOT, SEA_LEVEL, USUAL_TEMPERATURE, MeasuredFlies
from longball.questions.parks import park as park_of

# Where a wind blows to: along x and y.
WAYS = {"out": (1.0, 0.0), "in": (-1.0, 0.0), "left": (0.0, 1.0), "right": (0.0, -1.0)}


def flight(
    speed: Annotated[str, typer.Option(help='Off the bat, as "103 mph"; a number is in m/s.')],
    angle: Annotated[str, typer.Option(help="Above the horizontal; a number is in degrees.")],
    direction: Annotated[
        str, typer.Option(help="From centre field to the left; a number is in degrees.")
    ] = "0",
    park: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Whose fence and elevation; by default at sea level."),
    ] = None,
    wind: Annotated[
        str | None, typer.Option(help='As "10 mph out": out, in, left or right.')
    ] = None,
    temperature: Annotated[
        str, typer.Option(help='As "72 F"; a number is in K; by default 20 °C.')
    ] = str(USUAL_TEMPERATURE),
    elevation: Annotated[
        str | None, typer.Option(help="Above the sea, instead of the park's; a number is in m.")
    ] = None,
    bats: Annotated[
        str | None,
        typer.Option(metavar="R|L", help="The batter's side, which turns the ball's spin."),
    ] = None,
    model: Annotated[
        str, typer.Option(metavar="NAME", help=f"Of flight: {', '.join(MODELS)}.")
    ] = "nathan",
    set_: SetOption = None,
    engine: AnyEngine = "ivp",
    as_json: Json = False,
) -> None:
    """Compute the flight of a batted ball.

    It has the spin that a published regression expects at that angle and in that direction, as
    measured flies have in `longball measured`; --set launch.spin=… gives it another.
    """
    with refusing("--"):
        law = model_of(model)
    if bats not in (None, "R", "L"):
        wrong_call(f"--bats {bats}: R or L")
    if park is not None:
        with refusing("--park: "):
            where = park_of(park)
    height = where.elevation if park is not None else SEA_LEVEL
    change = chosen_changes(set_, None)
    if park is not None and not any(name.startswith("fence") for name, _ in change.values):
        block = where.fence.model_dump(mode="json", exclude_none=True)
        change = type(change)((("fence", block), *change.values))
    if wind is not None:
        change = type(change)((("air.wind", _wind(wind)), *change.values))
    ball = _ball(
        _in_si("--speed", speed, "m/s"),
        _in_si("--angle", angle, "rad", "deg"),
        -_in_si("--direction", direction, "rad", "deg"),
        {"R": 1.0, "L": -1.0, None: 0.0}[bats],
        _in_si("--temperature", temperature, "K"),
        height if elevation is None else _in_si("--elevation", elevation, "m"),
    )
    with refusing():
        solver: Any = engines.create(engine)
    (scene,) = scenes(ball, law, change=change)
    if isinstance(scene, InvalidScene):
        wrong_call(str(scene).partition("is no scene: ")[2])
    for key, question in doubts(scene):
        note(f"{key}: {question}")
    result = solve(scene, solver).model_copy(update={"id": None})
    if result.error is not None:
        tell(result.error)
        raise typer.Exit(1)
    if as_json:
        print(result.model_copy(update={"engine": signed(result.engine or "")}).line())
        return
    show(["", "SI", "ft, mph, °"], _rows(result))


def _in_si(option: str, text: str, si: str, usual: str = "") -> float:
    """Return a number of an option, with or without a unit, in an SI unit."""
    with refusing(f"{option} {text}: "):
        number = read_in_si(text, si, usual)
    if number is None:
        units = ", ".join(UNITS[si])
        wrong_call(f"{option} {text}: a number is needed, alone or with a unit: {units}")
    return number


def _wind(text: str) -> list[float]:
    """Return the wind of a text such as 10 mph out, m/s."""
    amount, _, word = text.strip().rpartition(" ")
    if word not in WAYS:
        wrong_call(f"--wind {text}: say where it blows to, as '10 mph out'"
                   f"{one_of('the ways are', word, WAYS)}")  # fmt: skip
    speed = _in_si("--wind", amount, "m/s")
    return [speed * way for way in WAYS[word]] + [0.0]


def _ball(
    speed: float, angle: float, bearing: float, side: float, temperature: float, elevation: float
) -> MeasuredFlies:
    """Return one ball as measured ones are; its bearing is positive to right field."""
    if not speed > 0.0:
        wrong_call(f"--speed: must be positive (got {speed} m/s)")
    one = {
        name: np.array([value])
        for name, value in (
            ("temperature", temperature), ("elevation", elevation), ("speed", speed),
            ("angle", angle), ("bearing", bearing), ("side", side),
        )
    }  # fmt: skip
    return MeasuredFlies(
        source="", rows_read=1, left_out=(), rows=np.array([1]), games=np.array([0]),
        weather_unknown=0, assumed=(), measured=np.full((1, 1), math.nan), **one,
    )  # fmt: skip


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
