"""First-order effects of edits, by which the search chooses the edits that it computes in full.

A small change of the acceleration moves the end of a flight by the integral, along the undisturbed
path, of the change times the derivative of the end by the velocity at that time. One batch of
flights gives these derivatives; then an edit costs one evaluation of its formula.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from longball.judge.diagnosis.chain import Stage
from longball.judge.diagnosis.expression import Evaluator, Node, Values, contains, depends
from longball.judge.diagnosis.operators import FREE, Edit
from longball.judge.diagnosis.residual import COARSE, START, Launched, flown, launched, take
from longball.model.arrays import Array

_PATH = frozenset(("path",))
# Accuracy of effects: free choices.
NODES = 10  # of a Gauss-Legendre rule over the time of flight
# Displacement for one-sided differences, m and m/s. The error of the differences is far below that
# of the long steps (`search.STEPS`).
KICK = 1e-4
OTHER = 1.1  # factor between two values of a free number, from which its effect follows
BESIDE_ZERO = 0.1  # the other value if the first is 0


# An edit, and a value of its free number, which is None if it has none.
Change = tuple[Edit, float | None]


class Many:
    """Values of formulas with many edits.

    Edits of the same node are evaluated together, on columns with a copy of the scenes for each
    edit.
    """

    def __init__(self, at: Values) -> None:
        self.at = at
        self._wide: dict[int, Values] = {}

    def of(self, root: Node, changes: Sequence[Change]) -> list[Array]:
        """Values of a formula, one for each change."""
        places: dict[Any, list[int]] = {}
        for i, (edit, _) in enumerate(changes):
            places.setdefault((edit.place, edit.within), []).append(i)
        found: list[Any] = [None] * len(changes)
        count = len(self.at.columns["kind"])
        for (place, within), every in places.items():
            for first in range(0, len(every), max(WIDTHS)):
                some = every[first : first + max(WIDTHS)]
                width = next(width for width in WIDTHS if width >= len(some))
                # The values of the replacements, with the scenes of one edit after those of
                # another.
                shape = np.shape(self.at.of(within[1] if within else place))[:-1]
                value = np.zeros((*shape, width, count))
                for k, i in enumerate(some):
                    edit, c = changes[i]
                    value[..., k, :] = self.at.given(edit.by, {FREE: c})
                value = value.reshape(*shape, -1)
                # The formula with these values of the node, on as many copies of the scenes.
                wide = self._on(width)
                if within is not None:
                    form, hole = within
                    value = wide.changed(form, hole, value)
                value = wide.changed(root, place, value)
                rows = np.broadcast_to(value, (3, width * count) if root.vector else width * count)
                rows = rows.reshape(*rows.shape[:-1], width, count)
                for k, i in enumerate(some):
                    found[i] = rows[..., k, :]
        return found

    def _on(self, width: int) -> Values:
        """The values on columns with `width` copies of the scenes."""
        if width not in self._wide:
            count = len(self.at.columns["kind"])
            self._wide[width] = Values(take(self.at.columns, np.tile(np.arange(count), width)))
        return self._wide[width]


# Numbers of edits that are evaluated together: with few different widths, the values of unedited
# nodes are computed few times. If there are fewer edits, the rest of the rows is padding.
WIDTHS = 1, 4, 16, 64  # free choices


# A function from balls and fractions of their flights to their states, shape (7, fractions, balls).
Path = Callable[[Launched, Array], Array]
# A function from balls, the states of a path and their fractions to the derivatives of the end
# (position and velocity) by these states, shape (6, 6, fractions, balls).
Sensitivity = Callable[[Launched, Array, Array], Array]


def flown_path(balls: Launched, shares: Array) -> Array:
    """States on the paths of balls under their law."""
    every = _repeated(balls, len(shares))
    whole = np.repeat(shares, len(balls.duration)) * every.duration
    return flown(every, whole, COARSE).reshape(7, len(shares), -1)


def cubic(end: Array) -> Path:
    """The cubics between the launch and given ends of flights, places and velocities."""

    def path(balls: Launched, shares: Array) -> Array:
        # Hermite's cubic for s from 0 to 1, and its derivative by the time. The path length is only
        # needed to rank edits of a decaying spin: the present speed times the time is good enough.
        s, lasts, y = shares[:, None], balls.duration, balls.y[:, None]
        went, v0, v1 = (end - balls.y[:6])[:3, None], y[3:6], end[3:, None]
        r = y[:3] + went * s * s * (3 - 2 * s) + lasts * s * (1 - s) * ((1 - s) * v0 - s * v1)
        v = 6 * s * (1 - s) * went / lasts + (1 - s) * (1 - 3 * s) * v0 + s * (3 * s - 2) * v1
        return np.concatenate([r, v, s * lasts * np.sqrt((v * v).sum(axis=0))[None]])

    return path


def kicked(balls: Launched, y: Array, shares: Array) -> Array:
    """Sensitivity of the end, from flights that begin at displaced states of the path."""
    # Seven copies of each state: one unchanged, six with one component displaced each. All of them
    # fly to the end in one batch.
    moved = np.tile(y.reshape(7, 1, -1), (1, 7, 1))
    moved[range(6), range(1, 7)] += KICK
    every = _repeated(balls, 7 * len(shares))
    rest = np.tile(np.repeat(1.0 - shares, len(balls.duration)), 7) * every.duration
    ends = flown(replace(every, y=moved.reshape(7, -1)), rest, COARSE).reshape(7, 7, -1)
    return ((ends[:6, 1:] - ends[:6, :1]) / KICK).reshape(6, 6, len(shares), -1)


def free(balls: Launched, y: Array, shares: Array) -> Array:
    """Sensitivity of the end without forces: a change of velocity moves it by the time left."""
    left = (1.0 - shares)[:, None] * balls.duration
    found = np.zeros((6, 6, *left.shape))
    found[range(6), range(6)] = 1.0
    found[range(3), range(3, 6)] = left
    return found


def _repeated(balls: Launched, times: int) -> Launched:
    return balls.some(np.tile(np.arange(len(balls.duration)), times))


class Response:
    """First-order effects of edits on the ends of a stage's flights.

    A change of the acceleration moves the end by its integral along the path, weighted by the
    sensitivity of the end. By default, path and sensitivity are those of the stage's law.

    If an edit leads a ball far from that path, the effects are not small. The path is then the
    `cubic` between the candidate's own ends, and the sensitivity that of `free` balls: 1 for the
    velocity, T - t for the position. With these weights, the integrals of the right acceleration
    give the end of any flight, however large the effects.

    Attributes
    ----------
    at
        Values at the nodes of a Gauss-Legendre rule.
    """

    def __init__(
        self, stage: Stage, known: Values, path: Path = flown_path,
        sensitivity: Sensitivity = kicked,
        nodes: int = NODES,
    ) -> None:  # fmt: skip
        self.stage, columns = stage, known.columns
        # The rule's nodes on 0 to 1, between the launch and the end.
        x, weights = np.polynomial.legendre.leggauss(nodes)
        shares = np.array([0.0, *(x + 1.0) / 2.0, 1.0])
        balls = launched(stage, columns)
        self._start, self._duration = balls.y[:6], balls.duration
        y = path(balls, shares)
        # Derivatives of the end: by position and velocity at the launch; by a velocity (for an
        # edited `rate`) and an acceleration at each node, times the node's weight; and by the
        # duration.
        by_state = sensitivity(balls, y[:, :-1], shares[:-1])
        self._at_launch = {"place": by_state[:, :3, 0], "velocity": by_state[:, 3:, 0]}
        during = by_state[:, :, 1:] * (weights[:, None] / 2.0 * balls.duration)
        self._during = {"rate": during[:, :3], "law": during[:, 3:]}
        self._at_end = balls.rates(y[:, -1], balls.duration)[:6]

        # The path, on which laws are evaluated.
        self._spin, count = balls.spin, len(balls.duration)

        def on_path(some: slice) -> Values:
            at = y[:, some].reshape(7, -1)
            tiled = take(columns, np.tile(np.arange(count), at.shape[1] // count))
            r, v, times = at[:3], at[3:6], (shares[some, None] * balls.duration).ravel()
            begun = {"r0": balls.y[:3], "v0": balls.y[3:6], "ω0": balls.spin}
            begun = {name: np.tile(x, len(times) // count) for name, x in begun.items()}
            steps = {str(START["r"].data): r, str(START["v"].data): v}
            return Values(
                {**tiled, **begun, **steps, "r": r, "v": v, "dr/dt": v, "t": times, "path": at[6]}
            )

        self.at = on_path(slice(1, -1))
        self._at_start, self._on_path = Many(known), Many(self.at)
        self._left = Many(on_path(slice(-1, None)))
        # An edit of the spin at the launch, or of the speed along the path, changes the law through
        # ω0 and the path. The path grows by the integrals, from the launch to each node and to the
        # end, of the polynomials that are 1 at one node and 0 at the others.
        law, spin_left = stage.roots["law"], stage.roots["spin_left"]
        self._law = Evaluator([law], self.at.columns, frozenset(("ω0", "path")))
        self._spin_left = Evaluator([spin_left], self._left.at.columns, _PATH)
        self._decays = depends(law, _PATH) or depends(spin_left, _PATH)
        basis = np.linalg.inv(np.polynomial.legendre.legvander(x, nodes - 1))
        grown = np.polynomial.legendre.legint(basis, lbnd=-1)
        self._until = np.polynomial.legendre.legval(np.append(x, 1.0), grown) / 2.0

    def _pushed(self, by: Array, name: str = "law") -> Array:
        """Change of the end, shape (6, balls), by an acceleration or a velocity along the path."""
        _, _, nodes, balls = self._during[name].shape
        a = np.broadcast_to(by, (3, nodes * balls)).reshape(3, nodes, balls)
        return np.asarray(np.einsum("ijkn,jkn->in", self._during[name], a))

    def _with_law(self, **other: Array) -> Array:
        """The change of the end, shape (6, balls), if the law has another ω0 or path."""
        at = {name: self.at.columns[name] for name in ("ω0", "path")}
        return self._pushed(self._law(**(at | other))[0] - self.at.of(self.stage.roots["law"]))

    def off(self, end: Array) -> Array:
        """Given ends minus those of `free` balls that the law accelerates along the path."""
        straight = self._start.copy()
        straight[:3] += self._duration * self._start[3:]
        return np.asarray(end - straight - self._pushed(self.at.of(self.stage.roots["law"])))

    def moved(self, changes: Sequence[Change]) -> Array:
        """Changes of the state, the spin and the path at the end, one for each of `changes`.

        Those of the spin and the path are the changes on the undisturbed path.
        """
        total = np.zeros((len(changes), 10, len(self._duration)))
        # Formulas are evaluated on the path, at the end, or (by default) at the launch.
        on_path = dict.fromkeys(("rate", "law", "through"), self._on_path)
        places = on_path | {"spin_left": self._left}
        share = self._left.at.of(self.stage.roots["spin_left"])
        for name, root in self.stage.roots.items():
            if name == "through" and not self._decays:
                continue
            here = [
                i
                for i, (edit, _) in enumerate(changes)
                if contains(root, edit.place) and self.stage.takes(name, edit.by)
            ]
            where = places.get(name, self._at_start)
            old = where.at.of(root)
            for i, value in zip(here, where.of(root, [changes[i] for i in here]), strict=True):
                change = value - old
                match name:
                    case "law" | "rate":
                        total[i, :6] += self._pushed(change, name)
                    case "place" | "velocity":
                        change = np.broadcast_to(change, (3, total.shape[2]))
                        total[i, :6] += np.einsum("ijn,jn->in", self._at_launch[name], change)
                    case "spin_left":
                        total[i, 6:9] += change * self._spin
                    case "spin":
                        total[i, 6:9] += share * change
                        turned = np.tile(change + self._spin, self._during["law"].shape[2])
                        total[i, :6] += self._with_law(ω0=turned)
                    case "through":
                        faster = np.broadcast_to(change, self.at.columns["path"].shape)
                        faster = faster.reshape(-1, total.shape[2]) * self._duration
                        *longer, at_end = np.einsum("jk,jn->kn", self._until, faster)
                        path = self.at.columns["path"] + np.ravel(longer)
                        total[i, :6] += self._with_law(path=path)
                        left = self._spin_left(path=self._left.at.columns["path"] + at_end)[0]
                        total[i, 6:9] += (left - share) * self._spin
                        total[i, 9] += at_end
                    case "duration":
                        total[i, :6] += self._at_end * change
        return total


class Direct:
    """Value of a formula, or of an event function, in some scenes."""

    def __init__(self, stage: Stage, known: Values) -> None:
        self.at, self._many = known, Many(known)
        (self._root,) = stage.roots.values()

    def moved(self, changes: Sequence[Change]) -> Array:
        """Changes of the value, one for each of `changes`."""
        shape = (3 if self._root.vector else 1, len(self.at.columns["kind"]))
        old = self.at.of(self._root)
        every = self._many.of(self._root, changes)
        return np.array([np.broadcast_to(value - old, shape) for value in every])


class Effects:
    """Fit of the first-order effects of edits to the errors, alone and in pairs.

    The fit scales the effect of an edit freely; two values of a free number span its effects. All
    scenes have the same weight: errors are divided by their size in the scene, or by the median
    size if the scene is right. `starts` are values of each edit's free number. The spin is used
    only if nothing else is wrong.

    A *trial* is an edit with one start: an edit has as many trials as its free number has starts.
    """

    def __init__(
        self, way: Response | Direct, edits: Sequence[Edit],
        starts: Sequence[Sequence[float]], off: Array,
    ) -> None:  # fmt: skip
        known, off = np.isfinite(off), np.nan_to_num(off)  # missing values count as right
        spin_alone = len(off) > ROWS and not off[:ROWS].any()
        rows = slice(ROWS, ROWS + 3) if spin_alone else slice(ROWS)
        known, off = known[rows], off[rows]
        sizes = np.sqrt((off * off).sum(axis=0))
        wrong = sizes > sizes.max(initial=0.0) * RIGHT
        scale = np.where(wrong, sizes, np.median(sizes[wrong]) if wrong.any() else 1.0)
        self.errors = (off / scale).ravel()
        self.edits = edits
        self.trials: list[Change] = []
        of, second = [], []
        for i, (edit, numbers) in enumerate(zip(edits, starts, strict=True)):
            for start in numbers if len(numbers) else (None,):
                self.trials.append((edit, start))
                of.append(i)
                second.append(None if start is None else (edit, OTHER * start or BESIDE_ZERO))
        self._of = np.array(of, int)  # the number of each trial's edit
        self._free = np.array([other is not None for other in second], bool)
        every = way.moved([*self.trials, *filter(None, second)])[:, rows]
        every = np.broadcast_to(every, (len(every), *off.shape)) / scale
        every = np.where(known & (np.abs(every) < FAR), every, 0.0).reshape(len(every), off.size)
        count = len(self.trials)
        moved, other = every[:count], np.zeros((count, every.shape[1]))
        # Orthonormal axes of each trial's effects (Gram-Schmidt): the first is along the effect,
        # the second, for a free number, along the part of its other effect that is orthogonal to
        # it.
        self._size, one = _unit(moved)
        beside = every[count:]
        along = np.einsum("ij,ij->i", one[self._free], beside)
        across = beside - along[:, None] * one[self._free]
        small = PARALLEL * np.abs(beside).max(axis=1, initial=0.0)
        across[np.abs(across).max(axis=1, initial=0.0) < small] = 0.0
        other[self._free] = across
        self._axes = np.stack([one, _unit(other)[1]])

    def left(self) -> list[float]:
        """Fraction of the squared errors that remains after a fit of each edit's effect.

        Of edits whose effects have the same direction, the one whose size is nearest comes first.
        """
        found = np.ones(len(self.edits))
        along = self._axes @ self.errors
        # Without a free number, an effect in the opposite direction explains nothing.
        forwards = self._free | (along[0] > 0)
        if (whole := float(self.errors @ self.errors)) > 0.0:
            # On orthonormal axes, a fit removes the squares of the components.
            rest = 1.0 - np.where(forwards, (along**2).sum(axis=0), 0.0) / whole
            with np.errstate(all="ignore"):
                amiss = np.where(self._free, 0.0, np.abs(np.log2(along[0] / self._size)))
            rest = np.minimum(rest * (1.0 + AMISS * np.nan_to_num(amiss)), 1.0)
            np.minimum.at(found, self._of, rest)
        return found.tolist()

    def bits(self) -> Array:
        """Bits of each edit plus those of the errors that its effect leaves."""
        numbers = np.count_nonzero(self.errors)
        own = np.array([edit.bits for edit in self.edits])
        return np.asarray(numbers / 2 * np.log2(np.maximum(self.left(), LINEAR)) + own)

    def pairs(self, count: int) -> list[tuple[Change, Change]]:
        """Pairs of trials whose effects together fit the errors best, the best ones first.

        An edit without a free number must have about the same effect in the pair as alone.
        """
        a, distinct = self.errors, self._distinct()
        one, other = self._axes[:, distinct]
        free, size = self._free[distinct], self._size[distinct]
        bits = np.array([self.trials[i][0].bits for i in distinct])
        whole, numbers = float(a @ a), np.count_nonzero(a)
        alone = whole - (one @ a) ** 2 - (other @ a) ** 2
        found = []
        for i in np.argsort(alone, kind="stable")[:FIRSTS]:
            u, w = one[i], other[i]
            rest = a - (u @ a) * u - (w @ a) * w
            # Least squares of `rest` on the two axes of every second trial at once, each less its
            # parts along u and w. `n` and `m` are their squares then, `slant` is their product.
            uu, uw, wu, ww = one @ u, one @ w, other @ u, other @ w
            n, m = 1.0 - uu**2 - uw**2, (other**2).sum(axis=1) - wu**2 - ww**2
            slant = -(uu * wu + uw * ww)
            # The second axis less its part along the first has the square `across`. `p` and `q` are
            # the coefficients on these orthogonal axes, `by` is that of the first axis itself.
            with np.errstate(all="ignore"):
                p = np.where(n > PARALLEL, (one @ rest) / n, 0.0)
                across = m - slant**2 / n
                q = np.where(across > PARALLEL, (other @ rest - slant * p) / across, 0.0)
                by = p - np.where(q == 0.0, 0.0, slant / n * q)
            fitted = n * p**2 + np.where(q == 0.0, 0.0, across * q**2)
            left = np.maximum(rest @ rest - fitted, 0.0) / whole
            # Without a free number, the fitted size of an effect must be near its own size.
            does = free | ((by > size / ABOUT) & (by < size * ABOUT))
            if not free[i]:
                own = u @ a - uu * by - wu * q
                does &= (own > size[i] / ABOUT) & (own < size[i] * ABOUT)
            score = numbers / 2 * np.log2(np.maximum(left, LINEAR)) + bits + bits[i]
            found += [
                (score[j], i, j)
                for j in np.argsort(np.where(does, score, np.inf), kind="stable")[:count]
                if does[j]
            ]
        best = {frozenset((i, j)): (i, j) for _, i, j in sorted(found)}
        return [
            (self.trials[distinct[i]], self.trials[distinct[j]])
            for i, j in [*best.values()][:count]
        ]

    def _distinct(self) -> list[int]:
        """The cheapest of all trials whose effects have the same directions."""
        # Trials with the same axes project a random vector to the same shadow. Trials without a
        # free number also need the same size to be equal.
        probe = np.random.default_rng(0).normal(size=self.errors.shape)
        shadow = sum((axis @ probe)[:, None] * axis for axis in self._axes)
        sizes = np.where(self._free, 0.0, np.float32(self._size))
        found: dict[bytes, int] = {}
        for i in sorted(range(len(self.trials)), key=lambda i: self.trials[i][0].bits):
            if self._size[i] > 0.0:
                key = (np.round(shadow[i], 5) + 0.0).tobytes() + sizes[i].tobytes()
                found.setdefault(key, i)
        return [*found.values()]


def _unit(rows: Array) -> tuple[Array, Array]:
    """Sizes of vectors, and their directions."""
    sizes = np.sqrt((rows * rows).sum(axis=1))
    return sizes, np.divide(rows, sizes[:, None], out=np.zeros_like(rows), where=sizes[:, None] > 0)


ROWS = 6  # position and velocity; the next three are the spin, and the last is the path
# Limits of the comparison: free choices.
FAR = 1e9  # in units of the error: larger effects are ignored
RIGHT = 1e-9  # a scene is right if its error is below this fraction of the largest one
PARALLEL = 1e-7  # fraction of an effect: an orthogonal part below it is rounding
FIRSTS = 200  # edits that fit best alone; at least one edit of a pair must be among them
AMISS = 1e-3  # relative penalty for each factor of 2 between an edit's effect and its fitted size
ABOUT = 2.0  # factor by which the effect of a finite edit may differ from its first-order effect
# Fraction of the squared errors that first-order effects leave even if the edit is right: smaller
# rests are not compared.
LINEAR = 1e-6
