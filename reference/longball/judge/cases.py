"""Cases with their truth, and the tolerances of a candidate's answers.

A `Case` is a golden one, or one that `Known` makes of any scene and result.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

from longball.engines.chain import solve
from longball.engines.engine import CannotSolve, Engine
from longball.engines.fence import stop_at
from longball.engines.ivp import Ivp
from longball.engines.verlet import Verlet
from longball.golden.case import Case as GoldenCase
from longball.golden.case import Quantity
from longball.judge.quantities import (
    OPTIONAL,
    QUANTITIES,
    Value,
    length,
    radius_of,
    values_of,
)
from longball.model.frame import launch_frame
from longball.model.law import law_of
from longball.model.names import one_of
from longball.model.numbers import DOUBLES, Undecided
from longball.model.quantities import number, numbers
from longball.model.readings import Reading
from longball.model.result import Result
from longball.model.scene import FlightScene, Scene, landing_height

# Relative error that doubles cannot avoid in a value whose sensitivity is not known: a thousand
# half ulps. A landing distance amplifies an error of the bat's height a thousand times, and hardly
# any at-bat amplifies more.
UNKNOWN_SENSITIVITY = 1e3 * 2.0**-53


@dataclass(frozen=True)
class Known:
    """A scene with a result that is taken for true; its sensitivity is `UNKNOWN_SENSITIVITY`."""

    scene: Scene
    expected: Result
    family: str = "given"
    flags: tuple[str, ...] = ()

    @property
    def id(self) -> str:
        """The scene's id."""
        return self.scene.id or ""

    def attainable(self, quantity: str) -> float:
        """Return the error that double precision may need, in the quantity's unit."""
        return UNKNOWN_SENSITIVITY * max(1.0, abs(float(number(self.expected, quantity))))


Case = GoldenCase | Known


def solved(scenes: Iterable[Scene], engine: Engine, family: str | None = None) -> list[Known]:
    """Return cases of scenes as an engine solves them; the family is the kind if not given."""
    return [Known(scene, solve(scene, engine), family or scene.kind) for scene in scenes]


def lacking(case: Case, given: Collection[str]) -> list[str]:
    """Return those of the `given` quantities that a case's result lacks.

    Most golden families have no apex and no angles.
    """
    known = values_of(case.expected)
    return [name for name in OPTIONAL if name in given and name not in known]


def completed(case: Case, names: Collection[str]) -> Case:
    """Return a golden case with quantities that its result lacks, as `ivp` has them."""
    if not names or isinstance(case, Known) or not decidable(case):
        return case
    try:
        found = solve(case.scene, Ivp())
    except (CannotSolve, Undecided):
        return case
    if found.outcome != case.expected.outcome:
        return case
    blocks: dict[str, Any] = {}
    for name in {name.partition(".")[0] for name in names}:
        mine, whole = getattr(case.expected, name), getattr(found, name)
        more = {k: x for k, x in whole or () if x is not None and getattr(mine, k, None) is None}
        blocks[name] = mine.model_copy(update=more) if mine else whole
    sizes = {
        name: UNKNOWN_SENSITIVITY * max(1.0, abs(float(x)))
        for name, x in numbers(found)
        if name not in case.quantities
    }
    known = {n: Quantity.model_construct(attainable=error) for n, error in sizes.items()}
    expected = case.expected.model_copy(update=blocks)
    return case.model_copy(
        update={"expected": expected, "quantities": {**case.quantities, **known}}
    )


def attainable(case: Case, quantity: str) -> float:
    """Return the error that double precision cannot avoid; of a vector, its length."""
    error = math.hypot(*map(case.attainable, QUANTITIES[quantity].names))
    # The golden data have no error for a landing at (0, 0, 0). The ball falls there from a height,
    # which is rounded.
    if error == 0.0 and quantity == "landing.position" and isinstance(case.scene, FlightScene):
        return 2.0**-53 * abs(case.scene.launch.position[2])
    return error


