"""Drag and lift, and the spin that they depend on.

A coefficient is that of ``k C U²``, ``k = ρ A / (2 m)``, with the speed U through the air. With
spin ω, the Magnus force is ``k C_L U² c/|c|``, ``c = ω × u``, and the spin parameter
``S = R ω_T / U`` is that of the transverse spin ``ω_T = |c|/U``; by the reading `spin_parameter`,
that of the whole spin, the force then being ``k R (C_L/S) c``. Without spin there is the paper's
lift, whose axis is fixed at launch. Sources: paper, Sec. III.B; A. M. Nathan, Am. J. Phys. 76
(2008) 119, and "Analysis of baseball trajectories" (2016), for the laws and their constants.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

from longball.model import trace
from longball.model.atmosphere import density, speed_of_sound
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
    cross,
    present,
    size,
    square,
    switched,
)
from longball.model.numbers import N, Numbers, Vector
from longball.model.trace import ZERO

# --- strengths ------------------------------------------------------------------------------------


def per_metre(scene: Any, value: float, numbers: Numbers[N]) -> N | None:
    """Return ``k C = ρ C A / (2 m)``, 1/m, for a value of a coefficient; None if it is zero."""
    if numbers.absent(value) or numbers.absent(scene.air.density):
        return None
    radius, mass = numbers.exact(scene.ball.radius), numbers.exact(scene.ball.mass)
    area = numbers.pi * radius * radius
    return density(scene, numbers) * numbers.exact(value) * area / (2 * mass)


def _is_number(coefficient: Any) -> bool:
    """Tell whether a coefficient is a number, or a column of them."""
    # Most terms of a law ask, and a float takes long to tell that it has no such attribute.
    return isinstance(coefficient, float) or not hasattr(coefficient, "law")


def law_name(coefficient: Any) -> str:
    """Return the name of a coefficient's law; a number is a constant."""
    return "constant" if _is_number(coefficient) else coefficient.law


def _value(coefficient: Any, key: str) -> Any:
    """Return a number of a coefficient's law; 0 if the law has none of that name."""
    if _is_number(coefficient):
        return coefficient if key == "value" else 0.0
    return getattr(coefficient, key, 0.0)


def _alone(value: Any) -> tuple[Any] | None:
    return None if value is None else (value,)


def _drag(scene: Any, frame: Any, numbers: Numbers[N]) -> tuple[N] | None:
    if scene.air is None:
        return None
    law = scene.air.drag_coefficient
    key = {"constant": "value", "spin": "constant", "crisis": "high_speed"}.get(law_name(law), "")
    return _alone(per_metre(scene, _value(law, key), numbers))


def _lift(scene: Any, frame: Any, numbers: Numbers[N]) -> tuple[N] | None:
    if scene.air is None or frame.spin is not None:
        return None
    return _alone(per_metre(scene, _value(scene.air.lift_coefficient, "value"), numbers))


def _spins(frame: Any, numbers: Numbers[N]) -> bool:
    """Tell whether a ball is launched with a spin that is not zero."""
    return frame.spin is not None and not all(map(numbers.absent, frame.spin))


def _spinning(
    law: str, strengths: Callable[[Any, Numbers[N]], tuple[Any, ...] | None], reading: str = ""
) -> Callable[[Any, Any, Numbers[N]], tuple[Any, ...] | None]:
    """Return the strengths of a term of a spinning ball: under a law of lift, and a reading."""

    def of_scene(scene: Any, frame: Any, numbers: Numbers[N]) -> tuple[Any, ...] | None:
        if scene.air is None or not _spins(frame, numbers):
            return None
        if law_name(scene.air.lift_coefficient) != law and law != "any":
            return None
        switch, _, option = reading.partition("=")
        if switch and getattr(scene.reading, switch) != option:
            return None
        return strengths(scene, numbers)

    return of_scene


def _spin_drag(scene: Any, numbers: Numbers[N]) -> tuple[Any] | None:
    return _alone(per_metre(scene, _value(scene.air.drag_coefficient, "per_spin"), numbers))


def _crisis(scene: Any, frame: Any, numbers: Numbers[N]) -> tuple[Any, ...] | None:
    if scene.air is None or law_name(scene.air.drag_coefficient) != "crisis":
        return None
    law = scene.air.drag_coefficient
    more = numbers.exact(law.low_speed) - numbers.exact(law.high_speed)
    per_unit = per_metre(scene, 1.0, numbers)
    if per_unit is None or numbers.absent(more):  # type: ignore[arg-type]
        return None
    return per_unit * more, numbers.exact(law.speed), numbers.exact(law.width)


def _level_lift(scene: Any, numbers: Numbers[N]) -> tuple[Any] | None:
    return _alone(per_metre(scene, _value(scene.air.lift_coefficient, "value"), numbers))


