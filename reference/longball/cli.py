"""The command line: data on standard output, words for people on standard error.

Exit status: 0 all well, 1 a line or a verdict failed, 2 the call itself was wrong.
"""

from __future__ import annotations

import csv
import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, BinaryIO, NoReturn

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from longball import __version__, engines
from longball.engines.lines import solve_lines
from longball.home_run import (
    PAPER_CURVES,
    AtBats,
    Estimate,
    Fit,
    draw,
    estimate,
    fit,
    monte_carlo,
    paper_at_bats,
    scenes,
    with_restitution,
)
from longball.model.readings import LEDGER, Entry, Reading
from longball.model.scene import AtBatScene, SceneError, parse_scene

app = typer.Typer(
    help="The precision reference for a simulator of baseball at-bats.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)

say = Console(stderr=True, highlight=False, soft_wrap=True)


def main() -> None:
    """Run the command line; no traceback reaches a user."""
    try:
        app()
    except KeyboardInterrupt:
        say.print("longball: interrupted")
        sys.exit(130)
    except BrokenPipeError:
        # Whoever read our output has enough. Python would complain again when it flushes.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except OSError as error:
        say.print(f"longball: {error.filename or 'output'}: {error.strerror}", markup=False)
        sys.exit(2)


def wrong_call(sentence: str) -> NoReturn:
    """Say what is wrong with the call and leave with status 2."""
    say.print(f"longball: {sentence}", markup=False)
    raise typer.Exit(2)


@app.callback(invoke_without_command=True)
def _version(
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    if version:
        print(f"longball {__version__}")
        raise typer.Exit


# --- solve ----------------------------------------------------------------------------------------


@app.command("solve", epilog="Example: longball solve at-bats.jsonl -o results.jsonl")
def solve_command(
    source: Annotated[
        str, typer.Argument(metavar="[SCENES|-]", help="JSON Lines, a scene each; - reads stdin.")
    ] = "-",
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Where results go; stdout if not given.")
    ] = None,
    engine: Annotated[
        str, typer.Option(help="Who computes: " + ", ".join(engines.ENGINES))
    ] = "ivp",
    method: Annotated[
        str | None, typer.Option(help="ivp: a method of solve_ivp; DOP853 if not given.")
    ] = None,
    rtol: Annotated[float | None, typer.Option(help="ivp: relative tolerance.")] = None,
    atol: Annotated[float | None, typer.Option(help="ivp: absolute tolerance, m, m/s.")] = None,
    workers: Annotated[int, typer.Option(help="Processes; -1: one a core.")] = 1,
) -> None:
    """Solve scenes: one line of JSON in, one line of JSON out."""
    options = {"method": method, "rtol": rtol, "atol": atol}
    try:
        solver = engines.create(engine, **{k: v for k, v in options.items() if v is not None})
    except ValueError as error:
        wrong_call(str(error))
    check_workers(workers)
    solved = failed = 0
    with reading_from(source) as lines, writing_to(output, source) as results:
        for result in solve_lines(lines, solver, workers):
            results.write(result.line().encode() + b"\n")
            results.flush()
            solved += 1
            failed += result.error is not None
    if solved == 0:
        say.print(f"longball: no scenes in {source}", markup=False)
    elif failed:
        say.print(f"longball: {failed} of {solved} lines could not be solved", markup=False)
    if failed or not solved:
        raise typer.Exit(1)


@contextmanager
def reading_from(source: str) -> Iterator[BinaryIO]:
    """Open a file of lines; - is standard input."""
    if source == "-":
        yield sys.stdin.buffer
    else:
        with open(source, "rb") as file:
            yield file


@contextmanager
def writing_to(output: Path | None, source: str) -> Iterator[BinaryIO]:
    """Open the file that results go to; None is standard output."""
    if output is None:
        yield sys.stdout.buffer
    elif source != "-" and output.exists() and output.samefile(source):
        wrong_call(f"{output} is the file that the scenes are read from")
    else:
        with open(output, "wb") as file:
            yield file


def check_workers(workers: int) -> None:
    """Refuse a number of processes that is neither positive nor -1."""
    if workers < 1 and workers != -1:
        wrong_call(f"--workers {workers}: a positive number, or -1 for one a core")


# --- homerun --------------------------------------------------------------------------------------

ReadingOption = Annotated[
    list[str] | None,
    typer.Option("--reading", metavar="NAME=OPTION", help="A switch of the ledger; repeatable."),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="BLOCK.KEY=VALUE", help="A value of the scene; repeatable."),
]
Samples = Annotated[int, typer.Option(min=1, help="At-bats drawn.")]
Seed = Annotated[int, typer.Option(min=0, help="Where the random numbers come from.")]
Workers = Annotated[int, typer.Option(help="Processes; -1: one a core.")]


