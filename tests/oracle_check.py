"""Golden cases confirmed by the oracle in many digits: `python -m tests.oracle_check`.

Every number of a case has to agree to 20 digits of its size, as the golden data's header defines
it, and every word has to be the same. A case is tried with 25 digits of work first, and with more
where they do not suffice: a hard case loses some on its way. Prints of each family how many cases
agree, and to how many digits at least; then a line for each that does not, is not told, or has no
outcome and is not asked.
"""

import argparse
import json
import math
import random
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

import mpmath
from mpmath import mpf

from longball.golden import header
from longball.golden.reader import DATA
from tests import oracle
from tests.nightly import quantities

DIGITS = 20
WORK = (25, 45, 70, 110)
MOST = 30  # digits of the golden data
# Quantities that the files may lack, since they came later.
LATER = ("apex.time", "apex.position", "landing.angle", "plate.approach.vertical",
         "plate.approach.horizontal")  # fmt: skip


class Finding(NamedTuple):
    """Digits to which a case agrees with the oracle, or why they cannot be told."""

    case: str
    digits: float | None
    sentence: str
    seconds: float  # of processor time
    tie: bool = False  # another outcome is nearer than the digits of work


def size(name, told, scene):
    """Size of a quantity, as the header of the golden data defines it."""
    own = oracle.length((*told[name], 0, 0)[:3])
    if name == "contact.margin":
        return max(own, mpf(scene["ball"]["radius"]) + mpf(scene["bat"]["radius"]))
    if name == "impact.friction_margin":
        return max(own, 1)
    if name in ("fence.clearance", "fence.margin"):
        return max(own, oracle.length(told["fence.position"]))
    return own or mpf(1)


def compared(case, result):
    """Digits to which a result agrees with a case, and what agrees least."""
    expected = {k: v for k, v in case["expected"].items() if k not in ("id", "engine")}
    scene = oracle.filled(case["scene"])
    with mpmath.workdps(2 * WORK[-1]):
        told, found = (dict(quantities(block, number=mpf)) for block in (expected, result))
        least, least_name = mpf(0), "nothing"
        for name in told | found:
            if name in LATER and name not in told:
                continue
            here, there = told.get(name), found.get(name)
            if not (isinstance(here, list) and isinstance(there, list)):
                if here != there:
                    return 0.0, f"{name} is {here} in the file, {there} by the oracle"
                continue
            apart = [abs(a - b) for a, b in zip(here, there, strict=True)]
            off = max(apart) / size(name, told, scene)
            if off > least:
                least, least_name = off, name
        if not least:
            return MOST, "all numbers are the same"
        digits = min(float(-mpmath.log10(least)), MOST)
        return digits, f"{least_name} differs by {mpmath.nstr(least, 3)} of its size"


def confirm(case):
    """Solve a golden case in as many digits as it takes."""
    start, before = time.process_time(), None
    for work in WORK:
        try:
            answer = oracle.solve(case["scene"], digits=work)
        except (oracle.Unclear, AssertionError) as error:
            digits, sentence, tie = None, str(error), False
            continue
        digits, sentence = compared(case, answer.result)
        tie = answer.doubt.least < mpf(10) ** -work
        if digits >= DIGITS or (before and abs(digits - before) < 0.1):
            break  # what more digits do not change is a difference
        before = digits
    return Finding(case["id"], digits, sentence, time.process_time() - start, tie)


def written(family):
    """Cases of a family as its file has them."""
    path = DATA / header().families[family].file
    return [*map(json.loads, path.read_text(encoding="utf-8").splitlines())]


def cases(family, sample=None, seed=1):
    """Cases of a family that have an outcome, or so many of them drawn at random."""
    solved = [case for case in written(family) if case["expected"].get("outcome")]
    if sample is None or sample >= len(solved):
        return solved
    return random.Random(f"{seed} {family}").sample(solved, sample)


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--sample", type=int, help="so many cases of each family; by default all")
    parser.add_argument("--seed", type=int, default=1, help="chooses which ones")
    parser.add_argument("--family", action="append", help="only that family; repeatable")
    parser.add_argument("--workers", type=int, help="processes; one per core")
    called = parser.parse_args()
    known = header().families
    chosen = {f: cases(f, called.sample, called.seed) for f in called.family or known}
    everything, row = [], "{:24} {:>5} {:>9} {:>13}"
    print(row.format("family", "cases", "confirmed", "digits, least"))
    with ProcessPoolExecutor(called.workers) as pool:
        futures = {f: [pool.submit(confirm, case) for case in some] for f, some in chosen.items()}
        for family, running in futures.items():
            found = [future.result() for future in running]
            agree = [one.digits for one in found if (one.digits or 0) >= DIGITS]
            least = f"{math.floor(min(agree) * 10) / 10}" if agree else ""
            print(row.format(family, len(found), len(agree), least), flush=True)
            everything += found
    others = [one for one in everything if (one.digits or 0) < DIGITS]
    for one in others:
        told = "not told" if one.digits is None else f"only {one.digits:.1f} digits"
        print(f"{one.case}: {told}: {one.sentence}")
    for case in (case for family in chosen for case in written(family)):
        if not case["expected"].get("outcome"):
            print(f"{case['id']}: not asked: {case['expected']['error']}")
    ties = [one.case for one in everything if one.tie]
    print(f"outcomes that hang on less than the digits of work: {', '.join(ties) or 'none'}")
    slowest = max(everything, key=lambda one: one.seconds)
    print(
        f"{len(everything) - len(others)} of {len(everything)} cases confirmed, "
        f"in {sum(one.seconds for one in everything):.0f} s of processor time, at most "
        f"{slowest.seconds:.1f} s for one, {slowest.case}"
    )
    return 1 if any(one.digits is not None for one in others) else 0


if __name__ == "__main__":
    sys.exit(main())
