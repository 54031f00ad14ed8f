"""The options of all commands: names, forms, checks and help, in one table.

A command is a function, and its parameters are its arguments and options. `command_of` looks up
each parameter in this table, as ``command.parameter`` or by its name alone.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from functools import wraps
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import typer

from longball.cli.command import Command
from longball.cli.messages import hushed
from longball.extras import naming_extras

# --- checks: wrong values are rejected before anything is computed --------------------------------


def _workers(workers: int) -> int:
    from longball.engines.parallel import checked

    try:
        checked(workers)
    except ValueError as error:
        raise typer.BadParameter(str(error).removeprefix("workers = ")) from None
    # Report a missing library now, not after the scenes are read.
    if workers > 1:
        import_module("joblib")
    return workers


def _finite(number: float | None) -> float | None:
    if number is not None and not math.isfinite(number):
        raise typer.BadParameter(f"{number} is not a finite number")
    return number


def _writable(file: Path | None) -> Path | None:
    if file is not None:
        if file.is_dir():  # an empty name is one, too
            raise typer.BadParameter(f"{file} is a folder; a file is needed")
        if not file.parent.is_dir():
            raise typer.BadParameter(f"{file}: there is no folder {file.parent}")
        if not os.access(file if file.exists() else file.parent, os.W_OK):
            raise typer.BadParameter(f"{file} cannot be written")
    return file


def _drawable(file: Path | None) -> Path | None:
    if _writable(file) and file:
        # Without a suffix, Matplotlib would add one, and write another file than the checked one.
        file = file if file.suffix else file.with_suffix(".png")
        with naming_extras():
            from matplotlib.backend_bases import FigureCanvasBase  # slow to import

        endings = [f".{name}" for name in FigureCanvasBase.get_supported_filetypes()]
        if file.suffix.lower() not in endings:
            raise typer.BadParameter(f"{file}: the endings of pictures are {', '.join(endings)}")
    return file


# Formats of scenes and results, by the suffix of the file.
TABLES = (".csv", ".parquet")
LINES = (".jsonl", ".ndjson", ".json", "")


def ending(file: str | Path) -> str:
    """Return the suffix of a file's name, which decides its format."""
    return Path(file).suffix.lower()


def _results(output: Path | None) -> Path | None:
    # Reject other suffixes, such as .xlsx: the file would contain JSON.
    if output is None or str(output) == "-":
        return None
    if ending(output) not in (*LINES, *TABLES):
        endings = ", ".join(filter(None, (*LINES, *TABLES)))
        raise typer.BadParameter(f"{output}: the endings of results are {endings}, or none")
    return _writable(output)


# --- the table ------------------------------------------------------------------------------------


def _option(
    about: str, metavar: str | None = None, check: Callable[..., Any] | None = None, **form: Any
) -> dict[str, Any]:
    return {"help": about, "metavar": metavar, "callback": check, **form}


def _picture(about: str) -> dict[str, Any]:
    return _option(f"{about}: .png, .svg, .pdf.", "FILE", _drawable)


def _written(about: str) -> dict[str, Any]:
    return _option(about, "FILE", _writable)


def _column_of_fit() -> dict[str, Any]:
    from longball.pitches import Columns

    names = ", ".join(Columns.model_fields)
    about = f"Set a column or unit of the table. NAME is one of {names}. By default, "
    return _option(f"{about}Statcast's names and units. height=null omits heights", "NAME=VALUE")


# Arguments: their form in the help, and their help.
ARGUMENTS = {
    "source": (
        "[SCENES|-]",
        "One scene per line of JSON, or per row of a .csv or .parquet; - reads stdin.",
    ),
    "parks.source": (
        "[SCENES|-]",
        "Batted balls, as longball flight --scene prints one; - reads stdin.",
    ),
    "judge.command": (
        "[-- COMMAND …]",
        "The program to judge: it reads scenes on standard input and writes results on standard "
        "output. If it contains {dt}, it is also run with several time steps, to measure its order "
        "of convergence.",
    ),
    "converge.command": (
        "-- COMMAND …{dt}…",
        "The program: it reads scenes on standard input and writes results on standard output. The "
        "time step, s, replaces {dt}.",
    ),
    "fit.pitches": ("[PITCHES.csv|-]", "One row per pitch; - reads stdin."),
    "table": ("[TABLE.csv|-]", "In Statcast's columns; - reads stdin."),
    "folder": ("[DIR]", "By default the set that comes with longball."),
    "golden write.folder": ("DIR", "Where the set is written."),
    "golden export.output": ("[FILE.zip]", "By default named by version."),
    "golden coverage.scenes": ("SCENES", "A file of scenes, or - for standard input."),
}

