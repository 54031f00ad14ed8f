"""Cost of laws of flight: spin, wind and a drag crisis, beside the paper's law and heyoka."""

from dataclasses import dataclass, field
from typing import Any

import longball as lb
from analysis.speed_error import contenders
from analysis.speed_error.contenders import Answers, Contender
from analysis.speed_error.measuring import Measured, measure
from analysis.speed_error.work import Work, flights, known
from analysis.writing import data
from longball.engines.batch import Batch, solve_columns
from longball.engines.batch.flights import Records
from longball.engines.batch.many import BLOCK
from longball.model.trace import Program

LAWS = data(__file__)


def works(count: int) -> dict[str, Work]:
    """Return the same launches under each law."""
    level, found = flights(count), {}
    for name, law in LAWS.items():
        launch = level.base.model_dump()["launch"] | {"spin": law.get("spin")}
        blocks: Any = {"launch": launch, "air": law.get("air", {})}
        found[name] = Work(lb.Flight(id="flight", **blocks), level.columns)
    return found


@dataclass(frozen=True)
class _Recording(Batch):
    """The batch engine, noting what it is given to fly."""

    given: list[tuple[Records, Program]] = field(default_factory=list)

    def fly_all(self, starts: Records, program: Program) -> Records:
        """Fly records to their stops."""
        self.given.append((starts, program))
        return super().fly_all(starts, program)


def kernel(work: Work) -> Contender:
    """Return the compiled code of the batch engine, without what makes records and tables.

    It flies the first scenes of the work, and answers nothing.
    """
    engine = _Recording()
    solve_columns(work.base, work[:BLOCK].columns, engine)
    ((starts, program),) = engine.given

    def solved(some: Work) -> Answers:
        engine.fly_all(starts[: len(some)], program)
        return Answers([""] * len(some), [None] * len(some))

    return Contender("kernel", "", solved, BLOCK)


def compared(rounds: int, count: int) -> dict[tuple[str, str], Measured]:
    """Time all under each law, in the same rounds; return what is found by law and method.

    Errors are those of the first `count` flights.
    """
    turns: dict[tuple[str, str], tuple[Contender, Work]] = {}
    for law, work in works(contenders.COMPILED).items():
        given = known(work, count)
        entrants = [kernel(work), contenders.batch(Batch().tolerance), contenders.ENCLOSURE]
        if "heyoka" not in contenders.missing_peers():
            entrants += contenders.heyoka()
        turns |= {(law, entrant.family): (entrant, given) for entrant in entrants}
    return dict(zip(turns, measure([*turns.values()], rounds), strict=True))
