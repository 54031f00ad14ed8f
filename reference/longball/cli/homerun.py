"""``longball homerun``."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from longball import engines, home_run
from longball.cli.changes import changes, chosen_switches
from longball.cli.cluster import on_cluster
from longball.cli.messages import fail, parsed, progress_bar, refusing, show, tell, wrong_call
from longball.cli.options import Options
from longball.home_run import Curve, Estimate, Fit, Integral
from longball.model.readings import FIGURE_SWITCH, SamplingReading
from longball.model.scene import AtBatScene, Fence, scene_of
from longball.pitches import load_fitted

Rows = Sequence[Estimate] | Sequence[Integral]


def homerun(o: Options) -> None:
    """Compute the probability of a home run.

    Quadrature integrates over the distributions of the samples, and also gives dP/de. It takes one
    to two seconds for each e, and minutes for readings under which P(e) has many kinks.
    """
    if o.method == "quadrature":
        if o.engine != "batch":
            wrong_call(f"--engine {o.engine}: quadrature always uses the engine batch")
        o.refuse("samples seed scenes", "quadrature draws no samples")
        o.refuse("scheduler", "quadrature takes seconds, and runs on this machine")
    switches = chosen_switches(o.reading)
    base = base_scene(switches["scene"], o.set, o.fence)
    if base.fence is not None and o.method == "quadrature":
        wrong_call("--fence: quadrature supports the 150 m rule only; use --method monte-carlo")
    # Check everything before the first flight, because a run may take hours.
    sampling = parsed(SamplingReading, switches["sampling"], "--reading ")
    curve = str(switches["figure"].get(FIGURE_SWITCH, "caption"))
    if curve not in home_run.PAPER_CURVES:
        known = ", ".join(home_run.PAPER_CURVES)
        wrong_call(f"--reading {FIGURE_SWITCH}: must be one of {known}")
    restitutions = parse_restitutions(o.e)
    at_bats = home_run.paper_at_bats(sampling)
    if o.pitches:
        with refusing():
            at_bats = load_fitted(o.pitches).drawn_in(at_bats)
    problem, space = (base, at_bats, restitutions), sampling.sample_space
    rows: Rows
    drawn: dict[str, int] = {}
    failed = 0
    if o.method == "quadrature":
        with progress_bar("restitutions", len(restitutions)) as advance:
            rows = home_run.integrals(
                *problem, sample_space=space, workers=o.workers, progress=advance
            )
        fitted = home_run.fit_form(restitutions, [row.p for row in rows])
    else:
        drawn = {"samples": o.samples, "seed": o.seed}
        solver = engines.create(o.engine)
        with on_cluster(o) as workers, progress_bar("at-bats", o.samples) as advance:
            rows = home_run.estimates(
                *problem,
                o.samples,
                o.seed,
                sample_space=space,
                engine=solver,
                workers=workers,
                progress=advance,
            )
        fitted = home_run.fit(rows)
        failed = max(row.failed for row in rows)
    # The paper's form and curves are only valid for its own rule, 150 m.
    of_paper = base.fence in (None, Fence(radius=home_run.HOME_RUN_DISTANCE))
    curves = home_run.PAPER_CURVES if of_paper else {}
    fitted = fitted if of_paper else None
    # Draw the at-bats of the estimates again, from the same seed.
    if o.scenes:
        sampled = list(home_run.scenes(base, home_run.draw(at_bats, o.samples, o.seed)))
        pitched = [scene for scene in sampled if scene is not None]
        lines = (
            home_run.with_restitution(x, each).line() for x in pitched for each in restitutions
        )
        # Line by line: there may be millions.
        with open(o.scenes, "w", encoding="utf-8") as file:
            file.writelines(f"{line}\n" for line in lines)
        if omitted := len(sampled) - len(pitched):
            tell(f"{omitted} samples drew a speed that is not positive; not in {o.scenes}")
    if o.csv:
        with open(o.csv, "w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, home_run.columns(rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(map(home_run.columns, rows))
    if o.figure:
        from longball.pictures import draw_probability, saved

        with saved(o.figure, (6.4, 4.2)) as (_, axes):
            draw_probability(axes, rows, fitted, curves)
    if o.json:
        chosen = base.reading.model_dump() | sampling.model_dump() | switches["figure"]
        data = as_data(rows, fitted, curves, chosen) | {"method": o.method} | drawn
        print(json.dumps(data, ensure_ascii=False))
    else:
        print_probability(rows, fitted, curves, curve)
    # Fail only after the table is printed: one undecided at-bat must not cost the whole run.
    if failed:
        fail(f"{failed} at-bats could not be solved; they count as no home run")


def base_scene(
    reading: Mapping[str, Any], values: Mapping[str, str], fence: str | None = None
) -> AtBatScene:
    """Return the at-bat of the options, without its random numbers."""
    change = changes(values, fence, {})
    with refusing():
        scene = scene_of(change({"id": "base", "kind": "at-bat", "reading": reading}))
    assert isinstance(scene, AtBatScene)
    with refusing("--set "):
        home_run.refuse_drawn(scene)
    return scene


def parse_restitutions(text: str) -> list[float]:
    """Return the values of first:last:step (last included) or of a list with commas."""
    try:
        if ":" not in text:
            values = [float(part) for part in text.split(",")]
        else:
            first, last, step = (float(part) for part in text.split(":"))
            # The list would never reach the last value.
            if step <= 0:
                raise ValueError
            # Round to decimal values: 0.41 + 3 × 0.01 is 0.44, not 0.43999999999999995.
            count = int((last - first) / step + 1.000001)
            values = [round(first + i * step, 12) for i in range(min(count, 10_001))]
    except (ValueError, OverflowError):
        wrong_call(f"--e {text}: must be FIRST:LAST:STEP, or values with commas between them")
    if not values:
        wrong_call(f"--e {text}: the last value is below the first")
    if not all(0 <= value <= 1 for value in values):
        wrong_call(f"--e {text}: restitutions lie between 0 and 1")
    if len(values) > 10_000:
        wrong_call(f"--e {text}: at most 10000 values")
    return values


def as_data(
    rows: Rows, fitted: Fit | None, curves: Mapping[str, Curve], reading: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the table for --json; an undefined number is null."""
    return {
        "rows": [
            {name: None if x != x else x for name, x in home_run.columns(row).items()}
            for row in rows
        ],
        "fit": fitted
        and asdict(fitted.curve) | {"c1_error": fitted.c1_error, "sigma_error": fitted.sigma_error},
        "paper": {
            name: asdict(curve) | {"p": [curve(row.e) for row in rows]}
            for name, curve in curves.items()
        },
        "reading": reading,
    }


