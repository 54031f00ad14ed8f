"""Programs that are known to be wrong, or known to be right, and the scenes that they are asked.

A `Subject` answers cases: a command does, or longball's own chain with an edit.
"""

import csv
import hashlib
import json
import math
import random
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from longball.engines.ivp import Ivp
from longball.golden import header, load
from longball.judge.answers import Answer
from longball.judge.candidate import Limits, run
from longball.judge.cases import Case, Converged, Exact, Paper, Profile, decidable, solved
from longball.judge.diagnosis.chain import OWN
from longball.judge.diagnosis.expression import Node, evaluate
from longball.judge.diagnosis.operators import edits
from longball.judge.diagnosis.residual import Data, begun, data_of, specialised_to, take, values
from longball.judge.diagnosis.search import defaults
from longball.judge.fresh import moved
from longball.judge.quantities import values_of
from longball.model.scene import Scene
from tests.planted.mutator import c_mutants, python_mutants

HERE = Path(__file__).resolve().parent
CANDIDATES = HERE.parent / "candidates"
ROOT = HERE.parent.parent
FLIGHTS = ("flight-vacuum", "flight-drag", "flight-lift", "flight-both")
PAPER = (*FLIGHTS, "flight-vertical", "flight-weightless", "pitch", "impact", "at-bat")
REAL = ("flight-spin-lift", "flight-weather", "impact-oblique", "fence")
# What doubles cannot decide tells nothing of a mistake; at_bat_lab.py knows no defaults.
EVERYTHING = tuple(
    name for name in header().families if not name.startswith("hard") and name != "defaults"
)
LIMITS = Limits(scene_seconds=20.0, total_seconds=120.0)

Answers = Mapping[str, Answer]
EXACT = Exact()


class Crashed(Exception):
    """A program that ends with an error, does not end, or leaves scenes unanswered."""


@dataclass(frozen=True)
class Subject:
    """A program to be judged."""

    source: str
    name: str  # "ballistics.c gravity_981"
    families: Sequence[str]  # of the golden data that it is judged by
    answers: Callable[[Sequence[Case]], Answers]
    original: Callable[[Sequence[Case]], Answers] | None = None  # the program without the mutation
    profile: Profile = EXACT  # that the original passes
    dt: float | None = None  # s, its time step

    def file(self, folder: Path) -> Path:
        """Where its result is kept."""
        digest = hashlib.sha256(f"{self.name} {self.families}".encode()).hexdigest()[:16]
        return folder / self.source / f"{digest}.json"


# --- scenes that nobody has seen ------------------------------------------------------------------


def pushed_aside(scene: Scene) -> bool:
    """True if a side force acts, which none of the programs knows."""
    air = getattr(scene, "air", None)
    return air is not None and air.side_coefficient is not None


