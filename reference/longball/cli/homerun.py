"""``longball homerun``."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, cast

import typer
from pydantic import ValidationError

from longball import engines
from longball.cli.cluster import Scheduler, on_cluster
from longball.cli.common import (
    Seed,
    Workers,
    check_workers,
    option_value,
    plain_table,
    progress_bar,
    say,
    show,
    split_assignment,
    wrong_call,
)
from longball.home_run import (
    MIDDLE_CELL,
    PAPER_CURVES,
    AtBats,
    Estimate,
    Fit,
    Integral,
    Mixture,
    draw,
    estimate,
    fit,
    fit_form,
    integrals,
    monte_carlo,
    paper_at_bats,
    scenes,
    with_restitution,
)
from longball.model.readings import (
    FIGURE_SWITCH,
    LEDGER,
    SCHEME_OPTIONS,
    Belongs,
    Fig7Parameters,
    SamplingReading,
)
from longball.model.scene import AtBatScene, SceneError, explain, parse_scene
from longball.pitches import PitchesError, load_fitted

ReadingOption = Annotated[
    list[str] | None,
    typer.Option("--reading", metavar="NAME=OPTION", help="A switch of the ledger; repeatable."),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="BLOCK.KEY=VALUE", help="A value of the scene; repeatable."),
]
METHODS = ("monte-carlo", "quadrature")
ENGINES = ("batch", "ivp")  # those that say what they cannot tell, in double precision
Samples = Annotated[int, typer.Option(min=1, help="At-bats drawn.")]


def homerun(
    samples: Samples = 1000,
    e: Annotated[
        str, typer.Option(help="Restitutions: first:last:step, or values with commas.")
    ] = "0.41:0.45:0.01",
    seed: Seed = 1,
    reading: ReadingOption = None,
    set_: SetOption = None,
    workers: Workers = -1,
    scheduler: Scheduler = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, not a table.")] = False,
    csv_file: Annotated[Path | None, typer.Option("--csv", help="Write the table here.")] = None,
    figure: Annotated[Path | None, typer.Option(help="Draw P(e) here: .png, .svg, .pdf")] = None,
    scenes_file: Annotated[
        Path | None, typer.Option("--scenes", help="Write the sampled at-bats here, as scenes.")
    ] = None,
    pitches: Annotated[
        Path | None, typer.Option(help="Draw pitches from what longball fit --json wrote.")
    ] = None,
    method: Annotated[str, typer.Option(help=" or ".join(METHODS))] = "monte-carlo",
    engine: Annotated[str, typer.Option(help="Who computes: " + ", ".join(ENGINES))] = "batch",
) -> None:
    """Compute the probability of a home run P(e), from sampled at-bats or by quadrature.

    Quadrature integrates over the distributions that samples are drawn from, and gives dP/de, too.
    It takes some seconds for each e; minutes under the few readings that make P(e) jagged, and the
    error says how far it got.
    """
    if method not in METHODS:
        wrong_call(f"--method {method}: the methods are {', '.join(METHODS)}")
    if engine not in ENGINES:
        wrong_call(f"--engine {engine}: the engines are {', '.join(ENGINES)}")
    if method == "quadrature" and engine != "batch":
        wrong_call(f"--engine {engine}: quadrature takes the engine batch")
    if method == "quadrature" and scenes_file:
        wrong_call("--scenes: quadrature draws no samples")
    if method == "quadrature" and scheduler:
        wrong_call("--scheduler: quadrature takes seconds, and works on this machine")
    check_workers(workers)
    switches = chosen_switches(reading or [])
    base = base_scene(switches["scene"], set_ or [])
    sampling = sampling_reading(switches["sampling"])
    curve = figure_curve(switches["figure"])
    restitutions = parse_restitutions(e)
    at_bats = paper_at_bats(sampling)
    if pitches:
        at_bats = with_pitches(at_bats, pitches)
    if scenes_file:
        write_scenes(scenes_file, base, at_bats, restitutions, samples, seed)
    rows: Sequence[Estimate] | Sequence[Integral]
    fields, drawn = FIELDS, {"samples": samples, "seed": seed}
    failed = 0
    if method == "quadrature":
        with progress_bar("restitutions", len(restitutions)) as advance:
            rows = integrals(
                base,
                at_bats,
                restitutions,
                sample_space=sampling.sample_space,
                workers=workers,
                progress=advance,
            )
        fitted = fit_form(restitutions, [row.p for row in rows])
        fields, drawn = INTEGRAL_FIELDS, {}
    else:
        with on_cluster(scheduler), progress_bar("at-bats", samples) as advance:
            struck = monte_carlo(
                base,
                at_bats,
                restitutions,
                samples,
                seed,
                engine=engines.create(engine),
                workers=workers,
                progress=advance,
            )
        rows = [
            estimate(x, some, sampling.sample_space)
            for x, some in zip(restitutions, struck, strict=True)
        ]
        fitted = fit(rows)
        failed = max(row.failed for row in rows)
    if csv_file:
        write_csv(csv_file, rows, fields)
    if figure:
        from longball.pictures import save_probability

        try:
            save_probability(figure, rows, fitted)
        except ValueError as error:  # an ending that matplotlib does not know
            wrong_call(f"--figure {figure}: {error}")
    if as_json:
        chosen = base.reading.model_dump() | sampling.model_dump() | switches["figure"]
        data = as_data(rows, fields, fitted, chosen) | {"method": method} | drawn
        print(json.dumps(data, ensure_ascii=False))
    else:
        print_probability(rows, fitted, curve)
    if failed:
        say.print(f"longball: {failed} at-bats could not be solved; they count as no home run")
        raise typer.Exit(1)


def chosen_switches(readings: Sequence[str]) -> dict[Belongs, dict[str, Any]]:
    """Return the switches that options set, by what they belong to."""
    ledger = {entry.switch: entry for entry in LEDGER if entry.is_switch}
    switches: dict[Belongs, dict[str, Any]] = {"scene": {}, "sampling": {}, "figure": {}}
    for text in readings:
        name, option = split_assignment("--reading", text)
        if name not in ledger:
            wrong_call(f"--reading {name}: not in the ledger, which has {', '.join(ledger)}")
        if ledger[name].belongs == "scheme":
            wrong_call(
                f"--reading {name}: of the paper's scheme, which does not compute P(e) here; it is "
                f"longball solve --engine verlet --{SCHEME_OPTIONS[name]}"
            )
        switches[ledger[name].belongs][name] = option_value(option)
    return switches


def sampling_reading(switches: Mapping[str, Any]) -> SamplingReading:
    """Return how at-bats are drawn."""
    try:
        return SamplingReading.model_validate(switches)
    except ValidationError as error:
        wrong_call(f"--reading {explain(error, SamplingReading)}")


def figure_curve(switches: Mapping[str, Any]) -> Fig7Parameters:
    """Return which of the paper's curves P(e) is held against."""
    chosen = str(switches.get(FIGURE_SWITCH, "caption"))
    if chosen not in PAPER_CURVES:
        wrong_call(f"--reading {FIGURE_SWITCH}: must be one of {', '.join(PAPER_CURVES)}")
    return cast(Fig7Parameters, chosen)


