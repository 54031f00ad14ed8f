"""The chain of a scene as data: inputs, definitions, and a stage for every step of the calculation.

Formulas stand here as expressions, in the order of docs/model.md and with its symbols, so that the
judge can edit them. `tests/judge/test_chain.py` compares every stage with the engines. A stage
starts from the candidate's own earlier values: a symbol such as `ẽ` below is the value that
the candidate reports.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple

from longball.judge.diagnosis.expression import (
    ARGUMENT,
    KG,
    NONE,
    Dimension,
    M,
    Node,
    S,
    component,
    constant,
    contains,
    cross,
    depends,
    dot,
    function,
    matrix,
    named,
    norm,
    solve,
    substitute,
    switch,
    symbol,
    table,
    times,
    unit,
    vector,
    where,
)

SPEED, ACCELERATION, RATE = (1, 0, -1), (1, 0, -2), (0, 0, -1)
DENSITY, IMPULSE, ENERGY = (-3, 1, 0), (1, 1, -1), (2, 1, -2)


class Input(NamedTuple):
    """A number or a vector of a scene: its symbol, its keys, and the value of null."""

    symbol: Node
    path: str
    null: float = math.nan


def _input(
    name: str, path: str, dimension: Dimension = NONE, vector: bool = False, null: float = math.nan
) -> Input:
    return Input(symbol(name, dimension, vector), path, null)


INPUTS = (
    _input("m", "ball.mass", KG),
    _input("R", "ball.radius", M),
    _input("e", "ball.restitution"),
    _input("β", "ball.inertia_factor", null=0.4),
    _input("g", "gravity", ACCELERATION),
    _input("release", "pitch.release", M, True),
    _input("V_0", "pitch.speed", SPEED),
    _input("aim_y", "pitch.aim[0]", M),
    _input("aim_z", "pitch.aim[1]", M),
    _input("pitch.velocity", "pitch.velocity", SPEED, True),
    _input("pitch.spin", "pitch.spin", RATE, True, null=0.0),
    _input("launch.position", "launch.position", M, True),
    _input("launch.velocity", "launch.velocity", SPEED, True),
    _input("launch.spin", "launch.spin", RATE, True, null=0.0),
    _input("incoming.position", "incoming.position", M, True),
    _input("incoming.velocity", "incoming.velocity", SPEED, True),
    _input("incoming.spin", "incoming.spin", RATE, True, null=0.0),
    _input("incoming.bat_height", "incoming.bat_height", M),
    _input("M", "bat.mass", KG),
    _input("L", "bat.length", M),
    _input("r_b", "bat.radius", M),
    _input("μ_f", "bat.friction"),
    _input("e_T", "bat.tangential_restitution", null=0.3),
    _input("ω_bat", "swing.angular_speed", RATE),
    _input("θ", "swing.tilt"),
    _input("σ_b", "swing.height_offset", M),
    _input("ground", "ground.height", M),
    _input("ρ_0", "air.density", DENSITY),
    _input("T", "air.density.temperature"),
    _input("p", "air.density.pressure"),
    _input("φ", "air.density.humidity"),
    _input("h", "air.density.elevation", M),
    _input("H", "air.density_scale_height", M),
    _input("C_D", "air.drag_coefficient"),
    _input("C_L", "air.lift_coefficient"),
    _input("drag.constant", "air.drag_coefficient.constant"),
    _input("drag.per_spin", "air.drag_coefficient.per_spin", S),
    _input("drag.high_speed", "air.drag_coefficient.high_speed"),
    _input("drag.low_speed", "air.drag_coefficient.low_speed"),
    _input("drag.speed", "air.drag_coefficient.speed", SPEED),
    _input("drag.width", "air.drag_coefficient.width", SPEED),
    _input("drag.value", "air.drag_coefficient.value"),
    _input("lift.value", "air.lift_coefficient.value"),
    _input("lift.numerator", "air.lift_coefficient.numerator"),
    _input("lift.constant", "air.lift_coefficient.constant"),
    _input("lift.slope", "air.lift_coefficient.slope"),
    _input("C_S", "air.side_coefficient.value"),
    _input("d", "air.side_coefficient.direction", vector=True),
    _input("W_0", "air.wind", SPEED, True),
    _input("wind.velocity", "air.wind.velocity", SPEED, True),
    _input("above", "air.wind.above", M),
    _input("wind.height", "air.wind.height", M),
    _input("z_0", "air.wind.roughness", M),
    _input("L_ω", "air.spin_decay_length", M),
    _input("λ", "earth.latitude"),
    _input("α", "earth.azimuth"),
    _input("fence.radius", "fence.radius", M),
)
I = {each.symbol.data: each.symbol for each in INPUTS}  # noqa: E741


def _given(part: str, release: str = "") -> Node:
    """Position, velocity or spin of the ball that a scene gives, from the block of its kind.

    A program has one function for the vectors of all blocks, so that a mistake in it is one edit.
    """
    pitch = I[release or f"pitch.{part}"]
    kinds = {"flight": I[f"launch.{part}"], "impact": I[f"incoming.{part}"]}
    return named(f"the scene's {part}", switch("kind", {"pitch": pitch, "at-bat": pitch} | kinds))


given_position = _given("position", "release")
given_velocity, given_spin = _given("velocity"), _given("spin")

# The variables of a flight, and its launch; and the formulas that hold during it.
MOVING = frozenset(("r", "dr/dt", "v", "t", "path"))
IN_FLIGHT = MOVING | {"r0", "v0", "ω0"}
FLYING = "rate", "law", "spin_left", "through"
r, v = symbol("r", M, True), symbol("v", SPEED, True)
r_dot = symbol("dr/dt", SPEED, True)  # equals v; a separate symbol, so that edits spare the law
t, path = symbol("t", S), symbol("path", M)
r0, v0, spin0 = symbol("r0", M, True), symbol("v0", SPEED, True), symbol("ω0", RATE, True)

e_x = named("e_x", vector(1.0, 0.0, 0.0))
e_y = named("e_y", vector(0.0, 1.0, 0.0))
e_z = named("e_z", vector(0.0, 0.0, 1.0))


def level(a: Node) -> Node:
    """The horizontal part of a vector."""
    return vector(component(a, 0), component(a, 1), constant(0.0, a.dimension))


# --- the air --------------------------------------------------------------------------------------

# Weather (docs/model.md, "Flight with spin, wind and weather"). Its formulas hold for numbers in SI
# units: a factor `constant(1.0, …)` gives a number its unit, or takes it away.
celsius = I["T"] - 273.15
# p_s, the saturation pressure of water vapour.
vapour = named(
    "p_s", 611.16 * function("exp", (18.687 - celsius / 234.5) * celsius / (257.14 + celsius))
)
# Reduces a pressure at sea level to the elevation. A pressure measured at the park needs no factor.
falls = named("e^(-κh)", function("exp", -(1.217e-4 * I["h"] / constant(1.0, M))))
pressed = switch("reading.pressure", {"sea_level": I["p"] * falls, "station": I["p"]})
weather = named(
    "ρ(T, p, φ)",
    1.2929 * (273.15 / I["T"]) * ((pressed - 0.3783 * I["φ"] * vapour) / 101325.0),
)
thins = named(
    "e^(-z/H)",
    switch(
        "air.density_scale_height",
        {"none": constant(1.0), "given": function("exp", -(component(r, 2) / I["H"]))},
    ),
)
ρ = named(
    "ρ",
    switch(
        "air.density",
        {"given": I["ρ_0"], "weather": weather * constant(1.0, DENSITY)},
    )
    * thins,
)
# Squares are written as products, so that "does not square R" is an edit (`operators._shapes`).
area = named("A", math.pi * (I["R"] * I["R"]))
k = named("k", ρ * area / (2.0 * I["m"]))

# The logarithmic profile of the wind, ln((z + z_0)/z_0)/ln((h + z_0)/z_0).
rise = named(
    "the wind's profile",
    function("log", (component(r, 2) + I["z_0"]) / I["z_0"])
    / function("log", (I["wind.height"] + I["z_0"]) / I["z_0"]),
)
# The textbook profile, which programs use in place of `rise`: z_0 is not added, and the wind is 0
# below z_0.
_unshifted = named(
    "ln(z/z_0)/ln(h/z_0)",
    function("log", 1.0 + function("positive", component(r, 2) / I["z_0"] - 1.0))
    / function("log", I["wind.height"] / I["z_0"]),
)
W = named(
    "W",
    switch(
        "air.wind",
        {
            "none": constant(0.0, SPEED, True),
            "given": I["W_0"],
            "above a height": function("rises", component(r, 2) - I["above"]) * I["wind.velocity"],
            "logarithmic": rise * level(I["wind.velocity"]),
        },
    ),
)
# Drag and lift depend on the velocity through the air. Under the reading wind_acts_on = drag, lift
# depends on the velocity over the ground.
u = named("u", v - W)
U = named("U", norm(u))
u_lift = named("u_L", switch("reading.wind_acts_on", {"both": u, "drag": v}))
U_lift = switch("reading.wind_acts_on", {"both": U, "drag": norm(v)})

# The fraction of the spin that is left. The reading spin_decay decides whether it falls with the
# path s through the air, with the time at 100 mph, or with the time at the present airspeed.
spin_left = named(
    "e^(-s/L_ω)",
    switch(
        "air.spin_decay_length",
        {
            "none": constant(1.0),
            "given": function(
                "exp",
                -(
                    switch(
                        "reading.spin_decay",
                        # 44.704 m/s are 100 mph.
                        {"path": path, "time": t * constant(44.704, SPEED), "nathan": t * U},
                    )
                    / I["L_ω"]
                ),
            ),
        },
    ),
)
spin = named("ω", spin_left * spin0)
c = named("ω × u", cross(spin, u_lift))
# The spin across the motion, in drag, in lift and in tables. It is |ω × u|/U, with the velocity
# over the ground in lift under wind_acts_on = drag. Two readings use the whole spin instead.
transverse = named("ω_T", norm(cross(spin, u)) / U)


def _spin_in(name: str, reading: str, across: Node) -> Node:
    return named(
        f"the spin in {name}",
        switch(f"reading.{reading}", {"transverse": across, "total": norm(spin)}),
    )


ω_drag = _spin_in("C_D", "drag_spin", transverse)
_across_lift = norm(c) / U_lift
_ω_lift = _spin_in("S", "spin_parameter", _across_lift)
_ω_table = _spin_in("S (drag)", "spin_parameter", transverse)
S_lift = named("S", I["R"] * _ω_lift / U_lift)
S_drag = named("S (drag)", I["R"] * _ω_table / U)
sound = named(
    "the speed of sound", 331.3 * function("sqrt", I["T"] / 273.15) * constant(1.0, SPEED)
)


def _tables(key: str, speed: Node, parameter: Node) -> dict[str, Node]:
    return {
        "table of speed": table(speed / constant(1.0, SPEED), key),
        "table of mach": table(speed / sound, key),
        "table of spin_parameter": table(parameter, key),
    }


C_D = named(
    "C_D",
    switch(
        "air.drag_coefficient",
        {
            "given": I["C_D"],
            "constant": I["drag.value"],
            "spin": I["drag.constant"] + I["drag.per_spin"] * ω_drag,
            "crisis": I["drag.high_speed"]
            + (I["drag.low_speed"] - I["drag.high_speed"])
            / (1.0 + function("exp", (U - I["drag.speed"]) / I["drag.width"]))
            + I["drag.per_spin"] * ω_drag,
            **_tables("air.drag_coefficient", U, S_drag),
        },
    ),
)
_bilinear = where(S_lift - 0.1, 0.09 + 0.6 * S_lift, 1.5 * S_lift)
C_L = named(
    "C_L",
    switch(
        "air.lift_coefficient",
        {
            "given": I["C_L"],
            "constant": I["lift.value"],
            "rational": I["lift.numerator"]
            * S_lift
            / (I["lift.constant"] + I["lift.slope"] * S_lift),
            "linear": I["lift.slope"] * S_lift,
            "bilinear": _bilinear,
            **_tables("air.lift_coefficient", U_lift, S_lift),
        },
    ),
)

# --- the law of motion ----------------------------------------------------------------------------


def _parts(a: Node) -> tuple[Node, Node, Node]:
    return component(a, 0), component(a, 1), component(a, 2)


def _heading(velocity: Node) -> Node:
    flat = level(velocity)
    return where(norm(flat), unit(flat), e_x)  # straight up or down: φ = 0


def _heading_by_parts(velocity: Node) -> Node:
    size = norm(level(velocity))
    ahead, aside, _ = _parts(velocity)
    return vector(
        where(size, ahead / size, constant(1.0)), where(size, aside / size, constant(0.0)), 0
    )


def _heading_by_angle(velocity: Node) -> Node:
    ahead, aside, _ = _parts(velocity)
    angle = named("φ", function("atan2", aside, ahead))
    return where(
        norm(level(velocity)), vector(function("cos", angle), function("sin", angle), 0), e_x
    )


def _headed(heading: Callable[[Node], Node]) -> Node:
    """h, the horizontal direction of the launch; of the velocity, if lift is always up."""
    options = {"fixed_spin_axis": heading(v0), "always_up": heading(v)}
    return named("h", switch("reading.lift_direction", options))


_ahead = _headed(_heading)
# ê, the axis of the paper's lift: horizontal, and to the right of h.
about = named("ê", cross(_ahead, e_z))
# With S of the total spin, k C_L U² c/|c| becomes k R (C_L/S) c: smooth where spin and motion are
# parallel, where c/|c| has no direction.
_per_spin = I["R"] * (C_L / S_lift)

# â, the direction of the side force: the part of d that is perpendicular to u.
_aimed = named("d̂", unit(I["d"]))
_sideways = named("d̂ - (d̂·û)û", _aimed - dot(_aimed, unit(u_lift)) * unit(u_lift))
_cosine, _sine = function("cos", I["λ"]), function("sin", I["λ"])
rotation = named(
    "Ω",
    constant(7.292115e-5, RATE)
    * vector(_cosine * function("cos", I["α"]), _cosine * function("sin", I["α"]), _sine),
)
_drag, _lift = named("k·C_D·U", k * C_D * U), named("k·C_L·U", k * C_L * U_lift)


def _per_turn(turned: Node, per_spin: Node = _per_spin) -> Node:
    """The lift of a spinning ball without a unit vector: k R (C_L/S) ω × u."""
    # Where ω × u is 0, so is the lift, but C_L/S may be 0/0.
    return k * where(norm(c), per_spin, constant(0.0, M)) * turned


def _spinning(total: Node) -> Node:
    """The lift of a spinning ball; `total` under the reading of that name."""
    transverse = k * C_L * (U_lift * U_lift) * unit(c)
    return switch("reading.spin_parameter", {"transverse": transverse, "total": total})


def _law(drag: Node, paper_lift: Node, spinning: Node) -> Node:
    """The law of motion from its drag, the paper's lift, and the lift of a spin.

    m dv/dt = -F_D + F_L + m g (paper, Eqs. 6 to 8), divided by m, with the terms of docs/model.md,
    "Flight with spin, wind and weather".
    """
    lift = switch("spin", {"none": paper_lift, "given": spinning})
    turns = switch(
        "earth",
        {"none": constant(0.0, ACCELERATION, True), "given": -(2.0 * cross(rotation, v))},
    )
    aside = switch(
        "air.side_coefficient",
        {
            "none": constant(0.0, ACCELERATION, True),
            "given": k * I["C_S"] * (U_lift * U_lift) * unit(_sideways),
        },
    )
    of_air = named("drag", drag) + named("lift", lift) + named("side force", aside)
    # Programs skip all of this without air: an edit of k, for example, changes nothing in a vacuum.
    acting = switch("air", {"none": constant(0.0, ACCELERATION, True), "given": of_air})
    return acting + named("gravity", -(I["g"] * e_z)) + named("Coriolis", turns)


def _by_components() -> Node:
    """The law written out by components, for programs without vectors."""
    (x, y, z), (p, q, s) = _parts(u_lift), _parts(spin)
    ahead, aside, _ = _parts(_headed(_heading_by_parts))
    lift = -(_lift * ahead * z), -(_lift * aside * z), _lift * (ahead * x + aside * y)
    turned = q * z - s * y, s * x - p * z, p * y - q * x
    return _law(
        vector(*(-(_drag * each) for each in _parts(u))), vector(*lift), _per_turn(vector(*turned))
    )


def _in_launch_frame() -> Node:
    """The law along the launch's horizontal direction, to its left, and upwards."""
    left = named("l", cross(e_z, _ahead))

    def spread(ahead: Node, aside: Node, up: Node) -> Node:
        return ahead * _ahead + aside * left + up * e_z

    def frame(a: Node) -> tuple[Node, Node, Node]:
        return dot(a, _ahead), dot(a, left), component(a, 2)

    ahead, _, up = frame(u_lift)
    lift = spread(-(_lift * up), constant(0.0, ACCELERATION), _lift * ahead)
    return _law(spread(*(-(_drag * each) for each in frame(u))), lift, _per_turn(c))


