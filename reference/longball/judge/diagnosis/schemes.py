"""Flights in fixed steps: edits of the candidate's integrator, not of its law.

A candidate takes steps of one length h in all scenes and makes its last step in one of a few ways.
An integrator is named if it reproduces every number of every scene
(`longball.judge.diagnosis.evidence`); otherwise the order of the errors may be reported.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longball.engines.verlet import PUSHES
from longball.judge.diagnosis.chain import Stage
from longball.judge.diagnosis.clocks import LONGEST, Scheme, clock, event
from longball.judge.diagnosis.evidence import (
    ADEQUATE,
    CHANCE,
    DIGIT,
    FEWEST,
    NUMBER,
    PART,
    cost,
    fitted,
    is_adequate,
    rounded,
)
from longball.judge.diagnosis.expression import Evaluator
from longball.judge.diagnosis.integrators import (
    BATTED,
    EXACT,
    INTEGRATORS,
    VERLET,
    Integrator,
    Way,
    slips,
    steps,
    together,
)
from longball.judge.diagnosis.operators import FACTORS, Edit
from longball.judge.diagnosis.residual import (
    Data,
    Followed,
    Index,
    compared,
    evenly,
    is_rough,
    mended,
    take,
)
from longball.model.arrays import Array

# Limits of the search: free choices.
FEW = 6  # wrong scenes with short flights, in which schemes are tried first
# Steps of the first trials, s. The errors with two steps give the order of an integrator, and the
# order gives the step with which its errors are as large as the candidate's.
TRIALS = (0.2, 0.04)
SHOWS = 100.0  # floors: a possible integrator can be at least so far off in some wrong scene
LEAST = 1e-300  # a divisor in place of 0
SHORTEST = 2e-5  # shortest step of a candidate, s
ELSEWHERE = 1e9  # relative error that no integrator makes: such a flight has another end
LOST = 1e12  # the residual, in floors, where a scheme gives no finite number
ALIKE = 0.3  # fraction by which errors of order 0 may depend on the step
MANY = 100, 40, 40  # integrators that are flown again, with better steps, in each round
# Largest fractions of the squared errors that a scheme may leave to be tried further, to fit, and
# to be nearly the candidate's.
ROUGHLY, FITS, CLOSELY = 0.7, 0.1, 1e-3
# Errors have an order if a scheme of that order leaves at most the fraction LIKE of them in the
# fraction MOST of the scenes.
LIKE, MOST = 0.1, 0.8
NEAR, CHORD = 1.25, 2.0  # round steps are tried within these factors of the fitted one

# Steps that people choose: round numbers, and the frame rates of screens and cameras. Which ones
# are tried is a free choice.
_DECADE = (1, 1.25, 1.5, 2, 2.5, 3, 4, 5, 6, 8)
_RATES = (24, 30, 60, 64, 90, 120, 128, 144, 240, 256, 480, 512, 960, 1024)
ROUND = tuple(
    sorted({0.1, 0.2, 0.3, 0.4, *(float(f"{m}e{k}") for m in _DECADE for k in (-5, -4, -3, -2))}
           | {1 / n for n in _RATES})
)  # fmt: skip
ROUND_BITS, TRIED_BITS = math.log2(len(ROUND)), math.log2(2 * (len(INTEGRATORS) + 1))
ODD_BITS = 30.0  # of a step that is not round


# An integrator, its step, and whether the end of a flight is on the chord between two steps.
Option = tuple[Integrator, float, bool]


def _nearer(one: Integrator, h: float, share: float) -> float:
    """The step with which errors are `share` times those with `h`."""
    return float(np.clip(h * share ** (1 / (one.order or 1)), SHORTEST, LONGEST))


def _shares(a: Array, b: Array) -> tuple[Array, Array]:
    """Ratios of errors a to those of schemes b, shape (numbers, schemes, scenes); residuals.

    A ratio is fitted by least squares. Its residual is the fraction of the squared errors a that
    the scaled errors b leave.
    """
    share = (a * b).sum(axis=(0, 2)) / np.maximum((b * b).sum(axis=(0, 2)), LEAST)
    rest = np.square(a - share[:, None] * b).sum(axis=(0, 2))
    return share, rest / np.maximum(np.square(a).sum(axis=(0, 2)), LEAST)


def _likeliest(found: Iterable[Scheme]) -> Scheme | None:
    """The scheme with the most evidence; those that explain all errors come first."""
    return max(found, key=lambda one: (one.mends is None, one.evidence), default=None)


@dataclass(frozen=True)
class Steps:
    """A flight stage whose errors are compared with those of schemes."""

    stage: Stage
    data: Data
    columns: Mapping[str, Any]
    followed: Followed

    @cached_property
    def few(self) -> Index:
        """Positions in `followed.some` of short wrong flights; none if most end elsewhere."""
        near = self.followed.wrong & (self.followed.relative < ELSEWHERE)
        if 2 * near.sum() < self.followed.wrong.sum():
            return np.zeros(0, dtype=int)
        return self.short(near, FEW)

    def short(self, flags: NDArray[np.bool_], most: int) -> Index:
        """Numbers of some of the flagged scenes, evenly spread over the shorter flights."""
        found = np.flatnonzero(flags & np.isfinite(self.durations))
        found = found[np.argsort(self.durations[found], kind="stable")]
        return evenly(found[: max(most, 2 * len(found) // 3)], most)

    @cached_property
    def possible(self) -> Sequence[Integrator]:
        """Integrators that the candidate may have used, judged by the scenes that are right.

        If the errors of an integrator are within the noise in right scenes, they are limited in
        wrong scenes, too. An integrator is impossible if this limit is below SHOWS floors in every
        wrong scene. Without right scenes, all are possible.
        """
        wrong = self.short(self.followed.wrong, SOME)
        right = self.short(self.followed.checked & ~self.followed.wrong, SOME)
        if not right.size:
            return INTEGRATORS

        # With the step, errors shrink by the same factor in all scenes. In right scenes they are at
        # most ADEQUATE floors, so that in wrong scenes they are at most ADEQUATE · largest(wrong) /
        # largest(right).

        def largest(some: Index) -> Array:
            made = self.made(INTEGRATORS, TRIALS[0], some)
            floors = (self.followed.floor / self.followed.scale)[:, None, some]
            # A floor is NaN where the candidate gives no number.
            return np.asarray(np.nanmax(np.abs(made) / floors, axis=(0, 2)))

        enough = ADEQUATE * largest(wrong) > SHOWS * largest(right)
        return [one for one, shows in zip(INTEGRATORS, enough, strict=True) if shows]

    @cached_property
    def durations(self) -> Array:
        """Times of flight, s."""
        root = self.stage.roots["duration"]
        found = Evaluator([root], take(self.columns, self.followed.some))()[0]
        return np.asarray(found + np.zeros(len(self.followed.some)))

    @cached_property
    def null(self) -> float:
        """Bits that the errors cost now."""
        return cost(self.followed.off / self.followed.floor)

    @cached_property
    def finest_null(self) -> float:
        """Bits that the errors cost now, also those that the profile grants."""
        return cost(self.followed.off / self.followed.finest)

    @property
    def square(self) -> float:
        """The sum of the squares of the errors in the first scenes."""
        return float(np.square(self.off).sum())

    def columns_of(self, some: Index) -> dict[str, Any]:
        """Columns of some of the scenes."""
        return self.stage.with_spin(take(self.columns, self.followed.some[some]))

    def rows(self, found: Mapping[str, Array]) -> Array:
        """Quantities as rows, in the order of `followed`."""
        return np.concatenate([np.atleast_2d(found[q]) for q in self.stage.quantities])

    def errors(self, options: Sequence[Option], some: Index) -> tuple[Array, Array]:
        """Differences of schemes from the exact path, and the errors of these.

        Both have the shape (numbers, options, scenes). Integrators with tables of one size are
        computed together, each in its own step.
        """
        shape = len(self.followed.off), len(options), len(some)
        made, doubt = np.zeros(shape), np.zeros(shape)
        groups: dict[Any, list[int]] = {}
        for i, (one, _, chord) in enumerate(options):
            groups.setdefault((one.like, chord), []).append(i)
        for (_, chord), group in groups.items():
            every = together([options[i][0] for i in group], len(some))
            h = np.repeat([options[i][1] for i in group], len(some))
            which = np.tile(some, len(group))
            with np.errstate(all="ignore"):
                found, doubts = steps(self.stage, self.columns_of(which), every, h, chord)
                # The exact value is the candidate's minus its residual, so no flight is needed.
                given = {q: self.data.given[q][..., self.followed.some[which]] for q in found}
                exact = self.rows(given) - self.followed.off[:, which]
                off, unsure = self.rows(found) - exact, self.rows(doubts)
            made[:, group] = off.reshape(len(off), len(group), -1)
            doubt[:, group] = unsure.reshape(len(off), len(group), -1)
        return made, doubt

    def left(self, options: Sequence[Option], some: Index) -> Array:
        """Errors that schemes leave unexplained, in floors: (numbers, options, scenes)."""
        made, doubt = self.errors(options, some)
        off = self.followed.off[:, None, some]
        r = (off - made) / (self.followed.floor[:, None, some] + doubt)
        return np.where(np.isfinite(off) & ~np.isfinite(r), LOST, r)

    def made(self, some: Sequence[Integrator], h: Any, which: Index) -> Array:
        """Errors that integrators make in scenes, in units of their sizes.

        `h` is the step of all, or of each.
        """
        h = h + np.zeros(len(some))
        options = [(one, float(step), False) for one, step in zip(some, h, strict=True)]
        made = self.errors(options, which)[0] / self.followed.scale[:, None, which]
        return np.clip(np.nan_to_num(made, posinf=0.0, neginf=0.0), -LOST, LOST)

    @cached_property
    def off(self) -> Array:
        """The candidate's errors in the first scenes, as `made` has those of schemes."""
        off = self.followed.off[:, self.few] / self.followed.scale[:, self.few]
        return np.nan_to_num(off)[:, None]

    @cached_property
    def trials(self) -> Sequence[Array]:
        """Errors of all integrators in the first scenes, in the steps of the first trials."""
        return [self.made(INTEGRATORS, h, self.few) for h in TRIALS]

    def fits(
        self, some: Sequence[Integrator], trials: Sequence[Array]
    ) -> list[tuple[float, float, Integrator]]:
        """Integrators with their best step and the error that they leave, the best first.

        In each round every integrator flies in a new step, which follows from its errors in the
        last step. The first steps are TRIALS.
        """
        places = {one.words: i for i, one in enumerate(some)}
        h, other = (np.full(len(some), step) for step in TRIALS)
        made, again = trials
        sizes = [np.sqrt(np.square(x).sum(axis=(0, 2))) for x in trials]
        # The order of a table with a wrong coefficient is unknown: take it from the two trials.
        with np.errstate(all="ignore"):
            orders = np.log(sizes[0] / sizes[1]) / math.log(TRIALS[0] / TRIALS[1])
        some = [
            one if one.order is not None else replace(one, order=max(1, round(order)))
            for one, order in zip(some, np.nan_to_num(orders), strict=True)
        ]
        # `made` are the errors in the steps `h`, `again` those in the steps `other`, tried last.
        for most in MANY:
            share, left = _shares(self.off, again)
            # Errors of order 0 are nearly independent of the step, and their rest is linear in it.
            slope = (again - made) / np.where(other == h, 1.0, other - h)[:, None]
            by, _ = _shares(self.off - again, slope)
            zero = np.array([one.order == 0 for one in some])
            fit = (left < ROUGHLY) & np.where(zero, np.abs(share - 1.0) < ALIKE, share > 0.0)
            best = [i for i in np.argsort(left, kind="stable") if fit[i]][:most]
            if not best:
                return []
            new = [
                other[i] + by[i] if zero[i] else _nearer(some[i], other[i], share[i]) for i in best
            ]
            some = [some[i] for i in best]
            h, other, made = other[best], np.clip(new, SHORTEST, LONGEST), again[:, best]
            again = self.made(some, other, self.few)
        _, left = _shares(self.off, again)
        # Integrators that leave the same error come in the order of `some`, the simplest first.
        return sorted(
            zip(left.tolist(), other.tolist(), some, strict=True),
            key=lambda x: (round(math.log10(x[0] + 1e-8)), places[x[2].words]),  # a free choice
        )

    @cached_property
    def fitting(self) -> list[tuple[float, float, Integrator]]:
        """Integrators that fit, without a wrong coefficient."""
        return self.fits(INTEGRATORS, self.trials)

    def nearest(self) -> Way | None:
        """The way whose errors are most like those of the flight, if some are."""
        for left, h, one in self.fitting[:1] if self.few.size else []:
            return Way(one, h) if left < FITS else None
        return None

    def named(self, dt: float | None, slipped: bool = True) -> Scheme | None:
        """The cheapest scheme that reproduces all numbers, if any; with slips only if `slipped`."""
        least = TRIED_BITS + (0.0 if dt else ROUND_BITS) + CHANCE  # a free choice
        if not self.few.size or self.null < least:  # no scheme saves more than the errors cost
            return None
        # A scheme makes errors in many scenes. In one or two ill-conditioned ones, some scheme will
        # make them by chance.
        if self.followed.beyond.sum() < FEWEST:
            return None
        found = self.fitting
        usual = [*ROUND, *([dt] if dt else [])]

        def near(fit: float, factor: float) -> list[float]:
            close = {h for h in usual if max(h / fit, fit / h) < factor}
            return sorted(close, key=lambda h: abs(math.log(h / fit)))

        # Options are integrators whose own errors fit, with and without a chord at the end; then
        # integrators in which the chord makes the larger error.
        options: list[Option] = [
            (one, h, chord)
            for left, fit, one in found if left < FITS
            for h in near(fit, NEAR) for chord in (False, True)
        ]  # fmt: skip
        # Errors of a chord grow as the square of the step: one trial gives the step.
        made, _ = self.errors([(EXACT, TRIALS[1], True)], self.few)
        off = self.followed.off[:, self.few]
        sizes = (np.nanmax(np.abs(x[:3]), initial=1e-30) for x in (off, made))  # a free choice
        fit = TRIALS[1] * math.sqrt(next(sizes) / next(sizes))
        chords = near(fit, CHORD)
        ways = (EXACT, *(one for one in INTEGRATORS if one.order and one.order > 1))
        options += [(one, h, True) for h in chords for one in ways]
        named = self._adequate(options, dt)
        # A scheme much like the candidate's may leave only errors that the profile grants, which
        # are most of the bits.
        if named is not None:
            explained = named.evidence + named.bits + CHANCE
            if explained > WELL * self.finest_null:
                return named
        # If no right integrator fits well in a round step: one that nearly fits, in any step; or
        # one of hundreds with a wrong coefficient, in a round step.
        others = [named]
        if named is None and found and found[0][0] < CLOSELY:
            others.append(self._adequate(list(self._free(found[:2])), dt))
        if slipped:
            trials = [self.made(slips(), h, self.few) for h in TRIALS]
            options = [
                (one, h, chord)
                for left, fit, one in self.fits(slips(), trials) if left < CLOSELY
                for h in near(fit, NEAR) for chord in (False, True)
            ]  # fmt: skip
            others.append(self._adequate(options, dt, math.log2(len(slips()))))
        return _likeliest(one for one in others if one is not None)

    def _free(self, found: Iterable[tuple[float, float, Integrator]]) -> Iterable[Option]:
        """Integrators in steps fitted freely, and rounded to one digit, two, and so on."""
        for _, fit, one in found:

            def left(steps: Array, one: Integrator = one) -> Array:
                options = [(one, float(abs(h)), False) for (h,) in steps]
                return self.left(options, self.few).swapaxes(0, 1)

            (c,), *_ = fitted(left, [(fit,)], 3)
            yield from ((one, x, False) for x, _ in rounded(abs(float(c))) if x > SHORTEST)

    def _holding(self, options: Sequence[Option]) -> Sequence[Option]:
        """Options that reproduce all numbers of most of the first scenes, and save bits there.

        The options with the smallest residual come first.
        """
        for some in (self.few[:2], self.few):  # two scenes rule out most options
            if options:
                r = self.left(options, some)
                near = (np.nan_to_num(np.abs(r)) <= ADEQUATE).all(axis=0).mean(axis=1)
                # Every scheme agrees with errors within the floors: the right one reduces them.
                f = self.followed
                finer = f.floor[:, some] / f.finest[:, some]
                left = np.array([cost(r[:, i] * finer) for i in range(len(options))])
                saves = left <= SAVES * cost(f.off[:, some] / f.finest[:, some])
                # A flight across a kink may differ even with the right option.
                enough = np.flatnonzero((near >= 0.5) & saves)
                costs = [cost(r[:, i]) for i in enough]
                options = [options[enough[i]] for i in np.argsort(costs, kind="stable")]
        return options

    def _adequate(
        self, options: Sequence[Option], dt: float | None, more: float = 0.0
    ) -> Scheme | None:
        """The likeliest option that reproduces all numbers. A slip costs `more` bits."""

        def bits(h: float) -> float:
            return TRIED_BITS + more + (0.0 if h == dt else ROUND_BITS if h in ROUND else ODD_BITS)

        found: list[Scheme] = []
        holding = self._holding(options)
        for one, h, chord in sorted(holding, key=lambda option: bits(option[1]))[:VERIFIED]:
            ways = {**self.data.ways, self.stage.name: Way(one, h, chord)}
            data = replace(self.data, ways=ways)  # shares the cache of flights
            after, _ = compared(self.stage, data, self.columns, self.followed.some)
            mends, breaks = mended(self.followed, after)
            evidence = self.finest_null - cost(after.off / after.finest) - bits(h) - CHANCE
            whole = is_adequate(after.off / after.floor, is_rough(self.stage))
            # A program may treat the path of a decaying spin, or a kink of the law, in another way.
            part = not breaks and mends >= max(FEWEST, PART * self.followed.beyond.sum())
            if evidence > 0 and (whole or part):
                alike = [
                    other.words for other, x, side in holding
                    if (x, side) == (h, chord) and other is not one
                ]  # fmt: skip
                way = Way(one, h, chord)
                said = way.words
                if alike and one is not EXACT:
                    said += f" (in these scenes the same as {' and '.join(dict.fromkeys(alike))})"
                part_of = None if whole else mends
                found.append(Scheme(said, one.order, h, bits(h), evidence, True, way, part_of))
        return _likeliest(found)

    def _alike(self) -> list[tuple[float, float, Integrator]]:
        """Integrators with a step, by the fraction of the median scene's errors that they leave.

        The median ignores the few scenes in which the errors of a flight nearly cancel.
        """
        found, a = [], self.off
        for h, b in zip(TRIALS, self.trials, strict=True):
            shares = np.median((a * b).sum(0) / np.maximum((b * b).sum(0), LEAST), axis=1)
            rest = np.square(a - shares[:, None] * b).sum(0) / np.maximum((a * a).sum(0), LEAST)
            lefts = np.median(rest, axis=1)
            found += [
                (float(left), _nearer(one, h, share), one)
                for one, share, left in zip(INTEGRATORS, shares, lefts, strict=True) if share > 0.0
            ]  # fmt: skip
        return sorted(found, key=lambda each: each[0])

    def order(self) -> Scheme | None:
        """The order of the errors; None if they have none."""
        wrong = self.short(self.followed.wrong, SOME)
        off = self.followed.off[:, wrong]
        null = cost(off / self.followed.floor[:, wrong])
        for _, h, one in self._alike()[:2] if self.few.size else []:
            made = self.errors([(one, h, False)], wrong)[0][:, 0]
            known = np.isfinite(off) & np.isfinite(made)
            before, after = (
                np.sqrt(np.square(np.where(known, x / self.followed.scale[:, wrong], 0.0)).sum(0))
                for x in (off, off - made)
            )
            bits = TRIED_BITS + ROUND_BITS
            evidence = null - cost(self.left([(one, h, False)], wrong)) - bits - CHANCE
            if np.mean(after < LIKE * before) >= MOST and evidence > 0:
                said = (
                    f"behaves like a scheme of order {one.order}, such as {one.words} in steps of"
                )
                return Scheme(f"{said} about {h:.2g} s", one.order, h, bits, evidence, False)
        return None


