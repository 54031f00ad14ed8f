"""The command line: data on standard output, messages on standard error.

Exit status: 0 success, 1 a line or a verdict failed, 2 the call itself was wrong.
"""

from __future__ import annotations

import re
from importlib import import_module
from itertools import takewhile
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from longball import __version__
from longball.model.names import did_you_mean, one_of

# Each command is a module of its own, which is imported when the command is asked for.
EXAMPLES = {
    "solve": "longball solve at-bats.jsonl -o results.jsonl",
    "judge": "longball judge -- longball solve --engine verlet --dt 1e-3",
    "converge": "longball converge --golden flight-both --expected 2 -- "
    "longball solve --engine verlet --forces implicit --dt {dt}",
    "homerun": "longball homerun --samples 1000 --e 0.41:0.45:0.01 --figure P.png",
    "fit": "longball fit pitches.csv --json > fitted.json",
    "measured": "longball measured statcast.csv --kind batted --figure errors.png",
    "movement": "longball movement statcast.csv",
    "spin": "longball spin statcast.csv --json > spins.jsonl",
    "flight": 'longball flight --speed "103 mph" --angle 28 --park "Coors Field"',
    "parks": "longball parks flies.jsonl",
    "aim": "longball aim flight.json --target 110",
    "infer": "longball infer flight.json --points path.csv --unknown launch.speed",
    "plot": "longball plot at-bats.jsonl -o paths.svg",
    "readings": "longball readings --samples 1000",
}
COMMANDS = (*EXAMPLES, "golden")


def module_of(command: str) -> Any:
    """Import the module of a command."""
    return import_module(f"longball.cli.{command}")


class Commands(TyperGroup):
    """Commands that are imported when they are asked for, and refuse values in plain words."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of the commands."""
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command, None if there is none of that name."""
        if cmd_name not in COMMANDS:
            if not (ctx.resilient_parsing or cmd_name.startswith("-")):
                known = one_of("the commands are", cmd_name, COMMANDS)
                ctx.fail(f"no such command {cmd_name!r}{known}")
            return None
        module = module_of(cmd_name)
        if cmd_name == "golden":  # which has commands of its own
            return typer.main.get_command(module.app)
        from longball.cli.command import Command

        alone = typer.Typer(add_completion=False, rich_markup_mode=None)
        command = alone.command(cmd_name, cls=Command, epilog=f"Example: {EXAMPLES[cmd_name]}")
        command(getattr(module, cmd_name))
        return typer.main.get_command(alone)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that is asked for, and give it what a file of settings has for it."""
        name, found, rest = super().resolve_command(ctx, args)
        command: Any = found
        asks_help = {"-h", "--help"} & {*takewhile(lambda word: word != "--", rest)}
        if name in EXAMPLES and not (asks_help or ctx.resilient_parsing):
            from longball.cli.settings import defaults_of, settings_of

            command.settings, given = settings_of(name, tuple(EXAMPLES))
            options = command.named_options()
            ctx.default_map = {name: defaults_of(command.settings, given, options, name)}
        return name, command, rest

    def invoke(self, ctx: Any) -> Any:
        """Call the command that is asked for."""
        try:
            return super().invoke(ctx)
        except typer.BadParameter as error:
            from longball.model.explain import in_our_words

            error.message = in_our_words(error.message)
            said_by = getattr(error.ctx, "default_map", None) or {}
            if error.param and error.param.name in said_by:
                command: Any = error.ctx and error.ctx.command
                file = command.settings
                error.message = f"{error.message.removesuffix('.')} (in {file})"
            if choice := re.fullmatch(r"'(.*)' is not one of (.*)\.", error.message):
                hint = did_you_mean(choice[1], re.findall(r"'([^']*)'", choice[2]))
                error.message = f"{error.message[:-1]}{hint or '.'}"
            raise
        except UsageError as error:
            _reword(error)
            raise


# The parent of typer's errors, which is click's in one version and its own in another.
UsageError: Any = typer.BadParameter.__mro__[1]


def _reword(error: Any) -> None:
    """Say in our words which option or argument there is not, and which may be meant."""
    command = error.ctx and error.ctx.command
    if option := getattr(error, "option_name", None):
        names = [name for each in command.get_params(error.ctx) for name in each.opts]
        error.message = f"no such option {option}{did_you_mean(option, names)}"
        error.possibilities = None
    elif unknown := re.match(r"No such command '(.*?)'", error.message):
        known = one_of("the commands are", unknown[1], command.list_commands(error.ctx))
        error.message, error.possibilities = f"no such command {unknown[1]!r}{known}", None
    elif extra := re.match(r"Got unexpected extra arguments? ?\(?s?\)? \((.*)\)", error.message):
        takes = " ".join(command.collect_usage_pieces(error.ctx)[1:]) or "options alone"
        error.message = f"{extra[1]}: one too many; the command takes {takes}"


app = typer.Typer(
    cls=Commands,
    help="The precision reference for baseball in flight.",
    epilog='Example: echo \'{"kind": "at-bat"}\' | longball solve',
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback(invoke_without_command=True)
def _version(
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    if version:
        print(f"longball {__version__}")
        raise typer.Exit
