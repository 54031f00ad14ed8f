"""First-order effects of edits, by which the search chooses the edits that it computes in full.

A small change of the acceleration moves the end of a flight by the integral, along the undisturbed
path, of the change times the derivative of the end by the velocity at that time. One batch of
flights gives these derivatives; then an edit costs one evaluation of its formula.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from longball.judge.diagnosis.chain import Stage
from longball.judge.diagnosis.expression import Evaluator, Node, Values, contains
from longball.judge.diagnosis.operators import FREE, Edit
from longball.judge.diagnosis.residual import COARSE, START, flown, launched, take
from longball.model.arrays import Array

NODES = 10  # of a Gauss-Legendre rule over the time of flight
KICK = 1e-4  # m and m/s: the change by which derivatives are taken
OTHER = 1.1  # factor between the two values of a free number that are tried


# An edit, and a value of its free number.
Change = tuple[Edit, float | None]


class Many:
    """Values of formulas with many edits, in some scenes.

    Edits of one place are evaluated together, on columns that hold a copy of the scenes for each
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
                shape = (3,) if (within[1] if within else place).vector else ()
                value = np.zeros((*shape, width, count))
                for k, i in enumerate(some):
                    edit, c = changes[i]
                    value[..., k, :] = self.at.given(edit.by, {FREE: c})
                value = value.reshape(*shape, -1)
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
        """The values on columns of so many copies of the scenes."""
        if width not in self._wide:
            count = len(self.at.columns["kind"])
            self._wide[width] = Values(take(self.at.columns, np.tile(np.arange(count), width)))
        return self._wide[width]


WIDTHS = 1, 4, 16, 64  # numbers of edits that are evaluated together; the last ones are padding


class Response:
    """A flight stage in some scenes, and how its end depends on what happens during the flight."""

    def __init__(self, stage: Stage, known: Values) -> None:
        self.stage = stage
        self._launch, columns = known, known.columns
        count = len(columns["kind"])
        x, weights = np.polynomial.legendre.leggauss(NODES)
        shares = np.repeat([0.0, *(x + 1.0) / 2.0], count)
        on_path = take(columns, np.tile(np.arange(count), NODES + 1))
        balls = launched(stage, on_path)
        duration = balls.duration
        y = flown(balls, shares * duration, COARSE)

        # The derivatives of the end, by components, by those of the state at each node.
        kicked = np.tile(y[:, None], (1, 7, 1))
        kicked[range(6), range(1, 7)] += KICK
        every = launched(stage, take(on_path, np.tile(np.arange(len(shares)), 7)))
        rest = np.tile((1.0 - shares) * duration, 7)
        ends = flown(replace(every, y=kicked.reshape(7, -1)), rest, COARSE).reshape(7, 7, -1)
        by_state = ((ends[:6, 1:] - ends[:6, :1]) / KICK).reshape(6, 6, NODES + 1, count)
        self._at_launch = {"place": by_state[:, :3, 0], "velocity": by_state[:, 3:, 0]}
        self._during = by_state[:, 3:, 1:] * (weights[:, None] / 2.0 * duration[:count])

        # The path, on which laws are evaluated.
        path = replace(balls, y=y[:, count:])
        at = {"r": path.y[:3], "v": path.y[3:6]}
        begun = {"r0": balls.y[:3, count:], "v0": balls.y[3:6, count:]}
        self._spin = self._launch.of(stage.roots["spin"]) + np.zeros((3, count))
        self.at = Values(
            {
                **take(on_path, np.arange(count, len(shares))), **at, **begun,
                "ω0": np.tile(self._spin, NODES),
                "t": (shares * duration)[count:], "path": path.y[6],
                **{str(node.data): at[name] for name, node in START.items()},
            }
        )  # fmt: skip
        self._at_start, self._on_path = Many(known), Many(self.at)
        self._turned = Evaluator([stage.roots["law"]], self.at.columns, frozenset(("ω0",)))
        end = ends[:, 0, :count]
        self._at_end = launched(stage, columns).rates(end, duration[:count])[:6]
        self._left = Many(
            Values({
                **columns, "r": end[:3], "v": end[3:6], "t": duration[:count], "path": end[6],
                "r0": balls.y[:3, :count], "v0": balls.y[3:6, :count], "ω0": self._spin,
            })
        )  # fmt: skip

    def moved(self, changes: Sequence[Change]) -> Array:
        """First-order changes of the state and the spin at the end, one for each of `changes`.

        The change of the spin is that on the undisturbed path.
        """
        total = np.zeros((len(changes), 9, self._at_end.shape[1]))
        places = {"law": self._on_path, "spin_left": self._left}
        share = self._left.at.of(self.stage.roots["spin_left"])
        for name, root in self.stage.roots.items():
            if name == "through":
                continue
            here = [i for i, (edit, _) in enumerate(changes) if contains(root, edit.place)]
            where = places.get(name, self._at_start)
            old = where.at.of(root)
            for i, value in zip(here, where.of(root, [changes[i] for i in here]), strict=True):
                change = value - old
                if name == "spin_left":
                    total[i, 6:] += change * self._spin
                    continue
                if name == "spin":
                    total[i, 6:] += share * change
                    turned = np.tile(change + self._spin, NODES)
                    change = self._turned(ω0=turned)[0] - self.at.of(self.stage.roots["law"])
                if name in ("law", "spin"):
                    change = np.broadcast_to(change, (3, NODES * total.shape[2]))
                    pushed = change.reshape(3, NODES, -1)
                    total[i, :6] += np.einsum("ijkn,jkn->in", self._during, pushed)
                elif name in self._at_launch:
                    change = np.broadcast_to(change, (3, total.shape[2]))
                    total[i, :6] += np.einsum("ijn,jn->in", self._at_launch[name], change)
                else:
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