def print_probability(
    rows: Rows, fitted: Fit | None, curves: Mapping[str, Curve], chosen: str
) -> None:
    """Print P(e) next to the paper's printed curves, and its difference from one of them."""
    beside = ("paper's caption", "text", "difference") if curves else ()
    table = []
    for row in rows:
        of_paper = [f"{curve(row.e):.4f}" for curve in curves.values()]
        off = [f"{row.p - curves[chosen](row.e):+.4f}"] if curves else []
        if isinstance(row, Estimate):
            interval = f"{row.low:.4f} to {row.high:.4f}"
            numbers = [f"{row.p:.4f}", interval, f"{row.home_runs} of {row.trials}"]
        else:
            slope = f"{row.slope:.7f}", f"{row.slope_error:.1e}"
            numbers = [f"{row.p:.8f}", f"{row.error:.1e}", *slope]
        table.append((f"{row.e:g}", *numbers, *of_paper, *off))
    # Samples have a confidence interval, integrals an error and a derivative.
    sampled = isinstance(rows[0], Estimate)
    head = ("P(e)", "95 %", "home runs") if sampled else ("P(e)", "error", "dP/de", "error")
    show(("e", *head, *beside), table)
    # The paper's curves do not apply to other fences.
    if not curves:
        return
    if fitted:
        c1 = f"C1 = {fitted.curve.c1:.0f} ± {fitted.c1_error:.0f} m"
        print(f"fit: {c1}, sigma = {fitted.curve.sigma:.1f} ± {fitted.sigma_error:.1f} m")
    elif len(rows) < home_run.FEWEST:
        print(f"fit: C1 and sigma need {home_run.FEWEST} values of e or more")
    else:
        print("fit: these home runs do not determine C1 and sigma")
    named = (f"{n} C1 = {c.c1:g} m, sigma = {c.sigma:g} m" for n, c in curves.items())
    print("paper:", "; ".join(named))
    print(f"difference: from the paper's {chosen} (reading fig7_parameters)")
