"""The law of motion: what accelerates a ball in flight.

Each flight has its own frame: s along the horizontal direction of the launch, y to the left of
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
    BySpeed,
    BySpin,
    ConstantDrag,
    ConstantLift,
    Flow,
    by_spin,
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
from longball.model.numbers import (
    N,
    Numbers,
    Vector,
    cross,
    minus,
    part_across,
    plus,
    present,
    scaled,
)
from longball.model.trace import ZERO, Node, Program


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
    """True if a state is in the vertical plane of its flight."""
    return not hasattr(state, "y")


# --- the law --------------------------------------------------------------------------------------


class Motion(NamedTuple):
    """Variables of a force, in the frame of the flight.

    Attributes
    ----------
    position
        Position, m.
    velocity
        Velocity over the ground, m/s.
    air
        Arguments of drag.
    lift
        Arguments of lift: the same, unless under the reading the wind does not act on lift.
    density
        Density of the air, relative to that at height 0.
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
        """Airspeed, m/s."""
        return self.air.speed


def acceleration(p: Strengths, motion: Motion) -> Vector:
    """Return ``ρ/ρ_0 (-k C_D U u + k R (C_L/S) ω × u + k C_S U² ê) - g e_z - 2 Ω × v``, and more.

    u is the velocity through the air, ω the spin at launch, S the spin parameter of the decayed
    spin, ê the direction of the side force; ``k = ρ_0 A / (2 m)``. Added `forces` are included.
    """
    air, lift = motion.air, motion.lift
    drag = p.shape.drag.drag(_Keys(p, "drag"), air)  # k C_D U
    magnus = p.shape.lift.lift(_Keys(p, "lift"), lift)  # k R C_L/S
    earth = p.earth_s, p.earth_y, p.earth_z
    # The order of the sum is fixed: another order would change the last bits in every engine.
    total = scaled(-(motion.density * drag), air.velocity)
    total = plus(total, scaled(motion.density * magnus, lift.across))
    # ê is along the component of a fixed unit vector d across u, ``d - (d·u) u/U²``, of the size
    # |d × u|/U. So U² ê = (U² d - (d·u) u) U/|d × u|.
    sine = _norm(_aside(p, lift))
    if p.side is not ZERO and sine is not ZERO:
        direction = p.side_s, p.side_y, p.side_z
        whole = part_across(direction, lift.velocity, lift.speed * lift.speed)
        side = scaled(p.side * (lift.speed / sine), whole)
        total = plus(total, scaled(motion.density, side))
    total = plus(total, (ZERO, ZERO, -p.gravity))
    # Coriolis acts on the velocity over the ground. The centrifugal force is part of g.
    total = plus(total, scaled(-2.0, cross(earth, motion.velocity)))
    for force in p.shape.forces:
        total = plus(total, force(motion, p.given))
    return total


def _aside(p: Strengths, flow: Flow) -> Vector:
    """Return ``d × u`` of the vector d of the side force; it is 0 if the force has no direction."""
    return cross((p.side_s, p.side_y, p.side_z), flow.velocity)


def motion_of(p: Strengths, position: Vector, velocity: Vector, path: Any) -> Motion:
    """Return the motion through the air, with the spin after a `path`."""
    through = minus(velocity, wind(p, position[2]))

    # the size of the spin, relative to that at launch
    # ``ω' = -(U/L_ω) ω`` has the solution e^(-path/L_ω), with the path through the air under every
    # reading of the wind. e^(-t/τ) is the same with a path at a fixed speed. Under `nathan`,
    # e^(-t U/L_ω) depends on the present U, so ω follows no differential equation: the law of
    # motion evaluates it from (r, v, t), and t is a path at 1 m/s.
    left: Any = 1.0
    if p.decay is not ZERO:
        exponent = -p.decay * path
        if p.shape.spin_decay == "nathan":
            exponent = -(p.decay / p.decay_speed) * (path * _size(p, through))
        left = p.auxiliary_for(trace.exp(exponent))

    # the flow about the ball, for drag and for lift
    spin, size = (p.spin_s, p.spin_y, p.spin_z), p.spin
    air = _flow(p, through, left, spin, size)
    if not p.shape.spins:
        # The paper's lift has an axis ê that is fixed at launch, horizontal and to the right. It is
        # the axis of backspin: ê × u turns a horizontal velocity upwards.
        spin, size = (ZERO, trace.constant(-1.0), ZERO), trace.constant(1.0)
    lift = _flow(p, velocity if p.shape.wind_acts_on == "drag" else through, left, spin, size)
    # e^(-z/H); the strength `thinning` is 1/H
    thin = 1.0 if p.thinning is ZERO else trace.exp(-p.thinning * position[2])
    return Motion(position, velocity, air, lift, thin, left)


