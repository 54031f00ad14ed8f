"""Explanations of when and where a flight ends, where the path itself is the true one.

Events that are met too early or late, at another height, only at the steps, on the line between
two of them; and times that are counted otherwise than the places they belong to.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from decimal import Decimal
from statistics import median

import numpy as np

from longball.judge.explanations import (
    Explanation,
    Seen,
    Sought,
    evenly,
    share_by,
    share_left,
    size_of,
)
from longball.judge.findings import many
from longball.judge.fits import told
from longball.judge.relations import DOUBLES as ALL_DIGITS
from longball.judge.relations import FEW_DECIMALS
from longball.judge.stages import (
    ENOUGH,
    NOWHERE,
    Change,
    Check,
    Numbers,
    Placed,
    Trial,
    Trials,
    follow,
    placed,
    view_values,
)
from longball.judge.steps import ROUND_STEPS, SHORTEST, FixedStep, common_step
from longball.model.arrays import Array
from longball.model.scene import landing_height

SAME = 1e-6  # relative: how little ends differ that are always as far off
FEW_OTHERS = 0.05  # of the ends, how many may be elsewhere for another reason


def _begin(trial: Trial) -> Numbers:
    """Return where the ball that lands is set free, m; NaN if that is not told."""
    flight = trial.scene.kind == "flight"
    held = trial.scene.launch.position if flight else trial.given.get("contact.position", NOWHERE)
    return tuple(held)


def _stays(trial: Trial) -> bool:
    """Tell whether a flight lands where, and when, it begins."""
    hang = trial.given.get("landing.hang_time", trial.given.get("landing.time"))
    return trial.given["landing.position"] == _begin(trial) and hang == (0.0,)


# Of a flight's end: the axis across the surface, the velocity there, and what the surface is.
_ENDS = {
    "landing": (2, "landing.velocity", "the ground"),
    "plate": (0, "plate.velocity", "the plate"),
}


def ends(stage: str, chosen: Seen, trials: Trials, dt: float | None) -> Iterator[Explanation]:
    """Yield where the ball is when a candidate says that it lands, or is at the "plate"."""
    # `chosen` are those of `trials` in which that fails; `dt` is the step in s, if it is known.
    event, wrong = chosen[0][1][0].quantity, [t for t, _ in chosen]
    offs = np.array([c.obtained[0] - c.expected[0] for _, cs in chosen for c in cs[:1]])
    landing = stage == "landing"
    if landing and all(map(_stays, wrong)):
        yield Explanation(
            "landing-is-launch", "gives the launch as the landing", "look for the ground behind "
            "the launch, and say airborne where it is not reached", quantity=event,
        )  # fmt: skip
    elif landing and all(
        t.given.get("fence.position") == t.given["landing.position"] for t in wrong
    ):
        yield Explanation(
            "landing-at-fence", "gives the place where the ball crosses the fence for the landing",
            "let the ball fly on to the ground", quantity=event,
        )  # fmt: skip
    elif landing:
        above = [_begin(t)[2] - landing_height(t.scene) for t in wrong]
        if any(above) and np.allclose(offs, above, rtol=1e-6, atol=1e-9):
            yield Explanation(
                "lands-at-launch-height", "lands at the height that it was launched from",
                "the ball lands at ground.height", quantity=event,
            )  # fmt: skip
    # Those of one scene, or that are always the same, are no steps'.
    if len(offs) < 2 or np.ptp(offs) <= SAME * np.abs(offs).max():
        return
    yield from _at_steps(stage, wrong, offs, dt or grid(stage, trials))


def _apart(way: Numbers, along: Numbers) -> float:
    """Return how far the ball is past the place where it is nearest to the bat's axis, m."""
    return way[0] * along[0] + way[2] * along[2]


# What is zero where a candidate may let ball and bat touch instead: from the place of the ball
# beside the bat's axis and along it (x, y, z), m, R + r_b, and the direction of its velocity.
_CONTACTS: tuple[tuple[str, str, str, Callable[[Numbers, float, Numbers], float]], ...] = (
    ("touches-at-plate", "puts the contact where the ball crosses the plate",
     "the contact is where the ball is R + r_b from the bat's axis",
     lambda way, reach, along: way[0]),
    ("touches-closest", "puts the contact where the ball is nearest to the bat's axis",
     "the contact is where the ball comes to be R + r_b from the bat's axis",
     lambda way, reach, along: _apart(way, along)),
    ("touches-last", "puts the contact where ball and bat part again",
     "the contact is where the ball comes to be R + r_b from the bat's axis", lambda way, reach,
     along: math.hypot(way[0], way[2]) - reach if _apart(way, along) > 0 else math.inf),
)  # fmt: skip


