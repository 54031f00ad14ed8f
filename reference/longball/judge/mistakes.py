"""The library of known mistakes: what authors of such simulators get wrong, and how to mend it.

Each mistake is a small change that longball makes to itself: it wraps a solver of scenes into one
that makes the mistake. Wrapped around each other they make several at once. A mistake that has
more than one likely form has a variant for each.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from longball.engines.ivp import Ivp
from longball.model import trace
from longball.model.aerodynamics import DRAG, LIFT
from longball.model.force import Drag, Force, Motion, Term
from longball.model.frame import launch_frame
from longball.model.law import FORCES, GRAVITY, law_of
from longball.model.numbers import DOUBLES, Numbers, Vector
from longball.model.readings import Reading
from longball.model.result import Contact, Landing, Result
from longball.model.scene import (
    AtBatScene,
    FlightScene,
    ImpactScene,
    Launch,
    PitchScene,
    Scene,
    landing_height,
)


@dataclass(frozen=True)
class Solver:
    """How scenes are solved, with the mistakes made so far.

    Attributes
    ----------
    solve
        From a scene to its result.
    forces
        What acts on the ball.
    dt
        s, for mistakes that depend on a time step.
    """

    solve: Callable[[Scene], Result]
    forces: tuple[Term, ...] = FORCES
    dt: float = 0.0

    def making(self, variant: Variant) -> Solver:
        """Return the solver that makes one more mistake."""
        return replace(self, solve=lambda scene: variant.wrapper(scene, self))

    def moved(
        self,
        scene: FlightScene | PitchScene | AtBatScene,
        position: Sequence[Any],
        velocity: Sequence[Any],
        seconds: float,
    ) -> tuple[Vector[float], Vector[float]]:
        """Return position, m, and velocity, m/s, a step or less later or earlier."""
        frame, start = launch_frame(_floats(position), _floats(velocity), DOUBLES)
        law = law_of(scene, frame, DOUBLES, self.forces)
        # A Taylor series in time holds on both sides of where it is expanded.
        series = next(Ivp().path(law, law.state_of(start), scene.time_limit).pieces())
        state = series.at(seconds)
        return frame.position(state), frame.velocity(state)


def _unchanged(scene: Scene, solver: Solver) -> Result:
    return solver.solve(scene)


@dataclass(frozen=True)
class Variant:
    """One form of a mistake.

    Attributes
    ----------
    wrapper
        What is done to scenes and results: solves a scene with the mistake made.
    forces
        What acts on the ball, if not the model's forces.
    scheme
        Options of the engine verlet that the mistake sets: it is made by those who take fixed
        steps as the paper does.
    steps
        Whether the mistake depends on a time step.
    instant
        Whether the bat strikes at once, in a scheme that is else the paper's. Where that scheme is
        the truth no such form is looked for: it is another departure from it than its mistake's.
    """

    wrapper: Callable[[Scene, Solver], Result] = _unchanged
    forces: tuple[Term, ...] | None = None
    scheme: Mapping[str, str] | None = None
    steps: bool = False
    instant: bool = False


@dataclass(frozen=True)
class Mistake:
    """A known mistake.

    Attributes
    ----------
    name
        For programs.
    sentence
        What the candidate does, said to its author.
    remedy
        How to mend it.
    variants
        Its forms.
    """

    name: str
    sentence: str
    remedy: str
    variants: tuple[Variant, ...]


# --- changed forces -------------------------------------------------------------------------------


# ``-k v``
DRAG_WITH_V = Drag(("drag",), DRAG.strengths, lambda motion, p: p.drag)


# m/s. A series in time cannot go through the kink of |c| at c = 0. What stands for it has none, and
# is too large by less than SMALL⁴/(8 |c|³): a flight is off by less than 1e-9 of its length. Closer
# to the kink, the high coefficients of a series would leave the range of doubles.
SMALL = 1e-3


def _drag_and_axes(scene: Any, frame: Any, numbers: Numbers[Any]) -> tuple[Any, ...] | None:
    drag = DRAG.strengths(scene, frame, numbers)
    return drag and (*drag, frame.cos, frame.sin, numbers.exact(SMALL))


def _drag_by_component(motion: Motion, p: Any) -> Vector[Any]:
    """Return ``-k |c| c`` for each component c along the axes of space."""
    u, v, w = motion.velocity
    x, y, z = (
        -p.drag * (c * c + p.small * p.small / 2) / trace.sqrt(c * c + p.small * p.small) * c
        for c in (p.cos * u - p.sin * v, p.sin * u + p.cos * v, w)
    )
    return p.cos * x + p.sin * y, p.cos * y - p.sin * x, z


DRAG_BY_COMPONENT = Force(("drag", "cos", "sin", "small"), _drag_and_axes, _drag_by_component)


# --- changed scenes -------------------------------------------------------------------------------


def _changed(change: Callable[[Scene], Scene]) -> Variant:
    return Variant(lambda scene, solver: solver.solve(change(scene)))


def _with(scene: Any, block: str, **values: object) -> Any:
    """Return a scene with other values in a block; as it is if it has no such block.

    It is not validated: who makes a mistake in a number does not notice that a launch is now
    underground, or a ball inside the bat.
    """
    held = getattr(scene, block, None)
    if held is None:
        return scene
    return scene.model_copy(update={block: held.model_copy(update=values)})


def _gravity(value: float) -> Variant:
    def change(scene: Scene) -> Scene:
        return (
            scene if isinstance(scene, ImpactScene) else scene.model_copy(update={"gravity": value})
        )

    return _changed(change)


def _density(value: float) -> Variant:
    return _changed(lambda scene: _with(scene, "air", density=value))


def _times(block: str, key: str, factor: float) -> Variant:
    """Return the mistake of a value that is so many times too large."""

    def change(scene: Any) -> Any:
        held = getattr(scene, block, None)
        return scene if held is None else _with(scene, block, **{key: getattr(held, key) * factor})

    return _changed(change)


def _reading(**switches: str) -> Variant:
    """Return the mistake of another reading.

    Its solver raises ValueError where the reading contradicts another mistake's.
    """

    def change(scene: Scene) -> Scene:
        reading = Reading.model_validate(scene.reading.model_dump() | switches)
        return scene.model_copy(update={"reading": reading})

    return _changed(change)


def _other_pivot(direction: float) -> Variant:
    """Return the mistake of r̃ measured from the bat's end A: the mirror image of the right thing.

    `direction` -1: with ω × r̃ computed from there, which also turns the bat's velocity round.
    """

    def wrapper(scene: Scene, solver: Solver) -> Result:
        if not isinstance(scene, AtBatScene | ImpactScene):
            return solver.solve(scene)
        mirrored = _mirrored(scene)
        speed = direction * scene.swing.angular_speed
        return _mirrored_result(solver.solve(_with(mirrored, "swing", angular_speed=speed)))

    return Variant(wrapper)


def _mirrored(scene: AtBatScene | ImpactScene) -> Any:
    if isinstance(scene, ImpactScene):
        incoming = scene.incoming
        return _with(
            scene,
            "incoming",
            position=_left_right(incoming.position),
            velocity=_left_right(incoming.velocity),
        )
    aim_y, aim_z = scene.pitch.aim
    release = _left_right(scene.pitch.release)
    return _with(scene, "pitch", release=release, aim=(-aim_y, aim_z))


def _left_right(vector: Any) -> Any:
    x, y, z = vector
    return x, -y, z


def _mirrored_result(result: Result) -> Result:
    blocks = {}
    for block in ("plate", "contact", "impact", "landing"):
        if (held := getattr(result, block)) is not None:
            vectors = {k: v for k, v in held if isinstance(v, tuple)}
            turned = {k: _left_right(v) for k, v in vectors.items()}
            blocks[block] = held.model_copy(update=turned)
    return result.model_copy(update=blocks)


# --- changed results ------------------------------------------------------------------------------


def _distance_from(contact_only: bool) -> Variant:
    """Return the mistake of D measured from where the batted ball starts."""

    def wrapper(scene: Scene, solver: Solver) -> Result:
        result = solver.solve(scene)
        if result.landing is None:
            return result
        if result.contact is not None and result.contact.position is not None:
            start = _floats(result.contact.position)
        elif isinstance(scene, FlightScene) and not contact_only:
            start = scene.launch.position
        else:
            return result
        x, y, _ = _floats(result.landing.position)
        distance = math.hypot(x - start[0], y - start[1])
        landing = result.landing.model_copy(update={"distance": distance})
        return result.model_copy(update={"landing": landing})

    return Variant(wrapper)


def _first_below(since_start: bool, on_floor: bool) -> Variant:
    """Return the mistake of a landing at the first step that is below the ground.

    The steps are counted from the start of the scene, or from launch or contact; the height may
    be reported as that of the ground all the same.
    """

    def wrapper(scene: Scene, solver: Solver) -> Result:
        result = solver.solve(scene)
        if result.landing is None or isinstance(scene, ImpactScene | PitchScene):
            return result
        landing = result.landing
        time, hang_time = float(landing.time), float(landing.hang_time)
        count = time if since_start else hang_time
        late = math.ceil(count / solver.dt) * solver.dt - count
        position, velocity = solver.moved(scene, landing.position, landing.velocity, late)
        below = Landing(
            time=time + late,
            hang_time=hang_time + late,
            position=position,
            velocity=velocity,
            distance=math.hypot(position[0], position[1]),
        )
        result = result.model_copy(update={"landing": below})
        return _on_floor(scene, result) if on_floor else result

    return Variant(wrapper, steps=True)


def _on_floor(scene: Scene, result: Result) -> Result:
    """Return a result in which the ball lands at the height of the ground, whatever it was."""
    if result.landing is None or isinstance(scene, ImpactScene | PitchScene):
        return result
    x, y, _ = result.landing.position
    landing = result.landing.model_copy(update={"position": (x, y, landing_height(scene))})
    return result.model_copy(update={"landing": landing})


def _strike_at_once(scene: Scene, solver: Solver) -> Result:
    """Let the ball fly on from the touching, with steps counted from there: no push that lasts."""
    result = solver.solve(scene)
    contact, impact, landing = result.contact, result.impact, result.landing
    if not isinstance(scene, AtBatScene) or not (contact and impact and landing):
        return result
    if contact.time is None or contact.position is None:
        return result
    launch = Launch(position=_floats(contact.position), velocity=_floats(impact.velocity))
    same = {k: v for k, v in scene if k in FlightScene.model_fields and k != "kind"}
    batted = solver.solve(FlightScene(**same, launch=launch)).landing
    if batted is not None:
        batted = batted.model_copy(update={"time": float(contact.time) + float(batted.time)})
    return result.model_copy(update={"landing": batted})


def _separating(scene: Scene, solver: Solver) -> Result:
    """Find ball and bat parting where the ball leaves the bat: no force, and no batted ball."""
    result = solver.solve(scene)
    if result.impact is None or not isinstance(scene, AtBatScene):
        return result
    return result.model_copy(update={"outcome": "separating", "impact": None, "landing": None})


def _linear_plate(scene: Scene, solver: Solver) -> Result:
    """Put the plate on the straight line between the steps on its two sides, and the bat there."""
    result = solver.solve(scene)
    if result.plate is None or not isinstance(scene, PitchScene | AtBatScene):
        return result
    plate, dt = result.plate, solver.dt
    time = float(plate.time)
    before = math.floor(time / dt) * dt
    ends = [
        solver.moved(scene, plate.position, plate.velocity, t - time) for t in (before, before + dt)
    ]
    (x0, y0, z0), (x1, y1, z1) = ends[0][0], ends[1][0]
    share = x0 / (x0 - x1)
    straight = plate.model_copy(
        update={
            "time": before + share * dt,
            "position": (0.0, y0 + share * (y1 - y0), z0 + share * (z1 - z0)),
            "velocity": tuple(
                a + share * (b - a) for a, b in zip(ends[0][1], ends[1][1], strict=True)
            ),
        }
    )
    if isinstance(scene, AtBatScene):
        higher = float(straight.position[2]) - float(plate.position[2])
        offset = scene.swing.height_offset + higher
        result = solver.solve(_with(scene, "swing", height_offset=offset))
    return result.model_copy(update={"plate": straight})


def _tunnel(scene: Scene, solver: Solver) -> Result:
    """Look for the bat at the steps only, and miss it where none falls into it."""
    result = solver.solve(scene)
    contact, impact, plate = result.contact, result.impact, result.plate
    if not isinstance(scene, AtBatScene) or not (contact and impact and plate):
        return result
    if contact.time is None or contact.position is None or contact.normal is None:
        return result
    delta_v = float(impact.impulse) / scene.ball.mass
    incoming = tuple(
        after - delta_v * n
        for after, n in zip(_floats(impact.velocity), _floats(contact.normal), strict=True)
    )
    time, dt = float(contact.time), solver.dt
    next_step = math.ceil(time / dt) * dt
    height = float(plate.position[2]) + scene.swing.height_offset
    reach = scene.ball.radius + scene.bat.radius
    distances = []
    for step in (next_step - dt, next_step):
        (x, _, z), _ = solver.moved(scene, contact.position, incoming, step - time)
        distances.append(math.hypot(x, z - height))
    if distances[1] < reach:
        return result
    return Result(
        id=result.id,
        outcome="missed",
        plate=plate,
        contact=Contact(margin=reach - min(distances)),
    )


def _floats(vector: Any) -> tuple[float, float, float]:
    x, y, z = map(float, vector)
    return x, y, z


# --- the library ----------------------------------------------------------------------------------


def _scheme(**switches: str) -> Variant:
    return Variant(scheme=switches, steps=True)


def _struck_at_once(forces: str) -> Variant:
    return Variant(_strike_at_once, scheme={"forces": forces}, steps=True, instant=True)


# What fixed steps do at best, with one of the treatments of the forces that are of order 2.
NO_SLIP = "verlet-steps"
SOUND = ("predicted_recomputed", "predicted_carried", "implicit")


KNOWN: dict[str, Mistake] = {
    mistake.name: mistake
    for mistake in (
        Mistake(
            "lagged-verlet",
            "takes drag and lift at the velocity of the step before",
            "predict the velocity at the step's end, v + aΔt, or iterate, before asking for the "
            "force there: the error then falls with Δt² instead of Δt",
            (
                _scheme(forces="old_carried"),
                _scheme(forces="old_recomputed"),
                _struck_at_once("old_carried"),
                _struck_at_once("old_recomputed"),
            ),
        ),
        Mistake(
            "half-step-verlet",
            "takes drag and lift at the half-step velocity, as is usual in molecular dynamics, "
            "where forces do not depend on it",
            "predict the velocity at the step's end, v½ + aΔt/2, before asking for the force there",
            (_scheme(forces="half_step"), _struck_at_once("half_step")),
        ),
        Mistake(
            NO_SLIP,
            "flies in steps of velocity Verlet; the error is that of the steps, and falls with Δt²",
            "this is no slip: take shorter steps, or a method of higher order",
            tuple(map(_struck_at_once, SOUND)),
        ),
        Mistake(
            "two-step-push",
            "lets the bat push for two steps, as Appendix B has it, while the ball flies on",
            "strike at once, at the time and place of touching; only the impulse is meant",
            tuple(_scheme(forces=forces) for forces in SOUND),
        ),
        Mistake(
            "first-below",
            "lets the ball land at the first step that is below the ground",
            "interpolate to the ground between the last two steps",
            (
                _first_below(since_start=True, on_floor=False),
                _first_below(since_start=True, on_floor=True),
                _first_below(since_start=False, on_floor=False),
                _first_below(since_start=False, on_floor=True),
                _scheme(forces="predicted_recomputed", landing="first_below"),
                Variant(
                    lambda scene, solver: _on_floor(scene, solver.solve(scene)),
                    scheme={
                        "forces": "predicted_recomputed",
                        "landing": "first_below",
                    },
                    steps=True,
                ),
            ),
        ),
        Mistake(
            "linear-plate",
            "takes the height of the pitch at the plate from the straight line between two steps",
            "step onto the plane x = 0: the last step's length follows from x and its velocity",
            (Variant(_linear_plate, steps=True),),
        ),
        Mistake(
            "tunnelling",
            "looks for the bat at its steps only, and misses it between two of them",
            "find the closest approach within the step, where d·v changes sign, and test there",
            (Variant(_tunnel, steps=True),),
        ),
        Mistake(
            "larger-root",
            "takes the larger root of Appendix B's quadratic: where the ball would leave the bat",
            "take the smaller of the two positive roots",
            (
                _scheme(forces="predicted_recomputed", root="larger"),
                Variant(
                    _separating,
                    scheme={"forces": "predicted_recomputed", "root": "larger"},
                    steps=True,
                ),
            ),
        ),
        Mistake(
            "drag-per-component",
            "drags each component by itself, with its own square",
            "the drag is -k V v: every component times the whole speed V",
            (Variant(forces=(DRAG_BY_COMPONENT, LIFT, GRAVITY)),),
        ),
        Mistake(
            "drag-with-v",
            "lets the drag grow with V, not with V²",
            "the drag is ½ C_D ρ A V², against the velocity",
            (Variant(forces=(DRAG_WITH_V, LIFT, GRAVITY)),),
        ),
        Mistake(
            "lift-sign",
            "lifts the ball the wrong way",
            "with backspin the lift turns the velocity upwards: k_L V (-w, u) in the flight plane",
            (_times("air", "lift_coefficient", -1.0),),
        ),
        Mistake(
            "lift-always-up",
            "keeps the lift on the upper side of the path, beyond the vertical too",
            "fix the spin axis at launch, or ask for the reading lift_direction = always_up",
            (_reading(lift_direction="always_up"),),
        ),
        Mistake(
            "plain-restitution",
            "uses e where ẽ belongs",
            "ẽ = e(1 + m/M_eff) + m/M_eff, M_eff = I/r̃²",
            (_reading(bat_ball_restitution="plain"),),
        ),
        Mistake(
            "nathan",
            "uses Nathan's formula: e with the effective mass in μ",
            "the paper prints ẽ = e(1 + m/M_eff) + m/M_eff with μ from the bat's mass M",
            (_reading(bat_ball_restitution="nathan"),),
        ),
        Mistake(
            "effective-mass",
            "takes M_eff = I/r̃, as printed, which is no mass",
            "M_eff = I/r̃²",
            (_reading(effective_mass="as_printed"),),
        ),
        Mistake(
            "reduced-mass",
            "takes μ from M_eff",
            "1/μ = 1/m + 1/M, with the bat's mass M",
            (_reading(reduced_mass="effective_mass"),),
        ),
        Mistake(
            "thin-rod",
            "takes the bat for a thin rod",
            "about its end a solid cylinder has I = M(L²/3 + r_b²/4)",
            (_reading(inertia="thin_rod"),),
        ),
        Mistake(
            "inertia-about-centre",
            "takes the bat's moment of inertia about its centre",
            "the swing turns about the end B: I = M(L²/3 + r_b²/4)",
            (_reading(inertia="about_centre"),),
        ),
        Mistake(
            "other-pivot",
            "lets the bat turn about its end A, at y = -L/2",
            "the pivot B is at y = +L/2: r̃ = L/2 - y",
            (_other_pivot(1.0), _other_pivot(-1.0)),
        ),
        Mistake(
            "tilt-in-degrees",
            "takes the tilt of the swing for degrees, or turns it into degrees",
            "swing.tilt is in radians",
            (
                _times("swing", "tilt", math.pi / 180),
                _times("swing", "tilt", 180 / math.pi),
            ),
        ),
        Mistake(
            "speed-in-km/h",
            "takes the speed of the pitch for km/h, or turns it into km/h",
            "pitch.speed is in m/s",
            (_times("pitch", "speed", 1 / 3.6), _times("pitch", "speed", 3.6)),
        ),
        Mistake(
            "radius-or-diameter",
            "takes the radius of the ball for its diameter, or the other way round",
            "0.0366 m is the ball's radius, though the paper calls it a diameter",
            (_times("ball", "radius", 2.0), _times("ball", "radius", 0.5)),
        ),
        Mistake(
            "g-9.81",
            "falls with g = 9.81 m/s²",
            "take the scene's gravity; the paper's is 9.8 m/s²",
            (_gravity(9.81), _gravity(9.80665)),
        ),
        Mistake(
            "air-1.225",
            "flies in air of 1.225 kg/m³",
            "take the scene's density; the paper's is 1.29 kg/m³",
            (_density(1.225),),
        ),
        Mistake(
            "air-1.2",
            "flies in air of 1.2 kg/m³",
            "take the scene's density; the paper's is 1.29 kg/m³",
            (_density(1.2), _density(1.204)),
        ),
        Mistake(
            "distance-from-contact",
            "measures the distance from where the ball was met, not from the plate",
            "D is the horizontal distance from the origin to the landing",
            (_distance_from(contact_only=True), _distance_from(contact_only=False)),
        ),
        Mistake(
            "landing-of-surface",
            "lets the ball land when its surface touches the ground, at z = R",
            "the ball lands when its centre reaches the ground, unless the reading ground_contact "
            "says otherwise",
            (_reading(ground_contact="surface"),),
        ),
    )
}

# This one shows in the numbers themselves and not in their errors; see `longball.judge.search`.
SINGLE = Mistake(
    "single-precision",
    "computes or writes in single precision",
    "use doubles throughout, and write them with 17 digits",
    (),
)
