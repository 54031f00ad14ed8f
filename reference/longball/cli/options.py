"""The options of all commands: names, defaults, types, checks and help.

`COMMANDS` has the arguments and options of each command with their defaults, and two tables have
their types, checks and help, under ``command.name`` or the name alone. A command is a function of
the values, `Options`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from importlib import import_module
from inspect import Parameter, Signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, get_args

import typer

from longball.cli.command import Command
from longball.cli.messages import hushed, note, wrong_call
from longball.cli.settings import INSTEAD, settings_of
from longball.extras import naming_extras
from longball.model.names import did_you_mean, one_of

# --- checks: wrong values are rejected before anything is computed --------------------------------


def _workers(workers: int) -> int:
    from longball.engines.parallel import checked

    try:
        checked(workers)
    except ValueError as error:
        raise ValueError(str(error).removeprefix("workers = ")) from None
    # Report a missing library now, not after the scenes are read.
    if workers > 1:
        import_module("joblib")
    return workers


def _kinds(names: list[str]) -> list[str]:
    from longball.model.scene import KINDS  # as slow to import as the model

    for name in names:
        if name not in KINDS:
            raise ValueError(f"{name}: there is none{one_of('the kinds are', name, KINDS)}")
    return [*dict.fromkeys(names)]


def _finite(number: float) -> float:
    if not math.isfinite(number):
        raise ValueError(f"{number} is not a finite number")
    return number


def _writable(file: Path) -> Path:
    if file.is_dir():  # an empty name is one, too
        raise ValueError(f"{file} is a folder; a file is needed")
    if not file.parent.is_dir():
        raise ValueError(f"{file}: there is no folder {file.parent}")
    if not os.access(file if file.exists() else file.parent, os.W_OK):
        raise ValueError(f"{file} cannot be written")
    return file


def _drawable(file: Path) -> Path:
    # Without a suffix, Matplotlib would add one, and write another file than the checked one.
    file = _writable(file) if file.suffix else _writable(file).with_suffix(".png")
    with naming_extras():
        from matplotlib.backend_bases import FigureCanvasBase  # slow to import

    endings = [f".{name}" for name in FigureCanvasBase.get_supported_filetypes()]
    if file.suffix.lower() not in endings:
        raise ValueError(f"{file}: the endings of pictures are {', '.join(endings)}")
    return file


# Formats of scenes and results, by the suffix of the file.
TABLES = (".csv", ".parquet")
LINES = (".jsonl", ".ndjson", ".json", "")


def ending(file: str | Path) -> str:
    """Return the suffix of a file's name, which decides its format."""
    return Path(file).suffix.lower()


def _results(output: Path) -> Path | None:
    # Reject other suffixes, such as .xlsx: the file would contain JSON.
    if str(output) == "-":
        return None
    if ending(output) not in (*LINES, *TABLES):
        endings = ", ".join(filter(None, (*LINES, *TABLES)))
        raise ValueError(f"{output}: the endings of results are {endings}, or none")
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


class Row(NamedTuple):
    """A row of the tables."""

    # A type; the place of one, which is imported on demand; the name of a text's value, such as
    # "SPEED"; or a list with this name if the option is repeatable. Its values are then a list, or
    # of the form NAME=VALUE a dict.
    form: Any
    about: str
    check: Callable[[Any], Any] | None = None  # of a given value; it may return another one
    min: float = -math.inf
    max: float = math.inf
    short: str = ""
    metavar: str = ""  # for help, in place of that of the form
    # From the word of `COMMANDS`.
    default: str = ""
    required: bool = False
    is_argument: bool = False


def _written(about: str) -> Row:
    return Row(Path, about, _writable)


def _picture(about: str, **more: Any) -> Row:
    return Row(Path, f"{about}: .png, .svg, .pdf.", _drawable, **more)


def _column_of_fit() -> Row:
    from longball.pitches import Columns

    names = ", ".join(Columns.model_fields)
    about = f"Set a column or unit of the table. NAME is one of {names}. By default, "
    return Row(["NAME=VALUE"], f"{about}Statcast's names and units. height=null omits heights")


