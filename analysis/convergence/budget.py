"""The error budget of an at-bat: every part of the scheme alone against the reference.

Each part is an engine that is the reference but for that part, so that the chain stays the one
that is written once, and the parts can be added up and held against the whole.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np

from analysis.convergence.pieces import TRUTH, distance, each, golden, passing
from analysis.speed_error.work import batted
from analysis.writing import STYLES, Report
from longball.convergence.family import mean_over_phases
from longball.convergence.order import fit_power_law, typical
from longball.engines.engine import Engine, Launch, Stepped, Touch
from longball.engines.event import BatSection, Event, Events, first_met, plate
from longball.engines.ivp import Ivp
from longball.engines.path import Flight
from longball.engines.polynomial import PolynomialPiece
from longball.engines.verlet import SteppedTouch, Verlet, interpolate, line_touch
from longball.model.arrays import Array
from longball.model.frame import Frame
from longball.model.law import Law, State
from longball.model.numbers import DOUBLES, Vector
from longball.model.readings import VerletForces
from longball.model.scene import AtBatScene

SCENES, FULL_SCENES = 8, 60
PHASES, FULL_PHASES = 4, 16
SEED = 4
STEPS = [float(step) for step in np.geomspace(0.05, 1e-5, 14)]
SHOWN: tuple[VerletForces, ...] = ("old_carried", "implicit")

# The parts of the scheme, and their orders in theory; {} is the treatment of the force.
FORCE, HALF_FORCE, WHOLE = "force: {}", "half force over two steps: {}", "the whole: {}"
PLATE, LINE = "plate on the line between steps", "straight line to the contact"
GROUND, BELOW = "ground on the line between steps", "first point below the ground"
IN_THEORY = {
    **{FORCE.format("old_carried"): 1, FORCE.format("implicit"): 2, PLATE: 2, LINE: 1},
    **{HALF_FORCE.format(treatment): 1 for treatment in SHOWN},
    **{GROUND: 2, BELOW: 1},
}
# What the whole with a treatment of the force is made of.
ADDED = {x: (LINE, HALF_FORCE.format(x), FORCE.format(x), PLATE, GROUND) for x in SHOWN}

# What figures call them.
SAID = {"force": "steps in flight"}
TITLES = {
    "old_carried": "drag and lift at the old velocity",
    "implicit": "drag and lift at the new velocity",
}


# --- engines that are the reference but for one part ----------------------------------------------

LawOf = Callable[[Frame], Law]


class StruckAtOnce(Stepped):
    """The whole impulse at once, where the ball touches the bat."""

    def rebound(
        self, frame: Frame, touch: Any, delta_v: Vector, law_in: LawOf, ground: Event
    ) -> Launch:
        """Set the ball free; see `longball.engines.engine.Stepped`."""
        at: Any = touch.exact if isinstance(touch, LineTouch) else touch
        after = tuple(v + dv for v, dv in zip(frame.velocity(at.state), delta_v, strict=True))
        return Launch(frame.position(at.state), cast(Vector, after), at.time, 0.0)


@dataclass(frozen=True)
class LineTouch(Touch):
    """A touch at the end of a straight line, and the true one."""

    exact: Touch | None = None


@dataclass(frozen=True)
class Smooth(StruckAtOnce, Verlet):
    """Steps with a treatment of the force, and nothing lost between them.

    Between two steps runs the cubic through both positions and velocities, whose error is of the
    fourth order. The reference takes over from the last step before the bat.
    """

    def stop_between(
        self, count: int, before: State, after: State, events: Events
    ) -> tuple[str, float, State]:
        """Return the first event on the cubic."""
        ((x, v), (there, end)), h = np.reshape([before, after], (2, 2, -1)), self.dt
        slope = (there - x) / h
        square, cube = (3 * slope - 2 * v - end) / h, (v + end - 2 * slope) / h**2
        rows = [[x, v, square, cube], [v, 2 * square, 3 * cube, np.zeros(len(x))]]
        piece = PolynomialPiece((count - 1) * h, h, type(before), np.hstack(rows).T.copy())
        met = first_met([piece], events, (count + 1) * h, 0.0, DOUBLES)
        assert met is not None
        return met.event.name, met.time, met.state

    def touch(
        self, pitch: Flight, law: Law, bat: BatSection, events: Events, limit: float
    ) -> Touch:
        """Touch as the reference does, from a step that is surely before the bat."""
        near = pitch.path.at(0.0)
        early = pitch.time - 2 * bat.reach / pitch.state.u
        count = max(0, math.floor(early / self.dt))
        if count:
            near = self.fly(law, near, [], (count - 0.5) * self.dt).state
        rest = TRUTH.fly(law, near, [plate(bat.frame, near, DOUBLES)], limit)
        touch = TRUTH.touch(rest, law, bat, events, limit)
        time = None if touch.time is None else count * self.dt + touch.time
        return replace(touch, time=time)


@dataclass(frozen=True)
class ButOnePart(Ivp):
    """The reference, but for a part of a scheme."""

    scheme: Verlet = field(default_factory=Verlet)

    def steps_at(self, flight: Flight, time: float) -> tuple[float, State, State]:
        """Return the time of the step before a time, and the exact states there and at the next."""
        dt = self.scheme.dt
        count = math.floor(time / dt)
        return count * dt, flight.path.at(count * dt), flight.path.at((count + 1) * dt)


class PlateOnTheLine(ButOnePart):
    """The height at the plate from the line between two steps; all else exact."""

    def fly(self, law: Law, start: State, events: Events, limit: float) -> Flight:
        """Fly exactly, and report a pitch on the chord."""
        exact = super().fly(law, start, events, limit)
        if exact.stop != "plate":
            return exact
        _, before, after = self.steps_at(exact, exact.time)
        share = (exact.state.s - before.s) / (after.s - before.s)
        return replace(exact, state=exact.state._replace(z=interpolate(before.z, after.z, share)))

    def touch(
        self, pitch: Flight, law: Law, bat: BatSection, events: Events, limit: float
    ) -> Touch:
        """Touch on the exact path a bat that is put on the chord."""
        exact = replace(pitch, state=pitch.path.at(pitch.time))
        return super().touch(exact, law, bat, events, limit)


class StraightToTheBat(StruckAtOnce, ButOnePart):
    """The impulse from where a straight line from the step before leads to; all else exact.

    The ball goes on from where it really touches: of the line's end, the scheme uses nothing but
    normal, velocities and restitution.
    """

    def touch(
        self, pitch: Flight, law: Law, bat: BatSection, events: Events, limit: float
    ) -> Touch:
        """Touch as Appendix B does; see `longball.engines.engine.Engine.touch`."""
        exact = super().touch(pitch, law, bat, events, limit)
        assert exact.time is not None
        begin, before, _ = self.steps_at(pitch, exact.time)
        ahead = line_touch(before, bat, "first")
        if ahead is None:
            return replace(exact, touched=None, doubt="Appendix B has no Δt'")
        there = before._replace(s=before.s + before.u * ahead, z=before.z + before.w * ahead)
        return LineTouch(exact.margin, True, begin + ahead, there, exact=exact)


class HalfForce(ButOnePart, Stepped):
    """Half of the force over two steps, from the step before an exact contact; all else exact."""

    def touch(
        self, pitch: Flight, law: Law, bat: BatSection, events: Events, limit: float
    ) -> Touch:
        """Touch exactly, and remember the step before."""
        exact = super().touch(pitch, law, bat, events, limit)
        margin, time, state = exact.margin, exact.time, exact.state
        assert time is not None
        assert state is not None
        begin, before, _ = self.steps_at(pitch, time)
        count = round(begin / self.scheme.dt)
        ahead = time - begin
        return SteppedTouch(
            margin, True, time, state, step=count, before=before, inside=state, ahead=ahead
        )

    def rebound(
        self, frame: Frame, touch: Any, delta_v: Vector, law_in: LawOf, ground: Event
    ) -> Launch:
        """Push for two steps, as the scheme does."""
        return self.scheme.rebound(frame, touch, delta_v, law_in, ground)


@dataclass(frozen=True)
class GroundBetweenSteps(ButOnePart):
    """The landing from the steps around it, that are counted from the release; all else exact.

    It is found by the scheme's rule for the ground.
    """

    contact: float = 0.0  # s, when the flight that lands begins

    def fly(self, law: Law, start: State, events: Events, limit: float) -> Flight:
        """Fly exactly, and land by the scheme's rule."""
        exact = super().fly(law, start, events, limit)
        if [event.name for event in events] != ["ground"]:
            return exact
        dt = self.scheme.dt
        count = math.ceil((self.contact + exact.time) / dt)
        before = exact.path.at(max(0.0, (count - 1) * dt - self.contact))
        after = exact.path.at(count * dt - self.contact)
        _, time, state = self.scheme.stop_between(count, before, after, events)
        return replace(exact, time=time - self.contact, state=state)