@app.command(epilog="Example: longball homerun --samples 1000 --e 0.41:0.45:0.01 --figure P.png")
def homerun(
    samples: Samples = 1000,
    e: Annotated[
        str, typer.Option(help="Restitutions: first:last:step, or values with commas.")
    ] = "0.41:0.45:0.01",
    seed: Seed = 1,
    reading: ReadingOption = None,
    set_: SetOption = None,
    workers: Workers = -1,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, not a table.")] = False,
    csv_file: Annotated[Path | None, typer.Option("--csv", help="Write the table here.")] = None,
    figure: Annotated[Path | None, typer.Option(help="Draw P(e) here: .png, .svg, .pdf")] = None,
    scenes_file: Annotated[
        Path | None, typer.Option("--scenes", help="Write the sampled at-bats here, as scenes.")
    ] = None,
    method: Annotated[str, typer.Option(help="monte-carlo")] = "monte-carlo",
) -> None:
    """Estimate the probability of a home run P(e) from sampled at-bats."""
    if method != "monte-carlo":
        wrong_call(f"--method {method}: the methods are monte-carlo")
    check_workers(workers)
    base = base_scene(reading or [], set_ or [])
    restitutions = parse_restitutions(e)
    at_bats = paper_at_bats(base.reading)
    if scenes_file:
        write_scenes(scenes_file, base, at_bats, restitutions, samples, seed)
    with progress_bar("at-bats", samples) as advance:
        struck = monte_carlo(
            base, at_bats, restitutions, samples, seed, workers=workers, progress=advance
        )
    rows = [estimate(x, some, base.reading) for x, some in zip(restitutions, struck, strict=True)]
    fitted = fit(rows)
    if csv_file:
        write_csv(csv_file, rows)
    if figure:
        from longball.pictures import save_probability

        try:
            save_probability(figure, rows, fitted)
        except ValueError as error:  # an ending that matplotlib does not know
            wrong_call(f"--figure {figure}: {error}")
    if as_json:
        print(json.dumps(as_data(rows, fitted, base.reading, samples, seed), ensure_ascii=False))
    else:
        print_probability(rows, fitted, base.reading)
    failed = max(row.failed for row in rows)
    if failed:
        say.print(f"longball: {failed} at-bats could not be solved; they count as no home run")
        raise typer.Exit(1)


def base_scene(readings: Sequence[str], values: Sequence[str]) -> AtBatScene:
    """Return the at-bat that options describe, with everything that is not drawn at random."""
    scene: dict[str, Any] = {"id": "base", "kind": "at-bat", "reading": {}}
    for text in readings:
        name, option = split_assignment("--reading", text)
        scene["reading"][name] = option_value(option)
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


