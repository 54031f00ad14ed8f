"""The command line: data on standard output, messages on standard error."""

from __future__ import annotations

import ast
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from longball import __version__
from longball.cli.command import InOneVoice
from longball.model.names import one_of

# The commands, with an example of each. The first word is that of a module, which is imported on
# demand: completion and --help must not load SciPy. The last word is that of a function in it.
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
    "golden list": "longball golden list",
    "golden path": "ls $(longball golden path)",
    "golden export": "longball golden export golden.zip",
    "golden write": "longball golden write golden-data",
    "golden coverage": "longball golden coverage scenes.jsonl",
    "golden check": "longball golden check --sample 50",
}
MODULES = tuple(dict.fromkeys(name.split()[0] for name in COMMANDS))
EXIT_STATUS = (
    "Exit status: 0 success, 1 a line or a verdict failed, 2 an option or an input is wrong."
)


def module_of(command: str) -> Any:
    """Import the module of a command."""
    return import_module(f"longball.cli.{command.split()[0]}")


def summary_of(command: str) -> str:
    """Return the first line of the docstring of a command or a group, without an import."""
    # Help lists all commands; importing them takes five times as long as parsing them.
    module, function = command.split()[0], command.split()[-1]
    tree: Any = ast.parse(Path(__file__).with_name(f"{module}.py").read_bytes())
    if command in COMMANDS:
        # The function has the command's name, with _ if it would hide a word of Python.
        functions = (node for node in tree.body if isinstance(node, ast.FunctionDef))
        tree = next(node for node in functions if node.name.rstrip("_") == function)
    return (ast.get_docstring(tree) or "").partition("\n")[0]


class Commands(InOneVoice, TyperGroup):
    """A group of commands, imported on demand."""

    prefix = ""  # of their names in `COMMANDS`, such as "golden "

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of the commands."""
        inner = (x.removeprefix(self.prefix) for x in COMMANDS if x.startswith(self.prefix))
        return [*dict.fromkeys(name.split()[0] for name in inner)]

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the section of the commands."""
        names = self.list_commands(ctx)
        with formatter.section("Commands"):
            formatter.write_dl([(name, summary_of(self.prefix + name)) for name in names])

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command, None if there is none of that name."""
        if cmd_name not in (names := self.list_commands(ctx)):
            # A shell asks for the completion of unfinished words.
            if not (ctx.resilient_parsing or cmd_name.startswith("-")):
                from longball.cli.messages import wrong_call  # loads the model

                known = one_of("the commands are", cmd_name, names)
                wrong_call(f"no such command {cmd_name!r}{known}")
            return None
        name = self.prefix + cmd_name
        example = next(x for known, x in COMMANDS.items() if f"{known} ".startswith(f"{name} "))
        more: dict[str, Any] = {
            "help": summary_of(name),
            "epilog": f"Example: {example}\n\n{EXIT_STATUS}",
        }
        if name not in COMMANDS:
            group = Commands(name=cmd_name, **more, no_args_is_help=True, rich_markup_mode=None)
            group.prefix = f"{name} "
            return group
        from longball.cli.options import command_of

        module = module_of(name)
        function = getattr(module, cmd_name, None) or getattr(module, f"{cmd_name}_")
        return command_of(name, function, more["epilog"])


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
