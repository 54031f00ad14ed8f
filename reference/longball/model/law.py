"""The law of motion: what accelerates a ball in flight.

Each term is one function over any kind of number, and the strengths that a scene gives it
(`longball.model.force`). The law of a scene is their sum, traced into straight-line code
(`longball.model.trace`): a term that the scene does not name is not in it, and neither is a
direction in which nothing moves the ball. A flight whose forces lie in the vertical plane of its
launch is flown in that plane, in four variables; one with other forces in space, in six. Where spin
decays, there is one more: what it decays along.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from types import SimpleNamespace
from typing import Any, Generic, NamedTuple

from longball.model import trace
from longball.model.aerodynamics import CRISIS, DECAYS, DRAG, LIFT, SPIN_TERMS, TABLES, spin_across
from longball.model.atmosphere import THINNING
from longball.model.earth import CORIOLIS
from longball.model.force import (
    Branches,
    Decay,
    Drag,
    Flow,
    Force,
    Lift,
    Motion,
    Piecewise,
    Term,
    Thinning,
    Wind,
    plus,
    scaled,
    size,
)
from longball.model.numbers import N, Numbers, Vector
from longball.model.trace import ZERO, Node, Program
from longball.model.wind import UNIFORM, WINDS, WINDS_ABOVE


class PlaneState(NamedTuple, Generic[N]):
    """Position and velocity in the vertical plane of a flight: m, m, m/s, m/s."""

    s: N
    z: N
    u: N
    w: N


class SpaceState(NamedTuple, Generic[N]):
    """Position and velocity in the frame of a flight: m, m, m, m/s, m/s, m/s."""

    s: N
    y: N
    z: N
    u: N
    v: N
    w: N


# Others have further components behind these; see `state_of_variables`.
State = PlaneState[N] | SpaceState[N]


@cache
def state_of_variables(variables: tuple[str, ...]) -> Callable[..., Any]:
    """Return the class of the states with these components."""
    for known in (PlaneState, SpaceState):
        if variables == known._fields:
            return known
    return namedtuple("State", variables)


def in_plane(state: Any) -> bool:
    """Tell whether a state is one in the vertical plane of a flight."""
    return not hasattr(state, "y")


# --- the terms ------------------------------------------------------------------------------------


def _weight(scene: Any, frame: Any, numbers: Numbers[N]) -> tuple[N] | None:
    return None if numbers.absent(scene.gravity) else (numbers.exact(scene.gravity),)


def _gravity(motion: Motion, p: Any) -> Vector[Any]:
    """Return ``-g e_z``."""
    return ZERO, ZERO, -p.gravity


GRAVITY = Force(("gravity",), _weight, _gravity)

PAPER: tuple[Term, ...] = (DRAG, LIFT, GRAVITY)
FORCES: tuple[Term, ...] = (
    *PAPER,
    *(CRISIS, *SPIN_TERMS, *DECAYS, *WINDS, THINNING, CORIOLIS, *TABLES, *WINDS_ABOVE),
)


# --- the law of a scene ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Law(Generic[N]):
    """The law of motion of a scene.

    Where terms have several forms, no number is computed by the law itself, but by `on(branches)`,
    with the branches that are valid in the state at hand.

    Attributes
    ----------
    code
        The rates of change of a state, component by component; of a law without a form, those of
        all forms of its terms at once, which only tell the variables.
    strengths
        Values of the program's parameters, by name; without a form, not those of `bends`.
    forces
        What the program was traced from.
    bends
        The terms that have several forms.
    form
        Which branch each of them has; None: the law has no form, or needs none.
    polynomial
        Whether each exponential and logarithm that a bend may depend on is a variable of its own,
        so that where the form changes is the zero of a polynomial in the variables.
    """

    code: Program
    strengths: Mapping[str, N]
    forces: tuple[Term, ...]
    bends: tuple[Bend[N], ...] = ()
    form: tuple[int, ...] | None = None
    polynomial: bool = False

    @property
    def program(self) -> Program:
        """The rates of change of a state, component by component.

        Raises `TypeError` if terms have several forms and none is chosen.
        """
        if self.bends and self.form is None:
            raise TypeError("terms of this law have several forms: ask law.on(branches)")
        return self.code

    @property
    def variables(self) -> tuple[str, ...]:
        """The components of a state, the same in all forms."""
        return self.code.variables

    @property
    def state(self) -> Callable[..., Any]:
        """The class of the states: `PlaneState`, `SpaceState`, or one with more components."""
        return state_of_variables(self.variables)

    def state_of(self, start: State[N]) -> State[N]:
        """Return a launch as a state of this law."""
        nothing = start.s * 0
        state: State[N] = self.state(*(getattr(start, name, nothing) for name in self.variables))
        return state

    def in_polynomials(self) -> Law[N]:
        """Return the law with what bends depend on as variables; see `polynomial`, `completed`."""
        first = [0] * len(self.bends)  # of all forms the arguments have the same functions
        if all(map(self.on(first)._is_polynomial, self.bends)):
            return self
        law = replace(self, polynomial=True)
        return replace(law, code=law.on(first).code)

    def completed(self, state: State[N], numbers: Numbers[N]) -> State[N]:
        """Return a state whose exponentials and logarithms are those of this form.

        They depend on the wind: where it sets in, they jump with the airspeed.
        """
        state = self.state_of(state)
        for name, value in self._traced.made.items():
            made = self._value(value, numbers)(*state)
            state = state._replace(**{name: made})
        return state

    def _is_polynomial(self, bend: Bend[N]) -> bool:
        nodes = self.passage(bend).nodes
        return all(n.kind in ("variable", "sum", "product") for n in nodes if not n.static)

    def spin_left(self, state: State[N], numbers: Numbers[N]) -> N:
        """Return the size of the spin in a state, relative to that at launch."""
        known = (getattr(state, name) for name in self.program.variables)
        found: N = self._value(self._traced.spin_left, numbers)(*known)
        return found

    @property
    def bends_of_spin(self) -> frozenset[int]:
        """The numbers of the bends on whose branches the size of the spin depends."""
        nodes = Program((), (), (self._traced.spin_left,)).nodes
        used = {node.args[0] for node in nodes if node.kind == "parameter"}
        return frozenset(
            which
            for which, bend in enumerate(self.bends)
            if not used.isdisjoint(bend.piecewise.term.parameters)
        )

    @property
    def _traced(self) -> _Traced:
        motion = "space" if "y" in self.variables else "plane"
        return _traced(self.forces, self.code.parameters, motion, self.polynomial)

    def _value(self, node: Node, numbers: Numbers[N]) -> Callable[..., N]:
        """Return the function from the components of a state to the value of a node."""
        bound = _value(self.program, node).bind(self.strengths, numbers.functions)
        return lambda *state: bound(*state)[0]

    @property
    def gravity(self) -> N | None:
        """g, m/s²; None where there is none."""
        return self.strengths.get("gravity")

    def rates(self, numbers: Numbers[N]) -> Callable[..., tuple[N, ...]]:
        """Return the function from the components of a state to their rates."""
        return self.program.bind(self.strengths, numbers.functions)

    def jacobian(self, numbers: Numbers[N]) -> Callable[..., tuple[N, ...]]:
        """Return the function from the components of a state to the rates' partial derivatives."""
        return _jacobian(self.program).bind(self.strengths, numbers.functions)

    def on(self, branches: Sequence[int]) -> Law[N]:
        """Return the law with these forms of the terms that have several."""
        switched = {name for bend in self.bends for name in bend.piecewise.term.parameters}
        strengths = {n: x for n, x in self.strengths.items() if n not in switched}
        terms = [f for f in self.forces if switched.isdisjoint(f.parameters)]
        for bend, branch in zip(self.bends, branches, strict=True):
            term = bend.piecewise.term
            strengths |= _named(term, bend.branches.strengths[branch])
            terms.append(term)
        law = law_with(strengths, tuple(terms), "y" in self.variables, self.polynomial)
        return replace(law, bends=self.bends, form=tuple(branches))

    def passage(self, bend: Bend[N]) -> Program:
        """Return a program that is positive where a bend's argument is beyond a level.

        It has the law's variables and parameters, and the parameter `level`.
        """
        return _passage(self.program, self._traced, bend.piecewise)

    def beyond(self, bend: Bend[N], level: N, numbers: Numbers[N]) -> Callable[[Any], Any]:
        """Return a function of the state that is positive where an argument is beyond a level."""
        known = {**self.strengths, "level": level}
        bound = self.passage(bend).bind(known, numbers.functions)
        return lambda state: bound(*state)[0]

    def branches(self, state: Any, numbers: Numbers[N]) -> list[Any]:
        """Return which forms the terms have in a state, or in many: by the levels passed.

        The numbers carry no radius.
        """
        return self._branching(numbers)(state)

    def _branching(self, numbers: Numbers[N]) -> Callable[[Any], list[Any]]:
        """Return the function from a state to the forms that the terms have there."""
        blowing = [bend.blows for bend in self.bends]

        def passed(form: Law[N]) -> list[list[Callable[[Any], Any]]]:
            return [[form.beyond(b, x, numbers) for x in b.branches.levels] for b in self.bends]

        def counted(passages: list[list[Callable[[Any], Any]]], state: Any) -> list[Any]:
            return [sum((value(state) > 0 for value in each), start=0) for each in passages]

        calm = passed(self.on([0] * len(blowing)))
        aloft = passed(self.on([int(blows) for blows in blowing])) if any(blowing) else []

        def branches(state: Any) -> list[Any]:
            below = counted(calm, state)
            if not aloft:
                return below
            above = below[blowing.index(True)]
            return [
                above if blows else less * (1 - above) + above * more
                for blows, less, more in zip(blowing, below, counted(aloft, state), strict=True)
            ]

        return branches

    def pointwise(self, numbers: Numbers[N]) -> Callable[..., tuple[N, ...]]:
        """Return the function from a state to its rates, each in the form valid there.

        The numbers carry no radius.
        """
        if not self.bends:
            return self.rates(numbers)
        branches = self._branching(numbers)
        forms: dict[tuple[int, ...], Callable[..., tuple[N, ...]]] = {}

        def rates(*state: N) -> tuple[N, ...]:
            there = tuple(map(int, branches(self.state(*state))))
            if there not in forms:
                forms[there] = self.on(there).rates(numbers)
            return forms[there](*state)

        return rates

    def without(self, force: Term) -> Law[N]:
        """Return the law without a force, or what has its parameters in its place."""
        kept = tuple(f for f in self.forces if not {*f.parameters} & {*force.parameters})
        names = {name for f in kept for name in f.parameters}
        strengths = {n: x for n, x in self.strengths.items() if n in names}
        parameters = tuple(name for name in self.code.parameters if name in names)
        code = _code(kept, parameters, "y" in self.variables, self.polynomial)
        return replace(self, code=code, strengths=strengths, forces=kept)

    def straight(self, sense: N) -> Law[N] | None:
        """Return the law of a vertical flight; `sense` is 1 on the way up and -1 on the way down.

        The ball drifts with the wind, as it starts; up and down are through the air. The speed is
        ``sense w`` there, without a square root: this law is smooth where the ball comes to rest,
        and holds on one side of it. None if a force drives the ball aside.
        """
        vertical = _program(
            self.forces, self.program.parameters, "vertical", self.polynomial, self.variables
        )
        if vertical is None:
            return None
        return replace(self, code=vertical, strengths={**self.strengths, "sense": sense})

    def drift(self, nothing: N) -> Vector[N]:
        """Return the wind, m/s, where it is the same in all of a form: `nothing`, if none blows."""
        s, y, z = (
            next((self.strengths[name] for name in names if name in self.strengths), nothing)
            for names in zip(*UNIFORM, strict=True)
        )
        return s, y, z