def _in_vectors(paper_lift: Node, total: Node | None = None) -> Node:
    return _law(-(k * C_D * U * u), paper_lift, _spinning(total or _per_turn(c)))


def _with_functions() -> Node:
    """The law of a program that has one function for ω_T, and one for S, in drag and in lift."""
    # With S of the total spin, R C_L/S is C_L U/|ω|.
    total = _per_turn(c, C_L * U_lift / norm(spin))
    law = _in_vectors(k * C_L * U_lift * cross(about, u_lift), total)
    # Under wind_acts_on = drag, the function has other arguments: u in drag, v in lift.
    share = (_ω_table / U) / (_ω_lift / U_lift)
    for one, same, else_ in (
        (S_drag, S_lift, S_lift * share), (_across_lift, transverse, _across_lift),
    ):  # fmt: skip
        law = substitute(law, one, switch("reading.wind_acts_on", {"both": same, "drag": else_}))
    return law


LAW = _in_vectors(k * C_L * U_lift * cross(about, u_lift))
# Other forms of the same law, in which other mistakes are small: a wrong axis is one edit of the
# law in vectors, and one component in place of another is one edit of the law by components.
OTHER_FORMS = (
    _in_vectors(k * C_L * (U_lift * U_lift) * unit(cross(about, u_lift))),
    _in_vectors(k * C_L * U_lift * cross(cross(_headed(_heading_by_angle), e_z), u_lift)),
    _by_components(),
    _in_launch_frame(),
    _with_functions(),
)