ARGUMENTS = {
    "source": Row(
        "[SCENES|-]",
        "One scene per line of JSON, or per row of a .csv or .parquet; - reads stdin.",
    ),
    "parks.source": Row(
        "[SCENES|-]", "Batted balls, as longball flight --scene prints one; - reads stdin."
    ),
    "judge.command": Row(
        ["[-- COMMAND …]"],
        "The program to judge: it reads scenes on standard input and writes results on standard "
        "output. If it contains {dt}, it is also run with several time steps, to measure its order "
        "of convergence.",
    ),
    "converge.command": Row(
        ["-- COMMAND …{dt}…"],
        "The program: it reads scenes on standard input and writes results on standard output. The "
        "time step, s, replaces {dt}.",
    ),
    "fit.table": Row("[PITCHES.csv|-]", "One row per pitch; - reads stdin."),
    "table": Row("[TABLE.csv|-]", "In Statcast's columns; - reads stdin."),
    "folder": Row(Path, "By default the set that comes with longball.", metavar="[DIR]"),
    "golden write.folder": Row(Path, "Where the set is written.", metavar="DIR"),
    "golden export.output": Row(Path, "By default named by version.", metavar="[FILE.zip]"),
    "golden coverage.scenes": Row("SCENES", "A file of scenes, or - for standard input."),
}

