"""Coverage of the golden data: which edits of the model they notice, family by family."""

from collections import Counter

import numpy as np
import pandas as pd

from analysis.scene_search import ENOUGH, POOL, drawn, is_ordinary
from analysis.writing import Report
from longball import golden
from longball.engines.ivp import Ivp
from longball.judge.cases import Case, decidable, solved
from longball.judge.coverage import NOTICED, Coverage, coverage

# Random scenes that tell which edits change anything; what none of so many shows is rare.
SCENES, FULL_SCENES = 200, 2000
SEED = 41  # not that of the search, whose scenes the golden data have
EVERY = 16  # edits of the operators, of which one is tried
FEW = ["stage", "edit", "golden", "drawn", "case"]  # columns of a table
SHOWN = 40  # edits in the list of those that few cases notice


def run(report: Report, full: bool) -> str:
    """Hold every edit against every golden case and the random scenes, and sum up."""
    pool = solved(drawn(FULL_SCENES if full else SCENES, SEED), Ivp(), POOL)
    cases: list[Case] = [*golden.load("all"), *(case for case in pool if decidable(case))]
    found = coverage(cases, 1 if full else EVERY)
    families = np.array([case.family for case in found.cases])
    own = families != POOL
    counts = found.noticed[:, own].sum(axis=1)
    names = [name for name in golden.header().families if name in families]
    shown = {name: found.noticed[:, families == name].any(axis=1) for name in names}
    once = sum(shown.values()) == 1
    alone = {name: int((seen & once).sum()) for name, seen in shown.items()}
    ordinary = found.noticed[:, is_ordinary(families)].any(axis=1)
    quick = np.isin([case.id for case in found.cases], golden.header().quick)
    surely = (counts >= ENOUGH) & ordinary
    few = [
        {"golden": counts[i], "drawn": found.noticed[i, ~own].sum()} | found.told(i)
        for i in sorted(np.flatnonzero(~surely), key=lambda i: counts[i])
    ]
    report.write_table("coverage_few", pd.DataFrame(few, columns=FEW))
    return report.render(
        "coverage", globals(), found=found, counts=counts, shown=shown, alone=alone, surely=surely,
        quick=found.noticed[:, quick].any(axis=1), quick_cases=int(quick.sum()), few=few,
        stages=zip(found.by_stage(counts > 0), found.by_stage(surely), strict=True),
        cases=int(own.sum()), pool=int((~own).sum()), same=reasons(found), full=full,
        notices=NOTICED, every=EVERY if not full else 1,
    )  # fmt: skip


def reasons(found: Coverage) -> list[tuple[str, int, str]]:
    """Return why edits move no number of any scene, how many do so, and an example of each."""
    count, example = Counter[str](), dict[str, str]()
    for edit, stage, reason in found.unnoticed:
        count[reason] += 1
        example.setdefault(reason, f"{stage}: {edit.words}")
    return [(reason, n, example[reason]) for reason, n in count.most_common()]