def _flow(p: Strengths, velocity: Vector, left: Any, spin: Vector, size: Any) -> Flow:
    """Return the motion through the air, from the spin at launch and its remaining fraction."""
    speed, across = _size(p, velocity), cross(spin, velocity)
    # |ω × u|: the root is shared by drag and lift.
    turning = _norm(across)  # ω_T U
    # ω_T, ω_T U, and numerator and denominator of ω_T/U: for the whole spin, and for the transverse
    # one.
    whole = size, size * speed, size, speed
    part = turning / speed, turning, turning, speed * speed
    # In a flight in its plane, a spin perpendicular to the plane is transverse as a whole, and so
    # is the axis of the paper's lift. The size is then a constant, without a square root.
    level = (spin[0] is ZERO and spin[2] is ZERO and velocity[1] is ZERO) or not p.shape.spins
    _, of_drag, _, _ = whole if level or p.shape.drag_spin == "total" else part
    rate, _, top, bottom = whole if level or p.shape.spin_parameter == "total" else part
    return Flow(velocity, speed, across, left * of_drag, rate, top, bottom, p.radius * left)


def _size(p: Strengths, velocity: Vector) -> Any:
    """Return the size of a velocity; for a vertical one, without a root."""
    # Vertical flights turn round at w = 0, where √(w²) has no derivative, but ±w has.
    moving = [component for component in velocity if component is not ZERO]
    return p.sense * moving[0] if len(moving) == 1 else _norm(velocity)


def _norm(a: Vector) -> Node:
    """Return ``|a|`` of a vector of nodes, in the form that `trace.squares` recognises."""
    # A sum of squares under a root has bounded derivatives; see `trace.derivative`.
    squared = trace.total(trace.square(x) for x in a if x is not ZERO)
    return squared if squared is ZERO else trace.sqrt(squared)


# --- tracing --------------------------------------------------------------------------------------


class Force(NamedTuple):
    """A force in addition to those of the model.

    Attributes
    ----------
    strengths
        Function of a scene, the `longball.model.frame.Frame` of a flight and a number system. It
        returns the values of the parameters, by name, or None if the scene has no such force.
    acceleration
        Function of the `Motion` and an object with the parameters as attributes. It returns the
        acceleration, m/s².
    """

    strengths: Callable[[Any, Any, Numbers], Mapping[str, Any] | None]
    acceleration: Callable[[Motion, Any], Vector]


class Shape(NamedTuple):
    """Choices of a scene that decide its law's operations; its numbers are strengths."""

    # Laws of the coefficients.
    drag: Any = ConstantDrag
    lift: Any = ConstantLift
    spins: bool = False  # True if the scene gives the ball's spin
    # Readings.
    spin_parameter: str = "transverse"
    drag_spin: str = "transverse"
    spin_decay: str = "path"
    wind_acts_on: str = "both"
    forces: tuple[Callable[[Motion, Any], Vector], ...] = ()
    # Is every exponential and logarithm that a switch may depend on an auxiliary variable? A
    # switching event is then the zero of a polynomial in the variables.
    polynomial: bool = False


class Strengths:
    """The strengths of a law as nodes, by name; a missing one is zero."""

    sense: Node  # of a vertical flight; see `Law.straight`

    def __init__(self, shape: Shape, names: tuple[str, ...]) -> None:
        self.shape = shape
        self.given = SimpleNamespace(**{name: trace.parameter(name) for name in names})
        self.auxiliary: dict[str, Node] = {}

    def __getattr__(self, name: str) -> Any:
        # Terms with a factor ZERO disappear from the trace: absent forces cost nothing.
        return getattr(self.given, name, ZERO)

    def auxiliary_for(self, value: Node) -> Node:
        """Return an exponential or a logarithm, or the auxiliary variable in its place."""
        # Events of the proofs must be polynomials of the variables. An exponential therefore
        # becomes a variable with its own equation.
        if not self.shape.polynomial or value.static:
            return value
        name = next(
            (n for n, x in self.auxiliary.items() if x is value),
            f"{value.kind}_{len(self.auxiliary)}",
        )
        self.auxiliary[name] = value
        return trace.variable(name)