# --- the collision --------------------------------------------------------------------------------


def own(quantity: str, name: str, dimension: Dimension = NONE, vector: bool = False) -> Node:
    """The symbol of a quantity that the candidate reports."""
    OWN[quantity] = found = symbol(name, dimension, vector)
    return found


# Symbols of the quantities, by quantity. Verdicts print the symbol's name: the letter of the model
# if there is one.
OWN: dict[str, Node] = {}
plate_time = own("plate.time", "plate.time", S)
plate = own("plate.position", "plate.position", M, True)
crossing = own("plate.velocity", "plate.velocity", SPEED, True)
own("plate.approach.vertical", "plate.approach.vertical")
own("plate.approach.horizontal", "plate.approach.horizontal")
contact_time = own("contact.time", "contact.time", S)
place = own("contact.position", "contact.position", M, True)
# No candidate reports these two. They follow from the pitch; an impact scene gives them.
_brought = own("contact.velocity", "V", SPEED, True), own("contact.spin", "ω", RATE, True)
V, spin_at = (
    named(str(pitched.data), switch("kind", {"impact": given, "at-bat": pitched}))
    for pitched, given in zip(_brought, (given_velocity, given_spin), strict=True)
)
own("contact.path", "the pitch's path", M)  # no candidate reports it, either
n = own("contact.normal", "n", NONE, True)
V_b = own("contact.bat_velocity", "V_b", SPEED, True)
w = own("contact.normal_speed", "Ṽ·n", SPEED)
own("contact.margin", "margin", M)
# The closest distance of the undisturbed pitch from the bat's axis is a minimum, and the highest
# point of a flight a maximum, which no formula gives: `longball.judge.diagnosis.residual.data_of`
# fills these columns from the truth.
closest = symbol("the closest distance", M)
rising, highest = symbol("the time to the highest point", S), symbol("the highest point", M, True)
ẽ = own("impact.restitution", "ẽ")
J = own("impact.impulse", "J", IMPULSE)
after = own("impact.velocity", "V⁺", SPEED, True)
spin_after = own("impact.spin", "ω⁺", RATE, True)
own("impact.friction_margin", "friction_margin")
own("impact.energy_change", "ΔE", ENERGY)
hang = own("landing.hang_time", "landing.hang_time", S)
# The time of flight, from `landing.hang_time` or from `landing.time`: see `residual.begun`. And the
# time of its end.
flown, ended = symbol("hang_time", S), symbol("the time of the landing", S)
landing_time = own("landing.time", "landing.time", S)
landing = own("landing.position", "landing.position", M, True)
coming_down = own("landing.velocity", "landing.velocity", SPEED, True)
own("landing.angle", "landing.angle")
own("apex.time", "apex.time", S)
own("apex.position", "apex.position", M, True)
own("landing.spin", "landing.spin", RATE, True)
own("landing.distance", "landing.distance", M)
flown_path = own("flight.path", "the ball's path", M)  # reported as `landing.path`, if at all
own("landing.path", "landing.path", M)
fence_time = own("fence.time", "fence.time", S)
at_fence = own("fence.position", "fence.position", M, True)
own("fence.velocity", "fence.velocity", SPEED, True)
own("fence.clearance", "fence.clearance", M)
own("fence.margin", "fence.margin", M)