# --- what explains a stage ------------------------------------------------------------------------


def explain_scheme(
    chain: Sequence[Stage], stage: Stage, data: Data, columns: Mapping[str, Any],
    followed: Followed, dt: float | None = None, steps: Steps | None = None,
) -> Scheme | None:  # fmt: skip
    """The scheme, event at a step, or clock that explains a stage, or the order of its errors."""
    if stage.kind == "event":
        return event(chain, stage, columns, followed, dt)
    if stage.kind == "formula" or not followed.wrong.any():
        return None
    steps = steps or Steps(stage, data, columns, followed)
    few = followed.of(steps.short(followed.wrong, SOME))
    if few.some.size and clock(stage, columns, few, dt) is not None:
        late = clock(stage, columns, followed, dt)
        if late is not None:
            return late
    return steps.named(dt) or steps.order()


def explain_push(
    stage: Stage, data: Data, columns: Mapping[str, Any], followed: Followed
) -> Scheme | None:
    """The contact force over some steps of the pitch's scheme that explains a batted flight.

    The paper's program has no impulse: half of the contact force F̄ acts at the steps around the
    contact (Appendix B), so that a batted flight begins before it.
    """
    pitch = data.ways.get("pitch")
    struck = followed.some[take(columns, followed.some)["kind"] == "at-bat"]
    wrong = np.intersect1d(struck, followed.some[followed.wrong])
    # Every batted ball is pushed.
    if stage.name not in BATTED or not isinstance(pitch, Way) or 2 * wrong.size <= struck.size:
        return None
    # Integrators of the same order that fly a pitch alike may differ with a push: try all of them.
    alike = [one for one in VERLET.values() if one.order == pitch.one.order and one != pitch.one]
    tried = [replace(pitch, one=one, push=push) for one in (pitch.one, *alike) for push in PUSHES]

    def left(way: Way, some: Index) -> Array:
        other = replace(data, ways={**data.ways, stage.name: way})
        after, _ = compared(stage, other, columns, some)
        return np.asarray(after.off / after.floor)

    def sized(way: Way) -> Iterator[tuple[Way, float]]:
        """The push in round sizes near the fitted one, with their bits."""

        def beside(sizes: Array) -> Array:
            return np.array([left(replace(way, times=float(x)), wrong[:FEW]) for (x,) in sizes])

        (c,), *_ = fitted(beside, [(1.0,)], 3)
        yield from ((replace(way, times=x), more) for x, more in rounded(float(c), FACTORS))

    # Pushes of the usual size come first. Fitting another size is expensive, because it takes
    # flights.
    null, choice = cost(followed.off / followed.floor), math.log2(len(tried))
    sizes = itertools.chain.from_iterable(map(sized, tried))
    for way, more in itertools.chain(((way, 0.0) for way in tried), sizes):
        if not is_adequate(left(way, wrong[:FEW]), is_rough(stage)):
            continue
        bits = choice + more
        evidence = null - cost(left(way, followed.some)) - bits - CHANCE
        if evidence > 0 and is_adequate(left(way, struck), is_rough(stage)):
            return Scheme(way.words, way.one.order, way.h, bits, evidence, adequate=True, way=way)
    return None