class _Keys:
    """Strengths of a coefficient, as attributes with the keys of its law."""

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
    # Numerator and denominator of the quantity that passes the thresholds, by `Switch.of`.
    passed: Mapping[str, tuple[Node, Node]]
    # Exponentials and logarithms that have auxiliary variables, by name, each in terms of the
    # variables before it.
    auxiliary: Mapping[str, Node]
    aside: Vector  # see `_aside`


@cache
def _traced(shape: Shape, names: tuple[str, ...], moving: str) -> _Traced:
    """Trace the law of a ball that moves in space, in a vertical plane, or vertically.

    A vertical flight is vertical relative to the air, with which it drifts.
    """
    p = Strengths(shape, names)
    s, y, z, u, v, w = map(trace.variable, "syzuvw")
    # In the plane of the launch, the sideways position and velocity are zero.
    if moving != "space":
        y = v = ZERO
    if moving == "vertical":
        p.sense = trace.parameter(_SENSE)
        # A vertical flight drifts with a constant wind, so that no air comes from the side. It
        # cannot drift with a profile, whose wind changes with the height.
        u, v = (p.wind_s, p.wind_y) if p.roughness is ZERO else (ZERO, ZERO)
    motion = motion_of(p, (s, y, z), (u, v, w), trace.variable("path"))
    rates = dict(zip("syzuvw", (u, v, w, *acceleration(p, motion)), strict=True))
    if p.decay is not ZERO:
        # Readings by time have a path with a fixed speed: 44.704 m/s (100 mph), or 1 m/s
        # (`nathan`).
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
        size, speed = _norm(aside), motion.lift.speed
        passed["side"] = size * size, speed * speed
    # Equations of the auxiliary variables: y' = y x' for y = exp x, and y' = e^-y x' for y = log x.
    # The form x'/x of the latter has a singularity, which errors of x could reach.
    for name, value in p.auxiliary.items():
        (x,), y = value.args, trace.variable(name)
        grows = trace.total(
            trace.derivative(x, trace.variable(v), ratio="quotient") * rate
            for v, rate in rates.items()
        )
        rates[name] = (y if value.kind == "exp" else trace.exp(-y)) * grows
    return _Traced(rates, trace.as_node(motion.spin_left), passed, p.auxiliary, aside)


# Components that must be constant for a law in the plane, and for a vertical one.
_STILL = {"space": "", "plane": "yv", "vertical": "uv"}


@cache
def _program(
    shape: Shape, names: tuple[str, ...], moving: str, variables: tuple[str, ...] = ()
) -> Program | None:
    """Return the program of a law; None if a force drives the ball out of the plane or line."""
    rates = _traced(shape, names, moving).rates
    # The law in the plane is valid only if no force points out of it.
    if any(rates[name] is not ZERO for name in _STILL[moving]):
        return None
    # Behind the six components: the path of the decay, exponentials, logarithms.
    variables = variables or (*("syzuvw" if moving == "space" else "szuw"), *[*rates][6:])
    if rates["y"] is not ZERO and "y" not in variables:
        return None
    program = Program(variables, names, tuple(rates[name] for name in variables))
    # The sense is a parameter only if the law contains the speed of a vertical flight.
    if trace.parameter(_SENSE) in program.nodes:
        program = replace(program, parameters=(*names, _SENSE))
    return program


def _code(shape: Shape, names: tuple[str, ...], in_space: bool = False) -> Program:
    """Return the program of a law: in the plane if it is valid there, unless `in_space`."""
    program = None if in_space else _program(shape, names, "plane")
    program = program or _program(shape, names, "space")
    assert program is not None
    return program


@lru_cache(maxsize=1024)
def _value(program: Program, node: Node, *parameters: str) -> Program:
    return replace(program, outputs=(node,), parameters=(*program.parameters, *parameters))


_SENSE = "sense"


# --- the law of a scene ---------------------------------------------------------------------------


class Switch(NamedTuple):
    """A part of a law whose strengths change where a function of the state passes a threshold."""

    of: str  # "wind", "drag", "lift" or "side"
    # Of each branch: below the first threshold, between two, beyond the last.
    strengths: tuple[Mapping[str, N], ...] = ({},)
    thresholds: tuple[N, ...] = ()  # increasing; without thresholds there is one branch
    question: str = ""  # the passing of a threshold as a clause, for messages

    @property
    def names(self) -> KeysView[str]:
        """The strengths that change."""
        return dict.fromkeys(name for strengths in self.strengths for name in strengths).keys()

    @property
    def ends_law(self) -> bool:
        """True if the law ends at the threshold: the side force has no direction below it."""
        return self.of == "side"

    @property
    def is_wind(self) -> bool:
        """True for the wind, at whose threshold the airspeed jumps."""
        return self.of == "wind"


