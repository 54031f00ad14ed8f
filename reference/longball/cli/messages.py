"""Messages of commands: sentences, tables and progress."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NoReturn, TypeVar

import typer
from pydantic import BaseModel, ValidationError
from rich.console import Console

from longball.model.explain import explain
from longball.text_table import aligned

M = TypeVar("M", bound=BaseModel)

# Standard error: errors, and notes and progress, which --quiet hides.
errors, say = (Console(stderr=True, highlight=False, soft_wrap=True, emoji=False) for _ in range(2))


def hushed(quiet: bool) -> bool:
    """Hide notes and progress, if --quiet is given."""
    say.quiet = quiet
    return quiet


def tell(sentence: str) -> None:
    """Print an error to standard error."""
    errors.print(f"longball: {sentence}", markup=False)


def note(sentence: str) -> None:
    """Print a note to standard error."""
    say.print(f"longball: {sentence}", markup=False)


def wrong_call(sentence: str) -> NoReturn:
    """Print a usage error and exit with status 2."""
    tell(sentence)
    raise typer.Exit(2)


def fail(sentence: str) -> NoReturn:
    """Print an error and exit with status 1."""
    tell(sentence)
    raise typer.Exit(1)


def exit_unless(passed: object) -> None:
    """Exit with status 1 if a line or a verdict failed."""
    if not passed:
        raise typer.Exit(1)


@contextmanager
def failing_unless(passed: bool) -> Iterator[None]:
    """Exit with status 1 after a failed verdict is printed, even if standard output is closed."""
    # In `finally`, because printing raises if the reader has closed the pipe.
    try:
        yield
    finally:
        exit_unless(passed)


def parsed(model: type[M], values: Mapping[str, Any], option: str = "") -> M:
    """Return options as a model; an invalid value is a usage error."""
    try:
        return model.model_validate(values)
    except ValidationError as error:
        wrong_call(f"{option}{explain(error, model)}")


@contextmanager
def refusing(what: str = "") -> Iterator[None]:
    """Turn a ValueError into a usage error; `what` comes before its message."""
    try:
        yield
    except ValueError as error:
        wrong_call(f"{what}{error}")


def show(head: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a table."""
    print("\n".join(aligned([head, *rows])))


@contextmanager
def progress_bar(what: str, total: int) -> Iterator[Callable[..., None]]:
    """Show progress on a terminal; yield a function that takes the work done (and the total)."""
    # No bar in files and pipes.
    if say.quiet or not say.is_terminal:
        yield lambda done, of=total: None
        return
    from rich import progress as parts

    columns = parts.BarColumn(), parts.MofNCompleteColumn(), parts.TimeRemainingColumn()
    with parts.Progress(parts.TextColumn(what), *columns, console=say, transient=True) as bar:
        task = bar.add_task(what, total=total)
        shown = 0.0

        def advance(done: int, of: int = total) -> None:
            nonlocal shown
            # At most ten times a second: drawing the bar takes longer than solving a flight.
            if done >= of or time.monotonic() > shown + 0.1:
                bar.update(task, completed=done, total=of)
                shown = time.monotonic()

        yield advance
