"""Clocks and events at steps: the candidate's states belong to other times than it reports.

A step length is reported only if the times are multiples of it, a *lattice*.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longball.judge.diagnosis.chain import OWN, Stage
from longball.judge.diagnosis.evidence import CHANCE, DIGIT, NUMBER, cost, is_adequate
from longball.judge.diagnosis.expression import Evaluator, words
from longball.judge.diagnosis.integrators import Way
from longball.judge.diagnosis.residual import Followed, Launched, flown, is_rough, launched, take
from longball.model.arrays import Array


@dataclass(frozen=True)
class Scheme:
    """Errors that the steps of a candidate explain.

    Attributes
    ----------
    words
        Clause without its subject that says what the candidate does.
    order, step
        Order and step (s) of the integrator; None if only an event or a clock is wrong.
    bits, evidence
        Cost of the scheme, and its evidence beyond chance.
    adequate
        True if the scheme reproduces all numbers of all scenes, or of those that it `mends`. Only
        such a scheme is named.
    way
        Integrator and step of the candidate's flight, if these are named.
    mends
        Of a scheme that explains only a part of the errors: the number of scenes.
    """

    words: str
    order: int | None
    step: float | None
    bits: float
    evidence: float
    adequate: bool
    way: Way | None = None
    mends: int | None = None


# Limits of the search: free choices.
ON_LATTICE = 1e-4  # of a step: largest distance of a time from a whole number of steps
FINEST, LONGEST = 1e-4, 0.4  # shortest and longest step that is searched for, s
MOST_STEPS = 1e6  # in the first times: a reported time may be wrong by a power of ten
MOST = 0.8  # fraction of the times for which a rule has to hold
TIMES = 5  # different times that are needed to detect a lattice


def lattice(times: Array, dt: float | None = None) -> tuple[float, float] | None:
    """The largest step of which most times are multiples, s, and its bits beyond chance.

    Some times may be off the lattice: a candidate may restart its steps at a kink of the law.
    """
    known = np.unique(times[np.isfinite(times) & (times > LONGEST)].round(12))
    if len(known) < TIMES:
        return None
    # The step divides a time on the lattice into a whole number of steps: try all divisions of the
    # first three times, since one of these may be off the lattice.
    tried = np.concatenate([np.array([dt])] if dt else [
        first / np.arange(math.ceil(first / LONGEST), min(first / FINEST, MOST_STEPS) + 1)
        for first in known[:3]
    ])  # fmt: skip
    # Drop a step once too many times are off its lattice: a few times leave few steps, and all
    # divisions at all times do not fit into memory.
    steps, misses = tried, np.zeros(len(tried), dtype=int)
    for time in known:
        counts = time / steps
        misses += np.abs(counts - np.round(counts)) >= ON_LATTICE
        possible = (len(known) - misses) / len(known) >= MOST
        steps, misses = steps[possible], misses[possible]
    if not steps.size:
        return None
    # By chance, a time lies on a lattice with the probability 2 ON_LATTICE; the time that gave the
    # step always does. A time off the lattice costs 5 bits.
    best = np.argmax(steps)
    on = len(known) - int(misses[best])
    bits = (on - 1) * -math.log2(2 * ON_LATTICE) - math.log2(len(tried)) - int(misses[best]) * 5.0
    return float(f"{steps[best]:.9g}"), bits


@dataclass(frozen=True)
class _Rule:
    """A rule for the true times of a candidate's states.

    `text` is a format for the name of the state and that of the reported time.
    """

    text: str
    times: Array
    bits: float = 0.0
    step: float | None = None


@dataclass(frozen=True)
class _States:
    """A candidate's states, compared with the exact path at any times."""

    stage: Stage
    columns: Mapping[str, Any]
    followed: Followed

    @cached_property
    def balls(self) -> Launched:
        own = take(self.columns, self.followed.some)
        return launched(self.stage, self.stage.with_spin(own))

    @cached_property
    def now(self) -> Array:
        """The states of the path at the times that the candidate gives."""
        return flown(self.balls, self.balls.duration)

    def off(self, part: slice, times: Array) -> tuple[Array, Array]:
        """States minus those of the path at other times, and the derivative of the path there."""
        y = flown(self.balls, times)
        return self.followed.off[part] + (self.now - y)[part], self.balls.rates(y, times)[part]

    def own_times(self, part: slice) -> Array:
        """The times at which the path is nearest to the candidate's states."""
        # Newton steps: the error along the path over the speed along it.
        times = self.balls.duration.copy()
        for _ in range(4):  # a free choice
            off, moving = self.off(part, times)
            times = times + np.nan_to_num((off * moving).sum(0) / (moving * moving).sum(0))
        return times


