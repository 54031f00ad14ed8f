"""Coverage of the golden data: which edits of the model they notice, family by family."""

from collections import Counter
from collections.abc import Iterator

import numpy as np
import pandas as pd

from analysis.scene_search import ENOUGH, drawn
from analysis.writing import Report
from longball import golden
from longball.engines.ivp import Ivp
from longball.judge.cases import Case, decidable, solved
from longball.judge.coverage import NOTICED, Coverage, coverage

# Random scenes that tell which edits change anything; what none of so many shows is rare.
SCENES, FULL_SCENES = 200, 2000
EVERY = 16  # edits of the operators, of which one is tried
POOL = "drawn"  # the family of these scenes
SHOWN = 40  # blind spots in the table


def run(report: Report, full: bool) -> str:
    """Hold every edit against every golden case and the random scenes, and sum up."""
    pool = solved(drawn(FULL_SCENES if full else SCENES), Ivp(), POOL)
    cases: list[Case] = [*golden.load("all"), *(case for case in pool if decidable(case))]
    found = coverage(cases, 1 if full else EVERY)
    families = np.array([case.family for case in found.cases])
    own = families != POOL
    counts = found.noticed[:, own].sum(axis=1)
    names = [name for name in golden.header().families if name in families]
    shown = {name: found.noticed[:, families == name].any(axis=1) for name in names}
    once = sum(shown.values()) == 1
    alone = {name: int((seen & once).sum()) for name, seen in shown.items()}
    ordinary = found.noticed[:, own & ~np.char.startswith(families, "hard")].any(axis=1)
    quick = np.isin([case.id for case in found.cases], golden.header().quick)
    blind = [found.told(i) for i in np.flatnonzero(counts == 0)]
    report.write_table("coverage_blind", pd.DataFrame(blind, columns=["stage", "edit", "case"]))
    return report.render(
        "coverage", globals(), found=found, counts=counts, shown=shown, alone=alone,
        ordinary=ordinary, quick=found.noticed[:, quick].any(axis=1), quick_cases=int(quick.sum()),
        stages=found.by_stage(counts > 0), enough=dict(by(found, counts >= ENOUGH)), blind=blind,
        cases=int(own.sum()), pool=int((~own).sum()), same=reasons(found), full=full,
        notices=NOTICED, every=EVERY if not full else 1,
    )  # fmt: skip


def by(found: Coverage, some: np.ndarray) -> Iterator[tuple[str, int]]:
    """Yield the stages, and the numbers of some edits among theirs."""
    yield from ((name, count) for name, _, count in found.by_stage(some))


def reasons(found: Coverage) -> list[tuple[str, int, str]]:
    """Return why edits move no number of any scene, how many do so, and an example of each."""
    count, example = Counter[str](), dict[str, str]()
    for edit, stage, reason in found.unnoticed:
        count[reason] += 1
        example.setdefault(reason, f"{stage}: {edit.words}")
    return [(reason, n, example[reason]) for reason, n in count.most_common()]
