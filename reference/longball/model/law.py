"""The law of motion: what accelerates a ball in flight.

A flight has a frame of its own: s along the horizontal direction of the launch, y to the left of
it, z up; u, v, w are the components of the velocity. The law is one function, `acceleration`,
traced into straight-line code (`longball.model.trace`): what the scene does not name is not in it,
and neither is a direction in which nothing moves the ball. A flight whose forces lie in the
vertical plane of its launch is flown in that plane, in four variables; one with other forces in
space, in six. Where spin decays, a further component is the path or the time along which it
decays.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, KeysView, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from types import SimpleNamespace
from typing import Any, NamedTuple

from longball.model import trace
from longball.model.air import (
    DRAG_LAWS,
    LIFT_LAWS,
    BySpeed,
    BySpin,
    ConstantDrag,
    ConstantLift,
    Flow,
    by_spin,
    law_name,
)
from longball.model.atmosphere import (
    ROUGHNESS,
    density,
    earth_strengths,
    speed_of_sound,
    wind,
    wind_strengths,
)
from longball.model.block import Block
from longball.model.numbers import N, Numbers, Vector, present
from longball.model.trace import ZERO, Node, Program
from longball.model.vectors import cross, minus, norm, part_across, plus, scaled


class PlaneState(NamedTuple):
    """Position and velocity in the vertical plane of a flight: m, m, m/s, m/s."""

    s: N
    z: N
    u: N
    w: N


class SpaceState(NamedTuple):
    """Position and velocity in the frame of a flight: m, m, m, m/s, m/s, m/s."""

    s: N
    y: N
    z: N
    u: N
    v: N
    w: N


# One of these, or one with further components behind them; see `state_of_variables`.
State = Any


@cache
def state_of_variables(variables: tuple[str, ...]) -> Callable[..., Any]:
    """Return the class of the states with these components."""
    for known in (PlaneState, SpaceState):
        if variables == known._fields:
            return known
    return namedtuple("State", variables)


def in_plane(state: Any) -> bool:
    """True if a state is one in the vertical plane of a flight."""
    return not hasattr(state, "y")


# --- the law --------------------------------------------------------------------------------------


class Motion(NamedTuple):
    """Variables of a force, in the frame of the flight.

    Attributes
    ----------
    position
        m.
    velocity
        Over the ground, m/s.
    air
        What drag depends on.
    lift
        What lift depends on: the same, unless the reading keeps the wind from the lift.
    density
        Of the air, relative to that at height 0.
    spin_left
        Size of the spin, relative to that at launch.
    """

    position: Vector
    velocity: Vector
    air: Flow
    lift: Flow
    density: Any
    spin_left: Any

    @property
    def speed(self) -> Any:
        """The airspeed, m/s."""
        return self.air.speed


def acceleration(p: Strengths, motion: Motion) -> Vector:
    """Return ``ρ/ρ_0 (-k C_D U u + k R (C_L/S) ω × u + k C_S U² ê) - g e_z - 2 Ω × v``, and more.

    u is the velocity through the air, ω the spin at launch, S the spin parameter of what is left of
    it, ê the direction of the side force; ``k = ρ_0 A / (2 m)``. The rest is what `forces` add.
    """
    air, lift = motion.air, motion.lift
    drag = p.shape.drag.drag(_Keys(p, "drag"), air)  # k C_D U
    magnus = p.shape.lift.lift(_Keys(p, "lift"), lift)  # k R C_L/S
    earth = p.earth_s, p.earth_y, p.earth_z
    # The order of the sum is part of the law: another one changes last bits in every engine.
    total = scaled(-(motion.density * drag), air.velocity)
    total = plus(total, scaled(motion.density * magnus, lift.across))
    total = plus(total, scaled(motion.density, side_force(p, lift)))
    total = plus(total, (ZERO, ZERO, -p.gravity))
    # Coriolis acts on the velocity over the ground. The centrifugal force is part of g.
    total = plus(total, scaled(-2.0, cross(earth, motion.velocity)))
    for force in p.shape.forces:
        total = plus(total, force(motion, p.given))
    return total


def side_force(p: Strengths, flow: Flow) -> Vector:
    """Return ``k C_S U² ê``, with ê along the part of a fixed unit vector d that is across u.

    That part is ``d - (d·u) u/U²``, of the size ``|d × u|/U``.
    """
    sine = norm(_aside(p, flow))
    if p.side is ZERO or sine is ZERO:
        return ZERO, ZERO, ZERO
    direction = p.side_s, p.side_y, p.side_z
    # U² ê = (U² d - (d·u) u) U/|d × u|, since |U² d - (d·u) u| = U |d × u|.
    whole = part_across(direction, flow.velocity, flow.speed * flow.speed)
    return scaled(p.side * (flow.speed / sine), whole)


def _aside(p: Strengths, flow: Flow) -> Vector:
    """Return ``d × u`` of the direction d of the side force, which is 0 where that has none."""
    return cross((p.side_s, p.side_y, p.side_z), flow.velocity)


def motion_of(p: Strengths, position: Vector, velocity: Vector, path: Any) -> Motion:
    """Return the motion through the air, with the spin that is left after a `path`."""
    through = minus(velocity, wind(p, position[2]))
    # The decay goes by the air that passes the ball, under any reading of the wind.
    left = _spin_left(p, path, _size(p, through))
    spin, size = (p.spin_s, p.spin_y, p.spin_z), p.spin
    air = _flow(p, through, left, spin, size)
    if not p.shape.spins:
        # The paper's lift: about an axis fixed at launch, as backspin has it. It is level and
        # points to the right, so that ê × u turns a level velocity upwards.
        spin, size = (ZERO, trace.constant(-1.0), ZERO), trace.constant(1.0)
    lift = _flow(p, velocity if p.shape.wind_acts_on == "drag" else through, left, spin, size)
    # e^(-z/H), which is not constant along a flight; the strength is 1/H
    thin = 1.0 if p.thinning is ZERO else trace.exp(-p.thinning * position[2])
    return Motion(position, velocity, air, lift, thin, left)


def _flow(p: Strengths, velocity: Vector, left: Any, spin: Vector, size: Any) -> Flow:
    """Return the motion through the air, from the spin at launch and the fraction that is left."""
    speed, across = _size(p, velocity), cross(spin, velocity)
    # |ω × u|: the root is shared by drag and lift.
    turning = norm(across)  # ω_T U
    # ω_T, ω_T U, and top and bottom of ω_T/U: of all the spin, and of its part across the velocity.
    whole = size, size * speed, size, speed
    part = turning / speed, turning, turning, speed * speed
    # All of it is across a flight in its plane, if it is perpendicular to that; and so is an axis
    # that the scene does not name.
    level = (spin[0] is ZERO and spin[2] is ZERO and velocity[1] is ZERO) or not p.shape.spins
    _, of_drag, _, _ = whole if level or p.shape.drag_spin == "total" else part
    rate, _, top, bottom = whole if level or p.shape.spin_parameter == "total" else part
    return Flow(velocity, speed, across, left * of_drag, rate, top, bottom, p.radius * left)


def _size(p: Strengths, velocity: Vector) -> Any:
    """Return the size of a velocity: straight up or down, without a root."""
    # √(w²) has no derivative at w = 0, ±w has: vertical flights turn there.
    moving = [component for component in velocity if component is not ZERO]
    return p.sense * moving[0] if len(moving) == 1 else norm(velocity)


def _spin_left(p: Strengths, path: Any, speed: Any) -> Any:
    """Return the size of the spin, relative to that at launch.

    ``ω' = -(U/L_ω) ω`` has e^(-path/L_ω) of the path through the air; e^(-t/τ) is the same of a
    path at a fixed speed. With e^(-t U/L_ω) of the present U, ω solves no equation of its own, but
    the law of motion with it is one in (r, v, t), and solved as such: the path is t times 1 m/s.
    """
    if p.decay is ZERO:
        return 1.0
    exponent = -p.decay * path
    if p.shape.spin_decay == "nathan":
        exponent = -(p.decay / p.decay_speed) * (path * speed)
    return p.auxiliary_for(trace.exp(exponent))


# --- what a law is traced with --------------------------------------------------------------------


class Force(NamedTuple):
    """A force besides those of the model.

    Attributes
    ----------
    strengths
        From a scene, the `longball.model.frame.Frame` of a flight and a number system to the values
        of its parameters, by name; None if the scene does not name the force.
    acceleration
        From the `Motion` and an object with the parameters as attributes to the acceleration, m/s².
    """

    strengths: Callable[[Any, Any, Numbers], Mapping[str, Any] | None]
    acceleration: Callable[[Motion, Any], Vector]


class Shape(NamedTuple):
    """Choices of a scene that decide its law's operations; its numbers are strengths."""

    # The laws of the coefficients
    drag: Any = ConstantDrag
    lift: Any = ConstantLift
    spins: bool = False  # whether the scene says how the ball spins
    # Readings
    spin_parameter: str = "transverse"
    drag_spin: str = "transverse"
    spin_decay: str = "path"
    wind_acts_on: str = "both"
    forces: tuple[Callable[[Motion, Any], Vector], ...] = ()