def _rational_lift(scene: Any, numbers: Numbers[N]) -> tuple[Any, ...] | None:
    law, radius = scene.air.lift_coefficient, numbers.exact(scene.ball.radius)
    strength = per_metre(scene, law.numerator, numbers)
    if strength is None:
        return None
    denominator = (numbers.exact(law.constant), numbers.exact(law.slope) * radius)
    return strength * radius, *(present(denominator, numbers) or (None, None))


def _linear_lift(scene: Any, numbers: Numbers[N]) -> tuple[Any] | None:
    strength = per_metre(scene, scene.air.lift_coefficient.slope, numbers)
    return None if strength is None else (strength * numbers.exact(scene.ball.radius),)


# --- spin -----------------------------------------------------------------------------------------


def _spin_of(scene: Any, frame: Any, numbers: Numbers[N]) -> tuple[Any, ...] | None:
    """Return the components of the spin at launch, and its size."""
    if scene.air is None or not _spins(frame, numbers):
        return None
    x, y, z = frame.spin
    found = present(frame.turned(frame.spin), numbers)
    return None if found is None else (*found, numbers.sqrt(x * x + y * y + z * z))


SPIN = Term(("spin_s", "spin_y", "spin_z", "spin"), _spin_of)


def spin_across(flow: Flow, p: Any) -> Vector[Any]:
    """Return ``c = ω × u``, of the spin at launch."""
    return cross((p.spin_s, p.spin_y, p.spin_z), flow.velocity)


def _is_level(flow: Flow, p: Any) -> bool:
    """Tell whether the spin is perpendicular to a flight in its plane: then ω_T is ω."""
    return p.spin_s is ZERO and p.spin_z is ZERO and flow.velocity[1] is ZERO


def spin_ratio(flow: Flow, p: Any, whole: bool) -> tuple[Any, Any]:
    """Return a and b of ``ω_T/U = b/a`` at the spin of the launch; `whole` takes ω for ω_T.

    They are U² and |c|, without a division, or U and ω.
    """
    if whole or _is_level(flow, p):
        return flow.speed, p.spin
    return square(flow.velocity), size(spin_across(flow, p))


def _across(flow: Flow, p: Any, whole: bool) -> Any:
    """Return ``|c| = ω_T U`` of the spin at launch; `whole` takes ω for ω_T."""
    if whole or _is_level(flow, p):
        return p.spin * flow.speed
    return size(spin_across(flow, p))


# --- terms ----------------------------------------------------------------------------------------


def _fixed_axis_lift(motion: Motion, p: Any) -> Vector[Any]:
    """Return ``k_L U (ê × u)``: lift about an axis fixed at launch, as backspin has it.

    ê is horizontal and points to the right of the launch, so that lift turns the velocity upwards
    from the horizontal: u' = -k_L V w, w' = k_L V u.
    """
    return _about_fixed_axis(motion, p.lift * motion.lift.speed)


def _about_fixed_axis(motion: Motion, lift: Any) -> Vector[Any]:
    (u, _, w), rate = motion.lift.velocity, motion.density * lift
    return -rate * w, ZERO, rate * u


def _crisis_rate(motion: Motion, p: Any) -> Any:
    """Return ``k (C_low - C_high) U / (1 + e^((U - U_c)/δ))``."""
    speed = motion.air.speed
    steepness = trace.exp((speed - p.crisis_speed) / p.crisis_width)
    return p.crisis * (speed / (1.0 + steepness))


DRAG = Drag(("drag",), _drag, lambda motion, p: p.drag * motion.air.speed)
CRISIS = Drag(("crisis", "crisis_speed", "crisis_width"), _crisis, _crisis_rate)
LIFT = Force(("lift",), _lift, _fixed_axis_lift)
LINEAR_LIFT = Lift(
    ("linear_lift",),
    _spinning("linear", _linear_lift),
    lambda motion, p: p.linear_lift * motion.spin_left,
)


def _spin_drag_of(whole: bool) -> Drag:
    """Return the drag ``k c_1 ω_T U u``."""

    def rate(motion: Motion, p: Any) -> Any:
        return p.spin_drag * (motion.spin_left * _across(motion.air, p, whole))

    reading = f"drag_spin={'total' if whole else 'transverse'}"
    return Drag(("spin_drag",), _spinning("any", _spin_drag, reading), rate)


def _level_lift_of(whole: bool) -> Lift:
    """Return the lift of a constant coefficient, ``k C_L U² c/|c|``."""

    def factor(motion: Motion, p: Any) -> Any:
        a, b = spin_ratio(motion.lift, p, whole)
        return ZERO if b is ZERO else p.level_lift * (a / b)

    return Lift(("level_lift",), _spinning("constant", _level_lift, _of_lift(whole)), factor)