# z_b = z'_b + σ_b (paper, Eq. 5), with the height z'_b of the pitch at the plate.
bat_height = named(
    "z_b",
    switch(
        "kind",
        {"impact": I["incoming.bat_height"], "at-bat": component(plate, 2) + I["σ_b"]},
    ),
)
x, y, z = (component(place, i) for i in range(3))
offset = named("r - axis", vector(x, constant(0.0, M), z - bat_height))
reach = named("R + r_b", I["R"] + I["r_b"])
lever = named("r̃", I["L"] / 2.0 - y)  # the distance from the pivot B, which is at y = L/2
_apart = named("|r - axis|", norm(offset))
_swung = named("ω_bat·r̃", I["ω_bat"] * lever)
_third = I["L"] * I["L"] / 3.0
_twelfth = I["L"] * I["L"] / 12.0
_quarter = I["r_b"] * I["r_b"] / 4.0


def _moment(name: str, about: Node) -> Node:
    """The bat's moment of inertia M (about + r_b²/4), or as the reading has it."""
    return named(
        name,
        switch(
            "reading.inertia",
            {
                "solid_cylinder": I["M"] * (about + _quarter),
                "thin_rod": I["M"] * about,
                "about_centre": I["M"] * (_twelfth + _quarter),
            },
        ),
    )