class Strengths:
    """The strengths of a law as nodes, by name; one that has no value is zero."""

    sense: Node  # of a vertical flight; see `Law.straight`

    def __init__(self, shape: Shape, names: tuple[str, ...], polynomial: bool = False) -> None:
        self.shape = shape
        self.given = SimpleNamespace(**{name: trace.parameter(name) for name in names})
        self.polynomial = polynomial
        self.auxiliary: dict[str, Node] = {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self.given, name, ZERO)

    def auxiliary_for(self, value: Node) -> Node:
        """Return an exponential or a logarithm, or the variable that stands for it."""
        # The Taylor engines and the proofs handle sums, products, quotients and roots. An
        # exponential becomes a variable with an equation of its own.
        if not self.polynomial or value.static:
            return value
        name = next(
            (n for n, x in self.auxiliary.items() if x is value),
            f"{value.kind}_{len(self.auxiliary)}",
        )
        self.auxiliary[name] = value
        return trace.variable(name)


class _Keys:
    """The strengths of a coefficient, under the keys of its law."""

    def __init__(self, p: Strengths, coefficient: str) -> None:
        self._strengths, self._coefficient = p, coefficient

    def __getattr__(self, key: str) -> Any:
        return getattr(self._strengths, _strength(self._coefficient, key))


