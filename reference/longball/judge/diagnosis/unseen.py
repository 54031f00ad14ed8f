"""New scenes, in which a name has to reproduce the candidate's numbers as well.

They are the compared scenes with every number moved. Their keys, options and readings are the same,
so that the candidate solves them, too. An edit that fits by a coincidence of the golden data's
numbers fails in them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from longball.engines.engine import CannotSolve
from longball.engines.ivp import Ivp
from longball.engines.verlet import Verlet
from longball.judge.answers import Answer
from longball.judge.cases import Known, decidable, solved
from longball.judge.diagnosis.chain import Stage
from longball.judge.diagnosis.clocks import Scheme
from longball.judge.diagnosis.digits import with_cut
from longball.judge.diagnosis.evidence import ADEQUATE, is_adequate
from longball.judge.diagnosis.findings import Finding
from longball.judge.diagnosis.integrators import in_steps
from longball.judge.diagnosis.operators import Edit
from longball.judge.diagnosis.outputs import outputs
from longball.judge.diagnosis.residual import (
    Data,
    Flying,
    Followed,
    compared,
    data_of,
    evenly,
    follow,
    follows,
    mended,
    seen,
)
from longball.judge.diagnosis.schemes import explain_scheme
from longball.judge.fresh import moved
from longball.model.numbers import Undecided
from longball.model.scene import Scene

# Runs a candidate again: from scenes to answers by id.
Solve = Callable[[Sequence[Any]], Mapping[str, Answer]]

SCENES = 100  # largest number of new scenes; a free choice


class Unseen:
    """Moved scenes. The candidate and the engine of the truth solve them when they are needed."""

    def __init__(
        self, known: Data, chain: Sequence[Stage], solve: Solve, scheme: Verlet | None
    ) -> None:
        self._known, self._chain, self._solve, self._scheme = known, chain, solve, scheme
        # The chain that was followed last, with its columns: a stage has many rivals.
        self._followed: tuple[tuple[Stage, ...], Mapping[str, Any]] = ((), {})

    @cached_property
    def data(self) -> Data | None:
        """The candidate's answers, where it has the right outcome; None if it has none."""
        # Solved at most once, and only if something is named: the candidate runs again, and so does
        # the engine of the truth.
        known = self._known
        some = evenly(np.arange(len(known.cases)), SCENES)
        scenes = [*moved([known.cases[i].scene for i in some], seed=1)]
        cases = [*self._cases(scenes)]
        answers = self._solve([case.scene for case in cases])
        cases = [
            case for case in cases
            if (told := answers.get(case.id)) and told.error is None
            and told.outcome in (None, case.expected.outcome)
        ]  # fmt: skip
        if not cases:
            return None
        data = data_of(cases, answers, known.granted)
        if self._scheme is not None:
            data = in_steps(data, self._scheme)
        return seen(self._chain, with_cut(data, known.cut))

    def _cases(self, scenes: Iterable[Scene]) -> Iterator[Known]:
        """Scenes with their truth, without those that doubles cannot decide."""
        for scene in scenes:
            try:
                (case,) = solved([scene], self._scheme or Ivp())
            except (CannotSolve, Undecided):
                continue
            if decidable(case):
                yield case

    def converted(self, found: Sequence[Finding]) -> Unseen | None:
        """The same with outputs converted back; None if these scenes refute a conversion."""
        if self.data is None:
            return self
        data, conversions = outputs(self.data, self._chain)
        if not {one.edit for one in found} <= {one.edit for one in conversions}:
            return None
        other = Unseen(self._known, self._chain, self._solve, self._scheme)
        other.data = data  # in place of the cached property, so that nothing is run again
        return other

    def holds(
        self, chain: tuple[Stage, ...], stage: Stage, edit: Edit, ways: Mapping[str, Flying]
    ) -> bool:
        """True if an edited stage reproduces the candidate's numbers in these scenes."""
        if (both := self._with_and_without(chain, stage, edit, ways)) is None:
            return True
        f, without = both
        return is_adequate(f.off / f.floor, edit.rough, without.beyond)

    def mends(
        self, chain: tuple[Stage, ...], stage: Stage, edit: Edit, ways: Mapping[str, Flying]
    ) -> bool:
        """True if an edit makes some wrong scenes right, if there are any, and breaks none."""
        if (both := self._with_and_without(chain, stage, edit, ways)) is None:
            return True
        f, without = both
        mends, breaks = mended(without, f)
        return not breaks and (mends > 0 or not without.beyond.any())

    def _with_and_without(
        self, chain: tuple[Stage, ...], stage: Stage, edit: Edit, ways: Mapping[str, Flying]
    ) -> tuple[Followed, Followed] | None:
        """Residuals of a stage with and without an edit; None if there are no new scenes."""
        if self.data is None:
            return None
        (edited,) = edit.apply([stage])
        rough = frozenset((stage.name,) if edit.rough else ())
        data = replace(self.data, ways=ways, rough=rough)
        if self._followed[0] is not chain:
            self._followed = chain, follow(chain, data)[0]
        columns = self._followed[1]
        some = np.flatnonzero(np.isin(columns["kind"], stage.scenes))
        return compared(edited, data, columns, some)[0], compared(stage, data, columns, some)[0]

    @cached_property
    def follows(self) -> bool:
        """True if every stage agrees in these scenes, to the digits that the candidate writes."""
        return self.data is None or follows(self._chain, self.data)

    def refuting(
        self, chain: tuple[Stage, ...], known: Data, dt: float | None
    ) -> Callable[[Stage, bool, Scheme | None], tuple[int, int] | None]:
        """Return a function that counts the scenes in which the explanation of a stage fails.

        `known` holds the ways and the roughness of flights that belong to the explanations. The
        arguments of the function are the stage, True if the explanation is a rough edit, and the
        scheme if it is one. It returns the number of scenes that refute the explanation, and the
        number of those that have the stage; None if none refutes it.
        """
        if self.data is None:
            return lambda stage, rough, scheme: None
        data = replace(self.data, ways=known.ways, rough=known.rough)
        columns, every = follow(chain, data)
        of = {f.stage.key: f for f in every}

        def refuted(stage: Stage, rough: bool, scheme: Scheme | None) -> tuple[int, int] | None:
            f = of[stage.key]
            r, checked = f.off / f.floor, int(f.checked.sum())
            beyond = int((np.abs(r) > ADEQUATE).any(axis=0).sum())
            if scheme is not None and scheme.way is None:  # a clock or an event: not in the chain
                again = explain_scheme(chain, f.stage, data, columns, f, dt)
                holds = not f.wrong.any() or (again is not None and again.adequate)
            else:
                loose = rough or scheme is not None
                # Rule 4 of docs/truth.md: 5 % of the numbers, or those of one scene. Of few scenes,
                # 5 % may be less than one.
                holds = is_adequate(r, loose) or (loose and beyond == 1)
            return None if not checked or holds else (beyond, checked)

        return refuted