# Limits of the search with edits: free choices.
SOME = 24  # wrong scenes with short flights, in which edits are tried first together with a scheme
VARIANTS = 6  # edits that are tried with all schemes
SAVES = 0.8  # largest fraction of the bits of the first scenes that a scheme leaves there
WELL = 0.5  # fraction of the bits of all errors that a scheme explains if it is the candidate's
VERIFIED = 3  # schemes that reproduce the first scenes and are then flown in all


def with_edit(
    plain: Steps, edits: Iterable[Edit], dt: float | None = None, like: Way | None = None
) -> tuple[Edit, Scheme] | None:
    """One of several edits, and the scheme by which the edited law is flown.

    If a way `like` the candidate's is known, it is used to rank the edits.
    """
    data, columns, followed = plain.data, plain.columns, plain.followed

    def searched(edit: Edit, some: Index) -> Steps:
        (other,) = edit.apply([plain.stage])
        with np.errstate(all="ignore"):
            return Steps(other, data, columns, compared(other, data, columns, some)[0])

    # Edits are ranked by the errors that an edit and a scheme leave together in short flights. For
    # the best edits all schemes are searched.
    short = plain.short(followed.wrong, SOME)
    null = cost(followed.off[:, short] / followed.floor[:, short])
    ways: list[tuple[float, Edit]] = []
    for edit in edits:
        for variant in _numbered(edit):
            search = searched(variant, followed.some[short])
            if not (search.few.size and (like or search.null < null)):
                continue
            tried, h = ([like.one], like.h) if like else (plain.possible, TRIALS[0])
            share, rest = _shares(search.off, search.made(tried, h, search.few))
            left = float(rest[share > 0.0].min(initial=1.0))  # a free choice above `ROUGHLY`
            if left < ROUGHLY:
                ways.append((left * search.square, variant))
    ways.sort(key=lambda way: (float(f"{way[0]:.6g}"), way[1].bits))
    different = {f"{way[0]:.6g}": way for way in reversed(ways)}  # one of equal edits
    for _, edit in [*different.values()][::-1][:VARIANTS]:
        search = searched(edit, followed.some)
        scheme = search.named(dt, slipped=False)
        if scheme is not None:
            saved = plain.null - search.null - edit.bits - math.log2(1 + len(ways))
            return edit, replace(scheme, evidence=scheme.evidence + saved)
    return None


def _numbered(edit: Edit) -> Iterable[Edit]:
    """An edit with usual and round values near its fitted number, which a scheme's errors move."""
    if not edit.starts:
        return [edit]
    (c,) = edit.starts
    if not isinstance(c, float):
        return []
    usual = [x for x in (FACTORS if edit.factor else ()) if abs(x - c) < MOVED * abs(c)]
    values = {x: math.log2(len(FACTORS)) for x in usual}
    for digits in (1, 2, 3):
        x = float(f"{c:.{digits}g}")
        if abs(x - c) < MOVED * abs(c):
            values.setdefault(x, NUMBER + DIGIT * digits)
    return [edit.settled(x, bits) for x, bits in values.items()]


MOVED = 0.05  # relative: how far a scheme's errors may move a free number; a free choice