def _strength(coefficient: str, key: str) -> str:
    """Return the name of a number of a coefficient as a strength."""
    return coefficient if key == "value" else f"{coefficient}_{key}"


@dataclass(frozen=True, eq=False)
class _Traced:
    """Traced parts of a law."""

    rates: Mapping[str, Node]  # of the variables, by name
    spin_left: Node  # the size of the spin, relative to that at launch
    # Top and bottom of what passes the thresholds, by `Switch.of`
    passed: Mapping[str, tuple[Node, Node]]
    # The auxiliary variables, which stand for exponentials and logarithms, by name: each in terms
    # of the variables before it.
    auxiliary: Mapping[str, Node]
    aside: Vector  # see `_aside`


@cache
def _traced(shape: Shape, names: tuple[str, ...], moving: str, polynomial: bool) -> _Traced:
    """Trace the law where the ball moves in space, in a vertical plane, or vertically.

    Vertically in the air, that is, with which it drifts. See `Law.polynomial`.
    """
    p = Strengths(shape, names, polynomial)
    s, y, z, u, v, w = map(trace.variable, "syzuvw")
    # In the plane of the launch nothing moves the ball aside.
    if moving != "space":
        y = v = ZERO
    if moving == "vertical":
        p.sense = trace.parameter(_SENSE)
        # A vertical flight in a wind drifts with it, so that no air comes from the side. No flight
        # drifts with a profile, whose wind changes with the height.
        u, v = (p.wind_s, p.wind_y) if p.roughness is ZERO else (ZERO, ZERO)
    motion = motion_of(p, (s, y, z), (u, v, w), trace.variable("path"))
    rates = dict(zip("syzuvw", (u, v, w, *acceleration(p, motion)), strict=True))
    if p.decay is not ZERO:
        # Time readings have a path of fixed speed: 44.704 m/s (100 mph), or 1 m/s under `nathan`.
        fixed = shape.spin_decay != "path"
        rates["path"] = trace.as_node(p.decay_speed if fixed else motion.speed)
    passed = {"wind": (z, trace.constant(1.0))}
    for of, law, flow in (("drag", shape.drag, motion.air), ("lift", shape.lift, motion.lift)):
        if hasattr(law, "passed"):
            top, bottom = map(trace.as_node, law.passed(flow))
            passed[of] = top, bottom
    aside = _aside(p, motion.lift)
    if p.side is not ZERO:
        # The sine of the angle between d and u, squared: the force has no direction at 0.
        size, speed = norm(aside), motion.lift.speed
        passed["side"] = size * size, speed * speed
    # Where y is exp x, y' is y x'; where it is log x, y' is e^-y x', which is 1/x x' without a
    # singularity that small errors of x come near to.
    for name, value in p.auxiliary.items():
        (x,), y = value.args, trace.variable(name)
        grows = trace.total(
            trace.derivative(x, trace.variable(v), ratio="quotient") * rate
            for v, rate in rates.items()
        )
        rates[name] = (y if value.kind == "exp" else trace.exp(-y)) * grows
    return _Traced(rates, trace.as_node(motion.spin_left), passed, p.auxiliary, aside)


