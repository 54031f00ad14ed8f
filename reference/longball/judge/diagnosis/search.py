"""Search for the cheapest edit of a stage that reproduces the candidate's numbers.

An accepted edit is applied to the chain, so that later stages inherit the mistake. The search has
three phases: edits are ranked by their first-order effects, the best are computed in a few
*screening* scenes, and those that fit there are verified in all scenes. `c` is the free number of
an edit, a constant fitted to the candidate's numbers. A *floor* is the noise of a number: errors
within it need no explanation. Residuals are errors in units of their floors.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from operator import attrgetter, itemgetter
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from longball.judge.diagnosis.chain import OWN, Kind, Stage
from longball.judge.diagnosis.evidence import (
    ADEQUATE,
    CHANCE,
    DIGIT,
    FEWEST,
    NUMBER,
    PART,
    cost,
    fitted,
    is_adequate,
    rounded,
)
from longball.judge.diagnosis.expression import (
    JUMPS,
    Node,
    Values,
    contains,
    ordered,
    symbol,
    used,
    where,
    words,
)
from longball.judge.diagnosis.operators import (
    FACTORS,
    FREE,
    LIKELY,
    NEAR_ONE,
    Edit,
    edits,
    edits_of_one_option,
)
from longball.judge.diagnosis.residual import (
    COARSE,
    FINE,
    HUGE,
    MIDDLE,
    SWITCHES,
    Data,
    Followed,
    Index,
    Stepping,
    compared,
    evenly,
    follow,
    inputs,
    is_rough,
    mended,
    take,
    values,
    with_every_option,
)
from longball.judge.diagnosis.response import Direct, Effects, Response, cubic, free
from longball.judge.diagnosis.scenes import ODDS
from longball.judge.diagnosis.unseen import Unseen
from longball.model.arrays import Array
from longball.model.scene import AtBatScene

# Limits of the search: free choices.
# Screening scenes: wrong ones, from the worst to the least, and right ones.
WRONG, RIGHT = 10, 10
# Scenes in which an edit is verified.
MOST_WRONG, MOST_RIGHT = 60, 30
# Median relative error of a flight above which first-order effects along the true path are
# unreliable.
FAR_OFF = 0.03
TWINS = 5  # kept of the edits that are equal at this stage: they may differ at other stages
TIMES = 3  # further copies of each screening scene among those that are moved at random
NEAR = 16  # edits that are combined with integration schemes
# Fractions of the initial cost in the screening scenes. An edit that leaves more than HALF is
# dropped from the search. One that leaves more than NEARER does not count among `NEAR`, either.
HALF, NEARER = 0.6, 0.97
# Relative error of an edit's effect that is computed in long steps; and of that on a flight by the
# candidate's scheme.
STEPS, OWN_STEPS = 1e-3, 0.05
# A scene may be a screening scene if the error of long steps is below NEARLY, relative to the size
# of each number. It is preferred if that error is below SHARE, relative to the candidate's error.
NEARLY, SHARE = 0.05, 0.02
LOST = 1e12  # the residual, in floors, where an edit gives no finite value


# --- results --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Named:
    """One edit, or a pair, that explains a stage."""

    edits: tuple[Edit, ...]
    evidence: float  # bits beyond chance
    same: tuple[Edit, ...] = ()  # edits that give equal numbers in all scenes
    # Of an edit that explains only a part of the errors: the number of scenes.
    mends: int | None = None


@dataclass(frozen=True)
class Located:
    """A stage that no edit explains, with the nearest edit if that is better than chance."""

    nearest: Edit | None = None
    left: float = 1.0  # fraction of the initial cost that remains with `nearest`
    near: tuple[Edit, ...] = ()  # the edits with the smallest cost in the screening scenes
    # If new scenes refute `nearest`: the number of those that do, and of all new scenes.
    refuted: tuple[int, int] | None = None


@cache
def defaults() -> Mapping[str, Any]:
    """The defaults of a scene by symbol of the chain."""
    # A key has a default only if its block is given. Together, these scenes have all blocks.
    air = {"lift_coefficient": {"law": "rational"}, "drag_coefficient": {"law": "spin"}}
    crisis = {"lift_coefficient": {"law": "linear"}, "drag_coefficient": {"law": "crisis"}}
    weather = {"density": {"temperature": 288.15}}
    spinning = {"spin": (0.0, 1.0, 0.0)}  # a free choice
    given: list[dict[str, Any]] = [
        {}, {"air": air, "pitch": spinning}, {"air": crisis, "pitch": spinning}, {"air": weather},
        {"bat": {"friction": 0.1}, "ball": {"inertia_factor": 0.4}, "earth": {"latitude": 0.0}},
    ]  # fmt: skip
    found: dict[str, Any] = {}
    for scene in given:
        for name, column in inputs([AtBatScene.model_validate(scene)]).items():
            if column.ndim == 1 and np.isfinite(column).all():
                found.setdefault(name, float(column[0]))
    for required in ("μ_f", "λ"):  # have no default: their numbers above are arbitrary
        found.pop(required, None)
    return found | {"z_0": 0.03}


def _in_floors(f: Followed) -> Array:
    r = f.off / f.floor
    return np.where(np.isfinite(f.off) & ~np.isfinite(r), LOST, r)


def _bits(f: Followed) -> float:
    """Cost of residuals in the finest floors: what a precise candidate leaves is evidence."""
    return cost(_in_floors(f) * f.floor / f.finest)


def _noise(f: Followed, some: NDArray[np.bool_]) -> float:
    """The 90th percentile of errors in some scenes, in the finest floors; infinity without any."""
    if not some.any():
        return math.inf
    return float(np.nanquantile(np.abs(f.off / f.finest)[:, some], 0.9, method="lower"))


def _median(x: Any) -> float:
    known = np.asarray(x)[np.isfinite(x)]
    return float(np.median(known)) if known.size else 0.0


class Layer(NamedTuple):
    """Budget of a search among some of the edits, which are sorted by `Explanation.rank`.

    Attributes
    ----------
    edits
        The edits that are ranked by their first-order effects.
    paths
        The `Explanation.responses` by which they are ranked.
    tried
        Number of edits that are computed in the screening scenes; `HELD` of these are verified.
    pairs
        True to search for a second edit, too.
    """

    edits: slice
    paths: slice
    tried: int
    pairs: bool = False


# How many edits are tried: free choices.
# Most named edits are in the first layer. The last layer has many more edits: it ranks them along
# one path only, and tries no pairs.
EVERY = slice(None)
CHUNK = 10_000  # edits whose effects are in memory at a time; those of pairs have to be
ALONE = (
    Layer(slice(2_000), EVERY, 50),
    Layer(slice(CHUNK), EVERY, 100, pairs=True),
    Layer(slice(CHUNK, 80_000), slice(-1, None), 100),
)
BESIDE_ANOTHER = (Layer(slice(5_000), EVERY, 50),)
OF_OPTION = (Layer(slice(CHUNK), EVERY, 50, pairs=True),)
HELD = 6  # edits of a layer that are verified in all scenes
# Edits that are tried with a second one, by the kind of stage. Of a flight there are few, because
# every trial integrates it.
PAIRS: Mapping[Kind, int] = {"flight": 1, "formula": 4, "event": 2}


class _Pair(NamedTuple):
    """Two edits of a stage.

    Attributes
    ----------
    bits
        The cost of the edits and of what they leave in the screening scenes.
    stage
        The stage with both.
    c
        Their free numbers.
    """

    bits: float
    one: Edit
    two: Edit
    stage: Stage
    c: Array


class _Screened(NamedTuple):
    """A group of equal edits, and the cost that they leave in the screening scenes.

    Attributes
    ----------
    fitted
        True if they explain these scenes: then they are computed in all scenes, too.
    """

    left: float
    group: list[Edit]
    fitted: bool


# Of an edit: "exact" if all residuals are within the noise; "rough" if it has a jump or a kink, and
# they are within the noise of steps across that; else "partial".
Fit = Literal["exact", "rough", "partial"]


class _Verified(NamedTuple):
    """An edit that is better than chance in all scenes.

    Attributes
    ----------
    alike
        The edit and those that give equal numbers in these scenes; without edits that
        `Explanation._is_possible` rejects.
    r
        Residuals of the edit, in floors.
    left
        Bits that these residuals cost.
    evidence
        Bits beyond chance.
    number
        Bits of the free number.
    """

    edit: Edit
    alike: tuple[Edit, ...]
    r: Array
    left: float
    evidence: float
    fit: Fit
    number: float

    @property
    def bits(self) -> float:
        """The cost of the edit and of what it leaves."""
        return self.left + self.edit.bits


@dataclass
class Explanation:
    """The search for edits that explain the errors of one stage.

    Attributes
    ----------
    all
        The scenes in which edits are verified; the good ones then in every scene.
    whole
        The search in all scenes, if this is one in a part of them: it has the same edits.
    base, null_all
        Residuals of these scenes without an edit, and their cost in bits.
    few
        Positions in `all` of the screening scenes.
    mild
        Positions of the scenes in which edits are ranked: those with small errors, and right ones.
    off, roughly, null
        Residuals in the screening scenes, the noise there, and the cost of the residuals.
    own_error
        The error of long steps in the screening scenes.
    noise, precise
        The candidate's errors in right scenes, in the finest floors; floors of that size.
    """

    chain: tuple[Stage, ...]
    stage: Stage
    data: Data
    columns: Mapping[str, Any]
    followed: Followed
    layers: tuple[Layer, ...] = ALONE
    pairs: int = 0
    whole: Explanation | None = None
    counted: dict[Any, int] = field(default_factory=dict)  # what `_wrong` returns
    telling: dict[tuple[str, Kind], Index] = field(default_factory=dict)  # what `_telling` returns
    # Free numbers with their bits and their spreads, by edit: what `settled` has fitted.
    numbers: dict[Edit, tuple[float, float, float]] = field(default_factory=dict)
    # Edits of all layers that are better than chance, but do not explain every scene.
    partial: list[_Verified] = field(default_factory=list)
    least: float = 1.0  # smallest fraction of the squared errors that an edit leaves to first order

    def __post_init__(self) -> None:
        f, stage = self.followed, self.stage
        # Wrong scenes come first, from the worst to the least: `evenly` takes errors of all sizes.
        wrong, right = f.some[f.beyond], f.some[~f.beyond & f.checked]
        sizes = f.relative[f.beyond]
        order = wrong[np.argsort(-sizes, kind="stable")]
        beside = with_every_option(take(self.columns, right))
        beside = np.union1d(right[beside], evenly(right, MOST_RIGHT))
        self.all = np.concatenate([evenly(order, MOST_WRONG), beside])
        self.base = base = self._compared(stage, self.all)
        self.null_all = self._null()
        # Screening uses long steps, and scenes in which long steps are accurate.
        is_wrong = np.isin(self.all, wrong)
        every = np.arange(len(self.all))
        coarse = self._off(stage, every, limits=COARSE)[0]
        missed = np.abs(coarse - base.off)
        near = np.asarray(~(missed > NEARLY * base.scale).any(axis=0))
        near = near if near[is_wrong].any() else np.ones_like(near)
        # Where the law has a kink, the error of long steps may exceed the effect of an edit: scenes
        # with a small error, relative to the candidate's, come first.
        shows = near & is_wrong & (missed <= SHARE * np.abs(base.off).max(axis=0)).all(axis=0)
        shows = shows if shows.any() else near & is_wrong
        failing = np.flatnonzero(shows)  # from the worst to the least
        passing = evenly(np.flatnonzero(near & ~is_wrong), RIGHT)
        self.few = few = np.concatenate([evenly(failing, WRONG), passing])
        self.noise = _noise(f, f.checked & ~f.beyond)
        self.precise = np.minimum(base.floor, max(self.noise, 1.0) * base.finest)
        # First-order effects are computed in long steps, too. They are most reliable where errors
        # are small.
        small = int((base.relative[failing] < FAR_OFF).sum())
        mild = failing[-max(small, math.ceil(len(failing) / 3)) :]
        self.mild = np.concatenate([evenly(mild, WRONG), passing])
        # The error of long steps is computed once, without an edit, and subtracted from every
        # trial. The remainder is proportional to the effect of the edit. The effect of the right
        # edit is the residual, so a fraction of the residual is allowed as noise. Where the law has
        # no value without an edit, such as the logarithmic wind below z = -z_0, the error is set to
        # 0.
        steps = STEPS if stage.kind == "flight" else 0.0
        if self.data.way(stage) is not None:
            steps = OWN_STEPS
        lost = ~np.isfinite(coarse[:, few]) | (np.abs(coarse[:, few]) >= HUGE)
        self.own_error = np.where(lost, 0.0, base.off[:, few] - coarse[:, few])
        self.off = np.where(lost, self._given(few), base.off[:, few])
        self.roughly = base.floor[:, few] + steps * np.abs(self.off)
        self.null = cost(self.off / self.roughly)
        self.finer_few = self.roughly / (base.finest[:, few] + steps * np.abs(self.off))

    # --- residuals --------------------------------------------------------------------------------

    @cached_property
    def decided(self) -> NDArray[np.bool_]:
        """The wrong scenes of `followed` that the other side of a branch explains."""
        found = np.zeros_like(self.followed.beyond)
        for node in ordered(self.stage.roots.values()) if self.stage.kind == "formula" else ():
            if node.op == "where":
                condition, *sides = node.args
                other = self.stage.edited(node, where(condition, *sides[::-1]))
                after = self._compared(other, self.followed.some)
                found |= ~(np.abs(_in_floors(after)) > ADEQUATE).any(axis=0)
        return found & self.followed.beyond

    def _null(self) -> float:
        """Cost of the residuals without an edit, in bits; a decision is one bit."""
        decided = np.isin(self.all, self.followed.some[self.decided])
        left = replace(self.base, off=np.where(decided, 0.0, self.base.off))
        return float(decided.sum()) + _bits(left)

    def _compared(self, stage: Stage, some: Index, rough: bool = False) -> Followed:
        data = replace(self.data, rough=self.data.rough.union((stage.name,) if rough else ()))
        with np.errstate(all="ignore"):
            return compared(stage, data, self.columns, some)[0]

    def _given(self, some: Index) -> Array:
        """The candidate's numbers in some of `all` scenes; 0 where an event ends."""
        rows = [
            np.atleast_2d(self.data.given[q][..., self.all[some]]) for q in self.stage.quantities
        ]
        given = np.concatenate(rows)
        if self.stage.kind == "event":
            return np.where(np.isfinite(given).all(axis=0), 0.0, np.nan)[None]
        return given

    def _off(
        self, stage: Stage, some: Index, c: Array | None = None, limits: Stepping = FINE
    ) -> Array:
        """Residuals of a stage in some of `all` scenes: shape (rows of c, numbers, scenes)."""
        # One copy of the scenes for each row of free numbers, all flown at once.
        c = np.zeros((1, 0)) if c is None else c
        columns = stage.with_spin(take(self.columns, np.tile(self.all[some], len(c))))
        columns |= {name: np.repeat(x, len(some)) for name, x in zip(NUMBERS, c.T, strict=False)}
        # A candidate's own steps are many: screening takes long steps of the exact path instead.
        way = self.data.way(stage) if limits.controlled else None
        found = values(stage, columns, limits) if way is None else way(stage, columns)[0]
        rows = np.concatenate([np.atleast_2d(found[q]) for q in stage.quantities])
        off = self._given(some)[:, None] - rows.reshape(len(rows), len(c), len(some))
        return np.asarray((-off if stage.kind == "event" else off).swapaxes(0, 1))

    def screened(self, stage: Stage, again: Sequence[Stepping]) -> Callable[[Array], Array]:
        """The function from free numbers to the residuals in the screening scenes, in floors.

        Long steps may diverge where the flight itself does not: if the other scenes are explained,
        these are flown `again` in other steps.
        """
        known, jumps = np.isfinite(self.off), is_rough(self.stage)

        def flown(numbers: Array) -> Array:
            off = self._off(stage, self.few, numbers, COARSE)
            r = (off + self.own_error) / self.roughly
            if jumps:  # an edit that removes one removes the error of long steps across it
                both = np.array([r, off / self.roughly])
                costs = [[cost(x) for x in some] for some in both]
                r = both[np.argmin(costs, axis=0), np.arange(len(numbers))]
            huge = np.asarray((known & ~(np.abs(off) < HUGE)).any(axis=1))
            for c, left, lost in zip(numbers, r, huge, strict=True):
                for limits in again:
                    if lost.any() and self._is_explained(left, ~lost):
                        off = self._off(stage, self.few[lost], c[None], limits)[0]
                        left[:, lost] = off / self.roughly[:, lost]
                        lost[lost] = ~(np.abs(off) < HUGE).all(axis=0)
            return np.where(known & ~np.isfinite(r), LOST, r)

        return flown

    def _screened_exactly(self, stage: Stage) -> Callable[[Array], Array]:
        """The same, with exact flights where long steps do not do."""
        if not self._moves_jumps(stage):
            return self.screened(stage, (MIDDLE, FINE))

        def flown(numbers: Array) -> Array:
            off = self._off(stage, self.few, numbers, FINE)
            lost = np.isfinite(self.off) & ~np.isfinite(off)
            return np.where(lost, LOST, off / self.roughly)

        return flown

    def _moves_jumps(self, stage: Stage) -> bool:
        """True if an edit moves a jump: the error of long steps across one depends on its place."""
        return self.stage.kind == "flight" and _jumps(stage) != _jumps(self.stage)

    def _is_explained(self, r: Array, some: NDArray[np.bool_]) -> bool:
        """True if little of the cost in these screening scenes is left; also if there are none."""
        before = cost((self.off / self.roughly)[:, some])
        return cost(r[:, some]) <= HALF * before

    def edited(self, edit: Edit) -> Stage:
        """The stage with an edit."""
        (stage,) = edit.apply([self.stage])
        return stage

    def _residual(self, stage: Stage, some: Index, limits: Stepping) -> Callable[[Array], Array]:
        """Errors in some of `all` scenes as a function of the free numbers.

        In floors as fine as the candidate's own errors in right scenes: a free number has as many
        digits as these show.
        """
        return lambda c: self._off(stage, some, c, limits) / self.precise[:, some]

    # --- the search -------------------------------------------------------------------------------

    def explain(self, unseen: Unseen | None = None) -> Named | Located:
        """The likeliest edit that explains the stage in all scenes; or two, if none does."""
        whole = self.whole or self
        likeliest, rank = whole.likeliest, whole.rank
        parts = [range(len(likeliest))[layer.edits] for layer in self.layers]
        located: list[Located] = []
        names: list[tuple[int, float, Named]] = []  # with the scenes left wrong, and their bits
        for i, (layer, part) in enumerate(zip(self.layers, parts, strict=True)):
            if not part or part in parts[i + 1 :]:  # another layer has all its edits
                continue
            if part.start and self.least > SHOWS:  # errors like noise, which no edit explains
                break
            found = self._explained_by(likeliest[layer.edits], part.stop, layer, unseen)
            # All flights share one law. A name that does not hold in the others competes with those
            # of further layers; and so does an edit whose number costs more than their edits do.
            # The last layer takes longest: it competes only with a number of many digits.
            if isinstance(found, Named):
                left, bits = self._left_by(found), sum(edit.bits for edit in found.edits)
                names.append((left, bits, found))
                most = rank(likeliest[part.stop - 1]) + (FEW_DIGITS if i > 0 else 0.0)
                if left == 0 and (len(found.edits) > 1 or bits <= most):
                    return found
                continue
            # The nearest of all edits counts. Those of several layers may explain the stage
            # together with a scheme.
            located = [*(located if part.start else ()), found]
        # As in `_named`, those go first that hold in new scenes.
        if len(names) > 1 and unseen is not None:
            names = [one for one in names if self._holds(one[2], unseen)] or names
        if names:
            return min(names, key=itemgetter(0, 1))[2]
        # An edit that explains some scenes and breaks none is one of several mistakes.
        if (one := self._of_a_part(unseen)) is not None:
            return one
        near = tuple(edit for found in located for edit in found.near)
        return replace(min(located, key=attrgetter("left"), default=Located()), near=near)

    @cached_property
    def likeliest(self) -> list[Edit]:
        """The edits of all layers, sorted by `rank`."""
        wrong = self.followed.some[self.followed.beyond]
        options = self.stage.with_spin(take(self.columns, wrong))
        most, found = max(layer.edits.stop for layer in self.layers), list[Edit]()
        for likely in (LIKELY, math.inf):
            if len(found) < min(FEW_EDITS, most):
                every = itertools.chain(
                    edits(self.chain, self.stage, defaults(), options, most=likely),
                    edits_of_one_option(self.stage, defaults(), options),
                )
                found = heapq.nsmallest(most, every, key=self.rank)
        return found

    @cached_property
    def rank(self) -> Callable[[Edit], float]:
        """The function by which edits are sorted; see `_by_use`."""
        own = self.stage.with_spin(take(self.columns, self.followed.some))
        return _by_use(self.stage, self.followed, own)

    def _holds(self, found: Named, unseen: Unseen) -> bool:
        """True if the edits of a name together reproduce the candidate's numbers in new scenes."""
        chain, (*others, last) = self.chain, found.edits
        for edit in others:
            chain = edit.apply(chain)
        (stage,) = (stage for stage in chain if stage.key == self.stage.key)
        return unseen.holds(chain, stage, last, self.data.ways)

    def of_one_option(self) -> Named | None:
        """Edits that explain the stage, made only in the scenes with one option of a switch.

        A program may have separate code for these scenes.
        """
        f, columns = self.followed, self.stage.with_spin(self.columns)
        # Search in the scenes with all options that the wrong scenes share: the others are right.
        shared, like = list[tuple[int, str, str]](), np.ones_like(f.beyond)
        for key in SWITCHES & columns.keys():
            options, here = columns[key][f.some], columns[key][f.some[f.beyond]]
            if (here == here[0]).all() and (options != here[0]).any():
                shared.append((len(np.unique(options)), key, str(here[0])))
                like &= options == here[0]
        if min(f.beyond.sum(), (f.checked & ~like).sum()) < FEWEST:
            return None
        few, choice = f.of(np.flatnonzero(like)), math.log2(1 + len(shared))
        found = Explanation(
            self.chain, self.stage, self.data, self.columns, few, OF_OPTION, self.pairs, whole=self
        ).explain()
        if not isinstance(found, Named) or found.mends is not None or found.evidence < choice:
            return None
        # The edit may hold in all scenes. Otherwise one of the options is the condition: likeliest
        # that of the switch with fewest options.
        holds: list[tuple[int, tuple[Edit, ...]]] = []  # with the scenes that are wrong elsewhere
        for edits_there in (found.edits, *((edit,) for edit in found.same)):
            _, breaks = mended(f, self._with(edits_there)[1])
            # A random option divides wrong scenes and broken ones with this probability, in bits.
            wrong = int(f.beyond.sum())
            bits = math.log2(math.comb(wrong + breaks, wrong)) - choice
            ways = [edits_there]
            for _, key, option in sorted(shared) if bits > SHARED else ():
                every = np.unique(columns[key]).tolist()
                ways.append(tuple(edit.where(key, option, every) for edit in edits_there))
            for way in ways:
                placed = tuple(map(self._placed, way))
                chain, after = self._with(placed)
                if not after.beyond.any():
                    holds.append((self._left(chain), placed))
        if not holds:
            return None
        return Named(min(holds, key=itemgetter(0))[1], found.evidence - choice)

    def _with(self, some: Sequence[Edit]) -> tuple[tuple[Stage, ...], Followed]:
        """The chain with some edits, and the residuals of the stage."""
        chain = self.chain
        for edit in some:
            chain = edit.apply(chain)
        (stage,) = (s for s, was in zip(chain, self.chain, strict=True) if was is self.stage)
        rough = any(edit.rough for edit in some)
        return chain, self._compared(stage, self.followed.some, rough)

    @cached_property
    def responses(self) -> list[tuple[Response | Direct, Array]]:
        """First-order effects along a path, with the errors that they are compared with.

        If the candidate's ball lands far off, there is a second path: the cubic between the
        candidate's own end states.
        """
        flies = self.stage.kind == "flight"
        known = Values(self.stage.with_spin(take(self.columns, self.all[self.mild])))
        way = (Response if flies else Direct)(self.stage, known)
        off, floor = self.base.off[:, self.mild], self.base.floor[:, self.mild]
        off = np.where(np.abs(off) >= HUGE, self._given(self.mild), off)
        errors = np.where(np.abs(off) <= floor, 0.0, off)  # NaN where nothing is given
        # An event function is 0 at the candidate's value if the edit is right: the edit moves it by
        # minus the residual.
        found = [(way, -errors if self.stage.kind == "event" else errors)]
        if flies and _median(self.base.relative[self.mild[:WRONG]]) > FAR_OFF:
            given = self._given(self.mild)[:6]
            made = values(self.stage, known.columns, COARSE)
            ends = np.concatenate([made[q] for q in self.stage.quantities[:2]])[: len(given)]
            ends = np.where(np.isfinite(given), given, ends)
            along = Response(self.stage, known, cubic(ends), free)
            found.append((along, np.where(np.isfinite(given), along.off(ends), np.nan)))
        return found

    @np.errstate(all="ignore")
    def candidates(self, some: Sequence[Edit], layer: Layer, needed: float) -> list[_Screened]:
        """Screen the edits of a layer.

        The search ends soon after an edit that saves the bits `needed` in the screening scenes.

        Return the groups sorted by the cost that they leave in the screening scenes plus their own.
        """
        # Random inputs, in which equal edits are detected. The screening scenes are repeated: if
        # they are few, their random moves still give several values.
        scenes = np.concatenate([self.all, np.tile(self.all[self.few], TIMES)])
        probe = self.probe = Values(_moved_at_random(self.stage, take(self.columns, scenes)))
        # The candidate's own point, and points beside it in all directions: see `_is_possible`.
        place = str(OWN[self.stage.quantities[0]].data)
        own = self.stage.with_spin(take(self.columns, self.all))
        own[FREE] = np.full(len(self.all), USUAL_NUMBER)
        self.there, *self.beside = (
            Values({**own, place: own[place] + by}) for by in (0.0, MOVED, -MOVED)
        )
        # Rank the edits by their cost plus that of the errors that their first-order effects leave.
        responses = self.responses[layer.paths]
        flies, at = self.stage.kind == "flight", responses[0][0].at
        bits: list[Array] = []
        for first in range(0, len(some), CHUNK):
            part = some[first : first + CHUNK]
            starts = [self._starts(edit, at) for edit in part]
            every = [Effects(way, part, starts, errors) for way, errors in responses]
            self.fits = every[0]
            # Flights are expensive: skip edits that explain almost nothing to first order.
            left = np.min([one.left() for one in every], axis=0)
            unlike = flies & (left > UNLIKE)
            bits.append(np.where(unlike, np.inf, np.min([one.bits() for one in every], axis=0)))
            self.least = min(self.least, float(left.min(initial=1.0)))
        total = np.concatenate(bits)
        ranks = np.argsort(total, kind="stable")[: np.isfinite(total).sum()]
        # Group equal edits. Skip an edit that changes nothing, and a constant in place of a divisor
        # if it divides by 0 in every scene.
        groups: dict[bytes, list[Edit]] = {}
        unchanged = _fingerprint(self.stage, probe)
        for edit in (some[i] for i in ranks):
            stage = self.edited(edit)
            if not self._is_possible(stage):
                continue
            if edit.by.op == "constant" and not _is_finite(stage, self.stage, probe):
                continue
            if (key := _fingerprint(stage, probe)) == unchanged:
                continue
            if key not in groups and len(groups) == layer.tried:
                break
            groups.setdefault(key, []).append(edit)
        # The best groups, computed in the screening scenes.
        null = cost(self.off / self.roughly * self.finer_few)
        found, last = list[_Screened](), math.inf
        for k, group in enumerate(groups.values()):
            if flies and k > last + FURTHER:  # flights are expensive: stop soon after a good edit
                break
            group.sort(key=lambda edit: edit.bits)
            edit, stage = group[0], self.edited(group[0])
            # Many trials in long steps. Of an edit that explains something there, the number is
            # then fitted exactly.
            quickly, exactly = self.screened(stage, (MIDDLE,)), self._screened_exactly(stage)
            if edit.starts:
                c, r = _fitted_from(quickly, self._starts(edit, at), edit.factor)
            else:
                c, (r,) = np.zeros(0), quickly(np.zeros((1, 0)))
            if not (lost := bool((r == LOST).any())) and cost(r) >= NEARER * self.null:
                continue
            if lost or self._moves_jumps(stage):
                c, r, _ = fitted(exactly, c[None], 2)
            number = 0.0
            if edit.starts:
                best = float(c[0])
                group[0] = replace(edit, starts=(best,))
                # Cost of the number: that of the roundest one which fits as well.
                number = min(
                    bits for x, bits in rounded(best, FACTORS)
                    if abs(x - best) <= FITTED * abs(best)
                )  # fmt: skip
                made = self.edited(edit.settled(best, 0.0))
                if not self._is_possible(made):
                    continue
            left = cost(r)
            saved = null - cost(r * self.finer_few)
            explains = is_adequate(r, edit.rough) and saved - edit.bits - number > needed
            # Many edits explain a few screening scenes, and most of them fail in others.
            if explains and self._fit(self.settled(group[0])[0])[0] != "partial":
                last = k
            if left < NEARER * self.null:
                found.append(_Screened(left, group, explains))
        found.sort(key=lambda one: one.left + one.group[0].bits)
        return found

    @np.errstate(all="ignore")
    def _is_possible(self, stage: Stage) -> bool:
        """True unless an edit leaves an event whose function is flat about the ball's position.

        A flat function is small wherever a flight ends, and would explain any end.
        """
        if stage.kind != "event":
            return True
        zero, old = stage.roots["zero"], self.stage.roots["zero"]
        if np.mean(np.abs(self.probe.of(zero)) < NOTHING) > ANYWHERE:
            return False
        for beside in self.beside:
            change, usual = (np.abs(beside.of(x) - self.there.of(x)) for x in (zero, old))
            if np.mean(change <= FLAT * usual) > ANYWHERE:
                return False
        return True

    def _starts(self, edit: Edit, at: Values) -> list[float]:
        """Initial values of an edit's free number; the median of an expression."""
        return [_median(at.of(x)) if isinstance(x, Node) else x for x in edit.starts]

    def settled(self, edit: Edit) -> tuple[Edit, tuple[float, float, float]]:
        """Fit the free number of an edit, if it has one, and round it as the residuals allow.

        Return the edit, and the number with its bits and its spread.
        """
        if not edit.starts:
            return edit, (math.nan, 0.0, 0.0)
        if edit not in self.numbers:
            stage = self.edited(edit)
            (start,) = edit.starts  # the number that `candidates` has fitted
            assert isinstance(start, float)
            with np.errstate(all="ignore"):
                c, *_ = fitted(self._residual(stage, self.few, MIDDLE), [(start,)], 2)
                every = self._residual(stage, np.arange(len(self.all)), FINE)
                c, r, slopes = fitted(every, c[None], 1)
                shows = float(np.sqrt(np.nansum(np.square(slopes[0] * c[0]))))
                spread = 1.0 / max(shows, 1.0 / SPREAD)
                self.numbers[edit] = *_roundest(c, r, slopes, 0), spread
        return edit.settled(*self.numbers[edit]), self.numbers[edit]

    def _explained_by(
        self, some: Sequence[Edit], tried: int, layer: Layer, unseen: Unseen | None
    ) -> Named | Located:
        """One or two edits of a layer that explain the stage; `tried` edits were tried so far."""
        # Rule 2 of docs/truth.md: bits beyond chance and the choice among the edits that were
        # tried.
        needed = CHANCE + math.log2(1 + tried)
        if self.null_all < needed:  # no edit can save more than the errors cost
            return Located()
        found = self.candidates(some, layer, needed)
        near = tuple(one.group[0] for one in found[:NEAR])
        alone = min((one.left for one in found), default=self.null)
        found = [one for one in found if one.left <= HALF * self.null]
        others = [one for one in found if not one.fitted][:HELD]
        found = [one for one in found if one.fitted or one in others]
        verified = [*self._verified(found, needed)]
        # Rule 1 of docs/truth.md: an edit that needs the noise of steps across a jump counts only
        # if no other edit explains the stage. Rule 3 chooses among edits of the same kind.
        for fit in ("exact", "rough"):
            adequate = [(e, x.evidence) for x in verified if x.fit == fit for e in x.alike]
            if adequate:
                return self._named(adequate, unseen)
        # No single edit explains the stage: there may be two mistakes. If one of them explains most
        # of the wrong scenes, it is the best edit, and a second one is searched for beside it.
        # Otherwise neither explains much alone, and the first-order effects of all pairs show which
        # edit to begin with.
        partial = [one for one in verified if one.fit == "partial"]
        self.partial += partial
        best = min(partial, key=attrgetter("bits"), default=None)
        if layer.pairs and self.pairs and self.null_all >= 2 * needed:
            shows = best is not None and self._share(best.r) >= MOST
            for edit in [best.edit] if best and shows else self._in_pairs(alone, self.pairs):
                if (both := self._with_another(edit, needed)) is not None:
                    return both
        if best is None:
            return Located(near=near)
        return Located(best.edit, best.left / self.null_all, near)

    def _of_a_part(self, unseen: Unseen | None) -> Named | None:
        """The edit that explains the largest part of the errors; None if no edit explains a part.

        It makes many of the wrong scenes right, and breaks no other.
        """
        found = defaultdict[int, list[tuple[Edit, float]]](list)  # by the scenes that they mend
        # An event has a single residual, which wrong coordinates make 0 in many scenes, too.
        for one in self.partial if self.stage.kind != "event" else ():
            # A number with many digits may fit a few similar scenes by coincidence.
            if one.number <= NUMBER + DIGIT:
                after = self._compared(self.edited(one.edit), self.followed.some, one.edit.rough)
                mends, breaks = mended(self.followed, after)
                # Many mistakes in a condition have the same effect on its decisions.
                tell = (self.followed.beyond & ~after.beyond & ~self.decided).sum()
                if tell >= FEWEST and not breaks and self._is_exact(after):
                    found[mends] += [(edit, one.evidence) for edit in one.alike]
        least = max(FEWEST, PART * self.followed.beyond.sum())
        for mends in sorted((n for n in found if n >= least), reverse=True):
            held = [
                (edit, evidence)
                for edit, evidence in found[mends]
                if unseen is None or unseen.mends(self.chain, self.stage, edit, self.data.ways)
            ]
            if held:
                return replace(self._named(held, None), mends=mends)
        return None

    def _is_exact(self, after: Followed) -> bool:
        """True if the errors in the scenes that an edit mends are about those of right scenes.

        An edit that only reduces errors mends the scenes in which they are small.
        """
        mends = self.followed.beyond & ~after.beyond
        usual = self.noise if math.isfinite(self.noise) else ADEQUATE
        return _noise(after, mends) <= max(ADEQUATE, NOISY * usual)

    def _verified(self, found: Sequence[_Screened], needed: float) -> Iterator[_Verified]:
        """Compute the first edit of each group of `candidates` in all scenes; yield good ones.

        An edit is good if it saves the bits `needed`.
        """
        for screened, group, is_fitted in found:
            # A group that leaves much is verified only if it is about the best: it may be one of
            # two, or long steps may be too coarse for it.
            limit = max(RIVAL * self.null, ABOUT * found[0].left)
            if screened > limit and not is_fitted:
                continue
            (edit, more), twins = self.settled(group[0]), group[1:TWINS]
            if group[0].starts:
                twins = [twin.settled(*more) for twin in twins if twin.starts]
                # The fitted number may equal that of an edit without a free number, such as "uses 1
                # for …". Such an edit is cheaper.
                place, same = (edit.place, edit.within), _fingerprint(self.edited(edit), self.probe)
                twins += [
                    e for e in (self.whole or self).likeliest
                    if not e.starts and (e.place, e.within) == place
                    and _fingerprint(self.edited(e), self.probe) == same
                ]  # fmt: skip
            else:
                twins = [twin for twin in twins if not twin.starts]
            fit, after = self._fit(edit)
            left = _bits(after)
            if self.null_all - left - edit.bits < needed:
                continue
            # A sample may lack the right scenes that the edit breaks.
            if fit != "partial":
                fit, _ = self._fit(edit, everywhere=True)
            alike = tuple(e for e in (edit, *twins) if self._is_possible(self.edited(e)))
            evidence = self.null_all - left - edit.bits - needed
            yield _Verified(edit, alike, _in_floors(after), left, evidence, fit, more[1])

    def _fit(self, edit: Edit, everywhere: bool = False) -> tuple[Fit, Followed]:
        """The fit of an edit without a free number, and its residuals.

        It is that in `all` scenes; or, if `everywhere`, in every scene of the stage.
        """
        stage, f = self.edited(edit), self.followed
        some, wrong = (f.some, f.beyond) if everywhere else (self.all, self.base.beyond)
        after = self._compared(stage, some)
        if is_adequate(_in_floors(after), edit.rough, wrong):
            return "exact", after
        if edit.rough:
            after = self._compared(stage, some, rough=True)
            if is_adequate(_in_floors(after), True, wrong):
                return "rough", after
        return "partial", after

    def _share(self, r: Array) -> float:
        """Fraction of the wrong scenes in which a residual, in floors, is within the noise."""
        return float(np.mean(np.nan_to_num(np.abs(r[:, self.base.beyond])).max(axis=0) <= ADEQUATE))

    @np.errstate(all="ignore")
    def _in_pairs(self, best: float, count: int) -> list[Edit]:
        """The edits, at most `count`, with which to begin a search for two mistakes.

        Each comes from one of the best pairs of `Effects.pairs`, and is the edit of the pair that
        explains more alone. `best` is the cost that the best single edit leaves in the screening
        scenes.
        """
        found: list[_Pair] = []
        for (one, a), (two, b) in self.fits.pairs(TOGETHER):
            # If the node of one edit contains that of the other, it is edited first: the other edit
            # would change it.
            if contains(one.place, two.place):
                (one, a), (two, b) = (two, b), (one, a)
            # Both free numbers have the same symbol. Rename that of `two` before `one` adds its
            # own.
            stage = self.edited(two)
            if a is not None:
                stage = _renamed(stage, *NUMBERS)
            (stage,) = one.apply([stage])
            starts = [x for x in (a, b) if x is not None]
            c, r, _ = fitted(self.screened(stage, (MIDDLE,)), [starts], 4)
            if (left := cost(r)) <= BETTER * best:
                found.append(_Pair(left + one.bits + two.bits, one, two, stage, c))
        # Of pairs with nearly equal costs, prefer those that explain other stages as well: stages
        # share definitions.
        least = min((pair.bits for pair in found), default=0.0)
        found = [pair for pair in found if pair.bits < least + RIVALS][:ELSEWHERE]
        found.sort(key=lambda pair: pair.bits + self._elsewhere(pair))
        return [self._settled_beside(pair) for pair in found[:count]]

    def _settled_beside(self, pair: _Pair) -> Edit:
        """The edit of a pair that explains more, with the roundest number that fits."""
        both, numbers = (pair.one, pair.two), np.split(pair.c, [len(pair.one.starts) and 1])
        left = [
            cost(self.screened(self.edited(edit), (MIDDLE,))(number[None]))
            for edit, number in zip(both, numbers, strict=True)
        ]
        which = int(left[1] < left[0])
        if not both[which].starts:
            return both[which]
        with np.errstate(all="ignore"):
            every = self._residual(pair.stage, np.arange(len(self.all)), FINE)
            c, r, slopes = fitted(every, pair.c[None], 2)
            number, bits = _roundest(c, r, slopes, which if len(c) > 1 else 0)
        return both[which].settled(number, bits)

    def _elsewhere(self, pair: _Pair) -> float:
        """Bits that the errors of other stages cost with a pair of edits."""
        numbers = iter(pair.c.tolist())
        one, two = (
            edit.settled(next(numbers), 0.0) if edit.starts else edit
            for edit in (pair.one, pair.two)
        )
        made, total = one.apply(two.apply(self.chain)), 0.0
        for stage, was in zip(made, self.chain, strict=True):
            if stage is not was and was is not self.stage:
                some = np.flatnonzero(np.isin(self.columns["kind"], stage.scenes))
                few = evenly(some, WRONG + RIGHT)
                total += cost(_in_floors(compared(stage, self.data, self.columns, few)[0]))
        return total

    def _with_another(self, edit: Edit, needed: float) -> Named | None:
        """Two edits that explain the stage together; each has to save the bits `needed`."""
        edit = self._placed(edit)
        chain = edit.apply(self.chain)
        (stage,) = [s for s, was in zip(chain, self.chain, strict=True) if was is self.stage]
        f = compared(stage, self.data, self.columns, self.followed.some)[0]
        if not f.beyond.any() or not self._is_possible(stage):
            return None
        # Search for the second edit in the chain with the first one applied, without pairs.
        second = Explanation(chain, stage, self.data, self.columns, f, BESIDE_ANOTHER).explain()
        if isinstance(second, Located) or second.mends is not None:
            return None
        both = (edit, *second.edits)
        for one in second.edits:
            (stage,) = one.apply([stage])
        left = _bits(self._compared(stage, self.all))
        spent = left + sum(one.bits + needed for one in both)
        return Named(both, second.evidence) if spent < self.null_all else None

    def _named(self, adequate: Sequence[tuple[Edit, float]], unseen: Unseen | None) -> Named:
        """Choose among adequate edits: the one that breaks least elsewhere, then the cheapest.

        Edits that do not reproduce the candidate's numbers in new scenes are dropped, unless this
        would drop all.
        """
        cheapest = min(edit.bits for edit, _ in adequate)
        ranked = [
            (self._broken(edit), edit, evidence)
            for edit, evidence in adequate
            if edit.bits <= cheapest + RIVALS
        ]
        ranked.sort(key=lambda one: (one[0], one[1].bits))
        if unseen is not None and len(ranked) > 1:
            ways = self.data.ways
            holds = (one for one in ranked if unseen.holds(self.chain, self.stage, one[1], ways))
            ranked = [*itertools.islice(holds, 1 + LISTED)] or ranked
        _, best, evidence = ranked[0]
        same = tuple(edit for _, edit, _ in ranked[1 : 1 + LISTED])
        return Named((self._placed(best),), evidence, same)

    def _placed(self, edit: Edit) -> Edit:
        """The edit in the widest scope that leaves fewest scenes wrong.

        The scopes are all stages that use the definition; all flights, which share one law; the
        flights of the same ball; this stage alone. Each is followed through the whole chain,
        because a wrong pitch hides what an edit does to later stages.
        """
        scopes: list[tuple[Stage, ...] | None] = [None]
        if self.stage.kind == "flight":
            flights = tuple(stage for stage in self.chain if stage.kind == "flight")
            launch = self.stage.roots["velocity"]
            scopes += [flights, tuple(s for s in flights if s.roots["velocity"] is launch)]
        found: dict[tuple[bool, ...], tuple[Edit, tuple[Stage, ...]]] = {}
        for only in (*scopes, (self.stage,)):
            placed = replace(edit, only=only)
            chain = placed.apply(self.chain)
            changed = (s is not was for s, was in zip(chain, self.chain, strict=True))
            found.setdefault(tuple(changed), (placed, chain))
        if len(found) == 1:  # only this stage uses the definition
            return edit

        return min(found.values(), key=lambda one: self._left(one[1]))[0]

    def _left(self, chain: tuple[Stage, ...]) -> int:
        """The number of scenes in which the stages of a chain are wrong."""
        return sum(int(f.beyond.sum()) for f in follow(chain, self.data)[1])

    def _left_by(self, found: Named) -> int:
        """The number of wrong scenes in all flights with the definition that a name changes."""
        chain = self.chain
        for edit in found.edits:
            chain = replace(edit, only=None).apply(chain)
        pairs = zip(self.chain, chain, strict=True)
        flights = [s for was, s in pairs if s is not was and s.kind == self.stage.kind == "flight"]
        return sum(self._wrong(s) for s in flights)

    def _broken(self, edit: Edit) -> int:
        """The number of scenes that an edit makes wrong at other stages; below 0 if it mends some.

        An edit that would break other stages is made at this stage alone, and breaks none.
        """
        more = sum(
            self._wrong(stage) - self._wrong(before)
            for before, stage in zip(self.chain, edit.apply(self.chain), strict=True)
            if stage is not before and before is not self.stage
        )
        return min(more, 0)

    def _wrong(self, stage: Stage) -> int:
        """The number of scenes in which a stage is wrong, of those in `_telling`."""
        some = self._telling(stage.key)
        probe = Values(_moved_at_random(stage, take(self.columns, some)))
        key = stage.key, _fingerprint(stage, probe)
        if key not in self.counted:
            with np.errstate(all="ignore"):
                one, _ = compared(stage, self.data, self.columns, some)
            self.counted[key] = int(one.wrong.sum())
        return self.counted[key]

    def _telling(self, key: tuple[str, Kind]) -> Index:
        """Scenes in which the edits of a stage are compared: wrong ones, and right ones."""
        if key not in self.telling:
            (stage,) = (one for one in self.chain if one.key == key)
            here = np.flatnonzero(np.isin(self.columns["kind"], stage.scenes))
            wrong = compared(stage, self.data, self.columns, here)[0].wrong
            some = evenly(here[wrong], MOST_WRONG), evenly(here[~wrong], MOST_RIGHT)
            self.telling[key] = np.concatenate(some)
        return self.telling[key]


