"""Shared parts of the commands: options, input and output, messages, progress."""

from __future__ import annotations

import math
import os
import stat
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, BinaryIO, NoReturn, TextIO, TypeVar

import typer
from pydantic import BaseModel, ValidationError
from rich.console import Console

from longball import engines
from longball.engines.parallel import checked
from longball.extras import naming_extras
from longball.model.explain import explain
from longball.text_table import aligned

M = TypeVar("M", bound=BaseModel)

# For people: what goes wrong, and what --quiet hides, notes and progress.
errors, say = (Console(stderr=True, highlight=False, soft_wrap=True, emoji=False) for _ in range(2))


def _checked(workers: int) -> int:
    try:
        checked(workers)
    except ValueError as error:
        raise typer.BadParameter(str(error).removeprefix("workers = ")) from None
    if workers > 1:
        import_module("joblib")  # if it is missing, that is said before anything is computed
    return workers


def _finite(number: float | None) -> float | None:
    if number is not None and not math.isfinite(number):
        raise typer.BadParameter(f"{number} is not a finite number")
    return number


def writable(file: Path | None) -> Path | None:
    """Refuse a file that cannot be written, before anything is computed."""
    if file is not None:
        if file.is_dir():  # an empty name is one, too
            raise typer.BadParameter(f"{file} is a folder; a file is needed")
        if not file.parent.is_dir():
            raise typer.BadParameter(f"{file}: there is no folder {file.parent}")
        if not os.access(file if file.exists() else file.parent, os.W_OK):
            raise typer.BadParameter(f"{file} cannot be written")
    return file


def drawable(file: Path | None) -> Path | None:
    """Refuse a file that no picture can be drawn to, likewise; without an ending it is a .png."""
    if writable(file) and file:
        file = file if file.suffix else file.with_suffix(".png")
        with naming_extras():
            from matplotlib.backend_bases import FigureCanvasBase  # slow to import

        endings = [f".{name}" for name in FigureCanvasBase.get_supported_filetypes()]
        if file.suffix.lower() not in endings:
            raise typer.BadParameter(f"{file}: the endings of pictures are {', '.join(endings)}")
    return file


def to_file(
    about: str, *names: str, check: Callable[[Path | None], Path | None] = writable, **others: Any
) -> Any:
    """Return an option that names a file to be written."""
    return typer.Option(*names, callback=check, help=about, **others)


to_picture = partial(to_file, check=drawable)


def _hushed(quiet: bool) -> bool:
    say.quiet = quiet
    return quiet