_AT = "contact.position: event", "contact.time"


def touchings(wrong: Seen, base: Change) -> Iterator[Explanation]:
    """Yield where else ball and bat touch, if that is so in every scene with such an error."""
    ways = _contacts(wrong, base)
    for name, sentence, remedy, off in _CONTACTS if ways else ():
        if all(abs(off(way, reach, along)) <= 1e-7 * reach for way, reach, along in ways):
            yield Explanation(name, sentence, remedy)


def _contacts(wrong: Seen, base: Change) -> list[tuple[Numbers, float, Numbers]]:
    """Return what `_CONTACTS` take, of contacts that are elsewhere; none of a few of them."""
    told_at = [t for t, cs in wrong if any(not c.follows and c.quantity in _AT for c in cs)]
    if len(told_at) < ENOUGH or any("contact.position" not in t.given for t in told_at):
        return []
    ways: list[tuple[Numbers, float, Numbers]] = []
    for trial in told_at:
        scene, _, before, height = view_values(trial, base, "contact.normal")
        x, y, z = trial.given["contact.position"]
        if any(before):  # nothing is said of the velocity beyond the bat's ends
            along = tuple(v / math.hypot(*before) for v in before)
            ways.append(((x, y, z - height), scene.ball.radius + scene.bat.radius, along))
    return ways


def reaches(wrong: Seen, base: Change) -> Iterator[Explanation]:
    """Yield another distance at which ball and bat touch, in m or beside R + r_b."""
    ways = _contacts(wrong, base)
    apart = [math.hypot(x, z) for (x, _, z), _, _ in ways]
    shares = [d / reach for d, (_, reach, _) in zip(apart, ways, strict=True)]
    for unit, values in ((" m", apart), (" (R + r_b)", shares)):
        middle = median(values or [0.0])
        if middle and max(abs(x - middle) for x in values) <= 1e-7 * middle:
            yield Explanation(
                f"touches-at-{middle:.6g}{unit}", "lets ball and bat touch where the ball's centre "
                f"is {middle:.6g}{unit} from the bat's axis", "they touch at R + r_b",
            )  # fmt: skip
            return


def contacts_at_steps(wrong: Seen) -> Iterator[Explanation]:
    """Yield that contacts are on the ball's way, and as late or early as the ends of steps are."""
    failing = [c for _, cs in wrong for c in cs if not c.follows]
    lags = [c.obtained[0] - c.expected[0] for c in failing if c.quantity == "contact.time"]
    if len(lags) < ENOUGH or any(c.quantity == "contact.position" for c in failing):
        return
    least, most = np.quantile(np.abs(lags), (0.1, 1.0))
    for name, side, where in (
        ("late", 1, "after it, as at the end of its step"),
        ("early", -1, "before it, as at the step before"),
    ):
        # The ends of steps are anywhere within a step.
        if least < most / 3 and np.mean(side * np.array(lags) > 0) >= 1 - FEW_OTHERS:
            yield Explanation(
                f"contact-{name}", "gives for the contact where the ball is up to "
                f"{most:.2g} s {where}", "find the time of touching within the step, and the state "
                "there", rank=2,
            )  # fmt: skip


def fences(wrong: Seen, base: Change) -> Iterator[Explanation]:
    """Yield what is wrong with when or where a ball passes the fence."""

    def mend(trial: Trial) -> Trial:
        time, begin = trial.given.get("fence.time"), trial.given.get("contact.time")
        if time is None or begin is None:
            return trial
        return trial.saying({"fence.time": (time[0] + begin[0],)})

    left = share_by(wrong, lambda t, _: sum(map(size_of, follow(mend(t), base, ("fence",)))))
    yield Explanation(
        "fence-time-since-contact", "counts fence.time from the contact",
        "fence.time is since the start of the scene", left, mend=mend,
    )  # fmt: skip


