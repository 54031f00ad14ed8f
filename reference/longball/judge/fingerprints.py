"""Which known mistakes explain a candidate's errors.

Every mistake of the library is made by longball itself, on the scenes that were judged; the
answers are its fingerprint. A set of mistakes explains as much of a candidate's error as it takes
away: the share is 1 - Σ|c - p| / Σ|c - t|, over all numbers of all scenes, with the candidate's
number c, the prediction p and the truth t, each difference relative to the size of its quantity
and none counted for more than that size; another outcome counts for one such number. No amplitude
is fitted, save for an unknown time step: g = 9.81 is either the reason or it is not.

Single mistakes are compared first. If one leaves more than noise, sets of two and three are
screened by adding up their fingerprints, and the promising ones are solved as they are.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from longball.engines.at_bat import solve
from longball.engines.engine import Engine
from longball.engines.ivp import Ivp
from longball.engines.verlet import Verlet
from longball.judge.altered import Drag, solve_with_drag
from longball.judge.answers import Answer
from longball.judge.cases import SLACK, Case, decidable
from longball.judge.diagnosis import Diagnosis, Finding, Suspect
from longball.judge.mistakes import KNOWN, SINGLE, Solver, Variant
from longball.judge.quantities import QUANTITIES, Value, values_of
from longball.model.readings import Reading
from longball.model.result import Outcome, Result
from longball.model.scene import FlightScene, ImpactScene, Scene

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

# A share of the error so large that another mistake is not looked for.
COMPLETE = 0.99999

# Fingerprints of mistakes that leave a mean error below this add up well enough to be found by
# their sum: what products of two such errors add is less than a tenth of either.
ADDITIVE = 0.02

LARGEST_SET = 3

PROMISING = 12  # sets that are solved, of all that were screened
REFINEMENTS = 8  # of a time step
LISTED = 5  # suspects in the report
MENTIONED = 0.01  # share of the error that an innocent suspect must explain to be listed

# Time steps tried where the candidate's is not known, s; refined from there.
STEPS = (0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001)

SHORTEST_STEP, LONGEST_STEP = 2e-5, 0.2  # s

# Fingerprints are taken from so many scenes of each kind.
SCENES = {"at-bat": 24, "flight": 8, "impact": 6, "pitch": 6}


# --- answers as arrays ----------------------------------------------------------------------------

COLUMNS = tuple(
    (name, component) for name, quantity in QUANTITIES.items() for component in range(quantity.size)
)
_OUTCOMES: dict[str | None, int] = {None: -1} | {
    name: i for i, name in enumerate(get_args(Outcome))
}


@dataclass(frozen=True)
class Answers:
    """Answers to the scenes: a row each.

    Attributes
    ----------
    numbers
        A column for each of `COLUMNS`; NaN where there is none.
    outcomes
        A code each; -1 where there is none.
    """

    numbers: Array
    outcomes: NDArray[np.int64]


def _answers(rows: Iterable[tuple[str | None, Mapping[str, Value]]]) -> Answers:
    numbers, outcomes = [], []
    for outcome, values in rows:
        outcomes.append(_OUTCOMES[outcome])
        numbers.append(
            [float(values[name][i]) if name in values else math.nan for name, i in COLUMNS]
        )
    return Answers(np.array(numbers).reshape(-1, len(COLUMNS)), np.array(outcomes, dtype=np.int64))


def _of_results(results: Iterable[Result]) -> Answers:
    return _answers((result.outcome, values_of(result)) for result in results)


# --- sets of mistakes -----------------------------------------------------------------------------


@dataclass(frozen=True, order=True)
class Atom:
    """A form of a known mistake."""

    mistake: str
    variant: int

    @property
    def made(self) -> Variant:
        """Return what is done."""
        return KNOWN[self.mistake].variants[self.variant]


@dataclass(frozen=True)
class Guess:
    """Mistakes made together, in a time step of so many seconds; 0 if none needs one."""

    atoms: tuple[Atom, ...]
    dt: float = 0.0

    @property
    def names(self) -> tuple[str, ...]:
        """Return the mistakes."""
        return tuple(atom.mistake for atom in self.atoms)


class _Contradiction(ValueError):
    """Mistakes that cannot be made together."""


class Fingerprints:
    """Fingerprints of the known mistakes on a number of scenes, taken when they are asked for.

    Parameters
    ----------
    cases
        That a candidate is judged by, as its profile's `truths` returned them.
    engine
        Of the profile, if what counts as true is what that engine says; else None.
    dt
        s, the candidate's time step, if it is known.
    """

    def __init__(
        self, cases: Sequence[Case], engine: Engine[float] | None = None, dt: float | None = None
    ) -> None:
        self.cases = tuple(telling(cases))
        self.scenes = [case.scene for case in self.cases]
        self.truth = _of_results(case.expected for case in self.cases)
        self.tolerance = _tolerances(self.cases)
        self.sizes = _sizes(self.truth)
        # What happens before or without a bat.
        plate = np.array([name.startswith("plate.") for name, _ in COLUMNS])
        batless = np.array([scene.kind in ("flight", "pitch") for scene in self.scenes])
        self.smooth: Flags = plate[None, :] | batless[:, None]
        self.scheme = engine if isinstance(engine, Verlet) else None
        if self.scheme:
            self.steps: tuple[float, ...] = (self.scheme.dt,)
        else:
            self.steps = STEPS if dt is None else (dt,)
        self.step_known = self.scheme is not None or dt is not None
        self._solved: dict[Guess, Answers | None] = {}
        self._ids = {id(scene) for scene in self.scenes}
        self._unchanged: dict[int, Result] = {}
        self._laws: dict[Drag, tuple[Answers, Answers]] = {}

    # --- predictions ------------------------------------------------------------------------------

    def predict(self, guess: Guess) -> Answers | None:
        """Return what a candidate with these mistakes answers; None if they contradict."""
        if guess not in self._solved:
            try:
                self._solved[guess] = self._predict(guess)
            except ValueError:  # a contradiction, or readings that the model refuses together
                self._solved[guess] = None
        return self._solved[guess]

    def singles(self, steps: Sequence[float]) -> Iterator[Guess]:
        """Yield every form of every mistake, with every one of some time steps."""
        for mistake in KNOWN.values():
            for i, variant in enumerate(mistake.variants):
                if variant.steps and variant.scheme is None and self.scheme:
                    continue  # part of the scheme itself
                for dt in steps if variant.steps else (0.0,):
                    yield Guess((Atom(mistake.name, i),), dt)

    def _predict(self, guess: Guess) -> Answers:
        atoms = sorted(guess.atoms)
        variants = [atom.made for atom in atoms]
        switches = _merged([v.scheme for v in variants if v.scheme is not None])
        if self.scheme and switches.get("verlet_forces") == MILD:
            del switches["verlet_forces"]  # the scene's own reading holds
        laws = [v.drag for v in variants if v.drag is not None]
        if len(laws) > 1:
            raise _Contradiction("two laws of drag")
        if switches and any(v.steps and v.scheme is None for v in variants):
            raise _Contradiction("the scheme does this by itself")
        engine = self._engine(guess.dt, switches)
        law = laws[0] if laws else None
        if law and isinstance(engine, Verlet):
            # The scheme's steps know the model's forces only: the effect of another is added.
            without = self.predict(Guess(tuple(a for a in atoms if not a.made.drag), guess.dt))
            if without is None:
                raise _Contradiction("the others contradict")
            return _shifted(without, *self._effect(law))

        def base(scene: Scene) -> Result:
            return solve_with_drag(scene, law) if law else solve(_under(scene, switches), engine)

        solver: Solver = base if law or switches else self._remembering(base)
        for variant in variants:
            solver = _wrapped(variant, solver, guess.dt)
        return _of_results(map(solver, self.scenes))

    def _remembering(self, solve: Solver) -> Solver:
        """Return a solver that solves the scenes themselves, unchanged, only once."""

        def remembering(scene: Scene) -> Result:
            if id(scene) not in self._ids:
                return solve(scene)
            if id(scene) not in self._unchanged:
                self._unchanged[id(scene)] = solve(scene)
            return self._unchanged[id(scene)]

        return remembering

    def _engine(self, dt: float, switches: Mapping[str, str]) -> Engine[float]:
        if self.scheme:
            return self.scheme
        return Verlet(dt=dt) if switches else Ivp()

    def _effect(self, law: Drag) -> tuple[Answers, Answers]:
        """Return the scenes' answers by the model and by another law of drag."""
        if law not in self._laws:
            self._laws[law] = (
                _of_results(solve(scene, Ivp()) for scene in self.scenes),
                _of_results(solve_with_drag(scene, law) for scene in self.scenes),
            )
        return self._laws[law]

    # --- comparing --------------------------------------------------------------------------------

    def error(self, a: Answers, b: Answers, seen: Flags) -> float:
        """Return the mean difference of two sets of answers, relative to the quantities' sizes.

        `seen` are the numbers that the candidate gave and the truth has. A number that only one
        side has differs by its size.
        """
        return float(self._differences(a, b, seen).mean())

    def _differences(self, a: Answers, b: Answers, seen: Flags) -> Array:
        with np.errstate(invalid="ignore", over="ignore"):
            numbers = np.minimum(np.abs(a.numbers - b.numbers) / self.sizes, 1.0)
        numbers = np.where(np.isnan(a.numbers) != np.isnan(b.numbers), 1.0, numbers)[seen]
        said = (a.outcomes != b.outcomes) & (a.outcomes >= 0) & (b.outcomes >= 0)
        return np.concatenate([np.nan_to_num(numbers), said.astype(float)])

    # --- the search -------------------------------------------------------------------------------

    def diagnose(self, answers: Mapping[str, Answer]) -> Diagnosis:
        """Return which known mistakes explain the errors of a candidate's answers."""
        search = _Search(self, answers)
        return search.diagnosis()