def _is_polynomial(node: Node) -> bool:
    nodes = Program((), (), (node,)).nodes
    return all(n.static or n.kind in ("variable", "sum", "product") for n in nodes)


# What must not change.
_STILL = {"space": "", "plane": "yv", "vertical": "uv"}


@cache
def _program(
    shape: Shape,
    names: tuple[str, ...],
    moving: str,
    polynomial: bool,
    variables: tuple[str, ...] = (),
) -> Program | None:
    """Return the program of a law; None if a force drives the ball out of where it holds."""
    rates = _traced(shape, names, moving, polynomial).rates
    # A law that drives the ball aside does not hold in the plane.
    if any(rates[name] is not ZERO for name in _STILL[moving]):
        return None
    # Further variables stand behind the six: the path of the decay, exponentials, logarithms.
    variables = variables or (*("syzuvw" if moving == "space" else "szuw"), *[*rates][6:])
    if rates["y"] is not ZERO and "y" not in variables:
        return None
    program = Program(variables, names, tuple(rates[name] for name in variables))
    # Only a vertical flight with a speed in its law needs to know its sense.
    if trace.parameter(_SENSE) in program.nodes:
        program = replace(program, parameters=(*names, _SENSE))
    return program


def _code(
    shape: Shape, names: tuple[str, ...], in_space: bool = False, polynomial: bool = False
) -> Program:
    """Return the program of a law in the plane, if it holds there and is not to be in space."""
    program = None if in_space else _program(shape, names, "plane", polynomial)
    program = program or _program(shape, names, "space", polynomial)
    assert program is not None
    return program


@lru_cache(maxsize=1024)
def _switching_function(program: Program, top: Node, bottom: Node) -> Program:
    # top/bottom passes the threshold where this is zero; nothing is divided.
    value = top - trace.parameter("threshold") * bottom
    return replace(program, outputs=(value,), parameters=(*program.parameters, "threshold"))


@lru_cache(maxsize=1024)
def _value(program: Program, node: Node) -> Program:
    return replace(program, outputs=(node,))


@cache
def _jacobian(program: Program) -> Program:
    return program.jacobian()


_SENSE = "sense"


# --- the law of a scene ---------------------------------------------------------------------------


class Switch(NamedTuple):
    """A part of a law, whose strengths change where a function of the state passes a threshold."""

    of: str  # the wind, the coefficient of drag or lift, or the side force
    # below the first threshold, between two, beyond the last
    strengths: tuple[Mapping[str, N], ...] = ({},)
    thresholds: tuple[N, ...] = ()  # in rising order; without any it is no switch
    question: str = ""  # whether a threshold is passed, as a clause

    @property
    def names(self) -> KeysView[str]:
        """The strengths that change."""
        return dict.fromkeys(name for strengths in self.strengths for name in strengths).keys()

    @property
    def ends_law(self) -> bool:
        """True if the law ends at its threshold, below which the side force has no direction."""
        return self.of == "side"

    @property
    def is_wind(self) -> bool:
        """True if it is the wind: where that changes, airspeeds jump."""
        return self.of == "wind"