@dataclass(frozen=True)
class Bend(Generic[N]):
    """A term that has several forms, with its branches in a scene."""

    piecewise: Piecewise
    branches: Branches

    @property
    def blows(self) -> bool:
        """Whether the term is a wind: where its form changes, airspeeds jump."""
        return isinstance(self.piecewise.term, Wind)


def law_of(
    scene: Any, frame: Any, numbers: Numbers[N], forces: tuple[Term, ...] = FORCES
) -> Law[N]:
    """Return the law of motion of a flight in a frame, of a scene with ball, air and gravity."""
    strengths: dict[str, N] = {}
    acting: list[Term] = []
    bends: list[Bend[N]] = []
    for force in forces:
        if isinstance(force, Piecewise):
            branches = force.branches(scene, frame, numbers)
            if branches is not None and branches.levels:
                bends.append(Bend(force, branches))
            elif branches is not None:  # one form: a table of the spin parameter, without spin
                acting.append(force.term)
                strengths |= _named(force.term, branches.strengths[0])
            continue
        values = force.strengths(scene, frame, numbers)
        if values is not None:
            acting.append(force)
            strengths |= _named(force, values)
    law = law_with(strengths, tuple(acting))
    if not bends:
        return law
    # The variables are the same on all branches: those of space, if one of them needs those.
    of_all = dict(strengths)
    for bend in bends:
        acting.append(bend.piecewise.term)
        for values in bend.branches.strengths:
            of_all |= _named(bend.piecewise.term, values)
    return replace(law_with(of_all, tuple(acting)), strengths=strengths, bends=tuple(bends))


