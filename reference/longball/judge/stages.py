"""Whether each stage of an answer follows from the candidate's own earlier values.

From the plate that a candidate reports, the bat's height; from its point of contact, the normal and
the bat's velocity; from its restitution, the impulse; from its velocity after the impact, the
flight. Every stage is computed with longball's own parts from what the candidate says of the stages
before, so that a mistake shows where it is made and not in what comes after it. Where the candidate
says nothing, longball's own value stands in.

A flight is looked at twice: where the ball is on its path at the candidate's own time, and whether
the event that ends it is met there. The first tests the law and the integrator, the second the
landing.
"""

from __future__ import annotations

import math
import random
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from decimal import Decimal
from functools import cached_property
from typing import Any

from longball.engines import chain
from longball.engines.chain import MODEL, ContactState, Model, OneCase
from longball.engines.engine import CannotSolve, Engine, Launch, Stepped
from longball.engines.fence import Chord, chords
from longball.engines.ivp import Ivp
from longball.engines.path import Leg
from longball.engines.verlet import Verlet
from longball.judge.answers import Answer
from longball.judge.any_law import ANY_LAW, is_papers
from longball.judge.cases import SLACK, Case, attainable
from longball.judge.quantities import difference, length, radius_of, values_of
from longball.model.bat import inertia_factor, lever_arm
from longball.model.force import cross
from longball.model.frame import launch_frame
from longball.model.impact import energy_change
from longball.model.numbers import DOUBLES, Undecided, plus
from longball.model.scene import FlightScene, ImpactScene, Scene, landing_height

Numbers = tuple[float, ...]

# In the order in which a scene goes through them.
STAGES = (
    "pitch", "plate", "touching", "normal", "bat velocity", "normal speed", "restitution",
    "impulse", "velocity after", "spin after", "energy", "flight", "spin decay", "fence",
    "landing", "landing velocity", "time", "distance",
)  # fmt: skip
COLLISION = STAGES[STAGES.index("normal") : STAGES.index("flight")]
FLYING = STAGES[STAGES.index("flight") :]


@dataclass(frozen=True)
class Change:
    """The one chain with something else in it: what a mistake is, or a fitted number."""

    # What is done to the scene before it is solved.
    scene: Callable[[Any], Any] = lambda scene: scene
    # What is done to the forces and the collision.
    model: Callable[[Model], Model] = lambda model: model
    engine: Engine[float] = ANY_LAW  # who flies
    # Whether the bat pushes for two steps of the paper's scheme, as Appendix B has it.
    push: bool = False
    # What is done to the scene where it is looked for when ball and bat meet, and nowhere else.
    meeting: Callable[[Any], Any] = lambda scene: scene
    # What is done to the launch of a batted ball, with its scene.
    launch: Callable[[Any, Launch[float]], Launch[float]] = lambda scene, launch: launch

    def then(self, other: Change) -> Change:
        """Return this change with another one on top."""
        return Change(
            lambda scene: other.scene(self.scene(scene)),
            lambda model: other.model(self.model(model)),
            self.engine if other.engine is ANY_LAW else other.engine,
            self.push or other.push,
            lambda scene: other.meeting(self.meeting(scene)),
            lambda scene, launch: other.launch(scene, self.launch(scene, launch)),
        )


NONE = Change()


@dataclass(frozen=True)
class Trial:
    """A case, and what a candidate says of it, in doubles."""

    case: Case
    # What it says, and what is true.
    given: Mapping[str, Numbers]
    expected: Mapping[str, Numbers]
    # Of each quantity the size, and the error that double precision cannot avoid.
    bounds: Mapping[str, tuple[float, float]]
    outcome: str | None = None
    # Half a unit in the last place written, if numbers are written with few decimals; the same of
    # numbers with few digits, relative to them.
    resolution: float = 0.0
    share: float = 0.0
    right: bool = False  # whether all that it says is true
    told: Mapping[str, object] = field(default_factory=dict)
    granted: float = 0.0  # the error of a quantity that counts as none, in its unit

    @property
    def scene(self) -> Any:
        """What was asked."""
        return self.case.scene

    @property
    def confused(self) -> bool:
        """Whether another outcome was given."""
        return self.outcome not in (None, self.case.expected.outcome)

    def saying(self, values: Mapping[str, Numbers]) -> Trial:
        """Return the trial as if the candidate said these values."""
        return replace(self, given={**self.given, **values})

    @cached_property
    def slips(self) -> Mapping[str, float]:
        """What few digits do to each quantity and to what follows from it.

        Found by moving all numbers by half a unit of their last digits, up or down at random.
        """
        draw = random.Random(0)
        as_given = _residuals(self)
        slips: dict[str, float] = {}
        for _ in range(MOVES):
            moved = {
                name: tuple(x + draw.choice((-1, 1)) * self.cut_off(x) for x in value)
                for name, value in self.given.items()
            }
            for quantity, residual in _residuals(self.saying(moved)).items():
                slip = WORST_MOVE * math.dist(residual, as_given.get(quantity, residual))
                slips[quantity] = max(slips.get(quantity, 0.0), slip)
        return slips

    @property
    def coarse(self) -> bool:
        """Whether its numbers are written with few digits."""
        return self.resolution > 0 or self.share > 0

    def cut_off(self, x: float) -> float:
        """Return what few digits may leave out of a number: half a unit in its last one."""
        return self.resolution + self.share * abs(x)