# Limits of the comparison: free choices.
# An edit that explains at least this fraction of the wrong scenes is tried as one of two mistakes.
MOST = 0.5
ABOUT = 2.0  # times what the best group leaves: groups that are about as good
RIVAL = 0.2  # largest fraction of the initial cost that a right edit leaves in screening scenes
SHARED = math.log2(ODDS)  # bits: least evidence that an option is the condition of an edit
NOISY = 10.0  # times the errors of right scenes: largest ones of scenes that an edit mends
UNLIKE = 0.8  # fraction of the squared errors that an edit of a flight must not leave
SHOWS = 0.5  # largest fraction of them that the best edit leaves if the errors have a cause
FURTHER = 12  # groups that are still computed after one that explains the screening scenes
FEW_EDITS = 20_000  # if fewer cost `LIKELY` bits or less, all are generated
RIGHT_USES = 2.0  # weight of the right scenes that use a node, as evidence for the node
FEW_DIGITS = NUMBER + 3 * DIGIT  # bits: a number that costs more may stand for a formula
SPREAD = 1e-6  # largest relative uncertainty of a number that later stages may show
FITTED = 1e-8  # relative error of a free number that is fitted in the screening scenes
BETTER = 0.8  # a pair must leave less than this fraction of the best single edit's cost
ELSEWHERE = 8  # pairs that are compared by the errors of other stages
TOGETHER = 40  # pairs with the best first-order fits, which are computed in the screening scenes
NUMBERS = FREE, f"{FREE}'"  # symbols of the free numbers of two edits
LISTED = 3  # equal edits that a verdict lists with the named one
RIVALS = 10.0  # bits: an edit that costs more than this above the cheapest is no rival
# An edited event function is rejected if it is below NOTHING, m, for more than the fraction
# ANYWHERE of balls at random positions; or if, in more than that fraction of the scenes, a
# displacement of the ball by MOVED, m, changes it by less than FLAT times the change without the
# edit.
NOTHING, ANYWHERE = 1e-9, 0.1
MOVED, FLAT = 0.1, 0.3
USUAL_NUMBER = 0.5  # the value of a free number there