# A row that needs an import is a function.
OPTIONS: dict[str, Row | Callable[[], Row]] = {
    # scenes, and what changes them
    "reading": Row(["NAME=OPTION"], "Set a switch of the ledger (longball readings)"),
    "set": Row(
        ["BLOCK.KEY=VALUE"],
        "Set a value of the scene, e.g. pitch.speed=40, pitch.speed=95mph or launch.angle=30deg",
    ),
    "fence": Row(
        "FILE|RADIUS",
        "Fence: a JSON file with a scene's fence block, or a radius, e.g. 120 or 400ft.",
    ),
    # how commands run, and print
    "engine": Row("longball.engines.Name", "Engine."),
    "workers": Row(int, "Parallel threads or processes; -1: one per core.", _workers),
    "scheduler": Row(
        "ADDRESS",
        "Work on the Dask cluster of this scheduler, tcp:// or tls://HOST:PORT; needs the extra "
        "dask.",
    ),
    "seed": Row(int, "Seed of the random numbers.", min=0),
    "quiet": Row(bool, "No progress, no notes: errors only.", hushed, short="-q"),
    "json": Row(bool, "Print JSON instead of text."),
    # solve, plot
    "solve.output": Row(
        Path,
        "Output file, .jsonl, .csv or .parquet; by default, or if -, stdout.",
        _results,
        short="-o",
    ),
    "plot.output": _picture("The picture", short="-o"),
    "integrator": Row(
        "NAME", "ivp: Taylor (default), or of solve_ivp: RK23, RK45, DOP853, Radau, BDF, LSODA."
    ),
    "rtol": Row(float, "ivp: relative tolerance of solve_ivp's methods, by default 5e-14."),
    "atol": Row(float, "ivp: their absolute tolerance, m and m/s, by default 5e-14."),
    "landing_error": Row(float, "batch: error allowed at the landing, m, by default 1e-13."),
    "digits": Row(
        int, "enclosure, multiprecision: digits of numbers, by default 30, up to 500 and 290."
    ),
    "solve.dt": Row(float, "verlet: time step, s, by default 0.05."),
    "forces": Row(
        "longball.model.readings.VerletForces",
        "verlet: velocity at which drag and lift are evaluated, by default old_carried.",
    ),
    "landing": Row(
        "longball.model.readings.VerletLanding",
        "verlet: position of the landing, by default interpolated.",
    ),
    "root": Row(
        "longball.model.readings.AppendixBRoot",
        "verlet: root of Appendix B's quadratic equation, by default first.",
    ),
    "contact_force": Row(
        "longball.model.readings.ContactForce",
        "verlet: step in which half of the contact force acts, by default whole.",
    ),
    "path": Row(bool, "Add the path: [[t, x, y, z, vx, vy, vz], …]."),
    "points": Row(
        int, "Points of the path, evenly spaced in time, by default 201.", min=2, max=1_000_000
    ),
    "certify": Row(bool, "Add a proven error bound to every number."),
    # judge, converge
    "judge.golden": Row(
        ["SET"],
        "Golden cases to use: a family (longball golden list), all, quick (a small set that "
        "detects nearly every edit) or usual-constants (gravities and air densities that other "
        "simulators use). By default the families of the paper's model except hard",
    ),
    "judge.scenes": Row(
        "FILE",
        "Judge by the scenes in this file, lines of JSON, .csv or .parquet. Longball first solves "
        "them with proven bounds.",
    ),
    "random": Row(int, "Judge by N random scenes, drawn from --seed.", min=1),
    "judge.seed": Row(int, "Seed of the random scenes, by default 1.", min=0),
    "kind": Row(["KIND"], "Scenes of this kind only: flight, pitch, impact or at-bat", _kinds),
    "judge.readings": Row(bool, "Use golden cases of other readings as well."),
    "write_defaults": Row(bool, "Add all defaults, except readings, to every scene."),
    "partial": Row(bool, "Accept missing scenes and quantities."),
    "as_csv": Row(bool, "Send scenes to COMMAND as CSV, and read its results as CSV."),
    "results": Row(
        Path,
        "Judge the results in this file, .jsonl or .csv, instead of running a COMMAND. Columns of "
        "a .csv: id, outcome, landing.distance, landing.position[0], …",
    ),
    "judge.column": Row(
        ["COLUMN=QUANTITY"],
        "The quantity in a column of the .csv, if the column has another name",
    ),
    "judge.samples": Row(
        Path, "At-bats that the program has drawn, as .jsonl, to test their distributions."
    ),
    "profile": Row(
        Literal["exact", "converged", "paper"],
        "Required accuracy. exact: within 100 times the unavoidable rounding error; converged: "
        "errors below --tolerance; paper: the same as the paper's scheme at its time step, 0.05 s "
        "or --dt.",
    ),
    "tolerance": Row(
        float, "Error that the profile converged allows, in SI units, by default 1e-6."
    ),
    "judge.dt": Row(float, "The program's time step, s. It replaces {dt} in the COMMAND."),
    "steps": Row(
        "FROM:TO:COUNT",
        "Time steps, s, that replace {dt} in turn, evenly spaced in their logarithm, at least 5. "
        "By default, trial runs choose them.",
    ),
    "knob": Row(
        "NAME=VALUES",
        "Values that replace {NAME} in the COMMAND in turn, from coarse to fine: FROM:TO:COUNT, or "
        "a list with commas. For programs with a tolerance or a number of steps.",
    ),
    "expected": Row(float, "Theoretical order of convergence of the method.", _finite),
    "timeout": Row(float, "Timeout per answer, s.", min=0.001),
    "total_timeout": Row(float, "Timeout for all answers together, s.", min=0.001),
    "format": Row(
        Literal["text", "json", "junit", "github"],
        "Format of the verdict: text, JSON, JUnit XML, or GitHub Actions annotations.",
    ),
    "judge.table": Row(bool, "Print a table of the errors of each quantity."),
    "html": _written("Write the verdict to FILE as HTML with figures."),
    "converge.scenes": Row(
        "FILE", "Lines of JSON, .csv or .parquet; by default golden flights and at-bats."
    ),
    "converge.golden": Row("SET", "Cases of one golden family instead; see longball golden list."),
    "truth": Row(
        bool, "Measure errors against proven values, or by differences between successive steps."
    ),
    "converge.csv": _written("Write the error at every step to FILE."),
    "converge.figure": _picture("Draw error against step in FILE"),
    # homerun, readings
    "homerun.samples": Row(int, "Number of at-bats drawn.", min=1),
    "homerun.e": Row(
        "FIRST:LAST:STEP", "Restitutions of the ball: first:last:step, or values with commas."
    ),
    "homerun.csv": _written("Write the table to FILE."),
    "homerun.figure": _picture("Draw P(e) in FILE"),
    "homerun.scenes": _written("Write the sampled at-bats to FILE, as scenes."),
    "pitches": Row(Path, "Pitch distributions written by longball fit --json."),
    "method": Row(
        Literal["monte-carlo", "quadrature"],
        "Method: samples, or integration over their distributions.",
    ),
    # Fast engines that report undecided at-bats; verlet would decide them by its errors.
    "homerun.engine": Row(Literal["batch", "ivp"], "Engine."),
    "readings.samples": Row(int, "Number of at-bats drawn; 0: the ledger only.", min=0),
    "readings.e": Row(float, "Restitution of the ball.", min=0.0, max=1.0),
    # tables of measurements
    "example": Row(bool, "Use the day of pitches that comes with longball."),
    "measured.kind": Row("longball.pitches.statcast.Kind", "Predict pitches or batted balls."),
    "model": Row("longball.pitches.models.Model", "Model of the flight."),
    "spin.model": Row("longball.pitches.models.Model", "Model whose law of lift is inverted."),
    "spin.speed": Row("SPEED", 'Speed at release, e.g. "95 mph"; without a unit in m/s.'),
    "release": Row(
        "X,Y,Z",
        "Position of the release, from the front of the plate; x to the pitcher, y to the "
        "catcher's left, z up.",
    ),
    "up": Row("LENGTH", "Movement upwards, e.g. 16in; without a unit in m."),
    "across": Row("LENGTH", "Movement to the catcher's left; without a unit in m."),
    "pfx": Row(bool, "Count from 40 ft, as PITCHf/x does."),
    "games": Row(
        Path,
        "game_pk, temperature (°F), and elevation (ft) or park of each game; by default those of "
        "the example. Other games are played at 20 °C at sea level.",
    ),
    "column": Row(["NAME=COLUMN"], "The table's name of Statcast's column NAME, e.g. vx0=VX0"),
    "measured.scenes": _written("Write the scenes to FILE."),
    "measured.csv": _written("Write each prediction to FILE, in SI units."),
    "measured.figure": _picture("Draw the errors in FILE"),
    "fit.column": _column_of_fit,
    "straight": Row("A,B", "Pitch types that count as straight, e.g. FF,SI."),
    "breaking": Row("A,B", "Pitch types that count as breaking; by default all others."),
    # flight, parks
    "speed": Row("SPEED", 'Exit speed, e.g. "103 mph"; without a unit in m/s.'),
    "angle": Row("ANGLE", "Angle above the horizontal; without a unit in degrees."),
    "direction": Row("ANGLE", "Angle left of centre field; without a unit in degrees."),
    "flight.park": Row("NAME", "Park that sets fence and elevation; by default sea level."),
    "wind": Row("WIND", 'Wind, e.g. "10 mph out": out, in, left or right.'),
    "temperature": Row("TEMPERATURE", 'Temperature, e.g. "72 F"; without a unit in K.'),
    "elevation": Row(
        "HEIGHT", "Height above sea level, instead of the park's; without a unit in m."
    ),
    "scene": Row(bool, "Print the scene instead, for longball parks, plot, aim and infer."),
    "bats": Row(Literal["R", "L"], "Batter's side; sets the sign of the side spin."),
    "parks.park": Row(["NAME"], "Solve in this park only"),
    # infer, aim
    "infer.points": Row(Path, "Points of the path: columns t, x, y, z, in s and m."),
    "measured": Row(
        ["NAME=VALUE"],
        "A number of the result, e.g. landing.distance=118.2 or landing.distance=390ft",
    ),
    "unknown": Row(
        ["NAME"], "A number to fit, e.g. launch.speed, launch.angle, air.drag_coefficient"
    ),
    "aim.unknown": Row(
        ["NAME"], "A number to compute: launch.angle or launch.speed, and launch.direction"
    ),
    "sigma": Row(
        float, "Standard deviation of the measurements; by default estimated from their scatter."
    ),
    "target": Row(
        "D|X,Y|X,Y,Z",
        "Target, m or with a unit: distance of the landing, its position, or a point of the path.",
    ),
    # golden
    "part": Row(Literal["cases", "probability"], "Only that part of the set."),
    "family": Row(["NAME"], "Only that family of cases; the others are taken from DIR"),
    "golden export.folder": Row(Path, "A set other than the shipped one.", metavar="DIR"),
    "most": Row(int, "Number of missed mistakes to list.", min=0),
    "every": Row(int, "Try one edit in N; 1 for all, which takes minutes.", min=1),
    "golden check.sample": Row(int, "Number of cases to solve again; by default all.", min=0),
    "golden check.seed": Row(int, "Seed of the sample.", min=0),
    "independent": Row(
        bool, "Solve them also by the multiprecision engine, which shares no method."
    ),
}