Trials = Sequence[Trial]


@dataclass(frozen=True)
class Check:
    """A quantity that follows from earlier ones, or does not."""

    # Where, and what.
    stage: str
    quantity: str
    expected: Numbers  # what follows from the candidate's earlier values
    obtained: Numbers  # what it says
    tolerance: float  # what rounding may do
    scale: float  # the size that the error is relative to

    @property
    def error(self) -> float:
        """The length of the difference; as large as the quantity where there is none."""
        error = math.dist(self.expected, self.obtained)
        return error if math.isfinite(error) else self.scale

    @property
    def follows(self) -> bool:
        """Whether the error is within the tolerance."""
        return self.error <= self.tolerance


# A law that errs by so much in the velocity errs by some of that times the time of flight in the
# place. What errs less there, by this factor, errs at the end only.
AT_THE_END = 3e-3

# Values given that are no state that a ball can be in, or parts that contradict each other.
_NO_STATE = (CannotSolve, Undecided, ArithmeticError, ValueError, KeyError, IndexError)


def trial_of(case: Case, answer: Answer, granted: float = 0.0) -> Trial:
    """Return a case and its answer in doubles; `granted` is the error that counts as none."""
    # Of points without velocities the slope is known, which many integrators do not move by.
    slopes = answer.path is not None and answer.path.shape[1] == 4
    given = {
        name: tuple(map(float, value))
        for name, value in answer.values.items()
        if not (slopes and name.endswith(".velocity"))
    }
    expected = values_of(case.expected)
    right = answer.outcome in (None, case.expected.outcome) and all(
        name in expected
        and difference(value, expected[name])
        <= max(granted, SLACK * attainable(case, name) + length(radius_of(case.expected, name)))
        for name, value in answer.values.items()
    )
    true = {name: tuple(map(float, value)) for name, value in expected.items()}
    bounds = {name: (length(value), attainable(case, name)) for name, value in expected.items()}
    written = _resolution(answer), _share(answer)
    return Trial(case, given, true, bounds, answer.outcome, *written, right, answer.told, granted)


SHORT = 7  # whoever writes so few digits leaves out more than single precision does
MOST_DIGITS = 12  # numbers with more digits are doubles, or as good
ENOUGH = 5  # fewer numbers than this may be short, or in single precision, by chance: 2.0 is


def half_unit(digits: int) -> float:
    """Return half a unit in the last digit, relative, of numbers with so many."""
    return 0.5 * 10.0 ** (1 - digits)


def _share(answer: Answer) -> float:
    """Return half a unit in the last digit written, relative, if all numbers have few digits."""
    written = [digits(x) for value in answer.values.values() for x in value]
    few = len(written) >= ENOUGH and max(written) <= MOST_DIGITS
    return half_unit(max(written)) if few else 0.0


def digits(x: Decimal) -> int:
    """Return how many digits a number is written with, but for zeros at its ends."""
    return len(x.normalize().as_tuple().digits)


def _resolution(answer: Answer) -> float:
    """Return half a unit in the last place written, if numbers are written with few decimals."""
    broken = [x for value in answer.values.values() for x in value if x != x.to_integral_value()]
    # Of 6.0E-4 four.
    places = max((-int(x.normalize().as_tuple().exponent) for x in broken), default=MOST_DIGITS + 1)
    return 0.5 * 10.0**-places if places <= MOST_DIGITS else 0.0


# How often the numbers of an answer are moved, and how much worse than the worst of these moves
# their rounding may be.
MOVES, WORST_MOVE = 4, 3.0

# What few digits do where a move of the numbers has another outcome: a ball lands a hundred metres
# away, and a change of energy is μ(Ṽ·n)², some 700 J, times one of ẽ.
HANDED_ON = 1000.0

CLOSE = 1e-6  # m: a place that is nearer to a flight than this is on it, for all that follows
ANY_LAW_ERROR = 3e-8  # of a quantity: flights under any law err by a third of it at most


