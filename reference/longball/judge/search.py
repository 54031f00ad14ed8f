"""The search for the known mistakes that explain a candidate's errors.

A set of mistakes explains as much of a candidate's error as it takes away: the share is
1 - Σ|c - p| / Σ|c - t|, over all numbers of all scenes, with the candidate's number c, the
prediction p and the truth t, each difference relative to the size of its quantity and none counted
for more than that size; another outcome counts for one such number. No amplitude is fitted, save
for an unknown time step: g = 9.81 is either the reason or it is not.

Single mistakes are compared first. If one leaves more than noise, sets of two and three are
screened by adding up their fingerprints, and the promising ones are solved as they are.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longball.judge.answers import Answer
from longball.judge.diagnosis import Diagnosis, Finding, Suspect
from longball.judge.fingerprints import (
    COLUMNS,
    OUTCOMES,
    Answers,
    Atom,
    Fingerprints,
    Guess,
    answers_of,
    joined_guess,
)
from longball.judge.mistakes import KNOWN, SINGLE

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# A set of mistakes is named if it explains this share of the error. A mistake that is made and
# computed leaves only the candidate's other errors; one that merely looks alike leaves more.
NAMED = 0.95

# One more mistake must take away this share of what is left; less may be chance among so many.
WORTHWHILE = 0.5

# Mean errors, relative to the size of the quantity. Below the first, what is left after naming a
# mistake is rounding; below the second, an error that no mistake explains is called noise: a
# solver's tolerance of 1e-6 leaves as much, and every known mistake a hundred times more.
ROUNDING = 1e-11
NOISE = 2e-6

# Single precision leaves 6e-8 a rounding: the paper's scheme computed in it is off by 2e-6 at most
# in nine of ten numbers. In the tenth bat and ball may amplify it, or meet where they did not.
SINGLE_NOISE = 1e-5

# A share of the error so large that another mistake is not looked for.
COMPLETE = 0.99999

# Fingerprints of mistakes that leave a mean error below this add up well enough to be found by
# their sum: what products of two such errors add is less than a tenth of either.
ADDITIVE = 0.02

LARGEST_SET = 3

PROMISING = 12  # sets that are solved, of all that were screened
REFINEMENTS = 8  # of a time step
LISTED = 5  # suspects in the report
MENTIONED = 0.01  # share of the error that a suspect not named must explain to be listed

SHORTEST_STEP, LONGEST_STEP = 2e-5, 0.2  # s

_MISTAKES = KNOWN | {SINGLE.name: SINGLE}

# Of a step in its effect: the known mistakes of the scheme have 1 and 2, and their sums what lies
# between, or seems to lie a little beyond.
LOWEST_POWER, HIGHEST_POWER = 0.5, 4.0


def diagnose(prints: Fingerprints, answers: Mapping[str, Answer]) -> Diagnosis:
    """Return which known mistakes explain the errors of a candidate's answers.

    Parameters
    ----------
    prints
        On the scenes that were judged.
    answers
        The candidate's, by the scene's id.
    """
    return _Search(prints, answers).diagnosis()


@dataclass(frozen=True)
class _Scored:
    """A guess, and the mean error that it leaves."""

    guess: Guess
    left: float


class _Search:
    """The search for what explains one candidate's answers."""

    def __init__(self, prints: Fingerprints, answers: Mapping[str, Answer]) -> None:
        self.prints = prints
        given = [answers.get(case.id) for case in prints.cases]
        self.candidate = answers_of(
            (answer.outcome, answer.values) if answer else (None, {}) for answer in given
        )
        truth = prints.truth
        self.seen: Flags = np.isfinite(self.candidate.numbers) & np.isfinite(truth.numbers)
        self.single = _in_single_precision(answer for answer in given if answer)
        self.count = sum(answer is not None and answer.error is None for answer in given)
        self.error = self.left_by(truth) if self.count else 0.0
        self.quantile90 = prints.quantile90(self.candidate, truth, self.seen) if self.count else 0.0
        times = self.candidate.numbers[:, COLUMNS.index(("landing.time", 0))]
        step = None if prints.step_known else common_step(times[np.isfinite(times)].tolist())
        self.steps = prints.steps if step is None else (*prints.steps, step)

    @cached_property
    def alone(self) -> list[Guess]:
        """Every mistake by itself, in every form that can be predicted."""
        guesses = self.prints.singles(self.steps)
        return [guess for guess in guesses if self.prints.predict(guess) is not None]

    def predicted(self, guess: Guess) -> Answers:
        """Return the prediction of a guess that does not contradict itself."""
        prediction = self.prints.predict(guess)
        assert prediction is not None
        return prediction

    def left_by(self, prediction: Answers) -> float:
        """Return the mean error that a prediction leaves."""
        return self.prints.error(self.candidate, prediction, self.seen)

    def attempt(self, guess: Guess) -> _Scored | None:
        """Return what a guess leaves; None if it contradicts itself."""
        prediction = self.prints.predict(guess)
        return None if prediction is None else _Scored(guess, self.left_by(prediction))

    def share(self, left: float) -> float:
        """Return the share of the error that is explained."""
        return 1.0 - left / self.error if self.error else 0.0

    def diagnosis(self) -> Diagnosis:
        """Return the finding."""
        if not self.count:
            return self._found("nothing", "there is no answer to diagnose", (), 0.0, {})
        if self._flawless():
            sentence = (
                f"no error beyond rounding in the {len(self.prints.cases)} ordinary scenes that "
                "fingerprints are taken from: what fails elsewhere is hard, not mistaken"
            )
            return self._found("nothing", sentence, (), 0.0, {})
        singles = self._best_singles()
        best = self._best_set(singles)
        share = self.share(best.left)
        if share >= NAMED:
            names = sorted(
                best.guess.names, key=lambda n: singles[n].left if n in singles else math.inf
            )
            if self.single:
                names.append(SINGLE.name)
            return self._found("known", "", names, share, singles, best)
        if self.single and self.quantile90 < SINGLE_NOISE:
            return self._found("known", "", [SINGLE.name], max(0.0, share), singles)
        if self.error < NOISE:
            sentence = (
                f"noise: errors of {self.error:.1e} of each quantity's size without the pattern "
                "of any known mistake, as rounding or a solver's tolerance leaves them"
            )
            return self._found("noise", sentence, (), max(0.0, share), singles)
        guessed = " and ".join(best.guess.names)
        sentence = (
            f"none of the known mistakes: the best guess, {guessed}, explains "
            f"{max(0.0, share):.0%} of the error, and a mistake that is made explains at least "
            f"{NAMED:.0%}"
        )
        if self.single:
            sentence += f"; it {SINGLE.sentence}, too, which explains no error as large as these"
        return self._found("unknown", sentence, (), max(0.0, share), singles)

    def _flawless(self) -> bool:
        with np.errstate(invalid="ignore"):
            off = np.abs(self.candidate.numbers - self.prints.truth.numbers) > self.prints.tolerance
        outcomes = self.candidate.outcomes
        other = (outcomes >= 0) & (outcomes != self.prints.truth.outcomes)
        return not (off[self.seen].any() or other.any() or self.single)

    def _best_singles(self) -> dict[str, _Scored]:
        """Return the best form of each mistake alone, best first."""
        forms: dict[Atom, _Scored] = {}
        for guess in self.alone:
            tried, (atom,) = self.attempt(guess), guess.atoms
            if tried and (atom not in forms or tried.left < forms[atom].left):
                forms[atom] = tried
        best: dict[str, _Scored] = {}
        for tried in sorted(map(self._refined, forms.values()), key=lambda t: t.left):
            best.setdefault(tried.guess.names[0], tried)
        return best

    def _best_set(self, singles: Mapping[str, _Scored]) -> _Scored:
        best = next(iter(singles.values()))
        seeds = list(singles.values())[:3]
        for size in range(2, LARGEST_SET + 1):
            if best.left <= ROUNDING + (1 - COMPLETE) * self.error or self.error < NOISE:
                break
            searches = [self._screened(seeds, size)]
            if self.error > ADDITIVE:
                searches.append(self._bold(seeds, singles))
            for guesses in searches:
                tried = self._tried(guesses)
                worthwhile = tried and tried[0].left < (1 - WORTHWHILE) * best.left
                if worthwhile and self.share(tried[0].left) >= NAMED:
                    break
            if not worthwhile:
                break
            best, seeds = tried[0], tried[:3]
        return best

    def _tried(self, guesses: Iterable[Guess]) -> list[_Scored]:
        """Return what guesses leave, the least first; no further once all is explained."""
        tried = []
        for guess in guesses:
            if one := self.attempt(guess):
                tried.append(self._refined(one))
                if self.share(tried[-1].left) >= COMPLETE:
                    break
        return sorted(tried, key=lambda t: t.left)

    def _screened(self, seeds: Sequence[_Scored], size: int) -> list[Guess]:
        """Return the most promising sets of a size, by adding up fingerprints.

        Some promise most over all numbers, some over those that no bat has amplified.
        """
        starts = self.alone if size == 2 else [seed.guess for seed in seeds]
        prints = self.prints
        effects = np.array([self._effect(guess) for guess in self.alone])
        aim = self._relative(self.candidate) - self._relative(prints.truth)
        others = np.array([self.predicted(guess).outcomes for guess in self.alone])
        changed = others != prints.truth.outcomes
        given = self.candidate.outcomes >= 0
        smooth = prints.smooth[self.seen]
        # By all numbers, and by the smooth ones: what each set leaves at the best of its steps.
        rankings: tuple[dict[tuple[Atom, ...], tuple[float, Guess]], ...] = {}, {}
        for start in starts:
            with np.errstate(invalid="ignore"):
                left = np.minimum(np.abs(aim - self._effect(start) - effects), 1.0)
            left = np.where(np.isnan(left), 1.0, left)
            outcomes = np.where(changed, others, self.predicted(start).outcomes)
            confused = ((outcomes != self.candidate.outcomes) & given).sum(axis=1)
            whole = left.sum(axis=1) + confused
            part = left[:, smooth].sum(axis=1)
            for guess, *rests in zip(self.alone, whole.tolist(), part.tolist(), strict=True):
                if joined := joined_guess(start, guess):
                    for ranking, rest in zip(rankings, rests, strict=True):
                        if rest < ranking.get(joined.atoms, (math.inf,))[0]:
                            ranking[joined.atoms] = rest, joined
        ranked = (sorted(r.values(), key=lambda item: item[0])[:PROMISING] for r in rankings)
        return list(dict.fromkeys(guess for best in ranked for _, guess in best))

    def _relative(self, answers: Answers) -> Array:
        """Return the numbers that are seen, relative to the sizes of their quantities."""
        relative: Array = (answers.numbers / self.prints.sizes)[self.seen]
        return relative

    def _effect(self, guess: Guess) -> Array:
        """Return what a guess does to the numbers that are seen."""
        return self._relative(self.predicted(guess)) - self._relative(self.prints.truth)

    def _bold(self, seeds: Sequence[_Scored], singles: Mapping[str, _Scored]) -> list[Guess]:
        """Return the best guesses, each with every other mistake.

        A mistake that changes much spoils the sum of fingerprints.
        """
        others = [guess for guess in self.alone if not guess.dt]
        others += [tried.guess for tried in singles.values() if tried.guess.dt]
        # The best one with every time step: the one that fits a mistake alone fits by chance.
        joined = [joined_guess(seeds[0].guess, guess) for guess in self.alone]
        joined += [joined_guess(seed.guess, guess) for seed in seeds[1:] for guess in others]
        return list(dict.fromkeys(guess for guess in joined if guess))

    def _refined(self, tried: _Scored) -> _Scored:
        """Return a guess with the time step that fits best, where it is not known.

        The effect of a scheme grows with a power of its step, more or less, as long as ball and
        bat have not met. So the step is sought by secants of the logarithms, from the power 1 on.
        People choose round numbers.
        """
        guess = tried.guess
        if self.prints.step_known or not any(atom.made.scheme for atom in guess.atoms):
            return tried
        rest = Guess(tuple(atom for atom in guess.atoms if not atom.made.steps))
        start = self.prints.predict(rest) if rest.atoms else self.prints.truth
        best, dt, power = tried, guess.dt, 1.0
        before: tuple[float, float] | None = None  # logarithms of the last step, and of its factor
        for _ in range(REFINEMENTS):
            prediction = self.prints.predict(Guess(guess.atoms, dt))
            if start is None or prediction is None:
                break
            factor = self._amplitude(start, prediction)
            if factor <= 0 or abs(factor - 1.0) < 1e-9:
                break
            now = math.log(dt), math.log(factor)
            if before and now[0] != before[0]:
                power = (before[1] - now[1]) / (now[0] - before[0])
                power = min(max(power, LOWEST_POWER), HIGHEST_POWER)
            before = now
            dt *= factor ** (1 / power)
            if not SHORTEST_STEP < dt < LONGEST_STEP:
                break
            for step in (float(f"{dt:.2g}"), float(f"{dt:.3g}"), dt):
                again = self.attempt(Guess(guess.atoms, step))
                if again and again.left < best.left:
                    best = again
            if self.share(best.left) >= COMPLETE:
                break
        return best

    def _amplitude(self, start: Answers, prediction: Answers) -> float:
        """Return how many times the way from start to prediction fits the candidate best."""
        with np.errstate(invalid="ignore"):
            step = (prediction.numbers - start.numbers) / self.prints.sizes
            way = (self.candidate.numbers - start.numbers) / self.prints.sizes
        used = self.seen & (np.abs(step) < 0.5) & (np.abs(way) < 0.5) & (step != 0.0)
        smooth = used & self.prints.smooth
        used = smooth if smooth.any() else used
        if not used.any():
            return 1.0
        # A median of ratios, weighted by the steps: whatever jumps has no say.
        ratios, weights = way[used] / step[used], np.abs(step[used])
        return float(np.quantile(ratios, 0.5, weights=weights, method="inverted_cdf"))

    # --- the text ---------------------------------------------------------------------------------

    def _found(
        self,
        finding: Finding,
        sentence: str,
        named: Sequence[str],
        share: float,
        singles: Mapping[str, _Scored],
        best: _Scored | None = None,
    ) -> Diagnosis:
        if finding == "known":
            step = best.guess.dt if best else 0.0
            sentence = "; ".join(f"it {_MISTAKES[name].sentence}" for name in named)
            if best:
                sentence += f": this explains {share:.2%} of the error"
            else:
                sentence += (
                    f", which leaves errors like these, {self.quantile90:.0e} of each quantity"
                )
            if step:
                sentence += f" (Δt = {step:.4g} s)"
            if best and self._misses_as(best.guess):
                sentence += "; like the printed scheme it looks for the bat at its steps only"
        others = (n for n, tried in singles.items() if self.share(tried.left) >= MENTIONED)
        order = list(dict.fromkeys([*named, *others]))
        suspects = [self._suspect(name, singles, best) for name in order]
        return Diagnosis(
            finding=finding,
            sentence=sentence,
            named=list(named),
            share=share,
            error=self.error,
            suspects=suspects[: max(LISTED, len(named))],
            invisible=self._invisible() if singles else [],
            scenes=len(self.prints.cases),
        )

    def _misses_as(self, guess: Guess) -> bool:
        """Tell whether the candidate misses a bat that steps in a guess's scheme miss, too."""
        if not any(atom.made.scheme for atom in guess.atoms):
            return False
        candidate, scheme, truth = (
            answers.outcomes == OUTCOMES["missed"]
            for answers in (self.candidate, self.predicted(guess), self.prints.truth)
        )
        return bool((candidate & scheme & ~truth).any())

    def _suspect(self, name: str, singles: Mapping[str, _Scored], best: _Scored | None) -> Suspect:
        mistake = _MISTAKES[name]
        found: dict[str, Any] = {"share": None, "step": None, "twins": []}
        if name in singles:
            alone, together = singles[name], best if best and name in best.guess.names else None
            guess = together.guess if together else alone.guess
            found = {
                "share": self.share(alone.left),
                "step": guess.dt if alone.guess.atoms[0].made.steps else None,
                "twins": self._twins(alone, together),
            }
        return Suspect(name=name, sentence=mistake.sentence, remedy=mistake.remedy, **found)

    def _twins(self, alone: _Scored, best: _Scored | None) -> list[str]:
        """Return the other mistakes that predict the same, alone or in the set named."""
        mine = self.predicted(alone.guess)
        if self.prints.error(mine, self.prints.truth, self.seen) <= ROUNDING:
            return []  # seen by nobody: no twin of another such
        same = [
            guess.names[0]
            for guess in self.alone
            if guess.names != alone.guess.names and self._alike(mine, guess)
        ]
        return list(dict.fromkeys([*same, *self._twins_in_set(alone, best)]))

    def _twins_in_set(self, alone: _Scored, best: _Scored | None) -> Iterator[str]:
        """Yield the mistakes of the scheme that would do as well in the set named.

        What tells two of them apart may be hidden by a third: no root of Appendix B is seen where
        a slow pitch never reaches the bat.
        """
        if best is None or not alone.guess.atoms[0].made.scheme:
            return
        mine = self.predicted(best.guess)
        rest = tuple(atom for atom in best.guess.atoms if atom.mistake != alone.guess.names[0])
        for atom in dict.fromkeys(guess.atoms[0] for guess in self.alone):
            if not atom.made.scheme:
                continue
            if rest and atom.mistake not in best.guess.names:
                other = Guess(tuple(sorted((*rest, atom))), best.guess.dt)
                if self._alike(mine, other):
                    yield atom.mistake

    def _alike(self, mine: Answers, guess: Guess) -> bool:
        other = self.prints.predict(guess)
        return other is not None and self.prints.error(mine, other, self.seen) <= ROUNDING

    def _invisible(self) -> list[str]:
        """Return the mistakes that change nothing that was judged."""
        visible = set()
        for guess in self.alone:
            if guess.names[0] not in visible and not self._alike(self.prints.truth, guess):
                visible.add(guess.names[0])
        return [name for name in KNOWN if name not in visible]


