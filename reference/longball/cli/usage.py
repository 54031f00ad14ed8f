"""Usage errors in one style: the option, the given value, and the correct form.

Typer detects them, with different words for each kind; only kind and value are taken from it.
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
            return f"{option}: a value is needed: {known[option].help}".rstrip(".")
        return f"{option} takes no value"
    if extra := re.match(r"Got unexpected extra arguments? ?\(?s?\)? \((.*)\)", error.message):
        takes = " ".join(command.collect_usage_pieces(error.ctx)[1:]) or "only options"
        # The shell has split --speed 103 mph.
        quote = "; a value with spaces needs quotes" if takes == "only options" else ""
        return f"unexpected {extra[1]}: the command takes {takes}{quote}{see_help}"
    return str(error.message)


def _of_value(error: Any, command: Any, parameter: Any) -> str:
    """Return the sentence on the value of an option or an argument."""
    from longball.model.explain import in_our_words

    is_argument = parameter.param_type_name == "argument"
    where = str(parameter.metavar) if is_argument else max(parameter.opts, key=len)
    # The value may be from the configuration file.
    if parameter.name in (error.ctx.default_map or {}):
        where = f"{command.settings}: {command.name}.{where.lstrip('-')}"
    if hasattr(error, "param_type"):  # it is missing
        return f"{where} is missing: {parameter.help}".rstrip(".")
    # Pydantic's errors have the value; our own messages begin with it.
    faults: list[Any] = getattr(error.__cause__, "errors", list)()
    given = f" {faults[0]['input']}:" if faults else ""
    message = in_our_words(error.message).rstrip(".")
    if choices := re.fullmatch(r"'(.*)' is not one of (.*)", message):
        known = re.findall(r"'([^']*)'", choices[2])
        given, message = f" {choices[1]}:", f"must be one of {', '.join(known)}"
        message += did_you_mean(choices[1], known)
    # Older versions of typer convert numbers themselves.
    if number := re.fullmatch(r"'(.*)' is not a valid (float|integer)", message):
        whole = "whole " if number[2] == "integer" else ""
        given, message = f" {number[1]}:", f"must be a {whole}number"
    if outside := re.fullmatch(r"(\S+) is not in the range (?:(.+)<=)?x(?:<=(.+))?", message):
        given, low, high = outside.groups()
        limit = f"least {low}" if low and float(given) < float(low) else f"most {high}"
        given, message = f" {given}:", f"must be at {limit}"
    return f"{where}{given} {message}"