@dataclass(frozen=True)
class Law:
    """The law of motion of a scene.

    Where parts of it have several forms, no number is computed by the law itself, but by
    `on(branches)`, with the branches that are valid in the state at hand.

    Attributes
    ----------
    code
        The rates of change of a state, component by component; of a law without a form, those of
        all forms at once, which only tell the variables.
    strengths
        Values of the program's parameters, by name; without a form, not those of `switches`.
    shape
        What the program was traced from.
    switches
        The parts that have several forms.
    form
        Which branch each of them has; None: the law has no form, or needs none.
    polynomial
        Whether each exponential and logarithm that a switch may depend on is a variable of its own,
        so that where the form changes is the zero of a polynomial in the variables.
    """

    code: Program
    strengths: Mapping[str, N]
    shape: Shape
    switches: tuple[Switch, ...] = ()
    form: tuple[int, ...] | None = None
    polynomial: bool = False

    @property
    def program(self) -> Program:
        """The rates of change of a state, component by component.

        Raises `TypeError` if parts have several forms and none is chosen.
        """
        if self.switches and self.form is None:
            raise TypeError("parts of this law have several forms: ask law.on(branches)")
        return self.code

    @property
    def variables(self) -> tuple[str, ...]:
        """The components of a state, the same in all forms."""
        return self.code.variables

    @property
    def state(self) -> Callable[..., Any]:
        """The class of the states: `PlaneState`, `SpaceState`, or one with more components."""
        return state_of_variables(self.variables)

    @property
    def gravity(self) -> N | None:
        """g, m/s²; None where there is none."""
        return self.strengths.get("gravity")

    @property
    def is_paper(self) -> bool:
        """True if nothing acts but the paper's drag, lift and gravity."""
        return self.shape == Shape() and self.strengths.keys() <= {*PAPER} and not self.switches

    @property
    def switches_of_spin(self) -> frozenset[int]:
        """The numbers of the switches on whose branches the size of the spin depends."""
        nodes = Program((), (), (self._traced.spin_left,)).nodes
        used = {node.args[0] for node in nodes if node.kind == "parameter"}
        return frozenset(which for which, switch in enumerate(self.switches) if switch.names & used)

    @property
    def _traced(self) -> _Traced:
        moving = "space" if "y" in self.variables else "plane"
        return _traced(self.shape, self.code.parameters, moving, self.polynomial)

    # Other laws.

    def on(self, branches: Sequence[int]) -> Law:
        """Return the law with these forms of the parts that have several."""
        # Strengths of other branches go first: a branch may lack a strength that another has.
        changed = {name for switch in self.switches for name in switch.names}
        strengths = {name: x for name, x in self.strengths.items() if name not in changed}
        for switch, branch in zip(self.switches, branches, strict=True):
            strengths |= switch.strengths[branch]
        code = _code(self.shape, tuple(strengths), "y" in self.variables, self.polynomial)
        return replace(self, code=code, strengths=strengths, form=tuple(branches))

    def without(self, strength: str) -> Law:
        """Return the law without one of its strengths."""
        strengths = {name: x for name, x in self.strengths.items() if name != strength}
        names = tuple(name for name in self.code.parameters if name != strength)
        code = _code(self.shape, names, "y" in self.variables, self.polynomial)
        return replace(self, code=code, strengths=strengths)

    def straight(self, sense: N) -> Law | None:
        """Return the law of a vertical flight; `sense` is 1 on the way up and -1 on the way down.

        The ball drifts with the wind, as it starts; up and down are through the air. The speed is
        ``sense w`` there, without a square root: this law is smooth where the ball comes to rest,
        and holds on one side of it. None if a force drives the ball aside.
        """
        names, variables = self.program.parameters, self.variables
        code = _program(self.shape, names, "vertical", self.polynomial, variables)
        if code is None:
            return None
        return replace(self, code=code, strengths={**self.strengths, _SENSE: sense})

    def in_polynomials(self) -> Law:
        """Return the law with variables for what switches depend on; see `completed`."""
        # In all forms the arguments of the switches have the same functions.
        first = self.on([0] * len(self.switches))
        passed = first._traced.passed
        if all(_is_polynomial(node) for switch in self.switches for node in passed[switch.of]):
            return self
        law = replace(self, polynomial=True)
        return replace(law, code=law.on(first.form or ()).code)

    # Numbers.

    def rates(self, numbers: Numbers) -> Callable[..., tuple[N, ...]]:
        """Return the function from the components of a state to their rates."""
        return self.program.bind(self.strengths, numbers.functions)

    def jacobian(self, numbers: Numbers) -> Callable[..., tuple[N, ...]]:
        """Return the function from the components of a state to the rates' partial derivatives."""
        return _jacobian(self.program).bind(self.strengths, numbers.functions)

    def state_of(self, start: State) -> State:
        """Return a launch as a state of this law."""
        nothing = start.s * 0
        return self.state(*(getattr(start, name, nothing) for name in self.variables))

    def completed(self, state: State, numbers: Numbers) -> State:
        """Return a state whose exponentials and logarithms are those of this form.

        They depend on the wind: where it sets in, they jump with the airspeed.
        """
        state = self.state_of(state)
        for name, node in self._traced.auxiliary.items():
            state = state._replace(**{name: self._value(node, state, numbers)})
        return state

    def spin_left(self, state: State, numbers: Numbers) -> N:
        """Return the size of the spin in a state, relative to that at launch."""
        return self._value(self._traced.spin_left, state, numbers)

    def aside(self, state: State, numbers: Numbers) -> Vector:
        """Return ``d × u`` of the direction d of a side force, m/s.

        It is zero where the force has no direction.
        """
        a, b, c = (self._value(node, state, numbers) for node in self._traced.aside)
        return a, b, c

    def _value(self, node: Node, state: State, numbers: Numbers) -> N:
        bound = _value(self.program, node).bind(self.strengths, numbers.functions)
        return bound(*(getattr(state, name) for name in self.variables))[0]

    def drift(self, nothing: N) -> Vector:
        """Return the wind, m/s, where it is the same in all of a form: `nothing`, if none blows."""
        known = {} if ROUGHNESS in self.strengths else self.strengths
        s, y, z = (known.get(name, nothing) for name in ("wind_s", "wind_y", "wind_z"))
        return s, y, z

    def switching_function(self, switch: Switch) -> Program:
        """Return a program that is positive where what a switch depends on is beyond a threshold.

        It has the law's variables and parameters, and the parameter `threshold`.
        """
        return _switching_function(self.program, *self._traced.passed[switch.of])

    def beyond(self, switch: Switch, threshold: N, numbers: Numbers) -> Callable[[Any], Any]:
        """Return a function of the state that is positive beyond a threshold of a switch."""
        known = {**self.strengths, "threshold": threshold}
        bound = self.switching_function(switch).bind(known, numbers.functions)
        return lambda state: bound(*state)[0]

    def branches(self, state: Any, numbers: Numbers) -> list[Any]:
        """Return which forms the parts have in a state, or in many: by the thresholds passed.

        The numbers carry no radius.
        """

        def passed(form: Law) -> list[Any]:
            counts = []
            for switch in self.switches:
                values = (form.beyond(switch, x, numbers)(state) for x in switch.thresholds)
                counts.append(sum((value > 0 for value in values), start=0))
            return counts

        winds = [switch.is_wind for switch in self.switches]
        below = passed(self.on([0] * len(winds)))
        if not any(winds):
            return below
        # Above the height where the wind sets in, the others depend on another airspeed.
        above, more = below[winds.index(True)], passed(self.on([*map(int, winds)]))
        return [
            above if is_wind else less * (1 - above) + above * beyond
            for is_wind, less, beyond in zip(winds, below, more, strict=True)
        ]

    def at(self, state: Any, numbers: Numbers) -> Law:
        """Return the law in the form valid in a state, whose numbers carry no radius."""
        return self.on([*map(int, self.branches(state, numbers))]) if self.switches else self