inertia = _moment("I", _third)
_free_inertia = _moment("J_free", _twelfth)
# I/r̃, as printed in the paper, is not a mass: dividing by 1 m makes it one.
_printed = inertia / (lever * constant(1.0, M))
effective = named(
    "M_eff",
    switch(
        "bat.support",
        {
            "pivot": switch(
                "reading.effective_mass",
                {"inertia_over_r_squared": inertia / (lever * lever), "as_printed": _printed},
            ),
            "free": 1.0 / (1.0 / I["M"] + y * y / _free_inertia),
        },
    ),
)


def _reduced(a: Node, b: Node) -> Node:
    return a * b / (a + b)


_with_bat = _reduced(I["m"], I["M"])
_with_effective = _reduced(I["m"], effective)
# The reduced mass (paper, Appendix A). The paper has M in it, but M_eff in Eq. 10.
μ = named(
    "μ",
    switch(
        "reading.bat_ball_restitution",
        {
            "as_printed": switch(
                "reading.reduced_mass", {"bat_mass": _with_bat, "effective_mass": _with_effective}
            ),
            "nathan": _with_effective,
            "plain": _with_bat,
        },
    ),
)
ratio = named("m/M_eff", I["m"] / effective)
Ṽ = named("Ṽ", V - V_b)

# With friction (docs/model.md, "Oblique impact").
_across = switch("bat.support", {"pivot": inertia, "free": _free_inertia})
_along = I["M"] * (I["r_b"] * I["r_b"]) / 2.0
_pivoted = vector(constant(0.0, M), -lever, constant(0.0, M))
_centred = vector(constant(0.0, M), y, constant(0.0, M))
arm = named("r", switch("bat.support", {"pivot": _pivoted, "free": _centred}) + I["r_b"] * n)
ball_inertia = named("I_ball", I["β"] * I["m"] * (I["R"] * I["R"]))
_cosine_of_tilt, _sine_of_tilt = function("cos", I["θ"]), function("sin", I["θ"])
_swing = I["ω_bat"] * lever * vector(_cosine_of_tilt, constant(0.0), _sine_of_tilt)
swinging = named(
    "ω'",
    I["ω_bat"] * vector(-_sine_of_tilt, constant(0.0), _cosine_of_tilt),
)
_turning = cross(swinging, I["r_b"] * n)  # the bat's surface about its axis
slip = named("g", V + cross(spin_at, -(I["R"] * n)) - V_b - _turning)
slip_across = named("g_t", slip - dot(slip, n) * n)


def _of_rigid_bodies(a: Node) -> Node:
    """K applied to a vector, with the n·K n of the rigid bodies (docs/model.md)."""
    turned = cross(arm, a)
    shaken = vector(
        component(turned, 0) / _across,
        component(turned, 1) / _along,
        component(turned, 2) / _across,
    )
    moved = a / I["m"] + (I["R"] * I["R"] / ball_inertia) * (a - dot(n, a) * n) + cross(shaken, arm)
    return moved + switch(
        "bat.support", {"pivot": a * constant(0.0, (0, -1, 0)), "free": a / I["M"]}
    )


_rigid = matrix("K", _of_rigid_bodies(ARGUMENT))
_stiff = 1.0 / μ - dot(n, times(_rigid, n))


def mobility(a: Node) -> Node:
    """K applied to a vector, with 1/μ in place of n·K n.

    Without friction, the impulse is then that of the paper, Eq. 9.
    """
    return times(_rigid, a) + _stiff * dot(n, a) * n


# The gripping impulse solves K P = …, for the columns of K. It is kept while |P_t| ≤ μ_f P_n;
# otherwise, also if P_n is negative, the ball slides.
_columns = mobility(e_x), mobility(e_y), mobility(e_z)
grip = named(
    "P (grip)",
    solve(_columns, -((1.0 + ẽ) * dot(slip, n) * n + (1.0 + I["e_T"]) * slip_across)),
)
grip_across = named("P_t", grip - dot(grip, n) * n)
_held = I["μ_f"] * dot(grip, n) - norm(grip_across)
_pressure = named("|P_n|", norm(dot(grip, n) * n))
friction_margin = _held / (I["μ_f"] * _pressure)
_way = switch(
    "reading.slide_direction", {"initial": unit(slip_across), "final": -unit(grip_across)}
)
_slides = named("n - μ_f t̂", n - I["μ_f"] * _way)
slide = named("P (slide)", -((1.0 + ẽ) * dot(slip, n) / dot(n, mobility(_slides))) * _slides)
push = named("P", where(-_held, slide, grip))
# The stages after the impulse start from the candidate's own values. Along the normal, P is J n.
# Its part across the normal is the model's, because no candidate reports it. The stage of the spin
# uses P = m (V⁺ - V), which contains only reported values.
_own_push = J * n + (push - dot(push, n) * n)
_turned = (I["R"] / ball_inertia) * cross(n, I["m"] * (after - V))

# --- fences ---------------------------------------------------------------------------------------

# The chord next to the candidate's own point on the fence: its two ends, with the heights there.
_a, _b = symbol("chord.a", M, True), symbol("chord.b", M, True)
_chord = level(_b - _a)
_beside = level(at_fence - _a)
# The height of the fence is linear along the chord.
_passed = named("the distance from the chord's first corner", dot(_beside, unit(_chord)))
_length = named("the chord's length", norm(_chord))
_top = component(_a, 2) + named(
    "the fence's rise along the chord",
    (component(_b, 2) - component(_a, 2)) * (_passed / _length),
)
fence_top = named(
    "fence's height", switch("fence", {"a circle": constant(0.0, M), "a polyline": _top})
)
fence_side = switch(
    "fence",
    {
        "a circle": norm(level(at_fence)) - I["fence.radius"],
        "a polyline": named(
            "the distance beyond the chord", component(cross(unit(_chord), _beside), 2)
        ),
    },
)
_clear = switch("reading.fence_clearance", {"centre": constant(0.0, M), "surface": I["R"]})
_surface = switch("reading.ground_contact", {"centre": constant(0.0, M), "surface": I["R"]})
_launched_at = switch("kind", {"flight": given_position, "at-bat": place})
_origin = switch(
    "reading.distance_origin",
    {
        "plate": constant(0.0, M, True),
        "launch": _launched_at,
    },
)