def _named(term: Term, values: tuple[Any, ...]) -> dict[str, Any]:
    """Return the strengths of a term by name, without those that are zero."""
    known = zip(term.parameters, values, strict=True)
    return {name: value for name, value in known if value is not None}


def law_with(
    strengths: Mapping[str, N],
    forces: tuple[Term, ...] = FORCES,
    in_space: bool = False,
    polynomial: bool = False,
) -> Law[N]:
    """Return the law of those forces whose parameters have values.

    It is that in the plane, if it holds there and is not to be that `in_space`. A parameter without
    a value, beside others that have one, is zero. See `Law.polynomial`.
    """
    acting = tuple(f for f in forces if any(name in strengths for name in f.parameters))
    code = _code(acting, tuple(strengths), in_space, polynomial)
    return Law(code, strengths, acting, polynomial=polynomial)


def _code(
    forces: tuple[Term, ...], names: tuple[str, ...], in_space: bool, polynomial: bool
) -> Program:
    """Return the program of a law in the plane, if it holds there and is not to be in space."""
    program = None if in_space else _program(forces, names, "plane", polynomial)
    program = program or _program(forces, names, "space", polynomial)
    assert program is not None
    return program


@dataclass(frozen=True, eq=False)
class _Traced:
    """What is traced of a law."""

    rates: Mapping[str, Node]  # of the variables, by name
    further: tuple[str, ...]  # the variables besides positions and velocities
    spin_left: Any  # the size of the spin, relative to that at launch
    # What it was traced with.
    motion: Motion
    parameters: Any
    # What the variables are that stand for exponentials and logarithms, by name: each in terms of
    # the variables before it.
    made: Mapping[str, Node] = field(default_factory=dict)