def clock(
    stage: Stage, columns: Mapping[str, Any], followed: Followed, dt: float | None
) -> Scheme | None:
    """The clock that explains a flight: its states lie on the exact path at other times."""
    states = _States(stage, columns, followed)
    with np.errstate(all="ignore"):
        # Position and velocity may be of different times, such as those before and after a step.
        told = states.balls.duration
        rows = slice(0, 3), slice(3, 6)
        parts = [part for part in rows if np.isfinite(followed.off[part]).any()]
        own = [states.own_times(part) for part in parts]
        rules = [_rule(told, times, dt) for times in own]
        if len(own) > 1 and _mostly(np.abs(own[0] - own[1]) < SAME):  # one clock for both
            rules = [replace(rules[0], bits=rules[0].bits / 2)] * 2
        left = [
            states.off(part, rule.times)[0] / followed.floor[part]
            for part, rule in zip(parts, rules, strict=True)
        ]
        left.append(followed.off[6:] / followed.floor[6:])  # no clock explains the spin
    r, bits = np.concatenate(left), sum(rule.bits for rule in rules)
    # Errors within the profile's tolerance are evidence, too (`Followed.finest`).
    finer = followed.floor / followed.finest
    finer_left = r * np.concatenate([finer[part] for part in (*parts, slice(6, None))])
    evidence = cost(followed.off / followed.finest) - cost(finer_left) - bits - CHANCE
    if evidence <= 0 or not is_adequate(r, is_rough(stage)):
        return None
    name = words(stage.roots["duration"])
    texts = dict.fromkeys(rule.text for rule in rules)
    whose = stage.quantities if len(texts) > 1 else ("position and velocity",)
    said = "; ".join(
        rule.text.format(quantity, name)
        for rule, quantity in zip(rules, whose, strict=False)
        if rule.text
    )
    step = next((rule.step for rule in rules if rule.step), None)
    return Scheme(said, None, step, bits, evidence, adequate=True)


def _rule(told: Array, own: Array, dt: float | None) -> _Rule:
    """The simplest rule for the true times of states, from the reported times."""
    # In this order: no delay; one delay; the states are those at steps; the reported times are
    # whole steps; no rule, so that every state has a free time.
    behind = told - own
    known = behind[np.isfinite(behind)]
    late = float(np.median(known))
    if _mostly(np.abs(known) < SAME):
        return _Rule("", told)
    if _mostly(np.abs(known - late) < max(SAME, 1e-4 * abs(late))):  # a free choice
        late = float(f"{late:.4g}")
        text = f"gives {{0}} of {abs(late):.6g} s {'before' if late > 0 else 'after'} {{1}}"
        return _Rule(text, told - late, NUMBER + 4 * DIGIT, abs(late))
    if found := lattice(own, dt):
        h, counts = found[0], told / found[0]
        for side, whole in (("before", np.floor(counts)), ("after", np.ceil(counts))):
            if _mostly(np.abs(whole * h - own) < SAME + ON_LATTICE * h):
                text = f"gives {{0}} of the step {side} {{1}}, in steps of {h:.6g} s"
                return _Rule(text, whole * h, NUMBER + 2 * DIGIT, h)
    if (found := lattice(told, dt)) and _mostly(np.abs(known) < found[0] * (1 + ON_LATTICE)):
        text = f"gives {{1}} in whole multiples of {found[0]:.6g} s"
        return _Rule(text, own, FREE * known.size, found[0])
    # If the velocity hardly changes, the time that fits it is uncertain: give that of most scenes.
    usual = float(np.quantile(np.abs(known), MOST))
    sides = {"before": _mostly(known > -SAME), "after": _mostly(known < SAME)}
    side = next((side for side, holds in sides.items() if holds), "before or after")
    text = f"gives {{0}} of up to {usual:.3g} s {side} {{1}}"
    return _Rule(text, own, FREE * known.size)


SAME = 1e-8  # s: times that differ by less are one; a free choice
FREE = 30.0  # cost in bits of a time that no rule gives; a free choice


def _mostly(those: NDArray[np.bool_]) -> bool:
    return bool(np.mean(those) >= MOST)


def event(
    chain: Sequence[Stage], stage: Stage, columns: Mapping[str, Any], followed: Followed,
    dt: float | None,
) -> Scheme | None:  # fmt: skip
    """The candidate reports the state at the step before or after an event."""
    quantity = stage.quantities[0]
    flight = next((x for x in chain if x.kind == "flight" and x.quantities[0] == quantity), None)
    if flight is None:
        return None
    some = followed.some[followed.wrong]
    own = flight.with_spin(take(columns, some))
    name = str(OWN[quantity].data)
    with np.errstate(all="ignore"):
        balls = launched(flight, own)
        found = lattice(balls.duration, dt)
        if found is None:
            return None
        h, bits = found
        now = flown(balls, balls.duration)[:3]
        sides = []
        for shift in (-h, 0.0, h):
            # The candidate's ball moves like that of the exact path, but from its own position: its
            # earlier errors do not matter here.
            moved = flown(balls, balls.duration + shift)[:3] - now
            zero = Evaluator([stage.roots["zero"]], {**own, name: own[name] + moved})()[0]
            sides.append(np.sign(zero) + np.zeros(len(some)))
    # If the ball is on the other side of the surface one step earlier or later, the event lies
    # within that step. By chance this holds in half of the scenes: each one is a bit of evidence.
    time = words(flight.roots["duration"])
    evidence = bits + len(some) - CHANCE
    for text, other in (("after", sides[0]), ("before", sides[2])):
        if evidence > 0 and _mostly(other * sides[1] < 0):
            said = f"uses {time} and {quantity} at the step {text} the event, in steps of {h:.6g} s"
            return Scheme(said, None, h, bits, evidence, adequate=True)
    return None