def _by_use(
    stage: Stage, followed: Followed, columns: Mapping[str, Any]
) -> Callable[[Edit], float]:
    """Bits of an edit, and of the share of wrong scenes among those that use its node.

    A node that mostly right scenes use is less likely the wrong one.
    """
    forms = itertools.chain.from_iterable(stage.forms.values())
    roots = frozenset((*stage.roots.values(), *forms))
    users, checked = used([*roots], columns), followed.checked

    @cache
    def bits(*nodes: Node) -> float:
        flags = np.any([users.get(node, np.False_) & checked for node in nodes], axis=0)
        share = ((flags & followed.beyond).sum() + 1) / (flags.sum() + 2)
        return -RIGHT_USES * math.log2(share)

    def rank(edit: Edit) -> float:
        node = edit.place if edit.within is None else edit.within[1]
        if node in roots:  # of a whole formula, the innermost nodes that the edit replaces
            kept = frozenset(ordered([edit.new]))
            lost = [x for x in ordered([node], kept) if x not in kept]
            inner = [x for x in lost if kept.issuperset(x.args)]
            return edit.bits + bits(*(inner or [node]))
        return edit.bits + bits(node if node in users else edit.place)

    return rank


def _jumps(stage: Stage) -> set[str]:
    """The numbers at whose zeros a law jumps, in words: definitions by name only."""
    return {words(node.args[0]) for node in ordered([stage.roots["law"]]) if node.op in JUMPS}


