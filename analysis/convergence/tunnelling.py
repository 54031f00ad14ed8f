"""Fraction of contacts that the test at steps misses: counted, and in closed form.

A ball that overlaps the bat for a window w is seen if one of the steps falls into it: with the
probability min(1, w/Δt) for a random phase. At a distance d of the axis the window of a straight
path is w = 2 √(reach² - d²)/V. Grazes have windows down to zero, so that no step is safe.
"""

import math
from itertools import product
from typing import Any

import numpy as np
from scipy.optimize import brentq

from analysis.convergence.pieces import TRUTH, each, golden, passing
from analysis.paper.printed import AT_BATS, BASE
from analysis.writing import STYLES, Report
from longball.engines.chain import approach_of
from longball.engines.verlet import Verlet
from longball.home_run import BLOCK, draw, draw_block, scenes, wilson
from longball.model.arrays import Array
from longball.model.quantities import replaced
from longball.model.scene import AtBatScene

BLOCKS, FULL_BLOCKS = 40, 1000  # of 50 pitches each
SEED = 11
PHASES = 6  # of the step, for each pitch
STEPS = (0.05, 0.03, 0.02, 0.01, 0.005, 0.003, 0.002, 0.001)  # s
RARE = (1e-3, 1e-6)  # of the contacts, missed
GRAZES, FULL_GRAZES = 400, 10_000
REACH = BASE.ball.radius + BASE.bat.radius  # m
HEIGHT = "swing.height_offset"  # m, of the bat over the pitch
NODES = 64  # of the quadrature over grazes; it is smooth, and 32 give the same twelve digits


def sees(scene: AtBatScene, dt: float) -> bool:
    """True if a step falls into the bat."""
    approach = approach_of(scene, Verlet(dt))
    return approach is not None and approach.touch.touched is not False


def count_block(block: int) -> tuple[Array, list[tuple[float, float]]]:
    """Return, of a block of pitches, (trials, missed, expected) by step, and speed and level."""
    counts, ways = np.zeros((3, len(STEPS))), []
    samples = draw_block(AT_BATS, SEED, block)
    for number, scene in enumerate(scenes(BASE, samples)):
        if scene is None or (way := passing(scene)) is None:
            continue
        ways.append((way.speed, way.level))
        for (column, step), share in product(enumerate(STEPS), golden(PHASES)):
            # Another start for each pitch, so that no speed meets the same phases.
            shift = (share + number / BLOCK) % 1.0
            dt = step / (1 + shift * step / way.time)
            counts[:, column] += 1, not sees(scene, dt), max(0.0, 1 - way.window / dt)
    return counts, ways


def expected(step: float, ways: Array) -> float:
    """Return the share of contacts that a step misses, in closed form but for an integral.

    With d = reach cos ψ the window is 2 reach sin ψ / V, and the miss has the probability
    1 - sin ψ / sin ψ₀ up to ψ₀, where the window is as long as the step. d is the level share
    of the bat's offset, which is normal; speeds and level shares are those of the pitches drawn.
    """
    speed, level = ways[:, :1], ways[:, 1:]
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    longest = np.minimum(1.0, speed * step / (2 * REACH))

    def integral(top: Array, missed: bool) -> float:
        psi = top * (nodes + 1) / 2
        offset = REACH * np.cos(psi) / level
        density = np.exp(-0.5 * (offset / AT_BATS.offset_deviation) ** 2) / level
        lost = 1 - 2 * REACH * np.sin(psi) / (speed * step) if missed else 1.0
        return float((top / 2 * weights * lost * density * np.sin(psi)).sum(axis=1).mean())

    return integral(np.arcsin(longest), True) / integral(np.full_like(speed, np.pi / 2), False)


def count_grazes(step: float, seed: int, count: int) -> tuple[int, int, float]:
    """Return grazes whose window is shorter than a step: how many, missed, and expected to be."""
    drawn = scenes(BASE, draw(AT_BATS, count, seed))
    shares = np.random.default_rng(seed).random((count, 2))
    trials, missed, waited = 0, 0, 0.0
    for scene, (depth, side) in zip(drawn, shares, strict=True):
        if scene is None or (middle := passing(replaced(scene, {HEIGHT: 0.0}))) is None:
            continue
        psi = math.asin(min(1.0, middle.speed * step / (2 * REACH))) * depth
        offset = math.copysign(REACH * math.cos(psi) / middle.level, side - 0.5)
        # The path is curved, and the shallowest graze is a micrometre deep: corrected twice.
        for _ in range(2):
            approach = approach_of(replaced(scene, {HEIGHT: offset}), TRUTH)
            assert approach is not None
            excess = approach.touch.margin - REACH * (1 - math.cos(psi))
            offset += math.copysign(excess / middle.level, offset)
        graze = replaced(scene, {HEIGHT: offset})
        if (way := passing(graze)) is not None and way.window < step:
            trials += 1
            missed += not sees(graze, step)
            waited += 1 - way.window / step
    return trials, missed, waited


def run(report: Report, full: bool) -> str:
    """Count the missed contacts, and find the steps that miss few."""
    blocks = range(FULL_BLOCKS if full else BLOCKS)
    found = each(report, "tunnelling", count_block, [(block,) for block in blocks])
    counts = sum(counts for counts, _ in found)
    ways = np.array([way for _, some in found for way in some])

    def excess(step: float, rare: float) -> float:
        return math.log(expected(step, ways) / rare)

    safe = {rare: float(brentq(excess, 1e-7, 0.05, rare)) for rare in RARE}
    count = (FULL_GRAZES if full else GRAZES) // 4
    calls = [(step, seed, count) for step in safe.values() for seed in range(4)]
    grazes = np.array(each(report, "grazes", count_grazes, calls)).reshape(len(RARE), 4, 3)
    (trials, missed, waited), style = counts, STYLES["measured"]
    grid = np.geomspace(min(safe.values()) / 2, 0.06, 80)
    with report.figure("convergence_tunnelling", size=(6.4, 3.8)) as (axes,):
        axes.plot(grid, [expected(h, ways) for h in grid], "--", label="closed form, all pitches")
        label = "closed form, the pitches tried"
        axes.plot(STEPS, waited / trials, **style, markersize=10, label=label)
        axes.plot(STEPS, missed / trials, "k.", markersize=6, label="counted")
        for rare, step in safe.items():
            axes.plot([step], [rare], "s", color="#D55E00")
            text = f"1 in {1 / rare:,.0f}: Δt = {step:.1e} s"
            axes.annotate(text, (step, rare), (9, -9), textcoords="offset points")
        axes.set(xscale="log", yscale="log", xlabel="step Δt, s", ylabel="contacts missed")
        axes.legend()
    return report.render(
        "tunnelling", globals(), pitches=len(blocks) * BLOCK, ways=ways, safe=safe,
        rows=[described(*column) for column in counts.T],
        grazes=[described(*of.sum(axis=0)) for of in grazes],
    )  # fmt: skip


def described(trials: float, missed: float, waited: float) -> dict[str, Any]:
    """Return counts with their share and its interval, and whether it has the closed form's."""
    low, high = wilson(int(missed), int(trials))
    share = waited / trials
    counts = {"trials": int(trials), "missed": int(missed), "waited": waited, "share": share}
    return counts | {"low": low, "high": high, "agrees": low <= share <= high}
