"""Commands as typer runs them, with help and usage errors in longball's words.

Typer splits the words of a call into options and texts, writes the help, and completes words in a
shell. `longball.cli.options` reads the texts.
"""

from __future__ import annotations

import re
from typing import Any

import typer
from typer.core import TyperCommand

from longball.model.names import did_you_mean

# Base class of typer's usage errors; it is click's in some versions, and typer's in others.
_UsageError: Any = typer.BadParameter.__mro__[1]


class InOneVoice:
    """A command or a group whose usage errors are printed like every other error."""

    def parse_args(self, ctx: Any, args: list[str]) -> Any:
        """Parse the arguments."""
        known: Any = super()
        try:
            return known.parse_args(ctx, args)
        except _UsageError as error:
            if type(error).__name__ == "NoArgsIsHelpError":  # its message is the help
                raise
            from longball.cli.messages import wrong_call  # loads the model: not needed for --help

            wrong_call(_sentence(error, self, ctx))


def _sentence(error: Any, command: Any, ctx: Any) -> str:
    """Return a sentence on a usage error; typer has different words for each kind."""
    see_help = f"; see {ctx.command_path} --help"
    if option := getattr(error, "option_name", None):
        known = {name: each for each in command.get_params(ctx) for name in each.opts}
        if option not in known:
            return f"no such option {option}{did_you_mean(option, known) or see_help}"
        if "requires" in error.message:
            about = str(known[option].help).partition("  [")[0]  # without default and limits
            return f"{option}: a value is needed: {about}".rstrip(".")
        return f"{option} takes no value"
    if extra := re.match(r"Got unexpected extra arguments? ?\(?s?\)? \((.*)\)", error.message):
        takes = " ".join(command.collect_usage_pieces(ctx)[1:]) or "only options"
        # The shell has split --speed 103 mph.
        quote = "; a value with spaces needs quotes" if takes == "only options" else ""
        return f"unexpected {extra[1]}: the command takes {takes}{quote}{see_help}"
    return str(error.message)


class Command(InOneVoice, TyperCommand):
    """A command whose help has no Python types."""

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Return the arguments of the usage line."""
        # Typer's own text would be [SCENES] for our metavar [SCENES|-].
        arguments = (p for p in self.params if p.param_type_name == "argument")
        return ["[OPTIONS]", *(str(p.metavar) for p in arguments)]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the sections of arguments and options."""
        rows: dict[str, list[tuple[str, str]]] = {"argument": [], "option": []}
        for parameter in self.get_params(ctx):
            if record := parameter.get_help_record(ctx):
                name = re.sub(r"<(.*)>", r"\1", record[0])
                if parameter.param_type_name == "argument":
                    name = str(parameter.metavar)
                rows[parameter.param_type_name].append((name, record[1]))
        for title, kind in (("Arguments", "argument"), ("Options", "option")):
            if rows[kind]:
                with formatter.section(title):
                    formatter.write_dl(rows[kind])
