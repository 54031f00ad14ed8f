"""Every number of the paper that can be had again: printed, ours, the difference, and why."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from analysis.paper import argument, pitch_fits
from analysis.paper.distances import BIN, distance
from analysis.paper.home_run_figures import Reproduced, printed_ratio, reproduced
from analysis.paper.printed import CARRIES, FLAT, P_TEXT, PAIRS, PEAKS, SAMPLES, UZR_SHARE, UZR_SPAN
from analysis.writing import render
from longball.home_run import PAPER_CURVES, RESTITUTIONS, Curve
from longball.pitches import EXAMPLE, fit_pitches

WHICH = "**reproduced**", "**by the nearest reading only**", "**by the default reading only**"


class Line(NamedTuple):
    """A line of the table: what is printed, and what the default and the nearest reading give."""

    place: str
    number: str
    printed: str
    ours: Sequence[str]
    off: Sequence[str]
    verdict: str


class Counterpart(NamedTuple):
    """A printed number, and what the default and the nearest reading give."""

    place: str
    what: str
    printed: float
    default: float
    nearest: float
    noise: float  # standard error of the printed number; of a rounding, half the last digit over √3
    digits: int  # decimals shown
    same: str  # why, if the nearest reading has it
    other: str  # why, if none has

    @property
    def verdict(self) -> str:
        """Say which of the two readings gives the printed number within twice its noise."""
        by_default, by_nearest = (
            abs(ours - self.printed) <= 2 * self.noise for ours in (self.default, self.nearest)
        )
        if by_nearest:
            return f"{WHICH[not by_default]}: {self.same}"
        return f"{WHICH[2] if by_default else '**not reproduced**'}: {self.other}"

    def line(self) -> Line:
        """Return a line of the table."""
        n, both = self.digits, (self.default, self.nearest)
        off = [f"{x - self.printed:+.{n}f}" for x in both]
        printed = f"{self.printed:.{n}f} ± {self.noise:.{n}f}"
        return Line(self.place, self.what, printed, [f"{x:.{n}f}" for x in both], off, self.verdict)


def noise(p: float) -> float:
    """Return the standard error of a share of the paper's samples."""
    return math.sqrt(p * (1 - p) / SAMPLES)


def of_seasons(default: Reproduced, nearest: Reproduced) -> Iterator[Line]:
    """Yield the counterparts of Table I."""
    for i, pair in enumerate(PAIRS):
        hit = printed_ratio(pair)
        yield Counterpart(
            "Table I", "home runs, {} over {}".format(*(season.year for season in pair)),
            hit.value, default.ratios[i].value, nearest.ratios[i].value, hit.error, 3,
            "e alone explains the seasons",
            "e alone does not explain the seasons, in the paper's own curve neither",
        ).line()  # fmt: skip


def of_home_runs(default: Reproduced, nearest: Reproduced) -> Iterator[Line]:
    """Yield the counterparts of Figs. 6 and 7 and the text."""
    caption, text = PAPER_CURVES["caption"], PAPER_CURVES["text"]
    yield Counterpart(
        "Fig. 6", f"density at e = 0.45 over {FLAT[0]:g} to {FLAT[1]:g} m, largest / smallest",
        1.0, default.flat, nearest.flat, flat_noise(nearest), 2,
        f"it is as flat as bins of {SAMPLES:,} samples can tell", "it is not flat",
    ).line()  # fmt: skip
    for e in (min(RESTITUTIONS), max(RESTITUTIONS)):
        yield Counterpart(
            "Fig. 7", f"P({e:g}) of the caption's curve", caption(e), default.trial.p(e),
            nearest.trial.p(e), noise(caption(e)), 4,
            "within the noise of its samples", "the printed parameters do not determine it",
        ).line()  # fmt: skip
    e, p = P_TEXT
    yield Counterpart(
        "Sec. V", f"P({e:g})", p, default.trial.p(e), nearest.trial.p(e),
        math.hypot(noise(p), 0.005 / math.sqrt(3)), 3,
        f"so says the caption's curve ({caption(e):.3f}); the text's own has {text(e):.3f}",
        "the printed parameters do not determine it",
    ).line()  # fmt: skip
    yield Counterpart(
        "Sec. V", f"share of D in {UZR_SPAN[0]:g} to {UZR_SPAN[1]:g} m (UZR)", UZR_SHARE,
        default.uzr_share, nearest.uzr_share, noise(UZR_SHARE), 3,
        "though UZR has balls where the fielders took them, and from two other seasons",
        "the default reading counts balls hit downwards, and hits less far",
    ).line()  # fmt: skip