def _at_steps(
    stage: str, trials: Trials, offs: np.ndarray, dt: float | None
) -> Iterator[Explanation]:
    """Yield that a flight ends at a step, if all ends are nearer to the surface than a step."""
    axis, velocity, _ = _ENDS[stage]
    speeds = [abs(t.given[velocity][axis]) if velocity in t.given else math.inf for t in trials]
    side = 1 if offs.min() >= 0 else -1 if offs.max() <= 0 else 0
    share = 1.1 if side else 0.6  # of a step, how far its end may be
    if dt is None or any(abs(o) > share * v * dt for o, v in zip(offs, speeds, strict=True)):
        return
    name, where = {
        ("landing", -1): ("first-below", "first step below the ground"),
        ("landing", 0): ("nearest", "step nearest to the ground"),
        ("landing", 1): ("last-above", "last step above the ground"),
        ("plate", -1): ("first-below-x", "first step behind the plate"),
        ("plate", 0): ("nearest-x", "step nearest to the plate"),
        ("plate", 1): ("last-above-x", "last step in front of the plate"),
    }[stage, side]
    yield Explanation(
        name, f"ends the flight at the {where}, in steps of {dt:.6g} s: by up to "
        f"{np.abs(offs).max():.2g} m",
        "interpolate to the surface between the last two steps, in time and velocity too",
        0.0, 1, quantity=f"{stage}.position: event", step=dt,
    )  # fmt: skip


_LOOSE = 1e-5  # s: an end nearer to the surface than this is that of a root found no better


def beside_surface(stage: str, wrong: Seen) -> Iterator[Explanation]:
    """Yield by how much flights that follow go on behind the surface, or end before it."""
    axis, name, where = _ENDS[stage]
    offs, late = [], []
    for trial, (check, *_) in wrong:
        speed = abs(trial.given.get(name, (0.0, 0.0, 0.0))[axis])
        offs.append(check.obtained[0] - check.expected[0])
        late.append(-offs[-1] / speed if speed else math.inf)
    low, high = min(offs), max(offs)
    if len(offs) > 1 and high - low <= SAME * max(abs(low), abs(high)):
        size = told(float(np.mean(offs)), (high - low) / 2)
        yield Explanation(
            f"{stage}-offset", f"ends the flight {size} m off {where}, always", None, 0.0, 1,
            quantity=f"{stage}.position: event",
        )  # fmt: skip
        return
    known = [*filter(math.isfinite, late)]  # a ball that all but grazes the surface tells nothing
    if len(known) < max(ENOUGH, (1 - FEW_OTHERS) * len(late)):
        return
    late = known
    side = "behind" if min(late) > 0 else "before" if max(late) < 0 else "before or behind"
    most = max(map(abs, late))
    loose = "; a root is found no better" if most < _LOOSE else ""
    yield Explanation(
        f"{stage}-beside-surface", f"ends the flight up to {most:.1e} s {side} {where}, by up to "
        f"{max(map(abs, offs)):.1e} m{loose}", "find the time of the end, and the state there, to "
        "the last digits: no step, and no root of a loose tolerance, is there",
        quantity=f"{stage}.position: event",
    )  # fmt: skip


def grid(stage: str, trials: Trials) -> float | None:
    """Return the step of which all times of a stage are multiples."""
    landing = ("landing.hang_time", "landing.time")
    names = ("plate.time",) if stage in ("pitch", "plate") else landing
    steps = (common_step([t.given[n][0] for t in trials if n in t.given]) for n in names)
    return next((step for step in steps if step is not None), None)


def clocks(stage: str, chosen: Seen, base: Change) -> Iterator[Explanation]:
    """Yield what is wrong with times of points that lie on the true path."""
    places = [p for t, _ in chosen if (p := placed(t, base, stage))]
    if len(places) < 2 or sum(p.off for p in places) > 0.05 * sum(p.moved for p in places):
        return
    clock, times = np.array([p.clock for p in places]), np.array([p.time for p in places])
    middle, doubt = float(np.median(clock)), float(np.ptp(clock)) / 2
    ratios = times / np.maximum(times - clock, 1e-12)
    ratio, rank, step = float(np.median(ratios)), 0, None
    remedy: str | None = None
    if doubt < 1e-3 * abs(middle):
        name, step = "clock-offset", abs(middle)
        sentence = f"the clock is {'ahead' if middle > 0 else 'behind'} by {told(step, doubt)} s "
        sentence += f"in all, as if a step were counted {'twice' if middle > 0 else 'too late'}"
        remedy = "let the time of a state be that of the same step"
    elif ratio and np.ptp(ratios) < 1e-3 * abs(ratio - 1):
        name, sentence = "clock-rate", f"the clock runs {told(ratio, 0)} times as fast"
    elif decimals := _rounded_to(times, clock):
        name, rank, remedy = "times-rounded", 3, ALL_DIGITS
        sentence = f"its times are rounded to {many(decimals, 'decimal')}"
    else:
        name, rank, remedy = "clock", 3, "look at how the time of the event is counted"
        sentence = f"its times are off by {clock.min():.3g} to {clock.max():.3g} s"

    def right(trial: Trial, time: float, which: str) -> float:
        if rank == 0:
            return time / ratio if step is None else time - middle
        return time - (place.clock if (place := placed(trial, base, which)) else 0.0)

    def mend(trial: Trial) -> Trial:
        # The same clock tells when ball and bat touch.
        timed = {"plate.time": stage, "contact.time": "touching"} if stage == "pitch" else {
            "landing.time": stage, "landing.hang_time": stage}  # fmt: skip
        given = trial.given
        mended = {n: right(trial, given[n][0], which) for n, which in timed.items() if n in given}
        if "contact.time" in mended:  # since when the batted ball flies
            by = mended["contact.time"] - given["contact.time"][0]
            later = (name for name in ("fence.time", "landing.time") if name in given)
            mended |= {name: given[name][0] + by for name in later}
        return trial.saying({name: (time,) for name, time in mended.items()})

    def left(trial: Trial, checks: Sequence[Check]) -> float:
        known = {c.quantity for c in checks}
        mended = follow(mend(trial), base, (stage,))
        return sum(size_of(c) for c in mended if c.quantity in known)

    yield Explanation(
        name, f"the points lie on the true path, within {max(p.off for p in places):.1e} m; "
        f"{sentence}", remedy, share_by(chosen, left), rank, mend=mend, step=step, stage="time",
    )  # fmt: skip


