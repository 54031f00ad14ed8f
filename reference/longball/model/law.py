"""The law of motion: what accelerates a ball in flight.

Each `Force` is one function in space, over any kind of number, and the strengths that a scene gives
it. The law of a scene is their sum, traced into straight-line code (`longball.model.trace`): a
force that the scene does not name is not in it, and neither is a direction in which nothing moves
the ball. A flight whose forces lie in the vertical plane of its launch is flown in that plane, in
four variables; one with other forces in space, in six.

A flight has a frame of its own: s along the horizontal direction of the launch, y to the left of
it, z up; u, v, w are the components of the velocity. Source: paper, Sec. III.B.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from types import SimpleNamespace
from typing import Any, Generic, NamedTuple

from longball.model import trace
from longball.model.numbers import N, Numbers, Vector
from longball.model.trace import ZERO, Node, Program


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


State = PlaneState[N] | SpaceState[N]


class Motion(NamedTuple):
    """What a force may depend on, in the frame of the flight.

    Attributes
    ----------
    position
        m.
    velocity
        m/s.
    speed
        Size of the velocity, m/s.
    """

    position: Vector[Any]
    velocity: Vector[Any]
    speed: Any


@dataclass(frozen=True)
class Force:
    """A force.

    Attributes
    ----------
    parameters
        Names of the force's parameters.
    strengths
        From a scene, the `longball.model.frame.Frame` of a flight and a number system to the values
        of the parameters; None if the scene does not name the force, which then is not in the law.
    acceleration
        From the motion and the parameters to the acceleration, m/s². Parameters are attributes.
    """

    parameters: tuple[str, ...]
    strengths: Callable[[Any, Any, Numbers[Any]], tuple[Any, ...] | None]
    acceleration: Callable[[Motion, Any], Vector[Any]]


# --- the paper's forces ---------------------------------------------------------------------------


def _per_metre(coefficient: str) -> Callable[[Any, Any, Numbers[N]], tuple[N] | None]:
    """Return the function from a scene to ``k = ρ C A / (2 m)``, 1/m."""

    def strength(scene: Any, frame: Any, numbers: Numbers[N]) -> tuple[N] | None:
        if scene.air is None:
            return None
        density, value = scene.air.density, getattr(scene.air, coefficient)
        if numbers.absent(density) or numbers.absent(value):
            return None
        density, value, radius, mass = (
            numbers.exact(x) for x in (density, value, scene.ball.radius, scene.ball.mass)
        )
        area = numbers.pi * radius * radius
        return (density * value * area / (2 * mass),)

    return strength


def _weight(scene: Any, frame: Any, numbers: Numbers[N]) -> tuple[N] | None:
    return None if numbers.absent(scene.gravity) else (numbers.exact(scene.gravity),)


def _gravity(motion: Motion, p: Any) -> Vector[Any]:
    """Return ``-g e_z``."""
    return ZERO, ZERO, -p.gravity


def _drag(motion: Motion, p: Any) -> Vector[Any]:
    """Return ``-k_D V v``."""
    u, v, w = (-p.drag * (motion.speed * component) for component in motion.velocity)
    return u, v, w


def _lift(motion: Motion, p: Any) -> Vector[Any]:
    """Return ``k_L V (ê × v)``: lift about an axis fixed at launch, as backspin has it.

    ê is horizontal and points to the right of the launch, so that lift turns the velocity upwards
    from the horizontal: u' = -k_L V w, w' = k_L V u.
    """
    u, _, w = motion.velocity
    return -p.lift * (motion.speed * w), ZERO, p.lift * (motion.speed * u)


DRAG = Force(("drag",), _per_metre("drag_coefficient"), _drag)
LIFT = Force(("lift",), _per_metre("lift_coefficient"), _lift)
GRAVITY = Force(("gravity",), _weight, _gravity)

FORCES: tuple[Force, ...] = (DRAG, LIFT, GRAVITY)


# --- the law of a scene ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Law(Generic[N]):
    """The law of motion of a scene.

    Attributes
    ----------
    program
        The rates of change of a `PlaneState` or a `SpaceState`, component by component.
    strengths
        Values of the program's parameters, by name.
    forces
        What the program was traced from.
    """

    program: Program
    strengths: Mapping[str, N]
    forces: tuple[Force, ...]

    @property
    def state(self) -> Callable[..., Any]:
        """The class of the states: `PlaneState` or `SpaceState`."""
        return SpaceState if "v" in self.program.variables else PlaneState

    def state_of(self, start: PlaneState[N]) -> State[N]:
        """Return a launch as a state of this law."""
        if self.state is PlaneState:
            return start
        nothing = start.s * 0
        return SpaceState(start.s, nothing, start.z, start.u, nothing, start.w)

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

    def without(self, force: Force) -> Law[N]:
        """Return the law without one of its forces."""
        strengths = {n: x for n, x in self.strengths.items() if n not in force.parameters}
        return law_with(strengths, self.forces)

    def straight(self, sense: N) -> Law[N] | None:
        """Return the law of a vertical flight; `sense` is 1 on the way up and -1 on the way down.

        The speed is ``sense w`` there, without a square root: this law is smooth where the ball
        comes to rest, and holds on one side of it. None if a force drives the ball aside.
        """
        vertical = _program(self.forces, tuple(self.strengths), "vertical")
        if vertical is None:
            return None
        rates = dict(zip(vertical.variables, vertical.outputs, strict=True))
        variables = self.program.variables
        program = replace(
            vertical, variables=variables, outputs=tuple(rates.get(x, ZERO) for x in variables)
        )
        return replace(self, program=program, strengths={**self.strengths, "sense": sense})


def law_of(
    scene: Any, frame: Any, numbers: Numbers[N], forces: tuple[Force, ...] = FORCES
) -> Law[N]:
    """Return the law of motion of a flight in a frame, of a scene with ball, air and gravity."""
    strengths: dict[str, N] = {}
    for force in forces:
        values = force.strengths(scene, frame, numbers)
        if values is not None:
            strengths |= zip(force.parameters, values, strict=True)
    return law_with(strengths, forces)


def law_with(strengths: Mapping[str, N], forces: tuple[Force, ...] = FORCES) -> Law[N]:
    """Return the law of those forces whose parameters have values; in the plane, if it holds."""
    acting = tuple(f for f in forces if all(name in strengths for name in f.parameters))
    names = tuple(strengths)
    program = _program(acting, names, "plane") or _program(acting, names, "space")
    assert program is not None
    return Law(program, strengths, acting)


@cache
def _program(forces: tuple[Force, ...], names: tuple[str, ...], motion: str) -> Program | None:
    """Trace the law where the ball moves in space, in a vertical plane, or vertically.

    None if a force drives the ball out of there.
    """
    parameters = SimpleNamespace(**{name: trace.parameter(name) for name in names})
    still = {"space": "", "plane": "yv", "vertical": "yvsu"}[motion]
    s, y, z, u, v, w = (ZERO if name in still else trace.variable(name) for name in "syzuvw")
    moving = Motion((s, y, z), (u, v, w), _speed((u, v, w)))
    total = [ZERO, ZERO, ZERO]
    for force in forces:
        pushed = force.acceleration(moving, parameters)
        total = [a + b for a, b in zip(total, pushed, strict=True)]
    rates = dict(zip("syzuvw", (u, v, w, *total), strict=True))
    if any(rates[name] is not ZERO for name in still):
        return None
    variables = "syzuvw" if motion == "space" else "szuw"
    program = Program(tuple(variables), names, tuple(rates[name] for name in variables))
    if trace.parameter(_SENSE) in program.nodes:
        program = replace(program, parameters=(*names, _SENSE))
    return program


_SENSE = "sense"


def _speed(velocity: tuple[Node, Node, Node]) -> Node:
    moving = [component for component in velocity if component is not ZERO]
    if len(moving) == 1:
        return trace.parameter(_SENSE) * moving[0]
    return trace.sqrt(trace.total(component * component for component in moving))


@cache
def _jacobian(program: Program) -> Program:
    return program.jacobian()
