"""A command of the command line: its help, and the options from a configuration file."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from typer.core import TyperCommand

from longball.cli.messages import note
from longball.cli.settings import INSTEAD
from longball.cli.usage import UsageError


class Command(TyperCommand):
    """A command whose help has no Python types, and which reports options from a file."""

    settings = ""  # name of the configuration file

    def named_options(self) -> Mapping[str, Any]:
        """Return parameters by their long names; the argument of a COMMAND is one of them."""
        long = {o.lstrip("-"): p for p in self.params for o in p.opts if o.startswith("--")}
        return long | {p.name: p for p in self.params if p.name == "command"}

    def parse_args(self, ctx: Any, args: list[str]) -> Any:
        """Parse the arguments, which override alternatives in the configuration file."""
        # Typer fills in the values of the file, and the defaults.
        try:
            rest = super().parse_args(ctx, args)
        except UsageError as error:
            error.ctx = error.ctx or ctx  # typer omits it for an option without a value
            raise
        # A COMMAND on the command line takes the place of results in the file, and so on.
        for names in INSTEAD:
            if any(given_by(ctx, name) == "COMMANDLINE" for name in names):
                ctx.params |= {name: None for name in names if given_by(ctx, name) == "DEFAULT_MAP"}
        return rest

    def invoke(self, ctx: Any) -> Any:
        """Call the command."""
        names = (name for name, parameter in self.named_options().items()
                 if given_by(ctx, parameter.name) == "DEFAULT_MAP"
                 and ctx.params.get(parameter.name) is not None)  # fmt: skip
        # Name the options from the file: invisible values would be hard to find.
        if given := ", ".join(names):
            note(f"{self.settings} gives {given}")
        return super().invoke(ctx)

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


def given_by(ctx: Any, name: str) -> str:
    """Return the source of a value: COMMANDLINE, DEFAULT_MAP (a file) or DEFAULT."""
    source = ctx.get_parameter_source(name)
    return source.name if source else ""