def _rational_lift_of(whole: bool) -> Lift:
    """Return the lift of ``C_L = c_2 S / (c_0 + c_1 S)``: ``k c_2 R c / (c_0 + c_1 S)``."""

    def factor(motion: Motion, p: Any) -> Any:
        a, b = spin_ratio(motion.lift, p, whole)
        slowed = p.rational_constant * a + p.rational_slope * (motion.spin_left * b)
        return p.rational_lift * (motion.spin_left * (a / slowed))

    names = ("rational_lift", "rational_constant", "rational_slope")
    return Lift(names, _spinning("rational", _rational_lift, _of_lift(whole)), factor)


def _of_lift(whole: bool) -> str:
    return f"spin_parameter={'total' if whole else 'transverse'}"


SPIN_TERMS: tuple[Term, ...] = (
    SPIN,
    LINEAR_LIFT,
    *(
        of_spin(whole)
        for of_spin in (_spin_drag_of, _level_lift_of, _rational_lift_of)
        for whole in (False, True)
    ),
)


# --- tables ---------------------------------------------------------------------------------------

# Sawicki, Hubbard and Stronge, Am. J. Phys. 71 (2003) 1152: C_L = 1.5 S, from S = 0.1 on
# 0.09 + 0.6 S.
BILINEAR = ((0.1,), ((0.0, 1.5), (0.09, 0.6)))


def _lines(law: Any, numbers: Numbers[N]) -> tuple[tuple[N, ...], list[tuple[N, N]]]:
    """Return where the lines of a law meet, and the value at 0 and the slope of each line."""
    exact = numbers.exact
    if law.law == "bilinear":
        nodes, lines = BILINEAR
        return tuple(map(exact, nodes)), [(exact(a), exact(b)) for a, b in lines]
    at, values = [*map(exact, law.at)], [*map(exact, law.values)]
    nothing = exact(0.0)
    found = [(values[0], nothing)]
    for (x, y), (right, above) in pairwise(zip(at, values, strict=True)):
        slope = (above - y) / (right - x)
        found.append((y - slope * x, slope))
    found.append((values[-1], nothing))
    first = 1 if law.at[0] == 0.0 else 0  # nothing is below 0
    return tuple(at[first:]), found[first:]


_BY_SPEED, _BY_SPIN = ("speed", "mach"), ("spin_parameter",)


def _table(
    term: Term, coefficient: str, of: tuple[str, ...], whole: bool | None = None
) -> Piecewise:
    """Return a term by a table of the speed or the spin parameter; `whole` takes ω for ω_T."""
    of_lift = coefficient == "lift_coefficient"

    def branches(scene: Any, frame: Any, numbers: Numbers[N]) -> Branches | None:
        law: Any = None if scene.air is None else getattr(scene.air, coefficient)
        if _is_number(law):
            return None
        known = getattr(law, "of", "spin_parameter" if law.law == "bilinear" else "")
        if known not in of:
            return None
        spins = _spins(frame, numbers)
        if whole is None:
            if of_lift and frame.spin is not None:
                return None
        elif whole != (scene.reading.spin_parameter == "total") or (of_lift and not spins):
            return None
        unit = per_metre(scene, 1.0, numbers)
        if unit is None:
            return None
        nodes, lines = _lines(law, numbers)
        # What the slope is multiplied by is U, and R times a spin.
        scale = numbers.exact(1.0)
        if known == "mach":
            scale = 1 / speed_of_sound(scene, numbers)
        elif known == "spin_parameter":
            scale = numbers.exact(scene.ball.radius)
        strengths = tuple(
            present((unit * at_0, unit * slope * scale), numbers) or (None, None)
            for at_0, slope in lines
        )
        if known == "spin_parameter" and not spins:
            return Branches((), strengths[:1])
        levels = (node / scale for node in nodes)
        return Branches(tuple(level * level for level in levels), strengths)

    if of is _BY_SPEED:
        argument, passes = _speed_squared(of_lift), "the airspeed"
    else:
        argument, passes = _spin_parameter_squared(of_lift, bool(whole)), "the spin parameter"
    question = f"{passes} passes a node of a table"
    return Piecewise(term.parameters, term.strengths, term, branches, argument, question)


def _speed_squared(of_lift: bool) -> Callable[[Motion, Any], tuple[Any, Any]]:
    def argument(motion: Motion, p: Any) -> tuple[Any, Any]:
        return square((motion.lift if of_lift else motion.air).velocity), 1.0

    return argument