PAPER = "drag", "lift", "gravity"  # the strengths of its law


def law_of(scene: Any, frame: Any, numbers: Numbers, forces: Sequence[Force] = ()) -> Law:
    """Return the law of motion of a flight.

    Parameters
    ----------
    scene
        With ball, air, gravity and reading: a scene, or any object with these attributes, whose
        numbers may be arrays of shape (n,), of n scenes.
    frame : longball.model.frame.Frame
        Of the flight, with its spin.
    numbers : longball.model.numbers.Numbers
        That the law computes with.
    forces
        What may act on the ball besides what the model has.

    Returns
    -------
    Law
        In the vertical plane of the launch, if its forces lie there; in space otherwise.

    Examples
    --------
    >>> from longball.model.frame import launch_frame
    >>> from longball.model.numbers import DOUBLES
    >>> from longball.model.scene import FlightScene, Launch
    >>> scene = FlightScene(launch=Launch(position=(0, 0, 1), velocity=(30, 0, 20)))
    >>> frame, start = launch_frame((0.0, 0.0, 1.0), (30.0, 0.0, 20.0), DOUBLES)
    >>> law = law_of(scene, frame, DOUBLES)
    >>> law.variables, [*law.strengths]
    (('s', 'z', 'u', 'w'), ['drag', 'lift', 'gravity'])
    >>> [round(rate, 6) for rate in law.rates(DOUBLES)(*start)]  # m/s, m/s, m/s², m/s²
    [30.0, 20.0, -10.799295, -11.149912]
    """
    shape = Shape()
    parts: list[Switch] = []
    others: dict[str, N] = {}
    if scene.air is not None:
        shape, parts, others = _in_air(scene, frame, numbers)
    switches = [part for part in parts if part.thresholds]
    strengths = {
        n: x for part in parts if not part.thresholds for n, x in part.strengths[0].items()
    }
    if not numbers.absent(scene.gravity):
        strengths["gravity"] = numbers.exact(scene.gravity)
    strengths |= others | earth_strengths(scene, frame, numbers)
    acting = []
    for force in forces:
        its = force.strengths(scene, frame, numbers)
        if its is not None:
            acting.append(force.acceleration)
            strengths |= its
    if acting:
        shape = shape._replace(forces=tuple(acting))
    # The variables are the same on all branches: those of space, if one of them needs those.
    names = dict.fromkeys([*strengths, *(name for switch in switches for name in switch.names)])
    return Law(_code(shape, tuple(names)), strengths, shape, tuple(switches))