def split_assignment(option: str, text: str) -> tuple[str, str]:
    """Return the two sides of NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        wrong_call(f"{option} {text}: NAME=VALUE is needed")
    return name, value


def option_value(text: str) -> Any:
    """Return a JSON value where the text is one, and the text itself elsewhere."""
    try:
        return json.loads(text)
    except ValueError:
        return text


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


FIELDS = ("e", "p", "low", "high", "home_runs", "trials", "failed")


def as_data(
    rows: Sequence[Estimate], fitted: Fit | None, reading: Reading, samples: int, seed: int
) -> dict[str, Any]:
    """Return what --json prints; a number that is not defined is null."""

    def known(value: float) -> float | None:
        return None if value != value else value

    return {
        "rows": [{name: known(getattr(row, name)) for name in FIELDS} for row in rows],
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
        "reading": reading.model_dump(),
        "method": "monte-carlo",
        "samples": samples,
        "seed": seed,
    }


def write_csv(path: Path, rows: Sequence[Estimate]) -> None:
    """Write estimates as a table."""
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(FIELDS)
        writer.writerows([getattr(row, name) for name in FIELDS] for row in rows)


def print_probability(rows: Sequence[Estimate], fitted: Fit | None, reading: Reading) -> None:
    """Print P(e) beside the paper's printed curves."""
    chosen = reading.fig7_parameters
    table = plain_table("e", "P(e)", "95 %", "home runs", "paper's caption", "text", "difference")
    for row in rows:
        table.add_row(
            f"{row.e:g}",
            f"{row.p:.4f}",
            f"{row.low:.4f} to {row.high:.4f}",
            f"{row.home_runs} of {row.trials}",
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


# --- readings -------------------------------------------------------------------------------------


@app.command(epilog="Example: longball readings --samples 1000")
def readings(
    samples: Annotated[int, typer.Option(min=0, help="At-bats drawn; 0: the ledger only.")] = 1000,
    e: Annotated[float, typer.Option(min=0.0, max=1.0, help="Restitution of the ball.")] = 0.42,
    seed: Seed = 1,
    workers: Workers = -1,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, not a table.")] = False,
) -> None:
    """Print the ledger of readings, and what each one does to P(e)."""
    check_workers(workers)
    lines = [(entry, option) for entry in LEDGER for option in entry.options]
    effects: dict[Reading | None, Estimate] = {}
    if samples:
        switched = dict.fromkeys(reading for line in lines if (reading := reading_with(*line)))
        with progress_bar("readings", len(switched)) as advance:
            for done, reading in enumerate(switched, 1):
                base = AtBatScene(id="base", reading=reading)
                (struck,) = monte_carlo(
                    base, paper_at_bats(reading), [e], samples, seed, workers=workers
                )
                effects[reading] = estimate(e, struck, reading)
                advance(done)
    if as_json:
        print(json.dumps(ledger_as_data(lines, effects), ensure_ascii=False))
        return
    table = plain_table("switch", "option", *([f"P({e:g})", "95 %"] if samples else []))
    for entry, option in lines:
        row = effects.get(reading_with(entry, option))
        numbers = [f"{row.p:.4f}", f"{row.low:.4f} to {row.high:.4f}"] if row else []
        default = " (default)" if option == entry.options[0] else ""
        table.add_row(entry.switch, option + default, *numbers)
    show(table)
    for entry in LEDGER:
        print(f"{entry.switch} ({entry.place}): {entry.why}")


def reading_with(entry: Entry, option: str) -> Reading | None:
    """Return the default reading with one switch set; None for what is no switch of a reading."""
    if entry.switch not in Reading.model_fields:
        return None
    return Reading.model_validate({entry.switch: option_value(option)})


def ledger_as_data(
    lines: Sequence[tuple[Entry, str]], effects: dict[Reading | None, Estimate]
) -> dict[str, Any]:
    """Return what --json prints."""
    rows = []
    for entry, option in lines:
        row = effects.get(reading_with(entry, option))
        effect = {"e": row.e, "p": row.p, "low": row.low, "high": row.high} if row else {}
        default = option == entry.options[0]
        rows.append({"switch": entry.switch, "option": option, "default": default} | effect)
    ledger = [{"switch": x.switch, "place": x.place, "why": x.why} for x in LEDGER]
    return {"rows": rows, "ledger": ledger}


# --- people ---------------------------------------------------------------------------------------


def plain_table(*columns: str) -> Table:
    """Return an empty table for standard output."""
    table = Table(box=None, pad_edge=False, header_style="")
    for column in columns:
        table.add_column(column, no_wrap=True)
    return table


def show(table: Table) -> None:
    """Print a table as wide as it is, whatever reads it."""
    console = Console(highlight=False, width=200, color_system=None)
    with console.capture() as printed:
        console.print(table)
    print("\n".join(line.rstrip() for line in printed.get().splitlines()))


@contextmanager
def progress_bar(what: str, total: int) -> Iterator[Callable[[int], None]]:
    """Show progress on standard error while it is a terminal; yields a function of what is done."""
    bar = Progress(
        TextColumn(what),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=say,
        disable=not say.is_terminal,
        transient=True,
    )
    with bar:
        task = bar.add_task(what, total=total)
        yield lambda done: bar.update(task, completed=done)


if __name__ == "__main__":
    main()