def _spin_parameter_squared(of_lift: bool, whole: bool) -> Callable[[Motion, Any], tuple[Any, Any]]:
    """Return S² = (R f)² (b/a)² without R²."""

    def argument(motion: Motion, p: Any) -> tuple[Any, Any]:
        flow = motion.lift if of_lift else motion.air
        left, speed = motion.spin_left * motion.spin_left, square(flow.velocity)
        if whole or _is_level(flow, p):
            return left * (p.spin * p.spin), speed
        return left * square(spin_across(flow, p)), speed * speed

    return argument


def _over_speed(flow: Flow, p: Any, whole: bool) -> Any:
    """Return ω_T at the spin of the launch."""
    if whole or _is_level(flow, p):
        return p.spin
    return size(spin_across(flow, p)) / flow.speed


def _tables() -> Iterator[Piecewise]:
    """Yield the tables of drag and lift."""
    drag, lift = ("drag_table", "drag_slope"), ("lift_table", "lift_slope")

    def drag_by_speed(motion: Motion, p: Any) -> Any:
        speed = motion.air.speed
        return p.drag_table * speed + p.drag_slope * (speed * speed)

    def fixed_axis(motion: Motion, p: Any) -> Vector[Any]:
        speed = motion.lift.speed
        return _about_fixed_axis(motion, p.lift_table * speed + p.lift_slope * (speed * speed))

    yield _table(Drag(drag, switched, drag_by_speed), "drag_coefficient", _BY_SPEED)
    yield _table(Force(lift, switched, fixed_axis), "lift_coefficient", _BY_SPEED)
    for whole in (False, True):

        def drag_by_spin(motion: Motion, p: Any, whole: bool = whole) -> Any:
            constant = p.drag_table * motion.air.speed
            if p.drag_slope is ZERO:  # as without spin
                return constant
            return constant + p.drag_slope * (motion.spin_left * _over_speed(motion.air, p, whole))

        def lift_by_speed(motion: Motion, p: Any, whole: bool = whole) -> Any:
            a, b = spin_ratio(motion.lift, p, whole)
            value = p.lift_table + p.lift_slope * motion.lift.speed
            return ZERO if b is ZERO or value is ZERO else value * (a / b)

        def lift_by_spin(motion: Motion, p: Any, whole: bool = whole) -> Any:
            a, b = spin_ratio(motion.lift, p, whole)
            linear = p.lift_slope * motion.spin_left
            return linear if p.lift_table is ZERO else p.lift_table * (a / b) + linear

        yield _table(Drag(drag, switched, drag_by_spin), "drag_coefficient", _BY_SPIN, whole)
        yield _table(Lift(lift, switched, lift_by_speed), "lift_coefficient", _BY_SPEED, whole)
        yield _table(Lift(lift, switched, lift_by_spin), "lift_coefficient", _BY_SPIN, whole)


TABLES = tuple(_tables())


# --- the decay of spin ----------------------------------------------------------------------------

# m/s, 100 mph: a decay in time is quoted as one along a path that is flown at this speed.
REFERENCE_SPEED = 44.704


def _decay(
    reading: str, speed: float | None = None
) -> Callable[[Any, Any, Numbers[N]], tuple[N, ...] | None]:
    """Return the function from a scene to 1/L_ω, and a speed."""

    def strengths(scene: Any, frame: Any, numbers: Numbers[N]) -> tuple[N, ...] | None:
        if scene.air is None or frame.spin is None or scene.air.spin_decay_length is None:
            return None
        if scene.reading.spin_decay != reading:
            return None
        per_length = 1 / numbers.exact(scene.air.spin_decay_length)
        return (per_length,) if speed is None else (per_length, numbers.exact(speed))

    return strengths


def _left(path: Any, speed: Any, p: Any) -> Any:
    """Return ``e^(-path/L_ω)``."""
    return trace.exp(-p.decay * path)


def _left_at_speed(path: Any, speed: Any, p: Any) -> Any:
    """Return ``e^(-t U/L_ω)``; the path is t times 1 m/s."""
    return trace.exp(-(p.decay / p.decay_speed) * (path * speed))


# ω' = -(U/L_ω) ω, which is e^(-path/L_ω) of the path through the air.
DECAY_ALONG_PATH = Decay(("decay",), _decay("path"), lambda motion, p: motion.speed, _left)
# e^(-t/τ), with τ the time that L_ω takes at 100 mph.
DECAY_IN_TIME = Decay(
    ("decay", "decay_speed"),
    _decay("time", REFERENCE_SPEED),
    lambda motion, p: p.decay_speed,
    _left,
)
# e^(-t U/L_ω) with the present U: ω solves no equation of its own, but the law of motion with it
# is one in (r, v, t), and solved as such.
DECAY_AT_SPEED = Decay(
    ("decay", "decay_speed"), _decay("nathan", 1.0), lambda motion, p: p.decay_speed, _left_at_speed
)
DECAYS = DECAY_ALONG_PATH, DECAY_IN_TIME, DECAY_AT_SPEED