def _rounded_to(times: Array, clock: Array) -> int:
    """Return how many decimals times are rounded to; 0 if they are not off by that."""
    # Times of steps that are never the nearest ones are cut off, and not rounded.
    exponents = (Decimal(f"{time:.12g}").normalize().as_tuple().exponent for time in times)
    decimals = max(-int(exponent) for exponent in exponents)
    unit = 10.0**-decimals
    near = clock.min() < 0 < clock.max() and abs(clock).max() < 0.5 * unit + 1e-9
    return decimals if near and 0 < decimals <= FEW_DECIMALS else 0


_SAME_PATH = 1e-3  # of what a velocity is off, what may be left where it is that of another time


def velocities_of_another_time(wrong: Seen, base: Change) -> Iterator[Explanation]:
    """Yield by how much earlier, or later, the velocities at the landing are those of the path."""
    places = [(t, placed(t, base, "landing velocity")) for t, _ in evenly(wrong, _MANY)]
    known = [(t, place) for t, place in places if place and _is_bent(place)]
    later, lefts, wholes = [], [], []
    for trial, place in known:
        said, time = np.array(trial.given["landing.velocity"]), place.time
        for _ in range(10):  # to the nearest velocity
            bend = _bend(place.way, time)
            if not 0.0 < (square := float(bend @ bend)) < math.inf:
                return
            time += float((said - place.velocity(time)) @ bend) / square
        later.append(time - place.time)
        lefts.append(float(np.linalg.norm(said - place.velocity(time))))
        wholes.append(float(np.linalg.norm(said - place.velocity(place.time))))
    if len(later) < ENOUGH or not np.isfinite([*later, *lefts]).all():
        return
    side = "before" if max(later) < 0 else "after" if min(later) > 0 else "before or after"
    size = np.abs(later)
    same = np.ptp(size) <= _SAME_PATH * size.max()
    most = f"{size.max():.3g} s" if same else f"{size.min():.1e} to {size.max():.1e} s"
    yield Explanation(
        "velocity-of-another-time", f"landing.velocity is that of the true path {most} {side} the "
        "landing, as at another step", "take velocity and place from the same time",
        share_left(lefts, wholes), 2, quantity="landing.velocity",
    )  # fmt: skip


# --- events between two steps ---------------------------------------------------------------------


def on_chords(few: Sought, base: Change, dt: float | None) -> Iterator[Explanation]:
    """Yield events that lie on the straight line between two steps on the true path."""
    places = [p for t in few.trials if (p := placed(t, base, few.stage))]
    whole = [p.moved for p in places]
    if not any(whole) or max(p.off for p in places) > 1:
        return

    def left(step: float) -> float:
        return share_left([_off_chord(step, p) for p in places], whole)

    tried = (dt,) if dt else [step for step in ROUND_STEPS if step >= SHORTEST]
    share, best = min((left(step), step) for step in tried)
    yield Explanation(
        "linear-event", f"puts the end of the flight on the straight line between two steps of "
        f"{best:.4g} s",
        "step onto the surface, or interpolate with the velocities (Hermite)", share, 0.9,
        Change(engine=FixedStep(dt=best, scheme="chords")), step=best,
        stage="plate" if few.stage == "pitch" else "landing",
    )  # fmt: skip


