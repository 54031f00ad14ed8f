"""Usage errors in one style: the option, the given value, and the correct form.

Typer detects them, with different words for each kind; only the kind is taken from it. Its messages
on values are ours, from `longball.cli.options`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import typer

from longball.model.names import did_you_mean

# Base class of typer's usage errors; it is click's in some versions, and typer's in others.
UsageError: Any = typer.BadParameter.__mro__[1]


@contextmanager
def in_one_voice() -> Iterator[None]:
    """Print a usage error like every other error, and exit with status 2."""
    try:
        yield
    except UsageError as error:
        if type(error).__name__ == "NoArgsIsHelpError":  # its message is the help
            raise
        from longball.cli.messages import wrong_call  # loads the model, which --help does not need

        wrong_call(_sentence(error))


def _sentence(error: Any) -> str:
    command, parameter = error.ctx and error.ctx.command, getattr(error, "param", None)
    if parameter is not None:
        return _of_value(error, command, parameter)
    see_help = f"; see {error.ctx.command_path} --help" if error.ctx else ""
    if option := getattr(error, "option_name", None):
        known = {name: each for each in command.get_params(error.ctx) for name in each.opts}
        if option not in known:
            return f"no such option {option}{did_you_mean(option, known) or see_help}"
        if "requires" in error.message:
            return f"{option}: a value is needed: {_about(known[option])}"
        return f"{option} takes no value"
    if extra := re.match(r"Got unexpected extra arguments? ?\(?s?\)? \((.*)\)", error.message):
        takes = " ".join(command.collect_usage_pieces(error.ctx)[1:]) or "only options"
        # The shell has split --speed 103 mph.
        quote = "; a value with spaces needs quotes" if takes == "only options" else ""
        return f"unexpected {extra[1]}: the command takes {takes}{quote}{see_help}"
    return str(error.message)


def _of_value(error: Any, command: Any, parameter: Any) -> str:
    """Return the sentence on the value of an option or an argument."""
    is_argument = parameter.param_type_name == "argument"
    where = str(parameter.metavar) if is_argument else max(parameter.opts, key=len)
    # The value may be from the configuration file.
    if parameter.name in (error.ctx.default_map or {}):
        where = f"{command.settings}: {command.name}.{where.lstrip('-')}"
    if hasattr(error, "param_type"):  # it is missing
        return f"{where} is missing: {_about(parameter)}"
    return f"{where} {error.message}"  # which begins with the value


def _about(parameter: Any) -> str:
    """Return the help of an option without its default and limits, as the end of a sentence."""
    return str(parameter.help).partition("  [")[0].rstrip(".")
