"""Every number of the paper that can be had again: printed, ours, the difference, and why."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from analysis.paper import argument, pitch_fits
from analysis.paper.balls import describe
from analysis.paper.distances import BIN, distance
from analysis.paper.home_run_figures import Reproduced, printed_ratio, reproduced
from analysis.paper.printed import (
    CARRIES,
    FLAT,
    P_TEXT,
    PAIRS,
    PEAKS,
    SAMPLES,
    UZR_SHARE,
    UZR_SPAN,
)
from analysis.writing import render, table
from longball.home_run import PAPER_CURVES, RESTITUTIONS, Curve
from longball.pitches import EXAMPLE, fit_pitches


@dataclass(frozen=True)
class Counterpart:
    """A printed number, and what the default and the nearest reading give.

    Attributes
    ----------
    place, what
        Where it stands, and what it is.
    printed, default, nearest
        Values.
    noise
        The standard error that the printed number has; a rounding counts with a standard
        deviation of half the last digit over √3.
    digits
        Decimals shown.
    same, other
        Why, if the nearest reading has it, and if none has.
    """

    place: str
    what: str
    printed: float
    default: float
    nearest: float
    noise: float
    digits: int
    same: str
    other: str

    @property
    def verdict(self) -> str:
        """Say which of the two readings gives the printed number within twice its noise."""
        by_default, by_nearest = (
            abs(ours - self.printed) <= 2 * self.noise for ours in (self.default, self.nearest)
        )
        if by_default and by_nearest:
            return f"**reproduced**: {self.same}"
        if by_nearest:
            return f"**by the nearest reading only**: {self.same}"
        if by_default:
            return f"**by the default reading only**: {self.other}"
        return f"**not reproduced**: {self.other}"

    def row(self) -> dict[str, str]:
        """Return a line of the table."""
        n = self.digits
        ours = [f"{x:.{n}f}" for x in (self.default, self.nearest)]
        off = [f"{x - self.printed:+.{n}f}" for x in (self.default, self.nearest)]
        printed = f"{self.printed:.{n}f} ± {self.noise:.{n}f}"
        return line(self.place, self.what, printed, ours, off, self.verdict)


def line(
    place: str, number: str, printed: str, ours: Sequence[str], off: Sequence[str], verdict: str
) -> dict[str, str]:
    """Return a line of the table; `ours` and `off` have the default and the nearest reading."""
    return {
        "place": place,
        "number": number,
        "printed": printed,
        "default": ours[0],
        "its difference": off[0],
        "nearest": ours[1],
        "difference": off[1],
        "verdict": verdict,
    }


def of_home_runs(default: Reproduced, nearest: Reproduced) -> list[Counterpart]:
    """Return the counterparts of Table I, Figs. 6 and 7 and the text."""
    caption, text = PAPER_CURVES["caption"], PAPER_CURVES["text"]

    def noise(p: float) -> float:
        return math.sqrt(p * (1 - p) / SAMPLES)

    hits = [printed_ratio(pair) for pair in PAIRS]
    e, p = P_TEXT
    return [
        *(
            Counterpart(
                "Table I", f"home runs, {hit.seasons[0]} over {hit.seasons[1]}", hit.value,
                default.ratios[i].value, nearest.ratios[i].value, hit.error, 3,
                "e alone explains the seasons",
                "e alone does not explain the seasons, in the paper's own curve neither",
            )
            for i, hit in enumerate(hits)
        ),
        Counterpart(
            "Fig. 6", f"density at e = 0.45 over {FLAT[0]:g} to {FLAT[1]:g} m, largest / smallest",
            1.0, default.flat, nearest.flat, flat_noise(nearest), 2,
            f"it is as flat as bins of {SAMPLES:,} samples can tell", "it is not flat",
        ),
        *(
            Counterpart(
                "Fig. 7", f"P({e:g}) of the caption's curve", caption(e), default.p(e),
                nearest.p(e), noise(caption(e)), 4,
                "within the noise of its samples", "the printed parameters do not determine it",
            )
            for e in (min(RESTITUTIONS), max(RESTITUTIONS))
        ),
        Counterpart(
            "Sec. V", f"P({e:g})", p, default.p(e), nearest.p(e),
            math.hypot(noise(p), 0.005 / math.sqrt(3)), 3,
            f"so says the caption's curve ({caption(e):.3f}); the text's own has {text(e):.3f}",
            "the printed parameters do not determine it",
        ),
        Counterpart(
            "Sec. V", f"share of D in {UZR_SPAN[0]:g} to {UZR_SPAN[1]:g} m (UZR)", UZR_SHARE,
            default.uzr_share, nearest.uzr_share, noise(UZR_SHARE), 3,
            "though UZR has balls where the fielders took them, and from two other seasons",
            "the default reading counts balls hit downwards, and hits less far",
        ),
    ]  # fmt: skip


def flat_noise(one: Reproduced) -> float:
    """Return by how much 1,000 samples scatter a bin over another, where the paper says flat.

    The largest over the smallest of four equal bins is about two such deviations above 1.
    """
    density = one.density[max(PEAKS)]
    first, last = (int(edge / BIN) for edge in FLAT)
    share = BIN * float(density[first:last].mean())
    return math.sqrt(2 / (SAMPLES * share))


def of_peaks(default: Reproduced, nearest: Reproduced) -> list[dict[str, str]]:
    """Return lines for the peaks of Fig. 6, which are judged by their chance."""
    lines = []
    for e, printed in PEAKS.items():
        peaks = [one.peaks[e] for one in (default, nearest)]
        texts = [f"{one.ours:g} (p = {one.p_value:.4f})" for one in peaks]
        off = [f"{one.ours - printed:+g}" for one in peaks]
        verdict = "**not reproduced**: the highest of 1,000 samples is seldom so far out"
        if all(one.p_value >= 0.05 for one in peaks):
            verdict = "**reproduced**: a peak of the samples"
        elif peaks[1].p_value >= 0.05:
            verdict = "**by the nearest reading only**: balls hit downwards are not in Fig. 6"
        what = f"highest peak at e = {e:g}, m"
        lines.append(line("Fig. 6", what, f"{printed:g}", texts, off, verdict))
    return lines


def of_curves(default: Reproduced, nearest: Reproduced) -> list[dict[str, str]]:
    """Return lines for the paper's two curves; C₁ and σ are judged together, by P(e)."""
    lines = []
    reasons = {
        "caption": "the printed parameters do not determine it",
        "text": "it contradicts the caption and the text's own P(0.42)",
    }
    for name, curve in PAPER_CURVES.items():
        texts, off, near = [], [], []
        for one in (default, nearest):
            apart = distance(one.rows, curve)
            fitted = one.fitted.curve if one.fitted else Curve(math.nan, math.nan)
            texts.append(f"{fitted.c1:.0f}, {fitted.sigma:.1f} (d² = {apart.squared:.1f})")
            off.append(f"{fitted.c1 - curve.c1:+.0f}, {fitted.sigma - curve.sigma:+.1f}")
            near.append(apart.near)
        verdict = f"**not reproduced**: {reasons[name]}"
        if any(near):
            which = "reproduced" if near[0] else "by the nearest reading only"
            verdict = f"**{which}**: P(e) is within the noise"
        printed = f"{curve.c1:g}, {curve.sigma:g}"
        lines.append(line("Fig. 7", f"C₁ and σ of the {name}, m", printed, texts, off, verdict))
    return lines