def asked(cases: Iterable[Case], readings: bool = False, hard: bool = True) -> list[Case]:
    """Return the cases that a program is asked.

    Those of other readings are among them if `readings`, and those of the family `hard` (grazes,
    ties, extreme numbers) if `hard`.
    """
    return [
        case
        for case in cases
        if (readings or case.scene.reading == Reading()) and (hard or case.family != HARD)
    ]


HARD = "hard"
# Flags of the golden data (header.json). FRAGILE: a few ulps of an input decide the outcome, so
# that another one need not be wrong. TANGENTIAL: the ball meets the ground or a fence at a small
# angle.
FRAGILE, TANGENTIAL = "fragile", "tangential"
VERTEX = "vertex"  # the ball passes a corner of the fence closely
MOST_PIECES = 1000  # segments of a flight that are searched: a loop has about six


def decidable(case: Case) -> bool:
    """True if there is a truth that double precision can decide."""
    return case.expected.outcome is not None and all(
        math.isfinite(attainable(case, quantity)) for quantity in values_of(case.expected)
    )


def _touches_within_errors(scene: FlightScene) -> bool:
    """True if doubles leave open whether a flight touches the ground where it turns."""
    # Half an ulp of each number of the launch moves a flight by 2⁻⁵³ of its height and of the way
    # flown so far, or a few times that; an engine may add `SLACK` times as much and pass. Where the
    # height turns from falling to rising nearer to the ground than this, it may be hit or not.
    frame, start = launch_frame(scene.launch.position, scene.launch.velocity, DOUBLES)
    frame = replace(frame, spin=scene.launch.spin)
    law, floor = law_of(scene, frame, DOUBLES), landing_height(scene)
    way = abs(start.z) + abs(floor)
    pieces = Ivp().pieces(law, law.state_of(start), scene.time_limit)
    try:
        for piece in islice(pieces, MOST_PIECES):
            heights = piece.curve(lambda state: state.z - floor)
            state = piece.at(0.0)
            for t in heights.turns(0.0, piece.length):
                if abs(heights(t)) <= SLACK * 2.0**-53 * (way + t * math.hypot(state.u, state.w)):
                    return True
            if heights(piece.length) < 0:  # the ball is down, wherever it has turned before
                return False
            way += piece.length * math.hypot(state.u, state.w)
    except Undecided:  # such as whether the height is reached above which the wind blows
        return True
    return False


def _passes_corner_within_errors(scene: FlightScene) -> bool:
    """True if doubles leave open on which side of a corner of the fence a flight passes."""
    # A corner is where the fence ends or has two heights; the way there is taken to be straight.
    # The place is rounded to 2⁻⁵³ of that way; an engine may add `SLACK` times as much and pass.
    frame, start = launch_frame(scene.launch.position, scene.launch.velocity, DOUBLES)
    error = SLACK * 2.0**-53
    s, place = stop_at(scene.fence, frame, start.s, 1, error, DOUBLES)
    return bool(place.to_break <= error * abs(s))


# The profile `exact` allows two digits less than attainable. The attainable error is that of inputs
# off by half an ulp; a careful implementation also rounds in each of its tens to hundreds of steps,
# with the same sensitivities. In 69 golden cases of all families the ivp engine,
# at 1e-13, needs 30 in most and 88 at the worst, except for a ball that almost comes to rest.
SLACK = 100.0

# Between what the rounding of a hundred steps can do, amplified by bat and ball a thousand times
# (1e-11 of a value), and the smallest difference of two readings of the scheme (1e-5 of it).
SAME_SCHEME = 1e-9


