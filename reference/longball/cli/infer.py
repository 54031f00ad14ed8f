"""``longball infer``."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from longball.cli.changes import ReadingOption, SetOption, chosen_changes
from longball.cli.common import Json, assignments, fail, refusing, wrong_call
from longball.cli.scenes import Source, one_scene
from longball.engines.engine import CannotSolve
from longball.model.jsonl import json_or_number
from longball.model.numbers import Undecided
from longball.model.scene import InvalidScene

Unknowns = Annotated[
    list[str] | None,
    typer.Option(
        "--unknown",
        metavar="NAME",
        help="A number to be found, as launch.speed, launch.angle, air.drag_coefficient; "
        "repeatable.",
    ),
]


def infer(
    source: Source = "-",
    points: Annotated[
        Path | None,
        typer.Option(
            metavar="POINTS.csv",
            exists=True,
            dir_okay=False,
            help="Points of the path: columns t, x, y, z, in s and m.",
        ),
    ] = None,
    measured: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            help="A number of the result, as landing.distance=118.2; repeatable.",
        ),
    ] = None,
    unknown: Unknowns = None,
    sigma: Annotated[
        float | None,
        typer.Option(help="Standard deviation of the measurements; if left out, as they scatter."),
    ] = None,
    set_: SetOption = None,
    reading: ReadingOption = None,
    as_json: Json = False,
) -> None:
    """Find numbers of a scene from what was measured: points of a path, or a landing.

    The scene has all that is known, and where the search for the unknowns starts.
    """
    from longball.questions.inverse import fit

    if (points is None) == (not measured):
        wrong_call("either --points FILE or --measured NAME=VALUE is needed")
    if not unknown:
        wrong_call("--unknown: name a number to be found, such as --unknown launch.speed")
    data: Any
    if points is not None:
        import pandas as pd

        with refusing(f"--points {points}: "):  # pandas' errors are ValueErrors
            data = pd.read_csv(points)
    else:
        pairs = assignments("--measured", measured)
        data = {name: json_or_number(value) for name, value in pairs.items()}
    scene = one_scene(source, chosen_changes(set_, None, reading))
    with answering():
        found = fit(data, scene, unknowns=unknown, sigma=sigma)
    if not as_json:
        print(found)
        return
    print(
        json.dumps(
            {
                "value": found.value,
                "sigma": found.sigma,
                "covariance": found.covariance.tolist(),
                "chi_squared": found.chi_squared,
                "freedom": found.freedom,
                "scene": json.loads(found.scene.line()),
            }
        )
    )


@contextmanager
def answering() -> Iterator[None]:
    """Say why there is no answer, with status 1; a misuse is a wrong call."""
    try:
        yield
    except (CannotSolve, Undecided, InvalidScene) as error:
        fail(str(error))
    except (TypeError, ValueError) as error:
        wrong_call(str(error))