# --- the budget -----------------------------------------------------------------------------------


def run(report: Report, full: bool) -> str:
    """Measure every part alone, and hold their sum against the whole."""
    count, phases = (FULL_SCENES, FULL_PHASES) if full else (SCENES, PHASES)
    scenes = batted(count, SEED)[0].scenes
    calls = [(scene, step, phases) for scene in scenes for step in STEPS]
    measured = each(report, "error budget", errors, calls)
    shape = (len(scenes), len(STEPS), phases)
    # By part: (scene, step, phase), m; the sum and what it leaves of the whole are parts too.
    parts = {
        name: np.array([found[name] for rows in measured for found in rows]).reshape(shape)
        for name in (*IN_THEORY, *map(WHOLE.format, SHOWN))
    }
    seen = {name: typical(rms(part)) for name, part in parts.items()}
    left = {}
    # The errors of the parts against the step, a panel a treatment.
    with report.figure("convergence_budget", rows=2, size=(6.4, 8.0)) as panels:
        for axes, (treatment, names) in zip(panels, ADDED.items(), strict=True):
            whole = WHOLE.format(treatment)
            left[treatment] = typical(rms(parts[whole] - sum(parts[name] for name in names)))
            axes.plot(STEPS, seen[whole], "k-", linewidth=2, label="the whole scheme")
            for name in names:
                part = name.removesuffix(f": {treatment}")
                line: Any = STYLES[part] | {"markersize": 4, "linewidth": 1}
                axes.plot(STEPS, seen[name], **line, label=SAID.get(part, part))
            axes.set(xscale="log", yscale="log", xlabel="step Δt, s", title=TITLES[treatment])
            axes.set_ylabel("error of the distance D, m")
        panels[1].sharey(panels[0])
        labels = panels[0].get_legend_handles_labels()
        panels[0].figure.legend(*labels, loc="outside lower center", ncols=2)
    laws = {name: fit_power_law(np.array(STEPS), of) for name, of in seen.items()}
    return report.render(
        "budget", globals(), scenes=len(scenes), phases=phases, seen=seen, laws=laws,
        left=left, largest=sorted(IN_THEORY, key=lambda name: -float(seen[name][0])),
        # Beyond a tenth and the interval.
        missed=[
            name for name, order in IN_THEORY.items()
            if not (law := laws[name]) or abs(law.order - order) > 0.1 + law.half_width
        ],
    )  # fmt: skip