def follow(trial: Trial, change: Change = NONE, only: Iterable[str] = STAGES) -> list[Check]:
    """Return what follows from a candidate's own earlier values under a change, stage by stage."""
    found: list[Check] = []
    with suppress(*_NO_STATE):  # beyond that nothing follows
        found.extend(_Following(trial, change).checks(frozenset(only)))
    return found


def _residuals(trial: Trial) -> dict[str, Numbers]:
    """Return how far each quantity is from what follows from the others."""
    exact = replace(trial, resolution=0.0, share=0.0)
    return {
        c.quantity: tuple(x - y for x, y in zip(c.obtained, c.expected, strict=True))
        for c in follow(exact)
    }


# Of which stage a quantity is, where it is told from the others by its block alone.
STAGE_OF = {
    "plate": "pitch", "contact.normal": "normal", "contact.bat_velocity": "bat velocity",
    "contact.normal_speed": "normal speed", "contact": "touching",
    "impact.restitution": "restitution", "impact.impulse": "impulse",
    "impact.energy_change": "energy", "impact.spin": "spin after", "impact": "velocity after",
    "fence": "fence", "landing.fair": "fence", "landing.time": "time",
    "landing.distance": "distance", "landing.velocity": "landing velocity",
    "landing.spin": "spin decay", "landing.path": "spin decay", "landing": "flight",
}  # fmt: skip


ENDS = ("plate", "plate.position"), ("landing", "landing.position")  # stages of their own


def stage_of(quantity: str) -> str:
    """Return the stage that a quantity is of."""
    return STAGE_OF.get(quantity) or STAGE_OF[quantity.partition(".")[0]]


def followed(trial: Trial) -> list[Check]:
    """Return what follows in a trial and what does not, to the last digits."""
    # Of an answer that is right in all, each of its quantities follows.
    if trial.right:
        true, given = trial.expected, trial.given
        named = [(stage_of(name), name, name) for name in given]
        named += [(at, f"{name}: event", name) for at, name in ENDS if name in given]
        return [Check(at, quantity, true[name], given[name], math.inf, 1.0)
                for at, quantity, name in named]  # fmt: skip
    checks = follow(trial)
    # What is right to within the errors of flights under any law may be wrong beyond them.
    return checks if any(not c.follows for c in checks) else follow(trial, Change(engine=Ivp()))


@dataclass(frozen=True)
class Placed:
    """Where a point that a candidate gives lies beside the true path."""

    off: float  # distance from the path, m
    clock: float  # how much later its time is than that of the nearest point of the path, s
    moved: float  # distance from where the ball is at its time, m
    time: float  # the candidate's, s since the flight begins
    point: Numbers  # the candidate's, m
    # The true path: from the time to the place, and to the velocity.
    way: Callable[[float], Numbers]
    velocity: Callable[[float], Numbers]


def placed(trial: Trial, change: Change, stage: str) -> Placed | None:
    """Place a landing, a plate ("pitch") or a contact ("touching") on the true path, or None."""
    following = _Following(trial, change)
    try:
        if stage == "touching":
            given = following.given
            at = given["contact.time"][0], given["contact.position"]
            following.flown = following.thrown[0], *at
        else:
            list(following.checks(frozenset([stage, "plate" if stage == "pitch" else "landing"])))
    except _NO_STATE:
        return None
    if following.flown is None:
        return None
    leg, flown, point = following.flown
    time = flown
    try:
        for _ in range(20):
            place, velocity = _at(leg, time)
            square = sum(v * v for v in velocity)
            along = sum((p - x) * v for p, x, v in zip(point, place, velocity, strict=True))
            time += along / square
            if abs(along / square) < 1e-14 * max(abs(time), 1.0):
                break
        nearest, there = _at(leg, time)[0], _at(leg, flown)[0]
    except (ArithmeticError, ValueError):
        return None
    off, moved = math.dist(nearest, point), math.dist(there, point)
    if not math.isfinite(off + moved):
        return None
    way = (lambda t: _at(leg, t)[0]), (lambda t: _at(leg, t)[1])
    return Placed(off, flown - time, moved, flown, point, *way)


def view_values(
    trial: Trial, change: Change, quantity: str
) -> tuple[Any, Mapping[str, Numbers], Numbers, float]:
    """Return what formulas take: scene, values so far, velocity before the impact, bat's height.

    Velocity and height are 0 where they are not known.
    """
    following = _Following(trial, change)
    flies = stage_of(quantity) in FLYING
    with suppress(*_NO_STATE):  # what comes later may not follow, and is not needed
        list(following.checks(frozenset(STAGES if flies else set(STAGES) - set(FLYING))))
    before: Numbers = (0.0, 0.0, 0.0)
    height = 0.0
    if "contact.normal" in trial.expected:
        with suppress(*_NO_STATE):
            height = following.height
            before = following.before
    # Where doubles do not tell what follows, as of a graze, the truth stands for it.
    known = {**trial.expected, **following.own}
    follows = {f"{name}:follows": value for name, value in known.items()}
    return following.scene, {**follows, **following.own, **following.given}, before, height