class Profile:
    """A named rule of how near a candidate must come to pass: here, as near as doubles can."""

    error = 0.0  # in the quantity's SI unit, what passes in any case

    def rule(self, cases: Sequence[Case]) -> str:
        """Return the rule in words, as it is for these cases."""
        if cases and all(isinstance(case, Known) for case in cases):
            return (
                f"exact: within {self.allowed(0.0):.0e} of a quantity, since nothing is known of "
                "how rounding shows in these scenes"
            )
        return f"exact: within {SLACK:g} times the error that double precision cannot avoid"

    def scheme(self) -> Verlet | None:
        """Return the engine whose results count as true; None for the golden data."""
        return None

    def truths(self, cases: Sequence[Case]) -> Sequence[Case]:
        """Return the cases with what counts as true under this profile."""
        if (scheme := self.scheme()) is None:
            return cases
        return [Known(c.scene, solve(c.scene, scheme), c.family, c.flags) for c in cases]

    def tolerance(self, case: Case, quantity: str, expected: Value) -> float:
        """Return the largest error that passes, in the quantity's unit."""
        proven = length(radius_of(case.expected, quantity))
        return max(self.error, SLACK * attainable(case, quantity) + proven)

    def allowed(self, size: float) -> float:
        """Return the tolerance of a value of that size whose sensitivity is not known."""
        return max(self.error, SLACK * UNKNOWN_SENSITIVITY * max(1.0, size))

    def may_be_refused(self, case: Case) -> bool:
        """True if errors within the tolerance leave the outcome open; then no answer is needed."""
        scene, flags = case.scene, case.flags
        if FRAGILE in flags:
            return True
        if isinstance(scene, FlightScene):
            if TANGENTIAL in flags and _touches_within_errors(scene):
                return True
            if VERTEX in flags and _passes_corner_within_errors(scene):
                return True
        values = values_of(case.expected)
        near = (name for name in ("contact.margin", "fence.clearance") if name in values)
        return any(length(values[n]) <= self.tolerance(case, n, values[n]) for n in near)


class Exact(Profile):
    """As good as double precision can be: within `SLACK` attainable errors."""


@dataclass(frozen=True)
class Converged(Profile):
    """An error below a number, or within what `Exact` allows where that is more.

    Attributes
    ----------
    error
        In the quantity's SI unit.
    """

    error: float = 1e-6

    def __post_init__(self) -> None:
        if not 0 < self.error < math.inf:
            raise ValueError(f"a tolerance of {self.error} is not a positive number")

    def rule(self, cases: Sequence[Case]) -> str:
        """Return the rule in words."""
        return f"converged: within {self.error:g} (m, s, m/s, J), or what double precision can do"


@dataclass(frozen=True)
class Paper(Profile):
    """The same answers as the paper's scheme at its time step, right or wrong.

    What counts as true is what longball's own Verlet engine answers.

    Attributes
    ----------
    dt
        s.
    """

    dt: float = 0.05

    def rule(self, cases: Sequence[Case]) -> str:
        """Return the rule in words."""
        return (
            f"paper: the answers of the printed scheme at Δt = {self.dt:g} s, "
            f"as longball's own Verlet engine gives them (not the truth), within "
            f"{SAME_SCHEME:g} of each value"
        )

    def scheme(self) -> Verlet:
        """Return the paper's scheme."""
        return Verlet(dt=self.dt)

    def tolerance(self, case: Case, quantity: str, expected: Value) -> float:
        """Return the largest error that passes; see `Profile.tolerance`."""
        return self.allowed(length(expected))

    def allowed(self, size: float) -> float:
        """Return the tolerance of a value of that size; see `Profile.allowed`."""
        return SAME_SCHEME * max(1.0, size)


def profile(
    given: Profile | str | None, tolerance: float | None = None, dt: float | None = None
) -> Profile:
    """Return a profile by name, `Exact` if none is given.

    A ValueError if there is none of that name, or it takes no such number.
    """
    if not isinstance(given, str):
        return given or Exact()
    if tolerance is not None and given != "converged":
        raise ValueError(f"profile {given} takes no tolerance; only converged does")
    if dt is not None and given != "paper":
        raise ValueError(f"profile {given} takes no time step; only paper does")
    kinds: dict[str, type[Profile]] = {"exact": Exact, "converged": Converged, "paper": Paper}
    if given not in kinds:
        raise ValueError(f"there is no profile {given!r}{one_of('the profiles are', given, kinds)}")
    return kinds[given](*(x for x in (tolerance, dt) if x is not None))
