"""``longball infer``."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from longball.cli.changes import chosen_changes
from longball.cli.messages import fail, refusing, wrong_call
from longball.cli.options import Options
from longball.cli.scenes import one_scene
from longball.engines.engine import CannotSolve
from longball.model.changes import value_of
from longball.model.numbers import Undecided
from longball.model.result import Result


def infer(o: Options) -> None:
    """Fit numbers of a scene to measurements: points of a path, or a landing.

    The scene gives the known values and the starting values of the unknowns.
    """
    from longball.questions.inverse import fit

    if (o.points is None) == (not o.measured):
        wrong_call("either --points FILE or --measured NAME=VALUE is needed")
    if not o.unknown:
        wrong_call("--unknown is missing: name a number, such as --unknown launch.speed")
    data: Any
    if o.points is not None:
        from longball.pitches.table import numbers, read_table

        # Columns may be in any order.
        with refusing():
            _, table = read_table(o.points, ("t", "x", "y", "z"))
            data = {name: numbers(table[name]) for name in table}
    else:
        # Values may have units, such as 390ft for landing.distance.
        with refusing("--measured "):
            data = {name: value_of(name, text, [Result]) for name, text in o.measured.items()}
    scene = one_scene(o.source, chosen_changes(o))
    with answering():
        fitted = fit(data, scene, unknowns=o.unknown, sigma=o.sigma)
    if not o.json:
        print(fitted)
        return
    names = "value", "sigma", "covariance", "chi_squared", "freedom"
    shown = {name: getattr(fitted, name) for name in names}
    shown["covariance"] = fitted.covariance.tolist()
    print(json.dumps(shown | {"scene": json.loads(fitted.scene.line())}))


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