def flat_noise(one: Reproduced) -> float:
    """Return by how much 1,000 samples scatter a bin over another, where the paper says flat.

    The largest over the smallest of four equal bins is about two such deviations above 1.
    """
    density = one.density[max(PEAKS)]
    first, last = (int(edge / BIN) for edge in FLAT)
    return math.sqrt(2 / (SAMPLES * BIN * float(density[first:last].mean())))


def of_peaks(default: Reproduced, nearest: Reproduced) -> Iterator[Line]:
    """Yield the peaks of Fig. 6, which are judged by their chance."""
    for e, printed in PEAKS.items():
        peaks = [one.trial.peaks[e] for one in (default, nearest)]
        texts = [f"{one.ours:g} (p = {one.p_value:.4f})" for one in peaks]
        verdict = "**not reproduced**: the highest of 1,000 samples is seldom so far out"
        if all(one.p_value >= 0.05 for one in peaks):
            verdict = f"{WHICH[0]}: a peak of the samples"
        elif peaks[1].p_value >= 0.05:
            verdict = f"{WHICH[1]}: balls hit downwards are not in Fig. 6"
        off = [f"{one.ours - printed:+g}" for one in peaks]
        yield Line("Fig. 6", f"highest peak at e = {e:g}, m", f"{printed:g}", texts, off, verdict)


def of_curves(default: Reproduced, nearest: Reproduced) -> Iterator[Line]:
    """Yield the paper's two curves; C₁ and σ are judged together, by P(e)."""
    reasons = {
        "caption": "the printed parameters do not determine it",
        "text": "it contradicts the caption and the text's own P(0.42)",
    }
    for name, curve in PAPER_CURVES.items():
        texts, off, near = [], [], []
        for one in (default, nearest):
            apart = distance(one.trial.rows, curve)
            fitted = one.fitted.curve if one.fitted else Curve(math.nan, math.nan)
            texts.append(f"{fitted.c1:.0f}, {fitted.sigma:.1f} (d² = {apart.squared:.1f})")
            off.append(f"{fitted.c1 - curve.c1:+.0f}, {fitted.sigma - curve.sigma:+.1f}")
            near.append(apart.near)
        verdict = f"**not reproduced**: {reasons[name]}"
        if any(near):
            verdict = f"{WHICH[not near[0]]}: P(e) is within the noise"
        printed = f"{curve.c1:g}, {curve.sigma:g}"
        yield Line("Fig. 7", f"C₁ and σ of the {name}, m", printed, texts, off, verdict)


def of_carry() -> Iterator[Line]:
    """Yield dD/de, in the paper and outside it."""
    default, nearest = (
        next((one.median for one in case.shifts if one.distance == 110.0), math.nan)
        for case in argument.everything()
    )
    for carry in CARRIES:
        yield Counterpart(
            "not the paper's", f"dD/de at 110 m, m: {carry.who}", carry.slope, default, nearest,
            carry.slope_error / math.sqrt(3), 0,
            "about as far as the rounding of its figures allows",
            "another pitch, swing and launch; see the last section",
        ).line()  # fmt: skip


def of_determination(full: bool) -> Iterator[dict[str, Any]]:
    """Yield what R² pitches drawn from the printed fits have, at the likeliest width of bin."""
    reasons = {
        "speed": "the width of its bins is not printed",
        "aim": "within the scatter of such draws",
    }
    determination = pitch_fits.determine(pitch_fits.FULL_DRAWS if full else pitch_fits.DRAWS)
    for place, what, unit in (("Fig. 2", "speed", "km/h"), ("Fig. 3", "aim", "cell")):
        printed = pitch_fits.PRINTED_R_SQUARED[what]
        rows = [row for row in determination if row["what"] == what]
        fits = any(row["low"] <= printed <= row["high"] for row in rows)
        verdict = f"consistent: {reasons[what]}" if fits else "not reproduced"
        row = min(rows, key=lambda one: abs(one["median"] - printed))
        yield row | {"place": place, "unit": unit, "printed": printed, "verdict": verdict}


def run(report: Path, full: bool) -> str:
    """Write the section; `full` takes more draws of pitches."""
    both = reproduced()
    home_runs = [
        *of_seasons(*both), *of_peaks(*both), *of_curves(*both), *of_home_runs(*both), *of_carry()
    ]  # fmt: skip
    heights = fit_pitches(EXAMPLE, replicates=2).height
    assert heights is not None  # the example has them
    return render(
        report, "counterparts", globals(), home_runs=home_runs, nearest=both[1].trial.name,
        drawn=pitch_fits.PITCHES, heights=heights, determination=list(of_determination(full)),
        pitches=[x for x in pitch_fits.compared() if x["method"] == "maximum_likelihood"],
    )  # fmt: skip