@cache
def _traced(
    forces: tuple[Term, ...], names: tuple[str, ...], motion: str, polynomial: bool
) -> _Traced:
    """Trace the law where the ball moves in space, in a vertical plane, or vertically.

    Vertically in the air, that is, with which it drifts. See `Law.polynomial`.
    """
    known = {name: trace.parameter(name) for name in names}
    named = {name for force in forces for name in force.parameters}
    named |= {name for names in UNIFORM for name in names}
    p = SimpleNamespace(**{**dict.fromkeys(named, ZERO), **known})
    s, y, z, u, v, w = map(trace.variable, "syzuvw")
    if motion != "space":
        y = v = ZERO
    if motion == "vertical":
        u, v, _ = (trace.total(vars(p)[x] for x in names) for names in zip(*UNIFORM, strict=True))
    path = trace.variable("path")
    position, velocity = (s, y, z), (u, v, w)
    calm = _flow(velocity)
    air, lift = calm, calm
    density: Any = 1.0
    spin_left: Any = 1.0
    for term in forces:
        match term:
            case Wind():
                wind = term.velocity(position, p)
                through = plus(air.velocity, scaled(-1.0, wind))
                if motion == "vertical" and wind[:2] == (u, v):
                    through = ZERO, ZERO, through[2]
                air = _flow(through)
                lift = air if term.lifts else lift
            case Thinning():
                density = density * term.density(position, p)
    further: dict[str, Node] = {}
    moving = Motion(position, velocity, air, lift, density, spin_left)
    for term in forces:
        if isinstance(term, Decay):
            further = {"path": trace.as_node(term.rate(moving, p))}
            moving = moving._replace(spin_left=term.left(path, air.speed, p))
    total: Vector[Any] = (ZERO, ZERO, ZERO)
    if drags := [term.rate(moving, p) for term in forces if isinstance(term, Drag)]:
        total = scaled(-(density * trace.total(drags)), air.velocity)
    if lifts := [term.factor(moving, p) for term in forces if isinstance(term, Lift)]:
        factor = density * trace.total(lifts)
        total = plus(total, scaled(factor, spin_across(lift, p)))
    for term in forces:
        if isinstance(term, Force):
            total = plus(total, term.acceleration(moving, p))
    rates = dict(zip("syzuvw", (*velocity, *total), strict=True)) | further
    traced = _Traced(rates, tuple(further), trace.as_node(moving.spin_left), moving, p)
    return _in_polynomials(traced) if polynomial else traced