_begun = named(
    "the time of the launch",
    switch("kind", {"flight": constant(0.0, S), "at-bat": contact_time}),
)
fence_flown = named("the time to the fence", fence_time - _begun)

# Other definitions that people use, and that no small edit of the right formula gives. Each one is
# in the pool of its stage (`Stage.pool`), where the operator `_others` finds it.
_in_space = vector(x, y, z - bat_height)
_sizes = I["m"] * (dot(after, after) - dot(V, V)) / 2.0
_ball = math.pi * 4.0 / 3.0 * (I["R"] * I["R"] * I["R"])
_displaced = switch("air", {"none": constant(0.0), "given": ρ * _ball / I["m"]})
# The saturation pressure by Magnus (WMO), Bolton and Tetens, in that order.
_vapours = tuple(
    named(f"{p:g}·exp({a:g}·t/({b:g} + t))", p * function("exp", a * celsius / (b + celsius)))
    for p, a, b in ((611.2, 17.62, 243.12), (611.2, 17.67, 243.5), (610.78, 17.27, 237.3))
)
# The density from the gas constants of dry air and water vapour, J/(kg K).
_humid = I["φ"] * vapour
_of_gases = named(
    "((p - φ·p_s)/287.05 + φ·p_s/461.5)/T", ((pressed - _humid) / 287.05 + _humid / 461.5) / I["T"]
)
_in_flight = (
    *_vapours,
    _of_gases,
    named("331.3 + 0.606·(T - 273.15)", (331.3 + 0.606 * celsius) * constant(1.0, SPEED)),
    named("g - ρ·V·g/m (buoyancy)", I["g"] * (1.0 - _displaced)),
    named("a/(1 + ρ·V/2m) (added mass)", LAW / (1.0 + _displaced / 2.0)),
    _unshifted,
    I["ground"],  # programs take heights above it
)
_from_launch = named("the distance from the launch", norm(level(landing - _launched_at)))
_leaving = switch("kind", {"flight": given_velocity, "at-bat": after})
_downrange = named(
    "the distance along the launch's heading", dot(landing - _launched_at, _heading(_leaving))
)
# The distance of the pitch from the bat's axis if its search ends at the plate: there it may still
# fall, for d·v = -σ_b v_z.
_at_plate = named("|σ_b|", function("abs", I["σ_b"], dimension=M))
_up_to_plate = named(
    "the closest distance up to the plate",
    where(I["σ_b"] * component(crossing, 2), _at_plate, closest),
)


# The fence as it is on maps of ballparks: its distance is linear in the bearing, not along a chord.
def _bearing(a: Node) -> Node:
    return function("atan2", component(a, 1), component(a, 0))


_share_of_angle = named(
    "the fraction of the chord's angle",
    (_bearing(at_fence) - _bearing(_a)) / (_bearing(_b) - _bearing(_a)),
)
_far_a, _far_b = norm(level(_a)), norm(level(_b))
_by_bearing = named(
    "the distance beyond a fence that is linear in the bearing",
    norm(level(at_fence)) - (_far_a + _share_of_angle * (_far_b - _far_a)),
)
# The gripping impulse with its part across cut to the cone, and its part along the normal kept.
_cut = named("P (grip) cut to the cone", dot(grip, n) * _slides)
OTHERWISE = {
    "normal": (named("(x, y, z - z_b)/|…|", unit(_in_space)),),
    "bat velocity": (
        named("L/2", I["L"] / 2.0), named("L/2 + y", I["L"] / 2.0 + y), -y,
        named("the velocity of the bat's surface", _swing + _turning),
    ),
    "normal speed": (named("V·n", dot(V, n)), named("-|Ṽ|", -norm(Ṽ))),
    "restitution": (
        named("L/2 + y", I["L"] / 2.0 + y), y,
        named("(e + ẽ)/2", (I["e"] + I["e"] * (1.0 + ratio) + ratio) / 2.0),
    ),
    "impulse": (
        named("(m + M)/2", (I["m"] + I["M"]) / 2.0), named("m + M", I["m"] + I["M"]),
        named("mM/√(m² + M²)", I["m"] * I["M"] / function(
            "sqrt", I["m"] * I["m"] + I["M"] * I["M"], dimension=KG
        )),
        named("V·n", dot(V, n)), named("-|Ṽ|", -norm(Ṽ)), _with_bat, _with_effective, _cut,
    ),
    "velocity after": (
        _cut,
        named("-ẽV", -(ẽ * V)), named("-eV", -(I["e"] * V)), _with_bat,
        named("V - (1 + ẽ)(V·n)n", V - (1.0 + ẽ) * dot(V, n) * n),
        named("V - (1 + ẽ)(Ṽ·n)n", V - (1.0 + ẽ) * w * n),
    ),
    "energy": (
        named("the ball's energy, m(V⁺² - V²)/2", _sizes), dot(V, n), _with_bat, _with_effective,
        named("(V⁺ - V_b)·n", dot(after - V_b, n)), I["e"], _cut,
    ),
    "distance": (_from_launch, _downrange, component(landing, 0), place, I["launch.position"]),
    "time": (plate_time,),
    "landing": (I["R"],),
    "plate": (reach,),
    "margin": (_at_plate, _up_to_plate),
    "fence margin": (_length,),
    "clearance": (_share_of_angle,),
    **dict.fromkeys(("pitch", "touching", "flight"), _in_flight),
    "fence": (*_in_flight, _by_bearing),
}  # fmt: skip

# --- the stages -----------------------------------------------------------------------------------

Kind = Literal["formula", "flight", "event"]