@dataclass(frozen=True)
class _Tried:
    """A guess, and the mean error that it leaves."""

    guess: Guess
    left: float


class _Search:
    """The search for what explains one candidate's answers."""

    def __init__(self, prints: Fingerprints, answers: Mapping[str, Answer]) -> None:
        self.prints = prints
        given = [answers.get(case.id) for case in prints.cases]
        self.candidate = _answers(
            (answer.outcome, answer.values) if answer else (None, {}) for answer in given
        )
        truth = prints.truth
        self.seen: Flags = np.isfinite(self.candidate.numbers) & np.isfinite(truth.numbers)
        self.single = _in_single_precision(answer for answer in given if answer)
        self.count = sum(answer is not None and answer.error is None for answer in given)
        self.error = self.left_by(truth) if self.count else 0.0
        step = None if prints.step_known else common_step(self._landing_times())
        self.steps = prints.steps if step is None else (*prints.steps, step)

    def _landing_times(self) -> list[float]:
        times = self.candidate.numbers[:, COLUMNS.index(("landing.time", 0))]
        return [float(time) for time in times if np.isfinite(time)]

    @cached_property
    def alone(self) -> list[Guess]:
        """Every mistake by itself, in every form that can be predicted."""
        guesses = self.prints.singles(self.steps)
        return [guess for guess in guesses if self.prints.predict(guess) is not None]

    def left_by(self, prediction: Answers) -> float:
        """Return the mean error that a prediction leaves."""
        return self.prints.error(self.candidate, prediction, self.seen)

    def attempt(self, guess: Guess) -> _Tried | None:
        """Return what a guess leaves; None if it contradicts itself."""
        prediction = self.prints.predict(guess)
        return None if prediction is None else _Tried(guess, self.left_by(prediction))

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
        if self.single:
            return self._found("known", "", [SINGLE.name], 1.0, singles)
        if self.error < NOISE:
            sentence = (
                f"noise: errors of {self.error:.1e} of each quantity's size without the pattern "
                "of any known mistake, as rounding or a solver's tolerance leaves them"
            )
            return self._found("noise", sentence, (), max(0.0, share), singles)
        sentence = (
            f"none of the known mistakes: the best guess, {_listed(best.guess.names)}, explains "
            f"{max(0.0, share):.0%} of the error, and a mistake that is made explains at least "
            f"{NAMED:.0%}"
        )
        return self._found("unknown", sentence, (), max(0.0, share), singles)

    def _flawless(self) -> bool:
        with np.errstate(invalid="ignore"):
            off = np.abs(self.candidate.numbers - self.prints.truth.numbers) > self.prints.tolerance
        outcomes = self.candidate.outcomes
        other = (outcomes >= 0) & (outcomes != self.prints.truth.outcomes)
        return not (off[self.seen].any() or other.any() or self.single)

    def _best_singles(self) -> dict[str, _Tried]:
        """Return the best form of each mistake alone, best first."""
        forms: dict[Atom, _Tried] = {}
        for guess in self.alone:
            tried, (atom,) = self.attempt(guess), guess.atoms
            if tried and (atom not in forms or tried.left < forms[atom].left):
                forms[atom] = tried
        best: dict[str, _Tried] = {}
        for tried in sorted(map(self._refined, forms.values()), key=lambda t: t.left):
            best.setdefault(tried.guess.names[0], tried)
        return best

    def _best_set(self, singles: Mapping[str, _Tried]) -> _Tried:
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

    def _tried(self, guesses: Iterable[Guess]) -> list[_Tried]:
        """Return what guesses leave, the least first; no further once all is explained."""
        tried = []
        for guess in guesses:
            if one := self.attempt(guess):
                tried.append(self._refined(one))
                if self.share(tried[-1].left) >= COMPLETE:
                    break
        return sorted(tried, key=lambda t: t.left)

    def _screened(self, seeds: Sequence[_Tried], size: int) -> list[Guess]:
        """Return the most promising sets of a size, by adding up fingerprints.

        Some promise most over all numbers, some over those that no bat has jumbled.
        """
        starts = self.alone if size == 2 else [seed.guess for seed in seeds]
        prints = self.prints
        effects = np.array([self._effect(guess) for guess in self.alone])
        aim = self._relative(self.candidate) - self._relative(prints.truth)
        others = np.array([self._outcomes(guess) for guess in self.alone])
        changed = others != prints.truth.outcomes
        said = self.candidate.outcomes >= 0
        smooth = prints.smooth[self.seen]
        everything: dict[tuple[Atom, ...], tuple[float, Guess]] = {}
        unjumbled: dict[tuple[Atom, ...], tuple[float, Guess]] = {}
        for start in starts:
            with np.errstate(invalid="ignore"):
                left = np.minimum(np.abs(aim - self._effect(start) - effects), 1.0)
            left = np.where(np.isnan(left), 1.0, left)
            outcomes = np.where(changed, others, self._outcomes(start))
            confused = ((outcomes != self.candidate.outcomes) & said).sum(axis=1)
            whole = left.sum(axis=1) + confused
            part = left[:, smooth].sum(axis=1)
            for guess, most, least in zip(self.alone, whole.tolist(), part.tolist(), strict=True):
                joined = _joined(start, guess)
                if joined is None:
                    continue
                key = joined.atoms
                for found, rest in ((everything, most), (unjumbled, least)):
                    if key not in found or rest < found[key][0]:
                        found[key] = rest, joined
        promising = []
        for found in (everything, unjumbled):
            ranked = sorted(found.values(), key=lambda item: item[0])
            promising += [guess for _, guess in ranked[:PROMISING]]
        return list(dict.fromkeys(promising))

    def _relative(self, answers: Answers) -> Array:
        """Return the numbers that are seen, relative to the sizes of their quantities."""
        relative: Array = (answers.numbers / self.prints.sizes)[self.seen]
        return relative

    def _effect(self, guess: Guess) -> Array:
        """Return what a guess does to the numbers that are seen."""
        prediction = self.prints.predict(guess)
        assert prediction is not None
        return self._relative(prediction) - self._relative(self.prints.truth)

    def _outcomes(self, guess: Guess) -> NDArray[np.int64]:
        prediction = self.prints.predict(guess)
        assert prediction is not None
        return prediction.outcomes

    def _bold(self, seeds: Sequence[_Tried], singles: Mapping[str, _Tried]) -> list[Guess]:
        """Return the best guesses, each with every other mistake.

        A mistake that changes much spoils the sum of fingerprints.
        """
        others = [guess for guess in self.alone if not guess.dt]
        others += [tried.guess for tried in singles.values() if tried.guess.dt]
        joined = (_joined(seed.guess, guess) for seed in seeds for guess in others)
        return list(dict.fromkeys(guess for guess in joined if guess))

    def _refined(self, tried: _Tried) -> _Tried:
        """Return a guess with the time step that fits best, where it is not known.

        The effect of a scheme's step grows in proportion to it, more or less, as long as ball and
        bat have not met; so it is fitted there, again and again. People choose round numbers.
        """
        guess = tried.guess
        if self.prints.step_known or not any(atom.made.scheme for atom in guess.atoms):
            return tried
        rest = Guess(tuple(atom for atom in guess.atoms if not atom.made.steps))
        start = self.prints.predict(rest) if rest.atoms else self.prints.truth
        best, dt = tried, guess.dt
        for _ in range(REFINEMENTS):
            prediction = self.prints.predict(Guess(guess.atoms, dt))
            if start is None or prediction is None:
                break
            factor = self._amplitude(start, prediction)
            if not SHORTEST_STEP < dt * factor < LONGEST_STEP or abs(factor - 1.0) < 1e-9:
                break
            dt *= factor
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
        order = np.argsort(ratios)
        middle = np.searchsorted(np.cumsum(weights[order]), weights.sum() / 2)
        return float(ratios[order][middle])

    # --- the words --------------------------------------------------------------------------------

    def _found(
        self,
        finding: Finding,
        sentence: str,
        named: Sequence[str],
        share: float,
        singles: Mapping[str, _Tried],
        best: _Tried | None = None,
    ) -> Diagnosis:
        if finding == "known":
            step = best.guess.dt if best else 0.0
            sentence = "; ".join(
                f"it {(KNOWN | {SINGLE.name: SINGLE})[name].sentence}" for name in named
            )
            sentence += f": this explains {share:.2%} of the error"
            if step:
                sentence += f" (Δt = {step:.4g} s)"
            if best and any(atom.made.scheme for atom in best.guess.atoms):
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

    def _suspect(self, name: str, singles: Mapping[str, _Tried], best: _Tried | None) -> Suspect:
        if name == SINGLE.name:
            return Suspect(
                name=name,
                sentence=SINGLE.sentence,
                remedy=SINGLE.remedy,
                share=1.0,
                step=None,
                twins=[],
            )
        mistake, alone = KNOWN[name], singles[name]
        dt = best.guess.dt if best and name in best.guess.names else alone.guess.dt
        atom = alone.guess.atoms[0].made
        return Suspect(
            name=name,
            sentence=mistake.sentence,
            remedy=mistake.remedy,
            share=self.share(alone.left),
            step=dt if atom.steps else None,
            twins=self._twins(alone),
        )

    def _twins(self, tried: _Tried) -> list[str]:
        """Return the other mistakes that predict the same numbers as a guess."""
        mine = self.prints.predict(tried.guess)
        assert mine is not None
        if self.prints.error(mine, self.prints.truth, self.seen) <= ROUNDING:
            return []  # seen by nobody: no twin of another such
        same = (
            guess.names[0]
            for guess in self.alone
            if guess.names != tried.guess.names and self._alike(mine, guess)
        )
        return list(dict.fromkeys(same))

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