@dataclass(frozen=True)
class Law:
    """The law of motion of a scene.

    If it has switches, numbers are computed by `on(branches)`, with the branches that are valid in
    the present state, not by the law itself.

    Attributes
    ----------
    code
        Program for the rates of change of a state. Before a branch is chosen, it contains the
        strengths of all branches, and only its variables are used.
    strengths
        Values of the program's parameters, by name; without branches, not those of `switches`.
    shape
        Choices with which the program was traced.
    switches
        Parts with several branches.
    form
        Chosen branch of each switch; None if none is chosen, or there are no switches.
    """

    code: Program
    strengths: Mapping[str, N]
    shape: Shape
    switches: tuple[Switch, ...] = ()
    form: tuple[int, ...] | None = None

    @property
    def program(self) -> Program:
        """Program for the rates of change of a state.

        Raises `TypeError` if the law has switches and no branches are chosen.
        """
        if self.switches and self.form is None:
            raise TypeError("this law has switches: choose branches by law.on(branches)")
        return self.code

    @property
    def variables(self) -> tuple[str, ...]:
        """Names of the components of a state, the same on all branches."""
        return self.code.variables

    @property
    def state(self) -> Callable[..., Any]:
        """Class of the states: `PlaneState`, `SpaceState`, or one with more components."""
        return state_of_variables(self.variables)

    @property
    def is_paper(self) -> bool:
        """True if the paper's drag, lift and gravity are the only forces."""
        return self.shape == Shape() and self.strengths.keys() <= {*PAPER} and not self.switches

    @property
    def switches_of_spin(self) -> frozenset[int]:
        """Indices of the switches whose branches change the size of the spin."""
        nodes = Program((), (), (self._traced.spin_left,)).nodes
        used = {node.args[0] for node in nodes if node.kind == "parameter"}
        return frozenset(which for which, switch in enumerate(self.switches) if switch.names & used)

    @property
    def _traced(self) -> _Traced:
        moving = "space" if "y" in self.variables else "plane"
        return _traced(self.shape, self.code.parameters, moving)

    # --- other laws

    def on(self, branches: Sequence[int]) -> Law:
        """Return the law with one branch of each switch."""
        # Remove the strengths of other branches first, because a branch may lack some of them.
        changed = {name for switch in self.switches for name in switch.names}
        strengths = {name: x for name, x in self.strengths.items() if name not in changed}
        for switch, branch in zip(self.switches, branches, strict=True):
            strengths |= switch.strengths[branch]
        code = _code(self.shape, tuple(strengths), "y" in self.variables)
        return replace(self, code=code, strengths=strengths, form=tuple(branches))

    def without(self, strength: str) -> Law:
        """Return the law without one of its strengths."""
        strengths = {name: x for name, x in self.strengths.items() if name != strength}
        names = tuple(name for name in self.code.parameters if name != strength)
        code = _code(self.shape, names, "y" in self.variables)
        return replace(self, code=code, strengths=strengths)

    def straight(self, sense: N) -> Law | None:
        """Return the law of a vertical flight; `sense` is 1 upwards and -1 downwards.

        The ball drifts with the wind and moves vertically relative to the air. Its speed is ``sense
        w``, without a square root, so that the law is smooth where the ball comes to rest; it is
        valid on one side of that point. The result is None if a force points sideways.
        """
        names, variables = self.program.parameters, self.variables
        code = _program(self.shape, names, "vertical", variables)
        if code is None:
            return None
        return replace(self, code=code, strengths={**self.strengths, _SENSE: sense})

    def in_polynomials(self) -> Law:
        """Return the law with variables for exponentials in its switches; see `completed`."""
        # The arguments of the switches contain the same functions on all branches.
        first = self.on([0] * len(self.switches))
        passed = tuple(node for switch in self.switches for node in first._traced.passed[switch.of])
        nodes = Program((), (), passed).nodes
        if all(n.static or n.kind in ("variable", "sum", "product") for n in nodes):
            return self
        law = replace(self, shape=self.shape._replace(polynomial=True))
        return replace(law, code=law.on(first.form or ()).code)

    # --- numbers

    def rates(self, numbers: Numbers) -> Callable[..., tuple[N, ...]]:
        """Return the function from the components of a state to their rates."""
        return self.program.bind(self.strengths, numbers.functions)

    def jacobian(self, numbers: Numbers) -> Callable[..., tuple[N, ...]]:
        """Return the function from the components of a state to the rates' partial derivatives."""
        return self.program.jacobian.bind(self.strengths, numbers.functions)

    def state_of(self, start: State) -> State:
        """Return a launch as a state of this law."""
        nothing = start.s * 0
        return self.state(*(getattr(start, name, nothing) for name in self.variables))

    def completed(self, state: State, numbers: Numbers) -> State:
        """Return a state with the auxiliary variables of these branches.

        The variables depend on the wind, and jump with the airspeed at its threshold.
        """
        state = self.state_of(state)
        for name, node in self._traced.auxiliary.items():
            state = state._replace(**{name: self._value(node, state, numbers)})
        return state

    def spin_left(self, state: State, numbers: Numbers) -> N:
        """Return the size of the spin in a state, relative to that at launch."""
        return self._value(self._traced.spin_left, state, numbers)

    def aside(self, state: State, numbers: Numbers) -> Vector:
        """Return ``d × u`` of the vector d of a side force, m/s; 0 if it has no direction."""
        a, b, c = (self._value(node, state, numbers) for node in self._traced.aside)
        return a, b, c

    def _value(self, node: Node, state: State, numbers: Numbers) -> N:
        bound = _value(self.program, node).bind(self.strengths, numbers.functions)
        return bound(*(getattr(state, name) for name in self.variables))[0]

    def drift(self, nothing: N) -> Vector:
        """Return the constant wind of these branches, m/s; `nothing` for a profile or no wind."""
        known = {} if ROUGHNESS in self.strengths else self.strengths
        s, y, z = (known.get(name, nothing) for name in ("wind_s", "wind_y", "wind_z"))
        return s, y, z

    def switching_function(self, switch: Switch) -> Program:
        """Return a program that is positive where the argument of a switch exceeds a threshold.

        It has the law's variables and parameters, and the parameter `threshold`.
        """
        # Zero where top/bottom passes the threshold, without a division.
        top, bottom = self._traced.passed[switch.of]
        return _value(self.program, top - trace.parameter("threshold") * bottom, "threshold")

    def beyond(self, switch: Switch, threshold: N, numbers: Numbers) -> Callable[[Any], Any]:
        """Return a function of the state that is positive beyond a threshold of a switch."""
        known = {**self.strengths, "threshold": threshold}
        bound = self.switching_function(switch).bind(known, numbers.functions)
        return lambda state: bound(*state)[0]