class _Following:
    """One trial under one change."""

    def __init__(self, trial: Trial, change: Change) -> None:
        self.trial, self.change = trial, change
        # Of a ball that the fence stops no landing is known.
        stopped = trial.case.expected.outcome == "wall"
        self.given = {n: x for n, x in trial.given.items()
                      if not (stopped and n.startswith("landing"))}  # fmt: skip
        self.scene: Any = change.scene(trial.scene)
        self.model = change.model(MODEL)
        self.own: dict[str, Numbers] = {}
        self.meeting: chain.Meeting[float] | None = None
        self.exact = True
        # The leg that a point lies on, when, s since it begins, and the point, m.
        self.flown: tuple[Leg[float], float, Numbers] | None = None

    def checks(self, only: frozenset[str]) -> Iterable[Check]:
        kind = self.scene.kind
        if kind in ("pitch", "at-bat") and {"pitch", "plate"} & only:
            yield from self._pitch(only)
        outcome = self.trial.case.expected.outcome
        if kind == "at-bat" and "touching" in only and "contact.margin" in self.trial.expected:
            yield from self._touching()
        if kind == "impact" and "touching" in only:
            yield from self._maybe("contact.position", self.scene.incoming.position)
        if "contact.normal" in self.trial.expected and set(COLLISION) & only:
            yield from self._collision(only)
        if outcome in ("batted", "landed", "home_run", "wall") and set(FLYING) & only:
            yield from self._flight(only)

    def _fly_by(self, case: OneCase[float]) -> None:
        """Take note of how exact a flight is."""
        if self.change.engine is ANY_LAW and not is_papers(case.law(case.legs[0].frame)):
            self.exact = False

    # --- the parts, each from what is given ---------------------------------------------------

    def _case(self, scene: Any = None) -> OneCase[float]:
        return OneCase(scene or self.scene, self.change.engine, self.model)

    def has(self, name: str) -> Numbers:
        """Return what the candidate says, or else longball's value, or raise a KeyError."""
        if name in ("contact.time", "contact.position") and name not in self.given:
            _ = self.met
        return self.given.get(name) or self.own[name]

    @cached_property
    def thrown(self) -> tuple[Leg[float], dict[str, Any]]:
        """The pitch, and the plate where it crosses it."""
        case = self._case()
        chain.reach_plate(case)
        self.own |= {k: _tuple(v) for k, v in case.answer.items() if k != "outcome"}
        self._fly_by(case)
        return case.legs[0], case.answer

    @cached_property
    def height(self) -> float:
        """Of the bat's axis, m, from the candidate's own plate."""
        if isinstance(self.scene, ImpactScene):
            return self.scene.incoming.bat_height
        _ = self.thrown
        return self.has("plate.position")[2] + float(self.scene.swing.height_offset)

    @cached_property
    def met(self) -> dict[str, Any]:
        """How the true pitch meets the bat where the candidate's plate puts it."""
        _, plate = self.thrown
        offset = self.height - plate["plate.position"][2]
        swing = self.scene.swing.model_copy(update={"height_offset": offset})
        swung = self.scene.model_copy(update={"swing": swing})
        case = self._case(self.change.meeting(swung))
        _, self.meeting = chain.meet_bat(case)
        for name in ("contact.time", "contact.position", "contact.margin"):
            if name in case.answer:
                self.own.setdefault(name, _tuple(case.answer[name]))
        return case.answer

    @cached_property
    def before(self) -> Numbers:
        """The ball's velocity at the contact, before the impact."""
        if isinstance(self.scene, ImpactScene):
            return self.scene.incoming.velocity
        leg, _ = self.thrown
        if isinstance(self.change.engine, Verlet):  # that of the step before, as printed
            _ = self.met
            if self.meeting is not None:
                return self.meeting.contact.velocity
        time, plate = self._touched(leg), self.given.get("plate.velocity")
        velocity = _at(leg, time)[1]
        if plate is None:
            return velocity
        at = self.given.get("plate.time") or self.own["plate.time"]
        return plus(velocity, 1.0, plus(plate, -1.0, _at(leg, at[0])[1]))

    def _touched(self, leg: Leg[float]) -> float:
        """Return when ball and bat touch, s: of two times the one that the place belongs to."""
        time, place = self.has("contact.time")[0], self.given.get("contact.position")
        if place is None or math.dist(_at(leg, time)[0], place) <= CLOSE:
            return time
        times = time, *_tuple(self.met.get("contact.time", time))
        return min(times, key=lambda t: math.dist(_at(leg, t)[0], place))

    @property
    def spin(self) -> tuple[float, float, float] | None:
        """The ball's spin at the contact, rad/s."""
        if isinstance(self.scene, ImpactScene):
            given = self.scene.incoming.spin
            return None if given is None else _three(given)
        leg, _ = self.thrown
        case, time = self._case(), self.has("contact.time")[0]
        return case.spin_at(leg.frame, case.law(leg.frame), leg.flight.path.at(time))

    # --- the stages -----------------------------------------------------------------------------

    def _pitch(self, only: frozenset[str]) -> Iterable[Check]:
        time, position = self.given.get("plate.time"), self.given.get("plate.position")
        case = self._case()
        if time and position and "plate" not in only and self._lasts(time[0]):
            leg = self._flown_to(case, 0.0, chain.release(case), time[0])
        else:
            leg, plate = self.thrown
            if "plate.time" not in plate:
                return
        if time and position:
            place, velocity = _at(leg, time[0])
            self.flown = leg, time[0], position
            yield self._check("plate.position", place)
            yield from self._maybe("plate.velocity", velocity)
            yield self._event("plate", "plate.position", 0.0, position[0])
        else:
            for name in ("plate.time", "plate.position", "plate.velocity"):
                yield from self._maybe(name, plate[name])

    def _lasts(self, time: float) -> bool:
        """Tell whether a flight may last for a time, s."""
        return bool(0.0 < time <= self.scene.time_limit)

    def _flown_to(
        self, case: OneCase[float], begin: float, begun: tuple[Any, Any, Any], time: float
    ) -> Leg[float]:
        """Return a flight to a time, s; where it ends, which takes as long to find, is not seen."""
        frame, law, start = begun
        leg = Leg(begin, frame, chain.fly(case, law, frame, start, limit=time))
        case.legs.append(leg)
        self._fly_by(case)
        return leg

    def _touching(self) -> Iterable[Check]:
        met, bat = self.met, self.change.meeting(self.scene).bat
        reach = self.scene.ball.radius + bat.radius
        # Where another distance counts as touching, the margin may still be by the true one.
        own = float(met["contact.margin"])
        margins = own, own + self.scene.bat.radius - bat.radius
        said = self.given.get("contact.margin", margins)[0]
        yield from self._maybe("contact.margin", min(margins, key=lambda x: abs(x - said)))
        time, position = self.given.get("contact.time"), self.given.get("contact.position")
        if "contact.time" not in met:
            return
        yield from self._maybe("contact.time", met["contact.time"])
        if position:
            gap = math.hypot(position[0], position[2] - self.height) - reach
            yield self._event("touching", "contact.position", 0.0, gap)
            # In the paper's steps the ball goes to the bat on a line of its own (Appendix B). Where
            # the place is right the time is another matter.
            places = [met["contact.position"]]
            if time and not isinstance(self.change.engine, Verlet):
                places.insert(0, _at(self.thrown[0], time[0])[0])
            place = min(places, key=lambda place: math.dist(_tuple(place), position))
            yield self._check("contact.position", place)

    def _collision(self, only: frozenset[str]) -> Iterable[Check]:
        position = self._contact_position()
        case, before = self._case(), self.before
        x, y, z = _three(position)
        ball = chain.Ball((x, y, z), _three(before), self.spin)
        _, contact = chain.meet(case, ball, (x, z - self.height), 0.0)[:2]
        for key in ("normal", "bat_velocity"):
            self.own[f"contact.{key}"] = _tuple(case.answer[f"contact.{key}"])
            if key == "normal" and self.scene.kind == "at-bat":
                self._take_normal(x, z - self.height)
            yield from self._maybe(f"contact.{key}", self.own[f"contact.{key}"])
        normal, bat = self.has("contact.normal"), self.has("contact.bat_velocity")
        speed = sum((v - b) * n for v, b, n in zip(before, bat, normal, strict=True))
        self.own["contact.normal_speed"] = (speed,)
        yield from self._maybe("contact.normal_speed", speed)
        if not {*COLLISION[3:], *FLYING} & only:
            return
        closing = self.has("contact.normal_speed")[0]
        arm = lever_arm(position[1], self.scene.bat, DOUBLES)
        if contact is None or closing >= 0 or self.trial.case.expected.impact is None:
            return
        said = {"normal": _three(normal), "bat_velocity": _three(bat)}
        yield from self._impact(replace(contact, **said, lever_arm=arm, normal_speed=closing))

    def _take_normal(self, x: float, z: float) -> None:
        """Take the normal divided by R + r_b, if the candidate's is nearer to that."""
        # Where ball and bat do not touch it is no unit vector, and divided so it follows as well.
        reach = self.scene.ball.radius + self.scene.bat.radius
        both = self.own["contact.normal"], (x / reach, 0.0, z / reach)
        said = self.given.get("contact.normal", both[0])
        self.own["contact.normal"] = min(both, key=lambda normal: math.dist(normal, said))

    def _impact(self, contact: ContactState[float]) -> Iterable[Check]:
        struck = self.model.collide(self._case(), contact, 0.0)[1]
        yield from self._maybe("impact.restitution", struck.restitution)
        e = self.given.get("impact.restitution", (struck.restitution,))[0]
        if e != struck.restitution:
            own = self._case(_with_restitution(self.scene, struck.restitution, e))
            struck = self.model.collide(own, contact, 0.0)[1]
        yield from self._maybe("impact.impulse", struck.impulse)
        more = self.given.get("impact.impulse", (struck.impulse,))[0] - struck.impulse
        after = plus(struck.velocity, more / self.scene.ball.mass, contact.normal)
        self.own["impact.velocity"] = after
        yield from self._maybe("impact.velocity", after)
        if struck.friction_margin is not None:
            yield from self._maybe("impact.friction_margin", struck.friction_margin)
        if struck.spin is not None:
            self.own["impact.spin"] = self._spun(contact, struck)
            self.own["contact.spin"] = contact.spin or (0.0, 0.0, 0.0)
            yield from self._maybe("impact.spin", self.own["impact.spin"])
        energy = struck.energy_change
        if self.scene.bat.friction is None:
            energy = self._energy(struck, e, contact.normal_speed)
        yield from self._maybe("impact.energy_change", energy)

    def _energy(self, struck: Any, restitution: float, normal_speed: float) -> float:
        """Return the change of energy by the true μ, or by that of the candidate's own impulse."""
        # The latter's is -J/((1 + ẽ) Ṽ·n). Of the two the one that it comes nearer to counts.
        pushes = [(struck.impulse, struck.restitution)]
        pushes += [(push, restitution) for push in self.given.get("impact.impulse", ())]
        masses = (-push / ((1 + e) * normal_speed) for push, e in pushes)
        follows = [energy_change(mass, restitution, normal_speed) for mass in masses]
        said = self.given.get("impact.energy_change", follows[:1])
        return float(min(follows, key=lambda energy: abs(energy - said[0])))

    def _spun(self, contact: ContactState[float], struck: Any) -> Numbers:
        """Return the spin after the impact, from the candidate's own velocity after it."""
        # Whatever the friction is, angular momentum about the point of contact stays.
        ball = self.scene.ball
        after = self.given.get("impact.velocity", struck.velocity)
        change = _three(plus(after, -1.0, struck.velocity))
        factor = 1 / (inertia_factor(ball, DOUBLES) * ball.radius)
        return plus(struck.spin, -factor, cross(contact.normal, change))

    def _contact_position(self) -> Numbers:
        impact = isinstance(self.scene, ImpactScene)
        return self.scene.incoming.position if impact else self.has("contact.position")

    def _launch(self) -> Launch[float]:
        """Return the launch of the batted ball, from the candidate's own values."""
        if isinstance(self.scene, FlightScene):
            given = self.scene.launch
            spin = None if given.spin is None else _three(given.spin)
            return Launch(given.position, given.velocity, 0.0, 0.0, spin=spin)
        start = _three(self._contact_position())
        hit = {"impact.velocity", "impact.spin"} & set(self.trial.expected)
        if not hit <= set(self.given):
            list(self._collision(frozenset(STAGES)))
        velocity = _three(self.has("impact.velocity"))
        turning = self.given.get("impact.spin") or self.own.get("impact.spin")
        begin = self.has("contact.time")[0]
        spin = None if turning is None else _three(turning)
        launch = Launch(start, velocity, begin, 0.0, spin=spin)
        return self.change.launch(self.scene, launch)

    def _flight(self, only: frozenset[str]) -> Iterable[Check]:
        given, begun, scene = self.given, self._launch(), self.scene
        launch = self._pushed(self._case(), begun)
        hang, time = given.get("landing.hang_time"), given.get("landing.time")
        position = given.get("landing.position")
        since = [hang[0] - launch.delay] if hang else []
        since += [time[0] - launch.time] if time else []
        if position and since:  # no law is followed far beyond what is asked for
            far = min(scene.time_limit, 2 * max(*since, 1.0))
            scene = scene.model_copy(update={"time_limit": far})
        case = self._case(scene)
        here = only.isdisjoint(FLYING[1:]) and position and since
        if here and self._lasts(since[0]) and max(since) - min(since) < 1e-9:
            frame, start = launch_frame(launch.position, launch.velocity, DOUBLES, launch.spin)
            self._flown_to(case, launch.time, (frame, case.law(frame), start), max(since))
        else:
            chain.land(case, launch, "batted")
            self._fly_by(case)
        leg, flown = case.legs[0], None
        if position and since:
            # Of two times that contradict each other the one that the place belongs to counts.
            known = [t for t in since if math.isfinite(sum(_at(leg, t)[0]))]
            flown = min(known or since, key=lambda t: math.dist(_at(leg, t)[0], position))
            if abs(since[0] - since[-1]) < 1e-9:
                since[0] = since[-1] = flown
            place, speed = _at(leg, flown)
            self.flown = leg, flown, position
            there = self._check("landing.position", place)
            yield there
            # Where the place is right the law is, and the velocity is another matter.
            for check in self._maybe("landing.velocity", speed):
                apart = there.follows and "landing velocity" in only
                at_end = not check.follows and there.error < AT_THE_END * check.error * abs(flown)
                yield check if apart or at_end else replace(check, stage="flight")
            yield from self._decay(case, leg, flown, there)
        elif "landing.time" in case.answer:
            for name in ("landing.position", "landing.velocity", "landing.hang_time"):
                yield from self._maybe(name, case.answer[name], "flight")
        yield from self._fence(case, leg, launch.time)
        if position and since:
            floor = landing_height(self.scene)
            yield self._event("landing", "landing.position", floor, position[2])
        if time and hang and position and flown == since[-1] != since[0]:
            yield self._check("landing.hang_time", time[0] - begun.time, "time")
        elif time and hang:
            yield self._check("landing.time", begun.time + hang[0])
        elif time and not position and "landing.time" in case.answer:
            yield self._check("landing.time", case.answer["landing.time"], "flight")
        if position:
            x, y, _ = position
            if self.scene.reading.distance_origin == "launch":
                x, y = x - launch.position[0], y - launch.position[1]
            yield from self._maybe("landing.distance", math.hypot(x, y))
        elif "landing.distance" in case.answer:
            yield from self._maybe("landing.distance", case.answer["landing.distance"], "flight")

    def _decay(
        self, case: OneCase[float], leg: Leg[float], flown: float, there: Check
    ) -> Iterable[Check]:
        """Yield how the spin falls along the candidate's own path, or else till its own landing."""
        # Where the landing does not follow, neither does the path: it may be as far off.
        if leg.frame.spin is None:
            return
        state: Any = leg.flight.path.at(max(flown, 0.0))
        off = 0.0 if there.follows else there.error / there.scale
        path = self.given.get("landing.path")
        if path and hasattr(state, "path") and self.scene.reading.spin_decay == "path":
            check = self._check("landing.path", state.path)
            yield replace(check, tolerance=check.tolerance + off * check.scale)
            state, off = state._replace(path=path[0]), 0.0
        # On the ground, so that it comes from above where the wind sets in at that height.
        landed = case.ground(state).place(state)
        spin = case.spin_at(leg.frame, case.law(leg.frame), landed)
        for check in self._maybe("landing.spin", spin or ()):
            yield replace(check, tolerance=check.tolerance + off * check.scale)

    def _fence(self, case: OneCase[float], leg: Leg[float], begin: float) -> Iterable[Check]:
        """Yield where the ball is at the candidate's own time, and what the fence is there."""
        fence, time = self.scene.fence, self.given.get("fence.time")
        position = self.given.get("fence.position")
        if fence is None:
            return
        if not (time and position):
            for name in [n for n in self.given if n.startswith("fence.") and n in case.answer]:
                yield self._check(name, case.answer[name])
            return
        place, velocity = _at(leg, time[0] - begin)
        yield self._check("fence.position", place)
        yield from self._maybe("fence.velocity", velocity)
        x, y, z = position
        if fence.polyline is None:
            off, top, margin = math.hypot(x, y) - fence.radius, 0.0, list[float]()
        else:
            sides = (_beside(chord, x, y) for chord in chords(fence.polyline, DOUBLES))
            off, top, *margin = min(sides, key=lambda found: abs(found[0]))
        yield self._event("fence", "fence.position", 0.0, off)
        above = z - top
        if self.scene.reading.fence_clearance == "surface":
            above -= self.scene.ball.radius
        yield from self._maybe("fence.clearance", above)
        for end in margin:
            yield from self._maybe("fence.margin", end)

    def _pushed(self, case: OneCase[float], launch: Launch[float]) -> Launch[float]:
        """Return where the ball is set free, if the bat pushes for two steps."""
        engine = self.change.engine
        if not (self.change.push and isinstance(engine, Stepped) and self.scene.kind == "at-bat"):
            return launch
        _ = self.met
        if self.meeting is None:
            return launch
        pitch, touch = self.meeting.approach.pitch, self.meeting.approach.touch
        delta_v, ground = plus(launch.velocity, -1.0, self.before), case.ground(pitch.start)
        return engine.rebound(pitch.frame, touch, _three(delta_v), case.law, ground)

    # --- checks ---------------------------------------------------------------------------------

    def _tolerance(self, quantity: str, expected: Numbers) -> float:
        """Return what rounding may do to a quantity, and few digits to what follows from it."""
        size, own = self.trial.bounds.get(quantity.partition(":")[0], (0.0, 0.0))
        # Numbers handed on have been rounded: a few hundred half ulps, where the truth has none.
        rounding = 1e-12 if self.exact else ANY_LAW_ERROR
        large = max(1.0, size, math.hypot(*expected))
        few = self.trial.cut_off(large)
        slip = self.trial.slips.get(quantity, HANDED_ON * few) if self.trial.coarse else 0.0
        return max(SLACK * own, rounding * large, self.trial.granted) + few + slip

    def _check(self, quantity: str, follows: Any, stage: str = "") -> Check:
        """Return a quantity beside what follows; its stage is the usual one if not given."""
        obtained, expected = self.given[quantity], _tuple(follows)
        self.own[quantity] = expected
        scale = max(self.trial.bounds.get(quantity, (0.0, 0.0))[0], 1e-3)
        tolerance = self._tolerance(quantity, expected)
        return Check(stage or stage_of(quantity), quantity, expected, obtained, tolerance, scale)

    def _maybe(self, quantity: str, follows: Any, stage: str = "") -> Iterable[Check]:
        if quantity in self.given:
            yield self._check(quantity, follows, stage)

    def _event(self, stage: str, quantity: str, expected: float, obtained: float) -> Check:
        tolerance = self._tolerance(f"{quantity}: event", ())
        return Check(stage, f"{quantity}: event", (expected,), (obtained,), tolerance, 1.0)