# Options: their help alone, or with the form of the value and a check. An option with a list of
# values is repeatable, which `_declared` adds to its help. A row that needs an import is a
# function.
OPTIONS: dict[str, str | dict[str, Any] | Callable[[], dict[str, Any]]] = {
    # scenes, and what changes them
    "reading": _option("Set a switch of the ledger (longball readings)", "NAME=OPTION"),
    "set": _option(
        "Set a value of the scene, e.g. pitch.speed=40, pitch.speed=95mph or launch.angle=30deg",
        "BLOCK.KEY=VALUE",
    ),
    "fence": _option(
        "Fence: a JSON file with a scene's fence block, or a radius, e.g. 120 or 400ft.",
        "FILE|RADIUS",
    ),
    # how commands run, and print
    "engine": "Engine.",
    "workers": _option("Parallel threads or processes; -1: one per core.", check=_workers),
    "scheduler": _option(
        "Work on the Dask cluster of this scheduler, tcp:// or tls://HOST:PORT; needs the extra "
        "dask.",
        "ADDRESS",
    ),
    "seed": _option("Seed of the random numbers.", min=0),
    "quiet": _option("No progress, no notes: errors only.", check=hushed, short="-q"),
    "json": "Print JSON instead of text.",
    # solve, plot
    "solve.output": _option(
        "Output file, .jsonl, .csv or .parquet; by default, or if -, stdout.",
        "FILE",
        _results,
        short="-o",
    ),
    "plot.output": _picture("The picture") | {"short": "-o"},
    "integrator": _option(
        "ivp: Taylor (default), or of solve_ivp: RK23, RK45, DOP853, Radau, BDF, LSODA.", "NAME"
    ),
    "rtol": "ivp: relative tolerance of solve_ivp's methods, by default 5e-14.",
    "atol": "ivp: their absolute tolerance, m and m/s, by default 5e-14.",
    "landing_error": "batch: error allowed at the landing, m, by default 1e-13.",
    "digits": "enclosure, multiprecision: digits of numbers, by default 30, up to 500 and 290.",
    "solve.dt": "verlet: time step, s, by default 0.05.",
    "forces": "verlet: velocity at which drag and lift are evaluated, by default old_carried.",
    "landing": "verlet: position of the landing, by default interpolated.",
    "root": "verlet: root of Appendix B's quadratic equation, by default first.",
    "contact_force": "verlet: step in which half of the contact force acts, by default whole.",
    "path": "Add the path: [[t, x, y, z, vx, vy, vz], …].",
    "points": _option(
        "Points of the path, evenly spaced in time, by default 201.", min=2, max=1_000_000
    ),
    "certify": "Add a proven error bound to every number.",
    # judge, converge
    "judge.golden": _option(
        "Golden cases to use: a family (longball golden list), all, quick (a small set that "
        "detects nearly every edit) or usual-constants (gravities and air densities that other "
        "simulators use). By default the families of the paper's model except hard",
        "SET",
    ),
    "judge.scenes": _option(
        "Judge by the scenes in this file, lines of JSON, .csv or .parquet. Longball first solves "
        "them with proven bounds.",
        "FILE",
    ),
    "random": _option("Judge by N random scenes, drawn from --seed.", "N", min=1),
    "judge.seed": _option("Seed of the random scenes, by default 1.", min=0),
    "kind": _option("Scenes of this kind only: flight, pitch, impact or at-bat", "KIND"),
    "readings": "Use golden cases of other readings as well.",
    "write_defaults": "Add all defaults, except readings, to every scene.",
    "partial": "Accept missing scenes and quantities.",
    "as_csv": "Send scenes to COMMAND as CSV, and read its results as CSV.",
    "results": _option(
        "Judge the results in this file, .jsonl or .csv, instead of running a COMMAND. Columns of "
        "a .csv: id, outcome, landing.distance, landing.position[0], …",
        "FILE",
    ),
    "judge.column": _option(
        "The quantity in a column of the .csv, if the column has another name", "COLUMN=QUANTITY"
    ),
    "judge.samples": "At-bats that the program has drawn, as .jsonl, to test their distributions.",
    "profile": _option(
        "Required accuracy. exact: within 100 times the unavoidable rounding error; converged: "
        "errors below --tolerance; paper: the same as the paper's scheme at its time step, 0.05 s "
        "or --dt.",
        "exact|converged|paper",
    ),
    "tolerance": "Error that the profile converged allows, in SI units, by default 1e-6.",
    "judge.dt": "The program's time step, s. It replaces {dt} in the COMMAND.",
    "steps": _option(
        "Time steps, s, that replace {dt} in turn, evenly spaced in their logarithm, at least 5. "
        "By default, trial runs choose them.",
        "FROM:TO:COUNT",
    ),
    "knob": _option(
        "Values that replace {NAME} in the COMMAND in turn, from coarse to fine: FROM:TO:COUNT, or "
        "a list with commas. For programs with a tolerance or a number of steps.",
        "NAME=VALUES",
    ),
    "expected": _option("Theoretical order of convergence of the method.", check=_finite),
    "timeout": _option("Timeout per answer, s.", min=0.001),
    "total_timeout": _option("Timeout for all answers together, s.", min=0.001),
    "format": "Format of the verdict: text, JSON, JUnit XML, or GitHub Actions annotations.",
    "judge.table": "Print a table of the errors of each quantity.",
    "html": _written("Write the verdict to FILE as HTML with figures."),
    "converge.scenes": _option(
        "Lines of JSON, .csv or .parquet; by default golden flights and at-bats.", "FILE"
    ),
    "converge.golden": _option(
        "Cases of one golden family instead; see longball golden list.", "SET"
    ),
    "truth": "Measure errors against proven values, or by differences between successive steps.",
    "converge.csv": _written("Write the error at every step to FILE."),
    "converge.figure": _picture("Draw error against step in FILE"),
    # homerun, readings
    "homerun.samples": _option("Number of at-bats drawn.", min=1),
    "homerun.e": _option(
        "Restitutions of the ball: first:last:step, or values with commas.", "FIRST:LAST:STEP"
    ),
    "homerun.csv": _written("Write the table to FILE."),
    "homerun.figure": _picture("Draw P(e) in FILE"),
    "homerun.scenes": _written("Write the sampled at-bats to FILE, as scenes."),
    "pitches": _option("Pitch distributions written by longball fit --json.", "FILE"),
    "method": "Method: samples, or integration over their distributions.",
    "readings.samples": _option("Number of at-bats drawn; 0: the ledger only.", min=0),
    "readings.e": _option("Restitution of the ball.", min=0.0, max=1.0),
    # tables of measurements
    "example": "Use the day of pitches that comes with longball.",
    "measured.kind": "Predict pitches or batted balls.",
    "model": "Model of the flight.",
    "spin.speed": _option('Speed at release, e.g. "95 mph"; without a unit in m/s.', "SPEED"),
    "release": _option(
        "Position of the release, from the front of the plate; x to the pitcher, y to the "
        "catcher's left, z up.",
        "X,Y,Z",
    ),
    "up": _option("Movement upwards, e.g. 16in; without a unit in m.", "LENGTH"),
    "across": _option("Movement to the catcher's left; without a unit in m.", "LENGTH"),
    "spin.model": "Model whose law of lift is inverted.",
    "pfx": "Count from 40 ft, as PITCHf/x does.",
    "games": _option(
        "game_pk, temperature (°F), and elevation (ft) or park of each game; by default those of "
        "the example. Other games are played at 20 °C at sea level.",
        "GAMES.csv",
    ),
    "column": _option("The table's name of Statcast's column NAME, e.g. vx0=VX0", "NAME=COLUMN"),
    "measured.scenes": _written("Write the scenes to FILE."),
    "measured.csv": _written("Write each prediction to FILE, in SI units."),
    "measured.figure": _picture("Draw the errors in FILE"),
    "fit.column": _column_of_fit,
    "straight": _option("Pitch types that count as straight, e.g. FF,SI.", "A,B"),
    "breaking": _option("Pitch types that count as breaking; by default all others.", "A,B"),
    # flight, parks
    "speed": _option('Exit speed, e.g. "103 mph"; without a unit in m/s.', "SPEED"),
    "angle": _option("Angle above the horizontal; without a unit in degrees.", "ANGLE"),
    "direction": _option("Angle left of centre field; without a unit in degrees.", "ANGLE"),
    "flight.park": _option("Park that sets fence and elevation; by default sea level.", "NAME"),
    "wind": _option('Wind, e.g. "10 mph out": out, in, left or right.', "WIND"),
    "temperature": _option(
        'Temperature, e.g. "72 F"; without a unit in K; by default 20 °C.', "TEMPERATURE"
    ),
    "elevation": _option(
        "Height above sea level, instead of the park's; without a unit in m.", "HEIGHT"
    ),
    "scene": "Print the scene instead, for longball parks, plot, aim and infer.",
    "bats": _option("Batter's side; sets the sign of the side spin.", "R|L"),
    "parks.park": _option("Solve in this park only", "NAME"),
    # infer, aim
    "infer.points": _option("Points of the path: columns t, x, y, z, in s and m.", "POINTS.csv"),
    "measured": _option(
        "A number of the result, e.g. landing.distance=118.2 or landing.distance=390ft",
        "NAME=VALUE",
    ),
    "unknown": _option(
        "A number to fit, e.g. launch.speed, launch.angle, air.drag_coefficient", "NAME"
    ),
    "aim.unknown": _option(
        "A number to compute: launch.angle or launch.speed, and launch.direction", "NAME"
    ),
    "sigma": "Standard deviation of the measurements; by default estimated from their scatter.",
    "target": _option(
        "Target, m or with a unit: distance of the landing, its position, or a point of the path.",
        "D|X,Y|X,Y,Z",
    ),
    # golden
    "part": "Only that part of the set.",
    "family": _option("Only that family of cases; the others are taken from DIR", "NAME"),
    "golden export.folder": _option("A set other than the shipped one.", "DIR"),
    "most": _option("Number of missed mistakes to list.", min=0),
    "every": _option("Try one edit in N; 1 for all, which takes minutes.", min=1),
    "golden check.sample": _option("Number of cases to solve again; by default all.", min=0),
    "golden check.seed": _option("Seed of the sample.", min=0),
    "independent": "Solve them also by the multiprecision engine, which shares no method.",
}