@dataclass(frozen=True)
class Stage:
    """A step of the calculation.

    Attributes
    ----------
    name
        Name in verdicts.
    quantities
        Computed quantities. Those of a flight are position, velocity, spin and path at its end.
    kind
        A "formula" has the root `value`. A "flight" has `place`, `velocity`, `spin`, `duration`,
        `rate` (of the place), `law` (the acceleration), `spin_left`, and `through` (the speed
        through the air, by which its path grows). An "event" has `zero`, which is 0 at the quantity
        given.
    roots
        Its expressions, by name.
    forms
        Equivalent forms of the roots, as other authors write them.
    scenes
        Kinds of scenes that have the stage.

    Examples
    --------
    A program whose bat is at rest has V·n for the normal speed:

    >>> (stage,) = (one for one in CHAIN if one.name == "normal speed")
    >>> stage.quantities, stage.kind, stage.roots
    (('contact.normal_speed',), 'formula', {'value': Ṽ · n})
    >>> stage.edited(Ṽ, V).roots
    {'value': V · n}
    """

    name: str
    quantities: tuple[str, ...]
    kind: Kind
    roots: Mapping[str, Node]
    forms: Mapping[str, tuple[Node, ...]] = field(default_factory=dict)
    scenes: tuple[str, ...] = ("flight", "at-bat")

    @property
    def key(self) -> tuple[str, Kind]:
        """Name and kind: an event and the flight that it ends may have one name."""
        return self.name, self.kind

    def edited(self, old: Node, new: Node) -> Stage:
        """The stage with one expression in place of another, in the roots that may contain it."""

        def changed(name: str, formula: Node) -> Node:
            return substitute(formula, old, new) if self.takes(name, new) else formula

        roots = {name: changed(name, root) for name, root in self.roots.items()}
        forms = {
            name: tuple(changed(name, form) for form in some) for name, some in self.forms.items()
        }
        same = all(roots[name] is root for name, root in self.roots.items())
        return self if same else replace(self, roots=roots, forms=forms)

    def takes(self, name: str, new: Node) -> bool:
        """True if a root may contain an expression: only those in flight have moving symbols."""
        return name in FLYING or not depends(new, IN_FLIGHT)

    @property
    def pool(self) -> tuple[Node, ...]:
        """Other definitions that people use at the stage.

        They are those of `OTHERWISE` and, in place of the crossing of the plate, the point aimed
        at.
        """
        straight = self.kind != "flight" and any(contains(x, plate) for x in self.roots.values())
        return (*OTHERWISE.get(self.name, ()), *(_aimed_at,) * straight)

    @property
    def spins(self) -> str:
        """The column of options of the switch `spin`: before the impact or after it."""
        return "spin" if "pitch" in self.scenes or self.name == "touching" else "spin after"

    def with_spin(self, columns: Mapping[str, Any]) -> dict[str, Any]:
        """Columns in which the switch `spin` has the options of the stage's ball."""
        return {**columns, "spin": columns[self.spins]}


_aim = vector(constant(0.0, M), I["aim_y"], I["aim_z"])
_towards = named("aim - release", _aim - given_position)


def _released(aimed: Node) -> Node:
    """The velocity at the release, from a form for pitches that are aimed."""
    return switch("pitch", {"aimed": aimed, "velocity": given_velocity})


_thrown = _released(I["V_0"] * unit(_towards))
_no_spin = constant(0.0, RATE, True)

# Where the pitch would cross the plate without forces.
_to_plate = component(given_position, 0) / component(given_velocity, 0)
_aimed_at = named(
    "the point aimed at",
    switch("pitch", {"aimed": _aim, "velocity": given_position - _to_plate * given_velocity}),
)

# A program may report another spin than it flies with. The law uses `spin_left` itself, so that an
# edit of this second name changes the reported spin alone.
_spin_reported = named("the share of the spin that is left", spin_left)


# A program may let the path grow by another speed than that of drag.
_speed_on_path = named("the speed along the path", U)


def _flight(duration: Node, place: Node, velocity: Node, spinning: Node) -> dict[str, Node]:
    return {
        "place": place, "velocity": velocity, "spin": spinning, "duration": duration,
        "rate": r_dot, "law": LAW, "spin_left": _spin_reported,
        "through": _speed_on_path,
    }  # fmt: skip


def _pitched(duration: Node) -> dict[str, Node]:
    turning = switch("spin", {"none": _no_spin, "given": given_spin})
    return _flight(duration, given_position, _thrown, turning)


def _batted(duration: Node) -> dict[str, Node]:
    return _flight(
        duration,
        _launched_at,
        _leaving,
        switch(
            "spin",
            {
                "none": _no_spin,
                "given": switch("kind", {"flight": given_spin, "at-bat": spin_after}),
            },
        ),
    )


def _formula(
    name: str, quantity: str, value: Node, scenes: tuple[str, ...] = ("flight", "at-bat")
) -> Stage:
    return Stage(name, (quantity,), "formula", {"value": value}, scenes=scenes)


_STRUCK = ("impact", "at-bat")
_forms = {"law": OTHER_FORMS, "rate": (vector(*_parts(r_dot)),)}
# Other forms of the velocity at the release: without a unit vector, and by the angle ε of the aim
# above the horizontal.
_by_parts = _released(I["V_0"] / norm(_towards) * _towards)
_flat_aim = named("(aim - release)_xy", level(_towards))
_rising = named("ε", function("atan", component(_towards, 2) / norm(_flat_aim)))
_by_angle = _released(
    I["V_0"] * (function("cos", _rising) * unit(_flat_aim))
    + I["V_0"] * function("sin", _rising) * e_z
)
_thrown_forms = _forms | {"velocity": (_by_parts, _by_angle)}