def law_with(
    strengths: Mapping[str, N], forces: Sequence[Callable[[Motion, Any], Vector]] = ()
) -> Law:
    """Return the paper's law with some of its strengths, and what is zero left out, and forces."""
    shape = Shape(forces=tuple(forces))
    return Law(_code(shape, tuple(strengths)), strengths, shape)


def _in_air(scene: Any, frame: Any, numbers: Numbers) -> tuple[Shape, list[Switch], dict[str, N]]:
    """Return the shape of a scene's law, its parts, and strengths of spin and density."""
    air, reading, exact = scene.air, scene.reading, numbers.exact
    spins = frame.spin is not None and not all(map(numbers.absent, frame.spin))
    # the coefficients
    drag_law, drag = _coefficient("drag", scene, spins, numbers)
    # A ball that does not spin has no lift, but for the paper's, whose axis no scene names.
    lift_law: Any = ConstantLift
    lift: Switch = Switch("lift")
    if spins or (frame.spin is None and not by_spin(air.lift_coefficient)):
        lift_law, lift = _coefficient("lift", scene, spins, numbers)
    parts, shape = [drag, lift], Shape(drag_law, lift_law)
    # wind and side force: each may end the form of the law on the way
    strengths: dict[str, N] = {}
    if air.wind is not None:
        shape = shape._replace(wind_acts_on=reading.wind_acts_on)
        question = "the ball passes the height above which the wind blows"
        parts.append(Switch("wind", *wind_strengths(scene, frame, numbers), question))
    if air.side_coefficient is not None:
        side = side_strengths(scene, frame, numbers)
        strengths |= side
        if side:
            question = "the airspeed turns along air.side_coefficient.direction"
            parts.append(Switch("side", ({}, {}), (numbers.exact(ALONG) * ALONG,), question))
    # the spin, as a vector in the frame and by its size, and what is left of it
    if frame.spin is not None:
        shape = shape._replace(
            spins=True,
            spin_parameter=reading.spin_parameter,
            drag_spin=reading.drag_spin,
            spin_decay=reading.spin_decay,
        )
    if spins:
        x, y, z = frame.spin
        s, left, up = frame.turned(frame.spin)
        strengths |= present({"spin_s": s, "spin_y": left, "spin_z": up}, numbers)
        strengths["spin"] = numbers.sqrt(x * x + y * y + z * z)
        strengths["radius"] = exact(scene.ball.radius)
    if frame.spin is not None and air.spin_decay_length is not None:
        strengths["decay"] = 1 / exact(air.spin_decay_length)
        if reading.spin_decay != "path":
            strengths["decay_speed"] = exact(PATH_SPEEDS[reading.spin_decay])
    if air.density_scale_height is not None:
        strengths["thinning"] = 1 / exact(air.density_scale_height)
    return shape, parts, strengths