def _fitted_from(
    screened: Callable[[Array], Array], starts: Sequence[float], factor: bool
) -> tuple[Array, Array]:
    """A free number with small errors, and those errors.

    Long steps may diverge for factors between 1 and that of the candidate, so that a fit from 1
    fails. Usual factors are therefore tried first, and the fit starts from the best numbers.
    """
    usual = [x for x in FACTORS if NEAR_ONE < abs(x) < 1 / NEAR_ONE] if factor else []
    tried = np.array([*dict.fromkeys((*starts, *usual))])[:, None]
    every = screened(tried)
    best = np.argsort([cost(r) for r in every], kind="stable")
    c, r, _ = fitted(screened, tried[best[:STARTS]])
    if cost(every[best[0]]) < cost(r):
        c, r = tried[best[0]], every[best[0]]
    return c, r


STARTS = 3  # starting values of the fit of a free number; a free choice


def _moved_at_random(stage: Stage, columns: Mapping[str, Any]) -> dict[str, Any]:  # a free choice
    """Columns with every number moved at random: unequal edits then give unequal values."""
    draw = np.random.default_rng(0)
    moved: dict[str, Any] = {}
    for name, column in stage.with_spin(columns).items():
        if column.dtype.kind != "f":
            moved[name] = column
            continue
        shifted = column * (1.0 + 0.1 * draw.normal(size=column.shape))
        if not (column > 0).all():
            shifted = shifted + 0.05 * draw.normal(size=column.shape)
        moved[name] = shifted
    count = len(columns["kind"])
    # Plausible states in flight: about 30 m/s forwards or backwards and 10 m/s upwards at the
    # launch, and within about 20 m of (0, 0, 30).
    launch = np.array([[30.0], [3.0], [10.0]]) * (1 + 0.5 * draw.normal(size=(3, count)))
    launch[0] *= draw.choice([-1.0, 1.0], size=count)
    moved |= {
        "v0": launch, "v": (v := 0.7 * launch + 5.0 * draw.normal(size=(3, count))), "dr/dt": v,
        "r": 20.0 * draw.normal(size=(3, count)) + np.array([[0.0], [0.0], [30.0]]),
        "r0": draw.normal(size=(3, count)), "t": draw.uniform(0.1, 3.0, count),
        "path": draw.uniform(10.0, 90.0, count), "ω0": 100.0 * draw.normal(size=(3, count)),
        FREE: draw.uniform(0.2, 0.9, count),
    }  # fmt: skip
    return moved


