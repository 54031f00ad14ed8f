"""The options of all commands: names, defaults, types, checks and help.

`COMMANDS` has the arguments and options of each command with their defaults, and two tables have
their types, checks and help, under ``command.name`` or the name alone. A command is a function of
the values, `Options`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from importlib import import_module
from inspect import Parameter, Signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from longball.cli.command import Command, given_by
from longball.cli.messages import hushed, wrong_call
from longball.cli.settings import INSTEAD
from longball.extras import naming_extras
from longball.model.names import one_of

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


def _kinds(names: list[str] | None) -> list[str]:
    from longball.model.scene import KINDS  # as slow to import as the model

    for name in names or ():
        if name not in KINDS:
            raise typer.BadParameter(f"{name}: there is none{one_of('the kinds are', name, KINDS)}")
    return [*dict.fromkeys(names or ())]


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

# name, name=default, or name! if it must be given; the order is that of the help. All commands have
# --quiet.
COMMANDS = {
    "solve": "source=- output engine=ivp integrator rtol atol landing_error digits dt forces "
    "landing root contact_force path points certify set fence reading workers=1 scheduler",
    "judge": "command golden scenes random seed kind readings write_defaults partial as_csv "
    "results column samples profile=converged tolerance dt steps knob expected timeout=60 "
    "total_timeout=3600 format=text table html",
    "converge": "command! scenes golden kind steps knob expected truth=yes as_csv timeout=60 json "
    "csv figure",
    "homerun": "samples=1000 e=0.41:0.45:0.01 seed=1 reading set workers=-1 scheduler json csv "
    "figure scenes pitches method=monte-carlo engine=batch fence",
    "fit": "table=- example column straight breaking seed=0 json",
    "measured": "table=- kind=pitch example model=nathan games column set fence reading "
    "engine=batch workers=1 scheduler scenes csv figure json",
    "movement": "table=- example pfx column workers=1 scheduler json",
    "spin": "table=- example model=nathan games column speed release=54ft,0,6ft up=0 across=0 pfx "
    "set workers=1 scheduler json",
    "flight": "speed! angle! direction=0 park wind temperature=20°C elevation bats model=nathan "
    "set engine=ivp scene json",
    "parks": "source park set reading engine=ivp workers=1 scheduler json",
    "aim": "source=- target unknown set reading",
    "infer": "source=- points measured unknown sigma set reading json",
    "plot": "source=- output=paths.png set fence reading engine=ivp",
    "readings": "samples=1000 e=0.42 seed=1 workers=-1 json",
    "golden list": "folder json",
    "golden path": "",
    "golden export": "output folder",
    "golden write": "folder! part family workers=-1",
    "golden coverage": "scenes! most=20 every=8 json",
    "golden check": "folder sample seed=1 independent=yes workers=-1",
}


def _row(
    form: Any, about: str, check: Callable[..., Any] | None = None, **more: Any
) -> dict[str, Any]:
    """Return a row of the tables.

    The form is a type; the place of one, which is imported on demand; the name of a text's value,
    such as "SPEED"; or a list with this name if the option is repeatable.
    """
    return {"form": form, "help": about, "callback": check, **more}


def _written(about: str) -> dict[str, Any]:
    return _row(Path, about, _writable)


def _picture(about: str, **more: Any) -> dict[str, Any]:
    return _row(Path, f"{about}: .png, .svg, .pdf.", _drawable, **more)


def _column_of_fit() -> dict[str, Any]:
    from longball.pitches import Columns

    names = ", ".join(Columns.model_fields)
    about = f"Set a column or unit of the table. NAME is one of {names}. By default, "
    return _row(["NAME=VALUE"], f"{about}Statcast's names and units. height=null omits heights")


ARGUMENTS = {
    "source": _row(
        "[SCENES|-]",
        "One scene per line of JSON, or per row of a .csv or .parquet; - reads stdin.",
    ),
    "parks.source": _row(
        "[SCENES|-]", "Batted balls, as longball flight --scene prints one; - reads stdin."
    ),
    "judge.command": _row(
        ["[-- COMMAND …]"],
        "The program to judge: it reads scenes on standard input and writes results on standard "
        "output. If it contains {dt}, it is also run with several time steps, to measure its order "
        "of convergence.",
    ),
    "converge.command": _row(
        ["-- COMMAND …{dt}…"],
        "The program: it reads scenes on standard input and writes results on standard output. The "
        "time step, s, replaces {dt}.",
    ),
    "fit.table": _row("[PITCHES.csv|-]", "One row per pitch; - reads stdin."),
    "table": _row("[TABLE.csv|-]", "In Statcast's columns; - reads stdin."),
    "folder": _row(Path, "By default the set that comes with longball.", metavar="[DIR]"),
    "golden write.folder": _row(Path, "Where the set is written.", metavar="DIR"),
    "golden export.output": _row(Path, "By default named by version.", metavar="[FILE.zip]"),
    "golden coverage.scenes": _row("SCENES", "A file of scenes, or - for standard input."),
}

# A row that needs an import is a function.
OPTIONS: dict[str, dict[str, Any] | Callable[[], dict[str, Any]]] = {
    # scenes, and what changes them
    "reading": _row(["NAME=OPTION"], "Set a switch of the ledger (longball readings)"),
    "set": _row(
        ["BLOCK.KEY=VALUE"],
        "Set a value of the scene, e.g. pitch.speed=40, pitch.speed=95mph or launch.angle=30deg",
    ),
    "fence": _row(
        "FILE|RADIUS",
        "Fence: a JSON file with a scene's fence block, or a radius, e.g. 120 or 400ft.",
    ),
    # how commands run, and print
    "engine": _row("longball.engines.Name", "Engine."),
    "workers": _row(int, "Parallel threads or processes; -1: one per core.", _workers),
    "scheduler": _row(
        "ADDRESS",
        "Work on the Dask cluster of this scheduler, tcp:// or tls://HOST:PORT; needs the extra "
        "dask.",
    ),
    "seed": _row(int, "Seed of the random numbers.", min=0),
    "quiet": _row(bool, "No progress, no notes: errors only.", hushed, short="-q"),
    "json": _row(bool, "Print JSON instead of text."),
    # solve, plot
    "solve.output": _row(
        Path,
        "Output file, .jsonl, .csv or .parquet; by default, or if -, stdout.",
        _results,
        short="-o",
    ),
    "plot.output": _picture("The picture", short="-o"),
    "integrator": _row(
        "NAME", "ivp: Taylor (default), or of solve_ivp: RK23, RK45, DOP853, Radau, BDF, LSODA."
    ),
    "rtol": _row(float, "ivp: relative tolerance of solve_ivp's methods, by default 5e-14."),
    "atol": _row(float, "ivp: their absolute tolerance, m and m/s, by default 5e-14."),
    "landing_error": _row(float, "batch: error allowed at the landing, m, by default 1e-13."),
    "digits": _row(
        int, "enclosure, multiprecision: digits of numbers, by default 30, up to 500 and 290."
    ),
    "solve.dt": _row(float, "verlet: time step, s, by default 0.05."),
    "forces": _row(
        "longball.model.readings.VerletForces",
        "verlet: velocity at which drag and lift are evaluated, by default old_carried.",
    ),
    "landing": _row(
        "longball.model.readings.VerletLanding",
        "verlet: position of the landing, by default interpolated.",
    ),
    "root": _row(
        "longball.model.readings.AppendixBRoot",
        "verlet: root of Appendix B's quadratic equation, by default first.",
    ),
    "contact_force": _row(
        "longball.model.readings.ContactForce",
        "verlet: step in which half of the contact force acts, by default whole.",
    ),
    "path": _row(bool, "Add the path: [[t, x, y, z, vx, vy, vz], …]."),
    "points": _row(
        int, "Points of the path, evenly spaced in time, by default 201.", min=2, max=1_000_000
    ),
    "certify": _row(bool, "Add a proven error bound to every number."),
    # judge, converge
    "judge.golden": _row(
        ["SET"],
        "Golden cases to use: a family (longball golden list), all, quick (a small set that "
        "detects nearly every edit) or usual-constants (gravities and air densities that other "
        "simulators use). By default the families of the paper's model except hard",
    ),
    "judge.scenes": _row(
        "FILE",
        "Judge by the scenes in this file, lines of JSON, .csv or .parquet. Longball first solves "
        "them with proven bounds.",
    ),
    "random": _row(int, "Judge by N random scenes, drawn from --seed.", min=1),
    "judge.seed": _row(int, "Seed of the random scenes, by default 1.", min=0),
    "kind": _row(["KIND"], "Scenes of this kind only: flight, pitch, impact or at-bat", _kinds),
    "judge.readings": _row(bool, "Use golden cases of other readings as well."),
    "write_defaults": _row(bool, "Add all defaults, except readings, to every scene."),
    "partial": _row(bool, "Accept missing scenes and quantities."),
    "as_csv": _row(bool, "Send scenes to COMMAND as CSV, and read its results as CSV."),
    "results": _row(
        Path,
        "Judge the results in this file, .jsonl or .csv, instead of running a COMMAND. Columns of "
        "a .csv: id, outcome, landing.distance, landing.position[0], …",
    ),
    "judge.column": _row(
        ["COLUMN=QUANTITY"],
        "The quantity in a column of the .csv, if the column has another name",
    ),
    "judge.samples": _row(
        Path, "At-bats that the program has drawn, as .jsonl, to test their distributions."
    ),
    "profile": _row(
        Literal["exact", "converged", "paper"],
        "Required accuracy. exact: within 100 times the unavoidable rounding error; converged: "
        "errors below --tolerance; paper: the same as the paper's scheme at its time step, 0.05 s "
        "or --dt.",
    ),
    "tolerance": _row(
        float, "Error that the profile converged allows, in SI units, by default 1e-6."
    ),
    "judge.dt": _row(float, "The program's time step, s. It replaces {dt} in the COMMAND."),
    "steps": _row(
        "FROM:TO:COUNT",
        "Time steps, s, that replace {dt} in turn, evenly spaced in their logarithm, at least 5. "
        "By default, trial runs choose them.",
    ),
    "knob": _row(
        "NAME=VALUES",
        "Values that replace {NAME} in the COMMAND in turn, from coarse to fine: FROM:TO:COUNT, or "
        "a list with commas. For programs with a tolerance or a number of steps.",
    ),
    "expected": _row(float, "Theoretical order of convergence of the method.", _finite),
    "timeout": _row(float, "Timeout per answer, s.", min=0.001),
    "total_timeout": _row(float, "Timeout for all answers together, s.", min=0.001),
    "format": _row(
        Literal["text", "json", "junit", "github"],
        "Format of the verdict: text, JSON, JUnit XML, or GitHub Actions annotations.",
    ),
    "judge.table": _row(bool, "Print a table of the errors of each quantity."),
    "html": _written("Write the verdict to FILE as HTML with figures."),
    "converge.scenes": _row(
        "FILE", "Lines of JSON, .csv or .parquet; by default golden flights and at-bats."
    ),
    "converge.golden": _row("SET", "Cases of one golden family instead; see longball golden list."),
    "truth": _row(
        bool, "Measure errors against proven values, or by differences between successive steps."
    ),
    "converge.csv": _written("Write the error at every step to FILE."),
    "converge.figure": _picture("Draw error against step in FILE"),
    # homerun, readings
    "homerun.samples": _row(int, "Number of at-bats drawn.", min=1),
    "homerun.e": _row(
        "FIRST:LAST:STEP", "Restitutions of the ball: first:last:step, or values with commas."
    ),
    "homerun.csv": _written("Write the table to FILE."),
    "homerun.figure": _picture("Draw P(e) in FILE"),
    "homerun.scenes": _written("Write the sampled at-bats to FILE, as scenes."),
    "pitches": _row(Path, "Pitch distributions written by longball fit --json."),
    "method": _row(
        Literal["monte-carlo", "quadrature"],
        "Method: samples, or integration over their distributions.",
    ),
    # Fast engines that report undecided at-bats; verlet would decide them by its errors.
    "homerun.engine": _row(Literal["batch", "ivp"], "Engine."),
    "readings.samples": _row(int, "Number of at-bats drawn; 0: the ledger only.", min=0),
    "readings.e": _row(float, "Restitution of the ball.", min=0.0, max=1.0),
    # tables of measurements
    "example": _row(bool, "Use the day of pitches that comes with longball."),
    "measured.kind": _row("longball.pitches.statcast.Kind", "Predict pitches or batted balls."),
    "model": _row("longball.pitches.models.Model", "Model of the flight."),
    "spin.model": _row("longball.pitches.models.Model", "Model whose law of lift is inverted."),
    "spin.speed": _row("SPEED", 'Speed at release, e.g. "95 mph"; without a unit in m/s.'),
    "release": _row(
        "X,Y,Z",
        "Position of the release, from the front of the plate; x to the pitcher, y to the "
        "catcher's left, z up.",
    ),
    "up": _row("LENGTH", "Movement upwards, e.g. 16in; without a unit in m."),
    "across": _row("LENGTH", "Movement to the catcher's left; without a unit in m."),
    "pfx": _row(bool, "Count from 40 ft, as PITCHf/x does."),
    "games": _row(
        Path,
        "game_pk, temperature (°F), and elevation (ft) or park of each game; by default those of "
        "the example. Other games are played at 20 °C at sea level.",
    ),
    "column": _row(["NAME=COLUMN"], "The table's name of Statcast's column NAME, e.g. vx0=VX0"),
    "measured.scenes": _written("Write the scenes to FILE."),
    "measured.csv": _written("Write each prediction to FILE, in SI units."),
    "measured.figure": _picture("Draw the errors in FILE"),
    "fit.column": _column_of_fit,
    "straight": _row("A,B", "Pitch types that count as straight, e.g. FF,SI."),
    "breaking": _row("A,B", "Pitch types that count as breaking; by default all others."),
    # flight, parks
    "speed": _row("SPEED", 'Exit speed, e.g. "103 mph"; without a unit in m/s.'),
    "angle": _row("ANGLE", "Angle above the horizontal; without a unit in degrees."),
    "direction": _row("ANGLE", "Angle left of centre field; without a unit in degrees."),
    "flight.park": _row("NAME", "Park that sets fence and elevation; by default sea level."),
    "wind": _row("WIND", 'Wind, e.g. "10 mph out": out, in, left or right.'),
    "temperature": _row("TEMPERATURE", 'Temperature, e.g. "72 F"; without a unit in K.'),
    "elevation": _row(
        "HEIGHT", "Height above sea level, instead of the park's; without a unit in m."
    ),
    "scene": _row(bool, "Print the scene instead, for longball parks, plot, aim and infer."),
    "bats": _row(Literal["R", "L"], "Batter's side; sets the sign of the side spin."),
    "parks.park": _row(["NAME"], "Solve in this park only"),
    # infer, aim
    "infer.points": _row(Path, "Points of the path: columns t, x, y, z, in s and m."),
    "measured": _row(
        ["NAME=VALUE"],
        "A number of the result, e.g. landing.distance=118.2 or landing.distance=390ft",
    ),
    "unknown": _row(
        ["NAME"], "A number to fit, e.g. launch.speed, launch.angle, air.drag_coefficient"
    ),
    "aim.unknown": _row(
        ["NAME"], "A number to compute: launch.angle or launch.speed, and launch.direction"
    ),
    "sigma": _row(
        float, "Standard deviation of the measurements; by default estimated from their scatter."
    ),
    "target": _row(
        "D|X,Y|X,Y,Z",
        "Target, m or with a unit: distance of the landing, its position, or a point of the path.",
    ),
    # golden
    "part": _row(Literal["cases", "probability"], "Only that part of the set."),
    "family": _row(["NAME"], "Only that family of cases; the others are taken from DIR"),
    "golden export.folder": _row(Path, "A set other than the shipped one.", metavar="DIR"),
    "most": _row(int, "Number of missed mistakes to list.", min=0),
    "every": _row(int, "Try one edit in N; 1 for all, which takes minutes.", min=1),
    "golden check.sample": _row(int, "Number of cases to solve again; by default all.", min=0),
    "golden check.seed": _row(int, "Seed of the sample.", min=0),
    "independent": _row(
        bool, "Solve them also by the multiprecision engine, which shares no method."
    ),
}


# --- commands -------------------------------------------------------------------------------------


class Options:
    """The arguments and options of a command, as attributes."""

    def __init__(self, ctx: Any, values: dict[str, Any]) -> None:
        vars(self).update(values)
        for names in INSTEAD:
            if sum(bool(values.get(name)) for name in names) > 1:
                *some, last = (flag(name) for name in names if name in values)
                both = "both" if len(some) == 1 else "two of them"
                wrong_call(f"either {', '.join(some)} or {last}, not {both}")
        self.given = {name for name in values if given_by(ctx, name) == "COMMANDLINE"}

    def refuse(self, names: str, why: str) -> None:
        """Reject options that have no effect here: a user would believe that they were applied."""
        for name in names.split():
            if name in self.given:
                wrong_call(f"{flag(name)}: {why}")

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...


def flag(name: str) -> str:
    """Return an option as it is written on the command line."""
    return "-- COMMAND" if name == "command" else f"--{name.replace('_', '-')}"


def command_of(name: str, function: Callable[[Options], None], epilog: str) -> Any:
    """Build a command from a function and the rows of the tables."""

    def run(ctx: typer.Context, **values: Any) -> None:
        function(Options(ctx, values))

    # Typer reads the signature of `run`, and its docstring for the help.
    context = Parameter("ctx", Parameter.KEYWORD_ONLY, annotation=typer.Context)
    asked = [_parameter(name, word) for word in f"{COMMANDS[name]} quiet".split()]
    run.__signature__ = Signature([context, *asked])  # type: ignore[attr-defined]
    run.__doc__ = function.__doc__
    alone = typer.Typer(add_completion=False, rich_markup_mode=None)
    alone.command(name.rpartition(" ")[2], cls=Command, epilog=epilog)(run)
    return typer.main.get_command(alone)


def _parameter(command: str, word: str) -> Parameter:
    """Return a parameter as typer reads it, from a word of `COMMANDS`."""
    name, _, text = word.partition("=")
    name, required = name.removesuffix("!"), name.endswith("!")
    own = f"{command}.{name}"
    is_argument = own in ARGUMENTS or (name in ARGUMENTS and own not in OPTIONS)
    table: Any = ARGUMENTS if is_argument else OPTIONS
    row = table[own] if own in table else table[name]
    more = {**(row() if callable(row) else row)}
    type_, short = more.pop("form"), more.pop("short", "")
    if isinstance(type_, list):
        more["metavar"], type_ = type_[0], list[str]
        more["help"] += "" if is_argument else "; repeatable."
    elif isinstance(type_, str) and type_.startswith("longball."):
        module, _, of = type_.rpartition(".")
        type_ = getattr(import_module(module), of)
    elif isinstance(type_, str):
        more["metavar"], type_ = type_, str
    default: Any = Parameter.empty if required else text or None
    if type_ in (int, float, bool, Path) and (text or type_ is bool):
        default = type_(text)
    if default is None:
        type_ |= None
    if is_argument:
        form: Any = typer.Argument(**more)
    else:
        # Only a switch that is on by default needs a second name, which turns it off.
        long = f"{flag(name)}/--no-{flag(name)[2:]}" if default is True else flag(name)
        form = typer.Option(*filter(None, (short, long)), **more)
    annotation = Annotated[type_, form]  # type: ignore[valid-type]
    return Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