# --- commands -------------------------------------------------------------------------------------


def declared(command: str) -> dict[str, Row]:
    """Return the arguments and options of a command by their names, with forms imported."""
    rows = {}
    for word in f"{COMMANDS[command]} quiet".split():
        name, _, default = word.partition("=")
        name, required = name.removesuffix("!"), name.endswith("!")
        own = f"{command}.{name}"
        is_argument = own in ARGUMENTS or (name in ARGUMENTS and own not in OPTIONS)
        table: Any = ARGUMENTS if is_argument else OPTIONS
        found = table[own] if own in table else table[name]
        row: Row = found() if callable(found) else found
        if isinstance(row.form, str) and row.form.startswith("longball."):
            module, _, of = row.form.rpartition(".")
            row = row._replace(form=getattr(import_module(module), of))
        rows[name] = row._replace(default=default, required=required, is_argument=is_argument)
    return rows


class Options:
    """The arguments and options of a command, as attributes."""

    def __init__(self, command: str, values: Mapping[str, Any]) -> None:
        self.given = {name for name, value in values.items() if value not in (None, [])}
        rows = declared(command)
        options = {n: row.form for n, row in rows.items() if n == "command" or not row.is_argument}
        file, settings = settings_of(command, [x for x in COMMANDS if " " not in x], options)
        # A COMMAND on the command line takes the place of results in the file, and so on.
        for names in INSTEAD:
            if self.given.intersection(names):
                settings = {name: x for name, x in settings.items() if name not in names}
        settings = {name: x for name, x in settings.items() if name not in self.given}
        for name, row in rows.items():
            place, value = _metavar(row) if row.is_argument else flag(name), row.default or None
            if name in self.given:
                value = values[name]
            elif name in settings:
                place, value = f"{file}: {command}.{flag(name)[2:]}", settings[name]
            if row.required and value is None:
                wrong_call(f"{place} is missing: {row.about}".rstrip("."))
            try:
                vars(self)[name] = _read(row, value)
            except ValueError as error:
                wrong_call(f"{place} {error}")
        # Name the options from the file: invisible values would be hard to find.
        if settings:
            note(f"{file} gives {', '.join(settings).replace('_', '-')}")
        for names in INSTEAD:
            if sum(bool(vars(self).get(name)) for name in names) > 1:
                *some, last = (flag(name) for name in names if name in rows)
                both = "both" if len(some) == 1 else "two of them"
                wrong_call(f"either {', '.join(some)} or {last}, not {both}")

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

    def run(**values: Any) -> None:
        function(Options(name, values))

    # Typer reads the signature of `run`, and its docstring for the help.
    parameters = [_parameter(*item) for item in declared(name).items()]
    run.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    run.__doc__ = function.__doc__
    alone = typer.Typer(add_completion=False, rich_markup_mode=None)
    alone.command(name.rpartition(" ")[2], cls=Command, epilog=epilog)(run)
    return typer.main.get_command(alone)