def common_step(times: Sequence[float]) -> float | None:
    """Return the largest step of which all times are multiples, s; None if there is none.

    A multiple is met to a millionth of a step.
    """
    distinct = sorted({time for time in times if time > LONGEST_STEP})
    if len(distinct) < 5:
        return None
    known = np.array(distinct[:12])
    counts = np.arange(math.ceil(known[0] / LONGEST_STEP), math.floor(known[0] / SHORTEST_STEP) + 1)
    multiples = known[1:, None] * counts / known[0]
    fits = np.abs(multiples - np.round(multiples)).max(axis=0) < 1e-6
    return float(known[0] / counts[np.argmax(fits)]) if fits.any() else None


# A quantity with fewer numbers than this may be in single precision by chance: 2.0 is.
ENOUGH = 5


def _in_single_precision(answers: Iterable[Answer]) -> bool:
    """Tell whether most quantities hold only numbers of single precision, or such as are written.

    Not all need to: a program in single precision may still take a square root in doubles.
    """
    numbers: dict[str, set[Decimal]] = defaultdict(set)
    for answer in answers:
        for name, value in answer.values.items():
            numbers[name].update(x for x in value if x)
    single = [all(map(_is_single, some)) for some in numbers.values() if len(some) >= ENOUGH]
    return 2 * sum(single) > len(single)


def _is_single(x: Decimal) -> bool:
    if abs(x.adjusted()) > 37:  # beyond the range of single precision
        return False
    single = np.float32(float(x))
    return float(x) == float(single) or x in (Decimal(str(single)), Decimal(f"{single:.9g}"))
