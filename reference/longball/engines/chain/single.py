"""One scene: the chain followed to its end, and a result of what it wrote."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any, get_args

from pydantic import ValidationError

from longball.engines.chain.at_bat import CHAINS, BatEncounter, approach_bat, finish, meet_bat
from longball.engines.chain.collision import MODEL, ContactState, Model
from longball.engines.chain.run import Run
from longball.engines.digits import to_digits
from longball.engines.engine import CannotSolve, Engine, ManyAtOnce, OutOfRange
from longball.engines.parallel import in_parallel
from longball.engines.path import Trajectory
from longball.model import result as written
from longball.model.numbers import Undecided
from longball.model.quantities import nested, replaced
from longball.model.result import Result
from longball.model.scene import AtBatScene, InvalidScene, Scene

BLOCKS: dict[str, type[Any]] = {
    "plate": written.Plate,
    "contact": written.Contact,
    "impact": written.Impact,
    "apex": written.Apex,
    "fence": written.Fence,
    "landing": written.Landing,
}

# The same, and the blocks within them, by their names.
PARTS: dict[str, type[Any]] = {
    **BLOCKS,
    "plate.approach": written.Approach,
}

# The quantities that are flags or whole numbers, not measured: their types, by name.
DISCRETE: dict[str, type[bool] | type[int]] = {
    f"{name}.{key}": kind
    for name, block in BLOCKS.items()
    for key, field in block.model_fields.items()
    for kind in (bool, int)
    for parts in [(field.annotation, *get_args(field.annotation))]
    if any(kind in (part, *get_args(part)) for part in parts)
}


def solve(scene: Scene, engine: Engine, model: Model = MODEL) -> Result:
    """Return the result of a scene; what cannot be solved is a result with an error.

    It has the digits that the engine promises; see `longball.engines.digits.to_digits`.
    """
    result, _ = solve_with_path(scene, engine, model)
    return result


def solve_once(scene: Scene, engine: Engine, model: Model = MODEL) -> Result:
    """Return the result of a scene by this engine, whatever digits it has."""
    return _answer(Run(scene, engine, model), CHAINS[scene.kind])


# Starting processes takes a second or two: as long as so many scenes by the slower engines.
_FEW = 100


def solve_each(
    scenes: Sequence[Scene], engine: Engine | ManyAtOnce, workers: int = 1
) -> Iterable[Result]:
    """Return the results of scenes, in order; of most engines each when it is asked for.

    Workers are threads of an engine that solves many scenes at once, and processes of another.
    """
    if isinstance(engine, ManyAtOnce):
        return engine.solve_all(scenes, workers)
    if workers == 1 or len(scenes) < _FEW:
        return (solve(scene, engine) for scene in scenes)
    return in_parallel(solve, ((scene, engine) for scene in scenes), workers)


def solve_with_path(
    scene: Scene, engine: Engine, model: Model = MODEL
) -> tuple[Result, Trajectory]:
    """Return the result of a scene, and the way of its ball from the start of the scene on."""

    def flown(one: Engine) -> tuple[Result, Trajectory]:
        run = Run(scene, one, model)
        result = _answer(run, CHAINS[scene.kind])
        return result, Trajectory(tuple(run.legs))

    return to_digits(scene, engine, flown)


def solve_with_points(scene: Scene, engine: Engine, points: int) -> Result:
    """Return the result of a scene with so many points of its path, if it has any."""
    result, way = solve_with_path(scene, engine)
    if result.error is not None or not way.legs:
        return result
    with engine.numbers.arithmetic():
        rows = way.evenly(points, engine.numbers)
        path = tuple(tuple(map(engine.numbers.report, row)) for row in rows)
    return result.model_copy(update={"path": path})


def solve_with_restitutions(
    scene: AtBatScene, restitutions: Sequence[float], engine: Engine
) -> list[Result]:
    """Return the results of an at-bat struck with balls that differ in restitution only.

    The pitch and its touching of the bat, which do not depend on it, are solved once.
    """
    # the pitch, once
    run = Run(scene, engine, MODEL)
    struck: list[ContactState | None] = []
    concluded = _follow(run, lambda: struck.append(meet_bat(run)))
    if concluded is not None:
        return [concluded] * len(restitutions)
    # the rest for each restitution, from a copy of what the pitch has recorded
    (contact,) = struck
    return [
        _answer(
            replace(
                run,
                scene=replaced(scene, {"ball.restitution": e}),
                answer=dict(run.answer),
                engines=[*run.engines],
            ),
            lambda one: finish(one, contact),
        )
        for e in restitutions
    ]


def quantities_of(scene: Scene, engine: Engine) -> dict[str, Any]:
    """Return a result's quantities and outcome by name, in the engine's own numbers.

    Raises `ArithmeticError` or `ValueError` if there is no result: `CannotSolve`, `InvalidScene`,
    `Undecided`, or what `_follow` words.
    """
    run = Run(scene, engine, MODEL)
    with run.numbers.arithmetic():
        CHAINS[scene.kind](run)
    return run.answer


def approach_of(scene: AtBatScene, engine: Engine) -> BatEncounter | None:
    """Return the approach of pitch and bat; None if the pitch does not reach the plate.

    Raises `CannotSolve` or `InvalidScene` or `Undecided`.
    """
    with engine.numbers.arithmetic():
        return approach_bat(Run(scene, engine, MODEL))


def _answer(run: Run, chain: Callable[[Run], None]) -> Result:
    """Go through a chain to its end; return the result."""
    result = _follow(run, lambda: chain(run))
    assert result is not None
    return result


def _follow(run: Run, chain: Callable[[], None]) -> Result | None:
    """Go through a chain; return the result, or an error; None if it is not concluded."""
    with run.numbers.arithmetic():
        try:
            try:
                chain()
            except (InvalidScene, Undecided, CannotSolve) as error:
                return _result(run, error)
            return _result(run) if "outcome" in run.answer else None
        # Overflow, a division by zero, or a result that pydantic refuses: no finite answer. What
        # was recorded is dropped, as it may have the numbers at fault.
        except (ArithmeticError, ValueError) as error:
            what = "a quantity is not finite" if isinstance(error, ValidationError) else str(error)
            reason = OutOfRange(f"the numbers leave the range of the engine: {what}")
            return _result(replace(run, answer={}), reason)


def _result(run: Run, error: InvalidScene | Undecided | CannotSolve | None = None) -> Result:
    """Build the result from the recorded quantities, or from the error."""

    def reported(value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(map(run.numbers.report, value))
        return value if isinstance(value, str | int) else run.numbers.report(value)

    told = {name: reported(x) for name, x in run.answer.items() if name != "outcome"}
    return Result(
        id=run.scene.id,
        engine=" and ".join(dict.fromkeys(run.engines)) or run.engine.description,
        outcome=None if error else run.answer["outcome"],
        error=None if error is None else str(error),
        code=None if error is None else error.code,
        **nested(told),
    )
