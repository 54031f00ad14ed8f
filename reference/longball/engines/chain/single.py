"""One scene: the chain followed to its end, and a result of what it wrote."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, get_args

from pydantic import ValidationError

from longball.engines.chain.at_bat import CHAINS, Approach, approach_bat, finish, meet_bat
from longball.engines.chain.cases import Cases
from longball.engines.chain.collision import MODEL, ContactState, Model
from longball.engines.chain.landing import Batted, land_in_space
from longball.engines.digits import to_digits
from longball.engines.engine import CannotSolve, Engine, ManyAtOnce, OutOfRange, Touch
from longball.engines.parallel import in_parallel
from longball.engines.path import Flight, Leg, Trajectory
from longball.model import result as written
from longball.model.frame import Frame
from longball.model.numbers import N, Undecided
from longball.model.quantities import nested, replaced
from longball.model.result import Outcome, Result
from longball.model.scene import AtBatScene, InvalidScene, Scene


@dataclass(frozen=True)
class OneCase(Cases[N]):
    """A scene, whose results are written into `answer`, and the way of its ball into `legs`.

    Once its outcome is known it is there no more.
    """

    scene: Scene
    engine: Engine[N]
    model: Model
    answer: dict[str, Any] = field(default_factory=dict)
    legs: list[Leg[N]] = field(default_factory=list)
    empty: bool = False
    engines: list[str] = field(default_factory=list)  # that flew the ball, in order

    def decide(self, x: N, error: N, question: str) -> tuple[bool, bool]:
        """See `Cases`."""
        positive = self.numbers.positive(x, error, question)
        return positive, not positive

    def refuse(self, reason: CannotSolve | Undecided) -> None:
        """See `Cases`."""
        if not self.empty:
            raise reason

    def touched(self, touch: Touch[N]) -> tuple[bool, bool]:
        """See `Cases`."""
        if touch.touched is None:
            raise Undecided(touch.doubt)
        return touch.touched, not touch.touched

    def take(self, condition: bool, *values: Any) -> tuple[Any, ...]:
        """See `Cases`."""
        if condition:
            return self, *values
        # `replace` takes three times as long.
        return OneCase(self.scene, self.engine, self.model, self.answer, self.legs, True), *values

    def either(
        self, condition: bool, yes: Callable[..., Any], no: Callable[..., Any], *values: Any
    ) -> Any:
        """See `Cases`."""
        return (yes if condition else no)(self, *values)

    def land_in_space(self, ball: Batted[N], outcome: Outcome) -> None:
        """See `Cases`."""
        land_in_space(self, ball, outcome)

    def follow(self, frame: Frame[N], flight: Flight[N], begin: N) -> None:
        """See `Cases`."""
        if not self.empty:
            self.legs.append(Leg(begin, frame, flight))

    def flown(self, flight: Flight[N]) -> None:
        """See `Cases`."""
        if not self.empty:
            self.engines.append(flight.flown_by or self.engine.description)

    def record(self, name: str, value: Any) -> None:
        """See `Cases`."""
        if not self.empty:
            self.answer[name] = value

    def conclude(self, outcome: Outcome) -> None:
        """See `Cases`."""
        self.record("outcome", outcome)

    def result(self, error: InvalidScene | Undecided | CannotSolve | None = None) -> Result:
        """Return what has been written, as a result; with an error, if there is one."""
        told = {name: self._reported(x) for name, x in self.answer.items() if name != "outcome"}
        return Result(
            id=self.scene.id,
            engine=described(self.engines) or self.engine.description,
            outcome=None if error else self.answer["outcome"],
            error=None if error is None else str(error),
            code=None if error is None else error.code,
            **nested(told),
        )

    def _reported(self, value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(map(self.numbers.report, value))
        return value if isinstance(value, str | int) else self.numbers.report(value)


def described(engines: Iterable[str]) -> str:
    """Return the description of all engines that flew a ball."""
    return " and ".join(dict.fromkeys(engines))


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

# The quantities that are told, not measured: their types, by name.
DISCRETE: dict[str, type[bool] | type[int]] = {
    f"{name}.{key}": kind
    for name, block in BLOCKS.items()
    for key, field in block.model_fields.items()
    for kind in (bool, int)
    for parts in [(field.annotation, *get_args(field.annotation))]
    if any(kind in (part, *get_args(part)) for part in parts)
}


def solve(scene: Scene, engine: Engine[N], model: Model = MODEL) -> Result:
    """Return the result of a scene; what cannot be solved is a result with an error.

    It has the digits that the engine promises; see `longball.engines.digits.to_digits`.
    """
    result, _ = to_digits(scene, engine, lambda one: (solve_once(scene, one, model), None))
    return result


def solve_once(scene: Scene, engine: Engine[N], model: Model = MODEL) -> Result:
    """Return the result of a scene by this engine, whatever digits it has."""
    return _answer(OneCase(scene, engine, model), CHAINS[scene.kind])


# Starting processes takes a second or two: as long as so many scenes take some engines.
_FEW = 100


def solve_each(
    scenes: Sequence[Scene], engine: Engine[N] | ManyAtOnce, workers: int = 1
) -> Iterable[Result]:
    """Return the results of scenes, in order; of most engines each when it is asked for.

    Workers are threads of an engine that solves many scenes at once, and processes of another.
    """
    if isinstance(engine, ManyAtOnce):
        return engine.solve_all(scenes, workers)
    if workers == 1 or len(scenes) < _FEW:
        return (solve(scene, engine) for scene in scenes)
    return in_parallel(solve, ((scene, engine) for scene in scenes), workers)


def solve_with_path(scene: Scene, engine: Engine[N]) -> tuple[Result, Trajectory[N]]:
    """Return the result of a scene, and the way of its ball from the start of the scene on."""

    def flown(one: Engine[N]) -> tuple[Result, Trajectory[N]]:
        case = OneCase(scene, one, MODEL)
        result = _answer(case, CHAINS[scene.kind])
        return result, Trajectory(tuple(case.legs))

    return to_digits(scene, engine, flown)


def solve_with_points(scene: Scene, engine: Engine[N], points: int) -> Result:
    """Return the result of a scene with so many points of its path, if it has any."""
    result, way = solve_with_path(scene, engine)
    if result.error is not None or not way.legs:
        return result
    with engine.numbers.arithmetic():
        rows = way.evenly(points, engine.numbers)
        path = tuple(tuple(map(engine.numbers.report, row)) for row in rows)
    return result.model_copy(update={"path": path})


def solve_with_restitutions(
    scene: AtBatScene, restitutions: Sequence[float], engine: Engine[N]
) -> list[Result]:
    """Return the results of an at-bat struck with balls that differ in restitution only.

    The pitch and its touching of the bat, which do not depend on it, are solved once.
    """
    case = OneCase(scene, engine, MODEL)
    struck: list[tuple[Cases[N], ContactState[N] | None]] = []
    concluded = _follow(case, lambda: struck.append(meet_bat(case)))
    if concluded is not None:
        return [concluded] * len(restitutions)
    ((_, contact),) = struck
    return [
        _answer(
            replace(
                case,
                scene=replaced(scene, {"ball.restitution": e}),
                answer=dict(case.answer),
                engines=[*case.engines],
            ),
            lambda one: finish(one, contact),
        )
        for e in restitutions
    ]


def quantities_of(scene: Scene, engine: Engine[N]) -> dict[str, Any]:
    """Return what a result holds by its names, the outcome too, in the engine's own numbers.

    Raises `ArithmeticError` or `ValueError` if there is no result: `CannotSolve`, `InvalidScene`,
    `Undecided`, or what `_follow` words.
    """
    case = OneCase(scene, engine, MODEL)
    with engine.numbers.arithmetic():
        CHAINS[scene.kind](case)
    return case.answer


def approach_of(scene: AtBatScene, engine: Engine[N]) -> Approach[N] | None:
    """Return how pitch and bat of a scene meet; None if the pitch does not reach the plate.

    Raises `CannotSolve` or `InvalidScene` or `Undecided`.
    """
    with engine.numbers.arithmetic():
        return approach_bat(OneCase(scene, engine, MODEL))[1]


def _answer(case: OneCase[N], chain: Callable[[OneCase[N]], None]) -> Result:
    """Go through a chain to its end; return the result."""
    result = _follow(case, lambda: chain(case))
    assert result is not None
    return result


def _follow(case: OneCase[N], chain: Callable[[], None]) -> Result | None:
    """Go through a chain; return the result, or an error; None if it is not concluded."""
    with case.numbers.arithmetic():
        try:
            try:
                chain()
            except (InvalidScene, Undecided, CannotSolve) as error:
                return case.result(error)
            return case.result() if "outcome" in case.answer else None
        except (ArithmeticError, ValueError) as error:
            what = "a quantity is not finite" if isinstance(error, ValidationError) else str(error)
            reason = OutOfRange(f"the numbers leave the range of the engine: {what}")
            return replace(case, answer={}).result(reason)