@cache
def golden(families: tuple[str, ...], most: int) -> tuple[Case, ...]:
    """At most so many cases of each family, evenly spread."""
    found = []
    for family in families:
        cases = [case for case in load(family) if decidable(case) and not pushed_aside(case.scene)]
        count = min(most, len(cases))
        found += [cases[i * len(cases) // count] for i in range(count)]
    return tuple(found)


@cache
def fresh(families: tuple[str, ...], count: int) -> tuple[Case, ...]:
    """New cases like those of the golden data: their scenes moved at random, and solved."""
    old = [case.scene for case in golden(families, 10**6)]
    random.Random(1).shuffle(old)
    scenes = moved([old[number % len(old)] for number in range(3 * count)], seed=2)
    found = list[Case]()
    for scene in scenes:
        try:
            (case,) = solved([scene], Ivp())
        except Exception:  # the reference cannot decide it
            continue
        found += [case] if decidable(case) else []
        if len(found) == count:
            break
    return tuple(found)


# --- the sources ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Program:
    """Answers of a command; a Crashed if it does not answer everything."""

    command: Sequence[str]
    table: bool = False

    def __call__(self, cases: Sequence[Case]) -> Answers:
        """Run it."""
        ran = run(self.command, [case.scene for case in cases], LIMITS, table=self.table)
        answers = ran.collected.answers
        if ran.status != 0 or len(answers) < len(cases):
            raise Crashed(ran.errors[-300:])
        return answers


def built(source: Path, folder: Path) -> Path:
    """Compile a program in C; a Crashed if it does not compile."""
    program = folder / source.stem
    command = ["cc", "-O1", "-w", "-o", program, source, "-lm"]
    if not program.exists() and subprocess.run(command, capture_output=True).returncode:
        raise Crashed("does not compile")
    return program


def planted(half: str, folder: Path) -> Iterator[Subject]:
    """The mistakes of mistakes.csv, and those that are edits of at_bat_lab.py."""
    programs = {
        "ballistics.c": [str(built(HERE / "ballistics.c", folder))],
        "flight.js": ["node", str(HERE / "flight.js")],
    }
    with (HERE / "mistakes.csv").open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            name = f"{row['program']} {row['name']}"
            if half in ("both", half_of(name)):
                families = PAPER if row["golden"] == "paper" else tuple(row["golden"].split())
                command = [*programs[row["program"]], "--mistake", row["name"]]
                yield Subject("planted", name, families, Program(command))
    for author in ("at_bat_lab", "batter"):
        rows = json.loads((HERE / f"{author}.json").read_text(encoding="utf-8"))
        for mistake, row in rows.items():
            name = f"{author}.py {mistake}"
            if half in ("both", half_of(name)):
                families = row["golden"].split() if "golden" in row else EVERYTHING
                yield Subject("planted", name, families, lab(row["edits"], folder))


def edited_lab(edits: Sequence[tuple[str, str]]) -> str:
    """The text of at_bat_lab.py with some of it replaced."""
    text = (HERE / "at_bat_lab.py").read_text(encoding="utf-8")
    for old, new in edits:
        assert old in text, old
        text = text.replace(old, new)
    return text


def lab(edits: Sequence[tuple[str, str]], folder: Path) -> "Mutated":
    """Answers of at_bat_lab.py with some of its text replaced."""
    return Mutated("at_bat_lab.py", edited_lab(edits), (), folder)


def half_of(name: str) -> str:
    """The half that a program with a mistake belongs to, "open" or "closed"."""
    return ("open", "closed")[hashlib.sha256(name.encode()).digest()[0] % 2]


# Programs whose source is mutated, with their arguments, the golden data that they solve, what they
# pass, and their time step.
GOOD = Converged(1e-6)
MUTATED: tuple[tuple[Path, Sequence[str], Sequence[str], Profile, float | None], ...] = (
    (ROOT / "docs" / "candidate.py", (), (*FLIGHTS, "flight-vertical"), GOOD, None),
    (CANDIDATES / "paper_verlet.py", ("--dt", "0.01"), PAPER, Paper(0.01), 0.01),
    (HERE / "at_bat_lab.py", (), (*PAPER, *REAL), GOOD, None),
    (CANDIDATES / "euler_csv.py", ("0.001", "17"), FLIGHTS, Converged(0.1), 0.001),
    (CANDIDATES / "paper_verlet.c", ("--dt", "0.01"), PAPER, Paper(0.01), 0.01),
    (HERE / "ballistics.c", (), (*PAPER, *REAL), GOOD, None),
)


@dataclass(frozen=True)
class Mutated:
    """Answers of a mutant, which is written and compiled when it is run first."""

    name: str
    source: str
    arguments: Sequence[str]
    folder: Path

    def __call__(self, cases: Sequence[Case]) -> Answers:
        """Run it."""
        digest = hashlib.sha256(self.source.encode()).hexdigest()[:16]
        file = self.folder / f"{digest}{Path(self.name).suffix}"
        file.write_text(self.source, encoding="utf-8")
        is_c = file.suffix == ".c"
        command = [str(built(file, self.folder))] if is_c else [sys.executable, str(file)]
        return Program([*command, *self.arguments], self.name == "euler_csv.py")(cases)


def mutants(seed: int, folder: Path) -> Iterator[Subject]:
    """Mutants of all programs in turn, each program's in a random order."""
    draw, queues = random.Random(seed), []
    for path, arguments, *more in MUTATED:
        source = path.read_text(encoding="utf-8")
        every = [*(c_mutants if path.suffix == ".c" else python_mutants)(source)]
        # What a planted mistake does is not done here.
        every = [m for m in every if "wrong" not in source.splitlines()[_line(m.change) - 1]]
        draw.shuffle(every)
        original = Mutated(path.name, source, arguments, folder)
        queues.append((path.name, more, original, every))
    for number in range(max(len(every) for *_, every in queues)):
        for name, (families, passes, dt), original, every in queues:
            if number < len(every):
                mutant = every[number]
                program = replace(original, source=mutant.source)
                title = f"{name} {mutant.change}"
                yield Subject("mutants", title, families, program, original, passes, dt)


def _line(change: str) -> int:
    return int(change.partition(":")[0])


@dataclass(frozen=True)
class Edited:
    """Answers of the chain with an edit; see `answers_of`."""

    chain: Any

    def __call__(self, cases: Sequence[Case]) -> Answers:
        """Solve the cases."""
        return answers_of(self.chain, cases)


def truth(cases: Sequence[Case]) -> Answers:
    """The answers of a program without any error."""
    return {c.id: Answer(c.id, c.expected.outcome, values_of(c.expected)) for c in cases}


def answers_of(chain: Sequence[Any], cases: Sequence[Case]) -> dict[str, Answer]:
    """Answers that a chain makes, with the outcomes and the options of the truth.

    A flight ends where its event is; a scene in which that is not found again is not answered.
    """
    data = data_of(cases, truth(cases))
    columns, lost = begun(data), np.zeros(len(cases), bool)
    with np.errstate(all="ignore"):
        for stage in chain:
            told = np.isfinite(np.atleast_2d(data.expected[stage.quantities[0]])).all(axis=0)
            some = np.flatnonzero(told & np.isin(columns["kind"], stage.scenes))
            if stage.kind == "event" or not len(some):
                continue
            event = _event_of(chain, stage) if stage.kind == "flight" else None
            if event is not None:
                lost[some[~_ended(stage, event, columns, some)]] = True
            for quantity, value in values(stage, take(columns, some)).items():
                _put(columns, quantity, some, value)
    answers = {}
    for i, case in enumerate(cases):
        told = {
            quantity: np.atleast_1d(columns[node.data][..., i])
            for quantity, node in OWN.items()
            if np.isfinite(data.expected[quantity][..., i]).all()
        }
        if not lost[i] and all(math.isfinite(x) for value in told.values() for x in value):
            exact = {q: tuple(Decimal(repr(float(x))) for x in xs) for q, xs in told.items()}
            answers[case.id] = Answer(case.id, case.expected.outcome, exact)
    return answers


def _put(columns: dict[str, Any], quantity: str, some: Any, value: Any) -> None:
    column = columns[OWN[quantity].data].copy()
    column[..., some] = value
    columns[OWN[quantity].data] = column


def _event_of(chain: Sequence[Any], flight: Any) -> Any:
    ends = (s for s in chain if s.kind == "event" and s.quantities[0] == flight.quantities[0])
    return next(ends, None)


def _ended(flight: Any, event: Any, columns: dict[str, Any], some: Any) -> Any:
    """Move the time of a flight to where its event is, by secants; true where it is found."""
    block = flight.quantities[0].partition(".")[0]
    clock = f"{block}.hang_time" if block == "landing" else f"{block}.time"

    def at(time: Any) -> Any:
        _put(columns, clock, some, time)
        for quantity, value in values(flight, take(columns, some)).items():
            _put(columns, quantity, some, value)
        (zero,) = values(event, take(columns, some)).values()
        return zero

    b = columns[OWN[clock].data][some]
    a, fb = b, at(b)
    best, least = b, np.abs(fb)
    a = b * (1 + 1e-4)
    fa = at(a)
    for _ in range(12):
        step = np.where(fa != fb, fb * (b - a) / (fb - fa), 0.0)
        a, fa = b, fb
        b = b - np.clip(np.nan_to_num(step), -0.2 * np.abs(b), 0.2 * np.abs(b))
        fb = at(b)
        better = np.abs(fb) < least
        best, least = np.where(better, b, best), np.where(better, np.abs(fb), least)
    at(best)
    return least < 1e-11


def own_edits(seed: int, most: int) -> Iterator[Subject]:
    """Edits of the chain of some families, drawn at random."""
    draw = random.Random(seed)
    sets = (("flight-both",), ("impact",), ("at-bat",), ("pitch",), ("flight-weather",),
            ("flight-spin-lift",), ("impact-oblique",), ("fence",))  # fmt: skip
    queues = []
    for families in sets:
        cases = golden(families, most)
        data = data_of(cases, truth(cases))
        chain = specialised_to(data)
        every = [
            (s, e)
            for s in chain
            if s.kind != "event"
            for e in edits(chain, s, defaults(), s.with_spin(data.columns))
        ]
        draw.shuffle(every)
        queues.append((families, chain, data, every))
    for number in range(max(len(every) for *_, every in queues)):
        for families, chain, data, every in queues:
            if number >= len(every):
                continue
            stage, edit = every[number]
            if edit.starts:
                if (value := _usual(edit.starts[0], data)) is None:
                    continue
                edit = edit.settled(float(f"{value * draw.uniform(0.8, 1.2):.3g}"), 0.0)
            name = f"{families[0]}: {stage.name} {edit.words}"
            yield Subject("edits", name, families, Edited(edit.apply(chain)), Edited(chain))


def _usual(start: float | Node, data: Data) -> float | None:
    if not isinstance(start, Node):
        return start
    try:
        found = float(np.nanmedian(evaluate(start, begun(data))))
    except KeyError:  # of a flight's state
        return None
    return found if math.isfinite(found) else None


# Runge and Kutta's method by steps of a length, in at_bat_lab.py.
STEPS = """    t_end, h = t + H, {step}
    while t < t_end - 1e-13:
        h = min(h, t_end - t)
        move = lambda k, part: tuple([a + part * b for a, b in zip(y, k)])
        a = rate(t, y)
        b = rate(t + h / 2, move(a, h / 2))
        c = rate(t + h / 2, move(b, h / 2))
        d = rate(t + h, move(c, h))
        y = tuple([x + h / 6 * sum(k) for x, *k in zip(y, a, b, b, c, c, d)])
        t += h
    return y, 1"""
SOLVE, STEP = "json.dumps(solve(scene))", "    return extrapolated(rate, t, y, H)"
# What is written with fewer digits; a number of single precision is another double.
WRITTEN = "json.dumps(json.loads(json.dumps(solve(scene)), parse_float=lambda x: {shown}))"


def right(folder: Path) -> Iterator[Subject]:
    """The right program at many levels of accuracy, for all scenes that it solves."""
    levels = {f"step {h}": (STEP, STEPS.format(step=h)) for h in (0.2, 0.1, 0.05, 0.02, 0.01, 5e-3)}
    for tolerance in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10):
        levels[f"tolerance {tolerance}"] = ("SHARP = 1e-13", f"SHARP = {tolerance}")
    single = "struct.unpack('f', struct.pack('f', float(x)))[0]"
    cuts = {"": "float(x)", " float32": single}
    cuts |= {f" {n} digits": f"float(f'{{float(x):.{n}g}}')" for n in (4, 6, 8, 10)}
    for families in (FLIGHTS, ("pitch",), ("impact",), ("at-bat",), PAPER):
        for made, level in levels.items():
            for short, shown in cuts.items():
                program = lab([level, (SOLVE, WRITTEN.format(shown=shown))], folder)
                name = f"at_bat_lab.py {families[0]}.. {made}{short}"
                yield Subject("right", name, families, program)
