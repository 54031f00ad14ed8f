"""The command line: data on standard output, messages on standard error.

Exit status: 0 success, 1 a line or a verdict failed, 2 the call itself was wrong.
"""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from longball import __version__
from longball.cli import golden
from longball.cli.converge import converge
from longball.cli.fit import fit
from longball.cli.homerun import homerun
from longball.cli.judge import judge
from longball.cli.measured import measured
from longball.cli.plot import plot
from longball.cli.readings import readings
from longball.cli.solve import solve
from longball.model.scene import in_our_words


class Commands(TyperGroup):
    """Commands that refuse the value of an option in plain words."""

    def invoke(self, ctx: Any) -> Any:
        """Call the command that is asked for."""
        try:
            return super().invoke(ctx)
        except typer.BadParameter as error:
            error.message = in_our_words(error.message)
            raise


app = typer.Typer(
    cls=Commands,
    help="The precision reference for baseball in flight.",
    epilog='Example: echo \'{"kind": "at-bat"}\' | longball solve',
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command(epilog="Example: longball solve at-bats.jsonl -o results.jsonl")(solve)
app.add_typer(golden.app, name="golden")
app.command(epilog="Example: longball judge -- longball solve --engine verlet --dt 1e-3")(judge)
app.command(
    epilog="Example: longball converge --golden flight-both --expected 2 -- "
    "longball solve --engine verlet --forces implicit --dt {dt}"
)(converge)
app.command(epilog="Example: longball homerun --samples 1000 --e 0.41:0.45:0.01 --figure P.png")(
    homerun
)
app.command(epilog="Example: longball fit pitches.csv --json > fitted.json")(fit)
app.command(epilog="Example: longball measured statcast.csv --kind batted --figure errors.png")(
    measured
)
app.command(epilog="Example: longball plot at-bats.jsonl -o paths.svg")(plot)
app.command(epilog="Example: longball readings --samples 1000")(readings)


@app.callback(invoke_without_command=True)
def _version(
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    if version:
        print(f"longball {__version__}")
        raise typer.Exit