# --- scenes that tell most ------------------------------------------------------------------------


def telling(cases: Iterable[Case]) -> list[Case]:
    """Return the cases that fingerprints are taken from: of each kind those that tell most.

    First come flights that turn back over the vertical, where alone the readings of the lift
    differ; then scenes with the paper's ball, air and gravity, which a program is likely to have
    been written for; the others fill up. Of as many as there are, evenly chosen.
    """
    groups: dict[str, list[list[Case]]] = {kind: [[], [], []] for kind in SCENES}
    for case in cases:
        if decidable(case) and _is_brief(case):
            rank = 0 if _turns_back(case) else 1 if _ordinary(case.scene) else 2
            groups[case.scene.kind][rank].append(case)
    chosen: list[Case] = []
    for kind, most in SCENES.items():
        picked: list[Case] = []
        for group, quota in zip(groups[kind], (most // 4, most, most), strict=True):
            picked += _evenly(group, min(quota, most - len(picked)))
        chosen += picked
    return chosen


# A million steps of the shortest step that is tried, and twice the longest at-bat of the paper's.
BRIEF = 20.0  # s


def _is_brief(case: Case) -> bool:
    """Tell whether a scene ends soon enough to be solved in small steps again and again."""
    if isinstance(case.scene, ImpactScene):
        return True
    landing = case.expected.landing
    ends = landing is None or float(landing.time) <= BRIEF
    return case.expected.outcome != "airborne" and ends and case.scene.time_limit <= 5 * BRIEF


def _evenly(cases: Sequence[Case], count: int) -> list[Case]:
    if len(cases) <= count:
        return list(cases)
    return [cases[i * len(cases) // count] for i in range(count)]


def _turns_back(case: Case) -> bool:
    """Tell whether a ball lands flying the other way than it was sent, as a loop makes it."""
    scene, result = case.scene, case.expected
    if result.landing is None:
        return False
    if result.impact is not None:
        out = result.impact.velocity
    elif isinstance(scene, FlightScene):
        out = scene.launch.velocity
    else:
        return False
    back = result.landing.velocity
    return float(out[0]) * float(back[0]) + float(out[1]) * float(back[1]) < 0


def _ordinary(scene: Scene) -> bool:
    """Tell whether a scene has the paper's ball, air (or none of it) and gravity."""
    model = type(scene).model_fields
    if scene.reading != Reading() or scene.ball.radius != model["ball"].default.radius:
        return False
    if isinstance(scene, ImpactScene):
        return True
    air = scene.air
    return scene.gravity == model["gravity"].default and (
        air is not None and air == model["air"].default
    )


# --- small things ---------------------------------------------------------------------------------


def _tolerances(cases: Sequence[Case]) -> Array:
    """Return what rounding can do to each number."""
    rows = []
    for case in cases:
        known = values_of(case.expected)
        row = []
        for name, i in COLUMNS:
            path = f"{name}[{i}]" if QUANTITIES[name].size > 1 else name
            row.append(SLACK * case.attainable(path) if name in known else math.nan)
        rows.append(row)
    return np.array(rows).reshape(-1, len(COLUMNS))


def _sizes(truth: Answers) -> Array:
    """Return the size of each column's quantity: the median length of its values."""
    sizes = {}
    for name in QUANTITIES:
        columns = [i for i, (other, _) in enumerate(COLUMNS) if other == name]
        lengths = np.sqrt((truth.numbers[:, columns] ** 2).sum(axis=1))
        lengths = lengths[np.isfinite(lengths) & (lengths > 0)]
        sizes[name] = float(np.median(lengths)) if lengths.size else 1.0
    return np.array([sizes[name] for name, _ in COLUMNS])


def _merged(schemes: Sequence[Mapping[str, str]]) -> dict[str, str]:
    """Return the switches of several mistakes of the scheme together."""
    merged: dict[str, str] = {}
    for scheme in schemes:
        for switch, option in scheme.items():
            held = merged.get(switch, MILD)
            if held not in (option, MILD) and option != MILD:
                raise _Contradiction(f"{switch} is {held} and {option}")
            merged[switch] = option if held == MILD else held
    return merged


# The treatment of forces that a mistake of the scheme is combined with if nothing else is known.
MILD = "predicted_recomputed"


def _under(scene: Scene, switches: Mapping[str, str]) -> Scene:
    if not switches:
        return scene
    reading = Reading.model_validate(scene.reading.model_dump() | dict(switches))
    return scene.model_copy(update={"reading": reading})


def _wrapped(variant: Variant, inner: Solver, dt: float) -> Solver:
    return lambda scene: variant.wrapper(scene, inner, dt)


def _shifted(start: Answers, origin: Answers, end: Answers) -> Answers:
    """Return answers moved by the way from `origin` to `end`."""
    numbers = start.numbers + (end.numbers - origin.numbers)
    outcomes = np.where(end.outcomes != origin.outcomes, end.outcomes, start.outcomes)
    return Answers(numbers, outcomes)


def _joined(a: Guess, b: Guess) -> Guess | None:
    """Return two guesses as one; None if they share a mistake or differ in their time step."""
    if set(a.names) & set(b.names):
        return None
    steps = {dt for dt in (a.dt, b.dt) if dt}
    if len(steps) > 1:
        return None
    return Guess(tuple(sorted(a.atoms + b.atoms)), steps.pop() if steps else 0.0)


def common_step(times: Sequence[float]) -> float | None:
    """Return the largest step of which all times are multiples, s; None if there is none.

    A multiple is met to a millionth of a step.
    """
    told = sorted({time for time in times if time > LONGEST_STEP})
    if len(told) < 5:
        return None
    known = np.array(told[:12])
    counts = np.arange(math.ceil(known[0] / LONGEST_STEP), math.floor(known[0] / SHORTEST_STEP) + 1)
    multiples = known[1:, None] * counts / known[0]
    fits = np.abs(multiples - np.round(multiples)).max(axis=0) < 1e-6
    return float(known[0] / counts[np.argmax(fits)]) if fits.any() else None


def _in_single_precision(answers: Iterable[Answer]) -> bool:
    """Tell whether every number is one of single precision, exactly or as such are written."""
    numbers = [x for answer in answers for value in answer.values.values() for x in value if x]
    return len(numbers) >= 10 and all(map(_is_single, numbers))


def _is_single(x: Decimal) -> bool:
    if abs(x.adjusted()) > 37:  # beyond the range of single precision
        return False
    single = np.float32(float(x))
    return float(x) == float(single) or x in (Decimal(str(single)), Decimal(f"{single:.9g}"))


def _listed(names: Sequence[str]) -> str:
    return " and ".join(names)