PAPER = "drag", "lift", "gravity"  # the strengths of its law


def law_of(scene: Any, frame: Any, numbers: Numbers, forces: Sequence[Force] = ()) -> Law:
    """Return the law of motion of a flight.

    Parameters
    ----------
    scene
        A scene, or any object with ball, air, gravity and reading. Its numbers may be arrays of
        shape (n,), for n scenes.
    frame : longball.model.frame.Frame
        Frame of the flight, with its spin.
    numbers : longball.model.numbers.Numbers
        Number system of the calculation.
    forces
        Forces in addition to those of the model.

    Returns
    -------
    Law
        The law in the vertical plane of the launch if all forces are in it; otherwise in space.

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
    switches: list[Switch] = []
    strengths: dict[str, N] = {}
    for part in parts:
        if part.thresholds:
            switches.append(part)
        else:
            strengths |= part.strengths[0]
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
    # All branches have the same variables: those of space if any branch needs them.
    names = dict.fromkeys([*strengths, *(name for switch in switches for name in switch.names)])
    return Law(_code(shape, tuple(names)), strengths, shape, tuple(switches))


def law_with(
    strengths: Mapping[str, N], forces: Sequence[Callable[[Motion, Any], Vector]] = ()
) -> Law:
    """Return the paper's law with given strengths and added forces; missing terms are zero."""
    shape = Shape(forces=tuple(forces))
    return Law(_code(shape, tuple(strengths)), strengths, shape)