def rms(errors: Array) -> Array:
    """Return the root mean square over phases of those that are there: (scene, step)."""
    return np.sqrt(mean_over_phases(errors**2))


def engines(forces: VerletForces, dt: float, contact: float) -> dict[str, Engine]:
    """Return the parts of the scheme with a treatment of the force, and the whole."""
    steps, below = Verlet(dt, forces), Verlet(dt, forces, "first_below")
    return {
        FORCE.format(forces): Smooth(dt, forces),
        PLATE: PlateOnTheLine(scheme=steps),
        LINE: StraightToTheBat(scheme=steps),
        HALF_FORCE.format(forces): HalfForce(scheme=steps),
        GROUND: GroundBetweenSteps(scheme=steps, contact=contact),
        BELOW: GroundBetweenSteps(scheme=below, contact=contact),
        WHOLE.format(forces): steps,
    }


def errors(scene: AtBatScene, step: float, phases: int) -> list[dict[str, float]]:
    """Return the errors of D, m, of every part, at steps that put one into the bat.

    The nominal step is changed so that a whole number of steps ends in the bat, `phases` times at
    different depths: what is measured is the error of contacts that are seen.
    """
    way = passing(scene)
    assert way is not None

    true, rows = distance(scene, TRUTH), []
    for share in golden(phases):
        inside = way.time + share * way.window
        dt = inside / max(1, round(inside / step))
        parts = {name: one for how in SHOWN for name, one in engines(how, dt, way.time).items()}
        rows.append({name: distance(scene, engine) - true for name, engine in parts.items()})
    return rows