def _roundest(c: Array, r: Array, slopes: Array, which: int) -> tuple[float, float]:
    """The roundest value of one of the fitted free numbers, and its bits.

    The residual `r` is linear in the numbers, with the derivatives `slopes`; the others are fitted
    again.
    """
    known = np.isfinite(r) & np.isfinite(slopes).all(axis=0)
    others = np.delete(slopes, which, axis=0)[:, known].T
    near = []
    for x, bits in rounded(float(c[which]), FACTORS):
        off = r + slopes[which] * (x - c[which])
        if others.size:
            off = off[known]
            off = off - others @ np.linalg.lstsq(others, off, rcond=None)[0]
        near.append((cost(off) + bits, bits, x))
    _, bits, x = min(near)
    return x, bits


def _renamed(stage: Stage, old: str, new: str) -> Stage:
    """A stage with a symbol renamed."""
    for node in [node for node in ordered(stage.roots.values()) if node.data == old]:
        stage = stage.edited(node, symbol(new, node.dimension, node.vector))
    return stage


def _is_finite(stage: Stage, before: Stage, probe: Values) -> bool:
    """True if every new node is finite in at least one scene; a division by 0 is no edit."""
    known = {*ordered(before.roots.values())}
    with np.errstate(all="ignore"):
        made = (x for x in ordered(stage.roots.values(), (), probe.arguments) if x not in known)
        return all(bool(np.isfinite(np.asarray(probe.of(x))).any()) for x in made)


def _fingerprint(stage: Stage, probe: Values) -> bytes:
    """The values of a stage on random inputs, to seven digits: those of equal formulas agree."""
    found, roots = [], [*stage.roots.values()]
    # Random inputs hardly ever lie between the positions of two jumps, so that edits of a jump look
    # equal. Its condition tells them apart.
    roots += [x.args[0] for x in ordered(roots, (), probe.arguments) if x.op in JUMPS]
    with np.errstate(all="ignore"):
        for root in roots:
            x = np.asarray(probe.of(root))
            # Round relative to the size of each vector, because a component that should be 0 is a
            # rounding error. Adding 0.0 turns -0.0 into 0.0.
            size = np.abs(x).max(axis=0) if x.ndim > 1 else np.abs(x)
            found += [np.round(x / np.where(size > 0, size, 1.0), 7) + 0.0, size]
        return b"".join(x.astype(np.float32).tobytes() for x in found)
