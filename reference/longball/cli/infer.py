"""``longball infer``."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from longball.cli.changes import chosen_changes
from longball.cli.messages import assignments, fail, refuse_if, refusing, wrong_call
from longball.cli.scenes import one_scene
from longball.engines.engine import CannotSolve
from longball.model.changes import value_of
from longball.model.numbers import Undecided
from longball.model.result import Result


def infer(
    source: str = "-",
    points: Path | None = None,
    measured: list[str] | None = None,
    unknown: list[str] | None = None,
    sigma: float | None = None,
    set_: list[str] | None = None,
    reading: list[str] | None = None,
    json_: bool = False,
) -> None:
    """Fit numbers of a scene to measurements: points of a path, or a landing.

    The scene gives the known values and the starting values of the unknowns.
    """
    from longball.questions.inverse import fit

    refuse_if(
        (
            (points is None) == (not measured),
            "either --points FILE or --measured NAME=VALUE is needed",
        ),
        (
            not unknown,
            "--unknown is missing: name a number of the scene, such as --unknown launch.speed",
        ),
    )
    assert unknown
    data: Any
    if points is not None:
        from longball.pitches.table import numbers, read_table

        # Columns may be in any order.
        with refusing():
            _, table = read_table(points, ("t", "x", "y", "z"))
            data = {name: numbers(table[name]) for name in table}
    else:
        pairs = assignments("--measured", measured)
        # Values may have units, such as 390ft for landing.distance.
        with refusing("--measured "):
            data = {name: value_of(name, text, [Result]) for name, text in pairs.items()}
    scene = one_scene(source, chosen_changes(set_, None, reading))
    with answering():
        fitted = fit(data, scene, unknowns=unknown, sigma=sigma)
    if not json_:
        print(fitted)
        return
    print(
        json.dumps(
            {
                "value": fitted.value,
                "sigma": fitted.sigma,
                "covariance": fitted.covariance.tolist(),
                "chi_squared": fitted.chi_squared,
                "freedom": fitted.freedom,
                "scene": json.loads(fitted.scene.line()),
            }
        )
    )


@contextmanager
def answering() -> Iterator[None]:
    """Turn errors without an answer into status 1, and misuse into a usage error."""
    try:
        yield
    except (CannotSolve, Undecided) as error:
        fail(str(error))
    # Last, since the exceptions above are ValueErrors, too.
    except (TypeError, ValueError) as error:
        wrong_call(str(error))