def _at(leg: Leg[float], time: float) -> tuple[Numbers, Numbers]:
    """Return position and velocity at a time of a leg, s, or just before it; NaN beyond it."""
    path = leg.flight.path
    try:
        if time < 0:
            piece = next(path.pieces())
            state = piece.at(max(time, -piece.length))
        else:
            state = path.at(time)
    except (ArithmeticError, ValueError):
        return NOWHERE, NOWHERE
    return leg.frame.position(state), leg.frame.velocity(state)


NOWHERE = (math.nan, math.nan, math.nan)


def _beside(chord: Chord[float], x: float, y: float) -> tuple[float, float, float]:
    """Return the distance from a chord, m, the fence's height there, and the way to its end."""
    a, b = chord.a[2], chord.b[2]
    along, aside, length = along_chord(chord, x, y)
    beyond = max(0.0, -along, along - length)
    off = math.copysign(math.hypot(aside, beyond), aside)
    return off, a + (b - a) * along / length, min(along, length - along)


def along_chord(chord: Chord[float], x: float, y: float) -> tuple[float, float, float]:
    """Return how far along a chord a place is, how far to its right, and the chord's length, m."""
    (ax, ay, _), (bx, by, _) = chord.a, chord.b
    length = math.hypot(bx - ax, by - ay)
    along = ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length
    return along, ((x - ax) * (by - ay) - (y - ay) * (bx - ax)) / length, length