def _in_air(scene: Any, frame: Any, numbers: Numbers) -> tuple[Shape, list[Switch], dict[str, N]]:
    """Return the shape of a scene's law, its parts, and strengths of spin and density."""
    air, reading, exact = scene.air, scene.reading, numbers.exact
    spins = frame.spin is not None and not all(map(numbers.absent, frame.spin))
    # the coefficients
    drag_law, drag = _coefficient("drag", scene, spins, numbers)
    # Without spin there is no lift, except the paper's, which needs no spin in the scene.
    lift_law: Any = ConstantLift
    lift: Switch = Switch("lift")
    if spins or (frame.spin is None and not by_spin(air.lift_coefficient)):
        lift_law, lift = _coefficient("lift", scene, spins, numbers)
    parts, shape = [drag, lift], Shape(drag_law, lift_law)
    # wind and side force, each with a threshold
    strengths: dict[str, N] = {}
    if air.wind is not None:
        shape = shape._replace(wind_acts_on=reading.wind_acts_on)
        question = "the ball passes the height above which the wind blows"
        parts.append(Switch("wind", *wind_strengths(scene, frame, numbers), question))
    if air.side_coefficient is not None:
        given = air.side_coefficient
        if (side := per_metre(scene, given.value, numbers)) is not None:
            # k C_S, 1/m, and the vector d with unit length
            s, y, z = frame.components(given.direction, numbers)
            size = numbers.sqrt(s * s + y * y + z * z)
            unit = {"side_s": s / size, "side_y": y / size, "side_z": z / size}
            strengths |= {"side": side} | present(unit, numbers)
            question = "the airspeed turns along air.side_coefficient.direction"
            parts.append(Switch("side", ({}, {}), (numbers.exact(ALONG) * ALONG,), question))
    # the spin vector in the frame, its size, and its decay
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


# Fixed speeds of the path of the decay, m/s, for readings by time. The decay time of the reading
# `time` is L_ω divided by 100 mph.
PATH_SPEEDS = {"time": 44.704, "nathan": 1.0}


# Sine of the angle between the airspeed and the vector of a side force below which the force has no
# direction. Doubles compute this sine to a relative error of a thousandth.
ALONG = 2.0**-20


def per_metre(scene: Any, value: float, numbers: Numbers) -> N | None:
    """Return ``k C = ρ C A / (2 m)``, 1/m, for a value of a coefficient; None if it is zero."""
    if numbers.absent(value) or numbers.absent(scene.air.density):
        return None
    radius, mass = numbers.exact(scene.ball.radius), numbers.exact(scene.ball.mass)
    area = numbers.pi * radius * radius
    return density(scene, numbers) * numbers.exact(value) * area / (2 * mass)


def _coefficient(of: str, scene: Any, spins: bool, numbers: Numbers) -> tuple[Any, Switch]:
    """Return the law of the coefficient of drag or lift, and its strengths."""
    given = getattr(scene.air, f"{of}_coefficient")
    constant: Any = ConstantDrag if of == "drag" else ConstantLift
    # In columns of scenes, a block is a namespace that names its class. A number is a constant.
    law: Any = type(given) if isinstance(given, Block) else getattr(given, "block", constant)

    # a formula
    if not hasattr(law, "lines"):
        linear: dict[str, N] = {}
        others: dict[str, N] = {}
        for key in law.model_fields:
            if key == "law":
                continue
            value = getattr(given, key, given)
            if key in law.nonlinear:
                others[_strength(of, key)] = numbers.exact(value)
            # Keys of value zero are left out, and with them their terms.
            elif (strength := per_metre(scene, value, numbers)) is not None:
                linear[_strength(of, key)] = strength
        if not linear:
            return constant, Switch(of)
        return law, Switch(of, (linear | present(others, numbers),))

    # lines between nodes
    unit = per_metre(scene, 1.0, numbers)
    if unit is None:
        return constant, Switch(of)
    nodes: Sequence[N] = ()
    lines: Sequence[tuple[N, N]]
    if given.of == "spin_parameter" and not spins:
        # Without spin S = 0, and the first value holds everywhere: no nodes, no switch.
        lines = [(numbers.exact(given.values[0]), numbers.exact(0.0))]
    else:
        nodes, lines = law.lines(given, numbers.exact)
    if given.of == "mach":
        sound = speed_of_sound(scene, numbers)
        nodes = tuple(node * sound for node in nodes)
        lines = tuple((at_0, slope / sound) for at_0, slope in lines)
    at_0, slope = _strength(of, "at_0"), _strength(of, "slope")
    strengths = tuple(present({at_0: unit * x, slope: unit * y}, numbers) for x, y in lines)
    thresholds = tuple(node * node for node in nodes)
    law = BySpin if given.of == "spin_parameter" else BySpeed
    return law, Switch(of, strengths, thresholds, f"{law.passes} passes a node of a table")