def base_scene(reading: Mapping[str, Any], values: Sequence[str]) -> AtBatScene:
    """Return the at-bat that options describe, with everything that is not drawn at random."""
    scene: dict[str, Any] = {"id": "base", "kind": "at-bat", "reading": reading}
    drawn = {"ball.restitution", "pitch.speed", "pitch.aim", "swing.tilt", "swing.height_offset"}
    for text in values:
        name, value = split_assignment("--set", text)
        if name in drawn:
            wrong_call(f"--set {name}: it varies from sample to sample")
        block, _, key = name.partition(".")
        if key:
            inner = scene.setdefault(block, {})
            if not isinstance(inner, dict):
                wrong_call(f"--set {name}: {block} is set to {inner} already")
            inner[key] = option_value(value)
        else:
            scene[block] = option_value(value)
    try:
        parsed = parse_scene(json.dumps(scene))
    except SceneError as error:
        wrong_call(str(error))
    assert isinstance(parsed, AtBatScene)
    return parsed


def with_pitches(at_bats: AtBats, path: Path) -> AtBats:
    """Return at-bats whose pitches are drawn from fitted distributions instead of the paper's."""
    try:
        fitted = load_fitted(path).distributions()
    except PitchesError as error:
        wrong_call(str(error))
    speed, aim = fitted.speed, fitted.aim
    left, right = ((cell - MIDDLE_CELL) * aim.cell_width for cell in aim.means)
    deviation = aim.standard_deviation * aim.cell_width
    return replace(
        at_bats,
        speed=Mixture(speed.weights[0], speed.means, speed.standard_deviations),
        aim=Mixture(aim.weights[0], (left, right), (deviation, deviation)),
    )