# The end of a flight has two stages. The flight computes the state at the candidate's own time; the
# event of the same name checks that the candidate's point lies on the plate, the bat, the fence or
# the ground. Two stages distinguish a wrong law from a wrong end. An impact scene has no pitch: its
# "touching" is a formula, the position that the scene gives.
CHAIN = (
    Stage(
        "pitch", ("plate.position", "plate.velocity"), "flight", _pitched(plate_time),
        _thrown_forms,
        ("pitch", "at-bat"),
    ),
    Stage(
        "plate", ("plate.position",), "event", {"zero": component(plate, 0)},
        scenes=("pitch", "at-bat"),
    ),
    _formula(
        "vertical approach", "plate.approach.vertical",
        function("atan2", component(crossing, 2), norm(level(crossing))), ("pitch", "at-bat"),
    ),
    _formula(
        "horizontal approach", "plate.approach.horizontal",
        function("atan2", component(crossing, 1), -component(crossing, 0)), ("pitch", "at-bat"),
    ),
    _formula("margin", "contact.margin", reach - closest, ("at-bat",)),
    Stage(
        "touching",
        ("contact.position", "contact.velocity", "contact.spin", "contact.path"),
        "flight", _pitched(contact_time), _thrown_forms, ("at-bat",),
    ),
    _formula("touching", "contact.position", given_position, ("impact",)),
    Stage(
        "touching", ("contact.position",), "event", {"zero": norm(offset) - reach},
        scenes=("at-bat",),
    ),
    Stage(
        "normal", ("contact.normal",), "formula", {"value": unit(offset)},
        {"value": (offset / reach, vector(x / _apart, constant(0.0), (z - bat_height) / _apart))},
        _STRUCK,
    ),
    Stage(
        "bat velocity", ("contact.bat_velocity",), "formula",
        {"value": _swing},
        {"value": (
            vector(_swung * _cosine_of_tilt, constant(0.0, SPEED), _swung * _sine_of_tilt),
        )},
        _STRUCK,
    ),
    _formula("normal speed", "contact.normal_speed", dot(Ṽ, n), _STRUCK),
    _formula(
        "restitution", "impact.restitution",
        # ẽ = e (1 + m/M_eff) + m/M_eff (paper, Eq. 10).
        switch(
            "reading.bat_ball_restitution",
            {"as_printed": I["e"] * (1.0 + ratio) + ratio, "nathan": I["e"], "plain": I["e"]},
        ),
        _STRUCK,
    ),
    _formula(
        "impulse", "impact.impulse",
        # F̄ Δt along the normal (paper, Eq. 9).
        switch("bat.friction", {"none": -(μ * (1.0 + ẽ) * w), "given": dot(push, n)}), _STRUCK,
    ),
    _formula(
        "velocity after", "impact.velocity",
        switch("bat.friction", {"none": V + J / I["m"] * n, "given": V + _own_push / I["m"]}),
        _STRUCK,
    ),
    _formula("friction margin", "impact.friction_margin", friction_margin, _STRUCK),
    _formula(
        "spin after", "impact.spin",
        switch("bat.friction", {"none": spin_at, "given": spin_at - _turned}), _STRUCK,
    ),
    _formula(
        "energy", "impact.energy_change",
        switch(
            "bat.friction",
            {
                "none": -(0.5 * μ * (1.0 - ẽ * ẽ) * (w * w)),
                "given": dot(push, slip + 0.5 * mobility(push)),
            },
        ),
        _STRUCK,
    ),
    Stage(
        "flight", ("landing.position", "landing.velocity", "landing.spin", "flight.path"), "flight",
        _batted(flown), _forms,
    ),
    Stage(
        "fence", ("fence.position", "fence.velocity"), "flight", _batted(fence_flown),
        _forms,
    ),
    Stage("fence", ("fence.position",), "event", {"zero": fence_side}),
    _formula("clearance", "fence.clearance", component(at_fence, 2) - fence_top - _clear),
    _formula(
        "fence margin", "fence.margin",
        named(
            "the distance to the nearer corner",
            function("least", _passed, _length - _passed, dimension=M),
        ),
    ),
    Stage(
        "landing", ("landing.position",), "event",
        {"zero": component(landing, 2) - (I["ground"] + _surface)},
    ),
    _formula(
        "landing angle", "landing.angle",
        function("atan2", -component(coming_down, 2), norm(level(coming_down))),
    ),
    _formula("apex time", "apex.time", _begun + rising),
    _formula("apex", "apex.position", highest),
    _formula("time", "landing.time", _begun + flown),
    _formula("hang time", "landing.hang_time", ended - _begun),
    _formula("distance", "landing.distance", norm(level(landing - _origin))),
    _formula("path", "landing.path", flown_path),
)  # fmt: skip

# --- the paper's scheme ---------------------------------------------------------------------------

# In the paper's scheme the ball meets the bat on a straight line from the last step before it, at
# t_k + τ with |d + v τ| = R + r_b; d runs from the bat's axis to the ball (Appendix B).
last_step = symbol("t_k", S)
_back = contact_time - last_step
# d at the last step, from the candidate's own contact back along the line.
_x, _z = x - component(V, 0) * _back, z - bat_height - component(V, 2) * _back
_v_x, _v_z = component(V, 0), component(V, 2)
_vv = named("v·v", _v_x * _v_x + _v_z * _v_z)
_dv = named("d·v", _x * _v_x + _z * _v_z)
_dd = named("d·d - (R + r_b)²", _x * _x + _z * _z - reach * reach)
# τ = ((d·d) - (R + r_b)²)/(-d·v + √…), the smaller root without cancellation; the other form of the
# stage is the usual formula.
_root = function("sqrt", _dv * _dv - _vv * _dd, dimension=(2, 0, -1))
_met = Stage(
    "contact time", ("contact.time",), "formula", {"value": last_step + _dd / (-_dv + _root)},
    {"value": (last_step + (-_dv - _root) / _vv,)}, ("at-bat",),
)  # fmt: skip
CHAIN_IN_STEPS = tuple(_met if stage.key == ("touching", "event") else stage for stage in CHAIN)