def of_carry() -> list[dict[str, str]]:
    """Return a line for dD/de, in the paper and outside it."""
    default, nearest = (
        next((one.median for one in case.shifts if one.distance == 110.0), math.nan)
        for case in argument.everything()
    )
    return [
        Counterpart(
            "not the paper's", f"dD/de at 110 m, m: {carry.who}", carry.slope, default, nearest,
            carry.slope_error / math.sqrt(3), 0,
            "about as far as the rounding of its figures allows",
            "another pitch, swing and launch; see the last section",
        ).row()
        for carry in CARRIES
    ]  # fmt: skip


def of_pitches(full: bool) -> list[dict[str, str]]:
    """Return lines for Sec. II: what pitches drawn from the printed fits give back."""
    lines = []
    for row in pitch_fits.compared():
        if row["method"] == "maximum_likelihood":
            digits = 2 if row["unit"] == "km/h" else 3
            place = "Table II" if row["unit"] == "km/h" else "Figs. 2, 3"
            lines.append(
                {
                    "place": place,
                    "number": row["quantity"] + (f", {row['unit']}" if row["unit"] else ""),
                    "printed": f"{row['printed']:g}",
                    "ours": f"{row['synthetic']:.{digits}f} ± {row['synthetic_error']:.{digits}f}",
                    "difference": f"{row['difference']:+.{digits}f}",
                    "verdict": row["verdict"],
                }
            )
    draws = pitch_fits.FULL_DRAWS if full else pitch_fits.DRAWS
    determination = pitch_fits.determine(draws)
    for place, what in (("Fig. 2", "speed"), ("Fig. 3", "aim")):
        printed = pitch_fits.PRINTED_R_SQUARED[what]
        rows = [row for row in determination if row["what"] == what]
        verdict = "not reproduced"
        if any(row["low"] <= printed <= row["high"] for row in rows):
            why = {
                "speed": "the width of its bins is not printed",
                "aim": "within the scatter of such draws",
            }
            verdict = f"consistent: {why[what]}"
        row = min(rows, key=lambda one: abs(one["median"] - printed))
        unit = "km/h" if what == "speed" else "cell"
        lines.append(
            {
                "place": place,
                "number": f"R², bins of {row['bin_width']:g} {unit}",
                "printed": f"{printed:g}",
                "ours": f"{row['median']:.4f} ({row['low']:.4f} to {row['high']:.4f})",
                "difference": f"{row['median'] - printed:+.4f}",
                "verdict": verdict,
            }
        )
    return [*lines, of_heights()]


