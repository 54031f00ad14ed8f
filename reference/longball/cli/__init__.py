"""The command line: data on standard output, messages on standard error."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from longball import __version__
from longball.cli.command import InOneVoice
from longball.model.names import one_of

# The commands, with an example of each. A command is a function in a module of the same name, which
# is imported on demand: completion and --help must not load SciPy.
COMMANDS = {
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
    "golden": "longball golden list",
}
GROUPS = ("golden",)  # commands with subcommands
EXIT_STATUS = (
    "Exit status: 0 success, 1 a line or a verdict failed, 2 an option or an input is wrong."
)


def module_of(command: str) -> Any:
    """Import the module of a command."""
    return import_module(f"longball.cli.{command}")


def summary_of(command: str, group: str = "") -> str:
    """Return the first line of a command's docstring, without importing its module."""
    # Help lists all commands; importing them takes five times as long as parsing them.
    tree: Any = ast.parse(Path(__file__).with_name(f"{group or command}.py").read_bytes())
    if command not in GROUPS:
        # The function has the command's name, with _ if it would hide a word of Python.
        functions = (node for node in tree.body if isinstance(node, ast.FunctionDef))
        tree = next(node for node in functions if node.name.rstrip("_") == command)
    return (ast.get_docstring(tree) or "").partition("\n")[0]


class Commands(InOneVoice, TyperGroup):
    """A group of commands, imported on demand."""

    group = ""  # name of the group; empty for longball itself
    examples: Mapping[str, str] = COMMANDS

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of the commands."""
        return [*self.examples]

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the section of the commands."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, summary_of(name, self.group)) for name in self.examples])

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command, None if there is none of that name."""
        if cmd_name not in self.examples:
            # A shell asks for the completion of unfinished words.
            if not (ctx.resilient_parsing or cmd_name.startswith("-")):
                from longball.cli.messages import wrong_call  # loads the model

                known = one_of("the commands are", cmd_name, self.examples)
                wrong_call(f"no such command {cmd_name!r}{known}")
            return None
        module = module_of(self.group or cmd_name)
        epilog = f"Example: {self.examples[cmd_name]}\n\n{EXIT_STATUS}"
        if cmd_name in GROUPS:
            group = Commands(
                name=cmd_name,
                help=summary_of(cmd_name),
                epilog=epilog,
                no_args_is_help=True,
                rich_markup_mode=None,
            )
            group.group, group.examples = cmd_name, module.COMMANDS
            return group
        from longball.cli.options import command_of

        # The key of options such as "golden check.seed".
        name = f"{self.group} {cmd_name}".strip()
        function = getattr(module, cmd_name, None) or getattr(module, f"{cmd_name}_")
        return command_of(name, function, epilog)


app = typer.Typer(
    cls=Commands,
    help="High-accuracy reference for baseball trajectories.",
    epilog=f'Example: echo \'{{"kind": "at-bat"}}\' | longball solve\n\n{EXIT_STATUS}',
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