def left_by(
    effects: Response | Direct, edits: Sequence[Edit], starts: Sequence[Sequence[float]], off: Array
) -> list[float]:
    """Fraction of the squared errors that remains after a fit of each edit's effect.

    The fit scales the effect freely. Each scene has the same weight: an error is divided by its
    size in that scene, or by the median size where the scene is right. `starts` are values of each
    edit's free number. The spin counts where nothing else is wrong.
    """
    off = np.nan_to_num(off)
    rows = slice(ROWS) if off[:ROWS].any() else slice(ROWS, None)
    off = off[rows]
    sizes = np.sqrt((off * off).sum(axis=0))
    wrong = sizes > sizes.max(initial=0.0) * RIGHT
    if not wrong.any():
        return [1.0] * len(edits)
    scale = np.where(wrong, sizes, np.median(sizes[wrong]))
    a = (off / scale).ravel()
    changes: list[Change] = []
    trials = []  # of an edit: slices of its changes
    for edit, numbers in zip(edits, starts, strict=True):
        # Two values of a free number span its effects: its start may change a few scenes only.
        first, width = len(changes), 2 if numbers else 1
        values = [x for start in numbers for x in (start, OTHER * start or 0.1)]
        changes += [(edit, x) for x in values or (None,)]
        trials.append([slice(i, i + width) for i in range(first, len(changes), width)])
    moved = effects.moved(changes)[:, rows]
    moved = (np.broadcast_to(moved, (len(changes), *off.shape)) / scale).reshape(len(changes), -1)
    moved = np.where(np.abs(moved) < FAR, moved, 0.0)
    found = []
    for numbers, slices in zip(starts, trials, strict=True):
        best = 1.0
        for b in (moved[some] for some in slices):
            parts = np.linalg.lstsq(b.T, a, rcond=1e-9)[0]
            if numbers or parts[0] > 0:
                rest = a - parts @ b
                best = min(best, float(rest @ rest) / float(a @ a))
        found.append(best)
    return found


ROWS = 6  # position and velocity; the spin follows
FAR = 1e9  # times the error: larger effects are ignored
RIGHT = 1e-9  # of the largest error: a scene with a smaller one is right