Quiet = Annotated[
    bool,
    typer.Option("-q", "--quiet", callback=_hushed, help="No progress, no notes: errors only."),
]
EngineName = Annotated[engines.Name, typer.Option(help="What solves the scenes.")]
# Of commands that seldom need another: without the list of them in the help.
AnyEngine = Annotated[str, typer.Option("--engine", metavar="NAME", help="What solves the scenes.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of the random numbers.")]
Workers = Annotated[
    int, typer.Option(callback=_checked, help="Parallel threads or processes; -1: one per core.")
]
Steps = Annotated[
    str | None,
    typer.Option(
        metavar="FROM:TO:COUNT",
        help="The time steps, s, that replace {dt} one after the other, evenly spaced in their "
        "logarithm, at least 5. By default, a few runs choose them.",
    ),
]
Knob = Annotated[
    str | None,
    typer.Option(
        metavar="NAME=VALUES",
        help="The values that replace {NAME} in the COMMAND one after the other, from coarse "
        "to fine: FROM:TO:COUNT, or a list with commas. For tolerances, numbers of steps and "
        "the like.",
    ),
]
Timeout = Annotated[float, typer.Option(min=0.001, help="Longest wait for the next result, s.")]
Expected = Annotated[
    float | None,
    typer.Option(callback=_finite, help="The order of convergence that the method should have."),
]
AsCsv = Annotated[
    bool,
    typer.Option("--as-csv", help="Send scenes to COMMAND as CSV, and read its results as CSV."),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of text.")]


def tell(sentence: str) -> None:
    """Print what is wrong to standard error."""
    errors.print(f"longball: {sentence}", markup=False)


def note(sentence: str) -> None:
    """Print what may be good to know to standard error."""
    say.print(f"longball: {sentence}", markup=False)


def wrong_call(sentence: str) -> NoReturn:
    """Print a usage error and exit with status 2."""
    tell(sentence)
    raise typer.Exit(2)


def fail(sentence: str) -> NoReturn:
    """Print what went wrong and exit with status 1."""
    tell(sentence)
    raise typer.Exit(1)


@contextmanager
def failing_unless(passed: bool) -> Iterator[None]:
    """Leave with status 1 after a verdict is printed, even to a reader that has left."""
    try:
        yield
    finally:
        if not passed:
            raise typer.Exit(1)


def parsed(model: type[M], values: Mapping[str, Any], option: str = "") -> M:
    """Return options as a model; an invalid one is a wrong call."""
    try:
        return model.model_validate(values)
    except ValidationError as error:
        wrong_call(f"{option}{explain(error, model)}")


@contextmanager
def refusing(what: str = "") -> Iterator[None]:
    """Make a ValueError a wrong call; `what` comes before its message."""
    try:
        yield
    except ValueError as error:
        wrong_call(f"{what}{error}")


def chosen_table(table: str, example: bool) -> str | Path | TextIO:
    """Return the table to read: longball's example, or a file; - is standard input."""
    if example and table != "-":
        wrong_call(f"either --example or {table}, not both")
    from longball.pitches import EXAMPLE  # brings numpy

    return EXAMPLE if example else sys.stdin if table == "-" else table


@contextmanager
def reading_table() -> Iterator[None]:
    """Exit with status 1 on a bad table, or 2 on one that cannot be opened, and say why."""
    from longball.pitches import TableError

    try:
        yield
    except TableError as error:
        if isinstance(error.__cause__, OSError):
            wrong_call(str(error))
        fail(str(error))


def named(source: str) -> str:
    """Return the name of a file of lines for messages."""
    return "standard input" if source == "-" else source


@contextmanager
def reading_from(source: str) -> Iterator[BinaryIO]:
    """Open a file of lines; - is standard input."""
    if source == "-":
        yield sys.stdin.buffer
    else:
        with open(source, "rb") as file:
            yield file


@contextmanager
def writing_to(output: Path | None, source: BinaryIO) -> Iterator[BinaryIO]:
    """Open the file that results go to, if it is not the source; None is standard output."""
    with suppress(OSError):  # a stream that is no file, an output that is not there yet
        there = os.stat(output if output is not None else sys.stdout.fileno())
        if stat.S_ISREG(there.st_mode) and os.path.samestat(there, os.fstat(source.fileno())):
            wrong_call(f"{output or 'standard output'} is the file that the scenes are read from")
    if output is None:
        yield sys.stdout.buffer
    else:
        with open(output, "wb") as file:
            yield file


def split_assignment(option: str, text: str) -> tuple[str, str]:
    """Return the two sides of NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        wrong_call(f"{option} {text}: NAME=VALUE is needed")
    return name, value


def assignments(option: str, texts: Iterable[str] | None) -> dict[str, str]:
    """Return the values of a repeated option by their names."""
    return dict(split_assignment(option, text) for text in texts or ())


def show(head: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a table."""
    print("\n".join(aligned([head, *rows])))


@contextmanager
def progress_bar(what: str, total: int) -> Iterator[Callable[..., None]]:
    """Show progress on a terminal; yield a function of what is done (and of the total)."""
    if say.quiet or not say.is_terminal:
        yield lambda done, of=total: None
        return
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    bar = Progress(
        TextColumn(what),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=say,
        transient=True,
    )
    with bar:
        task = bar.add_task(what, total=total)
        shown = 0.0

        def advance(done: int, of: int = total) -> None:
            nonlocal shown
            if done >= of or time.monotonic() > shown + 0.1:
                bar.update(task, completed=done, total=of)
                shown = time.monotonic()

        yield advance