def _parameter(name: str, row: Row) -> Parameter:
    """Return a parameter as typer reads it: a switch, a text or texts, None if it is not given."""
    form, is_list = row.form, isinstance(row.form, list)
    about, notes = row.about, []
    if is_list and not row.is_argument:
        about += "; repeatable."
    if row.default:
        notes.append(f"default: {flag(name)[2:] if form is bool else row.default}")
    if row.min > -math.inf:
        notes.append(f"x>={row.min}" if row.max == math.inf else f"{row.min}<=x<={row.max}")
    if row.required:
        notes.append("required")
    if notes:
        about += f"  [{'; '.join(notes)}]"
    more: dict[str, Any] = {"help": about, "metavar": None if form is bool else _metavar(row)}
    more["autocompletion"] = lambda: [] if is_list else get_args(form)
    if row.is_argument:
        argument: Any = typer.Argument(**more)
    else:
        # Only a switch that is on by default needs a second name, which turns it off.
        off = f"/--no-{flag(name)[2:]}" if form is bool and row.default else ""
        argument = typer.Option(*filter(None, (row.short, flag(name) + off)), **more)
    type_: Any = bool if form is bool else list[str] if is_list else str
    annotation = Annotated[type_ | None, argument]
    return Parameter(name, Parameter.KEYWORD_ONLY, default=None, annotation=annotation)


def _metavar(row: Row) -> str:
    """Return the name of a value in the help: a text has its own, and choices are a|b."""
    form = row.form
    if isinstance(form, list):
        return str(form[0])
    of_types: dict[Any, str] = {int: "N", float: "X", Path: "FILE"}
    return row.metavar or of_types.get(form) or "|".join(get_args(form)) or str(form)


def _read(row: Row, value: Any) -> Any:
    """Return the value of an option from its text; the error begins with the text."""
    form = row.form
    if form is bool:
        value = bool(value)
    elif value is None:
        return {} if isinstance(form, list) and "=" in form[0] else None
    elif form in (int, float):
        try:
            number = form(value)
        except ValueError:
            whole = "whole number" if form is int else "number"
            raise ValueError(f"{value}: must be a {whole}") from None
        limits = {"least": (row.min, number >= row.min), "most": (row.max, number <= row.max)}
        for at, (limit, holds) in limits.items():
            if math.isfinite(limit) and not holds:  # NaN is within no limit
                raise ValueError(f"{value}: must be at {at} {limit}")
        value = number
    elif form is Path:
        value = Path(value)
    elif isinstance(form, list) and "=" in form[0]:
        value = dict(map(_assignment, value))
    elif (choices := () if isinstance(form, list) else get_args(form)) and value not in choices:
        known = ", ".join(choices)
        raise ValueError(f"{value}: must be one of {known}{did_you_mean(value, choices)}")
    return value if row.check is None else row.check(value)


def _assignment(text: str) -> tuple[str, str]:
    """Return the two sides of NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        raise ValueError(f"{text}: must be NAME=VALUE")
    return name, value
