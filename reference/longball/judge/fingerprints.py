"""Fingerprints: what candidates with known mistakes answer, as longball makes them itself.

Every mistake of the library, alone or with others, is made on the scenes that were judged; the
answers, beside the truth, are its fingerprint. `longball.judge.search` looks for those that
explain a candidate's errors.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from longball.engines.chain import MODEL, Model, solve
from longball.engines.engine import Engine
from longball.engines.ivp import Ivp
from longball.engines.verlet import Verlet
from longball.judge.cases import SLACK, Case, decidable
from longball.judge.mistakes import KNOWN, NO_SLIP, SOUND, Solver, Variant
from longball.judge.quantities import QUANTITIES, Value, values_of
from longball.model.readings import Reading
from longball.model.result import Outcome, Result
from longball.model.scene import FlightScene, ImpactScene, Scene

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Time steps tried where the candidate's is not known, s; refined from there.
STEPS = (0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001)

# Fingerprints are taken from so many scenes of each kind.
SCENES = {"at-bat": 24, "flight": 8, "impact": 6, "pitch": 6}


# --- answers as arrays ----------------------------------------------------------------------------

COLUMNS = tuple(
    (name, component) for name, quantity in QUANTITIES.items() for component in range(quantity.size)
)
OUTCOMES: dict[str | None, int] = {None: -1} | {name: i for i, name in enumerate(get_args(Outcome))}


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


def answers_of(rows: Iterable[tuple[str | None, Mapping[str, Value]]]) -> Answers:
    """Return answers from the outcome and the quantities of each scene."""
    numbers, outcomes = [], []
    for outcome, values in rows:
        outcomes.append(OUTCOMES[outcome])
        numbers.append(
            [float(values[name][i]) if name in values else math.nan for name, i in COLUMNS]
        )
    return Answers(np.array(numbers).reshape(-1, len(COLUMNS)), np.array(outcomes, dtype=np.int64))


def _of_results(results: Iterable[Result]) -> Answers:
    return answers_of((result.outcome, values_of(result)) for result in results)


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
        self.cases = tuple(select_cases(cases))
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
                if self.scheme and (variant.instant or (variant.steps and variant.scheme is None)):
                    continue  # the scheme does otherwise; or it does this by itself
                for dt in steps if variant.steps else (0.0,):
                    yield Guess((Atom(mistake.name, i),), dt)

    def _predict(self, guess: Guess) -> Answers:
        atoms = sorted(guess.atoms)
        variants = [atom.made for atom in atoms]
        switches = _merged([v.scheme for v in variants if v.scheme is not None])
        if self.scheme and switches.get("forces") == ANY_SOUND:
            del switches["forces"]  # the scheme's own treatment holds
        models = [Model(forces=v.forces) for v in variants if v.forces is not None]
        if len(models) > 1:
            raise _Contradiction("two laws of drag")
        model = models[0] if models else MODEL
        if switches and any(v.steps and v.scheme is None for v in variants):
            raise _Contradiction("the scheme does this by itself")
        engine = self._engine(guess.dt, switches, model)
        if NO_SLIP in {atom.mistake for atom in atoms} and switches["forces"] not in SOUND:
            raise _Contradiction("no slip in the forces, and one")

        def base(scene: Scene) -> Result:
            return solve(scene, engine, model)

        plain = model is MODEL and not switches
        solver = Solver(self._remembering(base) if plain else base, model.forces, guess.dt)
        # What is done in steps is done under the forces that the other mistakes leave: innermost.
        for variant in sorted(variants, key=lambda v: not v.steps):
            solver = solver.making(variant)
        return _of_results(map(solver.solve, self.scenes))

    def _remembering(self, solve: Callable[[Scene], Result]) -> Callable[[Scene], Result]:
        """Return a solver that solves the scenes themselves, unchanged, only once."""

        def remembering(scene: Scene) -> Result:
            if id(scene) not in self._ids:
                return solve(scene)
            if id(scene) not in self._unchanged:
                self._unchanged[id(scene)] = solve(scene)
            return self._unchanged[id(scene)]

        return remembering

    def _engine(self, dt: float, options: Mapping[str, Any], model: Model) -> Engine[float]:
        if self.scheme:
            return replace(self.scheme, **options)
        if options:
            return Verlet(dt=dt, **options)
        # A component that drags by itself has a kink where it changes its sign. A Taylor step does
        # not see it and goes on beyond it; the error estimate of DOP853 does.
        return Ivp() if model is MODEL else Ivp("DOP853")

    # --- comparing --------------------------------------------------------------------------------

    def error(self, a: Answers, b: Answers, seen: Flags) -> float:
        """Return the mean difference of two sets of answers, relative to the quantities' sizes.

        `seen` are the numbers that the candidate gave and the truth has. A number that only one
        side has differs by its size.
        """
        return float(self._differences(a, b, seen).mean())

    def quantile90(self, a: Answers, b: Answers, seen: Flags) -> float:
        """Return the 90 % quantile of the differences; see `error`."""
        return float(np.quantile(self._differences(a, b, seen), 0.9))

    def _differences(self, a: Answers, b: Answers, seen: Flags) -> Array:
        with np.errstate(invalid="ignore", over="ignore"):
            numbers = np.minimum(np.abs(a.numbers - b.numbers) / self.sizes, 1.0)
        numbers = np.where(np.isnan(a.numbers) != np.isnan(b.numbers), 1.0, numbers)[seen]
        differ = (a.outcomes != b.outcomes) & (a.outcomes >= 0) & (b.outcomes >= 0)
        return np.concatenate([np.nan_to_num(numbers), differ.astype(float)])


# --- the cases that discriminate best -------------------------------------------------------------


def select_cases(cases: Iterable[Case]) -> list[Case]:
    """Return the cases that fingerprints are taken from: of each kind those that discriminate best.

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
    rows = [
        [
            SLACK * case.attainable(QUANTITIES[name].names[i]) if name in known else math.nan
            for name, i in COLUMNS
        ]
        for case in cases
        for known in [values_of(case.expected)]
    ]
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
            held = merged.get(switch, ANY_SOUND)
            if held not in (option, ANY_SOUND) and option != ANY_SOUND:
                raise _Contradiction(f"{switch} is {held} and {option}")
            merged[switch] = option if held == ANY_SOUND else held
    return merged


# The treatment of forces that a mistake of the scheme is combined with if nothing else is known.
ANY_SOUND = "predicted_recomputed"


def joined_guess(a: Guess, b: Guess) -> Guess | None:
    """Return two guesses as one; None if they share a mistake or differ in their time step."""
    if set(a.names) & set(b.names):
        return None
    steps = {dt for dt in (a.dt, b.dt) if dt}
    if len(steps) > 1:
        return None
    return Guess(tuple(sorted(a.atoms + b.atoms)), steps.pop() if steps else 0.0)