def _off_chord(dt: float, place: Placed) -> float:
    """Return how far a point is from the line between two steps on the true path, at its time."""
    first = math.floor(place.time / dt)
    share = place.time / dt - first
    try:
        a, b = place.way(first * dt), place.way((first + 1) * dt)
    except (ArithmeticError, ValueError):  # the flight cannot be followed beyond its end
        return place.moved
    return math.dist([p + (q - p) * share for p, q in zip(a, b, strict=True)], place.point)


_TICK = 1e-3  # s: a second difference over this is an acceleration, to six digits

# What a straight line, or a parabola in a vacuum, leaves of the way that the ball makes in the last
# step is along its acceleration, to this share, since that changes little in a step.
_ALONG = 0.03

_ACROSS = 0.1  # of the acceleration, the share across the velocity with which its direction tells

# How many times as large it is in one scene as in another, by where in a step the end is: nine in
# ten of them, and one in ten. Of laws and schemes it is the same, or goes with the time of flight.
_SPREAD = 1.8

_MANY = 40  # scenes that are enough to see that


def between_steps(stage: str, wrong: Seen, base: Change) -> Iterator[Explanation]:
    """Yield that an event is off the true path by what the way from a step to it leaves out.

    At "landing velocity", that the velocity there is so. On a way that is hardly bent across, any
    error lies along what is left out, and tells nothing.
    """
    known = ((t, placed(t, base, stage)) for t, _ in evenly(wrong, _MANY))
    places = [(t, p) for t, p in known if p and _is_bent(p)]
    if len(places) < ENOUGH:
        return
    times = np.array([p.time for _, p in places])
    event = "plate" if stage == "pitch" else "landing"
    where = _ENDS[event][2]
    if stage == "landing velocity":
        said = ((t.given["landing.velocity"], p) for t, p in places)
        by = np.array([np.subtract(velocity, p.velocity(p.time)) for velocity, p in said])
        event, what, unit = stage, "landing.velocity is off that of the true path", "m/s"
        ways = [("on a straight line", np.array([_bend(p.velocity, p.time) for _, p in places]))]
    else:
        by = np.array([np.subtract(p.point, p.way(p.time)) for _, p in places])
        what, unit = "the end is off the true path", "m"
        bent = np.array([_bend(p.way, p.time) for _, p in places])
        weight = np.array([(0.0, 0.0, -float(t.scene.gravity)) for t, _ in places])
        ways = [("on a straight line, or stays on that to the next step", bent),
                ("by a parabola without the air", bent - weight)]  # fmt: skip
    for way, missing in ways:
        squares = (missing**2).sum(axis=1)
        if not (np.isfinite(by).all() and np.isfinite(squares).all() and squares.all()):
            continue
        halves = (by * missing).sum(axis=1) / squares  # s²: of a step's square, up to a half
        rest = by - halves[:, None] * missing
        left = float(np.linalg.norm(rest, axis=1).sum() / np.linalg.norm(by, axis=1).sum())
        same_side = (halves > 0).all() or (halves < 0).all()
        if left > _ALONG or not same_side:
            continue
        if all(_spread(halves / times**power) > _SPREAD for power in range(3)):
            most = float(np.linalg.norm(by, axis=1).max())
            yield Explanation(
                "event-between-steps", f"{what} by up to {most:.1e} {unit}, as where one goes "
                f"from a step to {where} {way}",
                "step onto the surface, or interpolate by the order of the integrator", left, 4,
                allowed=_ALONG, stage=event,
            )  # fmt: skip
            return


def _is_bent(place: Placed) -> bool:
    """Tell whether the acceleration at a place is not along the velocity."""
    velocity, bend = place.velocity(place.time), _bend(place.way, place.time)
    size = float(np.linalg.norm(velocity) * np.linalg.norm(bend))
    return float(np.linalg.norm(np.cross(velocity, bend))) > _ACROSS * size


def _bend(way: Callable[[float], Sequence[float]], time: float) -> Array:
    """Return the second derivative of a way, shortly before a time, 1/s²."""
    try:
        a, b, c = (np.array(way(time - k * _TICK)) for k in range(3))
    except (ArithmeticError, ValueError):  # the flight cannot be followed beyond its end
        return np.full(3, np.nan)
    found: Array = (a - 2 * b + c) / _TICK**2
    return found


def _spread(values: Array) -> float:
    """Return by what factor nine in ten values, and one in ten, differ."""
    low, high = np.quantile(np.abs(values), (0.1, 0.9))
    return float(high / max(low, 1e-300))