def parse_restitutions(text: str) -> list[float]:
    """Return the values of first:last:step (last included) or of a list with commas."""
    try:
        if ":" not in text:
            values = [float(part) for part in text.split(",")]
        else:
            first, last, step = (float(part) for part in text.split(":"))
            if step <= 0:
                raise ValueError
            # Values that a reader would write: 0.41 + 3 × 0.01 is 0.44, not 0.43999999999999995.
            count = int((last - first) / step + 1.000001)
            values = [round(first + i * step, 12) for i in range(min(count, 10_001))]
    except (ValueError, OverflowError):
        wrong_call(f"--e {text}: first:last:step, or values with commas between them")
    if not values or not all(0 <= value <= 1 for value in values):
        wrong_call(f"--e {text}: restitutions lie between 0 and 1")
    if len(values) > 10_000:
        wrong_call(f"--e {text}: at most 10000 values")
    return values


def write_scenes(
    path: Path,
    base: AtBatScene,
    at_bats: AtBats,
    restitutions: Sequence[float],
    samples: int,
    seed: int,
) -> None:
    """Write sampled at-bats as scenes, one line for each sample and restitution."""
    left_out = 0
    with open(path, "w", encoding="utf-8") as file:
        for scene in scenes(base, draw(at_bats, samples, seed)):
            if scene is None:
                left_out += 1
                continue
            file.writelines(with_restitution(scene, x).line() + "\n" for x in restitutions)
    if left_out:
        say.print(f"longball: {left_out} samples drew a speed that is not positive; not in {path}")


FIELDS: tuple[str, ...] = ("e", "p", "low", "high", "home_runs", "trials", "failed")
INTEGRAL_FIELDS = ("e", "p", "error", "slope", "slope_error")


def as_data(
    rows: Sequence[Estimate] | Sequence[Integral],
    fields: Sequence[str],
    fitted: Fit | None,
    reading: Mapping[str, Any],
) -> dict[str, Any]:
    """Return what --json prints; a number that is not defined is null."""

    def known(value: float) -> float | None:
        return None if value != value else value

    return {
        "rows": [{name: known(getattr(row, name)) for name in fields} for row in rows],
        "fit": fitted
        and {
            "c1": fitted.curve.c1,
            "c1_error": fitted.c1_error,
            "sigma": fitted.curve.sigma,
            "sigma_error": fitted.sigma_error,
        },
        "paper": {
            name: {"c1": curve.c1, "sigma": curve.sigma, "p": [curve(row.e) for row in rows]}
            for name, curve in PAPER_CURVES.items()
        },
        "reading": reading,
    }


def write_csv(
    path: Path, rows: Sequence[Estimate] | Sequence[Integral], fields: Sequence[str]
) -> None:
    """Write estimates as a table."""
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(fields)
        writer.writerows([getattr(row, name) for name in fields] for row in rows)


def print_probability(
    rows: Sequence[Estimate] | Sequence[Integral], fitted: Fit | None, chosen: Fig7Parameters
) -> None:
    """Print P(e) beside the paper's printed curves, and its difference from one of them."""
    sampled = isinstance(rows[0], Estimate)
    columns = ("P(e)", "95 %", "home runs") if sampled else ("P(e)", "error", "dP/de", "error")
    table = plain_table("e", *columns, "paper's caption", "text", "difference")
    for row in rows:
        table.add_row(
            f"{row.e:g}",
            *found_at(row),
            *(f"{curve(row.e):.4f}" for curve in PAPER_CURVES.values()),
            f"{row.p - PAPER_CURVES[chosen](row.e):+.4f}",
        )
    show(table)
    if fitted:
        print(
            f"fit: C1 = {fitted.curve.c1:.0f} ± {fitted.c1_error:.0f} m, "
            f"sigma = {fitted.curve.sigma:.1f} ± {fitted.sigma_error:.1f} m"
        )
    else:
        print("fit: these home runs do not determine C1 and sigma")
    curves = "; ".join(
        f"{name} C1 = {curve.c1:g} m, sigma = {curve.sigma:g} m"
        for name, curve in PAPER_CURVES.items()
    )
    print(f"paper: {curves}")
    print(f"difference: from the paper's {chosen} (reading fig7_parameters)")


def found_at(row: Estimate | Integral) -> tuple[str, ...]:
    """Return what the table has of one e."""
    if isinstance(row, Estimate):
        interval = f"{row.low:.4f} to {row.high:.4f}"
        return f"{row.p:.4f}", interval, f"{row.home_runs} of {row.trials}"
    return f"{row.p:.8f}", f"{row.error:.1e}", f"{row.slope:.7f}", f"{row.slope_error:.1e}"