def _with_restitution(scene: Any, known: float, wanted: float) -> Any:
    """Return a scene whose ẽ is another one than that it has: ẽ is e + r (1 + e) for some r."""
    ball = scene.ball
    r = (known - ball.restitution) / (1 + ball.restitution)
    other = ball.model_copy(update={"restitution": (wanted - r) / (1 + r)})
    return scene.model_copy(update={"ball": other})


def _tuple(value: Any) -> Numbers:
    return tuple(map(float, value)) if isinstance(value, tuple) else (float(value),)


def _three(values: Any) -> tuple[float, float, float]:
    x, y, z = map(float, values)
    return x, y, z


def with_values(scene: Scene, values: Mapping[str, Any]) -> Any:
    """Return a scene with other values, as they are: no one who errs validates them."""
    # What the scene does not have stays out.
    changed: Any = scene
    for name, value in values.items():
        changed = _put(changed, re.findall(r"\w+", name), value)
    return changed


def _put(held: Any, way: Sequence[str], value: Any) -> Any:
    if not way:
        return value
    key, *rest = way
    if isinstance(held, tuple):
        i = int(key)
        return (*held[:i], _put(held[i], rest, value), *held[i + 1 :])
    if not hasattr(held, key):
        return held
    return held.model_copy(update={key: _put(getattr(held, key), rest, value)})
