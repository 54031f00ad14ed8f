"""First-order effects of edits, by which the search chooses the edits that it computes in full.

A small change of the acceleration moves the end of a flight by the integral, along the undisturbed
path, of the change times the derivative of the end by the velocity at that time. One batch of
flights gives these derivatives; then an edit costs one evaluation of its formula.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from longball.judge.diagnosis.chain import Stage
from longball.judge.diagnosis.expression import Evaluator, Values
from longball.judge.diagnosis.residual import COARSE, START, flown, launched, take
from longball.model.arrays import Array

NODES = 10  # of a Gauss-Legendre rule over the time of flight
KICK = 1e-4  # m and m/s: the change by which derivatives are taken
OTHER = 1.1  # factor between the two values of a free number that are tried


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
        self._turned = Evaluator([stage.roots["law"]], self.at.columns, frozenset(("ω0",)))
        end = ends[:, 0, :count]
        self._at_end = launched(stage, columns).rates(end, duration[:count])[:6]

    def moved(self, stage: Stage, free: Mapping[str, float]) -> Array:
        """First-order change of the state at the end by an edit."""
        total = np.zeros_like(self._at_end)
        for name, root in stage.roots.items():
            old = self.stage.roots[name]
            if root is old or name in ("through", "spin_left"):
                continue
            where = self.at if name == "law" else self._launch
            change = Evaluator([root], where, frozenset(free))(**free)[0] - where.of(old)
            if name == "spin":
                turned = np.tile(change + self._spin, NODES)
                change = self._turned(ω0=turned)[0] - self.at.of(self.stage.roots["law"])
            if name in ("law", "spin"):
                change = np.broadcast_to(change, (3, NODES * total.shape[1]))
                pushed = change.reshape(3, NODES, -1)
                total = total + np.einsum("ijkn,jkn->in", self._during, pushed)
            elif name in self._at_launch:
                change = np.broadcast_to(change, (3, total.shape[1]))
                total = total + np.einsum("ijn,jn->in", self._at_launch[name], change)
            else:
                total = total + self._at_end * change
        return total


class Direct:
    """Value of a formula, or of an event function, in some scenes."""

    def __init__(self, stage: Stage, known: Values) -> None:
        self.at = known
        (self._value,) = (known.of(root) for root in stage.roots.values())

    def moved(self, stage: Stage, free: Mapping[str, float]) -> Array:
        """Change of the value by an edit."""
        roots = [*stage.roots.values()]
        return np.atleast_2d(Evaluator(roots, self.at, frozenset(free))(**free)[0] - self._value)


def left_by(
    effects: Response | Direct, stage: Stage, name: str, starts: Sequence[float], off: Array
) -> float:
    """Fraction of the squared errors that remains after a fit of an edit's effect.

    The fit scales the effect freely. Each scene has the same weight: an error is divided by its
    size in that scene, or by the median size where the scene is right. `name` is the symbol of the
    edit's free number.
    """
    off = np.nan_to_num(off[:ROWS])
    sizes = np.sqrt((off * off).sum(axis=0))
    wrong = sizes > sizes.max(initial=0.0) * RIGHT
    if not wrong.any():  # only the spin is wrong
        return 0.0
    scale = np.where(wrong, sizes, np.median(sizes[wrong]))
    a = (off / scale).ravel()
    best = 1.0
    # Two values of a free number span its effects: its start may change a few scenes only.
    for start in starts or (None,):
        given = [{name: start}, {name: OTHER * start or 0.1}] if start is not None else [{}]
        b = np.array(
            [
                np.broadcast_to(effects.moved(stage, free) / scale, off.shape).ravel()
                for free in given
            ]
        )
        b = np.where(np.abs(b) < FAR, b, 0.0)
        parts = np.linalg.lstsq(b.T, a, rcond=1e-9)[0]
        if starts or parts[0] > 0:
            rest = a - parts @ b
            best = min(best, float(rest @ rest) / float(a @ a))
    return best


ROWS = 6  # position and velocity; effects on the spin are not computed
FAR = 1e9  # times the error: larger effects are ignored
RIGHT = 1e-9  # of the largest error: a scene with a smaller one is right