def command_of(name: str, function: Callable[..., None], epilog: str) -> Any:
    """Build a command from a function, with names and help of its options from the table."""
    # Annotations are strings; they are resolved in the command's module.
    hints = get_type_hints(function)

    @wraps(function)
    def run(**values: Any) -> None:
        function(**values)

    # Typer reads the signature of `run`. The function itself stays callable from tests.
    declared = signature(function)
    run.__signature__ = declared.replace(  # type: ignore[attr-defined]
        parameters=[
            each.replace(annotation=_declared(name, each.name, hints[each.name], each.default))
            for each in declared.parameters.values()
        ]
    )
    alone = typer.Typer(add_completion=False, rich_markup_mode=None)
    alone.command(name.rpartition(" ")[2], cls=Command, epilog=epilog)(run)
    return typer.main.get_command(alone)


def _declared(command: str, parameter: str, hint: Any, default: object) -> Any:
    """Return the annotation of a parameter as typer reads it."""
    if hint is typer.Context:
        return hint
    # A parameter such as `set_` has an underscore to avoid a word of Python.
    name = parameter.rstrip("_")
    own = f"{command}.{name}"
    if own in ARGUMENTS or (name in ARGUMENTS and own not in OPTIONS):
        metavar, about = ARGUMENTS.get(own) or ARGUMENTS[name]
        return Annotated[hint, typer.Argument(metavar=metavar, help=about)]
    row = OPTIONS[own] if own in OPTIONS else OPTIONS[name]
    form = {"help": row} if isinstance(row, str) else {**(row() if callable(row) else row)}
    if any(get_origin(each) is list for each in (hint, *get_args(hint))):
        form["help"] += "; repeatable."
    flag = f"--{name.replace('_', '-')}"
    # Only a switch that is on by default needs a second name, which turns it off.
    long = f"{flag}/--no-{flag[2:]}" if default is True else flag
    return Annotated[hint, typer.Option(*filter(None, (form.pop("short", ""), long)), **form)]