def of_heights() -> dict[str, str]:
    """Return the line for Fig. 4, which has no numbers printed; ours are another league's."""
    heights = fit_pitches(EXAMPLE, replicates=2).height
    assert heights is not None  # the example has them
    shares = [share.value for share in heights.shares]
    rarest = shares.index(min(shares)) + 1
    return {
        "place": "Fig. 4",
        "number": "share of z = 1 … 5",
        "printed": "the same, but z = 5 rarer",
        "ours": ", ".join(f"{share:.3f}" for share in shares) + " (MLB)",
        "difference": f"up to {max(shares[:4]) / min(shares[:4]) - 1:.0%} in z = 1 … 4",
        "verdict": ("z = 5 is the rarest, too" if rarest == 5 else "another one is the rarest")
        + (
            "; the others are equal"
            if heights.p_value_of_lower_four > 0.05
            else "; the others differ by more than chance: another league"
        ),
    }


def run(report: Path, full: bool) -> str:
    """Write the section; `full` takes more draws of pitches."""
    default, nearest = reproduced()
    home_runs = [one.row() for one in of_home_runs(default, nearest)]
    lines = [
        *home_runs[: len(PAIRS)],
        *of_peaks(default, nearest),
        *of_curves(default, nearest),
        *home_runs[len(PAIRS) :],
        *of_carry(),
    ]
    return render(
        report,
        "counterparts",
        drawn=pitch_fits.PITCHES,
        pitches=table(report, "paper_pitches", pd.DataFrame(of_pitches(full))),
        nearest=describe(nearest.base, nearest.space),
        samples=SAMPLES,
        home_runs=table(report, "paper_home_runs", pd.DataFrame(lines)),
    )