# m/s, of a path in which spin decays that is not the ball's. A decay in time is quoted as one along
# a path that is flown at 100 mph.
PATH_SPEEDS = {"time": 44.704, "nathan": 1.0}


# The sine of the angle between the airspeed and the direction of a side force at which the force is
# said to have no direction. A thousandth of it is lost to rounding in doubles.
ALONG = 2.0**-20


def side_strengths(scene: Any, frame: Any, numbers: Numbers) -> dict[str, N]:
    """Return ``k C_S`` of a side force, 1/m, and its direction as a unit vector."""
    given = scene.air.side_coefficient
    strength = per_metre(scene, given.value, numbers)
    if strength is None:
        return {}
    s, y, z = frame.components(given.direction, numbers)
    size = numbers.sqrt(s * s + y * y + z * z)
    unit = {"side_s": s / size, "side_y": y / size, "side_z": z / size}
    return {"side": strength} | present(unit, numbers)


def per_metre(scene: Any, value: float, numbers: Numbers) -> N | None:
    """Return ``k C = ρ C A / (2 m)``, 1/m, for a value of a coefficient; None if it is zero."""
    if numbers.absent(value) or numbers.absent(scene.air.density):
        return None
    radius, mass = numbers.exact(scene.ball.radius), numbers.exact(scene.ball.mass)
    area = numbers.pi * radius * radius
    return density(scene, numbers) * numbers.exact(value) * area / (2 * mass)


def _coefficient(of: str, scene: Any, spins: bool, numbers: Numbers) -> tuple[Any, Switch]:
    """Return the law of the coefficient of drag or lift, and its strengths."""
    given, laws = getattr(scene.air, f"{of}_coefficient"), DRAG_LAWS if of == "drag" else LIFT_LAWS
    # Of columns there is but the name.
    law: Any = type(given) if isinstance(given, Block) else laws[law_name(given)]
    if hasattr(law, "lines"):
        return _lines(of, given, scene, spins, numbers)
    linear: dict[str, N] = {}
    others: dict[str, N] = {}
    for key in _keys(law):
        value = getattr(given, key, given)
        if key in law.nonlinear:
            others[_strength(of, key)] = numbers.exact(value)
        elif (strength := per_metre(scene, value, numbers)) is not None:
            linear[_strength(of, key)] = strength
    if not linear:
        return laws["constant"], Switch(of)
    return law, Switch(of, (linear | present(others, numbers),))


@cache
def _keys(law: Any) -> tuple[str, ...]:
    """Return the keys of the numbers of a law."""
    return tuple(key for key in law.model_fields if key != "law")


def _lines(of: str, given: Any, scene: Any, spins: bool, numbers: Numbers) -> tuple[Any, Switch]:
    """Return the law of a coefficient that is linear between nodes; see `_coefficient`."""
    unit = per_metre(scene, 1.0, numbers)
    if unit is None:
        return ConstantDrag if of == "drag" else ConstantLift, Switch(of)
    law = BySpin if given.of == "spin_parameter" else BySpeed
    nodes: Sequence[N] = ()
    lines: Sequence[tuple[N, N]]
    if law is BySpin and not spins:
        # The value at S = 0. The nodes do not matter; in columns, they are not those of a block.
        lines = [(numbers.exact(given.values[0]), numbers.exact(0.0))]
    else:
        nodes, lines = given.lines(numbers.exact)
    if given.of == "mach":
        sound = speed_of_sound(scene, numbers)
        nodes = tuple(node * sound for node in nodes)
        lines = tuple((at_0, slope / sound) for at_0, slope in lines)
    at_0, slope = _strength(of, "at_0"), _strength(of, "slope")
    strengths = tuple(present({at_0: unit * x, slope: unit * y}, numbers) for x, y in lines)
    thresholds = tuple(node * node for node in nodes)
    return law, Switch(of, strengths, thresholds, f"{law.passes} passes a node of a table")