def _in_polynomials(traced: _Traced) -> _Traced:
    """Return a law whose exponentials and logarithms in winds and spin are variables.

    Where y is exp x, y' is y x'; where it is log x, y' is e^-y x', which is 1/x x' without a
    singularity that small errors of x come near to.
    """
    made: dict[str, Node] = {}
    variables: dict[Node, Node] = {}

    def known(value: Node) -> Node:
        return variables.get(value, value)

    def added(value: Node) -> Node:
        if value not in variables and not value.static:
            name = f"{value.kind}_{len(made)}"
            made[name], variables[value] = value, trace.variable(name)
        return known(value)

    motion = traced.motion
    parts = (*motion.air.velocity, *motion.lift.velocity, traced.spin_left)
    a, b, c, u, v, w, spin_left = trace.again(parts, added)
    air, lift = _flow((a, b, c)), _flow((u, v, w))
    rates = dict(zip(traced.rates, trace.again(traced.rates.values(), known), strict=True))
    for name, value in made.items():
        (x,) = value.args
        changes = (trace.derivative(x, trace.variable(v)) * r for v, r in rates.items())
        (grows,) = trace.again([trace.total(changes)], known)
        y = trace.variable(name)
        rates[name] = (y if value.kind == "exp" else trace.exp(-y)) * grows
    return replace(
        traced, rates=rates, further=(*traced.further, *made), spin_left=spin_left, made=made,
        motion=motion._replace(air=air, lift=lift, spin_left=spin_left),
    )  # fmt: skip


# What must not change.
_STILL = {"space": "", "plane": "yv", "vertical": "uv"}


@cache
def _program(
    forces: tuple[Term, ...],
    names: tuple[str, ...],
    motion: str,
    polynomial: bool,
    variables: tuple[str, ...] = (),
) -> Program | None:
    """Return the program of a law; None if a force drives the ball out of where it holds."""
    traced = _traced(forces, names, motion, polynomial)
    if any(traced.rates[name] is not ZERO for name in _STILL[motion]):
        return None
    variables = variables or (*("syzuvw" if motion == "space" else "szuw"), *traced.further)
    if traced.rates["y"] is not ZERO and "y" not in variables:
        return None
    program = Program(variables, names, tuple(traced.rates[name] for name in variables))
    if trace.parameter(_SENSE) in program.nodes:
        program = replace(program, parameters=(*names, _SENSE))
    return program


@lru_cache(maxsize=1024)
def _passage(program: Program, traced: _Traced, piecewise: Piecewise) -> Program:
    top, bottom = piecewise.argument(traced.motion, traced.parameters)
    value = trace.as_node(top) - trace.parameter("level") * bottom
    return replace(program, outputs=(value,), parameters=(*program.parameters, "level"))


@lru_cache(maxsize=1024)
def _value(program: Program, node: Node) -> Program:
    return replace(program, outputs=(node,))


_SENSE = "sense"


def _flow(velocity: Vector[Any]) -> Flow:
    moving = [component for component in velocity if component is not ZERO]
    if len(moving) == 1:
        return Flow(velocity, trace.parameter(_SENSE) * moving[0])
    return Flow(velocity, size(velocity))


@cache
def _jacobian(program: Program) -> Program:
    return program.jacobian()
